"""How wrong fitted laws are where the truth is known: at the conditions of Figs 7-10, simulated.

The answer is about laws, not about oils: a law that fails here fails in a world like the simulated
one, and nothing is decided about the real oils.
"""

from typing import Any

import numpy as np
import pandas as pd

from oilfilm import tables
from oilfilm.fitting.fitted import FittedLaw
from oilfilm.traction.law import CONDITIONS

_CUT_OFF = 1e6  # of mu, for laws that run away: its errors must be numbers of a table
_WORDS = ("pressure", "speed", "temperature")  # of CONDITIONS


def extrapolate(
    truth: pd.DataFrame, coefficients: pd.DataFrame, coverage: pd.DataFrame
) -> pd.DataFrame:
    """Every fitted law's traction beside the true one.

    Args:
        truth: Table `truth_grid`.
        coefficients: Table of coefficients, of any number of laws.
        coverage: Table of coverage; its accepted conditions span an oil's tested box.

    Returns:
        Table `extrapolation`: a row for each law and row of `truth`.
    """
    tested = coverage[coverage["state"] == "accepted"]
    parts = []
    for oil, of_oil in truth.groupby("oil", sort=False):
        beyond = _beyond(of_oil, tested[tested["oil"] == oil])
        named = of_oil.rename(columns={"traction_coefficient": "true_traction_coefficient"})
        fits = coefficients[coefficients["oil"] == oil]
        for law, fit in fits.groupby("law", sort=False):
            mu = _traction(FittedLaw.of(fit, str(oil)), of_oil).clip(-_CUT_OFF, _CUT_OFF)
            parts.append(named.assign(law=law, traction_coefficient=mu, beyond=beyond))
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
        )
    return lines


def relative_rms(compared: pd.DataFrame) -> float:
    """Root-mean-square error over the root-mean-square of true mu; NaN where nothing was fitted."""
    return float(_errors(compared)["relative_rms"])


def _beyond(truth: pd.DataFrame, tested: pd.DataFrame) -> list[str]:
    """The conditions of each row that lie outside the levels tested, joined; all if none was."""
    levels = tested[[f"nominal_{name}" for name in CONDITIONS]]
    low, high = levels.min().to_numpy(), levels.max().to_numpy()
    at = truth[list(CONDITIONS)].to_numpy()
    # a set point by Hertz from a load carries the load's rounding
    slack = 1e-3 * high
    outside = ~((at >= low - slack) & (at <= high + slack))
    return [", ".join(np.array(_WORDS)[row]) for row in outside]


def _traction(law: FittedLaw, truth: pd.DataFrame) -> "pd.Series[float]":
    """A fitted law at each row."""
    return pd.concat(
        [
            pd.Series(
                law.traction(np.array(levels), rows["slide_roll_ratio"].to_numpy()), rows.index
            )
            for levels, rows in truth.groupby(list(CONDITIONS), sort=False)
        ]
    )


def _errors(compared: pd.DataFrame) -> dict[str, Any]:
    """Errors over some rows; null where no row has a fitted value."""
    error = (compared["traction_coefficient"] - compared["true_traction_coefficient"]).to_numpy()
    known = ~np.isnan(error)
    at = (*CONDITIONS, "slide_roll_ratio", "true_traction_coefficient", "traction_coefficient")
    names = ("rmse", "relative_rms", "mean_error", "max_error", *(f"worst_{name}" for name in at))
    if not known.any():
        return {"n_points": 0, **dict.fromkeys(names, np.nan)}
    rows, error = compared[known], error[known]
    worst = rows.iloc[int(np.abs(error).argmax())]
    rmse = np.sqrt(np.mean(error**2))
    size = np.sqrt(np.mean(rows["true_traction_coefficient"] ** 2))
    values = (rmse, rmse / size, error.mean(), np.abs(error).max(), *(worst[name] for name in at))
    return {"n_points": len(rows), **dict(zip(names, values, strict=True))}
