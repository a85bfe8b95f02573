"""The contract: what every table holds, checked whenever one is written or read.

One pandera model stands for one table. A column's unit is the end of its name (`load_n`,
`entrainment_speed_m_s`), its meaning is its description here, and both travel in the Parquet
file, beside the schema version and the provenance.
"""

import json
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any, cast

import numpy as np
import pandas as pd
import pandera.pandas as pa
import pyarrow as arrow
import pyarrow.parquet as parquet
from pandera.typing.pandas import Series

from oilfilm.errors import OilfilmError
from oilfilm.units import ABSOLUTE_ZERO_C

SCHEMA_VERSION = 4

# The end of a column's name -> its unit; the longest ending that fits counts.
_UNITS = {
    "_s": "s",
    "_n": "N",
    "_m_s": "m/s",
    "_c": "degC",
    "_systematic_c": "K",
    "_change": "1",
    "_transient": "1",
    "_asymmetry": "1",
    "_rms": "1",
    "rmse": "1",
    "sse": "1",
    "_error": "1",
    "_spread": "1",
    "_cosine": "1",
    "_traction": "1",
    "condition_number": "1",
    "_gpa": "GPa",
    "_um": "um",
    "_ratio": "1",
    "_rpm": "rpm",
    "_n_m": "N m",
    "_deg": "deg",
    "_w": "W",
    "_mm": "mm",
    "_mm_rpm": "mm rpm",
    "_slip": "1",
    "_curvature": "1",
    "_coefficient": "1",
    "_difference": "1",
    "correlation": "1",
    "signed_root": "1",
    "gain": "1",
    "_weight": "1",
    "aic": "1",
    "bic": "1",
    "_share": "1",
}
# Infinity passes a plain lower bound; no quantity of a traction rig comes near this one.
LARGEST = 1e12


def _number(
    description: str, *, at_least: float = -LARGEST, at_most: float = LARGEST, gaps: bool = False
) -> Any:
    return pa.Field(ge=at_least, le=at_most, nullable=gaps, coerce=True, description=description)


def _share(description: str, *, gaps: bool = False) -> Any:
    return _number(description, at_least=0, at_most=1, gaps=gaps)


def _count(description: str) -> Any:
    return pa.Field(ge=0, coerce=True, description=description)


def _text(description: str, *, one_of: tuple[str, ...] = (), gaps: bool = False) -> Any:
    allowed: dict[str, Any] = {"isin": list(one_of)} if one_of else {}
    return pa.Field(nullable=gaps, coerce=True, description=description, **allowed)


def _flag(description: str) -> Any:
    return pa.Field(coerce=True, description=description)


class _Table(pa.DataFrameModel):
    class Config:
        strict = True
        ordered = True


class Samples(_Table):
    """One logged instant of one run, in SI units, before any correction."""

    run_id: Series[pd.CategoricalDtype] = pa.Field(
        coerce=True, description="run the instant belongs to"
    )
    row: Series[np.int64] = _count("data row in the raw log, counted from 1")
    time_s: Series[float] = _number("time as logged")
    load_n: Series[float] = _number("normal load as logged", gaps=True)
    traction_force_n: Series[float] = _number(
        "traction force as logged; the sensor's zero is still in it", gaps=True
    )
    traction_force_1_n: Series[float] = _number(
        "force with the disc faster, on rigs that reverse the slip (PCS TF1)", gaps=True
    )
    traction_force_2_n: Series[float] = _number(
        "force with the ball faster, on rigs that reverse the slip (PCS TF2)", gaps=True
    )
    ball_speed_m_s: Series[float] = _number("surface speed of the ball at the contact", gaps=True)
    disc_speed_m_s: Series[float] = _number("surface speed of the disc at the contact", gaps=True)
    inlet_temperature_c: Series[float] = _number("oil temperature at the inlet", gaps=True)
    film_thickness_um: Series[float] = _number(
        "film thickness measured by optical interferometry (EHD rigs only)", gaps=True
    )


class Runs(_Table):
    """One test run: where it came from and what became of it."""

    run_id: Series[str] = _text("unique name of the run in its campaign")
    campaign: Series[str] = _text("campaign the run belongs to")
    oil: Series[str] = _text("oil as named in config/oils")
    rig: Series[str] = _text("rig as named in config/rigs")
    kind: Series[str] = _text(
        "continuous: a signal against time; steps: each row is already a settled reading",
        one_of=("continuous", "steps"),
    )
    nominal_max_hertz_pressure_gpa: Series[float] = _number("set point", at_least=0, gaps=True)
    nominal_load_n: Series[float] = _number("set point", at_least=0, gaps=True)
    nominal_entrainment_speed_m_s: Series[float] = _number("set point", at_least=0, gaps=True)
    nominal_inlet_temperature_c: Series[float] = _number(
        "set point", at_least=ABSOLUTE_ZERO_C, gaps=True
    )
    file: Series[str] = _text("raw log, relative to the campaign's raw folder")
    sha256: Series[str] = _text("of the raw log's bytes")
    label: Series[str] = _text("the log's own name of the run; empty where it has none")
    reader: Series[str] = _text("reader that understood the log")
    samples: Series[np.int64] = _count("rows of the log that are in samples")
    refused_rows: Series[np.int64] = _count("rows of this run that are in quarantine")
    plateaus: Series[np.int64] = _count("steady plateaus found, each a row of points")
    accepted_points: Series[np.int64] = _count("points that passed every gate")
    verdict: Series[str] = _text(
        "accepted: at least one point passed", one_of=("accepted", "refused")
    )
    reason: Series[str] = _text("gate that refused the whole run and what it saw; empty if none")


class Points(_Table):
    """One steady plateau: the operating point, the traction coefficient and every gate's verdict.

    Standard errors are those of a plateau mean with autocorrelated noise. They hold the random
    part only: calibration errors, the same for a whole run, are not in them.
    """

    run_id: Series[str] = _text("run the plateau belongs to")
    oil: Series[str] = _text("oil as named in config/oils")
    first_row: Series[np.int64] = _count("first row of the settled part, in the raw log")
    last_row: Series[np.int64] = _count("last row of the settled part")
    n_samples: Series[np.int64] = _count("rows averaged; flagged spikes are not among them")
    n_spikes: Series[np.int64] = _count("rows left out of the mean as spikes of the force signal")
    time_s: Series[float] = _number("middle of the settled part")
    duration_s: Series[float] = _number(
        "length of the settled part; null for single readings", at_least=0, gaps=True
    )
    slide_roll_ratio: Series[float] = _number(
        "sliding speed, positive with the slower body slowed, over entrainment speed; null at "
        "standstill",
        gaps=True,
    )
    slide_roll_ratio_se: Series[float] = _number("standard error of the mean", gaps=True)
    entrainment_speed_m_s: Series[float] = _number("mean of the two surface speeds")
    load_n: Series[float] = _number("mean normal load", gaps=True)
    inlet_temperature_c: Series[float] = _number("mean inlet temperature", gaps=True)
    max_hertz_pressure_gpa: Series[float] = _number(
        "by Hertz from the measured load; null where geometry or material is unknown",
        at_least=0,
        gaps=True,
    )
    film_thickness_um: Series[float] = _number(
        "calculated (Hamrock-Dowson, settings under film); null where it cannot be calculated",
        at_least=0,
        gaps=True,
    )
    lambda_ratio: Series[float] = _number(
        "film thickness over combined roughness, as configured under film", at_least=0, gaps=True
    )
    measured_film_thickness_um: Series[float] = _number(
        "measured by optical interferometry (EHD rigs only)", gaps=True
    )
    film_judgement: Series[str] = _text(
        "full film: lambda above its limit",
        one_of=("full film", "below limit", "cannot be judged"),
    )
    traction_force_n: Series[float] = _number("mean force above the zero reference", gaps=True)
    traction_coefficient: Series[float] = _number("traction force over load", gaps=True)
    traction_coefficient_se: Series[float] = _number(
        "random standard error, zero reference included, for noise whose memory is short against "
        "the plateau; null for single readings",
        at_least=0,
        gaps=True,
    )
    slip_change: Series[float] = _number("second half minus first half of the plateau", gaps=True)
    traction_change: Series[float] = _number("the same of the traction coefficient", gaps=True)
    slip_transient: Series[float] = _number("first fifth minus the rest of the plateau", gaps=True)
    traction_transient: Series[float] = _number("the same of the traction coefficient", gaps=True)
    force_asymmetry: Series[float] = _number(
        "|TF1 + TF2| / (|TF1| + |TF2|): 0 where both slip directions pull alike, 1 where one has "
        "not reversed",
        at_least=0,
        at_most=1 + 1e-9,
        gaps=True,
    )
    load_systematic_n: Series[float] = _number(
        "standard uncertainty of the load's calibration, shared by all points of the rig; null "
        "where the rig file states none",
        at_least=0,
        gaps=True,
    )
    traction_force_systematic_n: Series[float] = _number(
        "the same of the traction force", at_least=0, gaps=True
    )
    entrainment_speed_systematic_m_s: Series[float] = _number(
        "the same of the entrainment speed", at_least=0, gaps=True
    )
    inlet_temperature_systematic_c: Series[float] = _number(
        "the same of the inlet temperature", at_least=0, gaps=True
    )
    accepted: Series[bool] = _flag("true where no gate refused the point")
    reasons: Series[str] = _text("names of the gates that refused it, joined by ';'; empty if none")


