"""Tables of the bearing: measured torque, torque by model, cage slip, size effect.

Decides: columns and key of the tables of torque.
"""

from oilfilm.tables.columns import count, declare_columns, flag, number, share, table, text, use
from oilfilm.tables.declaration import LARGEST
from oilfilm.units import ABSOLUTE_ZERO_C

# fmt: off
_CONDITIONAL = ("law's refits, calibration of the traction rig and the other terms' assumed "
    "uncertainty; true as far as the law's form is, which beyond the tested box nobody has tested; "
    "null without refits (fewer than 10 runs) or where over 5 % of the draws have no equilibrium")
declare_columns(
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
        "same points"),
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
