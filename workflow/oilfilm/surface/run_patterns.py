"""Patterns over the runs of a campaign, and how well each of them explains the points.

Positions in time are whole numbers. A step, a block and a single run are intervals of time, so that
cumulative sums give all of them at once. A Fourier transform gives all seasons at once.

Decides: which changes of a rig over its runs are looked for.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from oilfilm.base.ties import first_largest
from oilfilm.base.units import BoolArray, FloatArray, IndexArray
from oilfilm.surface.effect_likelihood import Information

# A season has a phase beside its size, which counts as so many patterns.
_PHASES = 4
# Longest campaign in which pairs of runs are exchanged while groups are searched.
_LARGEST_WITH_EXCHANGE = 150
# Starts of the search for a group, and its largest number of steps.
_STARTS, _STEPS = 3, 60
_TINY = 1e-300
# Columns of a root that are summed over patterns at once: all of them would be several roots.
_COLUMNS_AT_ONCE = 32


def _column_blocks(root: FloatArray) -> Iterator[FloatArray]:
    """The columns of a root, some at a time."""
    for first in range(0, root.shape[1], _COLUMNS_AT_ONCE):
        yield root[:, first : first + _COLUMNS_AT_ONCE]


class Patterns(Protocol):
    """Patterns of one kind over the runs."""

    @property
    def kind(self) -> str:
        """Kind: trend, step, season, block, run or label."""
        ...

    @property
    def count(self) -> int:
        """Number of patterns."""
        ...

    @property
    def chances(self) -> float:
        """Number of patterns that chance may choose from."""
        ...

    def ratios(self, information: Information, precision: float) -> FloatArray:
        """Twice the logarithm of the likelihood ratio of each pattern, shape (patterns,).

        Args:
            information: What the points say of the effects.
            precision: Inverse variance of the size of a change, before the data.
        """
        ...

    def columns(self, number: int) -> FloatArray:
        """One pattern, or the sine and the cosine of a season, shape (curves, 1 or 2)."""
        ...

    def label(self, number: int) -> str:
        """What the runs of a pattern have in common; empty if that is not known."""
        ...


@dataclass(frozen=True)
class Columns:
    """Patterns that are given one by one.

    Attributes:
        kind: trend or label.
        values: One pattern per column, shape (curves, patterns).
        labels: What the runs have in common, one per pattern.
    """

    kind: str
    values: FloatArray
    labels: tuple[str, ...]

    @property
    def count(self) -> int:
        """See `Patterns`."""
        return self.values.shape[1]

    @property
    def chances(self) -> float:
        """See `Patterns`."""
        return float(self.count)

    def ratios(self, information: Information, precision: float) -> FloatArray:
        """See `Patterns`."""
        return (information.pull @ self.values) ** 2 / (self.power(information) + precision)

    def power(self, information: Information) -> FloatArray:
        """p' W p of each pattern p, shape (patterns,)."""
        return information.between(self.values, self.values)

    @property
    def squares(self) -> FloatArray:
        """Sum of squares of each pattern about its mean, shape (patterns,)."""
        return np.sum((self.values - self.values.mean(axis=0)) ** 2, axis=0)

    def columns(self, number: int) -> FloatArray:
        """See `Patterns`."""
        return self.values[:, [number]]

    def label(self, number: int) -> str:
        """See `Patterns`."""
        return self.labels[number]


@dataclass(frozen=True)
class Intervals:
    """Patterns of runs that follow each other in time.

    Attributes:
        kind: step, block or run.
        order: Position in time of each curve, from 0, shape (curves,).
        starts: First position of each pattern, shape (patterns,).
        ends: First position after each pattern, shape (patterns,).
    """

    kind: str
    order: IndexArray
    starts: IndexArray
    ends: IndexArray

    @property
    def count(self) -> int:
        """See `Patterns`."""
        return len(self.starts)

    @property
    def chances(self) -> float:
        """See `Patterns`."""
        return float(self.count)

    def ratios(self, information: Information, precision: float) -> FloatArray:
        """See `Patterns`."""
        pull = self._sums(information.pull[:, np.newaxis])[:, 0]
        return pull**2 / (self.power(information) + precision)

    def power(self, information: Information) -> FloatArray:
        """p' W p of each pattern p, shape (patterns,)."""
        unshared = self._sums(information.unshared[:, np.newaxis])[:, 0]
        shared = np.zeros(self.count)
        for columns in _column_blocks(information.root):
            shared += np.sum(self._sums(columns) ** 2, axis=1)
        return unshared + information.sign * shared

    @property
    def squares(self) -> FloatArray:
        """Sum of squares of each pattern about its mean, shape (patterns,)."""
        runs, inside = len(self.order), self.ends - self.starts
        return inside * (runs - inside) / runs

    def columns(self, number: int) -> FloatArray:
        """See `Patterns`."""
        inside = (self.order >= self.starts[number]) & (self.order < self.ends[number])
        return inside[:, np.newaxis].astype(float)

    def label(self, number: int) -> str:
        """See `Patterns`."""
        return ""

    def _sums(self, values: FloatArray) -> FloatArray:
        """Sums of rows over each interval, shape (patterns, columns).

        Args:
            values: One row per curve, shape (curves, columns).
        """
        total = np.zeros((len(values) + 1, values.shape[1]))
        np.cumsum(values[np.argsort(self.order)], axis=0, out=total[1:])
        return total[self.ends] - total[self.starts]


