"""The drag fitted to published tests of bearings, and the setting that comes from it."""

import numpy as np
import pytest

from bearings import RPM, equilibrium
from campaigns import ROOT, printed
from deng2026_study.published_tests import published_tests_table
from deng2026_study.reference import PublishedBearingTests
from oilfilm.bearing.ellipse import gauss_rule
from oilfilm.bearing.quasistatic import OperatingPoints
from oilfilm.settings.messages import load
from oilfilm.settings.resolve import resolve
from oilfilm.settings.resolved import Settings
from oilfilm.torque.bearing_torque import OilInBearing, oils_in_bearings
from planted_fits import printed_fits
from simulated_lab.truth import true_tractions

PUBLISHED = load(
    ROOT / "workflow/deng2026_study/reference/bearing_tests.yaml", PublishedBearingTests
)
POWER_LOSS = PUBLISHED.tests[0]


@pytest.fixture(scope="module")
def config() -> Settings:
    return resolve(ROOT / "config", {})


@pytest.fixture(scope="module")
def oils(config: Settings) -> list[OilInBearing]:
    """The oils with the printed law: the setting must not depend on a campaign."""
    return oils_in_bearings(*printed_fits(), config)


def squares(config: Settings, share: float) -> float:
    """Of the relative errors of the power losses with a share of oil."""
    settings = config.with_changes({"bearing": {"oil_volume_fraction": share}})
    oils = oils_in_bearings(*printed_fits(), settings)
    table = published_tests_table(PUBLISHED, oils, settings)
    return float(((table["power_w"] / table["published_power_w"] - 1) ** 2).sum())


def test_the_drag_that_is_set_is_that_of_the_fit_with_the_printed_law(config, oils):
    table = published_tests_table(PUBLISHED, oils, config)
    losses = table[table["bearing"] == "nasa-35"]
    # docs/physics.md, Bearing; the setting has two digits of the fit
    assert losses["published_power_w"].tolist() == [350, 700, 1100, 1400]
    # the highest share of its range fits the slowest speed alone
    of_highest = losses["power_high_w"] / losses["published_power_w"]
    assert of_highest.iloc[0] == of_highest.min() == pytest.approx(1, rel=0.02)
    share = config.bearing.oil_volume_fraction
    least, *others = (squares(config, factor * share) for factor in (1.0, 0.96, 1.04))
    assert least < min(others)


@pytest.mark.nightly
def test_the_lowest_drag_left_open_is_that_of_the_fit_with_another_traction(config):
    # the film of the campaign `thermal` in place of a law
    thermal = resolve(ROOT / "config", {"campaign": "thermal"})
    bearing, nodes = config.bearings["nasa-35"].bearing("nasa-35"), (8, 2)
    film = true_tractions(thermal, printed())["4050"]
    law = film.at_points(gauss_rule(*nodes), bearing.radius_y_m[:, np.newaxis])
    speed, power = np.array([[row.inner_speed_rpm, row.power_w] for row in POWER_LOSS.rows]).T
    points = OperatingPoints.axial(667.0, speed * RPM)
    lowest = config.bearing.oil_volume_fraction_range[0]
    shares, squares = lowest * np.array([0.5, 1.0, 1.5]), []
    for share in shares:
        degc, some = POWER_LOSS.inlet_temperature_c, {"oil_volume_fraction": share}
        found = equilibrium(bearing, points, "4050", degc, law, nodes, **some)
        heat = bearing.ball_count * np.sum(found.balance.heats_w, axis=0)
        squares.append(np.sum((heat / power - 1) ** 2))
    bend, slope, _ = np.polyfit(shares, squares, 2)
    # vertex of a parabola, on few nodes of the ellipse
    assert lowest == pytest.approx(-slope / (2 * bend), rel=0.15)


def test_the_second_anchor_states_what_it_assumes(config, oils):
    table = published_tests_table(PUBLISHED, oils, config)
    skids = table[table["bearing"] == "nasa-120"]
    # NASA TN D-7870, abstract: at most 6 % of all loads, thrust to 22 240 N, 25 000 rpm
    assert set(skids["published_cage_slip"]) == {0.06}
    assert skids["axial_load_n"].max() == 22240
    assert skids["assumed"].str.startswith("whole geometry").all()
    assert "ball_diameter_m" in config.bearings["nasa-120"].assumed
    assert (np.diff(skids["cage_slip"]) < 0).all()  # more load, less slip
    assert (skids["cage_slip_low"] < skids["cage_slip_high"]).all()
