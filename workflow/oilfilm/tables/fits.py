"""Tables of the fits: constants, their proof and uncertainty, the laws compared."""

import numpy as np
from pandera.typing.pandas import Series

from oilfilm.tables.fields import Table, count, flag, number, text
from oilfilm.units import ABSOLUTE_ZERO_C


class Coefficients(Table):
    """One constant of one traction law for one oil."""

    oil: Series[str] = text("oil")
    law: Series[str] = text("traction law")
    constant: Series[str] = text("name as in the law's equation")
    value: Series[float] = number("fitted value; null where not identifiable", gaps=True)
    standard_error: Series[float] = number(
        "from resampling whole curves, so that errors shared by a run are in it",
        at_least=0,
        gaps=True,
    )
    lower: Series[float] = number("2.5 % quantile of the resampled fits", gaps=True)
    upper: Series[float] = number("97.5 % quantile", gaps=True)
    naive_standard_error: Series[float] = number(
        "from the Jacobian, as if every point were independent: too small wherever a run has "
        "errors of its own",
        at_least=0,
        gaps=True,
    )
    systematic_standard_error: Series[float] = number(
        "from the calibration of the rig's sensors, which no repetition lowers and which is not in "
        "standard_error; null where the rig file states none",
        at_least=0,
        gaps=True,
    )
    profile_lower: Series[float] = number(
        "lower end of the 95 % interval by profile likelihood, which like the naive error takes "
        "every point for independent; null where the profile does not reach it",
        gaps=True,
    )
    profile_upper: Series[float] = number("its upper end", gaps=True)
    weighted_value: Series[float] = number(
        "fitted with points weighted by their standard errors and the excess scatter", gaps=True
    )
    robust_value: Series[float] = number("fitted with a Cauchy loss", gaps=True)
    identifiable: Series[bool] = flag("false where the tested conditions cannot give it")
    verdict: Series[str] = text(
        "sign unknown: no effect at all lies within the errors, for all constants together; at a "
        "bound: of the search, past which the data would have it",
        one_of=("known", "sign unknown", "no interval", "at a bound", "not identifiable"),
    )
    printed_value: Series[float] = number("value printed in the paper, signs restored", gaps=True)


class FitQuality(Table):
    """How good one law's fit to one oil is, and the proof that it is the best one."""

    oil: Series[str] = text("oil")
    law: Series[str] = text("traction law")
    n_points: Series[np.int64] = count("accepted points fitted")
    n_curves: Series[np.int64] = count("runs they come from")
    sse: Series[float] = number("sum of squared errors of mu (Eq. 10)", at_least=0, gaps=True)
    rmse: Series[float] = number("root-mean-square error of mu", at_least=0, gaps=True)
    relative_rms: Series[float] = number(
        "rmse over the root-mean-square of measured mu", at_least=0, gaps=True
    )
    max_error: Series[float] = number("largest |fitted - measured| mu", at_least=0, gaps=True)
    weighted_difference: Series[float] = number(
        "root-mean-square difference of mu between the weighted fit and this one, over the points, "
        "relative to mu; null where no point has a standard error",
        at_least=0,
        gaps=True,
    )
    robust_difference: Series[float] = number("the same of the robust fit", at_least=0, gaps=True)
    pulling_curves: Series[str] = text(
        "runs that the robust fit all but ignores, worst first, joined by '; '"
    )
    searches: Series[np.int64] = count("independent global searches, each from its own seed")
    searches_agreeing: Series[np.int64] = count("of them, those that ended at the best optimum")
    sse_spread: Series[float] = number(
        "(largest - best) / best SSE over the searches", at_least=0, gaps=True
    )
    constant_spread: Series[float] = number(
        "largest difference of a constant between searches, in naive standard errors",
        at_least=0,
        gaps=True,
    )
    gradient_cosine: Series[float] = number(
        "largest |cos| between the residual and a column of the Jacobian: 0 at an optimum",
        at_least=0,
        gaps=True,
    )
    min_traction: Series[float] = number(
        "smallest mu on a dense grid over the tested box", gaps=True
    )
    condition_number: Series[float] = number(
        "of the Jacobian with columns of length 1: how nearly constants stand in for each other",
        at_least=1,
        gaps=True,
    )
    hessian_smallest: Series[float] = number(
        "smallest eigenvalue of the Hessian of half the SSE by the internal constants",
        at_least=0,
        gaps=True,
    )
    hessian_largest: Series[float] = number("its largest eigenvalue", at_least=0, gaps=True)
    active_bounds: Series[str] = text("constants that ended at a bound of the search; else empty")
    certified: Series[bool] = flag("true where every part of the certificate holds")
    verdict: Series[str] = text("the certificate in a sentence")
    fixed_conditions: Series[str] = text(
        "conditions that did not vary enough to give exponents, with their level"
    )
    tested_min_max_hertz_pressure_gpa: Series[float] = number(
        "smallest of the accepted points; null where unknown", gaps=True
    )
    tested_max_max_hertz_pressure_gpa: Series[float] = number("largest", gaps=True)
    tested_min_entrainment_speed_m_s: Series[float] = number("smallest", gaps=True)
    tested_max_entrainment_speed_m_s: Series[float] = number("largest", gaps=True)
    tested_min_inlet_temperature_c: Series[float] = number("smallest", gaps=True)
    tested_max_inlet_temperature_c: Series[float] = number("largest", gaps=True)
    tested_min_load_n: Series[float] = number("smallest", gaps=True)
    tested_max_load_n: Series[float] = number("largest", gaps=True)
    tested_min_slide_roll_ratio: Series[float] = number("smallest size", gaps=True)
    tested_max_slide_roll_ratio: Series[float] = number("largest size", gaps=True)


