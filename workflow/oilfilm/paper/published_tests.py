"""Published tests of bearings beside the calculation, and the drag that fits them best.

The oil's share of the volume between the rings, to which the drag is proportional, is the one
constant of a bearing that no drawing gives. It is fitted to published power losses.

Decides: where the drag in a bearing comes from.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pandas as pd
import scipy

from oilfilm import tables
from oilfilm.bearing.friction import Neighbour, friction_equilibrium
from oilfilm.bearing.geometry import Bearing
from oilfilm.paper.reference import PublishedBearingTest, PublishedBearingTests
from oilfilm.settings.resolved import Settings
from oilfilm.torque.bearing_torque import Cases, OilInBearing
from oilfilm.units import RAD_S_PER_RPM, FloatArray, IndexArray

# Shares of oil among which the fit looks; a tenth of the volume is far more than a sprayed
# bearing holds.
_LARGEST_FRACTION = 0.1
_TOLERANCE = 1e-7


def published_tests_table(
    published: PublishedBearingTests, oils: Sequence[OilInBearing], settings: Settings
) -> pd.DataFrame:
    """Published tests beside the calculated values, with the drag as set and at its range's ends.

    Args:
        published: Content of data/reference/bearing_tests.yaml.
        oils: Oils with their laws; tests with others are left out.
        settings: The settings.
    """
    by_name = {oil.name: oil for oil in oils}
    frames = [
        _one_test(test, by_name[test.oil], settings)
        for test in published.tests
        if test.oil in by_name and test.bearing in settings.bearings
    ]
    joined = pd.concat(frames, ignore_index=True) if frames else tables.empty("published_tests")
    columns = tables.columns("published_tests")
    return tables.conform(joined[columns], "published_tests", "table published_tests")


def fitted_fraction(test: PublishedBearingTest, oil: OilInBearing, bearing: Bearing) -> float:
    """Share of oil that gives the published power losses best; NaN where the test has none.

    Least squares of the relative errors, so that each speed counts alike.

    Args:
        test: The published test.
        oil: The oil with its law; every other constant is as set.
        bearing: The bearing.
    """
    at = _columns(test)
    published, speed = at["published_power_w"], at["inner_speed_rpm"] * RAD_S_PER_RPM
    if np.isnan(published).all():
        return np.nan
    known = _neighbour(test, oil, bearing)

    def squares(fraction: float) -> float:
        cases = _cases(test, oil, bearing, np.full(len(speed), fraction))
        power = friction_equilibrium(cases.problem, known).torque_n_m() * speed
        return float(np.nansum((power / published - 1) ** 2))

    bounds = 0.0, _LARGEST_FRACTION
    found = scipy.optimize.minimize_scalar(
        squares, bounds=bounds, method="bounded", options={"xatol": _TOLERANCE}
    )
    return float(found.x)


def _one_test(test: PublishedBearingTest, oil: OilInBearing, settings: Settings) -> pd.DataFrame:
    bearing, at = settings.bearings[test.bearing].bearing(test.bearing), _columns(test)
    speed = at["inner_speed_rpm"] * RAD_S_PER_RPM
    fractions = *settings.bearing.oil_volume_fraction_range, settings.bearing.oil_volume_fraction
    low, high, as_set = (
        _cases(test, oil, bearing, np.full(len(speed), fraction)).run() for fraction in fractions
    )
    return as_set.assign(
        **at,
        power_w=as_set["torque_n_m"] * speed,
        power_low_w=low["torque_n_m"] * speed,
        power_high_w=high["torque_n_m"] * speed,
        cage_slip_low=low["cage_slip"],
        cage_slip_high=high["cage_slip"],
        fitted_oil_volume_fraction=fitted_fraction(test, oil, bearing),
        oil_volume_fraction_alone=_fractions_alone(test, oil, bearing),
        source=test.source,
        assumed=test.assumed,
    )


def _fractions_alone(test: PublishedBearingTest, oil: OilInBearing, bearing: Bearing) -> FloatArray:
    """Share of oil that gives the published value of each row; NaN where none does."""
    at, known = _columns(test), _neighbour(test, oil, bearing)
    speed, power = at["inner_speed_rpm"] * RAD_S_PER_RPM, at["published_power_w"]

    def error(fraction: FloatArray, rows: IndexArray) -> FloatArray:
        every = np.zeros(len(speed))
        every[rows] = fraction
        found = friction_equilibrium(_cases(test, oil, bearing, every).problem, known)
        slip = found.cage_slip() - at["published_cage_slip"]
        return np.where(np.isnan(power), slip, found.torque_n_m() * speed - power)[rows]

    # late, as in `bearing.heat_balance`
    from scipy.optimize import elementwise  # noqa: PLC0415

    found = elementwise.find_root(
        error,
        (np.zeros(len(speed)), np.full(len(speed), _LARGEST_FRACTION)),
        args=(np.arange(len(speed)),),
        tolerances={"xatol": _TOLERANCE},
    )
    return np.where(found.success, found.x, np.nan)


def _neighbour(test: PublishedBearingTest, oil: OilInBearing, bearing: Bearing) -> Neighbour:
    """Equilibria with the share of oil that is set."""
    fraction = np.full(len(test.rows), oil.settings.oil_volume_fraction)
    problem = _cases(test, oil, bearing, fraction).problem
    return Neighbour.of(problem, friction_equilibrium(problem).solution.unknowns)


def _cases(
    test: PublishedBearingTest, oil: OilInBearing, bearing: Bearing, fractions: FloatArray
) -> Cases:
    """The rows of a test, each with a share of oil."""
    points = pd.DataFrame(_columns(test))[["inner_speed_rpm", "axial_load_n"]]
    points["inlet_temperature_c"] = test.inlet_temperature_c
    of_rows = (
        replace(oil, settings=oil.settings.model_copy(update={"oil_volume_fraction": fraction}))
        for fraction in fractions.tolist()
    )
    groups = [(each, "stress", points.iloc[[row]]) for row, each in enumerate(of_rows)]
    return Cases(bearing, groups)


def _columns(test: PublishedBearingTest) -> dict[str, FloatArray]:
    """The test's rows, an array a column; NaN where a row has no such value."""
    names = {
        "inner_speed_rpm": "inner_speed_rpm",
        "axial_load_n": "axial_load_n",
        "power_w": "published_power_w",
        "largest_cage_slip": "published_cage_slip",
    }
    return {
        column: np.array([getattr(row, name) for row in test.rows], dtype=float)
        for name, column in names.items()
    }
