"""Laws compared: the true one wins by two criteria, curves left out are those of brute force."""

from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd
import pytest

from campaigns import needs_study
from fit_points import polished
from law_points import EVERY_LAW, MATRIX, PLAUSIBLE_CONSTANTS, compare_laws, internal_of, points_of
from nights import nightly
from oilfilm import tables
from oilfilm.base.randomness import generator
from oilfilm.fits import global_search
from oilfilm.fits.best_law import _error_of_fit, best_laws
from oilfilm.fits.conditions import level_numbers_by_gap
from oilfilm.fits.fit import (
    errors_at_curves_left_out,
    errors_at_ends_left_out,
    fit_oil,
    laws_of_oil,
)
from oilfilm.fits.fit_tables import bayesian_criterion
from oilfilm.fits.soundness import lack_of_fit_table
from oilfilm.report.figures.fits import mu_at_zero_slip
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.tables.table_needs import FIT_TABLES
from oilfilm.traction import LAW_NAMES, LAWS
from oilfilm.traction.law import Observations
from pictures import draw
from reports import rows

NOISE = 2e-4


@pytest.mark.no_cover
@pytest.mark.nightly
@pytest.mark.parametrize("name", ["deng2026", "eyring", "wang-deng-groups", "tanh"])
def test_law_given_data_of_its_own_truth_wins(quick: Settings, name: str) -> None:
    laws = ["deng2026", "wang-deng-groups", "eyring", "tanh"]
    frames = compare_laws(points_of(EVERY_LAW[name], NOISE), "4050", laws, quick)
    table = frames.fit_quality.set_index("law")
    assert table["left_out_rmse"].idxmin() == name
    assert table["bic"].idxmin() == name
    assert table["temperature_end_out_relative_rms"].idxmin() == name
    # what is left of the errors is the noise
    assert table.at[name, "rmse"] == pytest.approx(NOISE, rel=0.05)
    assert table["n_points"].nunique() == 1


