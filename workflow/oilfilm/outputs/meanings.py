"""What the words of a verdict mean: the one home of these sentences, for summary and report."""

import re

MEANINGS = {
    "certified": "independent searches ended at the same constants and the checks of the optimum "
    "hold, so that these are the best constants of this law; whether the law is the best one, and "
    "right, is another question",
    "bounds reached": "constants that the search holds at the end of their range; the data would "
    "have them beyond it",
    "rms": "root-mean-square, here of the differences in mu over that of mu",
    "curves left out": "each run is predicted by a fit to all other runs: the error at what the "
    "fit has not seen, at conditions like those tested",
    "BIC": "Bayesian information criterion: misfit plus a penalty for each constant, the lowest is "
    "best; it counts each point as independent, and a difference below 2 is nothing",
    "tie": "the difference is no larger than its uncertainty",
    "judges": "the error at curves left out, and the BIC",
    "+-": "half width of the 95 % interval; the points of a run count as one, because they share "
    "its errors",
    "lack of fit": "what the form of the law misses, however often one measures",
    "repeat": "a run at the oil and the condition of an earlier run; their scatter is the noise",
    "F": "lack of fit over noise, as mean squares; above its limit it is more than chance",
    "joint interval": "holds for all constants of a fit together with 95 % confidence, calibration "
    "included; a sign is known where it leaves out zero",
    "sign unknown": "zero is in the joint interval",
    "in step": "exponent along the tested line of conditions that varied together, of none of them "
    "alone",
    "no interval": "too few runs to resample, so that the error is not known",
    "at a bound": "the constant is at the end of the range of the search; the data would have it "
    "beyond",
    "not identifiable": "the tested conditions cannot give this constant",
    "correlated": "near 1 or -1 the two constants replace each other, and only a combination of "
    "them is determined",
    "full film": "film thickness over roughness (lambda) above its limit: no contact of asperities",
    "STAND-IN": "properties of another oil, used in place of unknown ones",
    "CIRCULAR": "the data were made with what they are to test",
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
