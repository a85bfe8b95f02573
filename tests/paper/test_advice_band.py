"""The choice of oil by cage slip, with drag and law within their uncertainty."""

import numpy as np
import pandas as pd
import pytest

from bearings import printed_fits
from campaigns import ROOT
from oilfilm.paper.advice_band import advice_in_band
from oilfilm.paper.slip_advice import advise
from oilfilm.settings.resolve import resolve
from oilfilm.settings.resolved import Settings
from oilfilm.torque.bearing_torque import cage_slip_table, oils_in_bearings

Frames = tuple[pd.DataFrame, pd.DataFrame]
MORE_OIL = 0.03


@pytest.fixture(scope="module")
def config() -> Settings:
    small = {
        "cage_slip": {"pitch_speed_mm_rpm": [1e6, 3e6], "axial_load_n": [2000, 8000, 30000]},
        "oil_volume_fraction": 0.004,
        "oil_volume_fraction_range": [0.004, MORE_OIL],
    }
    band = {"oil_volume_fractions": 2, "refits": 1}
    changes = {"bearing": small, "selection": {"band": band}}
    return resolve(ROOT / "config", {"campaign": "demo"}).with_changes(changes)


def refits_of(coefficients: pd.DataFrame, *factors: float) -> pd.DataFrame:
    """Refits with A0 and B0, which is all traction, times these factors."""
    scaled = coefficients["constant"].isin(["A0", "B0"])
    return pd.concat(
        [
            coefficients[["oil", "law", "constant"]].assign(
                cause="resampled curves",
                refit=number,
                value=coefficients["value"] * np.where(scaled, factor, 1.0),
            )
            for number, factor in enumerate(factors)
        ]
    )


def in_band(config: Settings, *factors: float) -> Frames:
    coefficients, quality = printed_fits()
    oils = oils_in_bearings(coefficients, quality, config)
    slip = cage_slip_table(oils, config)
    return advice_in_band(oils, coefficients, refits_of(coefficients, *factors), slip, config)


@pytest.fixture(scope="module")
def tables_in_band(config: Settings) -> Frames:
    return in_band(config, 0.7)


def alone(config: Settings, fraction: float, factor: float) -> pd.DataFrame:
    """The advice with this drag and with all traction times a factor, worked out by itself."""
    changed = config.with_changes({"bearing": {"oil_volume_fraction": fraction}})
    coefficients, quality = printed_fits()
    scaled = coefficients["constant"].isin(["A0", "B0"])
    value = coefficients["value"] * np.where(scaled, factor, 1.0)
    oils = oils_in_bearings(coefficients.assign(value=value), quality, changed)
    slip = cage_slip_table(oils, changed)
    return advise(slip, changed.selection, changed.gates.lambda_limit)


@pytest.mark.no_cover
def test_each_scenario_is_that_of_the_bearing_by_itself(
    config: Settings, tables_in_band: Frames
) -> None:
    advice, band = tables_in_band
    band = band.set_index(["oil_volume_fraction", "refit"])["agreeing_points"]
    scenarios = {
        (fraction, refit): alone(config, fraction, factor)
        for fraction in (0.004, MORE_OIL)
        for refit, factor in enumerate((1.0, 0.7))
    }
    assert len(band) == len(scenarios)
    for scenario, expected in scenarios.items():
        assert band[scenario] == (expected["judgement"] == "agree").sum()
    point = ["pitch_speed_mm_rpm", "axial_load_n"]
    agree = (
        pd.concat(scenarios.values())
        .groupby(point)["judgement"]
        .agg(lambda verdicts: (verdicts == "agree").mean())
    )
    np.testing.assert_allclose(advice.set_index(point)["agree_share"], agree.loc[:])
    # more oil about, and less traction: somewhere another oil is best
    assert band.nunique() > 1
    assert (advice["best_oil_share"] < 1).any()
    uncertain = advice[advice["best_oil_share"] < 1]
    assert (uncertain["best_oils"].str.count(";") > 0).all()


def test_scenarios_that_are_alike_leave_every_choice_certain(config: Settings) -> None:
    narrow = {"oil_volume_fraction_range": [0.004, 0.004 * (1 + 1e-9)]}
    advice, band = in_band(config.with_changes({"bearing": narrow}), 1.0)
    assert (advice["best_oil_share"] == 1).all()
    assert set(advice["agree_share"]) <= {0.0, 1.0}
    assert (band["agreeing_points"] == advice["agree_share"].sum()).all()


def test_without_an_oil_of_the_rules_there_is_no_band(config: Settings) -> None:
    coefficients, quality = printed_fits()
    oils = [oil for oil in oils_in_bearings(coefficients, quality, config) if oil.name == "4050"]
    slip = cage_slip_table(oils, config)
    advice, band = advice_in_band(oils, coefficients, refits_of(coefficients, 1.0), slip, config)
    assert advice.empty
    assert band.empty
