"""Patterns in what a fit leaves over: runs that changed, and bends that the law lacks.

Each pattern is a column of errors that could have been made: "from run 12 on the force reads
higher", "mu bends over the temperature". What the constants can take up of it is taken
out; the rest is compared with the residuals, curve by curve, because the points of a run share its
errors. The pattern that explains most comes first. The other kind is looked for in what it leaves
over, so that a change of the rig is not called a bend of the law, nor a bend a change.

Decides: when a pattern in the residuals is called found.
"""

import itertools
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt
import scipy

from oilfilm.base.ties import first_largest, reaches
from oilfilm.base.units import BoolArray, FloatArray, IndexArray
from oilfilm.fits.conditions import levels_by_gap
from oilfilm.fits.descent import descend
from oilfilm.fits.engine import Optimum
from oilfilm.fits.measured_curves import EFFECTS, effects
from oilfilm.fits.problem import Problem, build_problem
from oilfilm.settings.config import PatternSettings

# How patterns are looked for; `patterns` of the configuration says when one is found.
# Rounds and beginnings of the search for two kinds of runs, and the tolerance of a refit in it.
_ROUNDS, _STARTS = 25, 24
_ROUGH = 1e-4
# Column of the entrainment speed among the conditions of every law.
_SPEED = 1
# Levels further apart than this share of the range; with four of them bends of the third order are
# looked for.
_GAP = 0.05
# Degrees of the polynomials over the slip, and over S dmu/dS / mu.
_SHAPES, _RISES = (2, 3, 4, 5), (1, 2, 3, 4)
# Residuals of an exact fit, over mu.
_ROUNDING = 1e-7
# Causes in the order in which they are preferred where they explain nearly the same.
_CAUSES = (
    *("traction force", "load", "inlet temperature", "entrainment speed", "slip"),
    "zero of the force",
)


@dataclass(frozen=True)
class Leftover:
    """A fit and what it leaves over, its curves in the order in which the runs were made.

    Attributes:
        problem: What was fitted.
        optimum: Where it ended.
        groups: Runs that have something in common, by what it is; True for those that have it.
        others: mu of other oils at the points, by oil.
        limits: When a pattern is called found.
    """

    problem: Problem
    optimum: Optimum
    groups: Mapping[str, BoolArray]
    others: Mapping[str, FloatArray]
    limits: PatternSettings

    @cached_property
    def residual(self) -> FloatArray:
        """Measured mu less the law."""
        return -self.problem.residual(self.optimum.values)

    @cached_property
    def jacobian(self) -> FloatArray:
        """Derivatives of mu by the free constants."""
        return self.problem.jacobian(self.optimum.values)

    @cached_property
    def signatures(self) -> dict[str, FloatArray]:
        """Change of (measured mu less the law) per unit of what may be wrong in a run.

        Of the load it is an offset of the cell in newtons, of force, speed and slip a share, of the
        temperature a kelvin; of another oil it is the share of it.
        """
        law, data = self.problem.law, self.problem.data
        of_curves = effects(law, self.problem.expand(self.optimum.values), data)
        columns = dict(zip(EFFECTS, of_curves.T, strict=True))
        columns["load"] = columns["load"] / data.load_n[data.curve]
        columns["slip"] = -self.by_slip
        known = {name: columns[name] for name in _CAUSES if np.isfinite(columns[name]).all()}
        return {**{f"oil {oil}": mu - self.fitted for oil, mu in self.others.items()}, **known}

    @cached_property
    def by_slip(self) -> FloatArray:
        """S dmu/dS at each point."""
        return self.problem.slip_slope(self.optimum.values)

    @property
    def fitted(self) -> FloatArray:
        """mu of the law at each point."""
        return self.problem.mu - self.residual

    @cached_property
    def _bend_basis(self) -> FloatArray:
        bends = (column for _, column in _bends(self))
        return np.linalg.qr(np.column_stack([self.jacobian, *bends]))[0]

    def beside_bends(self, columns: FloatArray) -> FloatArray:
        """Share of what the constants leave of each column that no bend of the law takes up."""
        left = _orthogonal(self.jacobian, columns)
        taken = np.sum((self._bend_basis.T @ left) ** 2, axis=0)
        return np.asarray(1 - taken / np.maximum(np.sum(left**2, axis=0), np.finfo(float).tiny))

    def beside_gain(self, columns: FloatArray) -> FloatArray:
        """What is left of each column, shape (points, n), when each curve has a gain of its own.

        The scatter of the force from run to run then hides no cause of another shape over slip.
        """
        starts, mu = self.problem.starts, self.fitted[:, np.newaxis]
        gain = np.add.reduceat(columns * mu, starts, axis=0) / np.add.reduceat(mu**2, starts)
        return np.asarray(columns - mu * gain[self.problem.observations.curve])

    @property
    def can_show(self) -> bool:
        """Whether there are curves enough to show a pattern."""
        curves = self.problem.curves - 2 - int(self.problem.followed.sum())
        return curves >= self.limits.curves_min

    @property
    def fewest(self) -> int:
        """Fewest curves of a group."""
        share = self.limits.curves_share_min * self.problem.curves
        return max(self.limits.curves_min, int(np.ceil(share)))

    def is_group(self, members: BoolArray) -> bool:
        """Whether these curves, and the others, are enough for a group."""
        return self.fewest <= int(members.sum()) <= len(members) - self.fewest


