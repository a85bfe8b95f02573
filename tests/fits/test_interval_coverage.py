"""The intervals hold as often as they say (short; `make bench NAME=coverage` is the long one)."""

import itertools

import numpy as np
import pandas as pd
import pytest
import scipy

from campaigns import printed
from fit_points import LAW, polished
from oilfilm.base.randomness import generator
from oilfilm.fits.fit import fit_oil
from oilfilm.fits.fitted import FittedLaw
from oilfilm.fits.interval import LEVELS, Band, _not_negative, scores_of_unseen
from oilfilm.fits.uncertainty import (
    curve_bootstrap,
    naive_covariance,
    robust_covariance,
    robust_draws,
)
from oilfilm.settings.resolved import Settings
from oilfilm.traction.law import to_internal
from simulated_points import Campaign, heated_film_truth, law_truth, spread_conditions

SMALL = np.array(list(itertools.product([1.0, 1.5], [25.0, 32.0, 40.0], [30.0, 100.0])))


@pytest.fixture(scope="module")
def conditions(config: Settings) -> np.ndarray:
    return np.array(list(itertools.product(*config.campaign.matrix.model_dump().values())))


def campaign(config: Settings, oil: str) -> Campaign:
    return Campaign(law_truth(oil), config.common_contact())


@pytest.mark.no_cover
def test_bootstrap_covers_and_naive_errors_do_not(config: Settings, conditions: np.ndarray) -> None:
    truth = to_internal(LAW, printed()["4050"])
    inside, naive = [], []
    for number in range(24):
        random = generator(1, "coverage", number)
        points = campaign(config, "4050").points(conditions, random)
        problem, best = polished(points, printed()["4050"])
        refits = curve_bootstrap(problem, best, 200, random)
        lower, upper = np.quantile(refits, [0.025, 0.975], axis=0)
        inside.append((lower <= truth) & (truth <= upper))
        errors = np.sqrt(np.diag(naive_covariance(problem, best)))
        naive.append(np.abs(best.values - truth) <= 1.96 * errors)
    # 24 campaigns of 12 constants that move together know a share of 95 % to about 3 %
    assert 0.88 < np.mean(inside) < 0.995
    assert np.mean(naive) < 0.7


@pytest.mark.no_cover
def test_errors_of_twelve_runs_are_the_scatter_of_such_campaigns(config: Settings) -> None:
    ends, variances = [], []
    for number in range(80):
        points = campaign(config, "4050").points(SMALL, generator(2, "small", number))
        problem, best = polished(points, printed()["4050"])
        ends.append(best.values)
        variances.append(np.diag(robust_covariance(problem, best)))
    ratio = np.sqrt(np.mean(variances, axis=0)) / np.std(ends, axis=0, ddof=1)
    # 80 campaigns know a standard deviation to 8 %
    assert (ratio > 0.7).all()
    assert (ratio < 1.5).all()


def test_draws_of_twelve_runs_do_not_depend_on_signs_that_a_kernel_chooses(
    config: Settings, monkeypatch: pytest.MonkeyPatch
) -> None:
    points = campaign(config, "4050").points(SMALL, generator(2, "small", 0))
    problem, best = polished(points, printed()["4050"])
    errors = np.sqrt(np.diag(robust_covariance(problem, best)))
    draws = robust_draws(problem, best, 4000, generator(1, "draws"))
    # a standard deviation from 4000 draws is known to 1.1 %
    np.testing.assert_allclose(np.std(draws, axis=0) / errors, 1, atol=0.05)
    qr, eigh = np.linalg.qr, np.linalg.eigh
    monkeypatch.setattr(np.linalg, "qr", lambda matrix: tuple(-part for part in qr(matrix)))
    monkeypatch.setattr(np.linalg, "eigh", lambda matrix: (eigh(matrix)[0], -eigh(matrix)[1]))
    other = robust_draws(problem, best, 4000, generator(1, "draws"))
    assert (np.abs(other - draws) / errors).max() < 1e-9