class Refits(Table):
    """One constant of one refit; the spread of the refits says how sure the constants are."""

    oil: Series[str] = text("oil")
    law: Series[str] = text("traction law")
    cause: Series[str] = text(
        "curves drawn again: to as many whole curves drawn with replacement; calibration of a "
        "sensor: that sensor off by its standard uncertainty",
    )
    refit: Series[np.int64] = count("number of the refit, of one cause")
    constant: Series[str] = text("name as in the table of coefficients")
    value: Series[float] = number("refitted value")


class Correlations(Table):
    """How two constants of a fit move together."""

    oil: Series[str] = text("oil")
    law: Series[str] = text("traction law")
    constant: Series[str] = text("name as in the table of coefficients")
    other: Series[str] = text("the other one")
    correlation: Series[float] = number(
        "over refits to curves drawn again; by the Jacobian where there are none",
        at_least=-1 - 1e-9,
        at_most=1 + 1e-9,
        gaps=True,
    )


class Profiles(Table):
    """One place of a profile likelihood: a constant held, all others fitted."""

    oil: Series[str] = text("oil")
    law: Series[str] = text("traction law")
    constant: Series[str] = text("constant held")
    value: Series[float] = number("at this value", gaps=True)
    signed_root: Series[float] = number(
        "signed root of the rise of the least SSE over the residual variance: for a linear law the "
        "distance from the optimum in naive standard errors",
        gaps=True,
    )


class CurveResiduals(Table):
    """How one run's curve lies to the fit of its oil."""

    oil: Series[str] = text("oil")
    law: Series[str] = text("traction law")
    run_id: Series[str] = text("run")
    n_points: Series[np.int64] = count("accepted points of it")
    rmse: Series[float] = number("root-mean-square error of mu", at_least=0)
    gain: Series[float] = number("factor by which the fit comes nearest to the curve")
    robust_weight: Series[float] = number(
        "mean weight of its points in the robust fit, 1 for points on the fit",
        at_least=0,
        at_most=1,
    )


class Comparison(Table):
    """One law's fit to one oil, judged on what it was fitted to and on what it has not seen."""

    oil: Series[str] = text("oil")
    law: Series[str] = text("traction law")
    n_points: Series[np.int64] = count("accepted points fitted")
    n_curves: Series[np.int64] = count("runs they come from")
    n_constants: Series[np.int64] = count("constants fitted, those that ended at a bound included")
    sse: Series[float] = number("sum of squared errors of mu (Eq. 10)", at_least=0, gaps=True)
    rmse: Series[float] = number("root-mean-square error of mu", at_least=0, gaps=True)
    relative_rms: Series[float] = number(
        "rmse over the root-mean-square of measured mu", at_least=0, gaps=True
    )
    max_error: Series[float] = number("largest |fitted - measured| mu", at_least=0, gaps=True)
    aic: Series[float] = number(
        "Akaike's information criterion; takes every point for independent, so that differences "
        "look surer than they are",
        gaps=True,
    )
    bic: Series[float] = number("Bayesian information criterion; the same holds", gaps=True)
    left_out_rmse: Series[float] = number(
        "root-mean-square error of mu at curves that were left out of the fit one at a time; null "
        "where the others do not give every constant",
        at_least=0,
        gaps=True,
    )
    pressure_end_out_relative_rms: Series[float] = number(
        "root-mean-square error at the lowest and at the highest level of pressure, each left out "
        "as a whole and extrapolated to, over the root-mean-square of mu there; null where the "
        "other levels do not give every constant",
        at_least=0,
        gaps=True,
    )
    speed_end_out_relative_rms: Series[float] = number(
        "the same of entrainment speed", at_least=0, gaps=True
    )
    temperature_end_out_relative_rms: Series[float] = number(
        "the same of inlet temperature", at_least=0, gaps=True
    )
    zero_slip_traction: Series[float] = number(
        "mu at no slip, where its size is largest over the tested conditions; should be 0",
        gaps=True,
    )
    negative_share: Series[float] = number(
        "share of the tested box where mu is below zero", at_least=0, at_most=1, gaps=True
    )
    second_rise_share: Series[float] = number(
        "share of the tested conditions at which mu rises again after its peak",
        at_least=0,
        at_most=1,
        gaps=True,
    )
    condition_number: Series[float] = number(
        "of the Jacobian with columns of length 1: how nearly constants stand in for each other",
        at_least=1,
        gaps=True,
    )
    certified: Series[bool] = flag("true where every part of the certificate holds")
    verdict: Series[str] = text("the certificate in a sentence")


