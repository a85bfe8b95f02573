"""How often the interval of the mean curve holds, as `make bench NAME=coverage` found it."""

from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from oilfilm.traction import LAW_TITLES
from style import ORANGE, row

TABLE = Path(__file__).parents[1] / "explanation/coverage.csv"


def coverage() -> Figure:
    """Share of noise-free truths inside, by truth and number of curves."""
    table = pd.read_csv(TABLE)
    truths = list(dict.fromkeys(table["truth"]))[::-1]
    names = [LAW_TITLES.get(truth, truth) for truth in truths]
    figure, panels = row(2, 8.4, 3.8)
    for panel, curves in zip(panels, (24, 12), strict=True):
        shown = table[table["curves"] == curves].groupby("truth").mean(numeric_only=True)
        shown = shown.loc[truths]
        where = np.arange(len(truths))
        for column, filled, of in (
            ("mean", "none", "all fits"),
            ("mean if sound", ORANGE, "sound"),
        ):
            label = f"interval of the mean curve: truth, {of}"
            panel.plot(shown[column], where, "s", color=ORANGE, markerfacecolor=filled, label=label)
        panel.set(xlim=(0, 1.02), title=f"{curves} curves", xlabel="share inside (1)")
        panel.set_yticks(where, names if panel is panels[0] else [""] * len(truths))
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=2)
    return figure
