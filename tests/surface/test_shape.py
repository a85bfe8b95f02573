"""Curves that contradict the others."""

from dataclasses import replace

import numpy as np
import pytest

from bad_curves import CURVE_DAMAGES, CurveDamage, damage_curves, film_collapse, one_step_high
from lawless_truths import TRUTHS
from nights import nightly, quick_ones
from oilfilm.surface.effects import ErrorPriors
from oilfilm.surface.measurements import Measurements
from oilfilm.surface.quick_law import quick_law
from oilfilm.surface.shape import REFUSED_ODDNESS, CurveJudge, curve_shapes
from oilfilm.surface.surface import fit_surface
from oilfilm.traction import PAPER_LAW
from surface_campaigns import grid, latin, random_conditions, simulated

SLIPS = np.geomspace(0.002, 0.3, 12)
TWELVE = grid((1.0, 1.5), (25.0, 40.0), (25.0, 72.0, 120.0))


def odd_rows(measured: Measurements) -> set[int]:
    return {shape.curve_index for shape in curve_shapes(measured, PAPER_LAW) if shape.is_odd}


@pytest.mark.slow
@pytest.mark.parametrize(
    "slips", [nightly(SLIPS), np.geomspace(0.006, 0.29, 6)], ids=["twelve", "six"]
)
def test_no_clean_curve_is_odd(slips):
    measured = simulated(TRUTHS["jt"], latin(), np.random.default_rng(31), slips=slips)
    assert odd_rows(measured) == set()


@pytest.mark.slow
@pytest.mark.parametrize(
    "damage", quick_ones(CURVE_DAMAGES, [film_collapse]), ids=lambda damage: damage.__name__
)
def test_damaged_curve_of_twelve_is_named(damage: CurveDamage):
    random = np.random.default_rng(32)
    measured = damage_curves(simulated(TRUTHS["sol"], TWELVE, random, slips=SLIPS), [5], damage)
    assert odd_rows(measured) == {5}


@pytest.mark.slow
@pytest.mark.parametrize("seed", quick_ones(range(3), [0]))
def test_corner_where_the_oil_behaves_otherwise_is_not_odd(seed: int):
    # the asperities of `mix` carry at the slow and hot end only
    random = np.random.default_rng(seed)
    slips = np.geomspace(0.006, 0.29, 6)
    for conditions in (TWELVE, latin()):
        shapes = curve_shapes(simulated(TRUTHS["mix"], conditions, random, slips=slips), PAPER_LAW)
        assert max(shape.oddness for shape in shapes) < REFUSED_ODDNESS


@pytest.mark.nightly
@pytest.mark.parametrize("damage", CURVE_DAMAGES, ids=lambda damage: damage.__name__)
def test_two_damaged_curves_of_24_are_named(damage: CurveDamage):
    random = np.random.default_rng(32)
    measured = damage_curves(simulated(TRUTHS["jt"], latin(), random, slips=SLIPS), [5, 17], damage)
    assert odd_rows(measured) == {5, 17}


@pytest.mark.slow
def test_one_high_step_is_named_with_its_point_and_its_size():
    random = np.random.default_rng(33)
    clean = simulated(TRUTHS["jt"], TWELVE, random, slips=SLIPS)
    measured = damage_curves(clean, [7], one_step_high)
    (odd,) = [shape for shape in curve_shapes(measured, PAPER_LAW) if shape.is_odd]
    assert odd.curve_index == 7
    assert odd.point_index == np.flatnonzero(measured.mu != clean.mu)
    # the step is 15 % too high; the error of the gain of a run is 0.8 %
    assert odd.expected_mu == pytest.approx(clean.mu[odd.point_index], rel=0.03)


def test_a_step_is_named_although_its_whole_curve_is_high():
    random = np.random.default_rng(33)
    clean = simulated(TRUTHS["jt"], TWELVE, random, slips=SLIPS)
    points_of_curve = np.flatnonzero(clean.curve_of_point == 7)
    step = points_of_curve[8]
    mu = clean.mu.copy()
    mu[points_of_curve] *= 1.06
    mu[step] *= 0.90
    (odd,) = [shape for shape in curve_shapes(replace(clean, mu=mu), PAPER_LAW) if shape.is_odd]
    assert (odd.curve_index, odd.point_index) == (7, step)


def test_expected_traction_is_right_where_a_curve_is_ten_times_too_low():
    random = np.random.default_rng(37)
    clean = simulated(TRUTHS["jt"], TWELVE, random, slips=SLIPS)
    low = replace(clean, mu=np.where(clean.curve_of_point == 4, clean.mu / 10, clean.mu))
    (odd,) = [shape for shape in curve_shapes(low, PAPER_LAW) if shape.is_odd]
    assert odd.curve_index == 4
    # the spread of a new run at low traction is up to 3 %
    assert odd.expected_mu == pytest.approx(clean.mu[odd.point_index], rel=0.06)


