"""Runs that a campaign lacks: levels, corners, repeats and references, in an order by chance."""

import itertools
import tracemalloc
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from campaigns import rows, without
from lawless_truths import TRUTHS
from oilfilm.base.units import BoolArray, FloatArray
from oilfilm.settings.resolved import Settings
from oilfilm.surface.measurements import LevelWidths, level_numbers, scaled_conditions
from oilfilm.surface.steadiness import smallest_visible_size
from oilfilm.surface.surface import fit_surface
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.torque.lacking_runs import first_runs, lacking_runs
from oilfilm.torque.operating_grid import Grid, OilFilm
from oilfilm.torque.run_order import ordering_condition
from oilfilm.torque.run_plan import MeasuredRuns, RunPlan, plan_runs, run_plan_table
from oilfilm.traction.law import CONDITIONS
from planned_tests import CONTACT, OIL
from planned_tests import SETTINGS as AS_STATED
from surface_campaigns import (
    PRESSURES,
    SPEEDS,
    TEMPERATURES,
    ends,
    fitted_law,
    grid,
    latin,
    random_conditions,
    simulated,
)

# A campaign without a matrix, so that nothing is planned but what its runs lack.
# A rig whose full scales are known, so that they bound the runs.
SETTINGS = AS_STATED.with_changes({"rigs": {"ball-on-disc-20mm": {"full_scale": {"assumed": []}}}})
PLAIN = without(SETTINGS, "matrix")
NO_DATA = MeasuredRuns.empty()
CUBE = grid(PRESSURES, (25.0, 32.0, 40.0), (25.0, 72.0, 120.0))
BOX = (ends(PRESSURES), ends(SPEEDS), ends(TEMPERATURES))


def measured(conditions: FloatArray) -> MeasuredRuns:
    """Runs in this order of time, with the traction of an oil and slips up to 0.3."""
    count = len(conditions)
    return MeasuredRuns(conditions, np.full(count, 0.03), np.full(count, 0.3))


def shuffled(conditions: FloatArray, seed: int = 3) -> FloatArray:
    return np.random.default_rng(seed).permutation(conditions)


def plan(conditions: FloatArray, settings: Settings = PLAIN) -> RunPlan:
    return plan_runs(measured(conditions), settings, OIL)


def conditions_of_reason(run_plan: RunPlan, reason: str) -> FloatArray:
    chosen = [run.conditions for run in run_plan.runs if run.reason == reason]
    return np.array(chosen).reshape(-1, 3)


def reasons(run_plan: RunPlan) -> set[str]:
    return {run.reason for run in run_plan.runs}


def with_planned_runs(conditions: FloatArray, run_plan: RunPlan) -> FloatArray:
    """The campaign after the runs of its plan."""
    return np.concatenate([conditions, [run.conditions for run in run_plan.runs]])


def level_counts(conditions: FloatArray) -> list[int]:
    """Number of levels of P, U and T, as a surface counts them."""
    numbers = level_numbers(scaled_conditions(conditions), LevelWidths())
    return [int(count) for count in numbers.max(axis=0) + 1]


def test_two_temperatures_get_the_one_between_where_pressure_and_speed_were_tested() -> None:
    tested = shuffled(grid(PRESSURES, SPEEDS, ends(TEMPERATURES)))
    run_plan = plan(tested)
    assert reasons(run_plan) == {"reference", "third_level"}
    third_level_conditions = conditions_of_reason(run_plan, "third_level")
    assert (third_level_conditions[:, 2] == (25 + 120) / 2).all()
    # the centre of the box, and one run on each face of pressure and speed
    pressures_and_speeds = {(p, u) for p, u, _ in third_level_conditions}
    assert pressures_and_speeds == {(1.25, 30), (1, 30), (1.5, 30), (1.25, 25), (1.25, 40)}
    assert pressures_and_speeds <= {(p, u) for p, u, _ in tested}
    new_levels = {run.new_levels for run in run_plan.runs if run.reason == "third_level"}
    assert new_levels == {("inlet_temperature_c",)}
    assert level_counts(tested) == [3, 4, 2]
    assert level_counts(with_planned_runs(tested, run_plan)) == [3, 4, 3]


