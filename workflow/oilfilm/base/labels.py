"""Labels of arguments: rows of pandas and dimensions of xarray say which values belong together.

Decides: which arguments of a Python call are combined, and which are refused.
"""

import importlib
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from oilfilm.base.errors import OilfilmError

# Gives an array of the broadcast shape, and a name, the labels of the arguments.
Labelled = Callable[[npt.NDArray[Any], str], Any]


def aligned(arguments: Mapping[str, Any]) -> tuple[dict[str, Any], Labelled]:
    """Arguments in a form that broadcasts by position, and a function that labels a result.

    Arrays of xarray broadcast by the names of their dimensions. Columns of pandas must have the
    same index, in the same order. Other arrays have no labels.

    Args:
        arguments: Numbers, arrays, columns or quantities of pint, by the name of the argument.

    Returns:
        The arguments, and a function of an array of the broadcast shape and a name.

    Raises:
        OilfilmError: Labels contradict each other, or an array without names of dimensions is
            beside arrays of xarray.

    Examples:
        >>> speed = pd.Series([20.0, 30.0], index=["a", "b"])
        >>> values, labelled = aligned({"speed": speed, "slip": 0.05})
        >>> list(labelled(np.array([0.01, 0.02]), "mu").index)
        ['a', 'b']
    """
    if any(hasattr(value, "dims") for value in arguments.values()):
        return _aligned_by_dimensions(arguments)
    indices = {}
    for argument, value in arguments.items():
        column = getattr(value, "magnitude", value)
        if isinstance(column, pd.Series):
            indices[argument] = column.index
    if not indices:
        return dict(arguments), lambda array, name: array
    (first_argument, first_index), *others = indices.items()
    for argument, other_index in others:
        if not other_index.equals(first_index):
            raise OilfilmError(
                _different_indices(first_argument, first_index, argument, other_index)
            )
    return dict(arguments), lambda array, name: pd.Series(array, first_index, name=name)


def _different_indices(
    first_argument: str,
    first_index: "pd.Index[Any]",
    other_argument: str,
    other_index: "pd.Index[Any]",
) -> str:
    """The sentence on two columns of pandas with different indices."""
    if len(first_index) != len(other_index):
        difference = f"{len(first_index)} and {len(other_index)} rows"
    elif first_index.sort_values().equals(other_index.sort_values()):
        difference = "the same labels in another order"
    else:
        difference = "different labels"
    return (
        f"{first_argument} and {other_argument}: the columns have different indices "
        f"({difference}), so that their rows do not belong together. Take both from one data "
        "frame, or give `.to_numpy()` where the order of the rows is right."
    )


def _aligned_by_dimensions(arguments: Mapping[str, Any]) -> tuple[dict[str, Any], Labelled]:
    """As `aligned`, where an argument is an array of xarray."""
    xarray = importlib.import_module("xarray")
    arrays = []
    for name, value in arguments.items():
        if hasattr(value, "dims"):
            arrays.append(value)
        elif np.ndim(value) == 0:
            arrays.append(xarray.DataArray(value))
        else:
            raise OilfilmError(
                f"{name}: found an array without names of dimensions beside arrays of xarray. "
                "Make it an array of xarray, or give `.to_numpy()` of the others."
            )
    try:
        broadcast = xarray.broadcast(*xarray.align(*arrays, join="exact"))
    except ValueError as error:
        reason = " ".join(str(error).split())
        names = ", ".join(arguments)
        raise OilfilmError(
            f"{names}: arrays of xarray have different coordinates ({reason}). Give all of them "
            "the same ones."
        ) from None
    template = broadcast[0]
    values = dict(zip(arguments, broadcast, strict=True))
    return values, lambda array, name: template.copy(data=array).rename(name)