@dataclass(frozen=True)
class Pattern:
    """One pattern: what, and where.

    Attributes:
        what: Code of the cause: one of `EFFECTS`, `slip`, `oil <name>`, `speed factor` or
            `slip factor` for a quantity that is read twice or half as large; of a bend `shape`, or
            the conditions over which mu or the scale of the slip bends.
        when: `trend`, `from` a run on, `group`, `some runs`; `law` for a bend of the law.
        runs: The runs concerned; all for a trend or a bend.
        group: What they have in common; empty where nothing is known.
        size: In the unit of the cause, as of `Leftover.signatures`; over all runs for a trend; the
            factor of a misread quantity.
        mu_share: Root-mean-square of the pattern over that of mu.
    """

    what: str
    when: str
    runs: tuple[str, ...]
    group: str = ""
    size: float = float("nan")
    mu_share: float = float("nan")


# A pattern, how much of the SSE it explains, and its column.
_Found = tuple[Pattern, float, FloatArray]


def natural_key(name: str) -> tuple[tuple[int, int, str], ...]:
    """Sorts names with numbers in them as people count.

    Examples:
        >>> sorted(["run10", "run9", "run1"], key=natural_key)
        ['run1', 'run9', 'run10']
    """
    parts = re.split(r"(\d+)", name)
    return tuple((1, int(part), "") if part.isdigit() else (0, 0, part) for part in parts)


def find_patterns(left: Leftover) -> list[Pattern]:
    """A change over the runs and a bend that the law lacks, where the residuals show them.

    Few curves show none.
    """
    # what an exact fit leaves over is rounding
    exact = _rms(left.residual) <= _ROUNDING * _rms(left.problem.mu)
    if exact or not left.can_show:
        return []
    found: list[Pattern] = []
    taken, least, searches = left.jacobian, 0.0, [_bend, _change]
    while best := _larger(*(search(left, taken) for search in searches)):
        pattern, explained, column = best
        # a change that is smaller than what the law lacks is most likely a part of that
        if explained >= least:
            found.append(pattern)
            least = explained
        searches.remove(_bend if pattern.when == "law" else _change)
        # where one bend is seen there are others
        every = [column for _, column in _bends(left)] if pattern.when == "law" else [column]
        taken = np.column_stack([taken, *every])
    return found


def _rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _larger(*found: _Found | None) -> _Found | None:
    known = [each for each in found if each is not None]
    return known[first_largest([each[1] for each in known])] if known else None


def _orthogonal(taken: FloatArray, columns: FloatArray) -> FloatArray:
    basis, _ = np.linalg.qr(taken)
    return np.asarray(columns - basis @ (basis.T @ columns))


