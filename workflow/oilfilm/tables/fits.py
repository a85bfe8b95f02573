"""Tables of the fits: constants, their proof and uncertainty, the laws compared."""

from oilfilm.tables.columns import table, use
from oilfilm.units import ABSOLUTE_ZERO_C

# One fit per oil and law: the tables that a fit writes.
OF_FIT = (
    *("coefficients", "fit_quality", "refits", "correlations", "profiles", "curve_residuals"),
    "law_points",
)

# fmt: off
TABLES = (
    table("coefficients", "One constant of one traction law for one oil.",
        columns="""
            oil law constant value standard_error lower upper joint_lower joint_upper
            naive_standard_error
            systematic_standard_error profile_lower profile_upper weighted_value robust_value
            identifiable verdict printed_value""",
        uses=(
            use("value", "fitted constant; null where not identifiable"),
            use("verdict", "sign unknown: zero is between joint_lower and joint_upper; "
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
            weighted_difference robust_difference searches searches_agreeing sse_spread
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
            bic_ties bic_difference bic_difference_error ends_out_law finding advice""",
        uses=(
            use("law", "configured"),
            use("verdict", "best: of the laws compared, by both criteria; tie: others are as good "
                "within the uncertainty; another law is better: by both criteria; "
                "criteria disagree: one of the two has the configured law among its best",
                allowed=("best", "tie", "another law is better", "criteria disagree",
                    "not compared")),
            use("advice", "empty where there is nothing to do"),
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
            verdict finding advice""",
        uses=(
            use("verdict", "shown: F is above its limit; not shown: it is not",
                allowed=("shown", "not shown", "no repeats", "no fit")),
            use("advice", "empty where there is nothing to do"),
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
