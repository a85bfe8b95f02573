"""What tests ask of any drawn figure."""

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure


def nothing_is_cut_off(figure: Figure) -> bool:
    """True where everything that is drawn lies on the figure, to a hundredth of an inch."""
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    box = figure.get_tightbbox(canvas.get_renderer())
    width, height = figure.get_size_inches()
    return min(box.x0, box.y0, width - box.x1, height - box.y1) > -0.01
