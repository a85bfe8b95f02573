"""Continuous ramps of slip give the planted curve and the planted lag, or are refused."""

from collections.abc import Callable

import numpy as np
import pytest
import scipy
from hypothesis import given
from hypothesis import strategies as st

from bad_logs import CONFIG, csv
from campaigns import rig_contact
from nights import examples, nightly, quick_ones
from oilfilm.curation import ramps
from oilfilm.curation.curate import CuratedTables, curate_logs
from oilfilm.curation.rig_kind import ForceLag, Signals
from oilfilm.curation.traction_rig import TractionRig
from oilfilm.physics.contact import load_for_max_hertz_pressure
from oilfilm.settings.resolved import Settings

SPEED_M_S = 30.0
LARGEST_SLIP = 0.26
Slip = Callable[[np.ndarray], np.ndarray]


def mu(slip: np.ndarray) -> np.ndarray:
    """A planted curve: it rises, has one peak and falls by heat. No law of the library has it."""
    size = np.abs(slip)
    rise = 90 * size / (1 + (90 * size) ** 1.7) ** (1 / 1.7)
    return np.sign(slip) * 0.055 * rise / (1 + 1.5 * size)


def line(*corners: tuple[float, float]) -> Slip:
    times, slips = zip(*corners, strict=True)
    return lambda time: np.interp(time, times, slips)


def sine(time: np.ndarray) -> np.ndarray:
    moving = (time > 5) & (time < 125)
    return np.where(moving, LARGEST_SLIP / 2 * (1 - np.cos(2 * np.pi * (time - 5) / 120)), 0.0)


def by_equal_factors(time: np.ndarray) -> np.ndarray:
    """From 0.002 to the largest slip and back, in 120 s."""
    share = np.clip(1 - np.abs(time - 65) / 60, 0.0, 1.0)
    return np.where(share > 0, 0.002 * (LARGEST_SLIP / 0.002) ** share, 0.0)


ROLLING = (0.0, 0.0), (5.0, 0.0)
TRIANGLE = line(*ROLLING, (65, LARGEST_SLIP), (125, 0), (130, 0))
TWO_TRIANGLES = line(*ROLLING, (35, 0.26), (65, 0), (95, 0.26), (125, 0), (130, 0))
BOTH_DIRECTIONS = line(*ROLLING, (35, 0.1), (95, -0.1), (125, 0), (130, 0))
ONE_WAY = line(*ROLLING, (125, LARGEST_SLIP))
FALL_TO_ROLLING = line(*ROLLING, (125, LARGEST_SLIP), (125.05, 0), (135, 0))
SWEEPS: dict[str, Slip] = {
    "triangle": TRIANGLE,
    "two triangles": TWO_TRIANGLES,
    "sine": sine,
    "by equal factors": by_equal_factors,
    "both directions": BOTH_DIRECTIONS,
    "one way and a fall": FALL_TO_ROLLING,
}


def ramp(
    slip: Slip,
    lag_s: float = 0.6,
    rate_hz: float = 20.0,
    noise_n: float = 0.02,
    seconds: float = 130.0,
    drift_n: float = 0.0,
    delay_s: float = 0.0,
    zero_n: float = 0.3,
    load_factor: float = 1.0,
    seed: int = 3,
) -> bytes:
    """A log of a ramp; the force is late by a filter of first order and a delay."""
    random = np.random.default_rng(seed)
    # the filter works between the rows
    steps_per_row = max(int(np.ceil(200 / rate_hz)), 1)
    step_s = 1 / (rate_hz * steps_per_row)
    time = np.arange(round(seconds / step_s)) * step_s
    contact = rig_contact()
    load_n = load_for_max_hertz_pressure(1.25e9, contact.radius_m, contact.reduced_modulus_pa)
    late = slip(np.maximum(time - delay_s, 0.0))
    force_n = mu(late) * load_n
    if lag_s:
        kept = np.exp(-step_s / lag_s)
        force_n = scipy.signal.lfilter([1 - kept], [1, -kept], force_n)
    rows = slice(None, None, steps_per_row)
    time, force_n = time[rows], force_n[rows]
    rig = CONFIG.rigs["ball-on-disc-20mm"]
    per_rpm = 2 * np.pi / 60

    def noise(size: float) -> np.ndarray:
        return size * random.standard_normal(len(time))

    half = slip(time) / 2
    ball = SPEED_M_S * (1 - half) + noise(0.005)
    disc = SPEED_M_S * (1 + half) + noise(0.005)
    return csv(
        {
            "time": time,
            "load": load_factor * load_n + noise(0.1) * (load_factor != 0),
            "traction_force": zero_n + drift_n * time / seconds + force_n + noise(noise_n),
            "ball_speed": ball / (per_rpm * rig.ball_track_radius_m),
            "disc_speed": disc / (per_rpm * rig.disc_track_radius_m),
            "inlet_temperature": 70 + noise(0.05),
        }
    )


