"""Raw logs to samples: every row of every file ends in samples or in quarantine.

One module reads one format. A format is recognised by the content of a file, never by its name.

Decides: which formats of logs are read; where each row of a raw log ends: in samples or in
quarantine.
"""

import hashlib
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any, Protocol

import numpy as np
import pandas as pd
import pyarrow as arrow

from oilfilm import tables
from oilfilm.errors import OilfilmError, printable
from oilfilm.logs import base, delimited_text, lvm, parquet, pcs, tdms
from oilfilm.logs.columns import ROWS_ADVICE, Found, read_tables
from oilfilm.logs.log_kind import LogKind, Vocabulary
from oilfilm.logs.raw_files import LARGEST_LOG
from oilfilm.logs.run_sheet import NO_SHEET, RunSheet
from oilfilm.logs.traction_log import TRACTION
from oilfilm.settings.resolved import Settings
from oilfilm.tables import LARGEST
from oilfilm.tables.table_file import digests_of_runs


class Reader(Protocol):
    """A module that reads one format."""

    def recognises(self, head: bytes) -> bool:
        """True where the first bytes of a file look like this format."""
        ...

    def tables(self, content: bytes, vocabulary: Vocabulary) -> Found:
        """How the text of a file is written, and its tables: names, units, keys, numbers.

        Raises:
            UnreadableLogError: Nothing of the file can be used.
            Exception: Whatever the library of a binary format stumbles over in a damaged file.
        """
        ...


# The first reader that recognises a file reads it. The reader of csv takes any text in columns, so
# it comes last.
READERS: dict[str, Reader] = {
    "tdms": tdms,
    "parquet": parquet,
    "lvm": lvm,
    "pcs": pcs,
    "csv": delimited_text,
}
# How files begin that are no logs.
FOREIGN = {
    b"PK\x03\x04": "an Excel workbook or a zip archive: export it as csv, or unpack it",
    b"TDSh": "the index of a tdms log without its data: take the file .tdms beside it",
    b"\x1f\x8b": "a log that was packed twice: unpack it once",
}
# Formats that a library reads: whatever it raises, the file is damaged.
BINARY = frozenset({"tdms", "parquet"})


def recognised_format(content: bytes) -> str | None:
    """The name of the format of a file's bytes; None where no reader recognises them."""
    head = content[:4096]
    if head.startswith(tuple(FOREIGN)):
        return None
    return next((name for name, reader in READERS.items() if reader.recognises(head)), None)


_LONGEST_LABEL = 200
_UNSUSPICIOUS = 1 << 24
_COMPRESSED = {b"\x1f\x8b": "gzip", b"\x28\xb5\x2f\xfd": "zstd"}


@dataclass(frozen=True)
class ReadLog:
    """How one raw file was understood: its format, its rows, and the columns of each run."""

    file: str
    format: str
    form: base.TextForm
    rows: int
    runs: Mapping[str, base.Understood]


@dataclass(frozen=True)
class Ingested:
    """What a share of a campaign's raw files holds; `samples` by oil."""

    samples: dict[str, pd.DataFrame]
    runs: pd.DataFrame
    quarantine: pd.DataFrame
    logs: list[ReadLog]

    def all_samples(self) -> pd.DataFrame:
        """The samples of all oils, the rows of a run together."""
        frames = [frame for frame in self.samples.values() if len(frame)]
        return pd.concat(frames, ignore_index=True) if frames else tables.empty("samples")


