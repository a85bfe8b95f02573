"""Maps for a tribologist: mu over speed and slip, mu over film or Hersey number, heat removed."""

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.patches import Rectangle
from matplotlib.ticker import MaxNLocator

from oilfilm.fits.fitted import FittedLaw
from oilfilm.physics.contact import Conditions, Contact
from oilfilm.physics.film import InletOil, film_thickness
from oilfilm.physics.thermal_traction import mean_film_rise
from oilfilm.report.figures import style
from oilfilm.report.figures.sheet import NothingToDrawError, Panel, Sheet, oil_grid, register
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.torque.operating_grid import Grid, films, obstacle, traction
from oilfilm.traction.law import CONDITIONS
from oilfilm.units import FloatArray

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
        str(oil): FittedLaw.of(fits.coefficients, oil, quality=fits.fit_quality)
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
