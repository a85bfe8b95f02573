"""What the fits are worth, and what they say to a tribologist.

Constants, how well data tell them apart, errors of all laws; mu over speed and slip, mu over film
or Hersey number, heat removed.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.patches import Rectangle
from matplotlib.ticker import LogLocator, MaxNLocator, NullFormatter

from oilfilm import tables
from oilfilm.base.units import FloatArray
from oilfilm.fits.fit import laws_of
from oilfilm.fits.fitted import FittedLaw
from oilfilm.fits.problem import curve_data
from oilfilm.physics.contact import Conditions, Contact
from oilfilm.physics.film import InletOil, film_thickness
from oilfilm.physics.thermal_traction import mean_film_rise
from oilfilm.report.document import number, significant
from oilfilm.report.figures import style
from oilfilm.report.figures.sheet import (
    NothingToDrawError,
    Panel,
    Sheet,
    oil_grid,
    register,
    table_page,
)
from oilfilm.report.words import law_name
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.torque.operating_grid import Grid, films, obstacle, traction
from oilfilm.traction import LAWS
from oilfilm.traction.law import CONDITIONS, QUANTITIES, Law

_ROW_IN = 0.17
_ENDS = ("pressure", "speed", "temperature")
# Kinds of error, from those on the fitted curves themselves to the farthest: how each is drawn.
_KINDS: dict[str, style.Look] = {
    "fitted curves": {"marker": "o", "markersize": 3.4},
    "curve left out": {"marker": "D", "markersize": 3.4},
    "end level left out": {"marker": "^", "markersize": 4},
}


@register(family="law", tables=("coefficients",), settings=("oils",))
def constants(results: CampaignTables, settings: Settings) -> Sheet:
    """Fitted constants.

    Fitted constants of the traction law for each oil, with their standard errors from a
    bootstrap over curves; none where there are too few.
    """
    table = results.configured.coefficients.assign(printed_value=np.nan)
    return draw_constants(table, list(settings.oils))


def draw_constants(table: pd.DataFrame, oils: Sequence[str], note: str = "") -> Sheet:
    """A table of constants, one group of columns per oil.

    Args:
        table: Table of coefficients with the column `printed_value`, which is shown where it is
            known.
        oils: Oils of the campaign.
        note: What `printed_value` is, for the lines below.
    """
    # a constant that no oil has, neither fitted nor printed, is no row
    shown = table.dropna(subset=["value", "printed_value"], how="all")
    names = list(dict.fromkeys(shown["constant"])) or ["no constants"]
    any_printed = bool(shown["printed_value"].notna().any())
    left = 0.12 if len(oils) == 1 else 0.06
    span = (1 - left) / len(oils)
    width = style.SINGLE_COLUMN_IN if len(oils) == 1 else style.DOUBLE_COLUMN_IN
    notes = [_powers(LAWS[name]) for name in table["law"].unique()]
    notes += [note] if any_printed else []
    sheet, panel, write = table_page(width, len(names), _ROW_IN, 2 * _ROW_IN, notes)
    write(0, "", names, fontweight="bold")
    for place, oil in enumerate(oils):
        name: style.Look = {"color": style.oil_colour(oil, oils), "fontweight": "bold"}
        write(left + (place + 0.53) * span, f"{oil}\n", [], ha="center", **name)
        rows = table[table["oil"] == oil].set_index("constant").reindex(names)
        for share, (head, texts) in _of_oil(rows).items():
            at, grey = left + (place + share) * span, {"color": style.GREY}
            write(at, f"\n{head}", texts, grey, ha="right")
    about = {"oil": table["oil"], "label": table["constant"]}
    error = table["standard_error"]
    ends = {"lower": table["value"] - error, "upper": table["value"] + error}
    panel.keep("fitted", np.nan, value=table["value"], **ends, **about)
    if any_printed:
        panel.keep("printed", np.nan, value=table["printed_value"], **about)
    return sheet


def _powers(law: Law) -> str:
    """What the constants of a law are powers of."""
    powers = ", ".join(
        f"{QUANTITIES[group].symbol} over {reference:g} {QUANTITIES[group].unit}"
        for group, reference in zip(law.groups, law.reference, strict=True)
    )
    return f"{law_name(law.name)}: {powers}"


def _of_oil(rows: pd.DataFrame) -> dict[float, tuple[str, list[str]]]:
    """Head and texts of each column of one oil, by its place within the oil's width."""
    # digits beyond the second of the error say nothing
    forms = list(map(significant, rows["standard_error"].fillna(rows["naive_standard_error"])))

    def texts(column: str, forms: Sequence[str]) -> list[str]:
        return [number(form)(value) for value, form in zip(rows[column], forms, strict=True)]

    fitted = "fitted", texts("value", forms)
    errors = "\N{PLUS-MINUS SIGN} s.e.", texts("standard_error", forms)
    if rows["printed_value"].isna().all():
        return {0.5: fitted, 0.97: errors}
    # what is printed has every digit of the print
    printed = "printed", texts("printed_value", [".10g"] * len(rows))
    return {0.29: fitted, 0.59: errors, 0.98: printed}


