"""The sections of a campaign's report, in their order.

Decides: which sections a report has.
"""

from oilfilm import studies
from oilfilm.report.document import Section
from oilfilm.report.sections.data import bearing, data, refused
from oilfilm.report.sections.fits import answer, constants, fits, laws
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables


def sections(results: CampaignTables, settings: Settings) -> list[Section]:
    """The sections that have something to say; those of the campaign's studies are the last.

    Args:
        results: The finished tables.
        settings: All settings of the campaign.
    """
    made = [
        answer(results, settings),
        data(results, settings),
        refused(results, settings),
        fits(results),
        constants(results),
        laws(results, settings),
        bearing(results, settings),
    ]
    for study in studies.load(settings.campaign.studies):
        made += study.sections(results, settings)
    return [section for section in made if section]
