"""Releases: the same for the same, refused or named where anything differs."""

import json
import os
import re
import shutil
import subprocess
import sys
from dataclasses import replace
from hashlib import sha256
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from campaigns import LABORATORY, ROOT, without
from oilfilm.base.errors import OilfilmError
from oilfilm.cli import main
from oilfilm.releases import release as making
from oilfilm.releases import release as releasing
from oilfilm.releases.manifest import (
    CHECKSUMS_FILE,
    MANIFEST_FILE,
    MOST_BYTES,
    canonical_json,
    read_manifest,
    text_sha256,
)
from oilfilm.releases.stored_release import pin
from oilfilm.settings.resolved import Settings
from releases import (
    RAW,
    fake_rebuild,
    finished_run,
    list_files_as_made,
    project,
    released,
    runs_of,
    verify,
)

SECOND = "data/raw/laboratory/b 12:30.csv"


@pytest.fixture
def run(config: Settings, tmp_path: Path) -> making.FinishedRun:
    return finished_run(project(tmp_path / "project"), config, RAW, {"runs": runs_of(RAW)})


def bytes_of(folder: Path) -> dict[str, bytes]:
    files = (path for path in sorted(folder.rglob("*")) if path.is_file())
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in files}


def test_same_run_in_another_folder_gives_the_same_version_and_bytes(
    run: making.FinishedRun, config: Settings, tmp_path: Path
) -> None:
    other = project(tmp_path / "elsewhere" / "deep")
    os.utime(other / "Snakefile", (0, 0))
    twin = finished_run(other, config, RAW, {"runs": runs_of(RAW)})
    one, two = released(run), released(twin)
    assert one.name == two.name
    assert bytes_of(one) == bytes_of(two)
    assert making.make_release(run, one.parent) == (one, False)


def test_release_holds_what_was_made_and_leaves_the_samples_out(release: Path) -> None:
    manifest, pinned = read_manifest(release)
    paths = {record.path for record in manifest.files}
    assert not pinned
    assert {
        *("config.yaml", "requirements.lock", "environment.json", "summary.txt"),
        *("tables/runs.parquet", "tables/datapackage.json", "figures/curves.png"),
        *("exports/4102/law.h", "code/Snakefile", "code/workflow/oilfilm/fit.py"),
    } <= paths
    assert not [path for path in paths if "samples" in path or "snakemake_timestamp" in path]
    assert [record.path for record in manifest.samples] == ["tables/samples/oil=4102"]
    assert [record.path for record in manifest.made_from.raw] == [
        "data/raw/laboratory/a.csv",
        SECOND,
    ]
    assert set(bytes_of(release)) == {*paths, MANIFEST_FILE, CHECKSUMS_FILE}
    report = (release / "report.html").read_bytes().decode()
    assert report.startswith("<h1>\u6cb9\r\n</h1>")
    assert f">{release.name}<" in report
    package = json.loads((release / "tables/datapackage.json").read_text(encoding="utf-8"))
    assert [resource["name"] for resource in package["resources"]] == ["runs"]
    assert {path.stat().st_mode & 0o777 for path in release.rglob("*") if path.is_file()} == {0o444}
    assert (release.parent / "latest").readlink() == Path(release.name)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("file", "settings"),
    [
        ("data/raw/laboratory/a.csv", {}),
        ("workflow/oilfilm/fit.py", {}),
        ("workflow/new.py", {}),
        ("data/reference/printed_coefficients.yaml", {}),
        ("requirements/run.lock", {}),
        ("", {"release": {"tag": "v2"}}),
        ("", {"gates": {"lambda_limit": 2.9}}),
    ],
)
def test_anything_that_a_release_is_made_from_changes_its_version(
    run: making.FinishedRun, file: str, settings: dict[str, Any]
) -> None:
    before = released(run)
    if file:
        (run.root / file).write_text("numpy==1\n", encoding="utf-8")
    raw = {
        path: sha256((run.root / path).read_bytes()).hexdigest() for path in run.raw_digest_by_path
    }
    after = released(
        replace(run, raw_digest_by_path=raw, settings=run.settings.with_changes(settings))
    )
    assert after.name != before.name
    assert verify(before) == verify(after) == []
    assert (before.parent / "latest").readlink() == Path(after.name)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("file", "sentence"),
    [
        ("results/laboratory/figures/curves.png", r"curves\.png: is not as its step wrote it"),
        (
            "results/laboratory/tables/samples/oil=4102/part-0.parquet",
            "is not as its step wrote it",
        ),
        (
            "results/laboratory/exports/4102/planted.h",
            r"planted\.h: no step of the run has written it",
        ),
        ("data/raw/laboratory/a.csv", r"data/raw/laboratory/a\.csv: has changed since the run"),
        (
            "results/releases/laboratory/latest/summary.txt",
            r"not as it was released: summary\.txt: dif",
        ),
    ],
)
def test_changed_file_is_not_released(run: making.FinishedRun, file: str, sentence: str) -> None:
    list_files_as_made(run)
    if "releases" in file:
        making.make_release(run, run.root / "results/releases/laboratory")
        (run.root / file).chmod(0o644)
    (run.root / file).write_bytes(b"?")
    with pytest.raises(OilfilmError, match=sentence):
        making.make_release(run, run.root / "results/releases/laboratory")


