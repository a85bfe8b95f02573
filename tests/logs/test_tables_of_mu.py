"""A table of mu is a log: settled readings without force and time."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from bad_logs import CONFIG
from campaigns import LABORATORY, printed
from command_line import printed_objects
from oilfilm.curation.curate import curate_logs
from oilfilm.logs.sheet_file import read_run_sheet
from oilfilm.logs.sniff import sniff
from oilfilm.logs.traction_log import TRACTION
from oilfilm.traction.laws.deng2026 import traction_coefficient

SLIPS = np.array([0.005, 0.01, 0.02, 0.05, 0.1, 0.2])
MU = traction_coefficient(printed()["4102"], 1.5, 20.0, 70.0, SLIPS)
# docs/physics.md: W 142 N at 1.5 GPa on the rig of the paper
LOAD_N = 142.0
LABELS = "# oil: 4102\n# log_kind: steps\n"
SPEED, LOAD, CELSIUS = "Mean speed (mm/s)", "Load (N)", "Lube temperature (degC)"
COLUMNS = {
    "slide_roll_ratio": {"name": "SRR"},
    "entrainment_speed": {"name": "Mean speed"},
    "traction_coefficient": {"name": "Traction Coeff"},
    "load": {"name": "Load"},
    "inlet_temperature": {"name": "Lube temperature"},
}
SETTINGS = CONFIG.with_changes({"campaign": {"columns": COLUMNS}})


def table(labels: str = LABELS, without: Sequence[str] = (), **others: Any) -> bytes:
    """Rows of 4102 at 1.5 GPa, 20 m/s and 70 degC without some columns, with others in front."""
    mu = {"Traction Coeff (-)": np.round(MU, 6)}
    every = {"SRR (%)": 100 * SLIPS, SPEED: 20_000, **mu, LOAD: LOAD_N, CELSIUS: 70}
    rows = pd.DataFrame({**others, **every}, index=range(len(SLIPS))).drop(columns=[*without])
    return (labels + rows.to_csv(index=False)).encode()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("labels", "without", "others"),
    [
        (LABELS, [], {}),
        (f"{LABELS}# load_n: 142\n", [LOAD], {}),
        (f"{LABELS}# load: 1.5 GPa\n# inlet_temperature_c: 70\n", [LOAD, CELSIUS], {}),
        (f"{LABELS}# entrainment_speed_m_s: 20\n", [SPEED], {}),
        (LABELS, [LOAD], {"Load (GPa)": 1.5}),
    ],
)
def test_table_of_mu_gives_points_with_the_mu_that_it_says(
    labels: str, without: Sequence[str], others: Mapping[str, float]
) -> None:
    verdict = curate_logs([("log", table(labels, without, **others))], SETTINGS)
    assert verdict.quarantine.empty
    points = verdict.points
    assert points["accepted"].all()
    np.testing.assert_allclose(points["traction_coefficient"], MU, atol=5e-7)
    np.testing.assert_allclose(points["slide_roll_ratio"], SLIPS, rtol=1e-12)
    np.testing.assert_allclose(points["max_hertz_pressure_gpa"], 1.5, rtol=0.002)
    assert points["time_s"].isna().all()


def test_table_that_does_not_say_that_its_rows_are_settled_lacks_the_time() -> None:
    (refusal,) = curate_logs([("log", table("# oil: 4102\n"))], SETTINGS).quarantine["reason"]
    assert "columns time" in refusal


def test_run_sheet_may_say_that_rows_are_settled() -> None:
    sheet = read_run_sheet(
        b"file,oil,log_kind\n*.csv,4102,steps\n", Path("runs.csv"), ["a.csv"], SETTINGS, TRACTION
    )
    verdict = curate_logs([("a.csv", table(""))], SETTINGS, sheet=sheet)
    assert verdict.points["accepted"].tolist() == [True] * len(SLIPS)


def test_gates_that_need_time_are_listed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log = tmp_path / "mtm.csv"
    names = "slide_roll_ratio [%],entrainment_speed [mm/s],traction_coefficient,load_n,"
    rows = table("").decode().partition("\n")[2]
    log.write_text(f"{LABELS}{names}inlet_temperature_c\n{rows}")
    where = ["--config", str(LABORATORY)]
    ((checked),) = printed_objects(capsys, "check", log, *where)
    (run,) = checked["runs"]
    assert (checked["verdict"], run["accepted_plateaus"]) == ("accepted", len(SLIPS))
    skipped = {each["gate"]: each["reason"] for each in run["gates_not_applied"]}
    for gate in ("time_disorder", "clock_jump", "stuck_channel", "stuck_sensor"):
        assert skipped[gate] == "the log has no time"
    assert skipped["not_steady"]


def test_coefficient_is_never_taken_for_a_force_and_names_keep_their_blanks() -> None:
    found = sniff("mtm.csv", table(""), lambda *signals: None)
    # `Load (N)` is known without a guess
    assert dict(found.candidates_of_quantity) == {
        "slide_roll_ratio": [("SRR (%)", "%")],
        "entrainment_speed": [("Mean speed (mm/s)", "mm/s")],
        "traction_coefficient": [("Traction Coeff (-)", "-")],
        "inlet_temperature": [("Lube temperature (degC)", "degC")],
    }
    assert found.missing_quantities == []
    assert [run.is_settled for run in found.runs] == [True]


def test_two_names_that_may_be_one_quantity_are_both_shown() -> None:
    others = {"COF (-)": 0.1, "Friction coefficient (-)": 0.1}
    content = table("", ["Traction Coeff (-)"], **others)
    found = sniff("mtm.csv", content, lambda *signals: None)
    assert [name for name, _ in found.candidates_of_quantity["traction_coefficient"]] == [
        "COF (-)",
        "Friction coefficient (-)",
    ]
