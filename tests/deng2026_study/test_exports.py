"""Exports of the printed constants: what they compute, and what they say of their origin."""

import io
import json
import runpy
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from openpyxl import load_workbook

from campaigns import REFERENCE, printed
from deng2026_study.settings import study_settings
from deng2026_study.study import describe_printed
from exported import grid, tables_of
from law_points import EVERY_LAW
from oilfilm.cli import main
from oilfilm.exports.campaign import export_campaign, export_oil, workbook
from oilfilm.exports.description import SLIP, Description
from oilfilm.settings.resolved import Settings
from oilfilm.traction.law import CONDITIONS
from oilfilm.traction.laws.deng2026 import traction_coefficient

PROVENANCE = {"code": "c", "settings": "s", "inputs": {}}
DENG = EVERY_LAW["deng2026"]
NAMES = [constant.name for constant in DENG.constants]
PRINTED_4102 = dict(zip(NAMES, printed()["4102"], strict=True))


@pytest.fixture(scope="module")
def described(config: Settings) -> dict[str, Description]:
    """The printed constants by oil."""
    tested = study_settings(config).printed.boxes.tested
    return {fit.oil: fit for fit in describe_printed(REFERENCE, tested, config.exports)}


def test_exported_printed_constants_give_eqs_7_to_9(
    described: dict[str, Description], tmp_path: Path
) -> None:
    rows = grid()[[*CONDITIONS, SLIP]].to_numpy()
    for fit in described.values():
        name = f"traction_{fit.identifier}.py"
        (tmp_path / name).write_bytes(export_oil(fit, PROVENANCE)[name])
        exported = runpy.run_path(str(tmp_path / name))
        mu = np.array([exported["traction_coefficient"](*row) for row in rows])
        outside = np.array([exported["outside_tested_box"](*row) for row in rows])
        of_paper = traction_coefficient(printed()[fit.oil], *rows.T[:3], np.abs(rows.T[3]))
        np.testing.assert_allclose(mu, np.sign(rows.T[3]) * of_paper, rtol=1e-12, atol=1e-16)
        # the paper's abstract: 1.0 to 1.5 GPa, 25 to 40 m/s, 25 to 120 degC, S up to 0.3
        inside = ((rows >= [1, 25, 25, -0.3]) & (rows <= [1.5, 40, 120, 0.3])).all(axis=1)
        np.testing.assert_array_equal(outside, ~inside | (of_paper > 0.12))


def test_exports_of_a_campaign_hold_printed_constants_of_its_oils_only(config: Settings) -> None:
    files = export_campaign(tables_of(DENG, ["4102", "own"], PRINTED_4102), config, PROVENANCE)
    of_paper = [name.split("/")[1] for name in files if name.startswith("printed-constants/")]
    assert set(of_paper) == {"README.md", "4102_printed"}
    content = json.loads(files["printed-constants/4102_printed/traction_4102_printed.json"])
    assert (content["campaign"], content["fit"]) == (None, None)
    assert {each["standard_error"] for each in content["constants"]} == {None}
    assert "SIMULATED DATA" in files["README.md"].decode()


def test_open_signs_go_with_printed_constants(
    described: dict[str, Description], capsys: pytest.CaptureFixture[str]
) -> None:
    lost = "the signs of B1, B2, C2, C3 were lost and are open"
    words = "--stress 1.5 --speed 40 --temperature 120 --slip 0.01".split()
    assert main(["predict", "--printed", "--oil", "4010", *words]) == 0
    text = capsys.readouterr().out
    assert lost in text
    ends = text.partition("over the open signs mu is ")[2].split()[:3:2]
    # worked out apart from this code
    np.testing.assert_allclose(list(map(float, ends)), [0.0018, 0.0157], atol=5e-5)
    sheet = load_workbook(io.BytesIO(workbook(described["4010"])))["mu"]
    assert any(lost in str(cell.value) for row in sheet.iter_rows() for cell in row)


def test_every_file_says_that_its_constants_are_printed(described: dict[str, Description]) -> None:
    for name, content in export_oil(described["4010"], PROVENANCE).items():
        if name.endswith(".csv"):
            assert set(pd.read_csv(io.BytesIO(content))["data"]) == {"printed"}
        elif name.endswith(".xlsx"):
            for sheet in load_workbook(io.BytesIO(content)):
                texts = [str(cell.value) for row in sheet.iter_rows(max_row=3) for cell in row]
                assert any("PRINTED CONSTANTS" in text for text in texts), sheet.title
        else:
            assert "PRINTED CONSTANTS" in content.decode(), name


def test_printed_constants_need_no_results(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    words = "--stress 1.2 --speed 30 --temperature 70 --slip 0.05".split()
    assert main(["predict", "--printed", "--oil", "4102", *words]) == 0
    output = capsys.readouterr().out
    true = float(traction_coefficient(printed()["4102"], 1.2, 30.0, 70.0, 0.05))
    assert f"mu = {true:.5f}, no interval" in output
    assert main(["predict", "--printed", "--oil", "own", *words]) == 2
    assert "'own'" in capsys.readouterr().err
