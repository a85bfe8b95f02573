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
    printed_constants_of_oil: Mapping[str, FloatArray],
    oil_names: Iterable[str],
    settings: PrintedSettings,
) -> pd.DataFrame:
    """One row per oil that has printed constants and a fit of the paper's law.

    Args:
        results: Tables of points, coefficients and fit quality, of one law per oil.
        printed_constants_of_oil: The twelve printed constants of each oil.
        oil_names: The campaign's oils.
        settings: Boxes of conditions and levels of the grid.

    Returns:
        The table `printed_judged`. All judgements are null where no point was accepted; the
        differences are where the conditions cannot give all twelve constants.
    """
    quality = results.fit_quality[results.fit_quality["law"] == LAW.name].set_index("oil")
    judged_rows = []
    for oil in oil_names:
        if oil not in printed_constants_of_oil or oil not in quality.index:
            continue
        points = results.points[results.points["oil"] == oil]
        judged_columns = {
            "oil": oil,
            "n_points": points["accepted"].sum(),
            "printed_sse": squared_error(points, printed_constants_of_oil[oil]),
            "fitted_sse": quality.at[oil, "sse"],
        }
        fitted_constants = FittedLaw.from_tables(
            results.coefficients, oil, law=LAW
        ).coefficients.constants
        for box_name, ends in settings.boxes.model_dump().items():
            judged_columns[f"{box_name}_difference"] = largest_difference(
                fitted_constants, printed_constants_of_oil[oil], ends, settings.levels
            )
        judged_rows.append(judged_columns)
    return tables.from_rows(judged_rows, "printed_judged")


def largest_difference(
    fitted_constants: FloatArray,
    printed_constants: FloatArray,
    box: Mapping[str, Sequence[float]],
    level_count: int,
) -> float:
    """printed - fitted mu where they differ most in a box, on a grid of evenly spaced levels.

    Args:
        fitted_constants: A0..A3, B0..B3, C0..C3; any NaN makes the answer NaN.
        printed_constants: The same, as printed.
        box: Lowest and highest value of each condition and of `slide_roll_ratio`.
        level_count: Number of levels of each condition and of slip.
    """
    lowest, highest = box["slide_roll_ratio"]
    slip = np.linspace(lowest, highest, level_count)
    internal = to_internal(LAW, np.array([printed_constants, fitted_constants])).T
    printed_mu, fitted_mu = np.moveaxis(
        TractionOverBox.over(box, level_count, slip, internal).mu, -1, 0
    )
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
    curves = curve_data(points)
    if len(curves.mu) == 0 or not np.all(curves.conditions > 0):
        return np.nan
    observations = Observations(LAW.design(curves.conditions), curves.curve, curves.slip)
    fitted_mu = LAW.traction(to_internal(LAW, constants), observations)
    return float(np.sum((fitted_mu - curves.mu) ** 2))


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
# Indices of the axes of arrays.
STRESS_AXIS, SPEED_AXIS, TEMPERATURE_AXIS, SLIP_AXIS = range(4)
# Names of the statements that count half. The paper does not state the first one: it follows from
# the Newtonian oil and its falling viscosity that section 2.4 names. The others are two readings of
# one sentence.
HALF_STATEMENTS = (
    "start_falls_with_temperature",
    "earlier_plateau_with_speed",
    "earlier_plateau_with_temperature",
)


