"""Whether a campaign has enough accepted runs.

Decides: when a run fails because too few runs were accepted.
"""

from collections.abc import Iterator

import pandas as pd

from oilfilm.base.errors import OilfilmError
from oilfilm.base.ties import exceeds
from oilfilm.logs.run_sheet import REMARKS
from oilfilm.settings.campaign import Campaign
from oilfilm.tables.campaign_tables import CampaignTables

# Oil, empty for all of them -> accepted runs and runs.
_Counts = dict[str, tuple[int, int]]


def accepted_runs_text(results: CampaignTables, campaign: Campaign) -> str:
    """Accepted runs of each oil, a line each.

    Args:
        results: Tables `runs`, `quarantine`, `torque_runs` and `torque_quarantine`.
        campaign: At least `name`, `min_accepted_runs`, `min_accepted_share` and `torque`.

    Raises:
        OilfilmError: There are too few.
    """
    if lacking := shortfalls(results, campaign):
        folder = f"results/{campaign.name}"
        raise OilfilmError(
            f"campaign {campaign.name!r}: too few accepted runs ({'; '.join(lacking)}). Everything "
            f"else is made: {folder}/summary.txt, the pages in {folder}/refused and "
            f"{folder}/tables/quarantine.csv say why runs were refused and what to do. Where fewer "
            "accepted runs are enough, say so in the campaign file (min_accepted_runs, "
            "min_accepted_share)."
        )
    return "".join(
        f"  {oil}: {accepted} of {runs}\n" if oil else f"{kind}: {accepted} of {runs} accepted\n"
        for kind, counts in _accepted_runs(results, campaign)
        for oil, (accepted, runs) in counts.items()
    )


def shortfalls(results: CampaignTables, campaign: Campaign) -> list[str]:
    """What is lacking in accepted runs, as sentences without an end; none where there are enough.

    Arguments are those of `accepted_runs_text`.
    """
    fewest, share = campaign.min_accepted_runs, campaign.min_accepted_share
    lacking = []
    for kind, counts in _accepted_runs(results, campaign):
        accepted, runs = counts[""]
        few = [oil for oil, (accepted_of_oil, _) in counts.items() if accepted_of_oil < fewest]
        for oil in [""] if "" in few else few:
            name = f"oil {oil}: " if oil else ""
            count = f"{counts[oil][0]} of {counts[oil][1]}"
            lacking.append(f"{name}{count} {kind} accepted, expected at least {fewest}")
        if "" not in few and exceeds(share * runs, accepted):
            lacking.append(
                f"{accepted} of {runs} {kind} accepted, expected at least {share:.0%} of them"
            )
    return lacking


def unread_logs(results: CampaignTables) -> set[str]:
    """Logs of which no run could be read; remarks on the run sheet refuse nothing."""
    quarantine = results.quarantine
    refused = quarantine.loc[~quarantine["rule"].isin(REMARKS), "file"]
    return set(refused) - set(results.runs["file"])


def _accepted_runs(results: CampaignTables, campaign: Campaign) -> Iterator[tuple[str, _Counts]]:
    """Accepted runs and runs of each kind of rig, by oil."""
    runs = results.runs
    known = runs[["oil"]].assign(accepted=runs["verdict"] == "accepted")
    yield "runs", _counts(known, len(unread_logs(results)))
    if campaign.torque is not None:
        quarantine = results.torque_quarantine
        refused = quarantine[~quarantine["rule"].isin(REMARKS)]
        runs = results.torque_runs.groupby("run_id").agg(
            oil=("oil", "first"), accepted=("accepted", "any")
        )
        # of a refused run, or a log that could not be read, there is no plateau
        names = refused["run_id"].where(refused["run_id"] != "", refused["file"])
        logs = {str(run).rpartition(":")[0] or run for run in runs.index}
        yield "torque runs", _counts(runs, len({*names} - {*runs.index} - logs))


def _counts(runs: pd.DataFrame, lost: int) -> _Counts:
    """Counts by oil, those of all runs first; of lost ones not even the oil is known."""
    counts = {"": (int(runs["accepted"].sum()), len(runs) + lost)}
    for oil, accepted in runs.loc[runs["oil"] != ""].groupby("oil", sort=False)["accepted"]:
        counts[str(oil)] = int(accepted.sum()), len(accepted)
    return counts
