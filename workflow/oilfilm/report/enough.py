"""Whether a campaign has enough accepted runs.

Decides: when a run fails because too few runs were accepted.
"""

from collections.abc import Iterable, Iterator
from typing import Any, NamedTuple

import pandas as pd

from oilfilm.base.errors import OilfilmError
from oilfilm.base.ties import exceeds
from oilfilm.logs.run_sheet import REMARKS
from oilfilm.settings.campaign import Campaign
from oilfilm.tables.campaign_tables import CampaignTables

_ALL_OILS = ""


class _RunCount(NamedTuple):
    """Number of accepted runs, and of all runs."""

    accepted: int
    runs: int


# Counts by oil; those of all oils are under `_ALL_OILS`.
_RunCounts = dict[str, _RunCount]


def accepted_runs_text(results: CampaignTables, campaign: Campaign) -> str:
    """Accepted runs of each oil, one line per oil.

    Args:
        results: Tables `runs`, `quarantine`, `torque_runs` and `torque_quarantine`.
        campaign: At least `name`, `min_accepted_runs`, `min_accepted_share` and `torque`.

    Raises:
        OilfilmError: There are too few.
    """
    sentences = shortfalls(results, campaign)
    if sentences:
        folder = f"results/{campaign.name}"
        raise OilfilmError(
            f"campaign {campaign.name!r}: too few accepted runs ({'; '.join(sentences)}). All "
            f"other files are made: {folder}/summary.txt, the pages in {folder}/refused and "
            f"{folder}/tables/quarantine.csv give the reason of each refusal and what to do. If "
            "fewer accepted runs are enough, set min_accepted_runs or min_accepted_share in the "
            "campaign file."
        )
    lines = []
    for kind, counts in _accepted_runs(results, campaign):
        for oil, (accepted, runs) in counts.items():
            if oil == _ALL_OILS:
                lines.append(f"{kind}: {accepted} of {runs} accepted\n")
            else:
                lines.append(f"  {oil}: {accepted} of {runs}\n")
    return "".join(lines)


def shortfalls(results: CampaignTables, campaign: Campaign) -> list[str]:
    """Oils and kinds of rig with too few accepted runs, as sentences without a full stop.

    Empty where there are enough. Arguments are those of `accepted_runs_text`.
    """
    fewest = campaign.min_accepted_runs
    smallest_share = campaign.min_accepted_share
    sentences = []
    for kind, counts in _accepted_runs(results, campaign):
        accepted, runs = counts[_ALL_OILS]
        if accepted < fewest:
            sentences.append(_too_few(kind, accepted, runs, fewest))
            continue
        for oil, (accepted_of_oil, runs_of_oil) in counts.items():
            if accepted_of_oil < fewest:
                sentence = _too_few(kind, accepted_of_oil, runs_of_oil, fewest)
                sentences.append(f"oil {oil}: {sentence}")
        if exceeds(smallest_share * runs, accepted):
            sentences.append(
                f"{accepted} of {runs} {kind} accepted, "
                f"expected at least {smallest_share:.0%} of them"
            )
    return sentences


def _too_few(kind: str, accepted: int, runs: int, fewest: int) -> str:
    """The sentence for too few accepted runs of a kind of rig."""
    return f"{accepted} of {runs} {kind} accepted, expected at least {fewest}"


def unread_logs(results: CampaignTables) -> set[str]:
    """Logs of which no run could be read; a remark on the run sheet is no refusal."""
    quarantine = results.quarantine
    refused_files = quarantine.loc[~quarantine["rule"].isin(REMARKS), "file"]
    return set(refused_files) - set(results.runs["file"])


def _accepted_runs(results: CampaignTables, campaign: Campaign) -> Iterator[tuple[str, _RunCounts]]:
    """Accepted runs and all runs of each kind of rig, by oil."""
    runs = results.runs
    traction_runs = pd.DataFrame(
        {"oil": runs["oil"], "accepted": runs["verdict"] == "accepted"}, index=runs.index
    )
    yield "runs", _counts(traction_runs, len(unread_logs(results)))
    if campaign.torque is not None:
        by_run = results.torque_runs.groupby("run_id")
        torque_runs = by_run.agg(oil=("oil", "first"), accepted=("accepted", "any"))
        lost = _lost_torque_runs(results.torque_quarantine, torque_runs.index)
        yield "torque runs", _counts(torque_runs, len(lost))


def _lost_torque_runs(quarantine: pd.DataFrame, run_ids: Iterable[Any]) -> set[str]:
    """Refused torque runs and unread logs, which have no plateau.

    Args:
        quarantine: Table `torque_quarantine`.
        run_ids: Runs with a plateau, as `LOG` or `LOG:RUN`.
    """
    refused = quarantine[~quarantine["rule"].isin(REMARKS)]
    names = refused["run_id"].where(refused["run_id"] != "", refused["file"])
    runs = {str(run_id) for run_id in run_ids}
    logs_of_runs = {run_id.rpartition(":")[0] or run_id for run_id in runs}
    return set(names) - runs - logs_of_runs


def _counts(runs: pd.DataFrame, lost: int) -> _RunCounts:
    """Counts of all runs, then by oil.

    Args:
        runs: Columns `oil` and `accepted`.
        lost: Number of runs and logs beside them, whose oil is not known.
    """
    counts = {_ALL_OILS: _RunCount(int(runs["accepted"].sum()), len(runs) + lost)}
    with_known_oil = runs[runs["oil"] != ""]
    for oil, accepted in with_known_oil.groupby("oil", sort=False)["accepted"]:
        counts[str(oil)] = _RunCount(int(accepted.sum()), len(accepted))
    return counts
