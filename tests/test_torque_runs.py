"""Torque logs: the tare comes off, planted torque comes back, and what is wrong is refused."""

from typing import Any

import numpy as np
import pandas as pd
import pytest

from campaigns import ROOT
from oilfilm.bearing.torque_runs import measure_torque
from oilfilm.config import resolve

RATE = 20
NAMES = (
    "time_s",
    "axial_load_n",
    "inner_speed_rpm",
    "oil_temperature_c",
    "outer_ring_temperature_c",
    "torque_n_m",
)


@pytest.fixture(scope="module")
def config() -> dict[str, Any]:
    return resolve(ROOT / "config", {})


def signals(seed: int = 1, levels: tuple[float, ...] = (2.0, 3.0, 5.0)) -> pd.DataFrame:
    """Rest, three speeds of known torque, rest; a tare of 0.3 N m, noise of 0.05 N m."""
    random = np.random.default_rng(seed)
    speed = np.concatenate([np.zeros(120), np.repeat([3000.0, 6000.0, 9000.0], 160), np.zeros(120)])
    torque = np.concatenate([np.zeros(120), np.repeat(levels, 160), np.zeros(120)])
    count = len(speed)
    return pd.DataFrame(
        {
            "time_s": np.arange(count) / RATE,
            "axial_load_n": 10000 + 5 * random.standard_normal(count),
            "inner_speed_rpm": speed + np.where(speed > 0, random.standard_normal(count), 0),
            "oil_temperature_c": 100 + 0.1 * random.standard_normal(count),
            "outer_ring_temperature_c": 110 + 0.1 * random.standard_normal(count),
            "torque_n_m": torque + 0.3 + 0.05 * random.standard_normal(count),
        }
    ).round(4)


def log(frame: pd.DataFrame, header: str = "# oil: 4050\n") -> bytes:
    return header.encode() + frame.to_csv(index=False, lineterminator="\n").encode()


def test_planted_torque_is_measured_within_its_errors(config):
    misses = []
    for seed in range(20):
        runs, refused = measure_torque([("a.csv", log(signals(seed)))], config)
        assert refused.empty
        assert runs["accepted"].all()
        misses.append((runs["torque_n_m"] - [2.0, 3.0, 5.0]) / runs["torque_n_m_se"])
        assert runs["tare_n_m"].to_numpy() == pytest.approx(0.3, abs=0.02)
    spread = np.concatenate(misses).std()
    assert 0.7 < spread < 1.4  # 60 draws of a variable of standard deviation 1


def test_a_tare_that_moves_is_taken_along_a_straight_line(config):
    frame = signals()
    frame["torque_n_m"] += 0.04 * frame["time_s"] / frame["time_s"].iloc[-1]
    runs, _ = measure_torque([("a.csv", log(frame))], config)
    assert runs["torque_n_m"].to_numpy() == pytest.approx([2, 3, 5], abs=0.03)
    assert runs["tare_n_m"].is_monotonic_increasing


def test_other_units_and_dialects_read_the_same(config):
    frame = signals()
    other = pd.DataFrame(
        {
            "time [min]": frame["time_s"] / 60,
            "axial load [kN]": frame["axial_load_n"] / 1e3,
            "inner speed [rad/s]": frame["inner_speed_rpm"] * np.pi / 30,
            "oil temperature [K]": frame["oil_temperature_c"] + 273.15,
            "outer ring temperature [degF]": frame["outer_ring_temperature_c"] * 1.8 + 32,
            "torque [N mm]": frame["torque_n_m"] * 1e3,
        }
    )
    text = "oil = 4050\r\n" + other.to_csv(
        index=False, sep=";", decimal=",", lineterminator="\r\n", float_format="%.9f"
    )
    plain, _ = measure_torque([("a.csv", log(frame))], config)
    converted, refused = measure_torque([("a.csv", text.encode("utf-16"))], config)
    assert refused.empty
    for name in ("axial_load_n", "inner_speed_rpm", "oil_temperature_c", "torque_n_m"):
        np.testing.assert_allclose(converted[name], plain[name], rtol=1e-6)


