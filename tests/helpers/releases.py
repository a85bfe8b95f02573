"""A small project with results, ready to be released, for the tests of releases."""

import json
import shutil
import struct
from collections.abc import Mapping, Sequence
from hashlib import sha256
from pathlib import Path

import pandas as pd
import pytest

from campaigns import ROOT, Campaign, rows
from oilfilm import tables
from oilfilm.base import home
from oilfilm.base.home import REQUIREMENTS_LOCK_FILE
from oilfilm.logs.raw_files import listing_text
from oilfilm.releases import release as releasing
from oilfilm.releases.manifest import (
    CHECKSUMS_FILE,
    MANIFEST_FILE,
    PINNED_MANIFEST_FILE,
    Environment,
    FileRecord,
    Manifest,
    checksums,
    read_manifest,
)
from oilfilm.releases.release import FinishedRun, make_release
from oilfilm.releases.stored_release import StoredRelease
from oilfilm.report.release_id import UNRELEASED
from oilfilm.settings.resolve import resolve
from oilfilm.settings.resolved import Settings

# A log may be named by the time of day.
RAW = {"a.csv": b"load_n\n1\n", "b 12:30.csv": b"load_n\n2\n"}
# A picture of 8 x 6 pixels, as far as its head.
PNG = b"\x89PNG\r\n\x1a\n" + struct.pack(">I4s2I", 13, b"IHDR", 8, 6) + bytes(range(64))


def project(root: Path) -> Path:
    """The top folder of a project: a little code, the real reference data, lock and profile."""
    (root / "workflow/oilfilm").mkdir(parents=True)
    (root / "workflow/oilfilm/fit.py").write_text("answer = 42\n", encoding="utf-8")
    (root / "Snakefile").write_text("# rules\n", encoding="utf-8")
    shutil.copytree(ROOT / "data/reference", root / "data/reference")
    for name in ("pyproject.toml", REQUIREMENTS_LOCK_FILE, "profiles/default/config.yaml"):
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / name, root / name)
    return root


def finished_run(
    root: Path, settings: Settings, raw: Mapping[str, bytes], frames: Mapping[str, pd.DataFrame]
) -> FinishedRun:
    """A finished run in a project: its raw logs, tables, one figure, one log."""
    name = settings.campaign.name
    logs, results = root / "data/raw" / name, Path("results", name)
    provenance = {"campaign": name, "data": settings.campaign.data, "rule": "test"}
    logs.mkdir(parents=True, exist_ok=True)
    for file, content in raw.items():
        (logs / file).write_bytes(content)
    files = [results / "tables" / f"{table}.parquet" for table in frames]
    for path, (table, frame) in zip(files, frames.items(), strict=True):
        tables.write(frame, table, root / path, provenance)
    sample = results / "tables/samples/oil=4102/part-0.parquet"
    content = {**provenance, "content": {}}
    tables.write(tables.empty_table("samples"), "samples", root / sample, content)
    others: dict[Path, bytes] = {
        results / "figures/curves.png": PNG,
        results / "summary.txt": b"fine\n",
        results / "report.html": f"<h1>\u6cb9\r\n</h1>{UNRELEASED}".encode(),
        results / "exports/4102/law.h": b"double mu;\n",
        results / "exports/.snakemake_timestamp": b"",
        results / "logs/fit-4102.log": b"4102: certified\ndone\n",
    }
    for path, content in others.items():
        (root / path).parent.mkdir(parents=True, exist_ok=True)
        (root / path).write_bytes(content)
    single = [path for path in others if path.parts[2] not in {"exports", "logs"}]
    return FinishedRun(
        root=root,
        home=root,
        settings=settings,
        results=results,
        output_paths=[*files, sample, *single, results / "exports"],
        raw_digest_by_path={
            f"data/raw/{name}/{file}": sha256(content).hexdigest()
            for file, content in sorted(raw.items())
        },
        step_listings=[results / "made/all.sha256"],
    )


