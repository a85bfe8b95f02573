"""Which of the compared laws describes each oil best, beside the configured one.

Two criteria: the error at curves that the fit has not seen, and the Bayesian information criterion
(BIC). A difference counts where it is larger than its uncertainty, which is that of whole curves,
because the points of a run share its errors.

Decides: which law is the best one for an oil, and when laws tie.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from oilfilm import tables
from oilfilm.base.ties import first_smallest, reaches
from oilfilm.base.units import FloatArray
from oilfilm.fits.interval import student_quantile

# Of a difference, two-sided: the level of every interval and test of the project.
_CONFIDENCE = 0.95
# A difference of fewer curves has no error: one degree of freedom and less.
FEWEST_CURVES = 3
_MEASURED = "traction_coefficient_measured"


@dataclass(frozen=True)
class Judged:
    """The laws by one judge.

    Attributes:
        best: The best law.
        ties: Laws that differ from it by no more than the uncertainty; the best one is first.
        difference: Of the configured law from the best one, 0 or more.
        error: Half width of its 95 % interval.
    """

    best: str
    ties: Sequence[str]
    difference: float
    error: float


def best_laws(
    quality: pd.DataFrame, law_points: pd.DataFrame, points: pd.DataFrame, bic_difference_min: float
) -> pd.DataFrame:
    """Table `law_verdicts`: one row per oil, the configured law beside the best ones.

    Args:
        quality: Table `fit_quality`, of every law.
        law_points: mu of every law at every accepted point.
        points: Table of points.
        bic_difference_min: Laws tie where their BIC differ by less.
    """
    measured = points[["run_id", "first_row", "traction_coefficient"]]
    beside = law_points.merge(measured, on=["run_id", "first_row"], suffixes=("", "_measured"))
    rows = []
    for fit in tables.rows(quality[quality["configured"]]):
        of_oil, beside_oil = (frame[frame["oil"] == fit["oil"]] for frame in (quality, beside))
        verdict = _verdict(fit, of_oil, beside_oil, bic_difference_min)
        rows.append({"oil": fit["oil"], "law": fit["law"], **verdict})
    return tables.filled(pd.DataFrame(rows), "law_verdicts")


def _verdict(
    fit: dict[str, Any], quality: pd.DataFrame, beside: pd.DataFrame, bic_difference_min: float
) -> dict[str, Any]:
    law, laws = fit["law"], quality.set_index("law")
    fitted_laws = laws.index[laws["bic"].notna()]
    if len(laws) == 1:
        return {"verdict": "no other law"}
    if law not in fitted_laws:
        return {"verdict": "no fit"}
    if len(fitted_laws) == 1:
        return {"verdict": "no other fit"}
    # other points, other sums: such laws cannot be set beside this one
    same = laws[(laws["n_points"] == laws.loc[law, "n_points"]) & laws["bic"].notna()]
    # of laws that are as good: the configured one, a proven fit, the fewest constants
    in_order = same.assign(other=same.index != law).sort_values(
        ["other", "certified", "n_constants"], ascending=[True, False, True], kind="stable"
    )
    preferred = list(in_order.index)
    squares = _squares(beside, same.index, "left_out_traction_coefficient")
    if law not in squares:
        return {"verdict": "constants left open"}
    if len(squares) < FEWEST_CURVES:
        return {"verdict": "too few curves"}
    own = beside[beside["law"] == law]
    counts = own.groupby("run_id").size().to_numpy()[:, np.newaxis]
    sums, points = squares.sum(), counts.sum()
    without_each = np.sqrt((sums - squares) / (points - counts))
    unseen = _judged(preferred, np.sqrt(sums / points), without_each)
    fitted = _squares(beside, same.index, "traction_coefficient")
    # the differences have the error of Vuong's statistic (Econometrica 57 (1989) 307, section 5)
    without_each = points * np.log(fitted.sum() - fitted)
    by_bic = _judged(preferred, same["bic"], without_each, bic_difference_min)
    size = float(np.sqrt(np.mean(own[_MEASURED] ** 2)))
    verdict, better = _judgement(law, unseen, by_bic, same)
    return {
        "verdict": verdict,
        "better_law": better,
        "left_out_law": unseen.best,
        "left_out_ties": tuple(unseen.ties),
        "left_out_relative_rms": laws["left_out_rmse"][law] / size,
        "best_left_out_relative_rms": laws["left_out_rmse"][unseen.best] / size,
        "left_out_difference": unseen.difference / size,
        "left_out_difference_error": unseen.error / size,
        "bic_law": by_bic.best,
        "bic_ties": tuple(by_bic.ties),
        "bic_difference": by_bic.difference,
        "bic_difference_error": by_bic.error,
        "ends_out_law": _best_at_ends(in_order),
    }


def _squares(beside: pd.DataFrame, laws: "pd.Index[str]", column: str) -> pd.DataFrame:
    """Sum of squared errors of each curve, one column per law.

    Laws without an error at some point are left out.
    """
    squares = (beside[column] - beside[_MEASURED]) ** 2
    sums = squares.groupby([beside["run_id"], beside["law"]]).sum(skipna=False).unstack()
    return sums.reindex(columns=laws).dropna(axis=1)


def _judged(
    preferred: list[str], values: "pd.Series[float]", without_each: pd.DataFrame, least: float = 0.0
) -> Judged:
    """The laws by one criterion, the least of which is best.

    Args:
        preferred: The laws in the order in which they are preferred where they are as good; the
            configured one is the first.
        values: Of the criterion, by law.
        without_each: The same without each curve, one column per law.
        least: A smaller difference is a tie.
    """
    among = values[[name for name in preferred if name in values]]
    best = str(among.index[first_smallest(among)])
    differences = values - values[best]
    apart = without_each.sub(without_each[best], axis=0)
    errors = {str(name): jackknife_error(each.to_numpy()) for name, each in apart.items()}
    ties = [
        name
        for name, error in errors.items()
        if name != best and reaches(max(error, least), differences[name], size=abs(values[best]))
    ]
    configured = preferred[0]
    return Judged(best, (best, *ties), float(differences[configured]), errors[configured])


def jackknife_error(replicates: FloatArray) -> float:
    """Half width of the 95 % interval of a statistic, from its values without each curve.

    Reference: B. Efron, C. Stein, Ann. Stat. 9 (1981) 586.

    Examples:
        Of a mean it is Student's: for 1, 2, 3, 4 it is t(3) s/sqrt(4) = 3.18245 * 1.29099/2

        >>> values = np.array([1.0, 2.0, 3.0, 4.0])
        >>> print(f"{jackknife_error((values.sum() - values) / 3):.4f}")
        2.0543
    """
    count = len(replicates)
    variance = (count - 1) / count * np.sum((replicates - replicates.mean()) ** 2)
    return float(student_quantile(_CONFIDENCE, count - 1) * np.sqrt(variance))


def _best_at_ends(laws: pd.DataFrame) -> str:
    """The law with the least error at end levels that were left out; empty where none is known.

    Args:
        laws: Rows of fit quality, the preferred laws first.
    """
    ends = laws.filter(regex="_end_out_relative_rms$").astype(float)
    known = ends.dropna(axis=1, how="all").dropna()
    if known.empty or not len(known.columns):
        return ""
    return str(known.index[first_smallest((known**2).mean(axis=1))])


def _judgement(law: str, unseen: Judged, by_bic: Judged, laws: pd.DataFrame) -> tuple[str, str]:
    """Verdict on the configured law, and the law to use in its place."""
    by_both = [name for name in unseen.ties if name in by_bic.ties]
    if law in by_both:
        return ("best" if by_both == [law] else "tie"), ""
    if law in unseen.ties or law in by_bic.ties:
        return "criteria disagree", ""
    # both refuse the configured one; where they name different laws, unseen curves decide.
    # A proven fit first, then the fewest constants
    order = laws.loc[by_both or list(unseen.ties)].sort_values(
        ["certified", "n_constants"], ascending=[False, True], kind="stable"
    )
    return "another law is better", str(order.index[0])