@register(family="law", tables=("correlations",), settings=("oils",))
def identifiability(results: CampaignTables, settings: Settings) -> Sheet:
    """Identifiability of the constants.

    Correlation of each pair of constants, by the bootstrap over curves or, with too few curves,
    by the Jacobian. Near 1 or -1 the two constants replace each other.
    """
    correlations = results.configured.correlations
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
        field = pairs.pivot(index="other", columns="constant", values="correlation")
        # from orange by white to purple, distinct for every kind of colour vision
        squares = field.reindex(index=names, columns=names).to_numpy(dtype=float)
        image = panel.axis.imshow(squares, cmap="PuOr", vmin=-1, vmax=1)
        panel.axis.set_xticks(range(len(names)), names, rotation=90, fontsize=6)
        panel.axis.set_yticks(range(len(names)), names, fontsize=6)
        panel.axis.grid(False)
        panel.axis.tick_params(length=0)
        label = pairs["constant"] + ", " + pairs["other"]
        panel.keep("correlation", np.nan, oil=oil, label=label, value=pairs["correlation"])
    sheet.colour_bar(image, "Correlation")
    return sheet


@register(family="law", tables=("fit_quality",), settings=("oils",))
def law_errors(results: CampaignTables, settings: Settings) -> Sheet:
    """Errors of the laws.

    Rms error of each law over the rms of the measured traction coefficient: on fitted curves, on
    curves left out, and on the lowest and highest levels of pressure, speed and temperature left
    out. Open symbols: fit not certified (the table of the comparison says why). The groups and
    readings of the Wang-Deng laws are ours.
    """
    compared, oils = results.fit_quality.dropna(subset="rmse"), list(settings.oils)
    laws = list(dict.fromkeys(compared["law"]))
    if not laws:
        raise NothingToDrawError("no law could be fitted")
    sheet = Sheet(width=style.DOUBLE_COLUMN_IN, left=1.75, height=0.34 * len(laws) + 0.1)
    panel = sheet.panel(title=None)
    for fit in tables.rows(compared):
        # laws are apart by one, their oils by so much that many stay within their law
        among = oils.index(fit["oil"]) - (len(oils) - 1) / 2
        _draw_errors(panel, fit, laws.index(fit["law"]) + among * min(0.24, 0.8 / len(oils)), oils)
    axis = panel.axis
    axis.set_yticks(range(len(laws)), map(law_name, laws))
    axis.set(ylim=(len(laws) - 0.45, -0.55), xscale="log")
    axis.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    # decimals as each level needs them: 0.2 %, 100 %
    axis.xaxis.set_major_formatter(lambda value, _: f"{100 * value:.3g}%")
    axis.xaxis.set_minor_formatter(NullFormatter())
    axis.grid(visible=False, axis="y")
    axis.set_xlabel(f"Rms error over rms of measured {style.MU}")
    white: style.Look = {"color": "black", "markerfacecolor": "white", "linestyle": ""}
    kinds = [style.line_handle(kind, **white, **look) for kind, look in _KINDS.items()]
    sheet.legend([*style.oil_patches(style.oils_in(compared, settings), oils), *kinds])
    return sheet


