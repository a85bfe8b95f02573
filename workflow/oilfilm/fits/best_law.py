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
from oilfilm.fits.interval import CONFIDENCE, student_half_width
from oilfilm.tables.campaign_tables import CampaignTables

# From fewer curves the error of a difference is not estimated: one degree of freedom and less.
FEWEST_CURVES = 3
_MEASURED_MU = "traction_coefficient_measured"
# Two laws are the same law on the points where their fitted mu differ by less than this share of
# the standard error of a fit, root-mean-square over the points. Four of sixteen constants that mean
# nothing move mu by sqrt(4/16) of it, in expectation. In `demo` and `thermal` the law on load and
# Eq. 7 differ by 0.2 to 0.3; the next pair of laws differs by 0.6.
_SAME_LAW_SHARE = 0.5

# By the name of the law: its mu at the points beside the measured mu, in the order of run and row.
_MuByLaw = Mapping[str, pd.DataFrame]
# Columns that name a point.
_POINT_KEY_COLUMNS = ["run_id", "first_row"]
_LAW_MU_COLUMNS = ["traction_coefficient", "left_out_traction_coefficient"]


@dataclass(frozen=True)
class Ranking:
    """The best law by one criterion, and those that tie with it.

    Attributes:
        best_law_name: Name of the best law.
        tied_law_names: Names of the laws that differ from it by no more than the uncertainty, the
            best law first.
        difference: Criterion of the configured law less that of the best law, 0 or more.
        difference_half_width: Half width of the 95 % interval of this difference.
    """

    best_law_name: str
    tied_law_names: Sequence[str]
    difference: float
    difference_half_width: float


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
        verdict = _verdict_columns(fit["law"], quality_of_oil, mu_by_law, bic_difference_min)
        rows.append({"oil": fit["oil"], "law": fit["law"], **verdict})
    return tables.filled_table(pd.DataFrame(rows), "law_verdicts")


def _mu_by_law(results: CampaignTables, oil: str, law_names: Iterable[str]) -> _MuByLaw:
    """mu of each law beside the measured mu, at the points of one oil.

    Laws are read one by one, and the name of each run is kept once: the points of all laws would be
    the largest table of a campaign.
    """
    measured_mu = results.table("points", [*_POINT_KEY_COLUMNS, "traction_coefficient"], oil=oil)
    measured_mu = measured_mu.rename(columns={"traction_coefficient": _MEASURED_MU})
    run_ids = pd.Index(sorted(measured_mu["run_id"].unique()))
    measured_mu = _with_numbered_runs(measured_mu, run_ids)
    mu_by_law = {}
    for law_name in law_names:
        points_of_law = results.table(
            "law_points", [*_POINT_KEY_COLUMNS, *_LAW_MU_COLUMNS], oil=oil, law=law_name
        )
        if points_of_law.empty:
            continue
        mu_of_law = _with_numbered_runs(points_of_law, run_ids).merge(
            measured_mu, on=_POINT_KEY_COLUMNS
        )
        mu_by_law[law_name] = mu_of_law.sort_values(_POINT_KEY_COLUMNS, ignore_index=True)
    return mu_by_law


def _with_numbered_runs(points: pd.DataFrame, run_ids: "pd.Index[str]") -> pd.DataFrame:
    """The points with `run_id` as a category: a number per point instead of a name.

    Args:
        points: With `run_id`.
        run_ids: Names of all runs, sorted.
    """
    run_of_point, distinct_run_ids = pd.factorize(points["run_id"])
    categories = pd.Categorical.from_codes(
        run_ids.get_indexer(distinct_run_ids)[run_of_point], run_ids
    )
    return points.assign(run_id=categories)


