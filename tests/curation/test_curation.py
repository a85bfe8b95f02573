"""Curation against what was planted, and against worlds whose answer is known in closed form."""

import io
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pyarrow.parquet as parquet
import pytest
from hypothesis import given
from hypothesis import strategies as st

import bad_logs
from campaigns import Campaign, printed
from damages import AT_A_LIMIT, GOOD_POINT, PLANNED_SLIPS, SOUND
from oilfilm import tables
from oilfilm.curation.curate import (
    CuratedTables,
    arrays_of_samples,
    collect,
    curate_ingested,
    curate_logs,
    curate_parts,
)
from oilfilm.curation.measure import find_steps, settled_parts
from oilfilm.curation.plateau_gates import judge_plateaus
from oilfilm.curation.traction_rig import TractionRig
from oilfilm.logs.ingest import IngestedLogs, ingest_logs, open_sample_files
from oilfilm.settings.campaign import Semantics
from oilfilm.settings.resolved import Settings
from oilfilm.traction.laws.deng2026 import traction_coefficient

PLATEAUS = bad_logs.CONFIG.curation.plateaus


# --- the demonstration campaign ---------------------------------------------------------------


@pytest.mark.slow
def test_every_planted_defect_is_refused_by_the_gate_meant_for_it(demo: Campaign) -> None:
    planted = demo.truth[demo.truth["defect"] != ""].merge(demo.curated.runs, on="run_id")
    assert len(planted) == 6
    assert (planted["verdict"] == "refused").all()
    assert (planted["rule"] == planted["gate"]).all()
    assert set(planted["run_id"]) <= set(demo.curated.quarantine["run_id"])


def test_no_clean_run_loses_a_plateau(demo: Campaign) -> None:
    clean = demo.truth.loc[demo.truth["defect"] == "", "run_id"]
    runs = demo.curated.runs.set_index("run_id").loc[clean]
    assert len(runs) == 212
    assert (runs["verdict"] == "accepted").all()
    assert (runs["accepted_points"] == 31).all()  # 31 slip steps each


def test_plateau_traction_is_the_true_one_within_its_errors(demo: Campaign) -> None:
    points = demo.curated.points.merge(demo.truth, on="run_id", suffixes=("", "_true"))
    points = points[points["accepted"]]
    names = ("max_hertz_pressure_gpa", "entrainment_speed_m_s", "inlet_temperature_c")
    for oil, group in points.groupby("oil"):
        at = (group[f"{name}_true"].to_numpy() for name in names)
        slip = group["slide_roll_ratio"]
        mu = traction_coefficient(printed()[oil], *at, slip.abs().to_numpy()) * np.sign(slip)
        error = (group["traction_coefficient"] - mu).abs()
        # 0.5 % of load is shared by a run; slip is known to 3e-4, at slopes up to 1.5
        allowed = 4 * np.hypot(0.005 * mu, 1.5 * group["slide_roll_ratio_se"])
        assert (error <= allowed + 4 * group["traction_coefficient_se"]).mean() > 0.999


# --- signals of known shape --------------------------------------------------------------------


@given(
    steps=st.lists(st.sampled_from([-0.02, -0.01, 0.01, 0.015, 0.05]), min_size=1, max_size=12),
    seconds=st.floats(2.2, 6.0),
    seed=st.integers(0, 1000),
)
def test_steps_are_found_only_where_they_are(steps: list[float], seconds: float, seed: int) -> None:
    levels = list(np.cumsum([0.0, *steps]))
    slip = np.repeat(levels, round(seconds * 50))
    slip = slip + 0.002 * np.random.default_rng(seed).standard_normal(len(slip))
    found = find_steps(slip, 0.02, 0.004, PLATEAUS)
    expected = np.arange(1, len(levels)) * round(seconds * 50)
    assert len(found) == len(expected)
    assert np.abs(found - expected).max() <= 12  # 0.24 s, the noise of the location
    for start, stop, level in zip(
        *settled_parts(len(slip), found, 0.02, PLATEAUS), levels, strict=True
    ):
        assert slip[start:stop].mean() == pytest.approx(level, abs=0.002)


@pytest.mark.slow
def test_transient_that_outlasts_the_settling_time_is_measured_and_refused() -> None:
    values = bad_logs.good()
    since_step = np.tile(np.arange(80) / bad_logs.RATE_HZ, 5)
    # exponential, 0.6 s, in mu; it halves the plateau's change but not its first fifth
    decay = 0.0135 * np.exp(-since_step / 0.6)
    sliding = np.repeat(np.array(bad_logs.PHASES) > 0, 80)
    values["traction_force"] += np.where(sliding, decay * values["load"], 0)
    log = [("log", bad_logs.csv(values))]
    points = curate_logs(log, bad_logs.CONFIG).points.query("slide_roll_ratio > 0.02")
    # the plateau of pure rolling alone does not save the run
    assert set(points["failed_gates"]) == {("no_point_left", "transient_not_ended")}
    # 62 rows are left from 0.8 s on; the noise of 0.02 N over 82 N moves a mean by some 1e-4
    steady = decay[80 + 16 : 80 + 78]
    expected = steady[:12].mean() - steady[12:].mean()
    np.testing.assert_allclose(points["traction_transient"], expected, atol=3e-4)


