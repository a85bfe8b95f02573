"""Published tests of bearings beside the calculation.

The drag is proportional to the share of oil in the space between the rings. No drawing gives this
share. A published power loss needs a small share or none. A published cage slip needs a large one.
No share fits both.

Decides: where the drag in a bearing comes from.
"""

from collections.abc import Sequence
from dataclasses import replace

import pandas as pd

from deng2026_study.reference import PublishedBearingTest, PublishedBearingTests
from oilfilm.base.units import RAD_S_PER_RPM
from oilfilm.settings.resolved import Settings
from oilfilm.torque.bearing_torque import CaseGroup, FrictionCases, OilInBearing, stack_tables


def published_tests_table(
    published_tests: PublishedBearingTests, oils: Sequence[OilInBearing], settings: Settings
) -> pd.DataFrame:
    """Published tests beside calculated values, for three oil volume fractions.

    These are the configured one and both ends of `bearing.oil_volume_fraction_range`.

    Args:
        published_tests: Content of reference/bearing_tests.yaml.
        oils: Oils with their laws. Tests with another oil are left out, and so are those of a
            bearing that is not configured.
        settings: The settings.

    Returns:
        The table `published_tests`.
    """
    oil_by_name = {oil.name: oil for oil in oils}
    frames = [
        _rows_of_test(test, oil_by_name[test.oil], settings)
        for test in published_tests.tests
        if test.oil in oil_by_name and test.bearing in settings.bearings
    ]
    return stack_tables(frames, "published_tests")


def _rows_of_test(
    test: PublishedBearingTest, oil: OilInBearing, settings: Settings
) -> pd.DataFrame:
    """The rows of one published test beside the calculated values."""
    bearing = settings.bearings[test.bearing].bearing(test.bearing)
    published_rows = pd.DataFrame([row.model_dump() for row in test.rows], dtype=float)
    # columns with plain names are calculated. "low" and "high" are at the lowest and the highest
    # fraction of oil
    operating_points = published_rows.rename(
        columns={"power_w": "published_power_w", "largest_cage_slip": "published_cage_slip"}
    ).assign(inlet_temperature_c=test.inlet_temperature_c)
    speed_rad_s = operating_points["inner_speed_rpm"] * RAD_S_PER_RPM

    def friction_with_fraction(oil_volume_fraction: float) -> pd.DataFrame:
        """Friction at the operating points.

        It is calculated by the traction law that has the maximum Hertz pressure as its load
        variable.
        """
        bearing_settings = oil.bearing_settings.model_copy(
            update={"oil_volume_fraction": oil_volume_fraction}
        )
        changed_oil = replace(oil, bearing_settings=bearing_settings)
        return FrictionCases(
            bearing, [CaseGroup(changed_oil, "stress", operating_points)]
        ).calculate()

    lowest_fraction, highest_fraction = settings.bearing.oil_volume_fraction_range
    at_lowest_fraction = friction_with_fraction(lowest_fraction)
    at_highest_fraction = friction_with_fraction(highest_fraction)
    at_set_fraction = friction_with_fraction(settings.bearing.oil_volume_fraction)
    return at_set_fraction.assign(
        power_w=at_set_fraction["torque_n_m"] * speed_rad_s,
        power_low_w=at_lowest_fraction["torque_n_m"] * speed_rad_s,
        power_high_w=at_highest_fraction["torque_n_m"] * speed_rad_s,
        cage_slip_low=at_lowest_fraction["cage_slip"],
        cage_slip_high=at_highest_fraction["cage_slip"],
        source=test.source,
        assumed=test.assumed,
    )
