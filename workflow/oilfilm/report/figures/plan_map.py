"""The map of tests: how much each rig condition would reduce the uncertainty of the torque."""

import itertools
from typing import Any

import numpy as np
import pandas as pd

from oilfilm.report.figures import style
from oilfilm.report.figures.registry import register
from oilfilm.report.figures.sheet import Panel, Sheet, sentences
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.traction.law import CONDITIONS

_PRESSURE, _SPEED, _TEMPERATURE = CONDITIONS
# The ordinate of each row of panels; of the third condition the best level is shown.
_ROWS = (_PRESSURE, _TEMPERATURE)


@register(
    category="Bearing",
    family="bearing",
    tables=("test_plan", "points"),
    settings=("oils",),
    requires="torque",
)
def plan(results: CampaignTables, settings: Settings) -> Sheet:
    """Tests to run next.

    Tests that the rig can run, one column of panels per oil. Abscissa: entrainment speed U
    (m/s). Ordinate: maximum Hertz pressure P (GPa, top) or inlet temperature T
    (\N{DEGREE SIGN}C, bottom). Colour: reduction (%) of the uncertainty of the calculated friction
    torque
    by one more curve. Only the uncertainty from the law counts, its form included, as root mean
    square over the duty points. The third condition has its best level. Numbers: tests to run
    next, in this order. Circles: measured runs. White: the rig cannot run the test with a full
    film.
    """
    tests = results.test_plan
    # by how much one test reduces the uncertainty
    share = tests["uncertainty_with_test"] / tests["uncertainty_now"]
    tests = tests.assign(reduction=100 * (1 - share))[tests["target"] == "torque"]
    oils = [oil for oil in settings.oils if (tests["oil"] == oil).any()]
    if not oils:
        return sentences(
            "No test can be planned for any oil:\n`oilfilm plan` says what is missing."
        )
    points = results.points[results.points["accepted"]]
    runs = points.groupby(["oil", "run_id"], as_index=False)[list(CONDITIONS)].mean().dropna()
    layout: style.Look = {"height": 1.5, "right": 0.7, "sharex": True, "sharey": "row"}
    sheet = Sheet(2 * len(oils), len(oils), width=style.DOUBLE_COLUMN_IN, **layout)
    for number, (y, oil) in enumerate(itertools.product(_ROWS, oils)):
        panel = sheet.panel(number, style.plain(oil), parse_math=False)
        panel.axis.set_ylabel(style.CONDITION_LABELS[y], fontsize=7)
        of_oil, of_runs = tests[tests["oil"] == oil], runs[runs["oil"] == oil]
        mesh = _draw(panel, of_oil, of_runs, y, tests["reduction"].max())
    sheet.label(style.CONDITION_LABELS[_SPEED], fontsize=7)
    sheet.colour_bar(mesh, "Reduction of the torque's uncertainty (%)")
    box: style.Look = {"marker": "s", "color": "black", "markerfacecolor": "white"}
    sheet.legend(
        [
            style.symbol_handle("number: test to run next, in this order", markersize=6, **box),
            style.symbol_handle("measured run", "o", color=style.GREY, markerfacecolor="none"),
        ]
    )
    return sheet


def _draw(panel: Panel, tests: pd.DataFrame, runs: pd.DataFrame, y: str, highest: float) -> Any:
    """Cells of speed and `y`, runs and chosen tests."""
    best = tests.loc[tests.groupby([_SPEED, y])["uncertainty_with_test"].idxmin()]
    field = best.pivot(index=y, columns=_SPEED, values="reduction")
    mesh = panel.axis.pcolormesh(
        style.cell_edges(field.columns.to_numpy(dtype=float), "linear"),
        style.cell_edges(field.index.to_numpy(dtype=float), "linear"),
        np.ma.masked_invalid(field.to_numpy(dtype=float)),
        cmap="YlGnBu",
        vmin=0,
        vmax=max(highest, 1e-6),
        rasterized=True,
    )
    oil = best["oil"].iloc[0]
    panel.keep("cell", best[_SPEED], best[y], value=best["reduction"], oil=oil)
    ring: style.Look = {"marker": "o", "markersize": 2.2, "markerfacecolor": "none"}
    panel.dots("measured", runs[_SPEED], runs[y], ring | {"color": style.GREY}, oil=oil)
    chosen = tests[tests["test_order"] > 0].sort_values("test_order")
    look: style.Look = {"ha": "center", "va": "center", "fontsize": 6, "weight": "bold"}
    look["bbox"] = {"boxstyle": "round,pad=0.15", "facecolor": "white", "linewidth": 0.5}
    for (speed, level), same in chosen.groupby([_SPEED, y]):
        # many side by side would cover their neighbours
        numbers = (", " if len(same) < 3 else "\n").join(same["test_order"].astype(str))
        panel.axis.annotate(numbers, (speed, level), **look)
    panel.keep("chosen", chosen[_SPEED], chosen[y], value=chosen["test_order"], oil=oil)
    panel.axis.grid(False)
    return mesh
