"""What the header lines of a log mean, in any language.

A key of the project is the one that oilfilm uses itself, as `load_n`. A logged key is that of the
log.

Decides: how a header line (`# key: value`) becomes a set point, an oil or a rig, with its unit, in
any language.
"""

import re
from collections.abc import Iterable, Mapping
from difflib import SequenceMatcher
from functools import lru_cache

from oilfilm.base.plain_key import plain_key
from oilfilm.base.units import Conversion, possible_conversion
from oilfilm.logs.base import (
    LARGEST_READING,
    LOAD_KEYS,
    QUANTITY_AND_UNIT_OF_SET_POINT,
    Refusal,
    is_in_set_point_range,
    parse_decimal,
    set_point_range_in_words,
)
from oilfilm.settings.resolved import Settings

FORMAT_ADVICE = "data/raw/README.md describes the format."

# Chinese input methods write full-width characters in place of these.
FULL_WIDTH_TO_ASCII = str.maketrans("\uff1a\uff1d\uff08\uff09\uff3b\uff3d", ":=()[]")
# Text of a unit as `plain_key` leaves it -> the unit.
UNIT_BY_PLAIN_KEY = {
    "gpa": "GPa",
    "mpa": "MPa",
    "pa": "Pa",
    "n": "N",
    "dan": "daN",
    "kn": "kN",
    "gf": "gf",
    "kgf": "kgf",
    "lbf": "lbf",
    "k": "K",
    "m_s": "m/s",
    "m/s": "m/s",
    "mm_s": "mm/s",
    "mm/s": "mm/s",
    "c": "degC",
    "degc": "degC",
    "\N{DEGREE SIGN}c": "degC",
    "f": "degF",
    "degf": "degF",
    "\N{DEGREE SIGN}f": "degF",
}
# A number whose only mark may be a decimal mark or one between thousands, as 1.250.
_NUMBER_WITH_ONE_GROUP = re.compile(r"[1-9]\d{0,2}[.,]\d{3}")
# No test is hotter or faster. A mark that would make a larger number is none between thousands.
_LARGEST_LIKELY_SET_POINT = {"inlet_temperature_c": 1000.0, "entrainment_speed_m_s": 1000.0}
# A decimal mark may be the last sign of a number, as in `80. N`.
_NUMBER_AND_UNIT = re.compile(r"([-+.,\d]*\d[.,]?(?:[eE][-+]?\d+)?)\s*(.*)")
# Two words with a larger similarity (ratio of `difflib`) are one word that is misspelt: less than
# one letter of four is changed.
_SIMILARITY_OF_MISSPELLING = 0.75
# Shorter names are similar to too many words.
_SHORTEST_NAME_COMPARED = 6
# Words for an oil in the key of a header line or in its name, and words that may be beside them.
WORDS_FOR_OIL = frozenset(
    "oil lubricant lube fluid grease öl oel prüföl schmierstoff huile lubrifiant aceite lubricante "
    "olio lubrificante масло 油 油样 油品 润滑油 试验油 潤滑油 試験油 윤활유".split()
)
_WORDS_BESIDE_OIL = frozenset("name id type test tested code no number".split())


def split_bracketed_unit(name: str) -> tuple[str, str]:
    """A name without the unit in brackets at its end, and that unit; empty where there is none.

    Examples:
        >>> split_bracketed_unit("load [N]")
        ('load', 'N')
        >>> split_bracketed_unit("load")
        ('load', '')
    """
    # no regular expression: a name with very many brackets would take hours
    if not name.isascii():
        name = name.translate(FULL_WIDTH_TO_ASCII)
    if not name.endswith(("]", ")")):
        return name, ""
    after_earlier_brackets = 1 + max(name.rfind("]", 0, -1), name.rfind(")", 0, -1))
    opening_brackets = [name.find(bracket, after_earlier_brackets) for bracket in "[("]
    opening_brackets = [opening for opening in opening_brackets if opening >= 0]
    if not opening_brackets:
        return name, ""
    opening = min(opening_brackets)
    return name[:opening].rstrip(" \t_"), name[opening + 1 : -1]


