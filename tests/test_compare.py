"""Fits side by side: a planted ratio comes back, whichever fit is named first."""

import re
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import oilfilm
from known_laws import known_law
from oilfilm import tables
from oilfilm.base.errors import OilfilmError
from oilfilm.cli import compare, main
from oilfilm.cli.compare import read_fits
from oilfilm.cli.compare_plot import comparison_figure
from oilfilm.fits.fitted import SLIP
from oilfilm.fits.oil_pairs import oil_pair, read_oil
from oilfilm.fits.side_by_side import (
    MU_COLUMNS,
    RATIO_COLUMNS,
    comparison_conditions,
    comparison_table,
)
from oilfilm.surface.support import Support
from oilfilm.traction.law import CONDITIONS
from pictures import nothing_is_cut_off

NAMES = [*CONDITIONS, "slide_roll_ratio"]
AT = {NAMES[0]: 1.25, NAMES[1]: 30.0, NAMES[2]: 80.0}
RATIO = 1.2


def table(factor: float) -> pd.DataFrame:
    """Points on the printed law of 4102 times a factor, with errors of 0.5 % per curve."""
    slip = np.linspace(0.01, 0.3, 6)
    levels = np.meshgrid([1.0, 1.25, 1.5], [25, 40], [50, 80, 120], slip)
    points = pd.DataFrame({name: level.ravel() for name, level in zip(NAMES, levels, strict=True)})
    printed_law = known_law("4102")
    mu = printed_law.predict_at(*(points[name] for name in NAMES)).traction_coefficient
    curve_of_point = points.groupby(NAMES[:3]).ngroup().to_numpy()
    factor_of_curve = 1 + 0.005 * np.random.default_rng(int(100 * factor)).standard_normal(
        curve_of_point.max() + 1
    )
    return points.assign(
        traction_coefficient=factor * mu * factor_of_curve[curve_of_point], curve=curve_of_point
    )


