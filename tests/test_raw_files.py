"""Which files count as logs, and that no path leads out of the raw folder."""

from pathlib import Path

import pytest

from oilfilm.errors import OilfilmError
from oilfilm.raw_files import raw_files, shard_of


def test_logs_are_found_in_subfolders_and_notes_are_not_logs(tmp_path: Path) -> None:
    (tmp_path / "june").mkdir()
    for name in ("b.csv", "june/a.csv", "README.md", ".hidden.csv"):
        (tmp_path / name).write_text("x")
    assert raw_files(tmp_path) == ["b.csv", "june/a.csv"]


def test_missing_and_empty_folders_are_told(tmp_path: Path) -> None:
    with pytest.raises(OilfilmError, match="no such folder"):
        raw_files(tmp_path / "june")
    with pytest.raises(OilfilmError, match="holds no logs"):
        raw_files(tmp_path)


def test_link_out_of_the_folder_is_refused(tmp_path: Path) -> None:
    (tmp_path / "secret.csv").write_text("x")
    folder = tmp_path / "raw"
    folder.mkdir()
    (folder / "log.csv").symlink_to(tmp_path / "secret.csv")
    with pytest.raises(OilfilmError, match="leads out of"):
        raw_files(folder)


def test_share_of_a_log_does_not_depend_on_the_other_logs() -> None:
    # CRC-32 of "123456789" is 0xCBF43926, the check value of the standard
    assert shard_of("123456789", 1000) == 0xCBF43926 % 1000
