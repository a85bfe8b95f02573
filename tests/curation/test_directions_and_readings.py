"""Sweeps in both directions, settled readings, slow logs and other controls of the speed."""

import functools

import numpy as np
import pandas as pd
import pytest

from bad_logs import CONFIG, Columns, csv, good
from nights import nightly, quick_ones
from oilfilm.curation.curate import CuratedTables, collect, curate_logs
from oilfilm.curation.measure import measure_run
from oilfilm.curation.plateau_gates import PLATEAU_GATES, sentence_of
from oilfilm.curation.traction_rig import TractionRig

SLIPS = (0.02, 0.03, 0.05, 0.08, 0.12, 0.16, 0.20)
SECONDS, RATE_HZ = 4.0, 20
HELD = round(SECONDS * RATE_HZ)
PER_RPM = 2 * np.pi / 60
RIG = CONFIG.rigs["ball-on-disc-20mm"]
# of mu; noise and zero of `good`
WITHIN = 5e-4


def judged(values: Columns, **keys: object) -> CuratedTables:
    return curate_logs([("log", csv(values, **keys))], CONFIG)


def rules(curated: CuratedTables) -> list[str]:
    return curated.runs["rule"].tolist()


def signed(slips: tuple[float, ...]) -> Columns:
    """A sweep over slips of both signs: traction is odd in slip."""
    phases = np.array((0.0, *slips, 0.0))
    values = good(tuple(np.abs(phases)))
    direction = np.repeat(np.where(phases < 0, -1, 1), HELD)
    values["traction_force"] = direction * values["traction_force"]
    ball = values["ball_speed"] * RIG.ball_track_radius_m
    disc = values["disc_speed"] * RIG.disc_track_radius_m
    slow = np.where(direction < 0, disc, ball)
    fast = np.where(direction < 0, ball, disc)
    values["ball_speed"] = slow / RIG.ball_track_radius_m
    values["disc_speed"] = fast / RIG.disc_track_radius_m
    return values


NEGATIVE = tuple(-slip for slip in SLIPS)
BOTH = {
    "one after the other": (*SLIPS, *NEGATIVE),
    "negative first": (*NEGATIVE[::-1], *SLIPS),
    "negative only": NEGATIVE,
    "alternating": tuple(np.ravel([SLIPS, NEGATIVE], order="F")),
    "up and down in both": (*SLIPS, *SLIPS[::-1], *NEGATIVE, *NEGATIVE[::-1]),
}


HARD_SWEEPS = ["negative only", "alternating", "up and down in both"]


@functools.cache
def one_direction() -> CuratedTables:
    return judged(good((0.0, *SLIPS, 0.0)))


@pytest.mark.parametrize("name", quick_ones(BOTH, HARD_SWEEPS))
def test_points_of_both_directions_are_those_of_one(name: str) -> None:
    curated = judged(signed(BOTH[name]))
    assert rules(curated) == [""]
    assert curated.runs["warning"].tolist() == [()]
    points = curated.points[
        curated.points["accepted"] & (curated.points["slide_roll_ratio"] > 0.01)
    ]
    assert len(points) >= len(BOTH[name]) - 2  # equal neighbours are one plateau
    one = one_direction().points
    expected = np.interp(
        points["slide_roll_ratio"], one["slide_roll_ratio"], one["traction_coefficient"]
    )
    np.testing.assert_allclose(points["traction_coefficient"], expected, atol=WITHIN)


def test_zero_that_one_direction_adds_and_the_other_takes_off_is_named() -> None:
    values = signed(BOTH["one after the other"])
    sliding = np.s_[HELD:-HELD]
    values["traction_force"][sliding] += 0.004 * values["load"][sliding]
    curated = judged(values)
    assert rules(curated) == ["directions_differ"]
    assert "+0.008" in curated.runs["reason"].iloc[0]


def readings(offset_mu: float, slips: tuple[float, ...], scatter: float = 0.0) -> bytes:
    """A table of settled readings, as an MTM gives it."""
    slip = np.array(slips)
    mu = curve(slip) + offset_mu
    mu += scatter * np.random.default_rng(3).standard_normal(len(slip))
    return readings_of(slip, mu)


