"""The simulated campaign: the same bytes each time, and honest about what it is."""

from typing import Any
from unittest.mock import Mock

import numpy as np
import pytest

from campaigns import ROOT, Campaign, carry_logs, printed
from oilfilm.base.errors import OilfilmError
from oilfilm.bearing.ellipse import TractionLaw
from oilfilm.settings.resolve import resolve
from oilfilm.settings.resolved import Settings
from simulated_lab.plan import SimulatedRun
from simulated_lab.simulate import simulate_campaign, slip_programme
from simulated_lab.truth import TrueTraction, true_tractions, truth_misfit


def test_log_depends_on_seed_and_name_and_says_simulated(config: Settings, demo: Campaign) -> None:
    alone = config.with_changes({"campaign": {"oils": ["4010"]}})
    run, content, _ = next(simulate_campaign(alone, printed()))
    assert content == (demo.folder / run.name).read_bytes()
    assert content.startswith(b"# simulated: yes")
    _, other, _ = next(simulate_campaign(alone.with_changes({"seed": 1}), printed()))
    assert other != content


def test_near_pressures_give_logs_with_different_names() -> None:
    names = []
    for pressure_gpa in (1.2, 1.23, 1.234):
        names.append(SimulatedRun("4102", {"max_hertz_pressure_gpa": pressure_gpa}).name)
    assert names == ["4102_P1.20.csv", "4102_P1.23.csv", "4102_P1.234.csv"]


@pytest.mark.parametrize("loads_n", [(100000.0, 100000.5), (1234567.5, 1234567.25)])
def test_levels_that_differ_in_any_digit_give_logs_of_their_own(loads_n: tuple[float, ...]) -> None:
    names = {SimulatedRun("4102", {"axial_load_n": load_n}).name for load_n in loads_n}
    assert len(names) == 2


def test_slip_programme_visits_31_steps_between_two_rolling_phases(config: Settings) -> None:
    time_s, slip = slip_programme(config.campaign.twin)
    assert len(time_s) == round((2 * 3.0 + 31 * 2.4) * 50)
    assert np.abs(slip[:150]).max() == 0
    assert abs(slip[-1]) < 1e-6
    ends = slip[150 + 119 : 150 + 31 * 120 : 120]
    np.testing.assert_allclose(ends, np.linspace(0, 0.3, 31), atol=1e-6)
    assert slip.max() > 0.3  # it overshoots


@pytest.mark.parametrize(
    ("oil", "rig", "words"),
    [
        ("9999", {}, "no constants are printed for the oil '9999'"),
        ("4102", {"full_scale": None}, "lacks the key `full_scale`"),
        ("4102", {"ball_radius_m": None}, "needs a rig of known geometry"),
    ],
)
def test_campaign_that_the_twin_cannot_simulate_is_refused_in_words(
    config: Settings, oil: str, rig: dict[str, Any], words: str
) -> None:
    plain = config.with_changes({"campaign": {"oils": [oil]}}).plain_values()
    ((name, keys),) = plain["rigs"].items()
    settings = Settings.from_plain_values({**plain, "rigs": {name: {**keys, **rig}}})
    with pytest.raises(OilfilmError, match=words):
        next(simulate_campaign(settings, printed()))


@pytest.mark.slow
def test_cold_runs_of_the_thermal_campaign_are_accepted_without_printed_constants() -> None:
    # slip that rings after the sweep swings the force by no more than the bodies' creep lets it;
    # a film alone swung it by newtons, and the closing rolling phase looked like a drifting zero
    matrix = {"max_hertz_pressure_gpa": [1.5], "entrainment_speed_m_s": [25, 35, 40]}
    campaign = {"oils": ["4102"], "matrix": matrix | {"inlet_temperature_c": [25]}}
    thermal = resolve(ROOT / "config", {"campaign": "thermal"}).with_changes({"campaign": campaign})
    logs = [(run.name, content) for run, content, _ in simulate_campaign(thermal, {})]
    assert len(logs) >= 3
    carried = carry_logs(thermal, [log for log in logs if log[0].endswith("_T025.csv")])
    assert carried.curated.quarantine.empty


def test_printed_truth_is_the_printed_law(config: Settings) -> None:
    # reference condition of the law, S = 0.05: (A0 + B0 S) exp(-C0 S) - A0 by hand
    at = (np.array(part) for part in (1.0, 20.0, 20.0, 0.05))
    assert true_tractions(config, printed())["4102"](*at) == pytest.approx(0.020412, abs=5e-7)


@pytest.mark.parametrize(
    # a law of p_max and slip alone is its own mean; a mean of a film by two quadratures
    ("campaign", "largest"),
    [("demo", 0.0), ("thermal", 0.001)],
)
def test_one_truth_is_behind_both_rigs(campaign: str, largest: float) -> None:
    config = resolve(ROOT / "config", {"campaign": campaign})
    for oil, truth in true_tractions(config, printed()).items():
        assert truth_misfit(truth, config) <= largest, oil


def test_misfit_is_what_the_torque_rig_has_too_much(config: Settings) -> None:
    truth = true_tractions(config, printed())["4050"]
    law = truth.local_law

    def more(*contact: Any) -> TractionLaw:
        return lambda at, slip: 1.07 * law(*contact)(at, slip)

    planted = Mock(spec=TrueTraction, side_effect=truth, local_law=more)
    assert truth_misfit(planted, config) == pytest.approx(0.07, abs=1e-6)
