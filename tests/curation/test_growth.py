"""Comparisons of many runs with each other: faster than all with all, and the same answers."""

import math

import numpy as np
import pytest

from oilfilm.curation.repeats import _ROUNDING, _equal_pairs


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
