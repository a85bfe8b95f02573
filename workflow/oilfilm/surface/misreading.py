"""Runs whose speed or slip is read twice or half as large: as a sum in place of a mean, or reverse.

Such a reading is too wrong for a small effect of a run. It is put right in the runs that may have
it in common, and the likelihood of all points stands beside that of the points as they were read.

Decides: when a speed or a slip is called misread by a factor of two.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from oilfilm.base.ties import first_largest
from oilfilm.base.units import BoolArray
from oilfilm.surface.effects import RunErrorSizes
from oilfilm.surface.measurements import Measurements
from oilfilm.surface.relabelled import Relabelled
from oilfilm.surface.run_patterns import patterns_of_labels
from oilfilm.surface.steadiness import SteadinessLimits
from oilfilm.surface.surface import LARGEST_DENSE, Surface
from oilfilm.surface.threads import with_one_blas_thread

# Column of the speed among the conditions.
_SPEED = 1
# Reading over the true value.
_FACTORS = (2.0, 0.5)


@dataclass(frozen=True)
class Misreading:
    """A quantity that some runs read too large by a factor.

    Attributes:
        quantity: speed or slip.
        factor: Reading over the true value.
        members: Whether each curve is misread, shape (curves,).
        label: What these runs have in common; empty if that is not known.
        score: Twice the logarithm of the likelihood ratio, less that of the number of candidates.
        is_alarm: Whether the factor explains more than chance does.
    """

    quantity: str
    factor: float
    members: BoolArray
    label: str
    score: float
    is_alarm: bool

    def put_right(self, measurements: Measurements) -> Measurements:
        """The points with the quantity divided by the factor in these runs."""
        if self.quantity == "speed":
            conditions = measurements.conditions.copy()
            conditions[self.members, _SPEED] /= self.factor
            return replace(measurements, conditions=conditions)
        slip = measurements.slip.copy()
        slip[self.members[measurements.curve]] /= self.factor
        return replace(measurements, slip=slip)


@with_one_blas_thread
def misread_runs(
    surface: Surface,
    labels: Mapping[str, BoolArray] | None = None,
    errors: RunErrorSizes | None = None,
    limits: SteadinessLimits | None = None,
) -> Misreading | None:
    """The factor that explains most; None if none explains anything.

    Args:
        surface: The surface; its measurements are in canonical order.
        labels: Whether each curve has a label, by label, shape (curves,).
        errors: Sizes of the errors of the rig, before the data.
        limits: When a factor is named: as a label.

    Returns:
        None also for more than 150 curves, for which no factor is tried.
    """
    measured = surface.measurements
    candidates = list(_candidates(measured, labels or {}))
    if not candidates or len(measured.conditions) > LARGEST_DENSE:
        return None
    as_read = Relabelled.as_read(surface, errors or RunErrorSizes())
    objective_as_read = as_read.objective_of(measured)
    gains = [
        objective_as_read - as_read.objective_of(candidate.put_right(measured))
        for candidate in candidates
    ]
    best = candidates[int(first_largest(gains))]
    if max(gains) <= 0:
        return None
    put_right = as_read.fitted_to(best.put_right(measured))
    ln_choices = np.log(len(candidates))
    score = float(2 * (as_read.objective - put_right.objective - ln_choices))
    alarm_score = (limits or SteadinessLimits()).alarm
    return replace(best, score=score, is_alarm=score > alarm_score)


def _candidates(measured: Measurements, labels: Mapping[str, BoolArray]) -> Iterator[Misreading]:
    """Runs with a label, and runs of large speed or slip, with each factor."""
    label_patterns = patterns_of_labels(labels)
    groups = [
        (label, label_patterns.values[:, row] > 0)
        for row, label in enumerate(label_patterns.labels)
    ]
    curves = len(measured.conditions)
    largest_slip = np.zeros(curves)
    np.maximum.at(largest_slip, measured.curve, measured.slip)
    by_quantity = {"speed": measured.conditions[:, _SPEED], "slip": largest_slip}
    for quantity, values in by_quantity.items():
        for factor in _FACTORS:
            for label, members in groups:
                yield Misreading(quantity, factor, members, label, -np.inf, False)
        if values.max() > _FACTORS[0] * values.min():
            large = values > np.sqrt(values.min() * values.max())
            yield Misreading(quantity, _FACTORS[0], large, "", -np.inf, False)
            yield Misreading(quantity, _FACTORS[1], ~large, "", -np.inf, False)
