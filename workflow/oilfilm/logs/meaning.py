"""What the name of a column means: quantity, definition, unit, and how each is known.

A name says what a column is by its words, in eight languages (`words.yaml`). Some names leave open
which of several definitions they mean: "Hertz pressure" may be the maximum or the mean. Such a
meaning is asked, never assumed. The numbers of other columns may answer it (`api/mu_columns.py`).

Decides: which words of a name make a quantity and its definition, and when a meaning is asked.
"""

import re
import unicodedata
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path
from typing import NamedTuple

import yaml

from oilfilm.base.plain_key import plain_key
from oilfilm.base.units import possible_conversion
from oilfilm.logs.header import split_bracketed_unit
from oilfilm.logs.log_schema import QuantityAndUnit, Vocabulary

# Quantity -> the unit in which it is used here.
UNIT_BY_QUANTITY = {
    "time": "s",
    "load": "N",
    "max_hertz_pressure": "GPa",
    "traction_force": "N",
    "traction_torque": "N m",
    "traction_coefficient": "1",
    "ball_speed": "m/s",
    "disc_speed": "m/s",
    "entrainment_speed": "m/s",
    "slide_roll_ratio": "1",
    "inlet_temperature": "degC",
}
# Quantity -> its definitions; the first is that of the project, which needs no conversion.
DEFINITIONS_OF_QUANTITY = {
    "max_hertz_pressure": ("maximum", "mean"),
    "entrainment_speed": ("mean", "sum"),
    "slide_roll_ratio": ("over_mean", "over_sum", "over_faster", "sliding_speed"),
}
# A definition in words.
DEFINITION_IN_WORDS = {
    "maximum": "the maximum Hertz pressure",
    "mean": "the mean",
    "sum": "the sum of both surface speeds",
    "over_mean": "the sliding speed over the mean of both surface speeds",
    "over_sum": "the sliding speed over the sum of both surface speeds",
    "over_faster": "the sliding speed over that of the faster body",
    "sliding_speed": "the sliding speed, the difference of both surface speeds",
}
# Spelling of a symbol in papers -> the symbol.
_SYMBOL_OF_SPELLING = {
    **dict.fromkeys(("p", "P", "p0", "P0", "pmax", "p_max", "Pmax", "P_max", "PMAX", "p max"), "P"),
    **dict.fromkeys(
        ("pH", "p_H", "PH", "P_H", "p_h", "ph", "pHertz", "\u03c3max", "\u03c3_max", "\u03c3H"), "P"
    ),
    **dict.fromkeys(("sigma_max", "sigma max", "P max", "p_0"), "P"),
    **dict.fromkeys(("pm", "p_m", "pmean", "p_mean", "Pmean", "p mean"), "p_mean"),
    **dict.fromkeys(("W", "FN", "F_N", "Fn", "F_n", "FZ", "F_z", "Fz", "F_Z", "fn", "fz"), "W"),
    **dict.fromkeys(("Ft", "F_t", "FT", "F_T", "Fx", "F_x", "FX", "Ff", "F_f", "Fr", "F_r"), "F"),
    **dict.fromkeys(("U", "u", "ue", "Ue", "U_e", "u_e", "u_m", "U_m", "Um", "um"), "U"),
    **dict.fromkeys(("S", "SRR", "srr"), "S"),
    **dict.fromkeys(("T",), "T"),
    **dict.fromkeys(("mu", "MU", "Mu", "\u03bc", "\u00b5"), "mu"),
    **dict.fromkeys(("t",), "t"),
}
_QUANTITY_AND_DEFINITION_OF_SYMBOL = {
    "P": ("max_hertz_pressure", "maximum"),
    "p_mean": ("max_hertz_pressure", "mean"),
    "W": ("load", ""),
    "F": ("traction_force", ""),
    "U": ("entrainment_speed", "mean"),
    "S": ("slide_roll_ratio", "over_mean"),
    "T": ("inlet_temperature", ""),
    "mu": ("traction_coefficient", ""),
    "t": ("time", ""),
}
_SUM_OR_DIFFERENCE_OF_SPEEDS = re.compile(r"u_?1\s*([+-])\s*u_?2|u_?2\s*(-)\s*u_?1", re.IGNORECASE)
_WORD = re.compile(r"[^\W\d_]+")
_CAMEL_CASE = re.compile(r"(?<=[a-zß-ÿ])(?=[A-Z])")
# Fewest letters of a unit in a name without brackets: a single letter may be a symbol.
_SHORTEST_UNIT = 2


