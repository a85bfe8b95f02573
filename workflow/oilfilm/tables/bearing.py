"""Tables of the bearing: measured torque, torque by model, cage slip, size effect."""

from oilfilm.tables.columns import table, use
from oilfilm.units import ABSOLUTE_ZERO_C

# fmt: off
FRICTION = """
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
FRICTION_USES = (
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
        columns=FRICTION + _BRANCHES + _UNCERTAINTY + """
            run_id first_row oil bearing load_variable inner_speed_rpm axial_load_n
            inlet_temperature_c measured_torque_n_m measured_torque_n_m_se
            measured_torque_n_m_uncertainty relative_error compatibility verdict
            palmgren_torque_n_m skf_torque_n_m skf_valid""",
        uses=(
            *FRICTION_USES,
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
        columns=FRICTION + _BRANCHES + _UNCERTAINTY + """
            oil bearing pitch_speed_mm_rpm inner_speed_rpm axial_load_n inlet_temperature_c""",
        uses=(
            *FRICTION_USES,
            use("inlet_temperature_c", required=True),
        ),
        key=("oil", "pitch_speed_mm_rpm", "axial_load_n"),
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
            use("best_oil", "of this point of the map: with a full film and the cage slip within "
                "selection.limits.slip_limit the one with the least torque; else the one with the "
                "least slip; empty at plateaus"),
            use("heated_best_oil", "empty at plateaus"),
        ),
        key=("run_id", "first_row", "oil", "inner_speed_rpm", "axial_load_n"),
        caveats="A lumped balance with one temperature for all contacts. Empty where the bearing's "
        "file has no oil_supply.",
    ),
    table("size_effect", "Torque by one load variable of the law for balls of another size or "
        "closer grooves.",
        columns=FRICTION + """
            oil bearing varied ball_diameter_mm groove_curvature load_variable axial_load_n
            inner_speed_rpm inlet_temperature_c relative_to_stress""",
        uses=(
            *FRICTION_USES,
            use("inlet_temperature_c", required=True),
        ),
        key=("oil", "varied", "ball_diameter_mm", "groove_curvature", "load_variable"),
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
