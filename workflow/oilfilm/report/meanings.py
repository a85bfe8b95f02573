"""What the words of a verdict mean: the one home of these sentences, for summary and report.

Decides: what a word of a verdict means.
"""

import re

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
    "CIRCULAR": "the data were made with the law that they are to test",
    "holds in part": "true at some of the conditions only",
    "by construction": "true for any constants, because the law's equation makes it so",
    "cannot be checked": "the campaign lacks what the claim is about",
}


def meanings(text: str) -> list[tuple[str, str]]:
    """The words of a text that need a meaning, each with its meaning, in one order.

    Args:
        text: What is shown.
    """
    return [(word, meaning) for word, meaning in MEANINGS.items() if _occurs(word, text)]


def _occurs(word: str, text: str) -> bool:
    if not word[-1].isalpha():
        return word in text.replace("\N{PLUS-MINUS SIGN}", "+-")
    ending = "s?" if word.islower() else ""
    return re.search(rf"(?<![\w-]){re.escape(word)}{ending}(?![\w-])", text) is not None
