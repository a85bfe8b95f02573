"""Captions of figures, with where their data are from."""

from oilfilm.figure_catalogue import figures
from oilfilm.outputs.facts import film_not_judged
from oilfilm.settings.campaign import Campaign

_PAPER = "Deng et al., Lubricants 14 (2026) 33"


def provenance(campaign: Campaign) -> str:
    """Whether a campaign's data were simulated or measured, and by whom, in words.

    Args:
        campaign: At least `name`, `data`, `credit` and `film_unjudged`.
    """
    sentence = (
        f"SIMULATED data (rig twin, campaign {campaign.name!r}), not a measurement"
        if campaign.data == "simulated"
        else f"Measured data{credit(campaign)}, campaign {campaign.name!r}"
    )
    if film_not_judged(campaign):
        sentence += "; film thickness NOT JUDGED"
    return sentence


def credit(campaign: Campaign) -> str:
    """Whose measured data they are, in brackets; empty where the campaign file does not say it."""
    return f" ({campaign.credit})" if campaign.credit else ""


def caption(name: str, campaign: Campaign) -> str:
    """The caption of a figure of a campaign: content, counterpart in the paper, provenance.

    Args:
        name: Name of the figure.
        campaign: As in `provenance`.
    """
    figure = figures()[name]
    parts = [figure.caption]
    if figure.paper:
        parts.append(f"{figure.paper} of {_PAPER}.")
    if figure.shows_data:
        parts.append(f"{provenance(campaign)}.")
    return " ".join(parts)