def curated(log: bytes, settings: Settings = CONFIG) -> CuratedTables:
    return curate_logs([("ramp.csv", log)], settings)


def with_zero(source: str) -> Settings:
    return CONFIG.with_changes({"campaign": {"semantics": {"zero": source}}})


def verdict(judged: CuratedTables) -> tuple[str, str]:
    (run,) = judged.runs.to_dict("records")
    return str(run["verdict"]), str(run["rule"])


def warning_of_lag(judged: CuratedTables) -> str:
    (warnings,) = judged.runs["warning"]
    (text,) = [text for text in warnings if text.startswith("slip_ramp")]
    return str(text)


def check_curve(judged: CuratedTables, relative: float) -> None:
    """Compare the accepted points with the planted curve."""
    points = judged.points[judged.points["accepted"]]
    assert len(points) >= 8
    true = mu(points["slide_roll_ratio"].to_numpy())
    error = points["traction_coefficient"].to_numpy() - true
    standard_error = points["traction_coefficient_se"].to_numpy()
    assert np.sqrt(np.mean((error / true) ** 2)) < relative
    # points of one run share the errors of zero and lag: two standard errors of these
    assert np.median(np.abs(error / standard_error)) < 2
    assert np.abs(error).max() < 6 * standard_error.max()


# the other tests have triangles
HARD_SWEEPS = ["by equal factors", "both directions", "one way and a fall"]


@pytest.mark.slow
@pytest.mark.parametrize("sweep", quick_ones(SWEEPS, HARD_SWEEPS))
@pytest.mark.parametrize("lag_s", quick_ones([0.05, 0.6, 1.5], [0.6]))
def test_ramp_gives_the_planted_curve_whatever_the_lag_is(sweep: str, lag_s: float) -> None:
    judged = curated(ramp(SWEEPS[sweep], lag_s, seconds=135))
    assert verdict(judged) == ("accepted", "")
    check_curve(judged, 0.015)
    lag = float(warning_of_lag(judged).partition("which is ")[2].partition(" +-")[0])
    assert lag == pytest.approx(lag_s, abs=0.1)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("rate_hz", "noise_n", "relative"),
    # 0.2 N is 3 % of the largest force, and 10 % of the smallest one that is read
    [nightly(5, 0.02, 0.015), (20, 0.2, 0.03), nightly(100, 0.2, 0.015), (1000, 0.2, 0.015)],
)
def test_ramps_of_all_rates_are_read(rate_hz: float, noise_n: float, relative: float) -> None:
    check_curve(curated(ramp(TRIANGLE, rate_hz=rate_hz, noise_n=noise_n)), relative)


def test_slow_ramp_of_a_slow_log() -> None:
    slow = line((0, 0), (20, 0), (620, 0.26), (1220, 0), (1240, 0))
    check_curve(curated(ramp(slow, rate_hz=1, seconds=1240)), 0.01)


def test_delay_is_found_as_a_filter_is() -> None:
    judged = curated(ramp(TRIANGLE, lag_s=0.2, delay_s=0.5))
    check_curve(judged, 0.01)
    assert "0.7" in warning_of_lag(judged)


@pytest.mark.slow
def test_lag_that_nothing_shows_widens_the_errors_and_is_named() -> None:
    judged = curated(ramp(ONE_WAY, 0.6, seconds=125), with_zero("opening_phase"))
    assert verdict(judged) == ("accepted", "")
    assert "0 to 2 s" in warning_of_lag(judged)
    check_curve(judged, 0.05)
    # a rig file that states the lag takes the doubt away
    settings = with_zero("opening_phase")
    stated = settings.with_changes(
        {"rigs": {"ball-on-disc-20mm": {"force_lag_s_range": [0.6, 0.6]}}}
    )
    known = curated(ramp(ONE_WAY, 0.6, seconds=125), stated)
    check_curve(known, 0.02)
    error = "traction_coefficient_se"
    low = judged.points["slide_roll_ratio"].idxmin()
    assert known.points[error].iloc[low] < judged.points[error].iloc[low] / 2


def test_lag_beyond_its_range_is_refused_for_it() -> None:
    judged = curated(ramp(TRIANGLE, 3.5))
    assert verdict(judged) == ("refused", "slip_ramps")


def test_lag_that_contradicts_the_stated_one_is_refused() -> None:
    stated = {"rigs": {"ball-on-disc-20mm": {"force_lag_s_range": [0.8, 1.5]}}}
    judged = curated(ramp(TRIANGLE, 0.3), CONFIG.with_changes(stated))
    assert verdict(judged) == ("refused", "slip_ramps")