@pytest.fixture(scope="module")
def folders(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    fit_folders = [tmp_path_factory.mktemp("compare") / name for name in ("june", "july")]
    for folder, factor in zip(fit_folders, (1.0, RATIO), strict=True):
        oilfilm.fit_table(table(factor), oil="oil", searches=2, bootstrap=40).save(folder)
    return fit_folders


@pytest.mark.slow
def test_planted_ratio_is_inside_the_interval_of_two_laws(folders: list[Path]) -> None:
    law_by_name = {folder.name: oilfilm.read_fit(folder, "oil") for folder in folders}
    july_to_june = comparison_table(law_by_name, AT, [0.02, 0.05, 0.2]).iloc[3:]
    assert (july_to_june["ratio_lower"] < RATIO).all() and (
        july_to_june["ratio_upper"] > RATIO
    ).all()
    june_to_july = comparison_table(
        dict(reversed(law_by_name.items())), AT, [0.02, 0.05, 0.2]
    ).iloc[3:]
    # the reciprocal, with its ends exchanged
    np.testing.assert_allclose(june_to_july["ratio"], 1 / july_to_june["ratio"], rtol=1e-12)
    np.testing.assert_allclose(
        june_to_july["ratio_lower"], 1 / july_to_june["ratio_upper"], rtol=1e-12
    )


@pytest.mark.slow
def test_ratio_at_negative_slip_is_that_at_positive_slip(folders: list[Path]) -> None:
    law_by_name = {folder.name: oilfilm.read_fit(folder, "oil") for folder in folders}
    columns = ["ratio", "ratio_lower", "ratio_upper"]
    forwards, backwards = (
        comparison_table(law_by_name, AT, [slip]).loc[1, columns].to_numpy(float)
        for slip in (0.05, -0.05)
    )
    assert np.isfinite(forwards).all()
    np.testing.assert_array_equal(backwards, forwards)


def test_fit_beside_itself_has_the_ratio_one(folders: list[Path]) -> None:
    fit = oilfilm.read_fit(folders[0], "oil")
    comparison = comparison_table({"a": fit, "b": fit}, AT, [0.1])
    assert comparison["ratio"].tolist() == [1, 1]
    # that the second one is the same fit is not known
    assert comparison.loc[0, ["ratio_lower", "ratio_upper"]].tolist() == [1, 1]
    assert comparison.loc[1, "ratio_lower"] < 1 < comparison.loc[1, "ratio_upper"]


def test_fits_of_one_temperature_below_zero_are_compared_there(folders: list[Path]) -> None:
    fit = oilfilm.read_fit(folders[0], "oil")
    box = fit.coefficients.tested_box.copy()
    box[list(fit.law.conditions).index("inlet_temperature_c")] = -10.0
    cold = replace(fit, coefficients=replace(fit.coefficients, tested_box=box))
    assert comparison_conditions({"a": cold, "b": cold}, {})["inlet_temperature_c"] == -10.0


def test_fits_are_compared_within_a_narrow_range_that_both_tested(folders: list[Path]) -> None:
    fit = oilfilm.read_fit(folders[0], "oil")
    fits = {}
    for name, tested_range in {"a": (1.0, 1.2006), "b": (1.2004, 1.5)}.items():
        box = fit.coefficients.tested_box.copy()
        box[0] = tested_range
        fits[name] = replace(fit, coefficients=replace(fit.coefficients, tested_box=box))
    pressure = comparison_conditions(fits, {})["max_hertz_pressure_gpa"]
    # three digits would be 1.2, which b was not tested at
    assert 1.2004 <= pressure <= 1.2006


def test_a_condition_that_no_run_of_one_fit_states_is_named_in_either_order(
    folders: list[Path],
) -> None:
    fit = oilfilm.read_fit(folders[0], "oil")
    box = fit.coefficients.tested_box.copy()
    box[0] = np.nan
    unknown = replace(fit, coefficients=replace(fit.coefficients, tested_box=box))
    reason = "max_hertz_pressure_gpa is not known of the runs of unknown"
    with pytest.raises(OilfilmError, match=reason):
        comparison_conditions({"known": fit, "unknown": unknown}, {})
    with pytest.raises(OilfilmError, match=reason):
        comparison_conditions({"unknown": unknown, "known": fit}, {})


@pytest.mark.slow
def test_command_names_campaigns_and_marks_what_was_not_tested(
    folders: list[Path], capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    picture = tmp_path / "mu.png"
    words = ["compare", *map(str, folders)]
    assert main([*words, "--slip", "5%", "--plot", str(picture)]) == 0
    text = capsys.readouterr().out
    (ratio,) = re.findall(r"(?m)^ *0\.05 +([\d.]+) \([\d.]+ to [\d.]+\) higher$", text)
    assert float(ratio) == pytest.approx(RATIO, rel=0.02)
    assert "18 conditions of both oils" in text and "95%" in text
    # a saved fit does not know its rig, and nobody knows a gain that all runs share
    assert "Not covered" in text
    assert "outside" not in text
    assert picture.stat().st_size > 0
    assert main([*words, "--stress", "2.5GPa"]) == 0
    assert "outside" in capsys.readouterr().out


def test_picture_has_room_for_names_of_any_length_and_form() -> None:
    long_name = "/".join(["results of the laboratory in another town"] * 4)
    names = [f"{long_name}, oil", "_hidden $a_b$"]
    slips = np.linspace(0.01, 0.3, 20)
    shared = {"outside": False, "over_limit": False, "ratio_outside": True}
    shared |= {"ratio_support": Support.SUPPORTED, "ratio_of": "laws"}
    mu_and_ratio = dict.fromkeys([*MU_COLUMNS, *RATIO_COLUMNS], 0.05)
    curves = pd.concat(
        pd.DataFrame({"fit": name, SLIP: slips, **mu_and_ratio, **shared}) for name in names
    )
    conditions_text = "P 1.25 GPa, U 30 m/s, T 80 degC, and more text than a line can hold, " * 2
    figure = comparison_figure(curves, conditions_text, has_simulated_data=True)
    assert nothing_is_cut_off(figure)
    entries = [text.get_text() for text in figure.legends[0].get_texts()]
    assert len(entries) == 2
    assert "_hidden $a_b$" in entries[1]
    assert "SIMULATED" in {text.get_text() for text in figure.texts}


@pytest.mark.slow
@pytest.mark.parametrize(("data", "is_simulated"), [("measured", False), ("simulated", True)])
def test_data_are_simulated_by_their_kind_whatever_the_campaign_is_called(
    folders: list[Path], monkeypatch: pytest.MonkeyPatch, data: str, is_simulated: bool
) -> None:
    footer = {"campaign": "simulated-check", "data": data}
    monkeypatch.setattr(compare, "results_and_footer", lambda folder: (folder, footer))
    fits = read_fits(folders, None)
    assert {fit.is_simulated for fit in fits.values()} == {is_simulated}


@pytest.mark.slow
def test_results_are_found_by_project_and_by_campaign(
    folders: list[Path],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    june, july = folders
    (tmp_path / "june/results").mkdir(parents=True)
    (tmp_path / "june/results/june").symlink_to(june)
    (tmp_path / "results").mkdir()
    (tmp_path / "results/july").symlink_to(july)
    monkeypatch.chdir(tmp_path)
    assert main(["compare", "june", "july", "--slip", "5%"]) == 0
    capsys.readouterr()
    assert main(["compare", "june"]) == 2
    assert "--oil" not in capsys.readouterr().err


@pytest.mark.nightly
def test_ratio_by_runs_is_much_narrower_than_that_of_two_laws(folders: list[Path]) -> None:
    oil_by_name = {folder.name: read_oil(folder, "oil") for folder in folders}
    law_by_name = {name: oil.fit for name, oil in oil_by_name.items()}
    pair_by_name = {"july": oil_pair(oil_by_name["june"], oil_by_name["july"])}
    slips = [0.0, 0.02, 0.05, 0.2]
    by_runs = comparison_table(law_by_name, AT, slips, pair_by_name).iloc[4:].set_index(SLIP)
    by_laws = comparison_table(law_by_name, AT, slips).iloc[4:].set_index(SLIP)
    assert set(by_runs["ratio_of"]) == {"runs"} and set(by_laws["ratio_of"]) == {"laws"}
    # at rolling both mu are 0
    assert np.isnan(by_runs.loc[0.0, "ratio"]) and by_runs.loc[0.0, "certain"] == ""
    assert by_runs.loc[0.0, "ratio_support"] == 0 and not by_runs.loc[0.0, "ratio_outside"]
    sliding = by_runs.loc[0.02:]
    assert (sliding["ratio_lower"] < RATIO).all() and (sliding["ratio_upper"] > RATIO).all()
    assert (sliding["certain"] == "higher").all()
    # what laws say apart is never certain
    assert (by_laws["certain"] == "").all()
    half_width = (sliding["ratio_upper"] - sliding["ratio_lower"]) / 2 / RATIO
    assert (half_width < 0.015).all()


@pytest.mark.slow
def test_fits_of_the_same_runs_are_compared_by_their_laws(
    folders: list[Path], capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    tanh_folder = tmp_path / "again"
    oilfilm.fit_table(table(1.0), oil="oil", law="tanh", searches=2, bootstrap=20).save(tanh_folder)
    assert main(["compare", str(folders[0]), str(tanh_folder), "--slip", "0.05"]) == 0
    text = capsys.readouterr().out
    assert "of laws" in text and "same runs" in text
    assert "higher" not in text and "Not covered" not in text


@pytest.mark.slow
def test_rigs_that_differ_are_named(
    folders: list[Path], capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    copied_folders = []
    for folder, rig in zip(folders, ("disc-1", "disc-2"), strict=True):
        copied_folder = Path(shutil.copytree(folder, tmp_path / folder.name))
        runs_file = copied_folder / "tables/runs.parquet"
        table_of_runs = tables.read("runs", runs_file).assign(rig=rig)
        tables.write(table_of_runs, "runs", runs_file, tables.read_footer(runs_file))
        copied_folders.append(str(copied_folder))
    assert main(["compare", *copied_folders, "--slip", "0.05"]) == 0
    assert "differ (disc-1; disc-2)" in capsys.readouterr().out


def test_one_fit_and_ranges_that_do_not_overlap_are_refused(folders: list[Path]) -> None:
    assert main(["compare", str(folders[0])]) == 2
    hot_fit = oilfilm.read_fit(folders[0], "oil")
    box = hot_fit.coefficients.tested_box.copy()
    box[list(hot_fit.law.conditions).index("inlet_temperature_c")] = 5.0, 35.0
    cold_fit = replace(hot_fit, coefficients=replace(hot_fit.coefficients, tested_box=box))
    with pytest.raises(OilfilmError, match="inlet_temperature_c"):
        comparison_conditions({"hot": hot_fit, "cold": cold_fit}, {})
