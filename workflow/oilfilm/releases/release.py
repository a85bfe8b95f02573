"""Make a release: collect every file in a temporary folder, then rename the folder.

Decides: which files are part of a release.
"""

import shutil
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from oilfilm import tables
from oilfilm.atomic_write import flush, make_folder, rename_flushed
from oilfilm.errors import OilfilmError
from oilfilm.home import RUN_LOCK
from oilfilm.releases.compare import logs_read
from oilfilm.releases.crate import CRATE, run_crate
from oilfilm.releases.manifest import (
    CHECKSUMS,
    CODE,
    CONFIG,
    ENVIRONMENT,
    LOCK,
    MANIFEST,
    FileRecord,
    MadeFrom,
    Manifest,
    canonical,
    checksums,
    files_below,
    read_manifest,
    records_below,
    sha256_of,
)
from oilfilm.releases.tree import code_files, code_tree_digest, copy_file, environment
from oilfilm.releases.verify import verify
from oilfilm.report.metadata import data_package
from oilfilm.report.release_id import with_release
from oilfilm.settings.resolved import Settings
from oilfilm.settings.yaml_file import as_yaml
from oilfilm.tables.table_file import content_digest, table_file

REPORT = "report.html"
_SAMPLES = "tables/samples/"


@dataclass(frozen=True)
class FinishedRun:
    """Outputs and inputs of a finished run.

    Attributes:
        root: Top folder of the project; all other paths but `home` start there.
        home: Folder of the workflow that made the run.
        settings: All settings of the run.
        results: Folder of the campaign's results.
        files: Output files and folders below it, all up to date.
        raw: Paths of the raw logs with the sha256 that each had when the run read it; empty for
            simulated logs, which the run wrote itself.
        copies: Folder with the local copies of what is kept in object storage.
    """

    root: Path
    home: Path
    settings: Settings
    results: Path
    files: Sequence[Path]
    raw: Mapping[str, str]
    copies: Path = Path()


def make_release(run: FinishedRun, releases: Path) -> tuple[Path, bool]:
    """Make the release of a finished run. The same run gives the same release.

    Samples are left out: they are the raw logs in SI units, and most of the bytes. The manifest
    has the hash of each oil's, which does not depend on how the work was spread over jobs.

    Args:
        run: The run to release.
        releases: Folder of the campaign's releases.

    Returns:
        The release's folder, and whether it is new.

    Raises:
        OilfilmError: A raw log has changed since the run read it, a table is damaged, or the
            release exists already with other content.
    """
    config = as_yaml(run.settings.plain())
    made_from = _made_from(run, config)
    version = made_from.version
    temporary, folder = releases / f".{version}.part", releases / version
    make_folder(releases)
    # left by a killed run
    for leftover in releases.glob(".*.part"):
        shutil.rmtree(leftover)
    new = not folder.exists()
    try:
        manifest = _gather(run, made_from, config, temporary)
        if new:
            flush(temporary)
            for name in files_below(temporary):
                (temporary / name).chmod(0o444)
            rename_flushed(temporary, folder)
        else:
            _refuse_other(folder, manifest)
    finally:
        shutil.rmtree(temporary, ignore_errors=True)  # a full disk needs the room
    _point(releases / "latest", version)
    return folder, new


def _made_from(run: FinishedRun, config: str) -> MadeFrom:
    return MadeFrom(
        campaign=run.settings.campaign.name,
        data=run.settings.campaign.data,
        tag=run.settings.release.tag,
        schema_version=tables.SCHEMA_VERSION,
        config=sha256_of(config),
        code=code_tree_digest(run.home),
        lock=FileRecord.of(run.home, RUN_LOCK).sha256,
        environment=environment(run.home),
        raw=_raw_records(run),
    )


