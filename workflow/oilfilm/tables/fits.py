"""Tables of the fits: constants, their proof and uncertainty, the laws compared.

Decides: columns and key of the tables of fits.
"""

from oilfilm.tables.columns import (
    TEST_CONDITIONS,
    count,
    declare_columns,
    flag,
    number,
    share,
    table,
    text,
    use,
)
from oilfilm.tables.declaration import BY_ROW
from oilfilm.units import ABSOLUTE_ZERO_C

# One fit per oil and law: the tables that a fit writes.
OF_FIT = (
    *("coefficients", "fit_quality", "refits", "correlations", "profiles", "curve_residuals"),
    "law_points",
)

# fmt: off
_INDEPENDENT = "takes every point as independent"
_CONSTANT_UNIT = "unit of the constant in its law's equation, with P in GPa, U in m/s, T in degC"
declare_columns(
    text("law", "traction law"),
    text("constant", "constant, as named in the law's equation"),
    text("other", "the other constant of a pair; empty where there is none"),
    number("standard_error", BY_ROW, "standard error of the constant, by bootstrap over curves, so "
        "that errors shared by a run are included",
        f'systematic part not included; {_CONSTANT_UNIT}', at_least=0),
    *(
        number(end, BY_ROW, f"{end} end of the constant's interval, which also decides on its "
            "sign: it holds for all constants of the fit together (fit.sign_confidence of "
            "config.yaml, Bonferroni), calibration included; never narrower than the central 95 % "
            "of the refits", _CONSTANT_UNIT)
        for end in ("lower", "upper")
    ),
    number("naive_standard_error", BY_ROW, "standard error of the constant from the Jacobian",
        f'{_INDEPENDENT}: too small where a run has errors of its own; {_CONSTANT_UNIT}',
        at_least=0),
    number("systematic_standard_error", BY_ROW, "part of the constant's error from the calibration "
        "of the rig's sensors; null where the rig file has none",
        f'repeated tests do not reduce it; {_CONSTANT_UNIT}', at_least=0),
    number("profile_lower", BY_ROW, "lower end of the 95 % interval by profile likelihood; null "
        "where the profile does not reach it", f'{_INDEPENDENT}; {_CONSTANT_UNIT}'),
    number("profile_upper", BY_ROW, "upper end of the 95 % interval by profile likelihood; null "
        "where the profile does not reach it", f'{_INDEPENDENT}; {_CONSTANT_UNIT}'),
    flag("identifiable", "false where the tested conditions cannot give the constant"),
    flag("configured", "true for the law that the campaign uses (fit.law); the others are fitted "
        "to be compared with it (compare.laws)"),
    text("certificate", "the certificate of the fit in a sentence"),
    flag("certified", "true where every part of the certificate holds"),
    count("n_points", "accepted points used"),
    count("n_curves", "runs that the points come from"),
    count("n_constants", "constants fitted, those that ended at a bound included"),
    count("n_conditions", "conditions compared"),
    number("sse", "1", "sum of squared errors of mu (Eq. 10)", at_least=0),
    number("rmse", "1", "root-mean-square error of mu", at_least=0),
    number("relative_rms", "1", "rmse over the root-mean-square of mu compared with", at_least=0),
    number("max_error", "1", "largest absolute error of mu", at_least=0),
    number("mean_error", "1", "mean of fitted minus true mu"),
    number("left_out_traction_coefficient", "1", "mu by a fit to all curves but the point's own; "
        "null where the other curves leave a constant open"),
    number("robust_difference", "1", "root-mean-square difference of mu between this fit and one "
        "with a Cauchy loss, relative to mu", at_least=0),
    count("searches", "independent global searches, each with its own seed"),
    count("searches_agreeing", "searches that ended at the best optimum"),
    # of exact points only rounding is left: a search that ended elsewhere is 1e24 times worse
    number("sse_spread", "1", "(largest - best) / best SSE over the searches", at_least=0,
        at_most=1e25),
    number("constant_spread", "1", "largest difference of a constant between searches, in naive "
        "standard errors", at_least=0),
    number("gradient_cosine", "1", "largest |cos| between the residual and a column of the "
        "Jacobian: 0 at an optimum", at_least=0),
    number("min_traction", "1", "smallest mu on a dense grid over the tested box"),
    number("condition_number", "1", "condition number of the Jacobian with columns of length 1: "
        "large where constants can replace each other, null where they do so to rounding",
        at_least=1, at_most=1e16),
    number("hessian_smallest", "1", "smallest eigenvalue of the Hessian of half the SSE, by the "
        "scaled constants of the search", at_least=0),
    number("hessian_largest", "1", "largest eigenvalue of the Hessian of half the SSE, by the "
        "scaled constants of the search", at_least=0),
    text("active_bounds", "constants that ended at a bound of the search; empty where none did"),
    text("incomplete_curves", "runs left out of the fit, because a condition that varied in the "
        "others is not known of them, joined by '; '"),
    text("fixed_conditions", "conditions without exponents, with the level or line on which mu is "
        "known: JSON list of condition, level, within (largest relative distance) and in_step "
        "(followed conditions: centre, exponent); empty where there are none"),
    *(
        number(f"tested_{end}_{name}", unit, f"{size} {quantity} of the accepted points")
        for name, unit, quantity in (
            *TEST_CONDITIONS,
            ("load_n", "N", "normal load"),
            ("slide_roll_ratio", "1", "absolute slide-roll ratio"),
        )
        for end, size in (("min", "smallest"), ("max", "largest"))
    ),
    text("cause", "resampled curves: bootstrap over whole curves; calibration of a sensor: that "
        "sensor is wrong by its standard uncertainty"),
    count("refit", "number of the refit, within one cause"),
    number("correlation", "1", "correlation of two constants over the bootstrap; by the Jacobian "
        "where there is none", at_least=-1 - 1e-9, at_most=1 + 1e-9),
    number("signed_root", "1", "signed root of the rise of the least SSE over the residual "
        "variance: for a linear law the distance from the optimum in naive standard errors"),
    number("gain", "1", "factor on the robust fit that comes nearest to the curve, points of "
        "little traction left out", required=True),
    share("robust_weight", "mean weight of the curve's points in the robust fit, 1 for points on "
        "it; points of little traction are left out", required=True),
    flag("odd", "whether the curve does not belong to the others of its oil: its gain or shape is "
        "far from theirs, or the robust fit nearly ignores it"),
    text("likely_oil", "oil with whose fit an odd curve agrees much better than with its own; "
        "its label may be wrong; empty where there is none"),
    number("aic", "1", "Akaike information criterion",
        f'{_INDEPENDENT}: differences look too sure'),
    number("bic", "1", "Bayesian information criterion",
        f'{_INDEPENDENT}: differences look too sure'),
    number("left_out_rmse", "1", "root-mean-square error of mu at curves left out of the fit, one "
        "at a time or, of many, in groups (compare.left_out_groups); null where the others do not "
        "give every constant", at_least=0),
    *(
        number(
            f"{name}_end_out_relative_rms",
            "1",
            f"root-mean-square error at the lowest and at the highest level of {quantity}, each "
            "left out of the fit, over the root-mean-square of mu there; null where the other "
            "levels do not give every constant",
            at_least=0,
        )
        for name, quantity in (
            ("pressure", "pressure"),
            ("speed", "entrainment speed"),
            ("temperature", "inlet temperature"),
        )
    ),
    text("better_law", "law that is better than the configured one by both criteria; empty where "
        "none is"),
    text("left_out_law", "law with the least error at curves left out"),
    text("left_out_ties", "laws that this judge does not tell from its best one, which is first, "
        "joined by ', '"),
    number("left_out_relative_rms", "1", "left_out_rmse over the root-mean-square of mu",
        at_least=0),
    number("best_left_out_relative_rms", "1", "the same of left_out_law", at_least=0),
    number("left_out_difference", "1", "difference of the two", at_least=0),
    number("left_out_difference_error", "1", "half width of its 95 % interval, from whole curves "
        "(jackknife)", at_least=0),
    text("bic_law", "law with the lowest BIC"),
    text("bic_ties", "laws that this judge does not tell from its best one, which is first, joined "
        "by ', '"),
    number("bic_difference", "1", "BIC of the configured law less the lowest one", at_least=0),
    number("bic_difference_error", "1", "half width of its 95 % interval, from whole curves "
        "(jackknife)", at_least=0),
    text("ends_out_law", "law with the least error at the lowest and highest levels of conditions, "
        "each left out of the fit; empty where no condition has enough levels"),
    count("n_repeats", "runs that repeat the condition of an earlier run"),
    count("n_repeated_conditions", "conditions that several runs have"),
    number("repeat_relative_rms", "1", "scatter of repeated runs at the same slip, standard "
        "deviation over the root-mean-square of mu: noise of whole runs and of points; null "
        "without repeats", at_least=0),
    number("lack_of_fit_relative_rms", "1", "what the law misses at any number of repeats, "
        "over the root-mean-square of mu; null without repeats", at_least=0),
    number("plateau_relative_rms", "1", "noise of the readings within plateaus alone, over the "
        "root-mean-square of mu; null where readings have no scatter",
        "a lower bound of the noise: errors that all readings of a run share are not in it",
        at_least=0),
    number("lack_of_fit_ratio", "1", "F: mean square of the lack of fit over that of repeats; null "
        "without repeats", at_least=0),
    number("lack_of_fit_limit", "1", "95 % limit of F, each run counted as one observation; null "
        "without repeats", at_least=0),
    *(
        number(f"detectable_ratio_{repeats}_repeats", "1", "least ratio of the residuals to the "
            f"noise at which {repeats} repeated runs show a lack of fit", at_least=0)
        for repeats in (2, 5)
    ),
    number("zero_slip_traction", "1", "largest mu by size at zero slip over the tested conditions; "
        "should be 0"),
    share("negative_share", "share of the tested box where mu is below zero"),
    share("second_rise_share", "share of the tested conditions at which mu rises again after its "
        "peak"),
    text("beyond", "conditions outside the levels at which the oil was tested, joined by ', '; "
        "empty inside"),
    number("true_traction_coefficient", "1", "true mu of the simulation"),
    number("traction_coefficient_lower", "1", "lower end of the 95 % interval of mu; null where "
        "the fit has none"),
    number("traction_coefficient_upper", "1", "upper end of the 95 % interval of mu; null where "
        "the fit has none"),
    share("interval_ratio", "share of the conditions at which the fit's 95 % interval contains the "
        "truth; null where the fit has none"),
    number("worst_true_traction_coefficient", "1", "true mu in the worst case"),
    number("worst_traction_coefficient", "1", "fitted mu in the worst case"),
)
TABLES = (
    table("coefficients", "One constant of one traction law for one oil.",
        columns="""
            oil law constant value standard_error lower upper
            naive_standard_error
            systematic_standard_error profile_lower profile_upper
            identifiable verdict""",
        uses=(
            use("value", "fitted constant; null where not identifiable"),
            use("verdict", "sign unknown: zero is between lower and upper; "
                "at a bound: of the search, beyond which the data would have it; in step: exponent "
                "along the tested line of conditions that varied in step, of none of them alone",
                allowed=("known", "sign unknown", "no interval", "at a bound", "in step",
                    "not identifiable")),
        ),
        key=("oil", "law", "constant"),
        references={"fit_quality": ("oil", "law")},
    ),
    table("fit_quality", "Quality of one law's fit to one oil, on its own data and on data left "
        "out, with the certificate of its optimum.",
        columns="""
            oil law configured n_points n_curves n_constants sse rmse relative_rms max_error aic bic
            left_out_rmse pressure_end_out_relative_rms speed_end_out_relative_rms
            temperature_end_out_relative_rms zero_slip_traction negative_share second_rise_share
            robust_difference searches searches_agreeing sse_spread
            constant_spread gradient_cosine min_traction condition_number hessian_smallest
            hessian_largest
            active_bounds certified certificate incomplete_curves fixed_conditions
            tested_min_max_hertz_pressure_gpa
            tested_max_max_hertz_pressure_gpa tested_min_entrainment_speed_m_s
            tested_max_entrainment_speed_m_s tested_min_inlet_temperature_c
            tested_max_inlet_temperature_c tested_min_load_n tested_max_load_n
            tested_min_slide_roll_ratio tested_max_slide_roll_ratio""",
        key=("oil", "law"),
    ),
    table("refits", "One constant of one refit; the spread of the refits gives the error of the "
        "constants.",
        columns="""
            oil law cause refit constant value""",
        uses=(
            use("value", "refitted constant", required=True),
        ),
        key=("oil", "law", "cause", "refit", "constant"),
        references={"coefficients": ("oil", "law", "constant")},
    ),
    table("correlations", "Correlation of two constants of one fit.",
        columns="""
            oil law constant other correlation""",
        key=("oil", "law", "constant", "other"),
        references={"coefficients": ("oil", "law", "constant")},
    ),
    table("profiles", "One point of a profile likelihood: one constant is held, all others are "
        "fitted.",
        columns="""
            oil law constant value signed_root""",
        uses=(
            use("value", "the constant is held at this value, all others are fitted"),
        ),
        no_key="Rows are the vertices of a line; a search may meet one value twice.",
        references={"coefficients": ("oil", "law", "constant")},
    ),
    table("curve_residuals", "Difference of one run's curve from the fit of its oil.",
        columns="""
            oil law run_id n_points rmse gain robust_weight odd likely_oil""",
        uses=(
            use("rmse", required=True),
        ),
        key=("oil", "law", "run_id"),
        references={"runs": ("run_id",), "fit_quality": ("oil", "law")},
    ),
    table("law_points", "One accepted point beside mu of one law, by the fit to all curves and by "
        "the fit that has not seen the point's own curve.",
        columns="""
            oil law run_id first_row slide_roll_ratio traction_coefficient
            left_out_traction_coefficient""",
        uses=(
            use("first_row", "as in points"),
            use("slide_roll_ratio", "as in points", required=True),
            use("traction_coefficient", "of the fit to all curves", required=True),
        ),
        key=("oil", "law", "run_id", "first_row"),
        references={"fit_quality": ("oil", "law"), "runs": ("run_id",)},
    ),
    table("law_verdicts", "The configured law of one oil beside the best of the laws compared.",
        columns="""
            oil law verdict better_law left_out_law left_out_ties left_out_relative_rms
            best_left_out_relative_rms left_out_difference left_out_difference_error bic_law
            bic_ties bic_difference bic_difference_error ends_out_law""",
        uses=(
            use("law", "configured"),
            use("verdict", "best: of the laws compared, by both criteria; tie: others are as good "
                "within the uncertainty; another law is better: by both criteria; "
                "criteria disagree: one of the two has the configured law among its best; "
                "not compared: no other law (compare.laws names none), no fit (of the configured "
                "law), no other fit, constants left open (by the curves that are not left out), "
                "too few curves",
                allowed=("best", "tie", "another law is better", "criteria disagree",
                    "no other law", "no fit", "no other fit", "constants left open",
                    "too few curves")),
        ),
        key=("oil", "law"),
        references={"fit_quality": ("oil", "law")},
        caveats=("The best of the laws compared need not be true, and curves left out are at "
            "conditions like the others: they say little of conditions never tested."),
    ),
    table("lack_of_fit", "What one law misses, beside the noise that repeated runs show.",
        columns="""
            oil law n_repeats n_repeated_conditions relative_rms repeat_relative_rms
            lack_of_fit_relative_rms plateau_relative_rms lack_of_fit_ratio lack_of_fit_limit
            detectable_ratio_2_repeats detectable_ratio_5_repeats verdict""",
        uses=(
            use("verdict", "shown: F is above its limit; not shown: it is not",
                allowed=("shown", "not shown", "no repeats", "no fit")),
        ),
        key=("oil", "law"),
        references={"fit_quality": ("oil", "law")},
    ),
    table("extrapolation", "One condition of a simulated campaign: mu of a fitted law beside the "
        "true mu.",
        columns="""
            oil law figure max_hertz_pressure_gpa entrainment_speed_m_s inlet_temperature_c load_n
            slide_roll_ratio beyond true_traction_coefficient traction_coefficient
            traction_coefficient_lower traction_coefficient_upper""",
        uses=(
            use("max_hertz_pressure_gpa", required=True),
            use("entrainment_speed_m_s", required=True, at_least=0),
            use("inlet_temperature_c", required=True, at_least=ABSOLUTE_ZERO_C),
            use("load_n", "gives the pressure on the rig", required=True, at_least=0),
            use("slide_roll_ratio", required=True, at_least=0),
            use("true_traction_coefficient", required=True, at_least=0),
            use("traction_coefficient", "of the fitted law, cut off at 1e6; null where nothing was "
                "fitted"),
        ),
        key=("oil", "law", "figure", "max_hertz_pressure_gpa", "entrainment_speed_m_s",
            "inlet_temperature_c", "slide_roll_ratio"),
        caveats=("It shows how laws behave in a world like the simulated one; it decides nothing "
            "about real oils."),
    ),
    table("extrapolation_errors", "Errors of one law for one oil against the truth, per figure and "
        "region.",
        columns="""
            law oil figure beyond n_conditions rmse relative_rms mean_error max_error interval_ratio
            worst_max_hertz_pressure_gpa worst_entrainment_speed_m_s worst_inlet_temperature_c
            worst_slide_roll_ratio worst_true_traction_coefficient worst_traction_coefficient""",
        key=("law", "oil", "figure", "beyond"),
        caveats=("It shows how laws behave in a world like the simulated one; it decides nothing "
            "about real oils."),
    ),
)
# fmt: on
