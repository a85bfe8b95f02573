"""The runs that a campaign lacks, in the order in which to make them; no law is needed.

A plan has the runs that the campaign lacks (`oilfilm.torque.lacking_runs`). It has repeats where
the order of the measured runs hides a drift, or where nothing else is lacking. All are in random
order. Every sixth run is a reference run, always at the same condition. It shows whether the rig
has changed, and joins the new runs to the old ones.

Decides: the runs to make next, their reasons and their order; the condition of reference runs.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
import scipy

from oilfilm.base.errors import OilfilmError
from oilfilm.base.natural_key import natural_key
from oilfilm.base.ties import exceeds
from oilfilm.base.units import BoolArray, FloatArray
from oilfilm.fits.run_assumptions import level_widths_of
from oilfilm.settings.config import PlanSettings
from oilfilm.settings.resolved import Settings
from oilfilm.surface.measurements import LevelWidths, scaled_conditions
from oilfilm.tables.campaign_tables import CURVE_COLUMNS, CampaignTables
from oilfilm.tables.set_points import with_matched_set_points, with_measured_set_points
from oilfilm.torque.bearing_torque import stack_tables
from oilfilm.torque.feasible_tests import JudgedTests, PlannedRig, judge_tests
from oilfilm.torque.lacking_runs import (
    ConditionLevels,
    PlannedRun,
    distinct_conditions,
    first_runs,
    is_among,
    lacking_runs,
)
from oilfilm.torque.operating_grid import OilFilm
from oilfilm.torque.run_order import ordering_condition, random_order
from oilfilm.traction.law import CONDITIONS

# Number of conditions that are repeated. After 24 runs in the order of pressure, the smallest trend
# of the force that is seen is 35 to 70 %. The plan lowers it to 3 % (`make bench NAME=run_plan`).
_REPEAT_COUNT = 5
# Number of other runs between two reference runs.
RUNS_BETWEEN_REFERENCES = 5
# Slips of a planned run, equally spaced in the logarithm, as a share of the largest one.
_SLIP_SHARES = np.geomspace(0.005, 1, 15)
# Scaled distance within which runs may be equally near but for rounding.
_ROUNDING_OF_DISTANCE = 1e-6


@dataclass(frozen=True)
class MeasuredRuns:
    """Accepted runs of one oil.

    Attributes:
        conditions: P in GPa, U in m/s and T in degC of each run, in the order of the numbers in
            their names, shape (runs, 3).
        largest_mu: Largest absolute traction coefficient of each run, shape (runs,).
        largest_slip: Largest absolute slip of each run, shape (runs,).
    """

    conditions: FloatArray
    largest_mu: FloatArray
    largest_slip: FloatArray

    @classmethod
    def from_results(
        cls, results: CampaignTables, settings: Settings, oil_name: str
    ) -> "MeasuredRuns":
        """The accepted runs of an oil, at the levels that their set points mean.

        Runs without a set point have their measured mean. Runs of unknown conditions are left out.
        """
        points = results.table("points", CURVE_COLUMNS, oil=oil_name)
        points = points[points["accepted"]]
        runs = results.runs[results.runs["run_id"].isin(points["run_id"])]
        runs_at_levels = with_matched_set_points(
            with_measured_set_points(runs, [points]), settings
        ).set_index("run_id")
        runs_at_levels = runs_at_levels.loc[sorted(runs_at_levels.index, key=natural_key)]
        conditions = runs_at_levels[[f"nominal_{name}" for name in CONDITIONS]].to_numpy(
            dtype=float
        )
        # pressure and speed have a logarithmic scale
        is_known = np.isfinite(conditions).all(axis=1) & (conditions[:, :2] > 0).all(axis=1)
        # slip and traction are below 0 where the ball is the faster body
        sizes = points[["traction_coefficient", "slide_roll_ratio"]].abs()
        largest_values_of_run = sizes.groupby(points["run_id"]).max().loc[runs_at_levels.index]
        return cls(
            conditions=conditions[is_known],
            largest_mu=largest_values_of_run["traction_coefficient"].to_numpy(dtype=float)[
                is_known
            ],
            largest_slip=largest_values_of_run["slide_roll_ratio"].to_numpy(dtype=float)[is_known],
        )

    @classmethod
    def empty(cls) -> "MeasuredRuns":
        """No runs, of a campaign without data."""
        return cls(np.empty((0, len(CONDITIONS))), np.empty(0), np.empty(0))


@dataclass(frozen=True)
class RunLimits:
    """What limits the runs of one oil on a rig.

    Attributes:
        rig: The rig.
        film: Film of the oil; None where its properties are not known.
        lambda_limit: A film is full above this ratio.
        measured: The measured runs.
        largest_mu_without_runs: Largest traction coefficient to expect where no run was measured.
    """

    rig: PlannedRig
    film: OilFilm | None
    lambda_limit: float
    measured: MeasuredRuns
    largest_mu_without_runs: float

    def judge(self, conditions: FloatArray) -> JudgedTests:
        """Judge runs at some conditions, shape (runs, 3)."""
        mu = self._expected_mu(conditions)[:, np.newaxis]
        return judge_tests(self.rig, self.film, self.lambda_limit, conditions, self.slips, mu)

    def can_run(self, conditions: FloatArray) -> BoolArray:
        """Which runs the rig can make, shape (runs,)."""
        return self.judge(conditions).is_feasible

    @property
    def slips(self) -> FloatArray:
        """Slips of a planned run, shape (slips,)."""
        largest_slip = self.rig.limits.slide_roll_ratio
        if len(self.measured.largest_slip):
            largest_slip = min(largest_slip, float(np.median(self.measured.largest_slip)))
        return largest_slip * _SLIP_SHARES

    def _expected_mu(self, conditions: FloatArray) -> FloatArray:
        """Largest mu of the nearest measured run, shape (runs,)."""
        if not len(self.measured.conditions):
            return np.full(len(conditions), self.largest_mu_without_runs)
        scaled_measured = scaled_conditions(self.measured.conditions)
        scaled_planned = scaled_conditions(conditions)
        # a tree, because all pairs of a large campaign do not fit into memory
        tree = scipy.spatial.cKDTree(scaled_measured)
        distance_to_nearest, _ = tree.query(scaled_planned)
        expected = np.empty(len(scaled_planned))
        near_indices_of_planned = tree.query_ball_point(
            scaled_planned, distance_to_nearest + _ROUNDING_OF_DISTANCE
        )
        for planned_index, near_index in enumerate(near_indices_of_planned):
            distance = np.sum(
                (scaled_planned[planned_index] - scaled_measured[near_index]) ** 2, axis=1
            )
            is_nearest = ~exceeds(distance, distance.min())
            expected[planned_index] = self.measured.largest_mu[near_index][is_nearest].max()
        return expected


@dataclass(frozen=True)
class RunPlan:
    """The runs to make next for one oil.

    Attributes:
        oil_name: Name of the oil.
        rig_name: Name of the rig.
        runs: The runs, in the order in which to make them.
        judged: Their load, largest slip and film, in the same order.
        ordered_by: The condition in whose order the measured runs were made; empty if none.
        left_out_count_by_limit: Number of lacking runs that the rig cannot make, by the limit.
        film_is_judged: Whether the film of the runs is judged. The oil's properties must be known.
    """

    oil_name: str
    rig_name: str
    runs: list[PlannedRun]
    judged: JudgedTests
    ordered_by: str
    left_out_count_by_limit: dict[str, int]
    film_is_judged: bool

    def table(self) -> pd.DataFrame:
        """Rows of the table `run_plan`."""
        conditions = _conditions_of(self.runs)
        frame = pd.DataFrame(conditions, columns=list(CONDITIONS))
        new_levels = pd.Series([run.new_levels for run in self.runs], dtype=object)
        return frame.assign(
            oil=self.oil_name,
            rig=self.rig_name,
            run_order=np.arange(1, len(self.runs) + 1),
            run_reason=[run.reason for run in self.runs],
            new_levels=new_levels,
            load_n=self.judged.load_n,
            slide_roll_ratio=self.judged.largest_slip,
            lambda_ratio=self.judged.smallest_lambda,
            ordered_by=self.ordered_by,
        )


def _conditions_of(runs: Sequence[PlannedRun]) -> FloatArray:
    """P, U and T of runs, shape (runs, 3)."""
    return np.array([run.conditions for run in runs]).reshape(-1, len(CONDITIONS))


def plan_runs(measured: MeasuredRuns, settings: Settings, oil_name: str) -> RunPlan:
    """The runs to make next for an oil.

    Args:
        measured: Its runs; none for a campaign without data.
        settings: The settings.
        oil_name: Name of the oil.

    Raises:
        OilfilmError: The rig is not known well enough.
    """
    rig = PlannedRig.from_settings(settings)
    properties = settings.properties_of(oil_name)
    film = None
    if properties is not None:
        film = OilFilm(rig.contact, properties, settings.film.thickness)
    plan_settings = settings.plan
    limits = RunLimits(
        rig, film, settings.gates.lambda_limit, measured, plan_settings.largest_traction
    )
    level_widths = level_widths_of(settings.same_condition)
    wanted_runs = _wanted_runs(
        measured, _matrix_conditions(settings), plan_settings, limits, level_widths
    )
    judged_wanted = limits.judge(_conditions_of(wanted_runs))
    runs = [wanted_runs[run_index] for run_index in np.flatnonzero(judged_wanted.is_feasible)]
    measured_order = ordering_condition(measured.conditions, level_widths)
    if measured_order or not runs:
        repeats = _repeat_runs(measured, level_widths, is_ordered=measured_order != "")
        can_repeat = limits.can_run(_conditions_of(repeats))
        runs += [repeats[run_index] for run_index in np.flatnonzero(can_repeat)]
    runs = _in_random_order(runs, measured.conditions, limits, level_widths, settings.seed)
    return RunPlan(
        oil_name=oil_name,
        rig_name=rig.name,
        runs=runs,
        judged=limits.judge(_conditions_of(runs)),
        ordered_by=measured_order,
        left_out_count_by_limit=judged_wanted.left_out_count_by_limit,
        film_is_judged=film is not None,
    )


def _matrix_conditions(settings: Settings) -> FloatArray:
    """P, U and T of the campaign's matrix, shape (conditions, 3); none without a matrix."""
    matrix = settings.campaign.matrix
    if matrix is None:
        return np.empty((0, len(CONDITIONS)))
    mesh = np.meshgrid(*(getattr(matrix, name) for name in CONDITIONS), indexing="ij")
    return np.stack(mesh, axis=-1).reshape(-1, len(CONDITIONS)).astype(float)


