"""Whether the zero of a traction force is one: phases that slide, forces that are left.

Decides: whether a phase is pure rolling; when a force contradicts the zero of a traction rig.
"""

from collections.abc import Mapping

import numpy as np

from oilfilm.curation import statistics
from oilfilm.curation.gate import Columns, Fault, Finding
from oilfilm.curation.rig_kind import Rest
from oilfilm.curation.signals import Signals
from oilfilm.curation.standstill import phases_at_standstill
from oilfilm.curation.zero import ZeroReference, phase_too_short, zero_reference
from oilfilm.settings.config import CurationSettings
from oilfilm.units import FloatArray

# No rig that means to roll slides so much, and no sweep begins with a negative slip.
_ABSURD_SLIP = 0.5
# So many standard errors are no chance.
_SURE = 5
# Slips of one level on the way up and down, relative.
_SAME = 1.1
# The curve may be so many times as steep at its beginning as up to its first level.
_STEEPEST = 10


def sliding_phase(rest: Rest, name: str, limit: float) -> Finding | None:
    """A phase whose slide-roll ratio is beyond a limit, if it is."""
    slip = float(np.mean(rest.signals["slide_roll_ratio"][rest.phases[name]]))
    if abs(slip) <= limit:
        return None
    wrong = slip < -limit or slip > _ABSURD_SLIP
    hint = "; such a slip may come from swapped speed columns or wrong track radii"
    return Finding(
        f"the {name} phase runs at a slide-roll ratio of {slip:.4f}; expected pure rolling, "
        f"within {limit}{hint if wrong else ''}"
    )


def part_of_curve(rest: Rest, plateaus: Columns, allowed: float) -> Fault | None:
    """A phase taken for pure rolling whose traction is more than a share of the largest one."""
    slips, mu = plateaus["slide_roll_ratio"], plateaus["traction_coefficient"]
    largest = float(np.nanmax(np.abs(mu), initial=0.0))
    for name, part in rest.phases.items():
        values = rest.signals["slide_roll_ratio"][np.newaxis, part]
        inside = np.ones(values.shape, dtype=bool)
        mean = statistics.means(values, inside)
        slip = float(mean[0])
        if abs(slip) <= _SURE * float(statistics.standard_errors(values, inside, mean)[0]):
            continue
        slope = initial_slope(slips, mu, slip)
        swallowed = abs(slope * slip)
        if swallowed > allowed * largest:
            return "zero_missing", Finding(
                f"the {name} phase is not pure rolling: its slide-roll ratio is {slip:.4f}. "
                f"By the initial slope of the run ({slope:.3g}) its traction coefficient is "
                f"{swallowed:.2g}, {swallowed / largest:.0%} of the largest one; allowed "
                f"{allowed:.0%}"
            )
    return None


def force_at_standstill(signals: Signals, curation: CurationSettings) -> dict[str, ZeroReference]:
    """The mean force before and after a run, where the rig stands still for long enough."""
    least_s, spike = curation.zero_reference.min_duration_s, curation.spikes.threshold
    return {
        name: zero_reference(signals, "traction_force_n", {name: part}, spike)
        for name, part in phases_at_standstill(signals, curation).items()
        if phase_too_short(signals, part, name, least_s) is None
    }


def left_at_standstill(still: Mapping[str, ZeroReference], allowed_n: float) -> Fault | None:
    """A force at standstill although the rig is said to have removed its zero."""
    for name, zero in still.items():
        force_n, error_n = float(zero.output[0]), float(zero.output_se[0])
        if abs(force_n) > allowed_n + _SURE * error_n:
            return _left(force_n, f"in the {name} phase of standstill", allowed_n)
    return None


def left_without_slip(plateaus: Columns, allowed_n: float) -> Fault | None:
    """A force on plateaus whose slip is none within its error, in the same case."""
    rolling = np.abs(plateaus["slide_roll_ratio"]) <= _SURE * plateaus["slide_roll_ratio_se"]
    force_n = plateaus["traction_force_n"]
    error_n = plateaus["traction_coefficient_se"] * plateaus["load_n"]
    off = force_n[rolling & (np.abs(force_n) > allowed_n + _SURE * error_n)]
    return _left(float(off[0]), "without slip", allowed_n) if len(off) else None


def _left(force_n: float, where: str, allowed_n: float) -> Fault:
    return "zero_left", Finding(
        f"the traction force is {force_n:.3g} N {where}, but semantics: zero is already_removed; "
        f"allowed {allowed_n:g} N"
    )


def standstill_hint(still: Mapping[str, ZeroReference], rig: str) -> str:
    """What to write so that the readings at standstill give the zero.

    Args:
        still: The force at standstill.
        rig: The rig, where the campaign file has semantics of its own for it; else empty.
    """
    if "opening" not in still:
        return ""
    when = {"opening": "before", "closing": "after"}
    forces = " and ".join(
        f"{zero.output[0]:.3g} N {when[name]} the run" for name, zero in still.items()
    )
    setting = "semantics: {zero: standstill}"
    if rig:
        setting = f"semantics_of_rig: {{{rig}: {{zero: standstill}}}}"
    return (
        f". The rig stands still, with a force of {forces}. Where no load is held sideways "
        f"there, that is the zero: write `{setting}` into the campaign's file in "
        "config/campaigns"
    )


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
