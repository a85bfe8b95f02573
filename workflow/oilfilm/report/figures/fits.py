"""Figures of the fits.

Constants, their correlations and the errors of all laws; mu over speed and slip, mu over the film,
mu without the film's own heat.
"""

from collections.abc import Collection, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib import colormaps
from matplotlib.colors import LogNorm
from matplotlib.patches import Rectangle
from matplotlib.patheffects import withStroke
from matplotlib.ticker import LogLocator, NullFormatter

from oilfilm import tables
from oilfilm.base.units import BoolArray, FloatArray
from oilfilm.fits.fit import laws_of_oil
from oilfilm.fits.fitted import FittedLaw
from oilfilm.fits.problem import curve_data
from oilfilm.physics.contact import Conditions, Contact
from oilfilm.physics.film import InletOil, film_thickness, film_viscosity_ratio
from oilfilm.physics.thermal_traction import mean_film_temperature_rise
from oilfilm.report.document import format_by_error, number_formatter
from oilfilm.report.figures import style
from oilfilm.report.figures.sheet import (
    NothingToDrawError,
    Panel,
    Sheet,
    declare_figure,
    oil_grid,
    table_page,
)
from oilfilm.report.names import law_title
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CURVE_COLUMNS, CampaignTables
from oilfilm.torque.operating_grid import Grid, film_by_oil, reason_without_value, traction_on_grid
from oilfilm.traction import LAWS
from oilfilm.traction.law import CONDITIONS, QUANTITIES, Law

_ROW_IN = 0.17  # height of a row of a table
# Conditions whose lowest and highest levels are left out, as names of columns begin.
_CONDITIONS_WITH_ENDS = ("pressure", "speed", "temperature")
# Symbol of each kind of error; each kind is farther from the fitted curves than the one before.
_LOOK_OF_ERROR: dict[str, style.Look] = {
    "fitted curves": {"marker": "o", "markersize": 3.4},
    "curve left out": {"marker": "D", "markersize": 3.4},
    "end level left out": {"marker": "^", "markersize": 4},
}


@declare_figure(family="law", tables=("coefficients",), settings=("oils",))
def constants(results: CampaignTables, settings: Settings) -> Sheet:
    """Fitted constants.

    Fitted constants of the traction law for each oil, with their standard errors from a
    bootstrap over curves; none where there are too few.
    """
    # a study has constants that a paper printed; a campaign alone has none
    table = results.configured_fits.coefficients.assign(printed_value=np.nan)
    return draw_constants(table, list(settings.oils))


def draw_constants(coefficients: pd.DataFrame, oils: Sequence[str], note: str = "") -> Sheet:
    """A table of constants, one group of columns per oil.

    Args:
        coefficients: Table of coefficients with the column `printed_value`, which is shown where it
            is known.
        oils: Oils of the campaign.
        note: What `printed_value` is, for the lines below.
    """
    # a constant that no oil has, neither fitted nor printed, is no row
    known_coefficients = coefficients.dropna(subset=["value", "printed_value"], how="all")
    shown_constants = list(dict.fromkeys(known_coefficients["constant"])) or ["no constants"]
    has_printed = bool(known_coefficients["printed_value"].notna().any())
    notes = [
        _powers_in_words(LAWS[name], set(known_coefficients["constant"]))
        for name in coefficients["law"].unique()
    ]
    if has_printed:
        notes.append(note)
    is_one_oil = len(oils) == 1
    width = style.SINGLE_COLUMN_IN if is_one_oil else style.DOUBLE_COLUMN_IN
    # as shares of the width: the column of names, and the columns of one oil
    names_share = 0.12 if is_one_oil else 0.06
    oil_share = (1 - names_share) / len(oils)
    sheet, panel, write = table_page(width, len(shown_constants), _ROW_IN, 2 * _ROW_IN, notes)
    write(0, "", shown_constants, fontweight="bold")
    for oil_index, oil in enumerate(oils):
        left_edge = names_share + oil_index * oil_share
        colour = style.oil_colour(oil, oils)
        write(
            left_edge + 0.53 * oil_share,
            f"{oil}\n",
            [""] * len(shown_constants),
            ha="center",
            color=colour,
            fontweight="bold",
        )
        rows_of_constants = (
            coefficients[coefficients["oil"] == oil].set_index("constant").reindex(shown_constants)
        )
        for right_edge, heading, texts in _columns_of_oil(rows_of_constants):
            x = left_edge + right_edge * oil_share
            write(x, f"\n{heading}", texts, {"color": style.GREY}, ha="right")
    details = {"oil": coefficients["oil"], "label": coefficients["constant"]}
    value = coefficients["value"]
    error = coefficients["standard_error"]
    panel.record("fitted", np.nan, value=value, lower=value - error, upper=value + error, **details)
    if has_printed:
        panel.record("printed", np.nan, value=coefficients["printed_value"], **details)
    return sheet


