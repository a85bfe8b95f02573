"""The map with the true traction, beside that by the fitted law."""

import numpy as np
import pandas as pd
import pytest

from campaigns import ROOT, printed
from oilfilm.settings.resolve import resolve
from oilfilm.torque.bearing_torque import CaseGroup, FrictionCases, oils_in_bearings
from planted_fits import printed_fits
from simulated_lab.true_bearing import true_cage_slip_map

POINTS = pd.DataFrame(
    {
        "axial_load_n": [10000.0, 20000.0, 10000.0],
        "inner_speed_rpm": [6000.0, 12000.0, 18000.0],
        "inlet_temperature_c": 100.0,
    }
)


def by_law(changed: float = 1.0) -> pd.DataFrame:
    """The map by the printed law with a factor on all traction, with intervals of 10 %."""
    settings = resolve(ROOT / "config", {"campaign": "demo"})
    oils = [oil for oil in oils_in_bearings(*printed_fits(), settings) if oil.name == "4050"]
    points = POINTS.assign(traction_factor=changed)
    calculated = FrictionCases(
        settings.tested_bearing(), [CaseGroup(oil, "stress", points) for oil in oils]
    ).calculate()
    for name in ("cage_slip", "torque_n_m"):
        calculated[f"{name}_lower"] = 0.9 * calculated[name]
        calculated[f"{name}_upper"] = 1.1 * calculated[name]
    return calculated


def test_the_law_that_made_the_logs_is_the_truth() -> None:
    truth = true_cage_slip_map(by_law(), resolve(ROOT / "config", {"campaign": "demo"}), printed())
    # 8 x 2 quadrature nodes in place of 16 x 4
    np.testing.assert_allclose(truth["cage_slip"], truth["law_cage_slip"], rtol=0.01)
    np.testing.assert_allclose(truth["torque_n_m"], truth["law_torque_n_m"], rtol=0.002)
    assert truth["cage_slip_inside"].all()
    assert truth["torque_inside"].all()


def test_a_law_with_half_of_the_traction_is_off_by_the_slip_that_it_lacks() -> None:
    truth = true_cage_slip_map(
        by_law(0.5), resolve(ROOT / "config", {"campaign": "demo"}), printed()
    )
    right = true_cage_slip_map(by_law(), resolve(ROOT / "config", {"campaign": "demo"}), printed())
    np.testing.assert_allclose(truth["cage_slip"], right["cage_slip"])
    assert (truth["law_cage_slip"] > 1.2 * truth["cage_slip"]).all()
    assert not truth["cage_slip_inside"].any()


def test_nothing_is_said_where_an_interval_is_missing() -> None:
    without = by_law().assign(cage_slip_lower=np.nan)
    truth = true_cage_slip_map(without, resolve(ROOT / "config", {"campaign": "demo"}), printed())
    assert truth["cage_slip_inside"].isna().all()
    assert truth["torque_inside"].notna().all()


@pytest.mark.parametrize("column", ["cage_slip", "torque_n_m", "lambda_ratio"])
def test_truth_has_all_that_the_choice_of_oil_needs(column: str) -> None:
    truth = true_cage_slip_map(by_law(), resolve(ROOT / "config", {"campaign": "demo"}), printed())
    assert truth[column].notna().all()
