"""Damages of other kinds than `mutations`: of lines, numbers, encodings, sectors and packings.

`rows_written` counts the rows of a log without any reader of oilfilm.
"""

import gzip
import re
from collections.abc import Callable

from numpy.random import Generator

_NUMBER = re.compile(rb"-?\d+\.\d+(?:e-?\d+)?")
_SECTOR = 512


def _lines(content: bytes) -> list[bytes]:
    return content.splitlines(keepends=True)


def _some(random: Generator, size: int) -> tuple[int, int]:
    start = int(random.integers(0, max(size, 1)))
    return start, min(size, start + int(random.integers(1, 40)))


def _shuffled(content: bytes, _: bytes, random: Generator) -> bytes:
    """Some lines in another order, as of two writers at a time."""
    lines = _lines(content)
    start, stop = _some(random, len(lines))
    lines[start:stop] = [lines[start + index] for index in random.permutation(stop - start)]
    return b"".join(lines)


def _interleaved(content: bytes, donor: bytes, random: Generator) -> bytes:
    """Lines of another log in between."""
    lines, others = _lines(content), _lines(donor)
    start, stop = _some(random, len(others))
    at = int(random.integers(0, len(lines) + 1))
    return b"".join([*lines[:at], *others[start:stop], *lines[at:]])


def _spliced(content: bytes, donor: bytes, random: Generator) -> bytes:
    """The first part of one log and the last of another."""
    return (
        content[: random.integers(0, len(content) + 1)]
        + donor[random.integers(0, len(donor) + 1) :]
    )


def _numbers(content: bytes, _: bytes, random: Generator) -> bytes:
    """Other digits, exponents, marks and signs in one number of a hundred."""
    forms: list[Callable[[bytes], bytes]] = [
        lambda number: number.replace(b".", b","),
        lambda number: number.replace(b".", b""),
        lambda number: number + b"e400",
        lambda number: b"-" + number,
        lambda number: number[:-1] + b"O",
        lambda number: number[::-1],
        lambda number: b"0x" + number,
        lambda number: number.replace(b".", b"_"),
        lambda number: "\N{ARABIC-INDIC DIGIT THREE}".encode() + number,
        lambda number: b"",
    ]

    def other(match: re.Match[bytes]) -> bytes:
        if random.random() > 0.01:
            return match[0]
        return forms[int(random.integers(0, len(forms)))](match[0])

    return _NUMBER.sub(other, content)


def _sectors(content: bytes, _: bytes, random: Generator) -> bytes:
    """A sector of a disk read as zeros, or as the one before it."""
    sector = int(random.integers(0, max(len(content) // _SECTOR, 1)))
    start, stop = _SECTOR * sector, _SECTOR * (sector + 1)
    before = content[max(start - _SECTOR, 0) : start] if random.random() < 0.5 else bytes(_SECTOR)
    return content[:start] + before + content[stop:]


def _encoded(content: bytes, _: bytes, random: Generator) -> bytes:
    """Another encoding, as editors write it."""
    text = content.decode("latin-1")
    name = ("utf-16", "utf-16-be", "utf-8-sig", "utf-32", "cp037", "utf-7")[random.integers(0, 6)]
    return text.encode(name, errors="replace")


def _line_ends(content: bytes, _: bytes, random: Generator) -> bytes:
    ends = (b"\r\n", b"\r", b"\n\n", b"\n\r", b"\x0b", b" \n", b",\n", b";\n")
    return content.replace(b"\n", ends[int(random.integers(0, len(ends)))])


def _repeated(content: bytes, _: bytes, random: Generator) -> bytes:
    """A transmission that was sent again."""
    lines = _lines(content)
    start, stop = _some(random, len(lines))
    return b"".join([*lines[:stop], *lines[start:stop], *lines[stop:]])


def _columns(content: bytes, _: bytes, random: Generator) -> bytes:
    """Cells of some lines moved by one, one too many or one too few."""
    lines = _lines(content)
    start, stop = _some(random, len(lines))
    for index in range(start, stop):
        cells = lines[index].rstrip(b"\n").split(b",")
        turn = (cells[1:] + cells[:1], cells[1:], [*cells, b"1"])[int(random.integers(0, 3))]
        lines[index] = b",".join(turn) + b"\n"
    return b"".join(lines)


def _packed(content: bytes, _: bytes, random: Generator) -> bytes:
    """A compressed file, cut or with a byte changed."""
    packed = bytearray(gzip.compress(content, mtime=0))
    if random.random() < 0.5:
        return bytes(packed[: random.integers(0, len(packed))])
    packed[random.integers(0, len(packed))] ^= 1 << int(random.integers(0, 8))
    return bytes(packed)


MUTATORS = (
    *(_shuffled, _interleaved, _spliced, _numbers, _sectors, _encoded),
    *(_line_ends, _repeated, _columns, _packed),
)


def attack(content: bytes, donor: bytes, random: Generator) -> bytes:
    """One or two damages; `donor` is another log, from which some take a part."""
    for _ in range(random.integers(1, 3)):
        content = MUTATORS[int(random.integers(0, len(MUTATORS)))](content, donor, random)
    return content


def rows_written(content: bytes) -> int | None:
    """Rows of a plain csv log: lines with any letter or digit but comments and the line of names.

    None where what is a row is open to interpretation: quotes, other encodings, control characters,
    no names, or names twice.
    """
    if b'"' in content or re.search(rb"[^\t\n\r\x20-\x7e]", content):
        return None
    lines = [line for line in re.split(rb"\r\n|\n|\r", content) if re.search(rb"\w", line)]
    rows = [line for line in lines if not line.lstrip().startswith(b"#")]
    return len(rows) - 1 if sum(b"time [s]" in line for line in rows) == 1 else None
