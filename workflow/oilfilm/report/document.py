"""The report of a campaign as a list of sections, which the renderers write as text and as HTML.

A section has facts (sentences), tables, and entries to unfold. Sentences are made from numbers by
templates: each line of a template is one sentence and begins with a mark.

    - 212 of 218 runs are accepted.          a fact
    ! 4010: the fit is NOT certified.        trouble: shown before all sections, and only there
    > Repeat the run.                        what to do about the sentence above

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
from oilfilm.report.words import gate_name, law_name, law_names, load_variable

_LIBRARY = Path(__file__).parents[1]
# Templates of a study are named with its package.
_TEMPLATES = (_LIBRARY, _LIBRARY.parent)
UNKNOWN = "not known"
_LINE_END = re.compile(r"[\r\n]+")


@dataclass(frozen=True)
class Fact:
    """Something that the campaign shows, told in a sentence or two.

    Attributes:
        text: The sentences.
        advice: What to do about it.
        is_trouble: Whether a reader must know it before all else.
    """

    text: str
    advice: str = ""
    is_trouble: bool = False


@dataclass(frozen=True)
class Entry:
    """Something that a page shows folded: a line, and what one reads when it is opened.

    Attributes:
        title: The line.
        verdicts: Short verdicts beside it, each with what it is based on.
        paragraphs: What is inside.
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
        facts: What it tells, in sentences (`facts` makes them).
        tables: What it shows; the text has those that say so.
        entries: Details, which only a page shows.
        words: Meanings of its own words, beside those of `glossary.yaml`.
    """

    anchor: str
    title: str
    facts: Sequence[Fact] = ()
    tables: Sequence["ShownTable"] = ()
    entries: Sequence[Entry] = ()
    words: Mapping[str, str] = field(default_factory=dict)

    def __bool__(self) -> bool:
        """True where it has something to say."""
        return bool(self.facts or any(self.tables) or self.entries)


def meanings(sections: Iterable[Section]) -> dict[str, str]:
    """The words of a report that need a meaning, each with its meaning."""
    known = dict(_declarations(Path(__file__).with_name("glossary.yaml")))
    for section in sections:
        known |= section.words
    return known


def facts(template: str, **numbers: Any) -> list[Fact]:
    """Sentences from numbers.

    Args:
        template: File below the library's folder, as `report/sections/data.jinja`.
        numbers: What the template names. A line end within a text becomes a blank.

    Raises:
        ValueError: A line of the template begins with no mark.

    Examples:
        >>> facts("report/sections/laws.jinja", rows=[], tie="A tie by construction")[0].text
        'A tie by construction.'
    """
    made: list[Fact] = []
    for line in _environment().get_template(template).render(numbers).split("\n"):
        mark, _, text = line.strip().partition(" ")
        match mark:
            case "":
                continue
            case "-" | "!":
                # what begins with a name keeps its small letter
                made.append(Fact(f"{text.strip().rstrip('.')}.", is_trouble=mark == "!"))
            case ">" if made:
                made[-1] = replace(made[-1], advice=sentence(text))
            case _:
                raise ValueError(f"{template}: the line {line!r} begins with no mark")
    return made


def sentence(text: str) -> str:
    """A text as a sentence: with a capital letter and a full stop.

    Examples:
        >>> sentence("the log is cut")
        'The log is cut.'
    """
    text = text.strip()
    return f"{text[:1].upper()}{text[1:].rstrip('.')}." if text else ""


def _percent(share: float, digits: int = 1) -> str:
    """A share in percent, in a sentence."""
    return UNKNOWN if np.isnan(share) else f"{100 * share:.{digits}f} %"


def _number(value: float, form: str = ".3g") -> str:
    """A number with the digits that a reader needs, in a sentence."""
    return UNKNOWN if np.isnan(value) else format(value, form)


def counted(count: int, what: str) -> str:
    """A number of things, as `1 log` or `2 logs`."""
    return f"{count} {what}{'' if count == 1 else 's'}"


def listed(values: Iterable[Any]) -> str:
    """Values with commas; of a mapping each value with its count.

    Examples:
        >>> listed(["4102", "4050"]), listed({"thin film": 3, "drift": 1})
        ('4102, 4050', 'thin film 3, drift 1')
    """
    if isinstance(values, Mapping):
        return ", ".join(f"{name} {count}" for name, count in values.items())
    return ", ".join(map(str, values))


@cache
def _environment() -> Environment:
    environment = Environment(
        loader=FileSystemLoader(_TEMPLATES),
        autoescape=False,  # noqa: S701  (plain text; the page's template escapes it)
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        # a name from a log cannot begin a line of its own
        finalize=lambda value: _LINE_END.sub(" ", value) if isinstance(value, str) else value,
    )
    environment.filters |= {
        "percent": _percent,
        "number": _number,
        "counted": counted,
        "listed": listed,
        "sentence": sentence,
        "law_name": law_name,
        "gate_name": gate_name,
    }
    return environment


_NONE = "\N{EN DASH}"
_MINUS = "\N{MINUS SIGN}"


Form = Callable[[Any], str]


@dataclass(frozen=True)
class Column:
    """A column of a shown table.

    Attributes:
        name: Name in the frame.
        heading: What is printed above it.
        form: How its values are printed.
        unit: Unit of the printed values; that of the table's model if None.
        meaning: What it is; that of the table's model if None.
        is_number: Whether the values are numbers; what the model says if it has the column.
        is_verdict: Whether the colour of a value says how good it is.
    """

    name: str
    heading: str
    form: Form = str
    unit: str | None = None
    meaning: str | None = None
    is_number: bool = False
    is_verdict: bool = False

    def described(self, model: tables.Table) -> "Column":
        """The column with what the model of its table says of it."""
        if self.name not in model.names:
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
        name: Of it in the page, unique.
        caption: What it shows.
        columns: Its columns.
        rows: One text per cell.
        left_out: Rows that are not shown, because there are too many.
        source: File of the campaign's results that has all of it.
        links: Where the first cell of each row leads; nowhere without them.
        in_text: Whether the text has it, beside the page.
    """

    name: str
    caption: str
    columns: Sequence[Column]
    rows: Sequence[Sequence[str]]
    left_out: int = 0
    source: str = ""
    links: Sequence[str] = ()
    in_text: bool = False

    def __bool__(self) -> bool:
        """True where it has rows."""
        return bool(self.rows)


