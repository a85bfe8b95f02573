"""Planner: tests at rig conditions that most reduce the uncertainty of a bearing's torque.

The form of the law may be wrong by a few per cent, which change over the conditions. Hence tests
near the conditions of the bearing's contacts are better than a power law far from them. A rig can
run tests within its limits and sensors, with a full film.

Decides: which tests the rig can run, and which of them are chosen next.
"""

from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from oilfilm.base.errors import OilfilmError
from oilfilm.base.ties import exceeds, reaches
from oilfilm.base.units import MM_PER_M, BoolArray, FloatArray
from oilfilm.bearing.geometry import Bearing
from oilfilm.fits.fitted import FittedLaw
from oilfilm.fits.measured_curves import (
    Design,
    FormError,
    Information,
    choose,
    form_coordinates,
    measured_information,
)
from oilfilm.fits.problem import Curves
from oilfilm.physics.contact import Contact
from oilfilm.settings.config import PlanLevels, PlanSettings, PointOfTraction
from oilfilm.settings.resolved import Settings
from oilfilm.settings.rig import Rig
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.torque.bearing_torque import OilInBearing, joined, oils_in_bearings
from oilfilm.torque.operating_grid import Film, Grid
from oilfilm.traction.law import CONDITIONS, to_constants

# Smallest number of slips of a test, as many as a curve has coefficients.
_FEWEST_SLIPS = 3


@dataclass(frozen=True)
class Candidates:
    """Tests that a rig can run.

    Attributes:
        tests: One row per test: P, U, T, load, largest slip, lambda at that slip.
        curves: Points of the tests.
        left_out: Number of conditions left out, by reason.
    """

    tests: pd.DataFrame
    curves: Curves
    left_out: dict[str, int]


def candidates(
    levels: PlanLevels,
    rig: Rig,
    name: str,
    film: Film,
    lambda_limit: float,
    information: Information,
) -> Candidates:
    """The tests at the levels of a plan that a rig can run with a full film.

    A test has those slips of the measured curves that the rig and its speed sensor reach.

    Args:
        levels: Levels of the three conditions.
        rig: The rig.
        name: Name of the rig.
        film: Film of the oil in the rig's contact.
        lambda_limit: A film is full above this ratio.
        information: Information of the measured curves: the law, its constants and the slips.

    Raises:
        OilfilmError: The rig's limits are not known, or no test is left.
    """
    limits = rig.limits
    scale = rig.full_scale
    if limits is None:
        raise OilfilmError(
            f"config/rigs/{name}.yaml: lacks the key `limits`, which a plan needs. Write the "
            "highest max_hertz_pressure_gpa, entrainment_speed_m_s, inlet_temperature_c and "
            "slide_roll_ratio at which the rig can run."
        )
    grid = Grid(
        max_hertz_pressure_gpa=np.array(levels.max_hertz_pressure_gpa, dtype=float),
        entrainment_speed_m_s=np.array(levels.entrainment_speed_m_s, dtype=float),
        inlet_temperature_c=np.array(levels.inlet_temperature_c, dtype=float),
        slide_roll_ratio=information.slip,
    )
    slips_per_test = len(information.slip)
    points = grid.operating_points()
    points["load_n"] = film.contact.load_n(points["max_hertz_pressure_gpa"].to_numpy())
    tests = points.iloc[::slips_per_test].drop(columns="slide_roll_ratio").reset_index(drop=True)
    conditions = tests[list(information.law.conditions)].to_numpy(dtype=float)
    load = tests["load_n"].to_numpy()
    test_of_point = np.repeat(np.arange(len(tests)), slips_per_test)
    all_curves = Curves(conditions, load, test_of_point, points["slide_roll_ratio"].to_numpy())
    # rows are tests, columns are slips
    shape = (len(tests), slips_per_test)
    observations = all_curves.observations(information.law)
    mu = information.law.traction(information.internal, observations).reshape(shape)
    slip = points["slide_roll_ratio"].to_numpy().reshape(shape)
    _, lambda_ratio = film.over(grid)
    lambda_ratio = lambda_ratio.reshape(shape)
    pressure, speed, temperature = (tests[name].to_numpy() for name in CONDITIONS)
    reached = reaches(limits.slide_roll_ratio, slip)
    # reasons why a condition cannot be tested, in the order of the message
    beyond: dict[str, BoolArray] = {
        "the rig's largest pressure": exceeds(pressure, limits.max_hertz_pressure_gpa),
        "the rig's largest speed": exceeds(speed, limits.entrainment_speed_m_s),
        "the rig's highest temperature": exceeds(temperature, limits.inlet_temperature_c),
    }
    if scale is not None:
        reached &= reaches(scale.surface_speed_m_s, speed[:, np.newaxis] * (1 + slip / 2))
        force = (load[:, np.newaxis] * mu).max(axis=1)
        beyond |= {
            "the load sensor's full scale": exceeds(load, scale.load_n),
            "the force sensor's full scale": exceeds(force, scale.traction_force_n),
            "the temperature sensor's full scale": exceeds(temperature, scale.temperature_c),
        }
    thin = reached & ~exceeds(lambda_ratio, lambda_limit)
    beyond |= {
        "the rig's smallest load": exceeds(limits.smallest_load_n or 0.0, load),
        "slips that the rig reaches at this speed": np.asarray(reached.sum(axis=1) < _FEWEST_SLIPS),
        f"a full film (lambda > {lambda_limit:g})": np.asarray(thin.any(axis=1)),
    }
    feasible = np.ones(len(tests), dtype=bool)
    left_out = {}
    for reason, is_beyond in beyond.items():
        left_out[reason] = int((feasible & is_beyond).sum())
        feasible &= ~is_beyond
    if not feasible.any():
        counts = ", ".join(f"{reason} ({count})" for reason, count in left_out.items() if count)
        raise OilfilmError(
            f"config/rigs/{name}.yaml, plan.levels: none of {len(tests)} conditions can be run; "
            f"they are beyond {counts}. Change plan.levels, or correct the rig's limits."
        )
    last_reached = slips_per_test - 1 - np.argmax(reached[:, ::-1], axis=1)
    largest = (np.arange(len(tests)), last_reached)
    tests = tests.assign(slide_roll_ratio=slip[largest], lambda_ratio=lambda_ratio[largest])
    reached_of_feasible = reached[feasible]
    curves = Curves(
        conditions[feasible],
        load[feasible],
        np.repeat(np.arange(feasible.sum()), reached_of_feasible.sum(axis=1)),
        slip[feasible][reached_of_feasible],
    )
    return Candidates(tests[feasible].reset_index(drop=True), curves, left_out)


