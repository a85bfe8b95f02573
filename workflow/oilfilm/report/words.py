"""Names and words of the report: load variables, gates, and what the words of verdicts mean.

Decides: the meaning of each word of a verdict, and the symbols of print.
"""

import re
from collections.abc import Mapping

from oilfilm.traction import LAW_TITLES

LOAD_VARIABLES = {
    **LAW_TITLES,
    "stress": "pressure-based",
    "load": "load-based",
    "dimensionless_load": "dimensionless load",
}
MEANINGS = {
    "certified": "independent searches ended at the same constants, and the checks of the optimum "
    "hold: these are the best constants of this law. Another law may still be better",
    "bounds reached": "constants at the end of the range of the search. The data would have them "
    "beyond it",
    "rms": "root mean square; here of the differences in mu, over that of mu",
    "SSE": "sum of squared errors of mu",
    "curves left out": "a fit to all other curves predicts each curve. This is the error at data "
    "that the fit has not seen, at conditions like those tested",
    "BIC": "Bayesian information criterion: misfit plus a penalty for each constant. The lowest is "
    "best. It takes points as independent; a difference below 2 means nothing",
    "tie": "the difference is no larger than its uncertainty",
    "criteria": "the error at curves left out, and the BIC",
    "+-": "half width of the 95 % interval. The points of a run count as one, because they share "
    "its errors",
    "lack of fit": "the part of the residuals that the form of the law misses, however often one "
    "measures",
    "repeat": "a run at the oil and the condition of an earlier run. Their scatter is the noise",
    "F": "mean squares of lack of fit over those of noise. Above its limit it is more than chance",
    "joint interval": "holds for all constants of a fit together with 95 % confidence, calibration "
    "included. A sign is known where the interval leaves out zero",
    "sign unknown": "zero is in the joint interval",
    "in step": "exponent along the tested line of conditions that varied together; not of one of "
    "them alone",
    "no interval": "too few runs to resample, so that the error is not known",
    "at a bound": "the constant is at the end of the range of the search. The data would have it "
    "beyond",
    "not identifiable": "the tested conditions cannot give this constant",
    "correlated": "near 1 or -1 the two constants replace each other. Only a combination of them "
    "is determined",
    "full film": "no contact of asperities: film thickness over roughness (lambda) is above its "
    "limit",
    "STAND-IN": "properties of another oil, used in place of unknown ones",
}
# What tables write in letters that every terminal has, as it is printed; in this order.
_PRINTED = {
    r"\bmu\b": "\N{GREEK SMALL LETTER MU}",
    r"\bdegC\b": "\N{DEGREE SIGN}C",
    r"\bum\b": "\N{MICRO SIGN}m",
    r"\bR2\b": "R\N{SUPERSCRIPT TWO}",
    ">=": "\N{GREATER-THAN OR EQUAL TO}",
    # a number and its unit stay in one line
    r"(?<=\d) (?=GPa|m/s|%|\N{DEGREE SIGN}|\N{MICRO SIGN})": "\N{NO-BREAK SPACE}",
    r"(?<=\bS) (?=\d)": "\N{NO-BREAK SPACE}",
}


def law_name(key: str) -> str:
    """The title of a law; laws that are not installed keep their name.

    Examples:
        >>> law_name("deng2026"), law_name("my-law")
        ('Deng (Eq. 7)', 'my-law')
    """
    return LAW_TITLES.get(key, key)


def load_variable(key: str) -> str:
    """A law and what it is evaluated with in the bearing, in words.

    Examples:
        >>> load_variable("load")
        'load-based'
    """
    return LOAD_VARIABLES.get(key, key.replace("_", " "))


def gate_name(key: str) -> str:
    """A gate, or another rule of refusal, in words.

    Examples:
        >>> gate_name("stuck_sensor")
        'stuck sensor'
    """
    return key.replace("_", " ")


def printed(text: str) -> str:
    """A sentence with the symbols of print.

    Examples:
        >>> printed("mu >= 0")
        'μ ≥ 0'
    """
    for plain, sign in _PRINTED.items():
        text = re.sub(plain, sign, text)
    return text


def meanings(text: str, *more: Mapping[str, str]) -> list[tuple[str, str]]:
    """The words of a text that need a meaning, each with its meaning, in one order.

    Args:
        text: What is shown.
        more: Meanings of further words.
    """
    known = {**MEANINGS, **{word: meaning for words in more for word, meaning in words.items()}}
    return [(word, meaning) for word, meaning in known.items() if _occurs(word, text)]


def _occurs(word: str, text: str) -> bool:
    if not word[-1].isalpha():
        return word in text.replace("\N{PLUS-MINUS SIGN}", "+-")
    # "steps" is no plural of the verdict "in step"
    ending = "s?" if word.islower() and word.isalpha() else ""
    return re.search(rf"(?<![\w-]){re.escape(word)}{ending}(?![\w-])", text) is not None
