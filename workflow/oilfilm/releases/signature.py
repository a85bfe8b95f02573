"""Signatures of releases, by the SSH keys that laboratories have already.

A manifest names the hash of every file, but whoever can write the release can write another
manifest. A signature of the manifest shows who vouches for it. OpenSSH makes and checks it
(`ssh-keygen -Y`, version 8.2 or newer); no key is read here.

Reference: OpenSSH, PROTOCOL.sshsig.
"""

import subprocess
from pathlib import Path

from oilfilm.atomic_write import write_bytes
from oilfilm.errors import OilfilmError, printable
from oilfilm.releases.manifest import MANIFEST, SIGNATURE, read_manifest


class NotSignedError(OilfilmError):
    """Nobody who is trusted vouches for a release."""


# A signature for another purpose is none of a release.
_PURPOSE = "oilfilm-release"
# One with the largest key of OpenSSH takes a tenth of this.
_LARGEST = 1 << 16


def sign(folder: Path, key: Path) -> Path:
    """Sign the manifest of a release; the file of the signature, beside the manifest.

    Args:
        folder: Folder of the release.
        key: Private SSH key, or a public one whose private part an agent holds. OpenSSH asks for
            its passphrase.

    Raises:
        OilfilmError: It is no release, or OpenSSH cannot sign with the key.
    """
    _, pinned = read_manifest(folder)
    if pinned:
        raise OilfilmError(f"{folder}: is a pin; sign the release that it was made from.")
    if not key.is_file():
        raise OilfilmError(f"{key}: there is no such key; expected the file of an SSH key.")
    content = (folder / MANIFEST).read_bytes()
    made = _ssh_keygen(["-Y", "sign", "-f", str(key), "-n", _PURPOSE], content)
    if made.returncode:
        raise OilfilmError(f"{key}: OpenSSH cannot sign with it: {_last_line(made)}")
    write_bytes(made.stdout, folder / SIGNATURE)
    return folder / SIGNATURE


def signer(folder: Path, signers: Path) -> str:
    """Who has signed a release: the name beside the key in the file of trusted signers.

    Args:
        folder: Folder of the release.
        signers: One line per key, `name key-type key`, as OpenSSH reads it (ssh-keygen(1),
            ALLOWED SIGNERS). Keep it where nobody else can write.

    Raises:
        NotSignedError: There is no signature, or it is of another manifest or of a stranger.
        OilfilmError: The file of signers or OpenSSH is missing.
    """
    signature = folder / SIGNATURE
    if not signers.is_file():
        raise OilfilmError(f"{signers}: there is no such file of trusted signers.")
    if not signature.is_file() or signature.is_symlink():
        raise NotSignedError(
            f"{SIGNATURE}: is missing. Whoever made the release can sign it: oilfilm sign RELEASE "
            "--key KEY"
        )
    if signature.stat().st_size > _LARGEST:
        raise NotSignedError(
            f"{SIGNATURE}: is larger than {_LARGEST} bytes, so it is not a signature."
        )
    both = ["-f", str(signers), "-s", str(signature), "-n", _PURPOSE]
    known = _ssh_keygen(["-Y", "find-principals", *both])
    name = known.stdout.decode("utf-8", "replace").partition("\n")[0].strip()
    if known.returncode or not name:
        raise NotSignedError(
            f"{SIGNATURE}: was made by none of the signers in {signers}. Do not trust the release, "
            "or add the key of its maker after you have checked it by another channel."
        )
    checked = _ssh_keygen(["-Y", "verify", *both, "-I", name], (folder / MANIFEST).read_bytes())
    if checked.returncode:
        raise NotSignedError(
            f"{SIGNATURE}: does not fit this manifest ({_last_line(checked)}). The release was "
            f"altered after {printable(name)} signed it, or the signature belongs to another one."
        )
    return name


def _ssh_keygen(
    arguments: list[str], content: bytes | None = None
) -> subprocess.CompletedProcess[bytes]:
    try:
        # a list of arguments, no shell; the program that the user's own system has
        return subprocess.run(  # noqa: S603
            ["ssh-keygen", *arguments],  # noqa: S607
            input=content,
            capture_output=True,
            check=False,
        )
    except FileNotFoundError:
        raise OilfilmError(
            "ssh-keygen was not found. Install OpenSSH (Debian, Ubuntu: sudo apt install "
            "openssh-client)."
        ) from None


def _last_line(done: subprocess.CompletedProcess[bytes]) -> str:
    lines = done.stderr.decode("utf-8", "replace").strip().splitlines()
    return printable(lines[-1]) if lines else f"ssh-keygen ended with code {done.returncode}"
