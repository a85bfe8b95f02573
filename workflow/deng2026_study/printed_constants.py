"""Printed constants compared with a campaign's own fit, and the signs that the paper's text allows.

The signs of the exponents are lost in our copy of the paper. Nearly all of section 4.3 describes
figures that the authors drew from these constants. So the statements of the text can be checked
with every set of signs. The name of a statement is a column of the table `signs`, which gives its
meaning and its section of the paper. Arrays have the axes P, U, T, (S,) sign sets: all 512 sign
sets of an oil are scored at once. P is the maximum Hertz pressure in GPa, which the paper calls
stress, U the entrainment speed in m/s, T the inlet temperature in degC, S the slide-roll ratio.

The total of a sign set is the number of statements that hold. Each statement counts by the share of
its box where it holds. The margin of a sign is the best total of the sets that have it, less the
best total of the sets that have the other sign. The other eight signs may be any.

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

# The law whose constants are printed.
LAW = DENG2026


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
    for oil in oils:
        if oil not in printed or oil not in quality.index:
            continue
        points = results.points[results.points["oil"] == oil]
        row = {
            "oil": oil,
            "n_points": points["accepted"].sum(),
            "printed_sse": squared_error(points, printed[oil]),
            "fitted_sse": quality.at[oil, "sse"],
        }
        fitted = FittedLaw.from_tables(results.coefficients, oil, law=LAW).coefficients.constants
        for box_name, ends in settings.boxes.model_dump().items():
            row[f"{box_name}_difference"] = largest_difference(
                fitted, printed[oil], ends, settings.levels
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
    printed_mu, fitted_mu = np.moveaxis(Surface.over(box, levels, slip, internal).mu, -1, 0)
    difference = printed_mu - fitted_mu
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
    observations = Observations(LAW.design(data.conditions), data.curve_of_point, data.slip)
    fitted_mu = LAW.traction(to_internal(LAW, constants), observations)
    return float(np.sum((fitted_mu - data.mu) ** 2))


# Name of a statement -> share of its box where it holds, for each sign set.
Shares = dict[str, FloatArray]

# Indices of the constants that are exponents.
_EXPONENTS = [index for index, constant in enumerate(LAW.constants) if constant.condition]
# Signs of the exponents, one row per sign set.
_SIGN_SETS = np.array(list(itertools.product((1, -1), repeat=len(_EXPONENTS))))
# Slips at which statements are checked, as keys of `printed.signs.slide_roll_ratio` in the
# settings: those of a whole curve (Fig. 7), and those of Figs 8 and 9. Totals and ranks are those
# of the whole curve. The slips of the figures can only make a verdict less sure.
_SLIP_LEVELS = ("curve", "figures")
# Axes of arrays.
STRESS, SPEED, TEMPERATURE, SLIP = range(4)
# Statements that count half. The paper does not state the first one: it follows from the Newtonian
# oil and its falling viscosity that section 2.4 names. The others are two readings of one sentence.
HALF = (
    "start_falls_with_temperature",
    "earlier_plateau_with_speed",
    "earlier_plateau_with_temperature",
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
        levels_of_axes = [np.linspace(box[name][0], box[name][1], levels) for name in CONDITIONS]
        conditions = np.stack(np.meshgrid(*levels_of_axes, indexing="ij"), axis=-1).reshape(
            -1, len(levels_of_axes)
        )
        sizes = LAW.sizes(internal, LAW.design(conditions))
        shape = -1, levels, levels, levels, internal.shape[1]
        largest_slip = max(box["slide_roll_ratio"])
        return cls(levels_of_axes[STRESS], np.sort(slip), largest_slip, sizes.reshape(shape))

    @cached_property
    def mu(self) -> FloatArray:
        """Traction coefficient, axes P, U, T, S, sets."""
        return np.stack([self.mu_at(slip) for slip in self.slip], axis=SLIP)

    def mu_at(self, slip: FloatArray | float) -> FloatArray:
        """Traction coefficient at one slip, or at a slip of each condition; axes P, U, T, sets."""
        return LAW.mu_of_sizes(self.sizes, np.asarray(slip))

    @cached_property
    def peak_slip(self) -> FloatArray:
        """Slip of the one peak, where dmu/dS = 0: 1/C + |A|/B."""
        size, slope, rate = self.sizes
        return 1 / rate + size / slope

    @cached_property
    def peak(self) -> FloatArray:
        """Largest mu within the box's slips."""
        return self.mu_at(np.minimum(self.peak_slip, self.largest_slip))

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
    candidates = {oil: _all_sign_sets(constants) for oil, constants in printed.items()}
    scores = [_scores(candidates, levels, settings, traction_max) for levels in _SLIP_LEVELS]
    sign_sets = []
    verdicts = []
    for oil in printed:
        if oil not in oils:
            continue
        shares_by_slips = [shares_of_oil[oil] for shares_of_oil in scores]
        in_use = (np.sign(printed[oil][_EXPONENTS]) == _SIGN_SETS).all(axis=1)
        rows = _table_of_sign_sets(oil, in_use, shares_by_slips)
        sign_sets.append(rows.sort_values("total", ascending=False, kind="stable"))
        effects = _effects(candidates[oil][:, in_use], settings)
        verdicts.append(_verdicts(rows, shares_by_slips, effects, settings.signs))
    if not sign_sets:
        return tables.empty("signs"), tables.empty("sign_verdicts")
    return (
        tables.conform(pd.concat(sign_sets), "signs", "sign sets"),
        tables.conform(pd.concat(verdicts), "sign_verdicts", "signs"),
    )


