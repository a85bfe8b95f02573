"""How firm the choice of oil by cage slip is: drag and law anywhere within their uncertainty.

Each scenario has one oil volume fraction (`bearing.oil_volume_fraction_range`) and one refit of the
law of each oil. The advice is worked out again in every scenario.

Decides: how firm the advice on oils is.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
import pandas as pd

from oilfilm import tables
from oilfilm.fits.fitted import FittedLaw
from oilfilm.paper.selection import OUTSIDE
from oilfilm.paper.slip_advice import advise
from oilfilm.settings.resolved import Settings
from oilfilm.torque.bearing_torque import OilInBearing
from oilfilm.units import FloatArray

_POINT = ["pitch_speed_mm_rpm", "axial_load_n"]
_SCENARIO = ["oil_volume_fraction", "refit"]
_SHARES = ["agree_share", "best_oil_share", "best_oils"]
# Without a choice there is nothing that scenarios could disagree about.
_NO_CHOICE = ("no film", OUTSIDE)


def advice_in_band(
    oils: Sequence[OilInBearing],
    coefficients: pd.DataFrame,
    refits: pd.DataFrame,
    cage_slip: pd.DataFrame,
    settings: Settings,
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """The advice at each operating point with its shares of scenarios, and each scenario's count.

    Args:
        oils: Oils with their laws.
        coefficients: Table of coefficients.
        refits: Table of refits.
        cage_slip: Table of cage slip, the nominal scenario.
        settings: `bearing`, `gates` and `selection`, and the campaign's bearing.

    Returns:
        The tables `slip_advice` and `advice_band`; empty where the rules name an oil that has no
        law.
    """
    choice, lambda_limit = settings.selection, settings.gates.lambda_limit
    nominal = advise(cage_slip, choice, lambda_limit)
    if nominal.empty:
        return nominal, tables.empty("advice_band")
    spread = {
        oil.name: FittedLaw.of(
            coefficients, oil.name, refits, law=oil.laws["stress"].fitted.law
        ).coefficients.spread[: choice.band.refits]
        for oil in oils
    }
    slips = pd.concat(_scenarios(oils, spread, cage_slip, settings), ignore_index=True)
    scenarios = [
        advise(of_scenario, choice, lambda_limit).assign(
            oil_volume_fraction=of_scenario["oil_volume_fraction"].iloc[0],
            refit=of_scenario["refit"].iloc[0],
        )
        for _, of_scenario in slips.groupby(_SCENARIO, sort=False)
    ]
    advice = pd.concat(scenarios, ignore_index=True)
    return _with_shares(nominal, advice), _by_scenario(advice)


def _scenarios(
    oils: Sequence[OilInBearing],
    spread: dict[str, FloatArray],
    cage_slip: pd.DataFrame,
    settings: Settings,
) -> Iterator[pd.DataFrame]:
    """Cage slip of each oil in every scenario; refit 0 is the fit itself."""
    bearing, band = settings.tested_bearing(), settings.bearing
    low, high = band.oil_volume_fraction_range
    levels = settings.selection.band.oil_volume_fractions
    fractions = np.union1d(np.geomspace(low, high, levels), band.oil_volume_fraction)
    # in every scenario each oil has a refit of its own: they were measured apart
    count = min(len(rows) for rows in spread.values())
    refits = np.arange(count + 1)
    for oil in oils:
        at = cage_slip[cage_slip["oil"] == oil.name]
        own = oil.laws["stress"].constants
        constants = np.vstack([own, spread[oil.name][:count]])
        points = at[["axial_load_n", "inner_speed_rpm", "inlet_temperature_c"]].to_numpy()
        load, speed, temperature = np.tile(points, (len(refits), 1)).T
        for fraction in fractions:
            drag = band.model_copy(update={"oil_volume_fraction": float(fraction)})
            drawn = replace(oil, settings=drag).with_constants(
                np.repeat(constants, len(at), axis=0)
            )
            yield drawn.run(bearing, load, speed, temperature).assign(
                pitch_speed_mm_rpm=np.tile(at["pitch_speed_mm_rpm"], len(refits)),
                oil_volume_fraction=fraction,
                refit=np.repeat(refits, len(at)),
            )


def _with_shares(nominal: pd.DataFrame, advice: pd.DataFrame) -> pd.DataFrame:
    """The nominal advice with the shares of scenarios in which it and its best oil are good."""
    chosen = advice[~advice["judgement"].isin(_NO_CHOICE)]
    best = nominal.set_index(_POINT)["best_oil"]
    shares = pd.DataFrame(index=best.index)
    if len(chosen):
        expected = best.loc[pd.MultiIndex.from_frame(chosen[_POINT])]
        good = [
            oil in oils.split("; ") for oil, oils in zip(expected, chosen["good_oils"], strict=True)
        ]
        by_point = chosen.assign(agree=chosen["judgement"] == "agree", good=good).groupby(_POINT)
        shares["agree_share"] = by_point["agree"].mean()
        shares["best_oil_share"] = by_point["good"].mean().where(best != "")
        shares["best_oils"] = by_point["best_oil"].agg(lambda oils: "; ".join(sorted(set(oils))))
    shares = shares.reindex(columns=_SHARES).fillna({"best_oils": ""})
    frame = nominal.drop(columns=_SHARES).join(shares, on=_POINT)
    return tables.conform(frame[tables.columns("slip_advice")], "slip_advice", "slip advice")


def _by_scenario(advice: pd.DataFrame) -> pd.DataFrame:
    """How many operating points of each scenario have a choice, and at how many it agrees."""
    counted = advice.assign(
        operating_points=~advice["judgement"].isin(_NO_CHOICE),
        agreeing_points=advice["judgement"] == "agree",
    )
    counts = counted.groupby(_SCENARIO)[["operating_points", "agreeing_points"]].sum()
    frame = counts.reset_index().assign(bearing=advice["bearing"].iloc[0])
    return tables.conform(frame[tables.columns("advice_band")], "advice_band", "advice band")