@dataclass(frozen=True)
class Meaning:
    """What the name of a column means.

    Attributes:
        quantity: A key of `UNIT_BY_QUANTITY`.
        definition: One of `DEFINITIONS_OF_QUANTITY`; empty where the quantity has one definition
            alone, or where the name does not say it.
        unit: Unit that the name states; empty where it states none.
        question: What the name leaves open, as a sentence; empty where it leaves nothing open.
        is_symbol: Whether the name is a symbol: a column with words for the quantity comes first.
        location: Where a temperature is measured: `inlet`, `bath`, `oil` or empty.
    """

    quantity: str
    definition: str = ""
    unit: str = ""
    question: str = ""
    is_symbol: bool = False
    location: str = ""


@cache
def _words_of_concept() -> dict[str, tuple[str, ...]]:
    """Concept -> the words for it, as `words.yaml` lists them."""
    text = Path(__file__).with_name("words.yaml").read_text(encoding="utf-8")
    entries = yaml.safe_load(text).items()
    return {concept: tuple(str(words).casefold().split()) for concept, words in entries}


class _WordForms(NamedTuple):
    """The words of `words.yaml` by how they are looked for in a name.

    Attributes:
        whole_words: Word -> its concepts; it counts where it stands alone.
        word_parts: Parts of words, as `reib-`, each with its concept.
        phrases: Several words, and Chinese and Japanese words, each with its concept, the longest
            first. They are found anywhere in a name.
    """

    whole_words: Mapping[str, set[str]]
    word_parts: Sequence[tuple[str, str]]
    phrases: Sequence[tuple[str, str]]


@cache
def _word_forms() -> _WordForms:
    whole_words: dict[str, set[str]] = {}
    word_parts: list[tuple[str, str]] = []
    phrases: list[tuple[str, str]] = []
    for concept, words in _words_of_concept().items():
        if concept.startswith("label_"):
            continue
        for word in words:
            if _is_cjk(word) or "_" in word:
                phrases.append((word.replace("_", " "), concept))
            elif word.startswith("-") or word.endswith("-"):
                word_parts.append((word, concept))
            else:
                whole_words.setdefault(word, set()).add(concept)
    phrases.sort(key=lambda entry: -len(entry[0]))
    return _WordForms(whole_words, word_parts, phrases)


def _is_cjk(text: str) -> bool:
    return any("\u3040" <= letter <= "\u9fff" for letter in text)


def concepts_in(name: str) -> frozenset[str]:
    """The concepts that the words of a name express: keys of `words.yaml`.

    Examples:
        >>> sorted(concepts_in("Reibungskraft"))
        ['force', 'friction']
        >>> sorted(concepts_in("coil temp"))
        ['elsewhere', 'temperature']
    """
    # `BallSpeed` is two words, `CoF` is one
    both_spellings = f"{name} {_CAMEL_CASE.sub(' ', name)}"
    remaining_text = unicodedata.normalize("NFKC", both_spellings).casefold()
    remaining_text = remaining_text.replace("-", " ").replace("_", " ")
    forms = _word_forms()
    concepts: set[str] = set()
    for phrase, concept in forms.phrases:
        if phrase in remaining_text:
            concepts.add(concept)
            # the same phrase may have two meanings; a shorter one inside it has none
            concepts |= {other_concept for other, other_concept in forms.phrases if other == phrase}
            remaining_text = remaining_text.replace(phrase, " ")
    for token in _WORD.findall(remaining_text):
        concepts |= forms.whole_words.get(token, set())
        for word_part, concept in forms.word_parts:
            if _has_part(token, word_part):
                concepts.add(concept)
    return frozenset(concepts)


