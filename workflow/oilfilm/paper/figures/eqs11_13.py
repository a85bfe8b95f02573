"""Eqs 11-13 of the paper: its printed constants beside the fitted ones."""

from oilfilm.paper.printed_law import with_printed
from oilfilm.paper.reference import PrintedCoefficients
from oilfilm.report.figures.constants import draw_constants
from oilfilm.report.figures.registry import Drawing, register
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables


@register(
    name="eqs11-13",
    like="constants",
    paper="Eqs 11-13",
    category="Paper",
    caption="Fitted constants of the traction law for each oil, with their standard errors "
    "from a bootstrap over curves. Beside them: the constants printed in the paper, signs "
    "restored, for the oils that it tested.",
    references=("printed_coefficients",),
)
def eqs11_13(
    results: CampaignTables, settings: Settings, printed_coefficients: PrintedCoefficients
) -> Drawing:
    """Each oil's constants: fitted with standard error, and printed."""
    table = with_printed(results.configured.coefficients, printed_coefficients)
    note = "Printed: Deng et al. 2026, signs reconstructed"
    return draw_constants(table, list(settings.oils), note)