def curve(slip: np.ndarray) -> np.ndarray:
    return 0.05 * np.tanh(slip / 0.01)


def readings_of(slip: np.ndarray, mu: np.ndarray) -> bytes:
    """Settled readings of these traction coefficients."""
    names = "load_n,slide_roll_ratio,traction_coefficient,entrainment_speed_m_s"
    rows = [f"82.2,{one:.5f},{other:.5f},30" for one, other in zip(slip, mu, strict=True)]
    return "\n".join(
        [
            "# oil: 4102",
            "# log_kind: steps",
            "# inlet_temperature_c: 70",
            f"{names},inlet_temperature_c",
        ]
        + [f"{row},70" for row in rows]
        + [""]
    ).encode()


WITH_REST = (0.0, *SLIPS)


@pytest.mark.parametrize(
    ("offset", "slips", "rule"),
    [
        (0.0, WITH_REST, ""),
        (0.0035, WITH_REST, "zero_left"),
        (-0.0035, WITH_REST, "zero_left"),
        (0.0, (*SLIPS, *NEGATIVE), ""),
        (0.0035, (*SLIPS, *NEGATIVE), "zero_left"),
    ],
)
def test_zero_of_settled_readings_is_tested_where_they_allow_it(
    offset: float, slips: tuple[float, ...], rule: str
) -> None:
    curated = curate_logs([("log", readings(offset, slips, scatter=2e-4))], CONFIG)
    assert rules(curated) == [rule]
    assert curated.runs["warning"].tolist() == [()]


@pytest.mark.parametrize("nearest_mu", [0.0, nightly(2e-5), -1e-4])
def test_reading_of_no_traction_at_hardly_any_slip_is_no_zero_of_the_others(
    nearest_mu: float,
) -> None:
    """At a slip of 1e-4 the traction coefficient is 0.0005; a rig may round it to 0."""
    slip = np.array((1e-4, 0.01, *SLIPS))
    mu = curve(slip)
    mu[0] = nearest_mu
    curated = curate_logs([("log", readings_of(slip, mu))], CONFIG)
    assert rules(curated) == [""]


@pytest.mark.parametrize("last_load_n", [82.2, 0.0])
def test_force_in_another_unit_is_named_even_if_a_reading_has_no_load(last_load_n: float) -> None:
    lines = readings(0.0, WITH_REST).decode().splitlines()
    first_row = len(lines) - len(WITH_REST)
    lines[first_row - 1] = lines[first_row - 1].replace("traction_coefficient", "traction_force_n")
    for row in range(first_row, len(lines)):
        load, slip, mu, *others = lines[row].split(",")
        force_kn = float(mu) * float(load) / 1000
        load = str(last_load_n) if row == len(lines) - 1 else load
        lines[row] = ",".join([load, slip, f"{force_kn:.7f}", *others])
    curated = curate_logs([("log", ("\n".join(lines) + "\n").encode())], CONFIG)
    assert rules(curated) == ["no_traction"]


def test_zero_of_readings_that_nothing_tests_is_taken_on_trust() -> None:
    curated = curate_logs([("log", readings(0.0035, SLIPS))], CONFIG)
    assert rules(curated) == [""]
    (warnings,) = curated.runs["warning"]
    assert [text.partition(":")[0] for text in warnings] == ["zero_on_trust"]


def test_signal_against_time_is_no_table_of_settled_readings() -> None:
    ramp = good(tuple(np.linspace(0.0, 0.2, 400)), seconds=1 / RATE_HZ)
    assert rules(judged(ramp, log_kind="steps")) == ["no_settled_readings"]
    slips = tuple(np.linspace(0.0, 0.2, 400))
    assert rules(curate_logs([("log", readings(0.0, slips, 1e-4))], CONFIG)) == [
        "no_settled_readings"
    ]