def _has_part(word: str, word_part: str) -> bool:
    """Whether a word begins with `part-`, ends with `-part` or has `-part-` in it."""
    letters = word_part.strip("-")
    if word_part.startswith("-") and word_part.endswith("-"):
        return letters in word
    return word.startswith(letters) if word_part.endswith("-") else word.endswith(letters)


def label_kind_of(name: str) -> str:
    """`oil` or `curve` where the name of a column of text says so; else empty."""
    concepts = concepts_in(name)
    if concepts & {"temperature", "time", "speed", "pressure", "friction"}:
        return ""
    plain_name = unicodedata.normalize("NFKC", name).casefold()
    words_of_name = set(_WORD.findall(plain_name))
    for label in ("oil", "curve"):
        for word in _words_of_concept()[f"label_{label}"]:
            if word in words_of_name or (_is_cjk(word) and word in plain_name):
                return label
    return ""


# ---------------------------------------------------------------- units


def _is_convertible(unit: str, quantity_unit: str) -> bool:
    """Whether a unit can be converted to that of a quantity."""
    return possible_conversion(unit, (quantity_unit,)) is not None


def is_unit_of(unit: str, quantity: str) -> bool:
    """Whether a quantity, in one of its definitions, can have a unit."""
    units_of_definitions = [UNIT_BY_QUANTITY[quantity]]
    if quantity in ("ball_speed", "disc_speed"):
        units_of_definitions.append("rpm")
    if quantity == "slide_roll_ratio":
        units_of_definitions.append("m/s")
    return any(
        _is_convertible(unit, unit_of_definition) for unit_of_definition in units_of_definitions
    )


def split_unit(name: str) -> tuple[str, str]:
    """A name without its unit, and the unit: in brackets, after a slash or comma, or at an end.

    Examples:
        >>> split_unit("Speed / mm s-1")
        ('Speed', 'mm s-1')
        >>> split_unit("speed_m_s")
        ('speed', 'm/s')
        >>> split_unit("Temp °C")
        ('Temp', '°C')
        >>> split_unit("time_min"), split_unit("Time / min"), split_unit("load_min")
        (('time', 'min'), ('Time', 'min'), ('load_min', ''))
    """
    bare_name, unit = split_bracketed_unit(name.strip())
    if unit:
        return bare_name, unit
    for separator in (" / ", " in ", ", "):
        name_before, separator_found, unit_after = bare_name.rpartition(separator)
        unit = unit_after.strip()
        if separator_found and (unit in _UNITS_OF_TIME or _is_any_unit(unit)):
            return name_before.strip(), unit
    if bare_name.endswith("%"):
        return bare_name[:-1].strip(), "%"
    plain_name = plain_key(bare_name)
    for ending, unit in _UNIT_OF_KEY_ENDING.items():
        if plain_name.endswith(f"_{ending}") and " " not in bare_name.strip():
            return bare_name[: -len(ending) - 1], unit
    name_before, separator_found, ending = bare_name.strip().rpartition("_")
    # `load_min` is the smallest load
    if separator_found and ending in _UNITS_OF_TIME and "time" in concepts_in(name_before):
        return name_before, ending
    words = bare_name.split()
    if len(words) > 1 and words[-1] == "N":
        return " ".join(words[:-1]), "N"
    for word_count in (2, 1):
        last_words = " ".join(words[-word_count:])
        if (
            len(words) > word_count
            and len(last_words) >= _SHORTEST_UNIT
            and _is_any_unit(last_words)
        ):
            return " ".join(words[:-word_count]), last_words
    if len(words) > 1 and len(words[0]) > _SHORTEST_UNIT and _is_any_unit(words[0]):
        return " ".join(words[1:]), words[0]
    return bare_name, ""


# Units of a time behind a slash, a comma or `in`, and at the end of a key.
_UNITS_OF_TIME = ("s", "ms", "min", "h")
# Ends of names that are written like keys, as `speed_m_s`.
_UNIT_OF_KEY_ENDING = {
    "mm_s": "mm/s",
    "m_s": "m/s",
    "gpa": "GPa",
    "mpa": "MPa",
    "degc": "degC",
    "rpm": "rpm",
    "percent": "%",
    "pct": "%",
    "kn": "kN",
    "n": "N",
    "c": "degC",
}


