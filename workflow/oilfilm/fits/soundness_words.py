"""Reasons why a fit is not sound, in sentences, for every page and program that shows a fit.

Decides: what is said of a fit that is not sound.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from oilfilm.traction.law import QUANTITIES


def what_is_wrong(row: Mapping[str, Any]) -> list[str]:
    """Reasons why a fit is not sound, with the meaning for mu; one sentence or two per reason.

    Args:
        row: Row of the table `soundness`.
    """
    sentences = []
    if row["campaign_verdict"] == "changed":
        sentences.append(_of_change(row))
    if row["law_verdict"] != "adequate":
        size = "" if np.isnan(row["bend_relative_rms"]) else f"{row['bend_relative_rms']:.1%}"
        bend = " and ".join(_quantity(code) for code in row["bend"])
        sentences.append(_LAW[row["law_verdict"]].format(bend=bend, size=size))
    if row["campaign_verdict"] == "too few curves" and row["law_verdict"] != "too few curves":
        sentences.append("The runs are too few to show whether the campaign was steady.")
    if not row["optimum_confirmed"] and row["law_verdict"] != "no fit":
        sentences.append(
            "The searches do not confirm the optimum: other constants may fit as well. Look at "
            "what is said above first; then raise fit.searches or fit.generations."
        )
    return sentences


_LAW = {
    "bend": "The law is not adequate: over {bend} the points bend away from it by {size} of mu "
    "(rms). The interval of the next run allows for it within the tested conditions; beyond them "
    "nothing does.",
    "misfit": "The law is not adequate: it misses the points by more than fit.odd_scatter. A "
    "condition may be missing, or runs do not belong together.",
    "lack of fit": "The law is not adequate: it misses more than repeated runs scatter.",
    "condition missing": "A condition is not known of every run, so that mu is mixed over its "
    "levels. Fill it in in the campaign or rig file.",
    "two levels": "A condition was tested at two levels only: a bend between them cannot be seen. "
    "The interval of the next run is wider there. Test a third level.",
    "too few curves": "The runs are too few to show whether the law is adequate or the campaign "
    "steady. Measure more runs.",
    "no fit": "Nothing could be fitted.",
}
# Unit of the size of a change, by its cause. Sizes of other causes are shares.
_UNITS = {"load": "N", "zero of the force": "N", "inlet temperature": "K"}


def _quantity(code: str) -> str:
    """Name of the quantity over which the points bend away from the law."""
    if code == "shape":
        return "the slide-roll ratio"
    if code in QUANTITIES:
        return f"the {QUANTITIES[code].short_meaning}"
    return f"the {code}"


def _of_change(row: Mapping[str, Any]) -> str:
    """The sentence on a change of the campaign."""
    cause = row["change"]
    size = row["change_size"]
    where = _where(row)
    if cause.endswith(" factor"):
        quantity = "the entrainment speed" if cause == "speed factor" else "the slip"
        change = f"{quantity} reads {size:g} times as large as in the others"
    elif cause == "oil":
        change = f"mu is that of a mixture with {size:.0%} of {row['change_oil']}"
    else:
        amount = f"{abs(size):.2g} {_UNITS[cause]}" if cause in _UNITS else f"{abs(size):.1%}"
        direction = "higher" if size > 0 else "lower"
        change = f"the {cause} reads {direction} by {amount}"
    return (
        f"The campaign is not steady. {where} {change}, or something acts like that; it moves mu "
        f"by {row['change_relative_rms']:.1%} (rms). Check these runs and their set-up, and leave "
        "out those that are wrong."
    )


def _where(row: Mapping[str, Any]) -> str:
    """Which runs a change is in; a trend is in all runs and names none."""
    runs = row["changed_runs"]
    match row["change_course"]:
        case "trend":
            return "Over the runs"
        case "from":
            return f"From run {runs[0]} on ({len(runs)} runs)"
        case "group":
            return f"In {len(runs)} runs with {row['change_group']} ({', '.join(runs)})"
        case _:
            return f"In {len(runs)} runs ({', '.join(runs)})"
