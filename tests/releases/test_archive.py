"""A release in one file and out of it again; damaged and hostile archives."""

import hashlib
import io
import shutil
import subprocess
import sys
import tarfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pyarrow as arrow
import pytest

from campaigns import ROOT, lay_out_small
from oilfilm import home
from oilfilm.cli import main
from oilfilm.errors import OilfilmError
from oilfilm.releases import archive as archives
from oilfilm.releases.archive import make_archive, restore_archive
from oilfilm.releases.manifest import files_below
from oilfilm.releases.verify import verify
from oilfilm.settings.resolved import Settings
from releases import measured_run, released

RAW = {"a 100%.csv": b"load_n\n1\n", "b 12:30.csv": b"load_n\n2\n"}
Members = list[tuple[tarfile.TarInfo, bytes]]


@pytest.fixture(scope="module")
def release(config: Settings, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The release of a project with measured logs, which tests leave as they found it."""
    return released(measured_run(config, tmp_path_factory.mktemp("archive") / "project", RAW))


@pytest.fixture(autouse=True)
def in_project(release: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(release.parents[3])
    monkeypatch.setattr(home, "HOME", release.parents[3])


@pytest.fixture(scope="module")
def archive(release: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(home, "HOME", release.parents[3])
        file = tmp_path_factory.mktemp("archives") / "june.tar.zst"
        make_archive(release, release.parents[3], file, packages=False)
        yield file


def test_archive_gives_back_release_logs_code_and_settings(
    release: Path, archive: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "restored"
    assert main(["restore", str(archive), str(folder)]) == 0
    assert "all files are as archived and as released" in capsys.readouterr().out
    place = folder / release.relative_to(release.parents[3])
    assert files_below(place) == files_below(release)
    assert verify(place) == []
    for name, content in RAW.items():
        assert (folder / "data/raw/demo" / name).read_bytes() == content
    for path in ("workflow/oilfilm/fit.py", "requirements.lock", "data/reference/claims.yaml"):
        assert (folder / path).read_bytes() == (release.parents[3] / path).read_bytes()
    assert (folder / "config/config.yaml").is_file()
    guide = (folder / "RESTORE.txt").read_text(encoding="utf-8")
    assert f"{place.relative_to(folder)} --rebuild" in guide
    # this archive has no packages
    assert "--require-hashes -r requirements.lock" in guide
    assert "--no-index" not in guide


def test_same_release_gives_the_same_archive(release: Path, archive: Path, tmp_path: Path) -> None:
    again = tmp_path / "again.tar.zst"
    make_archive(release.parent / "latest", release.parents[3], again, packages=False)
    assert again.read_bytes() == archive.read_bytes()


def test_tar_and_sha256sum_alone_open_and_check_it(archive: Path, tmp_path: Path) -> None:
    """RFC 8493: a bag needs no program of ours. GNU tar calls zstd, or Python stands in for it."""
    with arrow.CompressedInputStream(str(archive), "zstd") as plain:
        (tmp_path / "bag.tar").write_bytes(plain.read())
    subprocess.run(["tar", "-xf", "bag.tar"], cwd=tmp_path, check=True)
    (bag,) = (path for path in tmp_path.iterdir() if path.is_dir())
    assert (bag / "bagit.txt").read_text().startswith("BagIt-Version: 1.0\n")
    listing = (bag / "manifest-sha256.txt").read_text()
    assert "100%25.csv" in listing  # RFC 8493, section 2.1.3
    (bag / "plain").write_text(listing.replace("%25", "%"))
    for name in ("plain", "tagmanifest-sha256.txt"):
        subprocess.run(["sha256sum", "--quiet", "-c", name], cwd=bag, check=True)
    size, count = (bag / "bag-info.txt").read_text().split("Payload-Oxum: ")[1].split(".")
    payload = [path for path in (bag / "data").rglob("*") if path.is_file()]
    assert (int(size), int(count)) == (sum(p.stat().st_size for p in payload), len(payload))


def members_of(file: Path) -> Members:
    with (
        arrow.CompressedInputStream(str(file), "zstd") as plain,
        tarfile.open(fileobj=io.BytesIO(plain.read())) as opened,
    ):
        return [(each, opened.extractfile(each).read()) for each in opened]  # type: ignore[union-attr]


def packed(members: Members, file: Path) -> Path:
    with (
        arrow.CompressedOutputStream(str(file), "zstd") as stream,
        tarfile.open(fileobj=stream, mode="w|") as opened,  # type: ignore[call-overload]
    ):
        for member, content in members:
            opened.addfile(member, io.BytesIO(content) if member.isreg() else None)
    return file


def added(name: str, content: bytes = b"x", **changes: Any) -> Callable[[Members], Members]:
    def change(members: Members) -> Members:
        member = tarfile.TarInfo(members[0][0].name.partition("/")[0] + "/" + name)
        member.size = len(content)
        for key, value in changes.items():
            setattr(member, key, value)
        return [*members, (member, content)]

    return change


def altered(part: str) -> Callable[[Members], Members]:
    """One bit of the last file with a part in its name."""

    def change(members: Members) -> Members:
        last = max(index for index, (member, _) in enumerate(members) if part in member.name)
        member, content = members[last]
        return [
            *members[:last],
            (member, bytes([content[0] ^ 1]) + content[1:]),
            *members[last + 1 :],
        ]

    return change


def relisted(part: str) -> Callable[[Members], Members]:
    """An altered file whose hash is right in the listing, as a stranger can write it."""
    return lambda members: _relisted(members, altered(part)(members))


def _relisted(members: Members, changed: Members) -> Members:
    texts = {member.name.partition("/")[2]: content for member, content in changed}
    (index,) = (n for n, pair in enumerate(changed) if pair[1] != members[n][1])
    path = changed[index][0].name.partition("/")[2].replace("%", "%25")
    old, new = (hashlib.sha256(each[index][1]).hexdigest() for each in (members, changed))
    listing = texts["manifest-sha256.txt"].replace(
        f"{old}  {path}".encode(), f"{new}  {path}".encode()
    )
    tags = texts["tagmanifest-sha256.txt"].replace(
        hashlib.sha256(texts["manifest-sha256.txt"]).hexdigest().encode(),
        hashlib.sha256(listing).hexdigest().encode(),
    )
    texts |= {"manifest-sha256.txt": listing, "tagmanifest-sha256.txt": tags}
    return [(member, texts[member.name.partition("/")[2]]) for member, _ in changed]


HOSTILE: dict[str, tuple[Callable[[Members], Members], str]] = {
    "out of the folder": (added("data/../../x"), "is not a path below its folder"),
    "absolute": (added("/x"), "is not a path below its folder"),
    "drive": (added("c:x"), "is not a path below its folder"),
    "control character": (added("data/a\nb"), "is not a path below its folder"),
    "twice": (lambda members: [*members, members[-1]], "or occurs twice"),
    "link": (added("data/l", type=tarfile.SYMTYPE, linkname="/etc/passwd"), "is not a plain file"),
    "hard link": (added("data/l", type=tarfile.LNKTYPE, linkname="data/x"), "is not a plain file"),
    "device": (added("data/d", type=tarfile.CHRTYPE), "is not a plain file"),
    "extra": (added("data/x"), r"data/x is not named in it \(manifest"),
    "extra tag": (added("fetch.txt"), r"fetch.txt is not named in it \(tagmanifest"),
    "missing": (lambda members: members[:-1], "is missing"),
    "no listing": (lambda members: [each for each in members if "/tagm" not in each[0].name], "is"),
    "altered": (altered("/code/"), "differs"),
    "release relisted": (
        relisted("runs.parquet"),
        "its release is not as it was made: tables/runs",
    ),
    "code relisted": (relisted("/data/workflow/"), "the code beside it is not the one that made"),
    "log relisted": (relisted("/data/raw/"), r"not as it was made: data/raw/demo/"),
    "empty": (lambda members: [], "tagmanifest-sha256.txt is missing"),
}


@pytest.mark.parametrize("name", HOSTILE)
def test_damaged_or_hostile_archive_leaves_nothing(
    archive: Path, tmp_path: Path, name: str
) -> None:
    change, sentence = HOSTILE[name]
    file = packed(change(members_of(archive)), tmp_path / "stranger.tar.zst")
    with pytest.raises(OilfilmError, match=sentence):
        restore_archive(file, tmp_path / "inner" / "restored")
    assert not (tmp_path / "inner" / "restored").exists()
    assert {path.name for path in tmp_path.iterdir()} <= {"stranger.tar.zst", "inner"}


@pytest.mark.parametrize("share", [0.0, 0.1, 0.5, 0.999])
def test_archive_that_was_cut_is_refused(archive: Path, tmp_path: Path, share: float) -> None:
    content = archive.read_bytes()
    file = tmp_path / "cut.tar.zst"
    file.write_bytes(content[: int(share * len(content))])
    with pytest.raises(OilfilmError, match=r"cannot be read as an archive|is missing"):
        restore_archive(file, tmp_path / "restored")
    assert not (tmp_path / "restored").exists()


def test_file_larger_than_the_room_is_refused_before_it_is_unpacked(
    archive: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    usage = shutil.disk_usage(tmp_path)
    monkeypatch.setattr(archives.shutil, "disk_usage", lambda _: usage._replace(free=1000))
    with pytest.raises(OilfilmError, match="too large for this disk"):
        restore_archive(archive, tmp_path / "restored")


def test_what_cannot_be_archived_is_told(
    release: Path, archive: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    project = release.parents[3]
    with pytest.raises(OilfilmError, match=r"exists already. Name a new file"):
        make_archive(release, project, archive, packages=False)
    with pytest.raises(OilfilmError, match=r"exists already. Name a new folder"):
        restore_archive(archive, tmp_path)
    with pytest.raises(OilfilmError, match="is not the log that release"):
        make_archive(release, tmp_path, tmp_path / "a.tar.zst", packages=False)
    monkeypatch.setattr(home, "HOME", ROOT)
    with pytest.raises(OilfilmError, match="was made by other code than is installed here"):
        make_archive(release, project, tmp_path / "a.tar.zst", packages=False)
    assert not (tmp_path / "a.tar.zst").exists()


@pytest.mark.nightly
def test_restored_release_is_made_again_without_a_network(tmp_path: Path) -> None:
    """A blank Python, the packages of the archive, no registry: the same bytes."""
    project, file = tmp_path / "project", tmp_path / "small.tar.zst"
    lay_out_small(project)

    def run(*command: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run(command, cwd=project, capture_output=True, text=True, check=False)

    assert run("snakemake", "release", "--config", "campaign=small").returncode == 0
    done = run("oilfilm", "archive", "results/releases/small/latest", str(file))
    if "packages of requirements.lock cannot be collected" in done.stderr:
        pytest.skip(f"no registry of packages can be reached: {done.stderr.splitlines()[-1]}")
    assert done.returncode == 0, done.stderr
    restored = tmp_path / "restored"
    assert run("oilfilm", "restore", str(file), str(restored)).returncode == 0
    guide = (restored / "RESTORE.txt").read_text(encoding="utf-8")
    steps = [line.strip() for line in guide.splitlines() if line.startswith("    ")]
    assert len(steps) == 3
    # nothing of this environment, and every registry out of reach
    nowhere = "http://127.0.0.1:9"
    proxies = ("HTTP_PROXY", "HTTPS_PROXY", "http_proxy", "https_proxy")
    surroundings = {
        "PATH": f"{Path(sys._base_executable).parent}:/usr/bin:/bin",  # type: ignore[attr-defined]
        "HOME": str(tmp_path / "home"),
        "PIP_INDEX_URL": nowhere,
        **dict.fromkeys(proxies, nowhere),
    }
    for step in steps:
        done = subprocess.run(
            ["bash", "-c", step],
            cwd=restored,
            env=surroundings,
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 0, f"{step}\n{done.stdout}{done.stderr}"
    assert "rebuilt from the raw logs: the same bytes" in done.stdout
