"""One law fitted to one oil: searches, certificate, errors, and both tables of the result."""

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

import numpy as np
import pandas as pd

from oilfilm import tables
from oilfilm.fitting.certificate import Certificate, certify
from oilfilm.fitting.engine import Optimum, search
from oilfilm.fitting.problem import (
    BoolArray,
    CurveData,
    Problem,
    build_problem,
    curve_data,
    varied_conditions,
)
from oilfilm.fitting.systematic import calibration_refits
from oilfilm.fitting.uncertainty import Estimates, curve_bootstrap, naive_covariance
from oilfilm.randomness import generator
from oilfilm.traction import LAWS
from oilfilm.traction.law import CONDITIONS, FloatArray, Law, to_constants

_UNITS = dict(zip(CONDITIONS, ("GPa", "m/s", "degC"), strict=True))


def fit_oil(
    points: pd.DataFrame, oil: str, printed: FloatArray | None, config: Mapping[str, Any]
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Fit the configured law to one oil's accepted points.

    Args:
        points: Table of points of the campaign.
        oil: Oil to fit.
        printed: The constants printed for that oil, None where there are none.
        config: The resolved configuration.

    Returns:
        The oil's rows of the tables `coefficients` and `fit_quality`. Data that cannot be fitted
        give rows without values and a verdict that says why.
    """
    settings = config["fit"]
    law = LAWS[settings["law"]]
    of_oil = points[points["oil"] == oil]
    data = curve_data(of_oil)
    varied = varied_conditions(data.conditions, settings)
    fixed = _fixed_conditions(data, varied)
    try:
        problem = build_problem(law, data, varied)
    except ValueError as error:
        return _unfitted(law, oil, printed, data, fixed, f"not fitted: {error}")
    needed = int(problem.free.sum()) + 1
    if len(data.mu) < needed:
        why = f"not fitted: {len(data.mu)} accepted points, at least {needed} are needed"
        return _unfitted(law, oil, printed, data, fixed, why)
    return _fitted(problem, data, of_oil, varied, oil, printed, fixed, config)


def _fitted(
    problem: Problem,
    data: CurveData,
    points: pd.DataFrame,
    varied: BoolArray,
    oil: str,
    printed: FloatArray | None,
    fixed: str,
    config: Mapping[str, Any],
) -> tuple[pd.DataFrame, pd.DataFrame]:
    settings, seed = config["fit"], config["seed"]
    optima = [
        search(problem, settings, generator(seed, "search", oil, number))
        for number in range(settings["searches"])
    ]
    best = min(optima, key=lambda optimum: optimum.sse)
    naive = naive_covariance(problem, best)
    certificate = certify(problem, data, optima, np.sqrt(np.diag(naive)), settings)
    refits = np.empty((0, len(best.values)))
    if len(data.runs) >= settings["min_curves_to_resample"]:
        random = generator(seed, "bootstrap", oil)
        refits = curve_bootstrap(problem, best, settings["bootstrap"], random)
    shifted = calibration_refits(problem, best, points, varied)
    estimates = Estimates(best.values, naive, refits, shifted)
    coefficients = _coefficients(problem, estimates, oil, printed)
    return coefficients, _quality(problem, data, best, certificate, oil, fixed)


def _fixed_conditions(data: CurveData, varied: BoolArray) -> str:
    """The conditions that give no exponent, with their level, in words."""
    levels = data.conditions.mean(axis=0) if len(data.conditions) else np.full(3, np.nan)
    return "; ".join(
        f"{name} unknown" if np.isnan(level) else f"{name} {level:.4g} {_UNITS[name]}"
        for name, level, varies in zip(CONDITIONS, levels, varied, strict=True)
        if not varies
    )


def _coefficients(
    problem: Problem,
    estimates: Estimates,
    oil: str,
    printed: FloatArray | None,
) -> pd.DataFrame:
    law, free = problem.law, problem.free
    rows = []
    if free.all():
        rows = _constant_rows(
            [constant.name for constant in law.constants],
            estimates.through(lambda values: to_constants(law, values)),
        )
    else:
        # the level of a condition that did not vary is inside X0: neither can be told apart
        for constant in law.constants:
            known = constant.condition is not None and free[law.constants.index(constant)]
            rows += (
                _known_exponent(problem, estimates, constant.name)
                if known
                else [_constant_row(constant.name)]
            )
        rows += _local_rows(problem, estimates)
    frame = pd.DataFrame(rows).assign(oil=oil, law=law.name)
    names = [constant.name for constant in law.constants]
    values = dict(zip(names, printed, strict=True)) if printed is not None else {}
    frame["printed_value"] = frame["constant"].map(values).astype(float)
    return tables.conform(frame, "coefficients", f"fit of {oil}")


def _known_exponent(problem: Problem, estimates: Estimates, name: str) -> list[dict[str, Any]]:
    names = [constant.name for constant in problem.law.constants]
    place = int(problem.free[: names.index(name)].sum())
    return _constant_rows([name], estimates.through(lambda values: values[[place]]))


def _local_rows(problem: Problem, estimates: Estimates) -> list[dict[str, Any]]:
    """A, B and C for data of too few conditions.

    The conditions that gave exponents are taken at the law's reference, the others at the level
    that was tested.
    """
    design = problem.law.design(problem.law.reference)

    def local(values: FloatArray) -> FloatArray:
        return problem.law.local_values(problem.expand(values), design)[0]

    return _constant_rows(list(problem.law.local_constants), estimates.through(local))


def _constant_rows(names: list[str], estimates: Estimates) -> list[dict[str, Any]]:
    naive_errors, systematic = estimates.naive_errors, estimates.systematic_errors
    rows = []
    for place, name in enumerate(names):
        row = _constant_row(name, float(estimates.values[place]), float(naive_errors[place]))
        row["systematic_standard_error"] = float(systematic[place])
        if len(estimates.refits):
            drawn = estimates.refits[:, place]
            lower, upper = np.quantile(drawn, [0.025, 0.975])
            sign = "sign unknown" if lower <= 0 <= upper else "known"
            row |= {"standard_error": drawn.std(ddof=1), "lower": lower, "upper": upper}
            row["verdict"] = sign
        rows.append(row)
    return rows


def _constant_row(name: str, value: float = np.nan, naive_error: float = np.nan) -> dict[str, Any]:
    return {
        "constant": name,
        "value": value,
        "standard_error": np.nan,
        "lower": np.nan,
        "upper": np.nan,
        "naive_standard_error": naive_error,
        "systematic_standard_error": np.nan,
        "identifiable": not np.isnan(value),
        "verdict": "not identifiable" if np.isnan(value) else "no interval",
    }


def _quality(
    problem: Problem,
    data: CurveData,
    best: Optimum,
    certificate: Certificate,
    oil: str,
    fixed: str,
) -> pd.DataFrame:
    residual = problem.residual(best.values)
    rmse = float(np.sqrt(np.mean(residual**2)))
    row = {
        "oil": oil,
        "law": problem.law.name,
        "n_points": len(data.mu),
        "n_curves": len(data.runs),
        "sse": best.sse,
        "rmse": rmse,
        "relative_rms": rmse / float(np.sqrt(np.mean(data.mu**2))),
        "max_error": float(np.abs(residual).max()),
        "fixed_conditions": fixed,
        **asdict(certificate),
    }
    return tables.from_rows([row], "fit_quality")


def _unfitted(
    law: Law, oil: str, printed: FloatArray | None, data: CurveData, fixed: str, why: str
) -> tuple[pd.DataFrame, pd.DataFrame]:
    rows = [_constant_row(constant.name) for constant in law.constants]
    values = printed if printed is not None else np.full(len(law.constants), np.nan)
    coefficients = pd.DataFrame(rows).assign(oil=oil, law=law.name, printed_value=values)
    numbers = (
        "sse",
        "rmse",
        "relative_rms",
        "max_error",
        "sse_spread",
        "constant_spread",
        "gradient_cosine",
        "min_traction",
        "condition_number",
        "hessian_smallest",
        "hessian_largest",
    )
    quality = {
        "oil": oil,
        "law": law.name,
        "n_points": len(data.mu),
        "n_curves": len(data.runs),
        "searches": 0,
        "searches_agreeing": 0,
        "active_bounds": "",
        "certified": False,
        "verdict": why,
        "fixed_conditions": fixed,
        **dict.fromkeys(numbers, np.nan),
    }
    return (
        tables.conform(coefficients, "coefficients", f"fit of {oil}"),
        tables.from_rows([quality], "fit_quality"),
    )
