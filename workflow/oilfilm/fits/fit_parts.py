"""Parts of one law's fit to one oil, each for a job of its own; `fitting.drawn` joins them."""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from oilfilm.fits.fit import block_of_refits, located_at, search_ends
from oilfilm.fits.law_comparison import errors_left_out, fit_of_comparison, laws_of
from oilfilm.settings.resolved import Settings
from oilfilm.traction import LAWS
from oilfilm.traction.law import FloatArray


@dataclass(frozen=True)
class Part:
    """A part of a fit.

    Attributes:
        of: "fit" or "compare": the rule that the part is for.
        oil: The oil.
        law: Name of the law.
        what: "ends" of the searches, "refits", or errors at curves "left-out".
        block: Which of the refits, or of the groups that are left out.
    """

    of: str
    oil: str
    law: str
    what: str
    block: slice


def compute_part(
    part: Part, points: pd.DataFrame, settings: Settings, ends: FloatArray | None
) -> FloatArray:
    """A part of a fit.

    Args:
        part: Which one.
        points: Table of points.
        settings: Those of the rule that the part is for.
        ends: The ends of the searches, where they are known.

    Returns:
        The part, as of `Drawn`; empty where the law cannot be fitted.
    """
    oil, seed = part.oil, settings.seed
    of_fit = part.of == "fit"
    law = LAWS[part.law] if of_fit else laws_of(oil, settings).get(part.law)
    fit = settings.fit if of_fit else fit_of_comparison(settings)
    if law is None:
        return np.empty((0, 1))
    if ends is None:
        return search_ends(points, oil, fit, seed, law)
    if part.what == "refits":
        return block_of_refits(points, oil, fit, seed, law, ends, part.block)
    located = located_at(points, oil, fit, law, ends)
    return np.empty(0) if located is None else errors_left_out(*located, oil, settings, part.block)
