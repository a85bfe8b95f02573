"""The memory that one log may take, measured in a process of its own."""

import io
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pyarrow as arrow
import pyarrow.parquet as parquet
import pytest

import formats
from bad_logs import CONFIG, HEAD, NAMES
from campaigns import ROOT
from oilfilm.logs.ingest import read_log

MEASURE = """
import json, resource, sys
from pathlib import Path
from oilfilm.logs.ingest import read_bytes, read_log
from oilfilm.settings.resolve import resolve
def peak():
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss >> 10
settings = resolve(Path("tests/laboratory"), {})
read_log(Path(sys.argv[2]).read_bytes(), "small", settings)
before = peak()
_, reading = read_log(read_bytes(Path(sys.argv[1])), "log", settings)
kept = sum(map(len, reading.runs))
print(json.dumps([peak() - before, kept, [each.rule for each in reading.refusals]]))
"""


def measured(log: Path) -> tuple[int, int, list[str]]:
    """MiB that reading a log takes beyond those of a small one, its rows, rules that refused it."""
    small = log.with_name("small.csv")
    small.write_bytes(formats.csv(formats.columns(9)))
    command = [sys.executable, "-c", MEASURE, str(log), str(small)]
    text = subprocess.check_output(command, cwd=ROOT, env={"PYTHONPATH": str(ROOT / "workflow")})
    mib, rows, rules = json.loads(text)
    return mib, rows, rules


def rows_as_text(row: bytes, count: int) -> bytes:
    return b"%s%s\n" % (HEAD, NAMES) + count * row


def texts_in_numbers_place() -> bytes:
    """A load that is text: a few kilobytes unfold to 160 MiB."""
    text = arrow.DictionaryArray.from_arrays(np.zeros(10, np.int8), ["x" * (1 << 24)])
    values = {name: arrow.array(np.zeros(10)) for name in formats.columns(1)}
    buffer = io.BytesIO()
    parquet.write_table(arrow.table({**values, "load": text}), buffer, compression="zstd")
    return buffer.getvalue()


# 20 hours at 50 Hz
TWENTY_HOURS = b"1000.02,82.341,0.05210,28650.12,7160.03,70.02\n", 3_600_000


@pytest.mark.no_cover
@pytest.mark.nightly
def test_no_log_takes_more_memory_than_it_may(tmp_path: Path) -> None:
    (tmp_path / "log").write_bytes(rows_as_text(*TWENTY_HOURS))
    mib, kept, refused = measured(tmp_path / "log")
    assert (kept, refused, mib < 512) == (3_600_000, [], True)
    (tmp_path / "log").write_bytes(texts_in_numbers_place())
    mib, kept, refused = measured(tmp_path / "log")
    assert (kept, refused, mib < 128) == (0, ["columns"], True)


def test_text_of_more_rows_than_any_log_is_refused() -> None:
    (refusal,) = read_log(rows_as_text(b"1,1,1,1,1,1\n", 4_500_001), "log", CONFIG)[1].refusals
    assert refusal.rule == "too_large"