def starts_of(results: CampaignTables, oil: str, law_key: str, settings: Settings) -> pd.DataFrame:
    """mu at no slip of each curve (`run_id`, `y`), in the order of rising temperature."""
    fits = results.coefficients
    of_fit = (fits["oil"] == oil) & (fits["law"] == law_key)
    if fits.loc[of_fit, "value"].isna().all():
        return pd.DataFrame({"run_id": [], "y": []})
    law = laws_of(oil, settings)[law_key]
    data = curve_data(results.points[results.points["oil"] == oil], law.conditions)
    fitted = FittedLaw.from_tables(fits, oil, law=law)
    y = fitted.predict(data.conditions, np.zeros(len(data.runs))).traction_coefficient
    order = np.argsort(data.conditions[:, -1], kind="stable")
    return pd.DataFrame({"run_id": data.runs, "y": y}).iloc[order]


def _draw_errors(panel: Panel, fit: Mapping[str, Any], height: float, oils: Sequence[str]) -> None:
    """Each kind of error of one fit, on a line from the smallest to the largest."""
    colour = style.oil_colour(fit["oil"], oils)
    left_out = fit["left_out_rmse"] * fit["relative_rms"] / fit["rmse"]
    ends = [fit[f"{end}_end_out_relative_rms"] for end in _ENDS]
    errors = [fit["relative_rms"]], [left_out], ends
    line = [np.nanmin(np.concatenate(errors)), np.nanmax(np.concatenate(errors))]
    panel.axis.plot(line, [height] * 2, color=colour, linewidth=0.6)
    face = {"color": colour, "markerfacecolor": colour if fit["certified"] else "white"}
    label = fit["law"] if fit["certified"] else f"{fit['law']}, not certified"
    for (kind, look), values in zip(_KINDS.items(), errors, strict=True):
        known = np.array(values)[~np.isnan(values)]
        panel.dots(
            kind, known, np.full(len(known), height), face | look, oil=fit["oil"], label=label
        )


def symbol_of(fit: Mapping[str, Any], oils: Sequence[str]) -> style.Look:
    """Symbol of an oil, open where the fit is not certified."""
    look = style.oil_look(fit["oil"], oils)
    face = look["color"] if fit["certified"] else "white"
    return {**look, "markerfacecolor": face, "linestyle": ""}


_STEPS = 41  # along each axis of a map
_EXTRAPOLATED = 0.7  # of the lowest tested speed, and of 1 over the largest slip
_ROUNDS = 30  # in which a colder inlet and the heat of its film come to agree
_SPEED_TICKS = (1, 2, 5, 10, 20, 50, 100, 200)
_SLIP_TICKS = (0.001, 0.003, 0.01, 0.03, 0.1, 0.3)
_FILM_TICKS = (0.5, 1, 2, 5, 10, 20, 50, 100)


