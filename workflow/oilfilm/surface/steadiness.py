"""Changes of a rig over its runs, looked for in the effects of runs, given the conditions.

The variance of an effect is free under each candidate: a change would else be taken for scatter,
and hide itself. The score of a candidate is twice the logarithm of its likelihood ratio, less twice
that of the number of patterns of its kind.

Decides: when the runs of a campaign are not steady.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from oilfilm.base.ties import first_largest
from oilfilm.base.units import BoolArray, FloatArray, IndexArray
from oilfilm.surface.effect_likelihood import (
    EXPECTED,
    EffectLikelihood,
    Information,
    effect_likelihood,
)
from oilfilm.surface.effects import EFFECTS
from oilfilm.surface.reml import CurveCovariance
from oilfilm.surface.run_patterns import (
    Columns,
    Intervals,
    Patterns,
    likeliest_group,
    ln_groups,
    patterns_of_labels,
    patterns_over_time,
    steps_over_time,
)
from oilfilm.surface.surface import LARGEST_DENSE
from oilfilm.surface.threads import with_one_blas_thread

_FEWEST_RUNS_OF_GROUPS = 4
# A smaller share of the information counts as this one.
_SMALLEST_SHARE = 1e-6
# Groups are searched at each of so many variances, which are far from each other.
_VARIANCES_OF_GROUPS = 8


@dataclass(frozen=True)
class ChangeSizes:
    """One size of a change for each effect.

    Attributes:
        gain: Of the traction force, in ln mu.
        zero: Of the zero of the force, as a traction coefficient.
        slip_scale: Of the slide-roll ratio, in ln S; a slip that is read twice as large is 0.69.
        temperature_k: Of the temperature, in K.
    """

    gain: float
    zero: float
    slip_scale: float
    temperature_k: float

    def size_of(self, effect: str) -> float:
        """The size of one of `oilfilm.surface.effects.EFFECTS`."""
        return float(getattr(self, effect))


USUAL_CHANGES = ChangeSizes(gain=0.05, zero=5e-4, slip_scale=0.05, temperature_k=5.0)
LARGEST_CHANGES = ChangeSizes(gain=0.7, zero=0.01, slip_scale=0.8, temperature_k=15.0)


@dataclass(frozen=True)
class SteadinessLimits:
    """When a change over the runs is named.

    Attributes:
        alarm: Score above which a trend, a step, a season, a block or a label is named.
        alarm_of_groups: The same of two groups of runs that nothing tells apart but mu.
        alarm_of_a_run: The same of a single run, which is odd by chance more easily.
        fewest_runs: A step leaves so many runs on either side.
        longest_block: Runs of the longest block.
        seen_at: A change of so many standard deviations is called visible. How many of such changes
            are named is measured by `benchmarks/steadiness.py seen`.
        confounded: A pattern that resembles an effect of the conditions has a smaller share of the
            information than this. Its score must be larger by the same factor.
        usual: Standard deviation of a change, before the data. Where the order of the runs is that
            of a condition, a wrong law looks like a huge change, which is unlikely.
        largest: Sizes that no rig has, so that they are no cause.
    """

    alarm: float = 12.0
    alarm_of_groups: float = 18.0
    alarm_of_a_run: float = 30.0
    fewest_runs: int = 3
    longest_block: int = 6
    seen_at: float = 5.0
    confounded: float = 0.2
    usual: ChangeSizes = USUAL_CHANGES
    largest: ChangeSizes = LARGEST_CHANGES

    def alarm_of(self, kind: str) -> float:
        """The score above which a pattern of a kind is named."""
        by_kind = {"run": self.alarm_of_a_run, "group": self.alarm_of_groups}
        return by_kind.get(kind, self.alarm)

    def factor_on_score(self, share: FloatArray) -> FloatArray:
        """Factor on the score from which each pattern is named.

        Args:
            share: Information on each pattern, over the mean of patterns in a random order.
        """
        return np.maximum(1.0, self.confounded / share)


@dataclass(frozen=True)
class Change:
    """A change of the rig over its runs.

    Attributes:
        effect: One of `oilfilm.surface.effects.EFFECTS`.
        kind: trend, step, season, block, run, label or group.
        pattern: 1 for the runs that are suspect, else 0; of a trend from -0.5 to 0.5 over the
            runs, of a season from -1 to 1. Shape (curves,).
        size: Most likely size of the change: in ln mu for the gain, in ln S for the scale of slip,
            in mu for the zero, in K for the temperature.
        score: Twice the logarithm of the likelihood ratio, less the penalty.
        alarm: Score above which the change is too large to be chance or a wrong law.
        label: What the suspect runs have in common; empty if that is not known.
    """

    effect: str
    kind: str
    pattern: FloatArray
    size: float
    score: float
    alarm: float
    label: str

    @property
    def is_alarm(self) -> bool:
        """Whether the change is named."""
        return self.score > self.alarm


@dataclass(frozen=True)
class SmallestChanges:
    """The smallest change of each effect that would be seen, in the units of `Change.size`.

    Where the order of the runs is that of a condition, a trend of the rig and the effect of the
    condition resemble each other, and the sizes are large.

    Attributes:
        trend: Change from the first to the last run, by effect; infinite where none would be seen.
        step: Change from some run on, wherever that is, by effect; infinite where it would not be
            seen from each run on.
    """

    trend: dict[str, float]
    step: dict[str, float]


@with_one_blas_thread
def largest_change(
    covariance: CurveCovariance,
    order: IndexArray,
    labels: Mapping[str, BoolArray] | None = None,
    limits: SteadinessLimits | None = None,
) -> Change | None:
    """The change that is farthest above its limit, or least below it.

    Args:
        covariance: Covariance of the curves (`Surface.misfit_covariance`).
        order: Position in time of each curve, from 0, shape (curves,).
        labels: Whether each curve has a label, by label, shape (curves,).
        limits: When a change is named.

    Returns:
        None if each candidate has a size that no rig has.
    """
    limits = limits or SteadinessLimits()
    families = (
        *patterns_over_time(order, limits.fewest_runs, limits.longest_block),
        patterns_of_labels(labels or {}),
    )
    changes = []
    for effect in EFFECTS:
        likelihood = effect_likelihood(covariance, effect)
        precision = limits.usual.size_of(effect) ** -2
        profile = _Profile.at_variances(effect, likelihood, precision, len(order) <= LARGEST_DENSE)
        candidates = [profile.best(patterns) for patterns in families if patterns.count]
        changes.extend(profile.changes([*candidates, *profile.groups()], limits))
    possible = [
        change for change in changes if abs(change.size) <= limits.largest.size_of(change.effect)
    ]
    if not possible:
        return None
    excess = [change.score - change.alarm for change in possible]
    return _with_suspects(possible[int(first_largest(excess))], order)


@with_one_blas_thread
def smallest_changes(
    covariance: CurveCovariance, order: IndexArray, limits: SteadinessLimits | None = None
) -> SmallestChanges:
    """The smallest changes that would be seen: so many standard deviations as the limits say.

    Args:
        covariance: Covariance of the curves (`Surface.misfit_covariance`).
        order: Position in time of each curve, from 0, shape (curves,).
        limits: The number of standard deviations.
    """
    limits = limits or SteadinessLimits()
    # a rig that is right at its first run and drifts from there
    drift = (order / max(len(order) - 1, 1))[:, np.newaxis]
    trend = Columns("trend", drift, ("",))
    steps = steps_over_time(order, limits.fewest_runs)
    trend_sizes: dict[str, float] = {}
    step_sizes: dict[str, float] = {}
    for effect in EFFECTS:
        likelihood = effect_likelihood(covariance, effect)
        trend_sizes[effect] = _smallest_seen_size(effect, likelihood, trend, limits)
        step_sizes[effect] = _smallest_seen_size(effect, likelihood, steps, limits)
    return SmallestChanges(trend_sizes, step_sizes)


@with_one_blas_thread
def smallest_seen(
    covariance: CurveCovariance,
    effect: str,
    pattern: FloatArray,
    limits: SteadinessLimits | None = None,
) -> float:
    """The smallest size of a pattern over the runs that would be seen; infinite if none would.

    Args:
        covariance: Covariance of the curves (`Surface.misfit_covariance`).
        effect: One of `oilfilm.surface.effects.EFFECTS`.
        pattern: The pattern, in the order of the curves, shape (curves,).
        limits: The number of standard deviations.
    """
    likelihood = effect_likelihood(covariance, effect)
    patterns = Columns("trend", pattern[:, np.newaxis], ("",))
    return _smallest_seen_size(effect, likelihood, patterns, limits or SteadinessLimits())


def _smallest_seen_size(
    effect: str,
    likelihood: EffectLikelihood,
    patterns: Columns | Intervals,
    limits: SteadinessLimits,
) -> float:
    """The smallest size at which each of some patterns would be seen; infinite if one never is."""
    information = likelihood.information(EXPECTED)
    power = patterns.power(information)
    # the conditions may take up all of a pattern
    if not (power.size and np.all(power > 0)):
        return float("inf")
    share = _share_of_information(information, power, patterns.squares)
    prior_precision = limits.usual.size_of(effect) ** -2
    deviations = np.sqrt(limits.factor_on_score(share) * (power + prior_precision)) / power
    return limits.seen_at * float(deviations.max())


@dataclass(frozen=True)
class _Candidate:
    """A pattern that may be a change.

    Attributes:
        kind: Kind of the pattern.
        columns: The pattern, or the sine and the cosine of a season, shape (curves, 1 or 2).
        ln_chances: Logarithm of the number of patterns that chance may choose from.
        label: What the runs have in common; empty if that is not known.
    """

    kind: str
    columns: FloatArray
    ln_chances: float
    label: str


class _Likeliest(NamedTuple):
    """A candidate at the variance under which it is likeliest.

    Attributes:
        twice_ln_likelihood: Twice the logarithm of its likelihood, up to a constant.
        size: Most likely size of each of its columns.
        share: Information on it, over that of patterns in a random order.
    """

    twice_ln_likelihood: float
    size: FloatArray
    share: float


@dataclass(frozen=True)
class _Profile:
    """The likelihood of an effect at the variances at which patterns are compared.

    Attributes:
        effect: The effect.
        likelihood: Its likelihood.
        precision: Inverse variance of the size of a change, before the data.
        steady: Twice the logarithm of the likelihood without a change at each variance.
        compared: What the points say at some of the variances, by the number of the variance.
    """

    effect: str
    likelihood: EffectLikelihood
    precision: float
    steady: FloatArray
    compared: dict[int, Information]

    @classmethod
    def at_variances(
        cls, effect: str, likelihood: EffectLikelihood, precision: float, is_small_campaign: bool
    ) -> "_Profile":
        """All variances in a small campaign, else the most likely one of steady runs."""
        steady = likelihood.steady
        numbers = range(len(steady)) if is_small_campaign else [int(np.argmax(steady))]
        compared = {number: likelihood.information(number) for number in numbers}
        return cls(effect, likelihood, precision, steady, compared)

    def best(self, patterns: Patterns) -> _Candidate:
        """The pattern with the largest likelihood ratio."""
        ratios = [
            self.steady[number] + patterns.ratios(information, self.precision)
            for number, information in self.compared.items()
        ]
        number = int(first_largest(np.max(ratios, axis=0)))
        columns, label = patterns.columns(number), patterns.label(number)
        return _Candidate(patterns.kind, columns, float(np.log(patterns.chances)), label)

    def groups(self) -> list[_Candidate]:
        """The likeliest group of runs at some of the variances."""
        informations = list(self.compared.values())
        runs = len(informations[0].pull)
        if runs < _FEWEST_RUNS_OF_GROUPS:
            return []
        groups = {}
        for information in informations[:: max(len(informations) // _VARIANCES_OF_GROUPS, 1)]:
            members = likeliest_group(information, self.precision)
            groups[members.tobytes()] = members
        candidates = []
        for members in groups.values():
            ln_chances = float(ln_groups(runs)[np.count_nonzero(members)])
            columns = members[:, np.newaxis].astype(float)
            candidates.append(_Candidate("group", columns, ln_chances, ""))
        return candidates

    def changes(self, candidates: list[_Candidate], limits: SteadinessLimits) -> list[Change]:
        """The change by each candidate, with the variance under which it is likeliest."""
        likeliest = [_Likeliest(-np.inf, np.zeros(1), 1.0)] * len(candidates)
        for number, steady in enumerate(self.steady):
            # the large ones are made one by one, because together they do not fit into memory
            information = self.compared.get(number) or self.likelihood.information(number)
            for row, candidate in enumerate(candidates):
                columns = candidate.columns
                precision_of_size = columns.T @ information.times(columns)
                pull = information.pull @ columns
                precision_of_size = precision_of_size + self.precision * np.eye(len(pull))
                size = np.asarray(np.linalg.solve(precision_of_size, pull), dtype=float)
                twice_ln_likelihood = float(steady + pull @ size)
                if twice_ln_likelihood > likeliest[row].twice_ln_likelihood:
                    likeliest[row] = _Likeliest(
                        twice_ln_likelihood, size, _share_of_pattern(information, columns @ size)
                    )
        changes = []
        for candidate, (twice_ln_likelihood, size, share) in zip(
            candidates, likeliest, strict=True
        ):
            total_size = float(size[0]) if len(size) == 1 else float(np.linalg.norm(size))
            pattern = candidate.columns[:, 0]
            if len(size) > 1 and total_size > 0:
                pattern = candidate.columns @ size / total_size
            score = twice_ln_likelihood - float(self.steady.max()) - 2 * candidate.ln_chances
            factor = float(limits.factor_on_score(np.array(share)))
            alarm = limits.alarm_of(candidate.kind) * factor
            changes.append(
                Change(
                    self.effect, candidate.kind, pattern, total_size, score, alarm, candidate.label
                )
            )
        return changes


def _share_of_information(
    information: Information, power: FloatArray, squares: FloatArray
) -> FloatArray:
    """Information on each pattern over the mean of patterns in a random order, shape (patterns,).

    It is small where the pattern resembles an effect of the conditions, which the surface takes up.

    Args:
        information: What the points say of the effects.
        power: p' W p of each pattern p, shape (patterns,).
        squares: Sum of squares of each pattern about its mean, shape (patterns,).
    """
    runs = len(information.pull)
    ones = np.ones(runs)
    mean_information = ones @ information.times(ones) / runs
    random_information = (np.sum(information.diagonal()) - mean_information) / (runs - 1)
    expected = squares * random_information
    share = np.full(len(power), _SMALLEST_SHARE)
    np.divide(power, expected, out=share, where=expected > 0)
    return np.maximum(share, _SMALLEST_SHARE)


def _share_of_pattern(information: Information, pattern: FloatArray) -> float:
    """`_share_of_information` of one pattern, shape (curves,)."""
    power = pattern @ information.times(pattern)
    squares = np.sum((pattern - pattern.mean()) ** 2)
    share = _share_of_information(information, np.array([power]), np.array([squares]))
    return float(share[0])


def _with_suspects(change: Change, order: IndexArray) -> Change:
    """The change with the smaller group of runs as suspect, unless a label names the runs.

    Of two groups of the same size the one without the first run is suspect.
    """
    if change.kind in ("trend", "season", "label"):
        return change
    members = change.pattern > 0.5
    count_of_others = len(members) - np.count_nonzero(members)
    is_tie = np.count_nonzero(members) == count_of_others
    is_larger = np.count_nonzero(members) > count_of_others
    if is_larger or (is_tie and members[np.argmin(order)]):
        return replace(change, pattern=1 - change.pattern, size=-change.size)
    return change
