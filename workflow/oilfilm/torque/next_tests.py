"""Which tests to run next: rig conditions that most reduce what a bearing's torque leaves open.

The law's form may be wrong: by a few per cent that change over the conditions, so that tests near
the bearing's contacts tell more than a power law's lever far away. A rig can run tests within its
limits and sensors, with a full film.

Decides: which tests the rig can run, and which of them are chosen next.
"""

from dataclasses import dataclass, replace
from itertools import compress

import numpy as np
import pandas as pd

from oilfilm.bearing.geometry import Bearing
from oilfilm.errors import OilfilmError
from oilfilm.fits.fitted import FittedLaw
from oilfilm.fits.measured_curves import Design, FormError, Known, choose, known_of, place
from oilfilm.fits.problem import Curves
from oilfilm.physics.contact import Contact
from oilfilm.settings.config import PlanLevels, PlanSettings, PointOfTraction
from oilfilm.settings.resolved import Settings
from oilfilm.settings.rig import Rig
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.ties import exceeds, reaches
from oilfilm.torque.bearing_torque import OilInBearing, joined, oils_in_bearings
from oilfilm.torque.operating_grid import Film, Grid
from oilfilm.traction.law import CONDITIONS, to_constants
from oilfilm.units import MM_PER_M, BoolArray, FloatArray

# As many as a curve has coefficients at least.
_FEWEST_SLIPS = 3


@dataclass(frozen=True)
class Candidates:
    """Tests that a rig can run.

    Attributes:
        tests: One row per test: P, U, T, load, largest slip, lambda there.
        curves: Their points.
        left_out: Number of conditions left out, by the reason.
    """

    tests: pd.DataFrame
    curves: Curves
    left_out: dict[str, int]


def candidates(
    levels: PlanLevels, rig: Rig, name: str, film: Film, lambda_limit: float, known: Known
) -> Candidates:
    """The tests among the levels of a plan that a rig can run with a full film.

    A test has the slips of the measured curves, as far as the rig and its speed sensor reach.

    Raises:
        OilfilmError: The rig's limits are not known, or no test is left.
    """
    limits, scale = rig.limits, rig.full_scale
    if limits is None:
        raise OilfilmError(
            f"config/rigs/{name}.yaml: lacks the key `limits`, which a plan needs. Write the "
            "highest max_hertz_pressure_gpa, entrainment_speed_m_s, inlet_temperature_c and "
            "slide_roll_ratio at which the rig can run."
        )
    pressures, speeds, temperatures = (
        np.array(getattr(levels, each), dtype=float) for each in CONDITIONS
    )
    grid = Grid(pressures, speeds, temperatures, known.slip)
    points, count = grid.operating_points(), len(known.slip)
    points["load_n"] = film.contact.load_n(points["max_hertz_pressure_gpa"].to_numpy())
    tests = points.iloc[::count].drop(columns="slide_roll_ratio").reset_index(drop=True)
    slip = points["slide_roll_ratio"].to_numpy()
    conditions = tests[list(known.law.conditions)].to_numpy(dtype=float)
    load = tests["load_n"].to_numpy()
    every = Curves(conditions, load, np.repeat(np.arange(len(tests)), count), slip)
    shape = (len(tests), count)
    mu = known.law.traction(known.internal, every.at(known.law)).reshape(shape)
    pressure, speed, temperature = (tests[name].to_numpy() for name in CONDITIONS)
    slip, lambda_ratio = slip.reshape(shape), film.over(grid)[1].reshape(shape)
    reached = reaches(limits.slide_roll_ratio, slip)
    # why a condition cannot be tested, in the order in which reasons are given
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
    left, left_out = np.ones(len(tests), dtype=bool), {}
    for reason, is_beyond in beyond.items():
        left_out[reason] = int((left & is_beyond).sum())
        left &= ~is_beyond
    if not left.any():
        counts = ", ".join(f"{reason} ({count})" for reason, count in left_out.items() if count)
        raise OilfilmError(
            f"config/rigs/{name}.yaml, plan.levels: none of {len(left)} conditions can be run; "
            f"they are beyond {counts}. Change plan.levels, or correct the rig's limits."
        )
    last = np.arange(len(tests)), count - 1 - np.argmax(reached[:, ::-1], axis=1)
    tests = tests.assign(slide_roll_ratio=slip[last], lambda_ratio=lambda_ratio[last])[left]
    # points that are reached, of curves that are left
    curve = np.repeat(np.arange(left.sum()), reached[left].sum(axis=1))
    curves = Curves(conditions[left], load[left], curve, slip[left][reached[left]])
    return Candidates(tests.reset_index(drop=True), curves, left_out)


