"""Tables 1-3 and Eqs 11-13 of the paper, as configured and fitted, each number with its source."""

import textwrap
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from oilfilm.curation.coverage import with_levels
from oilfilm.paper.printed_law import with_printed
from oilfilm.paper.reference import PaperStatement, PaperTables, PrintedCoefficients
from oilfilm.report.figures import style
from oilfilm.report.figures.fits import draw_constants
from oilfilm.report.figures.registry import register
from oilfilm.report.figures.sheet import Sheet, table_page
from oilfilm.settings.base import present
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables

_PAPER = "in the paper's text"
_NONE = "\N{EN DASH}"
_LINE_IN = 0.125
_ROW_IN = 0.06  # between rows, beside their lines
_AT_C = 100.0  # of the oils' properties, as in the paper
# Quantity, unit and its value for an oil.
_OF_OIL: tuple[tuple[str, str, Any], ...] = (
    ("grade", "cSt", lambda oil: oil.nominal_kinematic_viscosity_100c_cst),
    ("kinematic viscosity", "cSt", lambda oil: 1e6 * oil.kinematic_viscosity_m2_s(_AT_C)),
    ("dynamic viscosity", "mPa s", lambda oil: 1e3 * oil.dynamic_viscosity_pa_s(_AT_C)),
    ("density", "kg/m\N{SUPERSCRIPT THREE}", lambda oil: oil.density_kg_m3(_AT_C)),
    (
        "pressure-viscosity coefficient",
        "1/GPa",
        lambda oil: 1e9 * oil.pressure_viscosity_coefficient_1_pa(_AT_C),
    ),
    ("thermal conductivity", "W/(m K)", lambda oil: oil.thermal_conductivity_w_mk(_AT_C)),
    ("specific heat", "J/(kg K)", lambda oil: oil.specific_heat_j_kgk(_AT_C)),
)
_MATRIX = {
    "max_hertz_pressure_gpa": ("maximum Hertz pressure", "GPa"),
    "entrainment_speed_m_s": ("entrainment speed", "m/s"),
    "inlet_temperature_c": ("inlet temperature", "\N{DEGREE SIGN}C"),
}


@register(
    paper="Table 1",
    family="data",
    settings=("oils",),
    references=("paper_tables",),
    shows_data=False,
)
def tab01(results: CampaignTables, settings: Settings, paper_tables: PaperTables) -> Sheet:
    """Properties of the oils.

    Density, viscosity, pressure-viscosity coefficient, thermal conductivity and specific heat
    at 100 \N{DEGREE SIGN}C and 1 bar, with their sources. The values of the paper are lost.
    Properties that stand in for unknown ones are marked.
    """
    rows, notes = [], []
    for name in settings.oils:
        oil = settings.properties_of(name)
        source = "no known properties"
        if oil is not None:
            source = f"stand-in: {oil.source}" if oil.stand_in else oil.source
        notes.append(f"{name}: {source}")
        rows += [
            _row(name, quantity, unit, np.nan if oil is None else float(of_oil(oil)), source)
            for quantity, unit, of_oil in _OF_OIL
        ]
    title = f"Properties at {_AT_C:g} \N{DEGREE SIGN}C and 1 bar"
    return _table(title, rows, notes, paper_tables.tab01)


@register(
    paper="Table 2",
    family="data",
    tables=("points", "runs"),
    settings=("oils", "rigs", "same_set_point", "campaign.matrix"),
    references=("paper_tables",),
)
def tab02(results: CampaignTables, settings: Settings, paper_tables: PaperTables) -> Sheet:
    """Test matrix.

    Levels of maximum Hertz pressure (GPa), entrainment speed (m/s) and inlet temperature
    (\N{DEGREE SIGN}C); slide-roll ratios of the accepted points; accepted curves. The table of
    the paper is lost; the last column quotes its text.
    """
    matrix, runs = settings.campaign.matrix, with_levels(results.runs, settings)
    logged = "set points of the logs"
    source = "campaign file, matrix" if matrix is not None else logged
    accepted = results.points[results.points["accepted"]]
    rows, about = [], "this campaign"
    for name, (quantity, unit) in _MATRIX.items():
        set_points = sorted(runs[f"nominal_{name}"].dropna().unique())
        levels = _levels(set_points if matrix is None else getattr(matrix, name))
        rows.append(_row(about, quantity, unit, levels, source))
    # of a rig whose contact is not known
    if loads := sorted(runs["nominal_load_n"].dropna().unique()):
        rows.append(_row(about, "load", "N", _levels(loads), logged))
    slips = accepted["slide_roll_ratio"].abs()
    reached = f"{round(slips.min(), 3):g} to {round(slips.max(), 3):g}" if len(slips) else _NONE
    rows.append(_row(about, "slide-roll ratio", "", reached, "accepted points"))
    for oil in settings.oils:
        of_oil = runs.loc[runs["oil"] == oil, "run_id"]
        curves = f"{of_oil.isin(accepted['run_id']).sum()} accepted of {len(of_oil)} runs"
        rows.append(_row(about, f"curves of {oil}", "", curves, "tables runs and points"))
    return _table("Test matrix", rows, [f"Levels: {source}."], paper_tables.tab02)


