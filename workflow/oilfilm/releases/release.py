"""A release made: everything gathered aside, then put into its place whole."""

import os
import shutil
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from oilfilm import tables
from oilfilm.errors import OilfilmError
from oilfilm.outputs.metadata import (
    data_package,
    describe,
    linked_data,
    read_vocabulary,
    table_file,
)
from oilfilm.outputs.report.release_id import with_release
from oilfilm.releases.crate import CRATE, run_crate
from oilfilm.releases.logs import logs_read
from oilfilm.releases.manifest import (
    CODE,
    CONFIG,
    ENVIRONMENT,
    LOCK,
    MANIFEST,
    FileRecord,
    Manifest,
    canonical,
    files_below,
    read_manifest,
    records_of,
    sha256_of,
    version_of,
)
from oilfilm.releases.tree import code_files, code_tree_digest, environment
from oilfilm.releases.verify import verify
from oilfilm.settings.load import as_yaml

REPORT = "report.html"
LOG = "log.txt"
_SAMPLES = "tables/samples/"


@dataclass(frozen=True)
class Made:
    """What a finished run has made and what it was made from.

    Attributes:
        root: Top folder of the project; all other paths start there.
        config: As resolved.
        results: Folder of the campaign's results.
        files: Files and folders below it, all of which the run has made or found up to date.
        raw: The raw logs' paths, with the sha256 that each had when the run asked for it; empty for
            what the run itself wrote.
        logs: Logs of the jobs.
    """

    root: Path
    config: Mapping[str, Any]
    results: Path
    files: Sequence[Path]
    raw: Mapping[str, str]
    logs: Sequence[Path]


def release(made: Made, releases: Path) -> tuple[Path, bool]:
    """Make the release of a finished run; the same run gives the same release.

    Samples are left out: they are the larger part of the tables and nothing but the raw logs in SI
    units. The manifest has their hashes.

    Args:
        made: What to release.
        releases: Folder of the campaign's releases.

    Returns:
        The release's folder, and whether it is new.

    Raises:
        OilfilmError: A raw log has changed since the run read it, or the release exists already
            with other content.
    """
    made_from = _made_from(made)
    version = version_of(made_from)
    aside, place = releases / f".{version}.part", releases / version
    # what a killed run has left
    for leftover in releases.glob(".*.part"):
        shutil.rmtree(leftover)
    new = not place.exists()
    try:
        manifest = _gather(made, made_from, aside)
        if new:
            _close(aside)
            aside.rename(place)
        else:
            _refuse_other(place, manifest)
    finally:
        shutil.rmtree(aside, ignore_errors=True)  # a full disk needs the room
    _point(releases / "latest", version)
    return place, new


def _made_from(made: Made) -> dict[str, Any]:
    """The stable part of the manifest: what the version depends on."""
    raw = records_of(made.root, list(made.raw))
    _refuse_changed(raw, made)
    return {
        "campaign": made.config["campaign"]["name"],
        "data": made.config["campaign"]["data"],
        "tag": made.config["release"]["tag"],
        "schema_version": tables.SCHEMA_VERSION,
        "config": sha256_of(as_yaml(made.config)),
        "code": code_tree_digest(made.root),
        "lock": FileRecord.of(made.root, LOCK).sha256,
        "environment": environment(made.root),
        "raw": [asdict(record) for record in raw],
    }


def _gather(made: Made, made_from: Mapping[str, Any], aside: Path) -> Manifest:
    """Everything of a release in a folder, and the manifest of it."""
    root, results = made.root, made.root / made.results
    paths = _below(made)
    samples = [path for path in paths if path.startswith(_SAMPLES)]
    for path in paths:
        if path not in samples:
            _copy(results / path, aside / path)
    for path in code_files(root):
        _copy(root / path, aside / CODE / path)
    _copy(root / LOCK, aside / LOCK)
    _write(aside / CONFIG, as_yaml(made.config))
    _write(aside / ENVIRONMENT, canonical(made_from["environment"]))
    _write(aside / LOG, _log_summary(made))
    if REPORT in paths:
        page = (aside / REPORT).read_bytes().decode("utf-8")
        _write(aside / REPORT, with_release(page, version_of(made_from)))
    _describe(aside / "tables", made.config)
    inside = records_of(aside, files_below(aside))
    _write(aside / CRATE, run_crate(made.config, made_from, inside))
    files = records_of(aside, files_below(aside))
    manifest = Manifest(made_from, files, records_of(results, samples))
    _write(aside / MANIFEST, manifest.text())
    return manifest


