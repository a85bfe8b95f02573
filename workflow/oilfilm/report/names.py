"""Names of the report: conditions, load variables, gates, symbols of print; the colour of an oil.

Decides: names and units on axes; the symbols of print; the colour of an oil.
"""

import re
from collections.abc import Iterable, Sequence
from typing import NamedTuple

from oilfilm.traction import LAW_TITLES


class ConditionTexts(NamedTuple):
    """How print names a quantity on which mu depends: symbol, label, and unit (empty for 1)."""

    symbol: str
    label: str
    unit: str


CONDITION_TEXTS = {
    "max_hertz_pressure_gpa": ConditionTexts("P", "Maximum Hertz pressure", "GPa"),
    "entrainment_speed_m_s": ConditionTexts("U", "Entrainment speed", "m/s"),
    "inlet_temperature_c": ConditionTexts("T", "Inlet temperature", "\N{DEGREE SIGN}C"),
    "slide_roll_ratio": ConditionTexts("S", "Slide-roll ratio", ""),
}
# Colours of Okabe and Ito, which are distinct for every kind of colour vision. Darker colours of
# Paul Tol follow, for campaigns of many oils. Beyond twelve oils colours are repeated.
_PALETTE = (
    "#0072B2",
    "#D55E00",
    "#009E73",
    "#CC79A7",
    "#E69F00",
    "#56B4E9",
    "#882255",
    "#332288",
    "#999933",
    "#117733",
    "#AA4499",
    "#661100",
)
# By the value of a column `load_variable`: how a bearing evaluates the campaign's law, or the name
# of another law.
_LAW_AND_LOAD_VARIABLE_TITLES = {
    **LAW_TITLES,
    "stress": "pressure-based",
    "load": "load-based",
    "dimensionless_load": "dimensionless load",
}
# Tables have only characters that every terminal can show. Pattern -> symbol of print, applied in
# this order.
_SYMBOLS_OF_PRINT = {
    r"\bmu\b": "\N{GREEK SMALL LETTER MU}",
    r"\blambda\b": "\N{GREEK SMALL LETTER LAMDA}",
    r"\bdegC\b": "\N{DEGREE SIGN}C",
    r"\bum\b": "\N{MICRO SIGN}m",
    r"\bR2\b": "R\N{SUPERSCRIPT TWO}",
    ">=": "\N{GREATER-THAN OR EQUAL TO}",
    "<=": "\N{LESS-THAN OR EQUAL TO}",
    # a number and its unit stay in one line
    r"(?<=\d) (?=(?:GPa|m/s|N|K|rpm)\b|%|\N{DEGREE SIGN}|\N{MICRO SIGN})": "\N{NO-BREAK SPACE}",
    r"(?<=\bS) (?=\d)": "\N{NO-BREAK SPACE}",
}
# A text in quotes is that of a log or a settings file. An apostrophe within a word opens none.
_QUOTED_TEXT = r"""(?<!\w)'[^']*'(?!\w)|(?<!\w)"[^"]*"(?!\w)"""


def oil_colour(oil: str, oils: Sequence[str]) -> str:
    """The colour of an oil, the same in all figures.

    Args:
        oil: Its name.
        oils: All oils of the campaign; their order decides.
    """
    return _PALETTE[list(oils).index(oil) % len(_PALETTE)]


def law_title(law_name: str) -> str:
    """The title of a law; its name where the law is not installed.

    Examples:
        >>> law_title("deng2026"), law_title("my-law")
        ('Deng (Eq. 7)', 'my-law')
    """
    return LAW_TITLES.get(law_name, law_name)


def law_titles(law_names: Sequence[str] | None) -> str:
    """The titles of laws, joined by commas; empty where they are not known.

    Examples:
        >>> law_titles(("deng2026", "my-law"))
        'Deng (Eq. 7), my-law'
    """
    return ", ".join(map(law_title, law_names or ()))


def load_variable_in_words(load_variable: str) -> str:
    """The name of a law in words, or of the load variable with which a bearing evaluates the law.

    Examples:
        >>> load_variable_in_words("load")
        'load-based'
    """
    return _LAW_AND_LOAD_VARIABLE_TITLES.get(load_variable, load_variable.replace("_", " "))


def gate_in_words(gate_name: str) -> str:
    """The name of a gate, or of another rule of refusal, in words.

    Examples:
        >>> gate_in_words("stuck_sensor")
        'stuck sensor'
    """
    return gate_name.replace("_", " ")


def unchanged_text_pattern(names: Iterable[str]) -> re.Pattern[str]:
    """Pattern of what the symbols of print must not change: quoted texts, and names of users.

    Args:
        names: Names of logs, runs, oils, rigs.
    """
    # all other names need no pattern: a campaign may have thousands
    changed_names = {name for name in names if _with_symbols(name) != name}
    # of two names that begin alike the longer one counts
    patterns = [
        rf"(?<!\w){re.escape(name)}(?!\w)" for name in sorted(changed_names, key=len, reverse=True)
    ]
    return re.compile(f"({'|'.join([*patterns, _QUOTED_TEXT])})")


def with_print_symbols(text: str, unchanged_pattern: re.Pattern[str] | None = None) -> str:
    """A sentence with the symbols of print in place of plain characters.

    Args:
        text: The sentence.
        unchanged_pattern: As `unchanged_text_pattern` gives it; where it is not given, no names
            are known.

    Examples:
        >>> with_print_symbols("mu >= 0")
        'μ ≥ 0'
        >>> names_of_logs = unchanged_text_pattern(["mu-oil", "mu-3.csv"])
        >>> with_print_symbols("mu-oil: mu of mu-3.csv", names_of_logs)
        'mu-oil: μ of mu-3.csv'
    """
    parts = (unchanged_pattern or unchanged_text_pattern(())).split(text)
    # every second part is as it was written
    parts[::2] = [_with_symbols(part) for part in parts[::2]]
    return "".join(parts)


def _with_symbols(text: str) -> str:
    """A text with the symbols of print, whoever has written it."""
    for pattern, symbol in _SYMBOLS_OF_PRINT.items():
        text = re.sub(pattern, symbol, text)
    return text
