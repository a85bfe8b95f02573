"""Every bad file ends in the verdict written beside it; a log is refused for its true reason."""

import re
import shutil
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from nptdms import RootObject
from pandas.testing import assert_frame_equal

import bad_logs
import formats
from bad_logs import CONFIG, KEYS, UNITS, csv, good
from campaigns import LABORATORY, ROOT
from nights import nightly, quick_ones
from oilfilm.base.errors import OilfilmError
from oilfilm.curation.curate import curate_logs
from oilfilm.logs.ingest import read_log
from oilfilm.settings.resolve import resolve
from oilfilm.settings.resolved import Settings
from oilfilm.tables.failed_gates import failed_any_of


@pytest.mark.slow
@pytest.mark.parametrize("write", [csv, partial(formats.tdms, keys=KEYS)])
def test_quantities_logged_twice_are_compared_and_cost_no_row(
    write: Callable[[bad_logs.Columns, Mapping[str, str]], bytes],
) -> None:
    values = bad_logs.logged_twice()
    values["slide_roll_ratio"][[5, 100]] = np.nan
    once = curate_logs([("log", write(good(), UNITS))], CONFIG)
    twice = curate_logs([("log", write(values, bad_logs.UNITS_TWICE))], CONFIG)
    assert twice.quarantine.empty
    assert_frame_equal(twice.points, once.points)


def text_beside(write: Callable[..., bytes]) -> bytes:
    values = {**good(), "slide_roll_ratio": np.array(["fast"] * len(good()["load"]))}
    return write(values, bad_logs.UNITS_TWICE, KEYS)


@pytest.mark.parametrize("write", [formats.tdms, formats.as_parquet])
def test_column_of_words_that_no_run_needs_is_let_be(write: Callable[..., bytes]) -> None:
    verdict = curate_logs([("log", text_beside(write))], CONFIG)
    assert verdict.quarantine.empty
    assert verdict.points["accepted"].all()


@pytest.mark.parametrize("noise_m_s", [0.0, 0.01])
def test_log_that_mostly_stands_still_is_compared_where_it_turns(noise_m_s: float) -> None:
    """Read as it lies there; the gates of curation are not asked."""
    turning = np.arange(400) >= 280
    random = np.random.default_rng(3)
    speed = 30.0 * turning + noise_m_s * random.standard_normal(400)
    values = {
        **{name: column[:400] for name, column in good().items()},
        "ball_speed": 0.99 * speed,
        "disc_speed": 1.01 * speed,
        "entrainment_speed": 30.01 * turning,
    }
    units = {
        **bad_logs.UNITS_TWICE,
        "ball_speed": "m/s",
        "disc_speed": "m/s",
        "entrainment_speed": "m/s",
    }
    for slip, disagrees in ((0.02, False), (0.04, True)):
        log = csv({**values, "slide_roll_ratio": 100 * slip * turning}, units)
        (run,) = read_log(log, "log", CONFIG)[1].runs
        assert (run.refusal is not None) == disagrees
        if run.refusal is not None:
            assert run.refusal.rule == "columns_disagree"
            assert run.refusal.reason.startswith("slide_roll_ratio")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("rule", "name"), [(rule, name) for rule, logs in bad_logs.BAD_LOGS.items() for name in logs]
)
def test_bad_log_gets_its_verdict_in_a_sentence(rule: str, name: str) -> None:
    content, sentence = bad_logs.BAD_LOGS[rule][name]
    config = bad_logs.PCS_CONFIG if name.startswith("pcs") else CONFIG
    verdict = curate_logs([("log", content)], config)
    reasons = verdict.quarantine.loc[verdict.quarantine["rule"] == rule, "reason"]
    assert any(sentence in reason for reason in reasons), verdict.quarantine["reason"].tolist()
    assert (verdict.quarantine["advice"] != "").all()
    # the rows around a bad one are used
    assert bool(verdict.points["accepted"].any()) == rule.endswith("_row")


def test_file_named_as_a_run_of_another_one_is_told() -> None:
    channels = [c for group in ("a", "b") for c in formats.tdms_channels(group, good(), UNITS)]
    log = formats.tdms_file([RootObject(KEYS), *channels])
    with pytest.raises(OilfilmError, match=r"^log:b: "):
        curate_logs([("log", log), ("log:b", bad_logs.GOOD)], CONFIG)