def _verdict_columns(
    configured_name: str, quality: pd.DataFrame, mu_by_law: _MuByLaw, bic_difference_min: float
) -> dict[str, Any]:
    """The columns of `law_verdicts` of one oil.

    Args:
        configured_name: Name of the configured law.
        quality: Rows of `fit_quality` of the oil.
        mu_by_law: mu of every law beside the measured mu at the oil's points.
        bic_difference_min: As in `best_laws`.
    """
    quality_by_law = quality.set_index("law")
    fitted_names = quality_by_law.index[quality_by_law["bic"].notna()]
    if len(quality_by_law) == 1:
        return {"verdict": "no other law"}
    if configured_name not in fitted_names:
        return {"verdict": "no fit"}
    # laws that were fitted to other points have other sums, and are not comparable
    runs_not_fitted = quality_by_law["incomplete_curves"].map(set)
    not_fitted_by_configured = runs_not_fitted[configured_name]
    has_same_points = runs_not_fitted.map(lambda run_ids: run_ids == not_fitted_by_configured)
    comparable = quality_by_law[has_same_points & quality_by_law["bic"].notna()]
    if len(comparable) == 1:
        return {"verdict": "no other fit"}
    # of laws that are equally good: the configured law, a certified fit, the fewest constants
    preferred_quality = comparable.assign(other=comparable.index != configured_name).sort_values(
        ["other", "certified", "n_constants"], ascending=[True, False, True], kind="stable"
    )
    same_laws = _same_laws(mu_by_law, list(preferred_quality.index))
    preferred_names = list(same_laws)
    preferred_quality = preferred_quality.loc[preferred_names]
    comparable = comparable.loc[preferred_names]
    left_out_sse = _sse_of_curves(mu_by_law, comparable.index, "left_out_traction_coefficient")
    if configured_name not in left_out_sse:
        return {"verdict": "constants left open"}
    if len(left_out_sse) < FEWEST_CURVES:
        return {"verdict": "too few curves"}
    points_of_law = mu_by_law[configured_name]
    by_curve = points_of_law.groupby("run_id", observed=True)
    points_per_curve = by_curve.size().to_numpy()[:, np.newaxis]
    point_count = points_per_curve.sum()
    total_sse = left_out_sse.sum()
    rmse_by_law = np.sqrt(total_sse / point_count)
    rmse_without_curve = np.sqrt((total_sse - left_out_sse) / (point_count - points_per_curve))
    by_left_out = _ranking(preferred_names, rmse_by_law, rmse_without_curve)
    fitted_sse = _sse_of_curves(mu_by_law, comparable.index, "traction_coefficient")
    # the differences have the error of Vuong's statistic (Econometrica 57 (1989) 307, section 5)
    bic_without_curve = point_count * np.log(fitted_sse.sum() - fitted_sse)
    by_bic = _ranking(preferred_names, comparable["bic"], bic_without_curve, bic_difference_min)
    rms_mu = float(np.sqrt(np.mean(points_of_law[_MEASURED_MU] ** 2)))
    verdict, better_name = _judgement(configured_name, by_left_out, by_bic, comparable)
    return {
        "verdict": verdict,
        "same_laws": same_laws[configured_name],
        "better_law": better_name,
        "same_as_better_law": same_laws.get(better_name, ()),
        "left_out_law": by_left_out.best_law_name,
        "left_out_ties": tuple(by_left_out.tied_law_names),
        "left_out_relative_rms": quality_by_law["left_out_rmse"][configured_name] / rms_mu,
        "best_left_out_relative_rms": quality_by_law["left_out_rmse"][by_left_out.best_law_name]
        / rms_mu,
        "left_out_difference": by_left_out.difference / rms_mu,
        "left_out_difference_error": by_left_out.difference_half_width / rms_mu,
        "bic_law": by_bic.best_law_name,
        "bic_ties": tuple(by_bic.tied_law_names),
        "bic_difference": by_bic.difference,
        "bic_difference_error": by_bic.difference_half_width,
        "ends_out_law": _best_law_at_ends(preferred_quality),
    }


def _same_laws(mu_by_law: _MuByLaw, law_names: Sequence[str]) -> dict[str, tuple[str, ...]]:
    """Names of the laws that differ on the points, each with those of the laws that equal it there.

    Args:
        mu_by_law: mu of every law beside the measured mu.
        law_names: Names of the laws, the preferred one first; their points are the same.
    """
    fitted_mu = {
        law_name: mu_by_law[law_name]["traction_coefficient"].to_numpy() for law_name in law_names
    }
    errors = {law_name: _error_of_fit(mu_by_law[law_name]) for law_name in law_names}
    rms_measured_mu = float(np.sqrt(np.mean(mu_by_law[law_names[0]][_MEASURED_MU] ** 2)))

    def are_same(law_name: str, other_name: str) -> bool:
        """Whether the mu of two laws differ by less than their errors explain."""
        difference = float(np.sqrt(np.mean((fitted_mu[law_name] - fitted_mu[other_name]) ** 2)))
        limit = _SAME_LAW_SHARE * min(errors[law_name], errors[other_name])
        return bool(reaches(limit, difference, term_size=rms_measured_mu))

    same_laws: dict[str, tuple[str, ...]] = {}
    for law_name in law_names:
        same_preferred = [other_name for other_name in same_laws if are_same(other_name, law_name)]
        if same_preferred:
            same_laws[same_preferred[0]] += (law_name,)
        else:
            same_laws[law_name] = ()
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
    error = left_out - mu_of_law[_MEASURED_MU]
    variance = (change * error).mean(skipna=False)
    # the identity holds for small changes; a fit that jumps may give less than 0
    return float(np.sqrt(max(variance, 0.0))) if np.isfinite(variance) else 0.0


