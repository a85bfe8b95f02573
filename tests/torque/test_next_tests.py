"""Tests to run next: what a plan promises is what refits of simulated tests then show."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd
import pytest
from scipy.stats import chi2

from bearings import exact_keys
from campaigns import without
from fit_points import LAW
from oilfilm.base.errors import OilfilmError
from oilfilm.base.randomness import generator
from oilfilm.base.units import FloatArray
from oilfilm.fits.fit import fit_oil
from oilfilm.fits.fitted import FittedLaw, predict
from oilfilm.fits.measured_curves import (
    ErrorVariances,
    Information,
    choose_curves,
    covariance,
    measured_information,
    uncertainties,
)
from oilfilm.settings.config import BearingSettings
from oilfilm.settings.resolved import Settings
from oilfilm.settings.rig import FullScale
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.torque.answers import operating_point_table
from oilfilm.torque.bearing_torque import CaseGroup, FrictionCases, oils_with_uncertainty
from oilfilm.torque.feasible_tests import PlannedRig, judge_tests
from oilfilm.torque.load_variables import LawInBearing
from oilfilm.torque.next_tests import (
    PlanRequest,
    feasible_candidates,
    plan_table,
    plan_tests,
    request_from_settings,
)
from oilfilm.torque.operating_grid import OilFilm
from oilfilm.torque.torque_uncertainty import RANDOM_FACTOR_TERMS
from oilfilm.torque.wanted_quantities import wanted_in_bearing, wanted_traction
from oilfilm.traction.law import CONDITIONS, to_constants
from pictures import draw, nothing_is_cut_off
from planned_tests import (
    CONTACT,
    DUTY,
    OIL,
    SETTINGS,
    SLIP,
    SMALL_PLAN,
    TRUE_CONSTANTS,
    Errors,
    curves_at,
    oil_in_bearing,
    refit,
    run_tests,
    torques,
)

# Nothing but the law is uncertain.
LAW_ALONE = SETTINGS.with_changes(
    {
        "bearings": {"mainshaft-167": exact_keys("mainshaft-167")},
        "bearing": {
            **{
                f"{name}_range": [value * (1 - 1e-9), value]
                for name, (value, _, _) in SETTINGS.bearing.uncertain_inputs().items()
            },
            "term_uncertainty": dict.fromkeys(RANDOM_FACTOR_TERMS, 0.0),
            "stand_in_uncertainty": {"viscosity": 0.0, "pressure_viscosity_coefficient": 0.0},
        },
    }
)
RUN_ERRORS, RIG_ERRORS = Errors(), np.array([0.004, 0.003, 0.001, 0.4])
RIG_NAME = "ball-on-disc-20mm"
REPEATS = 150


@pytest.fixture(scope="module")
def information() -> Information:
    """What the small matrix tells, with the errors as planted and the constants as they are."""
    sizes = ErrorVariances(RUN_ERRORS.of_curve**2, RUN_ERRORS.point**2)
    free = np.ones(len(TRUE_CONSTANTS), dtype=bool)
    return Information(
        LAW, TRUE_CONSTANTS, free, curves_at(SMALL_PLAN), sizes, RIG_ERRORS, SLIP, true_form
    )


def true_form(conditions: FloatArray, slip: FloatArray) -> FloatArray:
    """A law whose form is the planted one has no error of its form."""
    return np.zeros(len(slip))


def actual_errors(added_tests: list[tuple[float, float, float]]) -> FloatArray:
    """Relative errors of the torque after simulated tests and a refit, (repeats, duty points)."""
    constants = []
    for repeat_index in range(REPEATS):
        random = generator(repeat_index, "planned")
        errors_of_rig = RIG_ERRORS * random.standard_normal(4)
        constants.append(
            refit(
                run_tests(SMALL_PLAN + added_tests, random, RUN_ERRORS, errors_of_rig),
                RUN_ERRORS,
                RIG_ERRORS,
            )
        )
    return np.asarray(np.log(torques(np.array(constants)) / torques(TRUE_CONSTANTS[np.newaxis])))


@pytest.mark.slow
def test_torque_after_the_planned_tests_scatters_as_the_plan_promised(
    information: Information,
) -> None:
    """Standard deviations of 150 simulated campaigns, within the 99.9 % range of chi-square."""
    film = OilFilm(CONTACT, SETTINGS.oil_with_properties(OIL), SETTINGS.film.thickness)
    rig = PlannedRig.from_settings(SETTINGS)
    lambda_limit = SETTINGS.gates.lambda_limit
    feasible = feasible_candidates(SETTINGS.plan.levels, rig, film, lambda_limit, information)
    wanted_by_target = wanted_in_bearing(
        oil_in_bearing(), SETTINGS.tested_bearing(), DUTY, information, CONTACT
    )
    wanted_torque = wanted_by_target["torque"]
    change_by_form_error = np.zeros(len(wanted_torque.traction_gradient))
    gradients = information.gradients(
        wanted_torque.gradients, change_by_form_error, wanted_torque.coordinates
    )
    precision_of_test = information.precision_of_curves(feasible.curves, feasible.form_error)
    design = choose_curves(information.precision, precision_of_test, gradients, 4)
    added_tests = [
        tuple(row) for row in feasible.tests[list(CONDITIONS)].to_numpy()[design.chosen_indices]
    ]
    promised = uncertainties(design.final_precision, gradients)
    ratio = np.sqrt(np.mean(actual_errors(added_tests) ** 2, axis=0)) / promised
    lowest_ratio, highest_ratio = np.sqrt(chi2.ppf([0.0005, 0.9995], REPEATS) / REPEATS)
    assert (lowest_ratio < ratio).all(), ratio
    assert (ratio < highest_ratio).all(), ratio


@pytest.fixture(scope="module")
def results() -> CampaignTables:
    """A small measured campaign: fit with its refits, and the points."""
    points = run_tests(SMALL_PLAN, generator(7, "campaign"), RUN_ERRORS)
    quick = SETTINGS.with_changes({"fit": {"searches": 2, "bootstrap": 200}}).fit
    fit = fit_oil(points, OIL, quick, 1)
    return fit.replace(points=points)


@pytest.fixture(scope="module")
def request_for() -> PlanRequest:
    return replace(request_from_settings(SETTINGS), duty=DUTY, test_count=3)


def test_what_is_known_is_no_less_than_what_the_refits_know(results: CampaignTables) -> None:
    # Gauss and Markov: generalised least squares is the best linear estimate. The bootstrap over 12
    # curves knows a standard error to some 20 %
    fitted = FittedLaw.from_tables(results.coefficients, OIL, results.refits, results.fit_quality)
    information = measured_information(fitted, results.points, OIL, None, 0.0)
    assert not information.calibration_uncertainties.any()
    ours = np.diag(covariance(information.precision))[: len(TRUE_CONSTANTS)]
    ratio = np.sqrt(ours / np.diag(fitted.coefficients.covariance(LAW)))
    assert (ratio < 1.3).all()
    assert (ratio > 0.1).all()


@pytest.mark.nightly
def test_tests_near_the_contacts_win(results: CampaignTables, request_for: PlanRequest) -> None:
    """Distances of the first test from the contacts, in spans of the tests to choose from."""
    mean_distances = []
    for law_error in (1e-6, 0.15):
        settings = SETTINGS.with_changes({"bearing": {"law_error_beyond": law_error}})
        (plan,) = plan_tests(results, settings, OIL, replace(request_for, targets=("cage_slip",)))
        test_coordinates = plan.information.form_coordinates(plan.candidates.curves)
        span = np.ptp(test_coordinates, axis=0)
        contact_coordinates = plan.wanted.coordinates.reshape(-1, 3)
        scaled_distance = (
            test_coordinates[plan.curve_plan.chosen_indices][:, np.newaxis] - contact_coordinates
        ) / span
        mean_distances.append(np.linalg.norm(scaled_distance, axis=-1).min(axis=1).mean())
    assert mean_distances[1] < 0.7 * mean_distances[0]


@pytest.mark.slow
def test_the_plan_has_the_whole_uncertainty_of_the_bearing(
    results: CampaignTables, request_for: PlanRequest
) -> None:
    """Beside the standard deviations of draws, and without tests for a torque that drag decides."""
    (oil,) = oils_with_uncertainty(results, SETTINGS)
    points = operating_point_table(SETTINGS.tested_bearing(), *DUTY.T)
    cases = FrictionCases(SETTINGS.tested_bearing(), [CaseGroup(oil, "stress", points)])
    drawn, _, _ = cases.calculate_with_uncertainty(SETTINGS.seed)
    uncertainty_of_target = {
        "torque": drawn["torque_n_m_uncertainty"] / drawn["torque_n_m"],
        "cage_slip": drawn["cage_slip_uncertainty"],
    }
    torque_plan, slip_plan = plan_tests(results, SETTINGS, OIL, request_for)
    for plan in (torque_plan, slip_plan):
        table = plan.table()
        expected = np.sqrt((uncertainty_of_target[plan.wanted.target] ** 2).mean())
        # the law is drawn through the equilibrium there, and taken by its slopes here
        assert table["uncertainty_now"].iloc[0] == pytest.approx(expected, rel=0.1)
        without_law = table["uncertainty_without_law"].iloc[0]
        assert (table["uncertainty_with_test"] >= without_law).all()
    assert torque_plan.irreducible_uncertainty > 0.9 * torque_plan.total_uncertainty(
        torque_plan.curve_plan.uncertainty_before
    )
    assert not torque_plan.curve_plan.chosen_indices
    assert len(slip_plan.curve_plan.chosen_indices) == request_for.test_count


@pytest.mark.slow
def test_plan_keeps_to_what_the_rig_can_run(
    results: CampaignTables, request_for: PlanRequest
) -> None:
    """Stated 3 GPa, 50 m/s; lambda > 3; the first test of the table is the best one alone."""
    of_exact_bearing = replace(request_for, bearing=LAW_ALONE.tested_bearing())
    for plan in plan_tests(results, LAW_ALONE, OIL, of_exact_bearing):
        assert (plan.curve_plan.uncertainty_with_one <= plan.curve_plan.uncertainty_before).all()
        table = plan.table()
        # 3 GPa of this ball by Hertz; the assumed full scale of 200 N bounds nothing
        assert table["load_n"].max() == pytest.approx(1136, abs=1)
        fastest = table["entrainment_speed_m_s"] * (1 + table["slide_roll_ratio"] / 2)
        assert fastest.max() <= 50
        assert table["lambda_ratio"].min() > 3
        chosen_tests = table[table["test_order"] > 0].sort_values("test_order")
        assert chosen_tests["test_order"].tolist() == [1, 2, 3]
        first_test = chosen_tests.iloc[0]
        assert first_test["uncertainty_with_test"] == table["uncertainty_with_test"].min()
        assert first_test["uncertainty_with_plan"] == pytest.approx(
            first_test["uncertainty_with_test"]
        )
        assert chosen_tests["uncertainty_with_plan"].is_monotonic_decreasing
        assert sum(plan.candidates.left_out_count_by_limit.values()) + len(table) == 8 * 9 * 8


def test_gradients_of_the_torque_are_those_of_finite_changes_of_the_law(
    information: Information,
) -> None:
    """Against the torque with one constant moved by a tenth of its uncertainty."""
    bearing = SETTINGS.tested_bearing()
    wanted = wanted_in_bearing(oil_in_bearing(), bearing, DUTY, information, CONTACT)["torque"]
    step = 0.1 * np.sqrt(np.diag(covariance(information.precision))[: len(TRUE_CONSTANTS)])
    relative_change = (
        torques(TRUE_CONSTANTS + np.diag(step)) / torques(TRUE_CONSTANTS[np.newaxis]) - 1
    )
    expected = relative_change.T / step
    tolerance = 0.02 * np.abs(wanted.gradients).max()
    np.testing.assert_allclose(wanted.gradients, expected, atol=tolerance)


def test_operating_points_without_equilibrium_are_left_out_and_named(
    information: Information,
) -> None:
    crushed = np.array([[1e7, 12000.0, 100.0]])
    bearing = SETTINGS.tested_bearing()
    duty = np.concatenate([DUTY[:1], crushed])
    wanted = wanted_in_bearing(oil_in_bearing(), bearing, duty, information, CONTACT)["torque"]
    assert wanted.labels == ["10000 N, 9000 rpm, 100 degC"]
    assert wanted.left_out_reasons == ["1e+07 N, 12000 rpm, 100 degC: no equilibrium"]
    with pytest.raises(OilfilmError, match="no duty point has a steady motion"):
        wanted_in_bearing(oil_in_bearing(), bearing, crushed, information, CONTACT)


def test_a_film_that_the_formula_does_not_give_is_not_counted_as_a_thin_one() -> None:
    rig = replace(PlannedRig.from_settings(SETTINGS), full_scale=None)
    oil = SETTINGS.oil_with_properties("4102")
    film = OilFilm(rig.contact, oil, SETTINGS.film.thickness)
    # cold oil at high speed; hot oil at low speed; in between
    conditions = np.array([[3.0, 50.0, 25.0], [1.0, 5.0, 150.0], [1.0, 40.0, 60.0]])
    # the numerator of Gupta's reduction (docs/physics.md, Film) is not above 0 in cold oil
    heating = oil.dynamic_viscosity_pa_s(25.0) * oil.temperature_viscosity_coefficient_1_k(25.0)
    heating *= 50.0**2 / oil.thermal_conductivity_w_mk(25.0)
    assert 1 - 13.2 * 3.0e9 / rig.contact.reduced_modulus_pa * heating**0.42 < 0.1
    judged = judge_tests(rig, film, SETTINGS.gates.lambda_limit, conditions, SLIP, 0.03)
    counts = judged.left_out_count_by_limit
    assert judged.is_feasible.tolist() == [False, False, True]
    assert counts["a full film (lambda > 3)"] == 1
    assert counts["a film within the range of the formula"] == 1


def test_the_force_at_a_slip_that_the_rig_does_not_reach_refuses_no_test() -> None:
    rig = PlannedRig.from_settings(SETTINGS)
    # mu of 0.05 at the last slip, for which 1 + S/2 times 30 m/s is too fast
    slip, mu = np.array([0.01, 0.02, 0.05, 0.3]), np.array([0.01, 0.02, 0.03, 0.05])
    full_scale = FullScale(
        load_n=1e4,
        traction_force_n=0.04 * float(rig.contact.load_n(1.0)),
        surface_speed_m_s=31.0,
        temperature_c=200.0,
    )
    limited_rig = replace(rig, full_scale=full_scale)
    judged = judge_tests(limited_rig, None, 3.0, np.array([[1.0, 30.0, 60.0]]), slip, mu)
    assert judged.is_reached.tolist() == [[True, True, True, False]]
    assert judged.is_feasible.tolist() == [True]


@dataclass(frozen=True)
class Stepping:
    """Stands for an oil in a bearing: torque 2 + ln|A0/A0'|, at 1 N with a jump at the truth."""

    name: str = "stepping"
    constants: FloatArray | None = None
    bearing_settings: BearingSettings = SETTINGS.bearing

    @property
    def laws(self) -> Mapping[str, LawInBearing]:
        return oil_in_bearing().laws

    def with_constants(self, constants: FloatArray) -> "Stepping":
        return replace(self, constants=constants)

    def calculate(
        self, bearing: object, load: FloatArray, *_: FloatArray, traction_factor: FloatArray
    ) -> pd.DataFrame:
        assert self.constants is not None
        moved = np.log(self.constants[:, 0] / to_constants(LAW, TRUE_CONSTANTS)[0])
        torque = 2 + moved + np.where((load == 1) & (moved > 1e-6), 1.0, 0.0)
        columns: dict[str, float] = {"converged": True, "inlet_temperature_c": 100.0}
        for race in ("inner", "outer"):
            columns |= {f"{race}_max_hertz_pressure_gpa": 1.5}
            columns |= {
                f"{race}_entrainment_speed_m_s": 30.0,
                f"{race}_mean_slide_roll_ratio": 0.01,
            }
        return pd.DataFrame({"torque_n_m": torque, "cage_slip": 0.1 * torque, **columns})


