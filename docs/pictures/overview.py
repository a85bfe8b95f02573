"""How the parts of the project hang together."""

from matplotlib import pyplot
from matplotlib.figure import Figure

from style import BLUE, GREY, ORANGE

STEPS = {
    "logs": (0, 3, "raw logs\ndata/raw/<campaign>"),
    "twin": (0, 1.6, "rig twin\nsimulated logs"),
    "ingest": (2, 3, "ingest\nsamples, refused logs"),
    "curate": (4, 3, "curate\npoints with verdicts"),
    "collect": (6, 3, "collect\nall runs; points by oil"),
    "fit": (8, 3, "fit\nconstants, refits"),
    "torque": (6, 1.6, "torque runs\npoints of torque logs"),
    "studies": (8, 1.6, "studies\nlaws, claims, bearing"),
    "outputs": (8, 0.2, "outputs\nfigures, report, exports"),
    "release": (6, 0.2, "release\nfiles, manifest, version"),
}
ARROWS = [
    *("logs-ingest", "twin-logs", "ingest-curate", "curate-collect", "collect-fit", "fit-studies"),
    *("collect-torque", "torque-studies", "studies-outputs", "outputs-release"),
]


def flow() -> Figure:
    """From the logs to a release."""
    figure, axes = pyplot.subplots(figsize=(9.6, 3.2))
    for name, (x, y, text) in STEPS.items():
        colour = ORANGE if name == "twin" else GREY if name == "logs" else BLUE
        box = {"boxstyle": "round,pad=0.45", "facecolor": "white", "edgecolor": colour, "lw": 1.5}
        axes.text(x, y, text, ha="center", va="center", fontsize=7.5, bbox=box)
    for arrow in ARROWS:
        start, end = (STEPS[name][:2] for name in arrow.split("-"))
        axes.annotate(
            "",
            end,
            start,
            arrowprops={
                "arrowstyle": "-|>",
                "color": GREY,
                "shrinkA": 47 if start[1] == end[1] else 20,
                "shrinkB": 47 if start[1] == end[1] else 20,
                "linestyle": "--" if "twin" in arrow else "-",
            },
        )
    axes.set(xlim=(-1, 9), ylim=(-0.4, 3.6))
    axes.axis("off")
    return figure
