"""Which of the compared laws describes each oil best, beside the configured one.

There are two criteria: the error at curves that were left out of the fit, and the Bayesian
information criterion (BIC). A difference counts where it is larger than its uncertainty. The
uncertainty comes from whole curves, because the points of a run share its errors.

Two laws may be the same law on an oil's points: a law on load and one on pressure for one ball, or
a law whose further constants have no effect. Such laws count once, as the preferred one of them.

Decides: which law is the best one for an oil, when laws tie, and when two laws are the same law.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from oilfilm import tables
from oilfilm.base.ties import first_smallest, reaches
from oilfilm.base.units import FloatArray
from oilfilm.fits.interval import CONFIDENCE, student_quantile
from oilfilm.tables.campaign_tables import CampaignTables

# From fewer curves the error of a difference is not estimated: one degree of freedom and less.
FEWEST_CURVES = 3
_MEASURED = "traction_coefficient_measured"
# Two laws are the same law on the points where their fitted mu differ by less than this share of
# the standard error of a fit, root-mean-square over the points. Four of sixteen constants that mean
# nothing move mu by sqrt(4/16) of it, in expectation. In `demo` and `thermal` the law on load and
# Eq. 7 differ by 0.2 to 0.3; the next pair of laws differs by 0.6.
_SAME_WITHIN = 0.5

# mu of each law at its points beside the measured mu, in the order of run and row.
_MuByLaw = Mapping[str, pd.DataFrame]
# Columns that name a point.
_POINT_KEY = ["run_id", "first_row"]
_MU_OF_LAW = ["traction_coefficient", "left_out_traction_coefficient"]


@dataclass(frozen=True)
class Ranking:
    """The laws by one criterion.

    Attributes:
        best: The best law.
        ties: Laws that differ from it by no more than the uncertainty; the best law is first.
        difference: Criterion of the configured law less that of the best law, 0 or more.
        error: Half width of the 95 % interval of this difference.
    """

    best: str
    ties: Sequence[str]
    difference: float
    error: float


def best_laws(results: CampaignTables, bic_difference_min: float) -> pd.DataFrame:
    """Table `law_verdicts`: one row per oil, the configured law beside the best ones.

    Args:
        results: Tables `fit_quality` and `law_points` of every law, and `points`.
        bic_difference_min: Laws tie where their BIC differ by less.
    """
    quality = results.fit_quality
    rows = []
    for fit in tables.rows(quality[quality["configured"]]):
        quality_of_oil = quality[quality["oil"] == fit["oil"]]
        mu_by_law = _mu_by_law(results, fit["oil"], quality_of_oil["law"])
        verdict = _verdict(fit["law"], quality_of_oil, mu_by_law, bic_difference_min)
        rows.append({"oil": fit["oil"], "law": fit["law"], **verdict})
    return tables.filled(pd.DataFrame(rows), "law_verdicts")


def _mu_by_law(results: CampaignTables, oil: str, laws: Iterable[str]) -> _MuByLaw:
    """mu of each law beside the measured mu, at the points of one oil.

    Laws are read one by one, and names of runs kept once: all at once they would be the largest
    table of a campaign.
    """
    measured = results.table("points", [*_POINT_KEY, "traction_coefficient"], oil=oil)
    measured = measured.rename(columns={"traction_coefficient": _MEASURED})
    runs = pd.Index(sorted(measured["run_id"].unique()))
    measured = _with_numbered_runs(measured, runs)
    mu_by_law = {}
    for law in laws:
        points_of_law = results.table("law_points", [*_POINT_KEY, *_MU_OF_LAW], oil=oil, law=law)
        if points_of_law.empty:
            continue
        joined = _with_numbered_runs(points_of_law, runs).merge(measured, on=_POINT_KEY)
        mu_by_law[law] = joined.sort_values(_POINT_KEY, ignore_index=True)
    return mu_by_law


def _with_numbered_runs(points: pd.DataFrame, runs: "pd.Index[str]") -> pd.DataFrame:
    """The points with `run_id` as a category: a number per point in place of a name.

    Args:
        points: With `run_id`.
        runs: Names of all runs, in order.
    """
    number, names = pd.factorize(points["run_id"])
    categories = pd.Categorical.from_codes(runs.get_indexer(names)[number], runs)
    return points.assign(run_id=categories)


def _verdict(
    configured_law: str, quality: pd.DataFrame, mu_by_law: _MuByLaw, bic_difference_min: float
) -> dict[str, Any]:
    """The columns of `law_verdicts` of one oil.

    Args:
        configured_law: The configured law.
        quality: Rows of `fit_quality` of the oil.
        mu_by_law: mu of every law beside the measured mu at the oil's points.
        bic_difference_min: As in `best_laws`.
    """
    laws = quality.set_index("law")
    fitted_laws = laws.index[laws["bic"].notna()]
    if len(laws) == 1:
        return {"verdict": "no other law"}
    if configured_law not in fitted_laws:
        return {"verdict": "no fit"}
    if len(fitted_laws) == 1:
        return {"verdict": "no other fit"}
    # laws that were fitted to other points have other sums, and are not comparable
    has_same_points = laws["n_points"] == laws.loc[configured_law, "n_points"]
    comparable = laws[has_same_points & laws["bic"].notna()]
    # of laws that are equally good: the configured law, a certified fit, the fewest constants
    in_order = comparable.assign(other=comparable.index != configured_law).sort_values(
        ["other", "certified", "n_constants"], ascending=[True, False, True], kind="stable"
    )
    same_laws = _same_laws(mu_by_law, list(in_order.index))
    preferred = list(same_laws)
    in_order = in_order.loc[preferred]
    comparable = comparable.loc[preferred]
    left_out_sse = _sse_of_curves(mu_by_law, comparable.index, "left_out_traction_coefficient")
    if configured_law not in left_out_sse:
        return {"verdict": "constants left open"}
    if len(left_out_sse) < FEWEST_CURVES:
        return {"verdict": "too few curves"}
    points_of_law = mu_by_law[configured_law]
    by_curve = points_of_law.groupby("run_id", observed=True)
    points_per_curve = by_curve.size().to_numpy()[:, np.newaxis]
    points = points_per_curve.sum()
    total_sse = left_out_sse.sum()
    rmse = np.sqrt(total_sse / points)
    rmse_without_curve = np.sqrt((total_sse - left_out_sse) / (points - points_per_curve))
    left_out = _ranking(preferred, rmse, rmse_without_curve)
    fitted_sse = _sse_of_curves(mu_by_law, comparable.index, "traction_coefficient")
    # the differences have the error of Vuong's statistic (Econometrica 57 (1989) 307, section 5)
    bic_without_curve = points * np.log(fitted_sse.sum() - fitted_sse)
    by_bic = _ranking(preferred, comparable["bic"], bic_without_curve, bic_difference_min)
    rms_mu = float(np.sqrt(np.mean(points_of_law[_MEASURED] ** 2)))
    verdict, better_law = _judgement(configured_law, left_out, by_bic, comparable)
    return {
        "verdict": verdict,
        "same_laws": same_laws[configured_law],
        "better_law": better_law,
        "same_as_better_law": same_laws.get(better_law, ()),
        "left_out_law": left_out.best,
        "left_out_ties": tuple(left_out.ties),
        "left_out_relative_rms": laws["left_out_rmse"][configured_law] / rms_mu,
        "best_left_out_relative_rms": laws["left_out_rmse"][left_out.best] / rms_mu,
        "left_out_difference": left_out.difference / rms_mu,
        "left_out_difference_error": left_out.error / rms_mu,
        "bic_law": by_bic.best,
        "bic_ties": tuple(by_bic.ties),
        "bic_difference": by_bic.difference,
        "bic_difference_error": by_bic.error,
        "ends_out_law": _best_at_ends(in_order),
    }


def _same_laws(mu_by_law: _MuByLaw, in_order: Sequence[str]) -> dict[str, tuple[str, ...]]:
    """The laws that differ on the points, each with the laws that are the same law there.

    Args:
        mu_by_law: mu of every law beside the measured mu.
        in_order: The laws in the order in which they are preferred; their points are the same.
    """
    fitted = {law: mu_by_law[law]["traction_coefficient"].to_numpy() for law in in_order}
    errors = {law: _error_of_fit(mu_by_law[law]) for law in in_order}
    rms_measured_mu = float(np.sqrt(np.mean(mu_by_law[in_order[0]][_MEASURED] ** 2)))

    def are_same(first: str, second: str) -> bool:
        """Whether the mu of two laws differ by less than their errors explain."""
        difference = float(np.sqrt(np.mean((fitted[first] - fitted[second]) ** 2)))
        limit = _SAME_WITHIN * min(errors[first], errors[second])
        return bool(reaches(limit, difference, size=rms_measured_mu))

    same_laws: dict[str, tuple[str, ...]] = {}
    for law in in_order:
        preferred = [other for other in same_laws if are_same(other, law)]
        if preferred:
            same_laws[preferred[0]] += (law,)
        else:
            same_laws[law] = ()
    return same_laws


def _error_of_fit(mu_of_law: pd.DataFrame) -> float:
    """Standard error of a law's fitted mu, root-mean-square over the points.

    With the errors e of curve i in a fit without it, and the leverage H_i of the curve, the mean
    variance of mu is the mean of e^T H_i e, where H_i e is the change of mu by leaving the curve
    out. It is that of the jackknife, in which the points of a curve share its errors. It is 0 where
    a curve was not left out: only rounding then makes two laws the same.

    Reference: R. M. Bell, D. F. McCaffrey, Surv. Methodol. 28 (2002) 169 (CR3).
    """
    left_out = mu_of_law["left_out_traction_coefficient"]
    change = left_out - mu_of_law["traction_coefficient"]
    error = left_out - mu_of_law[_MEASURED]
    variance = (change * error).mean(skipna=False)
    # the identity holds for small changes; a fit that jumps may give less than 0
    return float(np.sqrt(max(variance, 0.0))) if np.isfinite(variance) else 0.0


def _sse_of_curves(mu_by_law: _MuByLaw, laws: "pd.Index[str]", column: str) -> pd.DataFrame:
    """Sum of squared errors of each curve, one column per law.

    Laws without an error at some point are left out.

    Args:
        mu_by_law: mu of every law beside the measured mu.
        laws: The laws that are compared.
        column: mu of the laws.
    """
    sums = {}
    for law in laws.intersection(list(mu_by_law), sort=False):
        mu_of_law = mu_by_law[law]
        squares = (mu_of_law[column] - mu_of_law[_MEASURED]) ** 2
        sums_of_curves = squares.groupby(mu_of_law["run_id"], observed=True).sum(skipna=False)
        sums[law] = sums_of_curves.set_axis(sums_of_curves.index.astype("str"))
    return pd.DataFrame(sums).dropna(axis=1)


def _ranking(
    preferred: list[str],
    values: "pd.Series[float]",
    values_without_curve: pd.DataFrame,
    tie_below: float = 0.0,
) -> Ranking:
    """The laws by one criterion; the smallest value is best.

    Args:
        preferred: The laws in the order in which they are preferred where they are equally good;
            the configured law is the first.
        values: Criterion by law.
        values_without_curve: The criterion without each curve in turn, one column per law.
        tie_below: A smaller difference is a tie.
    """
    in_order = values[[name for name in preferred if name in values]]
    best = str(in_order.index[first_smallest(in_order)])
    differences = values - values[best]
    differences_without_curve = values_without_curve.sub(values_without_curve[best], axis=0)
    errors = {
        str(name): jackknife_error(replicates.to_numpy())
        for name, replicates in differences_without_curve.items()
    }
    ties = [best]
    for name, error in errors.items():
        limit = max(error, tie_below)
        if name != best and reaches(limit, differences[name], size=abs(values[best])):
            ties.append(name)
    configured = preferred[0]
    return Ranking(best, ties, float(differences[configured]), errors[configured])


def jackknife_error(replicates: FloatArray) -> float:
    """Half width of the 95 % interval of a statistic, from its values without each curve in turn.

    Reference: B. Efron, C. Stein, Ann. Stat. 9 (1981) 586.

    Examples:
        For a mean it is that of Student: for 1, 2, 3, 4 it is t(3) s/sqrt(4), 3.18245 * 1.29099/2

        >>> values = np.array([1.0, 2.0, 3.0, 4.0])
        >>> print(f"{jackknife_error((values.sum() - values) / 3):.4f}")
        2.0543
    """
    count = len(replicates)
    variance = (count - 1) / count * np.sum((replicates - replicates.mean()) ** 2)
    return float(student_quantile(CONFIDENCE, count - 1) * np.sqrt(variance))


def _best_at_ends(laws: pd.DataFrame) -> str:
    """The law with the least error at end levels that were left out; empty where none is known.

    Args:
        laws: Rows of `fit_quality`, the preferred laws first.
    """
    errors = laws.filter(regex="_end_out_relative_rms$").astype(float)
    errors = errors.dropna(axis=1, how="all").dropna()
    if errors.empty or not len(errors.columns):
        return ""
    mean_squares = (errors**2).mean(axis=1)
    return str(errors.index[first_smallest(mean_squares)])


def _judgement(
    configured_law: str, left_out: Ranking, by_bic: Ranking, laws: pd.DataFrame
) -> tuple[str, str]:
    """Verdict on the configured law, and the law to use instead.

    Args:
        configured_law: The configured law.
        left_out: The laws by their error at curves left out.
        by_bic: The laws by their BIC.
        laws: Rows of `fit_quality` of the compared laws.
    """
    best_by_both = [name for name in left_out.ties if name in by_bic.ties]
    if best_by_both == [configured_law]:
        return "best", ""
    if configured_law in best_by_both:
        return "tie", ""
    if configured_law in left_out.ties or configured_law in by_bic.ties:
        return "criteria disagree", ""
    # both criteria refuse the configured law; where they name different laws, the curves left out
    # decide. A certified fit comes first, then the fewest constants.
    candidates = best_by_both if best_by_both else list(left_out.ties)
    in_order = laws.loc[candidates].sort_values(
        ["certified", "n_constants"], ascending=[False, True], kind="stable"
    )
    return "another law is better", str(in_order.index[0])