DUTY = ("axial_load_n", "inner_speed_rpm", "oil_temperature_c")
BEARING_TARGETS = ("torque", "cage_slip")
# Maximum pressure at both races, as columns of the calculated results.
_PRESSURES = ("inner_max_hertz_pressure_gpa", "outer_max_hertz_pressure_gpa")
# Of the tests to choose from, in ln p, ln U and degC, where a plan has one level of a condition.
_LEAST_SPAN = np.array([0.1, 0.1, 10.0])
# Step of the internal constants in finite differences.
_STEP = 1e-3
# Second over first difference of a smooth quantity is of the size of the step; of a jump it is 1.
_LARGEST_BEND = 0.5


@dataclass(frozen=True)
class Wanted:
    """Quantities whose uncertainty shall become small.

    Attributes:
        target: `torque`, `cage_slip` or `traction`.
        labels: Operating point of each, as text.
        gradients: By the free internal constants, shape (quantities, free); of torque and traction
            relative to the value.
        lever: Change of each (as of `gradients`) per relative change of all traction.
        places: Conditions at which traction counts, shape (quantities, places, 3), as of `place`.
        left_out: Operating points without such a gradient, with the reason.
    """

    target: str
    labels: list[str]
    gradients: FloatArray
    lever: FloatArray
    places: FloatArray
    left_out: list[str]


def wanted_in_bearing(
    oil: OilInBearing, bearing: Bearing, duty: FloatArray, known: Known, contact: Contact
) -> dict[str, Wanted]:
    """Torque and cage slip at operating points, with their gradients by the free constants.

    The gradients go through the friction equilibrium: it is solved again with each constant moved.

    Args:
        oil: The oil with its law.
        bearing: The bearing.
        duty: Rows of axial load in N, inner speed in rpm, oil temperature in degC.
        known: The constants.
        contact: Of the traction rig.

    Raises:
        OilfilmError: No operating point has a gradient.
    """
    free, count = np.flatnonzero(known.free), len(known.internal)
    # every constant to either side, and all traction
    step = _STEP * np.eye(count + 1)[[*free, count]]
    moves = np.concatenate([np.zeros((1, count + 1)), step, -step])
    constants = to_constants(known.law, known.internal + moves[:, :-1])
    load, speed, heat = np.tile(duty.T, len(moves))
    terms = oil.with_constants(np.repeat(constants, len(duty), axis=0)).run(
        *(bearing, load, speed, heat), traction_factor=np.exp(np.repeat(moves[:, -1], len(duty)))
    )
    first = terms.iloc[: len(duty)]
    rolling, pressure = first[["entrainment_speed_m_s"]], first[[*_PRESSURES]].to_numpy()
    both = (np.repeat(each, 2, axis=1) for each in (rolling.to_numpy(), duty[:, 2:]))
    places = place(contact.load_n(pressure), *both)
    # by target, moves and operating points
    values = np.moveaxis(
        terms[["torque_n_m", "cage_slip"]].to_numpy(dtype=float).reshape(len(moves), -1, 2), 2, 0
    )
    converged = terms["converged"].to_numpy(dtype=bool).reshape(len(moves), -1)
    solved: BoolArray = np.asarray(converged.all(axis=0))
    smooth: BoolArray = solved & np.all([_is_smooth(each) for each in values], axis=0)
    labels = [f"{load:g} N, {speed:g} rpm, {heat:g} degC" for load, speed, heat in duty]
    left_out = [
        f"{label}: " + ("it jumps with the constants" if good else "no equilibrium")
        for label, good, kept in zip(labels, solved, smooth, strict=True)
        if not kept
    ]
    if not smooth.any():
        raise OilfilmError(
            f"{oil.name} in {bearing.name}: no duty point has a steady motion that follows the "
            f"law's constants ({left_out[0]}). Choose other duty points."
        )
    wanted, kept = {}, list(compress(labels, smooth))
    for target, (middle, *ends) in zip(BEARING_TARGETS, values[..., smooth], strict=True):
        forward, back = np.split(np.array(ends), 2)
        gradient = (forward - back).T / (2 * _STEP)
        if target == "torque":
            gradient = gradient / middle[:, np.newaxis]
        by_constants, lever = gradient[:, :-1], gradient[:, -1]
        wanted[target] = Wanted(target, kept, by_constants, lever, places[smooth], left_out)
    return wanted