@dataclass(frozen=True)
class TractionOverBox:
    """Traction coefficient by Eqs 7-9 over a box of conditions, for many sets of constants.

    Attributes:
        stress_gpa: Levels of P, in GPa.
        slip: Levels of S.
        largest_slip: The box's largest S.
        sizes: |A|, B and C of Eq. 7, axes coefficient, P, U, T, sets.
    """

    stress_gpa: FloatArray
    slip: FloatArray
    largest_slip: float
    sizes: FloatArray

    @classmethod
    def over(
        cls,
        box: Mapping[str, Sequence[float]],
        level_count: int,
        slip: Sequence[float] | FloatArray,
        internal: FloatArray,
    ) -> "TractionOverBox":
        """The surface over a box.

        Args:
            box: Lowest and highest value of each condition and of `slide_roll_ratio`.
            level_count: Evenly spaced levels of each condition.
            slip: Levels of the slide-roll ratio.
            internal: Constants in the law's internal form, shape (constants, sets).
        """
        levels_of_axes = [
            np.linspace(box[name][0], box[name][1], level_count) for name in CONDITIONS
        ]
        conditions = np.stack(np.meshgrid(*levels_of_axes, indexing="ij"), axis=-1).reshape(
            -1, len(levels_of_axes)
        )
        sizes = LAW.sizes(internal, LAW.design(conditions))
        shape_of_sizes = -1, level_count, level_count, level_count, internal.shape[1]
        largest_slip = max(box["slide_roll_ratio"])
        return cls(
            levels_of_axes[STRESS_AXIS], np.sort(slip), largest_slip, sizes.reshape(shape_of_sizes)
        )

    @cached_property
    def mu(self) -> FloatArray:
        """Traction coefficient, axes P, U, T, S, sets."""
        return np.stack([self.mu_at(slip) for slip in self.slip], axis=SLIP_AXIS)

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
    printed_constants_of_oil: Mapping[str, FloatArray],
    oil_names: Collection[str],
    settings: PrintedSettings,
    traction_max: float,
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Score every sign set of every oil, and judge every sign in use.

    Args:
        printed_constants_of_oil: The twelve constants of each oil, with the signs in use; the most
            viscous oil first.
        oil_names: The oils whose rows are given.
        settings: Boxes of conditions, slide-roll ratios and limits.
        traction_max: Largest believable mu.

    Returns:
        The tables `signs` and `sign_verdicts`.
    """
    internal_of_sets_by_oil = {
        oil: _all_sign_sets(constants) for oil, constants in printed_constants_of_oil.items()
    }
    shares_by_oil_of_slip_levels = [
        _scores(internal_of_sets_by_oil, slip_levels, settings, traction_max)
        for slip_levels in _SLIP_LEVELS
    ]
    sign_sets = []
    verdicts = []
    for oil in printed_constants_of_oil:
        if oil not in oil_names:
            continue
        shares_of_slip_levels = [
            shares_of_oil[oil] for shares_of_oil in shares_by_oil_of_slip_levels
        ]
        is_in_use = (np.sign(printed_constants_of_oil[oil][_EXPONENTS]) == _SIGN_SETS).all(axis=1)
        rows_of_oil = _table_of_sign_sets(oil, is_in_use, shares_of_slip_levels)
        sign_sets.append(rows_of_oil.sort_values("total", ascending=False, kind="stable"))
        effects = _effects(internal_of_sets_by_oil[oil][:, is_in_use], settings)
        verdicts.append(_verdicts(rows_of_oil, shares_of_slip_levels, effects, settings.signs))
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
    oil: str, is_in_use: BoolArray, shares_of_slip_levels: Sequence[Shares]
) -> pd.DataFrame:
    """One row per sign set of an oil: its total, its ranks, and the share of each statement.

    Args:
        oil: The oil.
        is_in_use: Whether a set has the signs in use, shape (sets,).
        shares_of_slip_levels: Shares of the statements, for each of `_SLIP_LEVELS`.
    """
    totals = [pd.Series(_total(shares)) for shares in shares_of_slip_levels]
    ranks = [total.rank(method="min", ascending=False).astype(int) for total in totals]
    sign_texts = np.where(_SIGN_SETS > 0, "+", "-")
    rows = pd.DataFrame(
        {
            "oil": oil,
            "signs": ["".join(signs) for signs in sign_texts],
            "in_use": is_in_use,
            "rank": ranks[0],
            "rank_at_figures": ranks[1],
            "total": totals[0],
        }
    )
    return rows.assign(**shares_of_slip_levels[0])


def _scores(
    internal_of_sets_by_oil: Mapping[str, FloatArray],
    slip_levels: str,
    settings: PrintedSettings,
    traction_max: float,
) -> dict[str, Shares]:
    """The shares of the statements for each oil.

    Args:
        internal_of_sets_by_oil: Internal constants of every sign set of each oil, shape
            (constants, sets); the most viscous oil first.
        slip_levels: One of `_SLIP_LEVELS`.
        settings: Boxes of conditions, slide-roll ratios and limits.
        traction_max: Largest believable mu.
    """
    shares_of_oil: dict[str, Shares] = {}
    traction_of_oil: dict[str, TractionOverBox] = {}
    tractions_of_best_sets: list[TractionOverBox] = []
    for oil, internal in internal_of_sets_by_oil.items():
        tested_traction = _traction_over_box("tested", slip_levels, internal, settings)
        drawn_traction = _traction_over_box("extrapolated", slip_levels, internal, settings)
        traction_of_oil[oil] = drawn_traction
        compared_slips = settings.signs.slide_roll_ratio.figures
        where_statements_hold = where_true(
            tested_traction, drawn_traction, compared_slips, traction_max, settings.signs
        )
        shares_of_oil[oil] = {
            name: share_of_box(statement_holds)
            for name, statement_holds in where_statements_hold.items()
        }
        best_set_index = int(np.argmax(_total(shares_of_oil[oil])))
        traction_of_best_set = _traction_over_box(
            "extrapolated", slip_levels, internal[:, [best_set_index]], settings
        )
        tractions_of_best_sets.append(traction_of_best_set)
    # Oils are compared with the others as the others' own statements choose them. The signs in use
    # must not confirm each other.
    for oil_rank, (oil, traction_over_box) in enumerate(traction_of_oil.items()):
        more_viscous = tractions_of_best_sets[:oil_rank]
        less_viscous = tractions_of_best_sets[oil_rank + 1 :]
        shares_of_oil[oil]["viscosity_order"] = viscosity_order(
            traction_over_box, more_viscous, less_viscous
        )
        shares_of_oil[oil]["hot_convergence"] = hot_convergence(
            traction_over_box, more_viscous + less_viscous
        )
    return shares_of_oil


def _traction_over_box(
    box_name: str, slip_levels: str, internal: FloatArray, settings: PrintedSettings
) -> TractionOverBox:
    """The surface over a box of the settings, at one of `_SLIP_LEVELS`."""
    ends = settings.boxes.model_dump()[box_name]
    slips = settings.signs.slide_roll_ratio.model_dump()[slip_levels]
    return TractionOverBox.over(ends, settings.signs.levels, slips, internal)


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
            weight = 0.5 if name in HALF_STATEMENTS else 1.0
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
    internal_of_turns = np.tile(constants_in_use, (1, 1 + len(_EXPONENTS)))
    internal_of_turns[_EXPONENTS, range(1, internal_of_turns.shape[1])] *= -1
    traction_over_box = _traction_over_box("tested", _SLIP_LEVELS[0], internal_of_turns, settings)
    mu_of_turns = traction_over_box.mu.reshape(-1, internal_of_turns.shape[1])
    return np.abs(mu_of_turns[:, 1:] - mu_of_turns[:, :1]).max(axis=0) / mu_of_turns[:, 0].max()


def _verdicts(
    sign_sets: pd.DataFrame,
    shares_of_slip_levels: Sequence[Shares],
    effect_of_exponent: FloatArray,
    sign_settings: SignSettings,
) -> pd.DataFrame:
    """One row per sign in use of one oil.

    Args:
        sign_sets: Rows of the oil, as by `_table_of_sign_sets`.
        shares_of_slip_levels: Shares of the statements, for each of `_SLIP_LEVELS`.
        effect_of_exponent: As by `_effects`.
        sign_settings: The limits of the verdicts.
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
    for shares in shares_of_slip_levels:
        for statement in shares:
            margins_without_one.append(margins(_total(shares, without=statement)))
    frame = pd.DataFrame(
        {
            "oil": sign_sets["oil"].iloc[0],
            "constant": [LAW.constants[index].name for index in _EXPONENTS],
            "sign": np.where(signs_in_use > 0, "+", "-"),
            "margin": margins(sign_sets["total"].to_numpy()),
            "weakest_margin": np.min(margins_without_one, axis=0),
            "effect": effect_of_exponent,
        }
    )
    return frame.assign(
        verdict=verdicts(frame["margin"], frame["weakest_margin"], frame["effect"], sign_settings)
    )


