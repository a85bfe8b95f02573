"""What reads well aloud: equations as MathML, set by the browser itself, and heads of tables."""

import re
from typing import Any

from docutils import nodes
from latex2mathml.converter import convert
from sphinx.application import Sphinx
from sphinx.writers.html5 import HTML5Translator


def inline(self: HTML5Translator, node: nodes.math) -> None:
    """An equation within a sentence."""
    self.body.append(convert(node.astext()))
    raise nodes.SkipNode


def block(self: HTML5Translator, node: nodes.math_block) -> None:
    """An equation on a line of its own, with its number where it has one."""
    self.body.append(self.starttag(node, "div", CLASS="equation", tabindex="0"))
    self.body.append(convert(node.astext(), display="block"))
    if node["number"]:
        self.body.append(f'<span class="eqno">({node["number"]})</span>')
    self.body.append("</div>\n")
    raise nodes.SkipNode


def replace_empty_heads(
    app: Sphinx, page: str, template: str, context: dict[str, Any], tree: object
) -> None:
    """Replace empty heads of columns by cells: programs that read aloud would announce them."""
    if "body" in context:
        body = re.sub(r"<th[^>]*>(<p></p>)?</th>", "<td></td>", context["body"])
        context["body"] = body


def setup(app: Sphinx) -> dict[str, bool]:
    """Sphinx calls it."""
    app.add_html_math_renderer("mathml", (inline, None), (block, None))
    app.connect("html-page-context", replace_empty_heads)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
