"""Tables about the paper: printed constants judged, claims audited, its advice on oils.

Decides: columns and key of the tables of the paper.
"""

from oilfilm.paper.audit.reasons import REASONS
from oilfilm.tables import declare
from oilfilm.tables.bearing import FRICTION, FRICTION_USES
from oilfilm.tables.columns import (
    SLIP,
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
from oilfilm.tables.declaration import BY_ROW, LARGEST

# fmt: off
_CIRCULAR = (
    "CIRCULAR where the points are simulated from the printed constants; simulated from anything "
    "else it says nothing of the real oils"
)
_EXPONENTS = ("a0", "a1", "a2", "a3", "b0", "b1", "b2", "b3", "c0", "c1", "c2", "c3")
declare_columns(
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
                    *TEST_CONDITIONS,
                    SLIP,
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
    text("basis", "refit: the campaign's own fits and points; printed: the paper's constants, "
        "signs restored, and its Eq. 1", allowed=("refit", "printed")),
    text("judged_on", "conditions at which the claim was judged: the box tested by the paper, the "
        "box of its figs 7 to 10, the campaign's data or the paper's Eq. 1",
        allowed=("tested", "extrapolated", "data", "formula")),
    text("reason_code", "why the claim cannot be checked; empty where it was",
        allowed=("", *REASONS)),
    text("number", "name of the number; data/reference/claims.yaml says what it is"),
    count("cases", "conditions or rows at which the claim was judged"),
    share("share", "share of the cases in which the claim holds"),
    share("share_tested_box", "share of the cases in the tested box; null where there is none"),
    share("share_extrapolated_box", "share of the cases in the box of the paper's figs 7 to 10"),
    number("worst_value", BY_ROW, "value in the case that is farthest from holding",
        "unit: that of the claim's quantity in data/reference/claims.yaml"),
    text("worst_oil", "oil in the worst case; empty where oils are compared"),
)
declare_columns(
    text("selection_rule", "first rule of selection.rules that applies"),
    text("aim", "what the rule maximises or minimises", allowed=("most traction", "least heat")),
    text("advised_oil", "oil that the rule advises; empty where none that it prefers has enough "
        "film"),
    text("contradicting_rules", "later rules that advise another oil, joined by '; '"),
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
TABLES = (
    table("printed_judged", "The printed constants of one oil compared with the campaign's own "
        "fit.",
        columns="""
            oil n_points printed_sse fitted_sse a0_distance a1_distance a2_distance a3_distance
            b0_distance b1_distance b2_distance b3_distance c0_distance c1_distance c2_distance
            c3_distance joint_distance tested_difference tested_traction_coefficient
            tested_max_hertz_pressure_gpa tested_entrainment_speed_m_s tested_inlet_temperature_c
            tested_slide_roll_ratio extrapolated_difference extrapolated_traction_coefficient
            extrapolated_max_hertz_pressure_gpa extrapolated_entrainment_speed_m_s
            extrapolated_inlet_temperature_c extrapolated_slide_roll_ratio""",
        uses=(
            use("n_points", "those of the fit"),
        ),
        key=("oil",),
        caveats= "Null where the conditions cannot give all twelve constants, or their errors.",
    ),
    table("signs", "One of the 512 sign sets of an oil's nine printed exponents, compared with the "
        "paper's text.",
        columns="""
            oil signs in_use rank rank_at_figures total near_best physical rises_with_stress
            linear_in_stress falls_with_speed levels_off_with_speed falls_with_temperature
            levels_off_with_temperature start_falls_with_temperature rises_with_slip
            declines_slightly earlier_plateau_with_stress earlier_plateau_with_speed
            earlier_plateau_with_temperature slip_raises_stress_effect speed_mutes_stress_effect
            speed_mutes_temperature_effect viscosity_order hot_convergence sse""",
        uses=(
            use("sse", "on the accepted points of the campaign"),
        ),
        key=("oil", "signs"),
        caveats=("Thresholds: `printed.signs` of the configuration. Not judged: claims that A0 < "
            "0, B0 > 0 and C0 > 0 make true for every set (mu = 0 at S = 0, one peak, a linear "
            "start)."),
    ),
    table("sign_verdicts", "How certain the sign of one printed exponent is.",
        columns="""
            oil constant sign margin weakest_margin weakest_without weakest_slips near_best_share
            effect least_sse least_sse_turned verdict""",
        uses=(
            use("weakest_margin", required=True),
            use("verdict", "settled: every near-best set has this sign, whichever statement is "
                "left out and at either slips; probable: with every statement, at the slips of the "
                "whole curve; against: every one has the other sign; open: some have either; "
                "without effect: it moves mu by no_effect_max at most",
                allowed=("settled", "probable", "open", "against", "without effect")),
        ),
        key=("oil", "constant"),
    ),
    table("claims", "One claim of the paper, judged on one basis.",
        columns="""
            claim basis judged_on verdict reason_code cases share share_tested_box
            share_extrapolated_box worst_value
            worst_oil worst_max_hertz_pressure_gpa worst_entrainment_speed_m_s
            worst_inlet_temperature_c worst_slide_roll_ratio""",
        uses=(
            use("verdict", "by the share of the cases (audit.holds_share, audit.fails_share of "
                "config.yaml); by construction: it holds, but the law's equation makes it so "
                "whatever the data are",
                allowed=("holds", "by construction", "holds in part", "fails",
                    "cannot be checked")),
        ),
        key=("claim", "basis"),
    ),
    table("claim_numbers", "A further number of a claim, as the share of the cases in which a part "
        "of it holds.",
        columns="claim basis number oil value",
        uses=(
            use("oil", "empty where the number is of all oils"),
            use("value", required=True),
        ),
        key=("claim", "basis", "number", "oil"),
    ),
    table("selection", "One operating point: the oil that the paper's rules advise, and the best "
        "one by the numbers.",
        columns="""
            basis max_hertz_pressure_gpa entrainment_speed_m_s inlet_temperature_c slide_roll_ratio
            cage_slip selection_rule aim advised_oil contradicting_rules best_oil judgement
            loss_ratio advised_lambda_ratio best_lambda_ratio advised_traction_coefficient
            best_traction_coefficient""",
        uses=(
            use("max_hertz_pressure_gpa", required=True),
            use("entrainment_speed_m_s", required=True, at_least=0),
            use("inlet_temperature_c", required=True),
            use("slide_roll_ratio", required=True),
            use("cage_slip", "that has this slide-roll ratio by selection.reading", required=True),
            use("advised_oil", "the first that it prefers with enough film"),
            use("best_oil", "it meets the aim best"),
            use("judgement", "agree: the advised oil is best, or within selection.indifference of "
                "it; rule has none: no oil that it prefers has enough film, another has; no film: "
                "none has; outside the film formula: the choice depends on a film beyond the range "
                "of the thermal reduction", allowed=("agree", "disagree", "rule has none",
                "no film", "outside the film formula")),
        ),
        key=("basis", "max_hertz_pressure_gpa", "entrainment_speed_m_s", "inlet_temperature_c",
            "slide_roll_ratio"),
        caveats= "Lambda is that of the traction rig's contact, for oils that may be stand-ins.",
    ),
    table("slip_advice", "One operating point of a bearing: the oil that holds its cage, and the "
        "paper's advice.",
        columns="""
            bearing inlet_temperature_c pitch_speed_mm_rpm inner_speed_rpm axial_load_n
            oils_within_limit selection_rule slip_that_decides advised_oil advised_cage_slip
            advised_torque_n_m best_oil best_cage_slip best_torque_n_m good_oils judgement
            agree_share best_oil_share best_oils""",
        uses=(
            use("inlet_temperature_c", required=True),
            use("advised_oil", "of those that it prefers the first with enough film that holds the "
                "cage, else the last with enough film"),
            use("best_oil", "within the slip limit the one with the least torque; else the one "
                "with the least slip"),
            use("judgement", "agree: the advised oil is the best, or within selection.indifference "
                "of it; slips: beyond the limit while another oil does not; slips more: all do, "
                "and another less; heats more: within the limit, with more torque than another; "
                "rule has none: no oil that it prefers has enough film, another has; no film: none "
                "has; outside the film formula: the choice depends on a film beyond the range of "
                "the thermal reduction",
                allowed=("agree", "slips", "slips more", "heats more", "rule has none", "no film",
                    "outside the film formula")),
        ),
        key=("pitch_speed_mm_rpm", "axial_load_n"),
        caveats= "Scenarios: those of `advice_band` in which there is a choice at this point.",
    ),
    table("advice_band", "One scenario of drag and law: at how many operating points of a bearing "
        "the paper's advice agrees with the best oil by cage slip.",
        columns="""
            oil_volume_fraction refit bearing operating_points agreeing_points""",
        key=("oil_volume_fraction", "refit"),
        caveats= "Refit 0 is the fit. Beyond the tested conditions a law may be further off than "
            "its refits show.",
    ),
    table("published_tests", "Published tests of bearings and the calculated values, on which the "
        "drag is calibrated: power loss of one, cage slip of another.",
        columns=FRICTION + """
            bearing oil inner_speed_rpm axial_load_n inlet_temperature_c published_power_w
            published_cage_slip power_w power_low_w power_high_w cage_slip_low cage_slip_high
            fitted_oil_volume_fraction oil_volume_fraction_alone source assumed""",
        uses=(
            *FRICTION_USES,
            use("oil", "its traction was used"),
            use("inlet_temperature_c", required=True),
        ),
        key=("bearing", "inner_speed_rpm", "axial_load_n"),
        caveats="It is never a gate.",
    ),
)
# fmt: on
for each in TABLES:
    declare(each)
