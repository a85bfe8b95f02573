"""Where the data of a campaign are from, in words.

Decides: how simulated data are named.
"""

from oilfilm.settings.campaign import Campaign


def data_origin(campaign: Campaign) -> str:
    """Whether a campaign's data were simulated or measured, and by whom, in words.

    The report has this in its header. A figure of simulated data has its own mark.

    Args:
        campaign: At least `name`, `data`, `credit`, `simulated_by` and `twin`.
    """
    if campaign.data == "simulated":
        simulator = f"{campaign.simulator}, " if campaign.simulator else ""
        return f"SIMULATED data ({simulator}campaign {campaign.name!r}), not a measurement"
    return f"Measured data{credit_in_brackets(campaign)}, campaign {campaign.name!r}"


def credit_in_brackets(campaign: Campaign) -> str:
    """Who measured the data, in brackets; empty where the campaign file does not name anyone."""
    return f" ({campaign.credit})" if campaign.credit else ""
