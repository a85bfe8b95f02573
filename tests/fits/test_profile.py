"""Profile likelihood: a straight line where a law is linear, Student's interval there."""

from dataclasses import replace

import numpy as np

from campaigns import printed
from fit_points import make_points, matrix, polished
from oilfilm.fits.uncertainty import naive_covariance, profiles


def test_profile_rises_with_the_best_sse_that_the_others_allow() -> None:
    task, best = polished(make_points("4102", matrix(), noise=2e-4), printed()["4102"])
    naive = naive_covariance(task, best)
    errors = np.sqrt(np.diag(naive))
    values, z = profiles(task, best, naive)
    # with 2 232 points the law is nearly linear within a few standard errors
    np.testing.assert_allclose(z, (values - best.constants[:, None]) / errors[:, None], atol=0.12)
    assert (np.diff(z, axis=1) > 0).all()


def test_an_exact_fit_has_no_profile_beside_its_optimum() -> None:
    """Its constants have no errors, so that no distance from the optimum is one error."""
    task, best = polished(make_points("4102", matrix()[:24]), printed()["4102"])
    count = len(best.constants)
    values, z = profiles(task, replace(best, sse=0.0), np.zeros((count, count)))
    is_optimum = values == best.constants[:, None]
    assert is_optimum.sum(axis=1).tolist() == count * [1]
    assert (z[is_optimum] == 0).all() and np.isnan(z[~is_optimum]).all()
