"""Tables of the rig: raw samples, runs, plateaus, what was refused, and a simulation's truth.

Decides: columns and key of `samples`, `runs`, `points`, `quarantine` and coverage.
"""

import pandas as pd

from oilfilm.tables.columns import count, declare_columns, flag, number, table, text, use
from oilfilm.tables.declaration import repeated
from oilfilm.units import ABSOLUTE_ZERO_C


def _verdict_agrees_with_failed_gates(frame: pd.DataFrame) -> str:
    wrong = int((frame["accepted"] != (frame["failed_gates"] == "")).sum())
    return f"{wrong} points are accepted with a failed gate or refused without one" if wrong else ""


def _pages_are_unique(frame: pd.DataFrame) -> str:
    return repeated(frame[frame["page"] != ""], ["page"])


# fmt: off
declare_columns(
    count("samples", "rows of the log that are in the table samples"),
    count("refused_rows", "rows that are not in the table samples"),
    count("plateaus", "steady plateaus, each one row of points"),
    count("accepted_points", "points that passed every gate"),
    text("reason", "what was found and what was expected; empty where nothing was refused"),
    text("warning", "what is doubtful about a run that is used, with the likely cause; empty where "
        "nothing is"),
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
)
declare_columns(
    number("traction_force_n", "N", "traction force"),
    number("traction_force_1_n", "N", "force with the disc faster, on rigs that reverse the slip"),
    number("traction_force_2_n", "N", "force with the ball faster, on rigs that reverse the slip"),
    number("slide_roll_ratio_se", "1", "standard error of the mean slide-roll ratio",
        "random part only: calibration errors, which a whole run shares, are not included"),
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
    text("film_judgement", "full film: lambda above its limit",
        allowed=("full film", "below limit", "cannot be judged")),
)
TABLES = (
    table("samples", "One logged instant of one run, in SI units, before any correction.",
        columns="""
            run_id row time_s load_n traction_force_n traction_force_1_n traction_force_2_n
            ball_speed_m_s disc_speed_m_s inlet_temperature_c measured_film_thickness_um""",
        uses=(
            use("run_id", dictionary=True),
            use("time_s", "as logged"),
            use("load_n", "as logged"),
            use("traction_force_n", "as logged; the sensor's zero is still in it"),
            use("inlet_temperature_c", "as logged"),
        ),
        key=("run_id", "row"),
        references={"runs": ("run_id",)},
    ),
    table("runs", "One test run: its log, its set points and its verdict.",
        columns="""
            run_id campaign oil rig log_kind nominal_max_hertz_pressure_gpa nominal_load_n
            nominal_entrainment_speed_m_s nominal_inlet_temperature_c file sha256 content_sha256
            label reader encoding delimiter decimal_mark samples refused_rows plateaus
            accepted_points verdict rule reason warning""",
        uses=(
            use("refused_rows", "rows of this run in quarantine"),
            use("verdict", "accepted: at least one point passed", allowed=("accepted", "refused")),
            use("rule", "of the whole run; empty where none did"),
        ),
        key=("run_id",),
    ),
    table("points", "One steady plateau: the operating point, the traction coefficient and every "
        "gate's verdict.",
        columns="""
            run_id oil first_row last_row n_samples n_spikes time_s duration_s slide_roll_ratio
            slide_roll_ratio_se entrainment_speed_m_s load_n inlet_temperature_c
            max_hertz_pressure_gpa film_thickness_um lambda_ratio measured_film_thickness_um
            film_judgement traction_force_n traction_coefficient traction_coefficient_se slip_change
            traction_change slip_transient traction_transient force_asymmetry load_systematic_n
            traction_force_systematic_n entrainment_speed_systematic_m_s
            inlet_temperature_systematic_c accepted failed_gates""",
        uses=(
            use("first_row", "first row of the settled part"),
            use("last_row", "last row of the settled part"),
            use("time_s", "middle of the settled part"),
            use("duration_s", "null for single readings"),
            use("slide_roll_ratio", "null at standstill"),
            use("entrainment_speed_m_s", required=True),
            use("load_n", "mean over the plateau"),
            use("inlet_temperature_c", "mean over the plateau"),
            use("max_hertz_pressure_gpa", "from the measured load; null where geometry or material "
                "is unknown"),
            use("lambda_ratio", "as configured under film", at_least=0),
            use("traction_force_n", "mean above the zero reference"),
            use("traction_coefficient_se", "zero reference included, for noise whose memory is "
                "short against the plateau; null for single readings"),
        ),
        key=("run_id", "first_row"),
        references={"runs": ("run_id",)},
        caveats=("Standard errors are those of a plateau mean with autocorrelated noise. They are "
            "the random part only: calibration errors, which a whole run shares, are not "
            "included."),
        checks=(_verdict_agrees_with_failed_gates,),
    ),
    table("quarantine", "One refusal of a file, a run or a range of rows, or one remark.",
        columns="""
            campaign file run_id stage rule first_row last_row refused_rows reason advice""",
        uses=(
            use("file", "or the run sheet, in remarks on it"),
            use("run_id", "empty where the whole file is refused"),
            use("first_row", "0 where no row is meant"),
        ),
        no_key="One run or range of rows may be refused more than once.",
    ),
    table("coverage", "One operating condition of one oil on one rig: whether it was planned, and "
        "what was accepted.",
        columns="""
            oil rig nominal_max_hertz_pressure_gpa nominal_load_n nominal_entrainment_speed_m_s
            nominal_inlet_temperature_c runs_accepted runs_refused points_accepted points_refused
            state planned""",
        uses=(
            use("rig", "empty where the condition is missing and any of several rigs would do"),
            use("nominal_max_hertz_pressure_gpa", "by Hertz where the log gives a load; null where "
                "neither gives it"),
            use("nominal_load_n", "null where a pressure can be given"),
            use("points_refused", "those of refused runs included"),
        ),
        key=("oil", "rig", "nominal_max_hertz_pressure_gpa", "nominal_load_n",
            "nominal_entrainment_speed_m_s", "nominal_inlet_temperature_c"),
        caveats= "Files that cannot be read have no condition: they are in gate_counts only.",
    ),
    table("gate_counts", "One gate or rule and how much it refused; a point counts at each gate "
        "that refused it.",
        columns="""
            stage gate what files runs runs_refused points rows advice""",
        uses=(
            use("points", "points that it refused"),
        ),
        key=("stage", "gate", "what"),
    ),
    table("refused_pages", "One refused run, step or file, with its page and what is marked there.",
        columns="""
            run_id file oil page rule place first_row last_row reason advice""",
        uses=(
            use("run_id", "or step that gave none; empty where a whole file could not be read"),
            use("oil", "empty where there is no run"),
            use("first_row", "0 where the whole run is marked, or where there is no page"),
        ),
        no_key="One run or range of rows may be refused more than once.",
        checks=(_pages_are_unique,),
    ),
    table("truth", "What the rig twin planted in one simulated run.",
        columns="""
            run_id oil defect gate max_hertz_pressure_gpa entrainment_speed_m_s
            inlet_temperature_c""",
        uses=(
            use("gate", "empty for a clean run"),
            use("max_hertz_pressure_gpa", "true mean", required=True),
            use("entrainment_speed_m_s", "true mean", required=True),
            use("inlet_temperature_c", "true mean", required=True),
        ),
        key=("run_id",),
        caveats= "Only the twin and the tests read it.",
    ),
    table("truth_grid", "True traction of a simulated campaign at one condition, free of noise, "
        "beyond what was tested.",
        columns="""
            oil figure max_hertz_pressure_gpa entrainment_speed_m_s inlet_temperature_c load_n
            slide_roll_ratio traction_coefficient""",
        uses=(
            use("max_hertz_pressure_gpa", required=True),
            use("entrainment_speed_m_s", required=True, at_least=0),
            use("inlet_temperature_c", required=True, at_least=ABSOLUTE_ZERO_C),
            use("load_n", "gives the pressure on the rig", required=True, at_least=0),
            use("slide_roll_ratio", required=True, at_least=0),
            use("traction_coefficient", "true", required=True, at_least=0),
        ),
        key=("oil", "figure", "max_hertz_pressure_gpa", "entrainment_speed_m_s",
            "inlet_temperature_c", "slide_roll_ratio"),
        caveats= "Only the study of extrapolation reads it: no fit, gate or law does.",
    ),
)
