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
from oilfilm.fits.fitted import INTERVAL_COLUMNS, FittedLaw
from oilfilm.fits.measured_surface import OilSurface
from oilfilm.settings.resolved import Settings
from oilfilm.traction import LAWS
from oilfilm.traction.law import CONDITIONS, Law
from simulated_lab.truth import contact_of_only_rig, true_tractions

# Confidence level of the interval of the next run.
_CONFIDENCE_LEVEL = 0.95
# Largest |mu| in the table. A law may give far more beyond the tested box; errors must be finite.
_LARGEST_MU = 1e6
# Columns that describe the worst condition of a law.
_WORST_COLUMNS = [
    *CONDITIONS,
    "slide_roll_ratio",
    "true_traction_coefficient",
    "traction_coefficient",
]
# Short names of `CONDITIONS`.
_SHORT_NAMES = np.array(["pressure", "speed", "temperature"])


def truth_grid(settings: Settings, constants_by_oil: Mapping[str, FloatArray]) -> pd.DataFrame:
    """The true traction at the conditions of Figs 7-10, as table `truth_grid`.

    Args:
        settings: The settings of a simulated campaign.
        constants_by_oil: The printed constants of each oil.

    Raises:
        OilfilmError: As `true_tractions`.
    """
    contact = contact_of_only_rig(settings)
    grids = []
    for oil, true_traction in true_tractions(settings, constants_by_oil).items():
        for figure, conditions in study_settings(settings).extrapolation.items():
            levels = conditions.model_dump()
            grid = pd.DataFrame(itertools.product(*levels.values()), columns=list(levels))
            mu = true_traction(*(grid[name].to_numpy(dtype=float) for name in levels))
            load_n = contact.load_n(grid["max_hertz_pressure_gpa"].to_numpy())
            grids.append(
                grid.assign(oil=oil, figure=figure, load_n=load_n, traction_coefficient=mu)
            )
    return tables.conform(pd.concat(grids, ignore_index=True), "truth_grid", "truth of the twin")


def extrapolate(
    truth: pd.DataFrame,
    coefficients: pd.DataFrame,
    refits: pd.DataFrame,
    quality: pd.DataFrame,
    level_tolerance: float,
    laws_by_oil: Mapping[str, Mapping[str, Law]] | None = None,
    surface_by_oil: Mapping[str, OilSurface | None] | None = None,
) -> pd.DataFrame:
    """Every fitted law's traction, with the interval of the next run, beside the true one.

    Args:
        truth: Table `truth_grid`.
        coefficients: Table of coefficients, of any number of laws.
        refits: Table of refits.
        quality: Table of fit quality, which has each fit's tested box.
        level_tolerance: As in `is_beyond`.
        laws_by_oil: The laws by name, for each oil; if not given, the laws that need no properties
            of an oil.
        surface_by_oil: The surface of each oil, which gives the interval of the next run; without
            it there is no interval.

    Returns:
        Table `extrapolation`: one row per law and row of `truth`.
    """
    # grouped once, because the table is long
    refits_of_fit = dict(iter(refits.groupby(["oil", "law"])))
    frames = []
    for oil, truth_of_oil in truth.groupby("oil", sort=False):
        laws_of_oil = LAWS if laws_by_oil is None else laws_by_oil[str(oil)]
        interval_columns = _interval_of_next_run((surface_by_oil or {}).get(str(oil)), truth_of_oil)
        for quality_row in quality[quality["oil"] == oil].to_dict("records"):
            law_name = str(quality_row["law"])
            refits_of_law = refits_of_fit.get((oil, law_name), refits.iloc[:0])
            fitted = FittedLaw.from_tables(
                coefficients, str(oil), refits_of_law, quality, laws_of_oil[law_name]
            )
            frames.append(
                _rows_of_fit(
                    fitted, quality_row, truth_of_oil.assign(**interval_columns), level_tolerance
                )
            )
    return tables.conform(pd.concat(frames, ignore_index=True), "extrapolation", "extrapolation")


def _interval_of_next_run(surface: OilSurface | None, truth: pd.DataFrame) -> dict[str, FloatArray]:
    """Columns `obs_ci_lower` and `obs_ci_upper`; NaN without a surface, or without its support.

    Args:
        surface: The surface of an oil.
        truth: Rows of this oil of the table `truth_grid`, for their conditions and slips.
    """
    if surface is None:
        no_interval = np.full(len(truth), np.nan)
        return {"obs_ci_lower": no_interval, "obs_ci_upper": no_interval}
    conditions = truth[list(surface.law.law.conditions)].to_numpy(float)
    slip = truth["slide_roll_ratio"].to_numpy(float)
    prediction = surface.predict(
        surface.law.law, conditions, slip, _CONFIDENCE_LEVEL, whole_curve=False
    )
    return {"obs_ci_lower": prediction.lower, "obs_ci_upper": prediction.upper}


