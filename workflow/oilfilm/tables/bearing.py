"""Tables of the bearing: measured torque, torque by model, cage slip, size effect."""

from oilfilm.tables.columns import table, use
from oilfilm.units import ABSOLUTE_ZERO_C

# fmt: off
_FRICTION = """
    converged why residual energy_error quadrature_error torque_n_m outer_ring_torque_n_m
    traction_torque_n_m rolling_torque_n_m hysteresis_torque_n_m drag_torque_n_m pocket_torque_n_m
    land_torque_n_m gross_torque_n_m spin_torque_n_m differential_torque_n_m gyroscopic_torque_n_m
    cage_slip inner_slide_roll_ratio inner_contact_angle_deg outer_contact_angle_deg
    inner_max_hertz_pressure_gpa outer_max_hertz_pressure_gpa entrainment_speed_m_s lambda_ratio
    film_in_range largest_slide_roll_ratio mean_traction_coefficient share_beyond_slip
    share_beyond_pressure share_beyond_speed
"""
_BRANCHES = " bistable other_cage_slip other_torque_n_m "
_UNCERTAINTY = """
    power_w torque_n_m_uncertainty torque_n_m_lower torque_n_m_upper cage_slip_uncertainty
    cage_slip_lower cage_slip_upper power_w_uncertainty power_w_lower power_w_upper draws_split
"""
_FRICTION_USES = (
    use("torque_n_m", "calculated: sum of the six terms"),
    use("entrainment_speed_m_s", "mean of both races"),
    use("lambda_ratio", "minimum film over combined Rq; the worse race. Thermally reduced at each "
        "contact's own slip, its mean over the ellipse weighted by load: spin slides outside the "
        "middle alone. Null where film_in_range is false, which is no thin film", at_least=0),
)
TABLES = (
    table("torque_runs", "One steady plateau of a torque log: one speed of a bearing under one "
        "axial load.",
        columns="""
            run_id oil bearing sha256 reader first_row last_row n_samples n_spikes time_s duration_s
            inner_speed_rpm axial_load_n oil_temperature_c outer_ring_temperature_c tare_n_m
            torque_n_m torque_n_m_se torque_change_n_m oil_temperature_change_c accepted
            failed_gates""",
        uses=(
            use("first_row", "first row of the settled part"),
            use("last_row", "last row of the settled part"),
            use("time_s", "middle of the settled part"),
            use("duration_s", required=True),
            use("inner_speed_rpm", "mean over the plateau"),
            use("axial_load_n", "mean over the plateau"),
            use("oil_temperature_c", "mean over the plateau"),
            use("outer_ring_temperature_c", "mean over the plateau"),
            use("torque_n_m", "measured: mean over the plateau, tare subtracted; taken as what the "
                "inner ring needs", required=True),
            use("torque_n_m_se", required=True),
        ),
        key=("run_id", "first_row"),
    ),
    table("torque", "One plateau of a torque log: measured torque and the torque by one load "
        "variable of the law.",
        columns=_FRICTION + _BRANCHES + _UNCERTAINTY + """
            run_id first_row oil bearing load_variable inner_speed_rpm axial_load_n
            inlet_temperature_c measured_torque_n_m measured_torque_n_m_se
            measured_torque_n_m_uncertainty relative_error compatibility verdict
            palmgren_torque_n_m skf_torque_n_m skf_valid""",
        uses=(
            *_FRICTION_USES,
            use("first_row", "first row of its plateau"),
            use("inlet_temperature_c", required=True),
            use("verdict", "compatible: the compatibility is 2 at most, to either side; not known: "
                "the calculated torque has no uncertainty",
                allowed=("compatible", "not compatible", "not known")),
        ),
        key=("run_id", "first_row", "load_variable"),
        references={"torque_runs": ("run_id", "first_row")},
    ),
    table("torque_control", "What the comparison with SIMULATED torque can show for one oil.",
        columns="""
            oil verdict law_misfit n_plateaus median_torque_error largest_torque_error""",
        uses=(
            use("verdict", "positive control: the fitted law itself made the logs of both rigs, so "
                "that the comparison checks the code and nothing else; one truth: other physics "
                "made the logs of both; two truths: law_misfit is above audit.twin_misfit_max, so "
                "that the comparison shows nothing",
                allowed=("positive control", "one truth", "two truths")),
        ),
        key=("oil",),
        caveats="No row where the torque was measured.",
    ),
    table("torque_inversion", "Traction at the raceways inferred from the measured torque, with "
        "the other terms as calculated.",
        columns="""
            run_id first_row oil inner_speed_rpm axial_load_n inlet_temperature_c traction_share
            law_traction_coefficient traction_coefficient traction_coefficient_se
            traction_coefficient_systematic verdict""",
        uses=(
            use("first_row", "first row of its plateau"),
            use("inlet_temperature_c", required=True),
            use("traction_coefficient", "mean over the contacts that gives the measured torque; "
                "null where none does"),
            use("traction_coefficient_se", "from the random error of the torque"),
            use("verdict", "undetermined: the uncertainty is as large as the value",
                allowed=("determined", "undetermined", "no solution")),
        ),
        key=("run_id", "first_row"),
        references={"torque_runs": ("run_id", "first_row")},
    ),
    table("cage_slip", "Cage slip of one oil at one speed and axial load, from the friction "
        "equilibrium.",
        columns=_FRICTION + _BRANCHES + _UNCERTAINTY + """
            oil bearing pitch_speed_mm_rpm inner_speed_rpm axial_load_n inlet_temperature_c""",
        uses=(
            *_FRICTION_USES,
            use("inlet_temperature_c", required=True),
        ),
        key=("oil", "pitch_speed_mm_rpm", "axial_load_n"),
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
    table("heat_balance", "One oil at one point of the map of cage slip, or at one measured "
        "plateau: oil of the contacts at its inlet temperature, and as warm as friction makes it.",
        columns="""
            run_id first_row oil bearing inner_speed_rpm axial_load_n inlet_temperature_c balanced
            heat_w outlet_temperature_c contact_temperature_c torque_n_m heated_torque_n_m cage_slip
            heated_cage_slip lambda_ratio heated_lambda_ratio best_oil heated_best_oil""",
        uses=(
            use("run_id", "empty on the map"),
            use("first_row", "first row of its plateau; 0 on the map"),
            use("inlet_temperature_c", required=True),
            use("torque_n_m", "calculated, with oil at its inlet temperature"),
            use("cage_slip", "with oil at its inlet temperature"),
            use("lambda_ratio", "as in cage_slip, with oil at its inlet temperature", at_least=0),
            use("best_oil", "of this point of the map, as in slip_advice; empty at plateaus"),
            use("heated_best_oil", "empty at plateaus"),
        ),
        key=("run_id", "first_row", "oil", "inner_speed_rpm", "axial_load_n"),
        caveats="A lumped balance with one temperature for all contacts. Empty where the bearing's "
        "file has no oil_supply.",
    ),
    table("size_effect", "Torque by one load variable of the law for balls of another size or "
        "closer grooves.",
        columns=_FRICTION + """
            oil bearing varied ball_diameter_mm groove_curvature load_variable axial_load_n
            inner_speed_rpm inlet_temperature_c relative_to_stress""",
        uses=(
            *_FRICTION_USES,
            use("inlet_temperature_c", required=True),
        ),
        key=("oil", "varied", "ball_diameter_mm", "groove_curvature", "load_variable"),
    ),
    table("published_tests", "Published tests of bearings and the calculated values, on which the "
        "drag is calibrated: power loss of one, cage slip of another.",
        columns=_FRICTION + """
            bearing oil inner_speed_rpm axial_load_n inlet_temperature_c published_power_w
            published_cage_slip power_w power_low_w power_high_w cage_slip_low cage_slip_high
            fitted_oil_volume_fraction oil_volume_fraction_alone source assumed""",
        uses=(
            *_FRICTION_USES,
            use("oil", "its traction was used"),
            use("inlet_temperature_c", required=True),
        ),
        key=("bearing", "inner_speed_rpm", "axial_load_n"),
        caveats="It is never a gate.",
    ),
    table("test_plan", "One test that the rig can run, with what it does to the uncertainty of "
        "torque or cage slip; the tests to run next are numbered.",
        columns="""
            oil target bearing max_hertz_pressure_gpa entrainment_speed_m_s inlet_temperature_c
            load_n slide_roll_ratio lambda_ratio test_order uncertainty_now uncertainty_with_test
            uncertainty_with_plan""",
        uses=(
            use("bearing", "empty where the target is traction"),
            use("max_hertz_pressure_gpa", required=True),
            use("entrainment_speed_m_s", required=True, at_least=0),
            use("inlet_temperature_c", required=True, at_least=ABSOLUTE_ZERO_C),
            use("load_n", "gives the pressure on the rig", required=True, at_least=0),
            use("slide_roll_ratio", "largest of the test", required=True, at_least=0),
            use("lambda_ratio", "at the largest slip", required=True),
            use("uncertainty_now", required=True),
            use("uncertainty_with_test", required=True),
        ),
        key=("oil", "target", "max_hertz_pressure_gpa", "entrainment_speed_m_s",
            "inlet_temperature_c"),
        caveats="It assumes that the law's form is right: errors of that form beyond the tested "
            "box are not covered.",
    ),
    table("torque_truth", "What the rig twin planted at one speed of a simulated torque log.",
        columns="""
            run_id oil defect inner_speed_rpm axial_load_n oil_temperature_c torque_n_m
            traction_torque_n_m law_misfit""",
        uses=(
            use("torque_n_m", "true", required=True),
            use("traction_torque_n_m", "true", required=True),
        ),
        key=("run_id", "inner_speed_rpm"),
        caveats= "The analysis reads law_misfit alone.",
    ),
)
