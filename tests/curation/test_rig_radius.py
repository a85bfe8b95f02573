"""Load and pressure that are both stated say the radius of the ball; another one is refused."""

import numpy as np
import pytest

from bad_logs import CONFIG, UNITS, csv, good
from oilfilm.curation.curate import curate_logs

RIG = CONFIG.rigs["ball-on-disc-20mm"]
CONTACT = RIG.contact()
assert CONTACT is not None
LOAD_N = float(np.median(good()["load"]))
# p0 = (6 w E*^2 / (pi^3 R^2))^(1/3), with E* of two equal bodies E/(2 (1 - nu^2))
ball = RIG.ball
assert ball is not None
MODULUS_PA = ball.youngs_modulus_pa / 2 / (1 - ball.poisson_ratio**2)
PRESSURE_GPA = 1e-9 * (6 * LOAD_N * MODULUS_PA**2 / (np.pi**3 * CONTACT.radius_m**2)) ** (1 / 3)


@pytest.mark.parametrize(("factor", "is_refused"), [(1.0, False), (1.02, False), (1.21, True)])
def test_pressure_of_the_header_beside_a_load(factor: float, is_refused: bool) -> None:
    """A ball of 0.75 times the radius has 1.21 times the pressure."""
    log = csv(max_hertz_pressure_gpa=PRESSURE_GPA * factor, load_n=LOAD_N)
    quarantine = curate_logs([("log", log)], CONFIG).quarantine
    reasons = quarantine.loc[quarantine["rule"] == "rig_radius", "reason"]
    assert len(reasons) == is_refused
    for reason in reasons:
        assert "ball_radius_m 0.01" in reason
        assert f"radius of {0.01 / factor**1.5:.2g}"[:14] in reason


@pytest.mark.parametrize(("factor", "is_refused"), [(1.0, False), (1.21, True)])
def test_column_of_the_pressure_beside_a_load(factor: float, is_refused: bool) -> None:
    stated = np.full_like(good()["load"], PRESSURE_GPA * factor)
    name = "stated_max_hertz_pressure_gpa"
    log = csv({**good(), "max_hertz_pressure": stated}, {**UNITS, "max_hertz_pressure": "GPa"})
    log = log.replace(b"max_hertz_pressure [GPa]", name.encode())
    rules = curate_logs([("log", log)], CONFIG).quarantine["rule"].tolist()
    assert ("rig_radius" in rules) == is_refused
