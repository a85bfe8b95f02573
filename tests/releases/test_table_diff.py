"""Where two files differ is named: table cell, footer, pixel, metadata, line, byte."""

import struct
import zlib
from pathlib import Path

import numpy as np
import pyarrow as arrow
import pyarrow.parquet as parquet
import pytest
from matplotlib.image import imsave

from oilfilm.releases.table_diff import file_difference


@pytest.fixture
def two(tmp_path: Path) -> tuple[Path, Path]:
    # a file is known by its first bytes, but Matplotlib writes and reads pictures by the ending
    return tmp_path / "before.png", tmp_path / "after.png"


def write_table(path: Path, load: list[float | None], footer: str | bytes = "{}") -> None:
    content = arrow.table({"oil": ["a", "b", "c"], "load_n": load})
    parquet.write_table(content.replace_schema_metadata({"oilfilm": footer}), path)


def test_first_cell_of_a_table_is_named(two: tuple[Path, Path]) -> None:
    write_table(two[0], [1.0, None, 3.0])
    write_table(two[1], [1.0, None, 3.0])
    assert file_difference(*two) == ""
    write_table(two[1], [1.0, None, np.nextafter(3.0, 4.0)])
    difference = file_difference(*two)
    assert difference.startswith("column load_n, row 2: ")
    assert "3.0000000000000004" in difference


@pytest.mark.parametrize("footers", [("{}", '{"host": "here"}'), (b"\xff", b"\xfe")])
def test_footer_of_a_table_is_named(
    two: tuple[Path, Path], footers: tuple[str | bytes, str | bytes]
) -> None:
    for path, footer in zip(two, footers, strict=True):
        write_table(path, [1.0, 2.0, 3.0], footer)
    assert file_difference(*two).startswith("the same rows; oilfilm in the footer, line 1")


def test_pixel_and_metadata_of_a_picture_are_named(two: tuple[Path, Path]) -> None:
    before, after = two
    picture = np.zeros((4, 5, 3))
    imsave(before, picture, metadata={"Software": None})
    imsave(after, picture, metadata={"Software": None, "Creation Time": "today"})
    assert "metadata" in file_difference(before, after)
    assert "today" in file_difference(before, after)
    picture[2, 3] = 1.0
    imsave(after, picture, metadata={"Software": None})
    assert file_difference(before, after) == "1 pixels, the first at line 2, column 3"


def test_picture_that_cannot_be_opened_is_told(two: tuple[Path, Path]) -> None:
    before, after = two
    imsave(before, np.zeros((4, 5, 3)), metadata={"Software": None})
    content = before.read_bytes()
    pixels = content.index(b"IDAT") + 4
    after.write_bytes(content[:pixels] + bytes(8) + content[pixels + 8 :])
    assert file_difference(before, after).startswith("cannot be read (")
    # 100 000 pixels square, in a hundred bytes
    header = b"IHDR" + struct.pack(">IIBBBBB", 100_000, 100_000, 8, 2, 0, 0, 0)
    for path in two:
        png = path.read_bytes()
        path.write_bytes(png[:12] + header + struct.pack(">I", zlib.crc32(header)) + png[33:])
    assert "cannot be read" in file_difference(before, after)


@pytest.mark.parametrize(
    ("before", "after", "difference"),
    [
        (b"a\nb\n", b"a\nc\n", "line 2: 'b', then 'c'"),
        (b"a\n", b"a\nb\n", "2 letters, then 4"),
        (b"\xff\x00", b"\xff\x01", "byte 1"),
    ],
)
def test_line_and_byte_are_named(
    two: tuple[Path, Path], before: bytes, after: bytes, difference: str
) -> None:
    two[0].write_bytes(before)
    two[1].write_bytes(after)
    assert file_difference(*two) == difference


def test_link_that_leads_elsewhere_is_named(two: tuple[Path, Path]) -> None:
    for path, version in zip(two, ("v1-a", "v1-b"), strict=True):
        path.symlink_to(version)
    assert file_difference(*two) == "links to v1-a, then to v1-b"
