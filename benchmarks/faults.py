"""Runs killed at random moments: each must end, when run again, in the bytes of an undisturbed one.

Run by `make bench-faults`; prints a line a kill and the counts. The whole process group gets
SIGKILL: no program can see it coming.
"""

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
    """Kill as many runs; 0 where every one came to the same bytes."""
    with tempfile.TemporaryDirectory(prefix="oilfilm-faults-") as folder:
        whole = Path(folder, "undisturbed")
        lay_out_small(whole)
        begun = time.perf_counter()
        done = run(whole, Surroundings("2"), *TARGET)
        assert done.returncode == 0, done.stdout + done.stderr
        length_s = time.perf_counter() - begun
        print(f"undisturbed: {length_s:.0f} s", flush=True)
        struck = same = 0
        for number, share in enumerate(generator(SEED, "kills").uniform(0, 1, kills), start=1):
            found = one_kill(Path(folder, f"kill-{number}"), whole, share * length_s)
            struck += found[0]
            same += found[1]
        print(f"{kills} runs: {struck} killed, {kills - struck} had ended; {same} the same bytes")
        return int(same < kills)


def one_kill(place: Path, whole: Path, seconds: float) -> tuple[bool, bool]:
    """Whether the kill struck a run, and whether the next run came to the same bytes."""
    lay_out_small(place)
    struck = killed(place, seconds, "--cores", "2", *TARGET)
    begun = unfinished(place)
    done = run(place, Surroundings("2"), *TARGET)
    found = compare(whole, place) if done.returncode == 0 else done.stderr[-2000:]
    print(
        f"{'killed' if struck else 'ended '} at {seconds:5.1f} s, "
        f"{len(begun)} files unfinished {begun[:1]}: {found or 'the same bytes'}",
        flush=True,
    )
    return struck, not found


if __name__ == "__main__":
    sys.exit(main(int(sys.argv[1])))
