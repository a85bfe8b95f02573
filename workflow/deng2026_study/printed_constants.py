"""The printed constants, judged: beside a campaign's own fit, and all signs by the paper's text.

The signs of the exponents were lost. Nearly all of section 4.3 describes figures that the authors
drew from these very constants. A statement's name is a column of the table `signs`, which has its
meaning and its section of the paper. Arrays have the axes P, U, T, (S,) sign sets, so that all 512
sign sets of an oil are scored at once.

A set's total is the number of statements that hold, each counted by the share of its box where it
does. A sign is judged by its margin: the best total among the sets that have it, less the best
among those that have the other one, whatever the other eight signs are.

Decides: how printed and fitted constants are compared, and which signs they may have.
"""

import itertools
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pandas as pd

from deng2026_study.settings import PrintedSettings, SignSettings
from oilfilm import tables
from oilfilm.base.ties import evened, exceeds, first_largest, reaches
from oilfilm.base.units import BoolArray, FloatArray
from oilfilm.fits.fitted import FittedLaw
from oilfilm.fits.problem import curve_data
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.traction.law import CONDITIONS, Observations, to_internal
from oilfilm.traction.laws.deng2026 import DENG2026

LAW = DENG2026  # its constants are printed


def judge_printed(
    results: CampaignTables,
    printed: Mapping[str, FloatArray],
    oils: Iterable[str],
    settings: PrintedSettings,
) -> pd.DataFrame:
    """One row per oil that has printed constants and a fit of the paper's law.

    Args:
        results: Tables of points, coefficients and fit quality, of one law per oil.
        printed: The twelve printed constants of each oil.
        oils: The campaign's oils.
        settings: Boxes of conditions and levels of the grid.

    Returns:
        The table `printed_judged`. All judgements are null where no point was accepted; the
        differences are where the conditions cannot give all twelve constants.
    """
    quality = results.fit_quality[results.fit_quality["law"] == LAW.name].set_index("oil")
    rows = []
    for oil in [oil for oil in oils if oil in printed and oil in quality.index]:
        points = results.points[results.points["oil"] == oil]
        row = {
            "oil": oil,
            "n_points": points["accepted"].sum(),
            "printed_sse": squared_error(points, printed[oil]),
            "fitted_sse": quality.at[oil, "sse"],
        }
        fitted = FittedLaw.of(results.coefficients, oil, law=LAW).coefficients.constants
        for box, levels in settings.boxes.model_dump().items():
            row[f"{box}_difference"] = largest_difference(
                fitted, printed[oil], levels, settings.levels
            )
        rows.append(row)
    return tables.from_rows(rows, "printed_judged")


def largest_difference(
    fitted: FloatArray, printed: FloatArray, box: Mapping[str, Sequence[float]], levels: int
) -> float:
    """printed - fitted mu where they differ most in a box, on a grid of evenly spaced levels.

    Args:
        fitted: A0..A3, B0..B3, C0..C3; any NaN makes the answer NaN.
        printed: The same, as printed.
        box: Lowest and highest value of each condition and of `slide_roll_ratio`.
        levels: How many of each.
    """
    lowest, highest = box["slide_roll_ratio"]
    slip = np.linspace(lowest, highest, levels)
    internal = to_internal(LAW, np.array([printed, fitted])).T
    by_print, by_fit = np.moveaxis(Surface.over(box, levels, slip, internal).mu, -1, 0)
    difference = by_print - by_fit
    return float(difference.flat[first_largest(np.abs(difference).ravel())])


def squared_error(points: pd.DataFrame, constants: FloatArray) -> float:
    """Eq. 10 of constants on the accepted points of one oil, as the fit takes them.

    Args:
        points: The oil's rows of the table of points.
        constants: A0..A3, B0..B3, C0..C3.

    Returns:
        Sum of squared errors; NaN where no point was accepted, or where a condition is unknown or
        not above zero.
    """
    data = curve_data(points)
    if len(data.mu) == 0 or not np.all(data.conditions > 0):
        return np.nan
    at = Observations(LAW.design(data.conditions), data.curve, data.slip)
    return float(np.sum((LAW.traction(to_internal(LAW, constants), at) - data.mu) ** 2))


Shares = dict[str, FloatArray]  # of its box where a statement holds, for each sign set

_EXPONENTS = [index for index, constant in enumerate(LAW.constants) if constant.condition]
_SETS = np.array(list(itertools.product((1, -1), repeat=len(_EXPONENTS))))  # one row per set
# The slips whose totals count come first; the others may only lower a verdict.
_SLIPS = ("curve", "figures")
STRESS, SPEED, TEMPERATURE, SLIP = range(4)  # axes
# Statements that count half: the slope at zero slip, where the oil is Newtonian, follows only by
# the physics that a sentence names, and two are readings of one sentence.
HALF = (
    "start_falls_with_temperature",
    *("earlier_plateau_with_speed", "earlier_plateau_with_temperature"),
)