@pytest.mark.parametrize(("zero_n", "rule"), [(0.0, ""), (0.3, "zero_left")])
def test_zero_that_is_said_to_be_removed_is_tested_where_the_rig_rolls(
    zero_n: float, rule: str
) -> None:
    judged = curated(ramp(TRIANGLE, zero_n=zero_n), with_zero("already_removed"))
    assert verdict(judged)[1] == rule
    if not rule:
        check_curve(judged, 0.01)


def test_ramp_that_is_too_fast_for_a_curve_is_refused_for_it() -> None:
    fast = line((0, 0), (3, 0), (4, LARGEST_SLIP), (5, 0), (8, 0))
    judged = curated(ramp(fast, 0.05, rate_hz=1000, seconds=8))
    assert verdict(judged) == ("refused", "slip_ramps")


@pytest.mark.slow
@given(
    period_s=st.floats(0.1, 60),
    largest_slip=st.floats(0.001, 1.5),
    rate_hz=st.sampled_from([1.0, 5.0, 20.0, 200.0]),
    load_factor=st.sampled_from([1.0, 0.0, -1.0]),
    zero=st.sampled_from(["rolling_phases", "opening_phase", "standstill", "already_removed"]),
)
@examples(0.1)
def test_any_slip_that_moves_ends_in_a_verdict(
    period_s: float, largest_slip: float, rate_hz: float, load_factor: float, zero: str
) -> None:
    """A reading of a slip that moves is right within its errors, or the run is refused."""

    def swings(time: np.ndarray) -> np.ndarray:
        return largest_slip * np.sin(2 * np.pi * time / period_s)

    log = ramp(swings, 0.1, rate_hz, seconds=65, zero_n=0.0, load_factor=load_factor)
    judged = curated(log, with_zero(zero))
    if verdict(judged)[0] == "accepted":
        points = judged.points[judged.points["accepted"]]
        true = np.abs(mu(points["slide_roll_ratio"].to_numpy()))
        error = np.abs(points["traction_coefficient"].to_numpy() - true)
        allowed = 5 * points["traction_coefficient_se"].to_numpy().max() + 0.03 * true.max()
        assert np.median(error) < allowed


def test_slip_whose_late_force_comes_after_the_log_is_no_point() -> None:
    """The slip rises by 0.0125 in a second. With a lag of 2 s no row shows mu from 0.075 on."""
    time_s = np.arange(0.0, 13.0, 1 / 10)
    slip = line(*ROLLING, (13, 0.1))(time_s)
    random = np.random.default_rng(2)
    signals = Signals(
        np.arange(len(time_s)),
        time_s,
        {
            "slide_roll_ratio": slip,
            "load_n": np.full(len(time_s), 80.0),
            "traction_force_n": 80.0 * mu(slip) + 0.004 * random.standard_normal(len(time_s)),
        },
    )
    points = ramps.ramp_points(signals, (0.0, 2.0), 1, smallest_slip=0.004, spike_threshold=8.0)
    assert points is not None
    assert len(points.slip) >= ramps.FEWEST_RAMP_POINTS
    assert points.mu_se.max() < mu(slip).max()


@pytest.mark.parametrize(("relative_error", "rule"), [(0.09, "slip_ramps"), (0.03, None)])
def test_ramp_of_small_slips_is_judged_by_its_error_too(
    relative_error: float, rule: str | None
) -> None:
    slip = np.array([0.006, 0.008, 0.011, 0.015, 0.019])
    points = ramps.RampPoints(
        slip=slip,
        mu=mu(slip),
        mu_se=relative_error * mu(slip),
        starts=np.arange(5),
        stops=np.arange(1, 6),
        spike_counts=np.zeros(5, dtype=np.int64),
        lag=ForceLag(1.0, 0.6, is_seen=False, tried_range_s=(0.0, 2.0)),
        drift_n=0.0,
    )
    assert slip.max() < CONFIG.gates.sign_slip_min
    refusal = TractionRig(CONFIG)._ramp_refusal(points)
    assert (refusal and refusal.rule) == rule


