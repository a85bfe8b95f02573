"""The report of a campaign as a list of sections, which the renderers write as text and as HTML.

A section has facts (sentences), tables, and entries to unfold. Sentences are made from numbers by
templates: each line of a template is one sentence and begins with a mark.

    - 212 of 218 runs are accepted.          a fact
    ! 4010: the fit is NOT certified.        trouble: shown before all sections, and only there
    > Repeat the run.                        what to do about it; more lines add sentences

`shown_tables.yaml` beside this module declares which columns of the finished tables are shown.

Decides: what a section is, that trouble comes first, signs and units of numbers in shown tables,
the meaning of each word of a verdict (`glossary.yaml`).
"""

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import yaml
from jinja2 import Environment, FileSystemLoader, StrictUndefined

from oilfilm import tables
from oilfilm.base import studies
from oilfilm.report.names import gate_in_words, law_title, law_titles, load_variable_in_words

_LIBRARY_FOLDER = Path(__file__).parents[1]
# Templates of a study are named with its package.
_TEMPLATE_FOLDERS = (_LIBRARY_FOLDER, _LIBRARY_FOLDER.parent)
UNKNOWN = "not known"
_LINE_END = re.compile(r"[\r\n]+")


@dataclass(frozen=True)
class Fact:
    """A result of the campaign in a sentence.

    Attributes:
        text: The sentence.
        advice: What to do about it.
        is_trouble: Whether the report shows it before all sections.
    """

    text: str
    advice: str = ""
    is_trouble: bool = False


@dataclass(frozen=True)
class FoldedEntry:
    """A folded entry of the page: a line, and the text that appears when a reader opens it.

    Attributes:
        title: The line.
        verdicts: What is shown beside it: pairs of a basis and its short verdict.
        paragraphs: The text inside.
    """

    title: str
    verdicts: Sequence[tuple[str, str]] = ()
    paragraphs: Sequence[str] = ()


@dataclass(frozen=True)
class Section:
    """A part of the report.

    Attributes:
        anchor: Its name in addresses and templates, as `bearing`.
        title: Its heading.
        facts: Its sentences (`facts_from_template` makes them).
        tables: Its tables; the text report has only those with `in_text`.
        entries: Details, which only the page shows.
        glossary: Words that only this section uses, with their meanings.
    """

    anchor: str
    title: str
    facts: Sequence[Fact] = ()
    tables: Sequence["ShownTable"] = ()
    entries: Sequence[FoldedEntry] = ()
    glossary: Mapping[str, str] = field(default_factory=dict)

    def __bool__(self) -> bool:
        """True where it has any content."""
        return bool(self.facts or any(self.tables) or self.entries)


def meaning_by_word(sections: Iterable[Section]) -> dict[str, str]:
    """The words that a report explains, with their meanings; those of all reports are first."""
    meanings = dict(_yaml_content(Path(__file__).with_name("glossary.yaml")))
    for section in sections:
        meanings |= section.glossary
    return meanings


def facts_from_template(template: str, **variables: Any) -> list[Fact]:
    """Facts made by a template.

    Args:
        template: File below the library's folder, as `report/sections/data.jinja`. That of a study
            begins with the name of its package.
        variables: The variables of the template. A line end within a text becomes a blank.

    Raises:
        ValueError: A line of the template does not begin with a mark, or an advice has no fact.

    Examples:
        >>> template = "report/sections/laws.jinja"
        >>> facts_from_template(template, rows=[], tie="A tie by construction")[0].text
        'A tie by construction.'
    """
    facts_so_far: list[Fact] = []
    rendered = _environment().get_template(template).render(variables)
    for line in rendered.split("\n"):
        mark, _, line_text = line.strip().partition(" ")
        match mark:
            case "":
                continue
            case "-" | "!":
                # the first word may be a name: it keeps its small letter
                facts_so_far.append(Fact(_with_end_mark(line_text), is_trouble=mark == "!"))
            case ">" if facts_so_far:
                advice = f"{facts_so_far[-1].advice} {as_sentence(line_text)}".strip()
                facts_so_far[-1] = replace(facts_so_far[-1], advice=advice)
            case ">":
                raise ValueError(f"{template}: no fact is before the advice {line!r}")
            case _:
                raise ValueError(f"{template}: the line {line!r} begins with no mark")
    return facts_so_far


