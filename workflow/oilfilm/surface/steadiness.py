"""Changes of a rig over its runs, looked for in the effects of runs, given the conditions.

The effects u of a kind (one per run) enter the points by a design Z. Let P be the inverse
covariance of the points without these effects, A = Z' P Z and b = Z' P y. For u = beta p + noise of
variance s^2 per run, with a pattern p over the runs, the likelihood follows from the eigenvalues of
A alone, for all patterns and all s at once. The variance s^2 is free under each candidate: a change
would else be taken for scatter, and hide itself.

Decides: when the runs of a campaign are not steady.
"""

from dataclasses import dataclass, replace

import numpy as np
import scipy.linalg

from oilfilm.base.ties import first_largest
from oilfilm.base.units import FloatArray, IndexArray
from oilfilm.surface.effects import EFFECTS
from oilfilm.surface.reml import CurveCovariance
from oilfilm.surface.surface import LARGEST_DENSE
from oilfilm.surface.threads import with_one_blas_thread

# Twice the logarithm of the likelihood ratio, less twice that of the number of patterns of a kind,
# above which a change is named. A single run may be odd by chance more easily.
_ALARM = 12.0
_ALARM_OF_A_RUN = 30.0
_LONGEST_BLOCK = 6
# A step, or a block, leaves so many runs on either side.
_FEWEST_RUNS = 3
# A change of so many standard deviations would be seen.
_SEEN_AT = 5.0
# Variances that are tried, over the square of the size before the data.
_VARIANCES = np.geomspace(1e-3, 1e3, 61)
# Standard deviation of the logarithm of a size before the data.
_LN_SD = 0.6


@dataclass(frozen=True)
class Patterns:
    """Patterns of one kind over the runs.

    Attributes:
        kind: trend, step, block, run or group.
        columns: One pattern per column, in the order of the curves, shape (curves, patterns).
    """

    kind: str
    columns: FloatArray


@dataclass(frozen=True)
class Change:
    """A change of the rig over its runs.

    Attributes:
        effect: One of `oilfilm.surface.effects.EFFECTS`.
        kind: Kind of the pattern.
        pattern: The pattern, in the order of the curves, shape (curves,).
        size: Size of the change: relative for gain and scale of slip, in mu for the zero, in K for
            the temperature.
        score: Twice the logarithm of the likelihood ratio, less the penalty.
    """

    effect: str
    kind: str
    pattern: FloatArray
    size: float
    score: float

    @property
    def is_alarm(self) -> bool:
        """Whether the change is too large to be chance."""
        return self.score > (_ALARM_OF_A_RUN if self.kind == "run" else _ALARM)


