"""The certificate of a fit as a sentence, wherever a fit is shown.

Decides: what is said of a fit that is certified, that is not certified, or that could not be made.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from oilfilm.fits.conditions import fixed_conditions_from_json
from oilfilm.traction import ALL_LAWS
from oilfilm.traction.law import QUANTITIES

_LAW_BY_NAME = {law.name: law for law in ALL_LAWS}
# By the code in `doubts`. In braces are columns of `fit_quality`, and `bounds`, the texts of
# `active_bounds`. "their" stands for the searches: where errors or constants differ, the sentence
# on searches that disagree comes first.
_CLAUSE_BY_DOUBT = {
    "searches disagree": "{searches_agreeing} of {searches} searches agree",
    "errors differ": "their SSE exceed the smallest SSE by up to {sse_spread:.1e} of it",
    "constants differ": "their constants differ by up to {constant_spread:.1e} standard errors",
    "gradient": "gradient cosine {gradient_cosine:.1e}",
    "negative traction": "mu falls to {min_traction:.1e} in the tested box",
    "flat": "the SSE is flat in a direction of the constants",
    "at bounds": "bounds reached: {bounds}",
}
# By the code in `no_fit`. Counts follow their nouns, so that no plural goes with 1.
_REASON_BY_NO_FIT = {
    "properties unknown": "the law needs the oil's properties and one known contact (config)",
    "conditions did not vary": "the law needs these conditions to vary, independently of the "
    "others: {unvaried}",
    "no value": "the law needs conditions above zero, and a measured one is not",
    "no points": "no accepted points",
    "unknown traction": "accepted points without a traction coefficient or a slip: "
    "{unusable_points:.0f}",
    "no slip": "every slide-roll ratio is zero, where traction says nothing",
    "no traction": "no accepted point has traction above zero; is the sign of the force right "
    "(semantics of the campaign file)?",
    "too few points": "accepted points: {n_points}, distinct ones: {distinct_points:.0f}, needed: "
    "{points_needed:.0f} distinct ones",
    "constant traction": "mu is the same at every point, whatever the slip",
    "all constants at bounds": "every constant ended at a bound of its search, so that the law "
    "does not describe these points; are the units of force, load and slip right?",
}


def certificate_sentence(quality_row: Mapping[str, Any]) -> str:
    """Whether a fit is the best one of its law, and if not, why.

    Args:
        quality_row: A row of the table `fit_quality`.
    """
    if quality_row["no_fit"]:
        unvaried = _unvaried_conditions_text(quality_row)
        reason = _REASON_BY_NO_FIT[quality_row["no_fit"]].format(unvaried=unvaried, **quality_row)
        return f"not fitted: {reason}"
    if quality_row["certified"]:
        agreeing_count, search_count = quality_row["searches_agreeing"], quality_row["searches"]
        return f"certified: {agreeing_count} of {search_count} searches agree"
    bounds = ", ".join(quality_row["active_bounds"])
    doubt_clauses = [
        _CLAUSE_BY_DOUBT[doubt].format(bounds=bounds, **quality_row)
        for doubt in quality_row["doubts"]
    ]
    return f"not certified: {'; '.join(doubt_clauses)}"


def _unvaried_conditions_text(quality_row: Mapping[str, Any]) -> str:
    """The conditions that must vary for the law of a fit, and did not."""
    law = _LAW_BY_NAME[quality_row["law"]]
    fixed_names = {
        fixed.condition for fixed in fixed_conditions_from_json(quality_row["fixed_conditions"])
    }
    condition_varies = np.array([name not in fixed_names for name in law.conditions])
    unvaried_names = law.unvaried_conditions(condition_varies)
    return ", ".join(QUANTITIES[name].short_meaning for name in unvaried_names)
