"""Torque logs: the tare comes off, planted torque comes back, and what is wrong is refused."""

import gzip
import re
from collections.abc import Callable
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as arrow
import pytest

import formats
from campaigns import ROOT
from mutations import mutate
from oilfilm.curation.torque_runs import measure_torque
from oilfilm.randomness import generator
from oilfilm.readers import READERS
from oilfilm.settings.load import resolve

RATE = 20
BEARING = "mainshaft-167"
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


def stuck(frame: pd.DataFrame) -> pd.DataFrame:
    return frame.assign(torque_n_m=frame["torque_n_m"].where(frame["inner_speed_rpm"] < 5000, 3.25))


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
        (b"\x00\x01 rubbish", "unknown_format", "no reader knows this content"),
        (b"a,b,c,d\n1,2,3,4\n", "columns", "columns of a torque log"),
        (log(stuck(signals())), "stuck_sensor", "stays at exactly 3.25 N m"),
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
        ({"inner_speed_rpm": lambda f: -f["inner_speed_rpm"]}, "turns_backwards"),
    ],
)
def test_an_unsteady_or_impossible_plateau_is_kept_with_its_reason(config, change, gate):
    runs, _ = measure_torque([("a.csv", log(signals().assign(**change)))], config)
    assert len(runs) == 3
    assert runs["failed_gates"].str.contains(gate).any()
    assert not runs[runs["failed_gates"].str.contains(gate)]["accepted"].any()


@pytest.mark.parametrize("rows", [43, 45])  # of the second level: none or one is left of it
def test_a_level_too_short_to_settle_is_listed_and_costs_no_other(config, rows):
    frame = signals()
    speed = frame["inner_speed_rpm"]
    brief = pd.concat([frame[speed < 4000].iloc[:280], frame[speed.between(5e3, 7e3)][:rows]])
    whole = pd.concat([brief, frame[speed > 8000], frame.iloc[-120:]])
    whole = whole.assign(time_s=np.arange(len(whole)) / RATE)
    runs, refused = measure_torque([("a.csv", log(whole))], config)
    assert runs.loc[runs["accepted"], "inner_speed_rpm"].round(-1).tolist() == [3000, 9000]
    (found,) = refused.to_dict("records")
    assert found["rule"] == "too_short"
    assert re.search(r"the speed of about 6000 rpm was held for 2\.[123] s", found["reason"])


@pytest.mark.parametrize("acceleration_rpm_s", [100, 1000])
def test_ramps_between_levels_are_no_part_of_them(config, acceleration_rpm_s):
    random = np.random.default_rng(5)
    levels, held_s = [3000.0, 6000.0, 9000.0], 20
    speed = [np.zeros(8 * RATE)]
    for before, level in zip([0.0, *levels], [*levels, 0.0], strict=True):
        ramp = np.arange(before, level, np.sign(level - before) * acceleration_rpm_s / RATE)
        speed += [ramp, np.full(held_s * RATE if level else 8 * RATE, level)]
    speed = np.concatenate(speed)
    frame = pd.DataFrame(
        {
            "time_s": np.arange(len(speed)) / RATE,
            "axial_load_n": 10000 + 5 * random.standard_normal(len(speed)),
            "inner_speed_rpm": speed + np.where(speed > 0, random.standard_normal(len(speed)), 0),
            "oil_temperature_c": 100.0,
            "outer_ring_temperature_c": 110.0,
            "torque_n_m": 0.3 + speed / 3000 + 0.02 * random.standard_normal(len(speed)),
        }
    )
    runs, _ = measure_torque([("a.csv", log(frame))], config)
    kept = runs[runs["accepted"]]
    np.testing.assert_allclose(kept["inner_speed_rpm"], levels, rtol=1e-3)
    np.testing.assert_allclose(kept["torque_n_m"], [1, 2, 3], atol=0.02)


