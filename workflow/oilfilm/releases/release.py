"""Make a release: collect every file in a temporary folder, then rename the folder.

Decides: which files are part of a release.
"""

import shutil
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from oilfilm import tables
from oilfilm.atomic_write import flush, make_folder, rename_flushed
from oilfilm.digests import file_digest, files_below, files_of
from oilfilm.errors import OilfilmError
from oilfilm.home import RUN_LOCK, portable
from oilfilm.logs.raw_files import read_listings
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
    sha256_of,
)
from oilfilm.releases.stored_release import StoredRelease
from oilfilm.releases.tree import code_files, code_tree_digest, copy_file, environment
from oilfilm.report.metadata import data_package
from oilfilm.report.release_id import with_release
from oilfilm.settings.resolved import Settings
from oilfilm.settings.yaml_file import as_yaml
from oilfilm.tables.table_file import content_digest

_REPORT, _SAMPLES = "report.html", "tables/samples/"


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
        made: Files in which each step has listed the sha256 of what it wrote.
        copies: Folder with the local copies of what is kept in object storage.
    """

    root: Path
    home: Path
    settings: Settings
    results: Path
    files: Sequence[Path]
    raw: Mapping[str, str]
    made: Sequence[Path]
    copies: Path = Path()

    def below_results(self) -> dict[str, Path]:
        """Output files by their path below the results, without hidden files."""
        found: dict[str, Path] = {}
        for path in self.files:
            for file in files_of(self.root / path):
                name = file.relative_to(self.root / self.results)
                if not any(part.startswith(".") for part in name.parts):
                    found[name.as_posix()] = file
        return dict(sorted(found.items()))


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
        OilfilmError: A raw log has changed since the run read it, a file is not as its step wrote
            it, or the release exists already with other content.
    """
    config = as_yaml(run.settings.plain())
    made_from = MadeFrom(
        campaign=run.settings.campaign.name,
        data=run.settings.campaign.data,
        tag=run.settings.release.tag,
        schema_version=tables.SCHEMA_VERSION,
        config=sha256_of(config),
        code=code_tree_digest(run.home),
        lock=file_digest(run.home / RUN_LOCK),
        environment=environment(run.home),
        raw=_raw_records(run),
    )
    temporary, folder = releases / f".{made_from.version}.part", releases / made_from.version
    make_folder(releases)
    for leftover in releases.glob(".*.part"):  # of a killed run
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
    # a link, so that `latest/report.html` opens and every command accepts it; in one step
    link = releases / ".latest.new"
    link.unlink(missing_ok=True)
    link.symlink_to(made_from.version)
    rename_flushed(link, releases / "latest")
    return folder, new


def _raw_records(run: FinishedRun) -> list[FileRecord]:
    """The raw logs; refused where one has changed since the run read it."""
    records = []
    for path, digest in sorted(run.raw.items()):
        copied = run.root / run.copies / path
        record = FileRecord.of(copied if copied.is_file() else run.root / path, path)
        if record.sha256 != digest:
            raise OilfilmError(
                f"{path}: has changed since the run read it (sha256 {record.sha256[:12]}, "
                f"then {digest[:12]}). Put it back, or run `snakemake release` again to read it."
            )
        records.append(record)
    return records


def _refuse_damaged(run: FinishedRun, files: Mapping[str, Path]) -> None:
    """Refuse results that are not what their steps wrote, released or not."""
    stated = {
        path: (digest, made)
        for made in run.made
        for path, digest in read_listings(run.root / made).items()
    }
    released = {portable(run.results / name): file for name, file in files.items()}
    for path in sorted({*stated, *released}):
        file = released.get(path, run.root / path)
        if path not in stated:
            raise OilfilmError(f"{path}: no step of the run has written it. Move it away.")
        digest, made = stated[path]
        # what is kept in object storage and not released is not here
        if (path in released or file.is_file()) and file_digest(file) != digest:
            raise OilfilmError(
                f"{path}: is not as its step wrote it. Remove {made}, then run `snakemake release` "
                "again: the step is done anew."
            )


def _gather(run: FinishedRun, made_from: MadeFrom, config: str, folder: Path) -> Manifest:
    """Copy every file of a release into a folder; returns the manifest."""
    of_oil: dict[str, list[Path]] = {}
    copied = {LOCK: run.home / RUN_LOCK}
    files = run.below_results()
    _refuse_damaged(run, files)
    for name, path in files.items():
        if name.startswith(_SAMPLES):
            of_oil.setdefault(name.rpartition("/")[0], []).append(path)
        else:
            copied[name] = path
    copied |= {f"{CODE}/{name}": path for name, path in code_files(run.home).items()}
    for name, path in copied.items():
        copy_file(path, folder / name)
    texts = {
        CONFIG: config,
        ENVIRONMENT: canonical(made_from.environment.model_dump()),
        "tables/datapackage.json": data_package(
            run.settings, folder / "tables", folder.glob("tables/*.parquet")
        ),
    }
    if _REPORT in copied:
        page = (folder / _REPORT).read_bytes().decode("utf-8")
        texts[_REPORT] = with_release(page, made_from.version)
    for name, text in texts.items():
        (folder / name).write_bytes(text.encode("utf-8"))
    # the content of each oil's samples: one hash over all runs, and bytes of all columns
    width = 8 * (len(tables.columns("samples")) - 1)
    samples = [
        FileRecord(path=name, sha256=digest, size=rows * width)
        for name, paths in sorted(of_oil.items())
        for digest, rows in [content_digest(paths)]
    ]
    records = [FileRecord.of(folder / name, name) for name in files_below(folder)]
    manifest = Manifest.of(made_from, records, samples)
    for name, text in {MANIFEST: manifest.text(), CHECKSUMS: checksums(manifest)}.items():
        (folder / name).write_bytes(text.encode("utf-8"))
    return manifest


def _refuse_other(folder: Path, manifest: Manifest) -> None:
    """Refuse an existing release that differs from the new one."""
    stored = StoredRelease.open(folder)
    if damaged := stored.changes():
        raise OilfilmError(
            f"{folder}: exists and is not as it was released: {damaged[0]} Move it away, then run "
            "`snakemake release` again."
        )
    if stored.manifest.text() != manifest.text():
        old, new = ({*each.files, *each.samples} for each in (stored.manifest, manifest))
        first = min(old ^ new, key=lambda record: record.path).path
        raise OilfilmError(
            f"{folder}: exists and is left as it is, but the same inputs, configuration and code "
            f"have now given other bytes, first in {first}. A release never changes: "
            f"`oilfilm verify {folder} --rebuild` says which of the two can be made again."
        )
