"""Logs of a campaign whose curves contradict the others, and logs that no others can judge."""

import itertools

import numpy as np
import pandas as pd
import pytest

import bad_logs
from bad_curves import CURVE_DAMAGES, CurveDamage, film_collapse, late_by_a_step, one_step_high
from bad_logs import CONFIG, RATE_HZ
from campaigns import rig_contact
from lawless_truths import TRUTHS
from nights import nightly, quick_ones
from oilfilm.base.units import FloatArray
from oilfilm.curation.curate import CuratedTables, curate_logs
from oilfilm.curation.curve_shapes import judge_shapes
from oilfilm.physics.contact import load_for_max_hertz_pressure
from surface_campaigns import grid, latin, simulated

# The film is thick enough at these temperatures for the gate `thin_film`.
TWELVE = grid((1.0, 1.5), (25.0, 40.0), (25.0, 45.0, 70.0))
TEN_SLIPS = np.geomspace(0.004, 0.28, 10)
SIX_SLIPS = np.geomspace(0.006, 0.29, 6)
# At this condition the traction has fallen by a fifth from its peak before the film collapses.
ALONE, EVEN_SLIPS = grid((1.5,), (40.0,), (25.0,)), np.linspace(0.02, 0.28, 9)
# The full scale of the force sensor is 10 N.
SHARE_OF_TRUTH = 0.8
QUICK = (late_by_a_step,)


def late_by_a_zero(mu: FloatArray, slip: FloatArray, pressure_gpa: float) -> FloatArray:
    """The force is late by one step, and the first one shows that of pure rolling."""
    return np.append(0.0, mu[:-1])


def log(
    condition: FloatArray, slips: FloatArray, seed: int, damage: CurveDamage | None = None
) -> bytes:
    """A log of an oil of no law, in steps of slip between two phases of pure rolling."""
    random = np.random.default_rng(seed)
    pressure, speed, celsius = condition
    true_celsius = celsius + 0.3 * random.standard_normal()
    mu = SHARE_OF_TRUTH * TRUTHS["sol"](pressure, speed, true_celsius, slips)
    if damage is not None:
        mu = damage(mu, slips, pressure)
    contact = rig_contact()
    load_n = load_for_max_hertz_pressure(
        pressure * 1e9, contact.radius_m, contact.reduced_modulus_pa
    )
    samples = 4 * RATE_HZ
    levels = np.repeat([0.0, *slips, 0.0], samples)
    force_n = np.repeat([0.0, *mu, 0.0], samples) * load_n
    force_n *= 1 + 0.005 * random.standard_normal()

    def noise(size: float) -> FloatArray:
        return size * random.standard_normal(len(levels))

    per_rpm = 2 * np.pi / 60
    rig = CONFIG.rigs["ball-on-disc-20mm"]
    ball, disc = speed * (1 - levels / 2) + noise(0.005), speed * (1 + levels / 2) + noise(0.005)
    values = {
        "time": np.arange(len(levels)) / RATE_HZ,
        "load": load_n + noise(0.1),
        "traction_force": force_n + 0.2 + noise(0.02),
        "ball_speed": ball / (per_rpm * rig.ball_track_radius_m),
        "disc_speed": disc / (per_rpm * rig.disc_track_radius_m),
        "inlet_temperature": celsius + noise(0.05),
    }
    keys = {
        "max_hertz_pressure_gpa": pressure,
        "entrainment_speed_m_s": speed,
        "inlet_temperature_c": celsius,
    }
    return bad_logs.csv(values, **keys)


def judged(
    conditions: FloatArray, slips: FloatArray, bad: dict[int, CurveDamage] | None = None
) -> CuratedTables:
    """The verdicts on one log per condition, some of them with a defect."""
    damages = bad or {}
    logs = []
    for row, condition in enumerate(conditions):
        logs.append((f"{row:02d}.csv", log(condition, slips, row, damages.get(row))))
    return curate_logs(logs, CONFIG)


def told(curated: CuratedTables) -> dict[str, str]:
    """File -> rule or warning, of the runs that are not simply accepted."""
    texts = {}
    for run in curated.runs.itertuples():
        # the spin of the rig says nothing of a log
        warnings = [text for text in run.warning if not text.startswith("rig_spin")]
        text = run.rule or "; ".join(warnings)
        if text:
            texts[run.file] = text
    return texts


