"""Errors of fitted laws at the conditions of Figs 7-10, where the simulated truth is known.

The errors tell about laws, not about oils. A law that fails here fails for a truth like the
simulated one. Nothing follows for the real oils.
"""

import itertools
from collections.abc import Hashable, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from deng2026_study.settings import study_settings
from oilfilm import tables
from oilfilm.base.ties import first_largest, reaches
from oilfilm.base.units import FloatArray
from oilfilm.fits.fitted import INTERVALS, FittedLaw
from oilfilm.fits.measured_surface import OilSurface
from oilfilm.settings.resolved import Settings
from oilfilm.traction import LAWS
from oilfilm.traction.law import CONDITIONS, Law
from simulated_lab.truth import known_contact, true_tractions

# Confidence level of the interval of the next run.
_LEVEL = 0.95
# Largest size of mu in the table, for laws that run away: their errors must be finite.
_LARGEST_MU = 1e6
# Columns that describe the worst condition of a law.
_WORST = [*CONDITIONS, "slide_roll_ratio", "true_traction_coefficient", "traction_coefficient"]
# Short names of `CONDITIONS`.
_SHORT_NAMES = np.array(["pressure", "speed", "temperature"])


def truth_grid(settings: Settings, constants: Mapping[str, FloatArray]) -> pd.DataFrame:
    """The true traction at the conditions of Figs 7-10, as table `truth_grid`.

    Raises:
        OilfilmError: As `true_tractions`.
    """
    contact = known_contact(settings)
    grids = []
    for oil, traction in true_tractions(settings, constants).items():
        for figure, conditions in study_settings(settings).extrapolation.items():
            levels = conditions.model_dump()
            frame = pd.DataFrame(itertools.product(*levels.values()), columns=list(levels))
            mu = traction(*(frame[name].to_numpy(dtype=float) for name in levels))
            load_n = contact.load_n(frame["max_hertz_pressure_gpa"].to_numpy())
            grids.append(
                frame.assign(oil=oil, figure=figure, load_n=load_n, traction_coefficient=mu)
            )
    return tables.conform(pd.concat(grids, ignore_index=True), "truth_grid", "truth of the twin")


def extrapolate(
    truth: pd.DataFrame,
    coefficients: pd.DataFrame,
    refits: pd.DataFrame,
    quality: pd.DataFrame,
    within: float,
    laws: Mapping[str, Mapping[str, Law]] | None = None,
    surfaces: Mapping[str, OilSurface | None] | None = None,
) -> pd.DataFrame:
    """Every fitted law's traction, with the interval of the next run, beside the true one.

    Args:
        truth: Table `truth_grid`.
        coefficients: Table of coefficients, of any number of laws.
        refits: Table of refits.
        quality: Table of fit quality, which has each fit's tested box.
        within: As in `is_beyond`.
        laws: The laws by name, for each oil; without it those that need no properties of the oil.
        surfaces: The surface of each oil, from which the interval of the next run comes; without it
            there is none.

    Returns:
        Table `extrapolation`: one row per law and row of `truth`.
    """
    # grouped once, because the table is long
    refits_of_fit = dict(iter(refits.groupby(["oil", "law"])))
    parts = []
    for oil, truth_of_oil in truth.groupby("oil", sort=False):
        laws_of_oil = LAWS if laws is None else laws[str(oil)]
        interval = _interval_of_next_run((surfaces or {}).get(str(oil)), truth_of_oil)
        for fit in quality[quality["oil"] == oil].to_dict("records"):
            law = str(fit["law"])
            own_refits = refits_of_fit.get((oil, law), refits.iloc[:0])
            fitted = FittedLaw.from_tables(
                coefficients, str(oil), own_refits, quality, laws_of_oil[law]
            )
            parts.append(_predicted(fitted, fit, truth_of_oil.assign(**interval), within))
    return tables.conform(pd.concat(parts, ignore_index=True), "extrapolation", "extrapolation")


