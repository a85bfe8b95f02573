"""Facts about a campaign that its summary and its report both state."""

from collections.abc import Mapping

from oilfilm.curation.coverage import planned_states
from oilfilm.settings.campaign import Campaign
from oilfilm.settings.oil import OilFile
from oilfilm.tables.campaign_tables import CampaignTables


def accepted_runs(results: CampaignTables) -> str:
    """Accepted of all runs, as `212 of 218`."""
    accepted = (results.runs["verdict"] == "accepted").sum()
    return f"{accepted} of {len(results.runs)}"


def accepted_points(results: CampaignTables) -> str:
    """Accepted of all points."""
    return f"{results.points['accepted'].sum()} of {len(results.points)}"


def condition_counts(results: CampaignTables) -> dict[str, int]:
    """Number of conditions by state, `accepted`, `refused` or `missing`.

    Of the matrix, or of what was tested where the campaign has no matrix.
    """
    has_matrix = results.coverage["planned"].any()
    states = (planned_states(results.coverage) if has_matrix else results.coverage)["state"]
    counts = states.value_counts().reindex(["accepted", "refused", "missing"], fill_value=0)
    return {str(state): int(count) for state, count in counts.items()}


def unread_logs(results: CampaignTables) -> set[str]:
    """Logs of which no run could be read."""
    return set(results.quarantine["file"]) - set(results.runs["file"])


def stand_in_oils(oils: Mapping[str, OilFile | None]) -> list[str]:
    """Oils with the properties of another oil."""
    return [name for name, oil in oils.items() if oil is not None and oil.stand_in]


def film_not_judged(campaign: Campaign) -> bool:
    """Whether the campaign uses points without a film thickness."""
    return campaign.film_unjudged is not None and campaign.film_unjudged.accept
