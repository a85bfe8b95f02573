"""Counterparts of the paper's Figs 1 to 3 and 5, Tables 1-3 and Eqs 11-13: rigs, oils and curves.

Each number of a table has its source. The available text of the paper has lost the numbers of its
tables; a last column quotes what the text says of them. The two rigs are drawn from that text.
"""

import itertools
import string
import textwrap
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.patches import Circle, FancyArrowPatch, Patch, Rectangle

from deng2026_study.printed_law import add_printed_values
from deng2026_study.reference import PaperStatement, PaperTables
from deng2026_study.settings import study_settings
from oilfilm import tables
from oilfilm.fits.fitted import FittedLaw
from oilfilm.report.figures import style
from oilfilm.report.figures.curves import NO_POINT_MESSAGE, CurveInPanel, draw_curves
from oilfilm.report.figures.fits import draw_constants
from oilfilm.report.figures.sheet import Sheet, declare_figure, table_page
from oilfilm.settings.base import required_value
from oilfilm.settings.campaign import Campaign
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.tables.set_points import with_matched_set_points
from oilfilm.traction.law import CONDITIONS
from simulated_lab.printed import PrintedCoefficients

_PRESSURE, _SPEED, _TEMPERATURE = CONDITIONS
# Number of columns of a legend, as `Sheet.legend` takes it.
_AS_MANY_AS_FIT = 0


@declare_figure(
    counterpart="Fig. 2",
    family="data",
    tables=("points", "runs", "coefficients"),
    settings=("oils", "rigs", "same_set_point", "studies", "campaign.matrix"),
)
def fig02(results: CampaignTables, settings: Settings) -> Sheet:
    """Traction curves of one oil.

    Traction coefficient against slide-roll ratio, one row of panels per inlet temperature.
    Left: by maximum Hertz pressure; right: by entrainment speed. Symbols: plateau means with
    the 95 % interval of their random error. Lines: fitted law.
    """
    runs = with_matched_set_points(results.runs, settings)
    shown_conditions = study_settings(settings).figures.fig02
    oil = shown_conditions.oil
    temperatures = shown_conditions.inlet_temperature_c
    fitted = FittedLaw.from_tables(results.configured_fits.coefficients, oil)
    oil_colour = style.oil_colour(oil, list(settings.oils))
    sheet = Sheet(2 * len(temperatures), 2, height=1.7, sharex=True, sharey=True)
    # left: pressures at one speed; right: speeds at one pressure
    varied_and_fixed = ((_PRESSURE, _SPEED), (_SPEED, _PRESSURE))
    panels = itertools.product(temperatures, varied_and_fixed)
    for panel_index, (temperature, (varied, fixed)) in enumerate(panels):
        levels_of_panel = {_TEMPERATURE: temperature, fixed: getattr(shown_conditions, fixed)}
        levels = _levels_of(runs, settings.campaign, varied)
        shades = style.shades(oil_colour, len(levels))
        markers = itertools.cycle(style.MARKERS)
        curves = []
        for level, shade, marker in zip(levels, shades, markers, strict=False):
            points = _points_at_levels(
                results.points, runs, oil, {**levels_of_panel, varied: level}
            )
            label = style.level_phrases({varied: level})
            curves.append(CurveInPanel(label, oil, points, fitted, shade, marker))
        title = style.level_phrases(levels_of_panel) + _count_of_curves(curves)
        draw_curves(sheet.panel(panel_index, title), curves)
    left_panels = sheet.axes_of_panels[::2]
    right_panels = sheet.axes_of_panels[1::2]
    _label_axes_and_legend(sheet, [left_panels, right_panels])
    return sheet