def _raw_records(run: FinishedRun) -> list[FileRecord]:
    """The raw logs; refused where one has changed since the run read it."""

    def table(name: str) -> pd.DataFrame | None:
        path = run.results / "tables" / f"{name}.parquet"
        return tables.read(name, run.root / path) if path in run.files else None

    read = logs_read(run.settings.campaign.name, table, run.raw)
    records = []
    for path, digest in sorted(run.raw.items()):
        copied = (run.root / run.copies / path).is_file()
        record = FileRecord.of(run.root / run.copies if copied else run.root, path)
        # a log that could not be read at all has no row in any table
        _, in_table = read.get(path, ("", ""))
        for other in {digest, in_table} - {"", record.sha256}:
            raise OilfilmError(
                f"{path}: has changed since the run read it (sha256 {record.sha256[:12]}, "
                f"then {other[:12]}). Put it back, or run `snakemake release` again to read it."
            )
        records.append(record)
    return records


def _gather(run: FinishedRun, made_from: MadeFrom, config: str, temporary: Path) -> Manifest:
    """Copy every file of a release into a folder; returns the manifest."""
    results = run.root / run.results
    paths = _below(run)
    samples = [path for path in paths if path.startswith(_SAMPLES)]
    for path in paths:
        if path.endswith(".parquet"):
            tables.refuse_damaged(results / path)
        if path not in samples:
            copy_file(results / path, temporary / path)
    for path, file in code_files(run.home).items():
        copy_file(file, temporary / CODE / path)
    copy_file(run.home / RUN_LOCK, temporary / LOCK)
    _write(temporary / CONFIG, config)
    _write(temporary / ENVIRONMENT, canonical(made_from.environment.model_dump()))
    if REPORT in paths:
        page = (temporary / REPORT).read_bytes().decode("utf-8")
        _write(temporary / REPORT, with_release(page, made_from.version))
    described = [
        table_file(path, path.parent) for path in sorted(temporary.glob("tables/*.parquet"))
    ]
    _write(temporary / "tables/datapackage.json", data_package(run.settings, described))
    inside = records_below(temporary)
    _write(temporary / CRATE, run_crate(run.settings, made_from, inside))
    files = records_below(temporary)
    # the content of each oil's samples: one hash over all runs, and bytes of all columns
    of_oil: dict[str, list[Path]] = {}
    for path in samples:
        of_oil.setdefault(path.rpartition("/")[0], []).append(results / path)
    width = 8 * (len(tables.columns("samples")) - 1)
    contents = {folder: content_digest(paths) for folder, paths in sorted(of_oil.items())}
    left_out = [
        FileRecord(path=folder, sha256=digest, size=rows * width)
        for folder, (digest, rows) in contents.items()
    ]
    manifest = Manifest.of(made_from, files, left_out)
    _write(temporary / MANIFEST, manifest.text())
    _write(temporary / CHECKSUMS, checksums(manifest))
    return manifest


def _below(run: FinishedRun) -> list[str]:
    """Output files of a run, relative to the results, without hidden files."""
    names: set[str] = set()
    for path in run.files:
        inside = files_below(run.root / path) if (run.root / path).is_dir() else [""]
        names |= {
            (path / name).relative_to(run.results).as_posix()
            for name in inside
            if not any(part.startswith(".") for part in name.split("/"))
        }
    return sorted(names)


def _write(path: Path, text: str) -> None:
    path.write_bytes(text.encode("utf-8"))


def _refuse_other(folder: Path, manifest: Manifest) -> None:
    """Refuse an existing release that differs from the new one."""
    if damaged := verify(folder):
        raise OilfilmError(
            f"{folder}: exists and is not as it was released: {damaged[0]} Move it away, then run "
            "`snakemake release` again."
        )
    before, _ = read_manifest(folder)
    if before.text() == manifest.text():
        return
    old, new = ({*each.files, *each.samples} for each in (before, manifest))
    # the crate repeats the hashes of the others
    first = min(old ^ new, key=lambda record: (record.path == CRATE, record.path)).path
    raise OilfilmError(
        f"{folder}: exists and is left as it is, but the same inputs, configuration and code have "
        f"now given other bytes, first in {first}. A release never changes: "
        f"`oilfilm verify {folder} --rebuild` says which of the two can be made again."
    )


def _point(link: Path, version: str) -> None:
    """Point the link `latest` to a release, in one step.

    It is a link, so that `latest/report.html` opens and every command accepts it.
    """
    temporary = link.with_name(".latest.new")
    temporary.unlink(missing_ok=True)
    temporary.symlink_to(version)
    rename_flushed(temporary, link)
