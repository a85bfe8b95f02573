"""One law fitted to one oil: searches, certificate, errors, and the tables of the result."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from typing import Any

import numpy as np
import pandas as pd
from scipy.special import ndtri

from oilfilm import tables
from oilfilm.fitting.certificate import Certificate, certify
from oilfilm.fitting.engine import Optimum, at_bounds, search
from oilfilm.fitting.objectives import (
    Alternative,
    curve_weights,
    difference,
    pulling_curves,
    robust_fit,
    weighted_fit,
)
from oilfilm.fitting.problem import (
    CurveData,
    Problem,
    build_problem,
    curve_data,
    varied_conditions,
)
from oilfilm.fitting.profile import profile_interval, profiles
from oilfilm.fitting.remarks import fit_remarks
from oilfilm.fitting.systematic import SENSORS, calibration_refits
from oilfilm.fitting.uncertainty import Estimates, curve_bootstrap, naive_covariance
from oilfilm.randomness import generator
from oilfilm.traction import LAWS
from oilfilm.traction.law import BoolArray, FloatArray, Law

# What the tested box is of, and the columns of `fit_quality` that hold it.
BOX = (
    "max_hertz_pressure_gpa",
    "entrainment_speed_m_s",
    "inlet_temperature_c",
    "load_n",
    "slide_roll_ratio",
)


@dataclass(frozen=True)
class Found:
    """All that a fit found, before it becomes tables.

    Attributes:
        problem: What was fitted; constants that ran into a bound are held there.
        data: The curves it was fitted to.
        best: The best end of the searches.
    """

    problem: Problem
    data: CurveData
    best: Optimum
    certificate: Certificate
    estimates: Estimates
    profile: tuple[FloatArray, FloatArray]
    weighted: Alternative | None
    robust: Alternative | None


@dataclass(frozen=True)
class OilFit:
    """The tables of one oil's fit, each field named as its table, and what they were made from.

    `found` is None where the data could not be fitted.
    """

    coefficients: pd.DataFrame
    fit_quality: pd.DataFrame
    refits: pd.DataFrame
    correlations: pd.DataFrame
    profiles: pd.DataFrame
    curve_residuals: pd.DataFrame
    found: Found | None

    def tables(self) -> dict[str, pd.DataFrame]:
        """Name of each table and its rows."""
        return {one.name: getattr(self, one.name) for one in fields(self) if one.name != "found"}

    def remarks(self) -> list[str]:
        """What whoever uses the constants must know, a sentence each."""
        return [remark for row in tables.rows(self.fit_quality) for remark in fit_remarks(row)]


def fit_oil(
    points: pd.DataFrame, oil: str, printed: FloatArray | None, config: Mapping[str, Any]
) -> OilFit:
    """Fit the configured law to one oil's accepted points.

    Args:
        points: Table of points of the campaign.
        oil: Oil to fit.
        printed: The constants printed for that oil, None where there are none.
        config: The resolved configuration.

    Returns:
        The oil's rows of the tables of a fit. Data that cannot be fitted give rows without values
        and a verdict that says why.
    """
    of_oil = points[points["oil"] == oil]
    return fit_law(of_oil, oil, LAWS[config["fit"]["law"]], printed, config)


def fit_law(
    points: pd.DataFrame,
    oil: str,
    law: Law,
    printed: FloatArray | None,
    config: Mapping[str, Any],
) -> OilFit:
    """Fit one law to the accepted points of one oil.

    Args:
        points: The oil's rows of the table of points.
        oil: Its name.
        law: What to fit; config's `fit.law` is not asked.
        printed: As `fit_oil`.
        config: As `fit_oil`.

    Returns:
        As `fit_oil`.
    """
    settings = config["fit"]
    data = curve_data(points, law.conditions)
    varied = varied_conditions(data.conditions, settings)
    about = {"oil": oil, "law": law.name}
    quality = {
        **about,
        "n_points": len(data.mu),
        "n_curves": len(data.runs),
        "fixed_conditions": _fixed_conditions(law, data, varied),
        **_tested_box(points),
    }
    try:
        problem = build_problem(law, data, varied)
        _refuse_hopeless(problem, data)
    except ValueError as error:
        return _unfitted(law, about, quality, printed, f"not fitted: {error}")
    found = _fit(problem, data, points, varied, oil, config)
    return OilFit(
        coefficients=_coefficients(found, about, printed, settings),
        fit_quality=tables.from_rows([quality | _quality(found, settings)], "fit_quality"),
        refits=_refits(found, about),
        correlations=_correlations(found, about),
        profiles=_profiles(found, about),
        curve_residuals=_curve_residuals(found, about),
        found=found,
    )


def _refuse_hopeless(problem: Problem, data: CurveData) -> None:
    """Raise a ValueError that says in words why no law can be fitted to such data."""
    if not len(data.mu):
        raise ValueError("0 accepted points")
    lost = int((~np.isfinite(data.mu) | ~np.isfinite(data.slip)).sum())
    if lost:
        raise ValueError(f"{lost} accepted points have no traction coefficient or no slip")
    if not np.any(data.slip):
        raise ValueError("every slide-roll ratio is zero, where traction says nothing")
    if not np.any(data.mu > 0):
        raise ValueError(
            "no accepted point has traction above zero; is the sign of the force right "
            "(semantics of the campaign file)?"
        )
    levels = data.conditions[data.curve]
    distinct = len(np.unique(np.column_stack([levels, data.slip, data.mu]), axis=0))
    needed = int(problem.free.sum()) + 1
    if distinct < needed:
        copies = f", {distinct} of them distinct" if distinct < len(data.mu) else ""
        raise ValueError(
            f"{len(data.mu)} accepted points{copies}; at least {needed} distinct ones are needed"
        )
    if np.ptp(data.mu) == 0:
        raise ValueError(f"mu is {data.mu[0]:.4g} at every point, whatever the slip")


def _fit(
    problem: Problem,
    data: CurveData,
    points: pd.DataFrame,
    varied: BoolArray,
    oil: str,
    config: Mapping[str, Any],
) -> Found:
    settings, seed = config["fit"], config["seed"]
    optima = [
        search(problem, settings, generator(seed, "search", oil, number))
        for number in range(settings["searches"])
    ]
    best = min(optima, key=lambda optimum: optimum.sse)
    stuck = at_bounds(problem, best.values)
    problem = problem.holding(best.values, stuck)
    optima = [Optimum(optimum.values[~stuck], optimum.sse) for optimum in optima]
    best = min(optima, key=lambda optimum: optimum.sse)
    naive = naive_covariance(problem, best)
    refits = np.empty((0, len(best.values)))
    if len(data.runs) >= settings["min_curves_to_resample"]:
        random = generator(seed, "bootstrap", oil)
        refits = curve_bootstrap(problem, best, settings["bootstrap"], random)
    shifted = calibration_refits(problem, best, points, varied)
    return Found(
        problem,
        data,
        best,
        certify(problem, data, optima, np.sqrt(np.diag(naive)), settings),
        Estimates(best.values, naive, refits, shifted),
        profiles(problem, best, np.sqrt(np.diag(naive))),
        weighted_fit(problem, data, best),
        robust_fit(problem, best),
    )


def _fixed_conditions(law: Law, data: CurveData, varied: BoolArray) -> str:
    """The conditions that give no exponent, with their level, in words."""
    levels = data.conditions.mean(axis=0) if len(data.conditions) else np.full(len(varied), np.nan)
    return "; ".join(
        f"{name} unknown" if np.isnan(level) else f"{name} {level:.4g} {tables.unit_of(name)}"
        for name, level, varies in zip(law.conditions, levels, varied, strict=True)
        if not varies
    )


def _tested_box(points: pd.DataFrame) -> dict[str, float]:
    """Smallest and largest value of each condition over the accepted points, NaN if unknown."""
    accepted = points.loc[points["accepted"], list(BOX)].abs()
    low, high = accepted.min(), accepted.max()
    return {
        **{f"tested_min_{name}": float(low[name]) for name in BOX},
        **{f"tested_max_{name}": float(high[name]) for name in BOX},
    }


def _coefficients(
    found: Found, about: Mapping[str, str], printed: FloatArray | None, settings: Mapping[str, Any]
) -> pd.DataFrame:
    law, problem = found.problem.law, found.problem
    rows = _constant_rows(found, settings["sign_confidence"])
    names = [constant.name for constant in law.constants if constant.known is None]
    stuck = [
        _no_value(name) | {"value": value, "verdict": "at a bound"}
        for name, value in problem.at_bounds.items()
    ]
    # the level of a condition that did not vary is inside X0: neither can be told apart
    told = {*problem.names, *problem.at_bounds}
    lost = [_no_value(name) for name in names if name not in told]
    order = [*names, *law.local_constants]
    rows = sorted([*rows, *stuck, *lost], key=lambda row: order.index(row["constant"]))
    return _coefficient_table(rows, law, about, printed)


def _constant_rows(found: Found, sign_confidence: float) -> list[dict[str, Any]]:
    problem, estimates = found.problem, found.estimates.reported(found.problem)
    systematic = estimates.systematic_errors
    places, z = found.profile
    degrees = len(problem.mu) - len(found.best.values)
    others = {
        f"{name}_value": None if other is None else problem.reported(other.values)
        for name, other in (("weighted", found.weighted), ("robust", found.robust))
    }
    rows = []
    for place, name in enumerate(problem.names):
        row = _no_value(name) | {
            "value": estimates.values[place],
            "naive_standard_error": estimates.naive_errors[place],
            "systematic_standard_error": systematic[place],
            "identifiable": True,
            "verdict": "no interval",
            **{key: np.nan if of is None else of[place] for key, of in others.items()},
        }
        crossings = profile_interval(places[place], z[place], degrees)
        ends = sorted(_reported_one(problem, end, place) for end in crossings)
        row |= {"profile_lower": ends[0], "profile_upper": ends[1]}
        if len(estimates.refits):
            drawn = estimates.refits[:, place]
            lower, upper = np.quantile(drawn, [0.025, 0.975])
            error = float(drawn.std(ddof=1))
            row |= {"standard_error": error, "lower": lower, "upper": upper}
            reach = sign_reach(len(problem.names), sign_confidence)
            sure = np.abs(row["value"]) > reach * np.hypot(error, np.nan_to_num(systematic[place]))
            row["verdict"] = "known" if sure and lower * upper > 0 else "sign unknown"
        rows.append(row)
    return rows


def sign_reach(constants: int, confidence: float) -> float:
    """Standard errors that a constant must lie from zero for its sign to be called known.

    A fit calls the signs of all its constants at once: by an interval of 95 % each, of twelve
    constants without effect one would be called wrongly every second time. Hence Bonferroni's
    limit, for all of them together.

    Args:
        constants: Constants that are judged.
        confidence: That no sign is called wrongly, as a share.
    """
    return float(ndtri(1 - (1 - confidence) / (2 * constants)))


def _reported_one(problem: Problem, value: float, place: int) -> float:
    values = np.zeros(len(problem.names))
    values[place] = value
    return float(problem.reported(values)[place])


_NUMBERS_OF_A_CONSTANT = (
    "value",
    "standard_error",
    "lower",
    "upper",
    "naive_standard_error",
    "profile_lower",
    "profile_upper",
    "systematic_standard_error",
    "weighted_value",
    "robust_value",
)


def _no_value(name: str) -> dict[str, Any]:
    return {
        "constant": name,
        **dict.fromkeys(_NUMBERS_OF_A_CONSTANT, np.nan),
        "identifiable": False,
        "verdict": "not identifiable",
    }


def _coefficient_table(
    rows: list[dict[str, Any]], law: Law, about: Mapping[str, str], printed: FloatArray | None
) -> pd.DataFrame:
    frame = pd.DataFrame(rows).assign(**about)
    names = [constant.name for constant in law.constants]
    values = dict(zip(names, printed, strict=True)) if printed is not None else {}
    frame["printed_value"] = frame["constant"].map(values).astype(float)
    return tables.conform(frame, "coefficients", f"fit of {about['oil']}")


def _quality(found: Found, settings: Mapping[str, Any]) -> dict[str, Any]:
    problem, data = found.problem, found.data
    residual = problem.residual(found.best.values)
    rmse = float(np.sqrt(np.mean(residual**2)))
    weights = curve_weights(problem, found.robust)
    return {
        "sse": found.best.sse,
        "rmse": rmse,
        "relative_rms": rmse / float(np.sqrt(np.mean(data.mu**2))),
        "max_error": float(np.abs(residual).max()),
        "weighted_difference": difference(problem, found.best, found.weighted),
        "robust_difference": difference(problem, found.best, found.robust),
        "pulling_curves": "; ".join(pulling_curves(data, weights, settings)),
        **asdict(found.certificate),
    }


def _refits(found: Found, about: Mapping[str, str]) -> pd.DataFrame:
    estimates = found.estimates.reported(found.problem)
    causes = [("curves drawn again", estimates.refits)]
    causes += [
        (f"calibration of {sensor}", row[np.newaxis])
        for sensor, row in zip(SENSORS, estimates.shifted, strict=False)
    ]
    names = found.problem.names
    frames = [
        pd.DataFrame(
            {
                "cause": cause,
                "refit": np.repeat(np.arange(len(values)), len(names)),
                "constant": names * len(values),
                "value": values.ravel(),
            }
        )
        for cause, values in causes
        if len(values)
    ]
    if not frames:
        return tables.empty("refits")
    whole = pd.concat(frames, ignore_index=True).assign(**about)
    return tables.conform(whole, "refits", f"fit of {about['oil']}")


def _correlations(found: Found, about: Mapping[str, str]) -> pd.DataFrame:
    first, second = np.triu_indices(len(found.problem.names), k=1)
    names = np.array(found.problem.names)
    values = found.estimates.reported(found.problem).correlation[first, second]
    frame = pd.DataFrame(
        {"constant": names[first], "other": names[second], "correlation": values}
    ).assign(**about)
    return tables.conform(frame, "correlations", f"fit of {about['oil']}")


def _profiles(found: Found, about: Mapping[str, str]) -> pd.DataFrame:
    problem = found.problem
    places, z = found.profile
    # a constant below zero falls where its logarithm rises
    turned = np.where(problem.signs < 0, -1, 1)[:, np.newaxis]
    frame = pd.DataFrame(
        {
            "constant": np.repeat(problem.names, places.shape[1]),
            "value": problem.reported(places.T).T.ravel(),
            "signed_root": (turned * z).ravel(),
        }
    ).assign(**about)
    return tables.conform(frame, "profiles", f"fit of {about['oil']}")


def _curve_residuals(found: Found, about: Mapping[str, str]) -> pd.DataFrame:
    problem, data = found.problem, found.data
    residual = problem.residual(found.best.values)
    fitted = data.mu + residual

    def over_curves(of_points: FloatArray) -> FloatArray:
        return np.add.reduceat(of_points, problem.starts)

    counts = over_curves(np.ones(len(data.mu)))
    gain = over_curves(data.mu * fitted) / np.maximum(over_curves(fitted**2), 1e-300)
    frame = pd.DataFrame(
        {
            "run_id": data.runs,
            "n_points": counts.astype(np.int64),
            "rmse": np.sqrt(over_curves(residual**2) / counts),
            "gain": gain,
            "robust_weight": curve_weights(problem, found.robust),
        }
    ).assign(**about)
    return tables.conform(frame, "curve_residuals", f"fit of {about['oil']}")


def _unfitted(
    law: Law,
    about: Mapping[str, str],
    quality: Mapping[str, Any],
    printed: FloatArray | None,
    why: str,
) -> OilFit:
    rows = [_no_value(constant.name) for constant in law.constants if constant.known is None]
    without = {
        "searches": 0,
        "searches_agreeing": 0,
        "active_bounds": "",
        "pulling_curves": "",
        "certified": False,
        "certificate": why,
    }
    row = {**dict.fromkeys(tables.columns("fit_quality"), np.nan), **quality, **without}
    return OilFit(
        coefficients=_coefficient_table(rows, law, about, printed),
        fit_quality=tables.from_rows([row], "fit_quality"),
        refits=tables.empty("refits"),
        correlations=tables.empty("correlations"),
        profiles=tables.empty("profiles"),
        curve_residuals=tables.empty("curve_residuals"),
        found=None,
    )