def project_header(
    text_of_logged_key: Mapping[str, str], settings: Settings, decimal_mark: str = "."
) -> dict[str, str]:
    """Key of the project -> text, from header lines: set points in its units, the oil by its id.

    A line such as `lubricant` names the oil where no line `oil` does. Where both name oils of the
    campaign, and different ones, both are given. An empty line names no oil and no rig.

    Two lines with the same meaning and different values give both values. Such a text is neither
    a number nor an oil, and the log is refused.

    Args:
        text_of_logged_key: Key of the log, as `plain_key` makes it -> text of the line.
        settings: Settings with the names of keys under `header` and the aliases of oils.
        decimal_mark: Decimal mark of the log.
    """
    key_by_name = key_by_listed_name(settings)
    keys_and_texts: list[tuple[str, str]] = []
    for logged_key, text in text_of_logged_key.items():
        key, project_text = project_key_and_text(logged_key, text, key_by_name, decimal_mark)
        if key == "oil":
            project_text = oil_id(project_text, settings)
        keys_and_texts.append((key, project_text))
    text_of_key = joined_texts(
        (key, text) for key, text in keys_and_texts if text or key not in ("oil", "rig")
    )
    oil_texts = [
        oil_id(text, settings) for key, text in text_of_key.items() if oil_synonym_key({key: text})
    ]
    if oil_texts:
        stated_oil = text_of_key.get("oil", oil_texts[0])
        # other texts describe the oil: `oil_type: mineral`
        known_oils = set(settings.oil_id_by_name.values())
        other_oils = [text for text in dict.fromkeys(oil_texts) if text in known_oils]
        text_of_key["oil"] = " / ".join(dict.fromkeys([stated_oil, *other_oils]))
    return text_of_key


def joined_texts(keys_and_texts: Iterable[tuple[str, str]]) -> dict[str, str]:
    """Key -> text. Different texts of one key are joined: what needs this key refuses the log.

    Examples:
        >>> joined_texts([("oil", "4102"), ("rig", ""), ("oil", "4050"), ("rig", "mtm")])
        {'oil': '4102 / 4050', 'rig': 'mtm'}
    """
    texts_of_key: dict[str, dict[str, None]] = {}
    for key, text in keys_and_texts:
        texts_of_key.setdefault(key, {})[text] = None
    return {key: " / ".join(filter(None, texts)) for key, texts in texts_of_key.items()}


def header_of_part(
    text_of_file_key: Mapping[str, str], text_of_own_key: Mapping[str, str]
) -> dict[str, str]:
    """Header key -> text for a part of a file: the header of the file, then its own header lines.

    The oil of the part replaces that of the file, whatever the lines are called; only names that
    the campaign file lists are not known here. An empty line of the part replaces nothing.

    Args:
        text_of_file_key: Header key of the file -> its text.
        text_of_own_key: Header key of the part itself -> its text.
    """
    text_of_key = dict(text_of_file_key)
    if states_oil(text_of_own_key):
        text_of_key = {
            key: text for key, text in text_of_key.items() if not states_oil({key: text})
        }
    own_texts = {
        key: text for key, text in text_of_own_key.items() if text or key not in text_of_key
    }
    return text_of_key | own_texts


def key_by_listed_name(settings: Settings) -> dict[str, str]:
    """Name of a header line, listed under `header` of the campaign file -> key of the project."""
    key_by_name: dict[str, str] = {}
    for key, names in settings.campaign.header.items():
        for name in names:
            key_by_name[plain_key(name)] = key
    return key_by_name


