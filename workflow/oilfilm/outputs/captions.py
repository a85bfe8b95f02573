"""Captions of figures, with where their data are from."""

from collections.abc import Mapping
from typing import Any

from oilfilm.figure_catalogue import figures

_PAPER = "Deng et al., Lubricants 14 (2026) 33"


def provenance(campaign: Mapping[str, Any]) -> str:
    """Whether a campaign's data were simulated or measured, in words.

    Args:
        campaign: The campaign file's content, at least `name` and `data`.
    """
    sentence = (
        f"SIMULATED data (rig twin, campaign {campaign['name']!r}), not a measurement"
        if campaign["data"] == "simulated"
        else f"Measured data, campaign {campaign['name']!r}"
    )
    if campaign.get("film_unjudged", {}).get("accept"):
        sentence += "; film thickness NOT JUDGED"
    return sentence


def caption(name: str, campaign: Mapping[str, Any]) -> str:
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