@declare_figure(
    counterpart="Fig. 3",
    family="data",
    tables=("points", "runs", "coefficients"),
    settings=("oils", "rigs", "same_set_point", "studies", "campaign.matrix"),
)
def fig03(results: CampaignTables, settings: Settings) -> Sheet:
    """Traction curves of all oils at one temperature.

    Traction coefficient against slide-roll ratio, one panel per maximum Hertz pressure.
    Symbols: plateau means with the 95 % interval of their random error. Lines: fitted law.
    """
    runs = with_matched_set_points(results.runs, settings)
    shown_conditions = study_settings(settings).figures.fig03
    oils = list(settings.oils)
    levels_of_sheet = {
        _SPEED: shown_conditions.entrainment_speed_m_s,
        _TEMPERATURE: shown_conditions.inlet_temperature_c,
    }
    pressures = _levels_of(runs, settings.campaign, _PRESSURE)
    # all panels side by side; without any level one panel says so
    column_count = max(len(pressures), 1)
    sheet = Sheet(
        column_count, column_count, width=style.DOUBLE_COLUMN_IN, sharex=True, sharey=True
    )
    for panel_index, pressure in enumerate(pressures):
        curves = []
        for oil in oils:
            points = _points_at_levels(
                results.points, runs, oil, {_PRESSURE: pressure, **levels_of_sheet}
            )
            fitted = FittedLaw.from_tables(results.configured_fits.coefficients, oil)
            look = style.oil_look(oil, oils)
            curves.append(CurveInPanel(oil, oil, points, fitted, look["color"], look["marker"]))
        draw_curves(sheet.panel(panel_index, style.level_phrases({_PRESSURE: pressure})), curves)
    drawn_oils = set(sheet.drawn()["oil"])
    oils_without_points = [oil for oil in oils if oil not in drawn_oils]
    notes = style.missing_oil_handles(oils_without_points, "no accepted point here")
    _label_axes_and_legend(
        sheet, [sheet.axes_of_panels], notes, style.level_phrases(levels_of_sheet)
    )
    return sheet


def _count_of_curves(curves: Sequence[CurveInPanel]) -> str:
    """How many curves of a panel have points; empty where all or none have."""
    count = sum(len(curve.points) > 0 for curve in curves)
    if count in (0, len(curves)):
        return ""
    return f" ({count} of {len(curves)} curves)"


def _levels_of(runs: pd.DataFrame, campaign: Campaign, name: str) -> list[float]:
    """Levels of a condition: those of the campaign's matrix, else those that runs were set to."""
    if campaign.matrix is not None:
        return list(getattr(campaign.matrix, name))
    return sorted(runs[f"nominal_{name}"].dropna().unique())


def _points_at_levels(
    points: pd.DataFrame, runs: pd.DataFrame, oil: str, levels: Mapping[str, float]
) -> pd.DataFrame:
    """Accepted points of the runs of an oil at given levels."""
    runs = runs[runs["oil"] == oil]
    for name, level in levels.items():
        runs = runs[np.isclose(runs[f"nominal_{name}"], level)]
    return points[points["accepted"] & points["run_id"].isin(runs["run_id"])]


def _label_axes_and_legend(
    sheet: Sheet, groups: Sequence[Sequence[Axes]], notes: Sequence[Any] = (), title: str = ""
) -> None:
    """Label the axes, and list below each group of panels the series that any of them shows.

    Args:
        sheet: The drawn sheet.
        groups: Axes of the panels of each group; each group has one column of the legend.
        notes: Further entries of the legend, after those of the series.
        title: Title of the legend.
    """
    sheet.label_axes(style.CONDITION_LABELS["slide_roll_ratio"], style.TRACTION_LABEL)
    if not sheet.drawn_parts:
        # a panel without points has this text; a sheet without any level has drawn no panel
        if not sheet.axes_of_panels[0].texts:
            sheet.panel(0).write_message(NO_POINT_MESSAGE)
        return
    columns_of_handles = []
    for axes_of_group in groups:
        handles_and_labels = [axes.get_legend_handles_labels() for axes in axes_of_group]
        # a series may have no points in the first panel; the fullest one gives the order
        fullest_first = sorted(
            handles_and_labels,
            key=lambda handles_and_labels_of_axes: -len(handles_and_labels_of_axes[1]),
        )
        handle_of_label: dict[str, Any] = {}
        for handles, labels in fullest_first:
            handle_of_label.update(zip(labels, handles, strict=True))
        columns_of_handles.append(list(handle_of_label.values()))
    row_count = max(len(handles_of_column) for handles_of_column in columns_of_handles)
    legend_handles = []
    for handles_of_column in columns_of_handles:
        # empty entries, so that each group has a column of its own
        empty_entries = style.missing_oil_handles([""] * (row_count - len(handles_of_column)))
        legend_handles += [*handles_of_column, *empty_entries]
    column_count = len(groups) if len(groups) > 1 else _AS_MANY_AS_FIT
    sheet.legend([*legend_handles, *notes], title, column_count)
    sheet.axes_of_panels[0].set_ylim(bottom=0)
    # symbols at slip 0 are drawn completely
    sheet.axes_of_panels[0].set_xlim(left=-0.005)


