"""Residuals of the fit against every condition: where the law lacks something."""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from oilfilm.curation.coverage import with_levels
from oilfilm.fits.fitted import FittedLaw
from oilfilm.report.figures import style
from oilfilm.report.figures.registry import Drawing, marks, register
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables

_LABELS = {
    "max_hertz_pressure_gpa": "P (GPa)",
    "entrainment_speed_m_s": "U (m/s)",
    "inlet_temperature_c": "T (\N{DEGREE SIGN}C)",
    "slide_roll_ratio": "|S|",
}
_DELTA = "\N{GREEK CAPITAL LETTER DELTA}\N{GREEK SMALL LETTER MU}"
_GROUPS = 15  # of equally many points, where no set points tell levels apart
_MILLI = 1e3


@register(
    name="residuals",
    title="Residuals of the fit",
    caption="Measured minus fitted traction coefficient of all accepted plateaus against "
    "maximum Hertz pressure (GPa), entrainment speed (m/s), inlet temperature (\N{DEGREE SIGN}C) "
    "and slide-roll ratio. Symbols with bars: mean and scatter at each level. A mean away from "
    "zero shows a systematic error of the law.",
    category="Fits",
    family="data",
    tables=("points", "runs", "coefficients"),
    settings=("oils", "rigs", "same_set_point", "campaign.matrix"),
)
def residuals(results: CampaignTables, settings: Settings) -> Drawing:
    """One row of panels per oil, one column per condition: points, mean and scatter by level."""
    oils, runs = list(settings.oils), with_levels(results.runs, settings)
    figure = Figure(figsize=(style.DOUBLE_COLUMN_IN, 1.45 * len(oils) + 0.6))
    axes = figure.subplots(len(oils), len(_LABELS), sharex="col", sharey="row", squeeze=False)
    drawn: list[pd.DataFrame] = []
    for row, oil in enumerate(oils):
        points = _residuals(results, runs, oil)
        axes[row, 0].set_ylabel(f"{oil}: {_DELTA} (10$^{{-3}}$)")
        for column, condition in enumerate(_LABELS):
            axis = axes[row, column]
            panel = style.title_panel(axis, row * len(_LABELS) + column)
            if points is None or points[condition].isna().all():
                style.say_in_panel(axis, "no fit" if points is None else "not known")
                continue
            drawn += _draw(axis, panel, points, condition, oil, oils)
    for axis, label in zip(axes[-1], _LABELS.values(), strict=True):
        axis.set_xlabel(label)
    look: dict[str, Any] = {"linestyle": "none", "color": "black"}
    mean = "mean of a level, with the standard deviation of its plateaus"
    handles = [
        style.line_handle("plateau", marker=".", markersize=3, **look),
        style.line_handle(mean, marker="o", markerfacecolor="white", **look),
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=2)
    style.say_key(figure, f"{_DELTA}: measured minus fitted")
    return figure, drawn


def _residuals(results: CampaignTables, runs: pd.DataFrame, oil: str) -> pd.DataFrame | None:
    """Accepted points with their residual and the levels of their run; None without a fit."""
    of_oil = results.configured.coefficients[results.configured.coefficients["oil"] == oil]
    points = results.points[results.points["accepted"] & (results.points["oil"] == oil)]
    if of_oil.empty or points.empty:
        return None
    law = FittedLaw.of(of_oil, oil)
    slip = points["slide_roll_ratio"].to_numpy()
    fitted = law.predict(points[list(law.law.conditions)].to_numpy(), slip).traction_coefficient
    if np.isnan(fitted).all():
        return None
    # slip and traction of a rig that reverses the slip change sign together
    residual = np.where(slip < 0, -1, 1) * (points["traction_coefficient"] - fitted)
    nominal = [f"nominal_{name}" for name in _LABELS if name != "slide_roll_ratio"]
    known = points.assign(residual=_MILLI * residual, slide_roll_ratio=np.abs(slip))
    return known.merge(runs[["run_id", *nominal]], on="run_id")


def _draw(
    axis: Axes, panel: str, points: pd.DataFrame, condition: str, oil: str, oils: Sequence[str]
) -> Iterator[pd.DataFrame]:
    dots: dict[str, Any] = {"alpha": 0.25, "markersize": 1.2, "rasterized": True}
    x, y = points[condition], points["residual"]
    axis.plot(x, y, ".", color=style.oil_colour(oil, oils), **dots)
    yield marks(panel, "point", x, y, oil=oil)
    axis.axhline(0, color="black", linewidth=0.6)
    groups = points.groupby(_levels(points, condition), observed=True)
    means = groups.agg(x=(condition, "mean"), y=("residual", "mean"), spread=("residual", "std"))
    look: dict[str, Any] = {"fmt": "o", "color": "black", "markerfacecolor": "white"}
    look |= {"elinewidth": 0.7, "markeredgewidth": 0.7}
    at, mean, spread = means.to_numpy().T
    axis.errorbar(at, mean, spread, **look)
    yield marks(panel, "mean", at, mean, oil=oil, lower=mean - spread, upper=mean + spread)


def _levels(points: pd.DataFrame, condition: str) -> "pd.Series[Any]":
    """The level of each point: its set point, or a group of equally many points."""
    nominal = f"nominal_{condition}"
    if nominal in points and points[nominal].notna().all():
        return points[nominal]
    return pd.qcut(points[condition], _GROUPS, duplicates="drop")
