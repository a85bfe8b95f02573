"""Tables of the rig: raw samples, runs, plateaus, what was refused, and a simulation's truth."""

from collections.abc import Callable

import numpy as np
import pandas as pd
import pandera.pandas as pa
from pandera.typing.pandas import Series

from oilfilm.tables.fields import Table, count, flag, number, repeated, text
from oilfilm.units import ABSOLUTE_ZERO_C


class Samples(Table):
    """One logged instant of one run, in SI units, before any correction."""

    run_id: Series[pd.CategoricalDtype] = pa.Field(
        coerce=True, description="run the instant belongs to"
    )
    row: Series[np.int64] = count("data row in the raw log, counted from 1")
    time_s: Series[float] = number("time as logged")
    load_n: Series[float] = number("normal load as logged", gaps=True)
    traction_force_n: Series[float] = number(
        "traction force as logged; the sensor's zero is still in it", gaps=True
    )
    traction_force_1_n: Series[float] = number(
        "force with the disc faster, on rigs that reverse the slip (PCS TF1)", gaps=True
    )
    traction_force_2_n: Series[float] = number(
        "force with the ball faster, on rigs that reverse the slip (PCS TF2)", gaps=True
    )
    ball_speed_m_s: Series[float] = number("surface speed of the ball at the contact", gaps=True)
    disc_speed_m_s: Series[float] = number("surface speed of the disc at the contact", gaps=True)
    inlet_temperature_c: Series[float] = number("oil temperature at the inlet", gaps=True)
    film_thickness_um: Series[float] = number(
        "film thickness measured by optical interferometry (EHD rigs only)", gaps=True
    )


class Runs(Table):
    """One test run: where it came from and what became of it."""

    run_id: Series[str] = text("unique name of the run in its campaign")
    campaign: Series[str] = text("campaign the run belongs to")
    oil: Series[str] = text("oil as named in config/oils")
    rig: Series[str] = text("rig as named in config/rigs")
    kind: Series[str] = text(
        "continuous: a signal against time; steps: each row is already a settled reading",
        one_of=("continuous", "steps"),
    )
    nominal_max_hertz_pressure_gpa: Series[float] = number("set point", at_least=0, gaps=True)
    nominal_load_n: Series[float] = number("set point", at_least=0, gaps=True)
    nominal_entrainment_speed_m_s: Series[float] = number("set point", at_least=0, gaps=True)
    nominal_inlet_temperature_c: Series[float] = number(
        "set point", at_least=ABSOLUTE_ZERO_C, gaps=True
    )
    file: Series[str] = text("raw log, relative to the campaign's raw folder")
    sha256: Series[str] = text("of the raw log's bytes")
    content_sha256: Series[str] = text(
        "the same of a packed log once unpacked, so that copies are known, packed or not"
    )
    label: Series[str] = text("the log's own name of the run; empty where it has none")
    reader: Series[str] = text("reader that understood the log")
    samples: Series[np.int64] = count("rows of the log that are in samples")
    refused_rows: Series[np.int64] = count("rows of this run that are in quarantine")
    plateaus: Series[np.int64] = count("steady plateaus found, each a row of points")
    accepted_points: Series[np.int64] = count("points that passed every gate")
    verdict: Series[str] = text(
        "accepted: at least one point passed", one_of=("accepted", "refused")
    )
    rule: Series[str] = text("gate or rule that refused the whole run; empty if none")
    reason: Series[str] = text("what it found and what it expected; empty if none")


