"""Spin of a ball-on-disc rig, against a numerical integration over the contact."""

from collections.abc import Callable

import numpy as np
import pytest

from oilfilm.physics.rig_spin import edge_slip, spin_correction


def measured(law: Callable[[np.ndarray], np.ndarray], slip: float, edge: float) -> float:
    """mu of a contact with spin: mean of the traction along the slip, by Hertz's pressure.

    Plain midpoints in radius and angle; the share of the load between r and r + dr is
    3 r sqrt(1 - r^2) dr.
    """
    radius = (np.arange(400) + 0.5) / 400
    angle = (np.arange(400) + 0.5) / 400 * 2 * np.pi
    r, phi = np.meshgrid(radius, angle, indexing="ij")
    weight = r * np.sqrt(1 - r**2)
    along, across = slip - edge * r * np.sin(phi), edge * r * np.cos(phi)
    size = np.hypot(along, across)
    return float(np.average(law(size) * along / size, weights=weight))


def saturating(slip: np.ndarray) -> np.ndarray:
    """Traction that rises to a plateau and falls by heat."""
    return 0.04 * np.tanh(np.asarray(slip) / 0.004) / (1 + 5 * np.asarray(slip))


def rising(slip: np.ndarray) -> np.ndarray:
    return 0.03 * (1 - np.exp(-np.asarray(slip) / 0.02))


# a/R2 of 1.0 and 1.5 GPa on a 20 mm ball, track of 40 mm
@pytest.mark.parametrize("edge", [0.0035, 0.0053])
@pytest.mark.parametrize("law", [saturating, rising])
@pytest.mark.parametrize(("slip", "error"), [(0.0125, 3e-3), (0.02, 1e-3), (0.05, 3e-4)])
def test_the_correction_gives_back_the_traction_without_spin(law, edge, slip, error):
    step = 0.02 * slip
    mu_below, mu_with_spin, mu_above = (
        measured(law, slip + slip_change, edge) for slip_change in (-step, 0.0, step)
    )
    slope = (mu_above - mu_below) / (2 * step)
    curvature = (mu_above - 2 * mu_with_spin + mu_below) / step**2
    corrected = mu_with_spin * (1 + spin_correction(slip, mu_with_spin, slope, curvature, edge))
    assert corrected == pytest.approx(float(law(slip)), rel=error)
    # spin takes traction away
    assert mu_with_spin < law(slip)


def test_a_plateau_lacks_a_tenth_of_the_square_of_edge_over_slip():
    flat = lambda slip: 0.03 * np.ones_like(slip)  # noqa: E731
    assert 1 - measured(flat, 0.05, 0.005) / 0.03 == pytest.approx(0.01 / 10, rel=0.01)
    assert spin_correction(0.05, 0.03, 0.0, 0.0, 0.005) == pytest.approx(0.01 / 10)


def test_where_spin_is_half_of_the_slip_or_more_nothing_is_corrected():
    assert np.isnan(spin_correction(0.009, 0.03, 0.0, 0.0, 0.005))
    # docs/physics.md, Spin of the rig: 1.5 GPa on 20 mm of steel, 213 um on 40 mm
    assert edge_slip(213e-6, 40e-3) == pytest.approx(0.0053, abs=1e-4)
