"""Numbers that are just at a limit of curation: rounding decides nothing."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest

from oilfilm.curation.measure import find_steps
from oilfilm.curation.plateau_gates import PLATEAU_GATES
from oilfilm.curation.rig_kind import Signals
from oilfilm.curation.run_gates import clock_jump, temperature_drift
from oilfilm.settings.resolved import Settings

GATES = {gate.name: gate.judge for gate in PLATEAU_GATES}
# Starts of a clock, in s, at which differences of its time stamps have other last digits.
CLOCKS = (0.0, 0.1, 7.3, 1234.5, 86399.7)


def rig_of(config: Settings, **others: Any) -> Any:
    return SimpleNamespace(
        gate_limits=config.gates, plateau_settings=config.curation.plateaus, **others
    )


@pytest.mark.parametrize("side", [-1, 1])
def test_readings_just_at_a_tolerance_of_their_set_point_pass(config: Settings, side: int) -> None:
    # in decimal digits, as a rig writes them; their differences are off by rounding to either side
    nominal = {
        "load_n": np.array([10.0, 24.3, 47.7, 82.3]),
        "entrainment_speed_m_s": np.array([25.0, 30.0, 35.0, 40.0]),
        "inlet_temperature_c": np.array([25.3, 50.1, 70.7, 120.9]),
    }
    share = {"load_n": 0.03, "entrainment_speed_m_s": 0.02, "inlet_temperature_c": 0.0}
    absolute = {"load_n": 0.0, "entrainment_speed_m_s": 0.0, "inlet_temperature_c": 2.0}
    points = pd.DataFrame({f"nominal_{name}": values for name, values in nominal.items()})
    for name, values in nominal.items():
        points[name] = np.round(values + side * (share[name] * values + absolute[name]), 6)
    points = points.assign(run_id=["a", "b", "c", "d"], slide_roll_ratio=0.05, direction=1.0)
    planned = np.arange(1, 31) / 100
    rig = rig_of(config, planned_slips=planned.tolist())
    for name in ("load", "speed", "temperature"):
        assert not np.any(GATES[f"{name}_off_nominal"](points, rig))
    slips = pd.DataFrame({"slide_roll_ratio": np.round(planned + side * 0.003, 6)})
    assert not np.any(GATES["slip_off_set_point"](slips, rig))
    beyond = slips + side * 1e-5
    assert np.all(GATES["slip_off_set_point"](beyond, rig))


@pytest.mark.parametrize("rate_hz", [5, 8, 20, 30, 50, 128])
def test_a_clock_that_starts_at_another_time_cuts_off_as_many_rows(rate_hz: int) -> None:
    intervals = set()
    for start in CLOCKS:
        time_s = start + np.arange(100) / rate_hz
        intervals.add(Signals(np.arange(100), time_s, {}).interval_s)
    assert len(intervals) == 1
    assert intervals.pop() == pytest.approx(1 / rate_hz, rel=1e-8)


@pytest.mark.parametrize("start", CLOCKS)
@pytest.mark.parametrize(("gap", "refused"), [(10, False), (11, True)])
def test_a_gap_of_just_the_longest_length_is_no_jump_of_the_clock(
    config: Settings, start: float, gap: int, refused: bool
) -> None:
    number = np.concatenate([np.arange(50), 49 + gap + np.arange(50)])
    run: Any = SimpleNamespace(signals=Signals(np.arange(100), start + number / 50, {}))
    assert bool([*clock_jump(run, rig_of(config))]) == refused


@pytest.mark.parametrize("level_c", [25.3, 70.1, 119.9])
def test_a_temperature_that_drifts_by_just_the_limit_passes(
    config: Settings, level_c: float
) -> None:
    levels = np.array([level_c, round(level_c + 2.0, 6)])
    run: Any = SimpleNamespace(plateaus={"inlet_temperature_c": levels})
    assert not [*temperature_drift(run, rig_of(config))]


@pytest.mark.parametrize("offset", [0.0, 1.0, 7.7, 1e3])
def test_a_step_of_which_two_rows_are_the_middle_is_at_the_first_of_them(
    config: Settings, offset: float
) -> None:
    # a ramp over two rows between two levels without noise: both differences are equally large
    level = offset + np.concatenate([np.zeros(100), [0.1, 0.2], np.full(100, 0.3)])
    steps = find_steps(level, 0.02, 0.004, config.curation.plateaus)
    assert steps.tolist() == [101]
