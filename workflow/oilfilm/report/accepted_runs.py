"""Whether a campaign has enough accepted runs.

Decides: when a run fails because too few runs were accepted.
"""

from collections.abc import Iterator
from typing import NamedTuple

import pandas as pd

from oilfilm.base.errors import OilfilmError
from oilfilm.base.ties import exceeds
from oilfilm.logs.run_sheet import REMARK_RULES
from oilfilm.settings.campaign import Campaign
from oilfilm.tables.campaign_tables import CampaignTables

_ALL_OILS = ""


class _RunCount(NamedTuple):
    """Number of accepted runs, and of all runs."""

    accepted_count: int
    run_count: int


# Counts by oil; the counts over all oils have the key `_ALL_OILS`.
_RunCountByOil = dict[str, _RunCount]


def accepted_runs_text(results: CampaignTables, campaign: Campaign) -> str:
    """Accepted runs of each oil, one line per oil.

    Args:
        results: Tables `runs`, `quarantine`, `torque_runs` and `torque_quarantine`.
        campaign: At least `name`, `min_accepted_runs`, `min_accepted_share` and `torque`.

    Raises:
        OilfilmError: There are too few.
    """
    sentences = shortfall_sentences(results, campaign)
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
    for runs_name, counts in _run_counts_by_rig_kind(results, campaign):
        for oil, (accepted_count, run_count) in counts.items():
            if oil == _ALL_OILS:
                lines.append(f"{runs_name}: {accepted_count} of {run_count} accepted\n")
            else:
                lines.append(f"  {oil}: {accepted_count} of {run_count}\n")
    return "".join(lines)


def shortfall_sentences(results: CampaignTables, campaign: Campaign) -> list[str]:
    """Oils and kinds of rig with too few accepted runs, as sentences without a full stop.

    Empty where there are enough. Arguments are those of `accepted_runs_text`.
    """
    runs_min = campaign.min_accepted_runs
    share_min = campaign.min_accepted_share
    sentences = []
    for runs_name, counts in _run_counts_by_rig_kind(results, campaign):
        accepted_count, run_count = counts[_ALL_OILS]
        if accepted_count < runs_min:
            sentences.append(_shortfall_sentence(runs_name, accepted_count, run_count, runs_min))
            continue
        for oil, (accepted_count_of_oil, run_count_of_oil) in counts.items():
            if accepted_count_of_oil < runs_min:
                sentence = _shortfall_sentence(
                    runs_name, accepted_count_of_oil, run_count_of_oil, runs_min
                )
                sentences.append(f"oil {oil}: {sentence}")
        if exceeds(share_min * run_count, accepted_count):
            sentences.append(
                f"{accepted_count} of {run_count} {runs_name} accepted, "
                f"expected at least {100 * share_min:g} % of them"
            )
    return sentences


def _shortfall_sentence(runs_name: str, accepted_count: int, run_count: int, runs_min: int) -> str:
    """The sentence for too few accepted runs of a kind of rig."""
    return f"{accepted_count} of {run_count} {runs_name} accepted, expected at least {runs_min}"


def names_of_unread_logs(results: CampaignTables) -> set[str]:
    """Names of the logs of which no run could be read; a remark on the run sheet is no refusal."""
    quarantine = results.quarantine
    refused_files = quarantine.loc[~quarantine["rule"].isin(REMARK_RULES), "file"]
    return set(refused_files) - set(results.table("runs", ["file"])["file"])


def _run_counts_by_rig_kind(
    results: CampaignTables, campaign: Campaign
) -> Iterator[tuple[str, _RunCountByOil]]:
    """For each kind of rig: the name of its runs, and the number of accepted and of all, by oil."""
    runs = results.table("runs", ["run_id", "file", "oil", "verdict"])
    traction_runs = runs[["oil"]].assign(accepted=runs["verdict"] == "accepted")
    yield "runs", _run_counts_by_oil(traction_runs, lost_runs(results.quarantine, runs))
    if campaign.torque is not None:
        by_run = results.torque_runs.groupby("run_id")
        torque_runs = by_run.agg(oil=("oil", "first"), accepted=("accepted", "any"))
        lost = lost_runs(results.torque_quarantine, results.torque_runs)
        yield "torque runs", _run_counts_by_oil(torque_runs, lost)


def lost_runs(quarantine: pd.DataFrame, runs: pd.DataFrame) -> pd.DataFrame:
    """Refused runs and unread logs that have no row in the table of runs.

    Args:
        quarantine: Table `quarantine` or `torque_quarantine`.
        runs: Table `runs` or `torque_runs`, of which a refused torque run has no plateau.

    Returns:
        By the name of the run, or that of the log: `file`, `oil` (empty where it is not known) and
        `rule`, the first that refused it.
    """
    refused = quarantine[~quarantine["rule"].isin(REMARK_RULES)]
    refused_names = refused["run_id"].where(refused["run_id"] != "", refused["file"])
    is_lost = ~refused_names.isin([*runs["run_id"], *runs["file"]])
    by_name = refused[is_lost].groupby(refused_names[is_lost])
    return by_name.agg(file=("file", "first"), oil=("oil", "max"), rule=("rule", "first"))


def _run_counts_by_oil(read_runs: pd.DataFrame, lost: pd.DataFrame) -> _RunCountByOil:
    """Counts of all runs, then by oil.

    Args:
        read_runs: Columns `oil`, which is empty where it is not known, and `accepted`.
        lost: As of `lost_runs`.
    """
    runs = pd.concat([read_runs, lost[["oil"]].assign(accepted=False)])
    counts = {_ALL_OILS: _RunCount(int(runs["accepted"].sum()), len(runs))}
    with_known_oil = runs[runs["oil"] != ""]
    for oil, is_accepted in with_known_oil.groupby("oil", sort=False)["accepted"]:
        counts[str(oil)] = _RunCount(int(is_accepted.sum()), len(is_accepted))
    return counts