def _powers_in_words(law: Law, shown_constants: Collection[str]) -> str:
    """The quantities whose powers make the coefficients of a law, each over its reference, as text.

    Args:
        law: The law.
        shown_constants: Constants that are shown. A quantity without an exponent among them is left
            out.
    """
    varied_groups = {
        constant.group for constant in law.constants if constant.name in shown_constants
    }
    texts = []
    for group, reference in zip(law.groups, law.reference, strict=True):
        if group not in varied_groups:
            continue
        text = f"{QUANTITIES[group].symbol} over {reference:g} {QUANTITIES[group].unit}"
        texts.append(f"exponential of {text}" if group in law.exponential else text)
    return f"{law_title(law.name)}: {', '.join(texts) or 'no condition varied'}"


def _columns_of_oil(coefficients: pd.DataFrame) -> list[tuple[float, str, list[str]]]:
    """Right edge (share of the oil's width), heading and texts of each column of one oil."""
    errors = coefficients["standard_error"].fillna(coefficients["naive_standard_error"])
    number_formats = [format_by_error(error) for error in errors]

    def texts(column: str, number_formats: Sequence[str]) -> list[str]:
        """The column's values, each in its own number format."""
        return [
            number_formatter(number_format)(value)
            for value, number_format in zip(coefficients[column], number_formats, strict=True)
        ]

    fitted_texts = texts("value", number_formats)
    error_heading = "\N{PLUS-MINUS SIGN} s.e."
    error_texts = texts("standard_error", number_formats)
    if coefficients["printed_value"].isna().all():
        return [(0.5, "fitted", fitted_texts), (0.97, error_heading, error_texts)]
    # printed values keep all their printed digits
    printed_texts = texts("printed_value", [".10g"] * len(coefficients))
    return [
        (0.29, "fitted", fitted_texts),
        (0.59, error_heading, error_texts),
        (0.98, "printed", printed_texts),
    ]


@declare_figure(family="law", tables=("correlations",), settings=("oils",))
def identifiability(results: CampaignTables, settings: Settings) -> Sheet:
    """Identifiability of the constants.

    Correlation of each pair of constants, by the bootstrap over curves or, with too few curves,
    by the Jacobian. Near 1 or -1 the two constants replace each other.
    """
    correlations = results.configured_fits.correlations
    sheet, panels = oil_grid(
        style.oils_in(correlations, settings),
        "No oil has a fit.",
        width=style.DOUBLE_COLUMN_IN,
        height=1.55,
        across=0.4,
        right=0.8,
        sharex=False,
        sharey=False,
    )
    for panel, _, oil in panels:
        pairs = correlations[correlations["oil"] == oil]
        names = list(dict.fromkeys([*pairs["constant"], *pairs["other"]]))
        correlation_map = pairs.pivot(index="other", columns="constant", values="correlation")
        # from orange by white to purple, distinct for every kind of colour vision
        correlation_matrix = correlation_map.reindex(index=names, columns=names).to_numpy(
            dtype=float
        )
        image = panel.axes.imshow(correlation_matrix, cmap="PuOr", vmin=-1, vmax=1)
        panel.axes.set_xticks(range(len(names)), names, rotation=90, fontsize=6)
        panel.axes.set_yticks(range(len(names)), names, fontsize=6)
        panel.axes.grid(False)
        panel.axes.tick_params(length=0)
        labels = pairs["constant"] + ", " + pairs["other"]
        panel.record("correlation", np.nan, oil=oil, label=labels, value=pairs["correlation"])
    sheet.colour_bar(image, "Correlation")
    return sheet


@declare_figure(family="law", tables=("fit_quality",), settings=("oils",))
def law_errors(results: CampaignTables, settings: Settings) -> Sheet:
    """Errors of the laws.

    Rms error of each law over the rms of the measured traction coefficient: on fitted curves, on
    curves left out, and on the lowest and highest levels of pressure, speed and temperature left
    out. Open symbols: fit not certified (the table of the comparison says why). The dimensionless
    groups of the Wang-Deng laws, and how their equations are read, are of this software.
    """
    compared = results.fit_quality.dropna(subset="rmse")
    oils = list(settings.oils)
    laws = list(dict.fromkeys(compared["law"]))
    if not laws:
        raise NothingToDrawError("no law could be fitted")
    sheet = Sheet(width=style.DOUBLE_COLUMN_IN, left=1.75, height=0.34 * len(laws) + 0.1)
    panel = sheet.panel(title=None)
    # laws have a distance of one; all oils of a law stay within 0.8
    distance_of_oils = min(0.24, 0.8 / len(oils))
    for fit_row in tables.rows(compared):
        oils_from_middle = oils.index(fit_row["oil"]) - (len(oils) - 1) / 2
        y = laws.index(fit_row["law"]) + oils_from_middle * distance_of_oils
        _draw_law_errors(panel, fit_row, y, oils)
    axes = panel.axes
    axes.set_yticks(range(len(laws)), map(law_title, laws))
    axes.set(ylim=(len(laws) - 0.45, -0.55), xscale="log")
    axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    # decimals as each level needs them: 0.2 %, 100 %
    axes.xaxis.set_major_formatter(lambda value, _: f"{100 * value:.3g}%")
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.grid(visible=False, axis="y")
    axes.set_xlabel(f"Rms error over rms of measured {style.MU}")
    white: style.Look = {"color": "black", "markerfacecolor": "white", "linestyle": ""}
    kinds = [style.line_handle(kind, **white, **look) for kind, look in _LOOK_OF_ERROR.items()]
    sheet.legend([*style.oil_patches(style.oils_in(compared, settings), oils), *kinds])
    return sheet


