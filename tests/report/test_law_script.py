"""The script of the report computes the interval of Python."""

import json
import shutil
import subprocess

import numpy as np
import pytest

from oilfilm.report.explorer import law_of
from oilfilm.report.law_script import law_script
from oilfilm.traction import LAWS
from planted_fits import planted_fit

NODE = shutil.which("node")


@pytest.mark.skipif(NODE is None, reason="Node.js, which runs the script, is not installed")
def test_script_gives_mu_and_interval_of_python_at_random_conditions() -> None:
    fits = {name: planted_fit(law) for name, law in LAWS.items()}
    points = np.random.default_rng(2).uniform([0.5, 5, 5, 0], [3, 250, 180, 0.5], (200, 4))
    points[:10, 3] = 0
    asked = json.dumps([[law_of(fit, factor) for fit, factor, _ in fits.values()], points.tolist()])
    script = f"""{law_script(LAWS.values())}
const [fits, points] = {asked};
const ends = ({{ mu, lower, upper }}) => [mu, lower, upper].map((value) => value.toString());
console.log(JSON.stringify(fits.map((fit) => points.map((point) => ends(traction(fit, point))))));
"""
    run = subprocess.run(
        [str(NODE), "-"], input=script, capture_output=True, text=True, check=True, timeout=60
    )
    for (fit, factor, power), made in zip(fits.values(), json.loads(run.stdout), strict=True):
        conditions = np.column_stack([factor * points[:, 0] ** power, points[:, 1:3]])
        conditions[:, 1] = np.nan  # on the tested line
        expected = fit.predict(conditions, points[:, 3])
        mu, lower, upper = np.array(made, dtype=float).T
        assert not np.isnan(expected.obs_ci_upper).any()
        assert (expected.obs_ci_lower <= expected.traction_coefficient).all()
        np.testing.assert_allclose(mu, expected.traction_coefficient, rtol=1e-9, atol=1e-15)
        np.testing.assert_allclose(lower, expected.obs_ci_lower, rtol=1e-9, atol=1e-15)
        np.testing.assert_allclose(upper, expected.obs_ci_upper, rtol=1e-9, atol=1e-15)
