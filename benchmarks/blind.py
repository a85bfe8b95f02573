"""Logs of laboratories that the library has never seen: detection, right reasons, false alarms.

Each seed is a laboratory with its own rig, oils, habits and log formats (tests/helpers/blind_lab),
sound logs and one log with each fault. Printed per seed and in all: faults stopped or named with a
right reason, faults of which nothing was said, sound logs refused, points of sound logs refused,
constants inside their 95 % interval, and the relative rms error of mu with the sound logs.

    python benchmarks/blind.py [seeds]

Takes 3 minutes.
"""

import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "tests" / "helpers"))

from blind_check import Outcome, curated, outcome, settings_of, with_fits  # noqa: E402
from blind_lab.laboratory import build  # noqa: E402


def check_laboratory(seed: int) -> Outcome:
    """One laboratory."""
    with tempfile.TemporaryDirectory() as folder:
        project = Path(folder)
        laboratory = build(project, ROOT / "config", seed)
        settings = settings_of(project)
        verdicts = curated(project, settings)
        result = outcome(laboratory, verdicts)
        with_fits(result, laboratory, verdicts, settings)
    return result


def main(seeds: int = 10) -> None:
    """Print every laboratory and the whole."""
    results = []
    for seed in range(1, seeds + 1):
        result = check_laboratory(seed)
        results.append(result)
        print(f"seed {seed}: {_line([result])}", flush=True)
        for name in ("false_alarms", "silent", "misnamed"):
            for each in getattr(result, name):
                print(f"  {name.replace('_', ' ')}: {each}")
    print(f"all: {_line(results)}")


def _line(results: list[Outcome]) -> str:
    faults = sum(result.faults for result in results)
    inside = [each for result in results for each in result.inside]
    rms = max(each for result in results for each in result.rms.values())
    return (
        f"right {sum(result.right + len(result.named) for result in results) / faults:.1%}, silent "
        f"{sum(len(result.silent) for result in results)} of {faults}; false alarms "
        f"{sum(len(result.false_alarms) for result in results)}, points refused "
        f"{sum(result.refused_points for result in results) / len(results):.3%}; constants inside "
        f"{sum(inside) / len(inside):.1%}; rms of mu {rms:.2%}"
    )


if __name__ == "__main__":
    main(*(int(argument) for argument in sys.argv[1:2]))
