"""Comparisons that rounding does not decide.

The last digits of a number depend on the processor, on the version of a library and on the order
of a sum. So two numbers that differ by no more than a share of 1e-9 are equal here: a number on a
threshold is on it, and of equal candidates the first one is taken, in an order that a person has
declared. NaN is neither above nor below anything, and never the largest.

Decides: when two numbers are equal but for rounding; which of equal candidates is taken.
"""

import numpy as np
import numpy.typing as npt

from oilfilm.units import BoolArray, FloatArray, IndexArray

# A result of two processors differs by up to 1e-10 of itself; no verdict needs a finer difference.
ROUNDING = 1e-9


def exceeds(value: npt.ArrayLike, limit: npt.ArrayLike, size: npt.ArrayLike = 0.0) -> BoolArray:
    """Whether a number is larger than another one by more than rounding; false for NaN.

    Args:
        value: Any shape.
        limit: Of a shape that broadcasts with it.
        size: Of the terms, where both numbers are differences of larger ones: the rounding is that
            of the terms.

    Examples:
        >>> bool(exceeds(0.1 + 0.2, 0.3)), bool(exceeds(0.31, 0.3))
        (False, True)
    """
    value, limit, margin = _compared(value, limit, size)
    return np.asarray(value > limit + margin)


def reaches(value: npt.ArrayLike, limit: npt.ArrayLike, size: npt.ArrayLike = 0.0) -> BoolArray:
    """Whether a number is as large as another one, or less by rounding only; false for NaN.

    Args:
        value: Any shape.
        limit: Of a shape that broadcasts with it.
        size: As of `exceeds`.

    Examples:
        >>> bool(1.1 * 100 <= 110), bool(reaches(110, 1.1 * 100))
        (False, True)
    """
    value, limit, margin = _compared(value, limit, size)
    # infinity reaches itself
    return np.asarray((value >= limit) | (value >= limit - margin))


def _compared(
    value: npt.ArrayLike, limit: npt.ArrayLike, size: npt.ArrayLike
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Both numbers, and the difference between them that is rounding."""
    value, limit = np.asarray(value, dtype=float), np.asarray(limit, dtype=float)
    smaller = np.minimum(np.abs(value), np.abs(limit))
    # infinite numbers have no rounding
    margin = np.where(np.isfinite(smaller), ROUNDING * np.maximum(smaller, size), 0.0)
    return value, limit, margin


def first_largest(values: npt.ArrayLike, axis: int = -1) -> IndexArray:
    """Index along an axis of the first of those that are the largest but for rounding.

    NaN is never chosen, but where there is nothing else the index is 0.

    Examples:
        >>> first_largest([0.3, 0.1 + 0.2, np.nan]).item()
        0
    """
    values = np.asarray(values, dtype=float)
    largest = np.fmax.reduce(values, axis=axis, keepdims=True)
    return np.asarray(reaches(values, largest).argmax(axis=axis))


def first_smallest(values: npt.ArrayLike, axis: int = -1) -> IndexArray:
    """Index along an axis of the first of those that are the smallest but for rounding."""
    return first_largest(-np.asarray(values, dtype=float), axis)


def evened(values: FloatArray) -> FloatArray:
    """The same numbers, shape (n,), with one value for those that differ by rounding only.

    Ranks, sorting and counts of different values then treat them as equal.

    Examples:
        >>> len(np.unique([0.3, 0.1 + 0.2])), len(np.unique(evened(np.array([0.3, 0.1 + 0.2]))))
        (2, 1)
    """
    order = np.argsort(values, kind="stable")
    ranked = values[order]
    # NaN comes last and stays NaN
    is_new = exceeds(ranked[1:], ranked[:-1]) | np.isnan(ranked[1:])
    starts = np.flatnonzero(np.concatenate([[True], is_new])[: len(values)])
    group = np.cumsum(np.concatenate([[0], is_new]))[: len(values)]
    same = np.empty_like(values)
    same[order] = ranked[starts][group]
    return same
