"""Planner: tests at rig conditions that most reduce the uncertainty of a bearing's torque.

The form of the law may be wrong by a few per cent, which change over the conditions. Hence tests
near the conditions of the bearing's contacts are better than a power law far from them.

`oilfilm.torque.run_plan` plans the runs without which no law can be judged.

Decides: which tests make the torque of a bearing, or mu, most certain.
"""

from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from oilfilm.base.errors import OilfilmError
from oilfilm.base.units import FloatArray
from oilfilm.bearing.geometry import Bearing
from oilfilm.fits.fitted import FittedLaw
from oilfilm.fits.measured_curves import (
    Design,
    FormError,
    Information,
    choose,
    measured_information,
)
from oilfilm.fits.problem import Curves
from oilfilm.settings.config import PlanLevels, PlanSettings
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.torque.answers import DUTY, duty_points
from oilfilm.torque.bearing_torque import joined, oils_in_bearings
from oilfilm.torque.feasible_tests import PlannedRig, counted, judge_tests
from oilfilm.torque.operating_grid import Film, Grid
from oilfilm.torque.wanted_quantities import (
    BEARING_TARGETS,
    Wanted,
    wanted_in_bearing,
    wanted_traction,
)
from oilfilm.traction.law import CONDITIONS

# Smallest span of the tests to choose from, in ln p, ln U and degC. A plan may have only one level
# of a condition.
_SMALLEST_SPAN = np.array([0.1, 0.1, 10.0])


@dataclass(frozen=True)
class Candidates:
    """Tests that a rig can run.

    Attributes:
        tests: One row per test: P, U, T, load, largest slip, lambda at that slip.
        curves: Points of the tests.
        left_out: Number of conditions left out, by the limit that they are beyond.
    """

    tests: pd.DataFrame
    curves: Curves
    left_out: dict[str, int]


def candidates(
    levels: PlanLevels, rig: PlannedRig, film: Film, lambda_limit: float, information: Information
) -> Candidates:
    """The tests at the levels of a plan that a rig can run with a full film.

    A test has those slips of the measured curves that the rig and its speed sensor reach.

    Args:
        levels: Levels of the three conditions.
        rig: The rig.
        film: Film of the oil in the rig's contact.
        lambda_limit: A film is full above this ratio.
        information: Information of the measured curves: the law, its constants and the slips.

    Raises:
        OilfilmError: No test is left.
    """
    slip = information.slip
    tests = _all_tests(levels)
    load = rig.contact.load_n(tests["max_hertz_pressure_gpa"].to_numpy())
    mu = _expected_mu(information, tests, load)
    conditions = tests[list(CONDITIONS)].to_numpy(dtype=float)
    judged = judge_tests(rig, film, lambda_limit, conditions, slip, mu)
    is_feasible = judged.is_feasible
    if not is_feasible.any():
        raise OilfilmError(
            f"config/rigs/{rig.name}.yaml, plan.levels: none of {len(tests)} conditions can be "
            f"run; they are beyond {counted(judged.left_out)}. Change plan.levels, or correct the "
            "rig's limits."
        )
    tests = tests.assign(
        load_n=load, slide_roll_ratio=judged.largest_slip, lambda_ratio=judged.smallest_lambda
    )
    feasible_tests = tests[is_feasible].reset_index(drop=True)
    is_reached = judged.is_reached[is_feasible]
    all_slips = np.broadcast_to(slip, is_reached.shape)
    curves = Curves(
        conditions=feasible_tests[list(information.law.conditions)].to_numpy(dtype=float),
        load_n=feasible_tests["load_n"].to_numpy(),
        curve=np.repeat(np.arange(len(feasible_tests)), is_reached.sum(axis=1)),
        slip=all_slips[is_reached],
    )
    return Candidates(feasible_tests, curves, judged.left_out)


def _all_tests(levels: PlanLevels) -> pd.DataFrame:
    """P, U and T of all combinations of the levels."""
    grid = Grid(
        max_hertz_pressure_gpa=np.array(levels.max_hertz_pressure_gpa, dtype=float),
        entrainment_speed_m_s=np.array(levels.entrainment_speed_m_s, dtype=float),
        inlet_temperature_c=np.array(levels.inlet_temperature_c, dtype=float),
        slide_roll_ratio=np.zeros(1),
    )
    return grid.operating_points()[list(CONDITIONS)]


def _expected_mu(information: Information, tests: pd.DataFrame, load: FloatArray) -> FloatArray:
    """mu of the fitted law at each test and measured slip, shape (tests, slips)."""
    law = information.law
    slip = information.slip
    with_load = tests.assign(load_n=load)
    curves = Curves(
        conditions=with_load[list(law.conditions)].to_numpy(dtype=float),
        load_n=load,
        curve=np.repeat(np.arange(len(tests)), len(slip)),
        slip=np.tile(slip, len(tests)),
    )
    mu = law.traction(information.internal, curves.observations(law))
    return mu.reshape(len(tests), len(slip))