class Quarantine(_Table):
    """One thing that was refused - a file, a run or a range of rows - and why."""

    campaign: Series[str] = _text("campaign")
    file: Series[str] = _text("raw log, relative to the campaign's raw folder")
    run_id: Series[str] = _text("run concerned; empty where the whole file is")
    stage: Series[str] = _text("stage that refused", one_of=("ingest", "curate"))
    rule: Series[str] = _text("name of the rule or gate")
    first_row: Series[np.int64] = _count("first data row concerned; 0 where no row is meant")
    last_row: Series[np.int64] = _count("last data row concerned")
    refused_rows: Series[np.int64] = _count("rows that are not in samples because of this")
    reason: Series[str] = _text("what was found and what was expected")
    advice: Series[str] = _text("what to do about it")


class Coverage(_Table):
    """One operating condition of one oil on one rig: what was planned, and what came of it.

    Files that cannot be read at all have no condition: they stand in `gate_counts` alone.
    """

    oil: Series[str] = _text("oil as named in config/oils")
    rig: Series[str] = _text(
        "rig; empty where the condition is missing and any of several would do"
    )
    nominal_max_hertz_pressure_gpa: Series[float] = _number(
        "set point, by Hertz where the log gives a load; null where neither gives it",
        at_least=0,
        gaps=True,
    )
    nominal_load_n: Series[float] = _number(
        "set point where no pressure can be given; else null", at_least=0, gaps=True
    )
    nominal_entrainment_speed_m_s: Series[float] = _number("set point", at_least=0, gaps=True)
    nominal_inlet_temperature_c: Series[float] = _number(
        "set point", at_least=ABSOLUTE_ZERO_C, gaps=True
    )
    runs_accepted: Series[np.int64] = _count("runs with at least one accepted point")
    runs_refused: Series[np.int64] = _count("runs with none")
    points_accepted: Series[np.int64] = _count("points that passed every gate")
    points_refused: Series[np.int64] = _count("points that did not, those of refused runs included")
    state: Series[str] = _text(
        "accepted: at least one run is; refused: none of its runs is; missing: no run at all",
        one_of=("accepted", "refused", "missing"),
    )
    planned: Series[bool] = _flag("true where the campaign's matrix has the condition")


class GateCounts(_Table):
    """One gate or rule and how much it refused. A point counts at each gate that refused it."""

    stage: Series[str] = _text("stage that refused", one_of=("ingest", "curate"))
    gate: Series[str] = _text("name of the rule or gate")
    what: Series[str] = _text(
        "what it judges: a whole file, a run, a point or rows",
        one_of=("file", "run", "point", "rows"),
    )
    files: Series[np.int64] = _count("logs concerned")
    runs: Series[np.int64] = _count("runs concerned, wholly or in part")
    runs_refused: Series[np.int64] = _count("runs refused as a whole by it")
    points: Series[np.int64] = _count("points that name it among their reasons")
    rows: Series[np.int64] = _count("rows kept out of samples because of it")
    advice: Series[str] = _text("what to do about it")


class RefusedPages(_Table):
    """One run, step or file that was refused, where its page is and which place is marked."""

    run_id: Series[str] = _text(
        "run, or step that gave none; empty where a whole file could not be read"
    )
    file: Series[str] = _text("raw log, relative to the campaign's raw folder")
    oil: Series[str] = _text("oil; empty where there is no run")
    page: Series[str] = _text(
        "picture beside this table; empty where there is no signal to show, or where the page is "
        "beyond refused_pages_max"
    )
    rule: Series[str] = _text("name of the rule or gate")
    place: Series[str] = _text(
        "what is marked: the rows that the rule names, the plateaus that fail gates of their own "
        "where it names none, else the whole run; empty where there is no page",
        one_of=("rows", "plateaus", "whole run", ""),
    )
    first_row: Series[np.int64] = _count(
        "first data row marked; 0 where it is the whole run, or where there is no page"
    )
    last_row: Series[np.int64] = _count("last data row marked")
    reason: Series[str] = _text("what was found and what was expected")
    advice: Series[str] = _text("what to do about it")


class Coefficients(_Table):
    """One constant of one traction law for one oil."""

    oil: Series[str] = _text("oil")
    law: Series[str] = _text("traction law")
    constant: Series[str] = _text("name as in the law's equation")
    value: Series[float] = _number("fitted value; null where not identifiable", gaps=True)
    standard_error: Series[float] = _number(
        "from resampling whole curves, so that errors shared by a run are in it",
        at_least=0,
        gaps=True,
    )
    lower: Series[float] = _number("2.5 % quantile of the resampled fits", gaps=True)
    upper: Series[float] = _number("97.5 % quantile", gaps=True)
    naive_standard_error: Series[float] = _number(
        "from the Jacobian, as if every point were independent: too small wherever a run has "
        "errors of its own",
        at_least=0,
        gaps=True,
    )
    systematic_standard_error: Series[float] = _number(
        "from the calibration of the rig's sensors, which no repetition lowers and which is not in "
        "standard_error; null where the rig file states none",
        at_least=0,
        gaps=True,
    )
    profile_lower: Series[float] = _number(
        "lower end of the 95 % interval by profile likelihood, which like the naive error takes "
        "every point for independent; null where the profile does not reach it",
        gaps=True,
    )
    profile_upper: Series[float] = _number("its upper end", gaps=True)
    weighted_value: Series[float] = _number(
        "fitted with points weighted by their standard errors and the excess scatter", gaps=True
    )
    robust_value: Series[float] = _number("fitted with a Cauchy loss", gaps=True)
    identifiable: Series[bool] = _flag("false where the tested conditions cannot give it")
    verdict: Series[str] = _text(
        "sign unknown: no effect at all lies within the errors, for all constants together; at a "
        "bound: of the search, past which the data would have it",
        one_of=("known", "sign unknown", "no interval", "at a bound", "not identifiable"),
    )
    printed_value: Series[float] = _number("value printed in the paper, signs restored", gaps=True)


class FitQuality(_Table):
    """How good one law's fit to one oil is, and the proof that it is the best one."""

    oil: Series[str] = _text("oil")
    law: Series[str] = _text("traction law")
    n_points: Series[np.int64] = _count("accepted points fitted")
    n_curves: Series[np.int64] = _count("runs they come from")
    sse: Series[float] = _number("sum of squared errors of mu (Eq. 10)", at_least=0, gaps=True)
    rmse: Series[float] = _number("root-mean-square error of mu", at_least=0, gaps=True)
    relative_rms: Series[float] = _number(
        "rmse over the root-mean-square of measured mu", at_least=0, gaps=True
    )
    max_error: Series[float] = _number("largest |fitted - measured| mu", at_least=0, gaps=True)
    weighted_difference: Series[float] = _number(
        "root-mean-square difference of mu between the weighted fit and this one, over the points, "
        "relative to mu; null where no point has a standard error",
        at_least=0,
        gaps=True,
    )
    robust_difference: Series[float] = _number("the same of the robust fit", at_least=0, gaps=True)
    pulling_curves: Series[str] = _text(
        "runs that the robust fit all but ignores, worst first, joined by '; '"
    )
    searches: Series[np.int64] = _count("independent global searches, each from its own seed")
    searches_agreeing: Series[np.int64] = _count("of them, those that ended at the best optimum")
    sse_spread: Series[float] = _number(
        "(largest - best) / best SSE over the searches", at_least=0, gaps=True
    )
    constant_spread: Series[float] = _number(
        "largest difference of a constant between searches, in naive standard errors",
        at_least=0,
        gaps=True,
    )
    gradient_cosine: Series[float] = _number(
        "largest |cos| between the residual and a column of the Jacobian: 0 at an optimum",
        at_least=0,
        gaps=True,
    )
    min_traction: Series[float] = _number(
        "smallest mu on a dense grid over the tested box", gaps=True
    )
    condition_number: Series[float] = _number(
        "of the Jacobian with columns of length 1: how nearly constants stand in for each other",
        at_least=1,
        gaps=True,
    )
    hessian_smallest: Series[float] = _number(
        "smallest eigenvalue of the Hessian of half the SSE by the internal constants",
        at_least=0,
        gaps=True,
    )
    hessian_largest: Series[float] = _number("its largest eigenvalue", at_least=0, gaps=True)
    active_bounds: Series[str] = _text("constants that ended at a bound of the search; else empty")
    certified: Series[bool] = _flag("true where every part of the certificate holds")
    verdict: Series[str] = _text("the certificate in a sentence")
    fixed_conditions: Series[str] = _text(
        "conditions that did not vary enough to give exponents, with their level"
    )
    tested_min_max_hertz_pressure_gpa: Series[float] = _number(
        "smallest of the accepted points; null where unknown", gaps=True
    )
    tested_max_max_hertz_pressure_gpa: Series[float] = _number("largest", gaps=True)
    tested_min_entrainment_speed_m_s: Series[float] = _number("smallest", gaps=True)
    tested_max_entrainment_speed_m_s: Series[float] = _number("largest", gaps=True)
    tested_min_inlet_temperature_c: Series[float] = _number("smallest", gaps=True)
    tested_max_inlet_temperature_c: Series[float] = _number("largest", gaps=True)
    tested_min_load_n: Series[float] = _number("smallest", gaps=True)
    tested_max_load_n: Series[float] = _number("largest", gaps=True)
    tested_min_slide_roll_ratio: Series[float] = _number("smallest size", gaps=True)
    tested_max_slide_roll_ratio: Series[float] = _number("largest size", gaps=True)


