"""Friction equilibria of light and skidding bearings: found, complete, the same in any company."""

from dataclasses import replace

import numpy as np
import pytest

from bearings import RPM, in_operation, printed_law, problem, shipped
from nights import nightly
from oilfilm.bearing import equilibria as search
from oilfilm.bearing.equilibria import NearbyEquilibria, _Motions, equilibria, friction_equilibrium
from oilfilm.bearing.friction import FrictionProblem
from oilfilm.bearing.inputs import InputValues
from oilfilm.bearing.quasistatic import OperatingPoints

MAINSHAFT = shipped("mainshaft-167")


def mainshaft_problem(
    oil: str, rpm: float, temperature_c: float, loads_n: list[float]
) -> FrictionProblem:
    points = OperatingPoints.from_load_and_speed(np.array(loads_n), rpm * RPM)
    return problem(MAINSHAFT, points, oil, temperature_c)


# Found by MINPACK's hybr from cage speeds of 1 to 0.1 of rolling, all seven residuals below 1e-9
# (mainshaft-167, the printed laws).
SKIDDING = [
    ("4010", 12000, 70.0, 5200.0, 0.21241),
    nightly("4010", 12000, 70.0, 775.0, 0.90803),
    nightly("4010", 18000, 40.0, 1059.0, 0.96716),
    ("4102", 18000, 40.0, 500.0, 0.99751),
    nightly("4102", 18000, 40.0, 603.0, 0.99472),
    nightly("4102", 18000, 40.0, 728.0, 0.99070),
]


@pytest.mark.slow
@pytest.mark.parametrize(("oil", "rpm", "temperature_c", "load_n", "slip"), SKIDDING)
def test_a_skidding_cage_is_found_where_an_independent_solver_finds_one(
    oil, rpm, temperature_c, load_n, slip
):
    motion = friction_equilibrium(mainshaft_problem(oil, rpm, temperature_c, [load_n]))
    assert motion.solution.converged.all()
    assert motion.solution.residual < 1e-9
    assert not motion.held_by_band().any()
    assert motion.cage_slip()[0] == pytest.approx(slip, abs=6e-6)
    assert motion.outside_law()[0] == (slip > 0.9)


def test_a_skidding_cage_is_found_where_every_curve_is_lost(monkeypatch):
    # beside balls at rest rounding decides whether a curve gets to its end
    def lose_curves(problem, rule, wants_all_motions):
        point_count = len(problem.scale())
        no_motions = _Motions.with_full_bands(np.arange(0), np.empty((0, 7)))
        return no_motions, np.ones(point_count, dtype=bool)

    monkeypatch.setattr(search, "_search_motions", lose_curves)
    # slips by MINPACK's hybr, as above
    loads_n, slips = [330.0, 350.0], [0.886024, 0.886679]
    motions = equilibria(mainshaft_problem("4010", 23875.251809, 70.0, loads_n))
    assert motions.fastest.solution.converged.all()
    np.testing.assert_allclose(motions.fastest.cage_slip(), slips, atol=6e-7)
    assert not motions.is_complete.any()


def values(loads_n: list[float]) -> np.ndarray:
    """Slips and torques of both ends and how many equilibria there are, a row per load."""
    motions = equilibria(mainshaft_problem("4010", 12000, 70.0, loads_n))
    columns = [motions.count]
    for equilibrium in (motions.fastest, motions.slowest):
        columns += [equilibrium.cage_slip(), equilibrium.torque_n_m(), equilibrium.held_by_band()]
    return np.column_stack(columns)


# 4010 at 12 000 rpm and 70 degC: a motion beyond a fold and one held between the sides of a jump;
# two with the cage all but at rest.
@pytest.mark.slow
@pytest.mark.parametrize("loads_n", [[5200.0, 642.07], nightly([775.0, 877.7])])
def test_a_point_has_the_same_equilibria_alone_and_in_any_company(loads_n):
    values_in_company = values([*loads_n, 20000.0])
    for point_index, load_n in enumerate(loads_n):
        values_alone = values([load_n])[0]
        np.testing.assert_allclose(values_in_company[point_index], values_alone, rtol=1e-9)
    np.testing.assert_allclose(values([load_n, load_n])[0], values_alone, rtol=1e-9)


@pytest.mark.slow
def test_rolling_and_skidding_cages_under_one_load_are_all_listed():
    # 4010 at 6 000 rpm, 40 degC and 2 879 N: slips of a trial of the method with a code of its own
    motions = equilibria(mainshaft_problem("4010", 6000, 40.0, [2879.0]))
    assert motions.count.tolist() == [3]
    assert motions.fastest.cage_slip()[0] == pytest.approx(0.0338, abs=6e-5)
    assert motions.slowest.cage_slip()[0] == pytest.approx(0.3537, abs=6e-5)


@pytest.mark.slow
def test_a_motion_between_the_sides_of_a_jump_is_marked():
    # the outer contact does not roll: on either side of that the cage's balance has another sign
    load_n, slip = 683.4988689104133, 0.7704
    motion = friction_equilibrium(mainshaft_problem("4010", 6000, 40.0, [load_n]))
    assert motion.held_by_band().all()
    assert motion.cage_slip()[0] == pytest.approx(slip, abs=5e-4)
    unbanded = mainshaft_problem("4010", 6000, 40.0, [load_n])
    residuals = unbanded.residuals(motion.solution.unknowns, np.arange(1))
    assert np.abs(residuals).max() > 1e-9


