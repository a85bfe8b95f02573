"""Random damages of log files: what disks, cables, editors and people do to them.

`rows_written` counts the rows of a log without any reader of oilfilm.
"""

import gzip
import re
from collections.abc import Callable

import numpy as np
from numpy.random import Generator

from oilfilm.curation.curate import check_logs
from oilfilm.curation.rig_kind import RigKind
from oilfilm.curation.traction_rig import TRACTION_RIG
from oilfilm.settings.resolved import Settings

_NUMBER = re.compile(rb"-?\d+\.\d+(?:e-?\d+)?")
_SECTOR = 512
_ABSURD = [
    b"\x00" * 50,
    b"nan",
    b"inf",
    b"-inf",
    b"1e999",
    b"9" * 400,
    b"\xff\xfe",
    b"\r",
    b"\n\n\n",
    b",,,,,,,,",
    b"\t" * 30,
    b'"',
    b"# oil: \n",
    b"Step 1 started at 99/99/9999 99:99:99\n",
    b"=HYPERLINK(1)",
    b"-0",
    b"1,5",
    b"\xff" * 8,
    b"\xff\xff\xff\x7f",
    b"\x00" * 7 + b"\xf0\x7f",
    b"TDSm",
    b"PAR1",
    b"***End_of_Header***\n",
    b"Channels\t99999999999999999999\n",
    b"X_Value\t",
]


def _lines(content: bytes) -> list[bytes]:
    return content.splitlines(keepends=True)


def _some(random: Generator, size: int) -> tuple[int, int]:
    start = int(random.integers(0, max(size, 1)))
    return start, min(size, start + int(random.integers(1, 40)))


def _stretch(content: bytes, random: Generator) -> tuple[int, int]:
    """A stretch of up to 4000 bytes."""
    start, stop = sorted(int(position) for position in random.integers(0, len(content) + 1, 2))
    return start, min(stop, start + int(random.integers(1, 4000)))


def _flipped(content: bytes, _: bytes, random: Generator) -> bytes:
    """One to twenty bits turned over."""
    changed = bytearray(content)
    for position in random.integers(0, len(content), random.integers(1, 20)) if content else ():
        changed[position] ^= 1 << int(random.integers(0, 8))
    return bytes(changed)


def _cut(content: bytes, _: bytes, random: Generator) -> bytes:
    """The beginning, the end or the middle is lost."""
    start, stop = _stretch(content, random)
    kept = (content[:start], content[stop:], content[:start] + content[stop:])
    return kept[int(random.integers(0, len(kept)))]


def _absurd(content: bytes, _: bytes, random: Generator) -> bytes:
    """Something absurd between the bytes, over them, or in a cell."""
    start, _stop = _stretch(content, random)
    text, kind = _ABSURD[int(random.integers(0, len(_ABSURD)))], int(random.integers(0, 3))
    if kind < 2:
        # over what is there: lengths and offsets of a binary file stay in step
        return content[:start] + text + content[start + kind * len(text) :]
    cell = content.find(b",", start)
    end = content.find(b",", cell + 1)
    return content[: cell + 1] + text + content[end:] if 0 <= cell < end else content


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


def _errors(content: bytes, _: bytes, random: Generator) -> bytes:
    """Errors of a spreadsheet in the first cell of some lines below the names."""
    lines = _lines(content)
    start, stop = _some(random, len(lines))
    for index in range(max(start, len(lines) // 9), stop):
        error = (b"#N/A", b"#DIV/0!", b"#VALUE!", b"#REF!", b"N/A")[int(random.integers(0, 5))]
        lines[index] = error + b"," + lines[index].partition(b",")[2]
    return b"".join(lines)


def _packed(content: bytes, _: bytes, random: Generator) -> bytes:
    """A compressed file, cut or with a byte changed."""
    packed = bytearray(gzip.compress(content, mtime=0))
    if random.random() < 0.5:
        return bytes(packed[: random.integers(0, len(packed))])
    packed[random.integers(0, len(packed))] ^= 1 << int(random.integers(0, 8))
    return bytes(packed)


MUTATORS = (
    *(_flipped, _cut, _absurd),
    *(_shuffled, _interleaved, _spliced, _numbers, _sectors, _encoded),
    *(_line_ends, _repeated, _columns, _errors, _packed),
)


def attack(content: bytes, donor: bytes, random: Generator) -> bytes:
    """One to three damages; `donor` is another log, from which some take a part."""
    for _ in range(random.integers(1, 4)):
        content = MUTATORS[int(random.integers(0, len(MUTATORS)))](content, donor, random)
    return content


def rows_written(content: bytes) -> int | None:
    """Rows of a plain csv log: lines with any letter or digit but comments and the line of names.

    A comment has fewer commas than the names.

    None where what is a row is open to interpretation: quotes, other encodings, control characters,
    no names, or names twice.
    """
    if b'"' in content or re.search(rb"[^\t\n\r\x20-\x7e]", content):
        return None
    lines = [line for line in re.split(rb"\r\n|\n|\r", content) if re.search(rb"\w", line)]
    named = [line for line in lines if b"time [s]" in line and not line.startswith(b"#")]
    marks = named[0].count(b",") if named else 0
    rows = [line for line in lines if line.lstrip()[:1] != b"#" or line.count(b",") == marks]
    return len(rows) - 1 if len(named) == 1 else None


def carry(content: bytes, config: Settings, kind: RigKind = TRACTION_RIG) -> str:
    """Read and curate one damaged file; the rule or verdict it ends in.

    Asserts what must hold for any bytes. Readers raise where a row is lost.
    """
    verdict = check_logs([("log", content)], config, kind)
    points, runs, quarantine = verdict.points, verdict.runs, verdict.quarantine
    assert len(points) == runs["plateaus"].sum()
    assert not np.isinf(points.select_dtypes("float")).any(axis=None)
    assert ((runs["verdict"] == "accepted") | (runs["reason"] != "")).all()
    assert (quarantine["reason"] != "").all()
    assert len(runs) + len(quarantine) > 0
    return str(quarantine["rule"].iloc[0] if len(quarantine) else runs["verdict"].iloc[0])
