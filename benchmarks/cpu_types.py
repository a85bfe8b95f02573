"""How far numbers move from one type of CPU to another: fits to one oil, and a bearing.

Run by `make bench NAME=cpu_types`. NumPy, OpenBLAS, Arrow and the C library choose their kernels by
what the CPU can do; told that it can do less, they choose those of another CPU. Prints, for each
such CPU, which tables keep their bytes and how far the numbers of the others move, relative to the
largest of their column, and how far that is in standard errors of the constants. Then how far the
cage slip of a bearing moves, each operating point solved alone, beside another one, and in one call
of all.

Takes 5 minutes.
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
from oilfilm.tables.table_needs import FIT_TABLES  # noqa: E402
from other_cpus import CPUS, Cpu, environment_of  # noqa: E402

OIL = "4102"
# Light loads, at which the cage skids, and heavy ones; at 5 200 N two motions are near each other.
LOADS_N = np.sort([*np.geomspace(500, 20000, 24), 5200.0])
BEARING_OIL, SPEED_RPM, TEMPERATURE_C = "4010", 12000, 70.0
WAYS = ("alone", "beside 6000 N", "in one call")
THIS, SLIPS = "this one", "cage-slips.npy"


def environments() -> dict[str, tuple[dict[str, str], Cpu | None]]:
    """Variables of the environment by the name of what they stand for, and its type of CPU."""
    one, two = ({"OPENBLAS_NUM_THREADS": number} for number in "12")
    made: dict[str, tuple[dict[str, str], Cpu | None]] = {THIS: (one, None)}
    made |= {f"{THIS}, again": (one, None), f"{THIS}, two threads of OpenBLAS": (two, None)}
    for name, cpu in CPUS.items():
        if reason := cpu.lacking():
            print(f"NOT tried: {name} ({reason})")
        else:
            made[name] = cpu.environment, cpu
    return made


def make(folder: Path) -> None:
    """The tables of one oil: logs simulated, read, curated and fitted in this very process."""
    # imported here: the parent compares, and has a CPU of its own
    from campaigns import carry_through, printed  # noqa: PLC0415
    from law_points import compare_laws  # noqa: PLC0415
    from oilfilm.base.home import HOME  # noqa: PLC0415
    from oilfilm.releases.code_tree import environment  # noqa: PLC0415
    from oilfilm.settings.resolve import resolve  # noqa: PLC0415
    from simulated_lab.simulate import simulate_campaign  # noqa: PLC0415

    config = resolve(ROOT / "config", {"campaign": "demo"})
    raw = folder / "raw"
    raw.mkdir()
    for run, content, _ in simulate_campaign(config, printed()):
        if run.name.startswith(OIL):
            (raw / run.name).write_bytes(content)
    campaign = carry_through(config, raw, sorted(path.name for path in raw.iterdir()))
    made = {"points": campaign.curated.points, "runs": campaign.curated.runs}
    compared = compare_laws(campaign.curated.points, OIL, config.compare.laws, config)
    made |= {name: compared.table(name) for name in FIT_TABLES}
    for name, frame in made.items():
        tables.write(
            frame, name, folder / f"{name}.parquet", {"campaign": "demo", "data": "simulated"}
        )
    np.save(folder / SLIPS, cage_slips())
    print(environment(HOME).model_dump_json())


def cage_slips() -> np.ndarray:
    """Cage slip under each load, shape (ways, loads); NaN where no motion is found."""
    from bearings import RPM, problem, shipped  # noqa: PLC0415
    from oilfilm.bearing.equilibria import friction_equilibrium  # noqa: PLC0415
    from oilfilm.bearing.quasistatic import OperatingPoints  # noqa: PLC0415

    def slips(*loads: float) -> np.ndarray:
        points = OperatingPoints.from_load_and_speed(np.array(loads), SPEED_RPM * RPM)
        asked = problem(shipped("mainshaft-167"), points, BEARING_OIL, TEMPERATURE_C)
        found = friction_equilibrium(asked)
        return np.where(found.solution.converged, found.cage_slip(), np.nan)

    alone = [slips(load)[0] for load in LOADS_N]
    beside = [slips(load, 6000.0)[0] for load in LOADS_N]
    return np.array([alone, beside, slips(*LOADS_N)])


def main() -> None:
    """Make the tables on every CPU and compare them with those of this one."""
    with tempfile.TemporaryDirectory(prefix="oilfilm-cpu-") as top:
        first = Path(top, THIS)
        paths = os.pathsep.join([str(ROOT / "workflow"), str(ROOT / "tests/helpers")])
        for name, (environment, cpu) in environments().items():
            folder = Path(top, name)
            folder.mkdir()
            done = subprocess.run(
                [sys.executable, __file__, str(folder)],
                env={**os.environ, "PYTHONPATH": paths, **environment},
                stdout=subprocess.PIPE,
                text=True,
                check=True,
            )
            made_by = environment_of(done.stdout)
            print(f"\n{name}: {made_by.blas}, NumPy {made_by.cpu or 'baseline'}", flush=True)
            if cpu is not None:
                cpu.refuse_other(made_by)
            if folder != first:
                report(first, folder)
            report_slips(first, folder)


def report_slips(first: Path, other: Path) -> None:
    """Print how far cage slips are from those of this CPU in one call."""
    (*_, expected), found = (np.load(folder / SLIPS) for folder in (first, other))
    for way, slips in zip(WAYS, found, strict=True):
        lost = (np.isnan(slips) != np.isnan(expected)).sum()
        away = np.nanmax(np.abs(slips - expected))
        text = f"cage slip to {away:.1e}, {lost} of {len(slips)} points found in one way only"
        print(f"  {f'bearing, {way}':22} {text}")


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
