"""Captions of figures, and where the data of a campaign are from.

Decides: how simulated data are named.
"""

from oilfilm.base.figure_catalogue import figures
from oilfilm.settings.campaign import Campaign

PAPER = "Deng et al., Lubricants 14 (2026) 33"


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


def caption(name: str) -> str:
    """The caption of a figure: its content, and its counterpart in the paper."""
    figure = figures()[name]
    made_after = f" Made after {figure.paper} of {PAPER}." if figure.paper else ""
    return f"{figure.caption}{made_after}"
