"""Damaged logs for the fuzz tests: what disks, cables, editors and people do to files."""

import numpy as np

from oilfilm.curation.curate import check_logs
from oilfilm.curation.rig_kind import RigKind
from oilfilm.curation.traction_rig import TRACTION_RIG
from oilfilm.settings.resolved import Settings

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


def mutate(content: bytes, random: np.random.Generator) -> bytes:
    """One to four random damages of a file."""
    for _ in range(random.integers(1, 5)):
        content = _damage(content, random)
    return content


def _damage(content: bytes, random: np.random.Generator) -> bytes:
    size = max(len(content), 1)
    start, stop = sorted(int(position) for position in random.integers(0, size + 1, 2))
    stop = min(stop, start + int(random.integers(1, 4000)))
    kind = random.integers(0, 8)
    if kind == 0:  # bit flips
        changed = bytearray(content)
        for position in random.integers(0, size, random.integers(1, 20)):
            if position < len(changed):
                changed[position] ^= 1 << int(random.integers(0, 8))
        return bytes(changed)
    if kind == 1:
        return content[:start]
    if kind == 2:
        return content[:start] + content[stop:]
    if kind == 3:
        return content[:stop] + content[start:stop] + content[stop:]
    if kind in {4, 7}:
        absurd = _ABSURD[int(random.integers(0, len(_ABSURD)))]
        # over what stands there: lengths and offsets of a binary file stay in step
        return content[:start] + absurd + content[start + len(absurd) * (kind == 7) :]
    if kind == 5:  # a cell
        absurd = _ABSURD[int(random.integers(0, len(_ABSURD)))]
        cell = content.find(b",", start)
        end = content.find(b",", cell + 1)
        return content[: cell + 1] + absurd + content[end:] if 0 <= cell < end else content
    return content[stop:]


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
