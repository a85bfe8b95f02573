"""Reasons why a fit is not sound, in sentences, for every page and program that shows a fit.

Decides: what is said of a fit that is not sound, and of a campaign that is steady.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from oilfilm.traction.law import QUANTITIES


def soundness_warnings(row: Mapping[str, Any]) -> list[str]:
    """Reasons why a fit is not sound, with the meaning for mu; a few sentences per reason.

    Args:
        row: Row of the table `soundness`.
    """
    sentences = []
    if row["campaign_verdict"] == "changed":
        sentences.append(_change_sentence(row))
    if row["law_verdict"] != "adequate":
        sentence = _SENTENCE_BY_LAW_VERDICT[row["law_verdict"]]
        sentences.append(sentence.format(misfit=row["misfit"], run_scatter=row["run_scatter"]))
    # without a fit nothing was judged, however many runs there are
    if row["campaign_verdict"] == "too few curves" and row["law_verdict"] not in (
        "too few curves",
        "no fit",
    ):
        sentences.append("The runs are too few to show whether the campaign was steady.")
    if row["campaign_verdict"] == "no surface" and row["law_verdict"] != "no surface":
        sentences.append(
            "Without a surface of measured mu nothing shows whether the campaign was steady."
        )
    if not row["optimum_confirmed"] and row["law_verdict"] != "no fit":
        advice = "Raise fit.searches or fit.generations."
        if sentences:
            advice = "Look at what is said above first; then raise fit.searches or fit.generations."
        sentences.append(
            f"The searches do not confirm the optimum: other constants may fit as well. {advice}"
        )
    return sentences


def smallest_visible_changes_sentence(row: Mapping[str, Any]) -> str:
    """The smallest changes that a steady campaign would have shown; empty where it is not steady.

    Args:
        row: Row of the table `soundness`.
    """
    if row["campaign_verdict"] != "steady":
        return ""
    sentences = [
        "The runs are steady, if they were made in the order of their names.",
        _smallest_visible_change_sentence(row, "trend", "drift over the runs"),
        _smallest_visible_change_sentence(row, "step", "step at any run"),
        "A change of runs that share no label, speed, load or temperature is seen if it is several "
        "times as large.",
    ]
    resembled = row["order_resembles"]
    if resembled:
        quantity = QUANTITIES[resembled].short_meaning
        sentences.append(
            f"This order is that of the {quantity}: a smaller change is confounded with its "
            "effect. Repeat one condition every sixth run."
        )
    return " ".join(sentences)


def _smallest_visible_change_sentence(
    row: Mapping[str, Any], course: str, course_in_words: str
) -> str:
    """The smallest changes of a course that would have been seen.

    Args:
        row: Row of the table `soundness`.
        course: trend or step, as in the names of columns.
        course_in_words: Name of the course in the sentence.
    """
    visible_sizes, invisible_quantities = [], []
    for effect, (quantity, size_in_words) in _WORDS_BY_EFFECT.items():
        size = row[f"seen_{course}_{effect}"]
        if np.isnan(size):
            invisible_quantities.append(quantity)
        else:
            visible_sizes.append(size_in_words.format(size))
    if not visible_sizes:
        return f"No {course_in_words} would have been seen."
    visible_text = (
        f"A {course_in_words} of {_joined_by_or(visible_sizes)} would most likely have been seen"
    )
    if not invisible_quantities:
        return f"{visible_text}."
    return f"{visible_text}, but none of {_joined_by_or(invisible_quantities)}."


def _joined_by_or(texts: Sequence[str]) -> str:
    """Texts as `a`, `a or b`, `a, b or c`."""
    *first_texts, last_text = texts
    return f"{', '.join(first_texts)} or {last_text}" if first_texts else last_text


# What a change of the rig changes: the quantity, and how the size of a change is written, by the
# name of the effect in columns.
_WORDS_BY_EFFECT = {
    "gain": ("the traction force", "{:.1%} of the traction force"),
    "zero": ("the zero of the force", "{:.2g} in mu (zero of the force)"),
    "slip_scale": ("the slip", "{:.1%} of the slip"),
    "temperature_k": ("the temperature", "{:.2g} K"),
}
_SENTENCE_BY_LAW_VERDICT = {
    "none fits": "No law is adequate: the measurements depart from this one by {misfit:.1%} of mu, "
    "and runs scatter by {run_scatter:.1%}. Its constants describe the tested conditions, not the "
    "oil.",
    "misfit": "The law is not adequate: it misses the points by more than fit.odd_scatter of mu, "
    "or departs from the measurements by more than runs scatter (surface.largest_misfit). Use a "
    "law that fits better. A condition may be missing, or runs do not belong together.",
    "lack of fit": "The law is not adequate: it misses more than repeated runs scatter.",
    "condition missing": "A condition is not known of every run, so that mu is mixed over its "
    "levels. Fill it in in the campaign or rig file.",
    "two levels": "A condition was tested at two levels only: a law cannot be checked between "
    "them. The interval of the next run is wider there. Test a third level.",
    "too few curves": "The runs are too few to show whether the law is adequate or the campaign "
    "steady. Measure more runs.",
    "no surface": "Neither the law nor the steadiness of the campaign can be judged: no surface of "
    "measured mu could be made. None of the fitted laws can carry one, the contacts of the runs "
    "differ under a law of the load, or too few runs have all conditions. Compare a law of the "
    "pressure (compare.laws), or give the missing conditions.",
    "no fit": "Nothing could be fitted.",
}
# What has the same effect on mu as an error of a sensor, by the sensor's quantity.
_ALTERNATIVE_BY_CAUSE = {
    "traction force": "or the load is {other} than stated, the ball is worn or the oil "
    "is another one",
    "zero of the force": "or the force has an offset from another source",
    "slip": "or the speeds, the pressure or the oil are other ones",
    "inlet temperature": "or the contact is warmer or colder than the sensor",
}


def _change_sentence(row: Mapping[str, Any]) -> str:
    """The sentence on a change of the campaign."""
    effect = f"it moves mu by {row['change_relative_rms']:.1%} (rms)"
    if row["change"] == "temperature labels":
        runs = row["changed_runs"]
        return (
            f"The campaign is not steady. The temperatures of {_count_of_runs(runs)} "
            f"({', '.join(runs)}) seem to be exchanged among each other, by up to "
            f"{row['change_size']:.0f} K; {effect}. Compare the labels of these runs with their "
            "logs."
        )
    change = _change_clause(row)
    return (
        f"The campaign is not steady. {_affected_runs_clause(row)} {change}; {effect}. Check these "
        "runs and their set-up, and leave out those that are wrong."
    )


def _change_clause(row: Mapping[str, Any]) -> str:
    """What changed, and what acts like it."""
    # the column `change` names the cause, as `traction force`
    cause, size = row["change"], row["change_size"]
    if cause.endswith(" factor"):
        quantity = "the entrainment speed" if cause == "speed factor" else "the slip"
        return f"{quantity} reads {size:g} times as large as in the others"
    amount = f"{abs(size):.1%}"
    if cause == "inlet temperature":
        amount = f"{abs(size):.1f} K"
    elif cause == "zero of the force":
        amount = f"{abs(size):.2g} in mu"
    if row["change_course"] == "season":
        alternative = _ALTERNATIVE_BY_CAUSE[cause].format(other="other")
        return f"the {cause} comes and goes by {amount}, {alternative}"
    direction = "higher" if size > 0 else "lower"
    alternative = _ALTERNATIVE_BY_CAUSE[cause].format(other=direction)
    compared_with = " in the last one than in the first" if row["change_course"] == "trend" else ""
    return f"the {cause} reads {direction} by {amount}{compared_with}, {alternative}"


def _affected_runs_clause(row: Mapping[str, Any]) -> str:
    """Which runs a change is in; a trend and a season are in all runs and name none."""
    runs = row["changed_runs"]
    match row["change_course"]:
        case "trend" | "season":
            return "Over the runs, in the order of their names,"
        case "from":
            return f"From run {runs[0]} on ({_count_of_runs(runs)})"
        case "until":
            return f"Up to run {runs[-1]} ({_count_of_runs(runs)})"
        case "group":
            return f"In {_count_of_runs(runs)} with {row['change_group']} ({', '.join(runs)})"
        case _:
            return f"In {_count_of_runs(runs)} ({', '.join(runs)})"


def _count_of_runs(runs: Sequence[str]) -> str:
    """The number of runs, as `1 run` or `3 runs`."""
    return f"{len(runs)} run" if len(runs) == 1 else f"{len(runs)} runs"