def with_default_rig_and_oil(
    text_of_project_key: Mapping[str, str], settings: Settings
) -> dict[str, str]:
    """Key of the project -> text. A campaign with one rig, or one oil, needs no line for it."""
    text_of_key = dict(text_of_project_key)
    if len(settings.rigs) == 1:
        text_of_key.setdefault("rig", next(iter(settings.rigs)))
    if len(settings.oils) == 1:
        text_of_key.setdefault("oil", next(iter(settings.oils)))
    return text_of_key


def project_key_and_text(
    logged_key: str, text: str, key_by_name: Mapping[str, str], decimal_mark: str = "."
) -> tuple[str, str]:
    """Key of the project and text of a header line; the number of a set point in the key's unit.

    A number that can be read in two ways keeps its unit, so that it is no set point.

    Args:
        logged_key: The key of the log, as `plain_key` makes it.
        text: The text of the line.
        key_by_name: As `key_by_listed_name` gives them.
        decimal_mark: Decimal mark of the log or sheet; empty where it is not known.
    """
    set_point_key, unit_of_key = _set_point_key_and_unit(logged_key, key_by_name)
    number_text, unit_of_text = number_and_unit(text)
    unit = unit_of_text or unit_of_key
    # the load has one set point, as force or as pressure
    if set_point_key == "load_n" and conversion_to_set_point("max_hertz_pressure_gpa", unit):
        set_point_key = "max_hertz_pressure_gpa"
    # without a unit `load` may be anything
    if not unit_of_key and not conversion_to_set_point(set_point_key, unit_of_text):
        bare_key, _ = split_bracketed_unit(logged_key)
        key = key_by_name.get(logged_key) or key_by_name.get(bare_key) or logged_key
        return key, text
    try:
        value = parse_decimal(number_text)
    except ValueError:
        return set_point_key, text
    conversion = conversion_to_set_point(set_point_key, unit)
    is_ambiguous = not decimal_mark or decimal_mark not in number_text
    if conversion is None or (
        is_ambiguous and _two_possible_numbers(set_point_key, number_text, conversion)
    ):
        return set_point_key, text if unit_of_text else f"{text} {unit_of_key}"
    if text == number_text and "," not in text and conversion.scale == 1 and conversion.offset == 0:
        return set_point_key, text
    # rounded: the error of a conversion would make two values of 80 N and 0.08 kN
    return set_point_key, f"{conversion.scale * value + conversion.offset:.12g}"


def _set_point_key_and_unit(logged_key: str, key_by_name: Mapping[str, str]) -> tuple[str, str]:
    """Key of the set point and unit that the key of a header line gives; both empty without one.

    The unit is in brackets or in the key. A name that the campaign file lists, and the key of the
    project, are in the unit of the key.
    """
    bare_key, text_in_brackets = split_bracketed_unit(logged_key)
    # `plain_key` makes underscores of the blanks in `[ m / s ]`
    text_in_brackets = text_in_brackets.strip("_").replace("_/_", "/")
    unit_in_brackets = UNIT_BY_PLAIN_KEY.get(text_in_brackets, text_in_brackets)
    for set_point_key, (quantity, set_point_unit) in QUANTITY_AND_UNIT_OF_SET_POINT.items():
        if set_point_key in (logged_key, key_by_name.get(logged_key)):
            # brackets may be a part of a name that the campaign file lists
            return set_point_key, unit_in_brackets if unit_in_brackets and conversion_to_set_point(
                set_point_key, unit_in_brackets
            ) else set_point_unit
        if set_point_key in (bare_key, key_by_name.get(bare_key)):
            return set_point_key, unit_in_brackets or set_point_unit
        if logged_key.startswith(f"{quantity}_"):
            unit_in_key = logged_key.removeprefix(f"{quantity}_")
            if unit_in_key in UNIT_BY_PLAIN_KEY and conversion_to_set_point(
                set_point_key, unit_in_key
            ):
                return set_point_key, UNIT_BY_PLAIN_KEY[unit_in_key]
        if bare_key == quantity:
            return set_point_key, unit_in_brackets
    return "", ""


