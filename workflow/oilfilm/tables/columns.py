"""Every column of every table, declared once: name, type, unit, meaning, caveat, bounds.

A table lists the names of its columns. It may narrow a column and add a note (`use`), but it has no
unit and no meaning of its own: the same name is the same quantity everywhere.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

from oilfilm.tables.declaration import BY_ROW, LARGEST, Check, Column, Table, by_name
from oilfilm.traction import BEARING_LAW_NAMES
from oilfilm.units import ABSOLUTE_ZERO_C


def number(
    name: str,
    unit: str,
    meaning: str,
    caveat: str = "",
    *,
    required: bool = False,
    at_least: float = -LARGEST,
    at_most: float = LARGEST,
) -> Column:
    """A quantity, null where it is not known; infinity passes no bound."""
    return Column(name, "number", unit, meaning, caveat, not required, at_least, at_most)


def share(name: str, meaning: str, caveat: str = "", *, required: bool = False) -> Column:
    """A number from 0 to 1."""
    return number(name, "1", meaning, caveat, required=required, at_least=0, at_most=1)


def count(name: str, meaning: str, caveat: str = "") -> Column:
    """A whole number of things, or of a row; never null."""
    return Column(name, "integer", "1", meaning, caveat, at_least=0)


def text(name: str, meaning: str, caveat: str = "", *, allowed: tuple[str, ...] = ()) -> Column:
    """Words; empty rather than null."""
    return Column(name, "text", "", meaning, caveat, allowed=allowed)


def flag(name: str, meaning: str, caveat: str = "") -> Column:
    """True or false."""
    return Column(name, "flag", "", meaning, caveat)


# What a condition of a traction test is made of: end of a column's name, unit, quantity.
_TEST_CONDITIONS = (
    ("max_hertz_pressure_gpa", "GPa", "maximum Hertz pressure"),
    ("entrainment_speed_m_s", "m/s", "entrainment speed"),
    ("inlet_temperature_c", "degC", "inlet temperature"),
)
_SLIP = ("slide_roll_ratio", "1", "slide-roll ratio")

# fmt: off
_ORIGIN = (
    text("campaign", "campaign, as named in config/campaigns"),
    text("run_id", "run: one log file, or one group of it as file:group"),
    text("oil", "oil, as named in config/oils"),
    text("rig", "rig, as named in config/rigs"),
    text("bearing", "bearing, as named in config/bearings"),
    text("file", "raw log, relative to the campaign's raw folder"),
    text("sha256", "SHA-256 of the raw log's bytes"),
    text("content_sha256", "SHA-256 of the log after unpacking, so that packed copies are known"),
    text("label", "the log's own name of the run; empty where it has none"),
    text("reader", "format that the log was read as"),
    text("encoding", "encoding that a text log was read in; empty for other formats"),
    text("delimiter", "what parts the cells of a text log: comma, semicolon, tab, bar or blanks; "
        "empty for other formats"),
    text("decimal_mark", "decimal mark of a text log: point or comma; empty for other formats"),
    text("log_kind", "continuous: a signal against time; steps: each row is already a settled "
        "reading", allowed=("continuous", "steps")),
    count("row", "data row in the raw log, counted from 1"),
    count("first_row", "first data row concerned, in the raw log"),
    count("last_row", "last data row concerned, in the raw log"),
)

_CURATION = (
    count("samples", "rows of the log that are in the table samples"),
    count("refused_rows", "rows that are not in the table samples"),
    count("plateaus", "steady plateaus, each one row of points"),
    count("accepted_points", "points that passed every gate"),
    flag("accepted", "true where no gate refused the plateau"),
    text("reason", "what was found and what was expected; empty where nothing was refused"),
    text("warning", "what is doubtful about a run that is used, with the likely cause; empty where "
        "nothing is"),
    text("failed_gates", "gates that refused the plateau, joined by ';'; empty where none did"),
    text("advice", "what to do about it"),
    text("stage", "stage that refused", allowed=("ingest", "curate")),
    text("rule", "name of the rule or gate that refused"),
    text("gate", "name of the rule or gate that refuses"),
    text("what", "what the gate judges", allowed=("file", "run", "point", "rows")),
    count("files", "number of logs concerned"),
    count("runs", "number of runs concerned, wholly or in part"),
    count("points", "number of points concerned"),
    count("rows", "number of rows kept out of the table samples"),
    count("runs_accepted", "number of runs with at least one accepted point"),
    count("runs_refused", "number of runs refused as a whole"),
    count("points_accepted", "number of points that passed every gate"),
    count("points_refused", "number of points that did not pass every gate"),
    text("state", "accepted: at least one run is; refused: none of its runs is; missing: there is "
        "no run", allowed=("accepted", "refused", "missing")),
    flag("planned", "true where the campaign's matrix has the condition"),
    text("page", "picture beside the table; empty where there is no signal to show, or where there "
        "are more pages than refused_pages_max"),
    text("place", "what is marked on the page: the rows that the rule names, else the plateaus "
        "that fail gates of their own, else the whole run; empty where there is no page",
        allowed=("rows", "plateaus", "whole run", "")),
    text("defect", "defect planted by the rig twin; empty for a clean log"),
    number("law_misfit", "1", "root-mean-square difference between the traction behind the torque "
        "logs, averaged over the traction rig's contact, and the one behind the traction logs, "
        "over the campaign's matrix and slips, relative to the latter; 0 where a law is behind "
        "both",
        required=True),
)

_CONDITIONS = (
    number("time_s", "s", "time on the log's clock", required=True),
    number("duration_s", "s", "length of the settled part of a plateau", at_least=0),
    number("load_n", "N", "normal load of the contact"),
    number("max_hertz_pressure_gpa", "GPa", "maximum Hertz pressure of the contact", at_least=0),
    number("entrainment_speed_m_s", "m/s", "entrainment speed: mean of the two surface speeds"),
    number("slide_roll_ratio", "1", "slide-roll ratio: sliding speed over entrainment speed, "
        "positive where the slower body is slowed"),
    number("inlet_temperature_c", "degC", "oil temperature at the inlet"),
    number("ball_speed_m_s", "m/s", "surface speed of the ball at the contact"),
    number("disc_speed_m_s", "m/s", "surface speed of the disc at the contact"),
    number("nominal_load_n", "N", "set point of the normal load", at_least=0),
    number("nominal_max_hertz_pressure_gpa", "GPa", "set point of the maximum Hertz pressure",
        at_least=0),
    number("nominal_entrainment_speed_m_s", "m/s", "set point of the entrainment speed",
        at_least=0),
    number("nominal_inlet_temperature_c", "degC", "set point of the inlet temperature",
        at_least=ABSOLUTE_ZERO_C),
)

_TRACTION = (
    number("traction_force_n", "N", "traction force"),
    number("traction_force_1_n", "N", "force with the disc faster, on rigs that reverse the slip"),
    number("traction_force_2_n", "N", "force with the ball faster, on rigs that reverse the slip"),
    number("traction_coefficient", "1", "traction coefficient mu: traction force over normal load"),
    number("traction_coefficient_se", "1", "standard error of the traction coefficient",
        "random part only: calibration errors, which a whole run shares, are not included",
        at_least=0),
    number("slide_roll_ratio_se", "1", "standard error of the mean slide-roll ratio",
        "random part only: calibration errors, which a whole run shares, are not included"),
    count("n_samples", "rows averaged", "rows marked as spikes are not among them"),
    count("n_spikes", "rows left out of the mean as spikes"),
    number("slip_change", "1", "slide-roll ratio: second half of the plateau minus first half"),
    number("traction_change", "1", "traction coefficient: second half of the plateau minus first "
        "half"),
    number("slip_transient", "1", "slide-roll ratio: beginning of the plateau (setting "
        "transient_share) minus the rest"),
    number("traction_transient", "1", "traction coefficient: beginning of the plateau (setting "
        "transient_share) minus the rest"),
    number("force_asymmetry", "1", "|TF1 + TF2| / (|TF1| + |TF2|): 0 where both slip directions "
        "pull alike, 1 where one has not reversed", at_least=0, at_most=1 + 1e-9),
    *(
        number(
            name,
            unit,
            f"standard uncertainty of the calibration of the {quantity}, shared by all points of "
            "the rig; null where the rig file has none",
            at_least=0,
        )
        for name, unit, quantity in (
            ("load_systematic_n", "N", "load"),
            ("traction_force_systematic_n", "N", "traction force"),
            ("entrainment_speed_systematic_m_s", "m/s", "entrainment speed"),
            ("inlet_temperature_systematic_c", "K", "inlet temperature"),
        )
    ),
    number("film_thickness_um", "um", "calculated film thickness (Hamrock-Dowson, settings under "
        "film); null where it cannot be calculated", at_least=0),
    number("measured_film_thickness_um", "um", "film thickness measured by optical interferometry "
        "(EHD rigs only)"),
    number("lambda_ratio", "1", "film thickness over combined roughness"),
    text("film_judgement", "full film: lambda above its limit",
        allowed=("full film", "below limit", "cannot be judged")),
)

_INDEPENDENT = "takes every point as independent"
_CONSTANT_UNIT = "unit of the constant in its law's equation, with P in GPa, U in m/s, T in degC"

_FITS = (
    text("law", "traction law"),
    text("constant", "constant, as named in the law's equation"),
    text("other", "the other constant of a pair; empty where there is none"),
    number("value", BY_ROW, "value of what the row names", "unit: that of the quantity in the row"),
    number("standard_error", BY_ROW, "standard error of the constant, by bootstrap over curves, so "
        "that errors shared by a run are included",
        f'systematic part not included; {_CONSTANT_UNIT}', at_least=0),
    number("lower", BY_ROW, "2.5 % quantile of the constant's refits", _CONSTANT_UNIT),
    number("upper", BY_ROW, "97.5 % quantile of the constant's refits", _CONSTANT_UNIT),
    *(
        number(f"joint_{end}", BY_ROW, f"{end} end of the interval that decides on the constant's "
            "sign: for all constants of the fit together (fit.sign_confidence of config.yaml), "
            "calibration included", _CONSTANT_UNIT)
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
    number("weighted_value", BY_ROW, "constant fitted with points weighted by their standard "
        "errors and the excess scatter", _CONSTANT_UNIT),
    number("robust_value", BY_ROW, "constant fitted with a Cauchy loss", _CONSTANT_UNIT),
    number("printed_value", BY_ROW, "constant printed in the paper",
        f'signs restored; {_CONSTANT_UNIT}'),
    flag("identifiable", "false where the tested conditions cannot give the constant"),
    text("verdict", "verdict on what the row names"),
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
    number("weighted_difference", "1", "root-mean-square difference of mu between the weighted fit "
        "and this one, relative to mu; null where no point has a standard error", at_least=0),
    number("robust_difference", "1", "root-mean-square difference of mu between the robust fit and "
        "this one, relative to mu", at_least=0),
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
            *_TEST_CONDITIONS,
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
    number("zero_slip_traction", "1", "largest mu by size at zero slip over the tested conditions; "
        "should be 0"),
    share("negative_share", "share of the tested box where mu is below zero"),
    share("second_rise_share", "share of the tested conditions at which mu rises again after its "
        "peak"),
    text("figure", "figure of the paper that has the condition"),
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

_CIRCULAR = (
    "CIRCULAR where the points are simulated from the printed constants; simulated from anything "
    "else it says nothing of the real oils"
)
_EXPONENTS = ("a0", "a1", "a2", "a3", "b0", "b1", "b2", "b3", "c0", "c1", "c2", "c3")

_PAPER = (
    number("printed_sse", "1", "sum of squared errors of mu (Eq. 10) of the printed constants",
        at_least=0),
    number("fitted_sse", "1", "sum of squared errors of mu (Eq. 10) of the fit", at_least=0),
    *(
        number(
            f"{name}_distance",
            "1",
            f"(fitted - printed) {name.upper()} over its standard error, systematic part included",
        )
        for name in _EXPONENTS
    ),
    number("joint_distance", "1", "Mahalanobis distance of all twelve constants by the covariance "
        "of the refits, about 3.5 by chance alone; null without a covariance", at_least=0),
    *(
        column
        for box in ("tested", "extrapolated")
        for column in (
            number(
                f"{box}_difference",
                "1",
                f"printed - fitted mu where they differ most in the {box} box",
            ),
            *(
                number(f"{box}_{name}", unit, f"{quantity} where they differ most in the {box} box")
                for name, unit, quantity in (
                    ("traction_coefficient", "1", "fitted mu"),
                    *_TEST_CONDITIONS,
                    _SLIP,
                )
            ),
        )
    ),
    text("signs", "signs of A1 A2 A3 B1 B2 B3 C1 C2 C3: exponents of P, U, T"),
    flag("in_use", "true for the signs in data/reference/printed_coefficients.yaml"),
    count("rank", "rank by total, 1 the best; equal totals share a rank"),
    count("rank_at_figures", "rank if only the slips of the paper's figs 8 and 9 are used"),
    number("total", "1", "weighted sum of the statements' shares: how many hold", required=True),
    flag("near_best", "true where the total is less than near_best below the best"),
    share("physical", "share of the extrapolated box where mu >= 0 (by the signs of A0, B0, C0) "
        "and no peak above gates.traction_max; section 3: 'remains non-negative under all "
        "operating conditions'", required=True),
    share("rises_with_stress", "share of the extrapolated box where mu rises from each level of P "
        "to the next; section 4.3.3: 'increase with the maximum contact stress'", required=True),
    share("linear_in_stress", "share of the extrapolated box where mu(P) rises along a straight "
        "line (linear_r2_min); section 4.3.3: 'an approximately linear increase'", required=True),
    share("falls_with_speed", "share of the extrapolated box where mu falls from each level of U "
        "to the next; section 4.3.2: 'continues to decline as the entrainment speed increases from "
        "20 m/s to 200 m/s'", required=True),
    share("levels_off_with_speed", "share of the extrapolated box where mu falls by more over the "
        "first third of the speeds than it changes over the last; section 4.3.2: 'a clear plateau "
        "at high entrainment speeds'", required=True),
    share("falls_with_temperature", "share of the extrapolated box where mu falls from each level "
        "of T to the next; section 4.3.4: 'decrease markedly in a nonlinear manner with increasing "
        "temperature'", required=True),
    share("levels_off_with_temperature", "share of the extrapolated box where mu falls by more "
        "over 20-60 degC than it changes over 100-140; section 4.3.4: 'approximately 20-60 degC, "
        "the decrease is more pronounced, whereas in the high-temperature range (>100 degC), the "
        "curves flatten'", required=True),
    share("start_falls_with_temperature", "share of the tested box where the slope at zero slip "
        "falls from each level of T to the next; half weight, it follows by the physics named; "
        "section 2.4: 'typical Newtonian behavior', 'temperature-induced reduction in the "
        "lubricant's base viscosity'", required=True),
    share("rises_with_slip", "share of the extrapolated box where mu at the highest of "
        "slide_roll_ratio.figures is above that at the lowest; section 4.3.2: 'gradually increases "
        "as the SRR rises from 0.05 to 0.20'", required=True),
    share("declines_slightly", "share of the tested box where mu peaks within the slips and loses "
        "decline_max of the peak at most; section 2.4: 'reaches a maximum value ... a slight "
        "decline'", required=True),
    share("earlier_plateau_with_stress", "share of the extrapolated box where the linear range "
        "ends at smaller slip from each level of P to the next; section 4.3.1: 'the onset of "
        "nonlinearity occurs at a smaller SRR', 'reach the plateau region at relatively low SRR'",
        required=True),
    share("earlier_plateau_with_speed", "share of the tested box where the linear range ends at "
        "smaller slip from each level of U to the next; half weight, one reading; section 2.4: 'At "
        "high entrainment speeds ... enters the saturation regime at lower SRR values'",
        required=True),
    share("earlier_plateau_with_temperature", "share of the tested box where the linear range ends "
        "at smaller slip from each level of T to the next; half weight, the other reading; section "
        "2.4: 'decreasing trend with increasing oil supply temperature ... enters the saturation "
        "regime at lower SRR values'", required=True),
    share("slip_raises_stress_effect", "share of the extrapolated box where over the range of P mu "
        "gains more at the highest of slide_roll_ratio.figures than it changes at the lowest; "
        "section 4.3.3: 'the increase is more pronounced at a high SRR of 0.20'", required=True),
    share("speed_mutes_stress_effect", "share of the extrapolated box where over the range of P mu "
        "gains more at the lowest speed than it changes at the highest; section 4.3.3: 'at low "
        "speeds ... greater load sensitivity'", required=True),
    share("speed_mutes_temperature_effect", "share of the extrapolated box where over the range of "
        "T mu loses more at the lowest speed than it changes at the highest; section 4.3.4: "
        "'high-speed cases ... reduced sensitivity to temperature'", required=True),
    share("viscosity_order", "share of the extrapolated box where mu is below that of the next "
        "more viscous oil and above that of the next less viscous one, the mean of both, these "
        "with the set that their own statements like best; section 4.3.1: 'the traction level of "
        "lubricant 4102 is the highest, followed by 4050, while 4010 exhibits the lowest'"),
    share("hot_convergence", "share of the extrapolated box where mu is nearer to that of each "
        "other oil at the highest temperature than at the lowest; section 4.3.4: 'in the "
        "high-temperature region, the three curves gradually converge'"),
    text("sign", "sign in use", allowed=("+", "-")),
    number("margin", "1", "best total of the sets with this sign minus that of the sets with the "
        "other sign", required=True),
    number("weakest_margin", "1", "smallest margin with any one statement left out, at the slips "
        "of the whole curve or of the paper's figures alone"),
    text("weakest_without", "statement left out where the margin is smallest"),
    text("weakest_slips", "slips where the margin is smallest (printed.signs.slide_roll_ratio)",
        allowed=("curve", "figures")),
    share("near_best_share", "share of the near-best sets that have this sign", required=True),
    number("effect", "1", "largest change of mu over the tested box if this sign alone is turned, "
        "over the largest mu there", required=True, at_least=0),
    number("least_sse", "1", "least SSE of the sets with this sign", _CIRCULAR, at_least=0),
    number("least_sse_turned", "1", "least SSE of the sets with the other sign", _CIRCULAR,
        at_least=0),
    text("claim", "id of the claim in data/reference/claims.yaml"),
    text("section", "section of the paper that makes the claim"),
    text("statement", "the claim in short"),
    text("wording", "the paper's own words"),
    text("basis", "refit: the campaign's own fits and points; printed: the paper's constants, "
        "signs restored, and its Eq. 1", allowed=("refit", "printed")),
    text("definition", "what would make the claim hold"),
    text("judged_on", "conditions at which the claim was judged"),
    text("finding", "the figures in words, or why there are none"),
    count("cases", "conditions or rows at which the claim was judged"),
    share("share", "share of the cases in which the claim holds"),
    share("share_tested_box", "share of the cases in the tested box; null where there is none"),
    share("share_extrapolated_box", "share of the cases in the box of the paper's figs 7 to 10"),
    text("worst_quantity", "what worst_value is; empty where the claim was not checked"),
    number("worst_value", BY_ROW, "value in the case that is farthest from holding",
        "unit: that of worst_quantity"),
    text("worst_detail", "what worst_value is made of; empty where it needs no explanation"),
    text("worst_oil", "oil in the worst case; empty where oils are compared"),
    *(
        number(
            f"worst_{name}",
            unit,
            f"{quantity} in the worst case; null where the case has none, or all",
        )
        for name, unit, quantity in (*_TEST_CONDITIONS, _SLIP)
    ),
)

_SELECTION = (
    text("selection_rule", "first rule of selection.rules that applies"),
    text("aim", "what the rule maximises or minimises", allowed=("most traction", "least heat")),
    text("advised_oil", "oil that the rule advises; empty where none that it prefers has enough "
        "film"),
    text("contradicting_rules", "later rules that advise another oil, joined by '; '"),
    text("best_oil", "best oil of those with enough film; empty where there is none"),
    text("judgement", "the advised oil compared with the best one"),
    number("loss_ratio", "1", "by how much mu of the advised oil misses the aim, relative to the "
        "best oil"),
    *(
        number(f"{which}_{name}", unit, f"{quantity} with the {which} oil", at_least=at_least)
        for which in ("advised", "best")
        for name, unit, quantity, at_least in (
            ("lambda_ratio", "1", "lambda", 0),
            ("traction_coefficient", "1", "mu", -LARGEST),
            ("cage_slip", "1", "cage slip", -LARGEST),
            ("torque_n_m", "N m", "friction torque", -LARGEST),
        )
    ),
    text("oils_within_limit", "oils with enough film whose cage slip stays within "
        "selection.limits.slip_limit, joined by '; '; empty where none does"),
    text("good_oils", "oils that are the best one or within selection.indifference of it, joined "
        "by '; '; empty where there is none"),
    share("agree_share", "share of the scenarios in which the advised oil is one of the good oils"),
    share("best_oil_share", "share of the scenarios in which this best oil is one of the good oils",
        "1: drag and law within their uncertainty do not change the choice"),
    text("best_oils", "oils that are best in a scenario, joined by '; '"),
    share("oil_volume_fraction", "oil's share of the space that the balls travel through",
        required=True),
    count("operating_points", "operating points with a choice of oils"),
    count("agreeing_points", "operating points at which advice and best oil agree"),
    number("slip_that_decides", "1", "cage slip with the oil that the rules advise where nothing "
        "slips; null without film"),
)

_CONDITIONAL = ("law's refits, calibration of the traction rig and the other terms' assumed "
    "uncertainty; true as far as the law's form is, which beyond the tested box nobody has tested; "
    "null without refits (fewer than 10 runs) or where over 5 % of the draws have no equilibrium")

_BEARING = (
    number("inner_speed_rpm", "rpm", "speed of the inner ring; the outer ring rests",
        required=True),
    number("axial_load_n", "N", "axial load of the bearing", required=True),
    number("pitch_speed_mm_rpm", "mm rpm", "pitch diameter times speed, d_m n", required=True),
    number("oil_temperature_c", "degC", "oil temperature at the bearing's inlet", required=True),
    number("outer_ring_temperature_c", "degC", "temperature of the outer ring", required=True),
    number("torque_n_m", "N m", "friction torque: moment that turns the inner ring"),
    number("torque_n_m_se", "N m", "standard error of the friction torque, the tare's included",
        "random part only: calibration is not included", at_least=0),
    number("tare_n_m", "N m", "output at rest at that time, subtracted from the torque",
        required=True),
    number("torque_change_n_m", "N m", "torque: second half of the plateau minus first half",
        required=True),
    number("oil_temperature_change_c", "K", "oil temperature: second half of the plateau minus "
        "first half", required=True),
    flag("converged", "false: no equilibrium was found, and all results are null"),
    text("why", "why no equilibrium was found; empty where one was"),
    number("residual", "1", "largest force or moment out of balance, over the load of a ball"),
    number("energy_error", "1", "power put in at the rings minus all heat, over that power"),
    number("quadrature_error", "1", "relative change of the traction heat with twice as many "
        "integration points per direction"),
    number("outer_ring_torque_n_m", "N m", "moment of balls and cage on the outer ring: less by "
        "the drag, which the oil takes"),
    *(
        number(f"{name}_torque_n_m", "N m", meaning)
        for name, meaning in (
            ("traction", "term of the torque: sliding in the contacts"),
            ("rolling", "term of the torque: oil drawn into the contacts"),
            ("hysteresis", "term of the torque: hysteresis of the steel"),
            ("drag", "term of the torque: balls through oil and air"),
            ("pocket", "term of the torque: balls in the pockets of the cage"),
            ("land", "term of the torque: cage on its guiding land"),
            ("gross", "part of the traction term: slip of the whole contact"),
            ("spin", "part of the traction term: spin about the normal"),
            ("differential", "part of the traction term: slip across a curved contact"),
            ("gyroscopic", "part of the traction term: slip across the rolling direction"),
            ("palmgren", "friction torque by Palmgren's formula, as usually quoted"),
            ("skf", "friction torque by the SKF formula, as usually quoted"),
            ("measured", "measured friction torque"),
        )
    ),
    flag("skf_valid", "false where pitch diameter times speed is above "
        "bearing.skf_pitch_speed_max: the SKF formula says nothing there, because its sliding term "
        "grows with n^(8/3)"),
    number("measured_torque_n_m_se", "N m", "standard error of the measured friction torque",
        "random part only: calibration is not included", at_least=0),
    number("relative_error", "1", "calculated over measured torque, minus 1"),
    flag("film_in_range", "false where the formula of the film has no value: its thermal reduction "
        "is near or below zero in one of the contacts, or there is no equilibrium"),
    count("n_plateaus", "plateaus compared, without those that are bistable"),
    number("median_torque_error", "1", "median of the errors' sizes by the law on pressure, over "
        "these plateaus"),
    number("largest_torque_error", "1", "largest of them"),
    number("cage_slip", "1", "relative lag of the cage behind balls that roll on both races"),
    flag("bistable", "true where the cage may roll or skid: another equilibrium was found, or the "
        "draws of the uncertainty are in two groups (draws_split); numbers of the row are those of "
        "the equilibrium that a rolling start leads to"),
    number("other_cage_slip", "1", "cage slip in the other equilibrium; null where none was found"),
    number("other_torque_n_m", "N m", "friction torque in the other equilibrium; null where none "
        "was found"),
    *(
        number(f"{name}_{which}", unit, f"{meaning} of the calculated {quantity}", _CONDITIONAL,
            at_least=at_least)
        for name, unit, quantity in (
            ("torque_n_m", "N m", "friction torque"),
            ("cage_slip", "1", "cage slip"),
            ("power_w", "W", "power loss"),
        )
        for which, meaning, at_least in (
            ("uncertainty", "standard uncertainty", 0),
            ("lower", "2.5 % quantile", -LARGEST),
            ("upper", "97.5 % quantile", -LARGEST),
        )
    ),
    flag("draws_split", "true where the random draws of the uncertainty are in two groups, rolling "
        "and skidding cages"),
    number("measured_torque_n_m_uncertainty", "N m", "standard uncertainty of the measured "
        "friction torque: random error and calibration", at_least=0),
    number("compatibility", "1", "calculated minus measured torque over the standard uncertainty "
        "of this difference; null without refits",
        "the law's part is that of its constants: it is as true as the law's form is"),
    number("inner_slide_roll_ratio", "1", "slide-roll ratio in the middle of the contact with the "
        "inner race, mean over the balls; positive where the race is the faster one. About twice "
        "the cage slip where that is 15 to 80 %; below 5 % spin and creep decide"),
    *(
        number(f"{race}_{name}", unit, f"{quantity} at the {race} race")
        for name, unit, quantity in (
            ("contact_angle_deg", "deg", "contact angle"),
            ("max_hertz_pressure_gpa", "GPa", "maximum Hertz pressure"),
        )
        for race in ("inner", "outer")
    ),
    number("largest_slide_roll_ratio", "1", "largest slide-roll ratio anywhere in the contacts"),
    number("mean_traction_coefficient", "1", "mean mu over the contacts, weighted by load"),
    *(
        share(f"share_beyond_{name}", f"share of the traction heat {where}")
        for name, where in (
            ("slip", "at slide-roll ratios above any tested"),
            ("pressure", "in contacts of untested pressure"),
            ("speed", "in contacts of untested entrainment speed"),
        )
    ),
    text("load_variable", "load variable of the law. stress: maximum Hertz pressure; load: load in "
        "N; dimensionless_load: W/(E' Rx^2); otherwise the name of a law on load, fitted to the "
        "same points",
        allowed=("stress", "load", "dimensionless_load", *BEARING_LAW_NAMES)),
    number("traction_share", "1", "share of the calculated torque that the traction law decides"),
    number("law_traction_coefficient", "1", "mean mu over the contacts by the law"),
    number("traction_coefficient_systematic", "1", "standard uncertainty of mu from calibration "
        "and from the other terms' assumed uncertainty", at_least=0),
    text("varied", "ball size: all lengths in proportion, same pressure and surface speed; "
        "conformity: both grooves, same load and speed", allowed=("ball size", "conformity")),
    number("ball_diameter_mm", "mm", "diameter of the balls", required=True),
    number("groove_curvature", "1", "groove radius over ball diameter", required=True),
    number("relative_to_stress", "1", "traction torque over that of the load variable stress, "
        "minus 1"),
    number("power_w", "W", "calculated friction torque times speed"),
    flag("balanced", "false where no steady temperature was found: the heat jumps where the motion "
        "changes, or the oil would leave at more than 400 degC"),
    number("heat_w", "W", "friction heat of the bearing with heated oil"),
    number("outlet_temperature_c", "degC", "temperature of the oil that leaves the bearing"),
    number("contact_temperature_c", "degC", "temperature of the oil in the contacts, between inlet "
        "and outlet temperature"),
    number("heated_torque_n_m", "N m", "calculated friction torque with heated oil"),
    number("heated_cage_slip", "1", "cage slip with heated oil"),
    number("heated_lambda_ratio", "1", "film thickness over combined roughness with heated oil; as "
        "lambda_ratio", at_least=0),
    text("heated_best_oil", "best oil with heated oils; empty where no oil has enough film"),
    *(
        number(f"{name}_{end}{unit}", unit.removeprefix("_").upper() or "1", f"{quantity} with the "
            f"{end}est share of oil in bearing.oil_volume_fraction_range")
        for name, unit, quantity in (("power", "_w", "calculated power loss"),
            ("cage_slip", "", "calculated cage slip"))
        for end in ("low", "high")
    ),
    number("published_power_w", "W", "published power loss; null where none was",
        "second-hand figure"),
    number("published_cage_slip", "1", "largest published cage slip of the test, whatever the "
        "load; null where none was", "from an abstract"),
    share("fitted_oil_volume_fraction", "share of oil that gives the test's published power losses "
        "best: least squares of the relative errors, with the campaign's law"),
    share("oil_volume_fraction_alone", "share of oil that gives this published value exactly; null "
        "where none from 0 to 0.1 does"),
    text("source", "source of the value"),
    text("assumed", "inputs that the source does not give"),
    text("target", "quantity whose uncertainty the tests shall reduce. torque: relative; "
        "cage_slip: absolute; traction: mu, relative", allowed=("torque", "cage_slip", "traction")),
    count("test_order", "position of the test in the plan, from 1; 0 where it was not chosen"),
    *(
        number(f"uncertainty_{when}", "1", "root mean square over the wanted operating points of "
            f"the target's standard uncertainty from the law's constants, {meaning}",
            "as far as the law's form is right; other terms of the torque are not included",
            at_least=0)
        for when, meaning in (
            ("now", "with the curves measured so far"),
            ("with_test", "with this one test added"),
            ("with_plan", "with all tests of the plan up to this one; null where it was not "
                "chosen"),
        )
    ),
)

_PANEL_UNIT = "unit and meaning: title and axis of the panel, which are in the file's footer"

_FIGURES = (
    text("panel", "letter of the panel, or column of a table that is drawn"),
    text("series", "line, symbol or row of the panel"),
    text("words", "text that is drawn, or what tells a mark apart"),
    number("x", BY_ROW, "abscissa", _PANEL_UNIT),
    number("y", BY_ROW, "ordinate", _PANEL_UNIT),
    number("y_lower", BY_ROW, "lower end of a bar or band", _PANEL_UNIT),
    number("y_upper", BY_ROW, "upper end of a bar or band", _PANEL_UNIT),
)

COLUMNS = by_name((
    *_ORIGIN, *_CURATION, *_CONDITIONS, *_TRACTION, *_FITS, *_PAPER, *_SELECTION, *_BEARING,
    *_FIGURES,
))
# fmt: on


def unit_of(name: str) -> str:
    """The unit of a column; "1" for plain numbers, empty for text and flags.

    Raises:
        KeyError: No table has such a column.
    """
    return COLUMNS[name].unit


def use(
    name: str,
    note: str = "",
    *,
    required: bool = False,
    at_least: float | None = None,
    at_most: float | None = None,
    allowed: tuple[str, ...] = (),
    dictionary: bool = False,
) -> Column:
    """A column as one table has it: same unit and meaning, narrower bounds, a note.

    Raises:
        ValueError: A bound or an allowed text is outside what the column allows.
    """
    column = COLUMNS[name]
    low = column.at_least if at_least is None else at_least
    high = column.at_most if at_most is None else at_most
    wider = (
        (column.at_least is not None and low is not None and low < column.at_least)
        or (column.at_most is not None and high is not None and high > column.at_most)
        or (column.allowed and not set(allowed) <= set(column.allowed))
    )
    if wider:
        raise ValueError(f"column {column.name!r} cannot be widened by a table")
    return replace(
        column,
        note=note,
        nullable=column.nullable and not required,
        at_least=low,
        at_most=high,
        allowed=allowed or column.allowed,
        dictionary=dictionary,
    )


def table(
    name: str,
    description: str,
    *,
    columns: str,
    uses: Sequence[Column] = (),
    key: tuple[str, ...] = (),
    no_key: str = "",
    references: Mapping[str, tuple[str, ...]] | None = None,
    caveats: str = "",
    checks: tuple[Check, ...] = (),
) -> Table:
    """A table by the names of its columns, in order, separated by blanks.

    Args:
        name: Of the table.
        description: What one row is.
        columns: Names of its columns.
        uses: The columns among them that this table narrows, or adds a note to.
        key: Columns that no two rows share.
        no_key: Why there is no key.
        references: Other tables that its rows belong to, with the columns that say so.
        caveats: What a user must know about the whole table.
        checks: Checks over several columns.

    Raises:
        KeyError: A name is not declared above.
        ValueError: A column of `uses` is not in the table.
    """
    adapted = by_name(uses)
    names = columns.split()
    if unknown := set(adapted) - set(names):
        raise ValueError(f"table {name!r} has no columns {sorted(unknown)}")
    return Table(
        name=name,
        description=description,
        columns=tuple(adapted.get(each) or COLUMNS[each] for each in names),
        key=key,
        no_key=no_key,
        references=references or {},
        caveats=caveats,
        checks=checks,
    )