def patterns_over_time(order: IndexArray) -> tuple[Patterns, ...]:
    """Trend, steps, blocks of two to six runs, and single runs.

    Args:
        order: Position in time of each curve, from 0, shape (curves,).
    """
    runs = len(order)
    trend = order / max(runs - 1, 1) - 0.5
    steps = [order >= start for start in range(_FEWEST_RUNS, runs - _FEWEST_RUNS + 1)]
    blocks = []
    for length in range(2, min(_LONGEST_BLOCK, runs // 3) + 1):
        for start in range(runs - length + 1):
            blocks.append((order >= start) & (order < start + length))
    singles = np.equal.outer(order, np.arange(runs))
    return (
        Patterns("trend", trend[:, np.newaxis]),
        Patterns("step", np.array(steps, dtype=float).reshape(-1, runs).T),
        Patterns("block", np.array(blocks, dtype=float).reshape(-1, runs).T),
        Patterns("run", singles.astype(float)),
    )


def patterns_of_labels(labels: IndexArray) -> Patterns:
    """Each label against all others.

    Args:
        labels: Number of the label of each curve, from 0, shape (curves,).
    """
    return Patterns("group", np.equal.outer(labels, np.unique(labels)).astype(float))


@with_one_blas_thread
def largest_change(covariance: CurveCovariance, patterns: tuple[Patterns, ...]) -> Change:
    """The change that the points support most, over all effects and patterns.

    Args:
        covariance: Covariance of the curves (`Surface.misfit_covariance`).
        patterns: The patterns, in the order of the curves.

    Raises:
        ValueError: There are too many curves.
    """
    _refuse_large(covariance)
    candidates = []
    for effect in EFFECTS:
        profile = _Profile.of_effect(covariance, effect)
        for of_kind in patterns:
            columns = of_kind.columns
            if not columns.shape[1]:
                continue
            ratio, size = profile.ratios(columns)
            best = int(first_largest(ratio))
            score = float(ratio[best]) - 2 * np.log(columns.shape[1])
            candidates.append(
                Change(effect, of_kind.kind, columns[:, best], float(size[best]), float(score))
            )
    return candidates[int(first_largest([change.score for change in candidates]))]


@with_one_blas_thread
def smallest_seen(covariance: CurveCovariance, effect: str, pattern: FloatArray) -> float:
    """The smallest size of a change that would be seen: five standard deviations.

    Where the order of the runs is that of a condition, a trend of the rig and the effect of the
    condition resemble each other, and this size is large.

    Args:
        covariance: Covariance of the curves (`Surface.misfit_covariance`).
        effect: One of `oilfilm.surface.effects.EFFECTS`.
        pattern: The pattern, in the order of the curves, shape (curves,).

    Raises:
        ValueError: There are too many curves.
    """
    _refuse_large(covariance)
    profile = _Profile.of_effect(covariance, effect)
    variance = covariance.sizes.effects[EFFECTS.index(effect)] ** 2
    rotated = profile.vectors.T @ pattern
    information = np.sum(profile.values / (1 + variance * profile.values) * rotated**2)
    return float(_SEEN_AT / np.sqrt(information))


def _refuse_large(covariance: CurveCovariance) -> None:
    """Stop where the covariance of all curves does not fit into memory.

    Raises:
        ValueError: There are too many curves.
    """
    curves = len(covariance.curves.conditions)
    if curves > LARGEST_DENSE:
        raise ValueError(
            f"{curves} curves; steadiness is judged for {LARGEST_DENSE} at most: give the curves "
            "in parts, each one a period of time"
        )


@dataclass(frozen=True)
class _Profile:
    """What the points say of the effects of one kind.

    Attributes:
        values: Eigenvalues of A, shape (curves,).
        vectors: Eigenvectors of A, shape (curves, curves).
        pull: Q' b, shape (curves,).
        expected_variance: Variance of an effect before the data.
    """

    values: FloatArray
    vectors: FloatArray
    pull: FloatArray
    expected_variance: float

    @classmethod
    def of_effect(cls, covariance: CurveCovariance, effect: str) -> "_Profile":
        """The profile of one effect."""
        number = EFFECTS.index(effect)
        sizes = covariance.sizes.effects.copy()
        expected = float(sizes[number] ** 2)
        sizes[number] = 0.0
        without = replace(covariance, sizes=replace(covariance.sizes, effects=sizes))
        curves = covariance.curves
        design = curves.membership.multiply(curves.effects[:, number, np.newaxis]).toarray()
        factor = scipy.linalg.cholesky(without.matrix(), lower=True)
        half = scipy.linalg.solve_triangular(factor, design, lower=True)
        departure = scipy.linalg.solve_triangular(factor, curves.departure, lower=True)
        values, vectors = scipy.linalg.eigh(half.T @ half)
        pull = vectors.T @ (half.T @ departure)
        return cls(np.maximum(values, 0.0), vectors, pull, expected)

    def ratios(self, columns: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Twice the logarithm of the likelihood ratio of each pattern, and its size.

        Args:
            columns: One pattern per column, shape (curves, patterns).
        """
        variances = self.expected_variance * _VARIANCES
        # shape (variances, curves)
        shrinkage = 1 / (1 + np.outer(variances, self.values))
        prior = (np.log(_VARIANCES) / 2 / _LN_SD) ** 2
        steady = np.sum(
            variances[:, np.newaxis] * shrinkage * self.pull**2 + np.log(shrinkage), axis=1
        )
        steady -= prior
        rotated = self.vectors.T @ columns
        # shape (variances, patterns)
        information = (shrinkage * self.values) @ rotated**2
        score = (shrinkage * self.pull) @ rotated
        changed = steady[:, np.newaxis] + score**2 / np.maximum(information, 1e-300)
        best = np.argmax(changed, axis=0)
        patterns = np.arange(columns.shape[1])
        size = score[best, patterns] / np.maximum(information[best, patterns], 1e-300)
        return changed[best, patterns] - steady.max(), size
