"""Random damages of log files: what disks, cables, editors and people do to them.

`rows_written` counts the rows of a log without any reader of oilfilm.
"""

import re
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.random import Generator

from oilfilm.curation.curate import curate_logs
from oilfilm.curation.rig_kind import RigKind
from oilfilm.curation.traction_rig import TractionRig
from oilfilm.settings.resolved import Settings

Lines = list[bytes]
# Damages a log. Arguments: its bytes, those of another log, random numbers.
Mutator = Callable[[bytes, bytes, Generator], bytes]

_NUMBER = re.compile(rb"-?\d+\.\d+(?:e-?\d+)?")
# Bytes of a sector of a disk.
_SECTOR = 512
# What no cell holds: numbers, markup, beginnings of other formats.
_ABSURD_TEXTS = (
    *(b"nan", b"inf", b"-inf", b"1e999", b"9" * 400, b"-0", b"1,5", b'"', b"=HYPERLINK(1)"),
    *(bytes(50), b"\xff\xfe", b"\xff" * 8, b"\xff\xff\xff\x7f", b"\x00" * 7 + b"\xf0\x7f"),
    *(b"\r", b"\n\n\n", b",,,,,,,,", b"\t" * 30, b"# oil: \n", b"TDSm", b"PAR1", b"X_Value\t"),
    *(b"***End_of_Header***\n", b"Channels\t99999999999999999999\n"),
    b"Step 1 started at 99/99/9999 99:99:99\n",
)
_LINE_ENDS = (b"\r\n", b"\r", b"\n\n", b"\n\r", b"\x0b", b" \n", b",\n", b";\n")
_ENCODINGS = ("utf-16", "utf-16-be", "utf-8-sig", "utf-32", "cp037", "utf-7")
# Changes of a number: other digits, exponents, decimal marks and signs.
_CHANGES_OF_NUMBER: tuple[Callable[[bytes], bytes], ...] = (
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
)


def _any(choices: Sequence[Any], random: Generator) -> Any:
    return choices[int(random.integers(0, len(choices)))]


def _stretch(size: int, most: int, random: Generator) -> tuple[int, int]:
    """Start and end of a random stretch of something.

    Args:
        size: Size of the whole.
        most: The stretch is shorter than this.
        random: Source of chance.
    """
    start = int(random.integers(0, max(size, 1)))
    return start, min(size, start + int(random.integers(1, most)))


def flipped(content: bytes, _: bytes, random: Generator) -> bytes:
    """One to twenty bits turned over."""
    changed = bytearray(content)
    for position in random.integers(0, len(content), random.integers(1, 20)) if content else ():
        changed[position] ^= 1 << int(random.integers(0, 8))
    return bytes(changed)


def cut(content: bytes, _: bytes, random: Generator) -> bytes:
    """The beginning, the end or the middle is lost."""
    start, stop = _stretch(len(content), 4000, random)
    return _any((content[:start], content[stop:], content[:start] + content[stop:]), random)


def absurd(content: bytes, _: bytes, random: Generator) -> bytes:
    """Something absurd between the bytes, over them, or in a cell."""
    start, _stop = _stretch(len(content), 2, random)
    text, kind = _any(_ABSURD_TEXTS, random), int(random.integers(0, 3))
    if kind < 2:
        # over what is there: lengths and offsets of a binary file stay in step
        return content[:start] + text + content[start + kind * len(text) :]
    cell = content.find(b",", start)
    end = content.find(b",", cell + 1)
    return content[: cell + 1] + text + content[end:] if 0 <= cell < end else content


def spliced(content: bytes, donor: bytes, random: Generator) -> bytes:
    """The first part of one log and the last of another."""
    stop = random.integers(0, len(content) + 1)
    start = random.integers(0, len(donor) + 1)
    return content[:stop] + donor[start:]


def numbers(content: bytes, _: bytes, random: Generator) -> bytes:
    """One number of a hundred is written otherwise."""
    return _NUMBER.sub(
        lambda match: (
            match[0] if random.random() > 0.01 else _any(_CHANGES_OF_NUMBER, random)(match[0])
        ),
        content,
    )


def sectors(content: bytes, _: bytes, random: Generator) -> bytes:
    """A sector of a disk read as zeros, or as the one before it."""
    start = _SECTOR * int(random.integers(0, max(len(content) // _SECTOR, 1)))
    before = content[max(start - _SECTOR, 0) : start] if random.random() < 0.5 else bytes(_SECTOR)
    return content[:start] + before + content[start + _SECTOR :]


def encoded(content: bytes, _: bytes, random: Generator) -> bytes:
    """Another encoding, as editors write it."""
    return content.decode("latin-1").encode(_any(_ENCODINGS, random), errors="replace")


def line_ends(content: bytes, _: bytes, random: Generator) -> bytes:
    """Other line ends."""
    return content.replace(b"\n", _any(_LINE_ENDS, random))


def _in_lines(change: Callable[[Lines, Lines, Generator], Lines], name: str) -> Mutator:
    """A damage of some lines in a row, which also gets the lines of another log."""

    def mutator(content: bytes, donor: bytes, random: Generator) -> bytes:
        lines = content.splitlines(keepends=True)
        start, stop = _stretch(len(lines), 40, random)
        some = change(lines[start:stop], donor.splitlines(keepends=True), random)
        return b"".join([*lines[:start], *some, *lines[stop:]])

    mutator.__name__ = name
    return mutator


def _interleaved(some: Lines, others: Lines, random: Generator) -> Lines:
    start, stop = _stretch(len(others), 40, random)
    return [*others[start:stop], *some]


MUTATORS: tuple[Mutator, ...] = (
    *(flipped, cut, absurd, spliced, numbers, sectors, encoded, line_ends),
    # two writers at a time, a transmission that was sent again
    _in_lines(lambda some, _, random: [some[n] for n in random.permutation(len(some))], "shuffled"),
    _in_lines(_interleaved, "interleaved"),
    _in_lines(lambda some, *_: [*some, *some], "repeated"),
)


def attack(content: bytes, donor: bytes, random: Generator) -> bytes:
    """One to three damages; `donor` is another log, from which some take a part."""
    for _ in range(random.integers(1, 4)):
        content = _any(MUTATORS, random)(content, donor, random)
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
    comma_count = named[0].count(b",") if named else 0
    rows = [line for line in lines if line.lstrip()[:1] != b"#" or line.count(b",") == comma_count]
    return len(rows) - 1 if len(named) == 1 else None


def judge_bytes(content: bytes, config: Settings, kind: type[RigKind] = TractionRig) -> str:
    """Read and curate one file of any bytes; the rule or verdict it ends in.

    Asserts what must hold for any bytes. Readers raise where a row is lost.
    """
    verdict = curate_logs([("log", content)], config, kind)
    points, runs, quarantine = verdict.points, verdict.runs, verdict.quarantine
    assert len(points) == runs["plateaus"].sum()
    assert not np.isinf(points.select_dtypes("float")).any(axis=None)
    assert ((runs["verdict"] == "accepted") | (runs["reason"] != "")).all()
    assert (quarantine["reason"] != "").all()
    assert len(runs) + len(quarantine) > 0
    return str(quarantine["rule"].iloc[0] if len(quarantine) else runs["verdict"].iloc[0])