@pytest.mark.slow
@pytest.mark.parametrize("zero_term_count", quick_ones([0, 2], [2]))
def test_error_of_a_row_counts_every_parameter_of_the_fit(zero_term_count: int) -> None:
    """Noise that a fit takes away, over its variance: the number of parameters in the mean."""
    row_count, noise_n, load_n = 300, 0.05, 120.0
    time_s = np.linspace(0.0, 130.0, row_count)
    slip = TRIANGLE(time_s)
    signals = Signals(
        np.arange(row_count),
        time_s,
        {"slide_roll_ratio": slip, "load_n": np.full(row_count, load_n)},
    )
    lagged_force_n = np.interp(time_s - 0.9, time_s, load_n * mu(slip))
    random = np.random.default_rng(1)
    taken_away = []
    for _ in range(20):
        noise = noise_n * random.standard_normal(row_count)
        rows = ramps._averaged_ramp(signals, lagged_force_n + noise)
        knots = ramps._make_knots(rows, 1.4)
        residual = ramps._lag_fit(rows, knots, 2.0, zero_term_count).fun
        taken_away.append((np.sum(noise**2) - np.sum(residual**2)) / noise_n**2)
    standard_error = np.std(taken_away) / np.sqrt(len(taken_away))
    parameter_count = ramps._parameter_count(knots, zero_term_count)
    assert abs(np.mean(taken_away) - parameter_count) < 3 * standard_error
    # a residual that alternates has no autocorrelation that makes its error larger
    alternating = np.resize([1.0, -1.0], row_count)
    variance = ramps._variance_for_means(alternating, parameter_count)
    assert variance == pytest.approx(row_count / (row_count - np.mean(taken_away)), rel=0.02)


@pytest.mark.slow
def test_zero_is_found_by_both_directions_or_refused() -> None:
    without_rolling = line((0, -0.1), (60, 0.1), (120, -0.1))
    judged = curated(ramp(without_rolling, 0.3, seconds=120))
    assert verdict(judged) == ("accepted", "")
    check_curve(judged, 0.02)
    assert verdict(curated(ramp(ONE_WAY, seconds=125))) == ("refused", "zero_missing")


@pytest.mark.slow
@pytest.mark.parametrize(("drift_n", "rule"), [nightly(0.1, ""), (0.5, "zero_drift")])
def test_zero_that_drifts_is_followed_or_refused(drift_n: float, rule: str) -> None:
    judged = curated(ramp(TRIANGLE, drift_n=drift_n))
    assert verdict(judged)[1] == rule
    if not rule:
        check_curve(judged, 0.01)


def test_spikes_of_the_force_are_left_out() -> None:
    lines = ramp(TRIANGLE).decode().splitlines()
    first_row = 1 + next(row for row, text in enumerate(lines) if text.startswith("time"))
    for row in range(first_row + 200, len(lines), 300):
        cells = lines[row].split(",")
        cells[2] = str(float(cells[2]) + 5)
        lines[row] = ",".join(cells)
    judged = curated(("\n".join(lines) + "\n").encode())
    assert judged.points["n_spikes"].sum() >= 5
    check_curve(judged, 0.01)


def test_steps_with_much_noise_are_no_ramp() -> None:
    edges = np.arange(5, 5 + 3.0 * 14, 3.0)
    levels = np.array([0.0, *np.linspace(0.02, 0.26, 13), 0.0])
    stairs = lambda time: levels[np.searchsorted(edges, time, side="right")]  # noqa: E731
    random = np.random.default_rng(5)
    values = ramp(stairs, 0.05, seconds=52).decode().splitlines()
    first_row = 1 + next(row for row, text in enumerate(values) if text.startswith("time"))
    for row in range(first_row, len(values)):
        cells = values[row].split(",")
        # each speed scatters by 1 %
        cells[3:5] = [
            str(float(cell) * (1 + 0.01 * random.standard_normal())) for cell in cells[3:5]
        ]
        values[row] = ",".join(cells)
    judged = curated(("\n".join(values) + "\n").encode())
    assert "continuous ramp" not in judged.runs["reason"].iloc[0]
    (warnings,) = judged.runs["warning"]
    assert not any(text.startswith("slip_ramp") for text in warnings)


def test_steps_that_are_held_briefly_are_no_ramp() -> None:
    edges = np.arange(5, 5 + 0.9 * 15, 0.9)
    levels = np.array([0.0, *np.linspace(0.01, 0.26, 14), 0.0])
    stairs = lambda time: levels[np.searchsorted(edges, time, side="right")]  # noqa: E731
    judged = curated(ramp(stairs, 0.05, seconds=25))
    assert verdict(judged)[0] == "refused"
    (warnings,) = judged.runs["warning"]
    assert not any(text.startswith("slip_ramp") for text in warnings)


@pytest.mark.parametrize("wrong_load_n", [nightly(0.0), nightly(-0.05), 500.0])
def test_one_wrong_load_in_a_ramp_costs_nothing(wrong_load_n: float) -> None:
    log = ramp(TRIANGLE)
    lines = log.decode().splitlines()
    names = next(line for line in lines if line.startswith("time"))
    load_index = [name.startswith("load") for name in names.split(",")].index(True)
    row = lines.index(names) + 1200
    cells = lines[row].split(",")
    cells[load_index] = str(wrong_load_n)
    lines[row] = ",".join(cells)
    judged = curated("\n".join([*lines, ""]).encode())
    assert verdict(judged) == ("accepted", "")
    check_curve(judged, 0.01)
    assert len(judged.points) == len(curated(log).points)
