"""How wrong fitted laws are where the truth is known: at the conditions of Figs 7-10, simulated.

The answer is about laws, not about oils: a law that fails here fails in a world like the simulated
one, and nothing is decided about the real oils.
"""

import itertools
from collections.abc import Mapping

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

_CUT_OFF = 1e6  # of mu, for laws that run away: its errors must be numbers of a table
_AT = [*CONDITIONS, "slide_roll_ratio", "true_traction_coefficient", "traction_coefficient"]
_SHORT_NAMES = np.array(["pressure", "speed", "temperature"])  # of CONDITIONS


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
    # once, as the table is long
    spread = dict(iter(refits.groupby(["oil", "law"])))
    parts = []
    for oil, of_oil in truth.groupby("oil", sort=False):
        named = of_oil.rename(columns={"traction_coefficient": "true_traction_coefficient"})
        known = LAWS if laws is None else laws[str(oil)]
        for fit in quality[quality["oil"] == oil].to_dict("records"):
            law = str(fit["law"])
            own = spread.get((oil, law), refits.iloc[:0])
            fitted = FittedLaw.of(coefficients, str(oil), own, quality, known[law])
            conditions = of_oil[list(fitted.law.conditions)].to_numpy()
            mu = fitted.predict(conditions, of_oil["slide_roll_ratio"].to_numpy())
            box = [[fit[f"tested_min_{name}"], fit[f"tested_max_{name}"]] for name in CONDITIONS]
            outside = is_beyond(of_oil[list(CONDITIONS)].to_numpy(), np.array(box), within)
            regions = [tuple(_SHORT_NAMES[row].tolist()) for row in outside]
            predicted = named.assign(
                law=law,
                beyond=tables.lists(regions, named.index),
                traction_coefficient=mu.traction_coefficient,
                **{name: getattr(mu, name) for name in INTERVALS},
            )
            cut = ["traction_coefficient", *INTERVALS]
            predicted[cut] = predicted[cut].clip(-_CUT_OFF, _CUT_OFF)
            parts.append(predicted)
    return tables.conform(pd.concat(parts, ignore_index=True), "extrapolation", "extrapolation")


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
        held = true.between(beyond["obs_ci_lower"], beyond["obs_ci_upper"]).mean()
        error = group["traction_coefficient"] - group["true_traction_coefficient"]
        row = {
            "law": law,
            "relative_rms": relative_rms(group),
            "inside_relative_rms": relative_rms(group.drop(beyond.index)),
            "beyond_relative_rms": relative_rms(beyond),
            "beyond_obs_ci_ratio": held if beyond["obs_ci_lower"].notna().all() else np.nan,
        }
        worst = group[_AT].iloc[int(first_largest(error.abs()))].add_prefix("worst_")
        rows.append(row | dict(worst))
    return tables.from_rows(rows, "extrapolation_errors")


def relative_rms(compared: pd.DataFrame) -> float:
    """Root-mean-square error over the root-mean-square of true mu; NaN where nothing was fitted."""
    fitted = compared.dropna(subset="traction_coefficient")
    true = fitted["true_traction_coefficient"]
    error = np.linalg.norm(fitted["traction_coefficient"] - true)
    return float(error / np.linalg.norm(true)) if len(fitted) else np.nan


def is_beyond(at: FloatArray, box: FloatArray, within: float) -> npt.NDArray[np.bool_]:
    """Which levels lie outside those tested; all where none is known.

    Args:
        at: Levels, shape (points, conditions).
        box: Smallest and largest tested level of each condition, shape (conditions, 2).
        within: Share of a level that every run of it may have missed; it is tested all the same.
    """
    low, high = box.T
    slack = within * high
    return ~(reaches(at, low - slack) & reaches(high + slack, at))