class Points(Table):
    """One steady plateau: the operating point, the traction coefficient and every gate's verdict.

    Standard errors are those of a plateau mean with autocorrelated noise. They hold the random
    part only: calibration errors, the same for a whole run, are not in them.
    """

    run_id: Series[str] = text("run the plateau belongs to")
    oil: Series[str] = text("oil as named in config/oils")
    first_row: Series[np.int64] = count("first row of the settled part, in the raw log")
    last_row: Series[np.int64] = count("last row of the settled part")
    n_samples: Series[np.int64] = count("rows averaged; flagged spikes are not among them")
    n_spikes: Series[np.int64] = count("rows left out of the mean as spikes of the force signal")
    time_s: Series[float] = number("middle of the settled part")
    duration_s: Series[float] = number(
        "length of the settled part; null for single readings", at_least=0, gaps=True
    )
    slide_roll_ratio: Series[float] = number(
        "sliding speed, positive with the slower body slowed, over entrainment speed; null at "
        "standstill",
        gaps=True,
    )
    slide_roll_ratio_se: Series[float] = number("standard error of the mean", gaps=True)
    entrainment_speed_m_s: Series[float] = number("mean of the two surface speeds")
    load_n: Series[float] = number("mean normal load", gaps=True)
    inlet_temperature_c: Series[float] = number("mean inlet temperature", gaps=True)
    max_hertz_pressure_gpa: Series[float] = number(
        "by Hertz from the measured load; null where geometry or material is unknown",
        at_least=0,
        gaps=True,
    )
    film_thickness_um: Series[float] = number(
        "calculated (Hamrock-Dowson, settings under film); null where it cannot be calculated",
        at_least=0,
        gaps=True,
    )
    lambda_ratio: Series[float] = number(
        "film thickness over combined roughness, as configured under film", at_least=0, gaps=True
    )
    measured_film_thickness_um: Series[float] = number(
        "measured by optical interferometry (EHD rigs only)", gaps=True
    )
    film_judgement: Series[str] = text(
        "full film: lambda above its limit",
        one_of=("full film", "below limit", "cannot be judged"),
    )
    traction_force_n: Series[float] = number("mean force above the zero reference", gaps=True)
    traction_coefficient: Series[float] = number("traction force over load", gaps=True)
    traction_coefficient_se: Series[float] = number(
        "random standard error, zero reference included, for noise whose memory is short against "
        "the plateau; null for single readings",
        at_least=0,
        gaps=True,
    )
    slip_change: Series[float] = number("second half minus first half of the plateau", gaps=True)
    traction_change: Series[float] = number("the same of the traction coefficient", gaps=True)
    slip_transient: Series[float] = number(
        "beginning of the plateau (config: transient_share) minus the rest of it", gaps=True
    )
    traction_transient: Series[float] = number("the same of the traction coefficient", gaps=True)
    force_asymmetry: Series[float] = number(
        "|TF1 + TF2| / (|TF1| + |TF2|): 0 where both slip directions pull alike, 1 where one has "
        "not reversed",
        at_least=0,
        at_most=1 + 1e-9,
        gaps=True,
    )
    load_systematic_n: Series[float] = number(
        "standard uncertainty of the load's calibration, shared by all points of the rig; null "
        "where the rig file states none",
        at_least=0,
        gaps=True,
    )
    traction_force_systematic_n: Series[float] = number(
        "the same of the traction force", at_least=0, gaps=True
    )
    entrainment_speed_systematic_m_s: Series[float] = number(
        "the same of the entrainment speed", at_least=0, gaps=True
    )
    inlet_temperature_systematic_c: Series[float] = number(
        "the same of the inlet temperature", at_least=0, gaps=True
    )
    accepted: Series[bool] = flag("true where no gate refused the point")
    failed_gates: Series[str] = text(
        "names of the gates that refused it, joined by ';'; empty if none"
    )


class Quarantine(Table):
    """One thing that was refused - a file, a run or a range of rows - and why."""

    campaign: Series[str] = text("campaign")
    file: Series[str] = text("raw log, relative to the campaign's raw folder")
    run_id: Series[str] = text("run concerned; empty where the whole file is")
    stage: Series[str] = text("stage that refused", one_of=("ingest", "curate"))
    rule: Series[str] = text("name of the rule or gate")
    first_row: Series[np.int64] = count("first data row concerned; 0 where no row is meant")
    last_row: Series[np.int64] = count("last data row concerned")
    refused_rows: Series[np.int64] = count("rows that are not in samples because of this")
    reason: Series[str] = text("what was found and what was expected")
    advice: Series[str] = text("what to do about it")


class Coverage(Table):
    """One operating condition of one oil on one rig: what was planned, and what came of it.

    Files that cannot be read at all have no condition: they stand in `gate_counts` alone.
    """

    oil: Series[str] = text("oil as named in config/oils")
    rig: Series[str] = text("rig; empty where the condition is missing and any of several would do")
    nominal_max_hertz_pressure_gpa: Series[float] = number(
        "set point, by Hertz where the log gives a load; null where neither gives it",
        at_least=0,
        gaps=True,
    )
    nominal_load_n: Series[float] = number(
        "set point where no pressure can be given; else null", at_least=0, gaps=True
    )
    nominal_entrainment_speed_m_s: Series[float] = number("set point", at_least=0, gaps=True)
    nominal_inlet_temperature_c: Series[float] = number(
        "set point", at_least=ABSOLUTE_ZERO_C, gaps=True
    )
    runs_accepted: Series[np.int64] = count("runs with at least one accepted point")
    runs_refused: Series[np.int64] = count("runs with none")
    points_accepted: Series[np.int64] = count("points that passed every gate")
    points_refused: Series[np.int64] = count("points that did not, those of refused runs included")
    state: Series[str] = text(
        "accepted: at least one run is; refused: none of its runs is; missing: no run at all",
        one_of=("accepted", "refused", "missing"),
    )
    planned: Series[bool] = flag("true where the campaign's matrix has the condition")


