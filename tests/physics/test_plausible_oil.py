"""A file of an oil with a mistyped number is refused, or its doubt is said; true oils pass."""

from pathlib import Path

import numpy as np
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from campaigns import ROOT
from oilfilm.base.errors import OilfilmError
from oilfilm.settings.messages import first_mistake, load
from oilfilm.settings.resolve import resolve
from oilfilm.settings.rig import MeasuredOil, OilFile

SHIPPED = ("4010", "4050", "4102")
KELVIN_40, KELVIN_70, KELVIN_100 = 313.15, 343.15, 373.15
# A made-up mineral oil of 52 cSt at 40 degC and 7.4 cSt at 100 degC.
PLAIN = {
    "id": "own",
    "name": "own",
    "display_name": "own",
    "model": "walther",
    "nominal_kinematic_viscosity_100c_cst": 7.4,
    "stand_in": False,
    "note": "made up",
    "source": "made up",
    "coefficients": {"kinematic_viscosity_cst": [[KELVIN_40, 52.0], [KELVIN_100, 7.4]]},
    "pressure_viscosity": {"rule": "so-klaus"},
    "density_kg_m3": [[298.15, 865.0], [373.15, 815.0]],
    "specific_heat_j_kgk": [[300.0, 2000.0], [422.0, 2100.0]],
    "thermal_conductivity_w_mk": [[300.0, 0.14], [422.0, 0.13]],
}


def oil(**changes: object) -> dict[str, object]:
    return {**PLAIN, **changes}


def with_rows(model: str, rows: list[list[float]], **changes: object) -> dict[str, object]:
    return oil(model=model, coefficients={"kinematic_viscosity_cst": rows}, **changes)


@pytest.mark.parametrize("name", SHIPPED)
def test_shipped_oils_are_possible_wherever_the_rig_runs(name: str) -> None:
    file = load(ROOT / f"config/oils/{name}.yaml", OilFile)
    assert list(file.faults(20.0, 150.0)) == []
    assert list(file.doubts()) == []


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(
    ("values", "parts"),
    [
        # 46.9 typed for 16.9; the pole by hand: ln 52/46.9 over ln 46.9/7.4 is 0.0656, 377.6 K
        (
            with_rows("vogel", [[KELVIN_40, 52.0], [KELVIN_70, 46.9], [KELVIN_100, 7.4]]),
            ["kinematic_viscosity_cst", "pole at 378 K (104 degC)"],
        ),
        (
            with_rows("vogel", [[KELVIN_40, 52.0], [KELVIN_70, 10.0], [KELVIN_100, 7.4]]),
            ["kinematic_viscosity_cst", "pole at 299 K"],
        ),
        *(
            (with_rows(model, rows), ["kinematic_viscosity_cst", "falls with temperature"])
            for model in ("walther", "roelands")
            for rows in (
                [[KELVIN_40, 7.4], [KELVIN_100, 52.0]],
                [[KELVIN_40, 7.4], [KELVIN_100, 7.4]],
            )
        ),
        (
            with_rows("vogel", [[KELVIN_40, 52.0], [KELVIN_70, 7.4], [KELVIN_100, 16.9]]),
            ["found 7.4 cSt at 343.15 K and 16.9 cSt at 373.15 K"],
        ),
        (with_rows("walther", [[373.15, 7.4], [373.1500001, 7.3999]]), ["at least 10 K apart"]),
        (oil(density_kg_m3=[[298.15, 815.0], [373.15, 865.0]]), ["`density_kg_m3`", "rises"]),
        (oil(density_kg_m3=[[298.15, 865.0], [373.15, 515.0]]), ["`density_kg_m3`", "falls by"]),
    ],
)
def test_mistyped_number_ends_in_a_sentence(values: dict[str, object], parts: list[str]) -> None:
    mistake = first_mistake(values, OilFile)
    for part in parts:
        assert part in mistake


def test_place_of_a_mistyped_viscosity_is_named(tmp_path: Path) -> None:
    path = tmp_path / "own.yaml"
    values = with_rows("vogel", [[KELVIN_40, 52.0], [KELVIN_70, 46.9], [KELVIN_100, 7.4]])
    path.write_text(yaml.safe_dump(values, sort_keys=False), "utf-8")
    line = path.read_text("utf-8").splitlines().index("  kinematic_viscosity_cst:") + 1
    with pytest.raises(OilfilmError, match=rf"own\.yaml, line {line}: "):
        load(path, OilFile)


def test_oil_is_judged_over_the_temperatures_of_its_campaign(tmp_path: Path) -> None:
    """A pressure-viscosity coefficient of rows at 40 and 100 degC falls below 0 at 220 degC."""
    folder = tmp_path / "config"
    for kind in ("oils", "campaigns"):
        (folder / kind).mkdir(parents=True)
    rows = [[KELVIN_40, 1.8e-8], [KELVIN_100, 0.8e-8]]
    values = oil(pressure_viscosity={"rule": "given", "rows": rows})
    (folder / "oils/own.yaml").write_text(yaml.safe_dump(values), "utf-8")
    (folder / "config.yaml").write_text("campaign: june\n", "utf-8")
    campaign = {
        "data": "measured",
        "description": "one oil",
        "rigs": ["ball-on-disc-20mm"],
        "oils": ["own"],
        "figures": ["curves"],
    }
    for temperature_c, is_refused in ((100.0, False), (160.0, True)):
        campaign["set_points"] = {"inlet_temperature_c": temperature_c}
        (folder / "campaigns/june.yaml").write_text(yaml.safe_dump(campaign), "utf-8")
        if is_refused:
            with pytest.raises(OilfilmError, match=r"own\.yaml, line \d+, `pressure_viscosity`"):
                resolve(folder, {})
        else:
            resolve(folder, {})


