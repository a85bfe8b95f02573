"""Twelve laboratories at their first use: from `oilfilm init` to mu, or to a true reason.

Encodings, languages, workbooks, torque, several runs in a file, slow and fast loggers. Printed are
the questions, the accepted points, the relative error of mu (root mean square) and the share of
points within two standard errors and 1 % of calibration; where nothing is accepted, the reason.

    python benchmarks/first_use.py

Takes one minute.
"""

import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "tests" / "helpers"))

from first_use import outcomes  # noqa: E402


def main() -> None:
    """Print one line per laboratory."""
    with tempfile.TemporaryDirectory() as folder:
        for laboratory, outcome in outcomes(Path(folder)):
            numbers = f"{outcome.questions} questions, {outcome.accepted} points"
            if outcome.accepted:
                numbers += f", error {outcome.error:.2%}, inside {outcome.inside:.0%}"
            print(f"{laboratory.name}: {numbers}", flush=True)
            if not outcome.accepted:
                print("  " + "\n  ".join(outcome.printed.splitlines()[-8:]))


if __name__ == "__main__":
    main()