SLIPS = (0.0, 0.02, 0.04, 0.06, 0.08, 0.10, 0.12, 0.0)


def reason(content: bytes, settings: Settings = CONFIG) -> tuple[str, str]:
    """Rule and sentence of the refusal of a run, or of the file where there is none."""
    verdict = curate_logs([("log", content)], settings)
    assert not verdict.points["accepted"].any()
    for run in verdict.runs.to_dict("records"):
        return run["rule"], run["reason"]
    first = verdict.quarantine.iloc[0]
    return first["rule"], first["reason"]


@pytest.mark.parametrize(
    ("name", "below"),
    [
        ("load_n", "s,kN,N,rpm,rpm,degC\n"),
        ("load [N]", "s,kN,N,rpm,rpm,degC\n"),
        ("load_n [kN]", ""),
    ],
)
def test_unit_beside_a_name_that_states_another_is_refused(name: str, below: str) -> None:
    names = bad_logs.NAMES.decode().replace("load [N]", name)
    rows = bad_logs.ROWS.partition(b"\n")[2]
    rule, sentence = reason(bad_logs.HEAD + f"{names}\n{below}".encode() + rows)
    assert rule == "columns"
    assert f"{name!r} is in 'N' by its name and in 'kN' by the unit beside or below" in sentence


@pytest.mark.parametrize(("text", "is_refused"), [("yes", True), ("no", False), ("No", False)])
def test_log_is_simulated_unless_its_header_says_no(text: str, is_refused: bool) -> None:
    settings = CONFIG.with_changes({"campaign": {"data": "measured"}})
    _, reading = read_log(csv(simulated=text), "log", settings)
    assert ["simulated_log"] * is_refused == [refusal.rule for refusal in reading.refusals]


@pytest.mark.parametrize(
    ("logged", "below", "given", "contradicts"),
    [
        (" [N]", "", "lbf", True),
        (" [N]", "", "N", False),
        nightly(" [N]", "", "newton", False),
        ("", "", "lbf", False),
        ("", "s,N,N,rpm,rpm,degC", "lbf", True),
        nightly("", "s,N,N,rpm,rpm,degC", "newton", False),
    ],
)
def test_unit_that_contradicts_the_log_is_refused(
    logged: str, below: str, given: str, contradicts: bool
) -> None:
    """A load of 82 N would be 365 N, and mu a fourth of what it is."""
    content = bad_logs.GOOD.replace(b"load [N]", f"Normalkraft{logged}".encode())
    if below:
        names = next(line for line in content.splitlines() if b"Normalkraft" in line)
        content = content.replace(names, names + f"\n{below}".encode())
    columns = {"load": {"name": "Normalkraft", "unit": given}}
    settings = CONFIG.with_changes({"campaign": {"columns": columns}})
    quarantine = curate_logs([("log", content)], settings).quarantine
    told = quarantine["reason"].str.contains("is in 'N' by the log itself and in 'lbf' by").any()
    assert told == contradicts


@pytest.mark.parametrize("resolution", quick_ones([0.05, 0.02, 0.1, 1.0], [0.05, 1.0]))
def test_coarse_time_stamps_are_no_change_of_the_rate(resolution: float) -> None:
    values = good(seconds=12.0)
    coarse = np.floor(values["time"] / resolution + 1e-9) * resolution
    runs = curate_logs([("log", csv({**values, "time": coarse}))], CONFIG).runs
    assert "sampling_rate" not in set(runs["rule"])


def test_row_of_units_of_another_rig_is_seen() -> None:
    """As a wear rig writes it: the first is a mass, not a force."""
    names = "Fx,load,Y Position,disc_speed,Time"
    rows = "\n".join(f"12.1,8.2,3.0,10.0,{n / 10}" for n in range(20))
    log = f"# oil: 4102\n{names}\ng,kg,mm,mm/sec,sec\n{rows}\n".encode()
    columns = {"traction_force": {"name": "Fx"}, "time": {"name": "Time"}}
    rule, sentence = reason(log, CONFIG.with_changes({"campaign": {"columns": columns}}))
    assert rule == "columns"
    assert "has no unit" not in sentence
    # speeds are what it lacks, whatever its units
    assert "inlet_temperature, ball_speed" in sentence