@dataclass(frozen=True)
class Seasons:
    """Sine and cosine of periods between two runs and all runs.

    The frequencies are k/(2 n) per run for n runs, with k from 2 to n.

    Attributes:
        order: Position in time of each curve, from 0, shape (curves,).
    """

    order: IndexArray

    kind = "season"

    @property
    def count(self) -> int:
        """See `Patterns`."""
        return len(self.order) - 1

    @property
    def chances(self) -> float:
        """See `Patterns`."""
        return float(_PHASES * self.count)

    def ratios(self, information: Information, precision: float) -> FloatArray:
        """See `Patterns`."""
        by_time = np.argsort(self.order)
        points = 2 * len(self.order)
        numbers = np.arange(2, len(self.order) + 1)
        pull = np.fft.fft(information.pull[by_time], points)[numbers]
        unshared = np.fft.fft(information.unshared[by_time], points)
        unshared_at_double = unshared[2 * numbers % points]
        # cos^2 = (1 + cos 2x)/2, sin^2 = (1 - cos 2x)/2, sin cos = (sin 2x)/2
        cosine = (unshared[0].real + unshared_at_double.real) / 2
        sine = (unshared[0].real - unshared_at_double.real) / 2
        cross = -unshared_at_double.imag / 2
        sign = information.sign
        cosine += precision
        sine += precision
        for columns in _column_blocks(information.root):
            root = np.fft.fft(columns[by_time], points, axis=0)[numbers]
            cosine += sign * np.sum(root.real**2, axis=1)
            sine += sign * np.sum(root.imag**2, axis=1)
            cross -= sign * np.sum(root.real * root.imag, axis=1)
        determinant = sine * cosine - cross**2
        squares = cosine * pull.imag**2 + sine * pull.real**2
        return np.asarray((squares + 2 * cross * pull.imag * pull.real) / determinant)

    def columns(self, number: int) -> FloatArray:
        """See `Patterns`."""
        angle = np.pi * (number + 2) / len(self.order) * self.order
        return np.column_stack([np.sin(angle), np.cos(angle)])

    def label(self, number: int) -> str:
        """See `Patterns`."""
        return ""


