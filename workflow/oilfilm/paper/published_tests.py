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

from oilfilm.bearing.friction import Neighbour, friction_equilibrium
from oilfilm.bearing.geometry import Bearing
from oilfilm.paper.reference import PublishedBearingTest, PublishedBearingTests
from oilfilm.settings.resolved import Settings
from oilfilm.torque.bearing_torque import Cases, OilInBearing, joined
from oilfilm.units import RAD_S_PER_RPM

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
    return joined(frames, "published_tests")


def fitted_fraction(test: PublishedBearingTest, oil: OilInBearing, bearing: Bearing) -> float:
    """Share of oil that gives the published power losses best; NaN where the test has none.

    Least squares of the relative errors, so that each speed counts alike.

    Args:
        test: The published test.
        oil: The oil with its law; every other constant is as set.
        bearing: The bearing.
    """
    rows = _rows(test)
    if rows["published_power_w"].isna().all():
        return np.nan
    as_set = _cases(test, oil, bearing, oil.settings.oil_volume_fraction).problem
    known = Neighbour.of(as_set, friction_equilibrium(as_set).solution.unknowns)

    def squares(fraction: float) -> float:
        found = friction_equilibrium(_cases(test, oil, bearing, fraction).problem, known)
        power = found.torque_n_m() * rows["inner_speed_rpm"] * RAD_S_PER_RPM
        return float(np.nansum((power / rows["published_power_w"] - 1) ** 2))

    bounds = 0.0, _LARGEST_FRACTION
    found = scipy.optimize.minimize_scalar(
        squares, bounds=bounds, method="bounded", options={"xatol": _TOLERANCE}
    )
    return float(found.x)


def _one_test(test: PublishedBearingTest, oil: OilInBearing, settings: Settings) -> pd.DataFrame:
    bearing, rows = settings.bearings[test.bearing].bearing(test.bearing), _rows(test)
    speed = rows["inner_speed_rpm"] * RAD_S_PER_RPM
    fractions = *settings.bearing.oil_volume_fraction_range, settings.bearing.oil_volume_fraction
    low, high, as_set = (_cases(test, oil, bearing, fraction).run() for fraction in fractions)
    return as_set.assign(
        **{str(name): values for name, values in rows.items()},
        power_w=as_set["torque_n_m"] * speed,
        power_low_w=low["torque_n_m"] * speed,
        power_high_w=high["torque_n_m"] * speed,
        cage_slip_low=low["cage_slip"],
        cage_slip_high=high["cage_slip"],
        fitted_oil_volume_fraction=fitted_fraction(test, oil, bearing),
        source=test.source,
        assumed=test.assumed,
    )


def _cases(
    test: PublishedBearingTest, oil: OilInBearing, bearing: Bearing, fraction: float
) -> Cases:
    """The rows of a test with a share of oil."""
    points = _rows(test)[["inner_speed_rpm", "axial_load_n"]]
    settings = oil.settings.model_copy(update={"oil_volume_fraction": fraction})
    points["inlet_temperature_c"] = test.inlet_temperature_c
    return Cases(bearing, [(replace(oil, settings=settings), "stress", points)])


def _rows(test: PublishedBearingTest) -> pd.DataFrame:
    """The test's rows; NaN where a row has no such value."""
    names = {"power_w": "published_power_w", "largest_cage_slip": "published_cage_slip"}
    return pd.DataFrame([row.model_dump() for row in test.rows], dtype=float).rename(columns=names)
