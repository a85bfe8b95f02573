"""Whoever can write a release can write its manifest anew, but cannot sign it for another."""

import json
import shutil
import subprocess
from pathlib import Path

import pytest

from campaigns import ROOT
from oilfilm.cli import main
from oilfilm.errors import OilfilmError
from oilfilm.releases.manifest import CHECKSUMS, MANIFEST, SIGNATURE, read_manifest
from oilfilm.releases.signature import NotSignedError, sign, signer
from oilfilm.releases.verify import verify
from oilfilm.settings.resolved import Settings
from releases import alter, made, project, released, runs_of

RAW = {"a.csv": b"load_n\n1\n"}
pytestmark = pytest.mark.skipif(not shutil.which("ssh-keygen"), reason="ssh-keygen is missing")


@pytest.fixture
def release(config: Settings, tmp_path: Path) -> Path:
    return released(made(project(tmp_path / "p"), config, RAW, {"runs": runs_of(RAW, tmp_path)}))


def new_key(folder: Path, name: str) -> tuple[Path, str]:
    """A key without a passphrase, and its line in a file of trusted signers."""
    key = folder / name
    command = ["ssh-keygen", "-q", "-t", "ed25519", "-N", "", "-C", "", "-f", str(key)]
    subprocess.run(command, check=True)
    return key, f"{name}@lab.example {key.with_suffix('.pub').read_text(encoding='utf-8')}"


@pytest.fixture
def ada(tmp_path: Path) -> tuple[Path, Path]:
    """The key of somebody who is trusted, and the file of trusted signers."""
    key, line = new_key(tmp_path, "ada")
    signers = tmp_path / "signers"
    signers.write_text(line, encoding="utf-8")
    return key, signers


def test_signed_release_names_its_signer(
    release: Path, ada: tuple[Path, Path], capsys: pytest.CaptureFixture[str]
) -> None:
    key, signers = ada
    assert main(["sign", str(release), "--key", str(key)]) == 0
    capsys.readouterr()
    assert main(["verify", str(release), "--signers", str(signers)]) == 0
    assert "are as released; signed by ada@lab.example" in capsys.readouterr().out
    assert main(["verify", str(release), "--signers", str(signers), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["signed_by"] == "ada@lab.example"


def test_forged_release_passes_its_own_hashes_and_fails_its_signature(
    release: Path, ada: tuple[Path, Path], capsys: pytest.CaptureFixture[str]
) -> None:
    """The forger changes a result and writes every hash anew, also that of the manifest."""
    key, signers = ada
    sign(release, key)
    alter(release, "summary.txt", b"better\n")
    assert verify(release) == []
    with pytest.raises(NotSignedError, match="does not fit this manifest"):
        signer(release, signers)
    assert main(["verify", str(release), "--signers", str(signers)]) == 1
    assert "altered after ada@lab.example signed it" in capsys.readouterr().out


def test_key_of_a_stranger_is_no_signature(
    release: Path, ada: tuple[Path, Path], tmp_path: Path
) -> None:
    stranger, _ = new_key(tmp_path, "mallory")
    sign(release, stranger)
    with pytest.raises(NotSignedError, match=r"was made by none of the signers in .*signers"):
        signer(release, ada[1])


def test_signature_for_another_purpose_is_none_of_a_release(
    release: Path, ada: tuple[Path, Path]
) -> None:
    key, signers = ada
    content = (release / MANIFEST).read_bytes()
    command = ["ssh-keygen", "-Y", "sign", "-f", str(key), "-n", "git"]
    made_for_git = subprocess.run(command, input=content, capture_output=True, check=True)
    (release / SIGNATURE).write_bytes(made_for_git.stdout)
    with pytest.raises(NotSignedError, match="does not fit this manifest"):
        signer(release, signers)


@pytest.mark.parametrize("content", [None, b"", b"\xff" * 100, b"x" * (1 << 17)])
def test_release_without_a_true_signature_is_told(
    content: bytes | None, release: Path, ada: tuple[Path, Path]
) -> None:
    if content is not None:
        (release / SIGNATURE).write_bytes(content)
    with pytest.raises(NotSignedError, match=SIGNATURE):
        signer(release, ada[1])


def test_missing_key_and_missing_file_of_signers_are_told(release: Path, tmp_path: Path) -> None:
    with pytest.raises(OilfilmError, match="no such key"):
        sign(release, tmp_path / "nobody")
    with pytest.raises(OilfilmError, match="no such file of trusted signers"):
        signer(release, tmp_path / "nobody")
    with pytest.raises(OilfilmError, match="cannot sign with it"):
        sign(release, ROOT / "LICENSE")


@pytest.mark.skipif(not shutil.which("sha256sum"), reason="sha256sum is missing")
def test_sha256sum_checks_every_file_of_a_release(release: Path) -> None:
    """With a tool that every laboratory has, and nothing of this project."""
    check = ["sha256sum", "--check", "--strict", "--quiet", CHECKSUMS]
    assert subprocess.run(check, cwd=release, check=False).returncode == 0
    lines = (release / CHECKSUMS).read_text(encoding="utf-8").splitlines()
    files = {record.path for record in read_manifest(release)[0].files}
    assert {line.partition("  ")[2] for line in lines} == {MANIFEST, *files}
    summary = release / "summary.txt"
    summary.chmod(0o644)
    summary.write_text("better\n", encoding="utf-8")
    done = subprocess.run(check, cwd=release, capture_output=True, text=True, check=False)
    assert done.returncode != 0
    assert "summary.txt: FAILED" in done.stdout


def test_altered_checksums_are_told(release: Path) -> None:
    (release / CHECKSUMS).chmod(0o644)
    (release / CHECKSUMS).write_text("", encoding="utf-8")
    assert [each.partition(":")[0] for each in verify(release)] == [CHECKSUMS]