def moved_tare(frame: pd.DataFrame) -> pd.DataFrame:
    return frame.assign(torque_n_m=frame["torque_n_m"] + 0.01 * frame["time_s"])


@pytest.mark.parametrize(
    ("content", "rule", "words"),
    [
        (log(moved_tare(signals())), "tare", "the tare moves by 0."),
        (log(signals().iloc[110:]), "tare", "of the opening phase are at rest"),
        (log(signals().iloc[:-110]), "tare", "of the closing phase are at rest"),
        (log(signals().iloc[:120]), "tare", "never turns"),
        (log(signals().assign(time_s=1.0)), "time_disorder", "does not go on"),
        (log(signals(), "# oil: 9999\n"), "unknown_oil", "4102, 4050, 4010"),
        (log(signals(), ""), "header", "no line `# oil"),
        (log(signals(), "# oil: 4050\n# bearing: other\n"), "other_bearing", "mainshaft-167"),
        (log(signals().drop(columns="torque_n_m")), "columns", "lacks the columns torque"),
        (log(signals().rename(columns={"torque_n_m": "torque [N]"})), "columns", "'torque [N]'"),
        (b"\x00\x01 rubbish", "columns", "columns of a torque log"),
        (b"\x1f\x8brubbish", "damaged_archive", "cannot be unpacked"),
        (log(signals())[:-200], "truncated", "in the middle of row"),
    ],
)
def test_a_log_that_cannot_be_used_is_refused_in_words(config, content, rule, words):
    runs, refused = measure_torque([("bad.csv", content), ("good.csv", log(signals()))], config)
    assert set(runs["run_id"]) == {"good.csv"}
    of_rule = refused[refused["rule"] == rule]
    assert len(of_rule) == 1
    assert words in of_rule["reason"].iloc[0]
    assert of_rule["advice"].iloc[0]


def test_simulated_logs_stay_out_of_measured_campaigns(config):
    measured = {**config, "campaign": {**config["campaign"], "data": "measured"}}
    content = log(signals(), "# oil: 4050\n# simulated: yes\n")
    runs, refused = measure_torque([("a.csv", content)], measured)
    assert runs.empty
    assert list(refused["rule"]) == ["simulated_log"]


@pytest.mark.parametrize(
    ("change", "gate"),
    [
        (
            {"torque_n_m": lambda f: f["torque_n_m"] * (1 - 0.02 * (f["time_s"] % 8))},
            "torque_drifts",
        ),
        ({"torque_n_m": lambda f: 0.6 - f["torque_n_m"]}, "torque_not_positive"),
        ({"oil_temperature_c": lambda f: 60 + f["time_s"]}, "temperature_drifts"),
        ({"axial_load_n": lambda f: -f["axial_load_n"]}, "unloaded"),
    ],
)
def test_an_unsteady_or_impossible_plateau_is_kept_with_its_reason(config, change, gate):
    runs, _ = measure_torque([("a.csv", log(signals().assign(**change)))], config)
    assert len(runs) == 3
    assert runs["reasons"].str.contains(gate).any()
    assert not runs[runs["reasons"].str.contains(gate)]["accepted"].any()


def test_a_damaged_row_is_refused_by_its_number_and_the_rest_is_used(config):
    lines = log(signals()).split(b"\n")
    lines[200] = b"oops"
    runs, refused = measure_torque([("a.csv", b"\n".join(lines))], config)
    assert len(runs) == 3
    assert refused["rule"].tolist() == ["unreadable_row"]
    assert refused["first_row"].tolist() == [199]


def test_no_logs_give_empty_tables(config):
    runs, refused = measure_torque([], config)
    assert runs.empty
    assert refused.empty