@register(
    family="law",
    tables=("coefficients", "fit_quality"),
    settings=("figures", "film", "gates", "oils", "rigs"),
)
def friction_map(results: CampaignTables, settings: Settings) -> Sheet:
    """Friction map.

    Traction coefficient of the fitted law (colour) over entrainment speed (m/s) and slide-roll
    ratio, one column of panels per oil and one row per maximum Hertz pressure, at one inlet
    temperature. Dotted line: limiting shear stress of the oil over pressure (Bair and Winer
    1979); no film carries more. Dashed line: limit of lambda, below which the film is not full.
    Frame: tested conditions.
    """
    choice, laws = settings.figures.friction_map, _laws(results)
    pressures, temperature = choice.max_hertz_pressure_gpa, choice.inlet_temperature_c
    sheet, panels = oil_grid(
        list(laws),
        "No oil has a fitted law of pressure, speed and temperature.",
        list(enumerate(pressures)),
        lambda row, oil: f"{oil}, {row[1]:g} GPa",
        **{"height": 1.55, "right": 0.75, "across": 0.25, "width": style.DOUBLE_COLUMN_IN},
    )
    ranges = choice.entrainment_speed_m_s, choice.slide_roll_ratio
    speed, slip = (np.geomspace(low, high, _STEPS) for low, high in ranges)
    grid = Grid(np.array(pressures), speed, np.array([temperature]), slip)
    mesh, limit = np.meshgrid(speed, slip), settings.gates.lambda_limit
    mu = {oil: traction(law, grid) for oil, law in laws.items()}
    over_roughness = {oil: film.over(grid)[1] for oil, film in films(settings).items()}
    highest, handles = max(float(np.nanmax(field)) for field in mu.values()), dict[str, Any]()
    levels = MaxNLocator(20).tick_values(0, highest)
    for panel, (row, pressure), oil in panels:
        panel.axis.set(xscale="log", yscale="log")
        field = mu[oil][row, :, 0].T
        lambda_ratio = np.full_like(field, np.nan)
        if oil in over_roughness:
            lambda_ratio = over_roughness[oil][row, :, 0].T
        image = panel.axis.contourf(speed, slip, field, levels)
        most = laws[oil].coefficients.limiting_stress_ratio
        for label, of_line, level, dashes, width in (
            ("limiting shear stress", field, most, ":", 1.6),
            (f"lambda = {limit:g}", lambda_ratio, limit, "--", 0.9),
        ):
            look: style.Look = {"colors": "black", "linestyles": dashes, "linewidths": width}
            drawn = panel.axis.contour(speed, slip, of_line, [level], **look)
            if any(len(path) for path in drawn.get_paths()):
                look = {"color": "black", "linestyle": dashes, "linewidth": width}
                handles[label] = style.line_handle(label, **look)
        _frame(panel, laws[oil], pressure, temperature)
        panel.axis.grid(False)
        for series, values in (("mu", field), ("lambda", lambda_ratio)):
            panel.keep(series, mesh[0].ravel(), mesh[1].ravel(), oil=oil, value=values.ravel())
    style.log_ticks(sheet.axes[0].xaxis, _SPEED_TICKS)
    style.log_ticks(sheet.axes[0].yaxis, _SLIP_TICKS)
    sheet.axes[0].set(xlim=(speed[0], speed[-1]), ylim=(slip[0], slip[-1]))
    sheet.label("U (m/s)", style.CONDITION_LABELS["slide_roll_ratio"])
    sheet.colour_bar(image, style.TRACTION_LABEL)
    look = {"facecolor": "#3b528b", "edgecolor": "white", "label": "white frame: tested"}
    tested = Rectangle((0, 0), 1, 1, **look)
    at = style.level_phrases({"inlet_temperature_c": temperature})
    sheet.legend([*handles.values(), tested], at)
    return sheet


def _laws(results: CampaignTables) -> dict[str, FittedLaw]:
    """The configured law of each oil that has one of pressure, speed and temperature."""
    fits = results.configured
    laws = {
        str(oil): FittedLaw.from_tables(fits.coefficients, oil, quality=fits.fit_quality)
        for oil in fits.coefficients["oil"].unique()
    }
    return {oil: law for oil, law in laws.items() if not obstacle(law)}


def _frame(panel: Panel, law: FittedLaw, pressure: float, temperature: float) -> None:
    """The tested speeds and slips, where pressure and temperature were tested as well."""
    (least_p, most_p), (slow, fast), (cold, hot), (_, slip) = law.reach
    if least_p * 0.99 <= pressure <= most_p * 1.01 and cold - 1 <= temperature <= hot + 1:
        low = panel.axis.get_ylim()[0]
        frame = Rectangle((slow, low), fast - slow, slip - low, fill=False, edgecolor="white")
        panel.axis.add_patch(frame)