def significant(error: float) -> str:
    """Format that shows two digits of an error, which is all that a value is good for."""
    if np.isnan(error) or error <= 0:
        return ".4g"
    return f".{int(np.clip(1 - np.floor(np.log10(error)), 0, 8))}f"


def number(digits: str) -> Form:
    """A number with a proper minus; a dash where there is none."""
    return lambda value: _NONE if np.isnan(value) else f"{value:{digits}}".replace("-", _MINUS)


def percent(digits: int) -> Form:
    """A share in percent."""
    share = number(f".{digits}f")
    return lambda value: _NONE if np.isnan(value) else f"{share(100 * value)} %"


# What a declared column calls its form, beside formats of numbers and percents.
FORMS: dict[str, Form] = {
    "gate": gate_name,
    "law": law_name,
    "laws": law_names,
    "list": ", ".join,
    "load variable": load_variable,
    "yes or no": lambda flag: "yes" if flag else "no",
}


def show_table(
    frame: pd.DataFrame, declared: str, caption: str = "", name: str = "", most: int | None = None
) -> ShownTable:
    """A table of `shown_tables.yaml`; columns that the frame does not have are left out.

    Args:
        frame: Its rows.
        declared: Its name there.
        caption: What it shows, if not said there.
        name: Of it in the page, if another one.
        most: Rows that are shown at most.
    """
    about = _shown_tables()[declared]
    columns = []
    for column, given in about["columns"].items():
        keys = {"heading": given} if isinstance(given, str) else dict(given)
        if column in frame:
            columns.append(Column(column, **keys | {"form": _form(keys.get("form", ""))}))
    table = about.get("model", declared)
    if model := tables.TABLES.get(table):
        columns = [column.described(model) for column in columns]
    return ShownTable(
        name or declared,
        caption or about["caption"],
        columns,
        [
            [column.form(row[column.name]) for column in columns]
            for row in tables.rows(frame[:most])
        ],
        left_out=len(frame[most:]) if most is not None else 0,
        source=f"tables/{table}.parquet",
        in_text=about.get("in_text", False),
    )


@cache
def _shown_tables() -> dict[str, Any]:
    """Declarations of the shown tables of oilfilm and of all studies, by name."""
    declared = dict(_declarations(Path(__file__).with_name("shown_tables.yaml")))
    for file in studies.shown_tables(studies.available()):
        declared |= _declarations(file)
    return declared


@cache
def _declarations(path: Path) -> dict[str, Any]:
    return dict(yaml.safe_load(path.read_text(encoding="utf-8")))


def _form(name: str) -> Form:
    if name in FORMS or not name:
        return FORMS.get(name, str)
    return percent(int(name[:-1])) if name.endswith("%") else number(name)
