"""A law fitted as the mean of a surface."""

import numpy as np
import pytest

from lawless_truths import DENG_CONSTANTS, TRUTHS
from oilfilm.surface.quick_law import quick_law
from oilfilm.traction import PAPER_LAW
from surface_campaigns import PlantedErrors, grid, latin, simulated

NO_ERRORS = PlantedErrors(gain=0.0, zero=0.0, slip_scale=0.0, temperature_k=0.0, noise=0.0)


def test_constants_of_exact_points_are_found():
    measured = simulated(TRUTHS["own"], latin(), np.random.default_rng(1), NO_ERRORS)
    law = quick_law(PAPER_LAW, measured, 1e-5)
    assert law.constants == pytest.approx(DENG_CONSTANTS, abs=1e-3)
    assert law.is_free.all()


def test_exponents_of_a_condition_that_was_not_varied_are_held():
    conditions = grid((1.0, 1.5), (30.0,), (25.0, 72.0, 120.0))
    measured = simulated(TRUTHS["own"], conditions, np.random.default_rng(2), NO_ERRORS)
    law = quick_law(PAPER_LAW, measured, 1e-5)
    held = [
        constant.name
        for constant, free in zip(PAPER_LAW.constants, law.is_free, strict=True)
        if not free
    ]
    assert held == ["A2", "B2", "C2"]
    true = TRUTHS["own"](*measured.point_conditions.T, measured.slip)
    assert np.exp(law.log_mu(measured.point_conditions, measured.slip)) == pytest.approx(
        true, rel=1e-3
    )


def test_points_without_traction_give_no_law():
    measured = simulated(TRUTHS["own"], latin(), np.random.default_rng(3), NO_ERRORS)
    with pytest.raises(ValueError, match="check the unit of mu"):
        quick_law(PAPER_LAW, measured, 10.0)