def mu_at_zero_slip(
    results: CampaignTables, oil: str, law_name: str, settings: Settings
) -> pd.DataFrame:
    """mu of a law at zero slip for each curve (`run_id`, `y`), in order of rising temperature.

    Args:
        results: Tables `points` and `coefficients`.
        oil: Name of the oil.
        law_name: Name of the law.
        settings: Settings of the campaign.
    """
    coefficients = results.coefficients
    is_of_fit = (coefficients["oil"] == oil) & (coefficients["law"] == law_name)
    if coefficients.loc[is_of_fit, "value"].isna().all():
        return pd.DataFrame({"run_id": [], "y": []})
    law = laws_of_oil(oil, settings)[law_name]
    data = curve_data(results.table("points", CURVE_COLUMNS, oil=oil), law.conditions)
    fitted = FittedLaw.from_tables(coefficients, oil, law=law)
    mu = fitted.predict(data.conditions, np.zeros(len(data.run_ids))).traction_coefficient
    order = np.argsort(data.conditions[:, -1], kind="stable")
    return pd.DataFrame({"run_id": data.run_ids, "y": mu}).iloc[order]


def _draw_law_errors(
    panel: Panel, fit_row: Mapping[str, Any], y: float, oils: Sequence[str]
) -> None:
    """Draw each kind of error of one fit, on a line from the smallest to the largest.

    Args:
        panel: The panel.
        fit_row: Row of the table of fit quality.
        y: Ordinate of the fit.
        oils: Oils of the campaign.
    """
    oil = fit_row["oil"]
    left_out = fit_row["left_out_rmse"] * fit_row["relative_rms"] / fit_row["rmse"]
    errors_of_kind = {
        "fitted curves": np.array([fit_row["relative_rms"]]),
        "curve left out": np.array([left_out]),
        "end level left out": np.array(
            [fit_row[f"{condition}_end_out_relative_rms"] for condition in _CONDITIONS_WITH_ENDS]
        ),
    }
    all_errors = np.concatenate(list(errors_of_kind.values()))
    colour = style.oil_colour(oil, oils)
    ends_of_line = [np.nanmin(all_errors), np.nanmax(all_errors)]
    panel.axes.plot(ends_of_line, [y, y], color=colour, linewidth=0.6)
    label = fit_row["law"] if fit_row["certified"] else f"{fit_row['law']}, not certified"
    for kind, errors in errors_of_kind.items():
        known_errors = errors[~np.isnan(errors)]
        look: style.Look = {"color": colour, "markerfacecolor": "white"}
        if fit_row["certified"]:
            look["markerfacecolor"] = colour
        look.update(_LOOK_OF_ERROR[kind])
        panel.dots(kind, known_errors, np.full(len(known_errors), y), look, oil=oil, label=label)


def oil_symbol(fit_row: Mapping[str, Any], oils: Sequence[str]) -> style.Look:
    """Symbol of an oil, open where the fit is not certified."""
    look = style.oil_look(fit_row["oil"], oils)
    look["markerfacecolor"] = look["color"] if fit_row["certified"] else "white"
    look["linestyle"] = ""
    return look


_GRID_POINTS_PER_AXIS = 41  # along each axis of a map
# A white line with a black rim is seen on every colour.
_TESTED_FRAME: style.Look = {
    "fill": False,
    "edgecolor": "white",
    "linewidth": 1.0,
    "path_effects": [withStroke(linewidth=2.2, foreground="black")],
}
# `without_heat` extrapolates down to this share of the lowest tested speed, and up to the largest
# tested slip over this share.
_EXTRAPOLATION_SHARE = 0.7
# mu/S of a film without heat does not rise with S. A rise by this share is scatter: the correction
# takes its heat from readings.
_SCATTER_OF_SLOPE = 0.02
# Number of iterations, after which a colder inlet and the heat of its film agree.
_ITERATION_COUNT = 30
# The central film goes with speed to the power 0.67 (Hamrock and Dowson): its inverse.
_SPEED_PER_FILM = 1 / 0.67
_SPEED_TICKS = (1, 2, 5, 10, 20, 50, 100, 200)
_SLIP_TICKS = (0.001, 0.003, 0.01, 0.03, 0.1, 0.3)
_LAMBDA_TICKS = (0.5, 1, 2, 5, 10, 20, 50, 100)