def _all_sign_sets(constants: FloatArray) -> FloatArray:
    """Constants with every sign set, in the law's internal form, shape (constants, sets).

    Only exponents change their sign: A0, B0 and C0 keep it.
    """
    internal = np.tile(to_internal(LAW, constants)[:, np.newaxis], (1, len(_SIGN_SETS)))
    internal[_EXPONENTS] = np.abs(internal[_EXPONENTS]) * _SIGN_SETS.T
    return internal


def _table_of_sign_sets(
    oil: str, in_use: BoolArray, shares_by_slips: Sequence[Shares]
) -> pd.DataFrame:
    """One row per sign set of an oil: its total, its ranks, and the share of each statement.

    Args:
        oil: The oil.
        in_use: Whether a set has the signs in use, shape (sets,).
        shares_by_slips: Shares of the statements, for each of `_SLIP_LEVELS`.
    """
    totals = [pd.Series(_total(shares)) for shares in shares_by_slips]
    ranks = [total.rank(method="min", ascending=False).astype(int) for total in totals]
    texts = np.where(_SIGN_SETS > 0, "+", "-")
    rows = pd.DataFrame(
        {
            "oil": oil,
            "signs": ["".join(signs) for signs in texts],
            "in_use": in_use,
            "rank": ranks[0],
            "rank_at_figures": ranks[1],
            "total": totals[0],
        }
    )
    return rows.assign(**shares_by_slips[0])


def _scores(
    candidates: Mapping[str, FloatArray],
    slip_levels: str,
    settings: PrintedSettings,
    traction_max: float,
) -> dict[str, Shares]:
    """The shares of the statements for each oil.

    Args:
        candidates: Constants of every sign set of each oil, the most viscous oil first.
        slip_levels: One of `_SLIP_LEVELS`.
        settings: Boxes of conditions, slide-roll ratios and limits.
        traction_max: Largest believable mu.
    """
    scores: dict[str, Shares] = {}
    surfaces: dict[str, Surface] = {}
    best_surfaces: list[Surface] = []
    for oil, internal in candidates.items():
        tested_surface = _surface("tested", slip_levels, internal, settings)
        drawn_surface = _surface("extrapolated", slip_levels, internal, settings)
        surfaces[oil] = drawn_surface
        compared_slips = settings.signs.slide_roll_ratio.figures
        where_statements_hold = where_true(
            tested_surface, drawn_surface, compared_slips, traction_max, settings.signs
        )
        scores[oil] = {
            name: share(statement_holds) for name, statement_holds in where_statements_hold.items()
        }
        best = int(np.argmax(_total(scores[oil])))
        best_surface = _surface("extrapolated", slip_levels, internal[:, [best]], settings)
        best_surfaces.append(best_surface)
    # Oils are compared with the others as the others' own statements choose them. The signs in use
    # must not confirm each other.
    for index, (oil, surface) in enumerate(surfaces.items()):
        more_viscous = best_surfaces[:index]
        less_viscous = best_surfaces[index + 1 :]
        scores[oil]["viscosity_order"] = viscosity_order(surface, more_viscous, less_viscous)
        scores[oil]["hot_convergence"] = hot_convergence(surface, more_viscous + less_viscous)
    return scores


def _surface(
    box: str, slip_levels: str, internal: FloatArray, settings: PrintedSettings
) -> Surface:
    """The surface over a box of the settings, at one of `_SLIP_LEVELS`."""
    ends = settings.boxes.model_dump()[box]
    slips = settings.signs.slide_roll_ratio.model_dump()[slip_levels]
    return Surface.over(ends, settings.signs.levels, slips, internal)


def _total(shares: Shares, without: str = "") -> FloatArray:
    """Number of statements that hold for each sign set; those that cannot be judged do not count.

    Sets whose numbers differ only by rounding get the same number.

    Args:
        shares: Shares of the statements.
        without: A statement that is left out.
    """
    weighted = []
    for name, share_of_box in shares.items():
        if name != without:
            weight = 0.5 if name in HALF else 1.0
            weighted.append(weight * share_of_box)
    return evened(np.nansum(weighted, axis=0))