@cache
def _is_any_unit(text: str) -> bool:
    if text.casefold() in ("load", "force", "speed", "time", "min", "h", "a", "d", "t", "s"):
        return False
    return any(is_unit_of(text, quantity) for quantity in UNIT_BY_QUANTITY)


# ---------------------------------------------------------------- names


def meaning_of(
    name: str, unit_beside: str = "", *, may_be_set_point: bool = False
) -> Meaning | None:
    """The meaning of a column's name; None where it names nothing that is used here.

    Args:
        name: The name, perhaps with its unit.
        unit_beside: Unit that the log gives beside the name; empty without one.
        may_be_set_point: Whether a set point counts, as in the header of a log. A column of set
            points is no measurement.

    Examples:
        >>> meaning_of("mean Hertz pressure [GPa]")  # doctest: +ELLIPSIS
        Meaning(quantity='max_hertz_pressure', definition='mean', unit='GPa', ...)
        >>> meaning_of("coil temp [°C]") is None
        True
        >>> meaning_of("Schlupf [%]").question
        'it may be over the mean, over the sum or over the speed of the faster body'
    """
    bare_name, unit_of_name = split_unit(name)
    unit = unit_beside or unit_of_name
    # `F_n` is a symbol, not F in newtons
    symbol = _SYMBOL_OF_SPELLING.get(name.strip()) or _SYMBOL_OF_SPELLING.get(bare_name.strip())
    if name.strip() in _SYMBOL_OF_SPELLING:
        unit = unit_beside
    if symbol is not None:
        return _meaning_of_symbol(symbol, unit)
    concepts = concepts_in(bare_name)
    if may_be_set_point:
        concepts -= {"set"}
    if concepts & {"set", "error", "count", "other"}:
        return None
    speed_terms = _SUM_OR_DIFFERENCE_OF_SPEEDS.search(name)
    if speed_terms is not None:
        concepts |= {"sum" if speed_terms[1] == "+" else "difference", "speed"}
    for rule in _RULES:
        meaning = rule(concepts, unit)
        if meaning is not None:
            return replace(meaning, unit=unit)
    return None


def _meaning_of_symbol(symbol: str, unit: str) -> Meaning | None:
    """The meaning of a symbol; None where its unit contradicts it."""
    quantity, definition = _QUANTITY_AND_DEFINITION_OF_SYMBOL[symbol]
    if unit and not is_unit_of(unit, quantity):
        return None
    if quantity == "max_hertz_pressure" and _is_unit_of_supply(unit):
        question = f"{_PRESSURE_QUESTION}, or another pressure"
        return Meaning(quantity, unit=unit, question=question, is_symbol=True)
    return Meaning(quantity, definition, unit, is_symbol=True)


def _coefficient_rule(concepts: frozenset[str], unit: str) -> Meaning | None:
    if concepts & {"speed", "temperature", "pressure", "time", "torque"}:
        return None
    if "cof" in concepts or {"friction", "coefficient"} <= concepts:
        if unit and not _is_convertible(unit, "1"):
            return None
        return Meaning("traction_coefficient", question=_question_on_reading(concepts))
    return None


_READING_QUESTION = "it may be a single value of the run, as its largest one, not each reading"


def _question_on_reading(concepts: frozenset[str]) -> str:
    """The question where a name has a word such as peak or offset; else empty."""
    return _READING_QUESTION if concepts & {"max", "no_reading"} else ""


def _traction_rule(concepts: frozenset[str], unit: str) -> Meaning | None:
    if concepts & {"speed", "temperature", "time", "distance", "coefficient"}:
        return None
    if "friction" not in concepts:
        return None
    question = _question_on_reading(concepts)
    if "torque" in concepts or (unit and _is_convertible(unit, "N m")):
        return Meaning("traction_torque", question=question)
    if unit and _is_convertible(unit, "N"):
        return Meaning("traction_force", question=question)
    if unit and _is_convertible(unit, "1"):
        return Meaning("traction_coefficient", question=question)
    if unit:
        return None
    if "force" in concepts:
        return Meaning("traction_force", question=question)
    question = "it may be the coefficient, the force or the torque"
    return Meaning("traction_coefficient", question=question)