class Refits(_Table):
    """One constant of one refit; the spread of the refits says how sure the constants are."""

    oil: Series[str] = _text("oil")
    law: Series[str] = _text("traction law")
    cause: Series[str] = _text(
        "curves drawn again: to as many whole curves drawn with replacement; calibration of a "
        "sensor: that sensor off by its standard uncertainty",
    )
    refit: Series[np.int64] = _count("number of the refit, of one cause")
    constant: Series[str] = _text("name as in the table of coefficients")
    value: Series[float] = _number("refitted value")


class Correlations(_Table):
    """How two constants of a fit move together."""

    oil: Series[str] = _text("oil")
    law: Series[str] = _text("traction law")
    constant: Series[str] = _text("name as in the table of coefficients")
    other: Series[str] = _text("the other one")
    correlation: Series[float] = _number(
        "over refits to curves drawn again; by the Jacobian where there are none",
        at_least=-1 - 1e-9,
        at_most=1 + 1e-9,
        gaps=True,
    )


class Profiles(_Table):
    """One place of a profile likelihood: a constant held, all others fitted."""

    oil: Series[str] = _text("oil")
    law: Series[str] = _text("traction law")
    constant: Series[str] = _text("constant held")
    value: Series[float] = _number("at this value", gaps=True)
    signed_root: Series[float] = _number(
        "signed root of the rise of the least SSE over the residual variance: for a linear law the "
        "distance from the optimum in naive standard errors",
        gaps=True,
    )


class CurveResiduals(_Table):
    """How one run's curve lies to the fit of its oil."""

    oil: Series[str] = _text("oil")
    law: Series[str] = _text("traction law")
    run_id: Series[str] = _text("run")
    n_points: Series[np.int64] = _count("accepted points of it")
    rmse: Series[float] = _number("root-mean-square error of mu", at_least=0)
    gain: Series[float] = _number("factor by which the fit comes nearest to the curve")
    robust_weight: Series[float] = _number(
        "mean weight of its points in the robust fit, 1 for points on the fit",
        at_least=0,
        at_most=1,
    )


class Claims(_Table):
    """One claim of the paper on one basis: what would make it hold, and what was found."""

    claim: Series[str] = _text("id of the claim in data/reference/claims.yaml")
    section: Series[str] = _text("where the paper makes it")
    statement: Series[str] = _text("what the claim comes to")
    wording: Series[str] = _text("the paper's own words")
    basis: Series[str] = _text(
        "refit: the campaign's own fits and points; printed: the paper's constants, signs restored",
        one_of=("refit", "printed"),
    )
    definition: Series[str] = _text("what would make the claim hold")
    judged_on: Series[str] = _text("where the verdict was sought")
    verdict: Series[str] = _text(
        "by the share of the cases (audit.holds_share, audit.fails_share of config.yaml)",
        one_of=("holds", "holds in part", "fails", "cannot be checked"),
    )
    finding: Series[str] = _text("the figures in words, or why it cannot be checked")
    cases: Series[np.int64] = _count("places or rows where the claim was asked")
    share: Series[float] = _number(
        "of the cases in which it holds", at_least=0, at_most=1, gaps=True
    )
    share_tested_box: Series[float] = _number(
        "the same over the tested box; null where the claim has no case there",
        at_least=0,
        at_most=1,
        gaps=True,
    )
    share_extrapolated_box: Series[float] = _number(
        "the same over the box of the paper's figs 7 to 10",
        at_least=0,
        at_most=1,
        gaps=True,
    )
    worst_quantity: Series[str] = _text("what the worst value is; empty where not checked")
    worst_value: Series[float] = _number("in the case farthest from holding", gaps=True)
    worst_oil: Series[str] = _text("oil there; empty where oils are compared")
    worst_max_hertz_pressure_gpa: Series[float] = _number(
        "P there; null where the case spans all P or has none", gaps=True
    )
    worst_entrainment_speed_m_s: Series[float] = _number("U there", gaps=True)
    worst_inlet_temperature_c: Series[float] = _number("T there", gaps=True)
    worst_slide_roll_ratio: Series[float] = _number("S there", gaps=True)


class Selection(_Table):
    """One place of the operating map: the oil that the paper's rules advise, and the numbers' own.

    Lambda is that of the traction rig's contact, for oils that may be stand-ins.
    """

    basis: Series[str] = _text("as in the table of claims", one_of=("refit", "printed"))
    max_hertz_pressure_gpa: Series[float] = _number("P", at_least=0)
    entrainment_speed_m_s: Series[float] = _number("U", at_least=0)
    inlet_temperature_c: Series[float] = _number("T")
    slide_roll_ratio: Series[float] = _number("S, taken for the cage slip ratio")
    rule: Series[str] = _text("first rule of selection.rules that applies")
    aim: Series[str] = _text(
        "what it is after and the numbers are asked for", one_of=("most traction", "least heat")
    )
    advised_oil: Series[str] = _text("first oil it prefers that has enough film; empty if none has")
    contradicting_rules: Series[str] = _text(
        "later rules that apply as well and advise another oil, joined by '; '"
    )
    best_oil: Series[str] = _text("oil that meets the aim best of those with enough film")
    judgement: Series[str] = _text(
        "agree: the advised oil is best, or within selection.indifference of it; rule has none: "
        "no oil that it prefers has enough film, another has; no film: none has",
        one_of=("agree", "disagree", "rule has none", "no film"),
    )
    loss_ratio: Series[float] = _number(
        "by how much mu of the advised oil misses the aim, relative to the best one's", gaps=True
    )
    advised_lambda_ratio: Series[float] = _number("of the advised oil", at_least=0, gaps=True)
    best_lambda_ratio: Series[float] = _number("of the best one", at_least=0, gaps=True)
    advised_traction_coefficient: Series[float] = _number("mu of the advised oil", gaps=True)
    best_traction_coefficient: Series[float] = _number("mu of the best one", gaps=True)


class Truth(_Table):
    """What the rig twin planted in a simulated run. Only the twin and the tests read it."""

    run_id: Series[str] = _text("run")
    oil: Series[str] = _text("oil")
    defect: Series[str] = _text("planted defect; empty for a clean run")
    gate: Series[str] = _text("gate or rule that must catch it; empty for a clean run")
    max_hertz_pressure_gpa: Series[float] = _number("true mean pressure")
    entrainment_speed_m_s: Series[float] = _number("true mean speed")
    inlet_temperature_c: Series[float] = _number("true mean temperature")


class CoefficientTable(_Table):
    """The constants beside the printed ones, as drawn (Eqs 11-13)."""

    oil: Series[str] = _text("oil")
    constant: Series[str] = _text("constant")
    value: Series[float] = _number("fitted value", gaps=True)
    standard_error: Series[float] = _number("standard error", at_least=0, gaps=True)
    printed_value: Series[float] = _number("printed value", gaps=True)
    distance: Series[float] = _number("(fitted - printed) in standard errors", gaps=True)


class Curves(_Table):
    """Exactly what a figure of mu against slip draws."""

    panel: Series[str] = _text("panel letter")
    series: Series[str] = _text("legend entry")
    kind: Series[str] = _text("measured: points; fit: line", one_of=("measured", "fit"))
    oil: Series[str] = _text("oil")
    slide_roll_ratio: Series[float] = _number("abscissa")
    traction_coefficient: Series[float] = _number("ordinate")
    traction_coefficient_se: Series[float] = _number(
        "standard error; the bar drawn is 1.96 times as long to either side, none where null",
        gaps=True,
    )