def _below(made: Made) -> list[str]:
    """Files that the run has made, relative to the results; of folders all that is not hidden."""
    found = set()
    for path in made.files:
        inside = files_below(made.root / path) if (made.root / path).is_dir() else [""]
        found |= {
            (path / name).relative_to(made.results).as_posix()
            for name in inside
            if not any(part.startswith(".") for part in name.split("/"))
        }
    return sorted(found)


def _refuse_changed(raw: Sequence[FileRecord], made: Made) -> None:
    """What the run read must be what lies there now."""

    def table(name: str) -> pd.DataFrame | None:
        path = made.results / "tables" / f"{name}.parquet"
        return tables.read(name, made.root / path) if path in made.files else None

    read = logs_read(made.config["campaign"]["name"], table, {record.path for record in raw})
    for record in raw:
        # a log that could not be read at all has no row in any table
        before = {made.raw[record.path]}
        if record.path in read:
            before.add(read[record.path].sha256)
        for other in sorted(before - {"", record.sha256}):
            raise OilfilmError(
                f"{record.path}: has changed since the run read it (sha256 {record.sha256[:12]}, "
                f"then {other[:12]}). Put it back, or let `snakemake --forcerun` read it."
            )


def _log_summary(made: Made) -> str:
    """What the jobs had to say; one that only ended well has a line."""
    lines = []
    for log in sorted(made.logs):
        try:
            said = (made.root / log).read_text(encoding="utf-8").rstrip("\n").split("\n")
        except FileNotFoundError:
            raise OilfilmError(
                f"{log}: the log of a job is missing. Make its job run again with `snakemake "
                "--forcerun`, then release."
            ) from None
        lines += [f"{log.stem}: {line}" for line in said]
    return "\n".join(lines) + "\n"


def _describe(folder: Path, config: Mapping[str, Any]) -> None:
    """The tables' descriptions anew, for the tables that are here."""
    files = [table_file(path, folder) for path in sorted(folder.glob("*.parquet"))]
    dataset = describe(config, files, read_vocabulary(folder / "vocabulary.ttl"))
    _write(folder / "datapackage.json", data_package(dataset))
    _write(folder / "dataset.jsonld", linked_data(dataset))


def _copy(source: Path, target: Path) -> None:
    target.parent.mkdir(parents=True, exist_ok=True)
    shutil.copyfile(source, target)


def _write(path: Path, text: str) -> None:
    path.write_bytes(text.encode("utf-8"))


def _close(folder: Path) -> None:
    """Make every file read-only and see that it is on the disk before the folder gets its name."""
    for path in files_below(folder):
        (folder / path).chmod(0o444)
    for place in [folder, *folder.rglob("*")]:
        descriptor = os.open(place, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)


def _refuse_other(place: Path, manifest: Manifest) -> None:
    """A release that exists must be the one that would be made again."""
    if damaged := verify(place):
        raise OilfilmError(
            f"{place}: exists and is not as it was released: {damaged[0]} Move it away, then run "
            "`snakemake release` again."
        )
    before, _ = read_manifest(place)
    if before.text() == manifest.text():
        return
    old, new = ({*one.files, *one.samples} for one in (before, manifest))
    # the crate repeats the hashes of the others
    first = min(old ^ new, key=lambda record: (record.path == CRATE, record)).path
    raise OilfilmError(
        f"{place}: exists and is left as it is, but the same inputs, configuration and code have "
        f"now given other bytes, first in {first}. A release never changes: "
        f"`oilfilm verify {place} --rebuild` says which of the two can be made again."
    )


def _point(link: Path, version: str) -> None:
    """Let `latest` lead to a release, in one step.

    A link rather than a text file: `latest/report.html` opens, and every command takes it.
    """
    aside = link.with_name(".latest.new")
    aside.unlink(missing_ok=True)
    aside.symlink_to(version)
    aside.replace(link)