def _effects(constants_in_use: FloatArray, settings: PrintedSettings) -> FloatArray:
    """Largest change of mu over the tested box if one sign is turned, over the largest mu.

    Args:
        constants_in_use: Internal constants with the signs in use, shape (constants, 1).
        settings: The tested box and its levels.

    Returns:
        Shape (exponents,).
    """
    # first column: signs in use; one more column for each sign turned
    turned = np.tile(constants_in_use, (1, 1 + len(_EXPONENTS)))
    turned[_EXPONENTS, range(1, turned.shape[1])] *= -1
    surface = _surface("tested", _SLIP_LEVELS[0], turned, settings)
    mu_of_turns = surface.mu.reshape(-1, turned.shape[1])
    return np.abs(mu_of_turns[:, 1:] - mu_of_turns[:, :1]).max(axis=0) / mu_of_turns[:, 0].max()


def _verdicts(
    sign_sets: pd.DataFrame,
    shares_by_slips: Sequence[Shares],
    effects: FloatArray,
    limits: SignSettings,
) -> pd.DataFrame:
    """One row per sign in use of one oil.

    Args:
        sign_sets: Rows of the oil, as by `_table_of_sign_sets`.
        shares_by_slips: Shares of the statements, for each of `_SLIP_LEVELS`.
        effects: As by `_effects`.
        limits: The limits of the verdicts.
    """
    signs_in_use = _SIGN_SETS[sign_sets["in_use"]][0]
    # whether a set has the sign in use of an exponent, shape (exponents, sets)
    has_sign = (signs_in_use == _SIGN_SETS).T

    def margins(total: FloatArray) -> list[float]:
        return [
            total[has_sign_of_exponent].max() - total[~has_sign_of_exponent].max()
            for has_sign_of_exponent in has_sign
        ]

    margins_without_one = []
    for shares in shares_by_slips:
        for statement in shares:
            margins_without_one.append(margins(_total(shares, without=statement)))
    frame = pd.DataFrame(
        {
            "oil": sign_sets["oil"].iloc[0],
            "constant": [LAW.constants[index].name for index in _EXPONENTS],
            "sign": np.where(signs_in_use > 0, "+", "-"),
            "margin": margins(sign_sets["total"].to_numpy()),
            "weakest_margin": np.min(margins_without_one, axis=0),
            "effect": effects,
        }
    )
    return frame.assign(
        verdict=verdicts(frame["margin"], frame["weakest_margin"], frame["effect"], limits)
    )


def verdicts(
    margin: pd.Series, weakest_margin: pd.Series, effect: pd.Series, limits: SignSettings
) -> np.ndarray:
    """How sure the signs in use are.

    The verdict depends on the sets whose totals are within `near_best` statements of the best one:

    - Without effect: turning the sign alone moves mu by at most `no_effect_max` of its largest
      value.
    - Settled: all these sets have the sign, with any one statement left out and at either slips.
    - Probable: all of them have it with all statements, at the slips of the whole curve.
    - Against: all of them have the other sign.
    - Open: both signs occur among them.

    Args:
        margin: In statements (see the module).
        weakest_margin: The smallest margin with any one statement left out, at either slips.
        effect: Largest change of mu over its largest value.
        limits: The limits.
    """
    near_best = limits.near_best
    # the first condition that is met gives the verdict
    conditions = {
        "without effect": reaches(limits.no_effect_max, effect),
        "settled": reaches(weakest_margin, near_best),
        "probable": reaches(margin, near_best),
        "against": reaches(-near_best, margin),
    }
    return np.select(list(conditions.values()), list(conditions), "open")


