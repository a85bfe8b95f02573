"""The claims of the paper, with the share where each holds, and the study of its lost signs."""

import textwrap
from typing import Any

import pandas as pd
from matplotlib.patches import Rectangle

from oilfilm import tables
from oilfilm.paper.reference import Claims
from oilfilm.paper.sections import BASES, share_text
from oilfilm.report.figures import style
from oilfilm.report.figures.registry import register
from oilfilm.report.figures.sheet import Panel, Sheet, page, sentences
from oilfilm.report.words import printed
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables

_ROW_IN = 0.33
_BAR, _BAR_WIDTH = 0.68, 0.2  # of the page's width
_LETTERS = 36
_ALL, _IN_USE, _BEST = "all sets", "set in use", "best set"
# Columns of the table of signs that are no statement.
_NO_STATEMENT = ("oil", "signs", "in_use", "rank", "rank_at_figures", "total", "near_best", "sse")


@register(category="Claims", family="bearing", tables=("claims",), references=("claims",))
def claims(results: CampaignTables, settings: Settings, claims: Claims) -> Sheet:
    """Claims of the paper.

    Verdict on each claim of the paper, and share of the conditions where it holds. Upper bar of
    each claim: fits and points of this campaign. Lower bar: constants printed in the paper. The
    section on claims has the worst case of each, or why it cannot be checked.
    """
    drawn = results.claims
    if drawn.empty:
        return sentences("The paper tested none of these oils:\nno claims.")
    said = {claim.id: printed(claim.claim) for claim in claims.claims}
    judged = list(dict.fromkeys(drawn["claim"]))
    height_in, bottom = _ROW_IN * (len(judged) + 0.8), len(judged) + 0.1
    sheet, panel = page(style.SINGLE_COLUMN_IN, height_in, bottom=bottom, top=-0.7)
    heads: style.Look = {"va": "center", "fontsize": 7, "color": style.GREY}
    panel.axis.text(0.0, -0.35, "claim of the paper", **heads)
    panel.axis.text(_BAR - 0.04, -0.35, "holds in ... of cases", **heads)
    look: style.Look = {"va": "center", "linespacing": 1.1, "parse_math": False, "fontsize": 6.5}
    for row, claim in enumerate(judged):
        panel.axis.axhline(row, color="#dddddd", linewidth=0.5)
        statement = textwrap.fill(said[claim], _LETTERS, break_on_hyphens=False)
        panel.axis.text(0, row + 0.5, statement, **look)
        of_claim = drawn[drawn["claim"] == claim].set_index("basis")
        for line, basis in enumerate(BASES):
            if basis in of_claim.index:  # a claim on speeds alone needs no fit
                _draw_bar(panel, row + 0.28 + 0.46 * line, of_claim.loc[basis])
    handles = [
        style.symbol_handle(verdict, marker, color=colour, markersize=4)
        for verdict, (colour, marker) in style.VERDICTS.items()
    ]
    tick = style.symbol_handle("tested box", "|", color="black", markersize=6)
    sheet.legend([*handles, tick])
    about = {"label": drawn["verdict"], "value": drawn["share_tested_box"]}
    panel.keep(drawn["claim"] + ", " + drawn["basis"], drawn["share"], **about)
    return sheet


def _draw_bar(panel: Panel, y: float, line: "pd.Series[Any]") -> None:
    colour, marker = style.VERDICTS[line["verdict"]]
    panel.axis.plot(_BAR - 0.03, y, marker, color=colour, markersize=4)
    if not pd.isna(line["share"]):
        frame: style.Look = {"height": 0.26, "linewidth": 0.4}
        corner, width = (_BAR, y - 0.13), _BAR_WIDTH * line["share"]
        outline = Rectangle(corner, _BAR_WIDTH, facecolor="white", edgecolor="#999999", **frame)
        panel.axis.add_patch(outline)
        panel.axis.add_patch(Rectangle(corner, width, facecolor=colour, **frame))
        share = share_text(line["share"])
        panel.axis.text(_BAR + _BAR_WIDTH + 0.015, y, share, va="center", fontsize=6)
    if not pd.isna(line["share_tested_box"]):
        at = _BAR + _BAR_WIDTH * line["share_tested_box"]
        panel.axis.plot([at, at], [y - 0.2, y + 0.2], color="black", linewidth=1.2)