def ingest_logs(
    logs: Iterable[tuple[str, bytes]],
    settings: Settings,
    kind: LogKind = TRACTION,
    sheet: RunSheet = NO_SHEET,
    keep: Callable[[base.LoggedRun], None] | None = None,
    verified: Mapping[str, str] | None = None,
) -> Ingested:
    """Read raw logs, given by name and bytes, into samples, runs and quarantine.

    Args:
        logs: Name and bytes of each log.
        settings: Settings of the run.
        kind: The kind of log.
        sheet: The run sheet; what it says of a log beats its header.
        keep: Gets one run after the other; the samples that are returned are empty then.
        verified: sha256 of logs by name, where it is known when the log is read.

    Raises:
        OilfilmError: A log has the name of a run of another one.
        RuntimeError: A reader lost a row (a defect of oilfilm, never of the log).
    """
    logged: dict[str, list[base.LoggedRun]] = {oil: [] for oil in settings.oils}
    runs: list[dict[str, Any]] = []
    refused: list[dict[str, Any]] = []
    file_of_run: dict[str, str] = {}
    read: list[ReadLog] = []
    for file, content in logs:
        reader, reading = read_log(content, file, settings, kind, sheet)
        understood = {run.run_id: run.understood for run in reading.runs}
        read.append(ReadLog(file, reader, reading.form, reading.rows, understood))
        about = {"campaign": settings.campaign.name, "file": file}
        digest = (verified or {}).get(file) or hashlib.sha256(content).hexdigest()
        of_file = {**about, "sha256": digest, "content_sha256": reading.unpacked_sha256 or digest}
        of_file |= {"reader": reader, **asdict(reading.form)}
        for run in reading.runs:
            other = file_of_run.setdefault(run.run_id, file)
            if other != file:
                found = f"its run gets the name {run.run_id!r}, which a run of {other} has already"
                raise OilfilmError(f"{file}: {found}. Rename the file.")
            rows = sum(each.refused_rows for each in reading.refusals if each.run_id == run.run_id)
            runs.append({**of_file, **_about_run(run), "refused_rows": rows})
            (keep or logged[run.oil].append)(run)
        refused += [{**about, "stage": "ingest", **asdict(each)} for each in reading.refusals]
    about = {"campaign": settings.campaign.name, "file": sheet.name, "stage": "ingest"}
    refused += [{**about, **asdict(remark)} for remark in sheet.remarks]
    samples = {oil: _together(of_oil) for oil, of_oil in logged.items()}
    listed = tables.from_rows(runs, "runs"), tables.from_rows(refused, "quarantine")
    return Ingested(samples, *listed, read)


@contextmanager
def sample_files(
    paths: Mapping[str, Path], provenance: Mapping[str, Any]
) -> Iterator[Callable[[base.LoggedRun], None]]:
    """Write the samples of runs as they come, so that memory does not grow with their number.

    A row group has whole runs: as many as `tables.ROW_GROUP` rows hold, or a single longer one.
    The footer gets `content`, the digest of each run's samples.

    Args:
        paths: File of each oil.
        provenance: As `tables.writing`.
    """
    waiting: dict[str, list[base.LoggedRun]] = {oil: [] for oil in paths}
    content: dict[str, dict[str, str]] = {oil: {} for oil in paths}
    with ExitStack() as files:
        add = {}
        for oil, path in paths.items():
            about = {**provenance, "content": content[oil]}
            add[oil] = files.enter_context(tables.writing("samples", path, about))

        def write(oil: str) -> None:
            if waiting[oil]:
                samples = _together(waiting[oil])
                add[oil](samples)
                content[oil].update(digests_of_runs(samples))
                waiting[oil].clear()

        def keep(run: base.LoggedRun) -> None:
            if sum(map(len, waiting[run.oil])) + len(run) > tables.ROW_GROUP:
                write(run.oil)
            waiting[run.oil].append(run)

        yield keep
        for oil in paths:
            write(oil)


def read_bytes(path: Path) -> bytes:
    """A file's bytes; of one larger than any log no more than shows that it is.

    Raises:
        OilfilmError: The file cannot be read.
    """
    try:
        if path.exists() and not (path.is_file() or path.is_dir()):
            # a pipe without a writer would be waited for
            raise OilfilmError(f"{path}: is a pipe or a device; expected a file.")
        with path.open("rb") as file:
            return file.read(LARGEST_LOG + 1)
    except OSError as error:
        folder = isinstance(error, IsADirectoryError)
        advice = "Name the logs in it" if folder else "Check the path and its rights"
        raise OilfilmError(f"{path}: cannot be read ({error.strerror}). {advice}.") from error


def read_log(
    content: bytes,
    file: str,
    settings: Settings,
    kind: LogKind = TRACTION,
    sheet: RunSheet = NO_SHEET,
) -> tuple[str, base.Reading]:
    """The format of a file's bytes and what they hold; `file` is its name, unique among the logs.

    Raises:
        RuntimeError: The reader lost a row.
    """
    name = "none"
    try:
        inside = unpack(content)
        name = recognised_format(inside) or name
        found = _found(name, inside, kind.vocabulary_of(settings.campaign))
        reading = _without_absurd(read_tables(found, file, settings, kind, sheet))
        if not reading.runs and not reading.refusals:
            reason = f"the file looks like {name}, but holds no row of data"
            advice = "Take it out, or export it again."
            raise base.UnreadableLogError(reason, advice, rule="no_rows")
        if inside is not content:
            reading = replace(reading, unpacked_sha256=hashlib.sha256(inside).hexdigest())
    except base.UnreadableLogError as error:
        reading = base.Reading(error.rows, [], [error.refusal.of_rows("", 1, error.rows)])
    kept = sum(len(run) for run in reading.runs)
    refused = sum(refusal.refused_rows for refusal in reading.refusals)
    if kept + refused != reading.rows:
        raise RuntimeError(f"{file}: {reading.rows} rows, but {kept} kept and {refused} refused")
    refusals = [replace(refusal, reason=printable(refusal.reason)) for refusal in reading.refusals]
    return name, replace(reading, refusals=refusals)


