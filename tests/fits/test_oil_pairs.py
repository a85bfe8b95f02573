"""Two oils by their runs: which pairs have a ratio, and why others have none."""

from dataclasses import replace
from functools import partial

import numpy as np
import pandas as pd
import pytest

from fit_points import LAW, accepted_points
from lawless_truths import DENG_CONSTANTS, TRUTHS
from measured_surfaces import with_measured_surface
from oilfilm.base.errors import OilfilmError
from oilfilm.fits.fitted import Coefficients, FittedLaw, given_surface
from oilfilm.fits.oil_pairs import (
    MeasuredOil,
    Obstacle,
    assumptions_of_pair,
    limits_of_pair,
    oil_pair,
)
from oilfilm.fits.run_assumptions import RunAssumptions
from oilfilm.settings.resolved import Settings
from oilfilm.surface.effects import ErrorPriors
from oilfilm.surface.limits import SurfaceLimits
from oilfilm.surface.measurements import LevelWidths
from oilfilm.surface.ratio import RatioSurface
from oilfilm.traction import LAWS
from oilfilm.traction.law import CONDITIONS, to_constants
from surface_campaigns import PRESSURES, SPEEDS, TEMPERATURES, ends, grid

SLIP = np.array([0.0, 2e-4, 0.01, 0.05, 0.2])
CORNERS = grid(ends(PRESSURES), ends(SPEEDS), ends(TEMPERATURES))
FIT = FittedLaw(LAW, Coefficients.from_constants(LAW, to_constants(LAW.signs, DENG_CONSTANTS)))


def oil(factor: float, conditions: np.ndarray, seed: int, rig: str = "one") -> MeasuredOil:
    """Runs of an oil of Deng's law, times a factor, with gains of 0.5 % and noise."""
    random = np.random.default_rng(seed)
    frame = pd.DataFrame(conditions, columns=list(CONDITIONS)).assign(load_n=80.0)
    at = (np.repeat(column, len(SLIP)) for column in conditions.T)
    mu = factor * TRUTHS["own"](*at, np.tile(SLIP, len(conditions)))
    mu *= np.repeat(1 + 0.005 * random.standard_normal(len(conditions)), len(SLIP))
    return MeasuredOil(FIT, accepted_points("oil", frame, SLIP, mu, 1e-5, random), frozenset([rig]))


def test_a_planted_ratio_is_found_by_pairs_of_runs_whatever_their_names_are() -> None:
    first, second = oil(1.0, CORNERS, 61), oil(1.2, CORNERS, 62)
    pair = oil_pair(first, second)
    assert (pair.paired_count, pair.unpaired_count) == (8, 0)
    assert isinstance(pair.ratio_or_obstacle, RatioSurface)
    at, slip = np.array([[1.2, 32.0, 70.0]]), np.array([0.05])
    # the mean of 8 gains of 0.5 % of each oil has an error of 0.25 %
    assert pair.ratio_or_obstacle.predict(at, slip).ratio[0] == pytest.approx(1.2, rel=0.01)

    names = second.points["run_id"].map(lambda name: f"z{name[::-1]}")
    renamed = replace(second, points=second.points.assign(run_id=names).iloc[::-1])
    again = oil_pair(first, renamed)
    assert isinstance(again.ratio_or_obstacle, RatioSurface)
    assert (
        again.ratio_or_obstacle.predict(at, slip).ratio[0]
        == pair.ratio_or_obstacle.predict(at, slip).ratio[0]
    )