DUTY = ("axial_load_n", "inner_speed_rpm", "oil_temperature_c")
BEARING_TARGETS = ("torque", "cage_slip")
# Columns of the calculated results with the maximum pressure at both races.
_PRESSURES = ["inner_max_hertz_pressure_gpa", "outer_max_hertz_pressure_gpa"]
# Smallest span of the tests to choose from, in ln p, ln U and degC. A plan may have only one level
# of a condition.
_SMALLEST_SPAN = np.array([0.1, 0.1, 10.0])
# Step of the internal constants in finite differences.
_STEP = 1e-3
# Largest second difference over first difference of a smooth quantity. It is of the size of the
# step for a smooth quantity, and 1 for a jump.
_LARGEST_CURVATURE = 0.5


@dataclass(frozen=True)
class Wanted:
    """Quantities whose uncertainty is to be reduced.

    Attributes:
        target: `torque`, `cage_slip` or `traction`.
        labels: Operating point of each quantity, as text.
        gradients: Gradients by the free internal constants, shape (quantities, free). Those of
            torque and traction are relative to the value.
        lever: Change of each quantity per relative change of all traction, in the unit of
            `gradients`.
        places: Conditions of the contacts that matter, shape (quantities, contacts, 3), with the
            coordinates of `oilfilm.fits.measured_curves.form_coordinates`.
        left_out: Operating points without such a gradient, with the reason.
    """

    target: str
    labels: list[str]
    gradients: FloatArray
    lever: FloatArray
    places: FloatArray
    left_out: list[str]


