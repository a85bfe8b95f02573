"""Equal but for rounding: laws, runs, levels, conditions and tests that differ by 1e-12 only."""

import itertools
from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd
import pytest

from campaigns import printed
from fit_points import LAW, make_points, matrix, polished
from measured_surfaces import with_measured_surface
from nights import nightly, quick_ones
from oilfilm import tables
from oilfilm.base.levels import level_indices
from oilfilm.base.randomness import generator
from oilfilm.fits.best_law import best_laws
from oilfilm.fits.conditions import (
    condition_level_numbers,
    level_numbers_by_gap,
    varied_condition_mask,
)
from oilfilm.fits.fit_tables import certificate_columns
from oilfilm.fits.fitted import Coefficients, FittedLaw
from oilfilm.fits.global_search import Optimum
from oilfilm.fits.measured_curves import FormErrorProcess, choose_curves
from oilfilm.fits.steady_campaign import MeasuredCampaign, change_columns
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from reports import rows

BITS = (0.0, 1e-12, -1e-12)
bits_of = pytest.mark.parametrize("bits", BITS)


# ---------------------------------------------------------------- laws


# Of the configuration of the project.
BIC_DIFFERENCE_MIN = 2.0


def verdict(laws: dict[str, tuple[float, int, bool]], configured: str) -> dict[str, Any]:
    """The verdict on laws of 30 curves of one point each.

    Args:
        laws: By name: factor on the errors, number of constants, whether the fit is certified.
        configured: One of them.
    """
    names = [f"run{number}" for number in range(30)]
    errors = 0.01 * generator(1, "near ties").standard_normal(len(names))
    at = {"oil": "own", "run_id": names, "first_row": 0}
    quality, beside = [], []
    # with other signs at each point: laws that are as good, but not the same law
    signs = generator(2, "near ties").choice([-1.0, 1.0], (len(laws), len(names)))
    for (law, (factor, constants, certified)), sign in zip(laws.items(), signs, strict=True):
        rms = float(np.sqrt(np.mean((factor * errors) ** 2)))
        row = {"oil": "own", "law": law, "n_points": len(names), "left_out_rmse": rms}
        row |= {"bic": 60 * np.log(rms), "n_constants": constants, "certified": certified}
        row |= {f"{end}_end_out_relative_rms": rms for end in ("pressure", "temperature")}
        quality.append({**row, "configured": law == configured, "relative_rms": rms})
        mu = 1 + factor * sign * errors
        of_points = {"traction_coefficient": mu, "left_out_traction_coefficient": mu}
        beside.append(pd.DataFrame(at | {"law": law} | of_points))
    results = CampaignTables.from_frames(
        fit_quality=rows("fit_quality", *quality),
        law_points=pd.concat(beside),
        points=pd.DataFrame(at | {"traction_coefficient": 1.0}),
    )
    (row,) = tables.rows(best_laws(results, BIC_DIFFERENCE_MIN))
    return row


ORDERS = [*itertools.permutations(["eyring", "tanh", "carreau"])]


@pytest.mark.slow
@pytest.mark.parametrize("order", quick_ones(ORDERS, [ORDERS[0], ORDERS[-1]]))
def test_of_laws_that_are_as_good_a_declared_order_chooses(order: tuple[str, ...]) -> None:
    for bits in ((0.0, 0.0, 0.0), BITS, BITS[::-1], (*BITS[1:], BITS[0])):
        size = dict(zip(("eyring", "tanh", "carreau"), 1 + np.array(bits), strict=True))
        known = {"eyring": (12, True), "tanh": (9, True), "carreau": (6, False)}
        laws = {name: (size[name], *known[name]) for name in order}
        # the configured one itself
        row = verdict(laws, "eyring")
        assert row["verdict"] == "tie"
        assert row["left_out_law"] == row["bic_law"] == row["ends_out_law"] == "eyring"
        assert set(row["left_out_ties"]) == set(order)
        # a proven fit, then the fewest constants
        row = verdict({**laws, "deng2026": (3.0, 12, True)}, "deng2026")
        assert row["verdict"] == "another law is better"
        assert row["left_out_law"] == row["bic_law"] == row["ends_out_law"] == "tanh"
        assert row["better_law"] == "tanh"


# ---------------------------------------------------------------- certificate


def test_a_certificate_is_one_whatever_the_last_digits_of_the_searches(quick: Settings) -> None:
    problem, best = polished(make_points("4102", matrix(), noise=1e-4), printed()["4102"])
    doubts = set()
    for bits in BITS:
        ends = [best, Optimum(best.constants * (1 + bits), best.sse * (1 + abs(bits)))]
        made = certificate_columns(problem, ends, np.full(len(best.constants), 0.01), quick.fit)
        assert made["certified"]
        doubts.add(made["doubts"])
    assert doubts == {()}


# ---------------------------------------------------------------- conditions


@bits_of
def test_a_condition_that_varies_by_just_the_least_range_is_followed(
    quick: Settings, bits: float
) -> None:
    assert quick.fit.min_relative_range == 0.1
    for name, low, high in (
        ("max_hertz_pressure_gpa", 0.9, 1.0),
        ("entrainment_speed_m_s", 27.0, 30.0),
        ("inlet_temperature_c", 63.0, 70.0),
    ):
        levels = np.array([[low], [high * (1 + bits)]])
        assert varied_condition_mask([name], levels, quick.fit).all()


