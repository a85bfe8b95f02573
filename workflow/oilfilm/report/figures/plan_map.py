"""The map of tests: how much each rig condition would reduce the uncertainty of the torque."""

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.figure import Figure

from oilfilm.report.figures import style
from oilfilm.report.figures.registry import Drawing, marks, register
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.traction.law import CONDITIONS
from oilfilm.units import FloatArray

_PRESSURE, _SPEED, _TEMPERATURE = CONDITIONS
# The ordinate of each row of panels; of the third condition the best level is shown.
_ROWS = (_PRESSURE, _TEMPERATURE)
_COLOURS = "YlGnBu"


@register(
    name="plan",
    title="Tests to run next",
    caption="Tests that the rig can run, one column of panels per oil. Abscissa: entrainment "
    "speed U (m/s). Ordinate: maximum Hertz pressure P (GPa, top) or inlet temperature T "
    "(\N{DEGREE SIGN}C, bottom). Colour: reduction (%) of the uncertainty of the calculated "
    "friction torque by one more curve. Only the uncertainty from the constants of the law "
    "counts, as root mean square over the duty points. The third condition has its best level. "
    "Numbers: tests to run next, in this order. Circles: measured runs. The plan assumes that "
    "the form of the law is right.",
    category="Bearing",
    family="bearing",
    tables=("test_plan", "points"),
    settings=("oils",),
    requires="torque",
)
def plan_map(results: CampaignTables, settings: Settings) -> Drawing:
    """One column per oil; above P against U, below T against U."""
    tests = results.test_plan
    tests = tests[tests["target"] == "torque"]
    oils = [oil for oil in settings.oils if (tests["oil"] == oil).any()]
    if not oils:
        return style.sentences(
            "No test can be planned for any oil:\n`oilfilm plan` says what is missing."
        ), []
    points = results.points[results.points["accepted"]]
    runs = points.groupby(["oil", "run_id"], as_index=False)[list(CONDITIONS)].mean().dropna()
    figure = Figure(figsize=(style.DOUBLE_COLUMN_IN, 4.2))
    axes = list(figure.subplots(2, len(oils), sharex=True, sharey="row", squeeze=False).flat)
    highest = _reduction(tests).max()
    drawn = []
    for number, axis in enumerate(axes):
        row, column = divmod(number, len(oils))
        oil, y = oils[column], _ROWS[row]
        panel = style.title_panel(axis, number, style.plain(oil), parse_math=False)
        of_oil, of_runs = tests[tests["oil"] == oil], runs[runs["oil"] == oil]
        mesh, parts = _draw(axis, panel, of_oil, of_runs, y, highest)
        drawn += [part.assign(oil=oil) for part in parts]
    for row, y in enumerate(_ROWS):
        axes[row * len(oils)].set_ylabel(style.CONDITION_LABELS[y])
    for axis in axes[len(oils) :]:
        axis.set_xlabel(style.CONDITION_LABELS[_SPEED])
    bar = figure.colorbar(mesh, ax=axes, shrink=0.6, pad=0.01)
    bar.set_label("Reduction of the torque's uncertainty (%)", fontsize=7)
    bar.ax.tick_params(labelsize=6)
    style.say_key(
        figure,
        "Numbers: tests to run next. Circles: measured runs. White: the rig cannot run it with a "
        "full film. True as far as the law's form is, also beyond the measured runs.",
    )
    return figure, drawn


def _reduction(tests: pd.DataFrame) -> FloatArray:
    """By how much one test reduces the uncertainty, in %; below 0 where it would not."""
    return np.asarray(100 * (1 - tests["uncertainty_with_test"] / tests["uncertainty_now"]))


def _draw(
    axis: Axes, panel: str, tests: pd.DataFrame, runs: pd.DataFrame, y: str, highest: float
) -> tuple[QuadMesh, list[pd.DataFrame]]:
    """Cells of speed and `y`, runs and chosen tests."""
    best = tests.loc[tests.groupby([_SPEED, y])["uncertainty_with_test"].idxmin()]
    field = best.assign(reduction=_reduction(best)).pivot(
        index=y, columns=_SPEED, values="reduction"
    )
    mesh = axis.pcolormesh(
        style.cell_edges(field.columns.to_numpy(dtype=float), "linear"),
        style.cell_edges(field.index.to_numpy(dtype=float), "linear"),
        np.ma.masked_invalid(field.to_numpy(dtype=float)),
        cmap=_COLOURS,
        vmin=0,
        vmax=max(highest, 1e-6),
        rasterized=True,
    )
    axis.plot(runs[_SPEED], runs[y], "o", markersize=2.2, markerfacecolor="none", color=style.GREY)
    chosen = tests[tests["test_order"] > 0].sort_values("test_order")
    box: dict[str, Any] = {"boxstyle": "round,pad=0.15", "facecolor": "white", "linewidth": 0.5}
    for (speed, level), same in chosen.groupby([_SPEED, y]):
        # many side by side would cover their neighbours
        numbers = (", " if len(same) < 3 else "\n").join(same["test_order"].astype(str))
        axis.annotate(
            numbers, (speed, level), ha="center", va="center", fontsize=6, weight="bold", bbox=box
        )
    axis.grid(False)
    return mesh, [
        marks(panel, "cell", best[_SPEED], best[y], value=_reduction(best)),
        marks(panel, "measured", runs[_SPEED], runs[y]),
        marks(panel, "chosen", chosen[_SPEED], chosen[y], value=chosen["test_order"]),
    ]