def _interval_of_next_run(surface: OilSurface | None, truth: pd.DataFrame) -> dict[str, FloatArray]:
    """Columns `obs_ci_lower` and `obs_ci_upper`; NaN without a surface, or without support."""
    if surface is None:
        unknown = np.full(len(truth), np.nan)
        return {"obs_ci_lower": unknown, "obs_ci_upper": unknown}
    conditions = truth[list(surface.law.law.conditions)].to_numpy(float)
    slip = truth["slide_roll_ratio"].to_numpy(float)
    answer = surface.answer(surface.law.law, conditions, slip, _LEVEL, whole_curve=False)
    return {"obs_ci_lower": answer.lower, "obs_ci_upper": answer.upper}


def _predicted(
    fitted: FittedLaw, fit: Mapping[Hashable, Any], truth: pd.DataFrame, within: float
) -> pd.DataFrame:
    """The traction of one law beside the truth of its oil.

    Args:
        fitted: The law.
        fit: Its row of the table of fit quality.
        truth: Rows of its oil of the table `truth_grid`, with the interval of the next run.
        within: As in `is_beyond`.
    """
    conditions = truth[list(fitted.law.conditions)].to_numpy()
    mu = fitted.predict(conditions, truth["slide_roll_ratio"].to_numpy())
    box = [[fit[f"tested_min_{name}"], fit[f"tested_max_{name}"]] for name in CONDITIONS]
    beyond = is_beyond(truth[list(CONDITIONS)].to_numpy(), np.array(box), within)
    names_beyond = [tuple(_SHORT_NAMES[beyond_of_point].tolist()) for beyond_of_point in beyond]
    named = truth.rename(columns={"traction_coefficient": "true_traction_coefficient"})
    predicted = named.assign(
        law=fit["law"],
        beyond=tables.lists(names_beyond, named.index),
        traction_coefficient=mu.traction_coefficient,
    )
    for name in ("mean_ci_lower", "mean_ci_upper"):
        predicted[name] = getattr(mu, name)
    limited = ["traction_coefficient", *INTERVALS]
    predicted[limited] = predicted[limited].clip(-_LARGEST_MU, _LARGEST_MU)
    return predicted


def extrapolation_errors(compared: pd.DataFrame) -> pd.DataFrame:
    """Errors over all oils and figures, one row per law that was fitted.

    Args:
        compared: Table `extrapolation`.

    Returns:
        Table `extrapolation_errors`; NaN where no condition is in the tested box, or beyond it.
    """
    rows = []
    for law, group in compared.dropna(subset="traction_coefficient").groupby("law", sort=False):
        beyond = group[group["beyond"].map(len) > 0]
        supported = beyond.dropna(subset="obs_ci_lower")
        covered = supported["true_traction_coefficient"].between(
            supported["obs_ci_lower"], supported["obs_ci_upper"]
        )
        error = group["traction_coefficient"] - group["true_traction_coefficient"]
        row = {
            "law": law,
            "relative_rms": relative_rms(group),
            "inside_relative_rms": relative_rms(group.drop(beyond.index)),
            "beyond_relative_rms": relative_rms(beyond),
            "beyond_obs_ci_ratio": covered.mean(),
            "beyond_supported_ratio": beyond["obs_ci_lower"].notna().mean(),
        }
        worst = group[_WORST].iloc[int(first_largest(error.abs()))]
        row.update(worst.add_prefix("worst_"))
        rows.append(row)
    return tables.from_rows(rows, "extrapolation_errors")


def relative_rms(compared: pd.DataFrame) -> float:
    """Root-mean-square error over the root-mean-square of true mu; NaN where nothing was fitted."""
    fitted = compared.dropna(subset="traction_coefficient")
    if fitted.empty:
        return np.nan
    true = fitted["true_traction_coefficient"]
    error = np.linalg.norm(fitted["traction_coefficient"] - true)
    return float(error / np.linalg.norm(true))


def is_beyond(levels: FloatArray, box: FloatArray, within: float) -> npt.NDArray[np.bool_]:
    """Which levels are beyond the tested ones; all of them where the tested ones are unknown.

    Args:
        levels: Levels, shape (points, conditions).
        box: Smallest and largest tested level of each condition, shape (conditions, 2).
        within: Share of a level by which runs may miss it. Levels so near to the box count as
            tested.

    Returns:
        Shape (points, conditions).
    """
    low, high = box.T
    slack = within * high
    return ~(reaches(levels, low - slack) & reaches(high + slack, levels))