@dataclass(frozen=True)
class Surface:
    """Eqs 7-9 over a box of conditions, for many sets of constants.

    Attributes:
        stress: Levels of P, in GPa.
        slip: Levels of S.
        largest_slip: The box's largest S.
        sizes: |A|, B and C of Eq. 7, axes coefficient, P, U, T, sets.
    """

    stress: FloatArray
    slip: FloatArray
    largest_slip: float
    sizes: FloatArray

    @classmethod
    def over(
        cls,
        box: Mapping[str, Sequence[float]],
        levels: int,
        slip: Sequence[float] | FloatArray,
        internal: FloatArray,
    ) -> "Surface":
        """The surface over a box.

        Args:
            box: Lowest and highest value of each condition and of `slide_roll_ratio`.
            levels: Evenly spaced levels of each condition.
            slip: Levels of the slide-roll ratio.
            internal: Constants in the law's internal form, shape (constants, sets).
        """
        axes = [np.linspace(box[name][0], box[name][1], levels) for name in CONDITIONS]
        conditions = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(axes))
        sizes = LAW.sizes(internal, LAW.design(conditions))
        shape = -1, levels, levels, levels, internal.shape[1]
        largest = max(box["slide_roll_ratio"])
        return cls(axes[STRESS], np.sort(slip), largest, sizes.reshape(shape))

    @cached_property
    def mu(self) -> FloatArray:
        """Traction coefficient, axes P, U, T, S, sets."""
        return np.stack([self.at(slip) for slip in self.slip], axis=SLIP)

    def at(self, slip: FloatArray | float) -> FloatArray:
        """Traction coefficient at one slip, or at a slip of each condition; axes P, U, T, sets."""
        return LAW.value(self.sizes, np.asarray(slip))

    @cached_property
    def peak_slip(self) -> FloatArray:
        """Slip of the one peak, where dmu/dS = 0: 1/C + |A|/B."""
        size, slope, rate = self.sizes
        return 1 / rate + size / slope

    @cached_property
    def peak(self) -> FloatArray:
        """Largest mu within the box's slips."""
        return self.at(np.minimum(self.peak_slip, self.largest_slip))

    @property
    def slope(self) -> FloatArray:
        """Slope of the curve at zero slip: B + |A| C."""
        size, slope, rate = self.sizes
        return slope + size * rate

    @cached_property
    def knee(self) -> FloatArray:
        """Slip at which the straight start would reach the peak: the end of the linear range."""
        return self.peak / self.slope