def test_operating_points_where_the_motion_jumps_are_left_out_and_named(
    information: Information,
) -> None:
    duty = np.array([[1.0, 100, 100], [2.0, 100, 100]])
    wanted = wanted_in_bearing(Stepping(), SETTINGS.tested_bearing(), duty, information, CONTACT)
    assert wanted["torque"].left_out_reasons == [
        "1 N, 100 rpm, 100 degC: it jumps with the constants"
    ]
    # d ln(2 + x)/dx = 1/2 and d 0.1 (2 + x)/dx = 0.1, at x = ln|A0/A0'| = 0
    for target, slope in (("torque", 0.5), ("cage_slip", 0.1)):
        np.testing.assert_allclose(wanted[target].gradients, [[slope] + 11 * [0]], atol=1e-6)


def test_without_a_bearing_mu_is_planned_for(information: Information) -> None:
    """Gradients of ln mu against mu with a constant moved."""
    wanted = wanted_traction(SETTINGS.plan.traction_at, information, CONTACT)
    assert wanted.labels[0] == "1 GPa, 50 m/s, 100 degC, S 0.02"
    assert request_from_settings(without(SETTINGS, "torque")).targets == ("traction",)
    moved_constants = TRUE_CONSTANTS + 1e-5 * np.eye(len(TRUE_CONSTANTS))
    plan_points = SETTINGS.plan.traction_at
    points = [
        [getattr(point, name) for name in (*CONDITIONS, "slide_roll_ratio")]
        for point in plan_points
    ]
    for point, gradient in zip(points, wanted.gradients, strict=True):
        mu = [
            predict("deng2026", to_constants(LAW, row), *point).traction_coefficient
            for row in (TRUE_CONSTANTS, *moved_constants)
        ]
        slopes = (np.log(mu[1:]) - np.log(mu[0])) / 1e-5
        np.testing.assert_allclose(gradient, slopes, atol=1e-3 * np.abs(slopes).max())


