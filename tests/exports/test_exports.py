"""Exports: what the generated sources compute is what the law says, in the tools they are for."""

import io
import json
import re
import runpy
import shutil
import subprocess
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from campaigns import printed
from exported import HOSTILE, arguments_of, beyond, describe_law, expected, grid, tables_of
from law_points import EVERY_LAW
from nights import nightly
from oilfilm.exports.campaign import (
    _SPREADSHEET_FORMS,
    EXPORT_FORMS,
    adore_rows,
    export_campaign,
    export_oil,
)
from oilfilm.exports.description import SLIP, Description, describe, make_identifiers, plain_text
from oilfilm.settings.resolved import Settings
from oilfilm.traction.expression import Language, name_node, parse

PROVENANCE = {"code": "c", "settings": "s", "inputs": {}}
WARNINGS = ["-Wall", "-Wextra", "-pedantic", "-Werror"]

DENG = EVERY_LAW["deng2026"]
NAMES = [constant.name for constant in DENG.constants]
PRINTED_4102 = dict(zip(NAMES, printed()["4102"], strict=True))


@pytest.fixture(scope="module")
def fit(config: Settings) -> Description:
    """Oil 4050 as printed, everything known."""
    return describe_law(config, "deng2026")


@pytest.fixture(scope="module")
def curve_only(config: Settings) -> Description:
    """No exponent at all, the pressure not even known: one curve."""
    planted = {"A": -0.056, "B": 0.85, "C": 35.5}
    tables = tables_of(DENG, ["x-1"], planted, ("max_hertz_pressure_gpa",))
    points = tables.points.assign(max_hertz_pressure_gpa=np.nan)
    return describe(tables.replace(points=points), "x-1", "x_1", DENG, config)


def tool(name: str) -> str:
    path = shutil.which(name)
    if path is None:
        pytest.skip(f"{name} is not on PATH (.ci/tools installs it)")
    return path


