"""Sound logs of unusual rigs and loggers are used; faults that look like them are refused."""

import re
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest

import torque_logs
from bad_logs import CONFIG, KEYS, UNITS, Columns, csv, good
from nights import nightly
from oilfilm.curation.curate import CuratedTables, curate_logs
from oilfilm.curation.rig_kind import Signals
from oilfilm.curation.run_gates import impossible_traction, same_channel, two_conditions
from oilfilm.curation.torque_rig import TorqueRig
from oilfilm.curation.traction_rig import TractionRig
from oilfilm.tables import failed_gates

SLIPS = tuple(0.02 * step for step in range(12))
SWEEP = (*SLIPS, 0.0)
HELD = 80  # rows of each slip
SPINDLES = ("ball_speed", "disc_speed")
NO_SET_POINTS = dict.fromkeys(set(KEYS) - {"oil"})


def judged(values: Columns, **keys: object) -> CuratedTables:
    return curate_logs([("log", csv(values, **keys))], CONFIG)


def rules(curated: CuratedTables) -> list[str]:
    """Rules that refuse the run or rows of it."""
    return curated.quarantine["rule"].tolist()


def at_rest(values: Columns) -> Columns:
    """Three seconds more, in which both encoders read exactly 0 and the other sensors go on."""
    start = 480
    rows = np.r_[:start, :60, start : len(values["time"])]
    longer = {name: column[rows].copy() for name, column in values.items()}
    for name in SPINDLES:
        longer[name][start : start + 60] = 0.0
    return {**longer, "time": np.arange(len(rows)) / 20}


def coarse_thermometer(values: Columns) -> Columns:
    """0.1 degC resolution: it flickers between two digits, then holds one of them."""
    noise = np.random.default_rng(5).standard_normal(len(values["time"]))
    half = len(noise) // 2
    flicker = np.where(np.arange(len(noise)) < half, 70.05 + 0.03 * noise, 70.0 + 0.005 * noise)
    return {**values, "inlet_temperature": np.round(flicker, 1)}


def commanded(values: Columns) -> Columns:
    """Speeds as they were set, without noise, each slip reached on a ramp of half a second."""
    slip = np.repeat(SWEEP, HELD)
    for step in range(1, len(SWEEP)):
        ramp = np.s_[step * HELD - 5 : step * HELD + 5]
        slip[ramp] = np.linspace(SWEEP[step - 1], SWEEP[step], 10, endpoint=False)
    rolling = {name: np.mean(values[name][:HELD]) for name in SPINDLES}
    return {
        **values,
        "ball_speed": rolling["ball_speed"] * (1 - slip / 2),
        "disc_speed": rolling["disc_speed"] * (1 + slip / 2),
    }


def held_for(values: Columns, name: str, rows: int) -> Columns:
    """A channel that is renewed in every so many rows only."""
    count = len(values["time"])
    return {**values, name: np.repeat(values[name][::rows], rows)[:count]}


def late(values: Columns) -> Columns:
    """The clock of a program, with the three decimals of many loggers."""
    late_s = 0.005 * np.random.default_rng(7).standard_exponential(len(values["time"]))
    return {**values, "time": np.round(values["time"] + late_s, 3)}


