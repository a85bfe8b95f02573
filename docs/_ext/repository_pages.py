"""Pages of the repository outside `docs` as pages of the site, and links between all of them.

A stub in `docs` links to such a page, so that the repository has one home for it. In the site the
page itself takes the place of its stub.
"""

import re
from os.path import normpath, relpath
from pathlib import Path

from sphinx.application import Sphinx

ROOT = Path(__file__).parents[2]
# Page of the site -> file of the repository.
PAGES = {
    "changes": "CHANGELOG.md",
    "contributing": "CONTRIBUTING.md",
    "tests": "tests/README.md",
    "reference/log-formats": "data/raw/README.md",
    "reference/etm-slim": "data/raw/etm-slim/README.md",
    "reference/config-folder": "config/README.md",
}
# File of the repository -> page of the site.
_SITE = {file: page for page, file in PAGES.items()} | {"README.md": "index"}
_LINK = re.compile(r"(?<=\]\()([^)\s:#]+)(#[^)\s]*)?(?=\))")


def link_of_site(link: str, file: str, page: str) -> str:
    """A link of a file of the repository as a link of a page of the site."""
    path = normpath(Path(file).parent / link)
    if path in _SITE:
        target_file = f"docs/{_SITE[path]}.md"
    elif (ROOT / path).exists():
        target_file = path
    else:
        return link
    return relpath(target_file, Path(f"docs/{page}").parent)


def read_page(app: Sphinx, page: str, source: list[str]) -> None:
    """Put in the text of the repository's page, and turn its links."""
    suffix = Path(app.env.doc2path(page)).suffix
    if suffix != ".md":
        return
    file = PAGES.get(page, f"docs/{page}.md")
    text = (ROOT / file).read_text("utf-8") if page in PAGES else source[0]
    app.env.note_dependency(str(ROOT / file))
    source[0] = _LINK.sub(lambda link: link_of_site(link[1], file, page) + (link[2] or ""), text)


def setup(app: Sphinx) -> dict[str, bool]:
    """Sphinx calls it."""
    app.connect("source-read", read_page)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
