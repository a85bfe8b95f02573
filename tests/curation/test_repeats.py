"""Runs that repeat each other: copies, honest repeats and contradictions, however many they are."""

import numpy as np
import pandas as pd
import pytest

import bad_logs
from nights import nightly
from oilfilm.curation.curate import CuratedTables, collect, curate_logs
from oilfilm.settings.resolved import Settings

SLIPS = (0.0, 0.02, 0.03, 0.04, 0.05, 0.06, 0.08, 0.10, 0.12, 0.14, 0.17, 0.20, 0.0)
MEASURED = {
    "slide_roll_ratio": "slide_roll_ratio_se",
    "traction_coefficient": "traction_coefficient_se",
}


@pytest.fixture(scope="module")
def one_run() -> CuratedTables:
    return curate_logs([("run.csv", bad_logs.csv(bad_logs.good(SLIPS)))], bad_logs.CONFIG)


def with_repeats(settings: Settings, repeated_conditions: str) -> Settings:
    return settings.with_changes({"campaign": {"repeated_conditions": repeated_conditions}})


def repeats(one_run: CuratedTables, count: int, seed: int) -> CuratedTables:
    """The condition measured so many times, each time with errors of the stated size."""
    random = np.random.default_rng(seed)
    names = [f"run-{index:04d}.csv" for index in range(count)]
    runs = one_run.runs.loc[[0] * count].reset_index(drop=True)
    runs = runs.assign(run_id=names, file=names, content_sha256=names)
    points = one_run.points
    rows = np.tile(np.arange(len(points)), count)
    points = points.iloc[rows].reset_index(drop=True)
    points = points.assign(run_id=np.repeat(names, len(one_run.points)))
    for name, error in MEASURED.items():
        points[name] += points[error].fillna(0) * random.standard_normal(len(points))
    for name in ("load_n", "entrainment_speed_m_s", "inlet_temperature_c"):
        points[name] *= 1 + 1e-4 * random.uniform(-1, 1, len(points))
    return CuratedTables(points, runs, one_run.quarantine)


def refused_as(curated: CuratedTables, rule: str) -> list[str]:
    return curated.runs.loc[curated.runs["rule"] == rule, "run_id"].tolist()


@pytest.mark.nightly
@pytest.mark.parametrize("seed", range(3))
def test_no_honest_repeat_is_a_copy(one_run: CuratedTables, seed: int) -> None:
    settings = with_repeats(bad_logs.CONFIG, "accept")
    curated = collect(repeats(one_run, 400, seed), settings)
    assert refused_as(curated, "duplicate_log") == []


@pytest.mark.slow
def test_copy_with_another_zero_and_fewer_digits_is_found_among_many_repeats(
    one_run: CuratedTables,
) -> None:
    measured = repeats(one_run, 100, seed=3)
    points = measured.points
    of_copy = points["run_id"] == "run-0070.csv"
    copied = points.loc[points["run_id"] == "run-0020.csv", list(MEASURED)].to_numpy()
    points.loc[of_copy, list(MEASURED)] = copied
    mu = points.loc[of_copy, "traction_coefficient"]
    points.loc[of_copy, "traction_coefficient"] = (mu + 1e-4).round(5)
    curated = collect(measured, with_repeats(bad_logs.CONFIG, "accept"))
    assert refused_as(curated, "duplicate_log") == ["run-0070.csv"]


# a thousand take 14 minutes where each pair is compared alone
@pytest.mark.slow
@pytest.mark.parametrize("count", [200, nightly(1000)])
@pytest.mark.parametrize("repeated_conditions", ["accept", "refuse"])
def test_of_many_repeats_all_or_one_are_accepted(
    one_run: CuratedTables, repeated_conditions: str, count: int
) -> None:
    measured = repeats(one_run, count, seed=4)
    curated = collect(measured, with_repeats(bad_logs.CONFIG, repeated_conditions))
    accepted = curated.runs["verdict"] == "accepted"
    assert accepted.sum() == (count if repeated_conditions == "accept" else 1)


