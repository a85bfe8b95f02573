"""Campaigns of 24 runs in which the rig changed, as points, and what was planted in them."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from lawless_truths import LawlessTruth
from oilfilm.base.units import BoolArray, FloatArray, IndexArray
from oilfilm.surface.measurements import Measurements
from surface_campaigns import PlantedErrors, latin, simulated

REFERENCE = (1.25, 30.0, 70.0)
_RUNS_BETWEEN_REFERENCES = 6


@dataclass(frozen=True)
class Planted:
    """What was wrong in a campaign.

    Attributes:
        true_conditions: P, U and T that the contact had, shape (runs, 3).
        gain: Factor on mu by run, shape (runs,).
        zero: Added to mu by run, shape (runs,).
        slip_factor: True slip over the slip that is read, by run, shape (runs,).
        other_oil_share: Share of another oil, by run, shape (runs,).
        pattern: Course of the fault over the runs, shape (runs,).
        effect: The effect of runs that it is, or resembles.
        size: Its size in the unit of that effect; nan if it follows from mu.
    """

    true_conditions: FloatArray
    gain: FloatArray
    zero: FloatArray
    slip_factor: FloatArray
    other_oil_share: FloatArray
    pattern: FloatArray
    effect: str
    size: float


# Plants a fault. Arguments: conditions as labelled, position in time of each run, source of chance.
Fault = Callable[[FloatArray, IndexArray, np.random.Generator], Planted]


def no_fault(conditions: FloatArray, pattern: FloatArray, effect: str, size: float) -> Planted:
    """No fault yet: true conditions as labelled, and readings without errors.

    The arguments are attributes of `Planted`.
    """
    runs = len(conditions)
    ones, zeros = np.ones(runs), np.zeros(runs)
    return Planted(conditions.copy(), ones, zeros, ones, zeros, pattern, effect, size)


def _some(position: IndexArray, count: int, random: np.random.Generator) -> BoolArray:
    """Some runs, anywhere in time."""
    return np.isin(position, random.permutation(len(position))[:count])


def _late(position: IndexArray, random: np.random.Generator) -> BoolArray:
    """The runs after some run between a third and two thirds of the campaign."""
    runs = len(position)
    return position >= random.integers(runs // 3, 2 * runs // 3 + 1)


def _share(position: IndexArray) -> FloatArray:
    """Position in time from 0 to 1."""
    return position / (len(position) - 1)


def temperature_labels_permuted(conditions, position, random):
    """The temperatures of four runs are exchanged in a ring."""
    rows = random.permutation(len(position))[:4]
    planted = no_fault(
        conditions, np.isin(np.arange(len(position)), rows).astype(float), "", np.nan
    )
    true = conditions.copy()
    true[rows, 2] = conditions[np.roll(rows, 1), 2]
    pattern = (np.abs(true[:, 2] - conditions[:, 2]) > 1).astype(float)
    return replace(planted, true_conditions=true, pattern=pattern)


def ball_flat(conditions, position, random):
    """From some run on the pressure is 9 % lower than the label: the ball has a flat."""
    late = _late(position, random)
    planted = no_fault(conditions, late.astype(float), "gain", np.nan)
    planted.true_conditions[late, 0] *= 0.91
    return planted


def contamination(conditions, position, random):
    """Over the campaign the oil becomes a mixture with 40 % of another one."""
    planted = no_fault(conditions, _share(position), "gain", np.nan)
    return replace(planted, other_oil_share=0.4 * _share(position))


def day_and_night(conditions, position, random):
    """The temperature is 4 K higher for four runs, then 4 K lower for four."""
    day = np.where((position // 4) % 2 == 0, 1.0, -1.0)
    planted = no_fault(conditions, day, "temperature_k", 8.0)
    planted.true_conditions[:, 2] += 4.0 * day
    return planted


def force_step(conditions, position, random):
    """From some run on the force reads 3 % higher."""
    late = _late(position, random)
    return replace(
        no_fault(conditions, late.astype(float), "gain", 0.03), gain=np.where(late, 1.03, 1.0)
    )


def gain_drift(conditions, position, random):
    """The force reads higher by 6 % over the campaign."""
    share = _share(position)
    return replace(no_fault(conditions, share, "gain", 0.06), gain=1 + 0.06 * share)


def load_low(conditions, position, random):
    """The load of a third of the runs is 7 % lower than the one that mu is computed with."""
    some = _some(position, len(position) // 3, random)
    planted = no_fault(conditions, some.astype(float), "gain", np.nan)
    planted.true_conditions[some, 0] *= 0.93 ** (1 / 3)
    return replace(planted, gain=np.where(some, 0.93, 1.0))


def outlet_temperature(conditions, position, random):
    """Half of the runs state the temperature of the outlet, 9 K above that of the inlet."""
    some = _some(position, len(position) // 2, random)
    planted = no_fault(conditions, some.astype(float), "temperature_k", 9.0)
    planted.true_conditions[some, 2] -= 9.0
    return planted


def slip_step(conditions, position, random):
    """From some run on the slip reads 5 % low."""
    late = _late(position, random)
    return replace(
        no_fault(conditions, late.astype(float), "slip_scale", 0.05),
        slip_factor=np.where(late, 1.05, 1.0),
    )


def zero_drift(conditions, position, random):
    """The zero of the force moves by 6e-4 of mu over the campaign."""
    share = _share(position)
    return replace(no_fault(conditions, share, "zero", 6e-4), zero=6e-4 * share)


FAULTS: tuple[Fault, ...] = (
    temperature_labels_permuted,
    ball_flat,
    contamination,
    day_and_night,
    force_step,
    gain_drift,
    load_low,
    outlet_temperature,
    slip_step,
    zero_drift,
)
# Faults that grow or come and go: all runs are in them.
GRADUAL = (contamination, day_and_night, gain_drift, zero_drift)
# Faults of runs that nothing tells apart but mu.
WITHOUT_LABEL = (load_low, outlet_temperature)


@dataclass(frozen=True)
class BadCampaign:
    """A simulated campaign.

    Attributes:
        measured: The points, in canonical order.
        position: Position in time of each curve, shape (curves,).
        planted: What was wrong in each run, in the order of the plan.
        pattern: Course of the fault over the curves, shape (curves,).
        size: Size of the fault in the unit of its effect.
    """

    measured: Measurements
    position: IndexArray
    planted: Planted
    pattern: FloatArray
    size: float


def plan(run_order: str, random: np.random.Generator) -> tuple[FloatArray, IndexArray]:
    """Conditions of 24 runs, or 29 with references, and their positions in time.

    Args:
        run_order: `random`; `conditions`: in the order of the conditions; `references`: the same
            with a reference condition before every sixth run and at the end.
        random: Draws a random order.
    """
    conditions = latin()
    runs = len(conditions)
    if run_order == "random":
        return conditions, random.permutation(runs)
    if run_order == "references":
        rows = []
        for start in range(0, runs, _RUNS_BETWEEN_REFERENCES):
            rows.extend([REFERENCE, *conditions[start : start + _RUNS_BETWEEN_REFERENCES]])
        conditions = np.array([*rows, REFERENCE])
    return conditions, np.arange(len(conditions))


def bad_campaign(
    truth: LawlessTruth,
    fault: Fault | None,
    run_order: str,
    random: np.random.Generator,
    slips: FloatArray,
) -> BadCampaign:
    """A campaign with a fault, or without.

    Args:
        truth: mu of the oil.
        fault: The fault.
        run_order: As in `plan`.
        random: Draws the errors and the runs of the fault.
        slips: Slips of every curve.
    """
    conditions, position = plan(run_order, random)
    if fault is None:
        planted = no_fault(conditions, np.zeros(len(conditions)), "", 0.0)
    else:
        planted = fault(conditions, position, random)
    curve = np.repeat(np.arange(len(conditions)), len(slips))

    def mu_of_run(pressure, speed, temperature, slip):
        share, factor = planted.other_oil_share[curve], planted.slip_factor[curve]
        own = truth(pressure, speed, temperature, slip * factor)
        other = 0.8 * truth(pressure, speed, temperature + 15, slip * factor)
        mixed = (1 - share) * own + share * other
        return mixed * planted.gain[curve] + planted.zero[curve]

    measured = simulated(mu_of_run, planted.true_conditions, random, PlantedErrors(), slips)
    labelled = replace(measured, conditions=conditions)
    rows, _ = labelled.canonical_order()
    size = planted.size
    if np.isnan(size):
        # mean change of ln mu where the fault is full
        wrong_mu = mu_of_run(*planted.true_conditions[curve].T, measured.slip)
        right_mu = truth(*conditions[curve].T, measured.slip)
        is_full = planted.pattern[curve] > 0.9
        size = float(np.abs(np.mean(np.log(wrong_mu / right_mu)[is_full])))
    return BadCampaign(
        labelled.in_canonical_order(), position[rows], planted, planted.pattern[rows], size
    )