def _is_smooth(values: FloatArray) -> BoolArray:
    """Whether forward and backward differences agree, over all constants together."""
    forward, back = np.split(values[1:], 2)
    first = np.linalg.norm(forward - back, axis=0) / 2
    second = np.linalg.norm(forward + back - 2 * values[0], axis=0)
    # rounding of the equilibrium, where nothing depends on the law
    floor = 1e-9 * np.maximum(np.abs(values[0]), 1e-3)
    return np.asarray(second <= _LARGEST_BEND * first + floor)


def wanted_traction(at: list[PointOfTraction], known: Known, contact: Contact) -> Wanted:
    """mu at stated conditions, with its relative gradients by the free constants."""
    levels = pd.DataFrame([point.model_dump() for point in at])
    missing = sorted(set(known.law.conditions) - set(levels))
    if missing:
        raise OilfilmError(
            f"plan.traction_at: the law {known.law.name} is one of {', '.join(missing)}; plan for "
            "torque or cage slip."
        )
    slip = levels["slide_roll_ratio"].to_numpy(dtype=float)
    conditions = levels[list(known.law.conditions)].to_numpy(dtype=float)
    curves = Curves(conditions, np.ones(len(slip)), np.arange(len(slip)), slip)
    mu = known.law.traction(known.internal, curves.at(known.law))
    slopes = known.law.jacobian(known.internal, curves.at(known.law))[:, known.free]
    labels = [
        f"{row.max_hertz_pressure_gpa:g} GPa, {row.entrainment_speed_m_s:g} m/s, "
        f"{row.inlet_temperature_c:g} degC, S {row.slide_roll_ratio:g}"
        for row in at
    ]
    pressure, speed, temperature = levels[list(CONDITIONS)].to_numpy(dtype=float).T
    places = place(contact.load_n(pressure), speed, temperature)[:, np.newaxis]
    gradients = slopes / mu[:, np.newaxis]
    return Wanted("traction", labels, gradients, np.ones(len(mu)), places, [])


@dataclass(frozen=True)
class NextTests:
    """The tests to run next for one oil and one target.

    Attributes:
        oil: The oil.
        where: The bearing; empty for the target traction.
        known: What the measured curves tell.
        wanted: Whose uncertainty becomes small.
        candidates: The tests that the rig can run.
        gradients: Of what is wanted by all parameters of `known`.
        design: Those chosen.
    """

    oil: str
    where: str
    known: Known
    wanted: Wanted
    candidates: Candidates
    gradients: FloatArray
    design: Design

    def table(self) -> pd.DataFrame:
        """Rows of the table `test_plan`."""
        design, tests = self.design, self.candidates.tests
        order = np.zeros(len(tests), dtype=np.int64)
        order[design.chosen] = np.arange(1, len(design.chosen) + 1)
        after = np.full(len(tests), np.nan)
        after[design.chosen] = design.after
        return tests.assign(
            oil=self.oil,
            bearing=self.where,
            target=self.wanted.target,
            test_order=order,
            uncertainty_now=design.before,
            uncertainty_with_test=design.alone,
            uncertainty_with_plan=after,
        )


@dataclass(frozen=True)
class Request:
    """What a plan is asked for.

    Attributes:
        targets: Quantities whose uncertainty shall become small.
        count: Number of tests.
        bearing: The bearing; None for the target traction.
        duty: Its operating points, rows of load, speed and temperature.
    """

    targets: tuple[str, ...]
    count: int
    bearing: Bearing | None
    duty: FloatArray