def _two_possible_numbers(
    set_point_key: str, number_text: str, conversion: Conversion
) -> tuple[float, float] | None:
    """A number with its mark between thousands, and with a decimal mark; None where only one fits.

    Args:
        set_point_key: Key of a set point.
        number_text: The number.
        conversion: The conversion of its unit to that of the set point.
    """
    if not _NUMBER_WITH_ONE_GROUP.fullmatch(number_text):
        return None
    grouped_number = float(number_text.replace(",", "").replace(".", ""))
    set_point = conversion.scale * grouped_number + conversion.offset
    largest_likely = _LARGEST_LIKELY_SET_POINT.get(set_point_key, LARGEST_READING)
    if set_point > largest_likely or not is_in_set_point_range(set_point_key, set_point):
        return None
    return grouped_number, parse_decimal(number_text)


def expectation_in_words(set_point_key: str, text: str) -> str:
    """What is expected in place of a text that gives no set point, in words for a message.

    Args:
        set_point_key: Key of the set point.
        text: The text, as `project_key_and_text` gives it.
    """
    number_text, unit = number_and_unit(text)
    conversion = conversion_to_set_point(set_point_key, unit)
    numbers = _two_possible_numbers(set_point_key, number_text, conversion) if conversion else None
    if numbers is None:
        return set_point_range_in_words(set_point_key)
    with_group, with_decimals = numbers
    return (
        f"{with_group:.12g} or {with_decimals:.12g} (in {unit}), without a mark between thousands: "
        "it may be either number"
    )


def conversion_to_set_point(set_point_key: str, unit: str) -> Conversion | None:
    """The conversion of a unit, in any spelling, to that of a set point; None where none exists."""
    unit = UNIT_BY_PLAIN_KEY.get(plain_key(unit), unit)
    if not set_point_key or not unit:
        return None
    _, set_point_unit = QUANTITY_AND_UNIT_OF_SET_POINT[set_point_key]
    return possible_conversion(unit, (set_point_unit,))


def number_and_unit(text: str) -> tuple[str, str]:
    """The number that a text begins with and the text after it; both empty without a number."""
    match = _NUMBER_AND_UNIT.fullmatch(text)
    return (match[1], match[2]) if match else ("", "")


def oil_id(text: str, settings: Settings) -> str:
    """The id of an oil by any of its names; a text that names no oil stays as it is.

    Values of several header lines, joined by ` / `, become one id where all name the same oil.
    """
    id_by_name = settings.oil_id_by_name
    if plain_key(text) in id_by_name:
        return id_by_name[plain_key(text)]
    oil_ids = [id_by_name.get(plain_key(name), name) for name in text.split(" / ")]
    return " / ".join(dict.fromkeys(oil_ids))


def oil_synonym_key(text_of_key: Mapping[str, str]) -> str | None:
    """The key of a header line that names the oil, other than `oil`; None without one."""
    for key, text in text_of_key.items():
        words = frozenset(key.split("_")) - _WORDS_BESIDE_OIL
        if key != "oil" and text and len(words) == 1 and words <= WORDS_FOR_OIL:
            return key
    return None


def states_oil(text_of_key: Mapping[str, str]) -> bool:
    """Whether a header line names the oil, as `oil` or by another word; an empty one does not."""
    return bool(text_of_key.get("oil")) or oil_synonym_key(text_of_key) is not None


