"""How far numbers move from one type of CPU to another: one oil of the demonstration, refitted.

Run by `make bench-cpu`. NumPy, OpenBLAS, Arrow and the C library choose their kernels by what the
CPU can do; told that it can do less, they choose those of another CPU. Prints, for each such CPU,
which tables keep their bytes and how far the numbers of the others move, relative to the largest
of their column, and how far that is in standard errors of the constants.
"""

import os
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "tests/helpers"))

import numpy as np  # noqa: E402
import pandas as pd  # noqa: E402

from oilfilm import tables  # noqa: E402
from oilfilm.table_needs import OF_FIT  # noqa: E402

OIL = "4102"
NO_AVX512 = {
    "NPY_DISABLE_CPU_FEATURES": "X86_V4 AVX512_ICL AVX512_SPR",
    "ARROW_USER_SIMD_LEVEL": "AVX2",
    "GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX512F,-AVX512VL,-AVX512DQ,-AVX512BW",
}
NO_AVX = {
    "NPY_DISABLE_CPU_FEATURES": "X86_V3 X86_V4 AVX512_ICL AVX512_SPR",
    "ARROW_USER_SIMD_LEVEL": "NONE",
    "GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX,-AVX2,-FMA,-FMA4,-AVX512F",
}
CPUS = {
    "this one": {"OPENBLAS_NUM_THREADS": "1"},
    "this one, again": {"OPENBLAS_NUM_THREADS": "1"},
    "this one, two threads of OpenBLAS": {"OPENBLAS_NUM_THREADS": "2"},
    "AVX2, as Zen 2": {"OPENBLAS_NUM_THREADS": "1", "OPENBLAS_CORETYPE": "Zen", **NO_AVX512},
    "AVX2, as Haswell": {"OPENBLAS_NUM_THREADS": "1", "OPENBLAS_CORETYPE": "Haswell", **NO_AVX512},
    "AVX512, as Skylake-X": {"OPENBLAS_NUM_THREADS": "1", "OPENBLAS_CORETYPE": "SkylakeX"},
    "no AVX, as Prescott": {"OPENBLAS_NUM_THREADS": "1", "OPENBLAS_CORETYPE": "Prescott", **NO_AVX},
}


def make(folder: Path) -> None:
    """The tables of one oil: logs simulated, read, curated and fitted in this very process."""
    # imported here: the parent compares, and has a CPU of its own
    from campaigns import carry_through, printed  # noqa: PLC0415
    from law_points import compare_laws  # noqa: PLC0415
    from oilfilm.rig_twin.simulate import simulate_campaign  # noqa: PLC0415
    from oilfilm.settings.resolve import resolve  # noqa: PLC0415

    config = resolve(ROOT / "config", {"campaign": "demo"})
    raw = folder / "raw"
    raw.mkdir()
    for run, content, _ in simulate_campaign(config, printed()):
        if run.name.startswith(OIL):
            (raw / run.name).write_bytes(content)
    campaign = carry_through(config, raw, sorted(path.name for path in raw.iterdir()))
    made = {"points": campaign.curated.points, "runs": campaign.curated.runs}
    compared = compare_laws(campaign.curated.points, OIL, config.compare.laws, config)
    made |= {name: compared.table(name) for name in OF_FIT}
    for name, frame in made.items():
        tables.write(
            frame, name, folder / f"{name}.parquet", {"campaign": "demo", "data": "simulated"}
        )


def main() -> None:
    """Make the tables on every CPU and compare them with those of this one."""
    with tempfile.TemporaryDirectory(prefix="oilfilm-cpu-") as top:
        first = Path(top, "this one")
        for name, environment in CPUS.items():
            folder = Path(top, name)
            folder.mkdir()
            paths = os.pathsep.join([str(ROOT / "workflow"), str(ROOT / "tests/helpers")])
            subprocess.run(
                [sys.executable, __file__, str(folder)],
                env={**os.environ, "PYTHONPATH": paths, **environment},
                check=True,
            )
            if folder != first:
                print(f"\n{name}", flush=True)
                report(first, folder)


def report(first: Path, other: Path) -> None:
    """Print which tables moved, and how far."""
    logs = sorted((first / "raw").iterdir())
    same = sum(log.read_bytes() == (other / "raw" / log.name).read_bytes() for log in logs)
    print(f"  {'raw logs':18} {same} of {len(logs)} the same bytes")
    for path in sorted(first.glob("*.parquet")):
        if path.read_bytes() == (other / path.name).read_bytes():
            print(f"  {path.stem:18} the same bytes")
            continue
        old, new = (tables.read(path.stem, top / path.name) for top in (first, other))
        changes = {name: largest_change(old[name], new[name]) for name in old}
        moved = {name: change for name, change in changes.items() if change > 0}
        worst = max(moved, key=lambda name: moved[name])
        print(f"  {path.stem:18} {len(moved)} columns, at most {moved[worst]:.1e} ({worst})")
    for digits in (12, 9, 6):
        unlike, numbers = unlike_when_rounded(first, other, digits)
        print(f"  rounded to {digits} digits {unlike} of {numbers} numbers still differ")
    old, new = (tables.read("coefficients", top / "coefficients.parquet") for top in (first, other))
    steps = np.abs(new["value"] - old["value"]) / old["standard_error"]
    print(f"  constants move by at most {steps.max():.1e} standard errors")


def largest_change(old: pd.Series, new: pd.Series) -> float:
    """Largest change of a column over its largest value; infinite where rows or text differ.

    A change relative to each single value would be dominated by sums that are nearly zero.
    """
    if old.equals(new):
        return 0.0
    if len(old) != len(new) or old.dtype.kind != "f" or (old.isna() != new.isna()).any():
        return np.inf
    return float((old - new).abs().max() / old.abs().max())


def unlike_when_rounded(first: Path, other: Path, digits: int) -> tuple[int, int]:
    """Numbers of all tables that differ though both are rounded; and how many there are."""
    unlike = numbers = 0
    for path in sorted(first.glob("*.parquet")):
        old, new = (tables.read(path.stem, top / path.name) for top in (first, other))
        for name in old.select_dtypes("float"):
            one, two = (
                [f"{value:.{digits - 1}e}" for value in frame[name]] for frame in (old, new)
            )
            numbers += len(one)
            unlike += sum(a != b for a, b in zip(one, two, strict=True))
    return unlike, numbers


if __name__ == "__main__":
    if len(sys.argv) > 1:
        make(Path(sys.argv[1]))
    else:
        main()
