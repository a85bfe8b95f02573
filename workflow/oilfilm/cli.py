"""The command `oilfilm`: for the person at the rig, who wants a verdict on a log at once.

Everything else is done by snakemake.
"""

import argparse
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import pandas as pd

from oilfilm.config import resolve
from oilfilm.curation.curate import Curated, collect, curate
from oilfilm.errors import OilfilmError
from oilfilm.ingest import ingest_logs, read_bytes


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; 0 where every log is good, 1 where one is refused, 2 for a mistake."""
    parser = argparse.ArgumentParser(prog="oilfilm", description=__doc__)
    commands = parser.add_subparsers(dest="command", required=True)
    check = commands.add_parser("check", help="read logs and judge them by every gate")
    check.add_argument("logs", nargs="+", type=Path, metavar="FILE")
    check.add_argument("--campaign", help="whose rig, oils and limits count (config/campaigns)")
    check.add_argument("--config", type=Path, default=Path("config"), help="configuration folder")
    given = parser.parse_args(arguments)
    overrides = {"campaign": given.campaign} if given.campaign else {}
    try:
        config = resolve(given.config, overrides)
        logs = [(str(path), read_bytes(path)) for path in given.logs]
    except OilfilmError as mistake:
        print(mistake, file=sys.stderr)
        return 2
    verdict = check_logs(logs, config)
    print(report(verdict))
    return int(bool((verdict.runs["verdict"] == "refused").any() or verdict.runs.empty))


def check_logs(logs: Sequence[tuple[str, bytes]], config: Mapping[str, Any]) -> Curated:
    """What ingest and curation make of single logs."""
    found = ingest_logs(logs, config)
    samples = pd.concat(found.samples.values(), ignore_index=True)
    return collect([curate(samples, found.runs, config)], [found.quarantine], config)


def report(verdict: Curated) -> str:
    """A line a run, and what to do about everything that was refused."""
    lines = []
    for run in verdict.runs.to_dict("records"):
        points = verdict.points[verdict.points["run_id"] == run["run_id"]]
        lines.append(
            f"{run['run_id']}: {run['verdict'].upper()}, {run['accepted_points']} of "
            f"{run['plateaus']} plateaus, {run['samples']} rows"
        )
        if run["accepted_points"] == 0:
            continue
        gates = points.loc[~points["accepted"], "reasons"].str.split(";").explode()
        lines += [f"  {gate}: {count} plateaus" for gate, count in gates.value_counts().items()]
    for refused in verdict.quarantine.to_dict("records"):
        where = refused["run_id"] or refused["file"]
        lines += [
            f"{where}: {refused['rule']}: {refused['reason']}",
            f"  -> {refused['advice']}",
        ]
    return "\n".join(lines)
