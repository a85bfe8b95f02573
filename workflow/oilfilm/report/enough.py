"""Whether a campaign has enough accepted runs.

Decides: when a run fails because too few runs were accepted.
"""

from collections.abc import Iterator

import pandas as pd

from oilfilm.errors import OilfilmError
from oilfilm.logs.run_sheet import REMARKS
from oilfilm.settings.campaign import Campaign
from oilfilm.tables.campaign_tables import CampaignTables


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
    lines = [line for kind, runs in _kinds(results, campaign) for line in _counts(kind, runs)]
    return "\n".join(lines) + "\n"


def shortfalls(results: CampaignTables, campaign: Campaign) -> list[str]:
    """What is lacking in accepted runs, as sentences without an end; none where there are enough.

    Arguments are those of `accepted_runs_text`.
    """
    return [
        sentence
        for kind, runs in _kinds(results, campaign)
        for sentence in _shortfalls(kind, runs, campaign)
    ]


def unread_logs(results: CampaignTables) -> set[str]:
    """Logs of which no run could be read; remarks on the run sheet refuse nothing."""
    quarantine = results.quarantine
    refused = quarantine.loc[~quarantine["rule"].isin(REMARKS), "file"]
    return set(refused) - set(results.runs["file"])


def _kinds(results: CampaignTables, campaign: Campaign) -> Iterator[tuple[str, pd.DataFrame]]:
    """Runs of each kind of rig: columns oil and accepted, one row per run or unread log."""
    runs = results.runs
    known = runs[["oil"]].assign(accepted=runs["verdict"] == "accepted")
    yield "runs", _with_lost(known, len(unread_logs(results)))
    if campaign.torque is not None:
        quarantine = results.torque_quarantine
        refused = quarantine[~quarantine["rule"].isin(REMARKS)]
        runs = results.torque_runs.groupby("run_id").agg(
            oil=("oil", "first"), accepted=("accepted", "any")
        )
        # of a refused run, or a log that could not be read, there is no plateau
        names = refused["run_id"].where(refused["run_id"] != "", refused["file"])
        logs = {str(run).rpartition(":")[0] or run for run in runs.index}
        yield "torque runs", _with_lost(runs, len({*names} - {*runs.index} - logs))


def _with_lost(runs: pd.DataFrame, lost: int) -> pd.DataFrame:
    """The runs, and as many more of which not even the oil is known."""
    unread = pd.DataFrame({"oil": [""] * lost, "accepted": [False] * lost})
    return pd.concat([runs, unread], ignore_index=True).astype({"accepted": bool})


def _shortfalls(kind: str, runs: pd.DataFrame, campaign: Campaign) -> Iterator[str]:
    fewest, share, accepted = (
        campaign.min_accepted_runs,
        campaign.min_accepted_share,
        runs["accepted"].sum(),
    )
    if accepted < fewest:
        yield f"{accepted} of {len(runs)} {kind} accepted, expected at least {fewest}"
        return
    for oil, of_oil in runs[runs["oil"] != ""].groupby("oil", sort=False)["accepted"]:
        if of_oil.sum() < fewest:
            yield (
                f"oil {oil}: {of_oil.sum()} of {len(of_oil)} {kind} accepted, expected at least "
                f"{fewest}"
            )
    if accepted < share * len(runs):
        yield f"{accepted} of {len(runs)} {kind} accepted, expected at least {share:.0%} of them"


def _counts(kind: str, runs: pd.DataFrame) -> Iterator[str]:
    yield f"{kind}: {runs['accepted'].sum()} of {len(runs)} accepted"
    for oil, of_oil in runs[runs["oil"] != ""].groupby("oil", sort=False)["accepted"]:
        yield f"  {oil}: {of_oil.sum()} of {len(of_oil)}"