@declare_figure(
    family="law",
    tables=("coefficients", "fit_quality"),
    settings=("figures", "film", "gates", "oils", "rigs"),
)
def friction_map(results: CampaignTables, settings: Settings) -> Sheet:
    """Friction map.

    Traction coefficient of the fitted law (colour and labelled lines) over entrainment speed
    (m/s) and slide-roll ratio, one column of panels per oil and one row per maximum Hertz
    pressure, at one inlet temperature. Dotted line: limiting shear stress of the oil over pressure
    (Bair and Winer 1979), or that of usual oils where the file of the oil does not state it; no
    film carries more. Dashed line: limit of lambda, below which the film is not full, on the first
    rig whose contact and roughness are known. Frame: tested conditions. Traction coefficients above
    5, which only an extrapolated law has, are not coloured.
    """
    map_settings = settings.figures.friction_map
    fit_by_oil = _fit_by_oil(results)
    pressures_gpa = map_settings.max_hertz_pressure_gpa
    temperature_c = map_settings.inlet_temperature_c
    sheet, panels = oil_grid(
        list(fit_by_oil),
        "No oil has a fitted law of pressure, speed and temperature.",
        list(enumerate(pressures_gpa)),
        lambda row, oil: f"{oil}, {row[1]:g} GPa",
        height=1.55,
        right=0.75,
        across=0.25,
        width=style.DOUBLE_COLUMN_IN,
    )
    slowest, fastest = map_settings.entrainment_speed_m_s
    smallest_slip, largest_slip = map_settings.slide_roll_ratio
    speed = np.geomspace(slowest, fastest, _GRID_POINTS_PER_AXIS)
    slip = np.geomspace(smallest_slip, largest_slip, _GRID_POINTS_PER_AXIS)
    speed_mesh, slip_mesh = np.meshgrid(speed, slip)
    grid = Grid(np.array(pressures_gpa), speed, np.array([temperature_c]), slip)
    mu_of_oil = {oil: traction_on_grid(fit, grid) for oil, fit in fit_by_oil.items()}
    lambda_of_oil = {}
    for oil, film in film_by_oil(settings).items():
        _, lambda_of_oil[oil] = film.on_grid(grid)
    lambda_limit = settings.gates.lambda_limit
    largest_mu = max(float(np.nanmax(mu)) for mu in mu_of_oil.values())
    mu_levels = _levels_up_to(largest_mu)
    colours: style.Look = {"norm": LogNorm(mu_levels[0], mu_levels[-1]), "extend": "min"}
    level_lines: style.Look = {"colors": "white", "linewidths": 0.4}
    handle_by_label: dict[str, Any] = {}
    for panel, (pressure_index, pressure_gpa), oil in panels:
        panel.axes.set(xscale="log", yscale="log")
        mu = mu_of_oil[oil][pressure_index, :, 0].T
        lambda_ratio = np.full_like(mu, np.nan)
        if oil in lambda_of_oil:
            lambda_ratio = lambda_of_oil[oil][pressure_index, :, 0].T
        image = panel.axes.contourf(speed, slip, mu, mu_levels, **colours)
        lines_of_levels = panel.axes.contour(speed, slip, mu, mu_levels, **level_lines)
        panel.axes.clabel(lines_of_levels, fmt="%g", fontsize=5)
        stress_limit = fit_by_oil[oil].coefficients.limiting_stress_ratio
        for label, values, level, dashes, width in (
            ("limiting shear stress", mu, stress_limit, ":", 1.6),
            (f"{style.LAMBDA} = {lambda_limit:g}", lambda_ratio, lambda_limit, "--", 0.9),
        ):
            contour = panel.axes.contour(
                speed, slip, values, [level], colors="black", linestyles=dashes, linewidths=width
            )
            if any(len(path) for path in contour.get_paths()):
                handle_by_label[label] = style.line_handle(
                    label, color="black", linestyle=dashes, linewidth=width
                )
        _draw_tested_frame(panel, fit_by_oil[oil], pressure_gpa, temperature_c)
        panel.axes.grid(False)
        for series_name, values in (("mu", mu), ("lambda", lambda_ratio)):
            panel.record(
                series_name, speed_mesh.ravel(), slip_mesh.ravel(), oil=oil, value=values.ravel()
            )
    style.log_ticks(sheet.axes_of_panels[0].xaxis, _SPEED_TICKS)
    style.log_ticks(sheet.axes_of_panels[0].yaxis, _SLIP_TICKS)
    sheet.axes_of_panels[0].set(xlim=(speed[0], speed[-1]), ylim=(slip[0], slip[-1]))
    sheet.label_axes("U (m/s)", style.CONDITION_LABELS["slide_roll_ratio"])
    bar = sheet.colour_bar(image, style.TRACTION_LABEL, ticks=mu_levels)
    bar.yaxis.set_major_formatter("{x:g}")
    bar.minorticks_off()
    frame_handle = Rectangle((0, 0), 1, 1, label="tested", **_TESTED_FRAME)
    title = style.level_phrases({"inlet_temperature_c": temperature_c})
    sheet.legend([*handle_by_label.values(), frame_handle], title)
    return sheet


