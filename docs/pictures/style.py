"""The style of every picture of the site, and what several of them share."""

from collections.abc import Mapping
from typing import Any

from matplotlib import pyplot
from matplotlib.axes import Axes
from matplotlib.figure import Figure

# Okabe and Ito: told apart with every kind of colour vision.
BLUE, ORANGE, GREEN, RED, PURPLE, GREY = (
    *("#0072B2", "#E69F00", "#009E73", "#D55E00", "#CC79A7", "#666666"),
)
OILS = {"4102": BLUE, "4050": RED, "4010": GREEN}

STYLE: Mapping[str, Any] = {
    "axes.grid": True,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "axes.prop_cycle": pyplot.cycler(color=[BLUE, RED, GREEN, ORANGE, PURPLE, GREY]),
    "figure.constrained_layout.use": True,
    "figure.figsize": (6.4, 3.8),
    "font.size": 10,
    "grid.alpha": 0.3,
    "legend.frameon": False,
    "savefig.dpi": 160,
}


def axes(**settings: Any) -> tuple[Figure, Axes]:
    """One pair of axes with its labels."""
    figure, one = pyplot.subplots()
    one.set(**settings)
    return figure, one


def row(count: int, width: float = 8.4, height: float = 3.6) -> tuple[Figure, Any]:
    """Several axes side by side."""
    return pyplot.subplots(1, count, figsize=(width, height))
