"""Runs killed at random moments: each must end, when run again, in the bytes of an undisturbed one.

Run by `make bench-faults`; prints a line a kill and the counts. The whole process group gets
SIGKILL: no program can see it coming. A killed run is copied as it lies there; the copy is run to
its end and compared, the killed one goes on to be killed again, until it ends and another begins.
"""

import shutil
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

from campaigns import lay_out_small
from oilfilm.randomness import generator
from reproduce import Surroundings, compare, killed, run, unfinished

TARGET = ("release", "--config", "campaign=small")
SEED = 1


def main(kills: int) -> int:
    """Kill as often; 0 where every run came to the same bytes."""
    with tempfile.TemporaryDirectory(prefix="oilfilm-faults-") as folder:
        whole, place, copy = (Path(folder, name) for name in ("undisturbed", "killed", "copy"))
        lay_out_small(whole)
        length_s = timed(whole, *TARGET)
        start_s = timed(whole, "--dry-run", *TARGET)
        print(f"undisturbed: {length_s:.0f} s, of which {start_s:.0f} s to begin", flush=True)
        lay_out_small(place)
        struck = same = 0
        # a run gets so far each time that it ends after about as many kills
        longest_s = 2 * (start_s + length_s / kills)
        moments = generator(SEED, "kills")
        while struck < kills:
            seconds = moments.uniform(0, longest_s)
            if not killed(place, seconds, "--cores", "2", *TARGET):
                shutil.rmtree(place)
                lay_out_small(place)
                continue
            struck += 1
            begun = unfinished(place)
            shutil.copytree(place, copy, symlinks=True)
            done = run(copy, Surroundings("2"), *TARGET)
            found = compare(whole, copy) if done.returncode == 0 else done.stderr[-2000:]
            same += not found
            print(
                f"{struck:3d}: killed after {seconds:4.1f} s with {len(begun):2d} files unfinished "
                f"{begun[:1]}: {found or 'the same bytes'}",
                flush=True,
            )
            shutil.rmtree(copy)
        print(f"{struck} kills: {same} runs came to the same bytes")
        return int(same < kills)


def timed(place: Path, *arguments: str) -> float:
    """Seconds that snakemake takes."""
    begun = time.perf_counter()
    done = run(place, Surroundings("2"), *arguments)
    assert done.returncode == 0, done.stdout + done.stderr
    return time.perf_counter() - begun


if __name__ == "__main__":
    sys.exit(main(int(sys.argv[1])))
