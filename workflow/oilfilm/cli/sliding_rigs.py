"""Logs of rigs that do not roll: pin-on-disc, reciprocating and other sliding rigs.

Decides: when `oilfilm init` says that a rig does not roll.
"""

import re
import unicodedata
from collections.abc import Iterable, Sequence

from oilfilm.logs.likely_names import likely_line_of_names
from oilfilm.logs.meaning import concepts_in
from oilfilm.logs.sniff import VOCABULARY, SniffedLog

# Words in the names of the columns of a rig, in small letters, by its kind. A word of up to four
# letters must be a word of its own. English, German, French, Spanish, Italian, Russian, Chinese,
# Japanese.
_WORDS_BY_RIG_KIND = {
    "a reciprocating rig": (
        "frequency frequenz fréquence frecuencia frequenza частота 频率 周波数 "
        "stroke hub course carrera corsa ход 行程 ストローク amplitude 振幅 oscillat srv hfrr"
    ),
    "a pin-on-disc or another sliding rig": (
        "pin wear verschlei usure desgaste usura износ 磨损 摩耗 laps "
        "sliding gleitweg gleitgeschw glissement deslizamiento strisciamento скольжени 滑动 滑り "
        "cof rotary"
    ),
}
_MAX_LETTERS_OF_WHOLE_WORD = 4
_WORD_PATTERN = re.compile(r"[^\W\d_]+")
_MAX_SHOWN_NAMES = 4
_MAX_SEARCHED_LINES = 200


def why_not_rolling(log: SniffedLog, content: bytes) -> str:
    """Why the rig of a log does not roll; empty where it rolls, or where nothing shows it.

    Args:
        log: The log.
        content: Its bytes, for the names of columns that no reader knows.
    """
    column_names = list(log.names)
    if not column_names:
        lines = content.decode("utf-8", "replace").splitlines()[:_MAX_SEARCHED_LINES]
        likely_line = likely_line_of_names(lines)
        if likely_line is not None:
            _, line_of_names = likely_line
            column_names = re.split(r"[\t;|,]", line_of_names)
    if _is_rolling_rig(log, column_names):
        return ""
    for rig_kind, words in _WORDS_BY_RIG_KIND.items():
        names_of_kind = [name.strip() for name in column_names if _has_any_word(name, words)]
        if names_of_kind:
            shown_names = ", ".join(map(repr, names_of_kind[:_MAX_SHOWN_NAMES]))
            return (
                "this rig does not roll: oilfilm cannot use it, because the columns "
                f"{shown_names} are those of {rig_kind}, in which one body stands still. Traction "
                "needs two driven bodies: the speeds of both, or the entrainment speed and the "
                "slide-roll ratio. If both bodies turn, export their speeds too."
            )
    return ""


def _is_rolling_rig(log: SniffedLog, column_names: Iterable[str]) -> bool:
    """Whether format or names of columns show a rolling speed, or the speeds of two bodies."""
    if log.format_name == "pcs":
        # an export of a traction rig, whatever its columns
        return True
    quantities = set(log.candidates_of_quantity)
    for name in column_names:
        concepts = concepts_in(name)
        if concepts & {"entrainment", "srr"} or {"rolling", "speed"} <= concepts:
            return True
        meaning = VOCABULARY.quantity_and_unit(name)
        if meaning:
            quantities.add(meaning.quantity)
    has_both_bodies = quantities >= {"ball_speed", "disc_speed"}
    return has_both_bodies or bool(quantities & {"entrainment_speed", "slide_roll_ratio"})


def _has_any_word(name: str, words: str) -> bool:
    """Whether a name has one of some words, which are separated by blanks."""
    plain_name = unicodedata.normalize("NFKC", name).casefold()
    words_of_name: Sequence[str] = _WORD_PATTERN.findall(plain_name)
    for word in words.split():
        # Chinese and Japanese, from U+3000 on, have no blanks between words
        if len(word) <= _MAX_LETTERS_OF_WHOLE_WORD and word[0] < "\u3000":
            if word in words_of_name:
                return True
        elif word in plain_name:
            return True
    return False
