"""A raw log that has changed since a run first read it is refused, unless a reason is given."""

import re
from hashlib import sha256
from pathlib import Path

import pytest
import yaml

from oilfilm.base.errors import OilfilmError, printable
from oilfilm.logs.first_seen import FirstSeenDigests
from oilfilm.settings.campaign import AcknowledgedChange, Dataset
from oilfilm.settings.messages import first_mistake, validated

# A blank, a colon, quotes, a hash and a line separator, which YAML would take for its own, and a
# character beyond the first 65536.
LOG = Path('data/raw/june/run: 1 "a" #2 \u2028\U0001f6e2.csv')
OTHER = Path("data/raw/june/b.csv")
BEFORE, AFTER, LATER = (sha256(text).hexdigest() for text in (b"1.25", b"1.35", b"1.45"))


@pytest.fixture
def seen(tmp_path: Path) -> FirstSeenDigests:
    listing = FirstSeenDigests("june", folder=tmp_path)
    listing.check_and_add({LOG.as_posix(): BEFORE, OTHER.as_posix(): BEFORE}, [])
    return FirstSeenDigests("june", folder=tmp_path)


def refusal(seen: FirstSeenDigests, state: str, *acknowledged: AcknowledgedChange) -> str:
    """What is said of a log in this state; empty where it is accepted."""
    try:
        seen.check_and_add({LOG.as_posix(): state}, [each.model_dump() for each in acknowledged])
    except OilfilmError as error:
        return str(error)
    return ""


def pasted(message: str, reason: str) -> list[AcknowledgedChange]:
    """The entries of a campaign file that has the lines of a refusal."""
    lines = message.split("\n", 1)[1]
    written = yaml.safe_load(lines.replace("reason: ", f"reason: {reason}"))
    dataset: Dataset = validated(written, Dataset, lambda steps: "june.yaml")
    return dataset.acknowledged_changes


def test_digit_changed_in_a_log_is_refused_with_both_digests(seen: FirstSeenDigests) -> None:
    assert refusal(seen, BEFORE) == ""
    message = refusal(seen, AFTER)
    assert message.startswith(f"{printable(str(LOG))}: has changed since a run first read it")
    assert BEFORE[:16] in message
    assert AFTER[:16] in message
    assert "config/campaigns/june.yaml" in message


def test_pasted_lines_with_a_reason_keep_the_first_digest(
    seen: FirstSeenDigests, tmp_path: Path
) -> None:
    message = refusal(seen, AFTER)
    (change,) = pasted(message, "unit corrected")
    assert (change.log, change.reason) == (LOG.as_posix(), "unit corrected")
    written = yaml.safe_load(message.split("\n", 1)[1])
    assert "reason" in first_mistake(written, Dataset)
    digests = {LOG.as_posix(): AFTER, "data/raw/june/new.csv": AFTER}
    seen.check_and_add(digests, [change.model_dump()])
    lines = (tmp_path / "june.sha256").read_text(encoding="utf-8").split("\n")[:-1]
    # as `sha256sum -c` reads them
    assert lines == [f"{BEFORE}  {OTHER}", f"{AFTER}  data/raw/june/new.csv", f"{BEFORE}  {LOG}"]
    # a second change needs a reason of its own; a second list would be a duplicate key
    message = refusal(seen, LATER, change)
    assert "`acknowledged_changes`" in message
    assert "acknowledged_changes:\n" not in message
    assert refusal(seen, BEFORE, change) == ""


def test_log_of_an_earlier_run_that_is_gone_is_named(seen: FirstSeenDigests) -> None:
    assert (
        seen.sentence_on_missing([LOG.as_posix(), OTHER.as_posix(), "data/raw/june/new.csv"]) == ""
    )
    assert seen.sentence_on_missing([LOG.as_posix()]).startswith(
        "1 logs that an earlier run has read are gone"
    )
    assert OTHER.as_posix() in seen.sentence_on_missing([LOG.as_posix()])


@pytest.mark.parametrize("damage", [b" data/raw/", b"  data/raw/\xff"])
def test_damaged_listing_is_no_empty_one(
    seen: FirstSeenDigests, tmp_path: Path, damage: bytes
) -> None:
    path = tmp_path / "june.sha256"
    path.write_bytes(path.read_bytes().replace(b"  data/raw/", damage, 1))
    with pytest.raises(OilfilmError, match=re.escape(f"{path}, line 1: expected a sha256")):
        FirstSeenDigests("june", folder=tmp_path)


def test_last_line_of_an_edited_listing_counts_without_a_line_end(
    seen: FirstSeenDigests, tmp_path: Path
) -> None:
    path = tmp_path / "june.sha256"
    path.write_text(path.read_text(encoding="utf-8").rstrip("\n"), encoding="utf-8")
    assert LOG.as_posix() in FirstSeenDigests("june", folder=tmp_path).sentence_on_missing(
        [OTHER.as_posix()]
    )