def test_signal_without_time_is_no_table_of_settled_readings_even_if_it_begins_at_rest() -> None:
    """At rest the slide-roll ratio is 0/0."""
    slips = tuple(np.linspace(0.0, 0.2, 400))
    lines = readings(0.0, slips, 1e-4).decode().splitlines()
    first_row = next(index for index, line in enumerate(lines) if line.startswith("load_n")) + 1
    lines[first_row] = lines[first_row].replace(",30,", ",0,")
    log = ("\n".join(lines) + "\n").encode()
    assert rules(curate_logs([("log", log)], CONFIG)) == ["no_settled_readings"]


@pytest.mark.parametrize("interval_s", quick_ones([1.0, 2.0, 5.0, 10.0], [1.0, 10.0]))
def test_slow_log_has_its_zero_in_as_many_rows_as_it_needs(interval_s: float) -> None:
    values = good((0.0, *SLIPS, 0.0), seconds=1.0)
    # 20 rows of each slip
    values["time"] = interval_s * np.arange(len(values["time"]))
    curated = judged(values)
    assert rules(curated) == [""]
    assert curated.points["accepted"].sum() >= len(SLIPS)


def test_level_of_a_slow_log_that_ends_before_it_settles_has_no_duration() -> None:
    """3 rows of each level are cut off: nothing is left of 3 rows, and 3 of the last level's 6."""
    settings = CONFIG.with_changes({"curation": {"plateaus": {"settle_s": 30.0}}})
    slip = np.repeat([0.0, 0.02, 0.05, 0.08, 0.12, 0.2, 0.0], [24, 3, 3, 3, 3, 6, 24])
    rows = np.arange(len(slip))
    samples = {
        **dict.fromkeys(("load_n", "inlet_temperature_c"), np.full(len(slip), 80.0)),
        "row": rows,
        "time_s": 10.0 * rows,
        "traction_force_n": 80.0 * curve(slip),
        "ball_speed_m_s": 30 * (1 - slip / 2),
        "disc_speed_m_s": 30 * (1 + slip / 2),
    }
    signals = TractionRig.make_signals(samples, "", settings)
    plateaus = measure_run(signals, TractionRig(settings), "").plateaus
    is_sliding = plateaus["slide_roll_ratio"] > 0.01
    assert plateaus["duration_s"][is_sliding].tolist() == [0.0, 0.0, 0.0, 0.0, 30.0]


@pytest.mark.parametrize("body", ["faster", "slower"])
def test_speed_of_one_body_may_be_the_one_that_is_held(body: str) -> None:
    values = good((0.0, *SLIPS, 0.0))
    slip = np.repeat((0.0, *SLIPS, 0.0), HELD)
    factor = 1 / (1 + slip / 2) if body == "faster" else 1 / (1 - slip / 2)
    for name in ("ball_speed", "disc_speed"):
        values[name] = factor * values[name]
    curated = judged(values)
    assert rules(curated) == [""]
    (warnings,) = curated.runs["warning"]
    assert [text.partition(":")[0] for text in warnings] == ["body_at_set_speed"]
    points = curated.points[curated.points["accepted"]].sort_values("slide_roll_ratio")
    expected = 30 * np.interp(
        points["slide_roll_ratio"],
        np.sort(slip),
        np.sort(factor) if body == "slower" else -np.sort(-factor),
    )
    np.testing.assert_allclose(points["entrainment_speed_m_s"], expected, rtol=2e-3)


@pytest.mark.parametrize("body", ["ball_speed", "disc_speed"])
def test_speed_of_one_body_may_be_held_in_both_directions_of_slip(body: str) -> None:
    """The faster body is the disc in one direction and the ball in the other."""
    slips = (*SLIPS, *NEGATIVE)
    values = signed(slips)
    radius = RIG.ball_track_radius_m if body == "ball_speed" else RIG.disc_track_radius_m
    slip = np.repeat((0.0, *slips, 0.0), HELD)
    ratio_to_mean = 1 - slip / 2 if body == "ball_speed" else 1 + slip / 2
    np.testing.assert_allclose(values[body] * radius * PER_RPM, 30 * ratio_to_mean, rtol=2e-3)
    for name in ("ball_speed", "disc_speed"):
        values[name] = values[name] / ratio_to_mean
    curated = judged(values)
    assert rules(curated) == [""]
    assert curated.points["accepted"].all()
    (warnings,) = curated.runs["warning"]
    assert [text.partition(":")[0] for text in warnings] == ["body_at_set_speed"]
    assert "one body, in both directions" in warnings[0]