def as_sentence(text: str) -> str:
    """A text as a sentence: with a capital letter, and a full stop if it is no question.

    Examples:
        >>> as_sentence("the log is cut"), as_sentence("is the log cut?")
        ('The log is cut.', 'Is the log cut?')
    """
    text = text.strip()
    if not text:
        return ""
    return _with_end_mark(f"{text[0].upper()}{text[1:]}")


def _with_end_mark(text: str) -> str:
    """A text with one full stop at its end, or with its own question or exclamation mark."""
    text = text.strip().rstrip(".")
    return text if text.endswith(("?", "!")) else f"{text}."


def _percent_in_sentence(share: float, digits: int = 1) -> str:
    """A share in percent, in a sentence."""
    return UNKNOWN if np.isnan(share) else f"{100 * share:.{digits}f} %"


def _number_in_sentence(value: float, number_format: str = ".3g") -> str:
    """A number with the digits that a reader needs, in a sentence."""
    return UNKNOWN if np.isnan(value) else format(value, number_format)


def count_with_noun(count: int, noun: str) -> str:
    """A count with its noun, as `1 log` or `2 logs`."""
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


def joined_by_commas(values: Iterable[Any]) -> str:
    """Values joined by commas; in a mapping, each key with its count.

    Examples:
        >>> joined_by_commas(["4102", "4050"]), joined_by_commas({"thin film": 3, "drift": 1})
        ('4102, 4050', 'thin film 3, drift 1')
    """
    if isinstance(values, Mapping):
        return ", ".join(f"{name} {count}" for name, count in values.items())
    return ", ".join(map(str, values))


def _on_one_line(value: Any) -> Any:
    """A value of a template: a name from a log must not begin a line of its own."""
    return _LINE_END.sub(" ", value) if isinstance(value, str) else value


@cache
def _environment() -> Environment:
    """Jinja's environment of the documents, with their filters."""
    environment = Environment(
        loader=FileSystemLoader(_TEMPLATE_FOLDERS),
        autoescape=False,  # noqa: S701  (plain text; the page's template escapes it)
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        finalize=_on_one_line,
    )
    environment.filters |= {
        "percent": _percent_in_sentence,
        "number": _number_in_sentence,
        "counted": count_with_noun,
        "listed": joined_by_commas,
        "sentence": as_sentence,
        "law_title": law_title,
        "gate_in_words": gate_in_words,
    }
    return environment


_NO_VALUE = "\N{EN DASH}"
_MINUS = "\N{MINUS SIGN}"

# A function from a value to the text of its cell.
CellFormatter = Callable[[Any], str]


@dataclass(frozen=True)
class ShownColumn:
    """A column of a shown table.

    Attributes:
        name: Name in the frame.
        heading: Printed above it.
        form: Function that makes the text of a cell from a value.
        unit: Unit of the printed values; that of the table's model if None.
        meaning: Meaning of the column; that of the table's model if None.
        is_number: Whether the values are numbers; the model decides where it has the column.
        is_verdict: Whether a value has a colour that shows how good it is.
    """

    name: str
    heading: str
    form: CellFormatter = str
    unit: str | None = None
    meaning: str | None = None
    is_number: bool = False
    is_verdict: bool = False

    def completed_by(self, model: tables.Table) -> "ShownColumn":
        """The column, completed with unit, meaning and type from the model of its table."""
        if self.name not in model.column_names:
            return replace(self, unit=self.unit or "")
        column = model[self.name]
        unit = column.shown_unit.replace("degC", "\N{DEGREE SIGN}C")
        return replace(
            self,
            unit=unit if self.unit is None else self.unit,
            meaning=column.description if self.meaning is None else self.meaning,
            is_number=column.type in ("number", "integer"),
        )


@dataclass(frozen=True)
class ShownTable:
    """A table as it is printed: plain texts, which the page escapes.

    Attributes:
        name: Its unique name in the page.
        caption: Its caption.
        columns: Its columns.
        rows: One text per cell.
        left_out_count: Number of rows that are not shown, because there are too many.
        source: File with all rows, below the campaign's results.
        links: Address behind the first cell of each row; no links if empty.
        in_text: Whether the text report has it, too.
    """

    name: str
    caption: str
    columns: Sequence[ShownColumn]
    rows: Sequence[Sequence[str]]
    left_out_count: int = 0
    source: str = ""
    links: Sequence[str] = ()
    in_text: bool = False

    def __bool__(self) -> bool:
        """True where it has rows."""
        return bool(self.rows)


