"""No locked package has a known vulnerability: `python tests/lint/advisories.py PIP-AUDIT`.

The advisories are on the network. Without it nothing is checked, which is said; on GitHub, where
there is always one, that is an error.
"""

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[2]
LOCKS = [
    *sorted(ROOT.glob("requirements/*.lock")),
    *(ROOT / "benchmarks/rivals.lock", ROOT / "tests/lint/audit.lock"),
]
# Advisories that do no harm here, each with the reason; they are still printed.
HARMLESS: dict[str, str] = {}


def checked(pip_audit: str, lock: Path) -> list[dict[str, Any]] | None:
    """The packages of a lock file with their advisories; None where they could not be asked for."""
    command = [pip_audit, "--requirement", lock, "--require-hashes", "--disable-pip"]
    done = subprocess.run(
        [*command, "--format", "json", "--progress-spinner", "off"],
        capture_output=True,
        text=True,
        check=False,
    )
    try:
        packages: list[dict[str, Any]] = json.loads(done.stdout)["dependencies"]
    except ValueError:
        return None
    return None if any("skip_reason" in package for package in packages) else packages


def findings(packages: list[dict[str, Any]]) -> list[tuple[str, str]]:
    """The advisories of packages: id and sentence."""
    return [
        (
            advisory["id"],
            f"{package['name']} {package['version']}: {advisory['id']}, mended in "
            f"{', '.join(advisory['fix_versions']) or 'no version'}",
        )
        for package in packages
        for advisory in package["vulns"]
    ]


def main(pip_audit: str) -> int:
    """Print what is found; 1 where a package must be replaced or nothing could be asked for."""
    faults = 0
    for lock in LOCKS:
        packages = checked(pip_audit, lock)
        if packages is None:
            print(f"{lock.name}: advisories NOT CHECKED: they cannot be reached from here")
            faults += "CI" in os.environ
            continue
        found = findings(packages)
        for advisory, sentence in found:
            reason = HARMLESS.get(advisory)
            faults += reason is None
            print(f"{lock.name}: {sentence}" + (f" (harmless: {reason})" if reason else ""))
        print(f"{lock.name}: {len(packages)} packages, {len(found)} advisories")
    return int(faults > 0)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
