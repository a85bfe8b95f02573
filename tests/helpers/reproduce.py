"""A campaign run twice in surroundings that must not matter, and compared byte by byte.

`make verify` does it for the demonstration campaign: the second run has another folder, date,
number of cores, host name, user, network (none), locale, time zone, order of hashes and umask.
`make verify-python` does it with another version of Python, without a release, which names it.
"""

import base64
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from campaigns import ROOT, lay_out
from oilfilm.settings.resolve import resolve

GUARD = ROOT / "tests/guard"


@dataclass(frozen=True)
class Surroundings:
    """What a run finds around it.

    Attributes:
        cores: Number of cores.
        environment: Variables of the environment.
        before: Program and arguments that start the command.
        python: The Python that runs it.
        lacking: What could not be made different, in words.
    """

    cores: str = "1"
    environment: Mapping[str, str] = field(default_factory=dict)
    before: Sequence[str] = ()
    python: str = sys.executable
    lacking: Sequence[str] = ()


TWO_CORES = Surroundings("2")
USUAL = Surroundings(
    environment={"PYTHONHASHSEED": "1", "TZ": "UTC", "LC_ALL": "C.UTF-8", "USER": "one"}
)


def coverage_environment() -> dict[str, str]:
    """Environment of a run whose jobs count for coverage."""
    return {name: value for name, value in os.environ.items() if name.startswith("COVERAGE_")}


def unusual(folder: Path) -> Surroundings:
    """Everything different that can be made different on this machine."""
    environment = {
        **{"PYTHONHASHSEED": "2", "TZ": "Pacific/Kiritimati"},
        "PYTHONOPTIMIZE": "1",  # no `assert` is carried out
        # text is ASCII unless a program says otherwise
        **{"LC_ALL": "C", "PYTHONCOERCECLOCALE": "0", "PYTHONUTF8": "0"},
        **{"USER": "other", "LOGNAME": "other", "HOME": str(folder)},
    }
    clock, lacking = fake_clock("+400d"), []
    if not clock:
        lacking.append("another date (libfaketime is not installed)")
    before = ["unshare", "--user", "--map-user=65534", "--keep-caps", "--uts", "--net"]
    before += ["sh", "-c", 'hostname elsewhere && exec "$@"', "sh"]
    if not succeeds([*before, "true"]):
        before = []
        lacking.append("another host name and user id, and no network (unshare is not allowed)")
    before += ["sh", "-c", 'umask 077 && exec "$@"', "sh"]
    return Surroundings("2", {**environment, **clock}, before, lacking=lacking)


def succeeds(command: Sequence[str]) -> bool:
    """Whether a command can be run and ends without an error."""
    try:
        return subprocess.run(command, capture_output=True, check=False).returncode == 0
    except OSError:
        return False


def fake_clock(offset: str) -> dict[str, str]:
    """Environment in which the clock is off; empty where libfaketime is not installed."""
    # with a false monotonic clock Python's threads wait for ever
    true = dict.fromkeys(("FAKETIME_DONT_FAKE_MONOTONIC", "DONT_FAKE_MONOTONIC"), "1")
    for library in Path("/usr/lib").glob("*/faketime/libfaketimeMT.so.1"):
        return {"LD_PRELOAD": str(library), "FAKETIME": offset, **true}
    return {}


def command(
    project: Path, *arguments: str, python: str = sys.executable
) -> tuple[list[str], dict[str, str]]:
    """Snakemake in a project's folder, with the project's own library: command, environment.

    Coverage is not measured: its tracer nearly doubles the time of a job. Bytecode is kept: without
    it each job would compile the library anew.
    """
    left_out = {*coverage_environment(), "PYTHONDONTWRITEBYTECODE"}
    environment = {
        **{name: value for name, value in os.environ.items() if name not in left_out},
        "PYTHONPATH": os.pathsep.join([str(project / "workflow"), str(GUARD)]),
        "OILFILM_GUARD": str(project / "guard.log"),
    }
    return [python, "-m", "snakemake", *arguments], environment


def start(
    project: Path,
    *arguments: str,
    around: Surroundings = TWO_CORES,
    stdout: int = subprocess.PIPE,
    new_session: bool = False,
) -> subprocess.Popen[str]:
    """Start snakemake in a project's folder; all that it prints goes to `stdout`."""
    snakemake, environment = command(
        project, "--cores", around.cores, *arguments, python=around.python
    )
    return subprocess.Popen(
        [*around.before, *snakemake],
        cwd=project,
        env={**environment, **around.environment},
        stdout=stdout,
        stderr=subprocess.STDOUT,
        text=True,
        errors="replace",
        start_new_session=new_session,
    )


def run(project: Path, *arguments: str, around: Surroundings = TWO_CORES) -> tuple[int, str]:
    """Run snakemake in a project's folder: its exit code, and what it prints."""
    with start(project, *arguments, around=around) as process:
        output, _ = process.communicate()
    return process.returncode, output