@register(
    paper="Table 3",
    family="data",
    settings=("bearings", "campaign.torque"),
    references=("paper_tables",),
    shows_data=False,
    requires="torque",
)
def tab03(results: CampaignTables, settings: Settings, paper_tables: PaperTables) -> Sheet:
    """Parameters of the bearing.

    Geometry, materials and cage of the bearing, with their sources. The table of the paper is
    partly lost; the last column quotes its text.
    """
    torque = present(settings.campaign.torque, "torque", "the campaign")
    bearing, rows = settings.bearings[torque.bearing], []
    listed = pd.read_csv(Path(__file__).with_name("tab03.csv"), keep_default_na=False)
    for of, quantity, unit, keys, factor in listed.itertuples(index=False):
        about = torque.bearing, quantity, unit
        if of == "test":
            if torque.matrix is not None:
                levels = _levels([factor * level for level in getattr(torque.matrix, keys)])
                rows.append(_row(*about, levels, "campaign file, `torque`"))
            continue
        value: Any = bearing
        for key in keys.split("."):
            value = getattr(value, key, None)
        if value is not None:  # the file may leave it out
            source = "assumed" if keys.split(".")[0] in bearing.assumed else bearing.source
            value = value if isinstance(value, str) else factor * value
            # every digit of the drawing, and none that it has not
            rows.append(_row(*about, value, source, "{:.7g}".format))
    notes = [f"{torque.bearing}: {bearing.source}. *: assumed."]
    return _table("Bearing and test of its torque", rows, notes, paper_tables.tab03)


def _levels(levels: Iterable[float]) -> str:
    return ", ".join(f"{level:g}" for level in levels) or _NONE


def _number(value: float) -> str:
    """At least three digits, and all digits before the decimal point."""
    return f"{value:.{int(np.clip(2 - np.floor(np.log10(value)), 0, 3))}f}"


def _row(
    thing: str,
    quantity: str,
    unit: str,
    content: float | str,
    source: str,
    number_format: Callable[[float], str] = _number,
) -> dict[str, Any]:
    """One cell: a text, or a number in its format."""
    if isinstance(content, str):
        value, text = np.nan, content
    else:
        value, text = content, _NONE if np.isnan(content) else number_format(content)
    text = f"{text}*" if source == "assumed" else text
    columns = ("thing", "quantity", "unit", "words", "value", "source")
    return dict(zip(columns, (thing, quantity, unit, text, value, source), strict=True))


def _table(
    title: str,
    rows: list[dict[str, Any]],
    notes: list[str],
    of_paper: Mapping[str, PaperStatement],
) -> Sheet:
    """The rows as a table with one column per thing; last, what remains in the paper's text."""
    units = {row["quantity"]: row["unit"] for row in rows}
    for quantity, statement in of_paper.items():
        where = f" ({statement.where})" if statement.where else ""
        unit, source = units.get(quantity, ""), statement.where or "lost"
        rows.append(_row(_PAPER, quantity, unit, f"{statement.says}{where}", source))
    drawn = pd.DataFrame(rows)
    *things, _ = columns = [*drawn.loc[drawn["thing"] != _PAPER, "thing"].unique(), _PAPER]
    cells = drawn.pivot(index="quantity", columns="thing", values="words")
    cells = cells.reindex(index=drawn["quantity"].unique(), columns=columns).fillna("")
    few = len(things) <= 1
    cells[_PAPER] = ["\n".join(textwrap.wrap(text, 46 if few else 26)) for text in cells[_PAPER]]
    paper_x = 0.64 if few else 0.72
    ends = np.linspace(0.37, paper_x - 0.02, len(things) + 1)[1:]
    heads = [f"{name} ({unit})" if (unit := units.get(name, "")) else name for name in cells.index]
    row_in = _LINE_IN * (cells[_PAPER].str.count("\n").to_numpy() + 1) + _ROW_IN
    layout = style.DOUBLE_COLUMN_IN, len(cells), row_in, _LINE_IN + _ROW_IN
    sheet, panel, write = table_page(*layout, notes)
    bold: style.Look = {"fontweight": "bold"}
    write(0, title, heads, {"color": style.GREY})
    for thing, end in zip(things, ends, strict=True):
        write(end, thing, cells[thing], bold, ha="right")
    write(paper_x, _PAPER, cells[_PAPER], {**bold, "color": "black"}, color=style.GREY)
    series = drawn["quantity"] + drawn["unit"].map(lambda unit: f" ({unit})" if unit else "")
    label = drawn["words"] + " [" + drawn["source"] + "]"
    panel.keep(series, np.nan, value=drawn["value"], label=label, panel=drawn["thing"])
    return sheet


@register(like="constants", paper="Eqs 11-13", references=("printed_coefficients",))
def eqs11_13(
    results: CampaignTables, settings: Settings, printed_coefficients: PrintedCoefficients
) -> Sheet:
    """.

    Fitted constants of the traction law for each oil, with their standard errors from a
    bootstrap over curves. Beside them: the constants printed in the paper, signs restored, for
    the oils that it tested.
    """
    table = with_printed(results.configured.coefficients, printed_coefficients)
    note = "Printed: Deng et al. 2026, signs reconstructed"
    return draw_constants(table, list(settings.oils), note)
