"""Oil properties against the evaluated tables of docs/physics.md and against each other."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from campaigns import ROOT, oil_of
from oilfilm.physics.oils import Oil, PiecewiseLinear
from oilfilm.settings.messages import first_mistake
from oilfilm.settings.rig import MeasuredOil, OilFile
from oilfilm.settings.yaml_file import read_yaml

FOLDER = ROOT / "config" / "oils"
OILS = {name: oil_of(name) for name in ("4010", "4050", "4102")}

any_oil = st.sampled_from(sorted(OILS)).map(OILS.__getitem__)
rig_temperatures_c = st.floats(20.0, 150.0)  # the rig's range and a little beyond

# docs/physics.md, oils, "Evaluated" [C]: degC, eta mPa s, rho kg/m3, nu cSt, alpha 1e-8/Pa, beta
# 1/K
TABLE = [
    ("4010", 25, "19.76", "963", "20.51", "1.376", ".0393"),
    ("4010", 40, "11.60", "953", "12.18", "1.177", ".0321"),
    ("4010", 70, "5.17", "931", "5.55", "0.918", ".0227"),
    ("4010", 100, "2.87", "909", "3.15", "0.758", ".0171"),
    ("4010", 120, "2.09", "893", "2.34", "0.681", ".0145"),
    ("4010", 140, "1.60", "877", "1.82", "0.620", ".0125"),
    ("4050", 25, "46.40", "967", "47.97", "1.561", ".0430"),
    ("4050", 40, "25.60", "957", "26.74", "1.423", ".0365"),
    ("4050", 70, "10.02", "938", "10.69", "1.229", ".0267"),
    ("4050", 100, "5.01", "918", "5.46", "1.103", ".0200"),
    ("4050", 120, "3.48", "904", "3.85", "1.042", ".0166"),
    ("4050", 140, "2.56", "890", "2.88", "0.994", ".0139"),
]


def printed(figure: str) -> object:
    """A printed figure, to one unit of its last digit.

    Half a unit is the rounding of the figure itself, and 56 of the 60 figures keep to it. The
    other four (4010: rho at 40 degC, alpha at 100 and 140 degC; 4050: nu at 100 degC) lie 0.54
    to 0.55 of a unit off, so they were rounded from something slightly different.
    """
    decimals = len(figure.partition(".")[2])
    return pytest.approx(float(figure), abs=10.0**-decimals)


@pytest.mark.parametrize(("name", "celsius", "eta", "rho", "nu", "alpha", "beta"), TABLE)
def test_stand_ins_have_the_tabulated_properties(
    name: str, celsius: float, eta: str, rho: str, nu: str, alpha: str, beta: str
) -> None:
    oil = OILS[name]
    assert oil.dynamic_viscosity_pa_s(celsius) * 1e3 == printed(eta)
    assert oil.density_kg_m3(celsius) == printed(rho)
    assert oil.kinematic_viscosity_m2_s(celsius) * 1e6 == printed(nu)
    assert oil.pressure_viscosity_coefficient_1_pa(celsius) * 1e8 == printed(alpha)
    assert oil.temperature_viscosity_coefficient_1_k(celsius) == printed(beta)


# docs/physics.md [S]: MIL-L-7808 and MIL-L-23699 at temperatures in K; 4102 [C] at 293 to 423 K
SOURCES = [
    ("4010", "density_kg_m3", [311, 367, 422, 478], [954, 914, 870, 826]),
    ("4010", "specific_heat_j_kgk", [311, 367, 422, 478], [1800.2, 1967.7, 2177.0, 2344.5]),
    ("4010", "thermal_conductivity_w_mk", [311, 367, 422], [0.14485, 0.13395, 0.13265]),
    ("4050", "density_kg_m3", [233, 300, 367, 422], [1016, 966, 922, 884]),
    ("4050", "specific_heat_j_kgk", [233, 422], [2000, 2000]),
    # 0.14868 - 2.2275e-4 (T - 366.67)
    ("4050", "thermal_conductivity_w_mk", [366.67, 466.67], [0.14868, 0.126405]),
    ("4102", "density_kg_m3", [373.15], [920]),
    ("4102", "specific_heat_j_kgk", [293.15, 423.15], [2000, 2000]),
    ("4102", "thermal_conductivity_w_mk", [293.15, 423.15], [0.147, 0.147]),
]


@pytest.mark.parametrize(("name", "quantity", "kelvin", "values"), SOURCES)
def test_oils_keep_the_thermal_properties_of_their_source(
    name: str, quantity: str, kelvin: list[float], values: list[float]
) -> None:
    calculated = getattr(OILS[name], quantity)(np.array(kelvin) - 273.15)
    np.testing.assert_allclose(calculated, values, rtol=1e-6)


def test_4102_has_the_printed_viscosities() -> None:
    # docs/physics.md: 7.0 cSt at 100 degC and 40.2 cSt at 40 degC, printed to 0.05 cSt; alpha
    # 1.15e-8 1/Pa at 100 degC by the 23699 rule
    oil = OILS["4102"]
    viscosity_cst = oil.kinematic_viscosity_m2_s(np.array([100.0, 40.0])) * 1e6
    assert viscosity_cst == pytest.approx(np.array([7.0, 40.2]), abs=0.05)
    assert oil.pressure_viscosity_coefficient_1_pa(100.0) * 1e8 == pytest.approx(1.15, abs=0.005)
    assert oil.relative_uncertainty == {"pressure_viscosity_coefficient": 0.15, "density": 0.03}


@given(any_oil, rig_temperatures_c)
def test_beta_is_the_slope_of_the_logarithm_of_viscosity(oil: Oil, celsius: float) -> None:
    step = 0.01  # K; the central difference is then good to about 1e-8 of beta
    around = np.log(oil.dynamic_viscosity_pa_s(np.array([celsius - step, celsius + step])))
    slope = (around[0] - around[1]) / (2 * step)
    assert oil.temperature_viscosity_coefficient_1_k(celsius) == pytest.approx(slope, rel=1e-6)


def test_table_is_continued_beyond_both_ends() -> None:
    line = PiecewiseLinear((300.0, 310.0, 330.0), (10.0, 12.0, 8.0))
    temperatures = np.array([290.0, 300.0, 305.0, 310.0, 320.0, 330.0, 340.0])
    assert line.value_at(temperatures) == pytest.approx([8.0, 10.0, 11.0, 12.0, 10.0, 8.0, 6.0])


def own_oil(model: str, sheet: list[list[float]], **pressure: object) -> dict[str, object]:
    """An oil as its data sheet has it: 0.92 g/cm3 at every temperature."""
    values = dict(read_yaml(FOLDER / "4102.yaml").values)
    return values | {
        "model": model,
        "coefficients": {"kinematic_viscosity_cst": sheet},
        "density_kg_m3": [[300, 920], [400, 920]],
        "pressure_viscosity": {"rule": "so-klaus"} | pressure,
    }


# a polyalphaolefin of grade 6, as data sheets have it: 3 viscosities
SHEET = [[313.15, 40.2], [343.15, 14.8], [373.15, 7.0]]


@pytest.mark.parametrize(
    ("model", "rows"), [("walther", SHEET[::2]), ("vogel", SHEET), ("roelands", SHEET[::2])]
)
def test_own_oil_has_the_viscosities_of_its_data_sheet(model: str, rows: list[list[float]]) -> None:
    oil = MeasuredOil(**own_oil(model, rows)).properties()
    celsius, viscosity = np.array(SHEET).T - np.array([[273.15], [0.0]])
    calculated = oil.kinematic_viscosity_m2_s(celsius) * 1e6
    is_given = np.isin(SHEET, rows)[:, 0]
    np.testing.assert_allclose(calculated[is_given], viscosity[is_given], rtol=1e-9)
    # the laws agree between two temperatures: with the third one to some per cent
    np.testing.assert_allclose(calculated, viscosity, rtol=0.04)
    step = np.log(oil.dynamic_viscosity_pa_s(np.array([69.99, 70.01])))
    beta = oil.temperature_viscosity_coefficient_1_k(70.0)
    assert beta == pytest.approx((step[0] - step[1]) / 0.02, rel=1e-6)


@pytest.mark.parametrize(
    ("pressure", "alpha", "tolerance"),
    [
        # 2 tables' values between their levels; z by its formula, 0.6 (ln 0.03698 + 9.67)/0.1962
        ({"rule": "given", "rows": [[300, 2e-8], [400, 1e-8]]}, 18.685, 1e-3),
        ({"rule": "roelands", "z": 0.6}, 19.49, 1e-3),
        # esters and polyalphaolefins of 40 cSt have 15 to 25 1/GPa at 40 degC
        ({"rule": "so-klaus"}, 20, 0.2),
    ],
)
def test_pressure_viscosity_is_given_or_by_a_rule(
    pressure: dict[str, object], alpha: float, tolerance: float
) -> None:
    oil = MeasuredOil(**own_oil("walther", SHEET[::2], **pressure)).properties()
    calculated = float(oil.pressure_viscosity_coefficient_1_pa(40.0) * 1e9)
    assert calculated == pytest.approx(alpha, rel=tolerance)


@pytest.mark.parametrize(
    ("oil", "words"),
    [
        (own_oil("walther", SHEET), "found 3 viscosities; model: walther needs 2"),
        (own_oil("walther", SHEET[::2], rule="roelands"), "`z` goes with rule: roelands"),
        (
            own_oil("walther", SHEET[::2], rule="given", rows=[[300, 8e-8], [400, 8e-8]]),
            "is 80 1/GPa; expected 5 to 50",
        ),
        (
            own_oil("walther", SHEET[::2], rule="roelands", z=0.15),
            "is 4.872 1/GPa; expected 5 to 50",
        ),
        (own_oil("andrade", SHEET), "`model`: found 'andrade', expected one of 'adore-mil-l-7808'"),
        (read_yaml(FOLDER / "4102.yaml").values | {"model": "adore-mil-l-7808"}, "coefficients"),
    ],
)
def test_own_oil_that_cannot_be_is_refused(oil: dict[str, object], words: str) -> None:
    assert words in str(first_mistake(oil, OilFile))
