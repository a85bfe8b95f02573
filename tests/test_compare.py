"""Fits side by side: a planted ratio comes back, whichever fit is named first."""

import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import oilfilm
from known_laws import known_law
from oilfilm.base.errors import OilfilmError
from oilfilm.cli import main
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


def test_planted_ratio_is_inside_its_interval(folders: list[Path]) -> None:
    fits = {folder.name: oilfilm.read_fit(folder, "oil") for folder in folders}
    there = side_by_side(fits, AT, [0.02, 0.05, 0.2]).iloc[3:]
    assert (there["ratio_lower"] < RATIO).all() and (there["ratio_upper"] > RATIO).all()
    assert ((there["ratio_upper"] - there["ratio_lower"]) / RATIO < 0.1).all()
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
    (ratio,) = re.findall(r"(?m)^ *0\.05 +([\d.]+) \([\d.]+ to [\d.]+\)$", text)
    assert float(ratio) == pytest.approx(RATIO, rel=0.02)
    assert "outside" not in text
    assert picture.stat().st_size > 0
    assert main([*words, "--stress", "2.5GPa"]) == 0
    assert "outside" in capsys.readouterr().out


def test_one_fit_and_ranges_that_do_not_overlap_are_refused(folders: list[Path]) -> None:
    assert main(["compare", str(folders[0])]) == 2
    cold, fit = table(1.0, 60.0), oilfilm.read_fit(folders[0], "oil")
    cold = cold.assign(inlet_temperature_c=cold["inlet_temperature_c"] - 45)
    other = oilfilm.fit_table(cold, searches=2, bootstrap=20).law
    with pytest.raises(OilfilmError, match="inlet_temperature_c"):
        middle_of_tested({"hot": fit, "cold": other}, {})