def _fit_by_oil(results: CampaignTables) -> dict[str, FittedLaw]:
    """The configured law of each oil that has one of pressure, speed and temperature."""
    configured = results.configured_fits
    fit_by_oil = {}
    for oil in configured.coefficients["oil"].unique():
        fit = FittedLaw.from_tables(configured.coefficients, oil, quality=configured.fit_quality)
        if not reason_without_value(fit):
            fit_by_oil[str(oil)] = fit
    return fit_by_oil


def _draw_tested_frame(
    panel: Panel, fit: FittedLaw, pressure_gpa: float, temperature_c: float
) -> None:
    """Draw a frame round the tested speeds and slips, if pressure and temperature were tested.

    The tested ranges are widened by what runs may miss their set points.
    """
    pressures, speeds, temperatures, slips = fit.widened_box
    pressure_tested = pressures[0] * 0.99 <= pressure_gpa <= pressures[1] * 1.01
    temperature_tested = temperatures[0] - 1 <= temperature_c <= temperatures[1] + 1
    if pressure_tested and temperature_tested:
        # an axis of logarithms has no zero: the frame begins at its lower end
        lower_end, _ = panel.axes.get_ylim()
        width = speeds[1] - speeds[0]
        height = slips[1] - lower_end
        panel.axes.add_patch(Rectangle((speeds[0], lower_end), width, height, **_TESTED_FRAME))


def _levels_up_to(highest: float) -> FloatArray:
    """Levels of mu in steps of 1, 2, 3 and 5 that cover two decades up to the highest value.

    A value above 5 is that of a law far beyond its tests: the highest level is 5.
    """
    decades = 10.0 ** np.arange(-6, 1)
    levels = np.outer(decades, (1, 2, 3, 5)).ravel()
    highest = min(highest, levels[-1])
    first_index = np.searchsorted(levels, highest / 100)
    last_index = np.searchsorted(levels, highest)
    return levels[first_index : last_index + 1]


@declare_figure(family="data", tables=("points", "runs"), settings=("figures", "gates", "oils"))
def stribeck(results: CampaignTables, settings: Settings) -> Sheet:
    """Traction against film thickness.

    Traction coefficient of the accepted points nearest to one slide-roll ratio, one panel per
    oil, against the ratio of film thickness to roughness. Colour: maximum Hertz pressure. A line
    joins the runs of one pressure and temperature; speed rises along it. Its temperature is written
    at the slowest run of the oil's highest pressure. Dashed line: limit of a full film.
    """
    level = settings.figures.stribeck.slide_roll_ratio
    parts = results.blocks_of_runs("points", [*CURVE_COLUMNS, "lambda_ratio"])
    points = pd.concat(_points_near_slip(part, level) for part in parts)
    points = points.dropna(subset="lambda_ratio")
    points = _with_levels(points, results.runs)
    sheet, panels = oil_grid(
        style.oils_in(points, settings),
        "No accepted point near this slide-roll ratio has a known film:\n"
        "give the properties of the oil and the geometry of the rig.",
        height=1.9,
    )
    pressures = sorted(points["level_gpa"].unique())
    colours = _colour_by_pressure(pressures)
    limit = settings.gates.lambda_limit
    for panel, _, oil in panels:
        points_of_oil = points[points["oil"] == oil]
        for pressure in pressures:
            points_of_pressure = points_of_oil[points_of_oil["level_gpa"] == pressure]
            look: style.Look = {"color": colours[pressure], "linewidth": 0.8}
            for temperature, line in points_of_pressure.groupby("level_c"):
                by_speed = line.sort_values("entrainment_speed_m_s")
                lambda_ratio = by_speed["lambda_ratio"]
                mu = by_speed["traction_coefficient"].abs()
                panel.axes.plot(lambda_ratio, mu, marker="o", markersize=2.5, **look)
                panel.record(
                    "measured",
                    lambda_ratio,
                    mu,
                    oil=oil,
                    value=by_speed["max_hertz_pressure_gpa"],
                    label=by_speed["run_id"],
                )
                if pressure == points_of_oil["level_gpa"].max():
                    # to the left of the highest pressure nothing else is drawn
                    panel.axes.annotate(
                        f"{temperature:.0f} °C",
                        (lambda_ratio.iloc[0], mu.iloc[0]),
                        (-3, 0),
                        textcoords="offset points",
                        fontsize=5,
                        ha="right",
                        va="center",
                        bbox={"color": "white", "pad": 0.3},
                    )
        panel.axes.set_xscale("log")
        style.log_ticks(panel.axes.xaxis, _LAMBDA_TICKS)
        panel.axes.axvline(limit, color="black", linestyle="--")
    sheet.axes_of_panels[0].set_ylim(bottom=0)
    # room for the temperatures at the left
    sheet.axes_of_panels[0].set_xlim(left=0.6 * min(limit, points["lambda_ratio"].min()))
    sheet.label_axes(style.LAMBDA, f"{style.MU} at S = {level:g}")
    handles = [
        style.line_handle(f"P = {pressure:.3g} GPa", color=colours[pressure])
        for pressure in pressures
    ]
    full_film = f"{style.LAMBDA} = {limit:g}: full film to the right of it"
    handles.append(style.line_handle(full_film, color="black", linestyle="--"))
    sheet.legend(handles)
    return sheet


