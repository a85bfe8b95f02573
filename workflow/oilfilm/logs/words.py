"""What the names of columns and header lines seem to mean, in the languages of many laboratories.

Everything here is a guess. It becomes a line of a settings file that a person reads.

Decides: what `oilfilm init` takes a column or a header line for.
"""

import re
import unicodedata
from collections.abc import Iterable
from dataclasses import dataclass

from oilfilm.logs.log_kind import Vocabulary


@dataclass(frozen=True)
class _Words:
    """Parts of names by how much they tell, from 3 to 1, and parts of names of something else."""

    telling: tuple[str, str, str]
    others: str = ""


_NOT_MEASURED = "set soll target consigne"
# English, German, French, Spanish, Italian, Russian, Chinese, Japanese. Words of one or two letters
# count only alone.
_WORDS = {
    "time": _Words(("", "time elapsed zeit temps durée duree tiempo tempo время 时间 時間", "t")),
    "load": _Words(
        (
            "",
            "load normal last charge carga carico нагруз 载荷 法向 荷重 垂直 fn fz hertz pressung",
            "force kraft pressure pression presión pressione 压力 圧力 w",
        ),
        f"coef koeff beiwert {_NOT_MEASURED}",
    ),
    "traction_force": _Words(
        (
            "traction traktion friction reib tangent frott friccion fricción rozamiento attrito "
            "трен 摩擦 牵引 切向 fx ft ff fr umfangskraft",
            "",
            "force kraft",
        ),
        "coef koeff beiwert zahl 系数 系數",
    ),
    "traction_coefficient": _Words(
        (
            "coef koef koeff beiwert reibzahl reibungszahl traktionszahl cof mu μ 系数 係数",
            "traction traktion friction reib trakt attrito frott fricción трен 摩擦 牵引",
            "",
        ),
        f"film force kraft error fehler unc std {_NOT_MEASURED}",
    ),
    "ball_speed": _Words(
        ("ball kugel bille bola sfera шар 球", "", "n1 v1 u1"),
        f"slid gleit temp {_NOT_MEASURED}",
    ),
    "disc_speed": _Words(
        ("disc disk scheibe disque disco диск 盘 ディスク", "", "n2 v2 u2"),
        f"slid gleit temp {_NOT_MEASURED}",
    ),
    "entrainment_speed": _Words(
        (
            "entrain roll wälz roulement rodadura rotolamento 卷吸 滚动",
            "mean mittlere moyenne media medio 平均",
            "u speed",
        ),
        f"slid gleit {_NOT_MEASURED}",
    ),
    "slide_roll_ratio": _Words(
        (
            "srr slip schlupf wälzverhältnis gleit glissement deslizamiento strisciamento "
            "проскальз 滑滚 滑移 すべり",
            "slide sliding",
            "",
        ),
        _NOT_MEASURED,
    ),
    "inlet_temperature": _Words(
        (
            "inlet zulauf einlauf einlass vorlauf supply entrée entrada ingresso 入口",
            "",
            "temp öl oel oil huile aceite olio lube schmierstoff темп масл 温 油",
        ),
        "outlet auslauf ablauf rücklauf sortie salida uscita 出口 ambient raum room housing "
        f"gehäuse disc disk scheibe ball kugel {_NOT_MEASURED}",
    ),
}
# Words of the rig's bodies say whose speed it is only beside a unit or a word of speed.
_SPEEDS = "speed drehzahl geschwind vitesse velocidad velocità скорость 速 rpm spind n v u"
_SHORT = 2
# A name with a word of the most telling ones may be the quantity, whatever other names say.
_SURE = 3
_TOKENS = re.compile(r"[^\W\d_]+\d?|\d+")


def guessed(name: str, unit: str, vocabulary: Vocabulary) -> tuple[str, int]:
    """The quantity that a column's name seems to mean, and how likely it is; "" and 0: none.

    Args:
        name: Column name without its unit.
        unit: Unit as the log gives it; empty where it gives none.
        vocabulary: Units in which each quantity can be given.
    """
    unit = unit or _telling_unit(name, vocabulary)
    scores = {
        quantity: score
        for quantity in _WORDS
        if quantity in vocabulary.quantities
        if (score := _score(name, unit, quantity, vocabulary))
    }
    best = max(scores, key=lambda quantity: scores[quantity], default="")
    return best, scores.get(best, 0)


def _telling_unit(name: str, vocabulary: Vocabulary) -> str:
    """The unit at the end of a name; no single letter, because `n` may be a speed or newtons."""
    units = (unit_in_name(name, quantity, vocabulary) for quantity in vocabulary.quantities)
    return next((unit for unit in units if len(unit) > 1), "")


def _score(name: str, unit: str, quantity: str, vocabulary: Vocabulary) -> int:
    if unit and not vocabulary.fits(quantity, unit):
        return 0
    if has_word(name, _WORDS[quantity].others):
        return 0
    if quantity in ("ball_speed", "disc_speed") and not unit and not has_word(name, _SPEEDS):
        return 0
    return sum(
        weight
        for weight, words in zip((3, 2, 1), _WORDS[quantity].telling, strict=True)
        for word in words.split()
        if has_word(name, word)
    )


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
    return next(
        (
            unit
            for end in ends
            if (unit := " ".join(end).strip()) not in ("", name) and vocabulary.fits(quantity, unit)
        ),
        "",
    )


def guessed_columns(
    names: Iterable[tuple[str, str]], vocabulary: Vocabulary
) -> dict[str, list[tuple[str, str]]]:
    """The columns of one log by the quantity that they seem to mean; several where they are equal.

    Args:
        names: Each column's name and unit.
        vocabulary: What such logs may hold. Names that it knows need no guess.
    """
    own = {known[0] for name, _ in names if (known := vocabulary.meaning(name))}
    scores: dict[str, dict[tuple[str, str], int]] = {}
    for name, unit in dict.fromkeys(names):
        quantity, score = guessed(name, unit, vocabulary)
        if quantity and quantity not in own:
            scores.setdefault(quantity, {})[name, unit] = score
    return {
        quantity: [name for name, score in of.items() if score >= min(_SURE, max(of.values()))]
        for quantity, of in scores.items()
    }
