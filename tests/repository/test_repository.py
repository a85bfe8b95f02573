"""What must stay true of the files of the repository themselves."""

import io
import os
import re
import subprocess
import sys
import tarfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import yaml

ROOT = Path(__file__).parents[2]
WORKFLOWS = sorted((ROOT / ".github" / "workflows").glob("*.yml"))
PROFILES = sorted((ROOT / "profiles").glob("*/config.yaml"))

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
    return [
        f"{path.relative_to(ROOT)}:{number}: {line.strip()[:80]}"
        for path in tracked()
        for number, line in enumerate(path.read_text("utf-8", "replace").splitlines(), start=1)
        if pattern.search(line)
    ]


def actions() -> Iterator[str]:
    for path in WORKFLOWS:
        yield from re.findall(r"(?m)^\s*(?:- )?uses:\s*(.+)$", path.read_text(encoding="utf-8"))


def workflow(path: Path) -> dict[str, Any]:
    content = yaml.safe_load(path.read_text(encoding="utf-8"))
    assert isinstance(content, dict)
    return content


def steps(path: Path) -> list[dict[str, Any]]:
    return [step for job in workflow(path)["jobs"].values() for step in job["steps"]]


def commands(path: Path) -> list[str]:
    return [step["run"] for step in steps(path) if "run" in step]


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
    own = [
        line
        for line in script.read_text(encoding="utf-8").splitlines()
        if line and not line.startswith(("#", "set ", "cd "))
    ]
    assert own == [".ci/tools", "make test"]
    assert commands(ROOT / ".github/workflows/test.yml") == [*own, ".ci/windows"]


@pytest.mark.parametrize("path", WORKFLOWS, ids=lambda path: path.name)
def test_what_github_runs_can_be_run_anywhere(path: Path):
    targets = (ROOT / "Makefile").read_text(encoding="utf-8")
    for command in commands(path):
        script, _, rest = command.partition(" ")
        if script == "make":
            assert re.search(rf"(?m)^{rest}:", targets), command
        else:
            assert (ROOT / script).stat().st_mode & 0o100, command


@pytest.mark.parametrize("path", WORKFLOWS, ids=lambda path: path.name)
def test_workflows_may_only_read_but_for_those_that_publish(path: Path):
    publish = {
        "release.yml": [{"contents": "write", "attestations": "write", "id-token": "write"}],
        "docs.yml": [{"pages": "write", "id-token": "write"}],
    }
    assert workflow(path)["permissions"] == {"contents": "read"}
    more = [job["permissions"] for job in workflow(path)["jobs"].values() if "permissions" in job]
    assert more == publish.get(path.name, [])
    assert "secrets." not in path.read_text(encoding="utf-8")


@pytest.mark.parametrize("path", WORKFLOWS, ids=lambda path: path.name)
def test_nothing_is_cached_but_downloads_that_the_lock_checks(path: Path):
    for step in steps(path):
        assert "actions/cache" not in step.get("uses", "")
        given = step.get("with", {})
        assert given.get("cache", "pip") == "pip"
        lock = "requirements-dev.lock"
        assert given.get("cache-dependency-path", lock) == lock


@pytest.mark.parametrize("path", PROFILES, ids=lambda path: path.parent.name)
def test_profiles_name_steps_of_the_workflow_and_agree_on_how_a_run_goes(path: Path):
    smk = "".join(path.read_text("utf-8") for path in (ROOT / "workflow/rules").glob("*.smk"))
    steps = set(re.findall(r"(?m)^ *(?:rule|checkpoint) (\w+):$", smk))
    profile, default = workflow(path), workflow(ROOT / "profiles/default/config.yaml")
    grouped = {pair.partition("=")[0] for pair in profile.get("groups", [])}
    assert grouped | set(profile.get("set-resources", {})) <= steps
    shared = default.keys() - {"cores"} if "executor" in profile else set()
    assert {key: profile[key] for key in shared} == {key: default[key] for key in shared}


def test_what_may_sign_and_publish_runs_nothing_that_was_installed():
    """No test and no package has the rights of the job that attests what is published."""
    publish = workflow(ROOT / ".github/workflows/release.yml")["jobs"]["publish"]
    assert publish["needs"] == "release"
    used = [step.get("uses", step.get("run")).partition("@")[0] for step in publish["steps"]]
    assert used == [
        *("actions/checkout", "actions/download-artifact", "actions/attest"),
        '.ci/publish "$GITHUB_REF_NAME"',
    ]


def test_actions_are_pinned_by_commit_with_their_version_beside():
    used = list(actions())
    assert used
    assert not [each for each in used if not re.fullmatch(r"[\w./-]+@[0-9a-f]{40} # v[\d.]+", each)]


@pytest.mark.skipif(sys.platform != "linux", reason="GitHub publishes on Linux, by GNU tar")
def test_published_archives_are_the_same_bytes_whatever_the_umask(tmp_path: Path):
    """A stand-in for `gh` shows what it was given."""
    bin_ = tmp_path / "bin"
    bin_.mkdir()
    (bin_ / "gh").write_text('#!/bin/sh\nprintf "%s\\n" "$@"\n', encoding="utf-8")
    (bin_ / "gh").chmod(0o755)
    environment = {**os.environ, "PATH": f"{bin_}{os.pathsep}{os.environ['PATH']}"}
    archives = []
    for mask in (0o022, 0o077):
        project = tmp_path / f"{mask:o}"
        release = project / "results/releases/demo/v1-0123456789ab"
        for path, mode in ((release, 0o777), (release / "tables", 0o777)):
            path.mkdir(parents=True)
            path.chmod(mode & ~mask)
        (release / "tables/runs.parquet").write_bytes(b"PAR1")
        (release / "tables/runs.parquet").chmod(0o444)
        (release.parent / "latest").symlink_to(release.name)
        subprocess.run([ROOT / ".ci/pack"], cwd=project, check=True)
        done = subprocess.run(
            [ROOT / ".ci/publish", "v1"],
            cwd=project,
            env=environment,
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 0, done.stderr
        *arguments, archive = done.stdout.split()
        assert arguments[:4] == ["release", "create", "v1", "--verify-tag"]
        assert archive == "results/releases/demo-v1-0123456789ab.tar.gz"
        archives.append((project / archive).read_bytes())
    assert archives[0] == archives[1]
    with tarfile.open(fileobj=io.BytesIO(archives[0])) as archive:
        assert {member.name: oct(member.mode) for member in archive} == {
            "v1-0123456789ab": "0o755",
            "v1-0123456789ab/tables": "0o755",
            "v1-0123456789ab/tables/runs.parquet": "0o644",
        }
