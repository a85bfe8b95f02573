"""Parts of a fit that other jobs have computed, so that one fit may take many processors."""

import io
import zipfile
import zlib
from collections.abc import Iterable
from dataclasses import dataclass
from functools import reduce
from pathlib import Path

import numpy as np

from oilfilm.atomic_write import atomic_file
from oilfilm.errors import OilfilmError
from oilfilm.traction.law import FloatArray


@dataclass(frozen=True)
class Drawn:
    """Known parts of one law's fit to one oil; the fit itself computes those that are None.

    Attributes:
        ends: End of each search: free internal constants and SSE, shape (searches, free + 1).
        refits: As of `curve_bootstrap`.
        left_out: As of `leave_curves_out`.
    """

    ends: FloatArray | None = None
    refits: FloatArray | None = None
    left_out: FloatArray | None = None


NOTHING = Drawn()
# Errors of NumPy and zipfile at a damaged block, by the place of the damage.
_DAMAGED = (zipfile.BadZipFile, zlib.error, OSError, ValueError, KeyError, EOFError, RuntimeError)


def read_drawn(paths: Iterable[Path]) -> dict[str, Drawn]:
    """What files `<law>/ends-0.npz`, `<law>/refits-<block>.npz`, `<law>/left-out-<block>.npz` hold.

    Returns:
        By law; blocks are put together in their order.

    Raises:
        OilfilmError: A file is missing or damaged.
    """
    blocks: dict[str, dict[str, dict[int, FloatArray]]] = {}
    for path in paths:
        what, _, block = path.stem.rpartition("-")
        of_law = blocks.setdefault(path.parent.name, {})
        of_law.setdefault(what, {})[int(block)] = read_block(path)
    return {law: _together(of_law) for law, of_law in blocks.items()}


def _together(blocks: dict[str, dict[int, FloatArray]]) -> Drawn:
    ordered = {what: [of[block] for block in sorted(of)] for what, of in blocks.items()}
    refits, left_out = ordered.get("refits"), ordered.get("left-out")
    return Drawn(
        ordered["ends"][0],
        np.concatenate(refits) if refits else None,
        reduce(_either, left_out) if left_out else None,
    )


def _either(one: FloatArray, other: FloatArray) -> FloatArray:
    """Errors of two blocks: each has values at the curves that it leaves out, NaN elsewhere."""
    return np.where(np.isnan(one), other, one)


def write_block(block: FloatArray, path: Path) -> None:
    """Write a block completely or not at all, with a checksum: as .npz, which is a zip file."""
    with atomic_file(path) as aside, aside.open("wb") as file:
        np.savez(file, block=block)


def read_block(path: Path) -> FloatArray:
    """The block that `write_block` has written.

    Raises:
        OilfilmError: The file is missing or damaged.
    """
    try:
        with zipfile.ZipFile(path) as archive:
            content = archive.read("block.npy")  # compares the checksum before NumPy reads it
        block: FloatArray = np.load(io.BytesIO(content))
    except _DAMAGED as error:
        raise OilfilmError(
            f"{path}: cannot be read ({error}). Delete it and run snakemake again."
        ) from error
    return block