LIMITS = "lacks the key `limits`"


@pytest.mark.parametrize(
    ("lacking", "sentence"),
    [(("limits",), LIMITS), (("ball_radius_m", "limits"), "lacks the contact")],
)
def test_a_rig_that_is_not_known_is_refused(
    results: CampaignTables, request_for: PlanRequest, lacking: tuple[str, ...], sentence: str
) -> None:
    plain = SETTINGS.plain_values()
    rig = {key: value for key, value in plain["rigs"][RIG_NAME].items() if key not in lacking}
    settings = Settings.from_plain_values({**plain, "rigs": {RIG_NAME: rig}})
    with pytest.raises(OilfilmError, match=sentence):
        plan_tests(results, settings, OIL, request_for)
    table, reasons = plan_table(results, settings)
    assert table.empty
    assert sentence in reasons[0]


def test_nothing_to_plan_is_told_and_refused(
    results: CampaignTables, request_for: PlanRequest
) -> None:
    without_refits = results.replace(refits=results.refits.iloc[:0])
    with pytest.raises(OilfilmError, match="too few curves"):
        plan_tests(without_refits, SETTINGS, OIL, request_for)
    one_run = results.points[results.points["run_id"] == "run000"]
    with pytest.raises(OilfilmError, match="do not tell the law's constants apart"):
        plan_tests(results.replace(points=one_run), SETTINGS, OIL, request_for)
    # a full scale that is known bounds the tests
    with_known_full_scale = {"rigs": {RIG_NAME: {"full_scale": {"assumed": []}}}}
    levels = {"plan": {"levels": {"max_hertz_pressure_gpa": [2.5, 3.5]}}}
    beyond_the_rig = SETTINGS.with_changes({**with_known_full_scale, **levels})
    with pytest.raises(OilfilmError, match=r"largest pressure \(72\), the load sensor's .* \(72\)"):
        plan_tests(results, beyond_the_rig, OIL, request_for)
    one_speed = run_tests(
        [(p, 30.0, t) for p, _, t in SMALL_PLAN], generator(8, "speed"), RUN_ERRORS
    )
    quick = SETTINGS.with_changes({"fit": {"searches": 2, "bootstrap": 20}}).fit
    fit_of_one_speed = fit_oil(one_speed, OIL, quick, 1)
    at_one_speed = fit_of_one_speed.replace(points=one_speed)
    with pytest.raises(OilfilmError, match="follows every condition"):
        plan_tests(at_one_speed, SETTINGS, OIL, request_for)


