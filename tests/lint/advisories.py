"""No locked package has a known vulnerability: `python tests/lint/advisories.py PIP-AUDIT`.

The advisories are on the network. Without it nothing is checked, which is said; on GitHub, where
there is always one, that is an error.
"""

import json
import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
LOCKS = [
    *sorted(ROOT.glob("requirements/*.lock")),
    *(ROOT / "benchmarks/rivals.lock", ROOT / "tests/lint/audit.lock"),
]


def main(pip_audit: str) -> int:
    """Print what is found; 1 where a package must be replaced or nothing could be asked for.

    An advisory that does no harm here is let through by pip-audit's own `--ignore-vuln`.
    """
    faults = 0
    for lock in LOCKS:
        command = [pip_audit, "--requirement", lock, "--require-hashes", "--disable-pip"]
        command += ["--format", "json", "--progress-spinner", "off"]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        try:
            packages = json.loads(done.stdout)["dependencies"]
        except ValueError:
            packages = [{"skip_reason": done.stderr}]
        if any("skip_reason" in package for package in packages):
            print(f"{lock.name}: advisories NOT CHECKED: they cannot be reached from here")
            faults += "CI" in os.environ
            continue
        print(f"{lock.name}: {len(packages)} packages")
        for package in packages:
            for advisory in package["vulns"]:
                mended = ", ".join(advisory["fix_versions"]) or "no version"
                name = f"{package['name']} {package['version']}"
                print(f"{lock.name}: {name}: {advisory['id']}, mended in {mended}")
                faults += 1
    return int(faults > 0)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