@pytest.mark.slow
@pytest.mark.parametrize(
    "damage",
    [
        pytest.param(damage, marks=() if damage in QUICK else pytest.mark.nightly)
        for damage in CURVE_DAMAGES
    ],
    ids=lambda damage: damage.__name__,
)
def test_log_with_a_defect_that_no_oil_has_is_refused_or_warned_about_and_no_other(
    damage: CurveDamage,
):
    curated = judged(TWELVE, TEN_SLIPS, {5: damage})
    texts = told(curated)
    assert list(texts) == ["05.csv"]
    if texts["05.csv"].startswith("unusual_shape"):
        return
    assert texts["05.csv"] == "odd_shape"
    (row,) = curated.quarantine.itertuples()
    (run,) = curated.runs[curated.runs["file"] == "05.csv"].itertuples()
    # the rows are those of one step of slip
    assert 0 < row.last_row - row.first_row <= 4 * RATE_HZ
    assert row.last_row < run.samples
    assert not curated.points.loc[curated.points["run_id"] == run.run_id, "accepted"].any()


@pytest.mark.slow
@pytest.mark.parametrize("bad_name", quick_ones(["a.csv", "b.csv"], ["a.csv"]))
def test_good_repeat_is_kept_in_place_of_one_with_a_defect(bad_name: str):
    logs = [
        (f"{row:02d}.csv", log(condition, TEN_SLIPS, row))
        for row, condition in enumerate(TWELVE)
        if row != 5
    ]
    for seed, name in enumerate(("a.csv", "b.csv", "c.csv")):
        # two thirds of the curve of both are the same: it is no contradiction of the runs
        damage = one_step_high if name == bad_name else None
        logs.append((name, log(TWELVE[5], TEN_SLIPS, 50 + seed, damage)))
    curated = curate_logs(logs, CONFIG)
    rules = curated.runs.set_index("file")["rule"]
    kept, repeated = ("a.csv", "b.csv") if bad_name != "a.csv" else ("b.csv", "c.csv")
    assert (curated.runs["verdict"] == "accepted").sum() == 12
    assert rules[kept] == ""
    assert rules[repeated] == "duplicate_condition"
    if bad_name == "a.csv":
        assert rules["a.csv"] == "odd_shape"
    reasons = curated.quarantine.set_index("file")["reason"]
    assert f"{kept}, which is kept" in reasons[repeated]


@pytest.mark.nightly
def test_clean_logs_at_six_log_spaced_slips_are_accepted():
    conditions = latin()
    conditions[:, 2] = 25 + (conditions[:, 2] - 25) * 45 / 95
    assert told(judged(conditions, SIX_SLIPS)) == {}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("damage", "slips", "sentence"),
    [
        (film_collapse, EVEN_SLIPS, "two peaks"),
        (late_by_a_zero, EVEN_SLIPS, "faster than the slip"),
        (one_step_high, EVEN_SLIPS, "curve of the other levels"),
    ],
)
def test_first_log_alone_is_warned_about_what_no_oil_does(
    damage: CurveDamage, slips: FloatArray, sentence: str
):
    curated = judged(ALONE, slips, {0: damage})
    assert sentence in told(curated)["00.csv"]
    assert "few other curves" in told(curated)["00.csv"]
    assert (curated.runs["verdict"] == "accepted").all()


@pytest.mark.slow
@pytest.mark.parametrize(
    "slips", [nightly(TEN_SLIPS), nightly(SIX_SLIPS), EVEN_SLIPS], ids=["ten", "six", "even"]
)
def test_first_log_alone_is_accepted_where_an_oil_may_have_its_curve(slips: FloatArray):
    for condition in (TWELVE[:1], TWELVE[-1:], ALONE):
        assert told(judged(condition, slips)) == {}


def test_defects_are_told_where_three_logs_are_too_few_to_judge_each_other():
    conditions = np.vstack([TWELVE[:2], ALONE])
    assert list(told(judged(conditions, EVEN_SLIPS, {2: film_collapse}))) == ["02.csv"]


