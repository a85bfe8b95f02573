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
from oilfilm.base.errors import OilfilmError, printable
from oilfilm.logs import (
    base,
    delimited_text,
    lvm,
    matlab,
    opendocument,
    parquet,
    pcs,
    tdms,
    workbook,
)
from oilfilm.logs.columns import ROWS_ADVICE, read_tables
from oilfilm.logs.log_schema import LogSchema, Vocabulary
from oilfilm.logs.logged_table import TablesOfFile
from oilfilm.logs.raw_files import LARGEST_LOG_BYTES, TOO_LITTLE_MEMORY, read_beginning
from oilfilm.logs.run_sheet import NO_SHEET, RunSheet
from oilfilm.logs.traction_log import TRACTION
from oilfilm.settings.resolved import Settings
from oilfilm.tables import LARGEST_NUMBER
from oilfilm.tables.samples_content import digests_of_runs


class Reader(Protocol):
    """A module that reads one format."""

    def recognises(self, first_bytes: bytes) -> bool:
        """True where the first bytes of a file look like this format."""
        ...

    def tables(self, content: bytes, vocabulary: Vocabulary) -> TablesOfFile:
        """How the text of a file is written, and its tables: names, units, keys, numbers.

        Raises:
            UnreadableLogError: Nothing of the file can be used.
            Exception: Any error that the library of a binary format raises for a damaged file.
        """
        ...


# The first reader that recognises a file reads it. The reader of csv takes any text in columns, so
# it comes last.
READERS: dict[str, Reader] = {
    "tdms": tdms,
    "parquet": parquet,
    "lvm": lvm,
    "pcs": pcs,
    "xlsx": workbook,
    "ods": opendocument,
    "mat": matlab,
    "csv": delimited_text,
}
# Name of the format of a file that no reader recognises.
UNKNOWN_FORMAT = "none"
# First bytes of files that are no logs -> what they are.
DESCRIPTION_OF_FIRST_BYTES = {
    b"PK\x03\x04": "a zip archive: unpack it",
    b"\xd0\xcf\x11\xe0": "an old Excel workbook (.xls): save it as xlsx, ods or csv",
    b"\x89HDF": "an HDF5 file: export the channels as csv, or save a MATLAB file with -v7",
    b"TDSh": "the index of a tdms log without its data: take the file .tdms beside it",
    b"\x1f\x8b": "a log that was packed twice: unpack it once",
}
# Formats that a library reads. Any error that it raises shows a damaged file.
BINARY_FORMATS = frozenset({"tdms", "parquet", "xlsx", "ods", "mat"})


def recognised_format(content: bytes) -> str | None:
    """The name of the format of a file's bytes; None where no reader recognises them."""
    first_bytes = content[:4096]
    is_spreadsheet = workbook.recognises(first_bytes) or opendocument.recognises(first_bytes)
    if first_bytes.startswith(tuple(DESCRIPTION_OF_FIRST_BYTES)) and not is_spreadsheet:
        return None
    return next((name for name, reader in READERS.items() if reader.recognises(first_bytes)), None)


_LONGEST_LABEL = 200
_BYTES_PER_MIB = 1 << 20
# A file may always be unpacked to this size, however small it is.
_UNSUSPICIOUS_BYTES = 16 * _BYTES_PER_MIB
# First bytes of a packed file -> name of its codec.
_CODEC_OF_FIRST_BYTES = {b"\x1f\x8b": "gzip", b"\x28\xb5\x2f\xfd": "zstd"}


@dataclass(frozen=True)
class LogSummary:
    """How one raw file was read.

    Attributes:
        file: Name of the log.
        format_name: Name of its format; `none` where it is not known.
        dialect: How its text is written.
        row_count: Number of its data rows, good and bad.
        interpretation_of_run: Id of a run -> how its columns and header were interpreted.
    """

    file: str
    format_name: str
    dialect: base.TextDialect
    row_count: int
    interpretation_of_run: Mapping[str, base.RunInterpretation]


