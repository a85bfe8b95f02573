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
from oilfilm.bearing.geometry import Bearing
from oilfilm.paper.reference import PublishedBearingTest, PublishedBearingTests
from oilfilm.settings.resolved import Settings
from oilfilm.torque.bearing_torque import OilInBearing
from oilfilm.units import RAD_S_PER_RPM, FloatArray

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
    published = _columns(test)["published_power_w"]
    if np.isnan(published).all():
        return np.nan

    def squares(fraction: float) -> float:
        power = _run(test, oil, bearing, fraction)["power_w"].to_numpy()
        return float(np.nansum((power / published - 1) ** 2))

    bounds = 0.0, _LARGEST_FRACTION
    found = scipy.optimize.minimize_scalar(
        squares, bounds=bounds, method="bounded", options={"xatol": _TOLERANCE}
    )
    return float(found.x)


def _one_test(test: PublishedBearingTest, oil: OilInBearing, settings: Settings) -> pd.DataFrame:
    bearing = settings.bearings[test.bearing].bearing(test.bearing)
    low, high = (
        _run(test, oil, bearing, end) for end in settings.bearing.oil_volume_fraction_range
    )
    return _run(test, oil, bearing, settings.bearing.oil_volume_fraction).assign(
        **_columns(test),
        power_low_w=low["power_w"],
        power_high_w=high["power_w"],
        cage_slip_low=low["cage_slip"],
        cage_slip_high=high["cage_slip"],
        fitted_oil_volume_fraction=fitted_fraction(test, oil, bearing),
        oil_volume_fraction_alone=[
            _fraction_alone(test.model_copy(update={"rows": [row]}), oil, bearing)
            for row in test.rows
        ],
        source=test.source,
        assumed=test.assumed,
    )


def _fraction_alone(test: PublishedBearingTest, oil: OilInBearing, bearing: Bearing) -> float:
    """Share of oil that gives the published value of a test of one row; NaN where none does."""
    published = _columns(test)
    name = "cage_slip" if np.isnan(published["published_power_w"]).any() else "power_w"
    value = published[f"published_{name}"].item()

    def error(fraction: float) -> float:
        return _run(test, oil, bearing, fraction)[name].item() - value

    if not error(0.0) < 0 < error(_LARGEST_FRACTION):
        return np.nan
    return float(scipy.optimize.brentq(error, 0.0, _LARGEST_FRACTION, xtol=_TOLERANCE))


def _run(
    test: PublishedBearingTest, oil: OilInBearing, bearing: Bearing, fraction: float
) -> pd.DataFrame:
    """Calculated friction of each row with a share of oil."""
    settings = oil.settings.model_copy(update={"oil_volume_fraction": fraction})
    at = _columns(test)
    terms = replace(oil, settings=settings).run(
        bearing, at["axial_load_n"], at["inner_speed_rpm"], test.inlet_temperature_c
    )
    return terms.assign(power_w=terms["torque_n_m"] * at["inner_speed_rpm"] * RAD_S_PER_RPM)


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