def _surest(
    left: Leftover, candidates: list[tuple[Pattern, FloatArray]], taken: FloatArray
) -> _Found | None:
    """Of the patterns that are sure, the one that explains most; None where none is.

    Of patterns that explain the same it is the one of the fewest runs, and of these the first.

    Student's t of each coefficient by the residuals of whole curves, with the coefficient's own
    part taken out (cluster-robust), as many degrees of freedom as there are effective curves;
    Bonferroni's limit for all candidates together.

    Reference: A. V. Carter, K. T. Schnepel, D. G. Steigerwald, Rev. Econ. Stat. 99 (2017) 698.
    """
    columns = np.column_stack([column for _, column in candidates])
    rest, residual = _orthogonal(taken, columns), _orthogonal(taken, left.residual)
    power = np.sum(rest**2, axis=0)
    # what the constants take up shows nowhere
    shows = power > 1e-8 * np.sum(columns**2, axis=0)
    power = np.where(shows, power, 1.0)
    beta = rest.T @ residual / power
    errors = rest * (residual[:, np.newaxis] - rest * beta)
    scores = np.add.reduceat(errors, left.problem.starts, axis=0)
    count = len(scores)
    variance = np.sum(scores**2, axis=0) * count / (count - 1)
    t_value = beta * power / np.sqrt(np.maximum(variance, np.finfo(float).tiny))
    # curves that a pattern hardly touches say nothing of it
    of_curve = np.add.reduceat(rest**2, left.problem.starts, axis=0)
    squares = np.maximum(np.sum(of_curve**2, axis=0), np.finfo(float).tiny)
    effective = np.sum(of_curve, axis=0) ** 2 / squares
    degrees = np.maximum(effective - 2 - left.problem.followed.sum(), 1)
    p_value = len(candidates) * 2 * scipy.special.stdtr(degrees, -np.abs(t_value))
    explained = np.where(shows & (p_value < left.limits.false_alarms), beta**2 * power, 0.0)
    if not explained.max() > 0:
        return None
    # of causes that explain nearly the same, the first one
    nearly = reaches(explained, left.limits.nearly_share * explained.max())
    first = candidates[int(np.argmax(nearly))][0].what
    explained[[pattern.what != first for pattern, _ in candidates]] = 0.0
    # a group and all the other runs explain the same, as do a group and a step at its beginning
    equal = np.flatnonzero(reaches(explained, explained.max()))
    best = min(equal, key=lambda index: len(candidates[index][0].runs))
    pattern, column = candidates[best]
    return _sized(left, pattern, float(beta[best]), column), float(explained[best]), column


def _sized(left: Leftover, pattern: Pattern, size: float, column: FloatArray) -> Pattern:
    share = abs(size) * _rms(column) / _rms(left.problem.mu)
    return replace(pattern, size=size, mu_share=share)


def _bends(left: Leftover) -> list[tuple[Pattern, FloatArray]]:
    """What a law could lack: mu or the slip's scale bends over conditions; another shape over slip.

    The shape is looked for over the slip, and over S dmu/dS / mu, which is 1 where mu rises in
    proportion to the slip and 0 at its peak: curves may bend at different slips.
    """
    problem, every, mu = left.problem, tuple(left.problem.data.runs), left.fitted
    known = np.flatnonzero(problem.followed)
    scaled = problem.observations.design[:, 1:][:, known]
    scaled = (scaled - scaled.mean(axis=0)) / scaled.std(axis=0)
    bends = []
    # squares, products of two; cubes, which three levels do not tell from squares
    pairs = itertools.combinations_with_replacement(range(len(known)), 2)
    cubes = [
        (index,) * 3 for index, each in enumerate(scaled.T) if levels_by_gap(each, _GAP).max() > 2
    ]
    for powers in (*pairs, *cubes):
        names = [problem.law.groups[known[index]] for index in powers]
        product = scaled[:, list(powers)].prod(axis=1)[problem.observations.curve]
        bends += [(" ".join(dict.fromkeys(names)), each * product) for each in (mu, left.by_slip)]
    along = problem.observations.slip / problem.observations.slip.max()
    rise = np.clip(left.by_slip / np.where(mu > 0, mu, np.inf), -1, 1)
    for place, degrees in ((along, _SHAPES), (rise, _RISES)):
        shapes = (np.polynomial.Legendre.basis(degree)(2 * place - 1) for degree in degrees)
        bends += [("shape", mu * shape) for shape in shapes]
    return [(Pattern(what, "law", every), column) for what, column in bends]


def _changes(left: Leftover) -> Iterator[tuple[Pattern, FloatArray]]:
    """Every cause with every course over the runs: trend, step, groups."""
    runs = np.array(left.problem.data.runs)
    count = len(runs)
    courses: list[tuple[str, str, npt.NDArray[Any]]] = [
        ("trend", "", np.linspace(0, 1, count)),
        *(
            ("from", "", np.arange(count) >= step)
            for step in range(left.fewest, count - left.fewest + 1)
        ),
        *(("group", name, group) for name, group in left.groups.items() if left.is_group(group)),
    ]
    for cause, column in left.signatures.items():
        for when, group, course in courses:
            concerned = tuple(runs if when == "trend" else runs[course.astype(bool)])
            yield (
                Pattern(cause, when, concerned, group),
                column * course[left.problem.observations.curve],
            )