@dataclass(frozen=True)
class IngestedLogs:
    """The content of some raw files of a campaign.

    Attributes:
        samples_of_oil: Name of an oil -> table of the samples of its runs.
        runs: Table of runs.
        quarantine: Table of quarantine.
        logs: How each file was read.
    """

    samples_of_oil: dict[str, pd.DataFrame]
    runs: pd.DataFrame
    quarantine: pd.DataFrame
    logs: list[LogSummary]

    def all_samples(self) -> pd.DataFrame:
        """The samples of all oils, the rows of a run together."""
        frames = [frame for frame in self.samples_of_oil.values() if len(frame)]
        if len(frames) == 1:
            return frames[0]
        return pd.concat(frames, ignore_index=True) if frames else tables.empty_table("samples")


def ingest_logs(
    logs: Iterable[tuple[str, bytes]],
    settings: Settings,
    log_schema: LogSchema = TRACTION,
    sheet: RunSheet = NO_SHEET,
    keep_run: Callable[[base.LoggedRun], None] | None = None,
    digest_of_log: Mapping[str, str] | None = None,
) -> IngestedLogs:
    """Read raw logs into samples, runs and quarantine.

    Args:
        logs: Name and bytes of each log.
        settings: The settings.
        log_schema: What logs of this kind of rig may hold.
        sheet: The run sheet; it overrides the headers of the logs.
        keep_run: Called with one run after the other. Without it the samples are returned.
        digest_of_log: Name of a log -> its sha256, where it is known already.

    Raises:
        OilfilmError: Runs of two logs have the same name.
        RuntimeError: A reader lost a row (a defect of oilfilm, never of the log).
    """
    runs_of_oil: dict[str, list[base.LoggedRun]] = {oil_name: [] for oil_name in settings.oils}
    run_rows: list[dict[str, Any]] = []
    quarantine_rows: list[dict[str, Any]] = []
    file_of_run: dict[str, str] = {}
    log_summaries: list[LogSummary] = []
    for file, content in logs:
        format_name, parsed_log = read_log(content, file, settings, log_schema, sheet)
        interpretation_of_run = {run.run_id: run.interpretation for run in parsed_log.runs}
        log_summaries.append(
            LogSummary(
                file, format_name, parsed_log.dialect, parsed_log.row_count, interpretation_of_run
            )
        )
        digest = (digest_of_log or {}).get(file) or hashlib.sha256(content).hexdigest()
        columns_of_file = {
            "campaign": settings.campaign.name,
            "file": file,
            "sha256": digest,
            "content_sha256": parsed_log.unpacked_sha256 or digest,
            "reader": format_name,
            **asdict(parsed_log.dialect),
        }
        for run in parsed_log.runs:
            other_file = file_of_run.setdefault(run.run_id, file)
            if other_file != file:
                raise OilfilmError(
                    f"{file}: its run gets the name {run.run_id!r}, which a run of {other_file} "
                    "has already. Rename the file."
                )
            run_rows.append(columns_of_file | _run_row(run, parsed_log.refusals))
            if keep_run is None:
                runs_of_oil[run.oil_name].append(run)
            else:
                keep_run(run)
        oil_of_run = {run.run_id: run.oil_name for run in parsed_log.runs}
        quarantine_rows += _quarantine_rows(parsed_log.refusals, file, oil_of_run, settings)
    quarantine_rows += _quarantine_rows(sheet.remarks, sheet.name, {}, settings)
    return IngestedLogs(
        samples_of_oil={
            oil_name: _table_of_samples(runs) for oil_name, runs in runs_of_oil.items()
        },
        runs=tables.from_rows(run_rows, "runs"),
        quarantine=tables.from_rows(quarantine_rows, "quarantine"),
        logs=log_summaries,
    )