class ClaimsPage(_Table):
    """Exactly what the page of claims draws: two lines a claim, one a basis."""

    claim: Series[str] = _text("id of the claim")
    statement: Series[str] = _text("what the claim comes to")
    basis: Series[str] = _text("first line refit, second printed", one_of=("refit", "printed"))
    verdict: Series[str] = _text("colour and symbol")
    share: Series[float] = _number("length of the bar", at_least=0, at_most=1, gaps=True)
    share_tested_box: Series[float] = _number("place of the tick", gaps=True)
    words: Series[str] = _text("to the right of the bar")


class SelectionMap(_Table):
    """Exactly what the map of oils draws: a row a cell."""

    panel: Series[str] = _text("panel letter")
    basis: Series[str] = _text("basis drawn", one_of=("refit", "printed"))
    inlet_temperature_c: Series[float] = _number("of the panel")
    slide_roll_ratio: Series[float] = _number("of the panel")
    entrainment_speed_m_s: Series[float] = _number("abscissa", at_least=0)
    max_hertz_pressure_gpa: Series[float] = _number("ordinate", at_least=0)
    advised_oil: Series[str] = _text("colour of the cell; white where empty")
    best_oil: Series[str] = _text("symbol, drawn where the judgement is not agree")
    judgement: Series[str] = _text("as in the table of selection")


class CoverageMap(_Table):
    """Exactly what the coverage map draws: a row a cell, all rigs together."""

    panel: Series[str] = _text("number of the panel, in reading order")
    oil: Series[str] = _text("oil")
    nominal_inlet_temperature_c: Series[float] = _number(
        "set point of the panel", at_least=ABSOLUTE_ZERO_C, gaps=True
    )
    nominal_entrainment_speed_m_s: Series[float] = _number("abscissa", at_least=0, gaps=True)
    nominal_max_hertz_pressure_gpa: Series[float] = _number("ordinate", at_least=0, gaps=True)
    nominal_load_n: Series[float] = _number("ordinate without pressure", at_least=0, gaps=True)
    runs_accepted: Series[np.int64] = _count("first number of the cell")
    runs: Series[np.int64] = _count("second number of the cell: all runs")
    state: Series[str] = _text(
        "symbol and colour of the cell", one_of=("accepted", "refused", "missing")
    )
    planned: Series[bool] = _flag("false: drawn with a broken edge, if there is a matrix")


class TorqueRuns(_Table):
    """One steady plateau of a torque log: one speed of a bearing under one axial load."""

    run_id: Series[str] = _text("the log, relative to the folder of torque logs")
    oil: Series[str] = _text("oil as named in config/oils")
    bearing: Series[str] = _text("bearing as named in config/bearings")
    sha256: Series[str] = _text("of the raw log's bytes")
    first_row: Series[np.int64] = _count("first row of the settled part, in the raw log")
    last_row: Series[np.int64] = _count("last row of the settled part")
    n_samples: Series[np.int64] = _count("rows averaged; flagged spikes are not among them")
    n_spikes: Series[np.int64] = _count("rows left out of the mean as spikes of the torque")
    time_s: Series[float] = _number("middle of the settled part")
    duration_s: Series[float] = _number("length of the settled part", at_least=0)
    inner_speed_rpm: Series[float] = _number("mean speed of the inner ring; the outer one rests")
    axial_load_n: Series[float] = _number("mean axial load")
    oil_temperature_c: Series[float] = _number("mean oil temperature at the bearing's inlet")
    outer_ring_temperature_c: Series[float] = _number("mean outer ring temperature")
    tare_n_m: Series[float] = _number("output at rest at that time, removed from the torque")
    torque_n_m: Series[float] = _number("mean friction torque, tare removed")
    torque_n_m_se: Series[float] = _number(
        "random standard error, the tare's included; calibration is not in it", at_least=0
    )
    torque_change_n_m: Series[float] = _number("second half minus first half of the plateau")
    oil_temperature_change_c: Series[float] = _number("the same of the oil temperature")
    accepted: Series[bool] = _flag("true where no gate refused the plateau")
    reasons: Series[str] = _text("names of the gates that refused it, joined by ';'; empty if none")


class _BearingFriction(_Table):
    """Friction of a bearing at one operating point, term by term."""

    converged: Series[bool] = _flag("false: no equilibrium was found, and all results are null")
    why: Series[str] = _text("why no equilibrium was found; empty where one was")
    residual: Series[float] = _number(
        "largest force or moment out of balance, over the load of a ball", gaps=True
    )
    energy_error: Series[float] = _number(
        "power put in at the rings less all heat, over that power", gaps=True
    )
    quadrature_error: Series[float] = _number(
        "traction heat by twice as many places in either direction, relative difference", gaps=True
    )
    torque_n_m: Series[float] = _number("moment that turns the inner ring: six terms", gaps=True)
    traction_torque_n_m: Series[float] = _number("term: sliding in the contacts", gaps=True)
    rolling_torque_n_m: Series[float] = _number("term: oil drawn into the contacts", gaps=True)
    hysteresis_torque_n_m: Series[float] = _number("term: hysteresis of the steel", gaps=True)
    drag_torque_n_m: Series[float] = _number("term: balls through oil and air", gaps=True)
    pocket_torque_n_m: Series[float] = _number("term: balls in the cage's pockets", gaps=True)
    land_torque_n_m: Series[float] = _number("term: cage on its guiding land", gaps=True)
    gross_torque_n_m: Series[float] = _number(
        "part of traction: slip of the whole contact", gaps=True
    )
    spin_torque_n_m: Series[float] = _number("part of traction: spin about the normal", gaps=True)
    differential_torque_n_m: Series[float] = _number(
        "part of traction: slip across a curved contact", gaps=True
    )
    gyroscopic_torque_n_m: Series[float] = _number(
        "part of traction: slip across the rolling direction", gaps=True
    )
    cage_slip: Series[float] = _number(
        "by how much the cage lags behind balls that roll on both races, relative", gaps=True
    )
    inner_contact_angle_deg: Series[float] = _number("inner race", gaps=True)
    outer_contact_angle_deg: Series[float] = _number("outer race", gaps=True)
    inner_max_hertz_pressure_gpa: Series[float] = _number("inner race", gaps=True)
    outer_max_hertz_pressure_gpa: Series[float] = _number("outer race", gaps=True)
    entrainment_speed_m_s: Series[float] = _number("mean of both contacts", gaps=True)
    lambda_ratio: Series[float] = _number(
        "minimum film, thermally reduced, over combined Rq; the worse contact", gaps=True
    )
    largest_slide_roll_ratio: Series[float] = _number("anywhere in the ellipses", gaps=True)
    mean_traction_coefficient: Series[float] = _number("mean over the ellipses by load", gaps=True)
    share_beyond_slip: Series[float] = _share(
        "of the traction heat, at slide-roll ratios above any tested", gaps=True
    )
    share_beyond_pressure: Series[float] = _share(
        "of the traction heat, in contacts of untested pressure", gaps=True
    )
    share_beyond_speed: Series[float] = _share(
        "of the traction heat, in contacts of untested entrainment speed", gaps=True
    )


class Torque(_BearingFriction):
    """One plateau of a torque log and what one basis of the traction law makes of it."""

    run_id: Series[str] = _text("torque log")
    first_row: Series[np.int64] = _count("first row of its plateau")
    oil: Series[str] = _text("oil")
    bearing: Series[str] = _text("bearing")
    basis: Series[str] = _text(
        "what the law takes for the load: maximum Hertz stress, load in N, or W/(E' Rx^2)",
        one_of=("stress", "load", "dimensionless_load"),
    )
    inner_speed_rpm: Series[float] = _number("speed of the inner ring")
    axial_load_n: Series[float] = _number("axial load")
    inlet_temperature_c: Series[float] = _number("oil temperature at the inlet")
    measured_torque_n_m: Series[float] = _number("as in torque_runs", gaps=True)
    measured_torque_n_m_se: Series[float] = _number("as in torque_runs", at_least=0, gaps=True)
    relative_error: Series[float] = _number("calculated over measured torque, less 1", gaps=True)
    palmgren_torque_n_m: Series[float] = _number("from memory, outside: Palmgren", gaps=True)
    skf_torque_n_m: Series[float] = _number("from memory, outside: SKF", gaps=True)


class TorqueInversion(_Table):
    """Traction at the raceways by the measured torque, the other terms being as calculated."""

    run_id: Series[str] = _text("torque log")
    first_row: Series[np.int64] = _count("first row of its plateau")
    oil: Series[str] = _text("oil")
    inner_speed_rpm: Series[float] = _number("speed of the inner ring")
    axial_load_n: Series[float] = _number("axial load")
    inlet_temperature_c: Series[float] = _number("oil temperature at the inlet")
    traction_share: Series[float] = _number(
        "of the calculated torque: what the traction law decides", gaps=True
    )
    law_traction_coefficient: Series[float] = _number("mean in the ellipses by the law", gaps=True)
    traction_coefficient: Series[float] = _number(
        "mean in the ellipses that gives the measured torque; null where none does", gaps=True
    )
    traction_coefficient_se: Series[float] = _number(
        "its standard error from the torque's random one", at_least=0, gaps=True
    )
    traction_coefficient_systematic: Series[float] = _number(
        "standard uncertainty from calibration and from the other terms' assumed uncertainty",
        at_least=0,
        gaps=True,
    )
    verdict: Series[str] = _text(
        "undetermined: the uncertainty is as large as the value",
        one_of=("determined", "undetermined", "no solution"),
    )


