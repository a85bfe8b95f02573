"""Profile likelihood: a straight line where a law is linear, Student's interval there."""

import numpy as np
import pytest
from scipy.stats import t as student

from campaigns import printed
from fit_points import LAW, make_points, matrix, problem_of
from oilfilm.fits.engine import polish
from oilfilm.fits.uncertainty import naive_covariance, profile_interval, profiles
from oilfilm.traction.law import to_internal


def test_profile_rises_with_the_best_sse_that_the_others_allow() -> None:
    task = problem_of(make_points("4102", matrix(), noise=2e-4))
    best = polish(task, to_internal(LAW, printed()["4102"]))
    naive = naive_covariance(task, best)
    errors = np.sqrt(np.diag(naive))
    values, z = profiles(task, best, naive)
    degrees = len(task.mu) - 12
    # with 2 232 points the law is nearly linear within a few standard errors
    np.testing.assert_allclose(z, (values - best.values[:, None]) / errors[:, None], atol=0.12)
    assert (np.diff(z, axis=1) > 0).all()
    limit = student.ppf(0.975, degrees)
    ends = [profile_interval(*profile, degrees) for profile in zip(values, z, strict=True)]
    naive = best.values[:, None] + limit * errors[:, None] * np.array([-1, 1])
    assert (np.abs(np.array(ends) - naive) < 0.1 * errors[:, None]).all()


def test_interval_of_a_bent_profile_is_where_it_crosses() -> None:
    # z = ln x: crosses -+ t at exp(-+ t), lopsided as a naive interval never is
    values = np.exp(np.linspace(-4, 4, 41))
    lower, upper = profile_interval(values, np.log(values), 1000)
    limit = student.ppf(0.975, 1000)
    assert (lower, upper) == pytest.approx((np.exp(-limit), np.exp(limit)), rel=1e-3)


def test_profile_that_never_reaches_the_limit_gives_no_end() -> None:
    values = np.linspace(-4, 4, 13)
    flat = np.tanh(values)
    assert np.isnan(profile_interval(values, flat, 1000)).all()
    turning = np.where(values > 3, 0.0, values)
    assert np.isnan(profile_interval(values, turning, 1000)).all()
