"""Changes of a rig over its runs, looked for in the effects of runs, given the conditions.

A candidate is a pattern of one effect over the runs, as a step of the gain (`run_patterns`). Its
score is twice the logarithm of its likelihood ratio, less twice the logarithm of the number of
patterns of its kind. The variance of the effect is free under each candidate: otherwise a change
would be taken for scatter, and would hide itself.

Decides: when the runs of a campaign are not steady.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from oilfilm.base.ties import first_largest
from oilfilm.base.units import BoolArray, FloatArray, IndexArray
from oilfilm.surface.effect_likelihood import (
    FIT_VARIANCE_INDEX,
    EffectInformation,
    EffectLikelihood,
    effect_likelihood,
)
from oilfilm.surface.effects import EFFECT_NAMES
from oilfilm.surface.reml import CurveCovariance
from oilfilm.surface.run_patterns import (
    GivenPatterns,
    IntervalPatterns,
    Patterns,
    likeliest_group,
    ln_group_counts,
    patterns_of_labels,
    patterns_over_time,
    steps_over_time,
)
from oilfilm.surface.surface import LARGEST_EXACT_CURVE_COUNT
from oilfilm.surface.threads import with_one_blas_thread

# With fewer runs no groups are searched.
_FEWEST_RUNS_OF_GROUPS = 4
# A smaller share of the information is replaced by this one.
_SMALLEST_SHARE = 1e-6
# Number of variances, far from each other, at which groups are searched.
_VARIANCES_OF_GROUPS = 8


@dataclass(frozen=True)
class ChangeSizes:
    """One size of a change for each effect.

    Attributes:
        gain: Change of the gain of the traction force, in ln mu.
        zero: Change of the zero of the force, as a traction coefficient.
        slip_scale: Change of the scale of the slide-roll ratio, in ln S. It is 0.69 where the slip
            is read twice as large.
        temperature_k: Change of the temperature, in K.
    """

    gain: float
    zero: float
    slip_scale: float
    temperature_k: float

    def size_of(self, effect_name: str) -> float:
        """The size of one of `oilfilm.surface.effects.EFFECT_NAMES`."""
        return float(getattr(self, effect_name))


USUAL_CHANGES = ChangeSizes(gain=0.05, zero=5e-4, slip_scale=0.05, temperature_k=5.0)
LARGEST_CHANGES = ChangeSizes(gain=0.7, zero=0.01, slip_scale=0.8, temperature_k=15.0)


@dataclass(frozen=True)
class SteadinessLimits:
    """When a change over the runs is named. The settings `steadiness` give these limits.

    Attributes:
        alarm: Score above which a trend, a step, a season, a block or a label is named.
        alarm_of_groups: Score above which two groups of runs are named that only mu tells apart.
        alarm_of_a_run: Score above which a single run is named; it is odd by chance more easily.
        fewest_runs: Fewest runs on either side of a step.
        longest_block: Number of runs of the longest block.
        seen_at: A change of this many standard deviations is called visible.
            `benchmarks/steadiness.py seen` measures how many of such changes are named.
        confounded: Share of the information below which a pattern resembles an effect of the
            conditions. Its score must then be larger, by this share over that of the pattern.
        usual: Prior standard deviation of a change. Where the order of the runs is that
            of a condition, a wrong law looks like a huge change, which is unlikely.
        largest: Largest changes that a rig can have; a larger one has another cause.
    """

    alarm: float = 12.0
    alarm_of_groups: float = 18.0
    alarm_of_a_run: float = 30.0
    fewest_runs: int = 3
    longest_block: int = 6
    seen_at: float = 7.5
    confounded: float = 0.2
    usual: ChangeSizes = USUAL_CHANGES
    largest: ChangeSizes = LARGEST_CHANGES

    def alarm_of(self, kind: str) -> float:
        """The score above which a pattern of a kind is named."""
        by_kind = {"run": self.alarm_of_a_run, "group": self.alarm_of_groups}
        return by_kind.get(kind, self.alarm)

    def factor_on_score(self, share: FloatArray) -> FloatArray:
        """Factor on the score above which each pattern is named, 1 or more.

        Args:
            share: Information on each pattern over its mean in a random order of the runs.
        """
        return np.maximum(1.0, self.confounded / share)


@dataclass(frozen=True)
class Change:
    """A change of the rig over its runs.

    Attributes:
        effect_name: One of `oilfilm.surface.effects.EFFECT_NAMES`.
        kind: trend, step, season, block, run, label or group.
        pattern: Share of the change in each run, shape (curves,). It is 1 for suspect runs and 0
            for the others; for a trend it goes from -0.5 to 0.5, for a season from -1 to 1.
        size: Most likely size of the change: in ln mu for the gain, in ln S for the scale of slip,
            in mu for the zero, in K for the temperature.
        score: Twice the logarithm of the likelihood ratio, less twice that of the number of
            patterns of its kind.
        alarm_score: Score above which the change is too large to be chance or a wrong law.
        label: What the suspect runs have in common; empty if that is not known.
    """

    effect_name: str
    kind: str
    pattern: FloatArray
    size: float
    score: float
    alarm_score: float
    label: str

    @property
    def is_alarm(self) -> bool:
        """Whether the score is large enough for the change to be named."""
        return self.score > self.alarm_score


@dataclass(frozen=True)
class SmallestVisibleChanges:
    """The smallest change of each effect that would be visible, in the units of `Change.size`.

    Where the order of the runs is that of a condition, a trend of the rig and the effect of the
    condition resemble each other, and the sizes are large.

    Attributes:
        trend: Change from the first to the last run, by name of the effect; infinite where none
            would be visible.
        step: Step that would be visible at whichever run it is, by name of the effect; infinite
            where no step would be visible at some run.
    """

    trend: dict[str, float]
    step: dict[str, float]


@with_one_blas_thread
def largest_change(
    covariance: CurveCovariance,
    position_in_time: IndexArray,
    is_member_by_label: Mapping[str, BoolArray] | None = None,
    limits: SteadinessLimits | None = None,
) -> Change | None:
    """The change that is farthest above its limit, or least below it.

    Args:
        covariance: Covariance of the curves (`Surface.misfit_covariance`).
        position_in_time: Position in time of each curve, from 0, shape (curves,).
        is_member_by_label: Whether each curve has the label, by label, shape (curves,).
        limits: When a change is named.

    Returns:
        None if all candidates are larger than a change of a rig can be.
    """
    limits = limits or SteadinessLimits()
    pattern_families = (
        *patterns_over_time(position_in_time, limits.fewest_runs, limits.longest_block),
        patterns_of_labels(is_member_by_label or {}),
    )
    changes: list[Change] = []
    for effect_name in EFFECT_NAMES:
        changes += _likeliest_changes_of(effect_name, covariance, pattern_families, limits)
    possible_changes = [
        change
        for change in changes
        if abs(change.size) <= limits.largest.size_of(change.effect_name)
    ]
    if not possible_changes:
        return None
    excess = [change.score - change.alarm_score for change in possible_changes]
    return _with_suspects(possible_changes[int(first_largest(excess))], position_in_time)


def _likeliest_changes_of(
    effect_name: str,
    covariance: CurveCovariance,
    pattern_families: Sequence[Patterns],
    limits: SteadinessLimits,
) -> list[Change]:
    """The likeliest change of one effect by each kind of pattern.

    It frees its memory when it returns: in a large campaign there is no memory for two effects.

    Args:
        effect_name: Name of the effect.
        covariance: Covariance of the curves.
        pattern_families: Patterns of each kind.
        limits: When a change is named.
    """
    likelihood = effect_likelihood(covariance, effect_name)
    search = _ChangeSearch(
        effect_name,
        likelihood,
        prior_precision=limits.usual.size_of(effect_name) ** -2,
        twice_ln_steady_likelihoods=likelihood.twice_ln_steady_likelihoods(),
    )
    is_small_campaign = len(covariance.curves.conditions) <= LARGEST_EXACT_CURVE_COUNT
    candidates = search.candidates(pattern_families, is_small_campaign)
    return search.likeliest_changes(candidates, limits)


@with_one_blas_thread
def smallest_visible_changes(
    covariance: CurveCovariance,
    position_in_time: IndexArray,
    limits: SteadinessLimits | None = None,
) -> SmallestVisibleChanges:
    """The smallest changes that would be visible.

    Args:
        covariance: Covariance of the curves (`Surface.misfit_covariance`).
        position_in_time: Position in time of each curve, from 0, shape (curves,).
        limits: `seen_at`, the number of standard deviations of a visible change.
    """
    limits = limits or SteadinessLimits()
    # a rig that is right at its first run and drifts from there
    drift = (position_in_time / max(len(position_in_time) - 1, 1))[:, np.newaxis]
    trend_pattern = GivenPatterns("trend", drift, ("",))
    step_patterns = steps_over_time(position_in_time, limits.fewest_runs)
    trend_sizes: dict[str, float] = {}
    step_sizes: dict[str, float] = {}
    for effect_name in EFFECT_NAMES:
        trend_sizes[effect_name], step_sizes[effect_name] = _smallest_visible_sizes(
            effect_name, covariance, (trend_pattern, step_patterns), limits
        )
    return SmallestVisibleChanges(trend_sizes, step_sizes)


@with_one_blas_thread
def smallest_visible_size(
    covariance: CurveCovariance,
    effect_name: str,
    pattern: FloatArray,
    limits: SteadinessLimits | None = None,
) -> float:
    """The smallest size of a pattern over the runs that would be visible; infinite if none would.

    Args:
        covariance: Covariance of the curves (`Surface.misfit_covariance`).
        effect_name: One of `oilfilm.surface.effects.EFFECT_NAMES`.
        pattern: The pattern, in the order of the curves, shape (curves,).
        limits: `seen_at`, the number of standard deviations of a visible change.
    """
    single_pattern = GivenPatterns("trend", pattern[:, np.newaxis], ("",))
    (size,) = _smallest_visible_sizes(
        effect_name, covariance, (single_pattern,), limits or SteadinessLimits()
    )
    return size


def _smallest_visible_sizes(
    effect_name: str,
    covariance: CurveCovariance,
    pattern_families: Sequence[GivenPatterns | IntervalPatterns],
    limits: SteadinessLimits,
) -> list[float]:
    """The smallest size at which all patterns of each family would be visible.

    It is infinite if one of them never is.
    """
    information = effect_likelihood(covariance, effect_name).information(FIT_VARIANCE_INDEX)
    random_information = _random_information(information)
    prior_precision = limits.usual.size_of(effect_name) ** -2
    sizes = []
    for patterns in pattern_families:
        size_information = patterns.size_information(information)
        # the conditions may take up all of a pattern
        if not (size_information.size and np.all(size_information > 0)):
            sizes.append(float("inf"))
            continue
        share = _share_of_information(
            size_information, patterns.sums_of_squares, random_information
        )
        # a change has the score (size * information)^2 / precision; the factor raises its limit
        size_precision = size_information + prior_precision
        score_factor = limits.factor_on_score(share)
        standard_deviations = np.sqrt(score_factor * size_precision) / size_information
        sizes.append(limits.seen_at * float(standard_deviations.max()))
    return sizes


@dataclass(frozen=True)
class _Candidate:
    """A pattern that may be a change.

    Attributes:
        kind: Kind of the pattern.
        columns: The pattern, or the sine and the cosine of a season, shape (curves, 1 or 2).
        ln_chances: Logarithm of the number of patterns from which chance may choose.
        label: What the runs have in common; empty if that is not known.
    """

    kind: str
    columns: FloatArray
    ln_chances: float
    label: str


class _FittedCandidate(NamedTuple):
    """A candidate with its most likely size, at one variance of the effect.

    Attributes:
        twice_ln_likelihood: Twice the logarithm of its likelihood, up to a constant.
        size: Most likely size of each of its columns.
        share: Information on it over its mean in a random order of the runs.
    """

    twice_ln_likelihood: float
    size: FloatArray
    share: float


@dataclass(frozen=True)
class _ChangeSearch:
    """The search for the likeliest changes of one effect.

    What the points say at one variance is the largest array of a large campaign. It is made again
    where it is needed again, and never kept.

    Attributes:
        effect_name: Name of the effect.
        likelihood: Its likelihood.
        prior_precision: Prior inverse variance of the size of a change.
        twice_ln_steady_likelihoods: Twice the logarithm of the likelihood without a change at each
            variance, shape (variances,).
    """

    effect_name: str
    likelihood: EffectLikelihood
    prior_precision: float
    twice_ln_steady_likelihoods: FloatArray

    def candidates(
        self, pattern_families: Sequence[Patterns], is_small_campaign: bool
    ) -> list[_Candidate]:
        """The likeliest pattern of each kind, and the likeliest groups of runs.

        Patterns are compared at all variances if the campaign is small, and in a large campaign at
        the most likely variance of steady runs only.

        Args:
            pattern_families: Patterns of each kind.
            is_small_campaign: Whether the campaign is small.
        """
        variance_indices = list(range(len(self.twice_ln_steady_likelihoods)))
        if not is_small_campaign:
            variance_indices = [int(np.argmax(self.twice_ln_steady_likelihoods))]
        information_by_variance_index = {
            index: self.likelihood.information(index) for index in variance_indices
        }
        likeliest_patterns = [
            self._likeliest_pattern(patterns, information_by_variance_index)
            for patterns in pattern_families
            if patterns.count
        ]
        groups = self._likeliest_groups(list(information_by_variance_index.values()))
        return [*likeliest_patterns, *groups]

    def _likeliest_pattern(
        self, patterns: Patterns, information_by_variance_index: Mapping[int, EffectInformation]
    ) -> _Candidate:
        """The likeliest pattern of one kind."""
        likelihoods = [
            self.twice_ln_steady_likelihoods[variance_index]
            + patterns.twice_ln_likelihood_ratios(information, self.prior_precision)
            for variance_index, information in information_by_variance_index.items()
        ]
        pattern_index = int(first_largest(np.max(likelihoods, axis=0)))
        return _Candidate(
            kind=patterns.kind,
            columns=patterns.pattern_columns(pattern_index),
            ln_chances=float(np.log(patterns.chance_count)),
            label=patterns.label(pattern_index),
        )

    def _likeliest_groups(
        self, information_of_variances: Sequence[EffectInformation]
    ) -> list[_Candidate]:
        """The likeliest group of runs at each of some variances.

        Args:
            information_of_variances: What the points say of the effects, one item per variance.
        """
        run_count = len(information_of_variances[0].vector)
        if run_count < _FEWEST_RUNS_OF_GROUPS:
            return []
        # by bytes: a group that is found at several variances is one candidate
        is_member_by_bytes = {}
        stride = max(len(information_of_variances) // _VARIANCES_OF_GROUPS, 1)
        for information in information_of_variances[::stride]:
            is_member = likeliest_group(information, self.prior_precision)
            is_member_by_bytes[is_member.tobytes()] = is_member
        candidates = []
        for is_member in is_member_by_bytes.values():
            ln_chances = float(ln_group_counts(run_count)[np.count_nonzero(is_member)])
            columns = is_member[:, np.newaxis].astype(float)
            candidates.append(_Candidate("group", columns, ln_chances, ""))
        return candidates

    def likeliest_changes(
        self, candidates: Sequence[_Candidate], limits: SteadinessLimits
    ) -> list[Change]:
        """The change by each candidate, at the variance at which it is likeliest."""
        fits_of_variances = [
            self._fitted(candidates, variance_index)
            for variance_index in range(len(self.twice_ln_steady_likelihoods))
        ]
        changes = []
        for candidate_index, candidate in enumerate(candidates):
            fits = [fits_at_variance[candidate_index] for fits_at_variance in fits_of_variances]
            likeliest_fit = max(fits, key=lambda fit: fit.twice_ln_likelihood)
            changes.append(self._change(candidate, likeliest_fit, limits))
        return changes

    def _fitted(
        self, candidates: Sequence[_Candidate], variance_index: int
    ) -> list[_FittedCandidate]:
        """Each candidate with its most likely size at one of the variances."""
        information = self.likelihood.information(variance_index)
        random_information = _random_information(information)
        fits = []
        for candidate in candidates:
            columns = candidate.columns
            column_vector = information.vector @ columns
            data_precision = columns.T @ information.matrix_times(columns)
            size_precision = data_precision + self.prior_precision * np.eye(len(column_vector))
            size = np.asarray(np.linalg.solve(size_precision, column_vector), dtype=float)
            twice_ln_likelihood = float(
                self.twice_ln_steady_likelihoods[variance_index] + column_vector @ size
            )
            pattern = columns @ size
            size_information = size @ data_precision @ size
            sum_of_squares = np.sum((pattern - pattern.mean()) ** 2)
            share = _share_of_information(size_information, sum_of_squares, random_information)
            fits.append(_FittedCandidate(twice_ln_likelihood, size, float(share)))
        return fits

    def _change(
        self, candidate: _Candidate, fit: _FittedCandidate, limits: SteadinessLimits
    ) -> Change:
        """The change by a candidate."""
        has_two_columns = len(fit.size) > 1
        total_size = float(np.linalg.norm(fit.size)) if has_two_columns else float(fit.size[0])
        pattern = candidate.columns[:, 0]
        if has_two_columns and total_size > 0:
            pattern = candidate.columns @ fit.size / total_size
        largest_steady = float(self.twice_ln_steady_likelihoods.max())
        score = fit.twice_ln_likelihood - largest_steady - 2 * candidate.ln_chances
        score_factor = float(limits.factor_on_score(np.array(fit.share)))
        return Change(
            effect_name=self.effect_name,
            kind=candidate.kind,
            pattern=pattern,
            size=total_size,
            score=score,
            alarm_score=limits.alarm_of(candidate.kind) * score_factor,
            label=candidate.label,
        )


def _random_information(information: EffectInformation) -> float:
    """Mean information on a pattern in a random order of the runs, over its sum of squares."""
    run_count = len(information.vector)
    ones = np.ones(run_count)
    mean_information = ones @ information.matrix_times(ones) / run_count
    return float((np.sum(information.diagonal()) - mean_information) / (run_count - 1))


def _share_of_information(
    size_information: FloatArray, sums_of_squares: FloatArray, random_information: float
) -> FloatArray:
    """Information on each pattern over its mean in a random order of the runs, shape (patterns,).

    It is small where the pattern resembles an effect of the conditions, which the surface takes up.

    Args:
        size_information: p' W p, the information on the size of each pattern p, shape (patterns,).
        sums_of_squares: Sum of squares of each pattern about its mean, shape (patterns,).
        random_information: As `_random_information` gives it.
    """
    expected_information = sums_of_squares * random_information
    shares = np.full(np.shape(size_information), _SMALLEST_SHARE)
    np.divide(size_information, expected_information, out=shares, where=expected_information > 0)
    return np.maximum(shares, _SMALLEST_SHARE)


def _with_suspects(change: Change, position_in_time: IndexArray) -> Change:
    """The change with the smaller group of runs as suspect, unless a label names the runs.

    Of two groups of the same size the one without the first run is suspect.
    """
    if change.kind in ("trend", "season", "label"):
        return change
    is_member = change.pattern > 0.5
    other_count = len(is_member) - np.count_nonzero(is_member)
    is_tie = np.count_nonzero(is_member) == other_count
    is_larger = np.count_nonzero(is_member) > other_count
    if is_larger or (is_tie and is_member[np.argmin(position_in_time)]):
        return replace(change, pattern=1 - change.pattern, size=-change.size)
    return change
