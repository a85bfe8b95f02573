"""An engineer's answers at operating points: torque, power loss, cage slip, best oil.

Each answer has its interval, and the share of its variance by each cause with the range that was
drawn. The ranges decide the shares, so that both are shown together.

Decides: what to measure next, so that torque or cage slip of a bearing become more certain.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import pandas as pd

from oilfilm.base.units import MM_PER_M, FloatArray
from oilfilm.bearing.geometry import Bearing
from oilfilm.bearing.inputs import INPUTS
from oilfilm.settings.resolved import Settings
from oilfilm.torque.bearing_torque import Cases, OilInBearing
from oilfilm.torque.best_oil import best_oils, best_shares
from oilfilm.torque.torque_uncertainty import FACTOR_TERMS

_UM_PER_M = 1e6
_L_MIN_PER_M3_S = 6e4


class Cause(NamedTuple):
    """A cause of uncertainty in words.

    Attributes:
        meaning: What it is.
        unit: Unit of its range as it is shown.
        scale: The shown number over that of the calculation.
        measure: What would make it known.
    """

    meaning: str
    unit: str
    scale: float
    measure: str


CAUSES = {
    "oil_volume_fraction": Cause("drag: oil among the balls", "%", 100.0, "the cage's speed"),
    "feed_flow_m3_s": Cause("flow of the feed oil", "L/min", _L_MIN_PER_M3_S, "the flow of oil"),
    "momentum_share": Cause(
        "share of the flow with the ring's speed", "%", 100.0, "torque over flow at one speed"
    ),
    "replenishment_constant": Cause("starvation, K_rs", "1e-8", 1e8, "torque over flow"),
    "ellipse_factor": Cause("traction of ellipse over circle", "", 1.0, "traction of an ellipse"),
    "shaft_bore_ratio": Cause("bore of the shaft over groove", "", 1.0, "the bore of the shaft"),
    "shaft_interference_m": Cause(
        "interference on the shaft, radius", "um", _UM_PER_M, "the fit on the shaft"
    ),
    "housing_interference_m": Cause(
        "interference in the housing, radius", "um", _UM_PER_M, "the fit in the housing"
    ),
    "ring_temperature_difference_k": Cause(
        "inner less outer ring", "K", 1.0, "the temperatures of both rings"
    ),
    "ball_temperature_difference_k": Cause(
        "balls less mean of the rings", "K", 1.0, "the temperature of the balls"
    ),
    "rolling": Cause("formula of rolling resistance", "", 1.0, "torque at little traction"),
    "hysteresis": Cause("hysteresis of the steel", "", 1.0, "torque under load without oil flow"),
    "pocket": Cause("friction of the pockets", "", 1.0, "friction of a pocket"),
    "land": Cause("friction of the cage's land", "", 1.0, "friction of the land"),
    "viscosity": Cause("viscosity of a stand-in oil", "", 1.0, "viscosity of the oil itself"),
    "rig": Cause("calibration of the traction rig", "", 1.0, "the sensors of the traction rig"),
    "law": Cause("traction law", "", 1.0, "traction at the conditions of the contacts"),
    "runs": Cause("scatter of traction runs", "", 1.0, "repeats of traction runs"),
}


class Answers(NamedTuple):
    """Answers at operating points.

    Attributes:
        points: One row per oil and point, as the table of cage slip, with `best_oil`.
        shares: One row per oil, point and cause, with the range that was drawn: `range_low` and
            `range_high` in the unit of `CAUSES`, or the relative `standard_uncertainty`.
    """

    points: pd.DataFrame
    shares: pd.DataFrame


def operating_points(
    bearing: Bearing, load_n: FloatArray, speed_rpm: FloatArray, temperature_c: FloatArray
) -> pd.DataFrame:
    """Operating points as `answers` takes them; the arguments broadcast.

    Args:
        bearing: The bearing.
        load_n: Axial load.
        speed_rpm: Speed of the inner ring.
        temperature_c: Temperature of the oil at the inlet.
    """
    load, speed, temperature = np.broadcast_arrays(load_n, speed_rpm, temperature_c)
    return pd.DataFrame(
        {
            "axial_load_n": load.ravel(),
            "inner_speed_rpm": speed.ravel(),
            "pitch_speed_mm_rpm": speed.ravel() * bearing.pitch_diameter_m * MM_PER_M,
            "inlet_temperature_c": temperature.ravel(),
        }
    )


def answers(
    oils: Sequence[OilInBearing],
    bearing: Bearing,
    points: pd.DataFrame,
    settings: Settings,
    shares_of: str = "",
) -> Answers:
    """Torque, power loss, cage slip and best oil of each oil at each point, with their shares.

    Args:
        oils: The oils among which the best one is chosen.
        bearing: The bearing.
        points: Operating points of `operating_points`, each once.
        settings: `bearing`, `gates` and `seed`.
        shares_of: The oil of which shares of variance are wanted; by default all.
    """
    cases = Cases(bearing, [(oil, "stress", points) for oil in oils])
    terms, draws, drawing = cases.assessed(settings.seed)
    slip_limit = settings.bearing.cage_slip.slip_limit
    lambda_limit = settings.gates.lambda_limit
    terms = terms.assign(**best_shares(draws, len(oils), slip_limit, lambda_limit))
    best = best_oils(terms, slip_limit, lambda_limit)
    names = ["axial_load_n", "inner_speed_rpm", "inlet_temperature_c"]
    terms = terms.merge(best[[*names, "best_oil"]], on=names, how="left")
    is_wanted = (terms["oil"] == shares_of) if shares_of else terms["converged"]
    shares = drawing.shares(np.flatnonzero(is_wanted))
    keys = terms[["oil", "bearing", *names]]
    shares = shares.join(keys, on="point")
    law_errors = pd.Series(drawing.law_errors, drawing.which)
    return Answers(terms, _with_ranges(shares, law_errors, oils, bearing))


def _with_ranges(
    shares: pd.DataFrame,
    law_errors: "pd.Series[float]",
    oils: Sequence[OilInBearing],
    bearing: Bearing,
) -> pd.DataFrame:
    """Shares of variance with the range or the standard uncertainty that was drawn.

    Args:
        shares: Shares by oil, point and cause.
        law_errors: Relative standard error of the law's form, by the number of the point.
        oils: The oils.
        bearing: The bearing.
    """
    settings = oils[0].settings
    uncertain = {**bearing.uncertain, **settings.uncertain()}
    low = {name: CAUSES[name].scale * uncertain[name].low for name in INPUTS}
    high = {name: CAUSES[name].scale * uncertain[name].high for name in INPUTS}
    relative = {term: getattr(settings.term_uncertainty, term) for term in FACTOR_TERMS}
    standard = shares["cause"].map(relative).astype(float)
    is_law = shares["cause"] == "law"
    standard = standard.where(~is_law, shares["point"].map(law_errors))
    for oil in oils:
        of_oil = shares["oil"] == oil.name
        run_sd = np.nan_to_num(oil.laws["stress"].fitted.coefficients.run_sd)
        viscosity = settings.stand_in_uncertainty.viscosity * oil.oil.stand_in
        standard = standard.mask(of_oil & (shares["cause"] == "runs"), run_sd)
        standard = standard.mask(of_oil & (shares["cause"] == "viscosity"), viscosity)
    return shares.assign(
        range_low=shares["cause"].map(low).astype(float),
        range_high=shares["cause"].map(high).astype(float),
        standard_uncertainty=standard,
    )


def range_words(row: "pd.Series[float]") -> str:
    """The range of a row of `Answers.shares`, as `4 to 16 L/min` or `10 %`."""
    cause = CAUSES[str(row["cause"])]
    if np.isfinite(row["range_low"]):
        return f"{row['range_low']:.3g} to {row['range_high']:.3g} {cause.unit}".rstrip()
    if np.isfinite(row["standard_uncertainty"]):
        return f"{row['standard_uncertainty']:.2g} of it, one standard deviation"
    return "as stated in the rig's file"


def what_to_measure(shares: pd.DataFrame, column: str, least: float = 0.1) -> list[tuple[str, str]]:
    """The causes of the most variance, the largest first, and what would make each known.

    Args:
        shares: Rows of `Answers.shares`, of one point or of several.
        column: `torque_share` or `slip_share`; the median over the points counts.
        least: Smallest share that is named.
    """
    median = shares.groupby("cause")[column].median().sort_values(ascending=False)
    return [(str(cause), CAUSES[str(cause)].measure) for cause in median.index[median >= least]]
