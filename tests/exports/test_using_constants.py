"""docs/how-to/using-constants.md and docs/examples: every block of code does what the page says."""

import re
import shutil
import sys
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from campaigns import ROOT, printed
from command_line import succeeded
from oilfilm.cli import main
from oilfilm.traction.laws.deng2026 import traction_coefficient

pytest.importorskip("deng2026_study", reason="the page uses the constants of a study")
PAGE = (ROOT / "docs/how-to/using-constants.md").read_text(encoding="utf-8")


def block(language: str) -> str:
    (code,) = re.findall(rf"```{language}\n(.*?)```", PAGE, re.DOTALL)
    return code


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder in which the command of the page was run, and nothing else."""
    folder = tmp_path_factory.mktemp("user")
    program, *arguments = block("sh").split()
    assert program == "oilfilm"
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        assert main(arguments) == 0
    return folder


def mu_of_paper(slip: float) -> float:
    """4102 at 1.25 GPa, 30 m/s, 70 degC by Eqs 7-9."""
    return float(traction_coefficient(printed()["4102"], 1.25, 30.0, 70.0, slip))


def test_python_of_the_page_prints_mu(folder: Path) -> None:
    text = succeeded([sys.executable, "-I", "-c", block("python")], cwd=folder)
    numbers, inside = re.fullmatch(r"\[(.*)\] \[(.*)\]\n", text).groups()
    of_page = [mu_of_paper(0.01), mu_of_paper(0.05)]
    assert [float(number) for number in numbers.split()] == pytest.approx(of_page, abs=5e-6)
    assert inside.split() == ["False", "False"]


def test_c_of_the_page_prints_mu(folder: Path) -> None:
    if shutil.which("gcc") is None:
        pytest.skip("gcc is not on PATH (.ci/tools installs it)")
    (folder / "mu.c").write_text(block("c"), encoding="utf-8")
    succeeded(["gcc", "-std=c99", "mu.c", "-o", "mu", "-lm"], cwd=folder)
    assert succeeded(["./mu"], cwd=folder) == f"mu = {-mu_of_paper(0.05):.5f}\n"


def test_roller_of_the_page_moves_as_its_equation_says(folder: Path) -> None:
    rumoca = pytest.importorskip(
        "rumoca", reason="rumoca, a Modelica compiler, is not installed (Linux only)"
    )
    package = folder / "printed-constants/4102_printed/Traction_4102_printed.mo"
    text = f"{package.read_text(encoding='utf-8')}\n{block('modelica')}"
    result = rumoca.Session().loads(text, model="Roller").simulate((0.0, 0.01), dt=0.001)

    def acceleration(time: float, speed: np.ndarray) -> np.ndarray:
        slip = 2 * (31 - speed) / (31 + speed)
        at = 1.25, (speed + 31) / 2, 70.0, slip
        return traction_coefficient(printed()["4102"], *at) * 80 * 0.02**2 / 1e-3

    speed = solve_ivp(acceleration, (0.0, 0.01), [29.0], rtol=1e-10, atol=1e-12).y[0, -1]
    assert result["speed"][-1] == pytest.approx(speed, rel=1e-6)


def test_constants_of_one_oil_are_written(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    one = tmp_path / "one"
    assert main(["export", "--printed", "--oil", "4050", str(one)]) == 0
    assert {path.name for path in one.iterdir()} == {"README.md", "4050_printed"}
    assert main(["export", "--printed", str(one)]) == 2
    assert "one: exists already" in capsys.readouterr().err