def format_by_error(error: float) -> str:
    """Format of a value up to the second digit of its error: further digits mean nothing."""
    if np.isnan(error) or error <= 0:
        return ".4g"
    decimals = np.clip(1 - np.floor(np.log10(error)), 0, 8)
    return f".{int(decimals)}f"


def number_formatter(number_format: str) -> CellFormatter:
    """The form of numbers in a format as `.3g`, with a minus sign for print; a dash for NaN."""

    def text(value: float) -> str:
        return _NO_VALUE if np.isnan(value) else f"{value:{number_format}}".replace("-", _MINUS)

    return text


def percent_formatter(decimals: int) -> CellFormatter:
    """The form of shares, in percent with some decimals; a dash for NaN."""
    formatter_of_percentage = number_formatter(f".{decimals}f")

    def text(share: float) -> str:
        return _NO_VALUE if np.isnan(share) else f"{formatter_of_percentage(100 * share)} %"

    return text


# Formatters by their names in `shown_tables.yaml`, beside formats of numbers and percentages.
CELL_FORMATTERS: dict[str, CellFormatter] = {
    "gate": gate_in_words,
    "law": law_title,
    "laws": law_titles,
    "list": ", ".join,
    "load variable": load_variable_in_words,
    "yes or no": lambda flag: "yes" if flag else "no",
}


def show_table(
    frame: pd.DataFrame,
    declared_name: str,
    caption: str = "",
    name: str = "",
    rows_max: int | None = None,
) -> ShownTable:
    """A table of `shown_tables.yaml`; columns that the frame does not have are left out.

    Args:
        frame: Its rows.
        declared_name: The name of the table in `shown_tables.yaml`.
        caption: Its caption, if not declared there.
        name: Its name in the page, if it differs from the declared one.
        rows_max: Largest number of rows that are shown; no limit if None.
    """
    declaration = _shown_tables()[declared_name]
    model_name = declaration.get("model", declared_name)
    model = tables.TABLES.get(model_name)
    columns = []
    for column_name, declared_column in declaration["columns"].items():
        if column_name not in frame:
            continue
        column = _declared_column(column_name, declared_column)
        columns.append(column if model is None else column.completed_by(model))
    shown_rows = frame[:rows_max]
    return ShownTable(
        name=name or declared_name,
        caption=caption or declaration["caption"],
        columns=columns,
        rows=[
            [column.form(row[column.name]) for column in columns] for row in tables.rows(shown_rows)
        ],
        left_out_count=len(frame) - len(shown_rows),
        source=f"tables/{model_name}.parquet",
        in_text=declaration.get("in_text", False),
    )


@cache
def _shown_tables() -> dict[str, Any]:
    """Declarations of the shown tables of oilfilm and of all studies, by name."""
    declarations = dict(_yaml_content(Path(__file__).with_name("shown_tables.yaml")))
    for file in studies.shown_table_files(studies.available()):
        declarations |= _yaml_content(file)
    return declarations


@cache
def _yaml_content(path: Path) -> dict[str, Any]:
    """Content of a YAML file."""
    return dict(yaml.safe_load(path.read_text(encoding="utf-8")))


def _declared_column(name: str, declared_column: str | Mapping[str, Any]) -> ShownColumn:
    """A column from its declaration: its heading alone, or the attributes of `ShownColumn`."""
    if isinstance(declared_column, str):
        return ShownColumn(name, heading=declared_column)
    attributes = dict(declared_column)
    attributes["form"] = _declared_formatter(attributes.get("form", ""))
    return ShownColumn(name, **attributes)


def _declared_formatter(name: str) -> CellFormatter:
    """A form by its declared name: `law`, `.3g`, `1%`; plain text if empty."""
    if not name:
        return str
    if name in CELL_FORMATTERS:
        return CELL_FORMATTERS[name]
    if name.endswith("%"):
        return percent_formatter(int(name.removesuffix("%")))
    return number_formatter(name)
