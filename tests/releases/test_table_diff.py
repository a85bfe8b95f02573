"""Where two files differ is named: table cell, footer, line, byte."""

from pathlib import Path

import numpy as np
import pyarrow as arrow
import pyarrow.parquet as parquet
import pytest

from oilfilm.releases.table_diff import file_difference


@pytest.fixture
def two(tmp_path: Path) -> tuple[Path, Path]:
    return tmp_path / "before", tmp_path / "after"


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


def test_footer_of_a_table_is_named(two: tuple[Path, Path]) -> None:
    for path, footer in zip(two, (b"\xff", b"\xfe"), strict=True):
        write_table(path, [1.0, 2.0, 3.0], footer)
    assert file_difference(*two).startswith("the same rows; oilfilm in the footer, line 1")
    two[1].write_bytes(two[0].read_bytes()[:-20])
    assert file_difference(*two).startswith("cannot be read (")


@pytest.mark.parametrize(
    ("before", "after", "difference"),
    [
        (b"a\nb\n", b"a\nc\n", "line 2: b'b', then b'c'"),
        (b"a\n", b"a\nb\n", "2 bytes, then 4"),
    ],
)
def test_line_is_named(
    two: tuple[Path, Path], before: bytes, after: bytes, difference: str
) -> None:
    two[0].write_bytes(before)
    two[1].write_bytes(after)
    assert file_difference(*two) == difference


def test_link_that_leads_elsewhere_is_named(two: tuple[Path, Path]) -> None:
    for path, version in zip(two, ("v1-a", "v1-b"), strict=True):
        path.symlink_to(version)
    assert file_difference(*two) == "links to v1-a, then to v1-b"