def test_a_tare_of_one_row_is_refused_and_stops_no_other_log(config):
    slow = signals().iloc[::100].reset_index(drop=True)
    slow.loc[1, "inner_speed_rpm"] = 3000.0  # one row at rest before
    runs, refused = measure_torque([("a.csv", log(slow)), ("b.csv", log(signals()))], config)
    assert set(runs["run_id"]) == {"b.csv"}
    assert refused["rule"].tolist() == ["tare"]


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


UNITS = {
    "time": "s",
    "axial_load": "N",
    "inner_speed": "rpm",
    "oil_temperature": "degC",
    "outer_ring_temperature": "degC",
    "torque": "N m",
}
Write = Callable[..., bytes]
WRITERS: dict[str, Write] = {
    "csv": formats.csv,
    "tdms": formats.tdms,
    "lvm": formats.lvm,
    "parquet": formats.as_parquet,
}


def named(frame: pd.DataFrame) -> dict[str, np.ndarray]:
    """Columns by quantity, as the writers of `formats` want them."""
    return {quantity: frame[name].to_numpy() for quantity, name in zip(UNITS, NAMES, strict=True)}


def packings(content: bytes) -> list[bytes]:
    return [content, gzip.compress(content), arrow.compress(content, "zstd", asbytes=True)]


@pytest.mark.parametrize("name", WRITERS)
def test_every_format_gives_the_table_of_the_text_log(config, name):
    values = named(signals())
    text, _ = measure_torque([("a", formats.csv(values, UNITS, {"oil": "4050"}))], config)
    for content in packings(WRITERS[name](values, UNITS, {"oil": "4050", "bearing": BEARING})):
        runs, refused = measure_torque([("a", content)], config)
        assert refused.empty
        assert set(runs["reader"]) == {name}
        unlike = ["sha256", "reader"]
        pd.testing.assert_frame_equal(runs.drop(columns=unlike), text.drop(columns=unlike))


@pytest.mark.parametrize("name", WRITERS)
def test_columns_with_names_of_their_own_are_found_in_any_format(config, name):
    values = named(signals())
    text, _ = measure_torque([("a", formats.csv(values, UNITS, {"oil": "4050"}))], config)
    values["M_R"], values["Zeit"] = values.pop("torque") * 1e3, values["time"]
    columns = {"torque": {"name": "M_R", "unit": "N mm"}}
    if name == "csv":  # there with the unit in brackets behind the name
        values.pop("time")
        columns["time"] = {"name": "Zeit"}
    torque = config["campaign"]["torque"] | {"columns": columns}
    own = {**config, "campaign": config["campaign"] | {"torque": torque}}
    units = {**UNITS, "M_R": "N mm", "Zeit": "s"}
    runs, refused = measure_torque([("a", WRITERS[name](values, units, {"oil": "4050"}))], own)
    assert refused.empty
    np.testing.assert_allclose(runs["torque_n_m"], text["torque_n_m"], rtol=1e-9)


def test_groups_of_a_tdms_file_are_runs_of_their_own(config):
    one, other = named(signals(1)), named(signals(2, levels=(1.0, 2.0, 4.0)))
    content = formats.tdms_file(
        [formats.RootObject({"oil": "4050"})],
        formats.tdms_channels("cold", one, UNITS),
        formats.tdms_channels("warm", other, UNITS),
    )
    runs, refused = measure_torque([("a.tdms", content)], config)
    assert refused.empty
    levels = runs.groupby("run_id")["torque_n_m"].first()
    assert levels.to_dict() == pytest.approx({"a.tdms:cold": 2.0, "a.tdms:warm": 1.0}, abs=0.03)


def broken(write: Write) -> list[tuple[str, bytes, str]]:
    """What, content and rule of logs in one format that cannot be used."""
    frame, keys = signals(), {"oil": "4050"}
    whole = write(named(frame), UNITS, keys)
    unknown = named(frame) | {"torque": frame["torque_n_m"].to_numpy()}
    lacking = {quantity: column for quantity, column in unknown.items() if quantity != "torque"}
    return [
        ("tare", write(named(moved_tare(frame)), UNITS, keys), "tare"),
        ("stuck", write(named(stuck(frame)), UNITS, keys), "stuck_sensor"),
        ("oil", write(named(frame), UNITS, {"oil": "9999"}), "unknown_oil"),
        ("no oil", write(named(frame), UNITS, {"note": "x"}), "header"),
        ("bearing", write(named(frame), UNITS, {**keys, "bearing": "other"}), "other_bearing"),
        ("column", write(lacking, UNITS, keys), "columns"),
        ("unit", write(unknown, {**UNITS, "torque": "N"}, keys), "columns"),
        ("damaged archive", gzip.compress(whole)[:-9], "damaged_archive"),
    ]