# Heading of the column that quotes the paper.
_PAPER_COLUMN = "in the paper's text"
_NO_VALUE = "\N{EN DASH}"
# Height of a line of text, and space between rows.
_LINE_IN = 0.125
_ROW_SPACE_IN = 0.06
# Right end of the names of the quantities, from 0 to 1 of the width.
_END_OF_NAMES = 0.37
# Temperature of the oils' properties, as in the paper.
_PROPERTIES_AT_C = 100.0
# Quantity, unit, and a function that gives the value of an oil.
_OIL_PROPERTIES: tuple[tuple[str, str, Any], ...] = (
    ("grade", "cSt", lambda oil: oil.nominal_kinematic_viscosity_100c_cst),
    (
        "kinematic viscosity",
        "cSt",
        lambda oil: 1e6 * oil.kinematic_viscosity_m2_s(_PROPERTIES_AT_C),
    ),
    ("dynamic viscosity", "mPa s", lambda oil: 1e3 * oil.dynamic_viscosity_pa_s(_PROPERTIES_AT_C)),
    ("density", "kg/m\N{SUPERSCRIPT THREE}", lambda oil: oil.density_kg_m3(_PROPERTIES_AT_C)),
    (
        "pressure-viscosity coefficient",
        "1/GPa",
        lambda oil: 1e9 * oil.pressure_viscosity_coefficient_1_pa(_PROPERTIES_AT_C),
    ),
    (
        "thermal conductivity",
        "W/(m K)",
        lambda oil: oil.thermal_conductivity_w_mk(_PROPERTIES_AT_C),
    ),
    ("specific heat", "J/(kg K)", lambda oil: oil.specific_heat_j_kgk(_PROPERTIES_AT_C)),
)
# Quantity and unit of each condition of the test matrix.
_MATRIX_QUANTITIES = {
    "max_hertz_pressure_gpa": ("maximum Hertz pressure", "GPa"),
    "entrainment_speed_m_s": ("entrainment speed", "m/s"),
    "inlet_temperature_c": ("inlet temperature", "\N{DEGREE SIGN}C"),
}


