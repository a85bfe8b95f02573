"""Curves that contradict the others."""

import numpy as np
import pytest

from bad_curves import DAMAGES, damaged, film_collapse, one_step_high
from lawless_truths import TRUTHS
from oilfilm.surface.shape import odd_curves, point_scores, squares_per_point
from oilfilm.surface.surface import fit_surface
from surface_campaigns import fitted_law, grid, latin, simulated

SLIPS = np.geomspace(0.002, 0.3, 12)
TWELVE = grid((1.0, 1.5), (25.0, 40.0), (25.0, 72.0, 120.0))


def test_no_clean_curve_is_odd():
    measured = simulated(TRUTHS["jt"], latin(), np.random.default_rng(31), slips=SLIPS)
    assert odd_curves(measured, fitted_law(measured)) == ()


@pytest.mark.nightly
@pytest.mark.parametrize("damage", DAMAGES, ids=lambda damage: damage.__name__)
def test_damaged_curves_are_named(damage):
    random = np.random.default_rng(32)
    measured = damaged(simulated(TRUTHS["jt"], latin(), random, slips=SLIPS), [5, 17], damage)
    assert {odd.curve for odd in odd_curves(measured, fitted_law(measured))} == {5, 17}


def test_one_high_step_is_named_with_its_point():
    random = np.random.default_rng(33)
    clean = simulated(TRUTHS["jt"], TWELVE, random, slips=SLIPS)
    measured = damaged(clean, [7], one_step_high)
    (odd,) = odd_curves(measured, fitted_law(measured))
    assert odd.curve == 7
    assert odd.point == np.flatnonzero(measured.mu != clean.mu)


def test_scores_are_those_of_the_covariance_of_all_points():
    measured = simulated(TRUTHS["jt"], TWELVE, np.random.default_rng(34), slips=SLIPS)
    ordered = damaged(measured, [2], film_collapse).in_canonical_order()
    surface = fit_surface(ordered, fitted_law(ordered))
    posterior, covariance = surface.posterior, surface.covariance
    curves, noise = covariance.curves, covariance.sizes.noise
    vectors = curves.vectors.toarray()
    left = np.eye(len(vectors)) - vectors @ vectors.T
    total = vectors @ covariance.matrix() @ vectors.T + noise**2 * left
    departure = vectors @ curves.departure + curves.remainder
    point, others = 30, np.arange(len(departure)) != 30
    weights = np.linalg.solve(total[np.ix_(others, others)], total[others, point])
    error = departure[point] - weights @ departure[others]
    spread = np.sqrt(total[point, point] - weights @ total[others, point])
    assert point_scores(posterior, covariance)[point] == pytest.approx(
        abs(error) / spread, rel=1e-5
    )

    own = ordered.curve == 3
    across = np.linalg.solve(total[np.ix_(~own, ~own)], total[np.ix_(~own, own)]).T
    errors = departure[own] - across @ departure[~own]
    spreads = total[np.ix_(own, own)] - across @ total[np.ix_(~own, own)]
    squares = errors @ np.linalg.solve(spreads, errors) / own.sum()
    assert squares_per_point(posterior, covariance, ordered.curve)[3] == pytest.approx(
        squares, rel=1e-5
    )