def fake_rebuild(monkeypatch: pytest.MonkeyPatch, run: FinishedRun, **changed: bytes) -> None:
    """Replace snakemake in a rebuild: it gives the same results, some of them changed."""

    def run_again(folder: Path, *_: object) -> None:
        config = resolve(folder / "config", {})
        raw = {Path(path).name: (folder / path).read_bytes() for path in run.raw_digest_by_path}
        again = finished_run(folder, config, raw, {"runs": runs_of(raw)})
        for name, content in changed.items():
            (folder / run.results / f"{name}.txt").write_bytes(content)
        released(again)

    monkeypatch.setattr(releasing, "_run", run_again)
    monkeypatch.setattr(home, "HOME", run.home)


def runs_of(raw: dict[str, bytes]) -> pd.DataFrame:
    """One row per log, as ingest writes it."""
    common = {"campaign": "laboratory", "oil": "4102", "log_kind": "steps", "verdict": "accepted"}
    common |= dict.fromkeys(("samples", "plateaus", "accepted_points"), 1)
    found = []
    for name, content in raw.items():
        digests = dict.fromkeys(("sha256", "content_sha256"), sha256(content).hexdigest())
        found.append({**common, **digests, "run_id": name, "file": name})
    return rows("runs", *found)


def verify(folder: Path) -> list[str]:
    """What `oilfilm verify` finds in a release or a pin."""
    return StoredRelease.open(folder).find_changes()


def released(run: FinishedRun) -> Path:
    """The release of a run in its own project, whose files are as its steps have written them."""
    name = run.settings.campaign.name
    list_files_as_made(run)
    folder, _ = make_release(run, run.root / "results/releases" / name)
    return folder


def list_files_as_made(run: FinishedRun) -> None:
    """Write the list of what the steps have written: the digests of the files as they are now."""
    digests = {
        f"{run.results}/{name}": sha256(path.read_bytes()).hexdigest()
        for name, path in run.files_below_results().items()
    }
    (run.root / run.step_listings[0]).parent.mkdir(exist_ok=True)
    (run.root / run.step_listings[0]).write_text(listing_text(digests), encoding="utf-8")


def alter_file(release: Path, path: str, content: bytes) -> None:
    """Put other content into a release or a pin and into its manifest, as a stranger can."""
    (release / path).chmod(0o644)
    (release / path).write_bytes(content)
    record = FileRecord.from_file(release / path, path)
    manifest, _ = read_manifest(release)
    stated: dict[str, object] = {}
    if path == "config.yaml":
        stated = {"config": record.sha256}
    if path == "environment.json":
        stated = {"environment": Environment(**json.loads(content))}
    made_from = manifest.made_from.model_copy(update=stated)
    files = [record if each.path == path else each for each in manifest.files]
    write_manifest(release, Manifest.from_records(made_from, files, manifest.samples))


def write_manifest(release: Path, manifest: Manifest) -> None:
    """Give a release or a pin another manifest."""
    _, pinned = read_manifest(release)
    path = release / (PINNED_MANIFEST_FILE if pinned else MANIFEST_FILE)
    path.chmod(0o644)
    path.write_text(manifest.text(), encoding="utf-8")
    if not pinned:
        (release / CHECKSUMS_FILE).chmod(0o644)
        (release / CHECKSUMS_FILE).write_text(checksums(manifest), encoding="utf-8")


def tables_of(campaign: Campaign, oils: Sequence[str]) -> dict[str, pd.DataFrame]:
    """Runs, points and quick fits of some oils of a campaign."""
    fits = [campaign.fit(oil, searches=2, bootstrap=60) for oil in oils]
    judged = {"runs": campaign.curated.runs, "points": campaign.curated.points}
    return {
        **{name: table[table["oil"].isin(oils)] for name, table in judged.items()},
        **{
            name: pd.concat([fit.table(name) for fit in fits], ignore_index=True)
            for name in ("coefficients", "fit_quality", "refits")
        },
    }
