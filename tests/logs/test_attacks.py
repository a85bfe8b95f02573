"""Whatever happens to a file: a verdict, never a traceback, and no row lost."""

import itertools

import pytest

import bad_logs
from attacks import MUTATORS, attack, judge_bytes, rows_written
from bad_logs import PCS_CONFIG
from damages import SOUND
from formats import WRITERS
from nights import nightly
from oilfilm.base.randomness import generator
from oilfilm.curation.curate import curate_logs
from oilfilm.logs.ingest import read_log
from oilfilm.settings.resolved import Settings
from pcs_exports import film_export, traction_export


@pytest.mark.slow
@pytest.mark.parametrize("mutator", MUTATORS, ids=lambda mutator: mutator.__name__)
@pytest.mark.parametrize("rig", SOUND)
def test_every_row_of_a_damaged_log_is_accepted_or_refused(rig: str, mutator) -> None:
    """`make bench NAME=attack` takes 10 000 logs."""
    log, random = SOUND[rig], generator(1, "attack", rig)
    donor = SOUND["torque" if rig == "traction" else "traction"].text()
    content = mutator(log.text(), donor, random)
    runs = curate_logs([("log", content)], log.config, log.kind).runs
    written = rows_written(content)
    if len(runs) and written is not None:
        samples = runs["samples"].sum()
        # a line of blanks may be listed as a refused row
        assert samples <= written <= samples + runs["refused_rows"].sum()


# How many files of each format are damaged; `make bench NAME=fuzz` takes 20 000.
BY_DAY = [("traction", "csv"), ("torque", "lvm"), ("traction", "parquet"), ("torque", "tdms")]
CASES = [case if case in BY_DAY else nightly(*case) for case in itertools.product(SOUND, WRITERS)]
NUMBERS = pytest.mark.parametrize("files", [4, nightly(200)])


@pytest.mark.slow
@pytest.mark.no_cover
@NUMBERS
def test_damaged_pcs_logs_end_in_a_verdict(files: int) -> None:
    random = generator(1, "fuzz pcs")
    etm, ehd = traction_export(range(1, 6)), film_export()
    damaged = [attack(etm, ehd, random) for _ in range(files)]
    damaged += [attack(ehd, etm, random) for _ in range(files)]
    assert len({judge_bytes(each, PCS_CONFIG) for each in damaged}) >= 3


@pytest.mark.slow
@pytest.mark.no_cover
@NUMBERS
@pytest.mark.parametrize(("rig", "name"), CASES)
def test_damaged_logs_of_every_format_end_in_a_verdict(rig: str, name: str, files: int) -> None:
    log, random = SOUND[rig], generator(2, f"fuzz {rig} {name}")
    content = log.written(name)
    damaged = [content[: int(share * len(content))] for share in (0.03, 0.5, 0.9, 0.999)]
    damaged += [attack(content, log.text(), random) for _ in range(files)]
    assert len({judge_bytes(each, log.config, log.kind) for each in damaged}) >= 2


@pytest.mark.parametrize("content", [b"", b"\n", b"\0", b"#", b"# oil: 4102", b"\xef\xbb\xbf"])
def test_next_to_nothing_ends_in_a_verdict(config: Settings, content: bytes) -> None:
    assert judge_bytes(content, config) in {"unknown_format", "columns"}


@pytest.mark.parametrize("zeros", [1, 3])
def test_rows_of_a_text_that_zero_bytes_hide_are_counted(zeros: int) -> None:
    content = bad_logs.csv(bad_logs.good())
    damaged = content[:10] + zeros * b"\0" + content[10 + zeros :]
    _, reading = read_log(damaged, "log", bad_logs.CONFIG)
    (refusal,) = reading.refusals
    # five lines are above the rows
    rows = content.count(b"\n") - 5
    assert (refusal.rule, refusal.refused_rows) == ("unknown_format", rows)
