"""The report as plain text: the answer first, then trouble, then each section.

Decides: what the summary shows.
"""

from collections.abc import Iterable, Iterator, Sequence

from oilfilm.base.errors import printable
from oilfilm.base.text_table import markdown_table
from oilfilm.report.captions import data_origin
from oilfilm.report.document import Fact, Section, ShownTable, as_sentence, meaning_by_word
from oilfilm.settings.campaign import Campaign

_CONTENTS_OF_RESULTS = (
    ("Report", "report.html (open it in a browser; it needs no network)"),
    ("Tables", "tables (start with quarantine.csv)"),
    ("Figures", "figures"),
    ("Exports", "exports (the fits for bearing codes; start with README.md)"),
    ("Refused", "refused (one picture per run; index.parquet lists them)"),
)


def text_report(
    sections: Sequence[Section],
    campaign: Campaign,
    contents_of_results: Sequence[tuple[str, str]] = _CONTENTS_OF_RESULTS,
) -> str:
    """The text of summary.txt, made from the sections.

    Args:
        sections: Sections of the campaign's report; the first one is the answer.
        campaign: Name, description and origin of the data.
        contents_of_results: What there is in the results, each with its file or folder.
    """
    answer = sections[0]
    lines_on_files = [
        f"- {content}: results/{campaign.name}/{file}" for content, file in contents_of_results
    ]
    words_and_meanings = meaning_by_word(sections).items()
    lines = [
        as_sentence(f"Campaign {campaign.name}: {campaign.description}"),
        as_sentence(data_origin(campaign)),
        "",
    ]
    lines += _with_heading(answer.title, _section_lines(answer))
    lines += _with_heading("Trouble", _trouble_lines(sections))
    lines += _with_heading("Where to find what", lines_on_files)
    for section in sections[1:]:
        lines += _with_heading(section.title, _section_lines(section))
    lines += _with_heading(
        "Words", [f"- {word}: {as_sentence(meaning)}" for word, meaning in words_and_meanings]
    )
    return "\n".join(map(printable, lines)).rstrip() + "\n"


def _with_heading(title: str, lines: Iterable[str]) -> list[str]:
    """Lines below their heading, with one empty line at the end; nothing without lines."""
    body = list(lines)
    while body and not body[-1]:
        body.pop()
    if not body:
        return []
    return [title, "-" * len(title), *body, ""]


def _section_lines(section: Section) -> Iterator[str]:
    """Lines of the facts that are no trouble, and of the tables."""
    facts = [fact for fact in section.facts if not fact.is_trouble]
    if facts:
        yield from _fact_lines(facts)
        yield ""
    for table in section.tables:
        yield from _table_lines(table)


def _trouble_lines(sections: Iterable[Section]) -> Iterator[str]:
    """Lines of all trouble, below the titles of the sections."""
    for section in sections:
        trouble = [fact for fact in section.facts if fact.is_trouble]
        if trouble:
            yield f"{section.title}:"
            yield from _fact_lines(trouble)
            yield ""


def _fact_lines(facts: Iterable[Fact]) -> Iterator[str]:
    """Lines of facts, each with its advice."""
    for fact in facts:
        yield f"- {fact.text}"
        if fact.advice:
            yield f"  What to do: {fact.advice}"


def _table_lines(table: ShownTable) -> Iterator[str]:
    """Lines of a table; none where it has no rows or is for the page alone."""
    if not table or not table.in_text:
        return
    headings = [
        f"{column.heading} ({column.unit})" if column.unit else column.heading
        for column in table.columns
    ]
    # a reader who searches for -0.1 types the minus of a keyboard
    rows = [[cell.replace("\N{MINUS SIGN}", "-") for cell in row] for row in table.rows]
    yield f"{table.caption}:"
    yield ""
    yield from markdown_table(headings, rows)
    yield ""
    if table.left_out_count:
        yield f"And {table.left_out_count} more rows: {table.source}."
        yield ""
