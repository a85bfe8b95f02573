"""Runs killed at random moments: each must end, when run again, in the bytes of an undisturbed one.

Run by `make bench NAME=faults`; prints a line per kill and the counts. The whole process group gets
SIGKILL: no program can see it coming. The length of an undisturbed run is cut into as many parts as
there are kills; each kill falls somewhere into a part of its own, so that every stage is struck.

Takes half an hour.
"""

import shutil
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "tests/helpers"))

from campaigns import lay_out_small
from oilfilm.base.randomness import generator
from reproduce import compare, killed, run, succeed, unfinished

TARGET = ("release", "--config", "campaign=small")
SEED = 1


def main(kills: int = 30) -> int:
    """Kill as many runs; 0 where every one came to the same bytes when it was run again."""
    with tempfile.TemporaryDirectory(prefix="oilfilm-faults-") as folder:
        undisturbed, struck = Path(folder, "undisturbed"), Path(folder, "killed")
        lay_out_small(undisturbed)
        length_s = timed(undisturbed, *TARGET)
        print(f"undisturbed: {length_s:.0f} s", flush=True)
        moments = generator(SEED, "kills").uniform(size=kills)
        same_count = 0
        for number, moment in enumerate(moments, start=1):
            seconds = kill(struck, length_s * (number - 1 + moment) / kills)
            unfinished_files = unfinished(struck)
            code, output = run(struck, *TARGET)
            difference = compare(undisturbed, struck) if code == 0 else output[-2000:]
            same_count += not difference
            print(
                f"{number:3d}: killed after {seconds:4.1f} s with {len(unfinished_files):2d} files "
                f"unfinished {unfinished_files[:1]}: {difference or 'the same bytes'}",
                flush=True,
            )
        print(f"{kills} kills: {same_count} runs came to the same bytes")
        return int(same_count < kills)


def kill(project: Path, seconds: float) -> float:
    """A run begun anew and killed after so many seconds; earlier where it would have ended."""
    while True:
        shutil.rmtree(project, ignore_errors=True)
        lay_out_small(project)
        start_s = time.perf_counter()
        if killed(project, seconds, *TARGET):
            return seconds
        # it ended before the kill: the next one comes earlier
        seconds = 0.97 * (time.perf_counter() - start_s)


def timed(project: Path, *arguments: str) -> float:
    """Seconds that snakemake takes."""
    start_s = time.perf_counter()
    succeed(project, *arguments)
    return time.perf_counter() - start_s


if __name__ == "__main__":
    sys.exit(main(*map(int, sys.argv[1:2])))