def test_repeats_are_compared_as_one_pair_after_the_other(one_run: CuratedTables) -> None:
    """The stated difference of each refused run is that of the two curves alone."""
    measured = repeats(one_run, 6, seed=5)
    points = measured.points
    points.loc[points["run_id"] == "run-0004.csv", "traction_coefficient"] *= 1.2
    curated = collect(measured, with_repeats(bad_logs.CONFIG, "refuse"))
    assert refused_as(curated, "conflicting_condition") == ["run-0004.csv"]
    assert refused_as(curated, "duplicate_condition") == [
        *("run-0001.csv", "run-0002.csv", "run-0003.csv", "run-0005.csv")
    ]
    curves = {
        run_id: points_of_run[points_of_run["accepted"]].sort_values("slide_roll_ratio")
        for run_id, points_of_run in points.groupby("run_id")
    }
    first, odd = curves["run-0000.csv"], curves["run-0004.csv"]
    apart = min(difference(first, odd), difference(odd, first))
    reason = curated.runs.set_index("run_id").loc["run-0004.csv", "reason"]
    assert f"differs by {apart:.1%}" in reason


def test_runs_of_a_condition_without_a_common_slip_are_both_used() -> None:
    """Low slips in one run and high slips in the other are no repeats of each other."""
    low, high = (0.005, 0.01, 0.02, 0.03, 0.04, 0.05), (0.08, 0.1, 0.15, 0.2, 0.25, 0.3)
    settings = with_repeats(bad_logs.CONFIG, "refuse")
    slips_of_name = {"a.csv": low, "b.csv": high, "c.csv": low, "d.csv": high}
    logs = []
    for seed, (name, slips) in enumerate(slips_of_name.items()):
        values = bad_logs.good((0.0, *slips, 0.0))
        random = np.random.default_rng(seed)
        values["traction_force"] += 0.02 * random.standard_normal(len(values["time"]))
        logs.append((name, bad_logs.csv(values)))
    curated = curate_logs(logs, settings)
    reason_of_run = curated.runs.set_index("run_id")["reason"]
    assert refused_as(curated, "duplicate_condition") == ["c.csv", "d.csv"]
    assert curated.runs["rule"].tolist()[:2] == ["", ""]
    assert "a.csv, which is kept" in reason_of_run["c.csv"]
    assert "b.csv, which is kept" in reason_of_run["d.csv"]


@pytest.mark.parametrize("names", [("1.csv", "2.csv"), ("2.csv", "1.csv")])
def test_repeat_of_few_slips_does_not_contradict_one_of_many(names: tuple[str, str]) -> None:
    """A straight line between a slip of 1 % and one of 30 % is far below the curve."""
    few = bad_logs.csv(bad_logs.good((0.0, 0.01, 0.3, 0.0)))
    many = bad_logs.csv(
        bad_logs.good((0.0, 0.01, 0.02, 0.04, 0.06, 0.08, 0.1, 0.15, 0.2, 0.3, 0.0))
    )
    settings = with_repeats(bad_logs.CONFIG, "refuse")
    curated = curate_logs(sorted(zip(names, (few, many), strict=True)), settings)
    assert curated.runs["rule"].tolist() == ["", "duplicate_condition"]


def log_of(seed: int, oil: str, digits: int = 4) -> bytes:
    """One of several tests of the same condition."""
    values = bad_logs.good(SLIPS)
    random = np.random.default_rng(seed)
    values["traction_force"] += 0.02 * random.standard_normal(len(values["time"]))
    return bad_logs.csv({**values, "load": np.round(values["load"], digits)}, oil=oil)