def _found(name: str, content: bytes, vocabulary: Vocabulary) -> Found:
    """The tables of a file in a format.

    Raises:
        UnreadableLogError: The format is not known, or nothing of the file can be used.
    """
    if name not in READERS:
        seen = f"not text; its first bytes are {content[:8].hex(' ')} (hexadecimal)"
        seen = next((kind for mark, kind in FOREIGN.items() if content.startswith(mark)), seen)
        raise base.UnreadableLogError(
            f"the format is not known: the file is {seen}" if content else "the file is empty",
            f"Formats read: {', '.join(READERS)}. data/raw/README.md describes them.",
            rule="unknown_format",
        )
    try:
        return READERS[name].tables(content, vocabulary)
    except base.UnreadableLogError:
        raise
    except Exception as error:
        if name not in BINARY:
            raise
        what = " ".join(str(error).split())[:200] or type(error).__name__
        reason = f"the file begins like {name}, but cannot be read: {what}"
        raise base.UnreadableLogError(reason, base.COPY_AGAIN, rule="damaged_file") from error


def _without_absurd(reading: base.Reading) -> base.Reading:
    """The reading without rows whose numbers no table may hold, as the load of 1e6 GPa.

    Cells are judged by the readers; this is about what units and definitions make of them.
    """
    runs, refusals = [], [*reading.refusals]
    for run in reading.runs:
        held = np.ones(len(run), dtype=bool)
        for name, values in run.samples.items():
            absurd = held & ((values >= LARGEST) | (values <= -LARGEST))
            rows, problem = run.samples["row"][absurd], f"{name} comes out as {LARGEST:g} or more"
            about = run.run_id, rows, "unreadable_row", problem
            refusals += base.refused_ranges(*about, ROWS_ADVICE)
            held &= ~absurd
        kept = run.samples if held.all() else {n: v[held] for n, v in run.samples.items()}
        runs.append(replace(run, samples=kept))
    return replace(reading, runs=runs, refusals=refusals)


def unpack(content: bytes) -> bytes:
    """The bytes inside a .gz or .zst file, known by their first bytes; others as they are.

    Raises:
        UnreadableLogError: The compressed stream is cut or damaged, or the log is too large.
    """
    if len(content) > LARGEST_LOG:
        raise base.too_large(f"the file is larger than {LARGEST_LOG >> 20} MiB")
    codec = next((name for mark, name in _COMPRESSED.items() if content.startswith(mark)), None)
    if codec is None:
        return content
    # so much any log may unfold to: one of rest alone has the same rows throughout
    most = min(LARGEST_LOG, max(_UNSUSPICIOUS, base.MOST_FOLDED * len(content)))
    try:
        with arrow.CompressedInputStream(arrow.BufferReader(content), codec) as stream:
            inside = bytes(stream.read(most + 1))
    except OSError as error:
        damage = f"the compressed file cannot be unpacked: {error}"
        raise base.UnreadableLogError(damage, base.COPY_AGAIN, rule="damaged_archive") from error
    if len(inside) > most:
        times = f", its size times {base.MOST_FOLDED}" if most < LARGEST_LOG else ""
        raise base.too_large(f"unpacked the file has more than {most >> 20} MiB{times}")
    return inside


def _about_run(run: base.LoggedRun) -> dict[str, Any]:
    return {
        "run_id": run.run_id,
        "oil": run.oil,
        "rig": run.rig,
        "log_kind": run.kind,
        "label": printable(run.label)[:_LONGEST_LABEL],
        "columns": run.understood.names,
        "stated": run.understood.stated,
        **{f"nominal_{key}": run.nominal.get(key, np.nan) for key in base.SET_POINTS},
        "samples": len(run),
        "plateaus": 0,
        "accepted_points": 0,
        "verdict": "refused",
        "rule": run.flaw.rule if run.flaw else "",
        "reason": printable(run.flaw.reason) if run.flaw else "",
        "warning": "",
    }


def _together(runs: list[base.LoggedRun]) -> pd.DataFrame:
    """Samples of several runs under each other, with the run's id."""
    if not runs:
        return tables.empty("samples")
    codes = np.repeat(np.arange(len(runs)), [*map(len, runs)])
    ids = pd.Categorical.from_codes(codes, categories=pd.Index([run.run_id for run in runs]))
    names = runs[0].samples
    together = {name: np.concatenate([run.samples[name] for run in runs]) for name in names}
    return pd.DataFrame({"run_id": ids, **together}, copy=False)
