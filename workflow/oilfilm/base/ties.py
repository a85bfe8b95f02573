"""Comparisons that rounding does not decide.

The last digits of a number depend on the processor, on the version of a library and on the order
of a sum. So two numbers are equal here if their relative difference is at most 1e-9. A number that
misses a threshold by rounding is on it. Of equal candidates the first one is taken, in an order
that a person has declared. NaN is neither above nor below anything, and never the largest.

Decides: when two numbers are equal but for rounding; which of equal candidates is taken.
"""

import numpy as np
import numpy.typing as npt

from oilfilm.base.units import BoolArray, FloatArray, IndexArray

# Results of two processors differ by up to 1e-10, relative. No verdict needs a finer difference.
ROUNDING = 1e-9


def exceeds(
    value: npt.ArrayLike, limit: npt.ArrayLike, term_size: npt.ArrayLike = 0.0
) -> BoolArray:
    """Whether a number is larger than another one by more than rounding; false for NaN.

    Args:
        value: Any shape.
        limit: A shape that broadcasts with that of `value`.
        term_size: Absolute value of the terms, where `value` or `limit` is a difference of larger
            terms. The rounding is that of the terms then.

    Examples:
        >>> bool(exceeds(0.1 + 0.2, 0.3)), bool(exceeds(0.31, 0.3))
        (False, True)
    """
    values, limits = np.asarray(value, dtype=float), np.asarray(limit, dtype=float)
    return np.asarray(values > limits + _rounding(values, limits, term_size))


def reaches(
    value: npt.ArrayLike, limit: npt.ArrayLike, term_size: npt.ArrayLike = 0.0
) -> BoolArray:
    """Whether a number is at least as large as another one but for rounding; false for NaN.

    Args:
        value: Any shape.
        limit: A shape that broadcasts with that of `value`.
        term_size: As in `exceeds`.

    Examples:
        >>> bool(1.1 * 100 <= 110), bool(reaches(110, 1.1 * 100))
        (False, True)
    """
    values, limits = np.asarray(value, dtype=float), np.asarray(limit, dtype=float)
    # infinity reaches itself
    return np.asarray(
        (values >= limits) | (values >= limits - _rounding(values, limits, term_size))
    )


def _rounding(values: FloatArray, limits: FloatArray, term_size: npt.ArrayLike) -> FloatArray:
    """The largest difference of two numbers that is taken for rounding."""
    # relative to the smaller number, because a share of infinity is infinite
    smaller = np.minimum(np.abs(values), np.abs(limits))
    # two infinite numbers have no rounding
    return np.where(np.isfinite(smaller), ROUNDING * np.maximum(smaller, term_size), 0.0)


def first_largest(values: npt.ArrayLike, axis: int = -1) -> IndexArray:
    """Index along an axis of the first number that is the largest but for rounding.

    NaN is never chosen. Where there are only NaN the index is 0.

    Examples:
        >>> first_largest([0.3, 0.1 + 0.2, np.nan]).item()
        0
    """
    values = np.asarray(values, dtype=float)
    largest = np.fmax.reduce(values, axis=axis, keepdims=True)
    return np.asarray(reaches(values, largest).argmax(axis=axis))


def first_smallest(values: npt.ArrayLike, axis: int = -1) -> IndexArray:
    """Index along an axis of the first number that is the smallest but for rounding."""
    return first_largest(-np.asarray(values, dtype=float), axis)


def with_equal_ties(values: FloatArray) -> FloatArray:
    """The same numbers, shape (n,), with one value for numbers that differ by rounding only.

    A chain of numbers, each equal to the next one but for rounding, gets the smallest of them.
    Ranks, sorting and counts of different values then treat them as equal.

    Examples:
        >>> values = np.array([0.3, 0.1 + 0.2])
        >>> len(np.unique(values)), len(np.unique(with_equal_ties(values)))
        (2, 1)
    """
    order = np.argsort(values, kind="stable")
    sorted_values = values[order]
    # NaN comes last and stays NaN
    is_new_number = exceeds(sorted_values[1:], sorted_values[:-1]) | np.isnan(sorted_values[1:])
    is_group_start = np.concatenate([[True], is_new_number])
    # without any number there is no group
    is_group_start = is_group_start[: len(values)]
    group_of_rank = np.cumsum(is_group_start) - 1
    equalised_values = np.empty_like(values)
    equalised_values[order] = sorted_values[is_group_start][group_of_rank]
    return equalised_values
