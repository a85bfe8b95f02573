"""The directive `report`: the report of the demonstration as a page of the site.

The report is `results/demo/report.html`, of `make` or of the last release. Without it the page says
how to make one.
"""

import shutil
from pathlib import Path

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

REPORT = Path(__file__).parents[2] / "results/demo/report.html"
FILE = "demonstration-report.html"


class Report(SphinxDirective):
    """A link to the report, and the report itself below it."""

    def run(self) -> list[nodes.Node]:
        """Nodes of both, or of the sentence that there is none."""
        if not REPORT.exists():
            text = "This site was built without a report. Run make, then make docs."
            return [nodes.paragraph(text=text)]
        page = "../" * self.env.docname.count("/") + FILE
        html = (
            f'<p><a href="{page}">The report alone, in the whole window</a></p>'
            f'<iframe class="report" src="{page}" title="Report of the demonstration"></iframe>'
        )
        return [nodes.raw(text=html, format="html")]


def copy_report(app: Sphinx, error: Exception | None) -> None:
    """Put the report beside the pages."""
    if error is None and REPORT.exists() and app.builder.format == "html":
        shutil.copyfile(REPORT, Path(app.outdir) / FILE)


def setup(app: Sphinx) -> dict[str, bool]:
    """Sphinx calls it."""
    app.add_directive("report", Report)
    app.connect("build-finished", copy_report)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
