"""What the header lines of a log mean, in whatever language their keys are.

Decides: how a header line (`# key: value`) becomes a set point, an oil or a rig, with its unit, in
any language.
"""

import re
from collections.abc import Iterable, Mapping
from difflib import SequenceMatcher
from functools import lru_cache

from oilfilm.logs.base import LOADS, SET_POINT_UNITS, Refusal, decimal_number
from oilfilm.settings.base import plain_key
from oilfilm.settings.resolved import Settings
from oilfilm.units import Conversion, possible_conversion

FORMAT_ADVICE = "data/raw/README.md describes the format."

# Chinese input methods write the first for the second.
FULL_WIDTH = str.maketrans("\uff1a\uff1d\uff08\uff09\uff3b\uff3d", ":=()[]")
# Units as `plain_key` leaves them.
UNITS = {
    **{unit.lower(): unit for unit in "GPa MPa Pa N daN kN gf kgf lbf K".split()},
    **{"m_s": "m/s", "m/s": "m/s", "mm_s": "mm/s", "mm/s": "mm/s"},
    **dict.fromkeys(("c", "degc", "\N{DEGREE SIGN}c"), "degC"),
    **dict.fromkeys(("f", "degf", "\N{DEGREE SIGN}f"), "degF"),
}
_NUMBER_AND_UNIT = re.compile(r"([-+.,\d]*\d(?:[eE][-+]?\d+)?)\s*(.*)")
# Letters that a word shares with the one that is meant: more than if one of four were changed.
_ALIKE = 0.75
# Shorter names are near to too many words.
_SHORTEST_NAME = 6
# Keys under which logs name their oil, beside words such as `name` and `type`.
_OIL_KEYS = frozenset(
    "oil lubricant lube fluid grease öl oel prüföl schmierstoff huile lubrifiant aceite lubricante "
    "olio lubrificante масло 油 油样 油品 润滑油 试验油 潤滑油 試験油 윤활유".split()
)
_OIL_WORDS = frozenset("name id type test tested code no number".split())


def apart(name: str) -> tuple[str, str]:
    """A name and the unit in brackets at its end; empty where there are none.

    No regular expression: names come out of files, and one of many brackets would take hours.
    """
    name = name.translate(FULL_WIDTH)
    if not name.endswith(("]", ")")):
        return name, ""
    inside = 1 + max(name.rfind(mark, 0, -1) for mark in "])")
    brackets = [name.find(mark, inside) for mark in "[(" if mark in name[inside:]]
    if not brackets:
        return name, ""
    return name[: min(brackets)].rstrip(" \t_"), name[min(brackets) + 1 : -1]


def named_keys(logged: Mapping[str, str], settings: Settings) -> dict[str, str]:
    """Header lines by the project's keys: set points in its units, the oil by its id.

    Two lines with the same meaning and different values give both, which no gate takes.

    Args:
        logged: Header lines by the keys of the log, as `plain_key` makes them.
        settings: Its campaign's `header` lists names of keys, its oils may have aliases.
    """
    names = listed_names(settings)
    keys: dict[str, str] = {}
    for own, written in logged.items():
        key, text = meaning(own, written, names)
        if key == "oil":
            text = oil_id(text, settings)
        keys[key] = text if keys.get(key, text) == text else f"{keys[key]} / {text}"
    if like := oil_key(keys):
        keys.setdefault("oil", oil_id(keys[like], settings))
    return keys


def listed_names(settings: Settings) -> dict[str, str]:
    """The project's key by each name that the campaign file lists under `header`."""
    return {plain_key(name): key for key, own in settings.campaign.header.items() for name in own}


def header_keys(named: Mapping[str, str], settings: Settings) -> dict[str, str]:
    """Header lines by the project's keys; a log of the only oil or rig of a campaign names none."""
    keys = dict(named)
    if len(settings.rigs) == 1:
        keys.setdefault("rig", next(iter(settings.rigs)))
    if len(settings.oils) == 1:
        keys.setdefault("oil", next(iter(settings.oils)))
    return keys


def meaning(own: str, text: str, names: Mapping[str, str]) -> tuple[str, str]:
    """Key of the project and text of a header line; the number of a set point in the key's unit.

    Args:
        own: The key of the log, as `plain_key` makes it.
        text: The text of the line.
        names: As `listed_names` gives them.
    """
    name, unit = _set_point(own, names)
    digits, behind = number_and_unit(text)
    # the load has one set point, as force or as pressure
    if name == "load_n" and to_set_point("max_hertz_pressure_gpa", behind or unit):
        name = "max_hertz_pressure_gpa"
    # without a unit `load` may be anything
    if not (unit or to_set_point(name, behind)):
        return names.get(own, names.get(apart(own)[0], own)), text
    to = to_set_point(name, behind or unit)
    try:
        value = decimal_number(digits)
    except ValueError:
        return name, text
    if to is None:
        return name, text if behind else f"{text} {unit}"
    # with the rounding of a conversion, 80 N and 0.08 kN would be two values
    plain = text == digits and (to.scale, to.offset) == (1, 0)
    return name, text if plain else f"{to.scale * value + to.offset:.12g}"