@pytest.mark.slow
@pytest.mark.parametrize(
    "oil_of_name",
    [
        nightly({"c.csv": "4102", "a.csv": "4102", "b.csv": "4102"}),
        # the samples of one oil come after those of the other
        {"a.csv": "4102", "b.csv": "4050", "c.csv": "4102"},
        # names of files and of folders are sorted in different ways
        nightly({"s-2/a.csv": "4102", "s/b.csv": "4102", "s-2/c.csv": "4102"}),
    ],
)
def test_copy_is_found_in_whatever_order_the_logs_come(oil_of_name: dict[str, str]) -> None:
    names = list(oil_of_name)
    original, _, copy = names
    logs = []
    for name in names:
        seed = 1 if name in (original, copy) else 2
        logs.append((name, log_of(seed, oil_of_name[name], digits=2 if name == copy else 4)))
    settings = with_repeats(bad_logs.CONFIG, "accept")
    in_order = sorted(logs)
    orders = [logs, logs[::-1], in_order, in_order[::-1]]
    # names in alphabetical order have two orders only
    for logs_in_order in orders if logs != in_order else orders[:2]:
        curated = curate_logs(logs_in_order, settings)
        assert refused_as(curated, "duplicate_log") == [max(original, copy)]


@pytest.mark.slow
def test_no_run_is_a_copy_of_a_run_that_is_refused_itself(one_run: CuratedTables) -> None:
    """The middle one of three runs is a copy of both others, which are no copies of each other."""
    measured = repeats(one_run, 3, seed=8)
    points = measured.points
    names = list(MEASURED)
    of_run = [points["run_id"] == f"run-{index:04d}.csv" for index in range(3)]
    first = points.loc[of_run[0], names].to_numpy()
    errors = points.loc[of_run[0], list(MEASURED.values())].to_numpy()
    signs = np.where(np.arange(len(first)) % 2, 1, -1)[:, np.newaxis]
    found = set()
    for size in np.linspace(0.0, 1.0, 6):
        points.loc[of_run[1], names] = first + size * signs * errors
        points.loc[of_run[2], names] = first + 2 * size * signs * errors
        curated = collect(measured, with_repeats(bad_logs.CONFIG, "accept"))
        found.add(tuple(refused_as(curated, "duplicate_log")))
    both, middle = ("run-0001.csv", "run-0002.csv"), ("run-0001.csv",)
    # from three copies of each other to three runs
    assert found == {both, middle, ()}


@pytest.mark.nightly
def test_copy_is_found_among_points_in_whatever_order(one_run: CuratedTables) -> None:
    """Shares of a campaign and its oils come one after the other."""
    measured = repeats(one_run, 6, seed=7)
    points = measured.points
    copied = points.loc[points["run_id"] == "run-0001.csv", list(MEASURED)].to_numpy()
    points.loc[points["run_id"] == "run-0004.csv", list(MEASURED)] = copied + np.array([0.0, 1e-4])
    settings = with_repeats(bad_logs.CONFIG, "accept")
    by_run = [points_of_run for _, points_of_run in points.groupby("run_id")]
    for order in ([0, 1, 2, 3, 4, 5], [4, 2, 0, 5, 1, 3], [5, 4, 3, 2, 1, 0]):
        in_order = pd.concat([by_run[index] for index in order], ignore_index=True)
        curated = collect(CuratedTables(in_order, measured.runs, measured.quarantine), settings)
        assert refused_as(curated, "duplicate_log") == ["run-0004.csv"]


def difference(first: pd.DataFrame, later: pd.DataFrame) -> float:
    """Median relative difference of two curves beyond two standard errors, point by point."""
    differences = []
    for _, point in later.iterrows():
        slip = point["slide_roll_ratio"]
        slips = first["slide_roll_ratio"]
        # the slips of a level scatter
        smallest = max(slips.min() / 1.02, bad_logs.CONFIG.gates.sign_slip_min)
        if not smallest <= slip <= 1.02 * slips.max():
            continue
        mu = np.interp(slip, slips, first["traction_coefficient"])
        error = np.interp(slip, slips, first["traction_coefficient_se"])
        errors = 2 * np.hypot(error, point["traction_coefficient_se"])
        excess = max(abs(point["traction_coefficient"] - mu) - errors, 0)
        differences.append(2 * excess / (abs(point["traction_coefficient"]) + abs(mu)))
    return float(np.median(differences))
