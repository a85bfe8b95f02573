"""The oil that holds the cage, beside the paper's rules: planted slips, torques and films."""

from typing import Any

import numpy as np
import pandas as pd
import pytest

from oilfilm import tables
from oilfilm.paper.slip_advice import advise
from oilfilm.settings.resolved import Settings

# the paper's own order of viscosity, and of traction as it has it
OILS = ("4102", "4050", "4010")


def operating_point(
    number: int,
    slip: tuple[float, ...],
    torque: tuple[float, ...] = (3.0, 2.0, 1.0),
    film: tuple[float, ...] = (9.0, 8.0, 7.0),
    pressure_gpa: float = 1.5,
) -> list[dict[str, Any]]:
    """One operating point with each oil; by default the thinner oil has less torque."""
    return [
        {
            "bearing": "any",
            "oil": oil,
            "inlet_temperature_c": 70.0,
            "pitch_speed_mm_rpm": 1e6 * number,
            "inner_speed_rpm": 6000.0 * number,
            "axial_load_n": 1e4,
            "cage_slip": slip[index],
            "torque_n_m": torque[index],
            "lambda_ratio": film[index],
            "inner_max_hertz_pressure_gpa": pressure_gpa,
            "outer_max_hertz_pressure_gpa": 0.9 * pressure_gpa,
            "entrainment_speed_m_s": 50.0,
        }
        for index, oil in enumerate(OILS)
    ]


# slip of (4102, 4050, 4010), other numbers; then rule, advised oil, best oil, judgement
NAN = np.nan
CASES: dict[str, tuple[tuple[float, ...], dict[str, Any], tuple[str, str, str, str]]] = {
    "nothing slips": ((0.01, 0.01, 0.01), {}, ("little slip", "4010", "4010", "agree")),
    "4010 slips, 4050 holds": ((0.02, 0.1, 0.3), {}, ("slipping", "4050", "4050", "agree")),
    "only 4102 holds: it is necessary": (
        *((0.1, 0.2, 0.3), {}),
        ("slipping", "4102", "4102", "agree"),
    ),
    "nothing holds, and 4010 slips least": (
        *((0.4, 0.3, 0.2), {}),
        ("slipping", "4102", "4010", "slips more"),
    ),
    "4102 has less torque than 4050, and both hold": (
        *((0.02, 0.1, 0.3), {"torque": (1.5, 2.0, 1.0)}),
        ("slipping", "4050", "4102", "heats more"),
    ),
    "five percent of torque is no matter": (
        *((0.02, 0.1, 0.3), {"torque": (1.95, 2.0, 1.0)}),
        ("slipping", "4050", "4102", "agree"),
    ),
    "under light load 4102 slips as 4050 does, 4010 does not": (
        *((0.3, 0.3, 0.1), {"pressure_gpa": 0.9}),
        ("slipping", "4102", "4010", "slips"),
    ),
    "under light load 4102 is advised though 4010 holds with less torque": (
        *((0.01, 0.01, 0.01), {"pressure_gpa": 0.9}),
        ("light load", "4102", "4010", "heats more"),
    ),
    "4010 has no film": (
        *((0.01, 0.02, 0.0), {"film": (9.0, 8.0, 2.9)}),
        ("little slip", "4050", "4050", "agree"),
    ),
    "of one oil the film is not known, and it would be chosen": (
        *((0.01, 0.02, 0.01), {"film": (9.0, 8.0, NAN)}),
        ("little slip", "4050", "4050", "outside the film formula"),
    ),
    "of one oil the film is not known, and it would not be chosen": (
        *((0.01, 0.02, 0.01), {"film": (NAN, 8.0, 7.0)}),
        ("little slip", "4010", "4010", "agree"),
    ),
    "no film is known": (
        *((0.01, 0.02, 0.01), {"film": (NAN, NAN, NAN)}),
        ("little slip", "", "", "outside the film formula"),
    ),
    "no oil has film": (
        *((0.01, 0.02, 0.0), {"film": (2.0, 2.0, 2.0)}),
        ("little slip", "", "", "no film"),
    ),
    "without equilibrium an oil is no choice": (
        *((0.01, 0.02, NAN), {"film": (9.0, 8.0, NAN)}),
        ("little slip", "4050", "4050", "agree"),
    ),
}


@pytest.mark.parametrize(("slip", "others", "expected"), CASES.values(), ids=CASES)
def test_slip_decides_as_an_engineer_would(
    config: Settings, slip: tuple[float, ...], others: dict[str, Any], expected: tuple[str, ...]
) -> None:
    rows = pd.DataFrame(operating_point(1, slip, **others))
    advice = advise(rows, config.selection, config.gates.lambda_limit)
    columns = ["selection_rule", "advised_oil", "best_oil", "judgement"]
    assert tuple(advice[columns].iloc[0]) == expected


@pytest.mark.parametrize(
    ("reading", "million_mm_rpm", "rule"),
    [
        ("kinematic", 1.9, "little slip"),
        ("kinematic", 2.0, "hot and fast"),  # half of dmN 4e6
        ("paper", 3.8, "little slip"),  # 99 m/s
        ("paper", 3.9, "hot and fast"),  # 102 m/s
    ],
)
def test_speed_of_the_bearing_is_fast_by_the_reading(
    config: Settings, reading: str, million_mm_rpm: float, rule: str
) -> None:
    rows = pd.DataFrame(operating_point(1, (0.01, 0.01, 0.01)))
    rows = rows.assign(pitch_speed_mm_rpm=million_mm_rpm * 1e6, inlet_temperature_c=120.0)
    chosen = config.with_changes({"selection": {"reading": reading}}).selection
    assert advise(rows, chosen, 3.0)["selection_rule"].tolist() == [rule]


@pytest.mark.parametrize("reading", ["kinematic", "paper"])
@pytest.mark.parametrize(("slip", "rule"), [(0.15, "little slip"), (0.151, "slipping")])
def test_limit_of_cage_slip_is_the_same_in_both_readings(
    config: Settings, reading: str, slip: float, rule: str
) -> None:
    rows = pd.DataFrame(operating_point(1, (0.01, 0.01, slip)))
    chosen = config.with_changes({"selection": {"reading": reading}}).selection
    assert advise(rows, chosen, 3.0)["selection_rule"].tolist() == [rule]


def test_each_operating_point_is_judged_by_itself(config: Settings) -> None:
    rows = operating_point(1, (0.01, 0.01, 0.01)) + operating_point(2, (0.1, 0.2, 0.3))
    advice = advise(pd.DataFrame(rows).sample(frac=1, random_state=1), config.selection, 3.0)
    advice = advice.set_index("pitch_speed_mm_rpm")
    assert advice["oils_within_limit"].str.split("; ").map(set).to_dict() == {
        1e6: set(OILS),
        2e6: {"4102"},
    }
    assert advice["slip_that_decides"].to_dict() == {1e6: 0.01, 2e6: 0.3}
    assert advice.loc[2e6, "advised_cage_slip"] == 0.1
    assert advice.loc[1e6, "best_torque_n_m"] == 1.0


def test_without_an_oil_of_the_rules_there_is_no_advice(config: Settings) -> None:
    rows = [row for row in operating_point(1, (0.0, 0.0, 0.0)) if row["oil"] != "4050"]
    assert advise(pd.DataFrame(rows), config.selection, 3.0).empty
    assert advise(tables.empty("cage_slip"), config.selection, 3.0).empty