def run(*command: str, folder: Path, given: str = "") -> str:
    done = subprocess.run(
        command, cwd=folder, input=given, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def save(fit: Description, folder: Path) -> None:
    for name, content in export_oil(fit, PROVENANCE).items():
        (folder / name).write_bytes(content)


def texts_of(fit: Description) -> dict[str, str]:
    """Every export but the workbook, as text."""
    files = export_oil(fit, PROVENANCE).items()
    return {name: content.decode() for name, content in files if not name.endswith(".xlsx")}


def as_text(rows: np.ndarray) -> str:
    return "\n".join(" ".join(f"{value:.17g}" for value in row) for row in rows) + "\n"


# ------------------------------------------------ each tool: rows of arguments -> mu and flag


def by_c(fit: Description, rows: np.ndarray, folder: Path, compiler: str = "gcc") -> np.ndarray:
    name, count = fit.identifier, rows.shape[1]
    names = ", ".join(f"x[{index}]" for index in range(count))
    (folder / "main.c").write_text(
        f"""
#include <stdio.h>
#include "traction_{name}.h"

int main(void)
{{
    double x[4];
    while (scanf("{"%lf" * count}", {", ".join(f"&x[{i}]" for i in range(count))}) == {count}) {{
        printf("%.17g %d\\n", traction_coefficient_{name}({names}),
               outside_tested_box_{name}({names}));
    }}
    return 0;
}}
"""
    )
    standard = {"gcc": ["-x", "c", "-std=c99"], "g++": ["-x", "c++", "-std=c++11"]}[compiler]
    options = [*WARNINGS, *standard, "-O2"]
    run(tool(compiler), *options, "main.c", "-o", "main", "-lm", folder=folder)
    return np.loadtxt(io.StringIO(run("./main", folder=folder, given=as_text(rows))), ndmin=2)


def by_cpp(fit: Description, rows: np.ndarray, folder: Path) -> np.ndarray:
    return by_c(fit, rows, folder, "g++")


def by_fortran(fit: Description, rows: np.ndarray, folder: Path) -> np.ndarray:
    name, count = fit.identifier, rows.shape[1]
    names = ", ".join(f"x({column}, :)" for column in range(1, count + 1))
    (folder / "main.f90").write_text(
        f"""
program main
  use, intrinsic :: iso_fortran_env, only: real64
  use traction_{name}
  implicit none
  real(real64) :: x({count}, {len(rows)}), mu({len(rows)})
  logical :: outside({len(rows)})
  integer :: i
  read (*, *) x
  mu = traction_coefficient_{name}({names})
  outside = outside_tested_box_{name}({names})
  do i = 1, {len(rows)}
    print '(es25.17e3, i2)', mu(i), merge(1, 0, outside(i))
  end do
end program
"""
    )
    sources = [f"traction_{name}.f90", "main.f90"]
    options = [*WARNINGS, "-std=f2008", "-O2"]
    run(tool("gfortran"), *options, *sources, "-o", "main", folder=folder)
    return np.loadtxt(io.StringIO(run("./main", folder=folder, given=as_text(rows))), ndmin=2)


def by_octave(fit: Description, rows: np.ndarray, folder: Path) -> np.ndarray:
    (folder / "rows.txt").write_text(as_text(rows))
    names = ", ".join(f"x(:, {column})" for column in range(1, rows.shape[1] + 1))
    program = (
        f"x = load('rows.txt'); [mu, outside] = traction_coefficient_{fit.identifier}({names}); "
        "printf('%.17g %d\\n', [mu, outside]');"
    )
    return np.loadtxt(io.StringIO(octave(program, folder)), ndmin=2)


def octave(program: str, folder: Path) -> str:
    return run(tool("octave-cli"), "--norc", "--quiet", "--eval", program, folder=folder)


def by_modelica(fit: Description, rows: np.ndarray, folder: Path) -> np.ndarray:
    """Compiled and evaluated by Rumoca: every row as one equation of a model."""
    rumoca = pytest.importorskip(
        "rumoca", reason="rumoca, a Modelica compiler, is not installed (Linux only)"
    )
    package = f"Traction_{fit.identifier}"
    si = rows.copy()
    for column, condition in enumerate(fit.arguments):
        si[:, column] *= 1e9 if condition.symbol == "P" else 1
        si[:, column] += 273.15 if condition.symbol == "T" else 0
    values = "".join(f"  Real mu{row}; Boolean outside{row};\n" for row in range(len(rows)))
    equations = "".join(
        f"  mu{row} = {package}.coefficient({names});\n"
        f"  outside{row} = {package}.outsideTestedBox({names});\n"
        for row, names in enumerate(", ".join(map(repr, map(float, line))) for line in si)
    )
    source = (folder / f"{package}.mo").read_text(encoding="utf-8")
    text = f"{source}\nmodel Grid\n{values}equation\n{equations}end Grid;\n"
    result = rumoca.Session().loads(text, model="Grid").simulate((0.0, 1.0), dt=1.0)
    return np.array(
        [[result[f"mu{row}"][0], result[f"outside{row}"][0]] for row in range(len(rows))]
    )


def by_python(fit: Description, rows: np.ndarray, folder: Path) -> np.ndarray:
    """It needs NumPy alone."""
    path = folder / f"traction_{fit.identifier}.py"
    imports = re.findall(r"(?m)^\s*(?:import|from) (\S+)", path.read_text(encoding="utf-8"))
    assert imports == ["numpy"]
    exported = runpy.run_path(str(path))
    functions = exported["traction_coefficient"], exported["outside_tested_box"]
    return np.column_stack([function(*rows.T) for function in functions])


Evaluate = Callable[[Description, np.ndarray, Path], np.ndarray]
TOOLS = [by_c, by_cpp, by_fortran, by_octave, by_modelica, by_python]


def refuse_other_values(
    evaluate: Evaluate, fit: Description, rows: pd.DataFrame, folder: Path
) -> None:
    save(fit, folder)
    arguments = arguments_of(fit, rows)
    mu, outside = evaluate(fit, arguments, folder).T
    # mu of 1e-3 and less is a difference of terms of size 0.05
    np.testing.assert_allclose(mu, expected(fit, rows), rtol=1e-12, atol=1e-16)
    np.testing.assert_array_equal(outside == 1, beyond(fit, arguments, mu))


# Each law in two tools, each tool with the default law and with the one that has most functions.
LAWS_IN_TOOLS = [
    (evaluate, law, left_out)
    if evaluate is by_python or law == "deng2026"
    else nightly(evaluate, law, left_out)
    for evaluate in TOOLS
    for law, left_out in [*((law, None) for law in EVERY_LAW), ("deng2026", 1), ("carreau", 1)]
] + [(evaluate, "one curve", None) for evaluate in TOOLS]


@pytest.mark.slow
@pytest.mark.parametrize(("evaluate", "law", "left_out"), LAWS_IN_TOOLS)
def test_exported_function_computes_the_law_and_takes_no_condition_left_out(
    evaluate: Evaluate,
    law: str,
    left_out: int | None,
    config: Settings,
    curve_only: Description,
    tmp_path: Path,
) -> None:
    fit = curve_only if law == "one curve" else describe_law(config, law, left_out)
    assert left_out is None or "entrainment_speed_m_s" not in fit.argument_names
    assert law != "one curve" or fit.argument_names == [SLIP]
    refuse_other_values(evaluate, fit, grid(), tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("evaluate", [by_c, by_fortran, by_octave, by_python])
def test_no_value_where_law_has_none(evaluate: Evaluate, fit: Description, tmp_path: Path) -> None:
    save(fit, tmp_path)
    rows = np.tile([1.2, 30.0, 70.0, 0.1], (7, 1))
    rows[range(1, 7), [0, 1, 2, 0, 1, 2]] = [0.0] * 3 + [-1.0] * 3
    mu, outside = evaluate(fit, rows, tmp_path).T
    assert np.isfinite(mu).tolist() == [True] + 6 * [False]
    assert outside.tolist() == [0] + 6 * [1]


@pytest.mark.slow
@pytest.mark.parametrize("evaluate", TOOLS)
def test_exponential_of_the_temperature_has_a_value_in_frost(
    evaluate: Evaluate, config: Settings, tmp_path: Path
) -> None:
    fit = describe_law(config, "deng-exponential")
    save(fit, tmp_path)
    rows = np.tile([1.2, 30.0, -40.0, 0.1], (2, 1))
    rows[1, 2] = 0.0
    mu, outside = evaluate(fit, rows, tmp_path).T
    # by the equation: (A + B S) exp(-C S) - A with exp(X3 (T/20 degC - 1))
    bar_p, bar_u, term = 1.2, 1.5, rows[:, 2] / 20 - 1
    a = -0.030 * bar_p**0.43 * bar_u**-0.47 * np.exp(-0.06 * term)
    b = 0.92 * bar_p**1.80 * bar_u**-0.58 * np.exp(-0.60 * term)
    c = 27.0 * bar_p**0.69 * bar_u**0.01 * np.exp(-0.20 * term)
    np.testing.assert_allclose(mu, (a + b * 0.1) * np.exp(-c * 0.1) - a, rtol=1e-10)
    assert outside.tolist() == [1, 1]


def test_modelica_stops_where_the_law_has_no_value(fit: Description, tmp_path: Path) -> None:
    save(fit, tmp_path)
    with pytest.raises(Exception, match=r"(?i)assert|non-finite|above 0"):
        by_modelica(fit, np.array([[-1.0, 30.0, 70.0, 0.1]]), tmp_path)


@pytest.mark.parametrize(
    ("data", "sentence"),
    [("simulated", "SIMULATED DATA"), ("measured", "Measured data (A. Tribologist)")],
)
def test_every_file_says_whether_its_data_are_real(
    fit: Description, config: Settings, data: str, sentence: str
) -> None:
    campaign = fit.campaign.model_copy(update={"data": data, "credit": "A. Tribologist"})
    texts = texts_of(replace(fit, campaign=campaign))
    assert len(texts) == len(EXPORT_FORMS) + 1  # CSV and JSON, but not the workbook
    for name, text in texts.items():
        if name.endswith(".csv"):
            assert set(pd.read_csv(io.StringIO(text))["data"]) == {data}
        else:
            assert sentence in text, name


# ------------------------------------------------------------------------- hostile names


@pytest.fixture(scope="module")
def hostile(config: Settings) -> tuple[list[Description], dict[str, str]]:
    tables = tables_of(DENG, HOSTILE, PRINTED_4102)
    quality = tables.fit_quality.assign(certified=False)
    quality["doubts"] = [("at bounds",)] * len(quality)
    quality["active_bounds"] = [tuple(HOSTILE)] * len(quality)
    tables = tables.replace(fit_quality=quality)
    settings = config.with_changes({"campaign": {"description": " ".join(HOSTILE)}})
    names = make_identifiers(HOSTILE).items()
    fits = [describe(tables, oil, name, DENG, settings) for oil, name in names]
    return fits, export_campaign(tables, settings, PROVENANCE)


@pytest.mark.slow
@pytest.mark.parametrize("every", [3, nightly(1)])
@pytest.mark.parametrize("evaluate", TOOLS)
def test_hostile_names_change_nothing_of_the_code(
    evaluate: Evaluate, hostile: Any, tmp_path: Path, every: int
) -> None:
    """Of three tools in a row each takes other names."""
    for fit in hostile[0][TOOLS.index(evaluate) % every :: every]:
        folder = tmp_path / fit.identifier
        folder.mkdir()
        refuse_other_values(evaluate, fit, grid()[::37], folder)


@pytest.mark.slow
def test_hostile_names_stay_whole_in_json_and_harmless_in_csv(hostile: Any) -> None:
    fits, files = hostile
    for fit in fits:
        path = f"{fit.identifier}/traction_{fit.identifier}"
        assert json.loads(files[f"{path}.json"])["oil"] == fit.oil
        oils = pd.read_csv(io.BytesIO(files[f"{path}.csv"]), dtype=str, keep_default_na=False)
        assert set(oils["oil"]) == {f"'{fit.oil}" if fit.oil.startswith("=") else fit.oil}
    assert len(fits) == len(HOSTILE)
    assert all(re.fullmatch(r"README\.md|[a-z0-9_]+/[A-Za-z0-9_]+\.\w+", name) for name in files)


@pytest.mark.slow
@given(st.lists(st.text(), unique=True, max_size=8))
def test_identifiers_are_plain_short_and_all_different(oils: list[str]) -> None:
    names = list(make_identifiers(oils).values())
    assert len(set(names)) == len(oils)
    assert all(re.fullmatch(r"[a-z0-9][a-z0-9_]*", name) and len(name) <= 40 for name in names)


@pytest.mark.slow
@given(st.text())
def test_plain_text_can_end_no_comment_or_string(text: str) -> None:
    assert re.fullmatch(r"[A-Za-z0-9 .,:;()<>=+/%'_-]*", plain_text(text))


# ------------------------------------------------------------------------- JSON, CSV, ADORE


@pytest.mark.slow
@pytest.mark.parametrize("law", EVERY_LAW)
def test_json_and_csv_give_the_same_mu_back(config: Settings, law: str) -> None:
    """As a reader does who has the files alone: power laws, then the equation as it is written."""
    fit = describe_law(config, law)
    texts = texts_of(fit)
    assert pd.read_csv(io.StringIO(texts["traction_4050.csv"]))["unit"].notna().all()
    content = json.loads(texts["traction_4050.json"])
    assert {*content["files"], *content["not_written"]} == {"CSV", *EXPORT_FORMS}
    assert not set(content["not_written"]) - {"ADORE"}
    table = pd.read_csv(io.StringIO(texts["traction_4050.csv"]))
    constants = table[table["kind"] == "constant"]
    values = {constant["name"]: constant["value"] for constant in content["constants"]}
    assert dict(zip(constants["quantity"], constants["value"], strict=True)) == values
    for name, exponents in content["law"]["known_exponents"].items():
        values |= {f"{name}{number}": value for number, value in enumerate(exponents, 1)}
    arguments = arguments_of(fit, grid())
    references = [condition["reference"] for condition in content["conditions"][:3]]
    relative = arguments[:, :3] / references
    names = [condition["name"] for condition in content["conditions"][:3]]
    is_exponential = np.isin(names, content["law"]["exponential"])
    base = np.exp(relative - 1, out=relative, where=is_exponential)
    known: dict[str, Any] = {"S": np.abs(arguments[:, 3]), "asinh": np.arcsinh, **vars(np)}
    for name in fit.law.coefficient_names:
        exponents = [values[f"{name}{number}"] for number in (1, 2, 3)]
        known[name] = values[f"{name}0"] * (base**exponents).prod(axis=1)
    for name, text in content["law"]["parts_of_mu"].items():
        known[name] = eval(text, known)
    mu = eval(content["law"]["mu_for_slip_of_0_or_more"], known)
    sign = np.where(arguments[:, 3] < 0, -1, 1)
    np.testing.assert_allclose(sign * mu, expected(fit, grid()), rtol=1e-12, atol=1e-16)


@pytest.mark.parametrize("left_out", [None, 1])
@pytest.mark.parametrize("law", [name for name, law in EVERY_LAW.items() if law.adore])
def test_adore_form_is_the_law_at_points(law: str, left_out: int | None, config: Settings) -> None:
    fit = describe_law(config, law, left_out)
    slips = np.linspace(0, 0.5, 21)
    rows = adore_rows(fit)
    assert rows
    for row, point in zip(rows, fit.adore_points, strict=False):
        speed = row["entrainment_speed_m_s"]
        velocity = slips * speed
        mu = (row["A"] + row["B"] * velocity) * np.exp(-row["C"] * velocity) + row["D"]
        points = pd.DataFrame([{**point, "entrainment_speed_m_s": speed}] * len(slips))
        law_mu = expected(fit, points.assign(**{SLIP: slips}))
        np.testing.assert_allclose(mu, law_mu, rtol=1e-12, atol=1e-16)
        # as ADORE's user knows it, from the peak
        slope = row["B"] / (row["A"] + row["B"] * row["peak_slip_velocity"])
        assert row["C"] == pytest.approx(slope, rel=1e-12)
        assert row["peak_mu"] >= mu.max()


def test_fit_of_one_level_stands_at_that_level_once(curve_only: Description) -> None:
    (row,) = adore_rows(curve_only)
    assert row["max_hertz_pressure_gpa"] is None
    assert row["entrainment_speed_m_s"] == 32.5  # mean of its two runs
    head = texts_of(curve_only)["traction_x_1.h"]
    head = " ".join(head.replace("*", " ").split())
    assert "aximum Hertz pressure" in head
    assert "was tested at 32.5 m/s only" in head


def test_fit_whose_speed_is_not_known_is_exported_without_adore(config: Settings) -> None:
    planted = {"A": -0.056, "B": 0.85, "C": 35.5}
    tables = tables_of(DENG, ["x-1"], planted, ("entrainment_speed_m_s",))
    points = tables.points.assign(entrainment_speed_m_s=np.nan)
    fit = describe(tables.replace(points=points), "x-1", "x_1", DENG, config)
    content = json.loads(texts_of(fit)["traction_x_1.json"])
    assert set(content["not_written"]) == {"ADORE"}
    assert "speed" in content["not_written"]["ADORE"]


@pytest.mark.parametrize("text", ["S/log1p(S)", "log1p(S)**2"])
def test_a_product_in_a_spreadsheet_has_brackets_in_quotients_and_powers(text: str) -> None:
    language = Language(_SPREADSHEET_FORMS)
    written = language.write(parse(text, {"S": name_node("S")}))
    # the factors of ln(1 + S) = 2 artanh(S/(2 + S)) belong together
    assert "(2*ATANH(S/(2+S)))" in written


# ------------------------------------------------------------------------- what it says


def test_fit_of_one_run_is_said_to_be_of_one(config: Settings) -> None:
    tables = tables_of(DENG, ["4102"], {})
    tables = tables.replace(fit_quality=tables.fit_quality.assign(n_points=31, n_curves=1))
    fit = describe(tables, "4102", "4102", DENG, config)
    assert fit.fit_sentences[0].startswith("Fit: 31 points of 1 run, rms error")


def test_fit_without_a_curve_is_listed_with_the_reason(config: Settings) -> None:
    tables = tables_of(DENG, ["4102"], {})
    why = "not fitted: no accepted points"
    lost = {"no_fit": "no points", "certified": False, "rmse": np.nan, "max_error": np.nan}
    tables = tables.replace(fit_quality=tables.fit_quality.assign(**lost))
    files = export_campaign(tables, config, PROVENANCE)
    fitted = {name for name in files if not name.startswith("printed-constants/")}
    assert fitted == {"README.md", "4102/traction_4102.csv", "4102/traction_4102.json"}
    content = json.loads(files["4102/traction_4102.json"])
    assert content["not_written"] == dict.fromkeys(EXPORT_FORMS, why)
    assert why in files["README.md"].decode()


def test_what_keeps_a_fit_from_being_sound_is_in_code_and_json(fit: Description) -> None:
    texts = texts_of(
        replace(fit, law_with_constants=replace(fit.law_with_constants, warnings=("It drifts.",)))
    )
    assert json.loads(texts["traction_4050.json"])["fit"]["not_sound_because"] == ["It drifts."]
    assert "NOT SOUND: It drifts." in texts["traction_4050.h"]


def test_the_misfit_of_a_sound_law_is_stated_beside_the_scatter_of_runs(fit: Description) -> None:
    known = replace(fit, misfit_and_scatter=(0.0123, 0.0456))
    texts = texts_of(known)
    (of_json,) = [json.loads(text) for name, text in texts.items() if name.endswith(".json")]
    assert of_json["fit"]["misfit_of_law_relative"] == 0.0123
    assert of_json["fit"]["scatter_of_runs_relative"] == 0.0456
    # wherever the quality of the fit is told, both numbers are
    for text in texts.values():
        if "rms error of mu" in text:
            assert "1.2%" in text and "4.6%" in text


def test_an_unknown_misfit_is_null(fit: Description) -> None:
    (of_json,) = [
        json.loads(text) for name, text in texts_of(fit).items() if name.endswith(".json")
    ]
    assert of_json["fit"]["misfit_of_law_relative"] is None
