"""Fits whose parts are jobs of their own: no split changes a byte."""

import time
from math import ceil
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from fit_points import P, T, U, make_points, matrix
from oilfilm.errors import OilfilmError
from oilfilm.fits.drawn import Drawn, read_block, read_drawn, write_block
from oilfilm.fits.fit import fit_oil
from oilfilm.fits.fit_parts import Part, compute_part
from oilfilm.fits.law_comparison import compare_laws
from oilfilm.settings.resolved import Settings

OIL = "4102"
REFITS = 20
LAWS = ["deng2026", "tanh", "wang-deng-groups"]


@pytest.fixture(scope="module")
def quick(config: Settings) -> Settings:
    few = {"bootstrap": REFITS, "left_out_groups": 5, "laws": LAWS}
    return config.with_changes({"fit": {"searches": 2, "bootstrap": REFITS}, "compare": few})


@pytest.fixture(scope="module")
def points() -> pd.DataFrame:
    return make_points(OIL, matrix(P[:2], U[::3], T[::2]), noise=2e-4)


def drawn(
    folder: Path, of: str, law: str, points: pd.DataFrame, settings: Settings, size: int
) -> Drawn:
    """All parts of a fit, each written by a job of its own, as `Drawn`."""

    def write(what: str, number: int, ends: np.ndarray | None) -> np.ndarray:
        block = slice(number * size, (number + 1) * size)
        array = compute_part(Part(of, OIL, law, what, block), points, settings, ends)
        write_block(array, folder / law / f"{what}-{number}.npz")
        return array

    ends = write("ends", 0, None)
    whole = {"refits": REFITS, "left-out": 5} if of == "compare" else {"refits": REFITS}
    for what, total in whole.items():
        for number in range(ceil(total / size)):
            write(what, number, ends)
    return read_drawn(sorted((folder / law).glob("*.npz"), reverse=True))[law]


def test_block_has_the_same_bytes_whenever_it_is_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write_block(np.arange(6.0), tmp_path / "now.npz")
    monkeypatch.setattr(time, "time", lambda: 2e9)
    write_block(np.arange(6.0), tmp_path / "later.npz")
    assert (tmp_path / "now.npz").read_bytes() == (tmp_path / "later.npz").read_bytes()


def test_no_flipped_bit_of_a_block_changes_a_number(tmp_path: Path) -> None:
    path, block = tmp_path / "refits-0.npz", np.array([[1.0, np.nan], [2.0, 3.0]])
    write_block(block, path)
    sound = path.read_bytes()
    refused = 0
    for bit in range(8 * len(sound)):
        damaged = bytearray(sound)
        damaged[bit // 8] ^= 1 << bit % 8
        path.write_bytes(damaged)
        try:
            np.testing.assert_array_equal(read_block(path), block)
        except OilfilmError as error:
            assert str(error).startswith(f"{path}: cannot be read (")
            assert str(error).endswith("Delete it and run snakemake again.")
            refused += 1
    assert refused > 8 * (block.nbytes + 64)  # all of the numbers and of what says their shape


def test_block_that_is_cut_off_or_missing_is_refused_in_words(tmp_path: Path) -> None:
    path = tmp_path / "ends-0.npz"
    write_block(np.arange(6.0), path)
    path.write_bytes(path.read_bytes()[:-30])
    for _ in range(2):
        with pytest.raises(OilfilmError, match=r"ends-0\.npz: cannot be read \("):
            read_drawn([path])
        path.unlink(missing_ok=True)


@pytest.mark.parametrize("size", [7, 100])
def test_fit_has_the_same_bytes_however_its_refits_are_spread(
    quick: Settings, points: pd.DataFrame, tmp_path: Path, size: int
) -> None:
    whole = fit_oil(points, OIL, quick.fit, quick.seed)
    parts = drawn(tmp_path, "fit", quick.fit.law, points, quick, size)
    joined = fit_oil(points, OIL, quick.fit, quick.seed, drawn=parts)
    assert len(whole.refits) == REFITS * len(whole.coefficients)
    for name, table in whole.tables.items():
        pd.testing.assert_frame_equal(joined.tables[name], table, check_exact=True)


def test_comparison_has_the_same_bytes_law_by_law_and_fold_by_fold(
    quick: Settings, points: pd.DataFrame, tmp_path: Path
) -> None:
    whole = compare_laws(points, OIL, quick)
    apart = [
        compare_laws(
            points,
            OIL,
            quick,
            [law],
            {law: drawn(tmp_path, "compare", law, points, quick, size=2)},
        )
        for law in LAWS
    ]
    assert list(whole["comparison"]["law"]) == LAWS
    for name, table in whole.items():
        joined = pd.concat([frames[name] for frames in apart], ignore_index=True)
        pd.testing.assert_frame_equal(joined, table, check_exact=True)


def test_part_of_a_fit_that_cannot_be_made_is_empty_and_the_fit_says_why(
    quick: Settings, points: pd.DataFrame, tmp_path: Path
) -> None:
    nothing = points.assign(accepted=False)
    parts = drawn(tmp_path, "compare", "tanh", nothing, quick, size=100)
    assert parts.ends is not None
    assert not len(parts.ends)
    frames = compare_laws(nothing, OIL, quick, ["tanh"], {"tanh": parts})
    assert frames["comparison"]["certificate"].tolist() == ["not fitted: 0 accepted points"]