class Extrapolation(Table):
    """One condition of a simulated campaign: what a fitted law says, and what is true.

    It shows what laws do in a world like the simulated one and decides nothing about real oils.
    """

    oil: Series[str] = text("oil")
    law: Series[str] = text("traction law")
    figure: Series[str] = text("figure of the paper that has the condition")
    max_hertz_pressure_gpa: Series[float] = number("maximum Hertz pressure", at_least=0)
    entrainment_speed_m_s: Series[float] = number("entrainment speed", at_least=0)
    inlet_temperature_c: Series[float] = number("inlet temperature", at_least=ABSOLUTE_ZERO_C)
    load_n: Series[float] = number("normal load that gives the pressure on the rig", at_least=0)
    slide_roll_ratio: Series[float] = number("slide-roll ratio", at_least=0)
    beyond: Series[str] = text(
        "conditions that lie outside the levels at which the oil was tested, joined by ', '; "
        "empty inside"
    )
    true_traction_coefficient: Series[float] = number("mu of the truth", at_least=0)
    traction_coefficient: Series[float] = number(
        "mu of the fitted law, cut off at 1e6; null where nothing was fitted", gaps=True
    )
    lower: Series[float] = number(
        "lower end of the fit's own 95 % interval; null where it has none", gaps=True
    )
    upper: Series[float] = number("its upper end", gaps=True)


class ExtrapolationErrors(Table):
    """Errors of one fitted law for one oil against the truth, of one figure and one region.

    It shows what laws do in a world like the simulated one and decides nothing about real oils.
    """

    law: Series[str] = text("traction law")
    oil: Series[str] = text("oil")
    figure: Series[str] = text("figure of the paper")
    beyond: Series[str] = text("as in the table extrapolation")
    n_points: Series[np.int64] = count("conditions compared")
    rmse: Series[float] = number("root-mean-square error of mu", at_least=0, gaps=True)
    relative_rms: Series[float] = number(
        "rmse over the root-mean-square of true mu", at_least=0, gaps=True
    )
    mean_error: Series[float] = number("mean of fitted minus true mu", gaps=True)
    max_error: Series[float] = number("largest |fitted - true| mu", at_least=0, gaps=True)
    interval_ratio: Series[float] = number(
        "share of the conditions at which the fit's own 95 % interval holds the truth; null where "
        "the fit has none",
        at_least=0,
        at_most=1,
        gaps=True,
    )
    worst_max_hertz_pressure_gpa: Series[float] = number("where that is", gaps=True)
    worst_entrainment_speed_m_s: Series[float] = number("where that is", gaps=True)
    worst_inlet_temperature_c: Series[float] = number("where that is", gaps=True)
    worst_slide_roll_ratio: Series[float] = number("where that is", gaps=True)
    worst_true_traction_coefficient: Series[float] = number("mu of the truth there", gaps=True)
    worst_traction_coefficient: Series[float] = number("mu of the fitted law there", gaps=True)


TABLES: dict[str, type[Table]] = {
    "coefficients": Coefficients,
    "law_coefficients": Coefficients,
    "fit_quality": FitQuality,
    "law_fit_quality": FitQuality,
    "refits": Refits,
    "law_refits": Refits,
    "correlations": Correlations,
    "profiles": Profiles,
    "curve_residuals": CurveResiduals,
    "comparison": Comparison,
    "extrapolation": Extrapolation,
    "extrapolation_errors": ExtrapolationErrors,
}
# columns that no two rows of a table share
KEYS: dict[str, tuple[str, ...]] = {
    "coefficients": ("oil", "law", "constant"),
    "law_coefficients": ("oil", "law", "constant"),
    "fit_quality": ("oil", "law"),
    "law_fit_quality": ("oil", "law"),
    "refits": ("oil", "law", "cause", "refit", "constant"),
    "law_refits": ("oil", "law", "cause", "refit", "constant"),
    "correlations": ("oil", "law", "constant", "other"),
    "curve_residuals": ("oil", "law", "run_id"),
    "comparison": ("oil", "law"),
    "extrapolation_errors": ("law", "oil", "figure", "beyond"),
}