def test_levels_are_as_wide_as_the_campaign_states() -> None:
    """Temperatures that a rig holds within 3 K are two levels where a level is 8 K wide."""
    temperatures = (22.0, 25.0, 28.0, 117.0, 120.0, 123.0)
    tested = shuffled(grid(PRESSURES, SPEEDS, temperatures))
    wide_levels = PLAIN.with_changes({"same_condition": {"inlet_temperature_c": 8.0}})
    third_level_conditions = conditions_of_reason(plan(tested, wide_levels), "third_level")
    (new_temperature,) = set(third_level_conditions[:, 2])
    assert (22 + 117) / 2 <= new_temperature <= (28 + 123) / 2
    # with 2 K they are six levels, so that no level is between two
    narrow_levels = PLAIN.with_changes({"same_condition": {"inlet_temperature_c": 2.0}})
    assert "third_level" not in reasons(plan(tested, narrow_levels))


def test_level_between_pressures_and_speeds_is_in_the_middle_of_the_logarithm() -> None:
    run_plan = plan(shuffled(grid(*BOX)))
    third_level_conditions = conditions_of_reason(run_plan, "third_level")
    # sqrt(1.0 * 1.5) GPa, sqrt(25 * 40) m/s
    middle = np.array([1.22, 31.6, 72.5])
    centres_of_faces = []
    for condition_index, ends_of_condition in enumerate(BOX):
        for end_level in ends_of_condition:
            centre_of_face = middle.copy()
            centre_of_face[condition_index] = end_level
            centres_of_faces.append(tuple(centre_of_face))
    assert {tuple(row) for row in third_level_conditions} == {tuple(middle), *centres_of_faces}


def test_a_condition_that_was_not_varied_gets_two_levels() -> None:
    tested = shuffled(grid(PRESSURES, (30.0,), (25.0, 72.0, 120.0)))
    run_plan = plan(tested)
    assert level_counts(with_planned_runs(tested, run_plan)) == [3, 3, 3]
    assert {run.new_levels for run in run_plan.runs if run.reason == "not_varied"} == {
        ("entrainment_speed_m_s",)
    }
    # plan.levels has 10 to 50 m/s; at 50 m/s both surfaces would reach the full scale of 50 m/s
    # without any slip
    assert set(conditions_of_reason(run_plan, "not_varied")[:, 1]) == {10.0, 45.0}
    assert len(conditions_of_reason(run_plan, "corner")) > 0


@pytest.mark.parametrize("tested_speed", [20.0, 22.0, 27.0])
def test_a_speed_near_the_end_of_the_logarithmic_scale_is_an_end_itself(
    tested_speed: float,
) -> None:
    speeds = [1.0, 2.0, 5.0, 10.0, 20.0, 50.0]
    # the outer quarter of 1 to 50 m/s begins at 50^(3/4), 18.8 m/s
    runs = lacking_runs(
        grid(PRESSURES, (tested_speed,), (25.0, 72.0, 120.0)),
        [PRESSURES, speeds, TEMPERATURES],
        lambda conditions: np.ones(len(conditions), dtype=bool),
        LevelWidths(),
    )
    new_speeds = {float(run.conditions[1]) for run in runs if run.reason == "not_varied"}
    assert new_speeds == {1.0, float(f"{np.sqrt(tested_speed):.3g}")}


def some_of(*levels: float) -> st.SearchStrategy[list[float]]:
    """At least one of some levels, rising; all of them are further apart than one level is wide."""
    return st.sets(st.sampled_from(levels), min_size=1).map(sorted)


@given(
    limit=st.floats(20.0, 400.0),
    pressures=some_of(0.5, 0.8, 1.2, 1.8, 3.0),
    speeds=some_of(1.0, 5.0, 20.0, 50.0, 100.0),
    temperatures=some_of(20.0, 45.0, 80.0, 120.0, 150.0),
)
def test_first_plan_fills_the_largest_box_whose_corners_can_be_run(
    limit: float, pressures: list[float], speeds: list[float], temperatures: list[float]
) -> None:
    levels = [pressures, speeds, temperatures]

    def can_run(conditions: FloatArray) -> BoolArray:
        pressure, speed, temperature = conditions.T
        return np.asarray(pressure * speed + temperature < limit)

    boxes = [
        box
        for box in itertools.product(
            *(itertools.combinations_with_replacement(values, 2) for values in levels)
        )
        if can_run(np.array(list(itertools.product(*box)))).all()
    ]
    boxes = boxes or [tuple((values[0], values[-1]) for values in levels)]
    volumes = []
    for box in boxes:
        scaled_ends = scaled_conditions(np.array(box).T)
        volumes.append(np.prod(np.diff(scaled_ends, axis=0) + LevelWidths().scaled()))
    conditions = np.array([run.conditions for run in first_runs(levels, can_run, LevelWidths())])
    scaled = scaled_conditions(conditions)
    volume = np.prod(np.ptp(scaled, axis=0) + LevelWidths().scaled())
    assert volume == pytest.approx(max(volumes), rel=1e-9)