def _with_levels(points: pd.DataFrame, runs: pd.DataFrame) -> pd.DataFrame:
    """Points with the pressure and temperature at which their run was to be made.

    `level_gpa` and `level_c` are the set points of the run. Where it has none, they are what the
    point measured, to 0.05 GPa and to whole degrees.
    """
    set_points = runs.set_index("run_id").reindex(points["run_id"])
    pressure = set_points["nominal_max_hertz_pressure_gpa"].to_numpy()
    temperature = set_points["nominal_inlet_temperature_c"].to_numpy()
    measured_gpa = points["max_hertz_pressure_gpa"].to_numpy()
    measured_c = points["inlet_temperature_c"].to_numpy()
    rounded_gpa = np.round(measured_gpa * 20) / 20
    return points.assign(
        level_gpa=np.where(np.isfinite(pressure), pressure, rounded_gpa),
        level_c=np.where(np.isfinite(temperature), temperature, np.round(measured_c)),
    )


def _colour_by_pressure(pressures: Sequence[float]) -> dict[float, Any]:
    """A colour of viridis for each pressure; the highest pressure has the darkest one."""
    # the yellow end is too light on white
    shades = np.linspace(0.85, 0.0, len(pressures))
    return dict(zip(pressures, colormaps["viridis"](shades), strict=True))


def _points_near_slip(points: pd.DataFrame, slide_roll_ratio: float) -> pd.DataFrame:
    """The accepted point of each run that is nearest to a slip, if within a quarter of the slip."""
    accepted = points[points["accepted"]]
    distance = (accepted["slide_roll_ratio"].abs() - slide_roll_ratio).abs()
    near = accepted.assign(distance=distance)[distance <= 0.25 * slide_roll_ratio]
    return near.loc[near.groupby("run_id")["distance"].idxmin()]


