"""Patterns over the runs of a campaign, and how well each of them explains the points.

A pattern p has a value per run (one curve is one run here), and a change of the rig is a size times
a pattern. `effect_likelihood` defines W, q and the likelihood ratio of a pattern.

The position of a run in time is its rank, from 0. A step, a block and a single run are intervals of
positions: cumulative sums give all of them at once. A Fourier transform gives all seasons.

Decides: which changes of a rig over its runs are looked for.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from oilfilm.base.ties import first_largest
from oilfilm.base.units import BoolArray, FloatArray, IndexArray
from oilfilm.surface.effect_likelihood import EffectInformation

# A season has a phase beside its size. A free phase counts as this number of patterns.
_PATTERNS_PER_SEASON = 4
# Largest number of runs with which pairs of runs are exchanged in the search for a group.
_LARGEST_RUN_COUNT_WITH_EXCHANGE = 150
# Number of starts of the search for a group, for each order of the runs.
_STARTS_PER_ORDER = 3
# Largest number of steps of this search.
_MAX_STEPS = 60
# Keeps a quotient finite where the divisor is 0.
_SMALLEST_DIVISOR = 1e-300
# Number of columns of `EffectInformation.coupling_root` that are summed over patterns at once. All
# columns at once would take several times its memory.
_COLUMNS_AT_ONCE = 8


def _column_blocks(coupling_root: FloatArray) -> Iterator[FloatArray]:
    """The columns of `EffectInformation.coupling_root`, some at a time."""
    for first_column in range(0, coupling_root.shape[1], _COLUMNS_AT_ONCE):
        yield coupling_root[:, first_column : first_column + _COLUMNS_AT_ONCE]


class Patterns(Protocol):
    """Patterns of one kind over the runs, and their likelihood ratios."""

    @property
    def kind(self) -> str:
        """Kind: trend, step, season, block, run or label."""
        ...

    @property
    def count(self) -> int:
        """Number of patterns."""
        ...

    @property
    def chance_count(self) -> float:
        """Number of patterns from which chance may choose: a season counts once per phase."""
        ...

    def twice_ln_likelihood_ratios(
        self, information: EffectInformation, prior_precision: float
    ) -> FloatArray:
        """Twice the logarithm of the likelihood ratio of each pattern, shape (patterns,).

        Args:
            information: What the points say of the effects.
            prior_precision: Prior inverse variance of the size of a change.
        """
        ...

    def pattern_columns(self, pattern_index: int) -> FloatArray:
        """One pattern, or the sine and the cosine of a season, shape (curves, 1 or 2)."""
        ...

    def label(self, pattern_index: int) -> str:
        """What the runs of a pattern have in common; empty if that is not known."""
        ...


@dataclass(frozen=True)
class GivenPatterns:
    """Patterns of any form, each given as a column.

    Attributes:
        kind: trend or label.
        patterns: One pattern per column, shape (curves, patterns).
        labels: What the runs of each pattern have in common; empty if that is not known.
    """

    kind: str
    patterns: FloatArray
    labels: tuple[str, ...]

    @property
    def count(self) -> int:
        """See `Patterns`."""
        return self.patterns.shape[1]

    @property
    def chance_count(self) -> float:
        """See `Patterns`."""
        return float(self.count)

    def twice_ln_likelihood_ratios(
        self, information: EffectInformation, prior_precision: float
    ) -> FloatArray:
        """See `Patterns`."""
        return (information.vector @ self.patterns) ** 2 / (
            self.size_information(information) + prior_precision
        )

    def size_information(self, information: EffectInformation) -> FloatArray:
        """p' W p, the information on the size of each pattern p, shape (patterns,)."""
        return information.bilinear_forms(self.patterns, self.patterns)

    @property
    def sums_of_squares(self) -> FloatArray:
        """Sum of squares of each pattern about its mean, shape (patterns,)."""
        return np.sum((self.patterns - self.patterns.mean(axis=0)) ** 2, axis=0)

    def pattern_columns(self, pattern_index: int) -> FloatArray:
        """See `Patterns`."""
        return self.patterns[:, [pattern_index]]

    def label(self, pattern_index: int) -> str:
        """See `Patterns`."""
        return self.labels[pattern_index]