def _temperature_rule(concepts: frozenset[str], unit: str) -> Meaning | None:
    is_temperature_unit = bool(unit) and _is_convertible(unit, "degC")
    names_oil_in_degrees = is_temperature_unit and bool(concepts & {"inlet", "bath", "oil"})
    if "temperature" not in concepts and not names_oil_in_degrees:
        return None
    if concepts & {"elsewhere", "ball", "disc", "difference", "max"}:
        return None
    if unit and not is_temperature_unit:
        return None
    if concepts & {"film", "contact"}:
        question = "it is that of film or contact; the law needs that of the oil supplied"
        return Meaning("inlet_temperature", question=question)
    for location in ("inlet", "bath", "oil"):
        if location in concepts:
            return Meaning("inlet_temperature", location=location)
    return Meaning("inlet_temperature")


_PRESSURE_QUESTION = "it may be the maximum or the mean Hertz pressure"


def _is_unit_of_supply(unit: str) -> bool:
    """Whether pressures of an oil supply have a unit, and those of a contact hardly ever."""
    return unit.strip().casefold() in ("bar", "mbar", "kpa", "hpa")


def _pressure_rule(concepts: frozenset[str], unit: str) -> Meaning | None:
    is_pressure = bool(concepts & {"pressure", "stress"}) or "hertz" in concepts
    if not is_pressure or concepts & {"friction", "temperature", "speed", "time"}:
        return None
    if unit and not _is_convertible(unit, "GPa"):
        return None
    names_contact = bool(concepts & {"hertz", "contact", "stress"})
    # an oil supply has a largest pressure, too
    names_contact |= bool(concepts & {"max", "mean"}) and not _is_unit_of_supply(unit)
    if not names_contact or concepts & {"oil", "elsewhere", "inlet"}:
        if concepts & {"oil", "elsewhere", "inlet", "bath"} or "stress" in concepts:
            return None
        return Meaning("max_hertz_pressure", question=f"{_PRESSURE_QUESTION}, or another pressure")
    if "max" in concepts:
        return Meaning("max_hertz_pressure", "maximum")
    if "mean" in concepts:
        return Meaning("max_hertz_pressure", "mean")
    return Meaning("max_hertz_pressure", question=_PRESSURE_QUESTION)


def _slip_rule(concepts: frozenset[str], unit: str) -> Meaning | None:
    if concepts & {"temperature", "time", "distance", "force", "friction"}:
        return None
    is_speed_unit = bool(unit) and _is_convertible(unit, "m/s")
    is_ratio = bool(unit) and _is_convertible(unit, "1")
    names_slip = bool(concepts & {"slip", "sliding"})
    is_over_mean = names_slip and {"rolling", "ratio"} <= concepts
    if "srr" in concepts or is_over_mean:
        return None if is_speed_unit else Meaning("slide_roll_ratio", "over_mean")
    is_difference = "difference" in concepts and bool(concepts & {"speed", "rolling"})
    if (names_slip and ("speed" in concepts or is_speed_unit)) or is_difference:
        if is_ratio or (unit and not is_speed_unit):
            return None
        return Meaning("slide_roll_ratio", "sliding_speed")
    if "slip" in concepts or ("sliding" in concepts and ("ratio" in concepts or is_ratio)):
        question = "it may be over the mean, over the sum or over the speed of the faster body"
        return Meaning("slide_roll_ratio", question=question)
    if "sliding" in concepts and not unit:
        return Meaning("slide_roll_ratio", question="it may be a ratio or a sliding speed")
    return None


def _speed_rule(concepts: frozenset[str], unit: str) -> Meaning | None:
    is_speed_unit = bool(unit) and (_is_convertible(unit, "m/s") or _is_convertible(unit, "rpm"))
    if concepts & {"temperature", "time", "force", "pressure", "torque", "friction", "elsewhere"}:
        return None
    if (
        "speed" not in concepts
        and not is_speed_unit
        and not ("entrainment" in concepts and not unit)
    ):
        return None
    if unit and not is_speed_unit:
        return None
    if {"ball", "disc"} <= concepts:
        return None
    for body in ("ball", "disc"):
        if body in concepts:
            return Meaning(f"{body}_speed")
    if unit and not _is_convertible(unit, "m/s"):
        return None
    if "sum" in concepts:
        return Meaning("entrainment_speed", "sum")
    if concepts & {"entrainment", "rolling", "mean"}:
        return Meaning("entrainment_speed", "mean")
    if "speed" in concepts:
        question = "it may be the speed of ball or disc, or their mean"
        return Meaning("entrainment_speed", question=question)
    return None