def patterns_over_time(
    order: IndexArray, fewest_runs: int, longest_block: int
) -> tuple[Patterns, ...]:
    """Trend, steps, seasons, blocks of runs, and single runs.

    Args:
        order: Position in time of each curve, from 0, shape (curves,).
        fewest_runs: A step leaves so many runs on either side.
        longest_block: Runs of the longest block; a block has a third of all runs at most.
    """
    runs = len(order)
    trend = order / max(runs - 1, 1) - 0.5
    lengths = range(2, min(longest_block, runs // 3) + 1)
    starts = [np.arange(runs - length + 1) for length in lengths]
    ends = [np.arange(length, runs + 1) for length in lengths]
    no_rows = np.empty(0, dtype=np.int64)
    all_positions = np.arange(runs)
    return (
        Columns("trend", trend[:, np.newaxis], ("",)),
        steps_over_time(order, fewest_runs),
        Seasons(order),
        Intervals(
            "block", order, np.concatenate([no_rows, *starts]), np.concatenate([no_rows, *ends])
        ),
        Intervals("run", order, all_positions, all_positions + 1),
    )


def steps_over_time(order: IndexArray, fewest_runs: int) -> Intervals:
    """A step at each run that leaves some runs on either side.

    Args:
        order: Position in time of each curve, from 0, shape (curves,).
        fewest_runs: The number of these runs.
    """
    runs = len(order)
    starts = np.arange(fewest_runs, runs - fewest_runs + 1)
    return Intervals("step", order, starts, np.full(len(starts), runs))


def patterns_of_labels(labels: Mapping[str, BoolArray]) -> Columns:
    """The runs of each label against all others.

    Labels of the same runs are one, with the first name. Of two labels that divide all runs the
    smaller one stays. A label of a single run, or of all runs but one, is no pattern of its own.

    Args:
        labels: Whether each curve has a label, by label, shape (curves,).
    """
    chosen: dict[bytes, tuple[str, BoolArray]] = {}
    for label, members in labels.items():
        if not 2 <= np.count_nonzero(members) <= len(members) - 2:
            continue
        opposite = chosen.get((~members).tobytes())
        if opposite is not None:
            _, opposite_members = opposite
            if np.count_nonzero(members) >= np.count_nonzero(opposite_members):
                continue
            del chosen[(~members).tobytes()]
        chosen.setdefault(members.tobytes(), (label, members))
    curves = len(next(iter(labels.values()))) if labels else 0
    values = [np.zeros((curves, 0)), *(members[:, np.newaxis] for _, members in chosen.values())]
    names = tuple(label for label, _ in chosen.values())
    return Columns("label", np.hstack(values).astype(float), names)


def ln_groups(runs: int) -> FloatArray:
    """Logarithm of the number of groups of 0, 1, ... runs, up to half of them.

    >>> print(f"{np.exp(ln_groups(24)[12]):.0f}")
    2704156
    """
    logarithms = np.concatenate([[0.0], np.cumsum(np.log(np.arange(1, runs + 1)))])
    sizes = np.arange(runs // 2 + 1)
    return logarithms[runs] - logarithms[sizes] - logarithms[runs - sizes]


def likeliest_group(information: Information, precision: float) -> BoolArray:
    """The two groups of runs that explain most, less the penalty of their number.

    Runs are sorted by their estimated effects and cut in two. The best cuts are improved by single
    runs that change sides, and by pairs of runs that change places. The smaller group is returned.
    It has two runs at least, shape (curves,).

    Args:
        information: What the points say of the effects.
        precision: Inverse variance of the size of a change, before the data.
    """
    runs = len(information.pull)
    penalty = 2 * ln_groups(runs)
    diagonal = information.diagonal()
    starts = []
    for estimate in (information.pull, information.pull / np.maximum(diagonal, _TINY)):
        for direction in (1, -1):
            sorted_runs = np.argsort(direction * estimate, kind="stable")
            position = np.empty(runs, dtype=np.int64)
            position[sorted_runs] = np.arange(runs)
            sizes = np.arange(2, runs // 2 + 1)
            cuts = Intervals("cut", position, np.zeros_like(sizes), sizes)
            scores = cuts.ratios(information, precision) - penalty[sizes]
            for number in np.argsort(-scores, kind="stable")[:_STARTS]:
                starts.append((float(scores[number]), position < sizes[number]))
    improved = [_improved(information, precision, penalty, start) for _, start in starts]
    best = int(first_largest([score for score, _ in improved]))
    _, members = improved[best]
    return members


def _improved(
    information: Information, precision: float, penalty: FloatArray, members: BoolArray
) -> tuple[float, BoolArray]:
    """A group after all changes of sides that improve it, and its score.

    Args:
        information: What the points say of the effects.
        precision: Inverse variance of the size of a change, before the data.
        penalty: Penalty by the number of runs in the group.
        members: Whether each run is in the group at the start.
    """
    runs = len(members)
    members = members.copy()
    diagonal = information.diagonal()
    with_pairs = runs <= _LARGEST_WITH_EXCHANGE
    between = information.times(np.eye(runs)) if with_pairs else None
    score = -np.inf
    for _ in range(_STEPS):
        pattern = members.astype(float)
        sums = information.times(pattern)
        pull, power = float(information.pull @ pattern), float(sums @ pattern) + precision
        present_score = pull**2 / power - penalty[np.count_nonzero(members)]
        if present_score <= score + 1e-6:
            break
        score = present_score
        step = np.where(members, -1.0, 1.0)
        new_pull = pull + step * information.pull
        new_power = power + 2 * step * sums + diagonal
        new_count = np.count_nonzero(members) + step.astype(np.int64)
        allowed = (new_count >= 2) & (new_count < len(penalty))
        single_scores = new_pull**2 / new_power - penalty[new_count.clip(0, runs // 2)]
        single_scores[~allowed] = -np.inf
        changed = [int(np.argmax(single_scores))]
        best_score = float(single_scores[changed[0]])
        if between is not None:
            leaving, joining = np.flatnonzero(members), np.flatnonzero(~members)
            pair_pull = new_pull[leaving, np.newaxis] + information.pull[joining]
            pair_power = (
                new_power[leaving, np.newaxis]
                + 2 * (sums[joining] - between[np.ix_(leaving, joining)])
                + diagonal[joining]
            )
            pair_scores = pair_pull**2 / pair_power - penalty[len(leaving)]
            leaver, joiner = np.unravel_index(int(np.argmax(pair_scores)), pair_scores.shape)
            if pair_scores[leaver, joiner] > best_score:
                best_score = float(pair_scores[leaver, joiner])
                changed = [int(leaving[leaver]), int(joining[joiner])]
        if best_score <= score:
            break
        members[changed] ^= True
    return score, members
