"""Conda recipe, citation, archive and images say what pyproject.toml says; packages are built."""

import json
import re
import shlex
import shutil
import subprocess
import sys
import tomllib
from datetime import date
from pathlib import Path

import pytest
import yaml

from campaigns import ROOT
from command_line import succeeded

RECIPE = ROOT / "docs/containers/recipe.yaml"
# suffixes of files with text for people and machines
TEXT = {".md", ".toml", ".cff", ".yaml", ".yml", ".py", ".html", ".smk", ".mk", ".json", ".jinja"}
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]


def test_recipe_has_version_entry_point_and_packages_of_the_project() -> None:
    recipe = yaml.safe_load(RECIPE.read_text("utf-8"))
    assert recipe["context"]["version"] == PROJECT["version"]
    wanted = [f"python {PROJECT['requires-python']}", *PROJECT["dependencies"]]
    packages = {package.replace(" ", "") for package in recipe["requirements"]["run"]}
    assert packages == {package.replace(" ", "") for package in wanted}
    (entry,) = recipe["build"]["python"]["entry_points"]
    assert entry == f"oilfilm = {PROJECT['scripts']['oilfilm']}"


def test_citation_and_archive_have_title_version_authors_and_licence_of_the_project() -> None:
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text("utf-8"))
    archive = json.loads((ROOT / ".zenodo.json").read_text("utf-8"))
    for stated in (citation, archive):
        assert (stated["version"], stated["license"]) == (PROJECT["version"], PROJECT["license"])
        people = stated["authors"] if stated is citation else stated["creators"]
        assert people == PROJECT["authors"]
    assert archive["title"] == citation["title"]
    assert archive["description"] == citation["abstract"]
    assert archive["keywords"] == citation["keywords"]
    assert date.fromisoformat(citation["date-released"])


SHOWN = ("README.md", "pyproject.toml", "CITATION.cff")


def test_no_file_shows_a_placeholder_for_an_address() -> None:
    files = succeeded(["git", "ls-files", "-z"], cwd=ROOT).split("\0")
    texts = [ROOT / file for file in files if Path(file).suffix in TEXT]
    assert len(texts) > len(SHOWN)
    # in parts, so that this file is no example of it
    placeholder = "OWN" + "ER"
    assert not [path.name for path in texts if placeholder in path.read_text(encoding="utf-8")]


def test_release_writes_the_address_into_all_that_shows_one(tmp_path: Path) -> None:
    for name in SHOWN:
        shutil.copy(ROOT / name, tmp_path / name)
    address = "https://github.com/made-up/film"
    succeeded([sys.executable, ROOT / ".ci/address", address], cwd=tmp_path)
    project = tomllib.loads((tmp_path / "pyproject.toml").read_text("utf-8"))["project"]
    assert project["urls"].keys() == {"Homepage", "Documentation", "Changelog", "Issues"}
    assert project["urls"]["Homepage"] == address
    assert {**project, "urls": None} == {**PROJECT, "urls": None}
    citation = yaml.safe_load((tmp_path / "CITATION.cff").read_text("utf-8"))
    assert (citation["repository-code"], citation["url"]) == (
        address,
        "https://made-up.github.io/film",
    )
    badges = re.findall(
        r"(?m)^\[!\[\w+\]\((\S+)\)\]\((\S+)\)$", (tmp_path / "README.md").read_text("utf-8")
    )
    assert len(badges) == 3
    assert all("made-up" in image for image, _ in badges)


@pytest.mark.parametrize(
    "address", ["made-up/film", "http://example.org/x", "https://github.com/a"]
)
def test_release_refuses_what_is_no_address(address: str, tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, ROOT / ".ci/address", address],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 1
    assert address in done.stderr


@pytest.mark.nightly
def test_package_is_built_from_the_recipe(tmp_path: Path) -> None:
    """By this Python: conda-forge, which has the packages of the host, is not always reached."""
    rattler_build = pytest.importorskip("rattler_build", reason="pip install py-rattler-build")
    recipe = yaml.safe_load(RECIPE.read_text("utf-8"))
    recipe["source"]["path"] = str(ROOT)
    recipe["requirements"].pop("host")
    install = "-m uv pip install . --no-deps --no-build-isolation --prefix $PREFIX --python"
    recipe["build"]["script"] = f"{sys.executable} {install} {sys.executable}"
    path = tmp_path / "recipe.yaml"
    path.write_text(yaml.safe_dump(recipe), "utf-8")
    built = rattler_build.Stage0Recipe.from_file(path).run_build(
        output_dir=tmp_path / "out",
        channels=[],
        tool_config=rattler_build.ToolConfiguration(test_strategy="skip", compression_threads=1),
    )
    (package,) = (path for each in built for path in each.packages)
    content = rattler_build.Package.from_file(package)
    assert (content.name, str(content.version)) == ("oilfilm", PROJECT["version"])
    wanted = recipe["tests"][0]["package_contents"]["files"]
    assert {str(file) for file in content.files}.issuperset(wanted)


CONTAINERS = ROOT / "docs/containers"


def copied() -> list[str]:
    """What the image gets of a clone, by the list beside the Dockerfile."""
    lines = (CONTAINERS / "Dockerfile.dockerignore").read_text(encoding="utf-8").splitlines()
    return [line.removeprefix("!") for line in lines if line.startswith("!")]


def test_image_gets_every_file_that_the_wheel_ships() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    shipped = project["tool"]["hatch"]["build"]["targets"]["wheel"]["force-include"]
    assert shipped
    lost = [
        path for path in shipped if not any(Path(path).is_relative_to(name) for name in copied())
    ]
    assert lost == []


@pytest.mark.parametrize("recipe", ["Dockerfile", "apptainer.def"])
def test_base_image_is_named_by_its_digest(recipe: str) -> None:
    text = (CONTAINERS / recipe).read_text(encoding="utf-8")
    bases = re.findall(r"(?m)^(?:FROM|From:) \S+?(@sha256:[0-9a-f]{64})?$", text)
    assert bases
    assert all(bases)


@pytest.mark.nightly
def test_steps_of_the_recipes_work_in_an_empty_folder(tmp_path: Path) -> None:
    """No container engine is needed: the same commands, on the files that the image gets."""
    for name in copied():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        copy = shutil.copytree if (ROOT / name).is_dir() else shutil.copy
        copy(ROOT / name, tmp_path / name)
    text = (CONTAINERS / "Dockerfile").read_text(encoding="utf-8").replace("\\\n", " ")
    steps = [step for run in re.findall(r"(?m)^RUN (.+)$", text) for step in run.split("&&")]
    for step in (step for step in map(str.strip, steps) if step.startswith("make ")):
        succeeded(shlex.split(step), cwd=tmp_path)
    assert succeeded([tmp_path / ".venv/bin/oilfilm", "--version"]).startswith("oilfilm ")