@dataclass(frozen=True)
class NextTests:
    """The tests to run next for one oil and one target.

    Attributes:
        oil: Name of the oil.
        bearing: Name of the bearing; empty for the target traction.
        information: Information of the measured curves.
        wanted: Quantities whose uncertainty is to be reduced.
        candidates: Tests that the rig can run.
        gradients: Gradients of these quantities by all parameters of `information`.
        design: The chosen tests, and the uncertainty before and after them.
    """

    oil: str
    bearing: str
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
            bearing=self.bearing,
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
        return Request(("traction",), count, bearing=None, duty=np.empty((0, len(DUTY))))
    return Request(BEARING_TARGETS, count, bearing, duty_points(settings, bearing))


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
    rig = PlannedRig.of_campaign(settings)
    properties = settings.properties_of(oil)
    if properties is None:
        raise OilfilmError(
            f"{oil}: its properties are not known, so that no film can be calculated. Write "
            f"config/oils/{oil}.yaml and list it under `oils` of the campaign."
        )
    fitted = FittedLaw.of_configured(results, oil)
    information = measured_information(fitted, results.points, oil, rig.calibration)
    film = Film(rig.contact, properties, settings.film.thickness)
    levels = settings.plan.levels
    feasible = candidates(levels, rig, film, settings.gates.lambda_limit, information)
    wanted_by_target = _wanted(results, settings, oil, request, information, rig)
    return [
        _next_tests(oil, request, settings.plan, wanted_by_target[target], information, feasible)
        for target in request.targets
    ]


def _wanted(
    results: CampaignTables,
    settings: Settings,
    oil: str,
    request: Request,
    information: Information,
    rig: PlannedRig,
) -> dict[str, Wanted]:
    """The quantities of a request, by target.

    Raises:
        OilfilmError: The law cannot be used in the bearing, or as `wanted_in_bearing` and
            `wanted_traction`.
    """
    wanted_by_target: dict[str, Wanted] = {}
    is_for_bearing = not set(request.targets).isdisjoint(BEARING_TARGETS)
    if request.bearing is not None and is_for_bearing:
        quality = results.fit_quality[results.fit_quality["oil"] == oil]
        oil_in_bearing = oils_in_bearings(results.coefficients, quality, settings)
        if not oil_in_bearing:
            raise OilfilmError(
                f"{oil}: the rigs of the campaign have different contacts, so that its law cannot "
                "be used in a bearing. Plan for traction, or for a campaign of one rig."
            )
        wanted_by_target |= wanted_in_bearing(
            oil_in_bearing[0], request.bearing, request.duty, information, rig.contact
        )
    if "traction" in request.targets:
        points = settings.plan.traction_at
        wanted_by_target["traction"] = wanted_traction(points, information, rig.contact)
    return wanted_by_target


def _next_tests(
    oil: str,
    request: Request,
    plan: PlanSettings,
    wanted: Wanted,
    information: Information,
    feasible: Candidates,
) -> NextTests:
    """The tests of one oil that make the wanted quantities most certain."""
    form = _form_error(plan, wanted, information, feasible.curves)
    information_with_form = replace(information, form=form)
    gradients = information_with_form.gradients(wanted.gradients, wanted.lever, wanted.coordinates)
    design = choose(
        information_with_form.precision,
        information_with_form.of_curves(feasible.curves),
        gradients,
        request.count,
        plan.smallest_gain,
    )
    bearing = ""
    if request.bearing is not None and wanted.target in BEARING_TARGETS:
        bearing = request.bearing.name
    return NextTests(
        oil=oil,
        bearing=bearing,
        information=information_with_form,
        wanted=wanted,
        candidates=feasible,
        gradients=gradients,
        design=design,
    )


def _form_error(
    plan: PlanSettings, wanted: Wanted, information: Information, tests: Curves
) -> FormError:
    """Possible error of the law's form, with lengths relative to the span of the feasible tests."""
    of_tests = information.form_coordinates(tests)
    of_wanted = wanted.coordinates.reshape(-1, of_tests.shape[1])
    of_measured = information.form_coordinates(information.curves)
    span = np.maximum(np.ptp(of_tests, axis=0), _SMALLEST_SPAN)
    length = plan.form_error.length * span
    coordinates = np.concatenate([of_wanted, of_measured, of_tests])
    return FormError.spread_over(plan.form_error.size, length, coordinates)


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