@register(
    category="Claims",
    family="bearing",
    tables=("signs", "sign_verdicts"),
    settings=("oils",),
    shows_data=False,
)
def signs(results: CampaignTables, settings: Settings) -> Sheet:
    """Signs of the printed exponents.

    Score of all 512 sets of signs of the printed exponents, one column of panels per oil. The
    score counts statements of the paper that hold; no data are drawn. Top: total score by rank;
    dots: near-best sets; ring: set in use. Middle: statements that hold for the set in use.
    Bottom: margin of each sign with every statement (bars) and without the one that counts most
    (ticks), with its verdict.
    """
    oils = [oil for oil in settings.oils if (results.signs["oil"] == oil).any()]
    if not oils:
        return sentences("No oil of this campaign has printed constants.")
    layout: style.Look = {"height": (1.0, 2.3, 1.3), "left": 1.75, "down": 0.62}
    layout |= {"sharex": "row", "sharey": "row", "width": style.DOUBLE_COLUMN_IN}
    sheet = Sheet(3 * len(oils), len(oils), **layout)
    for column, oil in enumerate(oils):
        sets = results.signs[results.signs["oil"] == oil]
        verdicts = results.sign_verdicts[results.sign_verdicts["oil"] == oil]
        colour = style.oil_colour(oil, list(settings.oils))
        totals, statements, margins = (column + row * len(oils) for row in range(3))
        _draw_totals(sheet.panel(totals, oil), sets, oil, colour)
        _draw_statements(sheet.panel(statements), sets, oil, colour)
        _draw_margins(sheet.panel(margins), verdicts, oil, colour)
    left = sheet.axes[:: len(oils)]
    left[0].set_ylabel("Statements\nthat hold", fontsize=7)
    look: style.Look = {"fontsize": 7, "loc": "left"}
    for axis, label in zip(
        left,
        ("Rank of the sign set", "Share of the box where it holds", "Margin (statements)"),
        strict=True,
    ):
        axis.set_xlabel(label, **look)
    for axis in sheet.axes:
        axis.tick_params(labelbottom=True)
    # room for the verdicts right of the bars
    low, high = left[2].get_xlim()
    left[2].set_xlim(low, high + 0.75 * (high - low))
    black: style.Look = {"color": "black"}
    sheet.legend(
        [
            style.symbol_handle("near-best set, statement of the set in use", "o", **black),
            style.symbol_handle(_IN_USE, "o", markersize=6, markerfacecolor="none", **black),
            style.symbol_handle("statement of the best set, weakest margin", "|", **black),
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
    series = used.map({True: _IN_USE, False: _ALL})
    panel.keep(series, ranks, sets["total"], label=sets["signs"], oil=oil)


def _draw_statements(panel: Panel, sets: pd.DataFrame, oil: str, colour: str) -> None:
    """Share of its box where each statement holds, for the set in use and for the best one."""
    names = [name for name in sets.columns if name not in _NO_STATEMENT]
    in_use: style.Look = {"marker": "o", "color": colour, "markersize": 3}
    best: style.Look = {"marker": "|", "color": "black", "markersize": 7}
    for series, of_series, look in (
        (_IN_USE, sets[sets["in_use"]], in_use),
        (_BEST, sets, best),
    ):
        shares = of_series[names].iloc[0].astype(float).dropna()
        heights = [names.index(name) for name in shares.index]
        look |= {"clip_on": False}
        panel.dots(series, shares.to_numpy(), heights, look, label=list(shares.index), oil=oil)
    panel.axis.set_yticks(range(len(names)), [n.replace("_", " ") for n in names], fontsize=6.5)
    panel.axis.set_ylim(len(names) - 0.5, -0.5)
    panel.axis.set_xlim(-0.03, 1.03)


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
