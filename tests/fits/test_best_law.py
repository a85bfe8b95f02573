"""The best law is named by two criteria, with the uncertainty of their differences."""

from typing import Any

import numpy as np
import pandas as pd
import pytest

from law_points import compare_laws, points_of
from oilfilm import tables
from oilfilm.fits.best_law import best_laws
from oilfilm.fits.fit import fit_oil
from oilfilm.fits.fit_tables import bayesian_criterion
from oilfilm.fits.soundness import noise_and_misfit
from oilfilm.randomness import generator
from oilfilm.settings.resolved import Settings
from oilfilm.traction import LAWS
from reports import rows

NOISE = 2e-4


def verdict_of(points: pd.DataFrame, config: Settings, law: str) -> dict[str, Any]:
    configured = config.with_changes({"fit": {"law": law}})
    compared = compare_laws(points, "4050", ["deng2026", "tanh", "carreau"], configured)
    judged = best_laws(compared.fit_quality, compared.law_points, points)
    (row,) = tables.rows(judged)
    return row


def test_the_law_that_made_the_points_is_named_beside_another_configured_one(
    quick: Settings,
) -> None:
    points = points_of(LAWS["tanh"], NOISE)
    row = verdict_of(points, quick, "carreau")
    assert row["verdict"] == "another law is better"
    assert row["better_law"] == row["bic_law"] == row["left_out_law"] == "tanh"
    assert row["left_out_difference"] > row["left_out_difference_error"] > 0
    own = verdict_of(points, quick, "tanh")
    assert (own["verdict"], own["better_law"]) == ("best", "")


def compared(squares: dict[str, np.ndarray], constants: dict[str, int]) -> tuple[pd.DataFrame, ...]:
    """A comparison of laws with given squared errors of curves of one point each."""
    names = [f"run{number}" for number in range(len(next(iter(squares.values()))))]
    points = pd.DataFrame({"run_id": names, "first_row": 0, "traction_coefficient": 1.0})
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
        beside.append(
            pd.DataFrame({"oil": "own", "law": law, "run_id": names, "first_row": 0} | both)
        )
    return rows("fit_quality", *about), pd.concat(beside), points


def test_difference_within_the_scatter_of_curves_is_a_tie_and_a_larger_one_is_not() -> None:
    random = generator(2, "ties", "curves")
    base = random.chisquare(1, 60)
    scattered = base * np.exp(0.3 * random.standard_normal(60))
    better = 0.5 * base
    constants = {"deng2026": 3, "tanh": 3, "eyring": 3}
    (tie,) = tables.rows(best_laws(*compared({"deng2026": base, "tanh": scattered}, constants)))
    assert tie["verdict"] == "tie"
    (beaten,) = tables.rows(
        best_laws(*compared({"deng2026": base, "tanh": scattered, "eyring": better}, constants))
    )
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
        (
            30,
            {"deng2026": (1.0, 2), "tanh": (0.9, 40)},
            ("tanh", "deng2026", "criteria disagree", ""),
        ),
        # BIC by hand: 71.4 of deng2026, 128.7 of tanh, 9.9 of eyring
        (
            30,
            {"deng2026": (1.0, 20), "tanh": (0.7, 40), "eyring": (0.99, 2)},
            ("tanh", "eyring", "another law is better", "tanh"),
        ),
        (9, {"deng2026": (1.0, 3)}, ("", "", "no other law", "")),
        (2, {"deng2026": (1.0, 2), "tanh": (0.5, 2)}, ("", "", "too few curves", "")),
    ],
)
def test_verdict_on_the_first_law_is_that_of_both_criteria(
    curves: int, laws: dict[str, tuple[float, int]], expected: tuple[str, ...]
) -> None:
    """Each law has the same squared error at every curve, and a number of constants."""
    squares = {law: np.full(curves, square) for law, (square, _) in laws.items()}
    frames = compared(squares, {law: constants for law, (_, constants) in laws.items()})
    (row,) = tables.rows(best_laws(*frames))
    assert tuple(row[name] for name in ("left_out_law", "bic_law", "verdict", "better_law")) == (
        expected
    )


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
    (row,) = tables.rows(noise_and_misfit(fit.replace(points=points, runs=made), config))
    return row, float(np.sqrt(np.mean(error**2) / np.mean(points["traction_coefficient"] ** 2)))


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


def test_runs_without_set_points_are_repeats_where_they_were_measured_alike(
    quick: Settings,
) -> None:
    row, _ = misfit_of(quick, 1, "tanh", stated=False)
    assert (row["n_repeats"], row["n_repeated_conditions"]) == (1, 1)


def test_without_repeats_it_says_that_noise_is_not_known(quick: Settings) -> None:
    row, _ = misfit_of(quick, 0, "tanh")
    assert row["verdict"] == "no repeats"
