"""The command `oilfilm`: for the person at the rig, who wants a verdict on a log at once.

Everything else is done by snakemake.
"""

import argparse
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import pandas as pd

from oilfilm import tables
from oilfilm.config import resolve
from oilfilm.curation.curate import Curated, collect, curate
from oilfilm.curation.gates import advice_for
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
        logs = [(str(path), read_bytes(path)) for path in dict.fromkeys(given.logs)]
        verdict = check_logs(logs, config)
    except OilfilmError as mistake:
        print(mistake, file=sys.stderr)
        return 2
    print(report(verdict))
    unread = set(verdict.quarantine["file"]) - set(verdict.runs["file"])
    return int(bool((verdict.runs["verdict"] == "refused").any() or unread))


def check_logs(logs: Sequence[tuple[str, bytes]], config: Mapping[str, Any]) -> Curated:
    """What ingest and curation make of single logs."""
    found = ingest_logs(logs, config)
    samples = pd.concat(found.samples.values(), ignore_index=True)
    whole = collect([curate(samples, found.runs, config)], [found.quarantine], config)
    # what the workflow could not write must not pass here
    tables.conform(whole.points, "points", "points of these logs")
    return whole


# A file of more clean runs than this has them in one line.
_RUNS_LISTED = 10


def report(verdict: Curated) -> str:
    """A line a run, and what to do about everything that was refused."""
    runs, points = verdict.runs, verdict.points
    clean = runs["accepted_points"] == runs["plateaus"]
    lines = []
    for file, in_file in runs[clean].groupby("file"):
        if len(in_file) > _RUNS_LISTED:
            lines.append(
                f"{file}: {len(in_file)} runs ACCEPTED with all {in_file['plateaus'].sum()} "
                "plateaus"
            )
            runs = runs.drop(in_file.index)
    for run in runs.to_dict("records"):
        lines.append(
            f"{run['run_id']}: {run['verdict'].upper()}, {run['accepted_points']} of "
            f"{run['plateaus']} plateaus, {run['samples']} rows"
        )
        of_run = points[(points["run_id"] == run["run_id"]) & ~points["accepted"]]
        gates = of_run["reasons"].str.split(";").explode()
        for gate, count in gates.value_counts().items():
            rows = of_run.loc[gates.index[gates == gate], "first_row"]
            lines += [
                f"  {gate}: {count} plateaus, first at row {rows.min()}",
                f"    -> {advice_for(str(gate))}",
            ]
    for refused in verdict.quarantine.to_dict("records"):
        where = refused["run_id"] or refused["file"]
        lines += [
            f"{where}: {refused['rule']}: {refused['reason']}",
            f"  -> {refused['advice']}",
        ]
    return "\n".join(lines)