@register(family="data", tables=("points",), settings=("figures", "gates", "oils"))
def stribeck(results: CampaignTables, settings: Settings) -> Sheet:
    """Traction against film thickness.

    Traction coefficient of the accepted points nearest to one slide-roll ratio, one panel per
    oil, against lambda (film thickness over roughness). Colour: maximum Hertz pressure (GPa).
    Dashed line: limit of lambda for a full film.
    """
    level = settings.figures.stribeck.slide_roll_ratio
    points = _of_one_slip(results.points, level).dropna(subset="lambda_ratio")
    sheet, panels = oil_grid(
        style.oils_in(points, settings),
        "No accepted point near this slide-roll ratio has a known film:\n"
        "give the properties of the oil and the geometry of the rig.",
        height=1.9,
        right=0.75,
    )
    pressure = points["max_hertz_pressure_gpa"]
    for panel, _, oil in panels:
        of_oil = points[points["oil"] == oil]
        xy = of_oil["lambda_ratio"], of_oil["traction_coefficient"].abs()
        colour = of_oil["max_hertz_pressure_gpa"]
        span: style.Look = {"vmin": pressure.min(), "vmax": pressure.max(), "linewidths": 0}
        dots = panel.axis.scatter(*xy, c=colour, s=9, cmap="viridis_r", **span)
        panel.keep("measured", *xy, oil=oil, value=colour, label=of_oil["run_id"])
        panel.axis.set_xscale("log")
        panel.axis.set_ylim(bottom=0)
        style.log_ticks(panel.axis.xaxis, _FILM_TICKS)
        panel.axis.axvline(settings.gates.lambda_limit, color="black", linestyle="--")
    sheet.label("lambda", f"{style.MU} at S = {level:g}")
    sheet.colour_bar(dots, "Maximum Hertz pressure (GPa)")
    return sheet


def _of_one_slip(points: pd.DataFrame, slide_roll_ratio: float) -> pd.DataFrame:
    """Of each run the accepted point nearest to a slip, where it is within a quarter of it."""
    accepted = points[points["accepted"]]
    off = (accepted["slide_roll_ratio"].abs() - slide_roll_ratio).abs()
    near = accepted.assign(off=off)[off <= 0.25 * slide_roll_ratio]
    return near.loc[near.groupby("run_id")["off"].idxmin()]


