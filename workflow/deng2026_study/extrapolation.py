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
from oilfilm.settings.resolved import Settings
from oilfilm.traction import LAWS
from oilfilm.traction.law import CONDITIONS, Law
from simulated_lab.truth import known_contact, true_tractions

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
) -> pd.DataFrame:
    """Every fitted law's traction, with its own interval, beside the true one.

    Args:
        truth: Table `truth_grid`.
        coefficients: Table of coefficients, of any number of laws.
        refits: Table of refits.
        quality: Table of fit quality, which has each fit's tested box.
        within: As in `is_beyond`.
        laws: The laws by name, for each oil; without it those that need no properties of the oil.

    Returns:
        Table `extrapolation`: one row per law and row of `truth`.
    """
    # grouped once, because the table is long
    refits_of_fit = dict(iter(refits.groupby(["oil", "law"])))
    parts = []
    for oil, truth_of_oil in truth.groupby("oil", sort=False):
        laws_of_oil = LAWS if laws is None else laws[str(oil)]
        for fit in quality[quality["oil"] == oil].to_dict("records"):
            law = str(fit["law"])
            own_refits = refits_of_fit.get((oil, law), refits.iloc[:0])
            fitted = FittedLaw.from_tables(
                coefficients, str(oil), own_refits, quality, laws_of_oil[law]
            )
            parts.append(_predicted(fitted, fit, truth_of_oil, within))
    return tables.conform(pd.concat(parts, ignore_index=True), "extrapolation", "extrapolation")


def _predicted(
    fitted: FittedLaw, fit: Mapping[Hashable, Any], truth: pd.DataFrame, within: float
) -> pd.DataFrame:
    """The traction of one law beside the truth of its oil.

    Args:
        fitted: The law.
        fit: Its row of the table of fit quality.
        truth: Rows of its oil of the table `truth_grid`.
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
    for name in INTERVALS:
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
        true = beyond["true_traction_coefficient"]
        covered = true.between(beyond["obs_ci_lower"], beyond["obs_ci_upper"]).mean()
        has_intervals = beyond["obs_ci_lower"].notna().all()
        error = group["traction_coefficient"] - group["true_traction_coefficient"]
        row = {
            "law": law,
            "relative_rms": relative_rms(group),
            "inside_relative_rms": relative_rms(group.drop(beyond.index)),
            "beyond_relative_rms": relative_rms(beyond),
            "beyond_obs_ci_ratio": covered if has_intervals else np.nan,
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