def wanted_in_bearing(
    oil: OilInBearing,
    bearing: Bearing,
    duty: FloatArray,
    information: Information,
    contact: Contact,
) -> dict[str, Wanted]:
    """Torque and cage slip at operating points, with their gradients by the free constants.

    The gradients include the friction equilibrium, which is solved again with each moved constant.

    Args:
        oil: The oil with its law.
        bearing: The bearing.
        duty: Rows of axial load in N, inner speed in rpm, oil temperature in degC.
        information: Information of the measured curves: the law and its constants.
        contact: Contact of the traction rig.

    Raises:
        OilfilmError: No operating point has a gradient.
    """
    moves = _moves_of_constants(information)
    constants = to_constants(information.law, information.internal + moves[:, :-1])
    load, speed, temperature = np.tile(duty.T, len(moves))
    terms = oil.with_constants(np.repeat(constants, len(duty), axis=0)).run(
        bearing,
        load,
        speed,
        temperature,
        traction_factor=np.exp(np.repeat(moves[:, -1], len(duty))),
    )
    # one axis for the moves, one for the operating points
    shape = (len(moves), len(duty))
    values = {
        "torque": terms["torque_n_m"].to_numpy(dtype=float).reshape(shape),
        "cage_slip": terms["cage_slip"].to_numpy(dtype=float).reshape(shape),
    }
    converged = terms["converged"].to_numpy(dtype=bool).reshape(shape)
    solved: BoolArray = np.asarray(converged.all(axis=0))
    smooth: BoolArray = solved & _is_smooth(values["torque"]) & _is_smooth(values["cage_slip"])
    labels, left_out = [], []
    for (load_n, speed_rpm, temperature_c), is_solved, is_smooth in zip(
        duty, solved, smooth, strict=True
    ):
        label = f"{load_n:g} N, {speed_rpm:g} rpm, {temperature_c:g} degC"
        if is_smooth:
            labels.append(label)
        elif is_solved:
            left_out.append(f"{label}: it jumps with the constants")
        else:
            left_out.append(f"{label}: no equilibrium")
    if not labels:
        raise OilfilmError(
            f"{oil.name} in {bearing.name}: no duty point has a steady motion that follows the "
            f"law's constants ({left_out[0]}). Choose other duty points."
        )
    places = _contact_places(terms.iloc[: len(duty)], duty, contact)[smooth]
    wanted = {}
    for target in BEARING_TARGETS:
        smooth_values = values[target][:, smooth]
        forward, backward = np.split(smooth_values[1:], 2)
        gradient = (forward - backward).T / (2 * _STEP)
        if target == "torque":
            gradient = gradient / smooth_values[0][:, np.newaxis]
        wanted[target] = Wanted(
            target=target,
            labels=labels,
            gradients=gradient[:, :-1],
            lever=gradient[:, -1],
            places=places,
            left_out=left_out,
        )
    return wanted


def _moves_of_constants(information: Information) -> FloatArray:
    """Moves of the internal constants and of the logarithm of all traction.

    Returns:
        Rows of shape (constants + 1,). The first row moves nothing. Then each row moves one free
        constant, or the traction, forward. The same rows follow with backward moves.
    """
    count = len(information.internal)
    moved = [*np.flatnonzero(information.free), count]
    forward = _STEP * np.eye(count + 1)[moved]
    return np.concatenate([np.zeros((1, count + 1)), forward, -forward])


def _contact_places(terms: pd.DataFrame, duty: FloatArray, contact: Contact) -> FloatArray:
    """Conditions of both contacts at each operating point, shape (points, 2, 3)."""
    load = contact.load_n(terms[_PRESSURES].to_numpy())
    speed = terms["entrainment_speed_m_s"].to_numpy()
    temperature = duty[:, 2]
    return form_coordinates(load, np.column_stack([speed] * 2), np.column_stack([temperature] * 2))


def _is_smooth(values: FloatArray) -> BoolArray:
    """Whether forward and backward differences agree, over all constants together.

    Args:
        values: A quantity by moves (`_moves_of_constants`) and operating points.
    """
    forward, backward = np.split(values[1:], 2)
    first = np.linalg.norm(forward - backward, axis=0) / 2
    second = np.linalg.norm(forward + backward - 2 * values[0], axis=0)
    # rounding of the equilibrium, for a quantity that does not depend on the law
    rounding = 1e-9 * np.maximum(np.abs(values[0]), 1e-3)
    return np.asarray(second <= _LARGEST_CURVATURE * first + rounding)


