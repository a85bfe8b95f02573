"""The study of the lost signs of the printed exponents."""

import pandas as pd

from oilfilm import tables
from oilfilm.report.figures import style
from oilfilm.report.figures.registry import register
from oilfilm.report.figures.sheet import Panel, Sheet, sentences
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables


@register(
    category="Claims",
    family="bearing",
    tables=("signs", "sign_verdicts"),
    settings=("oils",),
    shows_data=False,
)
def signs(results: CampaignTables, settings: Settings) -> Sheet:
    """Signs of the printed exponents.

    Score of all 512 sets of signs of the printed exponents, one column of panels per oil. The score
    counts statements of the paper that hold; no data are drawn. Top: total score by rank; dots:
    near-best sets; ring: set in use. Bottom: margin of each sign with every statement (bars) and
    without the one that counts most (ticks), with its verdict.
    """
    oils = [oil for oil in settings.oils if (results.signs["oil"] == oil).any()]
    if not oils:
        return sentences("No oil of this campaign has printed constants.")
    layout: style.Look = {"height": (1.0, 1.3), "left": 0.7, "down": 0.62}
    layout |= {"sharex": "row", "sharey": "row", "width": style.DOUBLE_COLUMN_IN}
    sheet = Sheet(2 * len(oils), len(oils), **layout)
    for column, oil in enumerate(oils):
        sets = results.signs[results.signs["oil"] == oil]
        verdicts = results.sign_verdicts[results.sign_verdicts["oil"] == oil]
        colour = style.oil_colour(oil, list(settings.oils))
        _draw_totals(sheet.panel(column, oil), sets, oil, colour)
        _draw_margins(sheet.panel(column + len(oils)), verdicts, oil, colour)
    totals, margins = sheet.axes[:: len(oils)]
    totals.set_ylabel("Statements\nthat hold", fontsize=7)
    for axis, label in ((totals, "Rank of the sign set"), (margins, "Margin (statements)")):
        axis.set_xlabel(label, fontsize=7, loc="left")
    for axis in sheet.axes:
        axis.tick_params(labelbottom=True)
    # room for the verdicts right of the bars
    low, high = margins.get_xlim()
    margins.set_xlim(low, high + 0.75 * (high - low))
    black: style.Look = {"color": "black"}
    sheet.legend(
        [
            style.symbol_handle("near-best set", "o", **black),
            style.symbol_handle("set in use", "o", markersize=6, markerfacecolor="none", **black),
            style.symbol_handle("weakest margin", "|", **black),
        ]
    )
    return sheet


def _draw_totals(panel: Panel, sets: pd.DataFrame, oil: str, colour: str) -> None:
    """Total against rank; near-best sets as dots, the set in use ringed."""
    ranks = pd.Series(range(1, len(sets) + 1), index=sets.index)
    near, used = sets["near_best"], sets["in_use"]
    panel.axis.semilogx(ranks, sets["total"], color=style.GREY, linewidth=0.8)
    panel.axis.semilogx(ranks[near], sets["total"][near], "o", color=colour)
    ring: style.Look = {"markersize": 6, "markerfacecolor": "none", "color": "black"}
    panel.axis.semilogx(ranks[used], sets["total"][used], "o", **ring)
    panel.axis.xaxis.set_major_formatter("{x:g}")
    series = used.map({True: "set in use", False: "all sets"})
    panel.keep(series, ranks, sets["total"], label=sets["signs"], oil=oil)


def _draw_margins(panel: Panel, verdicts: pd.DataFrame, oil: str, colour: str) -> None:
    """Bars of the margin, its weakest value as a tick, the sign and the verdict in words."""
    axis, heights = panel.axis, range(len(verdicts))
    sure = verdicts["verdict"].map({"settled": 1.0, "probable": 0.55}).fillna(0.15)
    bars: style.Look = {"edgecolor": colour, "linewidth": 0.6, "height": 0.72}
    axis.barh(heights, verdicts["margin"], color=[style.tint(colour, s) for s in sure], **bars)
    axis.plot(verdicts["weakest_margin"], heights, "|", color="black", markersize=6)
    axis.axvline(0, color="black", linewidth=0.6)
    look: style.Look = {"ha": "right", "va": "center", "fontsize": 6.5}
    look["transform"] = axis.get_yaxis_transform()
    for height, row in enumerate(tables.rows(verdicts)):
        sign = row["sign"].replace("-", "\N{MINUS SIGN}")
        axis.text(1.0, height, f"{sign} {row['verdict']}", **look)
    axis.set_yticks(heights, verdicts["constant"])
    axis.set_ylim(len(verdicts) - 0.5, -0.5)
    label = verdicts["constant"] + " " + verdicts["sign"]
    ends = {"lower": verdicts["weakest_margin"], "oil": oil}
    panel.keep(verdicts["verdict"], verdicts["margin"], heights, label=label, **ends)