class CageSlip(_BearingFriction):
    """Cage slip of one oil at one speed and axial load, from the friction equilibrium."""

    oil: Series[str] = _text("oil")
    bearing: Series[str] = _text("bearing")
    pitch_speed_mm_rpm: Series[float] = _number("pitch diameter times speed, d_m n")
    inner_speed_rpm: Series[float] = _number("speed of the inner ring")
    axial_load_n: Series[float] = _number("axial load")
    inlet_temperature_c: Series[float] = _number("oil temperature at the inlet")


class SizeEffect(_BearingFriction):
    """What a basis of the traction law makes of balls of another size or closer grooves."""

    oil: Series[str] = _text("oil")
    bearing: Series[str] = _text("bearing that is varied")
    varied: Series[str] = _text(
        "ball size: all lengths in proportion, the same pressure and surface speed; conformity: "
        "both grooves, the same load and speed",
        one_of=("ball size", "conformity"),
    )
    ball_diameter_mm: Series[float] = _number("diameter of the balls")
    groove_curvature: Series[float] = _number("groove radius over ball diameter")
    basis: Series[str] = _text("as in torque", one_of=("stress", "load", "dimensionless_load"))
    axial_load_n: Series[float] = _number("axial load")
    inner_speed_rpm: Series[float] = _number("speed of the inner ring")
    inlet_temperature_c: Series[float] = _number("oil temperature at the inlet")
    relative_to_stress: Series[float] = _number(
        "traction torque over that of the stress basis, less 1", gaps=True
    )


class PowerLoss(_BearingFriction):
    """Published power loss of a bearing beside the calculated one: plausibility, never a gate."""

    bearing: Series[str] = _text("bearing")
    oil: Series[str] = _text("oil whose traction was taken")
    inner_speed_rpm: Series[float] = _number("speed of the inner ring")
    axial_load_n: Series[float] = _number("axial load")
    inlet_temperature_c: Series[float] = _number("oil temperature at the inlet")
    published_power_w: Series[float] = _number("second-hand figure")
    power_w: Series[float] = _number("calculated torque times speed", gaps=True)


class TorqueTruth(_Table):
    """What the twin planted in a simulated torque log. Only the twin and the tests read it."""

    run_id: Series[str] = _text("torque log")
    oil: Series[str] = _text("oil")
    defect: Series[str] = _text("planted defect; empty for a clean log")
    inner_speed_rpm: Series[float] = _number("speed of the inner ring")
    axial_load_n: Series[float] = _number("axial load")
    oil_temperature_c: Series[float] = _number("oil temperature")
    torque_n_m: Series[float] = _number("true friction torque")
    traction_torque_n_m: Series[float] = _number("its term of traction")
    law_misfit: Series[float] = _number(
        "root-mean-square difference of the twin's local traction from the law behind the traction "
        "rig's logs, averaged over the rig's contact, relative to the law's root-mean-square"
    )


class TorqueDrawn(_Table):
    """Exactly what a figure of torque against speed draws."""

    panel: Series[str] = _text("panel letter")
    series: Series[str] = _text("measured, or the basis of the law")
    oil: Series[str] = _text("oil")
    axial_load_n: Series[float] = _number("set of points: mean axial load")
    inner_speed_rpm: Series[float] = _number("abscissa")
    torque_n_m: Series[float] = _number("ordinate of the panels of torque", gaps=True)
    torque_n_m_se: Series[float] = _number(
        "standard error; the bar drawn is 1.96 times as long to either side", gaps=True
    )
    relative_error: Series[float] = _number("ordinate of the panels of error", gaps=True)


class TruthGrid(_Table):
    """The traction that is true in a simulated campaign, free of noise, beyond what was tested.

    Only what holds fits against it reads it: no fit, gate or law does.
    """

    oil: Series[str] = _text("oil")
    figure: Series[str] = _text("figure of the paper that has the condition")
    max_hertz_pressure_gpa: Series[float] = _number("maximum Hertz pressure", at_least=0)
    entrainment_speed_m_s: Series[float] = _number("entrainment speed", at_least=0)
    inlet_temperature_c: Series[float] = _number("inlet temperature", at_least=ABSOLUTE_ZERO_C)
    load_n: Series[float] = _number("normal load that gives the pressure on the rig", at_least=0)
    slide_roll_ratio: Series[float] = _number("slide-roll ratio", at_least=0)
    traction_coefficient: Series[float] = _number("true mu", at_least=0)


class Extrapolation(_Table):
    """One condition of a simulated campaign: what a fitted law says, and what is true.

    It shows what laws do in a world like the simulated one and decides nothing about real oils.
    """

    oil: Series[str] = _text("oil")
    law: Series[str] = _text("traction law")
    figure: Series[str] = _text("figure of the paper that has the condition")
    max_hertz_pressure_gpa: Series[float] = _number("maximum Hertz pressure", at_least=0)
    entrainment_speed_m_s: Series[float] = _number("entrainment speed", at_least=0)
    inlet_temperature_c: Series[float] = _number("inlet temperature", at_least=ABSOLUTE_ZERO_C)
    load_n: Series[float] = _number("normal load that gives the pressure on the rig", at_least=0)
    slide_roll_ratio: Series[float] = _number("slide-roll ratio", at_least=0)
    beyond: Series[str] = _text(
        "conditions that lie outside the levels at which the oil was tested, joined by ', '; "
        "empty inside"
    )
    true_traction_coefficient: Series[float] = _number("mu of the truth", at_least=0)
    traction_coefficient: Series[float] = _number(
        "mu of the fitted law, cut off at 1e6; null where nothing was fitted", gaps=True
    )
    lower: Series[float] = _number(
        "lower end of the fit's own 95 % interval; null where it has none", gaps=True
    )
    upper: Series[float] = _number("its upper end", gaps=True)


class ExtrapolationErrors(_Table):
    """Errors of one fitted law for one oil against the truth, of one figure and one region.

    It shows what laws do in a world like the simulated one and decides nothing about real oils.
    """

    law: Series[str] = _text("traction law")
    oil: Series[str] = _text("oil")
    figure: Series[str] = _text("figure of the paper")
    beyond: Series[str] = _text("as in the table extrapolation")
    n_points: Series[np.int64] = _count("conditions compared")
    rmse: Series[float] = _number("root-mean-square error of mu", at_least=0, gaps=True)
    relative_rms: Series[float] = _number(
        "rmse over the root-mean-square of true mu", at_least=0, gaps=True
    )
    mean_error: Series[float] = _number("mean of fitted minus true mu", gaps=True)
    max_error: Series[float] = _number("largest |fitted - true| mu", at_least=0, gaps=True)
    interval_ratio: Series[float] = _number(
        "share of the conditions at which the fit's own 95 % interval holds the truth; null where "
        "the fit has none",
        at_least=0,
        at_most=1,
        gaps=True,
    )
    worst_max_hertz_pressure_gpa: Series[float] = _number("where that is", gaps=True)
    worst_entrainment_speed_m_s: Series[float] = _number("where that is", gaps=True)
    worst_inlet_temperature_c: Series[float] = _number("where that is", gaps=True)
    worst_slide_roll_ratio: Series[float] = _number("where that is", gaps=True)
    worst_true_traction_coefficient: Series[float] = _number("mu of the truth there", gaps=True)
    worst_traction_coefficient: Series[float] = _number("mu of the fitted law there", gaps=True)


class ExtrapolationPanels(_Table):
    """Exactly what the figure of the extrapolation draws."""

    panel: Series[str] = _text("panel letter")
    kind: Series[str] = _text(
        "what the ordinate is: true mu, fitted mu, or a law's relative rms error",
        one_of=("true", "fit", "error"),
    )
    law: Series[str] = _text("traction law; empty for the truth")
    oil: Series[str] = _text("oil")
    x: Series[float] = _number(
        "abscissa, in the unit of its panel: S; U in m/s; P in GPa; T in degC; relative rms error "
        "in the tested box",
        gaps=True,
    )
    y: Series[float] = _number("ordinate: mu, or relative rms error beyond the box", gaps=True)