def test_held_speed_is_named_where_few_plateaus_are_accepted() -> None:
    """The mean speed of the only accepted plateau is off, and so it is not the held one."""
    values = good((0.0, *SLIPS, 0.0))
    slip = np.repeat((0.0, *SLIPS, 0.0), HELD)
    for name in ("ball_speed", "disc_speed"):
        values[name] = values[name] / (1 + slip / 2)
    measured = judged(values)
    is_last_slip = measured.points["slide_roll_ratio"] > SLIPS[-2] + 0.01
    points = measured.points.assign(accepted=is_last_slip)
    curated = collect(CuratedTables(points, measured.runs, measured.quarantine), CONFIG)
    assert points["accepted"].sum() == 1
    assert "body_at_set_speed: the speed of the faster body" in curated.runs["warning"].iloc[0][-1]


def test_equal_readings_of_a_flat_curve_are_no_stuck_sensor() -> None:
    flat = tuple(np.round(np.arange(0.05, 0.3, 0.02), 2))
    slip = np.array((0.0, 0.005, 0.01, 0.02, 0.03, *flat))
    # from a slip of 5 % on, all 13 readings are 0.0500
    curated = curate_logs([("log", readings_of(slip, curve(slip).round(4)))], CONFIG)
    assert rules(curated) == [""]


@pytest.mark.slow
def test_traction_at_a_slip_that_noise_hides_is_no_zero_that_was_left() -> None:
    """A slip of 0.005 may be within five of its standard errors; its 0.58 N are traction."""
    settings = CONFIG.with_changes({"campaign": {"semantics": {"zero": "already_removed"}}})
    rows = round(6.0 * RATE_HZ)
    first_slips = []
    for seed in range(5, 13):
        values = good((0.005, 0.06, 0.1, 0.15, 0.2), seconds=6.0)
        for name in ("load", "traction_force"):
            values[name] *= 4.25
        random = np.random.default_rng(seed)
        values["ball_speed"] *= 1 + 0.011 * random.standard_normal(len(values["time"]))
        log = csv(values, max_hertz_pressure_gpa=None)
        curated = curate_logs([("log", log)], settings)
        first = curated.points.iloc[0]
        first_slips.append(first["slide_roll_ratio"] / first["slide_roll_ratio_se"])
        assert first["last_row"] <= rows + 2
        assert "zero_left" not in rules(curated)
    assert min(first_slips) < CONFIG.gates.significant_errors


def test_run_without_a_temperature_is_none_in_which_it_moves() -> None:
    measured = one_direction()
    names = [f"{index}.csv" for index in range(6)]
    points = pd.concat([measured.points.assign(run_id=name) for name in names], ignore_index=True)
    for index, name in enumerate(names):
        points.loc[points["run_id"] == name, "slide_roll_ratio"] *= 1 + 0.01 * index
    runs = pd.concat([measured.runs.assign(run_id=name, file=name) for name in names])
    runs = runs.assign(content_sha256=names).reset_index(drop=True)
    settings = CONFIG.with_changes({"campaign": {"repeated_conditions": "accept"}})
    points.loc[points["run_id"].isin(names[:2]), "inlet_temperature_c"] = 70.0
    warned = {}
    for others in ("have none", "move"):
        if others == "have none":
            without = points["run_id"].isin(names[2:])
            judged_points = points.assign(
                inlet_temperature_c=points["inlet_temperature_c"].mask(without)
            )
        else:
            judged_points = points
        curated = collect(CuratedTables(judged_points, runs, measured.quarantine), settings)
        warned[others] = [
            run.run_id
            for run in curated.runs.itertuples()
            if any(text.startswith("constant_channel") for text in run.warning)
        ]
    assert warned == {"have none": [], "move": names[:2]}


