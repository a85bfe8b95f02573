"""Make a release, and rebuild one.

To make it, every file is collected in a temporary folder, which is then renamed. To rebuild it, the
raw logs are evaluated again in a temporary folder, and the result is compared byte by byte.

Decides: which files are part of a release; how a release is rebuilt.
"""

import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from oilfilm import home, tables
from oilfilm.atomic_write import flush, make_folder, rename_flushed
from oilfilm.digests import file_digest, files_below, files_of
from oilfilm.errors import OilfilmError, printable
from oilfilm.home import RUN_LOCK, portable
from oilfilm.logs.raw_files import read_listings
from oilfilm.releases.compare import Comparison, compare
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
from oilfilm.settings.campaign import Campaign
from oilfilm.settings.messages import check
from oilfilm.settings.resolve import unresolve
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


# What a run needs beside its code. The configuration comes from the release.
_OTHER_FILES = (home.RUN_LOCK, "pyproject.toml", "profiles/default/config.yaml")


def rebuild(release: Path, root: Path, cores: str) -> Comparison:
    """Rebuild a release from the local raw logs and code; compare it with what was rebuilt.

    The code in the release is never run: its author may be unknown. The local code must match.

    Args:
        release: Folder of the release.
        root: Top folder of the project, with code and raw logs.
        cores: For snakemake.

    Raises:
        OilfilmError: It is a pin, a raw log is missing or has changed, or the run fails.
    """
    stored = StoredRelease.open(release)
    with tempfile.TemporaryDirectory(prefix="oilfilm-rebuild-") as temporary:
        folder = Path(temporary)
        settings = lay_out(stored, root, folder)
        _run(folder, stored, cores)
        campaign = stored.manifest.made_from.campaign
        rebuilt = StoredRelease.open(folder / "results" / "releases" / campaign / "latest")
        return compare(stored, rebuilt, settings.drift)


def lay_out(stored: StoredRelease, root: Path, folder: Path) -> Settings:
    """Put local code, a release's configuration and measured logs into a fresh folder.

    Returns:
        The settings of the release.

    Raises:
        OilfilmError: It is a pin, its configuration is none, a raw log is missing or has changed.
    """
    if stored.pinned:
        raise OilfilmError(
            f"{stored.folder}: is a pin, which cannot be rebuilt; expected a release."
        )
    for path, file in code_files(home.HOME).items():
        copy_file(file, folder / path)
    for path in _OTHER_FILES:
        copy_file(home.HOME / path, folder / path)
    config = stored.config()
    try:
        settings = Settings.of(config)
        check(config["campaign"], Campaign, lambda steps: "campaign")
        texts = unresolve(settings)
    except (AttributeError, KeyError, TypeError, ValueError, RecursionError, OilfilmError) as error:
        raise OilfilmError(
            f"{stored.folder}: config.yaml is not a configuration of this version of oilfilm "
            f"({error}). If the release was made by another version, rebuild it with a clone of "
            f"that version; its code is in the folder {CODE}/ of the release."
        ) from error
    # the rig twin writes these logs again
    torque_twin = settings.campaign.torque and settings.campaign.torque.twin
    name = settings.campaign.name
    twins = {name: settings.campaign.twin, f"{name}-torque": torque_twin}
    for path, text in texts.items():
        target = folder / "config" / path
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text(text, encoding="utf-8")
    for record in stored.manifest.made_from.raw:
        if twins.get(record.path.split("/")[2]):
            continue
        source = root / record.path
        if source.is_file():
            copy_file(source, folder / record.path)
        if not source.is_file() or FileRecord.of(folder / record.path, record.path) != record:
            raise OilfilmError(
                f"{source}: is not the log that release {stored.name} was made from. "
                "Put the original back, then try again."
            )
    return settings


def _run(folder: Path, stored: StoredRelease, cores: str) -> None:
    command = [sys.executable, "-m", "snakemake", "release", "--cores", cores]
    # use the library of the copy, not the installed one
    environment = {**os.environ, "PYTHONPATH": str(folder / "workflow")}
    done = subprocess.run(  # noqa: S603 - a fixed command; `cores` is one argument
        command,
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
        errors="replace",
        check=False,
    )
    if done.returncode != 0:
        output = (done.stdout + done.stderr).replace(str(folder), ".").splitlines()
        last = "\n".join(printable(line) for line in output[-30:])
        raise OilfilmError(f"{stored.folder}: the rebuild failed. Its last lines:\n{last}")
