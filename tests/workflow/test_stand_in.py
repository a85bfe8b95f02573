"""A script can be run without a Snakemake run, as CONTRIBUTING.md says."""

import subprocess
import sys
from pathlib import Path

from campaigns import ROOT
from oilfilm import tables


def test_script_of_a_rule_runs_in_one_process(tmp_path: Path) -> None:
    for name in ("Snakefile", "workflow", "config", "requirements"):
        (tmp_path / name).symlink_to(ROOT / name)
    (tmp_path / "data").mkdir()
    (tmp_path / "data/reference").symlink_to(ROOT / "data/reference")
    command = [sys.executable, "workflow/stand_in.py", "torque_twin", "campaign=demo"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    (path,) = tmp_path.rglob("torque_truth.parquet")
    assert len(tables.read(path.stem, path)) > 0
