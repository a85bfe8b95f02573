"""Tables of figures: exactly what each draws."""

import numpy as np
from pandera.typing.pandas import Series

from oilfilm.tables.fields import Table, count, flag, number, text
from oilfilm.units import ABSOLUTE_ZERO_C


class CoefficientTable(Table):
    """The constants beside the printed ones, as drawn (Eqs 11-13)."""

    oil: Series[str] = text("oil")
    constant: Series[str] = text("constant")
    value: Series[float] = number("fitted value", gaps=True)
    standard_error: Series[float] = number("standard error", at_least=0, gaps=True)
    printed_value: Series[float] = number("printed value", gaps=True)


class Schematic(Table):
    """Exactly what the schematic drawing of a rig draws: a row a mark, later ones above."""

    panel: Series[str] = text("panel letter")
    mark: Series[str] = text(
        "box: from corner to corner; circle: to_x is its radius; words: joined to their end by a "
        "line",
        one_of=("box", "circle", "line", "film", "arrow", "turn", "words"),
    )
    kind: Series[str] = text("what it is made of, or does: its colour; else empty")
    x: Series[float] = number("start, in units of the drawing")
    y: Series[float] = number("start")
    to_x: Series[float] = number("end")
    to_y: Series[float] = number("end")
    words: Series[str] = text("what is written")


class StatedValues(Table):
    """The tables of oils, test matrix and bearing, as drawn: a row a cell (Tables 1-3)."""

    thing: Series[str] = text("column of the table: what has the value, or the paper's text")
    quantity: Series[str] = text("row of the table")
    unit: Series[str] = text("unit of the value; empty where it has none")
    words: Series[str] = text("what stands in the cell; * marks what is assumed")
    value: Series[float] = number("the value, null where words alone are known", gaps=True)
    source: Series[str] = text("where it is from")


class Curves(Table):
    """Exactly what a figure of mu against slip draws."""

    panel: Series[str] = text("panel letter")
    series: Series[str] = text("legend entry")
    kind: Series[str] = text("measured: points; fit: line", one_of=("measured", "fit"))
    oil: Series[str] = text("oil")
    slide_roll_ratio: Series[float] = number("abscissa")
    traction_coefficient: Series[float] = number("ordinate")
    traction_coefficient_se: Series[float] = number(
        "standard error; the bar drawn is 1.96 times as long to either side, none where null",
        gaps=True,
    )


class CoverageMap(Table):
    """Exactly what the coverage map draws: a row a cell, all rigs together."""

    panel: Series[str] = text("number of the panel, in reading order")
    oil: Series[str] = text("oil")
    nominal_inlet_temperature_c: Series[float] = number(
        "set point of the panel", at_least=ABSOLUTE_ZERO_C, gaps=True
    )
    nominal_entrainment_speed_m_s: Series[float] = number("abscissa", at_least=0, gaps=True)
    nominal_max_hertz_pressure_gpa: Series[float] = number("ordinate", at_least=0, gaps=True)
    nominal_load_n: Series[float] = number("ordinate without pressure", at_least=0, gaps=True)
    runs_accepted: Series[np.int64] = count("first number of the cell")
    runs: Series[np.int64] = count("second number of the cell: all runs")
    state: Series[str] = text(
        "symbol and colour of the cell", one_of=("accepted", "refused", "missing")
    )
    planned: Series[bool] = flag("false: drawn with a broken edge, if there is a matrix")


class LawPanels(Table):
    """Exactly what the figure of the laws' weaknesses draws (Fig. 4)."""

    panel: Series[str] = text("panel letter")
    law: Series[str] = text("traction law")
    oil: Series[str] = text("oil")
    kind: Series[str] = text(
        "zero slip: mu at no slip at a tested condition; the others: error of a law over mu",
        one_of=("zero slip", "fitted curves", "curve left out", "end level left out"),
    )
    x: Series[float] = number("abscissa", gaps=True)
    y: Series[float] = number("ordinate; of errors the place of the row")


class ModelCurves(Table):
    """Exactly what a figure of the law's curves draws (Figs 7-10): a row a vertex of a line."""

    panel: Series[str] = text("panel letter")
    oil: Series[str] = text("oil, colour of the line")
    series: Series[str] = text(
        "refit: full line in its interval; printed: thin dashed line", one_of=("refit", "printed")
    )
    max_hertz_pressure_gpa: Series[float] = number("maximum Hertz pressure", at_least=0)
    entrainment_speed_m_s: Series[float] = number("entrainment speed", at_least=0)
    inlet_temperature_c: Series[float] = number("inlet temperature", at_least=ABSOLUTE_ZERO_C)
    slide_roll_ratio: Series[float] = number("slide-roll ratio", at_least=0)
    traction_coefficient: Series[float] = number("ordinate")
    lower: Series[float] = number("lower edge of the band, none where null", gaps=True)
    upper: Series[float] = number("upper edge", gaps=True)
    extrapolated: Series[bool] = flag(
        "outside what the oil was tested at; shaded where it is so for any curve of the panel"
    )


