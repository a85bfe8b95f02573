"""The study of the lost signs: every sign set's total, the statements, and each sign's margin."""

from typing import Any

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from oilfilm.report.figures import style
from oilfilm.report.figures.registry import Drawing, marks, register
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables

_HEIGHTS_IN = (1.4, 2.7, 1.75)
_GREY = "#777777"
_MINUS = "\N{MINUS SIGN}"
_ALL, _IN_USE, _BEST = "all sets", "set in use", "best set"
# Columns of the table of signs that are no statement.
_NO_STATEMENT = ("oil", "signs", "in_use", "rank", "rank_at_figures", "total", "near_best", "sse")


@register(
    name="signs",
    title="Signs of the printed exponents",
    caption="Score of all 512 sets of signs of the printed exponents, one column of panels "
    "per oil. The score counts statements of the paper that hold. Top: total score by rank. "
    "Middle: statements that hold for the set in use. Bottom: margin of each sign.",
    category="Claims",
    family="bearing",
    tables=("signs", "sign_verdicts"),
    settings=("oils",),
    shows_data=False,
)
def sign_study(results: CampaignTables, settings: Settings) -> Drawing:
    """One column per oil: totals by rank, statements of the set in use, margin of each sign."""
    oils = [oil for oil in settings.oils if (results.signs["oil"] == oil).any()]
    if not oils:
        return style.sentences("No oil of this campaign has printed constants."), []
    figure = Figure(figsize=(style.DOUBLE_COLUMN_IN, sum(_HEIGHTS_IN)))
    axes = figure.subplots(
        3, len(oils), sharex="row", sharey="row", squeeze=False, height_ratios=_HEIGHTS_IN
    )
    drawn = []
    for column, oil in enumerate(oils):
        sets = results.signs[results.signs["oil"] == oil]
        verdicts = results.sign_verdicts[results.sign_verdicts["oil"] == oil]
        colour = style.oil_colour(oil, list(settings.oils))
        for row, (draw, of_oil) in enumerate(
            ((_draw_totals, sets), (_draw_statements, sets), (_draw_margins, verdicts))
        ):
            number, title = row * len(oils) + column, oil if row == 0 else ""
            panel = style.title_panel(axes[row, column], number, title)
            drawn.append(draw(axes[row, column], panel, of_oil, colour).assign(oil=oil))
    _label(axes[:, 0], axes[-1])
    style.say_key(
        figure,
        "Printed constants against the paper's text; no data are drawn.\n"
        "Top: dots near-best sets, ring set in use. Bottom: bars with every\n"
        "statement, ticks without the one that counts most.",
    )
    return figure, drawn


def _draw_totals(axis: Axes, panel: str, sets: pd.DataFrame, colour: str) -> pd.DataFrame:
    """Total against rank; near-best sets as dots, the set in use ringed and told in words."""
    ranks = pd.Series(range(1, len(sets) + 1), index=sets.index)
    near, used = sets["near_best"], sets["in_use"]
    axis.semilogx(ranks, sets["total"], color=_GREY, linewidth=0.8)
    axis.semilogx(ranks[near], sets["total"][near], "o", color=colour)
    axis.semilogx(
        ranks[used], sets["total"][used], "o", color="black", markersize=6, markerfacecolor="none"
    )
    axis.xaxis.set_major_formatter("{x:g}")
    behind = float(sets["total"][used].max() - sets["total"][~used].max())
    text = (
        f"in use: rank {sets['rank'][used].iloc[0]} of {len(sets)}\n"
        f"(at figs 8, 9: {sets['rank_at_figures'][used].iloc[0]}),\n"
        f"{abs(behind):.2g} {'ahead of the next' if behind > 0 else 'behind the best'};\n"
        f"near-best sets: {near.sum()}"
    )
    axis.text(0.03, 0.06, text, va="bottom", fontsize=6.5, transform=axis.transAxes)
    series = used.map({True: _IN_USE, False: _ALL})
    return marks(panel, series, ranks, sets["total"], label=sets["signs"])


def _draw_statements(axis: Axes, panel: str, sets: pd.DataFrame, colour: str) -> pd.DataFrame:
    """Share of its box where each statement holds, for the set in use and for the best one."""
    names = [name for name in sets.columns if name not in _NO_STATEMENT]
    in_use: dict[str, Any] = {"marker": "o", "color": colour, "markersize": 3}
    best: dict[str, Any] = {"marker": "|", "color": "black", "markersize": 7}
    rows = []
    for series, of_series, look in (
        (_IN_USE, sets[sets["in_use"]], in_use),
        (_BEST, sets, best),
    ):
        shares = of_series[names].iloc[0].astype(float).to_numpy()
        axis.plot(shares, range(len(names)), linestyle="", clip_on=False, label=series, **look)
        rows.append(marks(panel, series, shares, range(len(names)), label=names))
    axis.set_yticks(range(len(names)), [name.replace("_", " ") for name in names], fontsize=6.5)
    axis.set_ylim(len(names) - 0.5, -0.5)
    axis.set_xlim(-0.03, 1.03)
    return pd.concat(rows).dropna(subset="x")


def _draw_margins(axis: Axes, panel: str, verdicts: pd.DataFrame, colour: str) -> pd.DataFrame:
    """Bars of the margin, its weakest value as a tick, the sign and the verdict in words."""
    heights = range(len(verdicts))
    sure = verdicts["verdict"].map({"settled": 1.0, "probable": 0.55}).fillna(0.15)
    axis.set_axisbelow(True)
    axis.barh(
        heights,
        verdicts["margin"],
        color=[style.tint(colour, share) for share in sure],
        edgecolor=colour,
        linewidth=0.6,
        height=0.72,
    )
    axis.plot(verdicts["weakest_margin"], heights, "|", color="black", markersize=6)
    axis.axvline(0, color="black", linewidth=0.6)
    signs = verdicts["sign"].str.replace("-", _MINUS)
    look: dict[str, Any] = {"ha": "right", "va": "center", "fontsize": 6.5}
    for height, label in zip(heights, signs + " " + verdicts["verdict"], strict=True):
        axis.text(1.0, height, label, transform=axis.get_yaxis_transform(), **look)
    axis.set_yticks(heights, verdicts["constant"])
    axis.set_ylim(len(verdicts) - 0.5, -0.5)
    label = verdicts["constant"] + " " + verdicts["sign"]
    weakest = verdicts["weakest_margin"]
    return marks(
        panel, verdicts["verdict"], verdicts["margin"], heights, label=label, lower=weakest
    )


def _label(left: Any, last_row: Any) -> None:
    left[0].set_ylabel("Statements\nthat hold", fontsize=7)
    left[0].set_xlabel("Rank of the sign set", fontsize=7, loc="left")
    left[1].set_xlabel("Share of the box where it holds", fontsize=7, loc="left")
    left[1].legend(loc="lower left", fontsize=6.5, handletextpad=0.2)
    left[2].set_xlabel("Margin of the sign in use (statements)", fontsize=7, loc="left")
    # room for the verdicts right of the bars
    low, high = last_row[0].get_xlim()
    last_row[0].set_xlim(low, high + 0.75 * (high - low))
