"""Facts about a campaign that its summary and its report both state."""

from collections.abc import Mapping

import pandas as pd

from oilfilm.curation.coverage import planned_states
from oilfilm.readers.run_sheet import REMARKS
from oilfilm.settings.campaign import Campaign
from oilfilm.settings.oil import OilFile
from oilfilm.studies.law_comparison import TIE
from oilfilm.tables.campaign_tables import CampaignTables


def accepted_runs(results: CampaignTables) -> str:
    """Accepted of all runs, as `212 of 218`."""
    accepted = (results.runs["verdict"] == "accepted").sum()
    return f"{accepted} of {len(results.runs)}"


def accepted_points(results: CampaignTables) -> str:
    """Accepted of all points."""
    return f"{results.points['accepted'].sum()} of {len(results.points)}"


def circular(campaign: Campaign) -> str:
    """What verdicts on the claims are worth where the points were simulated; empty elsewhere."""
    if campaign.truth_is_law:
        return (
            "CIRCULAR on the refit: the points were SIMULATED with the printed constants, so that "
            f"verdicts are about those, not about the oils. Wang-Deng: {TIE}."
        )
    if campaign.data == "simulated":
        return "The points were SIMULATED: verdicts on the refit say nothing of the real oils."
    return ""


def condition_counts(results: CampaignTables) -> dict[str, int]:
    """Number of conditions by state, `accepted`, `refused` or `missing`.

    Of the matrix, or of what was tested where the campaign has no matrix.
    """
    has_matrix = results.coverage["planned"].any()
    states = (planned_states(results.coverage) if has_matrix else results.coverage)["state"]
    counts = states.value_counts().reindex(["accepted", "refused", "missing"], fill_value=0)
    return {str(state): int(count) for state, count in counts.items()}


def counted(count: int, what: str) -> str:
    """A number of things, as `1 log` or `2 logs`."""
    return f"{count} {what}{'' if count == 1 else 's'}"


def unread_logs(results: CampaignTables) -> set[str]:
    """Logs of which no run could be read."""
    return refused_files(results.quarantine) - set(results.runs["file"])


def refused_files(quarantine: pd.DataFrame) -> set[str]:
    """Logs that were refused in whole or in part; remarks refuse nothing."""
    return set(quarantine.loc[~quarantine["rule"].isin(REMARKS), "file"])


def stand_in_oils(oils: Mapping[str, OilFile | None]) -> list[str]:
    """Oils with the properties of another oil."""
    return [name for name, oil in oils.items() if oil is not None and oil.stand_in]


def film_unjudged_oils(points: pd.DataFrame) -> list[str]:
    """Oils with accepted points of which no film thickness could be calculated."""
    unjudged = points["accepted"] & (points["film_judgement"] == "cannot be judged")
    return list(dict.fromkeys(points.loc[unjudged, "oil"]))
