"""Captions of figures and tables as reStructuredText, which Snakemake's report reads."""

import re
from collections.abc import Collection

from oilfilm import tables
from oilfilm.figure_catalogue import figures
from oilfilm.report.captions import caption, provenance
from oilfilm.settings.campaign import Campaign


def figure_caption(figure: str, campaign: Campaign, unjudged: Collection[str]) -> str:
    """Title and caption of a figure of a campaign."""
    title = figures()[figure].numbered_title
    return f"**{_plain(title)}.** {_plain(caption(figure, campaign, unjudged))}\n"


def table_caption(table: str, campaign: Campaign, unjudged: Collection[str]) -> str:
    """What one row of a table is, the origin of the data, each column's unit and meaning."""
    model = tables.TABLES[table]
    lines = [_plain(f"{model.about}\n\n{provenance(campaign, unjudged)}.\n")]
    for column in model.columns:
        unit = f" ({column.unit})" if column.unit else ""
        lines.append(_plain(f"- {column.name}{unit}: {column.description}"))
    return "\n".join(lines) + "\n"


def campaign_caption(campaign: Campaign, unjudged: Collection[str]) -> str:
    """Description of a campaign, for the first page."""
    # on one line nothing of it can be a directive, which Snakemake's report would obey
    about = " ".join(f"Campaign {campaign.name}: {campaign.description}.".split())
    return f"{_plain(about)}\n\n{_plain(provenance(campaign, unjudged))}.\n"


def _plain(text: str) -> str:
    r"""The text without markup, neither of reStructuredText nor of Jinja.

    Examples:
        >>> print(_plain("|S| of run_ *x*"))
        \|S\| of run\_ \*x\*
    """
    return re.sub(r"([\\*_`|])", r"\\\1", text).replace("{", "(").replace("}", ")")
