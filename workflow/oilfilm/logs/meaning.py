"""What the name of a column means: quantity, definition, unit, and how each is known.

A name says what a column is by its words, in eight languages (`words.yaml`). Some names leave open
which of several definitions they mean: "Hertz pressure" may be the maximum or the mean. Such a
meaning is asked, never assumed. The numbers of other columns may answer it (`table_columns.py`).

Decides: which words of a name make a quantity and its definition, and when a meaning is asked.
"""

import re
import unicodedata
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path

import yaml

from oilfilm.base.plain_key import plain_key
from oilfilm.base.units import possible_conversion
from oilfilm.logs.header import split_unit
from oilfilm.logs.log_kind import Vocabulary

# Quantity -> the unit in which it is used here.
UNIT_OF = {
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
DEFINITIONS = {
    "max_hertz_pressure": ("maximum", "mean"),
    "entrainment_speed": ("mean", "sum"),
    "slide_roll_ratio": ("over_mean", "over_sum", "over_faster", "sliding_speed"),
}
# What a definition says, for a person.
DEFINITION_WORDS = {
    "maximum": "the maximum Hertz pressure",
    "mean": "the mean",
    "sum": "the sum of both surface speeds",
    "over_mean": "the sliding speed over the mean of both surface speeds",
    "over_sum": "the sliding speed over the sum of both surface speeds",
    "over_faster": "the sliding speed over that of the faster body",
    "sliding_speed": "the sliding speed, the difference of both surface speeds",
}
# Names that are symbols of papers, as they are written there -> quantity and definition.
_SYMBOLS = {
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
_MEANING_OF_SYMBOL = {
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
_SEVERAL_SPEEDS = re.compile(r"u_?1\s*([+-])\s*u_?2|u_?2\s*(-)\s*u_?1", re.IGNORECASE)
_WORD = re.compile(r"[^\W\d_]+")
_CAMEL_CASE = re.compile(r"(?<=[a-zß-ÿ])(?=[A-Z])")
# A unit in a name without brackets is written like this. A single letter may be a symbol.
_SHORTEST_UNIT = 2


@dataclass(frozen=True)
class Meaning:
    """What the name of a column means.

    Attributes:
        quantity: A key of `UNIT_OF`.
        definition: One of `DEFINITIONS`; empty where the quantity has one definition alone, or
            where the name does not say it.
        unit: Unit that the name states; empty where it states none.
        question: What the name leaves open, as a sentence; empty where it leaves nothing open.
        is_symbol: Whether the name is a symbol: a column with words for the quantity comes first.
        place: Of a temperature: `inlet`, `bath`, `oil` or empty.
    """

    quantity: str
    definition: str = ""
    unit: str = ""
    question: str = ""
    is_symbol: bool = False
    place: str = ""


@cache
def _words() -> dict[str, tuple[str, ...]]:
    """What a word says -> the words."""
    text = Path(__file__).with_name("words.yaml").read_text(encoding="utf-8")
    entries = yaml.safe_load(text).items()
    return {said: tuple(str(words).casefold().split()) for said, words in entries}


@cache
def _by_form() -> tuple[dict[str, set[str]], list[tuple[str, str]], list[tuple[str, str]]]:
    """Words that count alone, parts of words, and Chinese and Japanese words, the longest first."""
    alone: dict[str, set[str]] = {}
    parts: list[tuple[str, str]] = []
    anywhere: list[tuple[str, str]] = []
    for said, words in _words().items():
        if said.startswith("label_"):
            continue
        for word in words:
            if _is_cjk(word):
                anywhere.append((word, said))
            elif word.startswith("-") or word.endswith("-"):
                parts.append((word, said))
            else:
                alone.setdefault(word, set()).add(said)
    anywhere.sort(key=lambda entry: -len(entry[0]))
    return alone, parts, anywhere


def _is_cjk(text: str) -> bool:
    return any("\u3040" <= letter <= "\u9fff" for letter in text)


def sayings(name: str) -> frozenset[str]:
    """What the words of a name say: the keys of `words.yaml` of which it has a word.

    Examples:
        >>> sorted(sayings("Reibungskraft"))
        ['force', 'friction']
        >>> sorted(sayings("coil temp"))
        ['elsewhere', 'temperature']
    """
    # `BallSpeed` is two words, `CoF` is one
    both = f"{name} {_CAMEL_CASE.sub(' ', name)}"
    plain = unicodedata.normalize("NFKC", both).casefold()
    alone, parts, anywhere = _by_form()
    found: set[str] = set()
    rest = plain
    for word, said in anywhere:
        if word in rest:
            found.add(said)
            # the same letters may say two things; a shorter word inside them says nothing
            same_letters = {other for letters, other in anywhere if letters == word}
            found |= same_letters
            rest = rest.replace(word, " ")
    for token in _WORD.findall(rest.replace("-", " ")):
        found |= alone.get(token, set())
        for part, said in parts:
            if _has_part(token, part):
                found.add(said)
    return frozenset(found)


def _has_part(token: str, part: str) -> bool:
    """Whether a word begins with `part-`, ends with `-part` or has `-part-` in it."""
    letters = part.strip("-")
    if part.startswith("-") and part.endswith("-"):
        return letters in token
    return token.startswith(letters) if part.endswith("-") else token.endswith(letters)


def label_of(name: str) -> str:
    """`oil` or `curve` where the name of a column of text says so; else empty."""
    said = sayings(name)
    if said & {"temperature", "time", "speed", "pressure", "friction"}:
        return ""
    plain = unicodedata.normalize("NFKC", name).casefold()
    tokens = set(_WORD.findall(plain))
    for label in ("oil", "curve"):
        for word in _words()[f"label_{label}"]:
            if word in tokens or (_is_cjk(word) and word in plain):
                return label
    return ""


# ---------------------------------------------------------------- units


def _is_in(unit: str, quantity_unit: str) -> bool:
    return possible_conversion(unit, (quantity_unit,)) is not None


def is_unit_of(unit: str, quantity: str) -> bool:
    """Whether a quantity, in one of its definitions, can have a unit."""
    units = [UNIT_OF[quantity]]
    if quantity in ("ball_speed", "disc_speed"):
        units.append("rpm")
    if quantity == "slide_roll_ratio":
        units.append("m/s")
    return any(_is_in(unit, each) for each in units)


def stated_unit(name: str) -> tuple[str, str]:
    """A name without its unit, and the unit: in brackets, after a slash or comma, or at an end.

    Examples:
        >>> stated_unit("Speed / mm s-1")
        ('Speed', 'mm s-1')
        >>> stated_unit("speed_m_s")
        ('speed', 'm/s')
        >>> stated_unit("Temp °C")
        ('Temp', '°C')
    """
    bare, unit = split_unit(name.strip())
    if unit:
        return bare, unit
    for separator in (" / ", " in ", ", "):
        before, found, after = bare.rpartition(separator)
        if found and _is_any_unit(after.strip()):
            return before.strip(), after.strip()
    if bare.endswith("%"):
        return bare[:-1].strip(), "%"
    plain = plain_key(bare)
    for ending, unit in _UNITS_IN_KEYS.items():
        if plain.endswith(f"_{ending}") and " " not in bare.strip():
            return bare[: -len(ending) - 1], unit
    words = bare.split()
    if len(words) > 1 and words[-1] == "N":
        return " ".join(words[:-1]), "N"
    for count in (2, 1):
        last = " ".join(words[-count:])
        if len(words) > count and len(last) >= _SHORTEST_UNIT and _is_any_unit(last):
            return " ".join(words[:-count]), last
    if len(words) > 1 and len(words[0]) > _SHORTEST_UNIT and _is_any_unit(words[0]):
        return " ".join(words[1:]), words[0]
    return bare, ""


# Ends of names that are written like keys, as `speed_m_s`.
_UNITS_IN_KEYS = {
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
    return any(is_unit_of(text, quantity) for quantity in UNIT_OF)


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
    bare, unit_of_name = stated_unit(name)
    unit = unit_beside or unit_of_name
    # `F_n` is a symbol, not F in newtons
    symbol = _SYMBOLS.get(name.strip()) or _SYMBOLS.get(bare.strip())
    if name.strip() in _SYMBOLS:
        unit = unit_beside
    if symbol is not None:
        return _of_symbol(symbol, unit)
    said = sayings(bare)
    if may_be_set_point:
        said -= {"set"}
    if said & {"set", "error", "count", "other"}:
        return None
    sums = _SEVERAL_SPEEDS.search(name)
    if sums is not None:
        said |= {"sum" if sums[1] == "+" else "difference", "speed"}
    for rule in _RULES:
        found = rule(said, unit)
        if found is not None:
            return replace(found, unit=unit)
    return None


def _of_symbol(symbol: str, unit: str) -> Meaning | None:
    """The meaning of a symbol; None where its unit contradicts it."""
    quantity, definition = _MEANING_OF_SYMBOL[symbol]
    if unit and not is_unit_of(unit, quantity):
        return None
    return Meaning(quantity, definition, unit, is_symbol=True)


def _coefficient(said: frozenset[str], unit: str) -> Meaning | None:
    if said & {"speed", "temperature", "pressure", "time", "torque"}:
        return None
    if "cof" in said or {"friction", "coefficient"} <= said:
        if unit and not _is_in(unit, "1"):
            return None
        return Meaning("traction_coefficient")
    return None


def _traction(said: frozenset[str], unit: str) -> Meaning | None:
    if "friction" not in said or said & {"speed", "temperature", "time", "distance", "coefficient"}:
        return None
    if "torque" in said or (unit and _is_in(unit, "N m")):
        return Meaning("traction_torque")
    if unit and _is_in(unit, "N"):
        return Meaning("traction_force")
    if unit and _is_in(unit, "1"):
        return Meaning("traction_coefficient")
    if unit:
        return None
    if "force" in said:
        return Meaning("traction_force")
    question = "it may be the coefficient, the force or the torque"
    return Meaning("traction_coefficient", question=question)


def _temperature(said: frozenset[str], unit: str) -> Meaning | None:
    in_degrees = bool(unit) and _is_in(unit, "degC")
    if "temperature" not in said and not (in_degrees and said & {"inlet", "bath", "oil"}):
        return None
    if said & {"elsewhere", "ball", "disc", "difference", "max"}:
        return None
    if unit and not in_degrees:
        return None
    if said & {"film", "contact"}:
        question = "it is that of film or contact; the law needs that of the oil supplied"
        return Meaning("inlet_temperature", question=question)
    place = next((each for each in ("inlet", "bath", "oil") if each in said), "")
    return Meaning("inlet_temperature", place=place)


_WHICH_PRESSURE = "it may be the maximum or the mean Hertz pressure"


def _pressure(said: frozenset[str], unit: str) -> Meaning | None:
    is_pressure = bool(said & {"pressure", "stress"}) or "hertz" in said
    if not is_pressure or said & {"friction", "temperature", "speed", "time"}:
        return None
    if unit and not _is_in(unit, "GPa"):
        return None
    if not said & {"hertz", "contact", "max", "mean"} or said & {"oil", "elsewhere", "inlet"}:
        if said & {"oil", "elsewhere", "inlet", "bath"} or "stress" in said:
            return None
        return Meaning("max_hertz_pressure", question=f"{_WHICH_PRESSURE}, or another pressure")
    if "max" in said:
        return Meaning("max_hertz_pressure", "maximum")
    if "mean" in said:
        return Meaning("max_hertz_pressure", "mean")
    return Meaning("max_hertz_pressure", question=_WHICH_PRESSURE)


def _slip(said: frozenset[str], unit: str) -> Meaning | None:
    if said & {"temperature", "time", "distance", "force", "friction"}:
        return None
    in_speed = bool(unit) and _is_in(unit, "m/s")
    is_ratio = bool(unit) and _is_in(unit, "1")
    is_over_mean = "rolling" in said and "ratio" in said and bool(said & {"sliding", "slip"})
    if "srr" in said or is_over_mean:
        return None if in_speed else Meaning("slide_roll_ratio", "over_mean")
    speaks_of_slip = bool(said & {"slip", "sliding"})
    is_difference = "difference" in said and bool(said & {"speed", "rolling"})
    if (speaks_of_slip and ("speed" in said or in_speed)) or is_difference:
        if is_ratio or (unit and not in_speed):
            return None
        return Meaning("slide_roll_ratio", "sliding_speed")
    if "slip" in said or ("sliding" in said and ("ratio" in said or is_ratio)):
        question = "it may be over the mean, over the sum or over the speed of the faster body"
        return Meaning("slide_roll_ratio", question=question)
    if "sliding" in said and not unit:
        return Meaning("slide_roll_ratio", question="it may be a ratio or a sliding speed")
    return None


def _speed(said: frozenset[str], unit: str) -> Meaning | None:
    in_speed = bool(unit) and (_is_in(unit, "m/s") or _is_in(unit, "rpm"))
    if said & {"temperature", "time", "force", "pressure", "torque", "friction", "elsewhere"}:
        return None
    if "speed" not in said and not in_speed and not ("entrainment" in said and not unit):
        return None
    if unit and not in_speed:
        return None
    if {"ball", "disc"} <= said:
        return None
    for body in ("ball", "disc"):
        if body in said:
            return Meaning(f"{body}_speed")
    if unit and not _is_in(unit, "m/s"):
        return None
    if "sum" in said:
        return Meaning("entrainment_speed", "sum")
    if said & {"entrainment", "rolling", "mean"}:
        return Meaning("entrainment_speed", "mean")
    if "speed" in said:
        question = "it may be the speed of ball or disc, or their mean"
        return Meaning("entrainment_speed", question=question)
    return None


def _load(said: frozenset[str], unit: str) -> Meaning | None:
    if said & {"temperature", "speed", "time", "friction", "torque", "distance"}:
        return None
    if unit and not _is_in(unit, "N"):
        return None
    if "load" in said or {"normal", "force"} <= said:
        return Meaning("load")
    if "force" in said:
        return Meaning("load", question="it may be the load or the traction force")
    return None


def _time(said: frozenset[str], unit: str) -> Meaning | None:
    if "time" not in said or (unit and not _is_in(unit, "s")):
        return None
    return Meaning("time")


_Rule = Callable[[frozenset[str], str], Meaning | None]
# In this order: the first that knows the name counts.
_RULES: tuple[_Rule, ...] = (
    _coefficient,
    _traction,
    _temperature,
    _pressure,
    _slip,
    _speed,
    _load,
    _time,
)


# Ranks of meanings: words, then symbols, then what is open. Definitions and places are between.
_RANK_OF_WORDS, _RANK_OF_SYMBOL, RANK_OF_OPEN = 10, 50, 100
# The place of a temperature that is taken before others.
_PLACES = ("inlet", "bath", "oil", "")


def rank_of(meaning: Meaning) -> int:
    """The smaller, the sooner a column with this meaning is taken."""
    if meaning.question:
        return RANK_OF_OPEN
    rank = _RANK_OF_SYMBOL if meaning.is_symbol else _RANK_OF_WORDS
    definitions = DEFINITIONS.get(meaning.quantity, ("",))
    if meaning.definition in definitions:
        rank += definitions.index(meaning.definition)
    if meaning.quantity == "inlet_temperature":
        rank += _PLACES.index(meaning.place)
    return rank


def is_of_another_definition(meaning: Meaning) -> bool:
    """Whether numbers of this meaning must be converted to the definition of the project."""
    definitions = DEFINITIONS.get(meaning.quantity, ())
    return bool(meaning.definition) and meaning.definition != definitions[0]


def quantity_of_logs(quantity: str) -> str:
    """The quantity as logs name it: the load may be stated as a pressure."""
    return "load" if quantity == "max_hertz_pressure" else quantity


# ---------------------------------------------------------------- as a vocabulary


@dataclass(frozen=True)
class NamesInWords(Vocabulary):
    """A vocabulary that understands names by their words, too.

    Readers find the line of names and the row of units with it. It does not decide which column is
    taken.

    Attributes:
        stated: What the user says, by name.
    """

    stated: Mapping[str, Meaning] = field(default_factory=dict)

    def meaning(self, name: str) -> tuple[str, str] | None:
        """See `Vocabulary.meaning`."""
        known = super().meaning(name)
        if known is not None:
            return known
        meaning = meaning_of(name)
        for key in (name, split_unit(name)[0], stated_unit(name)[0]):
            meaning = self.stated.get(key, meaning)
        if meaning is None:
            return None
        quantity = quantity_of_logs(meaning.quantity)
        return (quantity, meaning.unit) if quantity in self.quantities else None