def tables_of(
    truth: str, conditions: FloatArray, slips: FloatArray, same_oil: bool
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Points and runs of clean curves of one oil, or of one oil per curve."""
    measured = simulated(TRUTHS[truth], conditions, np.random.default_rng(6), slips=slips)
    names = np.array([f"{row:02d}" for row in range(len(conditions))])
    pressure, speed, celsius = measured.point_conditions.T
    points = pd.DataFrame(
        {
            "run_id": names[measured.curve_of_point],
            "oil": "oil" if same_oil else names[measured.curve_of_point],
            "max_hertz_pressure_gpa": pressure,
            "entrainment_speed_m_s": speed,
            "inlet_temperature_c": celsius,
            "slide_roll_ratio": measured.slip,
            "traction_coefficient": measured.mu,
            "traction_coefficient_se": 0.003 * measured.mu,
            "first_row": 0,
            "last_row": 1,
            "accepted": True,
        }
    )
    return points, pd.DataFrame({"run_id": names, "rig": "rig", "verdict": "accepted"})


@pytest.mark.slow
@pytest.mark.parametrize(
    "designs",
    [
        pytest.param((SIX_SLIPS,), id="336 curves"),
        pytest.param(
            (TEN_SLIPS, SIX_SLIPS, EVEN_SLIPS), id="1008 curves", marks=pytest.mark.nightly
        ),
    ],
)
def test_no_oil_is_beyond_the_limits_that_hold_for_any(designs):
    """Of clean curves none is refused, and two at most are named."""
    named = []
    for truth, slips in itertools.product(TRUTHS, designs):
        verdicts = judge_shapes(*tables_of(truth, latin(), slips, same_oil=False))
        assert verdicts.refusals == []
        named += [(truth, len(slips), run) for run, _ in verdicts.warnings]
    # a kink of a curve looks like a wrong level
    assert {truth for truth, _, _ in named} <= {"pw"}
    assert len(named) <= 2, named


def test_curves_that_are_far_from_each_other_are_said_to_be_not_judged():
    conditions = np.array(
        [
            (0.6, 5.0, 25.0),
            (1.0, 15.0, 60.0),
            (1.5, 40.0, 90.0),
            (2.4, 90.0, 120.0),
            (0.7, 90.0, 40.0),
        ]
    )
    verdicts = judge_shapes(*tables_of("mix", conditions, TEN_SLIPS, same_oil=True))
    assert verdicts.refusals == []
    assert verdicts.unjudged_ids
    for _, sentence in verdicts.warnings:
        assert sentence.startswith("shape_not_judged")


@pytest.mark.parametrize("direction", [1, -1])
def test_single_curve_is_judged_in_both_directions(direction: int):
    points, runs = tables_of("sol", ALONE, EVEN_SLIPS, same_oil=True)
    points["traction_coefficient"] = film_collapse(
        points["traction_coefficient"].to_numpy(), EVEN_SLIPS, ALONE[0, 0]
    )
    for name in ("slide_roll_ratio", "traction_coefficient"):
        points[name] *= direction
    ((_, sentence),) = judge_shapes(points, runs).warnings
    assert sentence.startswith("odd_alone")


@pytest.mark.slow
def test_points_without_pressure_are_not_judged_by_others():
    points, runs = tables_of("sol", TWELVE, TEN_SLIPS, same_oil=True)
    is_scuffed = (points["run_id"] == "03") & (points["slide_roll_ratio"] > 0.05)
    points.loc[is_scuffed, "traction_coefficient"] *= 1.5
    assert [refusal.run_id for refusal in judge_shapes(points, runs).refusals] == ["03"]
    unknown = points.assign(max_hertz_pressure_gpa=np.nan)
    assert judge_shapes(unknown, runs).refusals == []


def test_curves_below_zero_degrees_are_said_to_be_not_judged():
    points, runs = tables_of("sol", TWELVE, TEN_SLIPS, same_oil=True)
    is_cold = points["run_id"] == "03"
    cold_points = points.assign(
        inlet_temperature_c=points["inlet_temperature_c"].mask(is_cold, -5.0)
    )
    verdicts = judge_shapes(cold_points, runs)
    assert verdicts.refusals == []
    ((run_id, sentence),) = verdicts.warnings
    assert run_id == "03"
    assert sentence.startswith("shape_not_judged")
    assert "-5 degC" in sentence


@pytest.mark.parametrize("share_of_truth", [0.01, 0.001])
def test_curves_without_traction_are_said_to_be_not_judged(share_of_truth: float):
    slips = np.array([0.0065, 0.013, 0.0195])
    points, runs = tables_of("sol", TWELVE[:8], slips, same_oil=True)
    for name in ("traction_coefficient", "traction_coefficient_se"):
        points[name] *= share_of_truth
    verdicts = judge_shapes(points, runs)
    assert verdicts.refusals == []
    assert verdicts.unjudged_ids == set(runs["run_id"])
    assert [run_id for run_id, _ in verdicts.warnings] == list(runs["run_id"])
    assert all(sentence.startswith("shape_not_judged") for _, sentence in verdicts.warnings)