SOUND: dict[str, Callable[[Columns], Columns]] = {
    "slips falling": lambda _: good((0.0, *SLIPS[:0:-1], 0.0)),
    "up and down": lambda _: good((*SLIPS, *SLIPS[-2:0:-1], 0.0)),
    "repeated levels": lambda _: good((0.0, 0.05, 0.0, 0.05, 0.1, 0.05, 0.1, 0.05, 0.0)),
    "clock of a program": late,
    "standstill in the middle": at_rest,
    "coarse thermometer": coarse_thermometer,
    "coarse force sensor": lambda values: {
        **values, "traction_force": np.round(values["traction_force"], 2),
    },
    "commanded speeds": commanded,
    "temperature once in five seconds": lambda values: held_for(values, "inlet_temperature", 100),
    "dead weight": lambda values: {**values, "load": np.full_like(values["load"], 82.2)},
    "one row in a second": lambda values: {
        **{name: column[::2] for name, column in values.items()},
        "time": np.arange(len(values["time"]) // 2, dtype=float),
    },
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("name", SOUND)
def test_unusual_log_that_nothing_is_wrong_with_is_used(name: str) -> None:
    curated = judged(SOUND[name](good(SWEEP)))
    assert rules(curated) == []
    assert curated.runs["warning"].tolist() == [()]
    assert curated.points["accepted"].mean() > 0.9


@pytest.mark.parametrize("every", [nightly(10), 20])
def test_slow_channel_that_is_written_in_few_rows_is_no_hole(every: int) -> None:
    values = good(SWEEP, seconds=20.0)
    head, _, rows = csv(values).partition(b"inlet_temperature [degC]\n")
    lines = rows.splitlines(keepends=True)
    for index, line in enumerate(lines):
        if index % every:
            lines[index] = line.rpartition(b",")[0] + b",\n"
    log = head + b"inlet_temperature [degC]\n" + b"".join(lines)
    curated = curate_logs([("log", log)], CONFIG)
    assert curated.runs["verdict"].tolist() == ["accepted"]
    assert set(rules(curated)) == {"unreadable_row"}
    # a hole of the slow channel is one
    hole = b"".join([*lines[:1500], *(b",,,,,\n" for _ in range(12 * every)), *lines[1500:]])
    curated = curate_logs([("log", head + b"inlet_temperature [degC]\n" + hole)], CONFIG)
    assert "missing_readings" in rules(curated)


def test_log_with_every_third_row_unusable_is_judged_on_the_others() -> None:
    """Steps of one row and of two occur equally often: their median, 1.5, does not occur."""
    head, names, rows = csv(good(SWEEP)).partition(b"inlet_temperature [degC]\n")
    lines = rows.splitlines(keepends=True)
    lines[2::3] = [b",,,,,\n"] * len(lines[2::3])
    # the last row is used: as many steps of two rows as of one
    lines = lines[: len(lines) // 3 * 3 - 2]
    curated = curate_logs([("log", head + names + b"".join(lines))], CONFIG)
    assert curated.runs["verdict"].tolist() == ["accepted"]
    assert set(rules(curated)) == {"unreadable_row"}


def test_channel_that_is_renewed_in_every_fourth_row_and_freezes_is_refused() -> None:
    values = held_for(good(SWEEP), "ball_speed", 4)
    values["ball_speed"][520:] = values["ball_speed"][520]
    assert rules(judged(values)) == ["stuck_channel"]


def test_bearing_that_stands_still_for_a_while_has_no_stuck_speed() -> None:
    levels = np.repeat([0, 1, 0, 2, 3, 0], [120, 160, 140, 160, 160, 120])
    torque = np.array([0.0, 2.0, 3.0, 5.0])[levels]
    log = torque_logs.text(torque_logs.signals_of(3000.0 * levels, torque, 1))
    curated = curate_logs([("log", log)], CONFIG, TorqueRig)
    assert rules(curated) == []
    kept = curated.points[curated.points["accepted"]]
    np.testing.assert_allclose(kept["torque_n_m"], [2, 3, 5], atol=0.03)


@pytest.mark.parametrize(("digits", "rule"), [(2, None), (0, "stuck_sensor")])
def test_force_of_too_few_digits_is_told_so(digits: int, rule: str | None) -> None:
    values = good(SWEEP)
    values["traction_force"] = np.round(10 * values["traction_force"], digits)
    curated = judged({**values, "load": 10 * values["load"]}, **NO_SET_POINTS)
    assert rules(curated) == ([rule] if rule else [])
    assert all("more digits" in reason for reason in curated.quarantine["reason"])


# --- gates alone -------------------------------------------------------------------------------

RIG = TractionRig(CONFIG)


@pytest.mark.parametrize(
    "signal", [np.full(400, 30.0), np.full(1, 30.0)], ids=["constant", "one row"]
)
def test_equal_readings_that_never_change_are_no_single_channel(signal: np.ndarray) -> None:
    columns = {channel.column: signal for channel in RIG.channels}
    refusal = SimpleNamespace(rule="zero_missing")
    run: Any = SimpleNamespace(
        rig_kind=RIG, signals=Signals(np.arange(len(signal)), signal, columns), refusal=refusal
    )
    assert [*same_channel(run, RIG)] == []


def test_zero_that_moves_without_a_load_shows_no_impossible_traction() -> None:
    plateaus = {
        "load_n": np.zeros(5),
        "slide_roll_ratio": np.full(5, 0.1),
        "traction_coefficient": np.full(5, np.nan),
    }
    run: Any = SimpleNamespace(plateaus=plateaus, refusal=SimpleNamespace(rule="zero_drift"))
    assert [*impossible_traction(run, RIG)] == []


@pytest.mark.parametrize("changing", [0, 2, 3, 4])
def test_log_is_to_be_cut_where_its_load_changes_and_not_where_it_wavers(changing: int) -> None:
    loads_n = np.array([50.0, 50, 50, 50, 30, 30, 30, 30])
    load_change = np.zeros(8)
    load_change[changing] = 0.5
    first_rows = 1 + 100 * np.arange(8)
    run: Any = SimpleNamespace(
        plateaus={
            "load_n": loads_n,
            "entrainment_speed_m_s": np.full(8, 30.0),
            "load_change": load_change,
            "first_row": first_rows,
            "last_row": first_rows + 99,
        }
    )
    (finding,) = two_conditions(run, RIG)
    assert finding["name"] == "load"
    assert finding["first"] == (501 if changing == 4 else 401)


def test_stuck_torque_is_named_even_if_no_speed_is_held() -> None:
    ramp = np.linspace(0, 3000, 40)
    speed_rpm = np.concatenate([np.zeros(120), ramp, ramp[::-1], np.zeros(120)])
    log = torque_logs.signals_of(speed_rpm, np.zeros(len(speed_rpm)), 1).assign(torque_n_m=2.0)
    curated = curate_logs([("log", torque_logs.text(log))], CONFIG, TorqueRig)
    assert len(curated.points) == 0
    assert rules(curated) == ["stuck_sensor"]


# --- faulty plateaus ---------------------------------------------------------------------------


def with_levels_changed(phases: tuple[float, ...], levels: range, factor: float) -> Columns:
    """The force of the last second of some levels times a factor."""
    values = good(phases)
    for level in levels:
        values["traction_force"][(level + 1) * HELD - 25 : (level + 1) * HELD - 5] *= factor
    return values


@pytest.mark.slow
@pytest.mark.parametrize(
    ("phases", "faulty", "refused"),
    [
        ((0.0, 0.05, 0.1, 0.0), 1, False),
        nightly((0.0, 0.05, 0.1, 0.15, 0.0), 1, False),
        nightly((0.0, 0.05, 0.1, 0.15, 0.2, 0.0), 3, True),
        (SWEEP, 3, False),
        (SWEEP, 5, True),
    ],
)
def test_many_faulty_plateaus_refuse(phases: tuple[float, ...], faulty: int, refused: bool) -> None:
    last = len(phases) - 1
    curated = judged(with_levels_changed(phases, range(last - faulty, last), 1.4))
    unsteady = ["not_steady", "spiky", "transient_not_ended"]
    bad = failed_gates.failed_any_of(curated.points, unsteady)
    assert bad.sum() == faulty
    assert rules(curated) == (["many_plateaus_fail"] if refused else [])
    for reason in curated.quarantine["reason"]:
        assert f"{faulty} of the {len(bad)} plateaus" in reason


@pytest.mark.slow
@pytest.mark.parametrize(("factor", "rows"), [(-1, 0), (20, 0), (20, 60)])
def test_one_steady_plateau_of_impossible_traction_refuses_the_run(factor: int, rows: int) -> None:
    """A plateau that is disturbed for its last second is refused alone."""
    values = good(SWEEP)
    values["traction_force"][5 * HELD + rows : 6 * HELD] *= factor
    curated = judged(values)
    assert rules(curated) == ([] if rows else ["impossible_traction"])
    gates = failed_gates.refusal_counts(curated.points).index
    assert ("spiky" if rows else "traction_unphysical") in gates
    assert curated.points["accepted"].sum() == (len(curated.points) - 1 if rows else 0)


def test_light_contact_whose_zero_is_a_little_off_is_used() -> None:
    """-0.03 N of 5 N are mu = -0.006 at no slip, and no fault of the sliding points."""
    values = good(SWEEP)
    values |= {name: values[name] * 5 / 82.2 for name in ("load", "traction_force")}
    values["traction_force"][50:HELD] -= 0.03
    curated = judged(values, **NO_SET_POINTS)
    assert curated.runs["verdict"].tolist() == ["accepted"]
    assert failed_gates.refusal_counts(curated.points).to_dict() == {"traction_unphysical": 1}


# --- simple mistakes ---------------------------------------------------------------------------


GF = 9.80665e-3  # N


@pytest.mark.slow
@pytest.mark.parametrize(
    ("change", "rule", "words"),
    [
        # a usual traction in gf, and in mN as well
        ({"traction_force": 3 / GF}, "force_scale", "as mN labelled N .* as gf labelled N"),
        nightly({"ball_speed": -1}, "speed_sign", "opposite sign of the ball's speed"),
        ({"ball_speed": -1, "disc_speed": -1}, "speed_sign", "both speeds"),
        ({"ball_speed": 6, "disc_speed": 6}, "speed_unit", "deg/s labelled 1/min"),
        nightly({"disc_speed": np.pi / 30}, "speed_unit", "disc's speed 9.549 times as large"),
        ({"load": 1 / 4.4482216}, "load_off_nominal", "may be in lbf"),
    ],
)
def test_wrong_unit_or_sign_is_named(change: dict[str, float], rule: str, words: str) -> None:
    values = good(SWEEP)
    for name, by in change.items():
        values[name] = by * values[name]
    curated = judged(values)
    assert rules(curated) == [rule]
    assert re.search(words, curated.quarantine["reason"].iloc[0])


@pytest.mark.slow
@pytest.mark.parametrize(("factor", "unit"), [(100, "1"), (1, "%"), nightly(1, "percent")])
def test_slip_in_percent_or_as_a_fraction_is_named_where_logged(factor: float, unit: str) -> None:
    random, slip = np.random.default_rng(3), np.repeat(SWEEP, HELD)
    values = {name: column for name, column in good(SWEEP).items() if name not in SPINDLES}
    values["entrainment_speed"] = 30 + 0.01 * random.standard_normal(len(slip))
    values["slide_roll_ratio"] = factor * (slip + 0.0005 * random.standard_normal(len(slip)))
    units = {**UNITS, "entrainment_speed": "m/s", "slide_roll_ratio": unit}
    units = {name: unit for name, unit in units.items() if name in values}
    assert rules(judged(values, units=units)) == ["slip_unit"]


def test_force_that_is_small_for_an_oil_is_a_warning() -> None:
    values = good(SWEEP)
    (run,) = judged(
        {**values, "traction_force": values["traction_force"] / 4.4482216}
    ).runs.to_dict("records")
    assert run["verdict"] == "accepted"
    (warning,) = run["warning"]
    assert warning.startswith("little_traction")


@pytest.mark.parametrize(
    ("row", "change_s", "steps"), [(400, -0.02, 2), (slice(600, None), 0.1, 1)]
)
def test_warning_names_a_wrong_digit_of_time(row: int | slice, change_s: float, steps: int) -> None:
    """Rows come every 0.05 s; none of these changes turns the clock back."""
    values = good(SWEEP)
    values["time"][row] += change_s
    run = judged(values).runs.iloc[0]
    assert run["verdict"] == "accepted"
    place = row if isinstance(row, int) else row.start
    # rows are counted from 1
    between = f"{0.05 + change_s:g} s pass between row {place} and row {place + 1}"
    (warning,) = run["warning"]
    assert warning.startswith(f"uneven_clock: rows come every 0.05 s, but {between}")
    assert f"({steps} such steps)" in warning


# --- runs against each other -------------------------------------------------------------------


def together(**logs: bytes) -> pd.Series:
    """The rule that refused each run; empty where none did."""
    curated = curate_logs(sorted(logs.items()), CONFIG)
    return curated.runs.set_index("run_id")["rule"]


def repeat(seed: int, force: float = 1.0) -> Columns:
    """The same run again, with other noise."""
    random, values = np.random.default_rng(seed), good(SWEEP)
    noise = 0.02 * random.standard_normal(len(values["time"]))
    return {**values, "traction_force": force * values["traction_force"] + noise}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("logs", "expected"),
    [
        ({1: 1.0, 2: 1.0, 3: 1.3}, ["", "duplicate_condition", "conflicting_condition"]),
        nightly({1: 1.3, 2: 1.0, 3: 1.0}, ["conflicting_condition", "", "duplicate_condition"]),
        ({1: 1.0, 2: 1.3}, ["conflicting_condition"] * 2),
        # 9 % are within the limit for two runs
        ({1: 1.09, 2: 1.0, 3: 1.0}, ["conflicting_condition", "", "duplicate_condition"]),
    ],
)
def test_run_that_most_others_contradict_is_refused(
    logs: dict[int, float], expected: list[str]
) -> None:
    rule = together(**{f"log{seed}": csv(repeat(seed, by)) for seed, by in logs.items()})
    assert rule.tolist() == expected


@pytest.mark.slow
@pytest.mark.parametrize(
    ("load_n", "rule"), [(82.2, "duplicate_condition"), (83.0, "duplicate_condition"), (84.5, "")]
)
def test_pressure_that_is_rounded_is_the_condition_of_its_load(load_n: float, rule: str) -> None:
    """1.25 GPa are 82.18 N; half a per cent of pressure is one and a half of load."""
    by_load = csv(repeat(2), max_hertz_pressure_gpa=None, load_n=load_n)
    assert together(a=csv(repeat(1)), b=by_load).tolist() == ["", rule]


# --- true reasons ------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize(("key", "value"), [("settle_s", 800.0), nightly("window_s", 80.0)])
def test_time_of_the_settings_that_no_run_can_meet_is_blamed(key: str, value: float) -> None:
    config = CONFIG.with_changes({"curation": {"plateaus": {key: value}}})
    curated = curate_logs([("log", csv(good(SWEEP)))], config)
    assert rules(curated) == ["long_setting"]
    assert f"curation.plateaus.{key} is {value:g}" in curated.runs.at[0, "reason"]


def test_same_readings_that_begin_later_and_are_rounded_are_known_under_another_oil() -> None:
    values = good(SWEEP)
    later = {name: np.round(column[20:], 2) for name, column in values.items()}
    rule = together(a=csv(values), b=csv(later, oil="4050"))
    assert rule.tolist() == ["conflicting_labels"] * 2
