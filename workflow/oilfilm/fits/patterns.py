"""Patterns in the residuals of a fit: runs that changed, and bends that the law lacks.

Each pattern is a column of possible errors: "from run 12 on the force reads higher", "mu bends over
the temperature". The part of it that the constants can take up is removed. The rest is compared
with the residuals, curve by curve, because the points of a run share its errors. The pattern that
explains most comes first. The other kind of pattern is searched in the remaining residuals, so
that a change of the rig is not called a bend of the law, nor a bend a change.

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

# The constants of the search; the limits of a pattern are in `patterns` of the configuration.
# Rounds of the search for two kinds of runs, and its random starts.
_MOST_ROUNDS = 25
_SPLIT_STARTS = 24
# The same for runs that are misread, and the relative decrease of the SSE at which a refit ends.
_MISREAD_ROUNDS = 5
_MISREAD_TOLERANCE = 1e-4
# Column of the entrainment speed among the conditions of every law.
_SPEED_COLUMN = 1
# Levels of a condition are further apart than this share of its range. Bends of the third order are
# searched where there are four levels.
_LEVEL_GAP = 0.05
# Degrees of the polynomials over the slip, and over S dmu/dS / mu.
_SLIP_DEGREES = (2, 3, 4, 5)
_RISE_DEGREES = (1, 2, 3, 4)
# Rms residual of an exact fit over the rms of mu.
_EXACT_RESIDUAL = 1e-7
# Share of a column's squared length below which the constants take up all of it.
_SHOWS = 1e-8
# Causes in the order in which they are preferred where they explain nearly the same.
_CAUSES = (
    "traction force",
    "load",
    "inlet temperature",
    "entrainment speed",
    "slip",
    "zero of the force",
)


@dataclass(frozen=True)
class Leftover:
    """A fit and its residuals, with the curves in the order in which the runs were made.

    Attributes:
        problem: What was fitted.
        optimum: Where it ended.
        groups: Which runs have something in common, by what it is, shape (curves,).
        others: mu of other oils at the points, by oil, shape (points,).
        limits: Limits of a pattern.
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
        """Change of (measured mu less the law) per unit of each cause, by cause, shape (points,).

        The unit of the load is a newton (an offset of the cell), that of the temperature a kelvin.
        Force, speed and slip have relative errors. Another oil has a share of the mixture.
        """
        data = self.problem.data
        internal = self.problem.expand(self.optimum.values)
        columns = dict(zip(EFFECTS, effects(self.problem.law, internal, data).T, strict=True))
        columns["load"] = columns["load"] / data.load_n[data.curve]
        columns["slip"] = -self.slip_slope
        signatures = {}
        for oil, mu in self.others.items():
            signatures[f"oil {oil}"] = mu - self.fitted
        for name in _CAUSES:
            if np.isfinite(columns[name]).all():
                signatures[name] = columns[name]
        return signatures

    @cached_property
    def slip_slope(self) -> FloatArray:
        """S dmu/dS at each point."""
        return self.problem.slip_slope(self.optimum.values)

    @property
    def fitted(self) -> FloatArray:
        """mu of the law at each point."""
        return self.problem.mu - self.residual

    @cached_property
    def _bend_basis(self) -> FloatArray:
        """Orthonormal basis of the constants and all bends, shape (points, n)."""
        bends = [column for _, column in _bends(self)]
        basis, _ = np.linalg.qr(np.column_stack([self.jacobian, *bends]))
        return basis

    def beside_bends(self, columns: FloatArray) -> FloatArray:
        """Share of each column that no bend takes up, of the part that the constants leave."""
        remaining = _orthogonal(self.jacobian, columns)
        in_bends = np.sum((self._bend_basis.T @ remaining) ** 2, axis=0)
        length = np.maximum(np.sum(remaining**2, axis=0), np.finfo(float).tiny)
        return np.asarray(1 - in_bends / length)

    def beside_gain(self, columns: FloatArray) -> FloatArray:
        """Each column without a gain of each curve, shape (points, n).

        The scatter of the force from run to run then hides no cause of another shape over slip.
        """
        starts = self.problem.starts
        mu = self.fitted[:, np.newaxis]
        gain = np.add.reduceat(columns * mu, starts, axis=0) / np.add.reduceat(mu**2, starts)
        return np.asarray(columns - mu * gain[self.problem.observations.curve])

    @property
    def can_show(self) -> bool:
        """Whether there are enough curves to show a pattern."""
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
    """One pattern: its cause and its course over the runs.

    Attributes:
        what: Code of the cause: one of `EFFECTS`, `slip`, `oil <name>`, `speed factor` or
            `slip factor` for a quantity that is read twice or half as large. Of a bend it is
            `shape`, or the conditions over which mu or the scale of the slip bends.
        when: `trend`, `from` a run on, `group`, `some runs`; `law` for a bend of the law.
        runs: The affected runs; all runs for a trend or a bend.
        group: What they have in common; empty where that is not known.
        size: In the unit of the cause, as in `Leftover.signatures`. For a trend it is the change
            over all runs, for a misread quantity the factor.
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
    """Sort key by which numbers in names are compared as numbers.

    Examples:
        >>> sorted(["run10", "run9", "run1"], key=natural_key)
        ['run1', 'run9', 'run10']
    """
    parts = re.split(r"(\d+)", name)
    return tuple((1, int(part), "") if part.isdigit() else (0, 0, part) for part in parts)


def find_patterns(left: Leftover) -> list[Pattern]:
    """A change over the runs and a bend that the law lacks, where the residuals show them.

    Returns:
        At most one pattern of each kind; none of too few curves.
    """
    # the residuals of an exact fit are rounding
    exact = _rms(left.residual) <= _EXACT_RESIDUAL * _rms(left.problem.mu)
    if exact or not left.can_show:
        return []
    patterns: list[Pattern] = []
    taken = left.jacobian
    least_explained = 0.0
    searches = [_bend, _change]
    while True:
        best = _larger(*[search(left, taken) for search in searches])
        if best is None:
            return patterns
        pattern, explained, column = best
        # a pattern that explains less than the first one is most likely a part of it
        if explained >= least_explained:
            patterns.append(pattern)
            least_explained = explained
        if pattern.when == "law":
            searches.remove(_bend)
            # where there is one bend there are others
            columns = [column for _, column in _bends(left)]
        else:
            searches.remove(_change)
            columns = [column]
        taken = np.column_stack([taken, *columns])


def _rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _larger(*candidates: _Found | None) -> _Found | None:
    """The pattern that explains most of the SSE; None where there is none."""
    patterns = [candidate for candidate in candidates if candidate is not None]
    if not patterns:
        return None
    return patterns[first_largest([explained for _, explained, _ in patterns])]


def _orthogonal(taken: FloatArray, columns: FloatArray) -> FloatArray:
    """Each column without the part that is a combination of the columns `taken`."""
    basis, _ = np.linalg.qr(taken)
    return np.asarray(columns - basis @ (basis.T @ columns))


def _surest(
    left: Leftover, candidates: list[tuple[Pattern, FloatArray]], taken: FloatArray
) -> _Found | None:
    """The significant pattern that explains most; None where no pattern is significant.

    Of patterns that explain the same it is the one of the fewest runs, and of these the first.

    The test is Student's t of each coefficient with a cluster-robust variance: from the residuals
    of whole curves, without the pattern's part. The degrees of freedom are those of the effective
    curves. Bonferroni's limit is for all candidates together.

    Reference: A. V. Carter, K. T. Schnepel, D. G. Steigerwald, Rev. Econ. Stat. 99 (2017) 698.
    """
    columns = np.column_stack([column for _, column in candidates])
    rest = _orthogonal(taken, columns)
    residual = _orthogonal(taken, left.residual)
    power = np.sum(rest**2, axis=0)
    # the residuals do not show a pattern that the constants take up
    shows = power > _SHOWS * np.sum(columns**2, axis=0)
    power = np.where(shows, power, 1.0)
    beta = rest.T @ residual / power
    errors = rest * (residual[:, np.newaxis] - rest * beta)
    scores = np.add.reduceat(errors, left.problem.starts, axis=0)
    count = len(scores)
    variance = np.sum(scores**2, axis=0) * count / (count - 1)
    t_value = beta * power / np.sqrt(np.maximum(variance, np.finfo(float).tiny))
    # curves in which a pattern is small give little information about it
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
    """The pattern with its size, and its share of mu.

    Args:
        left: The fit.
        pattern: The pattern.
        size: Factor of the column.
        column: Change of mu per unit of the size, shape (points,).
    """
    share = abs(size) * _rms(column) / _rms(left.problem.mu)
    return replace(pattern, size=size, mu_share=share)


def _bends(left: Leftover) -> list[tuple[Pattern, FloatArray]]:
    """Bends that a law may lack: mu or the slip's scale over conditions, or the shape over slip.

    The shape is searched over the slip, and over S dmu/dS / mu. The latter is 1 where mu rises in
    proportion to the slip and 0 at its peak, so that curves may bend at different slips.
    """
    problem = left.problem
    runs = tuple(problem.data.runs)
    mu = left.fitted
    followed = np.flatnonzero(problem.followed)
    logs = problem.observations.design[:, 1:][:, followed]
    scaled = (logs - logs.mean(axis=0)) / logs.std(axis=0)
    # squares and products of two; cubes, which three levels do not distinguish from squares
    pairs = itertools.combinations_with_replacement(range(len(followed)), 2)
    terms: list[tuple[int, ...]] = list(pairs)
    for index in range(len(followed)):
        if levels_by_gap(scaled[:, index], _LEVEL_GAP).max() > 2:
            terms.append((index, index, index))
    bends = []
    for term in terms:
        names = [problem.law.groups[followed[index]] for index in term]
        what = " ".join(dict.fromkeys(names))
        product = scaled[:, list(term)].prod(axis=1)[problem.observations.curve]
        bends.append((what, mu * product))
        bends.append((what, left.slip_slope * product))
    relative_slip = problem.observations.slip / problem.observations.slip.max()
    rise = np.clip(left.slip_slope / np.where(mu > 0, mu, np.inf), -1, 1)
    for variable, degrees in ((relative_slip, _SLIP_DEGREES), (rise, _RISE_DEGREES)):
        for degree in degrees:
            shape = np.polynomial.Legendre.basis(degree)(2 * variable - 1)
            bends.append(("shape", mu * shape))
    return [(Pattern(what, "law", runs), column) for what, column in bends]


def _changes(left: Leftover) -> Iterator[tuple[Pattern, FloatArray]]:
    """Every cause with every course over the runs: trend, step, groups."""
    runs = np.array(left.problem.data.runs)
    count = len(runs)
    courses: list[tuple[str, str, npt.NDArray[Any]]] = [("trend", "", np.linspace(0, 1, count))]
    for first in range(left.fewest, count - left.fewest + 1):
        courses.append(("from", "", np.arange(count) >= first))
    for name, members in left.groups.items():
        if left.is_group(members):
            courses.append(("group", name, members))
    curve = left.problem.observations.curve
    for cause, column in left.signatures.items():
        for when, group, course in courses:
            affected = runs if when == "trend" else runs[course.astype(bool)]
            yield Pattern(cause, when, tuple(affected), group), column * course[curve]


def _of_runs(left: Leftover, what: str, members: BoolArray, size: float) -> Pattern:
    """A pattern of some runs, with what these runs have in common.

    The residuals show which runs have the cause, but not which runs are right. A known group is
    called wrong, otherwise the later runs.
    """
    opposite_size = 1 / size if what.endswith("factor") else -size
    runs = np.array(left.problem.data.runs)
    for name, group in left.groups.items():
        alike = float(np.mean(group == members))
        if left.is_group(group) and max(alike, 1 - alike) >= left.limits.same_group:
            size_of_group = size if alike > 0.5 else opposite_size
            return Pattern(what, "group", tuple(runs[group]), name, size_of_group)
    if members[0]:
        members = ~members
        size = opposite_size
    first = int(np.argmax(members))
    when = "from" if members[first:].all() else "some runs"
    return Pattern(what, when, tuple(runs[members]), "", size)


def _split(left: Leftover, taken: FloatArray) -> _Found | None:
    """Runs of two kinds that differ by one cause; None where all runs are of one kind.

    Two steps alternate, from several starts: the constants and the size of the cause are fitted,
    then the runs that have the cause are found. A temperature is also searched beside a gain of
    each curve.
    """
    count = left.problem.curves
    starts = left.problem.starts
    random = np.random.default_rng(0)
    searches = []
    for cause, column in left.signatures.items():
        columns = np.column_stack([taken, left.residual, column])
        sums = _SumsOfCurves.from_columns(columns, starts)
        searches.append((cause, column, sums, sums))
        if cause == "inlet temperature":
            beside = _SumsOfCurves.from_columns(left.beside_gain(columns), starts)
            searches.append((cause, column, sums, beside))
    best: _Found | None = None
    for cause, column, sums, seen in searches:
        beginnings = [seen.amount(np.zeros(count), 0.0), *random.random((_SPLIT_STARTS, count))]
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
    """Sums over the points of each curve for the search of runs that have a cause.

    Attributes:
        power: Sum of the squared signature, shape (curves,).
        score: Sum of signature times residual, without the part that is taken, shape (curves,).
        shared: Effect of a cause in one curve on another curve through the constants, shape
            (curves, curves).
    """

    power: FloatArray
    score: FloatArray
    shared: FloatArray

    @classmethod
    def from_columns(cls, columns: FloatArray, starts: IndexArray) -> "_SumsOfCurves":
        """The sums from columns over points.

        Args:
            columns: What is taken, then the residual, then the signature, shape (points, n + 2).
            starts: First point of each curve.
        """
        basis, _ = np.linalg.qr(columns[:, :-2])
        residual = columns[:, -2]
        signature = columns[:, -1]
        rest = residual - basis @ (basis.T @ residual)
        projection = np.add.reduceat(basis * signature[:, np.newaxis], starts, axis=0)
        return cls(
            power=np.add.reduceat(signature * signature, starts),
            score=np.add.reduceat(signature * rest, starts),
            shared=projection @ projection.T,
        )

    def power_beside(self, members: BoolArray) -> float:
        """Squared length of the cause in these runs, without the part the constants take up."""
        return float(self.power[members].sum() - members @ self.shared @ members)

    def amount(self, members: FloatArray, size: float) -> FloatArray:
        """Amount of the cause in each curve, with constants fitted beside it in some."""
        # a curve in which the cause does not show has none of it
        shows = self.power > 0
        sums = self.score + size * self.shared @ members
        return np.divide(sums, self.power, out=np.zeros_like(sums), where=shows)

    def in_turns(self, members: BoolArray, left: Leftover) -> tuple[BoolArray, float, float]:
        """Which runs have the cause, its size, and their separation over the limit; 0 for none."""
        count = len(members)
        power = self.power
        followed = int(left.problem.followed.sum())
        if count - 1 - followed < left.limits.degrees_min:
            return members, 0.0, 0.0
        for _ in range(_MOST_ROUNDS):
            beside = self.power_beside(members)
            if not left.is_group(members) or beside <= _SHOWS * power.sum():
                return members, 0.0, 0.0
            size = float(self.score[members].sum()) / beside
            amount = self.amount(members.astype(float), size)
            now = np.abs(amount - size) < np.abs(amount)
            if (now == members).all():
                break
            members = now
        if not left.is_group(members):
            return members, 0.0, 0.0
        # runs in which the cause is larger give more information
        middle = float(np.average(amount[members], weights=power[members]))
        errors = amount - np.where(members, middle, 0.0)
        effective = float(power.sum()) ** 2 / float(power @ power)
        # the errors are too small by what is taken, above all where bends are taken as well
        free = 1 - np.trace(self.shared) / power.sum()
        squares = np.average(errors**2, weights=power) / max(free, np.finfo(float).tiny)
        scatter = np.sqrt(squares * count / (count - 2))
        limit = left.limits.separation + left.limits.separation_few / effective
        return members, size, float(abs(middle) / (limit * scatter))


def _bend(left: Leftover, taken: FloatArray) -> _Found | None:
    """The bend that explains most of the residuals; None where no bend is significant."""
    return _surest(left, _bends(left), taken)


def _change(left: Leftover, taken: FloatArray) -> _Found | None:
    """The change over the runs that explains most of the residuals; None where there is none."""
    misread = _misread(left) if taken is left.jacobian else None
    # runs are often made in the order of their conditions: a possible bend is no change
    candidates = list(_changes(left))
    share_beside_bends = left.beside_bends(np.column_stack([column for _, column in candidates]))
    is_no_bend = share_beside_bends > left.limits.told_apart_min
    changes = list(itertools.compress(candidates, is_no_bend))
    simple = _surest(left, changes, taken) if changes else None
    split = _split(left, taken)
    if simple is not None and split is not None:
        _, simple_explained, _ = simple
        _, split_explained, _ = split
        if simple_explained >= left.limits.nearly_share * split_explained:
            split = None
    return _larger(simple, split, misread)


def _misread(left: Leftover) -> _Found | None:
    """Speed or slip of some runs read twice or half as large; None where no run is misread.

    Such an error is too large for a linear model. The fit is repeated with the quantity corrected
    in some runs, and each run then belongs to the reading with which it agrees.
    """
    speed = left.problem.data.conditions[:, _SPEED_COLUMN]
    fast = speed > np.sqrt(speed.min() * speed.max())
    squares = _squares(left, left.problem, left.optimum)
    uneven = squares > np.median(squares)
    # runs whose curve rises at larger slip than the law
    later = np.add.reduceat(left.signatures["slip"] * left.residual, left.problem.starts)
    late = later > np.median(later)
    groups = [group for group in left.groups.values() if left.is_group(group)]
    starts = {"speed factor": [*groups, fast], "slip factor": [*groups, uneven, ~uneven, late]}
    best: _Found | None = None
    for what, factor in (("speed factor", 2.0), ("slip factor", 2.0), ("slip factor", 0.5)):
        for start in starts[what]:
            members, sse, corrected_mu = _read_right(left, what, factor, start)
            is_better = sse < left.limits.misread_sse_max * left.optimum.sse
            if left.is_group(members) and is_better:
                column = corrected_mu - left.fitted
                pattern = _of_runs(left, what, members, factor)
                pattern = replace(_sized(left, pattern, 1.0, column), size=pattern.size)
                best = _larger(best, (pattern, left.optimum.sse - sse, column))
    return best


def _squares(left: Leftover, problem: Problem, end: Optimum) -> FloatArray:
    """Sum of squared residuals of each curve, shape (curves,)."""
    squares = problem.residual(end.values) ** 2
    return np.asarray(
        np.bincount(left.problem.observations.curve, squares, left.problem.curves), dtype=float
    )


def _with_factor(left: Leftover, what: str, factor: FloatArray) -> Problem:
    """The problem with a quantity divided by a factor per run."""
    data = left.problem.data
    if what == "speed factor":
        conditions = data.conditions.copy()
        conditions[:, _SPEED_COLUMN] /= factor
        data = replace(data, conditions=conditions)
    else:
        data = replace(data, slip=data.slip / factor[data.curve])
    corrected = build_problem(left.problem.law, data, left.problem.varied)
    return replace(left.problem, observations=corrected.observations)


def _read_right(
    left: Leftover, what: str, factor: float, members: BoolArray
) -> tuple[BoolArray, float, FloatArray]:
    """Runs that agree with a reading divided by a factor, the SSE then, and mu of the law."""
    end = left.optimum
    plain = _with_factor(left, what, np.full(len(members), 1.0))
    divided = _with_factor(left, what, np.full(len(members), factor))
    problem = plain
    for _ in range(_MISREAD_ROUNDS):
        problem = _with_factor(left, what, np.where(members, factor, 1.0))
        ends, sse = descend(problem, end.values[np.newaxis], tolerance=_MISREAD_TOLERANCE)
        end = Optimum(ends[0], float(sse[0]))
        now = _squares(left, divided, end) < _squares(left, plain, end)
        if (now == members).all():
            break
        members = now
    return members, end.sse, problem.residual(end.values) + problem.mu
