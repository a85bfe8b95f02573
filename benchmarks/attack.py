"""Attacks from outside, with counts.

- Logs with damages that `fuzz.py` does not make: each must end in a verdict. Rows of plain csv logs
  are counted by another program than the reader: accepted and quarantined rows must be
  all that were written.
- One bit flipped in each file of a finished run and of its release: found by `sha256sum` with the
  list of the step that wrote it, by `oilfilm verify`, or by nothing.
- Every other attack is a test: folders, limits, two runs at a time, power failures, memory, forged
  and hostile releases, settings, run sheets and logs. Here they are run, and their cases counted.

    python benchmarks/attack.py [logs [seed]]

Takes an hour.
"""

import multiprocessing
import shutil
import subprocess
import sys
import tempfile
import traceback
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "tests/helpers"))

from attacks import attack, rows_written  # noqa: E402
from campaigns import lay_out_small  # noqa: E402
from damages import SOUND  # noqa: E402
from oilfilm.base.digests import files_below  # noqa: E402
from oilfilm.base.errors import OilfilmError  # noqa: E402
from oilfilm.base.randomness import generator  # noqa: E402
from oilfilm.curation.curate import curate_logs  # noqa: E402
from oilfilm.releases.stored_release import StoredRelease  # noqa: E402
from reproduce import succeed  # noqa: E402

NOT_FOUND = "NOT FOUND"
# Damaged logs of one job.
LOGS_PER_SHARE = 100
# Formats of the damaged logs, in turns.
FORMATS = ("csv", "csv", "csv", "tdms", "lvm", "parquet")
# Tests of other attacks, by what they attack.
CASES = {
    "folders, limits, full disks, kills": ["tests/run", "tests/workflow/test_faults.py"],
    "forged and hostile releases and tables": [
        "tests/releases/test_strangers.py",
        "tests/releases/test_releases.py",
    ],
    "hostile settings": ["tests/settings"],
    "hostile logs, folders and run sheets; rows and files counted apart": ["tests/logs"],
    "mistakes at the command line": ["tests/test_command_line.py"],
}


@dataclass
class LogOutcomes:
    """What became of damaged logs.

    Attributes:
        verdicts: How many ended in each rule or verdict.
        rows: How many plain csv logs kept all rows (True) or not (False), by verdict.
        failures: What went wrong.
    """

    verdicts: Counter[str] = field(default_factory=Counter)
    rows: Counter[tuple[str, bool]] = field(default_factory=Counter)
    failures: list[str] = field(default_factory=list)