def _load_rule(concepts: frozenset[str], unit: str) -> Meaning | None:
    if concepts & {"temperature", "speed", "time", "friction", "torque", "distance"}:
        return None
    if unit and not _is_convertible(unit, "N"):
        return None
    if "load" in concepts or {"normal", "force"} <= concepts:
        return Meaning("load", question=_question_on_reading(concepts))
    if "force" in concepts:
        return Meaning("load", question="it may be the load or the traction force")
    return None


def _time_rule(concepts: frozenset[str], unit: str) -> Meaning | None:
    if "time" not in concepts or (unit and not _is_convertible(unit, "s")):
        return None
    if concepts & {"contact", "load", "other_time"}:
        return Meaning("time", question="it may be another time than that of the reading")
    return Meaning("time")


# Function of the concepts of a name and of its unit that gives a meaning; None where the name means
# something else.
_Rule = Callable[[frozenset[str], str], Meaning | None]
# The first rule that gives a meaning counts.
_RULES: tuple[_Rule, ...] = (
    _coefficient_rule,
    _traction_rule,
    _temperature_rule,
    _pressure_rule,
    _slip_rule,
    _speed_rule,
    _load_rule,
    _time_rule,
)


# Ranks of meanings: words come before symbols, and symbols before open meanings. Definitions and
# locations of temperatures add small steps.
RANK_OF_WORDS, _RANK_OF_SYMBOL, RANK_OF_OPEN_MEANING = 10, 50, 100
# Locations of temperatures, in the order in which they are preferred.
_LOCATIONS = ("inlet", "bath", "oil", "")


def rank_of(meaning: Meaning) -> int:
    """Rank of a meaning: the column with the smallest rank is taken."""
    if meaning.question:
        return RANK_OF_OPEN_MEANING
    rank = _RANK_OF_SYMBOL if meaning.is_symbol else RANK_OF_WORDS
    definitions = DEFINITIONS_OF_QUANTITY.get(meaning.quantity, ("",))
    if meaning.definition in definitions:
        rank += definitions.index(meaning.definition)
    if meaning.quantity == "inlet_temperature":
        rank += _LOCATIONS.index(meaning.location)
    return rank


def is_of_another_definition(meaning: Meaning) -> bool:
    """Whether numbers of this meaning must be converted to the definition of the project."""
    definitions = DEFINITIONS_OF_QUANTITY.get(meaning.quantity, ())
    return bool(meaning.definition) and meaning.definition != definitions[0]


def quantity_in_logs(quantity: str) -> str:
    """The quantity as logs name it: the load may be stated as a pressure."""
    return "load" if quantity == "max_hertz_pressure" else quantity


# ---------------------------------------------------------------- as a vocabulary


@dataclass(frozen=True)
class WordVocabulary(Vocabulary):
    """A vocabulary that understands names by their words, too.

    Readers find the line of names and the row of units with it. It does not decide which column is
    taken.

    Attributes:
        stated_meaning_of_name: Name of a column -> its meaning, as the user says.
    """

    stated_meaning_of_name: Mapping[str, Meaning] = field(default_factory=dict)

    def quantity_and_unit(self, name: str) -> QuantityAndUnit | None:
        """See `Vocabulary.quantity_and_unit`."""
        quantity_and_unit = super().quantity_and_unit(name)
        if quantity_and_unit is not None:
            return quantity_and_unit
        meaning = meaning_of(name)
        for key in (name, split_bracketed_unit(name)[0], split_unit(name)[0]):
            meaning = self.stated_meaning_of_name.get(key, meaning)
        if meaning is None:
            return None
        quantity = quantity_in_logs(meaning.quantity)
        return (
            QuantityAndUnit(quantity, meaning.unit) if quantity in self.units_of_quantity else None
        )