class PrintedJudged(_Table):
    """The printed constants of one oil, beside the campaign's own fit.

    Nulls where the conditions cannot give all twelve constants, or their errors.
    """

    oil: Series[str] = _text("oil")
    n_points: Series[np.int64] = _count("accepted points, those of the fit")
    printed_sse: Series[float] = _number(
        "sum of squared errors of mu (Eq. 10) of the printed constants", at_least=0, gaps=True
    )
    fitted_sse: Series[float] = _number("the same of the fit", at_least=0, gaps=True)
    a0_distance: Series[float] = _number(
        "(fitted - printed) A0 over its standard error, systematic part included", gaps=True
    )
    a1_distance: Series[float] = _number("the same of A1", gaps=True)
    a2_distance: Series[float] = _number("the same of A2", gaps=True)
    a3_distance: Series[float] = _number("the same of A3", gaps=True)
    b0_distance: Series[float] = _number("the same of B0", gaps=True)
    b1_distance: Series[float] = _number("the same of B1", gaps=True)
    b2_distance: Series[float] = _number("the same of B2", gaps=True)
    b3_distance: Series[float] = _number("the same of B3", gaps=True)
    c0_distance: Series[float] = _number("the same of C0", gaps=True)
    c1_distance: Series[float] = _number("the same of C1", gaps=True)
    c2_distance: Series[float] = _number("the same of C2", gaps=True)
    c3_distance: Series[float] = _number("the same of C3", gaps=True)
    joint_distance: Series[float] = _number(
        "Mahalanobis distance of all twelve by the fit's covariance (refits), about 3.5 by chance "
        "alone; null without one",
        at_least=0,
        gaps=True,
    )
    tested_difference: Series[float] = _number(
        "printed - fitted mu where they differ most in the tested box", gaps=True
    )
    tested_traction_coefficient: Series[float] = _number("fitted mu there", gaps=True)
    tested_max_hertz_pressure_gpa: Series[float] = _number("P there", gaps=True)
    tested_entrainment_speed_m_s: Series[float] = _number("U there", gaps=True)
    tested_inlet_temperature_c: Series[float] = _number("T there", gaps=True)
    tested_slide_roll_ratio: Series[float] = _number("S there", gaps=True)
    extrapolated_difference: Series[float] = _number(
        "printed - fitted mu where they differ most in the extrapolated box", gaps=True
    )
    extrapolated_traction_coefficient: Series[float] = _number("fitted mu there", gaps=True)
    extrapolated_max_hertz_pressure_gpa: Series[float] = _number("P there", gaps=True)
    extrapolated_entrainment_speed_m_s: Series[float] = _number("U there", gaps=True)
    extrapolated_inlet_temperature_c: Series[float] = _number("T there", gaps=True)
    extrapolated_slide_roll_ratio: Series[float] = _number("S there", gaps=True)


class Signs(_Table):
    """One of the 512 sign sets of an oil's nine printed exponents, held against the paper's text.

    `printed.signs` of the configuration has the thresholds. Not judged here: claims that A0 < 0,
    B0 > 0 and C0 > 0 make true for every set (mu = 0 at S = 0, one peak, a linear start).
    """

    oil: Series[str] = _text("oil")
    signs: Series[str] = _text("of A1 A2 A3 B1 B2 B3 C1 C2 C3: exponents of P, U, T")
    in_use: Series[bool] = _flag("true for the set in data/reference/printed_coefficients.yaml")
    rank: Series[np.int64] = _count("by total, 1 the best; equals share a rank")
    rank_at_figures: Series[np.int64] = _count(
        "the same where only the slips of the paper's figs 8 and 9 are asked: how much it depends "
        "on that choice"
    )
    total: Series[float] = _number("weighted sum of the statements' shares: how many hold")
    near_best: Series[bool] = _flag("true where total is less than near_best below the best")
    physical: Series[float] = _share(
        "share of the extrapolated box where mu >= 0 (by the signs of A0, B0, C0) and no "
        "peak above gates.traction_max; section 3: 'remains non-negative under all "
        "operating conditions'"
    )
    rises_with_stress: Series[float] = _share(
        "share of the extrapolated box where mu rises from each level of P to the next; "
        "section 4.3.3: 'increase with the maximum contact stress'"
    )
    linear_in_stress: Series[float] = _share(
        "share of the extrapolated box where mu(P) rises along a straight line "
        "(linear_r2_min); section 4.3.3: 'an approximately linear increase'"
    )
    falls_with_speed: Series[float] = _share(
        "share of the extrapolated box where mu falls from each level of U to the next; "
        "section 4.3.2: 'continues to decline as the entrainment speed increases from 20 "
        "m/s to 200 m/s'"
    )
    levels_off_with_speed: Series[float] = _share(
        "share of the extrapolated box where mu falls by more over the first third of the "
        "speeds than it changes over the last; section 4.3.2: 'a clear plateau at high "
        "entrainment speeds'"
    )
    falls_with_temperature: Series[float] = _share(
        "share of the extrapolated box where mu falls from each level of T to the next; "
        "section 4.3.4: 'decrease markedly in a nonlinear manner with increasing "
        "temperature'"
    )
    levels_off_with_temperature: Series[float] = _share(
        "share of the extrapolated box where mu falls by more over 20-60 degC than it "
        "changes over 100-140; section 4.3.4: 'approximately 20-60 degC, the decrease is "
        "more pronounced, whereas in the high-temperature range (>100 degC), the curves "
        "flatten'"
    )
    start_falls_with_temperature: Series[float] = _share(
        "share of the tested box where the slope at zero slip falls from each level of T "
        "to the next; half weight, it follows by the physics named; section 2.4: 'typical "
        "Newtonian behavior', 'temperature-induced reduction in the lubricant's base "
        "viscosity'"
    )
    rises_with_slip: Series[float] = _share(
        "share of the extrapolated box where mu at the highest of slide_roll_ratio.figures is "
        "above that at the lowest; section 4.3.2: 'gradually increases as the SRR rises from 0.05 "
        "to 0.20'"
    )
    declines_slightly: Series[float] = _share(
        "share of the tested box where mu peaks within the slips and loses decline_max of "
        "the peak at most; section 2.4: 'reaches a maximum value ... a slight decline'"
    )
    earlier_plateau_with_stress: Series[float] = _share(
        "share of the extrapolated box where the linear range ends at smaller slip from "
        "each level of P to the next; section 4.3.1: 'the onset of nonlinearity occurs at "
        "a smaller SRR', 'reach the plateau region at relatively low SRR'"
    )
    earlier_plateau_with_speed: Series[float] = _share(
        "the same from each level of U to the next, in the tested box; half weight, "
        "one reading; section "
        "2.4: 'At high entrainment speeds ... enters the saturation regime at lower SRR "
        "values'"
    )
    earlier_plateau_with_temperature: Series[float] = _share(
        "the same from each level of T to the next, in the tested box; half weight, "
        "the other reading; "
        "section 2.4: 'decreasing trend with increasing oil supply temperature ... enters "
        "the saturation regime at lower SRR values'"
    )
    slip_raises_stress_effect: Series[float] = _share(
        "share of the extrapolated box where over the range of P mu gains more at the highest of "
        "slide_roll_ratio.figures than it changes at the lowest; section 4.3.3: 'the increase is "
        "more pronounced at a high SRR of 0.20'"
    )
    speed_mutes_stress_effect: Series[float] = _share(
        "share of the extrapolated box where over the range of P mu gains more at the lowest speed "
        "than it changes at the highest; section 4.3.3: 'at low speeds ... greater load "
        "sensitivity'"
    )
    speed_mutes_temperature_effect: Series[float] = _share(
        "share of the extrapolated box where over the range of T mu loses more at the lowest speed "
        "than it changes at the highest; section 4.3.4: 'high-speed cases ... reduced sensitivity "
        "to temperature'"
    )
    viscosity_order: Series[float] = _share(
        "share of the extrapolated box where mu is below that of the next more viscous "
        "oil and above that of the next less viscous one, the mean of both, these with "
        "the set that their own statements like best; section 4.3.1: 'the traction level "
        "of lubricant 4102 is the highest, followed by 4050, while 4010 exhibits the "
        "lowest'",
        gaps=True,
    )
    hot_convergence: Series[float] = _share(
        "share of it where mu is nearer to that of each other oil at the highest "
        "temperature than at the lowest; section 4.3.4: 'in the high-temperature region, "
        "the three curves gradually converge'",
        gaps=True,
    )
    sse: Series[float] = _number(
        "sum of squared errors of mu on the campaign's accepted points. CIRCULAR where they are "
        "simulated from the printed constants; simulated from anything else it says nothing of "
        "the real oils",
        at_least=0,
        gaps=True,
    )