def test_missing_corners_come_before_repeats_and_then_nothing_is_lacking() -> None:
    corner = np.array([1.5, 40.0, 120.0])
    is_corner = (corner == CUBE).all(axis=1)
    tested = shuffled(CUBE[~is_corner])
    run_plan = plan(tested)
    assert [run.reason for run in run_plan.runs] == ["reference", "corner"]
    assert conditions_of_reason(run_plan, "corner").tolist() == [corner.tolist()]
    with_corner = with_planned_runs(tested, run_plan)
    plan_of_repeats = plan(with_corner)
    assert reasons(plan_of_repeats) == {"reference", "repeat"}
    # the reference run was one repeat: four are lacking
    assert len(conditions_of_reason(plan_of_repeats, "repeat")) == 4
    assert not plan(with_planned_runs(with_corner, plan_of_repeats)).runs


def test_campaign_in_the_order_of_a_condition_gets_references_and_repeats() -> None:
    tested = grid(*BOX)
    run_plan = plan(tested)
    assert run_plan.ordered_by == "max_hertz_pressure_gpa"
    order = run_plan.table().set_index("run_order")["run_reason"]
    # seven runs at levels between, five repeats
    assert order.index[order == "reference"].tolist() == [1, 7, 13]
    assert len(order) == 7 + 5 + 3
    references = np.unique(conditions_of_reason(run_plan, "reference"), axis=0)
    assert len(references) == 1
    # at a tested condition: else a change of the rig between old and new runs would look like
    # the effect of the new level
    assert (tested == references).all(axis=1).any()
    repeats = conditions_of_reason(run_plan, "repeat")
    assert {tuple(row) for row in repeats} <= {tuple(row) for row in tested}
    # from the first to the last run
    assert {tuple(tested[0]), tuple(tested[-1])} <= {tuple(row) for row in repeats}
    extended_conditions = with_planned_runs(tested, run_plan)
    assert ordering_condition(extended_conditions, LevelWidths()) == ""
    next_plan = plan(extended_conditions)
    assert not next_plan.ordered_by
    assert "repeat" not in reasons(next_plan)


def test_reference_is_nearest_to_the_middle_of_the_box() -> None:
    run_plan = plan(shuffled(CUBE[:-1]))
    # the middle is 1.22 GPa, 31.6 m/s, 72.5 degC
    assert conditions_of_reason(run_plan, "reference").tolist() == [[1.25, 32.0, 72.0]]


@pytest.mark.slow
def test_the_plan_of_an_ordered_campaign_shows_a_trend_that_the_order_hid() -> None:
    """The smallest trend of the force, five standard deviations, of an oil without a law."""
    runs = latin()
    tested = runs[np.lexsort((runs[:, 0], runs[:, 1], runs[:, 2]))]
    smallest = []
    for conditions in (tested, with_planned_runs(tested, plan(tested))):
        random = np.random.default_rng(8)
        points = simulated(TRUTHS["jt"], conditions, random, slips=np.geomspace(0.002, 0.3, 9))
        curves, _ = points.canonical_order()
        surface = fit_surface(points, fitted_law(points))
        trend = np.linspace(-0.5, 0.5, len(conditions))[curves]
        smallest.append(smallest_visible_size(surface.misfit_covariance, "gain", trend))
    hidden, shown = smallest
    assert hidden > 0.2
    assert shown < 0.05