class GateCounts(Table):
    """One gate or rule and how much it refused. A point counts at each gate that refused it."""

    stage: Series[str] = text("stage that refused", one_of=("ingest", "curate"))
    gate: Series[str] = text("name of the rule or gate")
    what: Series[str] = text(
        "what it judges: a whole file, a run, a point or rows",
        one_of=("file", "run", "point", "rows"),
    )
    files: Series[np.int64] = count("logs concerned")
    runs: Series[np.int64] = count("runs concerned, wholly or in part")
    runs_refused: Series[np.int64] = count("runs refused as a whole by it")
    points: Series[np.int64] = count("points that it refused")
    rows: Series[np.int64] = count("rows kept out of samples because of it")
    advice: Series[str] = text("what to do about it")


class RefusedPages(Table):
    """One run, step or file that was refused, where its page is and which place is marked."""

    run_id: Series[str] = text(
        "run, or step that gave none; empty where a whole file could not be read"
    )
    file: Series[str] = text("raw log, relative to the campaign's raw folder")
    oil: Series[str] = text("oil; empty where there is no run")
    page: Series[str] = text(
        "picture beside this table; empty where there is no signal to show, or where the page is "
        "beyond refused_pages_max"
    )
    rule: Series[str] = text("name of the rule or gate")
    place: Series[str] = text(
        "what is marked: the rows that the rule names, the plateaus that fail gates of their own "
        "where it names none, else the whole run; empty where there is no page",
        one_of=("rows", "plateaus", "whole run", ""),
    )
    first_row: Series[np.int64] = count(
        "first data row marked; 0 where it is the whole run, or where there is no page"
    )
    last_row: Series[np.int64] = count("last data row marked")
    reason: Series[str] = text("what was found and what was expected")
    advice: Series[str] = text("what to do about it")


class Truth(Table):
    """What the rig twin planted in a simulated run. Only the twin and the tests read it."""

    run_id: Series[str] = text("run")
    oil: Series[str] = text("oil")
    defect: Series[str] = text("planted defect; empty for a clean run")
    gate: Series[str] = text("gate or rule that must catch it; empty for a clean run")
    max_hertz_pressure_gpa: Series[float] = number("true mean pressure")
    entrainment_speed_m_s: Series[float] = number("true mean speed")
    inlet_temperature_c: Series[float] = number("true mean temperature")


class TruthGrid(Table):
    """The traction that is true in a simulated campaign, free of noise, beyond what was tested.

    Only what holds fits against it reads it: no fit, gate or law does.
    """

    oil: Series[str] = text("oil")
    figure: Series[str] = text("figure of the paper that has the condition")
    max_hertz_pressure_gpa: Series[float] = number("maximum Hertz pressure", at_least=0)
    entrainment_speed_m_s: Series[float] = number("entrainment speed", at_least=0)
    inlet_temperature_c: Series[float] = number("inlet temperature", at_least=ABSOLUTE_ZERO_C)
    load_n: Series[float] = number("normal load that gives the pressure on the rig", at_least=0)
    slide_roll_ratio: Series[float] = number("slide-roll ratio", at_least=0)
    traction_coefficient: Series[float] = number("true mu", at_least=0)


TABLES: dict[str, type[Table]] = {
    "samples": Samples,
    "runs": Runs,
    "points": Points,
    "quarantine": Quarantine,
    "coverage": Coverage,
    "gate_counts": GateCounts,
    "refused_pages": RefusedPages,
    "truth": Truth,
    "truth_grid": TruthGrid,
}
# columns that no two rows of a table share
KEYS: dict[str, tuple[str, ...]] = {
    "runs": ("run_id",),
    "points": ("run_id", "first_row"),
    "coverage": (
        "oil",
        "rig",
        "nominal_max_hertz_pressure_gpa",
        "nominal_load_n",
        "nominal_entrainment_speed_m_s",
        "nominal_inlet_temperature_c",
    ),
    "gate_counts": ("stage", "gate", "what"),
}


def _verdict_agrees_with_gates(frame: pd.DataFrame) -> str:
    wrong = frame["accepted"] != (frame["failed_gates"] == "")
    return f"{wrong.sum()} points are accepted with a failed gate or refused without" * bool(
        wrong.any()
    )


def _pages_are_unique(frame: pd.DataFrame) -> str:
    return repeated(frame[frame["page"] != ""], ["page"])


# checks over several columns; each returns a complaint or an empty text
CHECKS: dict[str, Callable[[pd.DataFrame], str]] = {
    "points": _verdict_agrees_with_gates,
    "refused_pages": _pages_are_unique,
}
