"""Torque logs: planted torque comes back, the zero comes off, every format is read alike."""

import gzip
import re
from collections.abc import Callable

import numpy as np
import pandas as pd
import pyarrow as arrow
import pytest

import formats
from campaigns import ROOT
from mutations import mutate
from oilfilm.curation.curate import check_logs
from oilfilm.curation.torque_rig import TORQUE_RIG
from oilfilm.randomness import generator
from oilfilm.readers import READERS
from oilfilm.settings.load import resolve
from oilfilm.settings.resolved import Settings
from oilfilm.tables import failed_gates
from torque_logs import BEARING, RATE_HZ, UNITS, by_quantity, signals, text


@pytest.fixture(scope="module")
def config() -> Settings:
    return resolve(ROOT / "config", {})


def measured(logs: list[tuple[str, bytes]], config: Settings) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Plateaus and quarantine."""
    curated = check_logs(logs, config, TORQUE_RIG)
    return curated.points, curated.quarantine


def test_planted_torque_is_measured_within_its_errors(config):
    misses = []
    for seed in range(20):
        runs, refused = measured([("a.csv", text(signals(seed)))], config)
        assert refused.empty
        assert runs["accepted"].all()
        misses.append((runs["torque_n_m"] - [2.0, 3.0, 5.0]) / runs["torque_n_m_se"])
        assert runs["tare_n_m"].to_numpy() == pytest.approx(0.3, abs=0.02)
    spread = np.concatenate(misses).std()
    assert 0.7 < spread < 1.4  # 60 draws of a variable of standard deviation 1


def test_a_tare_that_moves_is_taken_along_a_straight_line(config):
    frame = signals()
    frame["torque_n_m"] += 0.04 * frame["time_s"] / frame["time_s"].iloc[-1]
    runs, _ = measured([("a.csv", text(frame))], config)
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
    dialect = "oil = 4050\r\n" + other.to_csv(
        index=False, sep=";", decimal=",", lineterminator="\r\n", float_format="%.9f"
    )
    plain, _ = measured([("a.csv", text(frame))], config)
    converted, refused = measured([("a.csv", dialect.encode("utf-16"))], config)
    assert refused.empty
    for name in ("axial_load_n", "inner_speed_rpm", "oil_temperature_c", "torque_n_m"):
        np.testing.assert_allclose(converted[name], plain[name], rtol=1e-6)


def stuck(frame: pd.DataFrame) -> pd.DataFrame:
    return frame.assign(torque_n_m=frame["torque_n_m"].where(frame["inner_speed_rpm"] < 5000, 3.25))


def moving_zero(frame: pd.DataFrame) -> pd.DataFrame:
    return frame.assign(torque_n_m=frame["torque_n_m"] + 0.01 * frame["time_s"])


@pytest.mark.parametrize(
    ("content", "rule", "words"),
    [
        (text(signals(), ""), "header", "no line `# oil"),
        (text(signals(), "# oil: 4050\n# bearing: other\n"), "other_bearing", "mainshaft-167"),
        (text(signals().drop(columns="torque_n_m")), "columns", "lacks the columns torque"),
        (text(signals().rename(columns={"torque_n_m": "torque [N]"})), "columns", "'torque [N]'"),
        (b"\x00\x01 rubbish", "unknown_format", "no reader knows this content"),
        (b"a,b,c,d\n1,2,3,4\n", "columns", "columns of a torque log"),
        (b"\x1f\x8brubbish", "damaged_archive", "cannot be unpacked"),
    ],
)
def test_a_log_that_cannot_be_used_is_refused_in_words(config, content, rule, words):
    runs, refused = measured([("bad.csv", content), ("good.csv", text(signals()))], config)
    assert set(runs["run_id"]) == {"good.csv"}
    of_rule = refused[refused["rule"] == rule]
    assert len(of_rule) == 1
    assert words in of_rule["reason"].iloc[0]
    assert of_rule["advice"].iloc[0]


def test_plateaus_are_kept_with_the_gate_that_refuses_them(config):
    frame = signals()
    frame["inner_speed_rpm"] *= -1
    runs, refused = measured([("a.csv", text(frame))], config)
    assert len(runs) == 3
    assert failed_gates.counts(runs)["turns_backwards"] == 3
    assert not runs["accepted"].any()
    assert refused["rule"].tolist() == ["turns_backwards"]


@pytest.mark.parametrize("rows", [43, 45])  # of the second level: none or one is left of it
def test_a_level_too_short_to_settle_is_listed_and_costs_no_other(config, rows):
    frame = signals()
    speed = frame["inner_speed_rpm"]
    brief = pd.concat([frame[speed < 4000].iloc[:280], frame[speed.between(5e3, 7e3)][:rows]])
    whole = pd.concat([brief, frame[speed > 8000], frame.iloc[-120:]])
    whole = whole.assign(time_s=np.arange(len(whole)) / RATE_HZ)
    runs, refused = measured([("a.csv", text(whole))], config)
    assert runs.loc[runs["accepted"], "inner_speed_rpm"].round(-1).tolist() == [3000, 9000]
    (found,) = refused.to_dict("records")
    assert found["rule"] == "too_short"
    assert re.search(r"the speed of about 6000 rpm was held for 2\.[123] s", found["reason"])


@pytest.mark.parametrize("acceleration_rpm_s", [100, 1000])
def test_ramps_between_levels_are_no_part_of_them(config, acceleration_rpm_s):
    random = np.random.default_rng(5)
    levels, held_s = [3000.0, 6000.0, 9000.0], 20
    speed = [np.zeros(8 * RATE_HZ)]
    for before, level in zip([0.0, *levels], [*levels, 0.0], strict=True):
        ramp = np.arange(before, level, np.sign(level - before) * acceleration_rpm_s / RATE_HZ)
        speed += [ramp, np.full(held_s * RATE_HZ if level else 8 * RATE_HZ, level)]
    speed = np.concatenate(speed)
    frame = pd.DataFrame(
        {
            "time_s": np.arange(len(speed)) / RATE_HZ,
            "axial_load_n": 10000 + 5 * random.standard_normal(len(speed)),
            "inner_speed_rpm": speed + np.where(speed > 0, random.standard_normal(len(speed)), 0),
            "oil_temperature_c": 100.0,
            "outer_ring_temperature_c": 110.0,
            "torque_n_m": 0.3 + speed / 3000 + 0.02 * random.standard_normal(len(speed)),
        }
    )
    runs, _ = measured([("a.csv", text(frame))], config)
    kept = runs[runs["accepted"]]
    np.testing.assert_allclose(kept["inner_speed_rpm"], levels, rtol=1e-3)
    np.testing.assert_allclose(kept["torque_n_m"], [1, 2, 3], atol=0.02)


def test_a_tare_of_one_row_is_refused_and_stops_no_other_text(config):
    slow = signals().iloc[::100].reset_index(drop=True)
    slow.loc[1, "inner_speed_rpm"] = 3000.0  # one row at rest before
    runs, refused = measured([("a.csv", text(slow)), ("b.csv", text(signals()))], config)
    assert set(runs["run_id"]) == {"b.csv"}
    assert refused["rule"].tolist() == ["zero_missing"]


def test_a_damaged_row_is_refused_by_its_number_and_the_rest_is_used(config):
    lines = text(signals()).split(b"\n")
    lines[200] = b"oops"
    runs, refused = measured([("a.csv", b"\n".join(lines))], config)
    assert len(runs) == 3
    assert refused["rule"].tolist() == ["unreadable_row"]
    assert refused["first_row"].tolist() == [199]


def test_no_logs_give_empty_tables(config):
    runs, refused = measured([], config)
    assert runs.empty
    assert refused.empty


Write = Callable[..., bytes]
WRITERS: dict[str, Write] = {
    "csv": formats.csv,
    "tdms": formats.tdms,
    "lvm": formats.lvm,
    "parquet": formats.as_parquet,
}


def packings(content: bytes) -> list[bytes]:
    return [content, gzip.compress(content), arrow.compress(content, "zstd", asbytes=True)]


@pytest.mark.parametrize("name", WRITERS)
def test_every_format_gives_the_table_of_the_text_text(config, name):
    values = by_quantity(signals())
    expected, _ = measured([("a", formats.csv(values, UNITS, {"oil": "4050"}))], config)
    for content in packings(WRITERS[name](values, UNITS, {"oil": "4050", "bearing": BEARING})):
        runs, refused = measured([("a", content)], config)
        assert refused.empty
        assert set(runs["reader"]) == {name}
        unlike = ["sha256", "reader"]
        pd.testing.assert_frame_equal(runs.drop(columns=unlike), expected.drop(columns=unlike))


@pytest.mark.parametrize("name", WRITERS)
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
    runs, refused = measured([("a", WRITERS[name](values, units, {"oil": "4050"}))], own)
    assert refused.empty
    np.testing.assert_allclose(runs["torque_n_m"], expected["torque_n_m"], rtol=1e-9)


def test_groups_of_a_tdms_file_are_runs_of_their_own(config):
    one, other = by_quantity(signals(1)), by_quantity(signals(2, levels=(1.0, 2.0, 4.0)))
    content = formats.tdms_file(
        [formats.RootObject({"oil": "4050"})],
        formats.tdms_channels("cold", one, UNITS),
        formats.tdms_channels("warm", other, UNITS),
    )
    runs, refused = measured([("a.tdms", content)], config)
    assert refused.empty
    levels = runs.groupby("run_id")["torque_n_m"].first()
    assert levels.to_dict() == pytest.approx({"a.tdms:cold": 2.0, "a.tdms:warm": 1.0}, abs=0.03)


def broken(write: Write) -> list[tuple[str, bytes, str]]:
    """What, content and rule of logs in one format that cannot be used."""
    frame, keys = signals(), {"oil": "4050"}
    whole = write(by_quantity(frame), UNITS, keys)
    unknown = by_quantity(frame) | {"torque": frame["torque_n_m"].to_numpy()}
    lacking = {quantity: column for quantity, column in unknown.items() if quantity != "torque"}
    return [
        ("zero", write(by_quantity(moving_zero(frame)), UNITS, keys), "zero_drift"),
        ("stuck", write(by_quantity(stuck(frame)), UNITS, keys), "stuck_sensor"),
        ("oil", write(by_quantity(frame), UNITS, {"oil": "9999"}), "unknown_oil"),
        ("no oil", write(by_quantity(frame), UNITS, {"note": "x"}), "header"),
        (
            "bearing",
            write(by_quantity(frame), UNITS, {**keys, "bearing": "other"}),
            "other_bearing",
        ),
        ("column", write(lacking, UNITS, keys), "columns"),
        ("unit", write(unknown, {**UNITS, "torque": "N"}, keys), "columns"),
        ("damaged archive", gzip.compress(whole)[:-9], "damaged_archive"),
    ]


@pytest.mark.parametrize("name", WRITERS)
def test_a_broken_log_of_any_format_is_listed_with_a_sentence(config, name):
    cases = broken(WRITERS[name])
    # half a binary file is damaged or truncated, as its format has it; half a text log lacks the
    # closing rest even where the cut falls between two rows
    whole = WRITERS[name](by_quantity(signals()), UNITS, {"oil": "4050"})
    cases += [("half", whole[: len(whole) // 2], "truncated damaged_file zero_missing")]
    runs, refused = measured([(what, content) for what, content, _ in cases], config)
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
    content = WRITERS[name](by_quantity(frame), UNITS, {"oil": "4050"})
    runs, refused = measured([("a", content)], config)
    assert len(runs) == 3
    (row,) = refused.to_dict("records")
    assert (row["rule"], row["first_row"], row["last_row"]) == ("unreadable_row", 200, 201)


@pytest.mark.parametrize("pack", [bytes, gzip.compress])
def test_a_copy_of_a_log_is_refused_by_the_name_of_the_first(config, pack):
    content = text(signals())
    runs, refused = measured([("a.csv", content), ("b.csv", pack(content))], config)
    assert set(runs["run_id"]) == {"a.csv"}
    assert refused["rule"].tolist() == ["duplicate_log"]
    assert "a.csv, which is kept" in refused["reason"].iloc[0]


def test_a_traction_log_among_torque_logs_is_refused(config):
    traction = formats.csv(formats.columns(9))
    export = b"Test Data File\nStep 1 started at 01/02/2024 10:00:00\n"
    runs, refused = measured([("a", traction), ("b", export)], config)
    assert runs.empty
    assert refused["rule"].tolist() == ["columns", "columns"]
    assert "no line names columns of a torque log" in refused["reason"].iloc[0]
    assert "no torque log" in refused["reason"].iloc[1]


@pytest.mark.parametrize("name", WRITERS)
@pytest.mark.parametrize("cut", [0.03, 0.5, 0.9, 0.999])
def test_a_log_cut_anywhere_never_ends_in_nothing(config, name, cut):
    whole = WRITERS[name](by_quantity(signals()), UNITS, {"oil": "4050"})
    runs, refused = measured([("a", whole[: int(cut * len(whole))])], config)
    assert len(runs) or len(refused)


@pytest.mark.parametrize("name", WRITERS)
def test_damaged_torque_logs_end_in_a_verdict(config, name):
    whole = WRITERS[name](by_quantity(signals()), UNITS, {"oil": "4050"})
    random = generator(1, f"fuzz torque {name}")
    for _ in range(60):
        runs, refused = measured([("a", mutate(whole, random))], config)
        assert len(runs) or len(refused)
        assert np.isfinite(runs.select_dtypes("number")).all(axis=None)
        assert (refused["reason"] != "").all()


def test_the_same_readers_serve_torque_and_traction():
    # PCS rigs log no torque
    assert {reader.name for reader in READERS} == {*WRITERS, "pcs"}
