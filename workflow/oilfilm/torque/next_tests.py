"""Planner: tests at rig conditions that most reduce the uncertainty of a bearing's torque.

The form of the law may be wrong, by as much as the measured surface leaves open and by more where
nothing was tested. Hence tests near the conditions of the bearing's contacts are better than a
power law far from them.

Tests of traction reduce the law's part of the uncertainty alone. Drag, feed oil and temperatures of
the rings leave the rest, which the table `test_plan` has as well. Tests are chosen by the law's
part: the rest does not change their order. No test is planned for the torque where another cause
makes the largest share of its variance. Tests for the cage slip are planned in any case, because
oils that share their drag differ by their laws.

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
    CurvePlan,
    FormErrorProcess,
    Information,
    choose_curves,
    measured_information,
)
from oilfilm.fits.problem import Curves
from oilfilm.physics.contact import Floats
from oilfilm.settings.config import PlanLevels, PlanSettings
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CURVE_COLUMNS, CampaignTables
from oilfilm.torque.answers import DUTY_COLUMNS, UncertaintyBudget, duty_points, uncertainty_budgets
from oilfilm.torque.bearing_torque import OilInBearing, oils_with_uncertainty, stack_tables
from oilfilm.torque.feasible_tests import PlannedRig, judge_tests, limits_with_counts
from oilfilm.torque.operating_grid import Grid, OilFilm
from oilfilm.torque.wanted_quantities import (
    BEARING_TARGETS,
    WantedQuantities,
    wanted_in_bearing,
    wanted_traction,
)
from oilfilm.traction.law import CONDITIONS

# Smallest span of the tests to choose from, in ln p, ln U and degC. A plan may have only one level
# of a condition.
_SMALLEST_SPAN = np.array([0.1, 0.1, 10.0])


@dataclass(frozen=True)
class CandidateTests:
    """Tests that a rig can run.

    Attributes:
        tests: One row per test: P, U, T, load, largest slip, lambda at that slip.
        curves: Points of the tests.
        form_error: Relative standard error of the law's form at each point, shape (points,).
        left_out_count_by_limit: Number of conditions left out, by the limit that they are beyond.
    """

    tests: pd.DataFrame
    curves: Curves
    form_error: FloatArray
    left_out_count_by_limit: dict[str, int]


def feasible_candidates(
    levels: PlanLevels,
    rig: PlannedRig,
    film: OilFilm,
    lambda_limit: float,
    information: Information,
) -> CandidateTests:
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
    slip = information.longest_curve_slips
    tests = _all_tests(levels)
    load_n = rig.contact.load_n(tests["max_hertz_pressure_gpa"].to_numpy())
    mu = _expected_mu(information, tests, load_n)
    conditions = tests[list(CONDITIONS)].to_numpy(dtype=float)
    judged = judge_tests(rig, film, lambda_limit, conditions, slip, mu)
    is_feasible = judged.is_feasible
    if not is_feasible.any():
        raise OilfilmError(
            f"config/rigs/{rig.name}.yaml, plan.levels: none of {len(tests)} conditions can be "
            f"run; they are beyond {limits_with_counts(judged.left_out_count_by_limit)}. "
            "Change plan.levels, or correct the rig's limits."
        )
    tests = tests.assign(
        load_n=load_n, slide_roll_ratio=judged.largest_slip, lambda_ratio=judged.smallest_lambda
    )
    feasible_tests = tests[is_feasible].reset_index(drop=True)
    is_reached = judged.is_reached[is_feasible]
    all_slips = np.broadcast_to(slip, is_reached.shape)
    curves = Curves(
        conditions=feasible_tests[list(information.law.conditions)].to_numpy(dtype=float),
        load_n=feasible_tests["load_n"].to_numpy(),
        curve_of_point=np.repeat(np.arange(len(feasible_tests)), is_reached.sum(axis=1)),
        slip=all_slips[is_reached],
    )
    form_error = information.form_error_at(curves.conditions[curves.curve_of_point], curves.slip)
    return CandidateTests(feasible_tests, curves, form_error, judged.left_out_count_by_limit)


def _all_tests(levels: PlanLevels) -> pd.DataFrame:
    """P, U and T of all combinations of the levels."""
    grid = Grid(
        max_hertz_pressure_gpa=np.array(levels.max_hertz_pressure_gpa, dtype=float),
        entrainment_speed_m_s=np.array(levels.entrainment_speed_m_s, dtype=float),
        inlet_temperature_c=np.array(levels.inlet_temperature_c, dtype=float),
        slide_roll_ratio=np.zeros(1),
    )
    return grid.operating_points()[list(CONDITIONS)]


def _expected_mu(information: Information, tests: pd.DataFrame, load_n: FloatArray) -> FloatArray:
    """mu of the fitted law at each test and measured slip, shape (tests, slips)."""
    law = information.law
    slip = information.longest_curve_slips
    with_load = tests.assign(load_n=load_n)
    curves = Curves(
        conditions=with_load[list(law.conditions)].to_numpy(dtype=float),
        load_n=load_n,
        curve_of_point=np.repeat(np.arange(len(tests)), len(slip)),
        slip=np.tile(slip, len(tests)),
    )
    mu = law.traction(information.internal_constants, curves.observations(law))
    return mu.reshape(len(tests), len(slip))


@dataclass(frozen=True)
class NextTests:
    """The tests to run next for one oil and one target.

    Attributes:
        oil_name: Name of the oil.
        bearing_name: Name of the bearing; empty for the target traction.
        budget: What makes the target uncertain in the bearing; None where that is not known.
        irreducible_uncertainty: Part of the uncertainty that no test of traction reduces, as a root
            mean square over the wanted quantities.
        information: Information of the measured curves.
        wanted: Quantities whose uncertainty is to be reduced.
        candidates: Tests that the rig can run.
        gradients: Gradients of these quantities by all parameters of `information`.
        curve_plan: The chosen tests, and the law's part of the uncertainty before and after them.
    """

    oil_name: str
    bearing_name: str
    budget: UncertaintyBudget | None
    irreducible_uncertainty: float
    information: Information
    wanted: WantedQuantities
    candidates: CandidateTests
    gradients: FloatArray
    curve_plan: CurvePlan

    def total_uncertainty(self, uncertainty_by_law: Floats) -> FloatArray:
        """The whole uncertainty with some parts by the law, of the shape of these parts."""
        return np.hypot(uncertainty_by_law, self.irreducible_uncertainty)

    def table(self) -> pd.DataFrame:
        """Rows of the table `test_plan`."""
        curve_plan = self.curve_plan
        tests = self.candidates.tests
        test_order = np.zeros(len(tests), dtype=np.int64)
        test_order[curve_plan.chosen_indices] = np.arange(1, len(curve_plan.chosen_indices) + 1)
        uncertainty_with_plan = np.full(len(tests), np.nan)
        uncertainty_with_plan[curve_plan.chosen_indices] = self.total_uncertainty(
            curve_plan.uncertainty_after
        )
        return tests.assign(
            oil=self.oil_name,
            bearing=self.bearing_name,
            target=self.wanted.target,
            test_order=test_order,
            uncertainty_without_law=self.irreducible_uncertainty,
            uncertainty_now=float(self.total_uncertainty(curve_plan.uncertainty_before)),
            uncertainty_with_test=self.total_uncertainty(curve_plan.uncertainty_with_one),
            uncertainty_with_plan=uncertainty_with_plan,
        )


@dataclass(frozen=True)
class PlanRequest:
    """Request for a plan.

    Attributes:
        targets: Quantities whose uncertainty is to be reduced.
        test_count: Number of tests.
        bearing: The bearing; None for the target traction.
        duty: Operating points of the bearing, rows of load, speed and temperature.
    """

    targets: tuple[str, ...]
    test_count: int
    bearing: Bearing | None
    duty: FloatArray


def request_from_settings(settings: Settings, bearing: Bearing | None = None) -> PlanRequest:
    """The request of the settings.

    Args:
        settings: The settings.
        bearing: A bearing in place of the campaign's.
    """
    test_count = settings.plan.tests
    if bearing is None and settings.campaign.torque is not None:
        bearing = settings.tested_bearing()
    if bearing is None:
        return PlanRequest(
            ("traction",), test_count, bearing=None, duty=np.empty((0, len(DUTY_COLUMNS)))
        )
    return PlanRequest(BEARING_TARGETS, test_count, bearing, duty_points(settings, bearing))


def plan_tests(
    results: CampaignTables, settings: Settings, oil_name: str, request: PlanRequest
) -> list[NextTests]:
    """The tests to run next for an oil, one plan for each target.

    Args:
        results: Tables coefficients, fit_quality, refits, curve_residuals, surfaces, surface_sizes
            and points.
        settings: The settings.
        oil_name: Name of the oil.
        request: The request.

    Raises:
        OilfilmError: Rig, oil or fit lack something that a plan needs.
    """
    rig = PlannedRig.from_settings(settings)
    properties = settings.properties_of(oil_name)
    if properties is None:
        raise OilfilmError(
            f"{oil_name}: its properties are not known, so that no film can be calculated. Write "
            f"config/oils/{oil_name}.yaml and list it under `oils` of the campaign."
        )
    fitted = FittedLaw.from_results(results, oil_name)
    law_error_beyond = settings.bearing.law_error_beyond
    points = results.table("points", CURVE_COLUMNS, oil=oil_name)
    information = measured_information(fitted, points, oil_name, rig.calibration, law_error_beyond)
    film = OilFilm(rig.contact, properties, settings.film.thickness)
    levels = settings.plan.levels
    candidates = feasible_candidates(levels, rig, film, settings.gates.lambda_limit, information)
    plans = []
    targets_in_bearing = [target for target in request.targets if target in BEARING_TARGETS]
    if request.bearing is not None and targets_in_bearing:
        oil_in_bearing = _oil_in_bearing(results, settings, oil_name)
        wanted_by_target = wanted_in_bearing(
            oil_in_bearing, request.bearing, request.duty, information, rig.contact
        )
        budget_by_target = uncertainty_budgets(
            oil_in_bearing, request.bearing, request.duty, settings
        )
        for target in targets_in_bearing:
            budget = budget_by_target[target]
            wanted = wanted_by_target[target].keep_known_points(
                np.isfinite(budget.irreducible_uncertainty_of_point),
                "too many draws have no equilibrium",
            )
            plans.append(
                _plan_for_target(
                    oil_name, request, settings.plan, wanted, information, candidates, budget
                )
            )
    if "traction" in request.targets:
        wanted = wanted_traction(settings.plan.traction_at, information, rig.contact)
        plans.append(
            _plan_for_target(oil_name, request, settings.plan, wanted, information, candidates)
        )
    return plans


def _oil_in_bearing(results: CampaignTables, settings: Settings, oil_name: str) -> OilInBearing:
    """An oil with its law in bearings, and everything that its uncertainty is made of.

    Raises:
        OilfilmError: The law cannot be used in a bearing.
    """
    for oil_in_bearing in oils_with_uncertainty(results, settings):
        if oil_in_bearing.name == oil_name:
            return oil_in_bearing
    for rig_name, rig in settings.rigs.items():
        if rig.contact() is None:
            raise OilfilmError(
                f"config/rigs/{rig_name}.yaml: lacks the contact (`ball_radius_m`, `ball`, "
                f"`disc`), so that the law of {oil_name} cannot be used in a bearing. Add it, or "
                "plan for traction."
            )
    raise OilfilmError(
        f"{oil_name}: the rigs of the campaign have different contacts, so that its law cannot "
        "be used in a bearing. Plan for traction, or for a campaign of one rig."
    )


def _plan_for_target(
    oil_name: str,
    request: PlanRequest,
    plan_settings: PlanSettings,
    wanted: WantedQuantities,
    information: Information,
    candidates: CandidateTests,
    budget: UncertaintyBudget | None = None,
) -> NextTests:
    """The tests of one oil that make the wanted quantities most certain.

    Args:
        oil_name: Name of the oil.
        request: The request.
        plan_settings: Settings of plans.
        wanted: The quantities.
        information: Information of the measured curves.
        candidates: Tests that the rig can run.
        budget: What makes the quantities uncertain in a bearing; None for mu.
    """
    form_process = _form_error_over_tests(plan_settings, wanted, information, candidates.curves)
    information_with_form = replace(information, form_process=form_process)
    gradients = information_with_form.gradients(
        wanted.gradients, wanted.change_by_form_error, wanted.coordinates
    )
    bearing_name = ""
    test_count = request.test_count
    irreducible_uncertainty = 0.0
    if request.bearing is not None and budget is not None:
        bearing_name = request.bearing.name
        irreducible_uncertainty = float(
            np.sqrt(np.mean(budget.irreducible_uncertainty_of_point[wanted.point_index] ** 2))
        )
        if wanted.target == "torque" and not budget.tests_may_help:
            test_count = 0
    curve_plan = choose_curves(
        information_with_form.precision,
        information_with_form.precision_of_curves(candidates.curves, candidates.form_error),
        gradients,
        test_count,
        plan_settings.smallest_gain,
    )
    return NextTests(
        oil_name=oil_name,
        bearing_name=bearing_name,
        budget=budget,
        irreducible_uncertainty=irreducible_uncertainty,
        information=information_with_form,
        wanted=wanted,
        candidates=candidates,
        gradients=gradients,
        curve_plan=curve_plan,
    )


def _form_error_over_tests(
    plan_settings: PlanSettings,
    wanted: WantedQuantities,
    information: Information,
    test_curves: Curves,
) -> FormErrorProcess:
    """Error of the law's form over its size, with lengths relative to the span of the tests."""
    test_coordinates = information.form_coordinates(test_curves)
    wanted_coordinates = wanted.coordinates.reshape(-1, test_coordinates.shape[1])
    measured_coordinates = information.form_coordinates(information.curves)
    span = np.maximum(np.ptp(test_coordinates, axis=0), _SMALLEST_SPAN)
    coordinate_lengths = plan_settings.form_error_length * span
    coordinates = np.concatenate([wanted_coordinates, measured_coordinates, test_coordinates])
    return FormErrorProcess.spread_over(coordinate_lengths, coordinates)


def plan_table(results: CampaignTables, settings: Settings) -> tuple[pd.DataFrame, list[str]]:
    """The table `test_plan` of a campaign, and the reasons why oils have no rows in it."""
    request = request_from_settings(settings)
    plans = []
    reasons = []
    for oil_name in settings.oils:
        try:
            plans += [plan.table() for plan in plan_tests(results, settings, oil_name, request)]
        except OilfilmError as error:
            reasons.append(str(error))
    return stack_tables(plans, "test_plan"), reasons