@register(
    family="data",
    tables=("points", "coefficients", "fit_quality"),
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
    multiplied by the law at that test over the law at this one. Points whose test would be
    colder than the tests, slower than 0.7 of the lowest tested speed or beyond the largest slip
    by as much are left out.
    """
    choice, laws = settings.figures.isothermal, _laws(results)
    contact = next(filter(None, (rig.contact() for rig in settings.rigs.values())), None)
    nothing = "The heat of no contact is known:\ngive rig, oil and a fitted law."
    if contact is None:
        raise NothingToDrawError(nothing)
    oils = [oil for oil in settings.oils if oil in laws and settings.properties_of(oil)]
    sheet, panels = oil_grid(oils, nothing, height=1.9)
    levels: dict[float, str] = {}
    for panel, _, oil in panels:
        for run, curve in _curves_of(results.points, oil, choice).groupby("run_id"):
            pressure = 0.05 * round(20 * float(curve["max_hertz_pressure_gpa"].mean()))
            marker = levels.setdefault(pressure, style.MARKERS[len(levels) % len(style.MARKERS)])
            corrected = without_heat(curve, laws[oil], contact, settings)
            about: style.Look = {"oil": oil, "label": str(run)}
            look = {"marker": marker, "color": style.oil_colour(oil, list(settings.oils))}
            x = curve["slide_roll_ratio"].abs()
            measured = curve["traction_coefficient"].abs()
            panel.dots("measured", x, measured, look | {"markerfacecolor": "white"}, **about)
            y = corrected["traction_coefficient"].abs()
            panel.dots("isothermal", x, y, look, value=corrected["rise_k"], **about)
        if not panel.axis.lines:
            panel.say("no accepted point here\n(config: figures, isothermal)")
    sheet.axes[0].set(xlim=(0, None), ylim=(0, None))
    sheet.label(style.CONDITION_LABELS["slide_roll_ratio"], style.TRACTION_LABEL)
    grey: style.Look = {"color": style.GREY}
    pressures = [(f"P = {pressure:.3g} GPa", marker) for pressure, marker in sorted(levels.items())]
    handles = [style.symbol_handle(*of_level, **grey) for of_level in pressures]
    handles.append(style.symbol_handle("measured", "o", markerfacecolor="white", **grey))
    handles.append(style.symbol_handle("isothermal", "o", **grey))
    at = choice.model_dump(include={"entrainment_speed_m_s", "inlet_temperature_c"})
    sheet.legend(handles, style.level_phrases(at))
    return sheet


def _curves_of(points: pd.DataFrame, oil: str, choice: Any) -> pd.DataFrame:
    """Accepted points of an oil at the chosen speed and temperature."""
    of_oil = points[points["accepted"] & (points["oil"] == oil)]
    means = of_oil.groupby("run_id")[list(CONDITIONS)].transform("mean")
    speed, temperature = means["entrainment_speed_m_s"], means["inlet_temperature_c"]
    near = ((speed / choice.entrainment_speed_m_s - 1).abs() < choice.same_within) & (
        (temperature - choice.inlet_temperature_c).abs() < choice.same_temperature_c
    )
    return of_oil[near]


def without_heat(
    curve: pd.DataFrame, law: FittedLaw, contact: Contact, settings: Settings
) -> pd.DataFrame:
    """mu of points with a film as cold as their inlet, and the heat of that film (`rise_k`).

    A test with a colder inlet T*, a lower speed U* and a larger slip S* has the same film thickness
    and sliding speed, and its film is as hot as the inlet was:

        T* + dT(T*, U*, S*) = T,   h(T*, U*) = h(T, U),   S* U* = S U
        mu_isothermal = mu law(T*, U*, S*)/law(T, U, S)

    NaN where that test is colder than the tests, or much slower, or at much more slip.
    """
    choice, oil = settings.figures.isothermal, settings.known_oil(str(curve["oil"].iloc[0]))
    load_n, pressure, speed, temperature, slip, mu = (
        curve[name].to_numpy(dtype=float)
        for name in ("load_n", *CONDITIONS, "slide_roll_ratio", "traction_coefficient")
    )
    coldest, slowest = law.reach[2, 0], _EXTRAPOLATED * law.reach[1, 0]
    radius = np.asarray(contact.radius_m)

    def state(speed: FloatArray, inlet_c: FloatArray) -> tuple[InletOil, Conditions]:
        at = Conditions(load_n, pressure, speed, inlet_c, radius, contact.reduced_modulus_pa)
        return InletOil.of(oil, inlet_c), at

    def mu_by_law(speed: FloatArray, inlet_c: FloatArray, slip: FloatArray) -> FloatArray:
        conditions = np.column_stack([pressure, speed, inlet_c])
        return law.predict(conditions, slip).traction_coefficient

    wanted_m = film_thickness(*state(speed, temperature), slip, "central")
    at_inlet = mu_by_law(speed, temperature, slip)
    cold, rise, slower = mu, np.zeros_like(mu), speed
    for _ in range(_ROUNDS):
        inlet_c = np.maximum(temperature - rise, coldest)
        colder = state(slower, inlet_c)
        faster_slip = slip * speed / slower
        thickness_m = film_thickness(*colder, faster_slip, "central")
        # beyond its range the thermal reduction gives no film
        thickness_m = np.where(thickness_m > 0, thickness_m, np.nan)
        slower = np.maximum(slower * (wanted_m / thickness_m) ** (1 / 0.67), slowest)
        solids = choice.solid_conductivity_w_mk, choice.solid_volumetric_heat_j_m3k
        before, rise = rise, mean_film_rise(*colder, cold, faster_slip, *solids)
        there = mu_by_law(slower, inlet_c, faster_slip)
        # without slip there is no traction, and nothing to correct
        cold = mu * np.where(at_inlet == 0, 1.0, there / np.where(at_inlet == 0, 1.0, at_inlet))
    _, most_slip = law.reach[3]
    # in a film that runs away from its inlet the two never agree
    tested = (temperature - rise >= coldest) & (slower > slowest) & (rise - before <= 0.01 * rise)
    tested &= np.abs(faster_slip) <= most_slip / _EXTRAPOLATED
    return pd.DataFrame({"traction_coefficient": np.where(tested, cold, np.nan), "rise_k": rise})