def outcomes_of_share(job: tuple[int, int]) -> LogOutcomes:
    """One share of the damaged logs."""
    seed, number = job
    random, outcomes = generator(seed, "attack", str(number)), LogOutcomes()
    for index in range(LOGS_PER_SHARE):
        log = SOUND[("traction", "torque")[index % 2]]
        donor = SOUND[("torque", "traction")[int(random.integers(0, 2))]].text()
        name = FORMATS[index // 2 % len(FORMATS)]
        content = attack(log.text() if name == "csv" else log.written(name), donor, random)
        try:
            verdict = curate_logs([("log", content)], log.config, log.kind)
        except Exception:  # any exception at all is what this looks for
            outcomes.failures.append(f"share {number}, log {index}:\n{traceback.format_exc()}")
            continue
        runs, quarantine = verdict.runs, verdict.quarantine
        ended = runs["verdict"].iloc[0] if len(runs) else "not a run"
        outcomes.verdicts[quarantine["rule"].iloc[0] if len(quarantine) else ended] += 1
        written = rows_written(content) if name == "csv" and len(runs) else None
        if written is not None:
            samples = runs["samples"].sum()
            # a line of blanks may be listed as a refused row
            kept = bool(samples <= written <= samples + runs["refused_rows"].sum())
            outcomes.rows[ended, kept] += 1
            if not kept:
                outcomes.failures.append(
                    f"share {number}, log {index}: {written} rows were written"
                )
    return outcomes


def damaged_logs(logs: int, seed: int) -> bool:
    """Print what became of damaged logs; whether all is well."""
    all_outcomes = LogOutcomes()
    jobs = [(seed, number) for number in range(logs // LOGS_PER_SHARE)]
    with multiprocessing.get_context("spawn").Pool(2) as pool:
        for done, part in enumerate(pool.imap_unordered(outcomes_of_share, jobs), start=1):
            all_outcomes.verdicts += part.verdicts
            all_outcomes.rows += part.rows
            all_outcomes.failures += part.failures
            if sys.stderr.isatty():
                print(f"\r{LOGS_PER_SHARE * done} of {logs}", end="", file=sys.stderr)
    ended = sum(all_outcomes.verdicts.values())
    print(f"damaged logs: {ended} of {LOGS_PER_SHARE * len(jobs)} ended in a verdict")
    print(f"  {dict(all_outcomes.verdicts.most_common())}")
    for (verdict, kept), count in sorted(all_outcomes.rows.items()):
        print(f"  {verdict}, rows counted apart: {count} {'all there' if kept else 'ROWS LOST'}")
    print("\n".join(all_outcomes.failures[:5]), flush=True)
    return not all_outcomes.failures


def flip_bit(file: Path, seed: int) -> None:
    """Change one bit of a file in place."""
    content = bytearray(file.read_bytes())
    random = generator(seed, "flip", file.name)
    content[random.integers(0, len(content))] ^= 1 << int(random.integers(0, 8))
    file.chmod(0o644)
    file.write_bytes(content)


def flipped_bits(seed: int) -> bool:
    """Flip a bit in each file of a run and of its release, and print who finds it."""
    with tempfile.TemporaryDirectory(prefix="oilfilm-attack-") as folder:
        project = Path(folder, "project")
        lay_out_small(project)
        succeed(project, "release", "--config", "campaign=small")
        release = (project / "results/releases/small/latest").resolve()
        counts: Counter[str] = Counter()
        for path in files_below(release):
            if not (release / path).stat().st_size:
                continue
            copy = Path(folder, "copy")
            shutil.copytree(release, copy, copy_function=shutil.copyfile)
            flip_bit(copy / path, seed)
            found = "found" if verify_finds_fault(copy) else f"{NOT_FOUND}: {path}"
            counts[f"release, {found}"] += 1
            shutil.rmtree(copy)
        # lists have no list; logs and the twin's own truth are not released
        for path in files_below(project / "results/small"):
            file = project / "results/small" / path
            if path.startswith(("logs/", "made/", "twin/")) or not file.stat().st_size:
                continue
            before = file.read_bytes()
            flip_bit(file, seed)
            found = "found" if lists_find_change(project) else f"{NOT_FOUND}: {path}"
            counts[f"run, {found}"] += 1
            file.write_bytes(before)
    for what, count in sorted(counts.items()):
        print(f"one bit flipped in a file of a {what}: {count}", flush=True)
    return not any(NOT_FOUND in what for what in counts)


def lists_find_change(project: Path) -> bool:
    """Whether `sha256sum` finds a file that is not as its step wrote it."""
    lists = [path.relative_to(project) for path in project.glob("results/small/made/*")]
    command = ["sha256sum", "--check", "--status", *map(str, lists)]
    return subprocess.run(command, cwd=project, check=False).returncode == 1


def verify_finds_fault(release: Path) -> bool:
    """Whether `oilfilm verify` finds fault with a release."""
    try:
        return bool(StoredRelease.open(release).find_changes())
    except OilfilmError:
        return True


def cases() -> bool:
    """Run the tests of attacks and print how many cases each kind has."""
    all_pass = True
    for name, files in CASES.items():
        command = [sys.executable, "-m", "pytest", "-q", "-n", "2", "-m", "", *files]
        done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
        print(f"{name}: {done.stdout.strip().splitlines()[-1]}", flush=True)
        all_pass &= done.returncode == 0
    return all_pass


def main(logs: int = 10_000, seed: int = 1) -> int:
    """All attacks; 0 where everything held."""
    held = [damaged_logs(logs, seed), flipped_bits(seed), cases()]
    print("everything held" if all(held) else "NOT EVERYTHING HELD")
    return int(not all(held))


if __name__ == "__main__":
    sys.exit(main(*map(int, sys.argv[1:3])))
