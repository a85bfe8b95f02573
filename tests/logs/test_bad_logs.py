"""Every bad file of the corpus ends in the verdict written beside it."""

from collections.abc import Callable, Mapping
from functools import partial

import numpy as np
import pytest
from nptdms import RootObject
from pandas.testing import assert_frame_equal

import formats
from bad_logs import (
    BAD_LOGS,
    CONFIG,
    GOOD,
    KEYS,
    UNITS,
    UNITS_TWICE,
    Bad,
    Columns,
    csv,
    good,
    logged_twice,
)
from oilfilm.curation.curate import check_logs
from oilfilm.errors import OilfilmError
from oilfilm.logs.ingest import read_log


@pytest.mark.parametrize("write", [csv, partial(formats.tdms, keys=KEYS)])
def test_quantities_logged_twice_are_compared_and_cost_no_row(
    write: Callable[[Columns, Mapping[str, str]], bytes],
) -> None:
    values = logged_twice()
    values["slide_roll_ratio"][[5, 100]] = np.nan
    once = check_logs([("log", write(good(), UNITS))], CONFIG)
    twice = check_logs([("log", write(values, UNITS_TWICE))], CONFIG)
    assert twice.quarantine.empty
    assert_frame_equal(twice.points, once.points)


def text_beside(write: Callable[..., bytes]) -> bytes:
    values = {**good(), "slide_roll_ratio": np.array(["fast"] * len(good()["load"]))}
    return write(values, UNITS_TWICE, KEYS)


@pytest.mark.parametrize("write", [formats.tdms, formats.as_parquet])
def test_column_of_words_that_no_run_needs_is_let_be(write: Callable[..., bytes]) -> None:
    verdict = check_logs([("log", text_beside(write))], CONFIG)
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
    units = {**UNITS_TWICE, "ball_speed": "m/s", "disc_speed": "m/s", "entrainment_speed": "m/s"}
    for slip, disagrees in ((0.02, False), (0.04, True)):
        log = csv({**values, "slide_roll_ratio": 100 * slip * turning}, units)
        (run,) = read_log(log, "log", CONFIG)[1].runs
        assert (run.flaw is not None) == disagrees
        if run.flaw is not None:
            assert run.flaw.rule == "columns_disagree"
            assert run.flaw.reason.startswith("slide_roll_ratio")


@pytest.mark.parametrize("bad", BAD_LOGS, ids=lambda bad: bad.name)
def test_bad_log_gets_its_verdict_in_a_sentence(bad: Bad) -> None:
    verdict = check_logs([("log", bad.content)], bad.config)
    reasons = verdict.quarantine.loc[verdict.quarantine["rule"] == bad.rule, "reason"]
    assert any(bad.sentence in reason for reason in reasons), verdict.quarantine["reason"].tolist()
    assert (verdict.quarantine["advice"] != "").all()
    assert bool(verdict.points["accepted"].any()) == bad.used


def test_file_named_as_a_run_of_another_one_is_told() -> None:
    channels = [c for group in ("a", "b") for c in formats.tdms_channels(group, good(), UNITS)]
    log = formats.tdms_file([RootObject(KEYS), *channels])
    with pytest.raises(OilfilmError, match=r"^log:b: its run .* which a run of log has already"):
        check_logs([("log", log), ("log:b", GOOD)], CONFIG)