def _rows_of_fit(
    fitted: FittedLaw,
    quality_row: Mapping[Hashable, Any],
    truth: pd.DataFrame,
    level_tolerance: float,
) -> pd.DataFrame:
    """The traction of one law beside the truth of its oil.

    Args:
        fitted: The law.
        quality_row: Its row of the table of fit quality.
        truth: Rows of its oil of the table `truth_grid`, with the interval of the next run.
        level_tolerance: As in `is_beyond`.
    """
    conditions = truth[list(fitted.law.conditions)].to_numpy()
    prediction = fitted.predict(conditions, truth["slide_roll_ratio"].to_numpy())
    box = [
        [quality_row[f"tested_min_{name}"], quality_row[f"tested_max_{name}"]]
        for name in CONDITIONS
    ]
    is_beyond_box = is_beyond(truth[list(CONDITIONS)].to_numpy(), np.array(box), level_tolerance)
    names_of_conditions_beyond = [
        tuple(_SHORT_NAMES[is_beyond_at_point].tolist()) for is_beyond_at_point in is_beyond_box
    ]
    with_true_mu = truth.rename(columns={"traction_coefficient": "true_traction_coefficient"})
    rows = with_true_mu.assign(
        law=quality_row["law"],
        beyond=tables.list_column(names_of_conditions_beyond, with_true_mu.index),
        traction_coefficient=prediction.traction_coefficient,
    )
    for name in ("mean_ci_lower", "mean_ci_upper"):
        rows[name] = getattr(prediction, name)
    limited_columns = ["traction_coefficient", *INTERVAL_COLUMNS]
    rows[limited_columns] = rows[limited_columns].clip(-_LARGEST_MU, _LARGEST_MU)
    return rows


def extrapolation_errors(compared: pd.DataFrame) -> pd.DataFrame:
    """Errors over all oils and figures, one row per law that was fitted.

    Args:
        compared: Table `extrapolation`.

    Returns:
        Table `extrapolation_errors`; NaN where no condition is in the tested box, or beyond it.
    """
    error_rows = []
    for law_name, rows_of_law in compared.dropna(subset="traction_coefficient").groupby(
        "law", sort=False
    ):
        rows_beyond = rows_of_law[rows_of_law["beyond"].map(len) > 0]
        rows_with_interval = rows_beyond.dropna(subset="obs_ci_lower")
        is_covered = rows_with_interval["true_traction_coefficient"].between(
            rows_with_interval["obs_ci_lower"], rows_with_interval["obs_ci_upper"]
        )
        error = rows_of_law["traction_coefficient"] - rows_of_law["true_traction_coefficient"]
        error_row = {
            "law": law_name,
            "relative_rms": relative_rms(rows_of_law),
            "inside_relative_rms": relative_rms(rows_of_law.drop(rows_beyond.index)),
            "beyond_relative_rms": relative_rms(rows_beyond),
            "beyond_obs_ci_ratio": is_covered.mean(),
            "beyond_supported_ratio": rows_beyond["obs_ci_lower"].notna().mean(),
        }
        worst_row = rows_of_law[_WORST_COLUMNS].iloc[int(first_largest(error.abs()))]
        error_row.update(worst_row.add_prefix("worst_"))
        error_rows.append(error_row)
    return tables.from_rows(error_rows, "extrapolation_errors")


def relative_rms(compared: pd.DataFrame) -> float:
    """Root-mean-square error over the root-mean-square of true mu; NaN where nothing was fitted.

    Args:
        compared: Rows of the table `extrapolation`.
    """
    rows_with_fit = compared.dropna(subset="traction_coefficient")
    if rows_with_fit.empty:
        return np.nan
    true_mu = rows_with_fit["true_traction_coefficient"]
    error_norm = np.linalg.norm(rows_with_fit["traction_coefficient"] - true_mu)
    return float(error_norm / np.linalg.norm(true_mu))


def is_beyond(levels: FloatArray, box: FloatArray, level_tolerance: float) -> npt.NDArray[np.bool_]:
    """Whether levels are beyond the tested ones; true where the tested ones are unknown.

    Args:
        levels: Levels, shape (points, conditions).
        box: Smallest and largest tested level of each condition, shape (conditions, 2).
        level_tolerance: Share of the largest tested level of a condition. Levels that are beyond
            the box by so much at most count as tested.

    Returns:
        Shape (points, conditions).
    """
    lowest, highest = box.T
    slack = level_tolerance * highest
    return ~(reaches(levels, lowest - slack) & reaches(highest + slack, levels))