@declare_figure(
    counterpart="Table 1",
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
    cells = []
    notes = []
    for name in settings.oils:
        oil = settings.properties_of(name)
        source = "no known properties"
        if oil is not None:
            source = f"stand-in: {oil.source}" if oil.stand_in else oil.source
        notes.append(f"{name}: {source}")
        for quantity, unit, value_of_oil in _OIL_PROPERTIES:
            value = np.nan if oil is None else float(value_of_oil(oil))
            cells.append(_table_cell(name, quantity, unit, value, source))
    title = f"Properties at {_PROPERTIES_AT_C:g} \N{DEGREE SIGN}C and 1 bar"
    return _table_sheet(title, cells, notes, paper_tables.tab01)


@declare_figure(
    counterpart="Table 2",
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
    matrix = settings.campaign.matrix
    runs = with_matched_set_points(results.runs, settings)
    source_of_logs = "set points of the logs"
    source = "campaign file, matrix" if matrix is not None else source_of_logs
    accepted = results.points[results.points["accepted"]]
    cells = []
    column_heading = "this campaign"
    for name, (quantity, unit) in _MATRIX_QUANTITIES.items():
        levels = _levels_of(runs, settings.campaign, name)
        cells.append(_table_cell(column_heading, quantity, unit, _levels_text(levels), source))
    # set points of a rig whose contact is not known
    loads = sorted(runs["nominal_load_n"].dropna().unique())
    if loads:
        cells.append(_table_cell(column_heading, "load", "N", _levels_text(loads), source_of_logs))
    slips = accepted["slide_roll_ratio"].abs()
    slip_range = _NO_VALUE
    if len(slips):
        slip_range = f"{round(slips.min(), 3):g} to {round(slips.max(), 3):g}"
    cells.append(_table_cell(column_heading, "slide-roll ratio", "", slip_range, "accepted points"))
    for oil in settings.oils:
        runs_of_oil = runs.loc[runs["oil"] == oil, "run_id"]
        accepted_count = runs_of_oil.isin(accepted["run_id"]).sum()
        curves = f"{accepted_count} accepted of {len(runs_of_oil)} runs"
        cells.append(
            _table_cell(column_heading, f"curves of {oil}", "", curves, "tables runs and points")
        )
    return _table_sheet("Test matrix", cells, [f"Levels: {source}."], paper_tables.tab02)


@declare_figure(
    counterpart="Table 3",
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
    torque = required_value(settings.campaign.torque, "torque", "the campaign")
    bearing = settings.bearings[torque.bearing]
    cells = []
    # column `of`: the quantity is one of the bearing's file, or of the test in the campaign file
    quantities = pd.read_csv(Path(__file__).with_name("tab03.csv"), keep_default_na=False)
    for subject, quantity, unit, dotted_key, factor in quantities.itertuples(index=False):
        if subject == "test":
            if torque.matrix is not None:
                levels = [factor * level for level in getattr(torque.matrix, dotted_key)]
                source = "campaign file, `torque`"
                cells.append(
                    _table_cell(torque.bearing, quantity, unit, _levels_text(levels), source)
                )
            continue
        keys = dotted_key.split(".")
        value: Any = bearing
        for key in keys:
            value = getattr(value, key, None)
        # the file of the bearing may leave the key out
        if value is not None:
            source = "assumed" if keys[0] in bearing.assumed else bearing.source
            content = value if isinstance(value, str) else factor * value
            # all digits of the drawing and no others
            cells.append(
                _table_cell(torque.bearing, quantity, unit, content, source, "{:.7g}".format)
            )
    notes = [f"{torque.bearing}: {bearing.source}. *: assumed."]
    return _table_sheet("Bearing and test of its torque", cells, notes, paper_tables.tab03)


def _levels_text(levels: Iterable[float]) -> str:
    return ", ".join(f"{level:g}" for level in levels) or _NO_VALUE


def _number(value: float) -> str:
    """A number with three digits or more, and at most three decimals."""
    decimals = int(np.clip(2 - np.floor(np.log10(value)), 0, 3))
    return f"{value:.{decimals}f}"


def _table_cell(
    column: str,
    quantity: str,
    unit: str,
    content: float | str,
    source: str,
    format_number: Callable[[float], str] = _number,
) -> dict[str, Any]:
    """One cell of a table, as a row of its own.

    Args:
        column: Head of the cell's column: an oil, a bearing, a campaign, or the paper.
        quantity: Name of the cell's row.
        unit: Unit of the quantity; may be empty.
        content: A text, or a number in the unit; NaN where it is not known.
        source: Where the content is from; a star marks what is `assumed`.
        format_number: Text of a number.
    """
    value = np.nan
    if isinstance(content, str):
        text = content
    else:
        value = content
        text = _NO_VALUE if np.isnan(value) else format_number(value)
    if source == "assumed":
        text += "*"
    return {
        "column": column,
        "quantity": quantity,
        "unit": unit,
        "text": text,
        "value": value,
        "source": source,
    }


def _table_sheet(
    title: str,
    cells_of_table: list[dict[str, Any]],
    notes: list[str],
    paper_statements: Mapping[str, PaperStatement],
) -> Sheet:
    """A table with one row per quantity; its last column quotes the paper.

    Args:
        title: Head of the names of the quantities.
        cells_of_table: Cells, as `_table_cell` returns them.
        notes: Notes below the table.
        paper_statements: What the paper's text says, by quantity. It is added to the cells.
    """
    units = {row["quantity"]: row["unit"] for row in cells_of_table}
    for quantity, statement in paper_statements.items():
        where_in_paper = f" ({statement.where})" if statement.where else ""
        unit = units.get(quantity, "")
        source = statement.where or "lost"
        cells_of_table.append(
            _table_cell(_PAPER_COLUMN, quantity, unit, f"{statement.says}{where_in_paper}", source)
        )
    drawn_cells = pd.DataFrame(cells_of_table)
    columns = list(drawn_cells.loc[drawn_cells["column"] != _PAPER_COLUMN, "column"].unique())
    text_by_quantity = drawn_cells.pivot(index="quantity", columns="column", values="text")
    text_by_quantity = text_by_quantity.reindex(
        index=drawn_cells["quantity"].unique(), columns=[*columns, _PAPER_COLUMN]
    ).fillna("")
    # start of the quotations, from 0 to 1 of the width, and letters per line behind it
    if len(columns) <= 1:
        paper_x = 0.64
        letters_per_line = 46
    else:
        paper_x = 0.72
        letters_per_line = 26
    text_by_quantity[_PAPER_COLUMN] = [
        "\n".join(textwrap.wrap(text, letters_per_line)) for text in text_by_quantity[_PAPER_COLUMN]
    ]
    right_ends = np.linspace(_END_OF_NAMES, paper_x - 0.02, len(columns) + 1)[1:]
    quantity_names = [
        _with_unit(quantity, units.get(quantity, "")) for quantity in text_by_quantity.index
    ]
    line_counts = text_by_quantity[_PAPER_COLUMN].str.count("\n").to_numpy() + 1
    row_in = _LINE_IN * line_counts + _ROW_SPACE_IN
    head_in = _LINE_IN + _ROW_SPACE_IN
    sheet, panel, write_column = table_page(
        style.DOUBLE_COLUMN_IN, len(text_by_quantity), row_in, head_in, notes
    )
    bold: style.Look = {"fontweight": "bold"}
    write_column(0, title, quantity_names, {"color": style.GREY})
    for column, right_end in zip(columns, right_ends, strict=True):
        write_column(right_end, column, text_by_quantity[column], bold, ha="right")
    write_column(
        paper_x,
        _PAPER_COLUMN,
        text_by_quantity[_PAPER_COLUMN],
        {**bold, "color": "black"},
        color=style.GREY,
    )
    row_names = [
        _with_unit(quantity, unit)
        for quantity, unit in zip(drawn_cells["quantity"], drawn_cells["unit"], strict=True)
    ]
    labels = drawn_cells["text"] + " [" + drawn_cells["source"] + "]"
    panel.record(
        row_names, np.nan, value=drawn_cells["value"], label=labels, panel=drawn_cells["column"]
    )
    return sheet


def _with_unit(quantity: str, unit: str) -> str:
    """A quantity with its unit in brackets, if it has one."""
    return f"{quantity} ({unit})" if unit else quantity


# The figure has no title of its own: the counterpart names it. Its paragraph replaces the first one
# of the caption of `constants`.
@declare_figure(like="constants", counterpart="Eqs 11-13", references=("printed_coefficients",))
def eqs11_13(
    results: CampaignTables, settings: Settings, printed_coefficients: PrintedCoefficients
) -> Sheet:
    """.

    Fitted constants of the traction law for each oil, with their standard errors from a
    bootstrap over curves. Beside them: the constants printed in the paper, signs restored, for
    the oils that it tested.
    """
    table = add_printed_values(results.configured_fits.coefficients, printed_coefficients)
    note = "Printed: Deng et al. 2026, signs reconstructed"
    return draw_constants(table, list(settings.oils), note)


# Colour and label in the legend of each kind of part of a rig.
_COLOUR_AND_LABEL_OF_KIND: dict[str, tuple[Any, str]] = {
    "fixed": (style.tint("#555555", 0.30), "fixed or guided"),
    "turning": ("#ffffff", "turning"),
    "sensor": (style.tint("#E69F00", 0.65), "sensor"),
    "drive": (style.tint("#CC79A7", 0.45), "drive"),
    "oil": (style.tint("#56B4E9", 0.60), "oil"),
}
_EDGE: style.Look = {"edgecolor": "black", "linewidth": 0.6}


@declare_figure(counterpart="Fig. 1", family="data", settings=("rigs",), shows_data=False)
def fig01(results: CampaignTables, settings: Settings) -> Sheet:
    """Traction rig.

    (a) Ball-on-disc rig with drives and sensors. (b) The cradle turns about the vertical axis
    of the air spindle. It presses against the force sensor, which measures along the rolling
    direction. (c) Contact of ball and disc with the measured speeds, load and force. Schematic
    after the text of the paper, not to scale; configured dimensions in mm.
    """
    sheet = Sheet(4, 2, height=(1.55, 1.9), left=0.05, bottom=0.05, width_ratios=(1.15, 1))
    # left one panel, as tall as both panels on the right
    grid = sheet.axes_of_panels[0].get_gridspec()
    for axes in sheet.axes_of_panels[::2]:
        axes.remove()
    sheet.axes_of_panels = [sheet.figure.add_subplot(grid[:, 0]), *sheet.axes_of_panels[1::2]]
    rig = next(iter(settings.rigs.values()))
    radii = {"disc": rig.disc_track_radius_m, "ball": rig.ball_track_radius_m}
    sizes = {
        name: "" if radius is None else f" = {1e3 * radius:.4g} mm"
        for name, radius in radii.items()
    }
    titles = ("Rig from the side", "Cradle from above", "Contact, along the ball's axis")
    return _draw_schematic(sheet, "fig01", titles, sizes)


@declare_figure(counterpart="Fig. 5", family="data", shows_data=False)
def fig05(results: CampaignTables, settings: Settings) -> Sheet:
    """Torque rig.

    Rig for the friction torque of a bearing: driven inner ring, pure axial load and under-race
    lubrication. The torque of the outer ring is measured. Schematic after the text of the
    paper, not to scale.
    """
    sheet = Sheet(width=style.DOUBLE_COLUMN_IN, left=0.05, top=0.05, bottom=0.05, height=2.3)
    return _draw_schematic(sheet, "fig05", [None], {})


def _draw_schematic(
    sheet: Sheet, name: str, titles: Sequence[str | None], sizes: Mapping[str, str]
) -> Sheet:
    """Draw the parts of a rig that a file lists, later ones over earlier ones, and the legend.

    A circle has its radius as `to_x`. Words are at (x, y), with a line to the part at (to_x, to_y)
    unless that is the same point. The table of the figure has two rows per part: start and end.

    Args:
        sheet: The sheet with its panels.
        name: The file `<name>.csv` beside this module has the parts.
        titles: Title of each panel.
        sizes: Text that replaces each name in braces in the words of the file.
    """
    parts = pd.read_csv(Path(__file__).with_name(f"{name}.csv"), keep_default_na=False)
    labels = [label.format_map(sizes).replace("\\n", "\n") for label in parts["words"]]
    panels = [sheet.panel(panel_index, title) for panel_index, title in enumerate(titles)]
    for part in tables.rows(parts.assign(words=labels)):
        panel_index = string.ascii_lowercase.index(part["panel"])
        _draw_mark(sheet.axes_of_panels[panel_index], part)
    for axes in sheet.axes_of_panels:
        axes.set_aspect("equal")
        axes.set_axis_off()
        axes.set_anchor("N")
    sheet.legend(
        [
            Patch(facecolor=colour, label=label, **_EDGE)
            for colour, label in _COLOUR_AND_LABEL_OF_KIND.values()
        ]
    )
    series_names = (parts["mark"] + " " + parts["kind"]).str.strip().repeat(2)
    x = parts[["x", "to_x"]].to_numpy().ravel()
    y = parts[["y", "to_y"]].to_numpy().ravel()
    panels[0].record(series_names, x, y, label=np.repeat(labels, 2), panel=parts["panel"].repeat(2))
    return sheet


def _draw_mark(axes: Axes, part: Mapping[str, Any]) -> None:
    """Draw one row of the file of a schematic."""
    start = (part["x"], part["y"])
    end = (part["to_x"], part["to_y"])
    width = end[0] - start[0]
    height = end[1] - start[1]
    colour, _ = _COLOUR_AND_LABEL_OF_KIND.get(part["kind"], ("black", ""))
    is_oil = part["kind"] == "oil"
    match part["mark"]:
        case "box":
            axes.add_patch(Rectangle(start, width, height, facecolor=colour, **_EDGE))
        case "film":
            axes.add_patch(Rectangle(start, width, height, facecolor=colour, linewidth=0))
        case "circle":
            axes.add_patch(Circle(start, end[0], facecolor=colour, **_EDGE))
        case "ring":
            axes.add_patch(Circle(start, end[0], fill=False, linewidth=0.6, linestyle="--"))
        case "line":
            thickness = 3.0 if is_oil else 0.6
            axes.plot(
                [start[0], end[0]],
                [start[1], end[1]],
                color=colour,
                linewidth=thickness,
                solid_capstyle="butt",
            )
        case "arrow" | "turn" | "turn left":
            bend = {"turn": -0.6, "turn left": 0.6}.get(part["mark"], 0.0)
            axes.add_patch(
                FancyArrowPatch(
                    start,
                    end,
                    arrowstyle="-|>",
                    connectionstyle=f"arc3,rad={bend}",
                    mutation_scale=7,
                    shrinkA=0,
                    shrinkB=0,
                    color="#0072B2" if is_oil else "black",
                    linewidth=0.9,
                )
            )
        case "words":
            _draw_label(axes, part["words"], start, end)


def _draw_label(
    axes: Axes, label: str, centre: tuple[float, float], target_point: tuple[float, float]
) -> None:
    """Write a label, with a line to its target unless that is the centre of the label."""
    box = None
    if centre != target_point:
        axes.plot(
            [centre[0], target_point[0]],
            [centre[1], target_point[1]],
            color=style.GREY,
            linewidth=0.5,
        )
        axes.plot(*target_point, ".", color=style.GREY, markersize=2.5)
        box = {"facecolor": "white", "edgecolor": "none", "pad": 0.8}
    axes.text(*centre, label, ha="center", va="center", fontsize=7, linespacing=1.1, bbox=box)
