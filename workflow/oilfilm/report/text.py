"""The report as plain text: the answer first, then trouble, then each section.

Decides: what the summary shows.
"""

from collections.abc import Iterable, Iterator, Sequence

from oilfilm.base.errors import printable
from oilfilm.base.text_table import markdown_table
from oilfilm.report.captions import provenance
from oilfilm.report.document import Fact, Section, ShownTable, meanings, sentence
from oilfilm.settings.campaign import Campaign

_PLACES = (
    ("Report", "report.html (open it in a browser; it needs no network)"),
    ("Tables", "tables (start with quarantine.csv)"),
    ("Figures", "figures"),
    ("Exports", "exports (the fits for bearing codes; start with README.md)"),
    ("Refused", "refused (one picture per run; index.parquet lists them)"),
)


def text(
    sections: Sequence[Section], campaign: Campaign, where: Sequence[tuple[str, str]] = _PLACES
) -> str:
    """The sections as text.

    Args:
        sections: Of the campaign's report.
        campaign: Name, description and origin of the data.
        where: What is in which file of the results.
    """
    first, *others = sections
    places = [f"- {what}: results/{campaign.name}/{place}" for what, place in where]
    lines = [
        sentence(f"Campaign {campaign.name}: {campaign.description}"),
        sentence(provenance(campaign)),
        "",
        *_headed(first.title, _contents(first)),
        *_headed("Trouble", _trouble(sections)),
        *_headed("Where to find what", places),
    ]
    for section in others:
        lines += _headed(section.title, _contents(section))
    words = meanings(sections).items()
    lines += _headed("Words", [f"- {word}: {sentence(meaning)}" for word, meaning in words])
    return "\n".join(map(printable, lines)).rstrip() + "\n"


def _headed(title: str, lines: Iterable[str]) -> list[str]:
    body = list(lines)
    while body[-1:] == [""]:
        body.pop()
    return [title, "-" * len(title), *body, ""] if body else []


def _contents(section: Section) -> Iterator[str]:
    own = [fact for fact in section.facts if not fact.is_trouble]
    yield from (*_bullets(own), *([""] if own else []))
    for table in section.tables:
        yield from _table(table)


def _trouble(sections: Iterable[Section]) -> Iterator[str]:
    for section in sections:
        if trouble := [fact for fact in section.facts if fact.is_trouble]:
            yield from (f"{section.title}:", *_bullets(trouble), "")


def _bullets(facts: Iterable[Fact]) -> Iterator[str]:
    for fact in facts:
        yield f"- {fact.text}"
        if fact.advice:
            yield f"  What to do: {fact.advice}"


def _table(table: ShownTable) -> Iterator[str]:
    if not table or not table.in_text:
        return
    heads = [
        f"{column.heading} ({column.unit})" if column.unit else column.heading
        for column in table.columns
    ]
    # a minus that a search for -0.1 finds
    rows = [[cell.replace("\N{MINUS SIGN}", "-") for cell in row] for row in table.rows]
    yield from (f"{table.caption}:", "", *markdown_table(heads, rows), "")
    if table.left_out:
        yield from (f"And {table.left_out} more rows: {table.source}.", "")