@dataclass(frozen=True)
class IntervalPatterns:
    """Patterns that are 1 for runs that follow each other in time, and 0 for all others.

    Attributes:
        kind: step, block, run or cut (runs in an order of their effects, not of time).
        position_in_time: Position in time of each curve, from 0, shape (curves,).
        start_positions: First position of each pattern, shape (patterns,).
        end_positions: First position after each pattern, shape (patterns,).
    """

    kind: str
    position_in_time: IndexArray
    start_positions: IndexArray
    end_positions: IndexArray

    @property
    def count(self) -> int:
        """See `Patterns`."""
        return len(self.start_positions)

    @property
    def chance_count(self) -> float:
        """See `Patterns`."""
        return float(self.count)

    def twice_ln_likelihood_ratios(
        self, information: EffectInformation, prior_precision: float
    ) -> FloatArray:
        """See `Patterns`."""
        projections = self._sums(information.vector[:, np.newaxis])[:, 0]
        return projections**2 / (self.size_information(information) + prior_precision)

    def size_information(self, information: EffectInformation) -> FloatArray:
        """p' W p, the information on the size of each pattern p, shape (patterns,)."""
        uncoupled_part = self._sums(information.uncoupled_diagonal[:, np.newaxis])[:, 0]
        coupled_part = np.zeros(self.count)
        for columns in _column_blocks(information.coupling_root):
            coupled_part += np.sum(self._sums(columns) ** 2, axis=1)
        return uncoupled_part + information.coupling_sign * coupled_part

    @property
    def sums_of_squares(self) -> FloatArray:
        """Sum of squares of each pattern about its mean, shape (patterns,)."""
        run_count = len(self.position_in_time)
        runs_inside = self.end_positions - self.start_positions
        return runs_inside * (run_count - runs_inside) / run_count

    def pattern_columns(self, pattern_index: int) -> FloatArray:
        """See `Patterns`."""
        has_begun = self.position_in_time >= self.start_positions[pattern_index]
        has_ended = self.position_in_time >= self.end_positions[pattern_index]
        return (has_begun & ~has_ended)[:, np.newaxis].astype(float)

    def label(self, pattern_index: int) -> str:
        """See `Patterns`."""
        return ""

    def _sums(self, rows_of_curves: FloatArray) -> FloatArray:
        """Sums of rows over each interval, shape (patterns, columns).

        Args:
            rows_of_curves: One row per curve, shape (curves, columns).
        """
        cumulative_sums = np.zeros((len(rows_of_curves) + 1, rows_of_curves.shape[1]))
        rows_in_time = rows_of_curves[np.argsort(self.position_in_time)]
        np.cumsum(rows_in_time, axis=0, out=cumulative_sums[1:])
        return cumulative_sums[self.end_positions] - cumulative_sums[self.start_positions]


@dataclass(frozen=True)
class SeasonPatterns:
    """Sines and cosines over time, with periods from two runs to all runs.

    With n runs the frequencies are k/(2 n) per run, and k goes from 2 to n. A pattern is a sine and
    a cosine of one frequency.

    Attributes:
        position_in_time: Position in time of each curve, from 0, shape (curves,).
    """

    position_in_time: IndexArray

    kind = "season"

    @property
    def count(self) -> int:
        """See `Patterns`."""
        return len(self.position_in_time) - 1

    @property
    def chance_count(self) -> float:
        """See `Patterns`."""
        return float(_PATTERNS_PER_SEASON * self.count)

    def twice_ln_likelihood_ratios(
        self, information: EffectInformation, prior_precision: float
    ) -> FloatArray:
        """See `Patterns`."""
        curves_by_time = np.argsort(self.position_in_time)
        transform_length = 2 * len(self.position_in_time)
        # k of the class docstring: the index of a frequency in a transform of 2 n values
        frequencies = np.arange(2, len(self.position_in_time) + 1)
        projections = np.fft.fft(information.vector[curves_by_time], transform_length)[frequencies]
        diagonal = np.fft.fft(information.uncoupled_diagonal[curves_by_time], transform_length)
        diagonal_at_double = diagonal[2 * frequencies % transform_length]
        # cos^2 = (1 + cos 2x)/2, sin^2 = (1 - cos 2x)/2, sin cos = (sin 2x)/2
        # W of cosine and cosine, of sine and sine, and of sine and cosine, of each frequency
        cosine = (diagonal[0].real + diagonal_at_double.real) / 2
        sine = (diagonal[0].real - diagonal_at_double.real) / 2
        cross = -diagonal_at_double.imag / 2
        sign = information.coupling_sign
        cosine += prior_precision
        sine += prior_precision
        for columns in _column_blocks(information.coupling_root):
            root = np.fft.fft(columns[curves_by_time], transform_length, axis=0)[frequencies]
            cosine += sign * np.sum(root.real**2, axis=1)
            sine += sign * np.sum(root.imag**2, axis=1)
            cross -= sign * np.sum(root.real * root.imag, axis=1)
        determinant = sine * cosine - cross**2
        squares = cosine * projections.imag**2 + sine * projections.real**2
        cross_product = 2 * cross * projections.imag * projections.real
        return np.asarray((squares + cross_product) / determinant)

    def pattern_columns(self, pattern_index: int) -> FloatArray:
        """See `Patterns`."""
        angle = np.pi * (pattern_index + 2) / len(self.position_in_time) * self.position_in_time
        return np.column_stack([np.sin(angle), np.cos(angle)])

    def label(self, pattern_index: int) -> str:
        """See `Patterns`."""
        return ""