@pytest.mark.no_cover
@pytest.mark.parametrize("film", [False, True], ids=["true law", "heated film"])
def test_the_interval_holds_new_runs(config: Settings, conditions: np.ndarray, film: bool) -> None:
    truths = {oil: law_truth(oil) for oil in printed()}
    if film:
        truths = {oil: heated_film_truth(oil) for oil in printed()}
    settings = config.fit.model_copy(update={"searches": 2, "bootstrap": 100})
    run = np.arange(len(conditions))
    some = conditions[(run + run // 6 + run // 24) % 3 == 0]  # every level, 24 runs
    parts = []
    for oil in printed():
        source = Campaign(truths[oil], config.common_contact())
        random = generator(3, "new runs", str(film), oil)
        fit = fit_oil(source.points(some, random, oil), oil, settings, 1)
        fitted = FittedLaw.of(fit.coefficients, oil, fit.refits, fit.fit_quality)
        box = some.min(axis=0), some.max(axis=0)
        new = source.points(spread_conditions(*box, 20, random), random, oil)
        new = new[new["slide_roll_ratio"] > 0]
        at = new[list(LAW.conditions)].to_numpy(float)
        predicted = fitted.predict(at, new["slide_roll_ratio"].to_numpy()).to_frame()
        parts.append(
            predicted.assign(
                **new[["traction_coefficient", "slide_roll_ratio"]]
                .rename(columns={"traction_coefficient": "measured"})
                .reset_index(drop=True)
            )
        )
    every = pd.concat(parts)
    mu = every["traction_coefficient"]
    inside = every["measured"].between(every["obs_ci_lower"], every["obs_ci_upper"])
    assert inside.mean() >= 0.90
    # also where mu rises, and a wrong law is most wrong
    assert inside[every["slide_roll_ratio"] < 0.03].mean() >= 0.90
    deviation = np.quantile(np.abs(every["measured"] / mu - 1), 0.95)
    width = (every["obs_ci_upper"] - every["obs_ci_lower"]) / 2 / mu
    # 1.6 is the limit of the benchmark's mean; 60 runs know their own 95 % quantile to 12 %
    assert np.median(width) < 1.12 * 1.6 * deviation
    if film:  # what the law itself says of its mean is no help where the law is wrong
        own = every["measured"].between(every["mean_ci_lower"], every["mean_ci_upper"])
        assert own.mean() < 0.7


def test_quantiles_of_curves_left_out_are_those_of_their_ranks() -> None:
    """19 curves of one point: the 95 % quantile is the largest of 19, the 90 % one the 18th."""
    errors = np.arange(1.0, 20.0)
    predicted = np.ones(19)
    none = np.zeros(19)
    unseen = scores_of_unseen(predicted, predicted - errors * 1e-3, none, none, np.arange(19))
    size = np.hypot(unseen.absolute, unseen.relative)
    # as half widths of an interval that does not change its sign: sinh|ln(measured/mu)|
    expected = np.sinh(-np.log1p(-errors * 1e-3)) / size
    known = dict(zip(LEVELS, unseen.quantiles, strict=True))
    assert known[0.95] == pytest.approx(expected[18])
    assert known[0.9] == pytest.approx(expected[17])
    assert known[0.5] == pytest.approx(expected[9])
    assert np.isnan(known[0.99])
    assert unseen.at(0.99) == (0.95, pytest.approx(expected[18]))


def test_a_curve_of_many_points_counts_as_one() -> None:
    none = np.zeros(9)
    few = scores_of_unseen(np.ones(9), 1 + 0.01 * np.arange(1, 10), none, none, np.arange(9))
    curve = np.repeat(np.arange(9), 50)
    error = np.repeat(0.01 * np.arange(1, 10), 50)
    many = scores_of_unseen(np.ones(450), 1 + error, np.zeros(450), np.zeros(450), curve)
    np.testing.assert_allclose(many.quantiles, few.quantiles)


def test_an_error_of_the_slips_scale_is_found_as_such() -> None:
    """Errors of 3 S dmu/dS per mille alone: the two other parts are none of it."""
    slip = np.linspace(0.002, 0.3, 50)
    mu, by_slip = -np.expm1(-slip / 0.05), slip / 0.05 * np.exp(-slip / 0.05)
    sign = np.repeat([-1.0, 1.0], 15)
    predicted, steep = np.tile(mu, 30), np.tile(by_slip, 30)
    errors = np.repeat(sign, 50) * 3e-3 * steep
    curve = np.repeat(np.arange(30), 50)
    unseen = scores_of_unseen(predicted, predicted + errors, steep, np.zeros(1500), curve)
    assert unseen.slip == pytest.approx(3e-3)
    assert unseen.relative < 1e-7
    # no point is exact, but most of the error is of the slip
    assert unseen.absolute < 0.06 * np.sqrt(np.mean((3e-3 * by_slip) ** 2))


@pytest.mark.parametrize("measured", [0.002, 0.005, 0.0099, 0.012, 0.03])
def test_the_interval_just_holds_the_curve_that_made_its_quantile(measured: float) -> None:
    """One error in nine is the largest: the 90 % interval of such a size ends at it."""
    predicted, none = np.full(9, 0.01), np.zeros(9)
    read = np.array([*[0.01] * 8, measured])
    unseen = scores_of_unseen(predicted, read, none, none, np.arange(9))
    times = unseen.at(0.9)[1]
    band = Band(np.zeros((1, 1)), unseen.absolute * times, unseen.relative * times)
    lower, upper = band.ends(np.array([0.01]), np.zeros((1, 1)), np.zeros((1, 0)))[:, 0]
    assert (lower if measured < 0.01 else upper) == pytest.approx(measured)


@pytest.mark.parametrize("seed", range(20))
def test_least_squares_without_a_negative_factor_are_those_of_scipy(seed: int) -> None:
    random = np.random.default_rng(seed)
    columns = random.normal(size=(30, 3)) ** 2 * [1.0, 1e-4, seed % 3]
    wanted = columns @ random.normal(size=3) + 0.1 * random.normal(size=30)
    expected, _ = scipy.optimize.nnls(columns, wanted)
    np.testing.assert_allclose(_not_negative(columns, wanted), expected, rtol=1e-9, atol=1e-12)