def _quarantine_rows(
    refusals: Iterable[base.Refusal], file: str, oil_of_run: Mapping[str, str], settings: Settings
) -> list[dict[str, Any]]:
    """Rows of the table of quarantine for the refusals of a file."""
    file_columns = {"campaign": settings.campaign.name, "file": file, "stage": "ingest"}
    return [
        file_columns | {"oil": oil_of_run.get(refusal.run_id, "")} | asdict(refusal)
        for refusal in refusals
    ]


@contextmanager
def open_sample_files(
    path_of_oil: Mapping[str, Path], provenance: Mapping[str, Any]
) -> Iterator[Callable[[base.LoggedRun], None]]:
    """Write the samples of runs one after the other: memory does not grow with their number.

    A row group has complete runs: as many as `tables.ROWS_PER_GROUP` rows hold, or a single longer
    one. The footer gets `content`, the digest of each run's samples.

    Args:
        path_of_oil: Name of an oil -> the file of its samples.
        provenance: As for `tables.writing`.

    Yields:
        A function that takes one run after the other.
    """
    waiting_runs_of_oil: dict[str, list[base.LoggedRun]] = {
        oil_name: [] for oil_name in path_of_oil
    }
    run_digests_of_oil: dict[str, dict[str, str]] = {oil_name: {} for oil_name in path_of_oil}
    with ExitStack() as files:
        write_samples_of_oil = {}
        for oil_name, path in path_of_oil.items():
            # filled while the samples are written; the footer is written last
            footer = {**provenance, "content": run_digests_of_oil[oil_name]}
            write_samples_of_oil[oil_name] = files.enter_context(
                tables.writing("samples", path, footer)
            )

        def write_waiting(oil_name: str) -> None:
            if waiting_runs_of_oil[oil_name]:
                samples = _table_of_samples(waiting_runs_of_oil[oil_name])
                write_samples_of_oil[oil_name](samples)
                run_digests_of_oil[oil_name].update(digests_of_runs(samples))
                waiting_runs_of_oil[oil_name].clear()

        def keep_run(run: base.LoggedRun) -> None:
            waiting_row_count = sum(
                len(waiting_run) for waiting_run in waiting_runs_of_oil[run.oil_name]
            )
            if waiting_row_count + len(run) > tables.ROWS_PER_GROUP:
                write_waiting(run.oil_name)
            waiting_runs_of_oil[run.oil_name].append(run)

        yield keep_run
        for oil_name in path_of_oil:
            write_waiting(oil_name)


def read_bytes(path: Path) -> bytes:
    """A file's bytes; of a file that is too large, one byte more than the largest log.

    Raises:
        OilfilmError: The file cannot be read.
    """
    try:
        if path.exists() and not (path.is_file() or path.is_dir()):
            # to open a pipe without a writer would wait without end
            raise OilfilmError(f"{path}: is a pipe or a device; expected a file.")
        with path.open("rb") as file:
            return read_beginning(file)
    except MemoryError:
        raise OilfilmError(f"{path}: {TOO_LITTLE_MEMORY}") from None
    except OSError as error:
        is_folder = isinstance(error, IsADirectoryError)
        advice = "Name the logs in it" if is_folder else "Check the path and its rights"
        raise OilfilmError(f"{path}: cannot be read ({error.strerror}). {advice}.") from error