# --- gates, one by one ---------------------------------------------------------------------------


@pytest.mark.parametrize(("change", "gate"), AT_A_LIMIT)
def test_gate_acts_at_its_limit(config: Settings, change: dict[str, Any], gate: str | None) -> None:
    planned = config.with_changes({"campaign": {"set_points": {"slide_roll_ratio": PLANNED_SLIPS}}})
    point = pd.DataFrame([{**GOOD_POINT, **change}])
    failed = judge_plateaus(point, TractionRig(planned)).iloc[0]
    assert failed[failed].index.tolist() == ([gate] if gate else [])


@pytest.mark.parametrize("slip", [0.05, 0.2])
def test_one_slip_that_is_read_again_and_again_has_the_set_speed(
    config: Settings, slip: float
) -> None:
    """The slower body scatters least: its speed, off by half of the slip, seems the held one."""
    speed_m_s = [29.98, 29.99, 30.0, 30.01, 30.02]
    points = pd.DataFrame([GOOD_POINT] * 5).assign(
        slide_roll_ratio=slip, entrainment_speed_m_s=speed_m_s
    )
    assert not judge_plateaus(points, TractionRig(config))["speed_off_nominal"].any()


def test_wrong_fringe_orders_leave_the_power_law_of_the_other_films(config: Settings) -> None:
    speed = np.geomspace(0.05, 3.0, 24)
    film = 0.03 * speed**0.67
    wrong = np.arange(24) % 3 == 1
    points = pd.DataFrame([GOOD_POINT] * 24).assign(
        entrainment_speed_m_s=speed,
        nominal_entrainment_speed_m_s=np.nan,
        measured_film_thickness_um=np.where(wrong, film + 0.19, film),
    )
    failed = judge_plateaus(points, TractionRig(config))
    assert failed["film_off_trend"].tolist() == wrong.tolist()


# --- what the signals are taken for -------------------------------------------------------------


@pytest.mark.parametrize("traction_sign", [1, -1])
@pytest.mark.parametrize(("slower", "force_sign"), [("ball", 1), ("disc", -1)])
def test_sign_and_slower_body_agree(traction_sign: int, slower: str, force_sign: int) -> None:
    log = Semantics(slower_body=slower, traction_sign=traction_sign)
    samples = tables.empty_table("samples").drop(columns="run_id").reindex(range(1))
    ball, disc = (9.0, 11.0) if slower == "ball" else (11.0, 9.0)
    force_n = traction_sign * force_sign * 2.0
    samples = samples.assign(traction_force_n=force_n, disc_speed_m_s=disc, ball_speed_m_s=ball)
    settings = Settings.from_plain_values(
        {"campaign": {"semantics": log.model_dump(), "semantics_of_rig": {}}}
    )
    signals = TractionRig.make_signals(arrays_of_samples(samples), "any", settings)
    assert signals["traction_force_n"].tolist() == [2.0]
    assert signals["slide_roll_ratio"].tolist() == [0.2]


@given(faster=st.floats(1, 60), ratio=st.floats(0, 0.99))
def test_every_definition_of_slip_becomes_sliding_over_mean_speed(
    faster: float, ratio: float
) -> None:
    sliding, total = faster * (1 - ratio), faster * (1 + ratio)
    both = np.array([1.0, -1.0]) * sliding
    divisors = {"over_mean": total / 2, "over_sum": total, "over_faster": faster}
    for definition, divisor in divisors.items():
        of_mean = Semantics(slide_roll_ratio=definition).over_mean(both / divisor)
        np.testing.assert_allclose(of_mean, both / (total / 2), rtol=1e-12)


def test_a_slip_over_the_faster_speed_that_no_rig_has_is_not_a_slip_of_the_other_sign() -> None:
    of_mean = Semantics(slide_roll_ratio="over_faster").over_mean(np.array([2.5, -3.0]))
    assert of_mean.tolist() == [np.inf, -np.inf]