class SignVerdicts(_Table):
    """How sure the sign in use of one printed exponent is."""

    oil: Series[str] = _text("oil")
    constant: Series[str] = _text("exponent")
    sign: Series[str] = _text("in use", one_of=("+", "-"))
    margin: Series[float] = _number(
        "best total of the sets with this sign less that of the sets with the other, in statements"
    )
    weakest_margin: Series[float] = _number(
        "smallest margin with any one statement left out, at the slips of the whole curve or of "
        "the paper's figures alone"
    )
    weakest_without: Series[str] = _text("the statement left out there")
    weakest_slips: Series[str] = _text(
        "the slips there (printed.signs.slide_roll_ratio)", one_of=("curve", "figures")
    )
    near_best_share: Series[float] = _share("share of the near-best sets that have this sign")
    effect: Series[float] = _number(
        "largest change of mu over the tested box if this sign alone is turned, over the largest "
        "mu there",
        at_least=0,
    )
    least_sse: Series[float] = _number(
        "least SSE of the sets with this sign; the same caution as for the column sse of signs",
        at_least=0,
        gaps=True,
    )
    least_sse_turned: Series[float] = _number(
        "the same of the sets with the other sign", at_least=0, gaps=True
    )
    verdict: Series[str] = _text(
        "settled: every near-best set has this sign, whichever statement is left out and at either "
        "slips; probable: with every statement, at the slips of the whole curve; against: every "
        "one has the other sign; open: some have either; without effect: it moves mu by "
        "no_effect_max at most",
        one_of=("settled", "probable", "open", "against", "without effect"),
    )


class SignStudy(_Table):
    """Exactly what the figure of the sign study draws."""

    panel: Series[str] = _text("panel letter")
    oil: Series[str] = _text("oil")
    series: Series[str] = _text("all sets, set in use, best set, or margin and its verdict")
    label: Series[str] = _text("signs, statement or exponent with its sign")
    rank: Series[float] = _number("abscissa of the totals", gaps=True)
    value: Series[float] = _number("total, share or margin")
    weakest_margin: Series[float] = _number("tick on the bar of a margin", gaps=True)


class Comparison(_Table):
    """One law's fit to one oil, judged on what it was fitted to and on what it has not seen."""

    oil: Series[str] = _text("oil")
    law: Series[str] = _text("traction law")
    n_points: Series[np.int64] = _count("accepted points fitted")
    n_curves: Series[np.int64] = _count("runs they come from")
    n_constants: Series[np.int64] = _count("constants fitted, those that ended at a bound included")
    sse: Series[float] = _number("sum of squared errors of mu (Eq. 10)", at_least=0, gaps=True)
    rmse: Series[float] = _number("root-mean-square error of mu", at_least=0, gaps=True)
    relative_rms: Series[float] = _number(
        "rmse over the root-mean-square of measured mu", at_least=0, gaps=True
    )
    max_error: Series[float] = _number("largest |fitted - measured| mu", at_least=0, gaps=True)
    aic: Series[float] = _number(
        "Akaike's information criterion; takes every point for independent, so that differences "
        "look surer than they are",
        gaps=True,
    )
    bic: Series[float] = _number("Bayesian information criterion; the same holds", gaps=True)
    left_out_rmse: Series[float] = _number(
        "root-mean-square error of mu at curves that were left out of the fit one at a time; null "
        "where the others do not give every constant",
        at_least=0,
        gaps=True,
    )
    pressure_end_out_relative_rms: Series[float] = _number(
        "root-mean-square error at the lowest and at the highest level of pressure, each left out "
        "as a whole and extrapolated to, over the root-mean-square of mu there; null where the "
        "other levels do not give every constant",
        at_least=0,
        gaps=True,
    )
    speed_end_out_relative_rms: Series[float] = _number(
        "the same of entrainment speed", at_least=0, gaps=True
    )
    temperature_end_out_relative_rms: Series[float] = _number(
        "the same of inlet temperature", at_least=0, gaps=True
    )
    zero_slip_traction: Series[float] = _number(
        "mu at no slip, where its size is largest over the tested conditions; should be 0",
        gaps=True,
    )
    negative_share: Series[float] = _number(
        "share of the tested box where mu is below zero", at_least=0, at_most=1, gaps=True
    )
    second_rise_share: Series[float] = _number(
        "share of the tested conditions at which mu rises again after its peak",
        at_least=0,
        at_most=1,
        gaps=True,
    )
    condition_number: Series[float] = _number(
        "of the Jacobian with columns of length 1: how nearly constants stand in for each other",
        at_least=1,
        gaps=True,
    )
    certified: Series[bool] = _flag("true where every part of the certificate holds")
    verdict: Series[str] = _text("the certificate in a sentence")


class LawPanels(_Table):
    """Exactly what the figure of the laws' weaknesses draws (Fig. 4)."""

    panel: Series[str] = _text("panel letter")
    law: Series[str] = _text("traction law")
    oil: Series[str] = _text("oil")
    kind: Series[str] = _text(
        "zero slip: mu at no slip at a tested condition; the others: error of a law over mu",
        one_of=("zero slip", "fitted curves", "curve left out", "end level left out"),
    )
    x: Series[float] = _number("abscissa", gaps=True)
    y: Series[float] = _number("ordinate; of errors the place of the row")


TABLES: dict[str, type[_Table]] = {
    "samples": Samples,
    "runs": Runs,
    "points": Points,
    "quarantine": Quarantine,
    "coverage": Coverage,
    "gate_counts": GateCounts,
    "refused_pages": RefusedPages,
    "coefficients": Coefficients,
    "fit_quality": FitQuality,
    "refits": Refits,
    "correlations": Correlations,
    "profiles": Profiles,
    "curve_residuals": CurveResiduals,
    "claims": Claims,
    "selection": Selection,
    "truth": Truth,
    "coefficient_table": CoefficientTable,
    "curves": Curves,
    "coverage_map": CoverageMap,
    "torque_runs": TorqueRuns,
    "torque": Torque,
    "torque_inversion": TorqueInversion,
    "cage_slip": CageSlip,
    "size_effect": SizeEffect,
    "power_loss": PowerLoss,
    "torque_truth": TorqueTruth,
    "torque_drawn": TorqueDrawn,
    "truth_grid": TruthGrid,
    "extrapolation": Extrapolation,
    "extrapolation_errors": ExtrapolationErrors,
    "extrapolation_panels": ExtrapolationPanels,
    "printed_judged": PrintedJudged,
    "signs": Signs,
    "sign_verdicts": SignVerdicts,
    "sign_study": SignStudy,
    "claims_page": ClaimsPage,
    "selection_map": SelectionMap,
    "comparison": Comparison,
    "law_coefficients": Coefficients,
    "law_fit_quality": FitQuality,
    "law_refits": Refits,
    "law_panels": LawPanels,
}


def _curve_rows_are_unique(frame: pd.DataFrame) -> str:
    return _repeated(frame, ["run_id", "first_row"])


def _verdict_agrees_with_reasons(frame: pd.DataFrame) -> str:
    wrong = frame["accepted"] != (frame["reasons"] == "")
    return f"{wrong.sum()} points are accepted with a reason or refused without" * bool(wrong.any())


def _pages_are_unique(frame: pd.DataFrame) -> str:
    return _repeated(frame[frame["page"] != ""], ["page"])


def _repeated(frame: pd.DataFrame, key: list[str]) -> str:
    repeated = frame[frame.duplicated(key)]
    if repeated.empty:
        return ""
    first = ", ".join(f"{name} {repeated.iloc[0][name]}" for name in key)
    return f"{len(repeated)} rows repeat {' + '.join(key)}, the first at {first}"


_SET_POINTS = tuple(name for name in Coverage.to_schema().columns if name.startswith("nominal_"))

_OPERATING_POINT = (
    "max_hertz_pressure_gpa",
    "entrainment_speed_m_s",
    "inlet_temperature_c",
    "slide_roll_ratio",
)

# Checks over several columns; each returns a complaint or an empty text.
_CHECKS: dict[str, tuple[Callable[[pd.DataFrame], str], ...]] = {
    "runs": (lambda frame: _repeated(frame, ["run_id"]),),
    "points": (_curve_rows_are_unique, _verdict_agrees_with_reasons),
    "coverage": (lambda frame: _repeated(frame, ["oil", "rig", *_SET_POINTS]),),
    "gate_counts": (lambda frame: _repeated(frame, ["stage", "gate", "what"]),),
    "refused_pages": (_pages_are_unique,),
    "coefficients": (lambda frame: _repeated(frame, ["oil", "law", "constant"]),),
    "fit_quality": (lambda frame: _repeated(frame, ["oil", "law"]),),
    "refits": (lambda frame: _repeated(frame, ["oil", "law", "cause", "refit", "constant"]),),
    "correlations": (lambda frame: _repeated(frame, ["oil", "law", "constant", "other"]),),
    "selection": (lambda frame: _repeated(frame, ["basis", *_OPERATING_POINT]),),
    "claims": (lambda frame: _repeated(frame, ["claim", "basis"]),),
    "curve_residuals": (lambda frame: _repeated(frame, ["oil", "law", "run_id"]),),
    "extrapolation_errors": (lambda frame: _repeated(frame, ["law", "oil", "figure", "beyond"]),),
    "printed_judged": (lambda frame: _repeated(frame, ["oil"]),),
    "signs": (lambda frame: _repeated(frame, ["oil", "signs"]),),
    "sign_verdicts": (lambda frame: _repeated(frame, ["oil", "constant"]),),
    "comparison": (lambda frame: _repeated(frame, ["oil", "law"]),),
    "law_coefficients": (lambda frame: _repeated(frame, ["oil", "law", "constant"]),),
    "law_fit_quality": (lambda frame: _repeated(frame, ["oil", "law"]),),
    "law_refits": (lambda frame: _repeated(frame, ["oil", "law", "cause", "refit", "constant"]),),
}