@pytest.mark.parametrize(
    ("conditions", "name"),
    [
        (grid(PRESSURES, SPEEDS, TEMPERATURES), "max_hertz_pressure_gpa"),
        (latin()[np.argsort(latin()[:, 2], kind="stable")], "inlet_temperature_c"),
        (CUBE[np.argsort(CUBE[:, 1], kind="stable")], "entrainment_speed_m_s"),
        (shuffled(latin()), ""),
        (shuffled(grid(*BOX)), ""),
        # each condition twice in a row: no run is repeated later
        (np.repeat(CUBE, 2, axis=0), "max_hertz_pressure_gpa"),
        # the first run again at the end
        (np.concatenate([CUBE, CUBE[:1]]), ""),
        (CUBE[:5], ""),
    ],
)
def test_order_of_a_condition_is_found(conditions: FloatArray, name: str) -> None:
    assert ordering_condition(conditions, LevelWidths()) == name


def test_first_plan_has_24_runs_at_three_or_more_levels_of_each_condition() -> None:
    run_plan = plan_runs(NO_DATA, PLAIN, OIL)
    first_conditions = conditions_of_reason(run_plan, "first_plan")
    assert len(first_conditions) == 24
    assert level_counts(first_conditions) == [3, 4, 6]
    order = run_plan.table().set_index("run_order")["run_reason"]
    assert order.index[order == "reference"].tolist() == [1, 7, 13, 19, 25]
    conditions = run_plan.table()[list(CONDITIONS)].to_numpy()
    assert ordering_condition(conditions, LevelWidths()) == ""


def lies_within_the_rig(run_plan: RunPlan, mu: float) -> None:
    """Against limits, sensors and film of the rig, from its file; the film as in the maps."""
    rig = SETTINGS.rigs[run_plan.rig_name]
    assert rig.limits is not None
    assert rig.full_scale is not None
    table = run_plan.table()
    load = CONTACT.load_n(table["max_hertz_pressure_gpa"].to_numpy())
    np.testing.assert_allclose(table["load_n"], load)
    assert load.max() <= rig.full_scale.load_n
    assert (load * mu).max() <= rig.full_scale.traction_force_n
    assert table["max_hertz_pressure_gpa"].max() <= rig.limits.max_hertz_pressure_gpa
    assert table["inlet_temperature_c"].max() <= rig.limits.inlet_temperature_c
    assert table["slide_roll_ratio"].max() <= rig.limits.slide_roll_ratio
    faster = table["entrainment_speed_m_s"] * (1 + table["slide_roll_ratio"] / 2)
    assert faster.max() <= rig.full_scale.surface_speed_m_s
    film = OilFilm(CONTACT, SETTINGS.oil_with_properties(OIL), SETTINGS.film.thickness)
    for row in table.to_dict("records"):
        point = Grid(*(np.array([row[name]]) for name in (*CONDITIONS, "slide_roll_ratio")))
        _, lambda_ratio = film.on_grid(point)
        assert lambda_ratio.item() == pytest.approx(row["lambda_ratio"])
        assert lambda_ratio.item() > SETTINGS.gates.lambda_limit


@pytest.mark.parametrize("seed", range(4))
def test_no_run_is_beyond_the_rig(seed: int) -> None:
    """Campaigns at the edge of the rig: loads near 200 N, 50 m/s, 150 degC, thin films."""
    random = np.random.default_rng(seed)
    possible = ([1.0, 1.3, 1.65], [3.0, 10.0, 48.0], [25.0, 90.0, 148.0])
    pairs = [tuple(np.sort(random.choice(values, 2, False)).tolist()) for values in possible]
    tested = shuffled(grid(*pairs), seed)
    run_plan = plan(tested)
    lies_within_the_rig(run_plan, 0.03)
    lies_within_the_rig(plan_runs(NO_DATA, PLAIN, OIL), PLAIN.plan.largest_traction)


def test_what_the_rig_cannot_run_is_counted_and_named() -> None:
    beyond = {"max_hertz_pressure_gpa": [1.0, 1.25, 2.0], "inlet_temperature_c": [25, 70, 120]}
    settings = SETTINGS.with_changes({"campaign": {"matrix": beyond}})
    run_plan = plan_runs(NO_DATA, settings, OIL)
    # 12 conditions of 2 GPa, 337 N, on a load cell of 200 N; 24 conditions remain
    assert run_plan.left_out_count_by_limit["the load sensor's full scale"] == 12
    planned = conditions_of_reason(run_plan, "planned")
    assert len(planned) == 24
    # two pressures remain
    assert len(conditions_of_reason(run_plan, "third_level")) > 0
    assert set(planned[:, 0]) == {1.0, 1.25}