def test_calibration_errors_stand_apart_or_are_null(demo: Campaign, etm: Campaign) -> None:
    points = demo.curated.points[demo.curated.points["accepted"]]
    # config/rigs: 0.5 % of load and force, 0.1 % of speed, 0.5 K
    np.testing.assert_allclose(points["load_systematic_n"], 0.005 * points["load_n"])
    np.testing.assert_allclose(
        points["entrainment_speed_systematic_m_s"], 0.001 * points["entrainment_speed_m_s"]
    )
    assert (points["inlet_temperature_systematic_c"] == 0.5).all()
    systematic = etm.curated.points.filter(like="_systematic_")
    assert systematic.shape[1] == 4
    assert systematic.isna().all(axis=None)


# --- logs that once stopped all of a campaign ---------------------------------------------------


@pytest.mark.parametrize(
    ("name", "rows", "value", "verdict"),
    [
        ("inlet_temperature", slice(None), -200.0, "refused"),
        ("load", slice(None), 1e-320, "refused"),
        ("_speed", slice(0, 1), 0.0, "accepted"),
        ("_speed", slice(None), 0.0, "refused"),
    ],
)
def test_absurd_log_is_one_refused_run(name: str, rows: slice, value: float, verdict: str) -> None:
    values = {name: column.copy() for name, column in SOUND["traction"].values.items()}
    for column in (column for key, column in values.items() if key.endswith(name)):
        column[rows] = value
    curated = curate_logs([("log.csv", SOUND["traction"].text(values))], bad_logs.CONFIG)
    assert curated.runs["verdict"].tolist() == [verdict]


@pytest.mark.parametrize("start", [660, 1500])
def test_spindle_slip_leaves_no_wrong_point(demo: Campaign, start: int) -> None:
    run_id = "4102_P1.25_U25_T070.csv"
    clean = demo.curated.points.query("run_id == @run_id")["slide_roll_ratio"].to_numpy()
    log = (demo.folder / run_id).read_text(encoding="utf-8")
    header, _, _ = log.partition("time_s")
    frame = pd.read_csv(io.StringIO(log), comment="#")
    frame.loc[start : start + 49, "ball_speed_rpm"] *= 0.95
    slipped = header + frame.round(4).to_csv(index=False)
    points = curate_logs([("log.csv", slipped.encode())], demo.config).points
    accepted = points[points["accepted"]]
    assert 27 <= len(accepted) < 31
    # each point left is one of the clean log's, to within the errors that it reports
    nearest = np.abs(accepted["slide_roll_ratio"].to_numpy()[:, np.newaxis] - clean).min(axis=1)
    assert (nearest <= 5 * accepted["slide_roll_ratio_se"]).all()


ABOUT = {"campaign": "demo", "data": "simulated"}


CONFIG = bad_logs.CONFIG


LOGS = [
    ("sound", SOUND["traction"].text()),
    ("short", bad_logs.csv(bad_logs.good((0.0, 0.05, 0.0)))),
    # a second look at the samples finds the mistake
    ("force_in_mn", SOUND["traction"].column("traction_force", lambda force_n: 1000 * force_n)),
    ("no_rows", SOUND["traction"].text().partition(b"\n0")[0]),
]


def in_parts(logs: Iterator[tuple[str, bytes]], folder: Path) -> tuple[IngestedLogs, CuratedTables]:
    paths = {oil: folder / f"{oil}.parquet" for oil in CONFIG.oils}
    with open_sample_files(paths, ABOUT) as keep:
        ingested = ingest_logs(logs, CONFIG, keep_run=keep)
    samples = tables.read_blocks("samples", *paths.values())
    return ingested, collect(curate_parts(samples, ingested, TractionRig(CONFIG)), CONFIG)


@pytest.mark.slow
def test_share_in_parts_gives_the_same(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    rows = len(SOUND["traction"].values["time"])
    monkeypatch.setattr(tables, "ROWS_PER_GROUP", 2 * rows)
    whole = ingest_logs(LOGS, CONFIG)
    expected = curate_ingested(whole, TractionRig(CONFIG))
    ingested, curated = in_parts(iter(LOGS), tmp_path)
    assert {"accepted", "refused"} == set(expected.runs["verdict"])
    assert {"", "force_scale", "no_rows"} <= set(expected.runs["rule"])
    pd.testing.assert_frame_equal(ingested.runs, whole.runs, check_exact=True)
    for name, frame in vars(expected).items():
        pd.testing.assert_frame_equal(getattr(curated, name), frame, check_exact=True)
    for oil, frame in whole.samples_of_oil.items():
        path = tmp_path / f"{oil}.parquet"
        pd.testing.assert_frame_equal(tables.read("samples", path), frame, check_exact=True)
        file = parquet.ParquetFile(path).metadata
        rows_of_groups = [file.row_group(at).num_rows for at in range(file.num_row_groups)]
        assert max(rows_of_groups) <= 2 * rows
