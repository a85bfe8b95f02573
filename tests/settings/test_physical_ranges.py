"""Values in the wrong unit, impossible dates and unreadable files: told with file, line and key."""

import re
import shutil
from pathlib import Path

import pytest

from campaigns import ROOT
from oilfilm.errors import OilfilmError
from oilfilm.settings.resolve import resolve

CONFIG, DEMO = "config.yaml", "campaigns/demo.yaml"
RIG, OIL, BEARING = "rigs/ball-on-disc-20mm.yaml", "oils/4102.yaml", "bearings/mainshaft-167.yaml"

# File, key, another value, what the message says besides.
WRONG = [
    (DEMO, "matrix.max_hertz_pressure_gpa.0", "[1000, 1250]", "1000, .* 10 or less, in GPa.*MPa"),
    (DEMO, "matrix.inlet_temperature_c.0", "[298, 323]", "in degC.*If it is in K, write 24.85"),
    (DEMO, "matrix.entrainment_speed_m_s.0", "[25000]", "If it is in mm/s, write 25."),
    (DEMO, "twin.slip_max", "30", "write 0.3"),
    (CONFIG, "gates.load_tolerance", "3", "found 3, .* less than 1.*If it is in %, write 0.03."),
    (RIG, "ball.youngs_modulus_pa", "207", "207, .* in Pa.*If it is in GPa, write 2.07e.11."),
    (RIG, "ball_roughness_ra_um", "14", "2 or less, in um.*If it is in nm, write 0.014."),
    (RIG, "ball_radius_m", "10", "If it is in mm, write 0.01."),
    (OIL, "density_kg_m3.0.1", "[[298.15, 0.9704], [373.15, 920]]", "in g/cm3, write 970.4."),
    (OIL, "density_kg_m3.0.0", "[[25, 970.4], [373.15, 920]]", "in K.*degC, write 298.15."),
    (OIL, "density_kg_m3", "[[300, 970.4], [300, 920]]", "each temperature once"),
    (OIL, "thermal_conductivity_w_mk.0.1", "[[300, 147], [400, 0.1]]", "mW/.m K., write 0.147."),
    (OIL, "specific_heat_j_kgk.0.1", "[[300, 2], [400, 2200]]", "kJ/.kg K., write 2000."),
    (OIL, "id", '"4050"', "'4102', the file's name"),
    (BEARING, "ball_diameter_m", "22.225", "If it is in mm, write 0.022225."),
    (CONFIG, "release.date", '"2026-02-30"', "a day of the calendar"),
    (CONFIG, "release.date", "2026-01-10", 'expected text.*Put it in quotes: "2026-01-10"'),
    (CONFIG, "gates.traction_min", ".nan", "nan"),
    (CONFIG, "gates.traction_max", ".inf", "inf"),
    (CONFIG, "gates.traction_max", "", "found nothing"),
    (CONFIG, "gates.lambda_limit", "three", "'three', expected a number"),
    (CONFIG, "curation.plateaus.settle_s", "1.0e+14", "86400 or less"),
    (CONFIG, "printed.boxes.tested.entrainment_speed_m_s", "[40, 25]", r"found \[40, 25\].*rising"),
]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    shutil.copytree(ROOT / "config", tmp_path / "config")
    return tmp_path / "config"


def write_instead(path: Path, key: str, value: str) -> int:
    """Give a key another value, or a new key its first one; the number of its line."""
    *groups, name = [step for step in key.split(".") if not step.isdigit()]
    text = path.read_text(encoding="utf-8")
    start = 0
    for group in groups:
        start = re.compile(rf"\b{group}:").search(text, start).end()
    found = re.compile(rf"\b{name}:([^\S\n]*(\[.*\]|\{{.*\}}|[^\s,}}#]*))").search(text, start)
    if found is None:
        path.write_text(f"{name}: {value}\n{text}", encoding="utf-8")
        return 1
    path.write_text(f"{text[: found.start(1)]} {value}{text[found.end(1) :]}", encoding="utf-8")
    return text[: found.start()].count("\n") + 1


@pytest.mark.parametrize(("file", "key", "value", "expected"), WRONG)
def test_value_that_no_rig_or_oil_has_is_refused(
    folder: Path, file: str, key: str, value: str, expected: str
) -> None:
    line = write_instead(folder / file, key, value)
    with pytest.raises(OilfilmError, match=f"line {line}.*{expected}") as mistake:
        resolve(folder, {"campaign": "demo"})
    assert str(mistake.value).startswith(f"{folder / file}, line ")
    assert f"`{key}`" in str(mistake.value)


@pytest.mark.parametrize(
    ("file", "key", "value", "expected"),
    [
        (OIL, "coefficients.viscosity_slope", "3.3", "100c_cst is 7; .* within 25%"),
        ("oils/4050.yaml", "stand_in", "false", "give 5.45 cSt .* is 5; .* within 5%"),
    ],
)
def test_coefficients_that_contradict_the_grade_of_the_oil_are_refused(
    folder: Path, file: str, key: str, value: str, expected: str
) -> None:
    write_instead(folder / file, key, value)
    with pytest.raises(OilfilmError, match=f"{file}, line [0-9]+: `coefficients`: .*{expected}"):
        resolve(folder, {"campaign": "demo"})


def test_file_that_is_not_utf_8_is_refused_with_its_line(folder: Path) -> None:
    path = folder / RIG
    # as an editor with a Western code page writes it
    path.write_bytes(path.read_text(encoding="utf-8").replace("90 mm", "\xb5m").encode("latin-1"))
    with pytest.raises(OilfilmError, match=r"mm\.yaml, line 3: .* UTF-8 .*0xb5.*save the file"):
        resolve(folder, {})


@pytest.mark.parametrize("campaign", ["demo", "thermal", "etm-slim", "template"])
def test_every_shipped_file_is_within_the_ranges(campaign: str) -> None:
    assert resolve(ROOT / "config", {"campaign": campaign}).campaign.name == campaign