@pytest.mark.slow
@pytest.mark.parametrize(
    ("count", "step"),
    [(2, 16), *(nightly(*case) for case in ((1, 1), (1, 16), (2, 1), (3, 1), (3, 16)))],
)
def test_few_curves_are_compared_without_a_mistake(quick: Settings, count: int, step: int) -> None:
    """Neighbouring and distant conditions: some laws then have constants without any effect."""
    runs = [f"run{step * number:03d}" for number in range(count)]
    points = points_of(EVERY_LAW["deng2026"], NOISE)
    frames = compare_laws(points[points["run_id"].isin(runs)], "4050", LAW_NAMES, quick)
    assert frames.fit_quality["n_points"].eq(len(points) * count // 48).all()


@pytest.mark.parametrize("groups", [100, 5])
def test_curves_left_out_are_those_of_brute_force(quick: Settings, groups: int) -> None:
    """One at a time, and in groups of three or four."""
    settings = quick.fit.model_copy(update={"left_out_groups": groups})
    law = LAWS["tanh"]
    points = points_of(law, 1e-3)
    few = points[points["run_id"].isin([f"run{number:03d}" for number in range(0, 48, 3)])]
    task, best = polished(few, PLAUSIBLE_CONSTANTS[law.name], law)
    errors = errors_at_curves_left_out(task, best, settings, np.random.default_rng(1))
    group = np.arange(task.curve_count)
    if groups < task.curve_count:
        group = np.random.default_rng(1).permutation(group) % groups
    for each in np.unique(group):
        mine = (group == each)[task.observations.curve_of_point]
        rows = np.flatnonzero(group != each)
        others = replace(
            task,
            observations=Observations(
                task.observations.design[rows],
                np.searchsorted(rows, task.observations.curve_of_point[~mine]),
                task.observations.slip[~mine],
            ),
            mu=task.mu[~mine],
        )
        end = global_search.converge(others, best.constants)
        expected = task.residual(end.constants)[mine]
        np.testing.assert_allclose(errors[mine], expected, rtol=1e-3, atol=1e-8)


def test_only_the_end_levels_are_extrapolated_to(quick: Settings) -> None:
    points = points_of(LAWS["deng2026"])
    task, best = polished(points, PLAUSIBLE_CONSTANTS["deng2026"])
    levels = level_numbers_by_gap(MATRIX["inlet_temperature_c"].to_numpy(), 0.05)
    errors = errors_at_ends_left_out(task, best, levels, quick.fit)
    ends = np.isin(levels[task.observations.curve_of_point], [0, 3])
    assert np.isnan(errors[~ends]).all()
    # exact points of the law itself: nothing is missed, however far
    assert np.abs(errors[ends]).max() < 1e-7


@pytest.mark.parametrize("scatter", [0.0, 1e-3])
def test_one_level_left_leaves_a_constant_open_however_it_scatters(
    quick: Settings, scatter: float
) -> None:
    """Of two levels, and of one: what a rig measures at one level gives no exponent."""
    law = LAWS["deng2026"]
    points = points_of(law)
    two = points["max_hertz_pressure_gpa"].isin([1.0, 1.5])
    of_run = points["run_id"].map(lambda run: generator(1, run).standard_normal())
    points["max_hertz_pressure_gpa"] *= 1 + scatter * of_run
    task, best = polished(points[two], PLAUSIBLE_CONSTANTS[law.name])
    pressures = task.data.conditions[:, 0]
    for levels in (
        level_numbers_by_gap(pressures, 0.05),
        np.zeros(task.curve_count, dtype=np.int64),
    ):
        assert np.isnan(errors_at_ends_left_out(task, best, levels, quick.fit)).all()


def test_law_without_what_it_needs_is_not_fitted_with_the_reason(quick: Settings) -> None:
    config = Settings.from_plain_values({**quick.plain_values(), "oils": {"4050": None}})
    laws = ["tanh", "wang-deng-groups"]
    frames = compare_laws(points_of(LAWS["tanh"], NOISE), "4050", laws, config)
    row = frames.fit_quality.set_index("law").loc["wang-deng-groups"]
    assert row["no_fit"] == "properties unknown"
    assert np.isnan(row["rmse"])
    assert set(frames.coefficients["law"]) == {"tanh"}
    assert "wang-deng-groups" not in laws_of_oil("4050", config)


def test_comparison_without_any_accepted_point_still_gives_its_tables(quick: Settings) -> None:
    refused = points_of(LAWS["tanh"]).assign(accepted=False)
    frames = compare_laws(refused, "4050", LAW_NAMES, quick)
    obstacles = frames.fit_quality.set_index("law")["no_fit"]
    assert (obstacles != "").all()
    # a law that needs a condition to vary has no points either
    assert obstacles[["deng2026", "wang-deng-critical-load"]].tolist() == ["no points"] * 2
    for name in FIT_TABLES:
        tables.conform(frames.table(name), name, name)
    figure, drawn = draw("law-errors", frames, quick)
    assert drawn.empty
    assert "no law could" in figure.axes[0].texts[0].get_text()


@pytest.fixture(scope="module")
def starting(quick: Settings) -> CampaignTables:
    """Points of a Wang-Deng law with traction at no slip; every other curve slips backwards."""
    points = points_of(STARTS, NOISE)
    back = points["run_id"].isin(sorted(points["run_id"].unique())[::2])
    both = ["slide_roll_ratio", "traction_coefficient"]
    # at no slip there is no direction
    points.loc[back & (points["slide_roll_ratio"] > 0), both] *= -1
    return compare_laws(points, "4050", ["deng2026", STARTS.name], quick)


STARTS = LAWS["wang-deng-load"]


@pytest.mark.slow
def test_figure_of_errors_draws_the_table(quick: Settings, starting: CampaignTables) -> None:
    figure, drawn = draw("law-errors", starting, quick)
    ticks = [label.get_text() for label in figure.axes[0].get_yticklabels()]
    assert "load-based Wang-Deng" in ticks  # by its name, as everywhere
    errors = drawn[(drawn["words"] == "deng2026") & (drawn["series"] == "fitted curves")]
    row = starting.fit_quality.set_index("law").loc["deng2026"]
    assert errors["x"].item() == pytest.approx(row["relative_rms"])


@pytest.mark.slow
def test_traction_without_slip_is_planted(quick: Settings, starting: CampaignTables) -> None:
    starts = mu_at_zero_slip(starting, "4050", STARTS.name, quick)["y"]
    # mu(0) = D - |A| of each condition
    design = STARTS.design(MATRIX[list(STARTS.conditions)].to_numpy())
    magnitudes = STARTS.magnitudes(internal_of(STARTS), design)
    np.testing.assert_allclose(
        np.sort(starts), np.sort(magnitudes[3] - magnitudes[0]), atol=3 * NOISE
    )


@needs_study
def test_fig04_shows_the_largest_growth(quick: Settings, starting: CampaignTables) -> None:
    _, drawn = draw("fig04", starting, quick)
    beside = starting.law_points[starting.law_points["law"] == STARTS.name]
    both = beside.merge(starting.points, on=["run_id", "first_row"], suffixes=("", "_m"))
    of_run = both.set_index("run_id")
    squares = [
        (of_run[f"{left}traction_coefficient"] - of_run["traction_coefficient_m"]) ** 2
        for left in ("left_out_", "")
    ]
    unseen, seen = (np.sqrt(each.groupby("run_id").mean()) for each in squares)
    shown = drawn.loc[drawn["panel"] == "b", "words"]
    assert set(shown.str.rpartition("run ")[2]) == {(unseen - seen).idxmax()}


def test_points_beside_a_law_keep_their_direction(starting: CampaignTables) -> None:
    point = ["run_id", "first_row"]
    both = starting.law_points.merge(starting.points, on=point, suffixes=("", "_m"))
    assert len(both) == 2 * len(starting.points)
    true = both[both["law"] == STARTS.name]
    for column in ("traction_coefficient", "left_out_traction_coefficient"):
        np.testing.assert_allclose(true[column], true["traction_coefficient_m"], atol=6 * NOISE)


@pytest.fixture(scope="module")
def made_by_tanh(quick: Settings) -> CampaignTables:
    """Laws fitted to points of one of them, while another one is configured."""
    laws = ["deng2026", "tanh", "eyring", "carreau"]
    configured = quick.with_changes({"fit": {"law": "carreau"}})
    return compare_laws(points_of(LAWS["tanh"], NOISE), "4050", laws, configured)


@pytest.mark.slow
def test_bounds_of_the_comparison_are_those_of_the_constants(made_by_tanh: CampaignTables) -> None:
    frames = made_by_tanh
    constants = frames.coefficients
    held = constants[constants["verdict"] == "at a bound"].groupby("law")["constant"].apply(set)
    for row in tables.rows(frames.fit_quality):
        names = set(row["active_bounds"])
        assert names == held.get(row["law"], set())
        assert not (names and row["certified"])
    assert len(held)


# R. E. Kass, A. E. Raftery, J. Am. Stat. Assoc. 90 (1995) 773: less is a bare mention.
BIC_DIFFERENCE_MIN = 2.0


@pytest.mark.slow
def test_law_that_made_the_points_is_named_beside_another_configured_one(
    made_by_tanh: CampaignTables,
) -> None:
    (row,) = tables.rows(best_laws(made_by_tanh, BIC_DIFFERENCE_MIN))
    assert row["verdict"] == "another law is better"
    assert row["better_law"] == row["bic_law"] == row["left_out_law"] == "tanh"
    assert row["left_out_difference"] > row["left_out_difference_error"] > 0
    quality = made_by_tanh.fit_quality
    quality = quality.assign(configured=quality["law"] == "tanh")
    (own,) = tables.rows(best_laws(made_by_tanh.replace(fit_quality=quality), BIC_DIFFERENCE_MIN))
    assert (own["verdict"], own["better_law"]) == ("best", "")


def compared(squares: dict[str, np.ndarray], constants: dict[str, int]) -> CampaignTables:
    """A comparison of laws with given squared errors of curves of one point each."""
    names = [f"run{number}" for number in range(len(next(iter(squares.values()))))]
    at = {"oil": "own", "run_id": names, "first_row": 0}
    about, beside = [], []
    for law, errors in squares.items():
        sse = float(errors.sum())
        bic = bayesian_criterion(sse, len(names), constants[law])
        quality = {"oil": "own", "law": law, "n_points": len(names), "bic": bic}
        quality |= {"n_constants": constants[law], "left_out_rmse": np.sqrt(sse / len(names))}
        quality |= {"configured": law == next(iter(squares)), "certified": True}
        about.append(quality | {"relative_rms": np.sqrt(sse / len(names))})
        mu = 1 + np.sqrt(errors)
        both = dict.fromkeys(("traction_coefficient", "left_out_traction_coefficient"), mu)
        beside.append(pd.DataFrame(at | {"law": law} | both))
    return CampaignTables.from_frames(
        fit_quality=rows("fit_quality", *about),
        law_points=pd.concat(beside),
        points=pd.DataFrame(at | {"traction_coefficient": 1.0}),
    )


def test_difference_within_the_scatter_of_curves_is_a_tie_and_a_larger_one_is_not() -> None:
    random = generator(2, "ties", "curves")
    base = random.chisquare(1, 60)
    scattered = base * np.exp(0.3 * random.standard_normal(60))
    better = 0.5 * base
    constants = {"deng2026": 3, "tanh": 3, "eyring": 3}
    laws_compared = compared({"deng2026": base, "tanh": scattered}, constants)
    (tie,) = tables.rows(best_laws(laws_compared, BIC_DIFFERENCE_MIN))
    assert tie["verdict"] == "tie"
    laws_compared = compared({"deng2026": base, "tanh": scattered, "eyring": better}, constants)
    (beaten,) = tables.rows(best_laws(laws_compared, BIC_DIFFERENCE_MIN))
    assert (beaten["verdict"], beaten["better_law"]) == ("another law is better", "eyring")
    # half the squares everywhere: n ln 2
    assert beaten["bic_difference"] == pytest.approx(60 * np.log(2))
    # by hand, the same for each curve: sqrt(mean) falls by 1 - sqrt(1/2)
    falls = (1 - np.sqrt(0.5)) * np.sqrt(base.mean())
    assert beaten["left_out_difference"] == pytest.approx(falls)


@pytest.mark.parametrize(
    ("curves", "laws", "expected"),
    [
        # less error, but 38 constants more
        (30, {"deng2026": (1.0, 2), "tanh": (0.9, 40)}, "tanh|deng2026|criteria disagree|"),
        # BIC by hand: 71.4 of deng2026, 128.7 of tanh, 9.9 of eyring, or 10.5 with more error
        (
            30,
            {"deng2026": (1.0, 20), "tanh": (0.7, 40), "eyring": (0.99, 2)},
            "tanh|eyring|another law is better|eyring",
        ),
        # tanh is worse than deng2026 by BIC, eyring by the curves left out
        (
            30,
            {"deng2026": (1.0, 20), "tanh": (0.7, 40), "eyring": (1.01, 2)},
            "tanh|eyring|criteria disagree|",
        ),
        (9, {"deng2026": (1.0, 3)}, "||no other law|"),
        (2, {"deng2026": (1.0, 2), "tanh": (0.5, 2)}, "||too few curves|"),
    ],
)
def test_verdict_on_the_first_law_is_that_of_both_criteria(
    curves: int, laws: dict[str, tuple[float, int]], expected: str
) -> None:
    """Each law has the same squared error at every curve, and a number of constants."""
    squares = {law: np.full(curves, square) for law, (square, _) in laws.items()}
    laws_compared = compared(squares, {law: constants for law, (_, constants) in laws.items()})
    (row,) = tables.rows(best_laws(laws_compared, BIC_DIFFERENCE_MIN))
    names = ("left_out_law", "bic_law", "verdict", "better_law")
    assert "|".join(row[name] for name in names) == expected


def test_a_law_beside_fits_to_other_curves_alone_is_not_called_the_best() -> None:
    squares = {"deng2026": np.full(30, 1.0), "tanh": np.full(30, 0.1)}
    laws_compared = compared(squares, {"deng2026": 3, "tanh": 3})
    # tanh lacks a curve: its sums of squares are of other points
    incomplete_curves = pd.Series([(), ("run0",)])
    quality = laws_compared.fit_quality.assign(incomplete_curves=incomplete_curves)
    (row,) = tables.rows(best_laws(laws_compared.replace(fit_quality=quality), BIC_DIFFERENCE_MIN))
    assert (row["verdict"], row["better_law"]) == ("no other fit", "")


# ---------------------------------------------------------------- laws that are one law


def lines(bend: float) -> tuple[CampaignTables, float]:
    """Fits to 40 curves: a line, the line with a constant that means nothing, and a parabola.

    Args:
        bend: Size of the parabola in the truth.

    Returns:
        `fit_quality`, `law_points` and `points`; and the jackknife error of the line's mu, from 40
        refits at all points, root-mean-square.
    """
    random = generator(4, "one law")
    x = np.tile(np.linspace(-1, 1, 5), 40)
    curve = np.repeat(np.arange(40), 5)
    of_curve, run_gain = random.standard_normal((2, 40))[:, curve]
    noise = random.standard_normal(len(x))
    mu = 1 + 0.2 * x + bend * x**2 + 0.02 * run_gain + 0.01 * noise
    at = {"oil": "own", "run_id": np.char.add("run", curve.astype(str)), "first_row": x}
    designs = {
        "deng2026": np.column_stack([x**0, x]),
        "tanh": np.column_stack([x**0, x, of_curve]),
        "eyring": np.column_stack([x**0, x, x**2]),
    }
    quality, beside, errors = [], [], []
    for law, design in designs.items():
        whole = design @ np.linalg.lstsq(design, mu, rcond=None)[0]
        refits = []
        for left_out in range(40):
            kept = curve != left_out
            refits.append(design @ np.linalg.lstsq(design[kept], mu[kept], rcond=None)[0])
        unseen = np.array(refits)[curve, np.arange(len(x))]
        errors.append(np.sqrt(np.mean(np.sum((np.array(refits) - whole) ** 2, axis=0))))
        sse = float(np.sum((whole - mu) ** 2))
        count = design.shape[1]
        row = {"oil": "own", "law": law, "n_points": len(x), "n_constants": count}
        row |= {"bic": bayesian_criterion(sse, len(x), count), "configured": law == "deng2026"}
        row |= {"left_out_rmse": np.sqrt(np.mean((unseen - mu) ** 2)), "certified": True}
        quality.append(row)
        of_law = {"traction_coefficient": whole, "left_out_traction_coefficient": unseen}
        beside.append(pd.DataFrame(at | {"law": law} | of_law))
    results = CampaignTables.from_frames(
        fit_quality=rows("fit_quality", *quality),
        law_points=pd.concat(beside),
        points=pd.DataFrame(at | {"traction_coefficient": mu}),
    )
    return results, errors[0]


def test_a_law_that_was_fitted_to_other_runs_is_not_compared() -> None:
    """A law of the load lacks a run without a load, one of the pressure a run without that."""
    squares = {"deng2026": np.full(9, 1.0), "tanh": np.full(9, 2.0), "wang-deng-load": np.ones(9)}
    results = compared(squares, dict.fromkeys(squares, 3))
    lacking = {"deng2026": ("run8",), "tanh": ("run8",), "wang-deng-load": ("run7",)}
    quality = results.fit_quality
    law_points = results.table("law_points")
    is_lacking = [
        run_id in lacking[law]
        for law, run_id in zip(law_points["law"], law_points["run_id"], strict=True)
    ]
    results = results.replace(
        fit_quality=quality.assign(incomplete_curves=quality["law"].map(lacking), n_points=8),
        law_points=law_points[~np.array(is_lacking)],
    )
    (row,) = tables.rows(best_laws(results, BIC_DIFFERENCE_MIN))
    assert (row["verdict"], row["left_out_law"], row["bic_law"]) == ("best", "deng2026", "deng2026")


def test_error_of_a_fit_is_that_of_refits_without_each_curve() -> None:
    results, expected = lines(bend=0.01)
    law_points = results.law_points
    measured = results.points[["run_id", "first_row", "traction_coefficient"]]
    of_law = law_points[law_points["law"] == "deng2026"]
    compared = of_law.merge(measured, on=["run_id", "first_row"], suffixes=("", "_measured"))
    assert _error_of_fit(compared) == pytest.approx(expected, rel=1e-9)


def test_law_whose_further_constant_means_nothing_counts_as_one_with_the_plain_one() -> None:
    results, _ = lines(bend=0.0)
    (row,) = tables.rows(best_laws(results, BIC_DIFFERENCE_MIN))
    assert (row["verdict"], row["same_laws"]) == ("best", ("tanh", "eyring"))
    assert row["left_out_ties"] == row["bic_ties"] == ("deng2026",)


def test_law_that_is_better_is_not_the_same_and_its_equals_are_named() -> None:
    results, _ = lines(bend=0.05)
    quality, law_points = results.fit_quality, results.law_points
    (row,) = tables.rows(best_laws(results, BIC_DIFFERENCE_MIN))
    assert (row["verdict"], row["better_law"]) == ("another law is better", "eyring")
    assert (row["same_laws"], row["same_as_better_law"]) == (("tanh",), ())
    # the better law once more, with another constant: no competitor of the first one
    again = quality[quality["law"] == "eyring"].assign(law="carreau", n_constants=4, bic=0.0)
    copied = law_points[law_points["law"] == "eyring"].assign(law="carreau")
    results = results.replace(
        fit_quality=pd.concat([quality, again]), law_points=pd.concat([law_points, copied])
    )
    (row,) = tables.rows(best_laws(results, BIC_DIFFERENCE_MIN))
    assert (row["better_law"], row["same_as_better_law"]) == ("eyring", ("carreau",))
    assert row["left_out_ties"] == ("eyring",)


@pytest.mark.slow
def test_load_and_pressure_are_one_law_on_the_points_of_one_ball(quick: Settings) -> None:
    points = points_of(LAWS["deng2026"], NOISE)
    compared = compare_laws(points, "4050", ["deng2026", "wang-deng-load", "tanh"], quick)
    (row,) = tables.rows(best_laws(compared, BIC_DIFFERENCE_MIN))
    assert (row["verdict"], row["same_laws"]) == ("best", ("wang-deng-load",))


def misfit_of(
    config: Settings, repeats: int, law: str, stated: bool = True
) -> tuple[dict[str, Any], float]:
    """The row of `lack_of_fit` of points of deng2026, some conditions run twice, and the noise.

    The noise, relative to mu, is the one planted: errors of whole runs and of points. Where no
    set points are stated, the loads of the repeats are off by less than the gates allow.
    """
    once = points_of(LAWS["deng2026"])
    names = once["run_id"].unique()[::6][:repeats]
    again = once[once["run_id"].isin(names)]
    again = again.assign(run_id=again["run_id"] + " again", load_n=again["load_n"] * 1.01)
    points = pd.concat([once, again], ignore_index=True)
    random = generator(8, "repeats", str(repeats))
    runs = points.drop_duplicates("run_id")
    gain = dict(zip(runs["run_id"], 0.01 * random.standard_normal(len(runs)), strict=True))
    mu = points["traction_coefficient"].to_numpy()
    error = mu * points["run_id"].map(gain) + NOISE * random.standard_normal(len(points))
    points["traction_coefficient"] = mu + error
    points["traction_coefficient_se"] = NOISE
    fit = fit_oil(points, "4050", config.fit, config.seed, law=LAWS[law])
    about = {"oil": "4050", "rig": next(iter(config.rigs)), "verdict": "accepted"}
    made = rows("runs", *(about | {"run_id": name} for name in runs["run_id"]))
    for column in ("max_hertz_pressure_gpa", "entrainment_speed_m_s", "inlet_temperature_c"):
        made[f"nominal_{column}"] = runs[column].to_numpy() if stated else np.nan
    (row,) = tables.rows(lack_of_fit_table(fit.replace(points=points, runs=made), config))
    return row, float(np.sqrt(np.mean(error**2) / np.mean(points["traction_coefficient"] ** 2)))


@pytest.mark.slow
def test_wrong_law_is_told_from_planted_noise_by_repeats(quick: Settings) -> None:
    right, noise = misfit_of(quick, 8, "deng2026")
    wrong, _ = misfit_of(quick, 8, "tanh")
    assert right["n_repeats"] == wrong["n_repeats"] == 8
    # eight runs give a standard deviation to a quarter
    assert right["repeat_relative_rms"] == pytest.approx(noise, rel=0.5)
    assert (right["verdict"], wrong["verdict"]) == ("not shown", "shown")
    # the squares add up to those of the residuals
    parts = wrong["repeat_relative_rms"] ** 2 + wrong["lack_of_fit_relative_rms"] ** 2
    assert np.sqrt(parts) == pytest.approx(wrong["relative_rms"], rel=0.02)
    assert right["lack_of_fit_relative_rms"] < 0.5 * wrong["lack_of_fit_relative_rms"]
    assert right["plateau_relative_rms"] < right["repeat_relative_rms"]


def test_runs_without_set_points_are_repeats_where_measured_alike(quick: Settings) -> None:
    row, _ = misfit_of(quick, 1, "tanh", stated=False)
    assert (row["n_repeats"], row["n_repeated_conditions"]) == (1, 1)


def test_without_repeats_it_says_that_noise_is_not_known(quick: Settings) -> None:
    row, _ = misfit_of(quick, 0, "tanh")
    assert row["verdict"] == "no repeats"
