"""What each fit misses beside the noise of its data: table `lack_of_fit`.

Decides: which runs repeat a condition.
"""

from typing import Any

import numpy as np
import pandas as pd

from oilfilm import tables
from oilfilm.curation.coverage import SET_POINTS, with_levels
from oilfilm.fits.conditions import clusters, levels_of
from oilfilm.fits.fitted import FittedLaw
from oilfilm.fits.lack_of_fit import ADVISED_REPEATS, LackOfFit, f_limit, lack_of_fit
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.units import FloatArray, IndexArray

# A set point that no log states is known by what was measured.
_MEASURED = ("max_hertz_pressure_gpa", "load_n", "entrainment_speed_m_s", "inlet_temperature_c")
_NOTHING = {
    "n_repeats": 0,
    "n_repeated_conditions": 0,
    **dict.fromkeys(
        (
            *("relative_rms", "repeat_relative_rms", "lack_of_fit_relative_rms"),
            *("plateau_relative_rms", "lack_of_fit_ratio", "lack_of_fit_limit"),
            *(f"detectable_ratio_{repeats}_repeats" for repeats in ADVISED_REPEATS),
        ),
        np.nan,
    ),
}


def noise_and_misfit(results: CampaignTables, settings: Settings) -> pd.DataFrame:
    """Table `lack_of_fit`: residuals of each fit, parted into noise and lack of fit.

    Args:
        results: Tables `coefficients`, `fit_quality`, `points` and `runs`.
        settings: `gates`, `rigs`, `oils`, `same_set_point`, and the campaign's `rigs` and `matrix`.
    """
    conditions = _conditions(results, settings)
    rows = []
    results = results.configured
    for quality in tables.rows(results.fit_quality):
        row = {"oil": quality["oil"], "law": quality["law"], **_NOTHING}
        if np.isnan(quality["rmse"]):
            rows.append({**row, "verdict": "no fit"})
            continue
        rows.append({**row, **_of_fit(quality, results, conditions, settings)})
    return tables.from_rows(rows, "lack_of_fit")


def _of_fit(
    quality: dict[str, Any],
    results: CampaignTables,
    conditions: "pd.Series[int]",
    settings: Settings,
) -> dict[str, Any]:
    fit = FittedLaw.of(results.coefficients, quality["oil"], None, results.fit_quality)
    points = results.points
    used = points[points["accepted"] & (points["oil"] == quality["oil"])]
    # a fit takes each run at its mean conditions
    means = used.groupby("run_id")[list(fit.law.conditions)].transform("mean").to_numpy(float)
    slip, mu = (used[name].to_numpy(float) for name in ("slide_roll_ratio", "traction_coefficient"))
    residual = np.where(slip < 0, -1.0, 1.0) * (fit.predict(means, slip).traction_coefficient - mu)
    known = np.isfinite(residual)
    used, residual, slip, mu = used[known], residual[known], slip[known], mu[known]
    condition = used["run_id"].map(conditions).to_numpy(np.int64)
    run, _ = pd.factorize(used["run_id"])
    levels = _slip_levels(np.abs(slip), condition, 2 * settings.gates.slip_tolerance)
    given = results.coefficients["oil"] == quality["oil"]
    constants = int(results.coefficients.loc[given, "value"].notna().sum())
    parts = lack_of_fit(residual, run, condition, levels, constants)
    size = float(np.sqrt(np.mean(mu**2)))
    errors = used["traction_coefficient_se"].dropna()
    row = {
        "n_repeats": parts.repeats,
        "n_repeated_conditions": parts.conditions,
        "relative_rms": quality["relative_rms"],
        "repeat_relative_rms": parts.noise / size,
        "lack_of_fit_relative_rms": parts.lack / size,
        "plateau_relative_rms": float(np.sqrt(np.mean(errors**2))) / size
        if len(errors)
        else np.nan,
        "lack_of_fit_ratio": parts.ratio,
        "lack_of_fit_limit": parts.limit,
    }
    # runs less the constants, each run counted as one observation
    runs = run.max() + 1 - constants * (run.max() + 1) / len(run)
    detectable = {
        f"detectable_ratio_{repeats}_repeats": float(np.sqrt(f_limit(max(runs, 1.0), repeats)))
        for repeats in ADVISED_REPEATS
    }
    return {**row, **detectable, "verdict": _verdict(parts)}


def _verdict(parts: LackOfFit) -> str:
    if np.isnan(parts.noise):
        return "no repeats"
    return "shown" if parts.shown else "not shown"


def _conditions(results: CampaignTables, settings: Settings) -> "pd.Series[int]":
    """Number of the condition of each run, by `run_id`.

    Runs have one condition where oil, rig and set points are the same. Of a set point that is not
    stated the measured mean counts, within the tolerances that gates allow from a set point.
    """
    runs = with_levels(results.runs, settings).set_index("run_id")
    accepted = results.points[results.points["accepted"]]
    means = accepted.groupby("run_id")[list(_MEASURED)].mean().reindex(runs.index)
    # pressure and load are one set point
    load_noted = runs[list(SET_POINTS[:2])].notna().any(axis=1)
    labels = runs[["oil", "rig"]].assign(load_noted=load_noted)
    for name, measured in zip(SET_POINTS, _MEASURED, strict=True):
        noted = runs[name].notna() | (load_noted if name in SET_POINTS[:2] else False)
        near = levels_of(measured, means[measured].to_numpy(float), settings.gates)
        labels[name] = runs[name].where(noted, -1.0 - near)
    return labels.groupby(list(labels), sort=False, dropna=False).ngroup()


def _slip_levels(slip: FloatArray, condition: IndexArray, width: float) -> IndexArray:
    """Level of slip of each point, among the points of its condition."""
    levels = np.empty(len(slip), dtype=np.int64)
    order = np.argsort(condition, kind="stable")
    edges = np.flatnonzero(np.diff(condition[order])) + 1
    for here in np.split(order, edges):
        levels[here] = clusters(slip[here], width)
    return levels
