"""The search of the surface of an oil, whose result is tables.

Decides: which law a surface stands on; when no law fits.
"""

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from oilfilm import tables
from oilfilm.base.units import FloatArray, IndexArray
from oilfilm.fits.best_law import best_laws
from oilfilm.fits.fitted import FittedLaw
from oilfilm.fits.measured_surface import (
    COLUMN_BY_EFFECT,
    LIMIT_NAMES,
    SIZE_SEARCHES,
    MeasuredContact,
    free_law,
    usable_measurements,
)
from oilfilm.fits.run_assumptions import RunAssumptions
from oilfilm.settings.config import ConfigKeys, SurfaceSettings
from oilfilm.settings.rig import Rig
from oilfilm.surface.effects import EFFECT_NAMES
from oilfilm.surface.law_mean import FreeLaw
from oilfilm.surface.limits import SurfaceLimits
from oilfilm.surface.measurements import Measurements
from oilfilm.surface.reml import size_names
from oilfilm.surface.surface import (
    LawVerdict,
    Surface,
    SurfaceSizes,
    most_likely_surface_sizes,
    surface_from_sizes,
)
from oilfilm.tables.campaign_tables import CURVE_COLUMNS, CampaignTables
from oilfilm.tables.table_needs import SURFACE_TABLES
from oilfilm.traction import LAWS
from oilfilm.traction.law import to_constants


def surface_tables_of_oil(
    results: CampaignTables, oil: str, settings: ConfigKeys, rigs: Mapping[str, Rig]
) -> CampaignTables:
    """The tables of the surface of one oil, without rows where it has none.

    It has none with too few curves, or without a fitted law on which it can stand.

    Args:
        results: Tables `points`, `coefficients`, `fit_quality` and `law_points` of its fits, and
            `runs`, which has no rows where the data name no rigs.
        oil: The oil.
        settings: `compare`, `same_condition` and `surface`.
        rigs: The rigs of the campaign by name.
    """
    basis = _surface_basis(results, oil, settings, rigs)
    if basis is None:
        return CampaignTables.from_frames(
            **{table: tables.empty_table(table) for table in SURFACE_TABLES}
        )
    tables.release_memory()
    return searched_surface_tables(
        oil,
        basis.law_name,
        basis.surface_law,
        basis.measurements,
        settings.surface,
        basis.assumptions,
    )


class _SurfaceBasis(NamedTuple):
    """What the surface of an oil is searched from.

    Attributes:
        law_name: Name of the law on which it stands.
        surface_law: This law with its free constants.
        measurements: The points.
        assumptions: What is known of the runs.
    """

    law_name: str
    surface_law: FreeLaw
    measurements: Measurements
    assumptions: RunAssumptions


def _surface_basis(
    results: CampaignTables, oil: str, settings: ConfigKeys, rigs: Mapping[str, Rig]
) -> _SurfaceBasis | None:
    """What the surface of an oil is searched from; None where it has none.

    The table of points is not kept during the search.

    Args:
        results: As of `surface_tables_of_oil`.
        oil: The oil.
        settings: As of `surface_tables_of_oil`.
        rigs: As of `surface_tables_of_oil`.
    """
    points = results.table("points", CURVE_COLUMNS, oil=oil)
    rig_name_of_run = _rig_of_runs(points, results.table("runs", ["run_id", "rig"]))
    assumptions = RunAssumptions.from_settings(settings.same_condition, rigs, rig_name_of_run)
    contact = MeasuredContact.from_points(points[points["accepted"]])
    for law_name in _law_names_in_order(results, oil, settings.compare.bic_difference_min):
        fit = FittedLaw.from_tables(results.coefficients, oil, law=LAWS[law_name])
        constants = fit.coefficients.constants
        if not contact.has_surface(fit.law) or np.isnan(constants).any():
            continue
        surface_law = free_law(fit.law, constants, fit.coefficients.group_has_exponent, contact)
        run_ids, measurements = usable_measurements(points, surface_law, contact, assumptions)
        if len(run_ids) < settings.surface.fewest_curves:
            break
        return _SurfaceBasis(law_name, surface_law, measurements, assumptions)
    return None