def _of_runs(left: Leftover, what: str, members: BoolArray, size: float) -> Pattern:
    """A pattern of some runs, with what they have in common and the others have not.

    Runs with the cause and runs without it are told apart, but not which are right: a known group
    is taken for the wrong ones, else those that come later.
    """
    other = 1 / size if what.endswith("factor") else -size
    runs = np.array(left.problem.data.runs)
    for name, group in left.groups.items():
        alike = float(np.mean(group == members))
        if left.is_group(group) and max(alike, 1 - alike) >= left.limits.same_group:
            return Pattern(what, "group", tuple(runs[group]), name, size if alike > 0.5 else other)
    if members[0]:
        members, size = ~members, other
    first = int(np.argmax(members))
    when = "from" if members[first:].all() else "some runs"
    return Pattern(what, when, tuple(runs[members]), "", size)


def _split(left: Leftover, taken: FloatArray) -> _Found | None:
    """Runs of two kinds, told apart by a cause alone; None where they are one kind.

    Fitted in turns from several beginnings: the constants and the size of the cause, then which
    runs have it. A temperature is looked for beside a gain of each curve's own as well.
    """
    count, starts, random = left.problem.curves, left.problem.starts, np.random.default_rng(0)
    searches = []
    for cause, column in left.signatures.items():
        columns = np.column_stack([taken, left.residual, column])
        sums = _SumsOfCurves.of(columns, starts)
        searches.append((cause, column, sums, sums))
        if cause == "inlet temperature":
            beside = _SumsOfCurves.of(left.beside_gain(columns), starts)
            searches.append((cause, column, sums, beside))
    best: _Found | None = None
    for cause, column, sums, seen in searches:
        beginnings = [seen.amount(np.zeros(count), 0.0), *random.random((_STARTS, count))]
        for beginning in beginnings:
            members, size, separation = seen.in_turns(beginning > np.median(beginning), left)
            if separation <= 1:
                continue
            marked = column * members[left.problem.observations.curve]
            if left.beside_bends(marked[:, np.newaxis])[0] <= left.limits.told_apart_min:
                continue
            pattern = _of_runs(left, cause, members, size)
            pattern = _sized(left, pattern, pattern.size, marked)
            best = _larger(best, (pattern, size**2 * sums.power_beside(members), marked))
    return best


@dataclass(frozen=True)
class _SumsOfCurves:
    """What finding the runs that have a cause needs of each curve.

    Attributes:
        power: Sum of the squared signature, shape (curves,).
        score: Sum of signature times residual, what is taken left out.
        shared: How much the constants take up of a cause in one curve and show in another, shape
            (curves, curves).
    """

    power: FloatArray
    score: FloatArray
    shared: FloatArray

    @classmethod
    def of(cls, columns: FloatArray, starts: IndexArray) -> "_SumsOfCurves":
        """Of columns: what is taken, then the residual, then the signature."""
        basis, _ = np.linalg.qr(columns[:, :-2])
        residual, signature = columns[:, -2:].T
        rest = residual - basis @ (basis.T @ residual)
        across = np.add.reduceat(basis * signature[:, np.newaxis], starts, axis=0)
        power, score = (np.add.reduceat(signature * each, starts) for each in (signature, rest))
        return cls(power, score, across @ across.T)

    def power_beside(self, members: BoolArray) -> float:
        """Squared length of the cause in these runs, beside what the constants take up."""
        return float(self.power[members].sum() - members @ self.shared @ members)

    def amount(self, members: FloatArray, size: float) -> FloatArray:
        """Amount of the cause in each curve, with constants fitted beside it in some."""
        # a curve in which the cause does not show has none of it
        shows = self.power > 0
        sums = self.score + size * self.shared @ members
        return np.divide(sums, self.power, out=np.zeros_like(sums), where=shows)

    def in_turns(self, members: BoolArray, left: Leftover) -> tuple[BoolArray, float, float]:
        """Which runs have the cause, its size, and their separation over the limit; 0 for none."""
        count, power, followed = len(members), self.power, int(left.problem.followed.sum())
        if count - 1 - followed < left.limits.degrees_min:
            return members, 0.0, 0.0
        for _ in range(_ROUNDS):
            beside = self.power_beside(members)
            if not left.is_group(members) or beside <= 1e-8 * power.sum():
                return members, 0.0, 0.0
            size = float(self.score[members].sum()) / beside
            amount = self.amount(members.astype(float), size)
            now = np.abs(amount - size) < np.abs(amount)
            if (now == members).all():
                break
            members = now
        if not left.is_group(members):
            return members, 0.0, 0.0
        # runs in which the cause shows more tell more
        middle = float(np.average(amount[members], weights=power[members]))
        errors = amount - np.where(members, middle, 0.0)
        effective = float(power.sum()) ** 2 / float(power @ power)
        # what is taken has made them smaller, above all where bends are taken as well
        free = 1 - np.trace(self.shared) / power.sum()
        squares = np.average(errors**2, weights=power) / max(free, np.finfo(float).tiny)
        scatter = np.sqrt(squares * count / (count - 2))
        limit = left.limits.separation + left.limits.separation_few / effective
        return members, size, float(abs(middle) / (limit * scatter))