UP, DOWN = (0.02, 0.035, 0.055, 0.085, 0.125, 0.165, 0.195), (0.2, 0.16, 0.12, 0.08, 0.05, 0.03)


def negative(slips: tuple[float, ...]) -> tuple[float, ...]:
    return tuple(-slip for slip in slips)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("parts", "is_rising"),
    [
        ((UP, DOWN), (True, False)),
        ((DOWN, UP), (False, True)),
        ((negative(DOWN), UP, DOWN, negative(UP)), (False, True, False, True)),
        ((UP, DOWN, negative(UP), negative(DOWN)), (True, False, True, False)),
    ],
    ids=["up and down", "down and up", "from most negative", "from zero"],
)
def test_traction_that_is_less_with_rising_slip_is_told_so(
    parts: tuple[tuple[float, ...], ...], is_rising: tuple[bool, ...]
) -> None:
    slip = np.concatenate(parts)
    factor = np.concatenate(
        [
            np.full(len(part), 0.92 if rises else 1.0)
            for part, rises in zip(parts, is_rising, strict=True)
        ]
    )
    curated = curate_logs([("log", readings_of(slip, factor * curve(slip)))], CONFIG)
    (warnings,) = curated.runs["warning"]
    (sentence,) = (text for text in warnings if text.startswith("branches_apart"))
    assert "with rising slip the traction coefficients are -8" in sentence


@pytest.mark.parametrize("parts", [(UP, DOWN), (DOWN, UP)], ids=["up and down", "down and up"])
def test_branches_are_compared_where_a_sweep_begins_and_ends_in_rolling(
    parts: tuple[tuple[float, ...], ...],
) -> None:
    first, second = parts
    values = good((0.0, *first, *second, 0.0))
    start = (1 + len(first)) * HELD
    values["traction_force"][start:-HELD] *= 1.5
    assert rules(judged(values)) == ["branches_differ"]


def test_largest_slip_names_the_limit_that_lets_it_pass() -> None:
    curated = judged(good((0.0, *SLIPS, 0.35, 0.42, 0.0)))
    points = curated.points
    beyond = points[[("slip_out_of_range" in gates) for gates in points["failed_gates"]]]
    rig = TractionRig(CONFIG)
    (slip_gate,) = (gate for gate in PLATEAU_GATES if gate.name == "slip_out_of_range")
    # rounded up: a limit of 0.42 may refuse half of the readings of 0.42
    assert "gates.slide_roll_ratio_max of 0.43" in sentence_of(slip_gate, beyond, rig)
    # no limit may be above 2, and slips in percent need another unit
    in_percent = beyond.assign(slide_roll_ratio=100 * beyond["slide_roll_ratio"])
    assert "slide_roll_ratio_max" not in sentence_of(slip_gate, in_percent, rig)


# the reader parts changes of 8 % and more (`set_point_changes.py`)
@pytest.mark.parametrize(("name", "factor"), [("load", 1.075), ("speed", 1.06)])
def test_two_conditions_in_one_log_are_named(name: str, factor: float) -> None:
    values = good((0.0, *SLIPS, 0.0, *SLIPS, 0.0))
    later = np.s_[(len(SLIPS) + 2) * HELD :]
    for column in ("load", "traction_force") if name == "load" else ("ball_speed", "disc_speed"):
        values[column][later] *= factor
    no_set_points = dict.fromkeys(("max_hertz_pressure_gpa", "entrainment_speed_m_s"))
    curated = judged(values, **no_set_points)
    assert rules(curated) == ["two_conditions"]
    assert (
        f"two {'loads' if name == 'load' else 'speeds'} in one log"
        in curated.runs["reason"].iloc[0]
    )


@pytest.mark.slow
def test_speed_that_is_off_at_all_slips_is_no_control_of_one_body() -> None:
    values = good((0.0, *SLIPS, 0.0))
    for name in ("ball_speed", "disc_speed"):
        # at slips of 2 to 10 % the slower body has the set speed within the tolerance
        values[name] = 1.03 * values[name]
    curated = judged(values)
    assert curated.points["accepted"].sum() == 0