def where_true(
    tested: Surface,
    drawn: Surface,
    compared_slips: Sequence[float],
    traction_max: float,
    limits: SignSettings,
) -> dict[str, BoolArray]:
    """Where each statement about one oil holds; the last axis is that of the sign sets.

    Args:
        tested: The box that was tested. Statements of section 2 are checked there.
        drawn: The box that the figures of section 4.3 draw. Statements of that section are checked
            there.
        compared_slips: Slips whose lowest and highest the text compares.
        traction_max: Largest believable mu.
        limits: What counts as linear and slight.
    """
    mu = drawn.mu
    low_slip_mu = drawn.mu_at(min(compared_slips))
    high_slip_mu = drawn.mu_at(max(compared_slips))
    # R2 of the straight line mu(P) is covariance^2/variances
    stress = drawn.stress - drawn.stress.mean()
    mu_deviation = mu - mu.mean(axis=STRESS, keepdims=True)
    covariance = np.tensordot(stress, mu_deviation, axes=1)
    variances = (stress**2).sum() * (mu_deviation**2).sum(axis=STRESS)
    is_linear = reaches(covariance**2, limits.linear_r2_min * variances)
    is_slight = reaches(tested.mu_at(tested.largest_slip), (1 - limits.decline_max) * tested.peak)
    # effects of stress and of temperature at the lowest speed and at the highest one
    stress_effect = (mu[-1] - mu[0])[[0, -1]]
    temperature_effect = (mu[:, :, 0] - mu[:, :, -1])[:, [0, -1]]
    slow_temperature_effect = temperature_effect[:, 0]
    fast_temperature_effect = np.abs(temperature_effect[:, 1])
    # largest mu of each sign set: differences have the rounding of these numbers
    largest_mu = np.abs(mu).max(axis=tuple(range(mu.ndim - 1)))
    return {
        "physical": reaches(mu.min(axis=SLIP), 0.0, drawn.peak) & reaches(traction_max, drawn.peak),
        "rises_with_stress": _falls(-mu, STRESS),
        "linear_in_stress": is_linear & (covariance > 0),
        "falls_with_speed": _falls(mu, SPEED),
        "levels_off_with_speed": _levels_off(mu, SPEED),
        "falls_with_temperature": _falls(mu, TEMPERATURE),
        "levels_off_with_temperature": _levels_off(mu, TEMPERATURE),
        "start_falls_with_temperature": _falls(tested.slope, TEMPERATURE),
        "rises_with_slip": exceeds(high_slip_mu, low_slip_mu),
        "declines_slightly": exceeds(tested.largest_slip, tested.peak_slip) & is_slight,
        "earlier_plateau_with_stress": _falls(drawn.knee, STRESS),
        "earlier_plateau_with_speed": _falls(tested.knee, SPEED),
        "earlier_plateau_with_temperature": _falls(tested.knee, TEMPERATURE),
        "slip_raises_stress_effect": exceeds(
            high_slip_mu[-1] - high_slip_mu[0], np.abs(low_slip_mu[-1] - low_slip_mu[0]), largest_mu
        ),
        "speed_mutes_stress_effect": exceeds(
            stress_effect[0], np.abs(stress_effect[1]), largest_mu
        ),
        "speed_mutes_temperature_effect": exceeds(
            slow_temperature_effect, fast_temperature_effect, largest_mu
        ),
    }


def viscosity_order(
    surface: Surface, more_viscous: Sequence[Surface], less_viscous: Sequence[Surface]
) -> FloatArray:
    """Mu is below that of the next more viscous oil, and above that of the next less viscous one.

    The other oils' surfaces are of one set each. NaN where there is no other oil.
    """
    where_statements_hold = []
    if more_viscous:
        where_statements_hold.append(exceeds(more_viscous[-1].mu, surface.mu))
    if less_viscous:
        where_statements_hold.append(exceeds(surface.mu, less_viscous[0].mu))
    return _mean_share(where_statements_hold, surface)


def hot_convergence(surface: Surface, others: Sequence[Surface]) -> FloatArray:
    """Mu is nearer to that of each other oil at the highest temperature than at the lowest."""
    is_nearer = []
    for other in others:
        gap = np.abs(surface.mu - other.mu)
        is_nearer.append(exceeds(gap[:, :, 0], gap[:, :, -1], other.mu.max()))
    return _mean_share(is_nearer, surface)


def share(where_it_holds: BoolArray) -> FloatArray:
    """Share of all conditions and slips where something holds, for each sign set."""
    return where_it_holds.reshape(-1, where_it_holds.shape[-1]).mean(axis=0)


def _mean_share(where_statements_hold: list[BoolArray], surface: Surface) -> FloatArray:
    """Mean of the shares where statements hold; NaN for each sign set without any statement."""
    if not where_statements_hold:
        return np.full(surface.mu.shape[-1], np.nan)
    return np.mean([share(holds) for holds in where_statements_hold], axis=0)


def _falls(values: FloatArray, axis: int) -> BoolArray:
    """Smaller at the next level of an axis."""
    levels = np.moveaxis(values, axis, 0)
    return np.moveaxis(exceeds(levels[:-1], levels[1:]), 0, axis)


def _levels_off(mu: FloatArray, axis: int) -> BoolArray:
    """Mu changes less over the last third of the levels than it falls over the first.

    Example: from 20 to 140 degC these thirds are 20-60 and 100-140 degC.
    """
    mu_of_level = np.moveaxis(mu, axis, 0)
    steps_of_third = (len(mu_of_level) - 1) // 3
    first_fall = mu_of_level[0] - mu_of_level[steps_of_third]
    last_change = np.abs(mu_of_level[-1 - steps_of_third] - mu_of_level[-1])
    return exceeds(first_fall, last_change, np.abs(mu_of_level).max(axis=0))
