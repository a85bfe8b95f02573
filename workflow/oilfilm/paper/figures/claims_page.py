"""The page of claims: what the paper says, and in how much of the domain it holds."""

import textwrap
from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.patches import Rectangle

from oilfilm import tables
from oilfilm.paper.audit.reasons import REASONS
from oilfilm.paper.reference import Claim, Claims
from oilfilm.paper.sections import BASES, share_text, worst_case
from oilfilm.report.figures import style
from oilfilm.report.figures.registry import Drawing, marks, register
from oilfilm.report.words import printed
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables

_ROW_IN = 0.40
_BAR, _BAR_WIDTH = 0.40, 0.13  # of the page's width
_TEXT = 0.62
_STATEMENT_LETTERS, _TEXT_LETTERS = 35, 62


@register(
    name="claims",
    title="Claims of the paper",
    caption="Verdict on each claim of the paper, share of the conditions where it holds, and "
    "worst case. Upper bar of each claim: fits and points of this campaign. Lower bar: constants "
    "printed in the paper.",
    category="Claims",
    family="bearing",
    tables=("claims",),
    references=("claims",),
)
def claims_page(results: CampaignTables, settings: Settings, claims: Claims) -> Drawing:
    """Each claim with one bar per basis: share of cases where it holds, and worst case."""
    if results.claims.empty:
        return style.sentences("The paper tested none of these oils:\nno claims."), []
    said = {claim.id: claim for claim in claims.claims}
    words = [_worst_case(row, said[row["claim"]]) for row in tables.rows(results.claims)]
    drawn = results.claims.assign(words=words)
    judged = list(dict.fromkeys(drawn["claim"]))
    height_in, bottom = _ROW_IN * (len(judged) + 1.2), len(judged) + 0.1
    figure, axis = style.page(style.DOUBLE_COLUMN_IN, height_in, bottom=bottom, top=-0.7)
    for x, head in (
        (0.0, "claim of the paper"),
        (_BAR, "holds in ... of cases"),
        (_TEXT, "worst case, or why it cannot be checked"),
    ):
        axis.text(x, -0.35, head, va="center", fontsize=7, color=style.GREY)
    for row, claim in enumerate(judged):
        of_claim = drawn[drawn["claim"] == claim].set_index("basis")
        axis.axhline(row, color="#dddddd", linewidth=0.5)
        statement = textwrap.fill(
            printed(said[claim].claim), _STATEMENT_LETTERS, break_on_hyphens=False
        )
        look: dict[str, Any] = {"va": "center", "linespacing": 1.1, "parse_math": False}
        axis.text(0, row + 0.5, statement, fontsize=7, **look)
        for line, (basis, name) in enumerate(BASES.items()):
            if basis not in of_claim.index:
                continue  # a claim on speeds alone, which needs no fit
            _draw_line(axis, row + 0.28 + 0.46 * line, name, of_claim.loc[basis])
    handles = [
        style.symbol_handle(verdict, style.VERDICT_MARKERS[verdict], color=colour, markersize=4)
        for verdict, colour in style.VERDICT_COLOURS.items()
    ]
    tick = style.symbol_handle("in the box that the paper tested", "|", color="black", markersize=6)
    figure.legend(handles=[*handles, tick], loc="outside lower left", ncols=3)
    about = {"label": drawn["verdict"] + ": " + drawn["words"], "value": drawn["share_tested_box"]}
    return figure, [marks("", drawn["claim"] + ", " + drawn["basis"], drawn["share"], **about)]


def _draw_line(axis: Axes, y: float, basis: str, line: "pd.Series[Any]") -> None:
    colour = style.VERDICT_COLOURS[line["verdict"]]
    axis.text(_BAR - 0.025, y, basis, ha="right", va="center", fontsize=6, color=style.GREY)
    axis.plot(_BAR - 0.012, y, style.VERDICT_MARKERS[line["verdict"]], color=colour, markersize=4)
    if not np.isnan(line["share"]):
        frame: dict[str, Any] = {"height": 0.26, "linewidth": 0.4}
        corner, width = (_BAR, y - 0.13), _BAR_WIDTH * line["share"]
        outline = Rectangle(corner, _BAR_WIDTH, facecolor="white", edgecolor="#999999", **frame)
        axis.add_patch(outline)
        axis.add_patch(Rectangle(corner, width, facecolor=colour, **frame))
        axis.text(_BAR + _BAR_WIDTH + 0.008, y, share_text(line["share"]), va="center", fontsize=6)
    if not np.isnan(line["share_tested_box"]):
        at = _BAR + _BAR_WIDTH * line["share_tested_box"]
        axis.plot([at, at], [y - 0.2, y + 0.2], color="black", linewidth=1.2)
    # two lines have room; the report and the table have the rest
    text = "\n".join(
        textwrap.wrap(printed(line["words"]), _TEXT_LETTERS, max_lines=2, placeholder=" ...")
    )
    axis.text(_TEXT, y, text, va="center", fontsize=5.5, linespacing=1.0, parse_math=False)


def _worst_case(row: Mapping[str, Any], claim: Claim) -> str:
    if row["reason_code"]:
        return REASONS[row["reason_code"]]
    if row["verdict"] == "by construction":
        return "the equation makes it so for any constants"
    return "" if row["share"] == 1 else worst_case(row, claim)
