"""Printed constants compared with a campaign's own fit, and the signs that the paper's text allows.

The signs of the exponents are lost in our copy of the paper. Nearly all of section 4.3 describes
figures that the authors drew from these constants. So the statements of the text can be checked
with every set of signs. Each statement is a column of the table `signs`. The description of the
column gives the meaning of the statement and its section of the paper.

All 512 sign sets of an oil are scored at once. Arrays have the axes P, U, T, S and sign sets, or
P, U, T and sign sets:

- P: maximum Hertz pressure in GPa, which the paper calls stress
- U: entrainment speed in m/s
- T: inlet temperature in degC
- S: slide-roll ratio

The total of a sign set is the number of statements that hold. Each statement counts by the share of
its box where it holds. The margin of a sign compares two totals: the best total of the sets with
this sign, less the best total of the sets with the other sign. The other eight signs are free.

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
from oilfilm.base.ties import exceeds, first_largest, reaches, with_equal_ties
from oilfilm.base.units import BoolArray, FloatArray
from oilfilm.fits.fitted import FittedLaw
from oilfilm.fits.problem import curve_data
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.traction.law import CONDITIONS, Observations, to_internal
from oilfilm.traction.laws.deng2026 import DENG2026

# The law whose constants are printed.
LAW = DENG2026


def compare_printed_with_fit(
    results: CampaignTables,
    constants_by_oil: Mapping[str, FloatArray],
    oils: Iterable[str],
    settings: PrintedSettings,
) -> pd.DataFrame:
    """Differences between printed and fitted constants: in the SSE of the points, and in mu.

    There is one row per oil that has printed constants and a fit of the paper's law.

    Args:
        results: Tables of points, coefficients and fit quality, of one law per oil.
        constants_by_oil: The twelve printed constants of each oil.
        oils: The campaign's oils.
        settings: Boxes of conditions and levels of the grid.

    Returns:
        The table `printed_judged`. Its differences are null where the tested conditions cannot
        determine all twelve constants. Where no point was accepted, both SSE are null too.
    """
    quality = results.fit_quality[results.fit_quality["law"] == LAW.name].set_index("oil")
    rows = []
    for oil in oils:
        if oil not in constants_by_oil or oil not in quality.index:
            continue
        points = results.points[results.points["oil"] == oil]
        row = {
            "oil": oil,
            "n_points": points["accepted"].sum(),
            "printed_sse": squared_error(points, constants_by_oil[oil]),
            "fitted_sse": quality.at[oil, "sse"],
        }
        fitted_constants = FittedLaw.from_tables(
            results.coefficients, oil, law=LAW
        ).coefficients.constants
        for box_name, box in settings.boxes.model_dump().items():
            row[f"{box_name}_difference"] = largest_difference(
                fitted_constants, constants_by_oil[oil], box, settings.levels
            )
        rows.append(row)
    return tables.from_rows(rows, "printed_judged")


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
        level_count: How many of each.
    """
    lowest, highest = box["slide_roll_ratio"]
    slip = np.linspace(lowest, highest, level_count)
    internal = to_internal(LAW, np.array([printed_constants, fitted_constants])).T
    printed_mu, fitted_mu = np.moveaxis(
        TractionOverBox.from_box(box, level_count, slip, internal).mu, -1, 0
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
    data = curve_data(points)
    if len(data.mu) == 0 or not np.all(data.conditions > 0):
        return np.nan
    observations = Observations(LAW.design(data.conditions), data.curve_of_point, data.slip)
    law_mu = LAW.traction(to_internal(LAW, constants), observations)
    return float(np.sum((law_mu - data.mu) ** 2))


# By name of a statement: the share of its box where it holds, for each sign set.
StatementShares = dict[str, FloatArray]

# Indices of the constants that are exponents.
_EXPONENT_INDICES = [index for index, constant in enumerate(LAW.constants) if constant.group]
# Signs of the exponents, one row per sign set.
_SIGN_SETS = np.array(list(itertools.product((1, -1), repeat=len(_EXPONENT_INDICES))))
# Slips at which statements are checked, as keys of `printed.signs.slide_roll_ratio` in the
# settings: those of a whole curve (Fig. 7), and those of Figs 8 and 9. Totals and ranks are those
# of the whole curve. The slips of the figures can only make a verdict less sure.
_SLIP_SET_NAMES = ("curve", "figures")
# Axes of arrays.
STRESS, SPEED, TEMPERATURE, SLIP = range(4)
# Statements that count half. The paper does not state the first one: it follows from the Newtonian
# oil and its falling viscosity that section 2.4 names. The others are two readings of one sentence.
HALF_STATEMENTS = (
    "start_falls_with_temperature",
    "earlier_plateau_with_speed",
    "earlier_plateau_with_temperature",
)


@dataclass(frozen=True)
class TractionOverBox:
    """Traction by Eqs 7-9 over a box of conditions, for many sets of constants.

    Attributes:
        pressure_gpa: Levels of P.
        slip: Levels of S.
        largest_slip: The box's largest S.
        magnitudes: |A|, B and C of Eq. 7, axes coefficient, P, U, T, sets.
    """

    pressure_gpa: FloatArray
    slip: FloatArray
    largest_slip: float
    magnitudes: FloatArray

    @classmethod
    def from_box(
        cls,
        box: Mapping[str, Sequence[float]],
        level_count: int,
        slip: Sequence[float] | FloatArray,
        internal: FloatArray,
    ) -> "TractionOverBox":
        """The traction over a box.

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
        magnitudes = LAW.magnitudes(internal, LAW.design(conditions))
        shape = -1, level_count, level_count, level_count, internal.shape[1]
        largest_slip = max(box["slide_roll_ratio"])
        return cls(levels_of_axes[STRESS], np.sort(slip), largest_slip, magnitudes.reshape(shape))

    @cached_property
    def mu(self) -> FloatArray:
        """Traction coefficient, axes P, U, T, S, sets."""
        return np.stack([self.mu_at(slip) for slip in self.slip], axis=SLIP)

    def mu_at(self, slip: FloatArray | float) -> FloatArray:
        """Traction coefficient at one slip, or at a slip of each condition; axes P, U, T, sets."""
        return LAW.mu_of_magnitudes(self.magnitudes, np.asarray(slip))

    @cached_property
    def peak_slip(self) -> FloatArray:
        """Slip of the one peak, where dmu/dS = 0: 1/C + |A|/B."""
        a, b, c = self.magnitudes
        return 1 / c + a / b

    @cached_property
    def peak_mu(self) -> FloatArray:
        """Largest mu within the box's slips."""
        return self.mu_at(np.minimum(self.peak_slip, self.largest_slip))

    @property
    def initial_slope(self) -> FloatArray:
        """Slope of the curve at zero slip: B + |A| C."""
        a, b, c = self.magnitudes
        return b + a * c

    @cached_property
    def knee(self) -> FloatArray:
        """Slip at which the straight start would reach the peak: the end of the linear range."""
        return self.peak_mu / self.initial_slope


def judge_signs(
    constants_by_oil: Mapping[str, FloatArray],
    oils: Collection[str],
    settings: PrintedSettings,
    traction_max: float,
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Score every sign set of every oil, and judge every sign in use.

    Args:
        constants_by_oil: The twelve constants of each oil, with the signs in use, the most viscous
            oil first.
        oils: The oils whose rows are given.
        settings: Boxes of conditions, slide-roll ratios and limits.
        traction_max: Largest believable mu.

    Returns:
        The tables `signs` and `sign_verdicts`.
    """
    sign_set_constants_by_oil = {
        oil: _all_sign_sets(constants) for oil, constants in constants_by_oil.items()
    }
    shares_by_oil_of_slips = [
        _shares_by_oil(sign_set_constants_by_oil, slip_set_name, settings, traction_max)
        for slip_set_name in _SLIP_SET_NAMES
    ]
    sign_set_tables = []
    verdict_tables = []
    for oil in constants_by_oil:
        if oil not in oils:
            continue
        shares_by_slips = [shares_by_oil[oil] for shares_by_oil in shares_by_oil_of_slips]
        is_in_use = (np.sign(constants_by_oil[oil][_EXPONENT_INDICES]) == _SIGN_SETS).all(axis=1)
        sign_set_table = _table_of_sign_sets(oil, is_in_use, shares_by_slips)
        sign_set_tables.append(sign_set_table.sort_values("total", ascending=False, kind="stable"))
        effects = _sign_effects(sign_set_constants_by_oil[oil][:, is_in_use], settings)
        verdict_tables.append(
            _verdict_table(sign_set_table, shares_by_slips, effects, settings.signs)
        )
    if not sign_set_tables:
        return tables.empty_table("signs"), tables.empty_table("sign_verdicts")
    return (
        tables.conform(pd.concat(sign_set_tables), "signs", "sign sets"),
        tables.conform(pd.concat(verdict_tables), "sign_verdicts", "signs"),
    )


def _all_sign_sets(constants: FloatArray) -> FloatArray:
    """Constants with every sign set, in the law's internal form, shape (constants, sets).

    Only exponents change their sign: A0, B0 and C0 keep it.
    """
    internal = np.tile(to_internal(LAW, constants)[:, np.newaxis], (1, len(_SIGN_SETS)))
    internal[_EXPONENT_INDICES] = np.abs(internal[_EXPONENT_INDICES]) * _SIGN_SETS.T
    return internal


def _table_of_sign_sets(
    oil: str, is_in_use: BoolArray, shares_by_slips: Sequence[StatementShares]
) -> pd.DataFrame:
    """One row per sign set of an oil: its total, its ranks, and the share of each statement.

    Args:
        oil: The oil.
        is_in_use: Whether a set has the signs in use, shape (sets,).
        shares_by_slips: Shares of the statements, for each of `_SLIP_SET_NAMES`.
    """
    totals_by_slips = [pd.Series(_statement_totals(shares)) for shares in shares_by_slips]
    ranks_by_slips = [
        total.rank(method="min", ascending=False).astype(int) for total in totals_by_slips
    ]
    texts = np.where(_SIGN_SETS > 0, "+", "-")
    rows = pd.DataFrame(
        {
            "oil": oil,
            "signs": ["".join(signs) for signs in texts],
            "in_use": is_in_use,
            "rank": ranks_by_slips[0],
            "rank_at_figures": ranks_by_slips[1],
            "total": totals_by_slips[0],
        }
    )
    return rows.assign(**shares_by_slips[0])


def _shares_by_oil(
    sign_set_constants_by_oil: Mapping[str, FloatArray],
    slip_set_name: str,
    settings: PrintedSettings,
    traction_max: float,
) -> dict[str, StatementShares]:
    """The shares of the statements for each oil.

    Args:
        sign_set_constants_by_oil: Constants of every sign set of each oil, the most viscous oil
            first.
        slip_set_name: One of `_SLIP_SET_NAMES`.
        settings: Boxes of conditions, slide-roll ratios and limits.
        traction_max: Largest believable mu.
    """
    shares_by_oil: dict[str, StatementShares] = {}
    figures_box_by_oil: dict[str, TractionOverBox] = {}
    figures_boxes_with_best_signs: list[TractionOverBox] = []
    for oil, internal in sign_set_constants_by_oil.items():
        tested = _traction_in_box("tested", slip_set_name, internal, settings)
        in_figures_box = _traction_in_box("extrapolated", slip_set_name, internal, settings)
        figures_box_by_oil[oil] = in_figures_box
        compared_slips = settings.signs.slide_roll_ratio.figures
        holds_by_statement = where_statements_hold(
            tested, in_figures_box, compared_slips, traction_max, settings.signs
        )
        shares_by_oil[oil] = {
            name: share_of_conditions(statement_holds)
            for name, statement_holds in holds_by_statement.items()
        }
        best_index = int(np.argmax(_statement_totals(shares_by_oil[oil])))
        figures_box_with_best_signs = _traction_in_box(
            "extrapolated", slip_set_name, internal[:, [best_index]], settings
        )
        figures_boxes_with_best_signs.append(figures_box_with_best_signs)
    # Each oil is compared with the other oils. These have the signs that their own statements
    # support best, not the signs in use: the signs in use must not confirm each other.
    for oil_index, (oil, traction) in enumerate(figures_box_by_oil.items()):
        more_viscous = figures_boxes_with_best_signs[:oil_index]
        less_viscous = figures_boxes_with_best_signs[oil_index + 1 :]
        shares_by_oil[oil]["viscosity_order"] = viscosity_order(
            traction, more_viscous, less_viscous
        )
        shares_by_oil[oil]["hot_convergence"] = hot_convergence(
            traction, more_viscous + less_viscous
        )
    return shares_by_oil


def _traction_in_box(
    box_name: str, slip_set_name: str, internal: FloatArray, settings: PrintedSettings
) -> TractionOverBox:
    """The traction over a box of the settings, at the slips of one of `_SLIP_SET_NAMES`."""
    box = settings.boxes.model_dump()[box_name]
    slips = settings.signs.slide_roll_ratio.model_dump()[slip_set_name]
    return TractionOverBox.from_box(box, settings.signs.levels, slips, internal)


def _statement_totals(shares: StatementShares, left_out_statement: str = "") -> FloatArray:
    """Number of statements that hold for each sign set; those that cannot be judged do not count.

    Sets whose numbers differ only by rounding get the same number.

    Args:
        shares: Shares of the statements.
        left_out_statement: A statement that is left out.
    """
    weighted_shares = []
    for name, share_of_box in shares.items():
        if name != left_out_statement:
            weight = 0.5 if name in HALF_STATEMENTS else 1.0
            weighted_shares.append(weight * share_of_box)
    return with_equal_ties(np.nansum(weighted_shares, axis=0))


def _sign_effects(constants_in_use: FloatArray, settings: PrintedSettings) -> FloatArray:
    """Relative effect of each sign: the largest change of mu in the tested box if it is turned.

    It is relative to the largest mu with the signs in use.

    Args:
        constants_in_use: Internal constants with the signs in use, shape (constants, 1).
        settings: The tested box and its levels.

    Returns:
        Shape (exponents,).
    """
    # first column: signs in use; one more column for each sign turned
    turned_constants = np.tile(constants_in_use, (1, 1 + len(_EXPONENT_INDICES)))
    turned_constants[_EXPONENT_INDICES, range(1, turned_constants.shape[1])] *= -1
    traction = _traction_in_box("tested", _SLIP_SET_NAMES[0], turned_constants, settings)
    mu_of_turns = traction.mu.reshape(-1, turned_constants.shape[1])
    return np.abs(mu_of_turns[:, 1:] - mu_of_turns[:, :1]).max(axis=0) / mu_of_turns[:, 0].max()


def _verdict_table(
    sign_sets: pd.DataFrame,
    shares_by_slips: Sequence[StatementShares],
    effects: FloatArray,
    limits: SignSettings,
) -> pd.DataFrame:
    """One row per sign in use of one oil.

    Args:
        sign_sets: Rows of the oil, as by `_table_of_sign_sets`.
        shares_by_slips: Shares of the statements, for each of `_SLIP_SET_NAMES`.
        effects: As by `_sign_effects`.
        limits: The limits of the verdicts.
    """
    signs_in_use = _SIGN_SETS[sign_sets["in_use"]][0]
    # whether a set has the sign in use of an exponent, shape (exponents, sets)
    has_sign = (signs_in_use == _SIGN_SETS).T

    def margins_of_signs(total: FloatArray) -> list[float]:
        return [
            total[has_sign_of_exponent].max() - total[~has_sign_of_exponent].max()
            for has_sign_of_exponent in has_sign
        ]

    margins_without_one = []
    for shares in shares_by_slips:
        for statement in shares:
            margins_without_one.append(
                margins_of_signs(_statement_totals(shares, left_out_statement=statement))
            )
    verdict_table = pd.DataFrame(
        {
            "oil": sign_sets["oil"].iloc[0],
            "constant": [LAW.constants[index].name for index in _EXPONENT_INDICES],
            "sign": np.where(signs_in_use > 0, "+", "-"),
            "margin": margins_of_signs(sign_sets["total"].to_numpy()),
            "weakest_margin": np.min(margins_without_one, axis=0),
            "effect": effects,
        }
    )
    return verdict_table.assign(
        verdict=sign_verdicts(
            verdict_table["margin"],
            verdict_table["weakest_margin"],
            verdict_table["effect"],
            limits,
        )
    )


def sign_verdicts(
    margin: pd.Series, weakest_margin: pd.Series, effect: pd.Series, limits: SignSettings
) -> np.ndarray:
    """How sure the signs in use are.

    The verdict depends on the sets whose totals are within `near_best` statements of the best one:

    - Without effect: turning the sign alone moves mu by at most `no_effect_max` of its largest
      value.
    - Settled: all these sets have the sign. This is so at the slips of the whole curve and at those
      of the figures, whichever statement is left out.
    - Probable: all of them have the sign if no statement is left out, at the slips of the whole
      curve.
    - Against: all of them have the other sign.
    - Open: both signs occur among them.

    Args:
        margin: In statements (see the module).
        weakest_margin: The smallest margin of all cases: one statement is left out, at the slips of
            the whole curve or at those of the figures.
        effect: Largest change of mu over its largest value.
        limits: The limits.
    """
    near_best = limits.near_best
    # the first condition that is met gives the verdict
    is_met_by_verdict = {
        "without effect": reaches(limits.no_effect_max, effect),
        "settled": reaches(weakest_margin, near_best),
        "probable": reaches(margin, near_best),
        "against": reaches(-near_best, margin),
    }
    return np.select(list(is_met_by_verdict.values()), list(is_met_by_verdict), "open")


def where_statements_hold(
    tested: TractionOverBox,
    in_figures_box: TractionOverBox,
    compared_slips: Sequence[float],
    traction_max: float,
    limits: SignSettings,
) -> dict[str, BoolArray]:
    """Where each statement about one oil holds; the last axis is that of the sign sets.

    Args:
        tested: The box that was tested. Statements of section 2 are checked there.
        in_figures_box: The box that the figures of section 4.3 draw. Statements of that section are
            checked there.
        compared_slips: Slips whose lowest and highest the text compares.
        traction_max: Largest believable mu.
        limits: What counts as linear and slight.
    """
    mu = in_figures_box.mu
    low_slip_mu = in_figures_box.mu_at(min(compared_slips))
    high_slip_mu = in_figures_box.mu_at(max(compared_slips))
    # R2 of the straight line mu(P) is covariance^2/variances
    pressure_deviation = in_figures_box.pressure_gpa - in_figures_box.pressure_gpa.mean()
    mu_deviation = mu - mu.mean(axis=STRESS, keepdims=True)
    covariance = np.tensordot(pressure_deviation, mu_deviation, axes=1)
    variances = (pressure_deviation**2).sum() * (mu_deviation**2).sum(axis=STRESS)
    is_linear = reaches(covariance**2, limits.linear_r2_min * variances)
    declines_little = reaches(
        tested.mu_at(tested.largest_slip), (1 - limits.decline_max) * tested.peak_mu
    )
    # effects of stress and of temperature at the lowest speed and at the highest one
    stress_effect = (mu[-1] - mu[0])[[0, -1]]
    temperature_effect = (mu[:, :, 0] - mu[:, :, -1])[:, [0, -1]]
    slow_temperature_effect = temperature_effect[:, 0]
    fast_temperature_effect = np.abs(temperature_effect[:, 1])
    # largest mu of each sign set: differences have the rounding of these numbers
    largest_mu = np.abs(mu).max(axis=tuple(range(mu.ndim - 1)))
    return {
        "physical": reaches(mu.min(axis=SLIP), 0.0, in_figures_box.peak_mu)
        & reaches(traction_max, in_figures_box.peak_mu),
        "rises_with_stress": _falls_to_next_level(-mu, STRESS),
        "linear_in_stress": is_linear & (covariance > 0),
        "falls_with_speed": _falls_to_next_level(mu, SPEED),
        "levels_off_with_speed": _levels_off(mu, SPEED),
        "falls_with_temperature": _falls_to_next_level(mu, TEMPERATURE),
        "levels_off_with_temperature": _levels_off(mu, TEMPERATURE),
        "start_falls_with_temperature": _falls_to_next_level(tested.initial_slope, TEMPERATURE),
        "rises_with_slip": exceeds(high_slip_mu, low_slip_mu),
        "declines_slightly": exceeds(tested.largest_slip, tested.peak_slip) & declines_little,
        "earlier_plateau_with_stress": _falls_to_next_level(in_figures_box.knee, STRESS),
        "earlier_plateau_with_speed": _falls_to_next_level(tested.knee, SPEED),
        "earlier_plateau_with_temperature": _falls_to_next_level(tested.knee, TEMPERATURE),
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
    traction: TractionOverBox,
    more_viscous: Sequence[TractionOverBox],
    less_viscous: Sequence[TractionOverBox],
) -> FloatArray:
    """How far mu is in the order of the viscosities, as the mean of two shares of conditions.

    In one share mu is below that of the next more viscous oil. In the other it is above that of the
    next less viscous oil. An oil that has only one of these neighbours has one share. The other
    oils have one set of constants each. NaN where there is no other oil.
    """
    holds_of_comparisons = []
    if more_viscous:
        holds_of_comparisons.append(exceeds(more_viscous[-1].mu, traction.mu))
    if less_viscous:
        holds_of_comparisons.append(exceeds(traction.mu, less_viscous[0].mu))
    return _mean_share(holds_of_comparisons, traction)


def hot_convergence(traction: TractionOverBox, others: Sequence[TractionOverBox]) -> FloatArray:
    """Share of conditions at which mu comes nearer to that of other oils as the oils warm.

    The highest temperature is compared with the lowest one.
    """
    is_nearer = []
    for other in others:
        gap = np.abs(traction.mu - other.mu)
        is_nearer.append(exceeds(gap[:, :, 0], gap[:, :, -1], other.mu.max()))
    return _mean_share(is_nearer, traction)


def share_of_conditions(holds: BoolArray) -> FloatArray:
    """Share of all conditions and slips at which something holds, for each sign set."""
    return holds.reshape(-1, holds.shape[-1]).mean(axis=0)


def _mean_share(holds_of_comparisons: list[BoolArray], traction: TractionOverBox) -> FloatArray:
    """Mean of the shares where statements hold; NaN for each sign set without any statement."""
    if not holds_of_comparisons:
        return np.full(traction.mu.shape[-1], np.nan)
    return np.mean([share_of_conditions(holds) for holds in holds_of_comparisons], axis=0)


def _falls_to_next_level(values: FloatArray, axis: int) -> BoolArray:
    """Whether values are smaller at the next level of an axis, at each level but the last."""
    levels = np.moveaxis(values, axis, 0)
    return np.moveaxis(exceeds(levels[:-1], levels[1:]), 0, axis)


def _levels_off(mu: FloatArray, axis: int) -> BoolArray:
    """Whether mu changes less over the last third of the levels than it falls over the first.

    Example: from 20 to 140 degC these thirds are 20-60 and 100-140 degC.
    """
    mu_of_level = np.moveaxis(mu, axis, 0)
    steps_of_third = (len(mu_of_level) - 1) // 3
    first_fall = mu_of_level[0] - mu_of_level[steps_of_third]
    last_change = np.abs(mu_of_level[-1 - steps_of_third] - mu_of_level[-1])
    return exceeds(first_fall, last_change, np.abs(mu_of_level).max(axis=0))
