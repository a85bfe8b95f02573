"""What must stay true of the files of the repository themselves."""

import re
import subprocess
from pathlib import Path

import pytest
import yaml

from campaigns import ROOT

PROFILES = sorted((ROOT / "profiles").glob("*/config.yaml"))
# A path of a machine, or a package registry.
FORBIDDEN = re.compile(
    r"(?<![\w.~-])/(?:home|Users|root|work|opt|tmp|private|mnt)/\w|\b[A-Z]:\\Users"
    r"|pypi\.org|pythonhosted\.org|npmjs\.(?:org|com)|anaconda\.(?:org|com)|deb\.debian\.org"
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


@pytest.mark.slow
def test_no_file_names_a_path_of_a_machine_or_a_package_registry() -> None:
    assert not [
        f"{path.relative_to(ROOT)}:{number}: {line.strip()[:80]}"
        for path in tracked()
        for number, line in enumerate(path.read_text("utf-8", "replace").splitlines(), start=1)
        if FORBIDDEN.search(line)
    ]


@pytest.mark.parametrize("path", PROFILES, ids=lambda path: path.parent.name)
def test_profile_names_steps_of_the_workflow_and_runs_as_the_default_does(path: Path) -> None:
    smk = "".join(path.read_text("utf-8") for path in (ROOT / "workflow/rules").glob("*.smk"))
    steps = set(re.findall(r"(?m)^ *(?:rule|checkpoint) (\w+):$", smk))
    profile, default = (
        yaml.safe_load(each.read_text("utf-8"))
        for each in (path, ROOT / "profiles/default/config.yaml")
    )
    grouped = {pair.partition("=")[0] for pair in profile.get("groups", [])}
    assert grouped | set(profile.get("set-resources", {})) <= steps
    shared = default.keys() - {"cores"} if "executor" in profile else set()
    assert {key: profile[key] for key in shared} == {key: default[key] for key in shared}
