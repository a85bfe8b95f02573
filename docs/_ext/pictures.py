"""The directive `picture`: a figure drawn by a function of `docs/pictures` while the site is built.

Its argument is `module.function`, its content the caption; `:alt:` says what the picture shows.
"""

import sys
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import ClassVar

import matplotlib as mpl
from docutils import nodes
from docutils.parsers.rst.directives.images import Figure
from matplotlib import pyplot
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

FOLDER = "_build/pictures"


@cache
def draw(name: str, folder: Path) -> Path:
    """The picture `module.function` as a file; drawn once in a build."""
    file = folder / f"{name}.png"
    module, _, function = name.partition(".")
    style = import_module("style")
    with pyplot.rc_context(style.STYLE):
        figure = getattr(import_module(module), function)()
        folder.mkdir(parents=True, exist_ok=True)
        figure.savefig(file, metadata={"Software": None})
        pyplot.close("all")
    return file


class Picture(Figure, SphinxDirective):
    """A figure whose argument is a function instead of a file."""

    required_arguments = 1
    option_spec: ClassVar = {**Figure.option_spec}

    def run(self) -> list[nodes.Node]:
        """Draw, then go on as for any figure."""
        if not self.options.get("alt") or not self.content:
            raise self.error("a picture needs an alternative text (:alt:) and a caption")
        file = draw(self.arguments[0], Path(self.env.srcdir) / FOLDER)
        self.env.note_dependency(f"pictures/{self.arguments[0].partition('.')[0]}.py")
        self.arguments[0] = f"/{FOLDER}/{file.name}"
        return Figure.run(self)


def setup(app: Sphinx) -> dict[str, bool]:
    """Sphinx calls it."""
    mpl.use("agg")
    sys.path.insert(0, str(Path(app.srcdir) / "pictures"))
    app.add_directive("picture", Picture)
    return {"parallel_read_safe": False, "parallel_write_safe": True}
