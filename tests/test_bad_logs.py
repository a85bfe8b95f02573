"""Every bad file of the corpus ends in the verdict written beside it."""

import hashlib

import pytest
from nptdms import RootObject

import formats
from bad_logs import BAD_LOGS, CONFIG, GOOD, KEYS, UNITS, Bad, good
from oilfilm.cli import check_logs
from oilfilm.errors import OilfilmError


def test_run_that_all_bad_ones_are_made_from_is_good() -> None:
    verdict = check_logs([("log", GOOD)], CONFIG)
    assert verdict.runs["verdict"].tolist() == ["accepted"]
    assert verdict.points["accepted"].all()
    assert verdict.quarantine.empty


@pytest.mark.parametrize("bad", BAD_LOGS, ids=lambda bad: bad.name)
def test_bad_log_gets_its_verdict_in_words(bad: Bad) -> None:
    verdict = check_logs([("log", bad.content)], bad.config or CONFIG)
    said = verdict.quarantine[["rule", "reason"]].to_dict("records")
    reasons = [each["reason"] for each in said if each["rule"] == bad.rule]
    assert reasons, said
    assert any(bad.words in reason for reason in reasons), reasons
    assert (verdict.quarantine["advice"] != "").all()
    assert bool(verdict.points["accepted"].any()) == bad.used


def test_corpus_holds_at_least_40_different_files() -> None:
    assert len(BAD_LOGS) >= 40
    assert len({bad.name for bad in BAD_LOGS}) == len(BAD_LOGS)
    assert len({hashlib.sha256(bad.content).digest() for bad in BAD_LOGS}) == len(BAD_LOGS)


def test_file_named_as_a_run_of_another_one_is_told() -> None:
    channels = [c for group in ("a", "b") for c in formats.tdms_channels(group, good(), UNITS)]
    log = formats.tdms_file([RootObject(KEYS), *channels])
    with pytest.raises(OilfilmError, match=r"^log:b: its run .* as one of log has already"):
        check_logs([("log", log), ("log:b", GOOD)], CONFIG)
