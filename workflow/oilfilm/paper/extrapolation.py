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
from oilfilm.fits.fitted import INTERVALS, FittedLaw
from oilfilm.traction import LAWS
from oilfilm.traction.law import CONDITIONS, Law
from oilfilm.units import FloatArray

_CUT_OFF = 1e6  # of mu, for laws that run away: its errors must be numbers of a table
_SHORT_NAMES = np.array(["pressure", "speed", "temperature"])  # of CONDITIONS


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
    parts = []
    for oil, of_oil in truth.groupby("oil", sort=False):
        named = of_oil.rename(columns={"traction_coefficient": "true_traction_coefficient"})
        fits = coefficients[coefficients["oil"] == oil]
        known = LAWS if laws is None else laws[str(oil)]
        for law in fits["law"].unique():
            fitted = FittedLaw.of(fits, str(oil), refits, quality, known[law])
            conditions = of_oil[list(fitted.law.conditions)].to_numpy()
            predicted = fitted.predict(conditions, of_oil["slide_roll_ratio"].to_numpy())
            numbers = {
                "traction_coefficient": predicted.traction_coefficient,
                **{name: getattr(predicted, name) for name in INTERVALS},
            }
            of_fit = quality[(quality["oil"] == oil) & (quality["law"] == law)]
            beyond = _beyond(of_oil, of_fit.iloc[0], within)
            cut = {name: np.clip(mu, -_CUT_OFF, _CUT_OFF) for name, mu in numbers.items()}
            parts.append(named.assign(law=law, beyond=beyond, **cut))
    return tables.conform(pd.concat(parts, ignore_index=True), "extrapolation", "extrapolation")


def extrapolation_errors(compared: pd.DataFrame) -> pd.DataFrame:
    """Errors of each law for each oil, by figure and by the conditions outside the tested box.

    Args:
        compared: Table `extrapolation`.

    Returns:
        Table `extrapolation_errors`.
    """
    keys = ["law", "oil", "figure", "beyond"]
    groups = compared.groupby(keys, sort=False)
    rows = [dict(zip(keys, key, strict=True)) | _errors(group) for key, group in groups]
    return tables.from_rows(rows, "extrapolation_errors")


def errors_by_law(compared: pd.DataFrame) -> list[dict[str, Any]]:
    """The errors over all oils and figures, one row per law that was fitted.

    Args:
        compared: Table `extrapolation`.

    Returns:
        `law`, the relative rms errors `inside_relative_rms` and `beyond_relative_rms` (of the
        tested box; NaN without such conditions), `beyond_obs_ci_ratio`, and the columns of the
        worst condition as in the table `extrapolation_errors`.
    """
    rows = []
    for law, group in compared.dropna(subset="traction_coefficient").groupby("law", sort=False):
        outside = group["beyond"] != ""
        beyond = _errors(group[outside])
        rows.append(
            _errors(group)
            | {"law": law, "inside_relative_rms": relative_rms(group[~outside])}
            | {f"beyond_{name}": beyond[name] for name in ("relative_rms", "obs_ci_ratio")}
        )
    return rows


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
    return [", ".join(_SHORT_NAMES[row]) for row in outside]


def _errors(compared: pd.DataFrame) -> dict[str, Any]:
    """Errors over some rows; null where no row has a fitted value."""
    at = (*CONDITIONS, "slide_roll_ratio", "true_traction_coefficient", "traction_coefficient")
    error = compared["traction_coefficient"] - compared["true_traction_coefficient"]
    rows, error = compared[error.notna()], error.dropna()
    if rows.empty:
        sizes = ("rmse", "relative_rms", "mean_error", "max_error", "obs_ci_ratio", "mean_ci_ratio")
        names = (*sizes, *(f"worst_{name}" for name in at))
        return {"n_conditions": 0, **dict.fromkeys(names, np.nan)}
    rmse = np.sqrt(np.mean(error.to_numpy() ** 2))
    worst = rows.iloc[int(error.abs().to_numpy().argmax())]
    return {
        "n_conditions": len(rows),
        "rmse": rmse,
        "relative_rms": rmse / np.sqrt(np.mean(rows["true_traction_coefficient"] ** 2)),
        "mean_error": error.to_numpy().mean(),
        "max_error": error.abs().max(),
        **{f"{kind}_ratio": _held(rows, kind) for kind in ("obs_ci", "mean_ci")},
        **{f"worst_{name}": worst[name] for name in at},
    }


def _held(rows: pd.DataFrame, kind: str) -> float:
    """Share of rows whose interval contains the truth; NaN where a row has none."""
    lower, upper = rows[f"{kind}_lower"], rows[f"{kind}_upper"]
    held = rows["true_traction_coefficient"].between(lower, upper)
    return float(held.mean()) if lower.notna().all() else float("nan")
