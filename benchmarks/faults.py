"""Runs killed at random moments: each must end, when run again, in the bytes of an undisturbed one.

Run by `make bench NAME=faults`; prints a line a kill and the counts. The whole process group gets
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
        whole, place = Path(folder, "undisturbed"), Path(folder, "killed")
        lay_out_small(whole)
        length_s = timed(whole, *TARGET)
        print(f"undisturbed: {length_s:.0f} s", flush=True)
        moments = generator(SEED, "kills").uniform(size=kills)
        same = 0
        for number, moment in enumerate(moments, start=1):
            seconds = kill(place, length_s * (number - 1 + moment) / kills)
            begun = unfinished(place)
            code, output = run(place, *TARGET)
            found = compare(whole, place) if code == 0 else output[-2000:]
            same += not found
            print(
                f"{number:3d}: killed after {seconds:4.1f} s with {len(begun):2d} files unfinished "
                f"{begun[:1]}: {found or 'the same bytes'}",
                flush=True,
            )
        print(f"{kills} kills: {same} runs came to the same bytes")
        return int(same < kills)


def kill(place: Path, seconds: float) -> float:
    """A run begun anew and killed after so many seconds; earlier where it would have ended."""
    while True:
        shutil.rmtree(place, ignore_errors=True)
        lay_out_small(place)
        begun = time.perf_counter()
        if killed(place, seconds, *TARGET):
            return seconds
        seconds = 0.97 * (time.perf_counter() - begun)


def timed(place: Path, *arguments: str) -> float:
    """Seconds that snakemake takes."""
    begun = time.perf_counter()
    succeed(place, *arguments)
    return time.perf_counter() - begun


if __name__ == "__main__":
    sys.exit(main(*map(int, sys.argv[1:2])))