def _rig_of_runs(points: pd.DataFrame, runs: pd.DataFrame) -> list[str] | None:
    """Names of the rigs of the accepted runs, as `RunAssumptions` has them; None if none is named.

    Args:
        points: The oil's rows of the table of points.
        runs: The table of runs.
    """
    if runs.empty:
        return None
    rig_by_run_id = dict(zip(runs["run_id"].astype(str), runs["rig"], strict=True))
    accepted_run_ids = sorted(points.loc[points["accepted"], "run_id"].astype(str).unique())
    rig_names = [rig_by_run_id[run_id] for run_id in accepted_run_ids]
    return rig_names if len(set(rig_names)) > 1 else rig_names[:1]


def with_surface(
    results: CampaignTables, oil: str, settings: ConfigKeys, rigs: Mapping[str, Rig] | None = None
) -> CampaignTables:
    """The tables of fits to one oil, with those of its surface; see `surface_tables_of_oil`."""
    surface_tables = surface_tables_of_oil(results, oil, settings, rigs or {})
    return results.replace(**{name: surface_tables.table(name) for name in SURFACE_TABLES})


def _law_names_in_order(
    results: CampaignTables, oil: str, bic_difference_min: float
) -> Iterator[str]:
    """Names of the laws that need no properties of the oil, the preferred one first.

    The preferred one is the configured law, if it predicts curves left out as well as the best one
    does. The others follow by that error.
    """
    quality = results.fit_quality[results.fit_quality["oil"] == oil]
    by_error = quality.sort_values("left_out_rmse", kind="stable", na_position="last")
    verdicts = best_laws(results.replace(fit_quality=quality), bic_difference_min)
    (verdict,) = tables.rows(verdicts)
    tied_names = verdict["left_out_ties"] or ()
    preferred_names = [verdict["law"]] if verdict["law"] in tied_names or not tied_names else []
    for law_name in dict.fromkeys([*preferred_names, *tied_names, *by_error["law"]]):
        if law_name in LAWS:
            yield law_name


def searched_surface_tables(
    oil: str,
    law_name: str,
    surface_law: FreeLaw,
    measurements: Measurements,
    settings: SurfaceSettings,
    assumptions: RunAssumptions,
) -> CampaignTables:
    """The tables of the surface about one law.

    Args:
        oil: The oil.
        law_name: Name of the law in the tables.
        surface_law: The law with its free constants.
        measurements: The points.
        settings: Config's `surface`.
        assumptions: What is known of the runs.
    """
    error_sizes = assumptions.error_sizes
    limits = SurfaceLimits(
        level=settings.level,
        largest_spread=settings.largest_spread,
        fewest_slips=settings.fewest_slips,
        reach_in_gaps=settings.reach_in_gaps,
        reach_in_slip=settings.reach_in_slip,
        reach_in_ranges=settings.reach_in_ranges,
        largest_spread_of_bound=settings.largest_spread_of_bound,
    )
    sizes = most_likely_surface_sizes(measurements, surface_law, error_sizes)
    surface = surface_from_sizes(measurements, surface_law, error_sizes, sizes, limits)
    interval_factors = surface.interval_factors
    ordered_measurements = surface.measurements
    prediction = surface.predict(ordered_measurements.point_conditions, ordered_measurements.slip)
    mu_of_law = np.exp(
        surface_law.log_mu(ordered_measurements.point_conditions, ordered_measurements.slip)
    )
    misfit = float(np.linalg.norm(mu_of_law - prediction.mu) / np.linalg.norm(prediction.mu))
    effect_columns = [COLUMN_BY_EFFECT[effect] for effect in EFFECT_NAMES]
    effect_sizes = np.exp(sizes.misfit)[: len(EFFECT_NAMES)]
    mu_errors_by_runs = prediction.mu * surface.sd_by_runs(effect_sizes)
    run_scatter = float(np.linalg.norm(mu_errors_by_runs) / np.linalg.norm(prediction.mu))
    next_run_sd = prediction.next_run_sd
    if ordered_measurements.rig_of_curve is not None:
        next_run_sd = _next_run_sd_on_own_rigs(surface, ordered_measurements.rig_of_curve)
    row = {
        "oil": oil,
        "law": law_name,
        "n_conditions": int(measurements.condition_of_curve().max()) + 1,
        "interval_level": interval_factors.level,
        "point_factor": interval_factors.point,
        "curve_factor": interval_factors.curve,
        "misfit": misfit,
        "run_scatter": run_scatter,
        # a law that misses less than runs differ cannot be told from one that fits
        "no_law_fits": misfit > max(run_scatter, settings.largest_misfit),
        "next_run_sd": float(np.median(next_run_sd)),
        "rig_gain_sd": surface.covariance.sizes.rig_gain or np.nan,
        "search_converged": sizes.converged,
        **dict(zip(effect_columns, effect_sizes.tolist(), strict=True)),
        **{limit: getattr(limits, limit) for limit in LIMIT_NAMES},
        **assumptions.surface_columns(),
    }
    return CampaignTables.from_frames(
        surfaces=tables.from_rows([row], "surfaces"),
        surface_sizes=tables.from_rows(
            [*_size_rows(oil, sizes), *assumptions.size_rows(oil)], "surface_sizes"
        ),
        surface_constants=tables.from_rows(
            _constant_rows(
                oil, law_name, surface_law, surface.verdict, misfit <= settings.largest_misfit
            ),
            "surface_constants",
        ),
    )


