"""Fig. 6 of the paper: measured and calculated friction torque."""

from oilfilm.report.figures.registry import Drawing, register
from oilfilm.report.figures.torque import torque
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables


@register(name="fig06", like="torque", paper="Fig. 6", category="Paper")
def fig06(results: CampaignTables, settings: Settings) -> Drawing:
    """Measured and calculated torque against speed, one panel per oil and axial load."""
    return torque(results, settings)
