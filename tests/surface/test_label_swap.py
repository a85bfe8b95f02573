"""Temperature labels that were exchanged among runs."""

import functools
from dataclasses import replace

import numpy as np
import pytest

from lawless_truths import TRUTHS
from nights import nightly
from oilfilm.surface import label_swap
from oilfilm.surface.effects import ErrorPriors
from oilfilm.surface.fitted_readings import FittedReadings
from oilfilm.surface.label_swap import likeliest_swap
from oilfilm.surface.law_mean import FreeLaw
from oilfilm.surface.surface import fit_surface
from surface_campaigns import fitted_law, latin, random_conditions, simulated

SLIPS = np.geomspace(0.002, 0.3, 9)
# rows of a ring
RING = (2, 11, 18, 22)


@functools.cache
def surface_with_labels(truth, rows, seed):
    """The surface of points whose temperatures go round in a ring among some runs."""
    conditions = latin()
    measured = simulated(TRUTHS[truth], conditions, np.random.default_rng(seed), slips=SLIPS)
    labelled, rows = conditions.copy(), np.array(rows, dtype=np.int64)
    labelled[rows, 2] = conditions[np.roll(rows, 1), 2]
    measured = replace(measured, conditions=labelled)
    curves, _ = measured.canonical_order()
    return fit_surface(measured, fitted_law(measured)), curves, conditions


@pytest.mark.slow
@pytest.mark.parametrize("truth", ["own", "jt"])
def test_exchanged_labels_are_found_with_the_right_temperatures(truth):
    surface, curves, true = surface_with_labels(truth, RING, 47)
    swap = likeliest_swap(surface)
    assert swap is not None
    assert swap.is_alarm
    assert set(curves[swap.curve_indices].tolist()) == set(RING)
    np.testing.assert_allclose(swap.temperatures_c, true[curves[swap.curve_indices], 2])


@pytest.mark.parametrize("truth", [nightly("own"), "jt"])
def test_right_labels_stay(truth):
    surface, *_ = surface_with_labels(truth, (), 48)
    swap = likeliest_swap(surface)
    assert swap is None or not swap.is_alarm


@pytest.mark.slow
def test_no_temperature_is_proposed_at_which_the_law_has_no_traction(monkeypatch):
    surface, _, true = surface_with_labels("own", RING, 47)

    def has_traction(law, conditions, slip):
        return (conditions != true[2]).any(axis=1)

    monkeypatch.setattr(FreeLaw, "has_traction", has_traction)
    swap = likeliest_swap(surface)
    conditions = surface.measurements.conditions.copy()
    conditions[swap.curve_indices, 2] = swap.temperatures_c
    assert (conditions != true[2]).any(axis=1).all()


@pytest.mark.slow
def test_the_exchange_is_not_tried_among_many_runs(monkeypatch):
    surface, *_ = surface_with_labels("own", RING, 47)
    assert likeliest_swap(surface) is not None
    monkeypatch.setattr(label_swap, "LARGEST_EXACT_CURVE_COUNT", 10)
    assert likeliest_swap(surface) is None


@pytest.mark.nightly
def test_the_labels_as_read_are_no_likelier_at_other_sizes():
    # the sizes of a surface of so many curves are those of a sample
    random = np.random.default_rng(62)
    measured = simulated(TRUTHS["own"], random_conditions(100, random), random, slips=SLIPS)
    surface = fit_surface(measured, fitted_law(measured))
    as_read = FittedReadings.as_read(surface, ErrorPriors())
    refitted = as_read.fit_to(as_read.measurements)
    assert as_read.negative_ln_posterior == pytest.approx(refitted.negative_ln_posterior, abs=0.05)