def succeed(project: Path, *arguments: str, around: Surroundings = TWO_CORES) -> str:
    """Run snakemake, which must succeed; what it prints."""
    code, output = run(project, *arguments, around=around)
    assert (code, "Traceback" in output) == (0, False), output
    return output


def fail(project: Path, *arguments: str, around: Surroundings = TWO_CORES) -> str:
    """Run snakemake, which must end with a sentence about a mistake; what it prints."""
    code, output = run(project, *arguments, around=around)
    assert (code != 0, "Traceback" in output) == (True, False), output
    return output


def announced_jobs(output: str) -> dict[str, int]:
    """How many jobs of each rule a run announces."""
    table = output.partition("Job stats")[2].partition("total")[0]
    rows = re.findall(r"(?m)^ *(\w[\w ]*?) +(\d+) *$", table)
    # the logger writes a blank for an underscore
    return {rule.replace(" ", "_"): int(count) for rule, count in rows}


def killed(
    project: Path, seconds: float, *arguments: str, files: int = 0, around: Surroundings = TWO_CORES
) -> bool:
    """Run snakemake and kill it and all its jobs; false where it had ended by itself.

    It is killed so many seconds after as many files are made as are asked for.
    """
    quiet = subprocess.DEVNULL
    with start(project, *arguments, around=around, stdout=quiet, new_session=True) as process:
        made = project / ".snakemake/metadata"
        while process.poll() is None and len([*made.glob("*")]) < files:
            time.sleep(0.05)
        try:
            process.wait(seconds)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            return True
    return False


def unfinished(project: Path) -> list[str]:
    """What Snakemake had begun to make, and not finished, when it was killed."""
    records = (project / ".snakemake/incomplete").glob("*")
    return sorted(base64.urlsafe_b64decode(record.name).decode() for record in records)


def files_made(project: Path) -> set[str]:
    """Files that a run has made, relative to the project."""
    return {
        path.relative_to(project).as_posix()
        for folder in ("results", "data/raw")
        for path in (project / folder).rglob("*")
        # Snakemake's log has dates
        if (path.is_symlink() or path.is_file()) and path.name != "snakemake.log"
    }


def stamps(project: Path) -> set[tuple[str, int, int]]:
    """Path, size and date of every file and folder of a project."""
    paths = ((path, path.lstat()) for path in [project, *project.rglob("*")])
    return {(path.as_posix(), stamp.st_size, stamp.st_mtime_ns) for path, stamp in paths}


def changed_files(before: set[tuple[str, int, int]], after: set[tuple[str, int, int]]) -> set[str]:
    """Paths that differ between two stamps, without bytecode and Snakemake's notes."""
    of_runs = re.compile(r"/(\.snakemake/(log|iocache)|__pycache__)")
    return {path for path, *_ in before ^ after if not of_runs.search(path)}


def content(path: Path) -> object:
    """Bytes of a file, or target of a link."""
    return path.readlink() if path.is_symlink() else path.read_bytes()


def compare(before: Path, after: Path) -> str:
    """The first file that two projects have made differently; empty if there is none."""
    old, new = files_made(before), files_made(after)
    if one_sided := old ^ new:
        return f"{min(one_sided)}: is in one of the projects only"
    different = (name for name in old if content(before / name) != content(after / name))
    return min(different, default="")


def copy_logs(campaign: str, project: Path) -> None:
    """Copy a campaign's measured logs; what a twin writes it writes again."""
    keys = resolve(ROOT / "config", {"campaign": campaign}).campaign
    twins = {campaign: keys.twin, f"{campaign}-torque": keys.torque and keys.torque.twin}
    for name, twin in twins.items():
        raw = ROOT / "data/raw" / name
        if twin is None and raw.is_dir():
            shutil.copytree(raw, project / "data/raw" / name)


def main(campaign: str, python: str = "") -> int:
    """Run a campaign twice and compare; 0 where all bytes are the same."""
    with tempfile.TemporaryDirectory(prefix="oilfilm-verify-") as folder:
        projects = (Path(folder, "first"), Path(folder, "the second/of two"))
        other = Surroundings("2", python=python) if python else unusual(Path(folder))
        surroundings = (USUAL, other)
        for lacking in other.lacking:
            print(f"NOT varied: {lacking}")
        for number, (project, around) in enumerate(zip(projects, surroundings, strict=True), 1):
            lay_out(project)
            copy_logs(campaign, project)
            print(f"run {number} of 2: {campaign}, {around.cores} core(s)", flush=True)
            target = "all" if python else "release"
            arguments = (target, "--config", f"campaign={campaign}")
            code, output = run(project, *arguments, around=around)
            if code != 0:
                print("\n".join(output.splitlines()[-30:]))
                return 1
        difference = compare(*projects)
        count = len(files_made(projects[0]))
        print(f"DIFFERENT: {difference}" if difference else f"the same bytes in all {count} files")
        return int(bool(difference))


if __name__ == "__main__":
    sys.exit(main(*(sys.argv[1:] or ["demo"])))