def test_a_first_plan_beyond_the_rig_names_the_limit() -> None:
    weak_rig = {"rigs": {"ball-on-disc-20mm": {"limits": {"max_hertz_pressure_gpa": 0.01}}}}
    run_plan = plan_runs(NO_DATA, PLAIN.with_changes(weak_rig), OIL)
    assert not run_plan.runs
    assert run_plan.left_out_count_by_limit["the rig's largest pressure"] == 24


def test_conditions_of_the_matrix_without_an_accepted_run_are_planned() -> None:
    matrix = grid(PRESSURES, SPEEDS, TEMPERATURES)
    lost = matrix[[5, 40]]
    run_plan = plan(shuffled(np.delete(matrix, [5, 40], axis=0)), SETTINGS)
    assert sorted(conditions_of_reason(run_plan, "planned").tolist()) == sorted(lost.tolist())
    assert reasons(run_plan) == {"reference", "planned"}


def campaign_tables(
    conditions: FloatArray, names: list[str], oil: str, direction: int = 1
) -> CampaignTables:
    """Accepted runs, whose set points are in the table of runs.

    Args:
        conditions: P, U and T of each run.
        names: Their names.
        oil: Name of the oil.
        direction: Sign of slip and traction: -1 where the ball is the faster body.
    """
    runs = []
    points = []
    set_points = [f"nominal_{name}" for name in CONDITIONS]
    for name, row in zip(names, conditions.tolist(), strict=True):
        run = {"run_id": name, "oil": oil, "rig": "ball-on-disc-20mm", "verdict": "accepted"}
        runs.append(run | dict(zip(set_points, row, strict=True)))
        for slip in (0.01, 0.3):
            point = {"run_id": name, "oil": oil, "accepted": True}
            point |= {"slide_roll_ratio": direction * slip}
            points.append(point | {"traction_coefficient": direction * (0.01 + row[0] / 100)})
    return CampaignTables.from_frames(runs=rows("runs", *runs), points=rows("points", *points))


def test_order_does_not_depend_on_names_of_runs_and_oils_or_on_the_order_of_rows() -> None:
    random = np.random.default_rng(5)
    conditions = random_conditions(12, random).round(2)
    names = [f"run{number}" for number in range(12)]
    oil_file = PLAIN.plain_values()["oils"][OIL]
    renamed_oil = Settings.from_plain_values(
        {**PLAIN.plain_values(), "oils": {"another": oil_file}}
    )
    tables = []
    for oil, settings in ((OIL, PLAIN), ("another", renamed_oil)):
        for _ in range(2):
            rows_in_order = random.permutation(12)
            named = random.permutation(names).tolist()
            results = campaign_tables(conditions[rows_in_order], named, oil)
            assert MeasuredRuns.from_results(results, settings, oil).conditions.shape == (12, 3)
            table, reasons_without_plan = run_plan_table(results, settings)
            assert not reasons_without_plan
            tables.append(table.drop(columns=["oil"]))
    for table in tables[1:]:
        pd.testing.assert_frame_equal(table, tables[0])


def test_runs_with_the_faster_ball_are_planned_with_the_size_of_their_slip() -> None:
    conditions = grid(*BOX)
    names = [f"run{number}" for number in range(8)]
    results = campaign_tables(conditions, names, OIL, direction=-1)
    measured_runs = MeasuredRuns.from_results(results, PLAIN, OIL)
    np.testing.assert_allclose(measured_runs.largest_slip, 0.3)
    np.testing.assert_allclose(measured_runs.largest_mu, 0.01 + conditions[:, 0] / 100)
    planned_slip = plan_runs(measured_runs, PLAIN, OIL).table()["slide_roll_ratio"]
    np.testing.assert_allclose(planned_slip, 0.3)


