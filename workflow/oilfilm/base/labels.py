"""Labels of arguments: rows of pandas and dimensions of xarray say which values belong together.

Decides: which arguments of a Python call are combined, and which are refused.
"""

import importlib
from collections import Counter
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from oilfilm.base.errors import OilfilmError

# Function of an array of the broadcast shape and a name. It returns the array under that name, with
# the labels of the arguments.
LabelResult = Callable[[npt.NDArray[Any], str], Any]


def aligned_arguments(arguments: Mapping[str, Any]) -> tuple[dict[str, Any], LabelResult]:
    """Arguments in a form that broadcasts by position, and a function that labels a result.

    Arrays of xarray broadcast by the names of their dimensions. Columns of pandas must have the
    same index, in the same order. Other arrays have no labels.

    Args:
        arguments: Numbers, arrays, columns or quantities of pint, by the name of the argument.

    Returns:
        The arguments by name, and the function that labels a result.

    Raises:
        OilfilmError: Labels contradict each other, or an array without names of dimensions is
            beside arrays of xarray.

    Examples:
        >>> speed = pd.Series([20.0, 30.0], index=["a", "b"])
        >>> arguments, label_result = aligned_arguments({"speed": speed, "slip": 0.05})
        >>> list(label_result(np.array([0.01, 0.02]), "mu").index)
        ['a', 'b']
    """
    if any(hasattr(value, "dims") for value in arguments.values()):
        return _aligned_by_dimensions(arguments)
    index_by_argument = {}
    for argument_name, value in arguments.items():
        plain_value = getattr(value, "magnitude", value)
        if isinstance(plain_value, pd.Series):
            index_by_argument[argument_name] = plain_value.index
    if not index_by_argument:
        return dict(arguments), lambda array, name: array
    (first_name, first_index), *other_arguments = index_by_argument.items()
    for argument_name, index in other_arguments:
        if not index.equals(first_index):
            raise OilfilmError(_different_indices(first_name, first_index, argument_name, index))

    def with_index(array: npt.NDArray[Any], name: str) -> "pd.Series[Any]":
        """A column with the index of the arguments, if it has as many values."""
        if array.shape != first_index.shape:
            raise OilfilmError(
                f"{first_name}: found a column of {len(first_index)} rows beside arrays that make "
                f"a result of shape {array.shape}; expected one value per row. Give numbers or "
                "columns of the same data frame, or give `.to_numpy()` of the column."
            )
        return pd.Series(array, first_index, name=name)

    return dict(arguments), with_index


def _different_indices(
    first_name: str, first_index: "pd.Index[Any]", other_name: str, other_index: "pd.Index[Any]"
) -> str:
    """The sentence on two columns of pandas with different indices."""
    if len(first_index) != len(other_index):
        difference = f"{len(first_index)} and {len(other_index)} rows"
    elif Counter(first_index) == Counter(other_index):
        difference = "the same labels in another order"
    else:
        difference = "different labels"
    return (
        f"{first_name} and {other_name}: the columns have different indices "
        f"({difference}), so that their rows do not belong together. Take both from one data "
        "frame, or give `.to_numpy()` where the order of the rows is right."
    )


def _aligned_by_dimensions(arguments: Mapping[str, Any]) -> tuple[dict[str, Any], LabelResult]:
    """As `aligned_arguments`, where an argument is an array of xarray."""
    xarray = importlib.import_module("xarray")
    array_by_argument = {}
    for argument_name, value in arguments.items():
        if hasattr(value, "dims"):
            array_by_argument[argument_name] = value
        elif np.ndim(value) != 0:
            raise OilfilmError(
                f"{argument_name}: found an array without names of dimensions beside arrays of "
                "xarray. Make it an array of xarray, or give `.to_numpy()` of the others."
            )
    try:
        aligned_arrays = xarray.align(*array_by_argument.values(), join="exact")
    except ValueError as error:
        reason = " ".join(str(error).split())
        argument_names = ", ".join(arguments)
        raise OilfilmError(
            f"{argument_names}: arrays of xarray have different coordinates ({reason}). Give all "
            "of them the same ones."
        ) from None
    broadcast_arrays = xarray.broadcast(*aligned_arrays)
    broadcast_by_argument = dict(zip(array_by_argument, broadcast_arrays, strict=True))
    # of coordinates that are no dimension those are left out in which arguments differ
    coordinates = xarray.merge(
        [array.coords.to_dataset() for array in broadcast_arrays], compat="minimal"
    ).coords
    dimensions = broadcast_arrays[0].dims

    def with_dimensions(array: npt.NDArray[Any], name: str) -> Any:
        """An array with the dimensions and coordinates of the arguments."""
        return xarray.DataArray(array, coordinates, dimensions, name)

    return {**arguments, **broadcast_by_argument}, with_dimensions