@pytest.mark.slow
def test_shapes_do_not_depend_on_the_order_of_curves_and_points():
    random = np.random.default_rng(34)
    measured = damage_curves(
        simulated(TRUTHS["jt"], TWELVE, random, slips=SLIPS), [2], film_collapse
    )
    new_row = random.permutation(12)
    points = random.permutation(len(measured.mu))
    shuffled = Measurements(
        measured.conditions[np.argsort(new_row)],
        new_row[measured.curve_of_point[points]],
        measured.slip[points],
        measured.mu[points],
    )
    shapes = curve_shapes(measured, PAPER_LAW)
    others = curve_shapes(shuffled, PAPER_LAW)
    for shape in shapes:
        other = others[new_row[shape.curve_index]]
        assert (
            replace(
                other, curve_index=shape.curve_index, point_index=int(points[other.point_index])
            )
            == shape
        )


@pytest.mark.slow
def test_curves_of_a_large_campaign_are_judged_in_parts():
    random = np.random.default_rng(35)
    conditions = random_conditions(100, random)
    clean = simulated(TRUTHS["jt"], conditions, random, slips=np.geomspace(0.01, 0.3, 5))
    assert odd_rows(damage_curves(clean, [60], film_collapse)) == {60}


def test_curve_is_judged_by_the_covariance_of_all_points():
    measured = simulated(TRUTHS["jt"], TWELVE, np.random.default_rng(34), slips=SLIPS)
    ordered = damage_curves(measured, [2], film_collapse).in_canonical_order()
    law = quick_law(PAPER_LAW, ordered, 1e-4)
    covariance = fit_surface(ordered, law).covariance
    curves, noise = covariance.curves, covariance.sizes.noise
    law_log_mu = law.log_mu(ordered.point_conditions, ordered.slip)
    zero_remainder = curves.remainder_of(4e-4 / ordered.mu)
    judge = CurveJudge(curves, covariance.matrix(), noise, law_log_mu, zero_remainder, 1e-4)
    vectors = curves.vectors.toarray()
    left = np.eye(len(vectors)) - vectors @ vectors.T
    total = vectors @ covariance.matrix() @ vectors.T + noise**2 * left
    is_same_curve = np.equal.outer(ordered.curve_of_point, ordered.curve_of_point)
    total += np.outer(zero_remainder, zero_remainder) * is_same_curve
    departure = vectors @ curves.departure + curves.remainder

    all_curves = np.arange(12)
    judged = list(judge.predicted_curves(all_curves))
    without_three = list(judge.predicted_curves(np.delete(all_curves, 3)))
    point, others = 30, np.arange(len(departure)) != 30
    weights = np.linalg.solve(total[np.ix_(others, others)], total[others, point])
    error = departure[point] - weights @ departure[others]
    spread = np.sqrt(total[point, point] - weights @ total[others, point])
    of_curve = judged[ordered.curve_of_point[point]]
    score = of_curve.point_scores()[of_curve.point_indices == point]
    assert score == pytest.approx(abs(error) / spread, rel=1e-5)

    own = ordered.curve_of_point == 3
    across = np.linalg.solve(total[np.ix_(~own, ~own)], total[np.ix_(~own, own)]).T
    errors = departure[own] - across @ departure[~own]
    spreads = total[np.ix_(own, own)] - across @ total[np.ix_(~own, own)]
    squares = errors @ np.linalg.solve(spreads, errors) / own.sum()
    for curve in (judged[3], without_three[3]):
        assert curve.squares_per_point == pytest.approx(squares, rel=1e-5)
        assert curve.deviations() == pytest.approx(errors, rel=1e-5)
        assert curve.log_mu_sds() == pytest.approx(np.sqrt(np.diag(spreads)), rel=1e-5)


@pytest.mark.parametrize("sign", [-1, nightly(1)])
def test_a_zero_that_runs_have_makes_no_curve_odd(sign: int):
    # three standard deviations of the zero: half of mu at the smallest slip
    clean = simulated(TRUTHS["own"], TWELVE, np.random.default_rng(39))
    zero = np.where(clean.curve_of_point == 2, sign * 1.2e-4, 0.0)
    assert odd_rows(replace(clean, mu=clean.mu + zero)) == set()


def test_no_curve_is_refused_where_half_of_them_contradict_the_others():
    random = np.random.default_rng(38)
    clean = simulated(TRUTHS["jt"], TWELVE, random, slips=SLIPS)
    half = damage_curves(clean, [0, 2, 4, 6, 8, 10], film_collapse)
    shapes = curve_shapes(half, PAPER_LAW)
    assert max(shape.oddness for shape in shapes) <= REFUSED_ODDNESS


def test_four_curves_cannot_judge_each_other():
    measured = simulated(TRUTHS["jt"], TWELVE[:4], np.random.default_rng(36), slips=SLIPS)
    with pytest.raises(ValueError, match="4 curves; expected 5 or more"):
        curve_shapes(measured, PAPER_LAW)


def test_curves_without_traction_beyond_the_zero_cannot_be_judged():
    measured = simulated(TRUTHS["sol"], TWELVE, np.random.default_rng(61), slips=SLIPS)
    zero = replace(ErrorPriors().zero, median=0.004)
    with pytest.raises(ValueError, match="no mu is clear of the error of the zero"):
        curve_shapes(measured, PAPER_LAW, replace(ErrorPriors(), zero=zero))
