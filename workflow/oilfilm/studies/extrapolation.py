"""How wrong fitted laws are where the truth is known: at the conditions of Figs 7-10, simulated.

The answer is about laws, not about oils: a law that fails here fails in a world like the simulated
one, and nothing is decided about the real oils.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from oilfilm import tables
from oilfilm.fitting.fitted import FittedLaw
from oilfilm.traction import LAWS
from oilfilm.traction.law import CONDITIONS, Law
from oilfilm.units import FloatArray

_CUT_OFF = 1e6  # of mu, for laws that run away: its errors must be numbers of a table
_WORDS = ("pressure", "speed", "temperature")  # of CONDITIONS


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
        quality: Table of fit quality, which knows each fit's tested box.
        within: As in `is_beyond`.
        laws: The laws by name, for each oil; without it those that need no properties of the oil.

    Returns:
        Table `extrapolation`: a row for each law and row of `truth`.
    """
    parts = []
    for oil, of_oil in truth.groupby("oil", sort=False):
        named = of_oil.rename(columns={"traction_coefficient": "true_traction_coefficient"})
        fits = coefficients[coefficients["oil"] == oil]
        known = LAWS if laws is None else laws[str(oil)]
        for law in fits["law"].unique():
            fitted = FittedLaw.of(fits, str(oil), refits, quality, known[law])
            conditions = of_oil[list(fitted.law.conditions)].to_numpy()
            found = fitted.predict(conditions, of_oil["slide_roll_ratio"].to_numpy())
            numbers = {
                "traction_coefficient": found.traction_coefficient,
                "traction_coefficient_lower": found.lower,
                "traction_coefficient_upper": found.upper,
            }
            of_fit = quality[(quality["oil"] == oil) & (quality["law"] == law)]
            beyond = _beyond(of_oil, of_fit.iloc[0], within)
            cut = {name: np.clip(mu, -_CUT_OFF, _CUT_OFF) for name, mu in numbers.items()}
            parts.append(named.assign(law=law, beyond=beyond, **cut))
    return tables.conform(pd.concat(parts, ignore_index=True), "extrapolation", "extrapolation")


def extrapolation_errors(compared: pd.DataFrame) -> pd.DataFrame:
    """Errors of each law for each oil, by figure and by what lies outside the tested box.

    Args:
        compared: Table `extrapolation`.

    Returns:
        Table `extrapolation_errors`.
    """
    keys = ["law", "oil", "figure", "beyond"]
    groups = compared.groupby(keys, sort=False)
    rows = [dict(zip(keys, key, strict=True)) | _errors(group) for key, group in groups]
    return tables.from_rows(rows, "extrapolation_errors")


def extrapolation_words(compared: pd.DataFrame) -> list[str]:
    """The errors of each law over all oils and figures, a sentence a law that was fitted."""
    lines = []
    for law, group in compared.dropna(subset="traction_coefficient").groupby("law", sort=False):
        outside = group["beyond"] != ""
        where = (("in the tested box", group[~outside]), ("beyond it", group[outside]))
        sizes = [
            f"{100 * relative_rms(rows):.3g} % of mu {words}" for words, rows in where if len(rows)
        ]
        at = _errors(group)
        lines.append(
            f"{law}: rms error {', '.join(sizes)}; at worst mu "
            f"{at['worst_traction_coefficient']:.4g} for "
            f"{at['worst_true_traction_coefficient']:.4g}, at "
            f"{at['worst_max_hertz_pressure_gpa']:g} GPa, "
            f"{at['worst_entrainment_speed_m_s']:g} m/s, "
            f"{at['worst_inlet_temperature_c']:g} degC, S {at['worst_slide_roll_ratio']:g}"
            + _held(group[outside])
        )
    return lines


def _held(beyond: pd.DataFrame) -> str:
    share = _errors(beyond)["interval_ratio"]
    words = f"; beyond it the fit's own 95 % interval holds the truth at {share:.0%} of conditions"
    return "" if np.isnan(share) else words


def relative_rms(compared: pd.DataFrame) -> float:
    """Root-mean-square error over the root-mean-square of true mu; NaN where nothing was fitted."""
    return float(_errors(compared)["relative_rms"])


def is_beyond(at: FloatArray, box: FloatArray, within: float) -> npt.NDArray[np.bool_]:
    """Which levels lie outside those tested; all where none is known.

    Args:
        at: Levels, shape (points, conditions).
        box: Smallest and largest tested level of each condition, shape (conditions, 2).
        within: Share of a level that every run of it may have missed; it is tested all the same.
    """
    low, high = box.T
    slack = within * high
    return np.asarray(~((at >= low - slack) & (at <= high + slack)))


def _beyond(truth: pd.DataFrame, fit: "pd.Series[Any]", within: float) -> list[str]:
    """The conditions of each row that lie outside those fitted, joined."""
    box = np.array(
        [[fit[f"tested_min_{name}"], fit[f"tested_max_{name}"]] for name in CONDITIONS], dtype=float
    )
    outside = is_beyond(truth[list(CONDITIONS)].to_numpy(), box, within)
    return [", ".join(np.array(_WORDS)[row]) for row in outside]


def _errors(compared: pd.DataFrame) -> dict[str, Any]:
    """Errors over some rows; null where no row has a fitted value."""
    error = (compared["traction_coefficient"] - compared["true_traction_coefficient"]).to_numpy()
    known = ~np.isnan(error)
    at = (*CONDITIONS, "slide_roll_ratio", "true_traction_coefficient", "traction_coefficient")
    sizes = ("rmse", "relative_rms", "mean_error", "max_error", "interval_ratio")
    names = (*sizes, *(f"worst_{name}" for name in at))
    if not known.any():
        return {"n_conditions": 0, **dict.fromkeys(names, np.nan)}
    rows, error = compared[known], error[known]
    worst = rows.iloc[int(np.abs(error).argmax())]
    rmse = np.sqrt(np.mean(error**2))
    size = np.sqrt(np.mean(rows["true_traction_coefficient"] ** 2))
    interval = rows["traction_coefficient_lower"], rows["traction_coefficient_upper"]
    held = rows["true_traction_coefficient"].between(*interval)
    share = held.mean() if interval[0].notna().all() else np.nan
    summed = (rmse, rmse / size, error.mean(), np.abs(error).max(), share)
    values = (*summed, *(worst[name] for name in at))
    return {"n_conditions": len(rows), **dict(zip(names, values, strict=True))}