def request_of(settings: Settings, bearing: Bearing | None = None) -> Request:
    """The request that the settings make.

    Args:
        settings: The settings.
        bearing: Instead of the campaign's.
    """
    plan, torque = settings.plan, settings.campaign.torque
    if bearing is None and torque is not None:
        bearing = settings.tested_bearing()
    targets = BEARING_TARGETS if bearing is not None else ("traction",)
    duty = np.empty((0, 3)) if bearing is None else _duty_points(plan, settings, bearing)
    return Request(targets, plan.tests, bearing, duty)


def _duty_points(plan: PlanSettings, settings: Settings, bearing: Bearing) -> FloatArray:
    """Rows of load, speed and temperature: those of the plan, of the torque tests, of the map."""
    if plan.duty_points:
        return np.array([[getattr(row, name) for name in DUTY] for row in plan.duty_points])
    torque = settings.campaign.torque
    if torque is not None and torque.matrix is not None:
        levels = [getattr(torque.matrix, name) for name in DUTY]
    else:
        cage = settings.bearing.cage_slip
        speed = np.array(cage.pitch_speed_mm_rpm) / (bearing.pitch_diameter_m * MM_PER_M)
        levels = [cage.axial_load_n, speed, [cage.inlet_temperature_c]]
    return np.stack([each.ravel() for each in np.meshgrid(*levels, indexing="ij")], axis=-1)


def plan_oil(
    results: CampaignTables, settings: Settings, oil: str, request: Request
) -> list[NextTests]:
    """The tests to run next for an oil, one plan for each target.

    Args:
        results: Tables coefficients, fit_quality, refits and points.
        settings: The settings.
        oil: Name of the oil.
        request: What is asked for.

    Raises:
        OilfilmError: Rig, oil or fit lack what a plan needs.
    """
    name, rig = _rig_of(settings)
    contact, properties = rig.contact(), settings.properties_of(oil)
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
    known = known_of(fitted, results.points, oil, rig.calibration)
    film = Film(contact, properties, settings.film.thickness)
    plan = settings.plan
    feasible = candidates(plan.levels, rig, name, film, settings.gates.lambda_limit, known)
    wanted: dict[str, Wanted] = {}
    if request.bearing is not None and set(request.targets) & set(BEARING_TARGETS):
        quality = results.fit_quality[results.fit_quality["oil"] == oil]
        own = oils_in_bearings(results.coefficients, quality, settings)
        if not own:
            raise OilfilmError(
                f"{oil}: the rigs of the campaign have different contacts, so that its law cannot "
                "be taken into a bearing. Plan for traction, or for a campaign of one rig."
            )
        wanted |= wanted_in_bearing(own[0], request.bearing, request.duty, known, contact)
    if "traction" in request.targets:
        wanted["traction"] = wanted_traction(plan.traction_at, known, contact)
    made = []
    for target in request.targets:
        asked = wanted[target]
        here = replace(known, form=_form_error(plan, asked, known, feasible.curves))
        gradients = here.gradients(asked.gradients, asked.lever, asked.places)
        new = here.of_curves(feasible.curves)
        design = choose(here.precision, new, gradients, request.count, plan.smallest_gain)
        where = "" if target == "traction" or request.bearing is None else request.bearing.name
        made.append(NextTests(oil, where, here, asked, feasible, gradients, design))
    return made


def _form_error(plan: PlanSettings, wanted: Wanted, known: Known, new: Curves) -> FormError:
    """How far the law's form may be wrong, with lengths by the span of the tests to choose from."""
    of_tests = known.places(new)
    length = plan.form_error.length * np.maximum(np.ptp(of_tests, axis=0), _LEAST_SPAN)
    every = [wanted.places.reshape(-1, 3), known.places(known.curves), of_tests]
    return FormError.near(plan.form_error.size, length, np.concatenate(every))


def _rig_of(settings: Settings) -> tuple[str, Rig]:
    """The rig that the next tests run on: the only one, or the only one with limits."""
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
    """The table `test_plan` of a campaign, and why oils have no rows in it."""
    request = request_of(settings)
    parts, reasons = [], []
    for oil in settings.oils:
        try:
            parts += [plan.table() for plan in plan_oil(results, settings, oil, request)]
        except OilfilmError as reason:
            reasons.append(str(reason))
    return joined(parts, "test_plan"), reasons
