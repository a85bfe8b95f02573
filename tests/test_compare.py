"""Fits side by side: a planted ratio comes back, whichever fit is named first."""

import re
import shutil
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import oilfilm
from known_laws import known_law
from oilfilm import tables
from oilfilm.base.errors import OilfilmError
from oilfilm.cli import main
from oilfilm.fits.fitted import SLIP
from oilfilm.fits.oil_pairs import oil_pair, read_oil
from oilfilm.fits.side_by_side import middle_of_tested, side_by_side
from oilfilm.traction.law import CONDITIONS

NAMES = [*CONDITIONS, "slide_roll_ratio"]
AT = {NAMES[0]: 1.25, NAMES[1]: 30.0, NAMES[2]: 80.0}
RATIO = 1.2


def table(factor: float, hottest_c: float = 120.0) -> pd.DataFrame:
    """Points on the printed law of 4102 times a factor, with errors of 0.5 % per curve."""
    slip = np.linspace(0.01, 0.3, 8)
    levels = np.meshgrid([1.0, 1.25, 1.5], [25, 30, 40], [50, 80, hottest_c], slip)
    points = pd.DataFrame({name: each.ravel() for name, each in zip(NAMES, levels, strict=True)})
    printed = known_law("4102")
    mu = printed.predict_at(*(points[name] for name in NAMES)).traction_coefficient
    curve = points.groupby(NAMES[:3]).ngroup().to_numpy()
    errors = 1 + 0.005 * np.random.default_rng(int(100 * factor)).standard_normal(curve.max() + 1)
    return points.assign(traction_coefficient=factor * mu * errors[curve], curve=curve)


@pytest.fixture(scope="module")
def folders(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    made = [tmp_path_factory.mktemp("compare") / name for name in ("june", "july")]
    for folder, factor in zip(made, (1.0, RATIO), strict=True):
        oilfilm.fit_table(table(factor), oil="oil", searches=2, bootstrap=40).save(folder)
    return made


def test_planted_ratio_is_inside_the_interval_of_two_laws(folders: list[Path]) -> None:
    fits = {folder.name: oilfilm.read_fit(folder, "oil") for folder in folders}
    there = side_by_side(fits, AT, [0.02, 0.05, 0.2]).iloc[3:]
    assert (there["ratio_lower"] < RATIO).all() and (there["ratio_upper"] > RATIO).all()
    back = side_by_side(dict(reversed(fits.items())), AT, [0.02, 0.05, 0.2]).iloc[3:]
    # the reciprocal, with its ends exchanged
    np.testing.assert_allclose(back["ratio"], 1 / there["ratio"], rtol=1e-12)
    np.testing.assert_allclose(back["ratio_lower"], 1 / there["ratio_upper"], rtol=1e-12)


def test_fit_beside_itself_has_the_ratio_one(folders: list[Path]) -> None:
    fit = oilfilm.read_fit(folders[0], "oil")
    beside = side_by_side({"a": fit, "b": fit}, AT, [0.1])
    assert beside["ratio"].tolist() == [1, 1]


def test_command_names_campaigns_and_marks_what_was_not_tested(
    folders: list[Path], capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    picture = tmp_path / "mu.png"
    words = ["compare", *map(str, folders)]
    assert main([*words, "--slip", "5%", "--plot", str(picture)]) == 0
    text = capsys.readouterr().out
    (ratio,) = re.findall(r"(?m)^ *0\.05 +([\d.]+) \([\d.]+ to [\d.]+\) higher$", text)
    assert float(ratio) == pytest.approx(RATIO, rel=0.02)
    assert "27 conditions of both oils" in text and "95%" in text
    # a saved fit does not know its rig, and nobody knows a gain that all runs share
    assert "Not covered" in text
    assert "outside" not in text
    assert picture.stat().st_size > 0
    assert main([*words, "--stress", "2.5GPa"]) == 0
    assert "outside" in capsys.readouterr().out


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


def test_ratio_by_runs_is_much_narrower_than_that_of_two_laws(folders: list[Path]) -> None:
    oils = {folder.name: read_oil(folder, "oil") for folder in folders}
    fits = {name: oil.fit for name, oil in oils.items()}
    pairs = {"july": oil_pair(oils["june"], oils["july"])}
    slips = [0.0, 0.02, 0.05, 0.2]
    by_runs = side_by_side(fits, AT, slips, pairs).iloc[4:].set_index(SLIP)
    by_laws = side_by_side(fits, AT, slips).iloc[4:].set_index(SLIP)
    assert set(by_runs["ratio_of"]) == {"runs"} and set(by_laws["ratio_of"]) == {"laws"}
    # at rolling both mu are 0
    assert np.isnan(by_runs.loc[0.0, "ratio"]) and by_runs.loc[0.0, "certain"] == ""
    assert by_runs.loc[0.0, "ratio_support"] == 0 and not by_runs.loc[0.0, "ratio_outside"]
    moving = by_runs.loc[0.02:]
    assert (moving["ratio_lower"] < RATIO).all() and (moving["ratio_upper"] > RATIO).all()
    assert (moving["certain"] == "higher").all()
    # what laws say apart is never certain
    assert (by_laws["certain"] == "").all()
    half_width = (moving["ratio_upper"] - moving["ratio_lower"]) / 2 / RATIO
    assert (half_width < 0.015).all()


def test_fits_of_the_same_runs_are_compared_by_their_laws(
    folders: list[Path], capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    again = tmp_path / "again"
    oilfilm.fit_table(table(1.0), oil="oil", law="tanh", searches=2, bootstrap=20).save(again)
    assert main(["compare", str(folders[0]), str(again), "--slip", "0.05"]) == 0
    text = capsys.readouterr().out
    assert "of laws" in text and "same runs" in text
    assert "higher" not in text and "Not covered" not in text


def test_rigs_that_differ_are_named(
    folders: list[Path], capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    named = []
    for folder, rig in zip(folders, ("disc-1", "disc-2"), strict=True):
        copy = Path(shutil.copytree(folder, tmp_path / folder.name))
        runs = copy / "tables/runs.parquet"
        table_of_runs = tables.read("runs", runs).assign(rig=rig)
        tables.write(table_of_runs, "runs", runs, tables.read_footer(runs))
        named.append(str(copy))
    assert main(["compare", *named, "--slip", "0.05"]) == 0
    assert "differ (disc-1; disc-2)" in capsys.readouterr().out


def test_one_fit_and_ranges_that_do_not_overlap_are_refused(folders: list[Path]) -> None:
    assert main(["compare", str(folders[0])]) == 2
    cold, fit = table(1.0, 60.0), oilfilm.read_fit(folders[0], "oil")
    cold = cold.assign(inlet_temperature_c=cold["inlet_temperature_c"] - 45)
    other = oilfilm.fit_table(cold, searches=2, bootstrap=20).law
    with pytest.raises(OilfilmError, match="inlet_temperature_c"):
        middle_of_tested({"hot": fit, "cold": other}, {})
