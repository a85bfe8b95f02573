"""What the names of columns and header lines seem to mean, in the languages of many laboratories.

Everything here is a guess. It becomes a line of a settings file that a person reads.

Decides: what `oilfilm init` takes a column or a header line for.
"""

import re
import unicodedata
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from oilfilm.logs.base import Names
from oilfilm.logs.header import apart
from oilfilm.logs.log_kind import Vocabulary
from oilfilm.settings.base import plain_key

_NOT_MEASURED = "set soll target consigne"
# Quantity -> parts of names by how much they tell, from 3 to 1, and parts of names of something
# else: in English, German, French, Spanish, Italian, Russian, Chinese, Japanese. Words of one or
# two letters count only alone.
_WORDS = {
    "time": ("", "time elapsed zeit temps durée duree tiempo tempo время 时间 時間", "t", ""),
    "load": (
        "",
        "load normal last charge carga carico нагруз 载荷 法向 荷重 垂直 fn fz hertz pressung",
        "force kraft pressure pression presión pressione 压力 圧力 w",
        f"coef koeff beiwert {_NOT_MEASURED}",
    ),
    "traction_force": (
        "traction traktion friction reib tangent frott friccion fricción rozamiento attrito "
        "трен 摩擦 牵引 切向 fx ft ff fr umfangskraft",
        "",
        "force kraft",
        "coef koeff beiwert zahl 系数 系數",
    ),
    "traction_coefficient": (
        "coef koef koeff beiwert reibzahl reibungszahl traktionszahl cof mu μ 系数 係数",
        "traction traktion friction reib trakt attrito frott fricción трен 摩擦 牵引",
        "",
        f"film force kraft error fehler unc std {_NOT_MEASURED}",
    ),
    "ball_speed": (
        "ball kugel bille bola sfera шар 球",
        "",
        "n1 v1 u1",
        f"slid gleit temp {_NOT_MEASURED}",
    ),
    "disc_speed": (
        "disc disk scheibe disque disco диск 盘 ディスク",
        "",
        "n2 v2 u2",
        f"slid gleit temp {_NOT_MEASURED}",
    ),
    "entrainment_speed": (
        "entrain roll wälz roulement rodadura rotolamento 卷吸 滚动",
        "mean mittlere moyenne media medio 平均",
        "u speed",
        f"slid gleit {_NOT_MEASURED}",
    ),
    "slide_roll_ratio": (
        "srr slip schlupf wälzverhältnis gleit glissement deslizamiento strisciamento "
        "проскальз 滑滚 滑移 すべり",
        "slide sliding",
        "",
        _NOT_MEASURED,
    ),
    "inlet_temperature": (
        "inlet zulauf einlauf einlass vorlauf supply entrée entrada ingresso 入口",
        "",
        "temp öl oel oil huile aceite olio lube schmierstoff темп масл 温 油",
        "outlet auslauf ablauf rücklauf sortie salida uscita 出口 ambient raum room housing "
        f"gehäuse disc disk scheibe ball kugel {_NOT_MEASURED}",
    ),
}
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
    for quantity, (*telling, others) in _WORDS.items():
        if quantity not in vocabulary.quantities or (unit and not vocabulary.fits(quantity, unit)):
            continue
        of_a_body = quantity in ("ball_speed", "disc_speed") and not unit
        if has_word(name, others) or (of_a_body and not has_word(name, _SPEEDS)):
            continue
        weighed = zip((3, 2, 1), telling, strict=True)
        scores[quantity] = sum(w * has_word(name, word) for w, of in weighed for word in of.split())
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

    `symbols` has quantities by plain names that are no words.
    """

    symbols: Mapping[str, str] = field(default_factory=dict)

    def meaning(self, name: str) -> tuple[str, str | None] | None:
        """See `Vocabulary.meaning`."""
        quantity, unit, _ = self.likely(name, apart(name)[1])
        return (quantity, unit or None) if quantity else None

    def likely(self, name: str, unit: str) -> tuple[str, str, int]:
        """Quantity and unit of a column's name, and how likely it is that."""
        if known := super().meaning(name):
            return known[0], unit or known[1] or "", _KNOWN
        bare = apart(name)[0]
        symbol = self.symbols.get(plain_key(bare), "")
        if symbol and (not unit or self.fits(symbol, unit)):
            return symbol, unit, _KNOWN
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