def _wanted_runs(
    measured: MeasuredRuns,
    matrix_conditions: FloatArray,
    plan_settings: PlanSettings,
    limits: RunLimits,
    level_widths: LevelWidths,
) -> list[PlannedRun]:
    """The runs that the campaign lacks: those of its matrix, then levels and corners."""
    levels_to_choose = [getattr(plan_settings.levels, name) for name in CONDITIONS]
    is_missing = ~is_among(matrix_conditions, measured.conditions, level_widths)
    runs = [PlannedRun(conditions, "planned") for conditions in matrix_conditions[is_missing]]
    missing_conditions = matrix_conditions[is_missing]
    missing_conditions = missing_conditions[limits.can_run(missing_conditions)]
    known_conditions = np.concatenate([measured.conditions, missing_conditions])
    if not len(known_conditions):
        return runs + first_runs(levels_to_choose, limits.can_run, level_widths)
    return runs + lacking_runs(known_conditions, levels_to_choose, limits.can_run, level_widths)


def _repeat_runs(
    measured: MeasuredRuns, level_widths: LevelWidths, *, is_ordered: bool
) -> list[PlannedRun]:
    """Repeats of measured conditions.

    Runs in the order of a condition are repeated from the first to the last. Other runs are
    repeated, over the range of their conditions, where fewer are repeats yet.
    """
    conditions = measured.conditions
    different_conditions = distinct_conditions(conditions, level_widths)
    if is_ordered:
        repeat_count = _REPEAT_COUNT
        # in the order in which they were made
        candidates = conditions
    else:
        repeat_count = _REPEAT_COUNT - (len(conditions) - len(different_conditions))
        candidates = different_conditions
    if repeat_count <= 0 or not len(candidates):
        return []
    candidate_index = (
        np.linspace(0, len(candidates) - 1, min(repeat_count, len(candidates))).round().astype(int)
    )
    return [
        PlannedRun(condition, "repeat")
        for condition in distinct_conditions(candidates[candidate_index], level_widths)
    ]


