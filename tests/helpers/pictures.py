"""What tests ask of any drawn figure."""

from collections.abc import Callable
from pathlib import Path

import matplotlib.image
import pandas as pd
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.testing.compare import compare_images

from oilfilm.base import studies
from oilfilm.base.figure_catalogue import figures
from oilfilm.base.home import reference_file
from oilfilm.report.figures.sheet import draw_figure, save
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables

# Root-mean-square difference of the pictures' values, of 255. The same code gives 0; this leaves
# room for the font rendering of another build of matplotlib, and every fault is larger.
TOLERANCE = 1.0
Draw = Callable[..., tuple[Figure, pd.DataFrame]]


def nothing_is_cut_off(figure: Figure) -> bool:
    """True where everything that is drawn lies on the figure, to a hundredth of an inch."""
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    box = figure.get_tightbbox(canvas.get_renderer())
    width, height = figure.get_size_inches()
    return min(box.x0, box.y0, width - box.x1, height - box.y1) > -0.01


def is_as_wide_as_a_column(figure: Figure, folder: Path) -> bool:
    """True where the saved picture is as wide as one column of a journal, or as two."""
    save(figure, folder / "figure.png")
    width = matplotlib.image.imread(folder / "figure.png").shape[1]
    return width in [int(mm / 25.4 * 180) for mm in (84, 174)]


def settings_of_oils(settings: Settings, oils: list[str]) -> Settings:
    """The settings of a campaign with some of its oils alone."""
    plain = settings.plain_values()
    return Settings.from_plain_values({**plain, "oils": {oil: plain["oils"][oil] for oil in oils}})


def difference_from(baseline: Path, figure: Figure, folder: Path) -> str | None:
    """What a figure has that its earlier picture has not; None where they look the same."""
    path = folder / baseline.name
    figure.savefig(path, dpi=60, metadata={"Software": None})
    message = compare_images(str(baseline), str(path), TOLERANCE)
    if message is None:
        return None
    return f"{message}\nIs it meant? Look at it, then copy it over the baseline."


def draw(name: str, results: CampaignTables, config: Settings) -> tuple[Figure, pd.DataFrame]:
    """A figure and the table of what it draws, as its job does."""
    figure = figures()[name]
    references = {
        reference: study.read_reference(reference_file(reference))
        for study in studies.load_studies([figure.study] if figure.study else [])
        for reference in figure.references
    }
    return draw_figure(name, results, config, references)


def drawing_of(results: CampaignTables, config: Settings) -> Draw:
    """A function that draws a figure by its name, from other settings or tables if given."""
    return lambda name, settings=config, **other_tables: draw(
        name, results.replace(**other_tables), settings
    )
