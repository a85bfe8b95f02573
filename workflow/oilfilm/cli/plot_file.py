"""The option `--plot` of several commands: a figure as a file.

Decides: which files a command draws.
"""

from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

from oilfilm.api.axes import refuse_without_matplotlib
from oilfilm.base.errors import OilfilmError

if TYPE_CHECKING:
    # loads slowly, and only the options with a plot need it
    from matplotlib.figure import Figure

_ENDINGS = (".png", ".svg")


def refuse_plot(path: Path | None) -> None:
    """Refuse a plot that could not be written, before anything is computed; set the style.

    Args:
        path: The typed file; None where none is wanted.

    Raises:
        OilfilmError: The file has another ending than png or svg, its folder is missing, or
            matplotlib is.
    """
    if path is None:
        return
    if path.suffix not in _ENDINGS:
        endings = " or ".join(_ENDINGS)
        raise OilfilmError(f"--plot: found {str(path)!r}; expected a file that ends in {endings}.")
    if not path.parent.is_dir():
        raise OilfilmError(f"--plot: there is no folder {path.parent}. Make it, or name another.")
    refuse_without_matplotlib()
    # its import sets the style, which counts for what is drawn afterwards
    import_module("oilfilm.report.figures.style")


def write_plot(figure: "Figure", path: Path) -> None:
    """Write a figure. The same figure gives the same bytes."""
    from oilfilm.report.figures import sheet  # noqa: PLC0415 - needs matplotlib

    sheet.save(figure, path)
