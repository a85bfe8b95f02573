"""What must stay true of the files of the repository themselves."""

import re
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).parents[1]
WORKFLOWS = sorted((ROOT / ".github" / "workflows").glob("*.yml"))

MACHINE_PATH = re.compile(
    r"(?<![\w.~-])/(?:home|Users|root|work|opt|tmp|private|mnt)/\w|\b[A-Z]:\\Users"
)
REGISTRY = re.compile(
    r"pypi\.org|pythonhosted\.org|npmjs\.(?:org|com)|anaconda\.(?:org|com)|deb\.debian\.org", re.I
)


def tracked() -> list[Path]:
    """The files under version control, and the new ones that would be added."""
    listed = subprocess.run(
        ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
        cwd=ROOT,
        capture_output=True,
        check=False,
    )
    if listed.returncode != 0:
        pytest.skip("not a clone: git knows no files here")
    paths = (ROOT / name for name in listed.stdout.decode().split("\0") if name)
    return [path for path in paths if path.is_file()]


def lines_with(pattern: re.Pattern[str]) -> list[str]:
    found = []
    for path in tracked():
        text = path.read_bytes().decode(errors="replace")
        for number, line in enumerate(text.splitlines(), start=1):
            if pattern.search(line):
                found.append(f"{path.relative_to(ROOT)}:{number}: {line.strip()[:80]}")
    return found


def actions() -> Iterator[str]:
    for path in WORKFLOWS:
        yield from re.findall(r"(?m)^\s*(?:- )?uses:\s*(.+)$", path.read_text(encoding="utf-8"))


def steps() -> list[str]:
    jobs = [yaml.safe_load(path.read_text(encoding="utf-8"))["jobs"] for path in WORKFLOWS]
    return [
        step["run"]
        for several in jobs
        for job in several.values()
        for step in job["steps"]
        if "run" in step
    ]


def test_no_file_names_a_path_of_somebodys_machine():
    assert not lines_with(MACHINE_PATH)


def test_no_file_names_a_package_registry():
    assert not lines_with(REGISTRY)


@pytest.mark.parametrize("folder", ["home", "Users", "root", "work"])
def test_machine_paths_are_recognised(folder: str):
    assert MACHINE_PATH.search(f"see /{folder}/someone/data.txt")
    assert not MACHINE_PATH.search(f"see results/{folder}/someone/data.txt")


def test_ci_runs_the_users_own_command():
    script = ROOT / ".ci" / "run"
    commands = [
        line
        for line in script.read_text(encoding="utf-8").splitlines()
        if line and not line.startswith(("#", "set ", "cd "))
    ]
    assert commands == [".ci/tools", "make test"]
    assert steps() == commands


def test_actions_are_pinned_by_commit_with_their_version_beside():
    used = list(actions())
    assert used
    assert not [each for each in used if not re.fullmatch(r"[\w./-]+@[0-9a-f]{40} # v[\d.]+", each)]
