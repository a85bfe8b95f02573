"""Which tests to run next: rig conditions that most reduce what a bearing's torque leaves open.

Everything rests on the law's form: the fitted law is taken as true at every condition. What the law
misses beyond the tested box is no part of these uncertainties.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import compress

import numpy as np
import pandas as pd

from oilfilm import tables
from oilfilm.bearing.geometry import Bearing
from oilfilm.errors import OilfilmError
from oilfilm.fitting.fitted import FittedLaw
from oilfilm.fitting.problem import curve_data
from oilfilm.settings.config import PlanLevels, PlanSettings, PointOfTraction
from oilfilm.settings.resolved import Settings
from oilfilm.settings.rig import Calibration, Rig
from oilfilm.studies.bearing_torque import OilInBearing, oils_in_bearings
from oilfilm.studies.curve_errors import (
    Curves,
    ErrorSizes,
    effects,
    error_sizes,
    information,
)
from oilfilm.studies.operating_grid import Film, Grid
from oilfilm.studies.optimal_design import Design, Information, choose
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.traction.law import CONDITIONS, BoolArray, FloatArray, Law, to_constants, to_internal
from oilfilm.units import MM_PER_M

DUTY = ("axial_load_n", "inner_speed_rpm", "oil_temperature_c")
BEARING_TARGETS = ("torque", "cage_slip")
# Step of the internal constants in finite differences.
_STEP = 1e-3
# Second over first difference of a smooth quantity is of the size of the step; of a jump it is 1.
_LARGEST_BEND = 0.5
# As many as a curve has coefficients at least.
_FEWEST_SLIPS = 3


@dataclass(frozen=True)
class Known:
    """What the measured curves tell about the constants that are not fixed.

    Attributes:
        law: The fitted law.
        internal: All its internal constants.
        free: Which of them the data decide.
        information: Of all measured curves.
        sizes: Variances of what is wrong in a curve, from the residuals of the fit.
        calibration: Standard uncertainty of each sensor's calibration.
        slip: Slide-roll ratios of the curve with the most points.
    """

    law: Law
    internal: FloatArray
    free: BoolArray
    information: Information
    sizes: ErrorSizes
    calibration: FloatArray
    slip: FloatArray

    def of_curves(self, curves: Curves) -> Information:
        """What each of some curves would tell."""
        jacobian = self.law.jacobian(self.internal, curves.at(self.law))[:, self.free]
        effect = effects(self.law, self.internal, curves)
        return information(jacobian, effect, self.sizes, self.calibration, curves.curve)


def known_of(
    fitted: FittedLaw, points: pd.DataFrame, oil: str, calibration: Calibration | None
) -> Known:
    """What the measured curves of an oil tell about the constants of its law.

    Args:
        fitted: The law with its refits.
        points: Table of points; those of the oil are used.
        oil: Name of the oil.
        calibration: Of the rig's sensors; without it they are taken as exact.

    Raises:
        OilfilmError: The fit has no constants, no refits, or does not follow a condition; or the
            points do not tell its constants apart.
    """
    coefficients = fitted.coefficients
    if np.isnan(coefficients.constants).any():
        raise OilfilmError(f"{oil}: nothing could be fitted; see results/*/summary.txt.")
    if coefficients.fixed or not coefficients.known.all():
        where = "; ".join(each.sentence() for each in coefficients.fixed)
        raise OilfilmError(
            f"{oil}: a plan needs a law that follows every condition ({where or 'it does not'}). "
            "First test at two or more levels of each condition, varied one at a time."
        )
    if len(coefficients.spread) < 2:
        raise OilfilmError(
            f"{oil}: the uncertainty of the constants is not known, because too few curves were "
            "tested (fit.min_curves_to_resample of config/config.yaml). Test more conditions first."
        )
    law = fitted.law
    internal = to_internal(law, coefficients.constants)
    spread = to_internal(law, coefficients.spread)
    # constants that the law gives, or that ended at a bound, are the same in every refit
    free = np.ptp(spread, axis=0) > 0
    curves, mu = _measured_curves(points[points["oil"] == oil], law)
    jacobian = law.jacobian(internal, curves.at(law))[:, free]
    if np.linalg.matrix_rank(jacobian) < jacobian.shape[1]:
        raise OilfilmError(
            f"{oil}: the accepted points do not tell the law's constants apart. Test at two or "
            "more levels of each condition, or fit again if points and fit are of different runs."
        )
    residual = mu - law.traction(internal, curves.at(law))
    effect = effects(law, internal, curves)
    sizes = error_sizes(jacobian, effect, residual, curves.curve)
    sensors = _sensor_errors(calibration)
    each = information(jacobian, effect, sizes, sensors, curves.curve)
    hessian = each.hessian.sum(axis=0)
    covariance = np.atleast_2d(np.cov(spread[:, free], rowvar=False))
    # the scatter that gives the constants the covariance of the bootstrap
    scatter = hessian @ covariance @ hessian
    now = Information(hessian, scatter, each.shared.sum(axis=0))
    longest = np.argmax(np.bincount(curves.curve))
    slip = np.sort(curves.slip[curves.curve == longest])
    return Known(law, internal, free, now, sizes, sensors, slip)


def _measured_curves(points: pd.DataFrame, law: Law) -> tuple[Curves, FloatArray]:
    """Accepted curves whose conditions are all known, and mu of their points."""
    accepted = points[points["accepted"]].dropna(subset=[*law.conditions, "load_n"])
    data = curve_data(accepted, law.conditions)
    load = accepted.groupby("run_id", sort=True)["load_n"].mean().to_numpy(dtype=float)
    return Curves(data.conditions, load, data.curve, data.slip), data.mu


def _sensor_errors(calibration: Calibration | None) -> FloatArray:
    """Standard uncertainties in the order of `systematic.SENSORS`; 0 where they are not stated."""
    if calibration is None:
        return np.zeros(4)
    return np.array(
        [
            calibration.load_relative,
            calibration.traction_force_relative,
            calibration.speed_relative,
            calibration.temperature_c,
        ]
    )


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
    points = grid.operating_points()
    pressure, speed, temperature, slip = points.to_numpy(dtype=float).T
    load = film.contact.load_n(pressure)
    lambda_ratio = film.over(grid)[1].ravel()
    shape = (-1, len(known.slip))
    tests = points.drop_duplicates(list(CONDITIONS))[list(CONDITIONS)].reset_index(drop=True)
    tests = tests.assign(load_n=load.reshape(shape)[:, 0])
    every = Curves(
        tests[list(known.law.conditions)].to_numpy(dtype=float),
        tests["load_n"].to_numpy(dtype=float),
        np.repeat(np.arange(len(tests)), len(known.slip)),
        slip,
    )
    force = load * known.law.traction(known.internal, every.at(known.law))
    reached = slip <= limits.slide_roll_ratio * (1 + 1e-6)
    largest: dict[str, tuple[FloatArray, float | None]] = {
        "the rig's largest pressure": (pressure, limits.max_hertz_pressure_gpa),
        "the rig's largest speed": (speed, limits.entrainment_speed_m_s),
        "the rig's highest temperature": (temperature, limits.inlet_temperature_c),
    }
    if scale is not None:
        reached &= speed * (1 + slip / 2) <= scale.surface_speed_m_s
        largest |= {
            "the load sensor's full scale": (load, scale.load_n),
            "the force sensor's full scale": (force, scale.traction_force_n),
            "the temperature sensor's full scale": (temperature, scale.temperature_c),
        }
    beyond: dict[str, BoolArray] = {
        reason: np.asarray((values > limit).reshape(shape).any(axis=1))
        for reason, (values, limit) in largest.items()
        if limit is not None
    }
    if limits.smallest_load_n is not None:
        beyond["the rig's smallest load"] = (load < limits.smallest_load_n).reshape(shape)[:, 0]
    few = reached.reshape(shape).sum(axis=1) < _FEWEST_SLIPS
    beyond["slips that the rig reaches at this speed"] = few
    thin = reached & ~(lambda_ratio > lambda_limit)
    beyond[f"a full film (lambda > {lambda_limit:g})"] = np.asarray(thin.reshape(shape).any(axis=1))
    reached, lambda_ratio = reached.reshape(shape), lambda_ratio.reshape(shape)
    return _feasible(tests, every, reached, lambda_ratio, beyond, name)


def _feasible(
    tests: pd.DataFrame,
    every: Curves,
    reached: BoolArray,
    lambda_ratio: FloatArray,
    beyond: Mapping[str, BoolArray],
    rig: str,
) -> Candidates:
    """The tests that are beyond nothing, and for how many others each reason is the first."""
    left = np.ones(len(reached), dtype=bool)
    left_out = {}
    for reason, is_beyond in beyond.items():
        left_out[reason] = int((left & is_beyond).sum())
        left &= ~is_beyond
    if not left.any():
        counts = ", ".join(f"{reason} ({count})" for reason, count in left_out.items() if count)
        raise OilfilmError(
            f"config/rigs/{rig}.yaml, plan.levels: none of {len(left)} conditions can be run; "
            f"they are beyond {counts}. Change plan.levels, or correct the rig's limits."
        )
    # points that are reached, of curves that are left
    point = (reached & left[:, np.newaxis]).ravel()
    number = np.cumsum(left) - 1
    last = reached.shape[1] - 1 - np.argmax(reached[:, ::-1], axis=1)
    row = np.arange(len(reached))
    slip = every.slip.reshape(reached.shape)
    tests = tests.assign(
        slide_roll_ratio=slip[row, last],
        lambda_ratio=lambda_ratio[row, last],
    )
    curves = Curves(
        every.conditions[left], every.load_n[left], number[every.curve[point]], every.slip[point]
    )
    return Candidates(tests[left].reset_index(drop=True), curves, left_out)


@dataclass(frozen=True)
class Wanted:
    """Quantities whose uncertainty shall become small.

    Attributes:
        target: `torque`, `cage_slip` or `traction`.
        labels: Operating point of each, as text.
        values: Their values by the fitted law.
        gradients: By the free internal constants, shape (quantities, free); of torque and traction
            relative to the value.
        left_out: Operating points without such a gradient, with the reason.
    """

    target: str
    labels: list[str]
    values: FloatArray
    gradients: FloatArray
    left_out: list[str]


def wanted_in_bearing(
    oil: OilInBearing, bearing: Bearing, duty: FloatArray, known: Known
) -> dict[str, Wanted]:
    """Torque and cage slip at operating points, with their gradients by the free constants.

    The gradients go through the friction equilibrium: it is solved anew with each constant moved.

    Args:
        oil: The oil with its law.
        bearing: The bearing.
        duty: Rows of axial load in N, inner speed in rpm, oil temperature in degC.
        known: The constants.

    Raises:
        OilfilmError: No operating point has a gradient.
    """
    free = np.flatnonzero(known.free)
    step = _STEP * np.eye(len(known.internal))[free]
    moved = known.internal + np.concatenate([np.zeros_like(step[:1]), step, -step])
    constants = np.repeat(to_constants(known.law, moved), len(duty), axis=0)
    terms = oil.with_constants(constants).run(bearing, *np.tile(duty.T, len(moved)))
    converged = terms["converged"].to_numpy(dtype=bool).reshape(len(moved), -1)
    solved: BoolArray = np.asarray(converged.all(axis=0))
    labels = [f"{load:g} N, {speed:g} rpm, {heat:g} degC" for load, speed, heat in duty]
    values = {
        target: terms[column].to_numpy(dtype=float).reshape(len(moved), -1)
        for target, column in zip(BEARING_TARGETS, ("torque_n_m", "cage_slip"), strict=True)
    }
    smooth = solved.copy()
    for each in values.values():
        smooth &= _is_smooth(each, len(free))
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
    wanted = {}
    for target, each in values.items():
        middle, ends = each[0], each[1:].reshape(2, len(free), -1)
        gradient = (ends[0] - ends[1]).T / (2 * _STEP)
        if target == "torque":
            gradient = gradient / middle[:, np.newaxis]
        kept = list(compress(labels, smooth))
        wanted[target] = Wanted(target, kept, middle[smooth], gradient[smooth], left_out)
    return wanted


def _is_smooth(values: FloatArray, free: int) -> BoolArray:
    """Whether forward and backward differences agree, over all constants together."""
    ends = values[1:].reshape(2, free, -1)
    first = np.linalg.norm(ends[0] - ends[1], axis=0) / 2
    second = np.linalg.norm(ends[0] + ends[1] - 2 * values[0], axis=0)
    # rounding of the equilibrium, where nothing depends on the law
    floor = 1e-9 * np.maximum(np.abs(values[0]), 1e-3)
    return np.asarray(second <= _LARGEST_BEND * first + floor)


def wanted_traction(at: list[PointOfTraction], known: Known) -> Wanted:
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
    return Wanted("traction", labels, mu, slopes / mu[:, np.newaxis], [])


@dataclass(frozen=True)
class NextTests:
    """The tests to run next for one oil and one target.

    Attributes:
        oil: The oil.
        where: The bearing; empty for the target traction.
        known: What the measured curves tell.
        wanted: Whose uncertainty becomes small.
        candidates: The tests that the rig can run.
        design: Those chosen.
    """

    oil: str
    where: str
    known: Known
    wanted: Wanted
    candidates: Candidates
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
    if contact is None:
        raise OilfilmError(
            f"config/rigs/{name}.yaml: lacks the contact (`ball_radius_m`, `ball`, `disc`, "
            "roughness), without which neither load nor film of a test is known. Add it."
        )
    if properties is None:
        raise OilfilmError(
            f"{oil}: its properties are not known, so that no film can be calculated. Write "
            f"config/oils/{oil}.yaml and list it under `oils` of the campaign."
        )
    fitted = FittedLaw.of(results.coefficients, oil, results.refits, results.fit_quality)
    known = known_of(fitted, results.points, oil, rig.calibration)
    film = Film(contact, properties, settings.film)
    plan = settings.plan
    feasible = candidates(plan.levels, rig, name, film, settings.gates.lambda_limit, known)
    new = known.of_curves(feasible.curves)
    wanted: dict[str, Wanted] = {}
    if request.bearing is not None and set(request.targets) & set(BEARING_TARGETS):
        in_bearings = oils_in_bearings(results.coefficients, results.fit_quality, settings)
        own = [each for each in in_bearings if each.name == oil]
        if not own:
            raise OilfilmError(
                f"{oil}: the rigs of the campaign have different contacts, so that its law cannot "
                "be taken into a bearing. Plan for traction, or for a campaign of one rig."
            )
        wanted |= wanted_in_bearing(own[0], request.bearing, request.duty, known)
    if "traction" in request.targets:
        wanted["traction"] = wanted_traction(plan.traction_at, known)
    return [
        NextTests(
            oil,
            "" if target == "traction" or request.bearing is None else request.bearing.name,
            known,
            wanted[target],
            feasible,
            choose(known.information, new, wanted[target].gradients, request.count),
        )
        for target in request.targets
    ]


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
    table = pd.concat(parts, ignore_index=True) if parts else tables.empty("test_plan")
    return tables.conform(table[tables.columns("test_plan")], "test_plan", "test_plan"), reasons
