"""The report of a campaign as a list of sections, which the renderers write as text and as HTML.

A section has facts (sentences), tables, and entries to unfold. Sentences are made from numbers by
templates: each line of a template is one sentence and begins with a mark.

    - 212 of 218 runs are accepted.          a fact
    ! 4010: the fit is NOT certified.        trouble: shown before all sections, and only there
    > Repeat the run.                        what to do about the sentence above

Decides: what a section is, and that trouble comes first.
"""

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from jinja2 import Environment, FileSystemLoader, StrictUndefined

from oilfilm.report.shown_table import ShownTable
from oilfilm.report.words import gate_name, law_name

_LIBRARY = Path(__file__).parents[1]
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
        downloads: Whole tables, by the name of the file that a page offers.
        words: Meanings of its own words, beside those of `oilfilm.report.words`.
    """

    anchor: str
    title: str
    facts: Sequence[Fact] = ()
    tables: Sequence[ShownTable] = ()
    entries: Sequence[Entry] = ()
    downloads: Mapping[str, pd.DataFrame] = field(default_factory=dict)
    words: Mapping[str, str] = field(default_factory=dict)

    def __bool__(self) -> bool:
        """True where it has something to say."""
        return bool(self.facts or any(self.tables) or self.entries)


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


def percent(share: float, digits: int = 1) -> str:
    """A share in percent.

    Examples:
        >>> percent(0.0421, 1), percent(float("nan"))
        ('4.2 %', 'not known')
    """
    return UNKNOWN if np.isnan(share) else f"{100 * share:.{digits}f} %"


def number(value: float, form: str = ".3g") -> str:
    """A number with the digits that a reader needs.

    Examples:
        >>> number(0.12345), number(2e-7, ".0e")
        ('0.123', '2e-07')
    """
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
        loader=FileSystemLoader(_LIBRARY),
        autoescape=False,  # noqa: S701  (plain text; the page's template escapes it)
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        # a name from a log cannot begin a line of its own
        finalize=lambda value: _LINE_END.sub(" ", value) if isinstance(value, str) else value,
    )
    environment.filters |= {
        "percent": percent,
        "number": number,
        "counted": counted,
        "listed": listed,
        "sentence": sentence,
        "law_name": law_name,
        "gate_name": gate_name,
    }
    return environment
