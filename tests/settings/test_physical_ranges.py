"""Values in the wrong unit, impossible dates and unreadable files: told with file, line and key."""

import shutil
from pathlib import Path

import pytest

from oilfilm.errors import OilfilmError
from oilfilm.settings.resolve import resolve

ROOT = Path(__file__).parents[2]
CONFIG, DEMO = "config.yaml", "campaigns/demo.yaml"
RIG, OIL, BEARING = "rigs/ball-on-disc-20mm.yaml", "oils/4102.yaml", "bearings/mainshaft-167.yaml"

# File, what is replaced, by what; the key, and what the message says besides.
WRONG = {
    "matrix in MPa": (
        DEMO,
        "max_hertz_pressure_gpa: [1.0, 1.25, 1.5]",
        "max_hertz_pressure_gpa: [1000, 1250, 1500]",
        "matrix.max_hertz_pressure_gpa.0",
        ["found 1000", "10 or less, in GPa", "If it is in MPa, write 1."],
    ),
    "matrix in K": (
        DEMO,
        "inlet_temperature_c: [25, 50,",
        "inlet_temperature_c: [298, 323,",
        "matrix.inlet_temperature_c.0",
        ["in degC", "If it is in K, write 24.85"],
    ),
    "matrix in mm/s": (
        DEMO,
        "entrainment_speed_m_s: [25,",
        "entrainment_speed_m_s: [25000,",
        "matrix.entrainment_speed_m_s.0",
        ["If it is in mm/s, write 25."],
    ),
    "slip in percent": (DEMO, "slip_max: 0.30", "slip_max: 30", "twin.slip_max", ["write 0.3"]),
    "tolerance in percent": (
        CONFIG,
        "load_tolerance: 0.03 ",
        "load_tolerance: 3 ",
        "gates.load_tolerance",
        ["found 3", "less than 1", "If it is in %, write 0.03."],
    ),
    "Young's modulus in GPa": (
        RIG,
        "ball: {youngs_modulus_pa: 203.0e+9",
        "ball: {youngs_modulus_pa: 207",
        "ball.youngs_modulus_pa",
        ["found 207", "in Pa", "If it is in GPa, write 2.07e+11."],
    ),
    "roughness in nm": (
        RIG,
        "ball_roughness_ra_um: 0.014",
        "ball_roughness_ra_um: 14",
        "ball_roughness_ra_um",
        ["2 or less, in um", "If it is in nm, write 0.014."],
    ),
    "radius in mm": (
        RIG,
        "ball_radius_m: 0.010",
        "ball_radius_m: 10",
        "ball_radius_m",
        ["If it is in mm, write 0.01."],
    ),
    "density in g/cm3": (
        OIL,
        "[298.15, 970.4]",
        "[298.15, 0.9704]",
        "density_kg_m3.0.1",
        ["If it is in g/cm3, write 970.4."],
    ),
    "table in degC": (
        OIL,
        "density_kg_m3: [[298.15, 970.4]",
        "density_kg_m3: [[25, 970.4]",
        "density_kg_m3.0.0",
        ["200 or more, in K", "If it is in degC, write 298.15."],
    ),
    "conductivity in mW": (
        OIL,
        "[[300, 0.147]",
        "[[300, 147]",
        "thermal_conductivity_w_mk.0.1",
        ["If it is in mW/(m K), write 0.147."],
    ),
    "specific heat in kJ": (
        OIL,
        "[[300, 2000]",
        "[[300, 2]",
        "specific_heat_j_kgk.0.1",
        ["If it is in kJ/(kg K), write 2000."],
    ),
    "temperature twice": (
        OIL,
        "[373.15, 920]]",
        "[298.15, 920]]",
        "density_kg_m3",
        ["each temperature once"],
    ),
    "viscosity of another grade": (
        OIL,
        "viscosity_slope: 3.4101",
        "viscosity_slope: 3.3",
        "coefficients",
        ["cSt at 100 degC", "nominal_kinematic_viscosity_100c_cst is 7", "within 25%"],
    ),
    "viscosity contradicts the coefficients": (
        "oils/4050.yaml",
        "stand_in: true",
        "stand_in: false",
        "coefficients",
        ["give 5.45 cSt", "is 5;", "within 5%"],
    ),
    "another oil's id": (OIL, 'id: "4102"', 'id: "4050"', "id", ["'4102', the file's name"]),
    "ball diameter in mm": (
        BEARING,
        "ball_diameter_m: 22.225e-3",
        "ball_diameter_m: 22.225",
        "ball_diameter_m",
        ["If it is in mm, write 0.022225."],
    ),
    "30th of February": (
        CONFIG,
        'date: "2026-01-10"',
        'date: "2026-02-30"',
        "release.date",
        ["a day of the calendar"],
    ),
    "day without quotes": (
        CONFIG,
        'date: "2026-01-10"',
        "date: 2026-01-10",
        "release.date",
        ["expected text", 'Put it in quotes: "2026-01-10"'],
    ),
    "no year": (DEMO, "licence: MIT", "date: last summer\nlicence: MIT", "date", ["with its year"]),
    "nan": (CONFIG, "traction_min: -0.002", "traction_min: .nan", "gates.traction_min", ["nan"]),
    "inf": (CONFIG, "traction_max: 0.15", "traction_max: .inf", "gates.traction_max", ["inf"]),
    "empty": (CONFIG, "traction_max: 0.15", "traction_max:", "gates.traction_max", ["nothing"]),
}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    shutil.copytree(ROOT / "config", tmp_path / "config")
    return tmp_path / "config"


def write_instead(path: Path, old: str, new: str) -> int:
    """Replace some text once; the number of its line."""
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new, 1), encoding="utf-8")
    return text[: text.index(old)].count("\n") + 1


@pytest.mark.parametrize(("file", "old", "new", "key", "expected"), WRONG.values(), ids=WRONG)
def test_value_that_no_rig_or_oil_has_is_refused(
    folder: Path, file: str, old: str, new: str, key: str, expected: list[str]
) -> None:
    line = write_instead(folder / file, old, new)
    with pytest.raises(OilfilmError) as mistake:
        resolve(folder, {"campaign": "demo"})
    message = str(mistake.value)
    assert f"{folder / file}, line " in message
    assert f"`{key}`" in message
    assert all(part in message for part in expected), message
    if key != "coefficients":
        assert f"line {line}" in message


def test_file_that_is_not_utf_8_is_refused_with_its_line(folder: Path) -> None:
    path = folder / RIG
    # as an editor with a Western code page writes it
    path.write_bytes(path.read_text(encoding="utf-8").replace("90 mm", "\xb5m").encode("latin-1"))
    with pytest.raises(OilfilmError, match=r"mm\.yaml, line 2: .* UTF-8 .*0xb5.*save the file"):
        resolve(folder, {})


@pytest.mark.parametrize("campaign", ["demo", "thermal", "etm-slim", "template"])
def test_every_shipped_file_is_within_the_ranges(campaign: str) -> None:
    assert resolve(ROOT / "config", {"campaign": campaign}).campaign.name == campaign