def _next_run_sd_on_own_rigs(surface: Surface, rig_of_curve: IndexArray) -> FloatArray:
    """Standard deviation of ln mu in the next run at the measured points, on the rig of each.

    Args:
        surface: The surface.
        rig_of_curve: Number of the rig of each curve of its measurements.
    """
    measurements = surface.measurements
    standard_deviations = []
    for rig_number in np.unique(rig_of_curve).tolist():
        points_of_rig = measurements.select_points(
            rig_of_curve[measurements.curve_of_point] == rig_number
        )
        on_rig = surface.predict(points_of_rig.point_conditions, points_of_rig.slip, rig_number)
        standard_deviations.append(on_rig.next_run_sd)
    return np.concatenate(standard_deviations)


def _size_rows(oil: str, sizes: SurfaceSizes) -> list[dict[str, Any]]:
    """Rows of the table `surface_sizes`."""
    rows = []
    for search in SIZE_SEARCHES:
        logarithms = getattr(sizes, search).tolist()
        names = size_names(tells_rigs_apart=len(logarithms) > len(size_names()))
        for size_name, logarithm in zip(names, logarithms, strict=True):
            rows.append({"oil": oil, "search": search, "size": size_name, "logarithm": logarithm})
    return rows


def _constant_rows(
    oil: str, law_name: str, surface_law: FreeLaw, verdict: LawVerdict, law_fits: bool
) -> list[dict[str, Any]]:
    """Rows of the table `surface_constants`: the free constants of the law in the surface.

    Constants of a law that does not fit depend on which conditions were tested, and have no errors.
    """
    internal_constants = surface_law.constants.copy()
    internal_constants[surface_law.is_free] = verdict.constants
    constants = to_constants(surface_law.law, internal_constants)
    standard_errors = np.full(len(constants), np.nan)
    if law_fits:
        standard_errors[surface_law.is_free] = verdict.standard_errors
    rows = []
    for constant, value, error in zip(
        surface_law.law.constants, constants, standard_errors, strict=True
    ):
        # the internal value of an X0 is ln|X0|
        value_change_per_internal = abs(value) if constant.group is None else 1.0
        standard_error = float(value_change_per_internal * error)
        row = {"oil": oil, "law": law_name, "constant": constant.name, "value": float(value)}
        rows.append({**row, "standard_error": standard_error})
    return [row for row, is_free in zip(rows, surface_law.is_free, strict=True) if is_free]