def _in_random_order(
    runs: list[PlannedRun],
    measured_conditions: FloatArray,
    limits: RunLimits,
    level_widths: LevelWidths,
    seed: int,
) -> list[PlannedRun]:
    """The runs in random order, with the reference runs between them."""
    if not runs:
        return []
    sorted_runs = sorted(runs, key=lambda run: tuple(run.conditions))
    reference = PlannedRun(
        _reference_condition(sorted_runs, measured_conditions, limits, level_widths), "reference"
    )
    ordered_runs = []
    order = random_order(_conditions_of(sorted_runs), seed, level_widths)
    for position, run_index in enumerate(order):
        if position % RUNS_BETWEEN_REFERENCES == 0:
            ordered_runs.append(reference)
        ordered_runs.append(sorted_runs[run_index])
    return ordered_runs


def _reference_condition(
    runs: list[PlannedRun],
    measured_conditions: FloatArray,
    limits: RunLimits,
    level_widths: LevelWidths,
) -> FloatArray:
    """The condition of reference runs: of measured ones that nearest to the middle of the box.

    A measured condition joins the new runs to the old ones. Without data it is one of the plan.
    """
    planned_conditions = _conditions_of(runs)
    all_conditions = np.concatenate([measured_conditions, planned_conditions])
    box = ConditionLevels.from_conditions(all_conditions, level_widths)
    runnable_conditions = measured_conditions[limits.can_run(measured_conditions)]
    is_allowed = is_among(
        box.conditions,
        runnable_conditions if len(runnable_conditions) else planned_conditions,
        level_widths,
    )
    return box.nearest(box.middle, is_allowed, np.ones(len(CONDITIONS), dtype=bool))


def run_plan_table(results: CampaignTables, settings: Settings) -> tuple[pd.DataFrame, list[str]]:
    """The table `run_plan` of a campaign, and the reasons why oils have no rows in it."""
    plans = []
    reasons = []
    for oil_name in settings.oils:
        try:
            measured = MeasuredRuns.from_results(results, settings, oil_name)
            plans.append(plan_runs(measured, settings, oil_name).table())
        except OilfilmError as error:
            reasons.append(str(error))
    return stack_tables(plans, "run_plan"), reasons
