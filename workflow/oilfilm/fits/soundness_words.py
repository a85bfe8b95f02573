"""What keeps a fit from being sound, in sentences, wherever a fit is shown.

Decides: what is said of a fit that is not sound.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from oilfilm.traction.law import QUANTITIES


def what_is_wrong(row: Mapping[str, Any]) -> list[str]:
    """What keeps a fit from being sound, and what it means for mu: a sentence each.

    Args:
        row: Of the table `soundness`.
    """
    sentences = []
    if row["campaign_verdict"] == "changed":
        sentences.append(_of_change(row))
    if row["law_verdict"] != "adequate":
        size = "" if np.isnan(row["bend_relative_rms"]) else f"{row['bend_relative_rms']:.1%}"
        bend = " and ".join(_name(each) for each in row["bend"])
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
# Unit of the size of a change; the others are shares.
_UNITS = {"load": "N", "zero of the force": "N", "inlet temperature": "K"}


def _name(code: str) -> str:
    if code == "shape":
        return "the slide-roll ratio"
    return "the " + (QUANTITIES[code].short_meaning if code in QUANTITIES else code)


def _of_change(row: Mapping[str, Any]) -> str:
    what, size, course = row["change"], row["change_size"], row["change_course"]
    runs = row["changed_runs"]
    named = f"{runs[0]} to {runs[-1]}" if course == "from" else ", ".join(runs)
    where = {
        "trend": "Over the runs",
        "from": f"From run {runs[0]} on ({len(runs)} runs)",
        "group": f"In {len(runs)} runs with {row['change_group']} ({named})",
        "some runs": f"In {len(runs)} runs ({named})",
    }[course]
    if what.endswith(" factor"):
        quantity = "the entrainment speed" if what == "speed factor" else "the slip"
        found = f"{quantity} reads {size:g} times as large as in the others"
    elif what == "oil":
        found = f"mu is that of a mixture with {size:.0%} of {row['change_oil']}"
    else:
        amount = f"{abs(size):.2g} {_UNITS[what]}" if what in _UNITS else f"{abs(size):.1%}"
        found = f"the {what} reads {'higher' if size > 0 else 'lower'} by {amount}"
    return (
        f"The campaign is not steady. {where} {found}, or something acts like that; it moves mu by "
        f"{row['change_relative_rms']:.1%} (rms). Check these runs and their set-up, and leave out "
        "those that are wrong."
    )