@pytest.mark.parametrize("name", WRITERS)
def test_a_broken_log_of_any_format_is_listed_with_a_sentence(config, name):
    cases = broken(WRITERS[name])
    # half a binary file is damaged or truncated, as its format has it; half a text log lacks the
    # closing tare even where the cut falls between two rows
    whole = WRITERS[name](named(signals()), UNITS, {"oil": "4050"})
    cases += [("half", whole[: len(whole) // 2], "truncated damaged_file tare")]
    runs, refused = measure_torque([(what, content) for what, content, _ in cases], config)
    assert runs.empty
    for what, _, rules in cases:
        of_case = refused[refused["file"] == what]
        assert set(of_case["rule"]) & set(rules.split()), what
        assert of_case["reason"].str.len().min() > 20
        assert (of_case["advice"] != "").all()


@pytest.mark.parametrize("name", WRITERS)
def test_a_row_that_is_no_measurement_is_refused_in_any_format(config, name):
    frame = signals()
    frame.loc[199:200, "torque_n_m"] = np.nan
    content = WRITERS[name](named(frame), UNITS, {"oil": "4050"})
    runs, refused = measure_torque([("a", content)], config)
    assert len(runs) == 3
    (row,) = refused.to_dict("records")
    assert (row["rule"], row["first_row"], row["last_row"]) == ("unreadable_row", 200, 201)


@pytest.mark.parametrize("pack", [bytes, gzip.compress])
def test_a_copy_of_a_log_is_refused_by_the_name_of_the_first(config, pack):
    content = log(signals())
    runs, refused = measure_torque([("a.csv", content), ("b.csv", pack(content))], config)
    assert set(runs["run_id"]) == {"a.csv"}
    assert refused["rule"].tolist() == ["duplicate_log"]
    assert "a.csv, which is kept" in refused["reason"].iloc[0]


def test_a_traction_log_among_torque_logs_is_refused(config):
    traction = formats.csv(formats.columns(9))
    export = b"Test Data File\nStep 1 started at 01/02/2024 10:00:00\n"
    runs, refused = measure_torque([("a", traction), ("b", export)], config)
    assert runs.empty
    assert refused["rule"].tolist() == ["columns", "columns"]
    assert "no line names columns of a torque log" in refused["reason"].iloc[0]
    assert "no torque log" in refused["reason"].iloc[1]


@pytest.mark.parametrize("name", WRITERS)
@pytest.mark.parametrize("cut", [0.03, 0.5, 0.9, 0.999])
def test_a_log_cut_anywhere_never_ends_in_nothing(config, name, cut):
    whole = WRITERS[name](named(signals()), UNITS, {"oil": "4050"})
    runs, refused = measure_torque([("a", whole[: int(cut * len(whole))])], config)
    assert len(runs) or len(refused)


@pytest.mark.parametrize("name", WRITERS)
def test_damaged_torque_logs_end_in_a_verdict(config, name):
    whole = WRITERS[name](named(signals()), UNITS, {"oil": "4050"})
    random = generator(1, f"fuzz torque {name}")
    for _ in range(60):
        runs, refused = measure_torque([("a", mutate(whole, random))], config)
        assert len(runs) or len(refused)
        assert np.isfinite(runs.select_dtypes("number")).all(axis=None)
        assert (refused["reason"] != "").all()


def test_the_same_readers_serve_torque_and_traction():
    # PCS rigs log no torque
    assert {reader.name for reader in READERS} == {*WRITERS, "pcs"}
