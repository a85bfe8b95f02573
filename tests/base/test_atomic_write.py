"""A file or folder is there whole or not at all."""

from pathlib import Path

import pytest

from oilfilm.base.atomic_write import atomic_file, atomic_folder


@pytest.mark.parametrize("name", ["law.h", "exports/law.h"])
def test_interrupted_file_or_folder_leaves_the_old_one_alone(tmp_path: Path, name: str) -> None:
    top_name, *inner_names = Path(name).parts
    open_atomically = atomic_folder if inner_names else atomic_file
    with open_atomically(tmp_path / top_name) as temporary_path:
        temporary_path.joinpath(*inner_names).write_text("old")
    with (
        pytest.raises(OSError, match="full"),
        open_atomically(tmp_path / top_name) as temporary_path,
    ):
        temporary_path.joinpath(*inner_names).write_text("ne")
        raise OSError("the disk is full")
    assert [entry.name for entry in tmp_path.iterdir()] == [top_name]
    assert (tmp_path / name).read_text() == "old"


def test_what_a_killed_run_left_beside_is_written_over(tmp_path: Path) -> None:
    leftover_folder = tmp_path / ".exports.part"
    leftover_folder.mkdir()
    (leftover_folder / "stranger.h").write_text("half")
    with atomic_folder(tmp_path / "exports") as temporary_folder:
        (temporary_folder / "a.h").write_text("new")
    assert [path.name for path in tmp_path.rglob("*")] == ["exports", "a.h"]