def read_log(
    content: bytes,
    file: str,
    settings: Settings,
    log_schema: LogSchema = TRACTION,
    sheet: RunSheet = NO_SHEET,
) -> tuple[str, base.ParsedLog]:
    """The name of the format of a file, and what the file holds.

    Args:
        content: The bytes of the file.
        file: Its name, unique among the logs.
        settings: The settings.
        log_schema: What logs of this kind of rig may hold.
        sheet: The run sheet.

    Raises:
        RuntimeError: The reader lost a row.
    """
    format_name = UNKNOWN_FORMAT
    try:
        unpacked = unpack(content)
        format_name = recognised_format(unpacked) or format_name
        tables_of_file = _tables_of_file(
            format_name, unpacked, log_schema.campaign_vocabulary(settings.campaign)
        )
        parsed_log = _without_absurd_rows(
            read_tables(tables_of_file, file, settings, log_schema, sheet)
        )
        if not parsed_log.runs and not parsed_log.refusals:
            reason = f"the file looks like {format_name}, but holds no row of data"
            advice = "Take it out, or export it again."
            raise base.UnreadableLogError(reason, advice, rule="no_rows")
        if unpacked is not content:
            parsed_log = replace(parsed_log, unpacked_sha256=hashlib.sha256(unpacked).hexdigest())
    except base.UnreadableLogError as error:
        parsed_log = base.ParsedLog(
            error.row_count, [], [error.refusal.for_rows("", 1, error.row_count)]
        )
    kept_row_count = sum(len(run) for run in parsed_log.runs)
    refused_row_count = sum(refusal.refused_rows for refusal in parsed_log.refusals)
    if kept_row_count + refused_row_count != parsed_log.row_count:
        raise RuntimeError(
            f"{file}: {parsed_log.row_count} rows, but {kept_row_count} kept and "
            f"{refused_row_count} refused"
        )
    refusals = [
        replace(refusal, reason=printable(refusal.reason)) for refusal in parsed_log.refusals
    ]
    return format_name, replace(parsed_log, refusals=refusals)


def _tables_of_file(format_name: str, content: bytes, vocabulary: Vocabulary) -> TablesOfFile:
    """The tables of a file in a format.

    Raises:
        UnreadableLogError: The format is not known, or nothing of the file can be used.
    """
    if format_name not in READERS:
        raise _unknown_format_error(content, vocabulary)
    try:
        return READERS[format_name].tables(content, vocabulary)
    except base.UnreadableLogError:
        raise
    except Exception as error:
        if format_name not in BINARY_FORMATS:
            raise
        message = " ".join(str(error).split())[:200] or type(error).__name__
        reason = f"the file begins like {format_name}, but cannot be read: {message}"
        raise base.UnreadableLogError(
            reason, base.COPY_AGAIN_ADVICE, rule="damaged_file"
        ) from error


def _unknown_format_error(content: bytes, vocabulary: Vocabulary) -> base.UnreadableLogError:
    """The error for a file that no reader recognises."""
    if content:
        description = f"not text; its first bytes are {content[:8].hex(' ')} (hexadecimal)"
        for first_bytes, foreign_description in DESCRIPTION_OF_FIRST_BYTES.items():
            if content.startswith(first_bytes):
                description = foreign_description
        reason = f"the format is not known: the file is {description}"
    else:
        reason = "the file is empty"
    return base.UnreadableLogError(
        reason,
        f"Formats read: {', '.join(READERS)}. data/raw/README.md describes them.",
        row_count=_row_count_among_zeros(content, vocabulary),
        rule="unknown_format",
    )


def _row_count_among_zeros(content: bytes, vocabulary: Vocabulary) -> int:
    """Number of rows of a text that is not recognised because of zero bytes; 0 without a text."""
    text = content.replace(b"\0", b"")
    if recognised_format(text) != "csv":
        return 0
    try:
        _, logged_tables = delimited_text.tables(text, vocabulary)
    except base.UnreadableLogError as error:
        return error.row_count
    return sum(table.row_count for table in logged_tables)


def _without_absurd_rows(parsed_log: base.ParsedLog) -> base.ParsedLog:
    """The parsed log without rows whose numbers no table may hold, such as a load of 1e6 GPa.

    Readers judge the cells. This function judges the numbers after conversion.
    """
    runs: list[base.LoggedRun] = []
    refusals = list(parsed_log.refusals)
    for run in parsed_log.runs:
        is_kept = np.ones(len(run), dtype=bool)
        for name, values in run.samples.items():
            is_absurd = is_kept & ((values >= LARGEST_NUMBER) | (values <= -LARGEST_NUMBER))
            refusals += base.refused_ranges(
                run.run_id,
                run.samples["row"][is_absurd],
                "unreadable_row",
                f"{name} comes out as {LARGEST_NUMBER:g} or more",
                ROWS_ADVICE,
            )
            is_kept &= ~is_absurd
        if is_kept.all():
            runs.append(run)
        else:
            samples = {name: values[is_kept] for name, values in run.samples.items()}
            runs.append(replace(run, samples=samples))
    return replace(parsed_log, runs=runs, refusals=refusals)


