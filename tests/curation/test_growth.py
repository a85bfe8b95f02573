"""Comparisons of many runs with each other: faster than all with all, and the same answers."""

import math

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from oilfilm.curation.coverage import _levels as levels_of
from oilfilm.curation.repeats import _ROUNDING, _equal_pairs
from oilfilm.settings.config import SameSetPointSettings

SAME = SameSetPointSettings(relative=0.005, temperature_c=0.5)


def pairs_by_brute_force(values: np.ndarray) -> list[tuple[int, int]]:
    """All runs with all others, mean by mean."""
    size = np.abs(np.nan_to_num(values)).max(axis=1)
    return [
        (one, other)
        for one in range(len(values))
        for other in range(one + 1, len(values))
        if all(
            (math.isnan(a) and math.isnan(b))
            or abs(a - b) <= _ROUNDING * max(size[one, mean], size[other, mean])
            for first, second in zip(values[one], values[other], strict=True)
            for mean, (a, b) in enumerate(zip(first, second, strict=True))
        )
    ]


@pytest.mark.parametrize("seed", range(6))
def test_copies_found_among_near_runs_are_those_of_all_pairs(seed: int) -> None:
    random = np.random.default_rng(seed)
    values = random.normal([0.0, 60.0, 1e-3], [1.0, 0.01, 1e-3], (40, 4, 3))
    values[random.integers(0, 40, 3), :, 1] = np.nan
    copies = random.choice(40, 12, replace=False)
    values[copies[:6]] = values[copies[6:]] * (1 + 0.9e-4 * random.choice([-1, 1], (6, 1, 1)))
    values[copies[2], 1, 0] += 1.0  # one copy was changed
    expected = pairs_by_brute_force(values)
    assert len(expected) >= 5
    assert list(_equal_pairs(values)) == expected


def levels_by_brute_force(values: list[float], planned: list[float]) -> list[float]:
    """The level of each set point, every level compared with every value."""
    levels = sorted(set(planned))
    for value in sorted(set(values)):
        allowed = SAME.relative * value * (1 + 1e-9)
        if not levels or min(abs(level - value) for level in levels) > allowed:
            levels.append(value)
    return [min(levels, key=lambda level, value=value: abs(level - value)) for value in values]


set_points = st.lists(st.integers(100, 140).map(lambda n: n / 100), max_size=12)


@settings(max_examples=60, deadline=None)
@given(values=set_points, planned=set_points)
def test_levels_of_set_points_are_those_of_all_comparisons(
    values: list[float], planned: list[float]
) -> None:
    name = "nominal_max_hertz_pressure_gpa"
    found = levels_of(
        pd.Series(values, name=name, dtype=float), pd.Series(planned, dtype=float), SAME
    )
    assert found.tolist() == levels_by_brute_force(values, planned)
