"""A campaign run twice in surroundings that must not matter, and compared byte by byte.

`make verify` does it for the demonstration campaign. The second run has another folder, date,
number of cores, host name, user, network (none), locale, time zone, order of hashes and umask.
"""

import base64
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

from campaigns import ROOT, lay_out
from oilfilm.releases.table_diff import folder_difference
from oilfilm.settings.resolve import resolve

GUARD = ROOT / "tests/guard"


@dataclass(frozen=True)
class Surroundings:
    """What a run finds around it."""

    cores: str = "1"
    environment: Mapping[str, str] = field(default_factory=dict)
    before: Sequence[str] = ()
    lacking: Sequence[str] = ()


def usual() -> Surroundings:
    return Surroundings(
        environment={"PYTHONHASHSEED": "1", "TZ": "UTC", "LC_ALL": "C.UTF-8", "USER": "one"}
    )


def unusual(folder: Path) -> Surroundings:
    """Everything different that can be made different on this machine."""
    environment = {
        "PYTHONHASHSEED": "2",
        "TZ": "Pacific/Kiritimati",
        # text is ASCII unless a program says otherwise
        **{"LC_ALL": "C", "PYTHONCOERCECLOCALE": "0", "PYTHONUTF8": "0"},
        **{"USER": "other", "LOGNAME": "other", "HOME": str(folder)},
    }
    before: list[str] = []
    lacking = []
    clock = fake_clock("+400d")
    if not clock:
        lacking.append("another date (libfaketime is not installed)")
    apart = ["unshare", "--user", "--map-user=65534", "--keep-caps", "--uts", "--net"]
    rename = ["sh", "-c", 'hostname elsewhere && exec "$@"', "sh"]
    if works([*apart, *rename, "true"]):
        before = [*apart, *rename]
    else:
        lacking.append("another host name and user id, and no network (unshare is not allowed)")
    before += ["sh", "-c", 'umask 077 && exec "$@"', "sh"]
    return Surroundings("2", {**environment, **clock}, before, lacking)


def works(command: Sequence[str]) -> bool:
    try:
        return subprocess.run(command, capture_output=True, check=False).returncode == 0
    except OSError:
        return False


@cache
def _libfaketime() -> str:
    places = [*Path("/usr/lib").glob("*/faketime/libfaketimeMT.so.1")]
    return str(places[0]) if places else ""


def fake_clock(offset: str) -> dict[str, str]:
    """Environment in which the clock is off; empty where libfaketime is not installed."""
    if not _libfaketime():
        return {}
    # with a false monotonic clock Python's threads wait for ever
    return {
        "LD_PRELOAD": _libfaketime(),
        "FAKETIME": offset,
        "FAKETIME_DONT_FAKE_MONOTONIC": "1",
        "DONT_FAKE_MONOTONIC": "1",
    }


def command(place: Path, *arguments: str) -> tuple[list[str], dict[str, str]]:
    """Snakemake in a project's folder, with the project's own library: command, environment."""
    environment = {
        **os.environ,
        "PYTHONPATH": os.pathsep.join([str(place / "workflow"), str(GUARD)]),
        "OILFILM_GUARD": str(place / "guard.log"),
    }
    return [sys.executable, "-m", "snakemake", *arguments], environment


def run(
    place: Path, surroundings: Surroundings, *arguments: str
) -> subprocess.CompletedProcess[str]:
    """Run snakemake in a project's folder."""
    called, environment = command(place, "--cores", surroundings.cores, *arguments)
    return subprocess.run(
        [*surroundings.before, *called],
        cwd=place,
        env={**environment, **surroundings.environment},
        capture_output=True,
        text=True,
        errors="replace",
        check=False,
    )


def killed(
    place: Path,
    seconds: float,
    *arguments: str,
    files: int = 0,
    clock: Mapping[str, str] | None = None,
) -> bool:
    """Run snakemake and kill it and all its jobs; false where it had ended by itself.

    It is killed so many seconds after as many files are made as are asked for.
    """
    called, environment = command(place, *arguments)
    with subprocess.Popen(
        called,
        cwd=place,
        env={**environment, **(clock or {})},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    ) as process:
        while process.poll() is None and recorded(place) < files:
            time.sleep(0.05)
        try:
            process.wait(seconds)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            return True
    return False


def recorded(place: Path) -> int:
    """How many files Snakemake knows to be made."""
    return sum(1 for _ in (place / ".snakemake/metadata").glob("*"))


def unfinished(place: Path) -> list[str]:
    """What Snakemake had begun to make, and not finished, when it was killed."""
    records = (place / ".snakemake/incomplete").glob("*")
    return sorted(base64.urlsafe_b64decode(record.name).decode() for record in records)


def made(place: Path) -> list[Path]:
    """Folders of what a run makes."""
    return [place / "results", place / "data/raw"]


def compare(one: Path, other: Path) -> str:
    """The first difference between what two projects have made."""
    pairs = zip(made(one), made(other), strict=True)
    return next((found for pair in pairs if (found := folder_difference(*pair))), "")


def take_logs(campaign: str, place: Path) -> None:
    """Copy a campaign's measured logs; what a twin writes it writes again."""
    keys = resolve(ROOT / "config", {"campaign": campaign}).campaign
    twins = {campaign: keys.twin, f"{campaign}-torque": keys.torque and keys.torque.twin}
    for name, twin in twins.items():
        raw = ROOT / "data/raw" / name
        if twin is None and raw.is_dir():
            shutil.copytree(raw, place / "data/raw" / name)


def main(campaign: str) -> int:
    with tempfile.TemporaryDirectory(prefix="oilfilm-verify-") as folder:
        first, second = Path(folder, "first"), Path(folder, "the second/of two")
        around = (usual(), unusual(Path(folder)))
        for lacking in around[1].lacking:
            print(f"NOT varied: {lacking}")
        for number, (place, each) in enumerate(zip((first, second), around, strict=True), start=1):
            lay_out(place)
            take_logs(campaign, place)
            print(f"run {number} of 2: {campaign}, {each.cores} core(s)", flush=True)
            done = run(place, each, "release", "--config", f"campaign={campaign}")
            if done.returncode != 0:
                print("\n".join((done.stdout + done.stderr).splitlines()[-30:]))
                return 1
        found = compare(first, second)
        files = sum(path.is_file() for top in made(first) for path in top.rglob("*"))
        print(f"DIFFERENT: {found}" if found else f"the same bytes in all {files} files")
        return int(bool(found))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1] if len(sys.argv) > 1 else "demo"))