class ResidualsDrawn(Table):
    """Exactly what the figure of residuals draws: a row a point or mean."""

    panel: Series[str] = text("panel letter")
    oil: Series[str] = text("oil")
    condition: Series[str] = text("column of points along the abscissa")
    kind: Series[str] = text("a plateau, or the mean of a level", one_of=("point", "mean"))
    x: Series[float] = number("abscissa", gaps=True)
    y: Series[float] = number("ordinate: measured minus fitted mu, in thousandths")
    spread: Series[float] = number("bar to either side of a mean", at_least=0, gaps=True)


class Identifiability(Table):
    """Exactly what the figure of identifiability draws: a row a square or vertex."""

    panel: Series[str] = text("panel letter")
    oil: Series[str] = text("oil")
    kind: Series[str] = text("square or vertex of a line", one_of=("correlation", "profile"))
    constant: Series[str] = text("constant")
    other: Series[str] = text("the other one of a pair; else empty")
    x: Series[float] = number("abscissa of a profile: distance in standard errors", gaps=True)
    value: Series[float] = number("colour of a square, ordinate of a profile", gaps=True)


class ExtrapolationPanels(Table):
    """Exactly what the figure of the extrapolation draws."""

    panel: Series[str] = text("panel letter")
    kind: Series[str] = text(
        "what the ordinate is: true mu, fitted mu, or a law's relative rms error",
        one_of=("true", "fit", "error"),
    )
    law: Series[str] = text("traction law; empty for the truth")
    oil: Series[str] = text("oil")
    x: Series[float] = number(
        "abscissa, in the unit of its panel: S; U in m/s; P in GPa; T in degC; relative rms error "
        "in the tested box",
        gaps=True,
    )
    y: Series[float] = number("ordinate: mu, or relative rms error beyond the box", gaps=True)


class SignStudy(Table):
    """Exactly what the figure of the sign study draws."""

    panel: Series[str] = text("panel letter")
    oil: Series[str] = text("oil")
    series: Series[str] = text("all sets, set in use, best set, or margin and its verdict")
    label: Series[str] = text("signs, statement or exponent with its sign")
    rank: Series[float] = number("abscissa of the totals", gaps=True)
    value: Series[float] = number("total, share or margin")
    weakest_margin: Series[float] = number("tick on the bar of a margin", gaps=True)


class ClaimsPage(Table):
    """Exactly what the page of claims draws: two lines a claim, one a basis."""

    claim: Series[str] = text("id of the claim")
    statement: Series[str] = text("what the claim comes to")
    basis: Series[str] = text("first line refit, second printed", one_of=("refit", "printed"))
    verdict: Series[str] = text("colour and symbol")
    share: Series[float] = number("length of the bar", at_least=0, at_most=1, gaps=True)
    share_tested_box: Series[float] = number("place of the tick", gaps=True)
    words: Series[str] = text("to the right of the bar")


class SelectionMap(Table):
    """Exactly what the map of oils draws: a row a cell."""

    panel: Series[str] = text("panel letter")
    basis: Series[str] = text("basis drawn", one_of=("refit", "printed"))
    inlet_temperature_c: Series[float] = number("of the panel")
    slide_roll_ratio: Series[float] = number("of the panel")
    entrainment_speed_m_s: Series[float] = number("abscissa", at_least=0)
    max_hertz_pressure_gpa: Series[float] = number("ordinate", at_least=0)
    advised_oil: Series[str] = text("colour of the cell; white where empty")
    best_oil: Series[str] = text("symbol, drawn where the judgement is not agree")
    judgement: Series[str] = text("as in the table of selection")


class TorqueDrawn(Table):
    """Exactly what a figure of torque against speed draws."""

    panel: Series[str] = text("panel letter")
    series: Series[str] = text("measured, or the basis of the law")
    oil: Series[str] = text("oil")
    axial_load_n: Series[float] = number("set of points: mean axial load")
    inner_speed_rpm: Series[float] = number("abscissa")
    torque_n_m: Series[float] = number("ordinate of the panels of torque", gaps=True)
    torque_n_m_se: Series[float] = number(
        "standard error; the bar drawn is 1.96 times as long to either side", gaps=True
    )
    relative_error: Series[float] = number("ordinate of the panels of error", gaps=True)


class CageSlipMap(Table):
    """Exactly what the map of cage slip draws: a row a cell."""

    panel: Series[str] = text("panel letter")
    oil: Series[str] = text("oil of the panel; empty in the last one, which shows the advice")
    pitch_speed_mm_rpm: Series[float] = number("abscissa")
    axial_load_n: Series[float] = number("ordinate")
    cage_slip: Series[float] = number("colour of the cell, and the line at the limit", gaps=True)
    advised_oil: Series[str] = text("colour of the cell of the last panel")
    best_oil: Series[str] = text("its symbol, drawn where the judgement is not agree")
    judgement: Series[str] = text("as in the table of slip advice")


TABLES: dict[str, type[Table]] = {
    "coefficient_table": CoefficientTable,
    "schematic": Schematic,
    "stated_values": StatedValues,
    "curves": Curves,
    "coverage_map": CoverageMap,
    "law_panels": LawPanels,
    "model_curves": ModelCurves,
    "residuals_drawn": ResidualsDrawn,
    "identifiability": Identifiability,
    "extrapolation_panels": ExtrapolationPanels,
    "sign_study": SignStudy,
    "claims_page": ClaimsPage,
    "selection_map": SelectionMap,
    "torque_drawn": TorqueDrawn,
    "cage_slip_map": CageSlipMap,
}