def _bend(left: Leftover, taken: FloatArray) -> _Found | None:
    return _surest(left, _bends(left), taken)


def _change(left: Leftover, taken: FloatArray) -> _Found | None:
    misread = _misread(left) if taken is left.jacobian else None
    # runs are often made in the order of their conditions: what a bend may be is no change
    candidates = [*_changes(left)]
    alone = left.beside_bends(np.column_stack([column for _, column in candidates]))
    told_apart = alone > left.limits.told_apart_min
    told = [*itertools.compress(candidates, told_apart)]
    simple = _surest(left, told, taken) if told else None
    split = _split(left, taken)
    if simple and split and simple[1] >= left.limits.nearly_share * split[1]:
        split = None
    return _larger(simple, split, misread)


def _misread(left: Leftover) -> _Found | None:
    """Speed or slip of some runs read twice or half as large; None where nothing says so.

    Such an error is too large for a slope. The fit is repeated with the quantity put right in some
    runs, and each run is then given to the reading that it agrees with.
    """
    speed = left.problem.data.conditions[:, _SPEED]
    fast = speed > np.sqrt(speed.min() * speed.max())
    squares = _squares(left, left.problem, left.optimum)
    uneven = squares > np.median(squares)
    # runs of which the curve rises later than the law
    later = np.add.reduceat(left.signatures["slip"] * left.residual, left.problem.starts)
    late = later > np.median(later)
    best: _Found | None = None
    for what, factor in (("speed factor", 2.0), ("slip factor", 2.0), ("slip factor", 0.5)):
        groups = [group for group in left.groups.values() if left.is_group(group)]
        for start in (*groups, *([fast] if what == "speed factor" else [uneven, ~uneven, late])):
            members, sse, right = _read_right(left, what, factor, start)
            lower = sse < left.limits.misread_sse_max * left.optimum.sse
            if left.is_group(members) and lower:
                column = right - left.fitted
                pattern = _of_runs(left, what, members, factor)
                pattern = replace(_sized(left, pattern, 1.0, column), size=pattern.size)
                best = _larger(best, (pattern, left.optimum.sse - sse, column))
    return best


def _squares(left: Leftover, problem: Problem, end: Optimum) -> FloatArray:
    squares = problem.residual(end.values) ** 2
    return np.asarray(
        np.bincount(left.problem.observations.curve, squares, left.problem.curves), dtype=float
    )


def _with_factor(left: Leftover, what: str, factor: FloatArray) -> Problem:
    """The problem with a quantity divided by a factor per run."""
    data = left.problem.data
    if what == "speed factor":
        conditions = data.conditions.copy()
        conditions[:, _SPEED] /= factor
        data = replace(data, conditions=conditions)
    else:
        data = replace(data, slip=data.slip / factor[data.curve])
    made = build_problem(left.problem.law, data, left.problem.varied)
    return replace(left.problem, observations=made.observations)


def _read_right(
    left: Leftover, what: str, factor: float, members: BoolArray
) -> tuple[BoolArray, float, FloatArray]:
    """Runs that agree with a reading divided by a factor, the SSE then, and mu of the law."""
    end = left.optimum
    plain, divided = (
        _with_factor(left, what, np.full(len(members), each)) for each in (1.0, factor)
    )
    problem = plain
    for _ in range(_ROUNDS // 5):
        problem = _with_factor(left, what, np.where(members, factor, 1.0))
        (values,), (sse,) = descend(problem, end.values[np.newaxis], tolerance=_ROUGH)
        end = Optimum(values, float(sse))
        now = _squares(left, divided, end) < _squares(left, plain, end)
        if (now == members).all():
            break
        members = now
    return members, end.sse, problem.residual(end.values) + problem.mu
