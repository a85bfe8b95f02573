import numpy as np
import pytest

from bearings import FOLDER, SHIPPED, shipped
from oilfilm.physics.contact import elliptical_contact
from oilfilm.settings.messages import first_mistake, load
from oilfilm.settings.resolved import merge
from oilfilm.settings.rig import BallMaterial, BearingFile
from oilfilm.settings.yaml_file import read_yaml


@pytest.mark.parametrize("name", [*SHIPPED, "template"])
def test_contacts_under_unit_load_are_exactly_hertz(name):
    bearing = shipped(name)
    cosine = np.linspace(0, 1, 50)[:, np.newaxis] * np.ones(2)
    exact = elliptical_contact(
        1.0, bearing.radius_x_m(cosine), bearing.radius_y_m, bearing.reduced_modulus_pa
    )
    stiffness, a_x, a_y = bearing.under_unit_load(cosine)
    np.testing.assert_allclose(stiffness, exact.approach_m**-1.5, rtol=1e-13)
    np.testing.assert_allclose(a_x, exact.semi_axis_x_m, rtol=1e-13)
    np.testing.assert_allclose(a_y, exact.semi_axis_y_m, rtol=1e-13)


def test_a_hybrid_bearing_is_stiffer_and_its_balls_lighter():
    config = load(FOLDER / "harris-218.yaml", BearingFile)
    ceramic = BallMaterial(youngs_modulus_pa=310e9, poisson_ratio=0.26, density_kg_m3=3200)
    steel, hybrid = (
        config.model_copy(update={"ball": ball}).bearing("218") for ball in (config.ball, ceramic)
    )
    assert hybrid.reduced_modulus_pa > steel.reduced_modulus_pa
    assert hybrid.ball_mass_kg / steel.ball_mass_kg == pytest.approx(3200 / 7833)


@pytest.mark.parametrize(
    ("changes", "key", "words"),
    [
        ({"ball_count": 18}, "ball_count", "there is room for 17"),
        ({"ball_count": 16.5}, "ball_count", "a whole number"),
        ({"inner_groove_curvature": 0.5}, "inner_groove_curvature", "more than 0.5"),
        ({"contact_angle_deg": 90.0}, "contact_angle_deg", "less than 90"),
        ({"ball_diameter_m": 0.07, "ball_count": 3}, "ball_diameter_m", "less than half"),
        ({"cage": {"guidance": "inner"}}, "cage.land_diameter_m", "guidance: inner"),
        ({"cage": {"land_diameter_m": 0.2}}, "cage.land_diameter_m", "far side"),
        ({"cage": {"land_clearance_m": 0.02}}, "cage.land_clearance_m", "well below"),
    ],
)
def test_impossible_geometry_is_refused_by_name(changes, key, words):
    changed = merge(read_yaml(FOLDER / "harris-218.yaml").values, changes)
    mistake = first_mistake(changed, BearingFile)
    assert mistake.startswith(f"`{key}`: found")
    assert words in mistake