def _sse_of_curves(mu_by_law: _MuByLaw, law_names: "pd.Index[str]", column: str) -> pd.DataFrame:
    """Sum of squared errors of each curve, one column per law.

    Laws without an error at some point are left out.

    Args:
        mu_by_law: mu of every law beside the measured mu.
        law_names: The laws that are compared.
        column: Column of the mu of the laws: fitted, or left out.
    """
    sse_by_law = {}
    for law_name in law_names.intersection(list(mu_by_law), sort=False):
        mu_of_law = mu_by_law[law_name]
        squares = (mu_of_law[column] - mu_of_law[_MEASURED_MU]) ** 2
        sums_of_curves = squares.groupby(mu_of_law["run_id"], observed=True).sum(skipna=False)
        sse_by_law[law_name] = sums_of_curves.set_axis(sums_of_curves.index.astype("str"))
    return pd.DataFrame(sse_by_law).dropna(axis=1)


def _ranking(
    preferred_names: list[str],
    criterion: "pd.Series[float]",
    criterion_without_curve: pd.DataFrame,
    tie_below: float = 0.0,
) -> Ranking:
    """The laws by one criterion; the smallest value is best.

    Args:
        preferred_names: Names of the laws, the preferred one first: it is taken where laws are
            equally good. The configured law is the first.
        criterion: Criterion by law.
        criterion_without_curve: The criterion without each curve in turn, one column per law.
        tie_below: A smaller difference is a tie.
    """
    preferred_criterion = criterion[
        [law_name for law_name in preferred_names if law_name in criterion]
    ]
    best_name = str(preferred_criterion.index[first_smallest(preferred_criterion)])
    differences = criterion - criterion[best_name]
    differences_without_curve = criterion_without_curve.sub(
        criterion_without_curve[best_name], axis=0
    )
    half_width_by_law = {
        str(law_name): jackknife_half_width(replicates.to_numpy())
        for law_name, replicates in differences_without_curve.items()
    }
    ties = [best_name]
    for law_name, half_width in half_width_by_law.items():
        limit = max(half_width, tie_below)
        if law_name != best_name and reaches(
            limit, differences[law_name], term_size=abs(criterion[best_name])
        ):
            ties.append(law_name)
    configured_name = preferred_names[0]
    return Ranking(
        best_name, ties, float(differences[configured_name]), half_width_by_law[configured_name]
    )


def jackknife_half_width(replicates: FloatArray) -> float:
    """Half width of the 95 % interval of a statistic, from its values without each curve in turn.

    Reference: B. Efron, C. Stein, Ann. Stat. 9 (1981) 586.

    Examples:
        For a mean it is that of Student: for 1, 2, 3, 4 it is t(3) s/sqrt(4), 3.18245 * 1.29099/2

        >>> values = np.array([1.0, 2.0, 3.0, 4.0])
        >>> print(f"{jackknife_half_width((values.sum() - values) / 3):.4f}")
        2.0543
    """
    curve_count = len(replicates)
    variance = (curve_count - 1) / curve_count * np.sum((replicates - replicates.mean()) ** 2)
    return float(student_half_width(CONFIDENCE, curve_count - 1) * np.sqrt(variance))


def _best_law_at_ends(quality: pd.DataFrame) -> str:
    """Name of the law with the least error at end levels left out; empty where none is known.

    Args:
        quality: Rows of `fit_quality`, the preferred laws first.
    """
    errors = quality.filter(regex="_end_out_relative_rms$").astype(float)
    errors = errors.dropna(axis=1, how="all").dropna()
    if errors.empty or not len(errors.columns):
        return ""
    mean_squares = (errors**2).mean(axis=1)
    return str(errors.index[first_smallest(mean_squares)])


def _judgement(
    configured_name: str, by_left_out: Ranking, by_bic: Ranking, quality: pd.DataFrame
) -> tuple[str, str]:
    """Verdict on the configured law, and the name of the law to use instead, or an empty name.

    Args:
        configured_name: Name of the configured law.
        by_left_out: The laws by their error at curves left out.
        by_bic: The laws by their BIC.
        quality: Rows of `fit_quality` of the compared laws.
    """
    best_by_both = [
        law_name for law_name in by_left_out.tied_law_names if law_name in by_bic.tied_law_names
    ]
    if best_by_both == [configured_name]:
        return "best", ""
    if configured_name in best_by_both:
        return "tie", ""
    if configured_name in by_left_out.tied_law_names or configured_name in by_bic.tied_law_names:
        return "criteria disagree", ""
    best_names = best_by_both or [*by_left_out.tied_law_names, *by_bic.tied_law_names]
    best_quality = quality.loc[list(dict.fromkeys(best_names))]
    # where the criteria name different laws, one of these may still be better by both
    criteria = ["left_out_rmse", "bic"]
    is_better = (best_quality[criteria] < quality.loc[configured_name, criteria]).all(axis=1)
    if not is_better.any():
        return "criteria disagree", ""
    # a certified fit comes first, then the fewest constants
    candidates = best_quality[is_better].sort_values(
        ["certified", "n_constants"], ascending=[False, True], kind="stable"
    )
    return "another law is better", str(candidates.index[0])
