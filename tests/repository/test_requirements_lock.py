"""The lock files against pyproject.toml and the installed packages, without a network."""

import re
import sys
import tomllib
from importlib import metadata
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from campaigns import ROOT
from command_line import succeeded

LOCKS = {path.stem: path for path in ROOT.glob("requirements/*.lock")}
# The extras of pyproject.toml that each lock holds.
RUNNING = ("report", "workflow", "clone")
EXTRAS = {
    "run": RUNNING,
    "dev": (*RUNNING, "s3", "dev"),
    "s3": ("workflow", "s3"),
    "slurm": ("workflow", "slurm"),
    "docs": ("report", "docs"),
}


def pins(lock: Path) -> dict[str, list[Requirement]]:
    """The pinned versions of each package; more than one where markers tell them apart."""
    found: dict[str, list[Requirement]] = {}
    for line in re.findall(r"(?m)^[A-Za-z0-9][^\\\n]*", lock.read_text(encoding="utf-8")):
        pin = Requirement(line)
        found.setdefault(canonicalize_name(pin.name), []).append(pin)
    return found


def version(pin: Requirement) -> str:
    (specifier,) = pin.specifier
    assert specifier.operator == "==", f"{pin} is no pin"
    return specifier.version


@pytest.mark.parametrize("lock", EXTRAS)
def test_lock_has_what_pyproject_asks_for(lock: str) -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    asked = [*project["dependencies"]]
    for extra in EXTRAS[lock]:
        asked += project["optional-dependencies"][extra]
    pinned = pins(LOCKS[lock])
    for needed in (each for each in map(Requirement, asked) if each.name != project["name"]):
        if needed.marker is None or needed.marker.evaluate({"extra": ""}):
            versions = [version(pin) for pin in pinned.get(canonicalize_name(needed.name), [])]
            fit = any(needed.specifier.contains(each, True) for each in versions)
            assert fit, "run `make lock`"


def test_locked_versions_are_installed_and_fit_each_other() -> None:
    installed = {canonicalize_name(each.name): each.version for each in metadata.distributions()}
    different = [
        f"{pin}: {installed.get(name)} is installed"
        for name, several in pins(LOCKS["dev"]).items()
        for pin in several
        if pin.marker is None or pin.marker.evaluate()
        if installed.get(name) != version(pin)
    ]
    assert not different, "run `make`"
    check = [sys.executable, "-m", "uv", "pip", "check", "--python", sys.executable]
    succeeded(check)


def test_locks_agree_and_name_hashes_but_no_place_to_install_from() -> None:
    """Optional packages and benchmarks run in one process with ours."""
    ours = pins(LOCKS["dev"])
    for lock in (*LOCKS.values(), *ROOT.glob("benchmarks/*.lock")):
        text, theirs = lock.read_text(encoding="utf-8"), pins(lock)
        for name in ours.keys() & theirs.keys():
            assert {version(pin) for pin in theirs[name]} <= {version(pin) for pin in ours[name]}
        blocks = re.findall(r"(?m)^[A-Za-z0-9].*\n(?: .*\n?)*", text)
        assert len(blocks) == sum(map(len, theirs.values()))
        assert all(re.search(r"--hash=sha256:[0-9a-f]{64}\b", block) for block in blocks)
        # no address, no option line (--index-url, --find-links), no direct reference, no path
        assert not re.findall(r"(?m)^.*://.*$|^-.*$|^[^#\n]* @ .*$|^[^#\n]*/.*$", text)