def unit_of(column: str) -> str:
    """The unit that a column's name ends in; empty for columns without one."""
    name = column.removesuffix("_se")
    endings = [ending for ending in _UNITS if name.endswith(ending)]
    return _UNITS[max(endings, key=len)] if endings else ""


def columns(table: str) -> list[str]:
    """Names of a table's columns, in order."""
    return list(TABLES[table].to_schema().columns)


def empty(table: str) -> pd.DataFrame:
    """The table with no rows and every column of its type."""
    return _empty(table).copy()


@cache
def _empty(table: str) -> pd.DataFrame:
    return conform(pd.DataFrame({name: [] for name in columns(table)}), table, "an empty table")


def from_rows(rows: list[dict[str, Any]], table: str) -> pd.DataFrame:
    """A table from one mapping a row; no rows give the empty table."""
    return conform(pd.DataFrame(rows), table, "new rows") if rows else empty(table)


def rows(frame: pd.DataFrame) -> list[dict[str, Any]]:
    """The rows of a table, a dictionary each."""
    return [{str(name): value for name, value in row.items()} for row in frame.to_dict("records")]


def conform(frame: pd.DataFrame, table: str, where: str) -> pd.DataFrame:
    """The frame with the table's columns in order and its types, every check passed.

    Columns are checked one at a time: a whole frame of samples at once takes three times the
    memory. Pandera is asked only about columns that do not plainly obey their model, because it
    takes a millisecond a column and several passes over a long one.

    Raises:
        OilfilmError: A column is missing, unknown, or holds what the contract forbids.
    """
    schema = TABLES[table].to_schema()
    missing = [name for name in schema.columns if name not in frame.columns]
    unknown = [name for name in frame.columns if name not in schema.columns]
    if missing or unknown:
        raise OilfilmError(
            f"{where}: table {table!r} lacks {missing or 'no column'} and has the unknown "
            f"{unknown or 'none'}. It was made by another version: rebuild it."
        )
    frame = frame.reset_index(drop=True)
    checked = {}
    for name, column in schema.columns.items():
        checked[name] = frame[name]
        if _plainly_obeys(checked[name], column):
            continue
        try:
            checked[name] = column.validate(frame[[name]], lazy=True)[name]
        except (pa.errors.SchemaErrors, pa.errors.SchemaError) as error:
            case = error.failure_cases.iloc[0]
            expected = case.get("check", column.dtype)
            raise OilfilmError(
                f"{where}: table {table!r}, column {name!r} ({column.description}): found "
                f"{case['failure_case']!r} at row {case['index']}, expected {expected}."
            ) from error
    # one block of all columns would be one more copy of a large table
    conformed = pd.DataFrame(checked, columns=list(schema.columns), copy=False)
    for check in _CHECKS.get(table, ()):
        complaint = check(conformed)
        if complaint:
            raise OilfilmError(f"{where}: table {table!r}: {complaint}.")
    return conformed


# pandera's name of a check -> whether all values of a column, nulls aside, pass it
_PLAIN_CHECKS: dict[str, Callable[..., bool]] = {
    "greater_than_or_equal_to": lambda values, min_value: (
        not np.fmin.reduce(values.to_numpy()) < min_value
    ),
    "less_than_or_equal_to": lambda values, max_value: (
        not np.fmax.reduce(values.to_numpy()) > max_value
    ),
    "isin": lambda values, allowed_values: values.dropna().isin(allowed_values).all(),
}


def _plainly_obeys(values: pd.Series, column: pa.Column) -> bool:
    """True where a column has its model's type and keeps its bounds; in any doubt false."""
    if values.dtype.name != column.dtype.type.name or column.unique:
        return False
    if values.empty:
        return True
    return (column.nullable or not values.hasnans) and all(
        check.name in _PLAIN_CHECKS and _PLAIN_CHECKS[check.name](values, **check.statistics)
        for check in column.checks
    )


def write(frame: pd.DataFrame, table: str, path: Path, provenance: Mapping[str, Any]) -> None:
    """Check a table and write it whole or not at all, with units and provenance in the footer.

    Args:
        frame: The rows.
        table: Name of the table's model.
        path: Parquet file to write.
        provenance: At least `campaign` and `data` ("simulated" or "measured"); plain JSON values.

    Raises:
        OilfilmError: The frame breaks the contract.
    """
    conformed, schema = conform(frame, table, str(path)), _arrow_schema(table)
    # column by column, in half of the time of `from_pandas`
    content = arrow.table(
        [arrow.array(conformed[field.name], field.type, from_pandas=True) for field in schema],
        schema=schema,
    )
    footer = {"table": table, "schema_version": SCHEMA_VERSION, **provenance}
    content = content.replace_schema_metadata(
        {"oilfilm": json.dumps(footer, sort_keys=True, ensure_ascii=False)}
    )
    path.parent.mkdir(parents=True, exist_ok=True)
    aside = path.with_name(path.name + ".part")
    encodings = {
        field.name: _ENCODINGS[str(field.type)] for field in schema if str(field.type) in _ENCODINGS
    }
    parquet.write_table(
        content,
        aside,
        compression="zstd",
        row_group_size=1 << 18,
        use_dictionary=[name for name in schema.names if name not in encodings],
        column_encoding=encodings,
    )
    aside.replace(path)


# Numbers hardly repeat: a dictionary of them takes five times the time and saves nothing.
_ENCODINGS = {"int64": "DELTA_BINARY_PACKED", "double": "BYTE_STREAM_SPLIT"}


def read(table: str, *paths: Path) -> pd.DataFrame:
    """Read a table, whole, in several files or in none (then empty), and check it again.

    Raises:
        OilfilmError: A file is missing or damaged, holds another table or another schema
            version, or breaks the contract.
    """
    if not paths:
        return empty(table)
    parts = [_read_part(table, path) for path in paths]
    where = str(paths[0]) if len(paths) == 1 else f"{paths[0]} and {len(paths) - 1} more"
    whole = arrow.concat_tables(parts).unify_dictionaries() if len(parts) > 1 else parts[0]
    return conform(whole.to_pandas(), table, where)


def _read_part(table: str, path: Path) -> arrow.Table:
    _check_footer(table, path)
    # not as part of a partitioned set: the folder `oil=...` would add a column
    return parquet.read_table(path, partitioning=None).replace_schema_metadata(None)


def read_run(table: str, paths: Sequence[Path], run_id: str) -> pd.DataFrame:
    """Only the rows of one run, from the files among which they are.

    Raises:
        OilfilmError: As `read`.
    """
    for path in paths:
        _check_footer(table, path)
    # what is not of the run never leaves Arrow, and row groups without it are not even read
    wanted = [("run_id", "==", run_id)]
    content = arrow.concat_tables(
        [parquet.read_table(path, filters=wanted, partitioning=None) for path in paths]
    )
    return conform(content.to_pandas(), table, f"run {run_id}")


def _check_footer(table: str, path: Path) -> None:
    footer = read_footer(path)
    if footer.get("table") != table or footer.get("schema_version") != SCHEMA_VERSION:
        raise OilfilmError(
            f"{path}: holds table {footer.get('table')!r}, schema version "
            f"{footer.get('schema_version')!r}; expected {table!r}, version {SCHEMA_VERSION}. "
            "Delete it and run snakemake again."
        )


def read_footer(path: Path) -> dict[str, Any]:
    """Provenance, table name and schema version of a Parquet file.

    Raises:
        OilfilmError: The file is missing, damaged or was not written by oilfilm.
    """
    try:
        metadata = parquet.read_schema(path).metadata or {}
    except (OSError, arrow.ArrowException) as error:
        raise OilfilmError(
            f"{path}: cannot be read as Parquet ({error}). Delete it and run snakemake again."
        ) from error
    if b"oilfilm" not in metadata:
        raise OilfilmError(f"{path}: is Parquet, but not a table of oilfilm.")
    return cast(dict[str, Any], json.loads(metadata[b"oilfilm"]))


def _arrow_schema(table: str) -> arrow.Schema:
    types = {
        "float64": arrow.float64(),
        "int64": arrow.int64(),
        "bool": arrow.bool_(),
        "category": arrow.dictionary(arrow.int32(), arrow.string()),
    }
    fields = []
    for name, column in TABLES[table].to_schema().columns.items():
        about = {"unit": unit_of(name), "description": column.description}
        fields.append(
            arrow.field(name, types.get(str(column.dtype), arrow.string()), metadata=about)
        )
    return arrow.schema(fields)