@pytest.mark.parametrize("value", ["900", "1250"])
def test_pressure_in_mpa_that_is_labelled_gpa_is_told(value: str) -> None:
    rule, sentence = reason(csv(max_hertz_pressure_gpa=value))
    assert (rule, "below 10 (in GPa, not MPa)" in sentence) == ("header", True)
    values = {**good(), "load": np.full(len(good()["load"]), float(value))}
    content = formats.csv(values, {**UNITS, "load": "GPa"}, KEYS)
    assert curate_logs([("log", content)], CONFIG).points.empty


@pytest.mark.parametrize(("seconds", "rows", "told"), [(4.0, 20, True), (8.0, 10, False)])
def test_sensor_slower_than_the_log_is_told(seconds: float, rows: int, told: bool) -> None:
    """Sample and hold at 20 rows per second: 3 readings of a plateau are no mean, 14 are."""
    values = good(SLIPS, seconds)
    held = values["traction_force"][np.arange(len(values["time"])) // rows * rows]
    values["traction_force"] = held
    verdict = curate_logs([("log", csv(values))], CONFIG)
    run = verdict.runs.iloc[0]
    assert run["rule"] == ("held_readings" if told else "")
    assert ("20 rows (1 s)" in run["reason"]) == told
    # a wild reading is one, in however many rows it is
    assert verdict.points["accepted"].any() != told
    assert not failed_any_of(verdict.points, ["spiky"]).any()


@pytest.mark.parametrize("drift_n", [nightly(0.0), 0.5])
def test_force_that_is_15_times_too_large_is_impossible_and_in_no_unit(drift_n: float) -> None:
    """A zero that moves by 0.5 N of 20 N, or an oil with mu of 0.002, is not the reason."""
    values = good(SLIPS)
    force = 15 * values["traction_force"] + np.linspace(0, drift_n, len(values["time"]))
    rule, sentence = reason(csv({**values, "traction_force": force}))
    assert (rule, "gf labelled N" in sentence) == ("impossible_traction", False)


RIG = "ball-on-disc-20mm"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("rig", "told"),
    [
        ({}, ""),
        ({"full_scale": {"load_n": 4}}, "load_n goes up to 82.1"),
        # of the disc at a slip of 0.2 and a mean speed of 30 m/s
        ({"full_scale": {"surface_speed_m_s": 32}}, "surface_speed_m_s goes up to 33"),
        ({"ball": {"youngs_modulus_pa": 20.6e9}}, "ball: youngs_modulus_pa is 2.06e+10"),
        ({"ball_radius_m": 0.1}, "ball_radius_m is 0.1;"),
    ],
)
def test_rig_that_is_like_no_other_is_doubted(rig: dict[str, object], told: str) -> None:
    """The set point is a load, so that no pressure depends on radius and modulus."""
    settings = CONFIG.with_changes({"rigs": {RIG: rig}})
    content = csv(good(), load_n=82.2, max_hertz_pressure_gpa=None)
    (warnings,) = curate_logs([("log", content)], settings).runs["warning"]
    assert (told in "; ".join(warnings)) if told else warnings == ()


@pytest.mark.parametrize("error", [0, 0.5])
def test_calibration_that_no_sensor_has_is_refused(error: float) -> None:
    with pytest.raises(OilfilmError, match=r"`rigs.*calibration.load_relative`: found 0"):
        CONFIG.with_changes({"rigs": {RIG: {"calibration": {"load_relative": error}}}})


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (
            "columns:\n  load: {name: [Fz, W]}\n  traction_force: {name: W}\n",
            "`columns.traction_force`: 'W' is listed for 'load' too",
        ),
        ("header:\n  oil: Oil\n  rig: [Rig, Oil]\n", "'Oil' is listed for 'oil' too"),
        ("columns:\n  load: {name: 5}\n", 'found 5, expected text. Put it in quotes: "5"'),
        ("oil_aliases:\n  4102: [Turbo]\n", "4102 under `oil_aliases` is no text. Put it"),
    ],
)
def test_mistake_of_a_campaign_file_is_told(tmp_path: Path, text: str, told: str) -> None:
    shutil.copytree(ROOT / "config", tmp_path, dirs_exist_ok=True)
    own = tmp_path / "campaigns/laboratory.yaml"
    shutil.copy(LABORATORY / "campaigns/laboratory.yaml", own)
    with own.open("a") as file:
        file.write(text)
    with pytest.raises(OilfilmError, match=re.escape(told)):
        resolve(tmp_path, {"campaign": "laboratory"})
