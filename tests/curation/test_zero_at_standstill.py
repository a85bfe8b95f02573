"""The zero of logs that stand still at both ends, and phases that only seem to roll."""

import re
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bad_logs import CONFIG, KEYS, Columns, csv
from nights import examples, nightly
from oilfilm.curation.curate import CuratedTables, curate_logs
from oilfilm.curation.rig_kind import Signals
from oilfilm.curation.zero import zero_reference
from standstill import LARGEST_MU, LEVELS, LOAD_N, UNITS, log, planted_mu

SHARE = CONFIG.curation.zero_reference.max_traction_share


def judged(values: Columns, zero: str) -> CuratedTables:
    campaign = {"semantics": {"zero": zero}, "film_unjudged": {"accept": True, "reason": "planted"}}
    keys = dict.fromkeys(set(KEYS) - {"oil"})
    config = CONFIG.with_changes({"campaign": campaign})
    return curate_logs([("log", csv(values, UNITS, **keys))], config)


def largest_error(curated: CuratedTables, slope: float = 5.0, shape: str = "exponential") -> float:
    points = curated.points[curated.points["accepted"]]
    truth = planted_mu(points["slide_roll_ratio"].to_numpy(), slope, shape)
    return float(np.abs(points["traction_coefficient"] - truth).max())


def reason(curated: CuratedTables) -> str:
    assert curated.runs["verdict"].tolist() == ["refused"]
    return str(curated.quarantine["reason"].iloc[0])


# 5 standard errors of a mean of 0.01 N over 2.5 s, twice, over the load
NOISE = 5 * np.sqrt(2) * 0.01 / np.sqrt(50) / LOAD_N + 2e-4


@pytest.mark.slow
@pytest.mark.parametrize(
    "run",
    [
        nightly({"offset_n": 0.35, "ramp_s": 0.0, "encoder_m_s": 5e-4}),
        nightly({"offset_n": -1.2}),
        {"offset_n": 0.35, "ramp_s": 4.0, "encoder_m_s": 5e-4},
        nightly({"still_s": (20.0, 0.0)}),
        {"still_s": (20.0, 0.7)},
        {"drift_n": 0.15},
    ],
)
def test_readings_at_standstill_give_the_zero(run: dict[str, Any]) -> None:
    curated = judged(log(**run), "standstill")
    assert curated.quarantine["rule"].tolist() == []
    assert curated.points["accepted"].tolist() == [True] * len(LEVELS)
    assert curated.points["n_spikes"].max() <= 1
    assert largest_error(curated) < NOISE


@pytest.mark.slow
@pytest.mark.parametrize(
    ("values", "rule", "words"),
    [
        (log(drift_n=0.4), "zero_drift", "moves by 0."),
        nightly(log(still_s=(0.0, 20.0)), "zero_missing", "no opening phase of standstill"),
        (log(still_s=(0.6, 20.0)), "zero_missing", "opening phase of standstill"),
    ],
)
def test_standstill_that_gives_no_zero_is_refused(values: Columns, rule: str, words: str) -> None:
    curated = judged(values, "standstill")
    assert curated.quarantine["rule"].tolist() == [rule]
    assert words in reason(curated)


@given(output=st.floats(-5, 5), per_s=st.floats(-0.1, 0.1), last_s=st.floats(30, 1000))
def test_linear_drift_of_zero_leaves_no_trace(output: float, per_s: float, last_s: float) -> None:
    """Mean of a line over a phase is its value at the mean time, so two phases give the line."""
    time_s = np.linspace(0, last_s, 400)
    line = output + per_s * time_s
    signals = Signals(np.arange(400), time_s, {"traction_force_n": line})
    phases = {"opening": slice(0, 60), "closing": slice(370, 400)}
    zero = zero_reference(signals, "traction_force_n", phases, 6.0)
    np.testing.assert_allclose(zero.zero_at(time_s), line, atol=1e-12)


ROLLING = {"levels": (0.0, *LEVELS[1:], 0.0), "still_s": (0.0, 0.0), "ramp_s": 0.0}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("run", "offset_n", "words"),
    [
        ({}, 0.35, "in the opening phase of standstill"),
        ({}, 0.0, ""),
        ({}, 0.1, ""),
        (ROLLING, 0.35, "without slip"),
        nightly(ROLLING, -0.35, "without slip"),
        (ROLLING, 0.0, ""),
    ],
)
def test_force_at_rest_contradicts_a_zero(run: dict[str, Any], offset_n: float, words: str) -> None:
    curated = judged(log(offset_n=offset_n, **run), "already_removed")
    assert curated.quarantine["rule"].tolist() == (["zero_left"] if words else [])
    if words:
        assert re.search(rf"is -?0\.3[45]\d* N {words}", reason(curated))
    else:
        assert largest_error(curated) < NOISE + offset_n / LOAD_N


def test_ramps_beside_a_standstill_are_no_part_of_the_levels() -> None:
    """With rolling at both ends the standstill is no zero, and its ramps were spikes."""
    levels = (0.0, *LEVELS[1:], 0.0)
    curated = judged(log(levels, ramp_s=3.0), "rolling_phases")
    assert curated.points["accepted"].tolist() == [True] * len(curated.points)
    assert curated.points["n_spikes"].max() <= 1
    assert largest_error(curated) < NOISE


def test_unit_of_a_load_is_offered_where_only_the_traction_shows_it() -> None:
    values = log(**ROLLING)
    curated = judged({**values, "load": values["load"] / 9.80665}, "rolling_phases")
    assert "kgf" in reason(curated)


@pytest.mark.parametrize(("zero", "is_seen"), [("opening_phase", False), ("rolling_phases", True)])
def test_zero_of_one_phase_is_named_as_blind_to_drift(zero: str, is_seen: bool) -> None:
    curated = judged(log((0.0, *LEVELS[1:], 0.0), still_s=(0, 0), ramp_s=0), zero)
    assert curated.runs["verdict"].tolist() == ["accepted"]
    (warnings,) = curated.runs["warning"]
    assert any(text.startswith("drift_not_seen") for text in warnings) != is_seen


@pytest.mark.slow
@given(
    offset_n=st.floats(-2, 2),
    slope=st.floats(1, 20),
    first=st.sampled_from([0.0, 0.0001, 0.0003, 0.0005, 0.001, 0.002, 0.003, 0.0039]),
    second=st.floats(0.005, 0.02),
    shape=st.sampled_from(["exponential", "tanh"]),
    seed=st.integers(0, 1000),
)
@examples(0.2)
def test_zero_of_an_opening_phase_is_right_or_refused(
    offset_n: float, slope: float, first: float, second: float, shape: str, seed: int
) -> None:
    levels = (first, *(second * np.array([1, 2, 3, 5, 8])))
    values = log(levels, offset_n, still_s=(0, 0), ramp_s=0, slope=slope, shape=shape, seed=seed)
    curated = judged(values, "opening_phase")
    accepted = curated.runs["verdict"].tolist() == ["accepted"]
    if accepted:
        # what the share allows, and the noise of the slope that it is judged by
        assert largest_error(curated, slope, shape) < 1.5 * SHARE * LARGEST_MU + NOISE
    assert accepted or first > 0
