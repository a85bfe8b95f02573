"""Many damaged logs: each must end in a verdict, within 5 s and 512 MiB, with no row lost.

Run by `make bench NAME=fuzz`; prints counts, the slowest file and the peak memory.

Takes half an hour.
"""

import multiprocessing
import resource
import sys
import time
import traceback
from collections import Counter
from pathlib import Path

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "tests/helpers"))

from attacks import attack, judge_bytes  # noqa: E402  (the tests' own helpers)
from campaigns import REAL_PCS, printed  # noqa: E402
from damages import SOUND  # noqa: E402
from oilfilm.base.randomness import generator  # noqa: E402
from oilfilm.settings.resolve import resolve  # noqa: E402
from simulated_lab.simulate import simulate_campaign  # noqa: E402

SLOWEST_S = 5.0
LARGEST_MIB = 512


def sound_logs() -> list[tuple[bytes, dict]]:
    """Good files of each format with the campaign they belong to."""
    demo = resolve(ROOT / "config", {"campaign": "demo"})
    log = next(content for run, content, _ in simulate_campaign(demo, printed()) if not run.defect)
    good = [(log, demo), (b"".join(log.splitlines(True)[:600]), demo)]
    good += [(SOUND["traction"].written(name), demo) for name in ("tdms", "lvm", "parquet")]
    if REAL_PCS.is_dir():
        etm = resolve(ROOT / "config", {"campaign": "etm-slim"})
        lines = (REAL_PCS / "ETM_slim_mapper.txt").read_bytes().splitlines(True)
        good += [(b"".join(lines[:220]), etm), ((REAL_PCS / "demo_12.txt").read_bytes(), etm)]
    else:
        print("the real PCS logs are not here: no pcs")
    return good


def judge_share(job: tuple[int, int]) -> tuple[Counter, list[str], float, int]:
    """Verdicts, failures, slowest time in s and peak memory in MiB of one share."""
    number, count = job
    good, random = sound_logs(), generator(number, "bench fuzz")
    verdicts: Counter = Counter()
    failures, slowest = [], 0.0
    for index in range(count):
        content, config = good[index % len(good)]
        start = time.perf_counter()
        try:
            verdicts[judge_bytes(attack(content, good[0][0], random), config)] += 1
        except Exception:  # any exception at all is what this looks for
            failures.append(f"share {number}, file {index}:\n{traceback.format_exc()}")
        slowest = max(slowest, time.perf_counter() - start)
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return verdicts, failures, slowest, peak // (1 << 20 if sys.platform == "darwin" else 1 << 10)


def main(total: int) -> int:
    """Spread the files over two processes and report."""
    jobs = [(number, 100) for number in range(total // 100)]
    verdicts: Counter = Counter()
    failures: list[str] = []
    slowest, peak = 0.0, 0
    with multiprocessing.get_context("spawn").Pool(2) as pool:
        for done, share in enumerate(pool.imap_unordered(judge_share, jobs), start=1):
            verdicts_of_share, failures_of_share, slowest_of_share, peak_of_share = share
            verdicts += verdicts_of_share
            failures += failures_of_share
            slowest, peak = max(slowest, slowest_of_share), max(peak, peak_of_share)
            if sys.stderr.isatty():
                print(f"\r{100 * done} of {total}", end="", file=sys.stderr)
    print(f"{sum(verdicts.values())} of {total} ended in a verdict: {dict(verdicts.most_common())}")
    print(f"slowest {slowest:.2f} s (allowed {SLOWEST_S:g}), peak {peak} MiB ({LARGEST_MIB})")
    print("\n".join(failures[:5]))
    return int(bool(failures) or slowest > SLOWEST_S or peak > LARGEST_MIB)


if __name__ == "__main__":
    sys.exit(main(int(sys.argv[1]) if len(sys.argv) > 1 else 20_000))