def test_oils_whose_runs_are_on_several_rigs_have_a_ratio(config: Settings) -> None:
    conditions = grid(PRESSURES, ends(SPEEDS), ends(TEMPERATURES))
    first, second = oil(1.0, conditions, 72), oil(1.2, conditions[: len(CORNERS)], 73)
    surface_settings = config.surface
    measured = with_measured_surface(FIT, first.points, surface_settings, "oil")
    assert measured.surface is not None
    run_count = len(measured.surface.run_ids)
    on_two_rigs = replace(
        measured.surface.assumptions, rig_name_of_run=("a", "b") * (run_count // 2)
    )
    surface = replace(measured.surface, assumptions=on_two_rigs)
    fit = replace(measured, read_surface=partial(given_surface, surface))
    pair = oil_pair(replace(first, fit=fit), second)
    assert isinstance(pair.ratio_or_obstacle, RatioSurface)


def test_a_pair_is_judged_by_what_both_oils_need_and_assume(config: Settings) -> None:
    first = oil(1.0, grid(PRESSURES, ends(SPEEDS), ends(TEMPERATURES)), 74)
    measured = with_measured_surface(FIT, first.points, config.surface, "oil")
    assert measured.surface is not None

    def oil_with(limits: SurfaceLimits, assumptions: RunAssumptions) -> MeasuredOil:
        surface = replace(measured.surface, limits=limits, assumptions=assumptions)
        fit = replace(measured, read_surface=partial(given_surface, surface))
        return replace(first, fit=fit)

    usual_gain = ErrorPriors().gain
    one = oil_with(
        SurfaceLimits(level=0.9, reach_in_ranges=0.2, fewest_slips=5),
        RunAssumptions(LevelWidths(0.01, 0.04, 5.0), usual_error_names=("zero",)),
    )
    other = oil_with(
        SurfaceLimits(level=0.8, largest_spread=0.1),
        RunAssumptions(
            LevelWidths(0.02, 0.03, 2.0),
            ErrorPriors(gain=replace(usual_gain, median=7 * usual_gain.median)),
            usual_error_names=("noise", "zero"),
        ),
    )
    for pair in ((one, other), (other, one)):
        assert limits_of_pair(*pair) == SurfaceLimits(
            level=0.9, largest_spread=0.1, fewest_slips=5, reach_in_ranges=0.2
        )
        assumptions = assumptions_of_pair(*pair)
        assert assumptions.level_widths == LevelWidths(0.01, 0.03, 2.0)
        # root mean square of 1 and 7
        assert assumptions.error_sizes.gain.median == pytest.approx(5 * usual_gain.median)
        assert set(assumptions.usual_error_names) == {"zero", "noise"}
    assert assumptions_of_pair(one, one).error_sizes == ErrorPriors()


def test_few_common_conditions_give_no_ratio() -> None:
    # three corners are common; the other five of the second oil are 20 K colder
    other = CORNERS.copy()
    other[3:, 2] -= np.where(other[3:, 2] > 50, 20, -20)
    pair = oil_pair(oil(1.0, CORNERS, 64), oil(1.2, other, 65))
    assert pair.ratio_or_obstacle is Obstacle.FEW_PAIRS
    assert (pair.paired_count, pair.unpaired_count) == (3, 10)


def test_runs_whose_speed_is_not_known_give_no_ratio() -> None:
    first, second = oil(1.0, CORNERS, 68), oil(1.2, CORNERS, 69)
    without_speed = second.points.assign(entrainment_speed_m_s=np.nan)
    pair = oil_pair(first, replace(second, points=without_speed))
    assert pair.ratio_or_obstacle is Obstacle.UNKNOWN_CONDITIONS


def test_mu_that_is_too_small_by_its_unit_ends_in_a_sentence() -> None:
    first, second = oil(1.0, CORNERS, 70), oil(1e-3, CORNERS, 71)
    with pytest.raises(OilfilmError, match="check the unit of mu"):
        oil_pair(first, second)


def test_the_same_runs_give_no_ratio() -> None:
    one = oil(1.0, CORNERS, 66)
    assert oil_pair(one, one).ratio_or_obstacle is Obstacle.SAME_RUNS


def test_a_law_of_other_conditions_gives_no_ratio() -> None:
    first, law = oil(1.0, CORNERS, 67), LAWS["wang-deng-load"]
    constants = np.ones(len(law.constants)) * np.where(law.signs < 0, -1, 1)
    other = replace(first, fit=FittedLaw(law, Coefficients.from_constants(law, constants)))
    assert oil_pair(first, other).ratio_or_obstacle is Obstacle.OTHER_CONDITIONS
