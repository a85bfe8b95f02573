"""The search of the surface of an oil, whose result is tables.

Decides: which law a surface stands on; when no law fits.
"""

from collections.abc import Collection, Iterator
from typing import Any

import numpy as np
import pandas as pd

from oilfilm import tables
from oilfilm.base.units import FloatArray, IndexArray
from oilfilm.fits.best_law import best_laws
from oilfilm.fits.fitted import FittedLaw
from oilfilm.fits.measured_surface import (
    COLUMN_OF_EFFECT,
    LIMITS,
    SEARCHES,
    Contact,
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


def surface_of_oil(
    results: CampaignTables, oil: str, settings: ConfigKeys, rigs: Collection[Rig]
) -> CampaignTables:
    """The tables of the surface of one oil, without rows where it has none.

    It has none with too few curves, or without a fitted law on which it can stand.

    Args:
        results: Tables `points`, `coefficients`, `fit_quality` and `law_points` of its fits, and
            `runs`, which has no rows where the data name no rigs.
        oil: The oil.
        settings: `compare`, `same_condition` and `surface`.
        rigs: The rigs of the campaign.
    """
    basis = _basis_of_surface(results, oil, settings, rigs)
    if basis is None:
        return CampaignTables.in_memory(**{table: tables.empty(table) for table in SURFACE_TABLES})
    law_name, law, measurements, assumptions = basis
    tables.release_memory()
    return searched_surface(oil, law_name, law, measurements, settings.surface, assumptions)


def _basis_of_surface(
    results: CampaignTables, oil: str, settings: ConfigKeys, rigs: Collection[Rig]
) -> tuple[str, FreeLaw, Measurements, RunAssumptions] | None:
    """Name of the law of a surface, the law, the points, and what is known of the runs.

    None without a surface. The table of points is not kept during the search.

    Args:
        results: As of `surface_of_oil`.
        oil: The oil.
        settings: As of `surface_of_oil`.
        rigs: The rigs of the campaign.
    """
    points = results.table("points", CURVE_COLUMNS, oil=oil)
    rig_name_of_run = _rig_of_runs(points, results.table("runs", ["run_id", "rig"]))
    assumptions = RunAssumptions.from_settings(settings.same_condition, rigs, rig_name_of_run)
    contact = Contact.from_points(points[points["accepted"]])
    for law_name in _laws_in_order(results, oil, settings.compare.bic_difference_min):
        fit = FittedLaw.from_tables(results.coefficients, oil, law=LAWS[law_name])
        constants = fit.coefficients.constants
        if not contact.has_surface(fit.law) or np.isnan(constants).any():
            continue
        law = free_law(fit.law, constants, fit.coefficients.group_has_exponent, contact)
        run_ids, measurements = usable_measurements(points, law, contact, assumptions)
        if len(run_ids) < settings.surface.fewest_curves:
            break
        return law_name, law, measurements, assumptions
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
    results: CampaignTables, oil: str, settings: ConfigKeys, rigs: Collection[Rig] = ()
) -> CampaignTables:
    """The tables of fits to one oil, with those of its surface; see `surface_of_oil`."""
    surface_tables = surface_of_oil(results, oil, settings, rigs)
    return results.replace(**{name: surface_tables.table(name) for name in SURFACE_TABLES})


def _laws_in_order(results: CampaignTables, oil: str, bic_difference_min: float) -> Iterator[str]:
    """Names of the laws that need no properties of the oil, the preferred one first.

    That is the configured law where it predicts curves left out as well as the best one does, then
    the others by that error.
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


def searched_surface(
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
    errors = assumptions.error_sizes
    limits = SurfaceLimits(
        level=settings.level,
        largest_spread=settings.largest_spread,
        fewest_slips=settings.fewest_slips,
        reach_in_gaps=settings.reach_in_gaps,
        reach_in_slip=settings.reach_in_slip,
        reach_in_ranges=settings.reach_in_ranges,
        largest_spread_of_bound=settings.largest_spread_of_bound,
    )
    sizes = most_likely_surface_sizes(measurements, surface_law, errors)
    surface = surface_from_sizes(measurements, surface_law, errors, sizes, limits)
    factors = surface.interval_factors
    tested = surface.measurements
    prediction = surface.predict(tested.point_conditions, tested.slip)
    mu_of_law = np.exp(surface_law.log_mu(tested.point_conditions, tested.slip))
    misfit = float(np.linalg.norm(mu_of_law - prediction.mu) / np.linalg.norm(prediction.mu))
    effect_columns = [COLUMN_OF_EFFECT[effect] for effect in EFFECT_NAMES]
    effect_sizes = np.exp(sizes.misfit)[: len(EFFECT_NAMES)]
    mu_errors_by_runs = prediction.mu * surface.sd_by_runs(effect_sizes)
    run_scatter = float(np.linalg.norm(mu_errors_by_runs) / np.linalg.norm(prediction.mu))
    next_run_sd = prediction.next_run_sd
    if tested.rig_of_curve is not None:
        next_run_sd = _sd_on_own_rigs(surface, tested.rig_of_curve)
    row = {
        "oil": oil,
        "law": law_name,
        "n_conditions": int(measurements.condition_of_curve().max()) + 1,
        "interval_level": factors.level,
        "point_factor": factors.point,
        "curve_factor": factors.curve,
        "misfit": misfit,
        "run_scatter": run_scatter,
        # a law that misses less than runs differ cannot be told from one that fits
        "no_law_fits": misfit > max(run_scatter, settings.largest_misfit),
        "next_run_sd": float(np.median(next_run_sd)),
        "rig_gain_sd": surface.covariance.sizes.rig_gain or np.nan,
        "search_converged": sizes.converged,
        **dict(zip(effect_columns, effect_sizes.tolist(), strict=True)),
        **{limit: getattr(limits, limit) for limit in LIMITS},
        **assumptions.columns(),
    }
    return CampaignTables.in_memory(
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


def _sd_on_own_rigs(surface: Surface, rig_of_curve: IndexArray) -> FloatArray:
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
    for search in SEARCHES:
        logarithms = getattr(sizes, search).tolist()
        names = size_names(tells_rigs_apart=len(logarithms) > len(size_names()))
        for size_name, logarithm in zip(names, logarithms, strict=True):
            rows.append({"oil": oil, "search": search, "size": size_name, "logarithm": logarithm})
    return rows


def _constant_rows(
    oil: str, law_name: str, surface_law: FreeLaw, verdict: LawVerdict, law_fits: bool
) -> list[dict[str, Any]]:
    """Rows of the table `surface_constants`: the free constants of the law in the surface.

    Constants of a law that does not fit describe the plan of the tests, and have no errors.
    """
    internal = surface_law.constants.copy()
    internal[surface_law.is_free] = verdict.constants
    constants = to_constants(surface_law.law, internal)
    errors = np.full(len(constants), np.nan)
    if law_fits:
        errors[surface_law.is_free] = verdict.standard_errors
    rows = []
    for constant, value, error in zip(surface_law.law.constants, constants, errors, strict=True):
        # the internal form of a factor is its logarithm
        error_factor = abs(value) if constant.condition is None else 1.0
        standard_error = float(error_factor * error)
        row = {"oil": oil, "law": law_name, "constant": constant.name, "value": float(value)}
        rows.append({**row, "standard_error": standard_error})
    return [row for row, is_free in zip(rows, surface_law.is_free, strict=True) if is_free]
