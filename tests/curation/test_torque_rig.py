"""Torque logs: planted torque comes back, the zero comes off, every format is read alike."""

import re

import numpy as np
import pandas as pd
import pytest

import formats
import torque_logs
from oilfilm.curation.curate import curate_logs
from oilfilm.curation.torque_rig import TorqueRig
from oilfilm.settings.resolved import Settings
from oilfilm.tables import failed_gates
from torque_logs import RATE_HZ, UNITS, by_quantity, signals, text


def measured(logs: list[tuple[str, bytes]], config: Settings) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Plateaus and quarantine, by no more settings than the rule `torque_runs` lists."""
    of_campaign = ("header", "oil_aliases", "torque")
    listed = config.plain_part("oils", "rigs", "torque_logs", "curation", campaign=of_campaign)
    curated = curate_logs(logs, Settings.from_plain_values(listed), TorqueRig)
    return curated.points, curated.quarantine


def test_planted_torque_is_measured_within_its_errors(config):
    runs, refused = measured([(f"{seed}.csv", text(signals(seed))) for seed in range(20)], config)
    assert refused.empty
    assert runs["accepted"].all()
    assert runs["tare_n_m"].to_numpy() == pytest.approx(0.3, abs=0.02)
    misses = (runs["torque_n_m"] - np.tile([2.0, 3.0, 5.0], 20)) / runs["torque_n_m_se"]
    assert 0.7 < misses.std() < 1.4  # 60 draws of a variable of standard deviation 1


def test_a_tare_that_moves_is_taken_along_a_straight_line(config):
    frame = signals()
    frame["torque_n_m"] += 0.04 * frame["time_s"] / frame["time_s"].iloc[-1]
    runs, _ = measured([("a.csv", text(frame))], config)
    assert runs["torque_n_m"].to_numpy() == pytest.approx([2, 3, 5], abs=0.03)
    assert runs["tare_n_m"].is_monotonic_increasing


def test_plateaus_are_kept_with_the_gate_that_refuses_them(config):
    frame = signals()
    frame["inner_speed_rpm"] *= -1
    runs, refused = measured([("a.csv", text(frame))], config)
    assert len(runs) == 3
    assert failed_gates.refusal_counts(runs)["turns_backwards"] == 3
    assert not runs["accepted"].any()
    assert refused["rule"].tolist() == ["turns_backwards"]


@pytest.mark.parametrize("rows", [43, 45])  # of the second level: none or one is left of it
def test_a_level_too_short_to_settle_is_listed_and_costs_no_other(config, rows):
    frame = signals()
    speed = frame["inner_speed_rpm"]
    brief = pd.concat([frame[speed < 4000].iloc[:280], frame[speed.between(5e3, 7e3)][:rows]])
    log = pd.concat([brief, frame[speed > 8000], frame.iloc[-120:]])
    log = log.assign(time_s=np.arange(len(log)) / RATE_HZ)
    runs, refused = measured([("a.csv", text(log))], config)
    assert runs.loc[runs["accepted"], "inner_speed_rpm"].round(-1).tolist() == [3000, 9000]
    (refusal,) = refused.to_dict("records")
    assert refusal["rule"] == "too_short"
    assert "6000 rpm" in refusal["reason"]
    assert re.search(r"2\.[123] s", refusal["reason"])


@pytest.mark.parametrize("stop_rows", [60, 160])
def test_torque_of_a_stop_in_the_middle_is_no_torque_of_a_speed(config, stop_rows):
    levels = np.repeat([0, 1, 2, 0, 3, 0], [120, 160, 160, stop_rows, 160, 120])
    torque = np.array([0.0, 2.0, 3.0, 5.0])[levels]
    # static friction holds 0.8 N m
    torque[440 : 440 + stop_rows] = 0.8
    runs, refused = measured(
        [("a.csv", text(torque_logs.signals_of(3000.0 * levels, torque, 1)))], config
    )
    assert refused.empty
    assert runs["inner_speed_rpm"].round(-1).tolist() == [3000, 6000, 9000]
    assert runs["accepted"].all()


@pytest.mark.parametrize("acceleration_rpm_s", [100, 1000])
def test_ramps_between_levels_are_no_part_of_them(config, acceleration_rpm_s):
    levels, held_s = [3000.0, 6000.0, 9000.0], 20
    speed = [np.zeros(8 * RATE_HZ)]
    for before, level in zip([0.0, *levels], [*levels, 0.0], strict=True):
        ramp = np.arange(before, level, np.sign(level - before) * acceleration_rpm_s / RATE_HZ)
        speed += [ramp, np.full(held_s * RATE_HZ if level else 8 * RATE_HZ, level)]
    speed = np.concatenate(speed)
    frame = torque_logs.signals_of(speed, speed / 3000, seed=5)
    runs, _ = measured([("a.csv", text(frame))], config)
    kept = runs[runs["accepted"]]
    np.testing.assert_allclose(kept["inner_speed_rpm"], levels, rtol=1e-3)
    np.testing.assert_allclose(kept["torque_n_m"], [1, 2, 3], atol=0.02)


@pytest.mark.slow
@pytest.mark.parametrize("name", formats.WRITERS)
def test_columns_with_names_of_their_own_are_found_in_any_format(config, name):
    values = by_quantity(signals())
    expected, _ = measured([("a", formats.csv(values, UNITS, {"oil": "4050"}))], config)
    values["M_R"], values["Zeit"] = values.pop("torque") * 1e3, values["time"]
    columns = {"torque": {"name": "M_R", "unit": "N mm"}}
    if name == "csv":  # there with the unit in brackets behind the name
        values.pop("time")
        columns["time"] = {"name": "Zeit"}
    own = config.with_changes({"campaign": {"torque": {"columns": columns}}})
    units = {**UNITS, "M_R": "N mm", "Zeit": "s"}
    runs, refused = measured([("a", formats.WRITERS[name](values, units, {"oil": "4050"}))], own)
    assert refused.empty
    np.testing.assert_allclose(runs["torque_n_m"], expected["torque_n_m"], rtol=1e-9)


def test_refused_torque_run_is_listed_with_its_oil(config):
    plateaus, refused = measured([("short.csv", text(signals()[:100]))], config)
    assert plateaus.empty
    assert set(refused["oil"]) == {"4050"}
