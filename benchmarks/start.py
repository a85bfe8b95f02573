"""How long commands take to start, against `import numpy`.

Each is started in turn, many times, in processes of its own; the ratio is of the medians of CPU
time, which other work on the machine hardly moves.

Takes seconds.
"""

import os
import resource
import statistics
import subprocess
import sys

TIMES = 15
BASELINE = "import numpy"
STARTED = {
    BASELINE: ["-c", "import numpy"],
    "oilfilm --help": ["-m", "oilfilm", "--help"],
    "oilfilm check --help": ["-m", "oilfilm", "check", "--help"],
    "import oilfilm": ["-c", "import oilfilm"],
    "oilfilm predict --printed": [
        *("-m", "oilfilm", "predict", "--printed", "--oil", "4102", "--stress", "1.2GPa"),
        *("--speed", "30m/s", "--temperature", "70degC", "--slip", "5%"),
    ],
}


def cpu_seconds(arguments: list[str]) -> float:
    """CPU time of one start of Python."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}
    command = [sys.executable, *arguments]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL, env=environment)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main() -> None:
    """Start each in turn; print medians and ratios."""
    taken: dict[str, list[float]] = {name: [] for name in STARTED}
    for _ in range(TIMES):
        for name, arguments in STARTED.items():
            taken[name].append(cpu_seconds(arguments))
    median = {name: statistics.median(times) for name, times in taken.items()}
    for name, seconds in median.items():
        print(f"{name:<26} {seconds:6.3f} s   {seconds / median[BASELINE]:5.2f} x {BASELINE}")


if __name__ == "__main__":
    main()
