"""What the names of columns and header lines seem to mean, in the languages of many laboratories.

Everything here is a guess. It becomes a line of a settings file that a person reads.
The words are in `words.yaml`: those of another language are added there.

Decides: what `oilfilm init` takes a column or a header line for.
"""

import re
import unicodedata
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import yaml

from oilfilm.logs.base import Names
from oilfilm.logs.header import apart
from oilfilm.logs.log_kind import Vocabulary
from oilfilm.settings.base import plain_key

# Quantity -> words by how much they tell of it: see the file.
_WORDS: dict[str, dict[str, str]] = yaml.safe_load(
    Path(__file__).with_name("words.yaml").read_text(encoding="utf-8")
)
_WEIGHTS = {"most": 3, "some": 2, "least": 1}
# Words of the rig's bodies say whose speed it is only beside a unit or a word of speed.
_SPEEDS = "speed drehzahl geschwind vitesse velocidad velocità скорость 速 rpm spind n v u"
_SHORT = 2
# A name with a word of the most telling ones may be the quantity, whatever other names say, but for
# those that need no guess.
_SURE, _KNOWN = 3, 100
_TOKENS = re.compile(r"[^\W\d_]+\d?|\d+")


def guessed(name: str, unit: str, vocabulary: Vocabulary) -> tuple[str, int]:
    """The quantity that a column's name seems to mean, and how likely it is; "" and 0: none.

    Args:
        name: Column name without its unit.
        unit: Unit as the log gives it; empty where it gives none.
        vocabulary: Units in which each quantity can be given.
    """
    # no single letter, because `n` may be a speed or newtons
    in_name = (unit_in_name(name, quantity, vocabulary) for quantity in vocabulary.quantities)
    unit = unit or next((each for each in in_name if len(each) > 1), "")
    scores = {"": 0}
    for quantity, words in _WORDS.items():
        if quantity not in vocabulary.quantities or (unit and not vocabulary.fits(quantity, unit)):
            continue
        of_a_body = quantity in ("ball_speed", "disc_speed") and not unit
        if has_word(name, words.get("others", "")) or (of_a_body and not has_word(name, _SPEEDS)):
            continue
        weighed = ((weight, words.get(key, "").split()) for key, weight in _WEIGHTS.items())
        scores[quantity] = sum(w * has_word(name, word) for w, of in weighed for word in of)
    best = max(scores, key=lambda quantity: scores[quantity])
    return best, scores[best]


def has_word(name: str, words: str) -> bool:
    """Whether a name has one of some words, given with blanks between, as a part of it."""
    plain = unicodedata.normalize("NFKC", name).casefold()
    tokens = set(_TOKENS.findall(plain))
    return any(
        word in tokens if len(word) <= _SHORT and word.isascii() else word in plain
        for word in words.split()
    )


def unit_in_name(name: str, quantity: str, vocabulary: Vocabulary) -> str:
    """The unit at an end of a name without brackets; empty where there is none."""
    ends = [name.split()[-1:], name.split()[-2:], name.split("/")[1:], name.split("_")[-1:]]
    # a letter before a name is a symbol
    ends += [words[:1] for words in [name.split()] if len(words) > 1 and len(words[0]) > 1]
    units = (" ".join(end).strip() for end in ends)
    fitting = (each for each in units if each not in ("", name))
    return next((each for each in fitting if vocabulary.fits(quantity, each)), "")


@dataclass(frozen=True)
class Guesses(Vocabulary):
    """A vocabulary in which names that are not known mean what they seem to mean.

    `symbols` says whether names that are symbols mean what papers use them for.
    """

    symbols: bool = False

    def meaning(self, name: str) -> tuple[str, str | None] | None:
        """See `Vocabulary.meaning`."""
        quantity, unit, _ = self.likely(name, apart(name)[1])
        return (quantity, unit or None) if quantity else None

    def likely(self, name: str, unit: str) -> tuple[str, str, int]:
        """Quantity and unit of a column's name, and how likely it is that."""
        if known := super().meaning(name):
            return known[0], unit or known[1] or "", _KNOWN
        bare = apart(name)[0]
        for quantity, words in _WORDS.items() if self.symbols else ():
            symbol = plain_key(bare) in words.get("symbols", "").split()
            if symbol and (not unit or self.fits(quantity, unit)):
                return quantity, unit, _KNOWN
        quantity, score = guessed(bare, unit, self)
        return quantity, unit, score

    def columns_by_quantity(self, names: Iterable[tuple[str, str]]) -> dict[str, Names]:
        """Names and units of the columns of a log by what they mean; several where in doubt."""
        scores: dict[str, dict[tuple[str, str], int]] = {}
        for name, beside in dict.fromkeys(names):
            quantity, unit, score = self.likely(name, beside or apart(name)[1])
            if quantity:
                scores.setdefault(quantity, {})[name, unit] = score
        found = {}
        for quantity, of in scores.items():
            best = max(of.values())
            least = best if best == _KNOWN else min(_SURE, best)
            found[quantity] = [name for name, score in of.items() if score >= least]
        return found
