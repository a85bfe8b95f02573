"""Comparisons that rounding does not decide: what is equal, what is not, what is unknown."""

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from oilfilm.base.ties import exceeds, first_largest, first_smallest, reaches, with_equal_ties

_SIZES = st.floats(1e-12, 1e12)
_BITS = st.floats(-1e-12, 1e-12)


@given(_SIZES, _BITS, st.sampled_from([-1, 1]))
def test_a_number_on_a_threshold_is_on_it_whatever_its_last_digits(
    size: float, bits: float, sign: int
) -> None:
    limit = sign * size
    value = limit * (1 + bits)
    assert reaches(value, limit)
    assert reaches(limit, value)
    assert not exceeds(value, limit)
    assert not exceeds(limit, value)


@given(_SIZES, st.floats(1e-8, 10), st.sampled_from([-1, 1]))
def test_a_difference_that_is_more_than_rounding_counts(
    size: float, share: float, sign: int
) -> None:
    smaller, larger = sorted([sign * size, sign * size * (1 + share)])
    assert exceeds(larger, smaller)
    assert not reaches(smaller, larger)


def test_differences_of_large_numbers_are_compared_with_the_rounding_of_these_numbers() -> None:
    # both are 0 but for the rounding of the terms
    first, second = 0.1 + 0.2 - 0.3, 0.0
    assert exceeds(first, second)
    assert not exceeds(first, second, term_size=0.3)


def test_nan_is_neither_above_nor_below_and_infinity_is_above_all() -> None:
    unknown = np.nan
    for value, limit in ((unknown, 1.0), (1.0, unknown), (unknown, unknown)):
        assert not exceeds(value, limit)
        assert not reaches(value, limit)
    assert exceeds(np.inf, 1e300)
    assert not exceeds(np.inf, np.inf)
    assert reaches(np.inf, np.inf)
    assert reaches(-np.inf, -np.inf)
    assert exceeds(1.0, -np.inf)


@given(st.permutations([0.5, 0.3, 0.1]), _BITS)
def test_of_equal_candidates_the_first_is_taken_whatever_their_last_digits(
    others: list[float], bits: float
) -> None:
    values = np.array([*others, 0.7, 0.7 * (1 + bits), np.nan])
    assert first_largest(values) == 3
    assert first_smallest(-values) == 3


def test_the_first_of_equals_is_found_along_any_axis() -> None:
    values = np.array([[0.3, 1.0], [0.1 + 0.2, np.nan], [0.2, 2.0]])
    np.testing.assert_array_equal(first_largest(values, axis=0), [0, 2])
    np.testing.assert_array_equal(first_smallest(values, axis=0), [2, 0])
    assert first_largest([np.nan, np.nan]) == 0


@pytest.mark.parametrize("bits", [0.0, 1e-12, -1e-12])
def test_equal_totals_share_a_rank(bits: float) -> None:
    totals = np.array([2.0, 0.3, 0.3 * (1 + bits), 5.0])
    ranks = pd.Series(with_equal_ties(totals)).rank(method="min", ascending=False)
    assert ranks.tolist() == [2, 3, 3, 1]
    np.testing.assert_allclose(with_equal_ties(totals), totals, rtol=1e-11)


def test_unknown_numbers_and_none_at_all_stay_as_they_are() -> None:
    np.testing.assert_array_equal(
        with_equal_ties(np.array([np.nan, 1.0, np.nan])), [np.nan, 1.0, np.nan]
    )
    assert with_equal_ties(np.array([])).shape == (0,)
