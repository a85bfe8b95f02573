"""Captions of figures, with where their data are from.

Decides: how simulated data and data without a film thickness are named.
"""

from collections.abc import Collection, Mapping

import pandas as pd

from oilfilm.figure_catalogue import figures
from oilfilm.fits.law_comparison import TIE
from oilfilm.settings.campaign import Campaign
from oilfilm.settings.oil import OilFile

PAPER = "Deng et al., Lubricants 14 (2026) 33"


def provenance(campaign: Campaign, unjudged: Collection[str]) -> str:
    """Whether a campaign's data were simulated or measured, and by whom, in words.

    Args:
        campaign: At least `name`, `data`, `credit`, `simulated_by` and `twin`.
        unjudged: Oils whose points are used without a film thickness.
    """
    sentence = f"Measured data{credit(campaign)}, campaign {campaign.name!r}"
    if campaign.data == "simulated":
        by = f"{campaign.simulator}, " if campaign.simulator else ""
        sentence = f"SIMULATED data ({by}campaign {campaign.name!r}), not a measurement"
    if unjudged:
        sentence += f"; film thickness NOT JUDGED: {', '.join(unjudged)}"
    return sentence


def credit(campaign: Campaign) -> str:
    """Whose measured data they are, in brackets; empty where the campaign file does not say it."""
    return f" ({campaign.credit})" if campaign.credit else ""


def tie(campaign: Campaign) -> str:
    """What must be said wherever the laws of a campaign are compared; mostly empty.

    Args:
        campaign: At least `twin`.
    """
    return f"Wang-Deng here: {TIE}." if campaign.truth_is_law else ""


def caption(name: str, campaign: Campaign, unjudged: Collection[str]) -> str:
    """The caption of a figure of a campaign: content, counterpart in the paper, provenance.

    Args:
        name: Name of the figure.
        campaign: As in `provenance`.
        unjudged: As there.
    """
    figure = figures()[name]
    parts = [figure.caption]
    if figure.paper:
        parts.append(f"Made after {figure.paper} of {PAPER}.")
    if figure.shows_data:
        parts.append(f"{provenance(campaign, unjudged)}.")
    if figure.compares_laws and (sentence := tie(campaign)):
        parts.append(sentence)
    return " ".join(parts)


def film_unjudged_oils(points: pd.DataFrame) -> list[str]:
    """Oils with accepted points of which no film thickness could be calculated."""
    unjudged = points["accepted"] & (points["film_judgement"] == "cannot be judged")
    return list(dict.fromkeys(points.loc[unjudged, "oil"]))


def stand_in_oils(oils: Mapping[str, OilFile | None]) -> list[str]:
    """Oils with the properties of another oil."""
    return [name for name, oil in oils.items() if oil is not None and oil.stand_in]
