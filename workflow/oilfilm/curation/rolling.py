"""Whether a phase of pure rolling rolls: its traction must not be part of the curve.

Decides: whether a phase is pure rolling.
"""

import numpy as np

from oilfilm.units import FloatArray

# Slips of one level on the way up and down, relative.
_SAME = 1.1
# The curve may be so many times as steep at its beginning as up to its first level.
_STEEPEST = 10


def initial_slope(slip: FloatArray, mu: FloatArray, at_slip: float) -> float:
    """d mu/dS at the beginning of a curve whose zero was taken at a slip; 0 where none is known.

    The chord from that slip to the nearest level, times the factor by which the chord to the next
    level is flatter, extended over the distance: the slope of a saturating curve falls as an
    exponential. A curve that has saturated at its nearest level may be ten times as steep.

    Args:
        slip: Slide-roll ratio of each plateau, shape (n,).
        mu: Traction coefficient above the zero, shape (n,).
        at_slip: Mean slide-roll ratio of the phase that gave the zero.

    Examples:
        By hand: the chord 12.5 (exp(-0.2) - exp(-0.6)) = 3.374, times exp(0.3), because chords
        0.004 apart fall by exp(-0.4). The curve's own slope is 4.524 at 0.001 and 5 at 0.

        >>> slip = np.array([0.006, 0.01, 0.02])
        >>> mu = 0.05 * (np.exp(-0.002 / 0.01) - np.exp(-slip / 0.01))
        >>> print(f"{initial_slope(slip, mu, 0.002):.3f}")
        4.554
    """
    away, size = np.abs(slip - at_slip), np.abs(mu)
    known = np.isfinite(away) & np.isfinite(size) & (away > 0) & (away >= abs(at_slip) / 2)
    away, size = away[known], size[known]
    if len(away) == 0:
        return 0.0
    near = away <= _SAME * away.min()
    chord, to_near = size[near].mean() / away[near].mean(), away[near].mean()
    away, size = away[~near], size[~near] - size[near].mean()
    if len(away) == 0:
        return float(_STEEPEST * chord)
    next_ = away <= _SAME * away.min()
    step = away[next_].mean() - to_near
    flatter = max(size[next_].mean() / step, 0.0)
    if flatter <= 0:
        return float(_STEEPEST * chord)
    # from the middle of the first chord back to the middle of what the zero swallowed
    power = (to_near + abs(at_slip)) / (to_near + step)
    return float(chord * np.clip((chord / flatter) ** power, 1, _STEEPEST))
