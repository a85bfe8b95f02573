"""Make a release, and rebuild one.

A new release is collected in a temporary folder, which is then renamed. A rebuild evaluates the raw
logs again in a temporary folder and compares the result byte by byte.

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

from oilfilm import tables
from oilfilm.base import home
from oilfilm.base.atomic_write import flush, make_folder, rename_flushed
from oilfilm.base.digests import file_digest, files_below, files_of
from oilfilm.base.errors import OilfilmError, printable
from oilfilm.base.home import REQUIREMENTS_LOCK_FILE, project_path
from oilfilm.releases.code_tree import code_files, code_tree_digest, copy_file, environment
from oilfilm.releases.compare import Comparison, compare
from oilfilm.releases.manifest import (
    CHECKSUMS_FILE,
    CODE_FOLDER,
    CONFIG_FILE,
    ENVIRONMENT_FILE,
    LOCK_FILE,
    MANIFEST_FILE,
    FileRecord,
    Manifest,
    ReleaseInputs,
    canonical_json,
    checksums,
    text_sha256,
)
from oilfilm.releases.step_outputs import StepOutputs
from oilfilm.releases.stored_release import StoredRelease
from oilfilm.report.metadata import data_package
from oilfilm.report.release_id import with_release
from oilfilm.settings.campaign import Campaign
from oilfilm.settings.messages import validated
from oilfilm.settings.resolve import config_files_of
from oilfilm.settings.resolved import Settings
from oilfilm.settings.yaml_file import as_yaml
from oilfilm.tables.samples_content import samples_digest_and_row_count

_REPORT = "report.html"
# Folder of the samples below the results.
_SAMPLES = "tables/samples/"
# Lines of a failed run that its message quotes.
_QUOTED_LINES = 30


@dataclass(frozen=True)
class FinishedRun:
    """Outputs and inputs of a finished run.

    Attributes:
        root: Top folder of the project. All other paths but `home` start there.
        home: Folder of the workflow that made the run.
        settings: All settings of the run.
        results: Folder of the campaign's results.
        output_paths: Output files and folders below it, all up to date.
        raw_digest_by_path: sha256 of each raw log and run sheet when the run read it, by path.
        step_listings: Files in which each step has listed the sha256 of its outputs.
        copies_folder: Folder with the local copies of files in object storage; below it a file has
            the path that it has below `root`.
    """

    root: Path
    home: Path
    settings: Settings
    results: Path
    output_paths: Sequence[Path]
    raw_digest_by_path: Mapping[str, str]
    step_listings: Sequence[Path]
    copies_folder: Path = Path()

    def files_below_results(self) -> dict[str, Path]:
        """Output files by their path below the results, without hidden files."""
        file_by_path: dict[str, Path] = {}
        for path in self.output_paths:
            for file in files_of(self.root / path):
                path_below_results = file.relative_to(self.root / self.results)
                if not any(
                    folder_or_file.startswith(".") for folder_or_file in path_below_results.parts
                ):
                    file_by_path[path_below_results.as_posix()] = file
        return dict(sorted(file_by_path.items()))


def make_release(run: FinishedRun, releases: Path) -> tuple[Path, bool]:
    """Make the release of a finished run. The same run gives the same release.

    Samples are left out: they are the raw logs in SI units, and most of the bytes. The manifest
    has one hash over the samples of each oil. It does not depend on how the work was spread over
    jobs.

    Args:
        run: The run to release.
        releases: Folder of the campaign's releases.

    Returns:
        The folder of the release, and whether this call made it.

    Raises:
        OilfilmError: A raw log has changed since the run read it, a file is not as its step wrote
            it, or the release exists already with other content.
    """
    config_text = as_yaml(run.settings.plain_values())
    made_from = ReleaseInputs(
        campaign=run.settings.campaign.name,
        data=run.settings.campaign.data,
        tag=run.settings.release.tag,
        config=text_sha256(config_text),
        code=code_tree_digest(run.home),
        lock=file_digest(run.home / REQUIREMENTS_LOCK_FILE),
        environment=environment(run.home),
        raw=_raw_records(run),
    )
    folder = releases / made_from.version
    temporary = releases / f".{made_from.version}.part"
    make_folder(releases)
    for leftover in releases.glob(".*.part"):  # of a killed run
        shutil.rmtree(leftover)
    is_new = not folder.exists()
    try:
        manifest = _collect_files(run, made_from, config_text, temporary)
        if is_new:
            flush(temporary)
            for name in files_below(temporary):
                (temporary / name).chmod(0o444)
            rename_flushed(temporary, folder)
        else:
            _refuse_other(folder, manifest)
    finally:
        shutil.rmtree(temporary, ignore_errors=True)  # a full disk needs the room
    # a link, so that `latest/report.html` opens and every command accepts it
    link = releases / ".latest.new"
    link.unlink(missing_ok=True)
    link.symlink_to(made_from.version)
    rename_flushed(link, releases / "latest")
    return folder, is_new


def _raw_records(run: FinishedRun) -> list[FileRecord]:
    """The records of the raw logs.

    Raises:
        OilfilmError: A log has changed since the run read it.
    """
    records = []
    for path, digest in sorted(run.raw_digest_by_path.items()):
        local_copy = run.root / run.copies_folder / path
        file = local_copy if local_copy.is_file() else run.root / path
        record = FileRecord.from_file(file, path)
        if record.sha256 != digest:
            raise OilfilmError(
                f"{path}: has changed since the run read it (sha256 {record.sha256[:12]}, "
                f"then {digest[:12]}). Put it back, or run `snakemake release` again to read it."
            )
        records.append(record)
    return records


def _refuse_damaged(run: FinishedRun, files: Mapping[str, Path]) -> None:
    """Refuse results that are not as their steps wrote them, even if they are not to be released.

    Raises:
        OilfilmError: There is such a result.
    """
    listed_outputs = StepOutputs.from_listings(run.root / listing for listing in run.step_listings)
    released_files = {project_path(run.results / name): file for name, file in files.items()}
    for path in sorted(listed_outputs.digest_by_path.keys() | released_files.keys()):
        if path not in listed_outputs.digest_by_path:
            raise OilfilmError(f"{path}: no step of the run has written it. Move it away.")
        file = released_files.get(path, run.root / path)
        # a file in object storage that is not released has no local copy
        if path in released_files or file.is_file():
            listed_outputs.refuse_altered(path, file)


def _collect_files(
    run: FinishedRun, made_from: ReleaseInputs, config_text: str, folder: Path
) -> Manifest:
    """Copy every file of a release into a folder, and write its manifest.

    Returns:
        The manifest.
    """
    result_files = run.files_below_results()
    _refuse_damaged(run, result_files)
    source_by_path = {LOCK_FILE: run.home / REQUIREMENTS_LOCK_FILE}
    for path_in_release, path in result_files.items():
        if not path_in_release.startswith(_SAMPLES):
            source_by_path[path_in_release] = path
    for path_in_release, path in code_files(run.home).items():
        source_by_path[f"{CODE_FOLDER}/{path_in_release}"] = path
    for path_in_release, path in source_by_path.items():
        copy_file(path, folder / path_in_release)
    text_by_path = {
        CONFIG_FILE: config_text,
        ENVIRONMENT_FILE: canonical_json(made_from.environment.model_dump()),
        "tables/datapackage.json": data_package(
            run.settings, folder / "tables", folder.glob("tables/*.parquet")
        ),
    }
    if _REPORT in source_by_path:
        page = (folder / _REPORT).read_bytes().decode("utf-8")
        text_by_path[_REPORT] = with_release(page, made_from.version)
    for path_in_release, text in text_by_path.items():
        (folder / path_in_release).write_bytes(text.encode("utf-8"))
    records = [
        FileRecord.from_file(folder / path_in_release, path_in_release)
        for path_in_release in files_below(folder)
    ]
    manifest = Manifest.from_records(made_from, records, _sample_records(result_files))
    (folder / MANIFEST_FILE).write_bytes(manifest.text().encode("utf-8"))
    (folder / CHECKSUMS_FILE).write_bytes(checksums(manifest).encode("utf-8"))
    return manifest


def _sample_records(result_files: Mapping[str, Path]) -> list[FileRecord]:
    """One record for the samples of each oil: a hash over all runs, and the bytes of all columns.

    Args:
        result_files: Output files by their path below the results.
    """
    files_of_oil: dict[str, list[Path]] = {}
    for path_below_results, path in result_files.items():
        if path_below_results.startswith(_SAMPLES):
            folder, _, _ = path_below_results.rpartition("/")
            files_of_oil.setdefault(folder, []).append(path)
    bytes_per_row = 8 * (len(tables.columns("samples")) - 1)
    records = []
    for folder, files in sorted(files_of_oil.items()):
        digest, row_count = samples_digest_and_row_count(files)
        records.append(FileRecord(path=folder, sha256=digest, size=row_count * bytes_per_row))
    return records


def _refuse_other(folder: Path, manifest: Manifest) -> None:
    """Refuse an existing release that differs from the new one.

    Raises:
        OilfilmError: It differs, or has been changed.
    """
    stored = StoredRelease.open(folder)
    changes = stored.find_changes()
    if changes:
        raise OilfilmError(
            f"{folder}: exists and is not as it was released: {changes[0]} Move it away, then run "
            "`snakemake release` again."
        )
    if stored.manifest.text() != manifest.text():
        old_records = {*stored.manifest.files, *stored.manifest.samples}
        new_records = {*manifest.files, *manifest.samples}
        first_path = min(record.path for record in old_records ^ new_records)
        raise OilfilmError(
            f"{folder}: exists and is left as it is, but the same inputs, configuration and code "
            f"have now given other bytes, first in {first_path}. A release never changes: "
            f"`oilfilm verify {folder} --rebuild` says which of the two can be made again."
        )


# Files that a run needs beside its code. The configuration comes from the release.
_OTHER_FILES = (home.REQUIREMENTS_LOCK_FILE, "pyproject.toml", "profiles/default/config.yaml")


def rebuild(release: Path, root: Path, cores: str) -> Comparison:
    """Rebuild a release from the local raw logs and code, and compare the two.

    The code in the release is never run, because its author may be unknown. The local code must
    match.

    Args:
        release: Folder of the release.
        root: Top folder of the project, with code and raw logs.
        cores: Number of cores for snakemake, or `all`.

    Raises:
        OilfilmError: It is a pin, a raw log is missing or has changed, or the run fails.
    """
    stored = StoredRelease.open(release)
    with tempfile.TemporaryDirectory(prefix="oilfilm-rebuild-") as temporary:
        folder = Path(temporary)
        settings = lay_out_rebuild(stored, root, folder)
        _run(folder, stored, cores)
        campaign = stored.manifest.made_from.campaign
        rebuilt = StoredRelease.open(folder / "results" / "releases" / campaign / "latest")
        return compare(stored, rebuilt, settings.drift)


def lay_out_rebuild(stored: StoredRelease, root: Path, folder: Path) -> Settings:
    """Put local code, a release's configuration and measured logs into a fresh folder.

    Returns:
        The settings of the release.

    Raises:
        OilfilmError: It is a pin, its configuration cannot be used, or a raw log is missing or has
            changed.
    """
    if stored.is_pin:
        raise OilfilmError(
            f"{stored.folder}: is a pin, which cannot be rebuilt; expected a release."
        )
    for path, file in code_files(home.HOME).items():
        copy_file(file, folder / path)
    for path in _OTHER_FILES:
        copy_file(home.HOME / path, folder / path)
    config = stored.read_config()
    try:
        settings = Settings.from_plain_values(config)
        validated(config["campaign"], Campaign, lambda key_path: "campaign")
        text_by_config_path = config_files_of(settings)
    except (AttributeError, KeyError, TypeError, ValueError, RecursionError, OilfilmError) as error:
        raise OilfilmError(
            f"{stored.folder}: config.yaml is not a configuration of this version of oilfilm "
            f"({error}). If the release was made by another version, rebuild it with a clone of "
            f"that version; its code is in the folder {CODE_FOLDER}/ of the release."
        ) from error
    for path, text in text_by_config_path.items():
        target = folder / "config" / path
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text(text, encoding="utf-8")
    simulated_folders = _simulated_folders(settings.campaign)
    for record in stored.manifest.made_from.raw:
        _, _, log_folder, *_ = record.path.split("/")
        if log_folder in simulated_folders:
            continue  # the rig twin writes these logs again
        source = root / record.path
        if source.is_file():
            copy_file(source, folder / record.path)
        if (
            not source.is_file()
            or FileRecord.from_file(folder / record.path, record.path) != record
        ):
            raise OilfilmError(
                f"{source}: is not the log that release {stored.name} was made from. "
                "Put the original back, then try again."
            )
    return settings


def _simulated_folders(campaign: Campaign) -> set[str]:
    """Folders below data/raw whose logs the rig twin writes."""
    folders = set()
    if campaign.twin is not None:
        folders.add(campaign.name)
    if campaign.torque is not None and campaign.torque.twin is not None:
        folders.add(f"{campaign.name}-torque")
    return folders


def _run(folder: Path, stored: StoredRelease, cores: str) -> None:
    """Run the workflow in a folder up to its release.

    Raises:
        OilfilmError: The run fails.
    """
    command = [sys.executable, "-m", "snakemake", "release", "--cores", cores]
    # use the library of the copy, not the installed one
    environment_variables = {**os.environ, "PYTHONPATH": str(folder / "workflow")}
    finished = subprocess.run(  # noqa: S603 - a fixed command; `cores` is one argument
        command,
        cwd=folder,
        env=environment_variables,
        capture_output=True,
        text=True,
        errors="replace",
        check=False,
    )
    if finished.returncode != 0:
        output = (finished.stdout + finished.stderr).replace(str(folder), ".").splitlines()
        last_lines = "\n".join(printable(line) for line in output[-_QUOTED_LINES:])
        raise OilfilmError(f"{stored.folder}: the rebuild failed. Its last lines:\n{last_lines}")