def _set_point(own: str, names: Mapping[str, str]) -> tuple[str, str]:
    """Set point that a name gives, and its unit: in brackets, in the name, or empty.

    What the campaign lists under a name, and what has the key's own, is in the unit of the key.
    """
    bare, written = apart(own)
    unit = UNITS.get(written, written)
    for key, (quantity, usual) in SET_POINT_UNITS.items():
        tail = own.removeprefix(f"{quantity}_")
        if names.get(own) == key or own == key:
            # brackets may be a part of a name that the campaign file lists
            return key, unit if unit and to_set_point(key, unit) else usual
        if key in (bare, names.get(bare)):
            return key, unit or usual
        if tail != own and tail in UNITS and to_set_point(key, tail):
            return key, UNITS[tail]
        if bare == quantity:
            return key, unit
    return "", ""


def to_set_point(name: str, unit: str) -> Conversion | None:
    """How a unit, in whatever letters, becomes that of a set point; None where it cannot."""
    written = UNITS.get(plain_key(unit), unit)
    return possible_conversion(written, (SET_POINT_UNITS[name][1],)) if name and written else None


def number_and_unit(text: str) -> tuple[str, str]:
    """The digits at the beginning of a text and what is behind them; empty where there are none."""
    match = _NUMBER_AND_UNIT.fullmatch(text)
    return (match[1], match[2]) if match else ("", "")


def oil_id(text: str, settings: Settings) -> str:
    """The id of an oil by any of its names, of several lines joined too; else the text."""
    ids = settings.oil_ids
    named = dict.fromkeys(ids.get(plain_key(part), part) for part in text.split(" / "))
    return ids.get(plain_key(text)) or " / ".join(named)


def oil_key(keys: Mapping[str, str]) -> str | None:
    """The key of a header line that names the oil, though not under `oil`."""
    for key, text in keys.items():
        words = frozenset(key.split("_")) - _OIL_WORDS
        if key != "oil" and text and len(words) == 1 and words <= _OIL_KEYS:
            return key
    return None


def misspelt_key(keys: Mapping[str, str], settings: Settings) -> Refusal | None:
    """A key that nearly is that of a set point which neither the log nor the campaign has."""
    known = keys.keys() | settings.campaign.set_points.model_dump(exclude_none=True).keys()
    # the load has one set point, as force or as pressure
    known = (known | LOADS if known & LOADS else known) - {"oil"}
    names = {word: key for key, (of, _) in SET_POINT_UNITS.items() for word in (key, of)}
    listed = listed_names(settings).items()
    names |= {word: key for word, key in listed if key in ("oil", *SET_POINT_UNITS)}
    for word, name in names.items():
        for key, text in keys.items() if name not in known else ():
            unitless = key == word and number_and_unit(text)[0]
            if unitless or _is_slip_of_the_pen(apart(key)[0], word):
                meant = name if unitless else word
                reason = f"the header has the unknown key {key[:60]!r}; did you mean {meant!r}?"
                advice = "Correct the header, or list the key under `header` of the campaign file."
                return Refusal("unknown_header_key", reason, f"{advice} {FORMAT_ADVICE}")
    return None


@lru_cache(maxsize=4096)
def _is_slip_of_the_pen(written: str, meant: str) -> bool:
    """As many words, each with most letters of the one that is meant; no short name.

    Examples:
        >>> _is_slip_of_the_pen("entrainement_speed_m_s", "entrainment_speed_m_s")
        True
        >>> _is_slip_of_the_pen("outlet_temperature_c", "inlet_temperature_c")
        False
    """
    words = written.split("_"), meant.split("_")
    if written == meant or len(meant) < _SHORTEST_NAME or len(words[0]) != len(words[1]):
        return False
    pairs = zip(*words, strict=True)
    return all(SequenceMatcher(None, *pair).ratio() > _ALIKE for pair in pairs)


def unknown(kind: str, keys: Mapping[str, str], known: Iterable[str]) -> Refusal | None:
    """Why the name of an oil or a rig in a log's header cannot be used."""
    listed = ", ".join(known)
    if kind not in keys:
        return Refusal(
            "header",
            f"the header has no line `# {kind}: ...` and no property `{kind}`; the campaign has "
            f"several: {listed}",
            f"Add it, name the {kind} in the run sheet, or list the log's own key under "
            f"`header: {kind}` of the campaign file. {FORMAT_ADVICE}",
        )
    if keys[kind] in known:
        return None
    alias = ", list the name under `oil_aliases`" if kind == "oil" else ""
    return Refusal(
        f"unknown_{kind}",
        f"the header says {kind} {keys[kind][:60]!r}; the campaign knows {listed}",
        f"Correct the header{alias} or add the {kind} to the campaign file.",
    )


def simulation_problem(keys: Mapping[str, str], settings: Settings) -> Refusal | None:
    """Why a simulated log cannot be used in a campaign of measured ones."""
    if keys.get("simulated", "no") == "no" or settings.campaign.data != "measured":
        return None
    return Refusal(
        "simulated_log",
        "the header says that the log is simulated; the campaign file says data: measured",
        "Take the log out, or say data: simulated in the campaign file.",
    )
