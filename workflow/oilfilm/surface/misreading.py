"""Runs whose speed or slip is read twice or half as large: as a sum in place of a mean, or reverse.

Such an error is too large for an effect of a run. The reading is corrected in runs that may share
the error. The likelihood of all points is then compared with that of the points as they were read.

Decides: when a speed or a slip is called misread by a factor of two.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from oilfilm.base.ties import first_largest
from oilfilm.base.units import BoolArray
from oilfilm.surface.effects import ErrorPriors
from oilfilm.surface.fitted_readings import FittedReadings
from oilfilm.surface.measurements import Measurements
from oilfilm.surface.run_patterns import patterns_of_labels
from oilfilm.surface.steadiness import SteadinessLimits
from oilfilm.surface.surface import LARGEST_EXACT_CURVE_COUNT, Surface
from oilfilm.surface.threads import with_one_blas_thread

# Column of the speed among the conditions.
_SPEED_COLUMN = 1
# Factors (reading over true value) that are tried.
_CANDIDATE_FACTORS = (2.0, 0.5)


@dataclass(frozen=True)
class Misreading:
    """A quantity that some runs read too large by a factor.

    Attributes:
        quantity: speed or slip.
        factor: Reading over the true value.
        is_misread: Whether each curve is misread, shape (curves,).
        label: What these runs have in common; empty if that is not known.
        score: Twice the logarithm of the ratio of likelihood times priors, each at its most likely
            sizes, less twice that of the number of candidates.
        is_alarm: Whether the factor explains more than chance does.
    """

    quantity: str
    factor: float
    is_misread: BoolArray
    label: str
    score: float
    is_alarm: bool

    def corrected(self, measurements: Measurements) -> Measurements:
        """The points, with the quantity divided by the factor in the misread runs."""
        if self.quantity == "speed":
            conditions = measurements.conditions.copy()
            conditions[self.is_misread, _SPEED_COLUMN] /= self.factor
            return replace(measurements, conditions=conditions)
        slip = measurements.slip.copy()
        slip[self.is_misread[measurements.curve_of_point]] /= self.factor
        return replace(measurements, slip=slip)


@with_one_blas_thread
def likeliest_misreading(
    surface: Surface,
    is_member_by_label: Mapping[str, BoolArray] | None = None,
    error_priors: ErrorPriors | None = None,
    limits: SteadinessLimits | None = None,
) -> Misreading | None:
    """The factor that explains most; None if none explains anything.

    Args:
        surface: The surface; its measurements are in canonical order.
        is_member_by_label: Whether each curve has the label, by label, shape (curves,).
        error_priors: Priors of the sizes of the errors of the rig.
        limits: `alarm`, the score above which a factor is named.

    Returns:
        None also for more than 150 curves, for which no factor is tried.
    """
    measurements_as_read = surface.measurements
    candidates = list(_candidates(measurements_as_read, is_member_by_label or {}))
    if not candidates or len(measurements_as_read.conditions) > LARGEST_EXACT_CURVE_COUNT:
        return None
    as_read = FittedReadings.as_read(surface, error_priors or ErrorPriors())
    negative_ln_likelihood_as_read = as_read.negative_ln_likelihood_of(measurements_as_read)
    improvements = [
        negative_ln_likelihood_as_read
        - as_read.negative_ln_likelihood_of(candidate.corrected(measurements_as_read))
        for candidate in candidates
    ]
    likeliest = candidates[int(first_largest(improvements))]
    if max(improvements) <= 0:
        return None
    corrected = as_read.fit_to(likeliest.corrected(measurements_as_read))
    ln_choices = np.log(len(candidates))
    score = float(
        2 * (as_read.negative_ln_posterior - corrected.negative_ln_posterior - ln_choices)
    )
    alarm_score = (limits or SteadinessLimits()).alarm
    return replace(likeliest, score=score, is_alarm=score > alarm_score)


def _candidates(
    measurements_as_read: Measurements, is_member_by_label: Mapping[str, BoolArray]
) -> Iterator[Misreading]:
    """Each factor on speed and on slip, for runs of each label, of large and of small values."""
    label_patterns = patterns_of_labels(is_member_by_label)
    labelled_groups = [
        (label, label_patterns.patterns[:, pattern_index] > 0)
        for pattern_index, label in enumerate(label_patterns.labels)
    ]
    curve_count = len(measurements_as_read.conditions)
    largest_slip = np.zeros(curve_count)
    np.maximum.at(largest_slip, measurements_as_read.curve_of_point, measurements_as_read.slip)
    values_by_quantity = {
        "speed": measurements_as_read.conditions[:, _SPEED_COLUMN],
        "slip": largest_slip,
    }
    for quantity, values in values_by_quantity.items():
        for factor in _CANDIDATE_FACTORS:
            for label, is_member in labelled_groups:
                yield Misreading(quantity, factor, is_member, label, -np.inf, False)
        if values.max() > _CANDIDATE_FACTORS[0] * values.min():
            is_large = values > np.sqrt(values.min() * values.max())
            yield Misreading(quantity, _CANDIDATE_FACTORS[0], is_large, "", -np.inf, False)
            yield Misreading(quantity, _CANDIDATE_FACTORS[1], ~is_large, "", -np.inf, False)