def unpack(content: bytes) -> bytes:
    """The bytes inside a .gz or .zst file, recognised by its first bytes; others are unchanged.

    Raises:
        UnreadableLogError: The compressed stream is cut or damaged, or the log is too large.
    """
    if len(content) > LARGEST_LOG_BYTES:
        raise base.too_large_error(
            f"the file is larger than {LARGEST_LOG_BYTES // _BYTES_PER_MIB} MiB"
        )
    codec = ""
    for first_bytes, codec_name in _CODEC_OF_FIRST_BYTES.items():
        if content.startswith(first_bytes):
            codec = codec_name
    if not codec:
        return content
    # a log of a rig at rest has the same row throughout and is packed to very few bytes
    most_byte_count_by_ratio = max(_UNSUSPICIOUS_BYTES, base.MOST_UNPACKED_RATIO * len(content))
    most_byte_count = min(LARGEST_LOG_BYTES, most_byte_count_by_ratio)
    try:
        with arrow.CompressedInputStream(arrow.BufferReader(content), codec) as stream:
            unpacked = bytes(stream.read(most_byte_count + 1))
    except OSError as error:
        damage = f"the compressed file cannot be unpacked: {error}"
        raise base.UnreadableLogError(
            damage, base.COPY_AGAIN_ADVICE, rule="damaged_archive"
        ) from error
    if len(unpacked) > most_byte_count:
        ratio = (
            f", its size times {base.MOST_UNPACKED_RATIO}"
            if most_byte_count < LARGEST_LOG_BYTES
            else ""
        )
        raise base.too_large_error(
            f"unpacked the file has more than {most_byte_count // _BYTES_PER_MIB} MiB{ratio}"
        )
    return unpacked


def _run_row(run: base.LoggedRun, refusals: Iterable[base.Refusal]) -> dict[str, Any]:
    """A row of the table of runs, without the columns of the file.

    Args:
        run: The run.
        refusals: All refusals of its file.
    """
    refused_row_count = sum(
        refusal.refused_rows for refusal in refusals if refusal.run_id == run.run_id
    )
    return {
        "run_id": run.run_id,
        "oil": run.oil_name,
        "rig": run.rig_name,
        "log_kind": run.log_kind,
        "label": printable(run.label)[:_LONGEST_LABEL],
        "columns": run.interpretation.names_with_units,
        "stated": run.interpretation.statements,
        **{f"nominal_{key}": run.set_points.get(key, np.nan) for key in base.SET_POINT_KEYS},
        "samples": len(run),
        # until curation judges the run
        "plateaus": 0,
        "accepted_points": 0,
        "verdict": "refused",
        "rule": run.refusal.rule if run.refusal else "",
        "reason": printable(run.refusal.reason) if run.refusal else "",
        "warning": (),
        "refused_rows": refused_row_count,
    }


def _table_of_samples(runs: list[base.LoggedRun]) -> pd.DataFrame:
    """Table of samples of several runs, one below the other."""
    if not runs:
        return tables.empty_table("samples")
    row_counts = [len(run) for run in runs]
    run_index_of_row = np.repeat(np.arange(len(runs), dtype=np.int32), row_counts)
    run_ids = pd.Index([run.run_id for run in runs])
    columns: dict[str, Any] = {"run_id": pd.Categorical.from_codes(run_index_of_row, run_ids)}
    for name in runs[0].samples:
        arrays_of_runs = [run.samples[name] for run in runs]
        # a long log is a run alone: no copy
        columns[name] = (
            np.concatenate(arrays_of_runs) if len(arrays_of_runs) > 1 else arrays_of_runs[0]
        )
    return pd.DataFrame(columns, copy=False)
