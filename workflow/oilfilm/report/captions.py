"""Where the data of a campaign are from.

Decides: how simulated data are named.
"""

from oilfilm.settings.campaign import Campaign


def provenance(campaign: Campaign) -> str:
    """Whether a campaign's data were simulated or measured, and by whom, in words.

    The report says it once, in its header; a figure of simulated data has a mark of its own.

    Args:
        campaign: At least `name`, `data`, `credit`, `simulated_by` and `twin`.
    """
    if campaign.data == "simulated":
        by = f"{campaign.simulator}, " if campaign.simulator else ""
        return f"SIMULATED data ({by}campaign {campaign.name!r}), not a measurement"
    return f"Measured data{credit(campaign)}, campaign {campaign.name!r}"


def credit(campaign: Campaign) -> str:
    """Whose measured data they are, in brackets; empty where the campaign file does not say it."""
    return f" ({campaign.credit})" if campaign.credit else ""