def test_other_bytes_under_the_same_version_are_refused(run: making.FinishedRun) -> None:
    release = released(run)
    before = bytes_of(release)
    (run.root / run.results / "summary.txt").write_text("otherwise\n", encoding="utf-8")
    with pytest.raises(OilfilmError, match=r"now given other bytes, first in summary\.txt"):
        released(run)
    assert bytes_of(release) == before


@pytest.mark.parametrize(
    ("step", "error"),
    [("copy_file", OSError(28, "No space left on device")), ("flush", KeyboardInterrupt())],
)
def test_interrupted_release_gives_its_room_back_and_the_next_run_makes_it(
    run: making.FinishedRun, monkeypatch: pytest.MonkeyPatch, step: str, error: BaseException
) -> None:
    def interrupt(*_: object) -> None:
        raise error

    releases = run.root / "results/releases/laboratory"
    with monkeypatch.context() as patch, pytest.raises(type(error)):
        patch.setattr(making, step, interrupt)
        released(run)
    assert not list(releases.glob("*"))
    release = released(run)
    assert sorted(path.name for path in releases.iterdir()) == ["latest", release.name]
    assert verify(release) == []


# ---------------------------------------------------------------- integrity


@pytest.fixture(scope="module")
def loose(release: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of a release whose files can be written."""
    copy = tmp_path_factory.mktemp("loose") / release.name
    shutil.copytree(release, copy, copy_function=shutil.copyfile)
    return copy


def complaints(folder: Path) -> list[str]:
    try:
        return verify(folder)
    except OilfilmError as refused:
        return [str(refused).removeprefix(f"{folder}/")]


@given(data=st.data())
def test_any_changed_byte_is_found_and_its_file_named(loose: Path, data: st.DataObject) -> None:
    files = sorted(path for path in loose.rglob("*") if path.is_file() and path.stat().st_size)
    path = data.draw(st.sampled_from([loose / MANIFEST_FILE, *files]))
    before = path.read_bytes()
    at = data.draw(st.integers(0, len(before) - 1))
    other = data.draw(st.integers(0, 255).filter(lambda value: value != before[at]))
    try:
        path.write_bytes(before[:at] + bytes([other]) + before[at + 1 :])
        (complaint,) = complaints(loose)
        assert complaint.startswith(f"{path.relative_to(loose).as_posix()}:")
    finally:
        path.write_bytes(before)


def test_one_file_that_differs_is_said_to_be_one(
    loose: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "release"
    shutil.copytree(loose, folder)
    (folder / "summary.txt").unlink()
    assert main(["verify", str(folder)]) == 1
    assert capsys.readouterr().out.startswith(f"{folder}: 1 file is not as released:")


def test_every_file_that_differs_is_missing_or_extra_is_named(
    loose: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "release"
    shutil.copytree(loose, folder)
    assert main(["verify", str(folder)]) == 0
    assert capsys.readouterr().out.startswith(f"{loose.name}: all ")
    (folder / "summary.txt").unlink()
    (folder / "exports/4102/law.h").write_bytes(b"much longer than before, all of it\n" * 3)
    (folder / "figures/fig99.png").write_bytes(b"")
    (folder / "code/workflow/oilfilm/.planted.pyc").write_bytes(b"")
    (folder / "config.yaml").unlink()
    (folder / "config.yaml").symlink_to(ROOT / "config/config.yaml")
    assert main(["verify", str(folder)]) == 1
    printed = capsys.readouterr().out.splitlines()
    assert printed[0].endswith(": 5 files are not as released:")
    assert [line.split(":")[0] for line in printed[1:]] == [
        "code/workflow/oilfilm/.planted.pyc",
        *("config.yaml", "exports/4102/law.h", "figures/fig99.png", "summary.txt"),
    ]
    assert "plain file" in printed[2]


@pytest.mark.parametrize("kept", [None, 0, -1], ids=["deleted", "empty", "a line short"])
def test_release_without_all_hashes_is_refused(
    loose: Path, tmp_path: Path, kept: int | None
) -> None:
    folder = shutil.copytree(loose, tmp_path / "release")
    lines = (folder / CHECKSUMS_FILE).read_text(encoding="utf-8").splitlines(keepends=True)
    # the manifest and every file, by another program's reading
    named = {line.split("  ", 1)[1].rstrip("\n") for line in lines}
    assert named == {*bytes_of(folder)} - {CHECKSUMS_FILE}
    if kept is None:
        (folder / CHECKSUMS_FILE).unlink()
    else:
        (folder / CHECKSUMS_FILE).write_text("".join(lines[:kept]), encoding="utf-8")
    (complaint,) = verify(folder)
    assert complaint.startswith(f"{CHECKSUMS_FILE}: ")


@pytest.mark.parametrize(
    "name", ["v2-aaaaaaaaaaaa", "releases/other/{}", "releases/laboratory/v1-000000000000"]
)
def test_release_under_another_name_is_refused(loose: Path, tmp_path: Path, name: str) -> None:
    (complaint,) = verify(shutil.copytree(loose, tmp_path / name.format(loose.name)))
    assert f"laboratory {loose.name}" in complaint
    for place in (f"releases/laboratory/{loose.name}", loose.name, "latest"):
        assert verify(shutil.copytree(loose, tmp_path / "right" / place)) == []


@pytest.mark.nightly
def test_manifest_of_zeros_takes_little_memory(tmp_path: Path) -> None:
    """32 MB of zeros, with 600 MB for them beside what the library takes."""
    zeros = '{{"made_from": {{"raw": [{}0]}}}}'.format("0," * 16_777_000)
    (tmp_path / MANIFEST_FILE).write_text(zeros, encoding="utf-8")
    program = (
        "import resource, sys; from oilfilm.cli import main; import oilfilm.cli.releases\n"
        "pages = int(open('/proc/self/statm').read().split()[0])\n"
        "most = pages * resource.getpagesize() + 600_000_000\n"
        "resource.setrlimit(resource.RLIMIT_AS, (most, most))\n"
        "sys.exit(main(['verify', sys.argv[1]]))"
    )
    command = [sys.executable, "-c", program, str(tmp_path)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)
    assert (done.returncode, len(done.stderr) < 2000) == (2, True), done.stderr[:2000]


def hostile(manifest: dict[str, Any]) -> list[Any]:
    """Manifests that a stranger might send."""
    first, made_from = manifest["files"][0], manifest["made_from"]
    escapes = (
        "../../outside",
        "/etc/passwd",
        "a/../b",
        "C:/x",
        "a\\b",
        "",
        MANIFEST_FILE,
        "a\ud800",
    )
    elsewhere = {**made_from["raw"][0], "path": "workflow/oilfilm/cli.py"}
    environment = {**made_from["environment"], "packages": {"\x1b[31mX": 5}}
    of_inputs = {"campaign": "../x"}, {"raw": [elsewhere]}, {"environment": environment}
    changes: list[dict[str, Any]] = [
        *({"files": [{**first, "path": path}]} for path in (*escapes, "a" * 1025)),
        *({"made_from": {**made_from, **change}} for change in of_inputs),
        *({"files": [{**first, "size": -1}]}, {"samples": [{**first, "sha256": "0"}]}),
        *({"extra": 1}, {"format": 1}, {"version": "v" * 100_000}),
    ]
    return [*({**manifest, **change} for change in changes), []]


def sealed(content: Any) -> str:
    """A manifest with the hash that belongs to it, which a stranger can compute as well."""
    if not isinstance(content, dict):
        return canonical_json(content)
    rest = {key: value for key, value in content.items() if key != "sha256"}
    # a half of a letter can only stand there escaped
    text = canonical_json(rest).encode("utf-8", "backslashreplace").decode("utf-8")
    return canonical_json({**rest, "sha256": text_sha256(text)}).replace("\ud800", "\\ud800")


def test_hostile_manifest_is_refused_in_a_sentence(
    release: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    manifest = json.loads((release / MANIFEST_FILE).read_text(encoding="utf-8"))
    texts = [sealed(content) for content in hostile(manifest)]
    texts += ["{" * 100_000, "[" * 100_000 + "]" * 100_000, "\xff", "", '{"format": 1e999}']
    for number, text in enumerate(texts):
        folder = tmp_path / str(number)
        folder.mkdir()
        # one of the texts is no UTF-8
        (folder / MANIFEST_FILE).write_text(text, encoding="latin-1")
        assert main(["verify", str(folder)]) == 2, text[:200]
        printed = capsys.readouterr().err
        assert f"{folder}/{MANIFEST_FILE}: " in printed
        assert "\x1b" not in printed
        # refused for what it says, not for a hash that does not fit
        assert "was altered" not in printed
        assert len(printed) < 2000
    with (tmp_path / MANIFEST_FILE).open("wb") as large:
        large.truncate(MOST_BYTES + 1)
    assert main(["verify", str(tmp_path)]) == 2
    assert "is larger than" in capsys.readouterr().err
    (tmp_path / MANIFEST_FILE).unlink()
    assert main(["verify", str(tmp_path)]) == 2
    assert "manifest.json" in capsys.readouterr().err


@pytest.mark.slow
def test_manifest_of_too_many_files_is_refused(release: Path, tmp_path: Path) -> None:
    manifest = json.loads((release / MANIFEST_FILE).read_text(encoding="utf-8"))
    files = [{**manifest["files"][0], "path": str(number)} for number in range(100_001)]
    (tmp_path / MANIFEST_FILE).write_text(
        json.dumps({**manifest, "files": files}), encoding="utf-8"
    )
    with pytest.raises(OilfilmError, match="expected 100000 or fewer items"):
        read_manifest(tmp_path)


@pytest.mark.parametrize(
    "path", ["config.yaml", "requirements.lock", "code/workflow/oilfilm/fit.py", "environment.json"]
)
def test_files_of_another_version_are_refused(release: Path, tmp_path: Path, path: str) -> None:
    """A stranger can seal anything anew, but not under the version of something else."""
    manifest = json.loads((release / MANIFEST_FILE).read_text(encoding="utf-8"))
    (record,) = (each for each in manifest["files"] if each["path"] == path)
    record["sha256"] = "0" * 64
    (tmp_path / MANIFEST_FILE).write_text(sealed(manifest), encoding="utf-8")
    with pytest.raises(OilfilmError, match="inputs"):
        read_manifest(tmp_path)


# ---------------------------------------------------------------- configuration and pin


def test_pin_is_verified(release: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = pin(release, tmp_path)
    assert folder == tmp_path / "data/reference/pins/laboratory"
    assert read_manifest(folder)[0].version == release.name
    assert main(["verify", str(folder)]) == 0
    assert "pin" in capsys.readouterr().out
    (folder / "config.yaml").write_text("changed: true\n", encoding="utf-8")
    assert verify(folder)[0].startswith("config.yaml: differs")
    with pytest.raises(OilfilmError, match="is a pin already"):
        pin(folder, tmp_path)


@pytest.mark.parametrize("path", ["tables/runs.parquet", "summary.txt", "config.yaml"])
def test_pin_without_a_file_that_pins_keep_is_no_reference(
    release: Path, tmp_path: Path, path: str, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = pin(release, tmp_path)
    (folder / path).unlink()
    assert main(["verify", str(folder)]) == 1
    assert f"{path}: is missing" in capsys.readouterr().out
    configuration = ["--config", str(LABORATORY)]
    assert main(["diff", str(folder), str(release), "--gate", *configuration]) == 2
    assert f"{path}: is missing" in capsys.readouterr().err


def test_pins_of_the_repository_are_whole() -> None:
    for folder in (ROOT / "data/reference/pins").iterdir():
        assert verify(folder) == [], folder.name


def test_pin_does_not_change_the_version_of_what_it_pins(run: making.FinishedRun) -> None:
    release = released(run)
    pin(release, run.root)
    assert released(run) == release


# ---------------------------------------------------------------- rebuilding


@pytest.fixture
def measured(
    config: Settings, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> making.FinishedRun:
    """A run of measured logs, which a rebuild has to find again; the project is the folder."""
    campaign = without(config, "twin", "torque").with_changes({"campaign": {"figures": ["curves"]}})
    own = Settings.from_plain_values({**campaign.plain_values(), "bearings": {}})
    run = finished_run(project(tmp_path / "project"), own, RAW, {"runs": runs_of(RAW)})
    monkeypatch.chdir(run.root)
    return run


def test_rebuild_from_the_raw_logs_gives_the_same_bytes(
    measured: making.FinishedRun,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """The release's own configuration counts, whatever config/ holds by now."""
    fake_rebuild(monkeypatch, measured)
    assert main(["verify", str(released(measured)), "--rebuild"]) == 0
    assert "the same bytes" in capsys.readouterr().out


def test_rebuild_names_every_difference(
    measured: making.FinishedRun,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    release = released(measured)
    fake_rebuild(monkeypatch, measured, summary=b"fine\nor not\n")
    (measured.root / "workflow/oilfilm/fit.py").write_text("answer = 43\n", encoding="utf-8")
    assert main(["verify", str(release), "--rebuild"]) == 1
    printed = capsys.readouterr().out
    assert re.findall(r"(?m)^  (\S+) +[0-9a-f]{12}  [0-9a-f]{12}$", printed) == [
        *("code/workflow/oilfilm/fit.py", "report.html", "summary.txt")
    ]


def test_rebuild_on_another_kernel_says_so(
    measured: making.FinishedRun,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    release = released(measured)
    here = read_manifest(release)[0].made_from.environment
    there = here.model_copy(update={"blas": ["openblas 0.3.31 Elsewhere"]})
    monkeypatch.setattr(making, "environment", lambda home: there)
    fake_rebuild(monkeypatch, measured)
    assert main(["verify", str(release), "--rebuild"]) == 1
    printed = capsys.readouterr().out
    assert "\n\nMade with another kernel:\n" in printed
    assert "  B openblas 0.3.31 Elsewhere; NumPy" in printed
    # the packages, and the files that name them
    assert re.findall(r"(?m)^([A-Z]\w+): \d+$", printed) == ["Packages", "Files"]


def test_rebuild_that_fails_ends_in_its_last_words_which_steer_no_terminal(
    measured: making.FinishedRun, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    python = tmp_path / "python"
    python.write_text('#!/bin/sh\nprintf "first\\n\\033[31mred in %s\\n" "$PWD"\nexit 1\n')
    python.chmod(0o755)
    monkeypatch.setattr(releasing.sys, "executable", str(python))
    with pytest.raises(OilfilmError) as failed:
        releasing.rebuild(released(measured), measured.root, "1")
    assert "the rebuild failed. Its last lines:\nfirst\n\\x1b[31mred in ." in str(failed.value)


def test_rebuild_wants_the_very_logs(measured: making.FinishedRun) -> None:
    release = released(measured)
    (measured.root / SECOND).write_bytes(b"load_n\n2.02\n")
    with pytest.raises(OilfilmError, match=f"{SECOND}: is not the log that release"):
        releasing.rebuild(release, measured.root, "1")