def vogel_cst(a_cst: float, b_k: float, pole_k: float, temperature_k: float) -> float:
    return float(a_cst * np.exp(b_k / (temperature_k - pole_k)))


# Viscosity at 100 degC in cSt, and b and T_0 of Vogel's formula, in K: oils of a viscosity index
# of about -50 (3 cSt, 750 K, 185 K) to 250. Oils beyond are not usual.
vogel_oils = st.tuples(st.floats(3.0, 30.0), st.floats(750.0, 1200.0), st.floats(140.0, 185.0))


def has_usual_slope(true: tuple[float, float, float]) -> bool:
    """Whether Walther's line between 40 and 100 degC has a slope that is well within usual ones."""
    at_100_cst, b_k, pole_k = true
    at_40_cst = at_100_cst * vogel_cst(1.0, b_k, pole_k, KELVIN_40)
    at_40_cst /= vogel_cst(1.0, b_k, pole_k, KELVIN_100)
    ends = [np.log10(np.log10(each + 0.7)) for each in (at_40_cst, at_100_cst)]
    slope = (ends[0] - ends[1]) / np.log10(KELVIN_100 / KELVIN_40)
    return bool(1.6 < slope < 4.9)


def has_usual_rows(rows: list[list[float]]) -> bool:
    """Whether Walther's line through two viscosities has the slope of a usual oil."""
    (first_k, first_cst), (last_k, last_cst) = rows
    ends = [np.log10(np.log10(each + 0.7)) for each in (first_cst, last_cst)]
    return bool(1.5 <= (ends[0] - ends[1]) / np.log10(last_k / first_k) <= 5.0)


true_oils = vogel_oils.filter(has_usual_slope)


def rows_of(true: tuple[float, float, float], temperatures_k: list[float]) -> list[list[float]]:
    at_100_cst, b_k, pole_k = true
    a_cst = at_100_cst / vogel_cst(1.0, b_k, pole_k, KELVIN_100)
    # a data sheet has three digits
    return [[t, float(f"{vogel_cst(a_cst, b_k, pole_k, t):.3g}")] for t in temperatures_k]


MODELS = {
    "walther": [KELVIN_40, KELVIN_100],
    "roelands": [KELVIN_40, KELVIN_100],
    "vogel": [KELVIN_40, KELVIN_70, KELVIN_100],
}


def judged(model: str, rows: list[list[float]], nominal_cst: float) -> tuple[str, list[str]]:
    """The mistake in a file of an oil, and what is unusual where there is none."""
    values = with_rows(
        model,
        rows,
        nominal_kinematic_viscosity_100c_cst=nominal_cst,
        pressure_viscosity={"rule": "roelands", "z": 0.6},
    )
    mistake = first_mistake(values, OilFile)
    if mistake:
        return mistake, []
    return "", list(MeasuredOil.model_validate(values).doubts())


@given(true_oils, st.sampled_from(sorted(MODELS)))
def test_true_oils_pass(true: tuple[float, float, float], model: str) -> None:
    assert judged(model, rows_of(true, MODELS[model]), true[0]) == ("", [])


@given(
    true_oils,
    st.sampled_from(sorted(MODELS)),
    st.integers(0, 2),
    st.sampled_from([0.01, 0.1, 10.0, 100.0]),
)
def test_decimal_point_in_the_wrong_place_is_refused_or_said(
    true: tuple[float, float, float], model: str, row: int, factor: float
) -> None:
    rows = rows_of(true, MODELS[model])
    rows[row % len(rows)][1] *= factor
    mistake, doubts = judged(model, rows, true[0])
    # two wrong viscosities may be those of another usual oil: nothing can tell
    assert mistake or doubts or (model != "vogel" and has_usual_rows(rows))


@given(true_oils, st.sampled_from([1 / 1.5, 1 / 1.3, 1.3, 1.5, 2.0, 2.8]))
def test_mistyped_middle_viscosity_of_three_is_refused_or_said(
    true: tuple[float, float, float], factor: float
) -> None:
    rows = rows_of(true, MODELS["vogel"])
    rows[1][1] *= factor
    mistake, doubts = judged("vogel", rows, true[0])
    assert mistake or doubts


@given(true_oils, st.sampled_from(sorted(MODELS)), st.data())
def test_swapped_viscosities_are_refused(
    true: tuple[float, float, float], model: str, data: st.DataObject
) -> None:
    rows = rows_of(true, MODELS[model])
    first, second = data.draw(
        st.lists(st.integers(0, len(rows) - 1), min_size=2, max_size=2, unique=True)
    )
    rows[first][1], rows[second][1] = rows[second][1], rows[first][1]
    mistake, _ = judged(model, rows, true[0])
    assert "falls with temperature" in mistake