def wanted_traction(
    points: list[PointOfTraction], information: Information, contact: Contact
) -> Wanted:
    """mu at given conditions, with its relative gradients by the free constants.

    Args:
        points: The conditions and slips.
        information: Information of the measured curves: the law and its constants.
        contact: Contact of the traction rig.

    Raises:
        OilfilmError: The law depends on a condition that the points do not have.
    """
    levels = pd.DataFrame([point.model_dump() for point in points])
    missing = sorted(set(information.law.conditions) - set(levels))
    if missing:
        raise OilfilmError(
            f"plan.traction_at: the law {information.law.name} needs {', '.join(missing)}; plan "
            "for torque or cage slip."
        )
    slip = levels["slide_roll_ratio"].to_numpy(dtype=float)
    conditions = levels[list(information.law.conditions)].to_numpy(dtype=float)
    curves = Curves(conditions, np.ones(len(slip)), np.arange(len(slip)), slip)
    observations = curves.observations(information.law)
    mu = information.law.traction(information.internal, observations)
    jacobian = information.law.jacobian(information.internal, observations)
    slopes = jacobian[:, information.free]
    labels = [
        f"{point.max_hertz_pressure_gpa:g} GPa, {point.entrainment_speed_m_s:g} m/s, "
        f"{point.inlet_temperature_c:g} degC, S {point.slide_roll_ratio:g}"
        for point in points
    ]
    pressure, speed, temperature = levels[list(CONDITIONS)].to_numpy(dtype=float).T
    return Wanted(
        target="traction",
        labels=labels,
        gradients=slopes / mu[:, np.newaxis],
        lever=np.ones(len(mu)),
        places=form_coordinates(contact.load_n(pressure), speed, temperature)[:, np.newaxis],
        left_out=[],
    )


@dataclass(frozen=True)
class NextTests:
    """The tests to run next for one oil and one target.

    Attributes:
        oil: Name of the oil.
        where: Name of the bearing; empty for the target traction.
        information: Information of the measured curves.
        wanted: Quantities whose uncertainty is to be reduced.
        candidates: Tests that the rig can run.
        gradients: Gradients of these quantities by all parameters of `information`.
        design: The chosen tests, and the uncertainty before and after them.
    """

    oil: str
    where: str
    information: Information
    wanted: Wanted
    candidates: Candidates
    gradients: FloatArray
    design: Design

    def table(self) -> pd.DataFrame:
        """Rows of the table `test_plan`."""
        design = self.design
        tests = self.candidates.tests
        order = np.zeros(len(tests), dtype=np.int64)
        order[design.chosen] = np.arange(1, len(design.chosen) + 1)
        uncertainty_with_plan = np.full(len(tests), np.nan)
        uncertainty_with_plan[design.chosen] = design.after
        return tests.assign(
            oil=self.oil,
            bearing=self.where,
            target=self.wanted.target,
            test_order=order,
            uncertainty_now=design.before,
            uncertainty_with_test=design.alone,
            uncertainty_with_plan=uncertainty_with_plan,
        )


@dataclass(frozen=True)
class Request:
    """Request for a plan.

    Attributes:
        targets: Quantities whose uncertainty is to be reduced.
        count: Number of tests.
        bearing: The bearing; None for the target traction.
        duty: Operating points of the bearing, rows of load, speed and temperature.
    """

    targets: tuple[str, ...]
    count: int
    bearing: Bearing | None
    duty: FloatArray


def request_of(settings: Settings, bearing: Bearing | None = None) -> Request:
    """The request of the settings.

    Args:
        settings: The settings.
        bearing: A bearing in place of the campaign's.
    """
    count = settings.plan.tests
    if bearing is None and settings.campaign.torque is not None:
        bearing = settings.tested_bearing()
    if bearing is None:
        return Request(("traction",), count, bearing=None, duty=np.empty((0, 3)))
    return Request(BEARING_TARGETS, count, bearing, _duty_points(settings, bearing))


def _duty_points(settings: Settings, bearing: Bearing) -> FloatArray:
    """Rows of load, speed and temperature.

    They are those of the plan, else of the torque tests, else of the cage-slip map.
    """
    duty_points = settings.plan.duty_points
    if duty_points:
        return np.array([[getattr(point, name) for name in DUTY] for point in duty_points])
    torque = settings.campaign.torque
    if torque is not None and torque.matrix is not None:
        loads, speeds, temperatures = (getattr(torque.matrix, name) for name in DUTY)
    else:
        cage_slip = settings.bearing.cage_slip
        loads = cage_slip.axial_load_n
        pitch_mm = bearing.pitch_diameter_m * MM_PER_M
        speeds = np.array(cage_slip.pitch_speed_mm_rpm) / pitch_mm
        temperatures = [cage_slip.inlet_temperature_c]
    mesh = np.meshgrid(loads, speeds, temperatures, indexing="ij")
    return np.stack(mesh, axis=-1).reshape(-1, len(DUTY))


