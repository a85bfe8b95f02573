"""Old names, for callers that are not converted yet."""

from collections.abc import Mapping
from typing import Any

from oilfilm.settings.campaign import CampaignKeys, Semantics

__all__ = ["Semantics", "semantics_of"]


def semantics_of(campaign: Mapping[str, Any] | CampaignKeys, rig: str) -> Semantics:
    """What the campaign file says of its rigs in general and of this one."""
    if isinstance(campaign, CampaignKeys):
        return campaign.semantics_for(rig)
    general = campaign.get("semantics", {})
    return Semantics(**{**general, **campaign.get("semantics_of_rig", {}).get(rig, {})})