def patterns_over_time(
    position_in_time: IndexArray, fewest_runs: int, longest_block: int
) -> tuple[Patterns, ...]:
    """Trend, steps, seasons, blocks of runs, and single runs.

    Args:
        position_in_time: Position in time of each curve, from 0, shape (curves,).
        fewest_runs: Fewest runs on either side of a step.
        longest_block: Number of runs of the longest block; a block has a third of all runs at most.
    """
    run_count = len(position_in_time)
    trend = position_in_time / max(run_count - 1, 1) - 0.5
    block_lengths = range(2, min(longest_block, run_count // 3) + 1)
    block_starts = [np.arange(run_count - length + 1) for length in block_lengths]
    block_ends = [np.arange(length, run_count + 1) for length in block_lengths]
    no_positions = np.empty(0, dtype=np.int64)
    all_positions = np.arange(run_count)
    return (
        GivenPatterns("trend", trend[:, np.newaxis], ("",)),
        steps_over_time(position_in_time, fewest_runs),
        SeasonPatterns(position_in_time),
        IntervalPatterns(
            "block",
            position_in_time,
            np.concatenate([no_positions, *block_starts]),
            np.concatenate([no_positions, *block_ends]),
        ),
        IntervalPatterns("run", position_in_time, all_positions, all_positions + 1),
    )


def steps_over_time(position_in_time: IndexArray, fewest_runs: int) -> IntervalPatterns:
    """A step at each run that has enough runs on either side.

    Args:
        position_in_time: Position in time of each curve, from 0, shape (curves,).
        fewest_runs: Fewest runs on either side of a step.
    """
    run_count = len(position_in_time)
    start_positions = np.arange(fewest_runs, run_count - fewest_runs + 1)
    return IntervalPatterns(
        "step", position_in_time, start_positions, np.full(len(start_positions), run_count)
    )


def patterns_of_labels(is_member_by_label: Mapping[str, BoolArray]) -> GivenPatterns:
    """The runs of each label against all others.

    Labels of the same runs give one pattern, with the first of these labels. Of two labels that
    divide all runs, the one of fewer runs is kept. A label of a single run, or of all runs but one,
    gives no pattern.

    Args:
        is_member_by_label: Whether each curve has the label, by label, shape (curves,).
    """
    # label and runs of each pattern, by the bytes of its runs
    pattern_by_bytes: dict[bytes, tuple[str, BoolArray]] = {}
    for label, is_member in is_member_by_label.items():
        if not 2 <= np.count_nonzero(is_member) <= len(is_member) - 2:
            continue
        opposite = pattern_by_bytes.get((~is_member).tobytes())
        if opposite is not None:
            _, is_opposite_member = opposite
            if np.count_nonzero(is_member) >= np.count_nonzero(is_opposite_member):
                continue
            del pattern_by_bytes[(~is_member).tobytes()]
        pattern_by_bytes.setdefault(is_member.tobytes(), (label, is_member))
    curve_count = len(next(iter(is_member_by_label.values()))) if is_member_by_label else 0
    pattern_columns = [
        np.zeros((curve_count, 0)),
        *(is_member[:, np.newaxis] for _, is_member in pattern_by_bytes.values()),
    ]
    kept_labels = tuple(label for label, _ in pattern_by_bytes.values())
    return GivenPatterns("label", np.hstack(pattern_columns).astype(float), kept_labels)


def ln_group_counts(run_count: int) -> FloatArray:
    """Logarithm of the number of possible groups of 0, 1, ... runs, up to half of the runs.

    >>> print(f"{np.exp(ln_group_counts(24)[12]):.0f}")
    2704156
    """
    ln_factorials = np.concatenate([[0.0], np.cumsum(np.log(np.arange(1, run_count + 1)))])
    group_sizes = np.arange(run_count // 2 + 1)
    ln_orders_of_all = ln_factorials[run_count]
    ln_orders_of_others = ln_factorials[run_count - group_sizes]
    return ln_orders_of_all - ln_factorials[group_sizes] - ln_orders_of_others


def likeliest_group(information: EffectInformation, prior_precision: float) -> BoolArray:
    """The smaller of the two groups of runs whose difference explains most, less a penalty.

    The penalty is twice the logarithm of the number of groups of this size.

    Runs are sorted by their estimated effects and cut in two. The best cuts are improved by single
    runs that change sides, and by pairs of runs that change places.

    Args:
        information: What the points say of the effects of four runs or more.
        prior_precision: Prior inverse variance of the size of a change.

    Returns:
        Whether each run is in the group, which has at least two runs, shape (curves,).
    """
    run_count = len(information.vector)
    penalty = 2 * ln_group_counts(run_count)
    diagonal = information.diagonal()
    start_groups = []
    for estimated_effects in (
        information.vector,
        information.vector / np.maximum(diagonal, _SMALLEST_DIVISOR),
    ):
        for sort_sign in (1, -1):
            sorted_runs = np.argsort(sort_sign * estimated_effects, kind="stable")
            rank_of_run = np.empty(run_count, dtype=np.int64)
            rank_of_run[sorted_runs] = np.arange(run_count)
            group_sizes = np.arange(2, run_count // 2 + 1)
            cuts = IntervalPatterns("cut", rank_of_run, np.zeros_like(group_sizes), group_sizes)
            scores = (
                cuts.twice_ln_likelihood_ratios(information, prior_precision) - penalty[group_sizes]
            )
            for size_index in np.argsort(-scores, kind="stable")[:_STARTS_PER_ORDER]:
                start_groups.append(rank_of_run < group_sizes[size_index])
    improved_groups = [
        _improved_group(information, prior_precision, penalty, group) for group in start_groups
    ]
    best_index = int(first_largest([score for score, _ in improved_groups]))
    _, is_member = improved_groups[best_index]
    return is_member


def _improved_group(
    information: EffectInformation,
    prior_precision: float,
    penalty: FloatArray,
    is_member: BoolArray,
) -> tuple[float, BoolArray]:
    """Improves a group by changes of sides; returns its score, and whether each run is in it.

    Args:
        information: What the points say of the effects.
        prior_precision: Prior inverse variance of the size of a change.
        penalty: Penalty on the score of a group of 0, 1, ... runs.
        is_member: Whether each run is in the group at the start, shape (curves,).
    """
    run_count = len(is_member)
    is_new_member = is_member
    diagonal = information.diagonal()
    # W in full, for pairs of runs that change places; None where there are too many runs for that
    w_matrix = None
    if run_count <= _LARGEST_RUN_COUNT_WITH_EXCHANGE:
        w_matrix = information.matrix_times(np.eye(run_count))
    score = -np.inf
    for _ in range(_MAX_STEPS):
        pattern = is_new_member.astype(float)
        w_times_pattern = information.matrix_times(pattern)
        projection = float(information.vector @ pattern)
        size_precision = float(w_times_pattern @ pattern) + prior_precision
        present_score = projection**2 / size_precision - penalty[np.count_nonzero(is_new_member)]
        if present_score <= score + 1e-6:
            break
        score = present_score
        is_member = is_new_member
        # -1 for a run that would leave the group, 1 for one that would join it
        change_sign = np.where(is_member, -1.0, 1.0)
        new_projections = projection + change_sign * information.vector
        new_size_precisions = size_precision + 2 * change_sign * w_times_pattern + diagonal
        new_count = np.count_nonzero(is_member) + change_sign.astype(np.int64)
        is_allowed = (new_count >= 2) & (new_count < len(penalty))
        single_scores = (
            new_projections**2 / new_size_precisions - penalty[new_count.clip(0, run_count // 2)]
        )
        single_scores[~is_allowed] = -np.inf
        changed_runs = [int(np.argmax(single_scores))]
        best_score = float(single_scores[changed_runs[0]])
        if w_matrix is not None:
            leaving = np.flatnonzero(is_member)
            joining = np.flatnonzero(~is_member)
            pair_projections = new_projections[leaving, np.newaxis] + information.vector[joining]
            pair_size_precisions = (
                new_size_precisions[leaving, np.newaxis]
                + 2 * (w_times_pattern[joining] - w_matrix[np.ix_(leaving, joining)])
                + diagonal[joining]
            )
            pair_scores = pair_projections**2 / pair_size_precisions - penalty[len(leaving)]
            # positions in `leaving` and `joining`
            leaver, joiner = np.unravel_index(int(np.argmax(pair_scores)), pair_scores.shape)
            if pair_scores[leaver, joiner] > best_score:
                best_score = float(pair_scores[leaver, joiner])
                changed_runs = [int(leaving[leaver]), int(joining[joiner])]
        if best_score <= score:
            break
        is_new_member = is_member.copy()
        is_new_member[changed_runs] ^= True
    return score, is_member