@pytest.mark.nightly
def test_a_motion_is_exact_where_the_curve_of_its_bands_stalls():
    # the bands shrink along a curve that ends before they are gone
    problem = mainshaft_problem("4010", 23900, 40.0, [998.014446])
    motion = equilibria(problem).fastest
    residuals = problem.residuals(motion.solution.unknowns, np.arange(1))
    assert np.abs(residuals).max() < 1e-10
    assert not motion.held_by_band().any()


@pytest.mark.nightly
def test_a_motion_between_the_sides_of_a_jump_is_found_again_beside_itself():
    # random draws are looked for in this way, 5 000 N beside it has no jump
    equilibrium = friction_equilibrium(
        mainshaft_problem("4010", 6000, 40.0, [683.4988689104133, 5000.0])
    )
    assert equilibrium.held_by_band().tolist() == [True, False]
    nearby_equilibria = NearbyEquilibria.from_unknowns(
        equilibrium.problem, equilibrium.solution.unknowns
    )
    for equilibrium_again in (
        friction_equilibrium(equilibrium.problem, nearby_equilibria),
        equilibria(equilibrium.problem).fastest,
    ):
        assert equilibrium_again.solution.converged.all()
        assert equilibrium_again.held_by_band().tolist() == [True, False]
        np.testing.assert_allclose(
            equilibrium_again.cage_slip(), equilibrium.cage_slip(), rtol=1e-9
        )


# A random draw of the demonstration at 500 N, 17 906 rpm and 100 degC: the cage is all but at rest.
DRAWN_INPUTS = {
    "oil_volume_fraction": 0.003340283080264223,
    "feed_flow_m3_s": 0.00016722162952067125,
    "momentum_share": 0.8111268796927915,
    "replenishment_constant": 5.957844388928576e-08,
    "ellipse_factor": 0.9690903125253894,
    "shaft_bore_ratio": 0.7313974590692954,
    "shaft_interference_m": 1.0354481241979671e-05,
    "housing_interference_m": 1.2921659614676795e-06,
    "ring_temperature_difference_k": -1.5895849100256818,
    "ball_temperature_difference_k": 11.242246287121343,
}
DRAWN_FACTORS = [1.1947404472, 1.001581958, 1.0945721285, 1.0, 1.6882372817, 0.9529540765]
DRAWN_CONSTANTS = [
    *(-4.79251854, 3.14307511, -0.56020553, -0.12573169, 0.76662611, 2.00107361),
    *(-0.0117601, -2.35849792, 3.90625633, 0.46695037, 0.08504908, -0.94096412),
]


@pytest.mark.slow
def test_rounding_does_not_choose_the_motion_beside_a_jump():
    # the loads differ by as much as rounding does
    loads_n = 500.0 * (1 + 1e-13 * np.arange(12))
    drawn_law = replace(printed_law("4010"), internal_constants=np.array([DRAWN_CONSTANTS]))
    points = OperatingPoints.from_load_and_speed(loads_n, 17906.43885697232 * RPM)
    at_rest = problem(MAINSHAFT, points, "4010", 100.0, law=drawn_law)
    factors = np.tile(DRAWN_FACTORS, (len(loads_n), 1))
    at_rest = replace(at_rest, lubrication=replace(at_rest.lubrication, factors=factors))
    inputs = InputValues(
        **{name: np.full(len(loads_n), value) for name, value in DRAWN_INPUTS.items()}
    )
    motion = friction_equilibrium(at_rest.with_inputs(inputs))
    assert motion.solution.converged.all()
    assert not motion.held_by_band().any()
    np.testing.assert_allclose(motion.cage_slip(), motion.cage_slip()[0], atol=1e-9)


@pytest.mark.slow
def test_more_drag_never_makes_a_cage_faster():
    oil_volume_fractions = np.linspace(0.002, 0.05, 6)
    points = OperatingPoints.from_load_and_speed(3000.0, 12000 * RPM)
    slips = [
        friction_equilibrium(
            problem(MAINSHAFT, points, "4010", 70.0, oil_volume_fraction=oil_volume_fraction)
        ).cage_slip()[0]
        for oil_volume_fraction in oil_volume_fractions
    ]
    assert (np.diff(slips) > 0).all()


@pytest.mark.nightly
def test_balls_that_hardly_touch_a_race_have_no_motion_and_spoil_no_other_point() -> None:
    # 0.01 N on all balls of the bearing
    points = OperatingPoints.from_load_and_speed(np.array([0.01, 20000.0]), 24000 * RPM)
    motion = friction_equilibrium(in_operation(problem(MAINSHAFT, points, "4050", 100.0)))
    np.testing.assert_array_equal(motion.solution.converged, [False, True])


@pytest.mark.slow
def test_beyond_the_law_no_motion_is_called_the_only_one() -> None:
    points = OperatingPoints.from_load_and_speed(np.array([500.0, 20000.0]), 18000 * RPM)
    motions = equilibria(problem(shipped("mainshaft-167"), points, "4102", 40.0))
    np.testing.assert_array_equal(motions.count, [1, 1])
    np.testing.assert_array_equal(motions.fastest.outside_law(), [True, False])
    np.testing.assert_array_equal(motions.is_complete, [False, True])