@declare_figure(
    family="data",
    tables=("points", "runs", "coefficients", "fit_quality"),
    settings=("figures", "oils", "rigs"),
)
def isothermal(results: CampaignTables, settings: Settings) -> Sheet:
    """Traction curves without their own heat.

    Traction coefficient against slide-roll ratio, one panel per oil, at the set points of one
    temperature and one speed, by maximum Hertz pressure. Open symbols: measured. Filled
    symbols: corrected to a film as cold as its inlet. The film is hotter than the inlet by the
    flash temperature of both bodies (Archard 1959) and the conduction across the film (Carslaw
    and Jaeger 1959). The fitted law says what a test with an inlet colder by that rise, with
    the same film thickness and sliding speed, would have shown: the measured value is
    multiplied by the law at that test over the law at this one. Points are left out where that
    test would be colder than the tests, slower than 0.7 of the lowest tested speed or beyond the
    largest slip by as much. They are also left out where the result is impossible: the traction
    grows by more than the oil's viscosity does (Barus), or faster than in proportion to the slip.
    A run on a rig whose contact is not known has no filled symbols.
    """
    figure_settings = settings.figures.isothermal
    fit_by_oil = _fit_by_oil(results)
    contact_of_rig = {name: rig.contact() for name, rig in settings.rigs.items()}
    reason = "The heat of no contact is known:\ngive rig, oil and a fitted law."
    if all(contact is None for contact in contact_of_rig.values()):
        raise NothingToDrawError(reason)
    rig_of_run = results.table("runs", ["run_id", "rig"]).set_index("run_id")["rig"]
    oils = [oil for oil in settings.oils if oil in fit_by_oil and settings.properties_of(oil)]
    sheet, panels = oil_grid(oils, reason, height=1.9)
    marker_of_pressure: dict[float, str] = {}
    for panel, _, oil in panels:
        colour = style.oil_colour(oil, list(settings.oils))
        for run_id, curve in _points_at_conditions(results, oil, figure_settings).groupby("run_id"):
            # to steps of 0.05 GPa
            pressure = 0.05 * round(20 * float(curve["max_hertz_pressure_gpa"].mean()))
            next_marker = style.MARKERS[len(marker_of_pressure) % len(style.MARKERS)]
            marker = marker_of_pressure.setdefault(pressure, next_marker)
            filled: style.Look = {"marker": marker, "color": colour}
            open_symbol: style.Look = {
                "marker": marker,
                "color": colour,
                "markerfacecolor": "white",
            }
            details = {"oil": oil, "label": str(run_id)}
            slip = curve["slide_roll_ratio"].abs()
            measured = curve["traction_coefficient"].abs()
            panel.dots("measured", slip, measured, open_symbol, **details)
            contact = contact_of_rig[rig_of_run[run_id]]
            if contact is None:
                continue
            corrected = without_heat(curve, fit_by_oil[oil], contact, settings)
            isothermal_mu = corrected["traction_coefficient"].abs()
            rise_k = corrected["rise_k"]
            panel.dots("isothermal", slip, isothermal_mu, filled, value=rise_k, **details)
        if not panel.axes.lines:
            panel.write_message("no accepted point here\n(config: figures, isothermal)")
    sheet.axes_of_panels[0].set(xlim=(0, None), ylim=(0, None))
    sheet.label_axes(style.CONDITION_LABELS["slide_roll_ratio"], style.TRACTION_LABEL)
    grey: style.Look = {"color": style.GREY}
    handles = [
        style.symbol_handle(f"P = {pressure:.3g} GPa", marker, **grey)
        for pressure, marker in sorted(marker_of_pressure.items())
    ]
    handles.append(style.symbol_handle("measured", "o", markerfacecolor="white", **grey))
    handles.append(style.symbol_handle("isothermal", "o", **grey))
    conditions_shown = figure_settings.model_dump(
        include={"entrainment_speed_m_s", "inlet_temperature_c"}
    )
    sheet.legend(handles, style.level_phrases(conditions_shown))
    return sheet


def _points_at_conditions(results: CampaignTables, oil: str, figure_settings: Any) -> pd.DataFrame:
    """Accepted points of an oil at the chosen speed and temperature, of known pressure."""
    points = results.table("points", CURVE_COLUMNS, oil=oil)
    points_of_oil = points[points["accepted"]].dropna(subset=["max_hertz_pressure_gpa"])
    means = points_of_oil.groupby("run_id")[list(CONDITIONS)].transform("mean")
    relative_speed = means["entrainment_speed_m_s"] / figure_settings.entrainment_speed_m_s - 1
    temperature_difference_c = means["inlet_temperature_c"] - figure_settings.inlet_temperature_c
    same_speed = relative_speed.abs() < figure_settings.same_within
    same_temperature = temperature_difference_c.abs() < figure_settings.same_temperature_c
    return points_of_oil[same_speed & same_temperature]


