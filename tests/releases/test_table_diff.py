"""Where two files differ is named: table cell, footer, pixel, metadata, line, byte."""

import struct
import zlib
from pathlib import Path

import numpy as np
import pyarrow as arrow
import pyarrow.parquet as parquet
import pytest
from matplotlib.image import imsave

from oilfilm.releases.table_diff import (
    file_difference,
    folder_difference,
    largest_relative_differences,
)


@pytest.fixture
def two(tmp_path: Path) -> tuple[Path, Path]:
    for name in ("one", "other"):
        (tmp_path / name).mkdir()
    return tmp_path / "one", tmp_path / "other"


def table(path: Path, load: list[float | None], said: str = "{}") -> Path:
    content = arrow.table({"oil": ["a", "b", "c"], "load_n": load})
    parquet.write_table(content.replace_schema_metadata({"oilfilm": said}), path)
    return path


def test_equal_folders_have_no_difference(two: tuple[Path, Path]) -> None:
    for folder in two:
        table(folder / "points.parquet", [1.0, None, 3.0])
    assert folder_difference(*two) == ""


def test_first_cell_of_a_table_is_named(two: tuple[Path, Path]) -> None:
    table(two[0] / "points.parquet", [1.0, None, 3.0])
    table(two[1] / "points.parquet", [1.0, None, np.nextafter(3.0, 4.0)])
    found = folder_difference(*two)
    assert found.startswith("points.parquet: column load_n, row 2: ")
    assert "3.0000000000000004" in found


def test_footer_of_a_table_is_named(two: tuple[Path, Path]) -> None:
    one = table(two[0] / "a.parquet", [1.0, 2.0, 3.0])
    other = table(two[1] / "a.parquet", [1.0, 2.0, 3.0], '{"host": "here"}')
    found = file_difference(one, other)
    assert found.startswith("the same rows; oilfilm in the footer, line 1")


def test_pixel_and_metadata_of_a_picture_are_named(two: tuple[Path, Path]) -> None:
    one, other = (folder / "fig.png" for folder in two)
    picture = np.zeros((4, 5, 3))
    imsave(one, picture, metadata={"Software": None})
    imsave(other, picture, metadata={"Software": None, "Creation Time": "today"})
    assert "metadata" in file_difference(one, other)
    assert "today" in file_difference(one, other)
    picture[2, 3] = 1.0
    imsave(other, picture, metadata={"Software": None})
    assert file_difference(one, other) == "1 pixels, the first at line 2, column 3"


def test_picture_that_cannot_be_opened_is_told(two: tuple[Path, Path]) -> None:
    one, other = (folder / "fig.png" for folder in two)
    imsave(one, np.zeros((4, 5, 3)), metadata={"Software": None})
    content = one.read_bytes()
    pixels = content.index(b"IDAT") + 4
    other.write_bytes(content[:pixels] + bytes(8) + content[pixels + 8 :])
    assert file_difference(one, other).startswith(f"byte {pixels}; cannot be read as PNG (")
    # 100 000 pixels square, in a hundred bytes
    header = b"IHDR" + struct.pack(">IIBBBBB", 100_000, 100_000, 8, 2, 0, 0, 0)
    for path in (one, other):
        drawn = path.read_bytes()
        path.write_bytes(drawn[:12] + header + struct.pack(">I", zlib.crc32(header)) + drawn[33:])
    assert "cannot be read as PNG" in file_difference(one, other)


def test_line_byte_and_missing_file_are_named(two: tuple[Path, Path]) -> None:
    for folder, text in zip(two, ("a\nb\n", "a\nc\n"), strict=True):
        (folder / "summary.txt").write_text(text)
    assert folder_difference(*two) == "summary.txt: line 2: 'b', then 'c'"
    for folder, content in zip(two, (b"\xff\x00", b"\xff\x01"), strict=True):
        (folder / "data.bin").write_bytes(content)
    assert folder_difference(*two).startswith("data.bin: byte 1")
    (two[0] / "data.bin").unlink()
    assert folder_difference(*two).startswith("data.bin: is missing in")


def test_movement_is_relative_to_the_largest_value_of_a_column(two: tuple[Path, Path]) -> None:
    one = table(two[0] / "a.parquet", [1e-9, None, 4.0])
    other = table(two[1] / "a.parquet", [2e-9, None, 4.0])
    assert largest_relative_differences(one, other) == {"load_n": pytest.approx(2.5e-10)}
    other = table(two[1] / "a.parquet", [1e-9, 0.0, 4.0])
    assert largest_relative_differences(one, other) == {"load_n": np.inf}


def test_categories_that_differ_are_named(two: tuple[Path, Path]) -> None:
    for folder, oils in zip(two, (["a", "b"], ["a", "c"]), strict=True):
        named = arrow.array(oils).dictionary_encode()
        parquet.write_table(arrow.table({"oil": named}), folder / "samples.parquet")
    assert folder_difference(*two) == "samples.parquet: column oil, row 1: 'b', then 'c'"


def test_footer_that_is_no_text_is_named(two: tuple[Path, Path]) -> None:
    for folder, said in zip(two, (b"\xff", b"\xfe"), strict=True):
        content = arrow.table({"oil": ["a"]}).replace_schema_metadata({"oilfilm": said})
        parquet.write_table(content, folder / "a.parquet")
    assert "oilfilm in the footer" in folder_difference(*two)


def test_link_that_leads_elsewhere_is_named(two: tuple[Path, Path]) -> None:
    for folder, version in zip(two, ("v1-a", "v1-b"), strict=True):
        (folder / "latest").symlink_to(version)
    assert folder_difference(*two) == "latest: links to v1-a, then to v1-b"
    (two[1] / "latest").unlink()
    assert "latest: is missing" in folder_difference(*two)
