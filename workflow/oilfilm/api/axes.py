"""Axes of matplotlib for the plots of results.

Decides: what becomes of a plot where matplotlib is missing.
"""

from importlib.util import find_spec
from typing import Any

from oilfilm.base.errors import OilfilmError


def refuse_without_matplotlib() -> None:
    """Refuse a plot where matplotlib is not installed.

    Raises:
        OilfilmError: It is not.
    """
    if find_spec("matplotlib") is None:
        raise OilfilmError(
            "A plot needs matplotlib, which is not installed. Install it: pip install matplotlib, "
            "or oilfilm with its extra `report`: pip install '.[report]' in the folder of its code."
        )


def given_or_new_axes(axes: Any) -> Any:
    """The axes to draw into: the given ones, else new ones.

    Args:
        axes: Axes of matplotlib; None for new ones.

    Raises:
        OilfilmError: Something else than axes is given, or matplotlib is missing.
    """
    refuse_without_matplotlib()
    if axes is None:
        from matplotlib import pyplot  # noqa: PLC0415 - loads slowly, and only plots need it

        _, axes = pyplot.subplots(layout="constrained")
    if not hasattr(axes, "fill_between"):
        raise OilfilmError(
            f"plot: found {axes!r}; expected axes of matplotlib. `plot()` makes new ones; to write "
            "a file: `plot().figure.savefig(FILE)`."
        )
    return axes