def verdicts(
    margin: pd.Series, weakest_margin: pd.Series, effect: pd.Series, sign_settings: SignSettings
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
        sign_settings: The limits.
    """
    near_best = sign_settings.near_best
    # the first condition that is met gives the verdict
    conditions = {
        "without effect": reaches(sign_settings.no_effect_max, effect),
        "settled": reaches(weakest_margin, near_best),
        "probable": reaches(margin, near_best),
        "against": reaches(-near_best, margin),
    }
    return np.select(list(conditions.values()), list(conditions), "open")


def where_true(
    tested_traction: TractionOverBox,
    drawn_traction: TractionOverBox,
    compared_slips: Sequence[float],
    traction_max: float,
    sign_settings: SignSettings,
) -> dict[str, BoolArray]:
    """Where each statement about one oil holds, by name; the last axis is that of the sign sets.

    Args:
        tested_traction: Traction over the box that was tested. Statements of section 2 are checked
            there.
        drawn_traction: Traction over the box that the figures of section 4.3 draw. Statements of
            that section are checked there.
        compared_slips: Slips whose lowest and highest the text compares.
        traction_max: Largest believable mu.
        sign_settings: What counts as linear and slight.
    """
    mu = drawn_traction.mu
    low_slip_mu = drawn_traction.mu_at(min(compared_slips))
    high_slip_mu = drawn_traction.mu_at(max(compared_slips))
    # R2 of the straight line mu(P) is covariance^2/variances
    stress = drawn_traction.stress_gpa - drawn_traction.stress_gpa.mean()
    mu_deviation = mu - mu.mean(axis=STRESS_AXIS, keepdims=True)
    covariance = np.tensordot(stress, mu_deviation, axes=1)
    product_of_squares = (stress**2).sum() * (mu_deviation**2).sum(axis=STRESS_AXIS)
    is_linear = reaches(covariance**2, sign_settings.linear_r2_min * product_of_squares)
    is_slight = reaches(
        tested_traction.mu_at(tested_traction.largest_slip),
        (1 - sign_settings.decline_max) * tested_traction.peak,
    )
    # effects of stress and of temperature at the lowest speed and at the highest one
    stress_effect = (mu[-1] - mu[0])[[0, -1]]
    temperature_effect = (mu[:, :, 0] - mu[:, :, -1])[:, [0, -1]]
    slow_temperature_effect = temperature_effect[:, 0]
    fast_temperature_effect = np.abs(temperature_effect[:, 1])
    # largest mu of each sign set: differences have the rounding of these numbers
    largest_mu = np.abs(mu).max(axis=tuple(range(mu.ndim - 1)))
    return {
        "physical": reaches(mu.min(axis=SLIP_AXIS), 0.0, drawn_traction.peak)
        & reaches(traction_max, drawn_traction.peak),
        "rises_with_stress": _falls(-mu, STRESS_AXIS),
        "linear_in_stress": is_linear & (covariance > 0),
        "falls_with_speed": _falls(mu, SPEED_AXIS),
        "levels_off_with_speed": _levels_off(mu, SPEED_AXIS),
        "falls_with_temperature": _falls(mu, TEMPERATURE_AXIS),
        "levels_off_with_temperature": _levels_off(mu, TEMPERATURE_AXIS),
        "start_falls_with_temperature": _falls(tested_traction.slope, TEMPERATURE_AXIS),
        "rises_with_slip": exceeds(high_slip_mu, low_slip_mu),
        "declines_slightly": exceeds(tested_traction.largest_slip, tested_traction.peak_slip)
        & is_slight,
        "earlier_plateau_with_stress": _falls(drawn_traction.knee, STRESS_AXIS),
        "earlier_plateau_with_speed": _falls(tested_traction.knee, SPEED_AXIS),
        "earlier_plateau_with_temperature": _falls(tested_traction.knee, TEMPERATURE_AXIS),
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
    traction_over_box: TractionOverBox,
    more_viscous: Sequence[TractionOverBox],
    less_viscous: Sequence[TractionOverBox],
) -> FloatArray:
    """Mu is below that of the next more viscous oil, and above that of the next less viscous one.

    The other oils' surfaces are of one set each. NaN where there is no other oil.
    """
    where_statements_hold = []
    if more_viscous:
        where_statements_hold.append(exceeds(more_viscous[-1].mu, traction_over_box.mu))
    if less_viscous:
        where_statements_hold.append(exceeds(traction_over_box.mu, less_viscous[0].mu))
    return _mean_share(where_statements_hold, traction_over_box)


def hot_convergence(
    traction_over_box: TractionOverBox, others: Sequence[TractionOverBox]
) -> FloatArray:
    """Mu is nearer to that of each other oil at the highest temperature than at the lowest."""
    is_nearer = []
    for other in others:
        gap = np.abs(traction_over_box.mu - other.mu)
        is_nearer.append(exceeds(gap[:, :, 0], gap[:, :, -1], other.mu.max()))
    return _mean_share(is_nearer, traction_over_box)


def share_of_box(where_it_holds: BoolArray) -> FloatArray:
    """Share of all conditions and slips where something holds, for each sign set."""
    return where_it_holds.reshape(-1, where_it_holds.shape[-1]).mean(axis=0)


def _mean_share(
    where_statements_hold: list[BoolArray], traction_over_box: TractionOverBox
) -> FloatArray:
    """Mean of the shares where statements hold; NaN for each sign set without any statement."""
    if not where_statements_hold:
        return np.full(traction_over_box.mu.shape[-1], np.nan)
    return np.mean([share_of_box(holds) for holds in where_statements_hold], axis=0)


def _falls(values: FloatArray, axis: int) -> BoolArray:
    """Smaller at the next level of an axis."""
    values_of_level = np.moveaxis(values, axis, 0)
    return np.moveaxis(exceeds(values_of_level[:-1], values_of_level[1:]), 0, axis)


def _levels_off(mu: FloatArray, axis: int) -> BoolArray:
    """Mu changes less over the last third of the levels than it falls over the first.

    Example: from 20 to 140 degC these thirds are 20-60 and 100-140 degC.
    """
    mu_of_level = np.moveaxis(mu, axis, 0)
    steps_of_third = (len(mu_of_level) - 1) // 3
    first_fall = mu_of_level[0] - mu_of_level[steps_of_third]
    last_change = np.abs(mu_of_level[-1 - steps_of_third] - mu_of_level[-1])
    return exceeds(first_fall, last_change, np.abs(mu_of_level).max(axis=0))
