"""A file or folder is there whole or not at all."""

from pathlib import Path

import pytest

from oilfilm.base.atomic_write import atomic_file, atomic_folder


@pytest.mark.parametrize("name", ["law.h", "exports/law.h"])
def test_interrupted_file_or_folder_leaves_the_old_one_alone(tmp_path: Path, name: str) -> None:
    first, *inside = Path(name).parts
    whole = atomic_folder if inside else atomic_file
    with whole(tmp_path / first) as aside:
        aside.joinpath(*inside).write_text("old")
    with pytest.raises(OSError, match="full"), whole(tmp_path / first) as aside:
        aside.joinpath(*inside).write_text("ne")
        raise OSError("the disk is full")
    assert [each.name for each in tmp_path.iterdir()] == [first]
    assert (tmp_path / name).read_text() == "old"


def test_what_a_killed_run_left_beside_is_written_over(tmp_path: Path) -> None:
    left = tmp_path / ".exports.part"
    left.mkdir()
    (left / "stranger.h").write_text("half")
    with atomic_folder(tmp_path / "exports") as aside:
        (aside / "a.h").write_text("new")
    assert [each.name for each in tmp_path.rglob("*")] == ["exports", "a.h"]
