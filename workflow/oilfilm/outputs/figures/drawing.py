"""What a figure is: its words, how it is drawn, and the table of what it draws."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import pandas as pd
from matplotlib.figure import Figure

from oilfilm.outputs.captions import CAPTIONS
from oilfilm.tables.campaign_tables import CampaignTables


@dataclass(frozen=True)
class Drawing:
    """How a figure is drawn from finished tables, and the table model of what it draws.

    Attributes:
        name: Its name, a key of `captions.CAPTIONS`.
        draw: From tables and settings to the figure and what it draws.
        table: Name of the table's model.
    """

    name: str
    draw: Callable[[CampaignTables, Mapping[str, Any]], tuple[Figure, pd.DataFrame]]
    table: str

    @property
    def title(self) -> str:
        """A few words."""
        return CAPTIONS[self.name].title

    @property
    def caption(self) -> str:
        """What is drawn, without where the data are from: `captions.caption` adds that."""
        return CAPTIONS[self.name].words

    @property
    def category(self) -> str:
        """Where it belongs among the others."""
        return CAPTIONS[self.name].category
