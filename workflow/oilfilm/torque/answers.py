"""An engineer's answers at operating points: torque, power loss, cage slip, best oil.

Each answer has its interval. The share of each cause in its variance is shown with the range from
which the cause was drawn, because that range decides the share.

Decides: what to measure next, so that torque or cage slip of a bearing become more certain.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
import pandas as pd

from oilfilm import tables
from oilfilm.base.units import MM_PER_M, BoolArray, FloatArray
from oilfilm.bearing.geometry import Bearing
from oilfilm.bearing.inputs import INPUT_NAMES
from oilfilm.settings.resolved import Settings
from oilfilm.torque.bearing_torque import CaseGroup, FrictionCases, OilInBearing, stack_tables
from oilfilm.torque.best_oil import best_oil_table, best_shares
from oilfilm.torque.torque_uncertainty import NUMBER_NAMES_OF_CAUSE, RANDOM_FACTOR_TERMS

# Columns of a duty point: an operating point of a bearing for which an answer is wanted.
DUTY_COLUMNS = ("axial_load_n", "inner_speed_rpm", "oil_temperature_c")
# Most operating points of a campaign that have shares of variance. The shares of a point take as
# long to calculate as ten intervals.
_MOST_POINTS_WITH_SHARES = 8
# Causes in the traction. Tests of traction are planned where one of them has the largest share.
_TRACTION_CAUSES = ("law", "runs", "rig")
# What is left where the law and its rig are exact, as one cause. The scatter of runs is part of it,
# because one more run does not make the next one scatter less.
_IRREDUCIBLE_CAUSES = {
    "irreducible": tuple(
        name
        for cause, names in NUMBER_NAMES_OF_CAUSE.items()
        if cause not in ("law", "rig")
        for name in names
    )
}
_UM_PER_M = 1e6
# Numbers from this one on are shown without decimals.
_NO_DECIMALS_FROM = 100
_L_MIN_PER_M3_S = 6e4


class UncertaintyCause(NamedTuple):
    """Description of a cause of uncertainty.

    Attributes:
        meaning: What it is.
        unit: Unit in which its range is shown.
        shown_per_calculated: Factor from the unit of the calculation to the shown unit.
        quantity_to_measure: What to measure, so that the cause becomes known.
    """

    meaning: str
    unit: str
    shown_per_calculated: float
    quantity_to_measure: str


CAUSE_BY_NAME = {
    "oil_volume_fraction": UncertaintyCause(
        "drag: oil among the balls", "%", 100.0, "the cage's speed"
    ),
    "feed_flow_m3_s": UncertaintyCause(
        "flow of the feed oil", "L/min", _L_MIN_PER_M3_S, "the flow of oil"
    ),
    "momentum_share": UncertaintyCause(
        "share of the flow with the ring's speed", "%", 100.0, "torque over flow at one speed"
    ),
    "replenishment_constant": UncertaintyCause(
        "starvation, K_rs", "times 1e-8", 1e8, "torque over flow"
    ),
    "ellipse_factor": UncertaintyCause(
        "traction of ellipse over circle", "", 1.0, "traction of an ellipse"
    ),
    "shaft_bore_ratio": UncertaintyCause(
        "bore of the shaft over groove", "", 1.0, "the bore of the shaft"
    ),
    "shaft_interference_m": UncertaintyCause(
        "interference on the shaft, radius", "um", _UM_PER_M, "the fit on the shaft"
    ),
    "housing_interference_m": UncertaintyCause(
        "interference in the housing, radius", "um", _UM_PER_M, "the fit in the housing"
    ),
    "ring_temperature_difference_k": UncertaintyCause(
        "inner less outer ring", "K", 1.0, "the temperatures of both rings"
    ),
    "ball_temperature_difference_k": UncertaintyCause(
        "balls less mean of the rings", "K", 1.0, "the temperature of the balls"
    ),
    "rolling": UncertaintyCause(
        "formula of rolling resistance", "", 1.0, "torque at little traction"
    ),
    "hysteresis": UncertaintyCause(
        "hysteresis of the steel", "", 1.0, "torque under load without oil flow"
    ),
    "pocket": UncertaintyCause("friction of the pockets", "", 1.0, "friction of a pocket"),
    "land": UncertaintyCause("friction of the cage's land", "", 1.0, "friction of the land"),
    "viscosity": UncertaintyCause(
        "viscosity of a stand-in oil", "", 1.0, "viscosity of the oil itself"
    ),
    "rig": UncertaintyCause(
        "calibration of the traction rig", "", 1.0, "the sensors of the traction rig"
    ),
    "law": UncertaintyCause("traction law", "", 1.0, "traction at the conditions of the contacts"),
    "runs": UncertaintyCause("scatter of traction runs", "", 1.0, "repeats of traction runs"),
}


class Answers(NamedTuple):
    """Torque, power loss, cage slip and best oil at operating points.

    Attributes:
        points: One row per oil and point, as the table of cage slip, with `best_oil`.
        shares: One row per oil, point and cause, with the range that was drawn: `range_low` and
            `range_high` in the unit of `CAUSE_BY_NAME`, or the relative `standard_uncertainty`.
            Where the scatter of runs or the flow of the feed oil is not known nothing was drawn for
            it: its shares are null.
    """

    points: pd.DataFrame
    shares: pd.DataFrame


def duty_points(settings: Settings, bearing: Bearing) -> FloatArray:
    """Operating points that a campaign names, with the columns `DUTY_COLUMNS`: shape (points, 3).

    They are those of the plan, else of the torque tests, else of the cage-slip map.
    """
    duty_of_plan = settings.plan.duty_points
    if duty_of_plan:
        return np.array([[getattr(point, name) for name in DUTY_COLUMNS] for point in duty_of_plan])
    torque = settings.campaign.torque
    if torque is not None and torque.matrix is not None:
        loads_n, speeds_rpm, temperatures_c = (
            getattr(torque.matrix, name) for name in DUTY_COLUMNS
        )
    else:
        cage_slip = settings.bearing.cage_slip
        loads_n = cage_slip.axial_load_n
        pitch_mm = bearing.pitch_diameter_m * MM_PER_M
        speeds_rpm = np.array(cage_slip.pitch_speed_mm_rpm) / pitch_mm
        temperatures_c = [cage_slip.inlet_temperature_c]
    mesh = np.meshgrid(loads_n, speeds_rpm, temperatures_c, indexing="ij")
    return np.stack(mesh, axis=-1).reshape(-1, len(DUTY_COLUMNS))


def operating_point_table(
    bearing: Bearing,
    axial_load_n: FloatArray,
    inner_speed_rpm: FloatArray,
    inlet_temperature_c: FloatArray,
) -> pd.DataFrame:
    """Operating points for `calculate_answers`, one row per point; the arguments broadcast.

    Args:
        bearing: The bearing.
        axial_load_n: Axial load.
        inner_speed_rpm: Speed of the inner ring.
        inlet_temperature_c: Temperature of the oil at the inlet.
    """
    load_n, speed_rpm, temperature_c = np.broadcast_arrays(
        axial_load_n, inner_speed_rpm, inlet_temperature_c
    )
    return pd.DataFrame(
        {
            "axial_load_n": load_n.ravel(),
            "inner_speed_rpm": speed_rpm.ravel(),
            "pitch_speed_mm_rpm": speed_rpm.ravel() * bearing.pitch_diameter_m * MM_PER_M,
            "inlet_temperature_c": temperature_c.ravel(),
        }
    )


def calculate_answers(
    oils: Sequence[OilInBearing],
    bearing: Bearing,
    points: pd.DataFrame,
    settings: Settings,
    needs_shares: Callable[[pd.DataFrame], BoolArray],
) -> Answers:
    """Torque, power loss, cage slip and best oil of each oil at each point, with their shares.

    Args:
        oils: The oils among which the best one is chosen.
        bearing: The bearing.
        points: Operating points of `operating_point_table`, each once.
        settings: `bearing`, `gates` and `seed`.
        needs_shares: Returns which rows of `Answers.points` shall have shares of variance.
    """
    cases = FrictionCases(bearing, [CaseGroup(oil, "stress", points) for oil in oils])
    calculated, draws, random_draws = cases.calculate_with_uncertainty(settings.seed)
    slip_limit = settings.bearing.cage_slip.slip_limit
    lambda_limit = settings.gates.lambda_limit
    calculated = calculated.assign(**best_shares(draws, len(oils), slip_limit, lambda_limit))
    best_oil_of_point = best_oil_table(calculated, slip_limit, lambda_limit)
    point_columns = ["axial_load_n", "inner_speed_rpm", "inlet_temperature_c"]
    calculated = calculated.merge(
        best_oil_of_point[[*point_columns, "best_oil"]], on=point_columns, how="left"
    )
    shares = random_draws.calculate_shares(np.flatnonzero(needs_shares(calculated)))
    key_columns = calculated[["oil", "bearing", *point_columns]]
    shares = shares.join(key_columns, on="point")
    law_errors = pd.Series(random_draws.law_error_of_drawn_point, random_draws.drawn_point_index)
    return Answers(calculated, _add_ranges(shares, law_errors, oils, bearing))


def campaign_answers(oils: Sequence[OilInBearing], settings: Settings) -> dict[str, pd.DataFrame]:
    """The tables `bearing_answers` and `variance_shares` of a campaign, by their names.

    They are calculated for the campaign's bearing at its `duty_points`.

    Args:
        oils: Oils with their laws.
        settings: The settings.
    """
    if not oils:
        table_names = ("bearing_answers", "variance_shares")
        return {table_name: tables.empty_table(table_name) for table_name in table_names}
    bearing = settings.tested_bearing()
    points = operating_point_table(bearing, *duty_points(settings, bearing).T).drop_duplicates()
    has_shares = _evenly_spaced_mask(len(points))
    answered = calculate_answers(
        oils,
        bearing,
        points,
        settings,
        # the points of one oil after those of the other
        lambda results: np.tile(has_shares, len(oils)),
    )
    return {
        "bearing_answers": stack_tables([answered.points], "bearing_answers"),
        "variance_shares": stack_tables([answered.shares], "variance_shares"),
    }


class UncertaintyBudget(NamedTuple):
    """What makes torque or cage slip of an oil uncertain, over several operating points.

    Uncertainties are relative for the torque, absolute for the slip.

    Attributes:
        uncertainty: Root mean square of the standard uncertainty; NaN where it is not known.
        irreducible_uncertainty_of_point: Standard uncertainty that is left at each operating point
            if the law and its rig are exact, shape (points,); NaN where it is not known.
        largest_cause: The cause with the largest median share; empty where it is not known.
        largest_share: Median share of that cause; NaN where it is not known.
        law_share: Sum of the median shares of all of traction: the law, its rig and its runs.
    """

    uncertainty: float
    irreducible_uncertainty_of_point: FloatArray
    largest_cause: str
    largest_share: float
    law_share: float

    @property
    def tests_may_help(self) -> bool:
        """Whether traction has the largest share, or no share is known."""
        return self.largest_cause in ("", *_TRACTION_CAUSES)


def uncertainty_budgets(
    oil: OilInBearing, bearing: Bearing, duty: FloatArray, settings: Settings
) -> dict[str, UncertaintyBudget]:
    """The budgets of `torque` and `cage_slip` of an oil.

    Args:
        oil: The oil with its refits.
        bearing: The bearing.
        duty: Duty points, with the columns `DUTY_COLUMNS`.
        settings: `bearing` and `seed`.
    """
    points = operating_point_table(bearing, *duty.T)
    calculated, _, random_draws = FrictionCases(
        bearing, [CaseGroup(oil, "stress", points)]
    ).calculate_with_uncertainty(settings.seed)
    uncertainty_by_target = {
        "torque": calculated["torque_n_m_uncertainty"] / calculated["torque_n_m"],
        "cage_slip": calculated["cage_slip_uncertainty"],
    }
    shares_by_cause = random_draws.calculate_shares(
        np.flatnonzero(_evenly_spaced_mask(len(points)))
    )
    irreducible_shares = random_draws.calculate_shares(
        np.arange(len(points)), _IRREDUCIBLE_CAUSES
    ).set_index("point")
    share_column_by_target = {"torque": "torque_share", "cage_slip": "slip_share"}
    budget_by_target = {}
    for target, uncertainty in uncertainty_by_target.items():
        share_column = share_column_by_target[target]
        rms_uncertainty = float(np.sqrt((uncertainty**2).mean()))
        irreducible_share = irreducible_shares[share_column].reindex(calculated.index).astype(float)
        irreducible_uncertainty = (uncertainty * np.sqrt(irreducible_share)).to_numpy(dtype=float)
        median_share = shares_by_cause.groupby("variance_cause")[share_column].median().dropna()
        if median_share.empty:
            budget_by_target[target] = UncertaintyBudget(
                rms_uncertainty, irreducible_uncertainty, "", np.nan, np.nan
            )
            continue
        cause = str(median_share.idxmax())
        budget_by_target[target] = UncertaintyBudget(
            uncertainty=rms_uncertainty,
            irreducible_uncertainty_of_point=irreducible_uncertainty,
            largest_cause=cause,
            largest_share=float(median_share[cause]),
            law_share=float(median_share[list(_TRACTION_CAUSES)].sum()),
        )
    return budget_by_target


def _evenly_spaced_mask(point_count: int) -> BoolArray:
    """True for the evenly spaced points that have shares of variance, shape (points,)."""
    chosen_index = (
        np.linspace(0, point_count - 1, min(point_count, _MOST_POINTS_WITH_SHARES))
        .round()
        .astype(int)
    )
    return np.isin(np.arange(point_count), chosen_index)


def _add_ranges(
    shares: pd.DataFrame,
    law_error_of_point: "pd.Series[float]",
    oils: Sequence[OilInBearing],
    bearing: Bearing,
) -> pd.DataFrame:
    """Shares of variance with the range or the standard uncertainty that was drawn.

    Args:
        shares: Shares by oil, point and cause.
        law_error_of_point: Relative standard error of the law's form, by the index of the point.
        oils: The oils.
        bearing: The bearing.
    """
    settings = oils[0].bearing_settings
    uncertain_input_by_name = {**bearing.uncertain_inputs, **settings.uncertain_inputs()}
    lowest_by_cause = {
        name: CAUSE_BY_NAME[name].shown_per_calculated * uncertain_input_by_name[name].low
        for name in INPUT_NAMES
    }
    highest_by_cause = {
        name: CAUSE_BY_NAME[name].shown_per_calculated * uncertain_input_by_name[name].high
        for name in INPUT_NAMES
    }
    relative_uncertainty_by_cause = {
        term: getattr(settings.term_uncertainty, term) for term in RANDOM_FACTOR_TERMS
    }
    standard_uncertainty = shares["variance_cause"].map(relative_uncertainty_by_cause).astype(float)
    is_law = shares["variance_cause"] == "law"
    standard_uncertainty = standard_uncertainty.where(
        ~is_law, shares["point"].map(law_error_of_point)
    )
    for oil in oils:
        is_of_oil = shares["oil"] == oil.name
        run_sd = oil.laws["stress"].fitted.coefficients.run_sd
        viscosity = settings.stand_in_uncertainty.viscosity * oil.properties.stand_in
        standard_uncertainty = standard_uncertainty.mask(
            is_of_oil & (shares["variance_cause"] == "runs"), run_sd
        )
        standard_uncertainty = standard_uncertainty.mask(
            is_of_oil & (shares["variance_cause"] == "viscosity"), viscosity
        )
    range_low = shares["variance_cause"].map(lowest_by_cause).astype(float)
    may_be_unknown = shares["variance_cause"].isin(["runs", *INPUT_NAMES])
    is_unknown = may_be_unknown & standard_uncertainty.isna() & range_low.isna()
    return shares.assign(
        torque_share=shares["torque_share"].mask(is_unknown),
        slip_share=shares["slip_share"].mask(is_unknown),
        range_low=range_low,
        range_high=shares["variance_cause"].map(highest_by_cause).astype(float),
        standard_uncertainty=standard_uncertainty,
    )


def three_digit_text(value: float) -> str:
    """A number with three significant digits or more, as text without an exponent.

    Examples:
        >>> three_digit_text(1234.5), three_digit_text(5.914), three_digit_text(0.0000123)
        ('1234', '5.91', '0.0000123')
    """
    if abs(value) >= _NO_DECIMALS_FROM:
        return f"{value:.0f}"
    return np.format_float_positional(float(f"{value:.3g}"), trim="-")


def interval_text(value: float, lower: float, upper: float) -> str:
    """A number with its interval, as `5.91 (4.46 to 9.84)`."""
    if not np.isfinite(value):
        return "not known"
    if not np.isfinite(lower):
        return f"{three_digit_text(value)} (no interval)"
    return f"{three_digit_text(value)} ({three_digit_text(lower)} to {three_digit_text(upper)})"


def range_text(share_row: "pd.Series[float]") -> str:
    """The range of a row of `Answers.shares`, as `4 to 16 L/min` or `10 %`."""
    cause = CAUSE_BY_NAME[str(share_row["variance_cause"])]
    if np.isfinite(share_row["range_low"]):
        return (
            f"{share_row['range_low']:.3g} to {share_row['range_high']:.3g} {cause.unit}".rstrip()
        )
    if np.isfinite(share_row["standard_uncertainty"]):
        return f"{100 * share_row['standard_uncertainty']:.2g} % of it, one standard deviation"
    return "as stated in the rig's file" if cause is CAUSE_BY_NAME["rig"] else "not known"


def what_to_measure(
    shares: pd.DataFrame, share_column: str, smallest_share: float = 0.1
) -> list[tuple[str, str]]:
    """The causes of the most variance, the largest first, each with what to measure.

    Args:
        shares: Rows of `Answers.shares`, of one point or of several.
        share_column: `torque_share` or `slip_share`; the median over the points counts.
        smallest_share: Smallest share that is named.
    """
    median_share = (
        shares.groupby("variance_cause")[share_column].median().sort_values(ascending=False)
    )
    return [
        (str(cause), CAUSE_BY_NAME[str(cause)].quantity_to_measure)
        for cause in median_share.index[median_share >= smallest_share]
    ]
