"""What heated oil changes in the bearing's tables."""

import numpy as np
import pandas as pd
import pytest

from campaigns import LABORATORY
from oilfilm import tables
from oilfilm.settings.resolve import resolve
from oilfilm.settings.resolved import Settings
from oilfilm.torque.bearing_torque import OilInBearing, cage_slip_table, oils_in_bearings
from oilfilm.torque.best_oil import best_oil_table
from oilfilm.torque.heat_balance import heat_balance_table
from planted_fits import printed_fits

MAP = {"pitch_speed_mm_rpm": [1e6, 3e6], "axial_load_n": [1000, 20000]}


@pytest.fixture(scope="module")
def config() -> Settings:
    return resolve(LABORATORY, {}).with_changes({"bearing": {"cage_slip": MAP}})


@pytest.fixture(scope="module")
def oils(config: Settings) -> list[OilInBearing]:
    return oils_in_bearings(*printed_fits(), config)


@pytest.fixture(scope="module")
def slip(config: Settings, oils: list[OilInBearing]) -> pd.DataFrame:
    return cage_slip_table(oils, config)


@pytest.fixture(scope="module")
def table(config: Settings, oils: list[OilInBearing], slip: pd.DataFrame) -> pd.DataFrame:
    return heat_balance_table(oils, slip, tables.empty_table("torque"), config)


@pytest.mark.slow
def test_heated_oil_on_the_map_takes_its_share_and_the_best_oil_is_found_again(
    config, oils, slip, table
):
    assert len(table) == len(slip)
    assert table["balanced"].all()
    (of_4050,) = (oil.properties for oil in oils if oil.name == "4050")
    rows = table[table["oil"] == "4050"]
    # 8 L/min, c_p 2000 J/(kg K) (docs/physics.md, Oils), share 0.8 of torque times speed
    rise = rows["outlet_temperature_c"] - 100
    carried_heat = of_4050.density_kg_m3(100.0) * 8e-3 / 60 * 2000 * rise
    friction_heat = rows["heated_torque_n_m"] * rows["inner_speed_rpm"] * np.pi / 30
    np.testing.assert_allclose(carried_heat, 0.8 * friction_heat, rtol=1e-5)
    np.testing.assert_allclose(rows["heat_w"], friction_heat)
    np.testing.assert_allclose(rows["contact_temperature_c"], 100 + rise / 2)
    # the columns of the inlet are those of the map
    inlet_rows = slip.set_index(["oil", "inner_speed_rpm", "axial_load_n"])
    heated_rows = table.set_index(["oil", "inner_speed_rpm", "axial_load_n"]).loc[inlet_rows.index]
    np.testing.assert_array_equal(heated_rows["torque_n_m"], inlet_rows["torque_n_m"])
    # hot oil has thinner films and less torque, where balls roll rather than skid
    rolling = heated_rows.xs(20000, level="axial_load_n")
    assert (rolling["heated_lambda_ratio"] < rolling["lambda_ratio"]).all()
    assert (rolling["heated_torque_n_m"] < rolling["torque_n_m"]).all()
    limits = config.bearing.cage_slip.slip_limit, config.gates.lambda_limit
    best = best_oil_table(slip, *limits).set_index(["inner_speed_rpm", "axial_load_n"])["best_oil"]
    assert (rows.set_index(["inner_speed_rpm", "axial_load_n"])["best_oil"] == best).all()


@pytest.mark.slow
def test_heated_oil_is_given_speed_with_the_mass_flow_of_the_inlet(config, oils, table):
    rows = table[(table["oil"] == "4050") & (table["axial_load_n"] == 20000)]
    (oil,) = (oil for oil in oils if oil.name == "4050")
    # without a balance, the flow at the contacts' temperature has the density there
    at_contacts = oil.calculate(
        config.tested_bearing(),
        rows["axial_load_n"],
        rows["inner_speed_rpm"],
        rows["contact_temperature_c"],
    )
    density = oil.properties.density_kg_m3
    lighter_kg_m3 = density(100.0) - density(rows["contact_temperature_c"].to_numpy())
    # 8 L/min leave the ring at 72.608 mm: m' omega r^2, of the mass that the inlet has more
    speed_rad_s = rows["inner_speed_rpm"].to_numpy() * np.pi / 30
    lacking_n_m = lighter_kg_m3 * 8e-3 / 60 * speed_rad_s * 72.608e-3**2
    difference_n_m = rows["heated_torque_n_m"].to_numpy() - at_contacts["torque_n_m"].to_numpy()
    assert lacking_n_m.max() > 0.01
    np.testing.assert_allclose(difference_n_m, lacking_n_m, rtol=1e-3, atol=1e-6)


def test_without_a_known_flow_there_is_no_balance(config, oils):
    file = config.bearings["mainshaft-167"].model_copy(update={"oil_supply": None})
    unknown = config.model_copy(update={"bearings": config.bearings | {"mainshaft-167": file}})
    table = heat_balance_table(
        oils, tables.empty_table("cage_slip"), tables.empty_table("torque"), unknown
    )
    assert table.empty