def study_signs(
    printed: Mapping[str, FloatArray],
    oils: Collection[str],
    settings: PrintedSettings,
    traction_max: float,
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Score every sign set of every oil, and judge every sign in use.

    Args:
        printed: The twelve constants of each oil, with the signs in use, the most viscous first.
        oils: The oils whose rows are given.
        settings: Boxes of conditions, slide-roll ratios and limits.
        traction_max: Largest believable mu.

    Returns:
        The tables `signs` and `sign_verdicts`.
    """
    # internal constants of every sign set, shape (constants, sets); A0, B0, C0 keep their sign
    candidates = {}
    for oil, constants in printed.items():
        internal = np.tile(to_internal(LAW, constants)[:, np.newaxis], (1, len(_SETS)))
        internal[_EXPONENTS] = np.abs(internal[_EXPONENTS]) * _SETS.T
        candidates[oil] = internal
    scores = [_scores(candidates, slips, settings, traction_max) for slips in _SLIPS]
    sets, verdicts = [], []
    for oil in [oil for oil in printed if oil in oils]:
        of_oil, internal = [each[oil] for each in scores], candidates[oil]
        totals = [pd.Series(_total(shares)) for shares in of_oil]
        ranks = [total.rank(method="min", ascending=False).astype(int) for total in totals]
        in_use = (np.sign(printed[oil][_EXPONENTS]) == _SETS).all(axis=1)
        rows = pd.DataFrame(
            {
                "oil": oil,
                "signs": ["".join("+" if sign > 0 else "-" for sign in signs) for signs in _SETS],
                "in_use": in_use,
                "rank": ranks[0],
                "rank_at_figures": ranks[1],
                "total": totals[0],
                **of_oil[0],
            }
        )
        sets.append(rows.sort_values("total", ascending=False, kind="stable"))
        effects = _effects(internal[:, in_use], settings)
        verdicts.append(_verdicts(rows, of_oil, effects, settings.signs))
    if not sets:
        return tables.empty("signs"), tables.empty("sign_verdicts")
    return (
        tables.conform(pd.concat(sets), "signs", "sign sets"),
        tables.conform(pd.concat(verdicts), "sign_verdicts", "signs"),
    )


def _scores(
    candidates: Mapping[str, FloatArray], slips: str, settings: PrintedSettings, traction_max: float
) -> dict[str, Shares]:
    """The statements' shares of each oil."""
    scores, surfaces, best = {}, {}, {}
    for oil, internal in candidates.items():
        tested = _surface("tested", slips, internal, settings)
        surfaces[oil] = drawn = _surface("extrapolated", slips, internal, settings)
        compared = settings.signs.slide_roll_ratio.figures
        holds = where_true(tested, drawn, compared, traction_max, settings.signs)
        scores[oil] = {name: share(each) for name, each in holds.items()}
        winner = int(np.argmax(_total(scores[oil])))
        best[oil] = _surface("extrapolated", slips, internal[:, [winner]], settings)
    # the others as their own statements choose them: the signs in use must not vouch for each other
    others = list(best.values())
    for index, (oil, surface) in enumerate(surfaces.items()):
        before, after = others[:index], others[index + 1 :]
        scores[oil]["viscosity_order"] = viscosity_order(surface, before, after)
        scores[oil]["hot_convergence"] = hot_convergence(surface, before + after)
    return scores


def _surface(box: str, slips: str, internal: FloatArray, settings: PrintedSettings) -> Surface:
    levels, slip = settings.boxes.model_dump()[box], settings.signs.slide_roll_ratio.model_dump()
    return Surface.over(levels, settings.signs.levels, slip[slips], internal)


def _total(shares: Shares, without: str = "") -> FloatArray:
    """Number of statements that hold, those that cannot be asked not counted.

    Sets of which the numbers are equal but for rounding have the same one.
    """
    weighted = [
        (0.5 if name in HALF else 1.0) * share for name, share in shares.items() if name != without
    ]
    return evened(np.nansum(weighted, axis=0))


def _effects(in_use: FloatArray, settings: PrintedSettings) -> FloatArray:
    """Largest change of mu over the tested box if one sign is turned, over the largest mu."""
    turned = np.tile(in_use, (1, 1 + len(_EXPONENTS)))
    turned[_EXPONENTS, range(1, turned.shape[1])] *= -1
    mu = _surface("tested", _SLIPS[0], turned, settings).mu.reshape(-1, turned.shape[1])
    return np.abs(mu[:, 1:] - mu[:, :1]).max(axis=0) / mu[:, 0].max()


def _verdicts(
    sets: pd.DataFrame, by_slips: list[Shares], effects: FloatArray, limits: SignSettings
) -> pd.DataFrame:
    """One row per sign in use of one oil."""
    signs = _SETS[sets["in_use"]][0]
    has = (signs == _SETS).T

    def margins(total: FloatArray) -> list[float]:
        return [total[own].max() - total[~own].max() for own in has]

    without = [margins(_total(shares, without=name)) for shares in by_slips for name in shares]
    frame = pd.DataFrame(
        {
            "oil": sets["oil"].iloc[0],
            "constant": [LAW.constants[index].name for index in _EXPONENTS],
            "sign": np.where(signs > 0, "+", "-"),
            "margin": margins(sets["total"].to_numpy()),
            "weakest_margin": np.min(without, axis=0),
            "effect": effects,
        }
    )
    return frame.assign(
        verdict=verdicts(frame["margin"], frame["weakest_margin"], frame["effect"], limits)
    )


def verdicts(
    margin: pd.Series, weakest: pd.Series, effect: pd.Series, limits: SignSettings
) -> np.ndarray:
    """How sure the signs in use are.

    Without effect: turning it alone moves mu by `no_effect_max` of its largest value at most.
    Settled: all sets within `near_best` statements of the best have the sign, whichever one
    statement is left out and at either slips. Probable: all of them have it at the slips of the
    whole curve, with every statement.
    Against: all of them have the other one. Open: both signs are among them.

    Args:
        margin: In statements (see the module).
        weakest: The smallest margin with any one statement left out, at either slips.
        effect: Largest change of mu over its largest value.
        limits: The limits.
    """
    near, none = limits.near_best, reaches(limits.no_effect_max, effect)
    found = [none, reaches(weakest, near), reaches(margin, near), reaches(-near, margin)]
    return np.select(found, ["without effect", "settled", "probable", "against"], "open")


def where_true(
    tested: Surface,
    drawn: Surface,
    compared: Sequence[float],
    traction_max: float,
    limits: SignSettings,
) -> dict[str, BoolArray]:
    """Where each statement about one oil holds, for each sign set: the last axis.

    Args:
        tested: The box that was tested (section 2).
        drawn: The box that the figures of section 4.3 draw.
        compared: Slips whose lowest and highest the text compares.
        traction_max: Largest believable mu.
        limits: What counts as linear and slight.
    """
    mu = drawn.mu
    low, high = drawn.at(min(compared)), drawn.at(max(compared))
    # R2 of the straight line mu(P) is covariance^2/variances
    stress, off = drawn.stress - drawn.stress.mean(), mu - mu.mean(axis=STRESS, keepdims=True)
    covariance = np.tensordot(stress, off, axes=1)
    variances = (stress**2).sum() * (off**2).sum(axis=STRESS)
    linear = reaches(covariance**2, limits.linear_r2_min * variances)
    slight = reaches(tested.at(tested.largest_slip), (1 - limits.decline_max) * tested.peak)
    # change by stress and by temperature at the lowest speed and at the highest one
    of_stress, of_heat = (mu[-1] - mu[0])[[0, -1]], (mu[:, :, 0] - mu[:, :, -1])[:, [0, -1]]
    # of each sign set: differences have the rounding of these numbers
    largest = np.abs(mu).max(axis=tuple(range(mu.ndim - 1)))
    return {
        "physical": reaches(mu.min(axis=SLIP), 0.0, drawn.peak) & reaches(traction_max, drawn.peak),
        "rises_with_stress": _falls(-mu, STRESS),
        "linear_in_stress": linear & (covariance > 0),
        "falls_with_speed": _falls(mu, SPEED),
        "levels_off_with_speed": _levels_off(mu, SPEED),
        "falls_with_temperature": _falls(mu, TEMPERATURE),
        "levels_off_with_temperature": _levels_off(mu, TEMPERATURE),
        "start_falls_with_temperature": _falls(tested.slope, TEMPERATURE),
        "rises_with_slip": exceeds(high, low),
        "declines_slightly": exceeds(tested.largest_slip, tested.peak_slip) & slight,
        "earlier_plateau_with_stress": _falls(drawn.knee, STRESS),
        "earlier_plateau_with_speed": _falls(tested.knee, SPEED),
        "earlier_plateau_with_temperature": _falls(tested.knee, TEMPERATURE),
        "slip_raises_stress_effect": exceeds(high[-1] - high[0], np.abs(low[-1] - low[0]), largest),
        "speed_mutes_stress_effect": exceeds(of_stress[0], np.abs(of_stress[1]), largest),
        "speed_mutes_temperature_effect": exceeds(of_heat[:, 0], np.abs(of_heat[:, 1]), largest),
    }


def viscosity_order(
    surface: Surface, more_viscous: Sequence[Surface], less_viscous: Sequence[Surface]
) -> FloatArray:
    """Mu is below that of the next more viscous oil, and above that of the next less viscous one.

    The other oils' surfaces are of one set each. NaN where there is no other oil.
    """
    holds = [exceeds(other.mu, surface.mu) for other in more_viscous[-1:]]
    holds += [exceeds(surface.mu, other.mu) for other in less_viscous[:1]]
    return _mean(holds, surface)


def hot_convergence(surface: Surface, others: Sequence[Surface]) -> FloatArray:
    """Mu is nearer to that of each other oil at the highest temperature than at the lowest."""
    apart = [np.abs(surface.mu - other.mu) for other in others]
    sizes = [other.mu.max() for other in others]
    nearer = [
        exceeds(gap[:, :, 0], gap[:, :, -1], size) for gap, size in zip(apart, sizes, strict=True)
    ]
    return _mean(nearer, surface)


def share(holds: BoolArray) -> FloatArray:
    """Share of all conditions and slips where something holds, for each sign set."""
    return holds.reshape(-1, holds.shape[-1]).mean(axis=0)


def _mean(holds: list[BoolArray], surface: Surface) -> FloatArray:
    nothing = np.full(surface.mu.shape[-1], np.nan)
    return np.mean([share(each) for each in holds], axis=0) if holds else nothing


def _falls(values: FloatArray, axis: int) -> BoolArray:
    """Smaller at the next level of an axis."""
    levels = np.moveaxis(values, axis, 0)
    return np.moveaxis(exceeds(levels[:-1], levels[1:]), 0, axis)


def _levels_off(mu: FloatArray, axis: int) -> BoolArray:
    """Mu changes less over the last third of the levels than it falls over the first.

    Of 20 to 140 degC the thirds are 20-60 and 100-140.
    """
    level = np.moveaxis(mu, axis, 0)
    third = (len(level) - 1) // 3
    first, last = level[0] - level[third], np.abs(level[-1 - third] - level[-1])
    return exceeds(first, last, np.abs(level).max(axis=0))
