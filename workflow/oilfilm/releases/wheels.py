"""The packages of a lock as files that pip installs without a network."""

import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

from packaging.utils import parse_wheel_filename

from oilfilm.digests import file_digest
from oilfilm.errors import OilfilmError, printable

# Folder of the packages in an archive, and in it the list of them that pip reads.
WHEELS, LOCK_OF_WHEELS = "wheels", "wheels.lock"
_SETUPTOOLS = re.compile(r"^setuptools==.*?(?=^\S)", re.MULTILINE | re.DOTALL)


def collect_wheels(lock: Path, folder: Path) -> None:
    """Download every package of a lock for this Python and kind of machine, by its hash.

    What comes as source only is built here, with the setuptools of the lock: where it is installed
    later, there may be no compiler. `LOCK_OF_WHEELS` has the hashes of the files as they are then.

    Args:
        lock: Names, versions and hashes, as requirements.lock.
        folder: Where the wheels go; made.

    Raises:
        OilfilmError: A package cannot be had, or this Python cannot make environments.
    """
    with tempfile.TemporaryDirectory(prefix="oilfilm-wheels-") as temporary:
        place = Path(temporary)
        # the environment at hand may have been made without pip
        _python(sys._base_executable, "-m", "venv", str(place / "venv"))  # type: ignore[attr-defined]
        pip = (str(place / "venv" / "bin" / "python"), "-m", "pip", "--disable-pip-version-check")
        builder = _SETUPTOOLS.search(f"{lock.read_text(encoding='utf-8')}\nend\n")
        if builder is None:
            raise OilfilmError(
                f"{lock}: does not name setuptools, which builds packages from source."
            )
        (place / "setuptools.lock").write_text(builder[0], encoding="utf-8")
        known = ("--require-hashes", "--requirement")
        _python(*pip, "install", "--quiet", *known, str(place / "setuptools.lock"))
        how = ("--no-deps", "--no-build-isolation", "--wheel-dir", str(folder))
        _python(*pip, "wheel", "--quiet", *how, *known, str(lock))
    lines = []
    for wheel in sorted(folder.glob("*.whl")):
        name, version, _, _ = parse_wheel_filename(wheel.name)
        lines.append(f"{name}=={version} --hash=sha256:{file_digest(wheel)}\n")
    (folder / LOCK_OF_WHEELS).write_text("".join(lines), encoding="utf-8")


def _python(*command: str) -> None:
    done = subprocess.run(  # noqa: S603 - fixed commands; paths are one argument each
        command,
        env={**os.environ, "PIP_USE_PEP517": "1"},
        capture_output=True,
        text=True,
        errors="replace",
        check=False,
    )
    if done.returncode != 0:
        last = "\n".join(printable(line) for line in done.stderr.splitlines()[-5:])
        raise OilfilmError(
            "The packages of requirements.lock cannot be collected. Leave them out by "
            f"`--no-packages`, or mend this:\n{last}"
        )