def test_a_plan_is_for_one_rig_and_contact(
    results: CampaignTables, request_for: PlanRequest
) -> None:
    plain = SETTINGS.plain_values()
    rig = plain["rigs"][RIG_NAME]
    rig_of_another_ball = {key: value for key, value in rig.items() if key != "limits"} | {
        "ball_radius_m": 0.02
    }
    settings = Settings.from_plain_values(
        {**plain, "rigs": {RIG_NAME: rig, "other": rig_of_another_ball}}
    )
    with pytest.raises(OilfilmError, match="different contacts"):
        plan_tests(results, settings, OIL, request_for)
    (plan,) = plan_tests(results, settings, OIL, replace(request_for, targets=("traction",)))
    assert len(plan.curve_plan.chosen_indices) == request_for.test_count
    rig_of_unknown_ball = {
        key: value for key, value in rig_of_another_ball.items() if key != "ball_radius_m"
    }
    settings = Settings.from_plain_values(
        {**plain, "rigs": {RIG_NAME: rig, "other": rig_of_unknown_ball}}
    )
    with pytest.raises(OilfilmError, match=r"config/rigs/other\.yaml"):
        plan_tests(results, settings, OIL, request_for)
    settings = Settings.from_plain_values({**plain, "rigs": {RIG_NAME: rig, "other": rig}})
    with pytest.raises(OilfilmError, match="A plan is for one rig"):
        plan_tests(results, settings, OIL, request_for)


@pytest.mark.slow
def test_map_of_tests_draws_what_the_table_has(results: CampaignTables) -> None:
    table, reasons = plan_table(results, LAW_ALONE)
    assert not reasons
    figure, drawn = draw("plan", results.replace(test_plan=table), LAW_ALONE)
    assert nothing_is_cut_off(figure)
    of_torque = table[table["target"] == "torque"]
    chosen = drawn[(drawn["series"] == "chosen") & (drawn["panel"] == "a")]
    assert sorted(chosen["value"]) == [1, 2, 3, 4, 5]
    largest_reduction = drawn.loc[drawn["series"] == "cell", "value"].max()
    reduction = 1 - of_torque["uncertainty_with_test"] / of_torque["uncertainty_now"]
    assert largest_reduction == pytest.approx(100 * reduction.max())