def misspelt_key_problem(text_of_key: Mapping[str, str], settings: Settings) -> Refusal | None:
    """The refusal of a key like that of a set point, or of the oil, that has no value.

    Such a key is probably misspelt. Values come from the log or the campaign file. The only oil of
    a campaign may be one that the log does not name.
    """
    keys_with_value = set(text_of_key) | set(
        settings.campaign.set_points.model_dump(exclude_none=True)
    )
    # the load has one set point, as force or as pressure
    if keys_with_value & LOAD_KEYS:
        keys_with_value |= LOAD_KEYS
    if len(settings.oils) == 1:
        keys_with_value.discard("oil")
    key_by_name: dict[str, str] = {}
    for key, (quantity, _) in QUANTITY_AND_UNIT_OF_SET_POINT.items():
        key_by_name[key] = key
        key_by_name[quantity] = key
    for name, key in key_by_listed_name(settings).items():
        if key == "oil" or key in QUANTITY_AND_UNIT_OF_SET_POINT:
            key_by_name[name] = key
    for name, key in key_by_name.items():
        if key in keys_with_value:
            continue
        for logged_key, text in text_of_key.items():
            lacks_unit = logged_key == name and number_and_unit(text)[0] != ""
            bare_key, _ = split_bracketed_unit(logged_key)
            if lacks_unit or _is_misspelling(bare_key, name):
                return _unknown_key_problem(logged_key, key if lacks_unit else name)
    return None


def _unknown_key_problem(logged_key: str, meant_key: str) -> Refusal:
    return Refusal(
        "unknown_header_key",
        f"the header has the unknown key {logged_key[:60]!r}; did you mean {meant_key!r}?",
        f"Correct the header, or list the key under `header` of the campaign file. {FORMAT_ADVICE}",
    )


@lru_cache(maxsize=4096)
def _is_misspelling(written: str, meant: str) -> bool:
    """Whether a name has as many words as the meant one, each similar to its counterpart.

    A short name is no misspelling of another.

    Examples:
        >>> _is_misspelling("entrainement_speed_m_s", "entrainment_speed_m_s")
        True
        >>> _is_misspelling("outlet_temperature_c", "inlet_temperature_c")
        False
    """
    written_words = written.split("_")
    meant_words = meant.split("_")
    if (
        written == meant
        or len(meant) < _SHORTEST_NAME_COMPARED
        or len(written_words) != len(meant_words)
    ):
        return False
    return all(
        SequenceMatcher(None, word, meant_word).ratio() > _SIMILARITY_OF_MISSPELLING
        for word, meant_word in zip(written_words, meant_words, strict=True)
    )


def unknown_name_problem(
    key: str, text_of_key: Mapping[str, str], names: Iterable[str]
) -> Refusal | None:
    """Why the oil or the rig in a log's header cannot be used; None where it can.

    Args:
        key: `oil` or `rig`.
        text_of_key: Header keys of the log.
        names: The oils or rigs of the campaign.
    """
    names_in_words = ", ".join(names)
    if key not in text_of_key:
        return Refusal(
            "header",
            f"the header has no line `# {key}: ...` and no property `{key}`; the campaign has "
            f"several: {names_in_words}",
            f"Add it, name the {key} in the run sheet, or list the log's own key under "
            f"`header: {key}` of the campaign file. {FORMAT_ADVICE}",
        )
    if text_of_key[key] in names:
        return None
    advice_on_alias = ", list the name under `oil_aliases`" if key == "oil" else ""
    return Refusal(
        f"unknown_{key}",
        f"the header says {key} {text_of_key[key][:60]!r}; the campaign knows {names_in_words}",
        f"Correct the header{advice_on_alias} or add the {key} to the campaign file.",
    )


def says_simulated(text_of_key: Mapping[str, str]) -> bool:
    """Whether a header line `simulated` says anything but `no`."""
    return text_of_key.get("simulated", "no").casefold() != "no"


def simulation_problem(text_of_key: Mapping[str, str], settings: Settings) -> Refusal | None:
    """Why a simulated log cannot be used in a campaign of measured logs; None where it can."""
    if not says_simulated(text_of_key) or settings.campaign.data != "measured":
        return None
    return Refusal(
        "simulated_log",
        f"the header says simulated: {text_of_key['simulated'][:60]!r}, which is not 'no'; the "
        "campaign file says data: measured",
        "Take the log out, or say data: simulated in the campaign file.",
    )
