"""Tables about the paper: printed constants judged, claims audited, its advice on oils."""

from oilfilm.tables import declare
from oilfilm.tables.bearing import FRICTION, FRICTION_USES
from oilfilm.tables.columns import table, use

# fmt: off
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
            claim section statement wording basis definition judged_on verdict finding cases share
            share_tested_box share_extrapolated_box worst_quantity worst_value worst_detail
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
