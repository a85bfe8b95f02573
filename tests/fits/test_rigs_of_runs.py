"""Rigs of runs: from tables of points and runs to the answer on a rig, and back from the tables."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from fit_points import LAW, make_points, matrix
from oilfilm import tables
from oilfilm.cli.predict import prediction
from oilfilm.fits.fit import fit_oil
from oilfilm.fits.fitted import FittedLaw, read_surface
from oilfilm.fits.measured_surface import ANOTHER_RIG_NAME
from oilfilm.fits.surface_search import with_surface
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables

OIL = "4050"
RIGS = ("alpha", "beta", "gamma")
GAINS = {"alpha": 1.03, "beta": 1.0, "gamma": 0.97}
AT = {
    "max_hertz_pressure_gpa": 1.25,
    "entrainment_speed_m_s": 30.0,
    "inlet_temperature_c": 70.0,
    "slide_roll_ratio": 0.05,
}


def fitted_to(found: CampaignTables, runs: pd.DataFrame | None, config: Settings) -> FittedLaw:
    """The fit of a law with the surface, read from its tables as a finished campaign is."""
    if runs is not None:
        found = found.replace(runs=runs)
    found = with_surface(found, OIL, config)
    written = {name: tables.conform(found.table(name), name, name) for name in ("surfaces",)}
    found = found.replace(**written)
    fit = FittedLaw.from_tables(
        found.coefficients, OIL, found.refits, found.fit_quality, LAW, found.curve_residuals
    )
    return replace(fit, read_surface=lambda: read_surface(found, OIL))


@pytest.fixture(scope="module")
def points() -> pd.DataFrame:
    """24 runs on three rigs that take turns, with a gain each."""
    points = make_points(OIL, matrix([1.0, 1.25, 1.5], [25.0, 40.0], [25.0, 50.0, 85.0, 120.0]))
    random = np.random.default_rng(5)
    gain = 1 + 0.005 * random.standard_normal(24)
    run = points["run_id"].str[3:].astype(int)
    gain_of_rig = run.mod(3).map(lambda number: GAINS[RIGS[number]])
    mu = points["traction_coefficient"] * gain[run] * gain_of_rig
    return points.assign(traction_coefficient=mu, traction_coefficient_se=1e-5)


@pytest.fixture(scope="module")
def of_law(points: pd.DataFrame, config: Settings) -> CampaignTables:
    """The fit of the law, which knows no rigs."""
    settings = config.fit.model_copy(update={"searches": 2, "bootstrap": 40})
    return fit_oil(points, OIL, settings, 1, LAW).replace(points=points)


@pytest.fixture(scope="module")
def runs(points: pd.DataFrame) -> pd.DataFrame:
    """The rig of each run, from the last run to the first."""
    names = points["run_id"].unique()[::-1]
    rig = [RIGS[int(name[3:]) % 3] for name in names]
    return pd.DataFrame({"run_id": names, "rig": rig, "oil": OIL, "verdict": "accepted"})


@pytest.fixture(scope="module")
def fit(of_law: CampaignTables, runs: pd.DataFrame, config: Settings) -> FittedLaw:
    return fitted_to(of_law, runs, config)


def half_width(fit: FittedLaw, rig: str | None = None) -> float:
    """Half width of the interval of the next run, relative."""
    row, _ = prediction(fit, OIL, AT, rig)
    return float(np.log(row["obs_ci_upper"] / row["obs_ci_lower"]) / 2)


@pytest.mark.slow
def test_each_rig_has_its_own_answer(fit: FittedLaw) -> None:
    middle = {}
    for rig in RIGS:
        row, sentences = prediction(fit, OIL, AT, rig)
        middle[rig] = np.sqrt(row["obs_ci_lower"] * row["obs_ci_upper"])
        assert any(rig in sentence for sentence in sentences)
    # planted 1.03 and 0.97; eight runs of a rig scatter by 0.5 % each
    assert middle["alpha"] / middle["beta"] == pytest.approx(1.03, abs=0.008)
    assert middle["gamma"] / middle["beta"] == pytest.approx(0.97, abs=0.008)


@pytest.mark.slow
def test_another_rig_is_less_known_than_one_of_these(fit: FittedLaw) -> None:
    assert half_width(fit, "alpha") < half_width(fit) < half_width(fit, ANOTHER_RIG_NAME)


@pytest.mark.slow
def test_runs_whose_rigs_are_not_named_are_those_of_one_rig(
    of_law: CampaignTables, fit: FittedLaw, config: Settings
) -> None:
    unnamed = fitted_to(of_law, None, config)
    assert unnamed.surface is not None and unnamed.surface.rig_names == ()
    assert half_width(unnamed) > half_width(fit, "beta")
    with pytest.raises(Exception, match="Leave the rig out"):
        prediction(unnamed, OIL, AT, ANOTHER_RIG_NAME)


@pytest.mark.slow
def test_an_unknown_rig_is_refused_with_those_that_are_known(fit: FittedLaw) -> None:
    with pytest.raises(Exception, match="alpha, beta, gamma"):
        prediction(fit, OIL, AT, "delta")


@pytest.mark.slow
def test_the_rig_of_a_refused_run_is_not_needed(
    of_law: CampaignTables, runs: pd.DataFrame, fit: FittedLaw, config: Settings
) -> None:
    refused = {"run_id": "other", "rig": "delta", "oil": OIL, "verdict": "refused"}
    other = fitted_to(of_law, pd.concat([runs, pd.DataFrame([refused])]), config)
    assert other.surface is not None and other.surface.rig_names == RIGS
    assert half_width(other, "beta") == half_width(fit, "beta")