def plan_oil(
    results: CampaignTables, settings: Settings, oil: str, request: Request
) -> list[NextTests]:
    """The tests to run next for an oil, one plan for each target.

    Args:
        results: Tables coefficients, fit_quality, refits and points.
        settings: The settings.
        oil: Name of the oil.
        request: The request.

    Raises:
        OilfilmError: Rig, oil or fit lack something that a plan needs.
    """
    name, rig = _planned_rig(settings)
    contact = rig.contact()
    properties = settings.properties_of(oil)
    if contact is None or np.isnan(contact.roughness_rq_m):
        raise OilfilmError(
            f"config/rigs/{name}.yaml: lacks the contact (`ball_radius_m`, `ball`, `disc`, "
            "roughness), without which neither load nor film of a test is known. Add it."
        )
    if properties is None:
        raise OilfilmError(
            f"{oil}: its properties are not known, so that no film can be calculated. Write "
            f"config/oils/{oil}.yaml and list it under `oils` of the campaign."
        )
    fitted = FittedLaw.of_configured(results, oil)
    information = measured_information(fitted, results.points, oil, rig.calibration)
    film = Film(contact, properties, settings.film.thickness)
    plan = settings.plan
    feasible = candidates(plan.levels, rig, name, film, settings.gates.lambda_limit, information)
    wanted_by_target: dict[str, Wanted] = {}
    if request.bearing is not None and set(request.targets) & set(BEARING_TARGETS):
        quality = results.fit_quality[results.fit_quality["oil"] == oil]
        oil_in_bearing = oils_in_bearings(results.coefficients, quality, settings)
        if not oil_in_bearing:
            raise OilfilmError(
                f"{oil}: the rigs of the campaign have different contacts, so that its law cannot "
                "be used in a bearing. Plan for traction, or for a campaign of one rig."
            )
        wanted_by_target |= wanted_in_bearing(
            oil_in_bearing[0], request.bearing, request.duty, information, contact
        )
    if "traction" in request.targets:
        wanted_by_target["traction"] = wanted_traction(plan.traction_at, information, contact)
    plans = []
    for target in request.targets:
        wanted = wanted_by_target[target]
        form = _form_error(plan, wanted, information, feasible.curves)
        information_with_form = replace(information, form=form)
        gradients = information_with_form.gradients(wanted.gradients, wanted.lever, wanted.places)
        design = choose(
            information_with_form.precision,
            information_with_form.of_curves(feasible.curves),
            gradients,
            request.count,
            plan.smallest_gain,
        )
        if request.bearing is None or target == "traction":
            bearing_name = ""
        else:
            bearing_name = request.bearing.name
        plans.append(
            NextTests(
                oil=oil,
                where=bearing_name,
                information=information_with_form,
                wanted=wanted,
                candidates=feasible,
                gradients=gradients,
                design=design,
            )
        )
    return plans


def _form_error(
    plan: PlanSettings, wanted: Wanted, information: Information, tests: Curves
) -> FormError:
    """Possible error of the law's form, with lengths relative to the span of the feasible tests."""
    places_of_tests = information.form_coordinates(tests)
    span = np.maximum(np.ptp(places_of_tests, axis=0), _SMALLEST_SPAN)
    places_of_wanted = wanted.places.reshape(-1, 3)
    places_of_measured = information.form_coordinates(information.curves)
    all_places = [places_of_wanted, places_of_measured, places_of_tests]
    length = plan.form_error.length * span
    return FormError.spread_over(plan.form_error.size, length, np.concatenate(all_places))


def _planned_rig(settings: Settings) -> tuple[str, Rig]:
    """The rig of the next tests: the only rig, or the only rig with limits."""
    rigs = settings.rigs
    limited = [name for name, rig in rigs.items() if rig.limits is not None]
    if len(rigs) == 1 or len(limited) == 1:
        name = limited[0] if limited else next(iter(rigs))
        return name, rigs[name]
    raise OilfilmError(
        f"the campaign has the rigs {', '.join(rigs)}; {len(limited)} of them have `limits`. A "
        "plan is for one rig: write `limits` in the file of that rig alone (config/rigs)."
    )


def plan_table(results: CampaignTables, settings: Settings) -> tuple[pd.DataFrame, list[str]]:
    """The table `test_plan` of a campaign, and the reasons why oils have no rows in it."""
    request = request_of(settings)
    plans = []
    reasons = []
    for oil in settings.oils:
        try:
            plans += [plan.table() for plan in plan_oil(results, settings, oil, request)]
        except OilfilmError as reason:
            reasons.append(str(reason))
    return joined(plans, "test_plan"), reasons