def without_heat(
    curve: pd.DataFrame, fit: FittedLaw, contact: Contact, settings: Settings
) -> pd.DataFrame:
    """mu of points with a film as cold as their inlet, and the heating of that film (`rise_k`).

    A test with a colder inlet T*, a lower speed U* and a larger slip S* has the same film thickness
    and sliding speed, and its film is as hot as the inlet was:

        T* + dT(T*, U*, S*) = T,   h(T*, U*) = h(T, U),   S* U* = S U
        mu_isothermal = mu law(T*, U*, S*)/law(T, U, S)

    mu is NaN where that test is colder than the tests, much slower, or at much more slip. It is
    NaN as well where no film can have it: beyond the ratio of the viscosities at inlet and film
    temperature, which a Newtonian film reaches, and from the slip on at which mu/S rises. A law
    that holds no heat makes such values.

    Args:
        curve: Rows of the table of points, of one oil.
        fit: The fitted law of pressure, speed and temperature.
        contact: Geometry and stiffness of the rig's contact.
        settings: Settings of the campaign.
    """
    figure_settings = settings.figures.isothermal
    oil = settings.oil_with_properties(str(curve["oil"].iloc[0]))
    load_n = curve["load_n"].to_numpy(dtype=float)
    pressure = curve["max_hertz_pressure_gpa"].to_numpy(dtype=float)
    speed = curve["entrainment_speed_m_s"].to_numpy(dtype=float)
    temperature = curve["inlet_temperature_c"].to_numpy(dtype=float)
    slip = curve["slide_roll_ratio"].to_numpy(dtype=float)
    mu = curve["traction_coefficient"].to_numpy(dtype=float)
    _, speeds, temperatures, slips = fit.widened_box
    coldest = temperatures[0]
    slowest = _EXTRAPOLATION_SHARE * speeds[0]
    largest_slip = slips[1] / _EXTRAPOLATION_SHARE
    radius = np.asarray(contact.radius_m)

    def film_state(speed: FloatArray, inlet_c: FloatArray) -> tuple[InletOil, Conditions]:
        """Oil and conditions of each point at other speeds and inlet temperatures."""
        conditions = Conditions(
            load_n, pressure, speed, inlet_c, radius, contact.reduced_modulus_pa
        )
        return InletOil.from_oil(oil, inlet_c), conditions

    def mu_by_law(speed: FloatArray, inlet_c: FloatArray, slip: FloatArray) -> FloatArray:
        """mu of the fitted law at other speeds, inlet temperatures and slips."""
        conditions = np.column_stack([pressure, speed, inlet_c])
        return fit.predict(conditions, slip).traction_coefficient

    measured_film_m = film_thickness(*film_state(speed, temperature), slip, "central")
    law_mu = mu_by_law(speed, temperature, slip)
    # without slip there is no traction, and nothing to correct
    has_no_traction = law_mu == 0
    divisor = np.where(has_no_traction, 1.0, law_mu)
    cold_mu = mu
    cold_speed = speed
    rise_k = np.zeros_like(mu)
    for _ in range(_ITERATION_COUNT):
        cold_inlet_c = np.maximum(temperature - rise_k, coldest)
        cold_state = film_state(cold_speed, cold_inlet_c)
        cold_slip = np.clip(slip * speed / cold_speed, -largest_slip, largest_slip)
        cold_film_m = film_thickness(*cold_state, cold_slip, "central")
        # beyond its range the thermal reduction gives no film
        cold_film_m = np.where(cold_film_m > 0, cold_film_m, np.nan)
        cold_speed = cold_speed * (measured_film_m / cold_film_m) ** _SPEED_PER_FILM
        cold_speed = np.maximum(cold_speed, slowest)
        previous_rise_k = rise_k
        rise_k = mean_film_temperature_rise(
            *cold_state,
            cold_mu,
            cold_slip,
            figure_settings.solid_conductivity_w_mk,
            figure_settings.solid_volumetric_heat_j_m3k,
        )
        cold_law_mu = mu_by_law(cold_speed, cold_inlet_c, cold_slip)
        cold_mu = mu * np.where(has_no_traction, 1.0, cold_law_mu / divisor)
    measured_rise_k = mean_film_temperature_rise(
        *film_state(speed, temperature),
        mu,
        slip,
        figure_settings.solid_conductivity_w_mk,
        figure_settings.solid_volumetric_heat_j_m3k,
    )
    viscosity_ratio = film_viscosity_ratio(oil, pressure, temperature, measured_rise_k)
    is_possible = np.abs(cold_mu) <= viscosity_ratio * np.abs(mu)
    # the law in place of the readings, whose scatter at low slip says nothing of the correction
    with np.errstate(divide="ignore", invalid="ignore"):
        is_possible &= ~_is_beyond_rising_slope(slip, law_mu * cold_mu / mu)
    # inlet and heat do not agree where the heating of the film grows without end
    is_steady = np.abs(rise_k - previous_rise_k) <= 0.01 * np.abs(rise_k)
    is_known = is_steady & (temperature - rise_k >= coldest) & (cold_speed > slowest)
    is_known &= np.abs(cold_slip) < largest_slip
    is_known &= is_possible
    return pd.DataFrame(
        {"traction_coefficient": np.where(is_known, cold_mu, np.nan), "rise_k": rise_k}
    )


def _is_beyond_rising_slope(slip: FloatArray, mu: FloatArray) -> BoolArray:
    """Whether each point of a curve is at or beyond the slip at which mu/S begins to rise."""
    order = np.argsort(np.abs(slip), kind="stable")
    is_sliding = slip[order] != 0
    slope = np.full(len(slip), np.inf)
    slope[is_sliding] = np.abs(mu[order][is_sliding] / slip[order][is_sliding])
    smallest_before = np.fmin.accumulate(np.r_[np.inf, slope])[:-1]
    is_rising = slope > (1 + _SCATTER_OF_SLOPE) * smallest_before
    is_beyond = np.empty(len(slip), dtype=bool)
    is_beyond[order] = np.logical_or.accumulate(is_rising)
    return is_beyond