@bits_of
def test_levels_that_are_just_the_gap_apart_are_one_whatever_their_last_digits(bits: float) -> None:
    # 21 levels are a twentieth of their range apart, which is the gap
    levels = np.linspace(0.9, 1.9, 21)
    levels[1::2] *= 1 + bits
    assert level_numbers_by_gap(levels, 0.05).max() == 0
    assert level_numbers_by_gap(levels, 0.049).max() == 20
    assert level_numbers_by_gap(levels[:0], 0.05).tolist() == []
    slips = np.array([0.01, 0.016, 0.022]) * [1, 1 + bits, 1]
    assert level_indices(slips, 0.006).tolist() == [1, 1, 2]


@pytest.mark.filterwarnings("error")
def test_infinite_values_are_levels_and_not_unknown(config: Settings) -> None:
    """The logarithm of a load of 0 is minus infinity."""
    values = np.array([0.0, -np.inf, np.nan, np.inf, -np.inf, np.inf])
    assert level_indices(values, 0.1).tolist() == [2, 1, 0, 3, 1, 3]
    loads = np.array([20.0, 0.0, 0.0, np.nan])
    level_numbers = condition_level_numbers("load_n", loads, config.same_condition)
    assert level_numbers.tolist() == [2, 1, 1, 0]


@bits_of
def test_the_missing_corner_of_a_grid_is_just_one_step_away_and_not_outside(bits: float) -> None:
    # the corner is within the tested box, and one step from its neighbours
    grid = np.array(matrix([1.0, 1.25, 1.5625], [25.0, 30.0, 36.0], [30.0, 60.0, 90.0]))
    corner, tested = grid[-1] * (1 + bits), grid[:-1]
    box = np.array([*zip(grid.min(axis=0), grid.max(axis=0), strict=True), (0.0, 0.3)])
    known = replace(
        Coefficients.from_constants(LAW, printed()["4102"]),
        tested_box=box,
        tested_conditions=tested,
    )
    found = FittedLaw(LAW, known).predict(corner[np.newaxis], np.array([0.05]))
    assert found.spacings == pytest.approx([1.0], rel=1e-9)
    assert not found.outside.any()
    assert (found.distance == 0).all()
    farther = FittedLaw(LAW, known).predict(corner[np.newaxis] * 1.001, np.array([0.05]))
    assert farther.outside.all()


# ---------------------------------------------------------------- changes of the rig


@pytest.mark.slow
@pytest.mark.parametrize("bits", [nightly(0.0), 1e-13, nightly(-1e-13)])
def test_of_a_group_and_all_other_runs_the_smaller_one_is_blamed_whatever_the_names(
    config: Settings, bits: float
) -> None:
    conditions = matrix([1.0, 1.25, 1.5], [25.0, 40.0], [25.0, 50.0, 85.0, 120.0])
    points = make_points("4050", conditions, noise=1e-4)
    few = np.random.default_rng(1).permutation(len(conditions)) < len(conditions) / 4
    run = points["run_id"].str.removeprefix("run").astype(int).to_numpy()
    gain = np.where(few, 1.05, 1.0) * (1 + bits * (np.arange(len(few)) % 3))
    points["traction_coefficient"] *= gain[run]
    fitted = FittedLaw(LAW, Coefficients.from_constants(LAW, printed()["4050"]))
    surface = with_measured_surface(fitted, points, config.surface).surface
    assert surface is not None
    campaign = MeasuredCampaign.from_surface(surface)
    runs = np.array([f"run{number:03d}" for number in range(len(few))])
    for smaller, larger in (("rig a", "rig b"), ("rig b", "rig a")):
        is_few = np.isin(campaign.run_ids, runs[few])
        row = change_columns(campaign, {smaller: is_few, larger: ~is_few}, config.steadiness)
        assert (row["change"], row["change_course"]) == ("traction force", "group")
        assert row["change_group"] == smaller
        assert set(row["changed_runs"]) == set(runs[few])
        assert row["change_size"] == pytest.approx(0.05, rel=0.1)


# ---------------------------------------------------------------- tests to run next


@pytest.mark.parametrize("seed", range(3))
def test_places_on_a_grid_that_are_as_far_are_taken_in_their_order(seed: int) -> None:
    axes = np.log([1.0, 1.25, 1.5625]), np.log([25.0, 30.0, 36.0]), np.array([30.0, 60.0, 90.0])
    places = np.array([*itertools.product(*axes)])
    exact = FormErrorProcess.spread_over(np.ptp(places, axis=0), places).centres
    bits = 1e-12 * np.random.default_rng(seed).choice([-1, 0, 1], places.shape)
    moved = FormErrorProcess.spread_over(np.ptp(places, axis=0), places * (1 + bits)).centres
    np.testing.assert_allclose(moved, exact, rtol=1e-11)


@bits_of
def test_of_tests_that_tell_the_same_the_first_is_planned(bits: float) -> None:
    x = np.array([-2.0, 1.0, 2.0, -2.0])
    rows_of = np.stack([np.ones_like(x), x], axis=-1)[:, np.newaxis]
    new = np.swapaxes(rows_of, 1, 2) @ rows_of
    new[2] *= 1 + bits
    new[3] *= 1 - bits
    # a slope is as well known by either end
    plan = choose_curves(np.diag([4.0, 10.0]), new, np.array([[0.0, 1.0]]), 3)
    assert plan.chosen_indices == [0, 2, 3]
