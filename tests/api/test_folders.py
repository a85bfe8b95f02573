"""Folders of settings and of a project, where a call names one or none."""

from pathlib import Path

import pytest

from oilfilm.api.folders import project_folder


@pytest.mark.parametrize("option", [".", "../config", "below/..", "{project}/config"])
def test_project_is_above_its_configuration_folder_however_that_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, option: str
) -> None:
    (tmp_path / "config/below").mkdir(parents=True)
    monkeypatch.chdir(tmp_path / "config")
    assert project_folder(Path(option.format(project=tmp_path))).samefile(tmp_path)


def test_configuration_above_the_current_folder_has_its_project_above_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "config/rigs").mkdir(parents=True)
    monkeypatch.chdir(tmp_path / "config/rigs")
    assert project_folder(Path("..")) == tmp_path


def test_relative_path_stays_relative() -> None:
    # messages and results must not show where a project lies
    assert project_folder(Path("config")) == Path()


def test_linked_configuration_belongs_to_the_project_that_has_the_link(tmp_path: Path) -> None:
    (tmp_path / "shared").mkdir()
    project = tmp_path / "project"
    project.mkdir()
    (project / "config").symlink_to(tmp_path / "shared")
    assert project_folder(project / "config") == project