def test_the_seed_decides_the_order_and_nothing_else() -> None:
    tested = shuffled(grid(*BOX))
    tables = []
    for seed in (1, 1, 2):
        table = plan(tested, PLAIN.with_changes({"seed": seed})).table()
        tables.append(table[[*CONDITIONS, "run_reason"]])
    pd.testing.assert_frame_equal(tables[0], tables[1])
    assert not tables[0].equals(tables[2])
    by_value = [
        table.sort_values([*CONDITIONS, "run_reason"], ignore_index=True) for table in tables
    ]
    pd.testing.assert_frame_equal(by_value[0], by_value[2])


def test_an_oil_without_runs_gets_a_first_plan_beside_an_oil_with_runs() -> None:
    plain = PLAIN.plain_values()
    settings = Settings.from_plain_values(
        {**plain, "oils": {OIL: plain["oils"][OIL], "new": plain["oils"][OIL]}}
    )
    results = campaign_tables(shuffled(grid(*BOX)), [f"run{number}" for number in range(8)], OIL)
    table, reasons_without_plan = run_plan_table(results, settings)
    assert not reasons_without_plan
    of_new = table[table["oil"] == "new"]
    assert (of_new["run_reason"] == "first_plan").sum() == 24
    assert "first_plan" not in set(table.loc[table["oil"] == OIL, "run_reason"])


def test_a_corner_that_the_rig_cannot_run_keeps_no_campaign_from_its_repeats() -> None:
    """1.5 GPa at 25 degC needs more than 10 N of force where the nearest mu is 0.08."""
    is_lost = (CUBE[:, 0] == 1.5) & (CUBE[:, 2] == 25) & (CUBE[:, 1] == 25)
    tested = shuffled(CUBE[~is_lost])
    near_the_corner = (tested[:, 0] > 1.2) & (tested[:, 2] < 80)
    runs = replace(measured(tested), largest_mu=np.where(near_the_corner, 0.08, 0.03))
    run_plan = plan_runs(runs, PLAIN, OIL)
    assert run_plan.left_out_count_by_limit["the force sensor's full scale"] == 1
    assert reasons(run_plan) == {"reference", "repeat"}


def test_oil_of_unknown_properties_is_planned_without_a_film() -> None:
    plain = PLAIN.plain_values()
    settings = Settings.from_plain_values({**plain, "oils": {OIL: None}})
    run_plan = plan(shuffled(grid(*BOX)), settings)
    assert not run_plan.film_is_judged
    assert run_plan.table()["lambda_ratio"].isna().all()


def test_rig_without_limits_has_no_plan_and_the_reason_is_told() -> None:
    plain = PLAIN.plain_values()
    (name,) = plain["rigs"]
    rig = {key: value for key, value in plain["rigs"][name].items() if key != "limits"}
    settings = Settings.from_plain_values({**plain, "rigs": {name: rig}})
    results = campaign_tables(grid(*BOX), [f"run{number}" for number in range(8)], OIL)
    table, reasons_without_plan = run_plan_table(results, settings)
    assert table.empty
    assert "lacks the key `limits`" in reasons_without_plan[0]


def test_the_force_of_a_run_is_that_of_the_nearest_measured_run() -> None:
    """A force sensor of 10 N: 142 N at 1.5 GPa, so that mu of 0.08 is too much there."""
    tested = shuffled(grid(PRESSURES, (25.0, 32.0, 40.0), ends(TEMPERATURES)))
    is_cold = tested[:, 2] == 25
    largest_mu = np.where(is_cold & (tested[:, 0] == 1.5), 0.08, 0.03)
    runs = replace(measured(tested), largest_mu=largest_mu)
    run_plan = plan_runs(runs, PLAIN, OIL)
    third_level_conditions = conditions_of_reason(run_plan, "third_level")
    # 72.5 degC is as near to 25 degC as to 120 degC: the larger mu counts
    assert 1.5 not in third_level_conditions[:, 0]
    assert run_plan.left_out_count_by_limit["the force sensor's full scale"] == 1


def test_memory_of_a_plan_does_not_grow_with_pairs_of_runs() -> None:
    lowest, highest = np.array(BOX).T
    conditions = np.random.default_rng(1).uniform(lowest, highest, (2000, 3))
    tracemalloc.start()
    plan(conditions)
    _, peak_bytes = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    # the distances of all pairs take 96 MB
    assert peak_bytes < 20e6
