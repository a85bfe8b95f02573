"""The documentation site, built and opened in a browser: no message, no request, search, access.

Nightly, because the build takes a minute. Needs what `make docs` installs, and chromium.
"""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from browsers import Tab
from campaigns import ROOT

pytest.importorskip("sphinx", reason="the site is tested after `make docs`")
pytestmark = pytest.mark.nightly

PAGES = (
    *("index", "tutorials/index", "tutorials/first-csv", "tutorials/bearing"),
    *("how-to/describe-logs", "how-to/cluster", "reference/gates"),
    *("reference/api", "reference/glossary", "reference/tables"),
    *("study/findings", "report", "reference/configuration/config"),
    *("explanation/law", "explanation/film", "explanation/method", "notebooks/first-curve"),
)


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("site")
    done = subprocess.run(
        [
            *(sys.executable, "-m", "sphinx", "--fail-on-warning", "--keep-going", "--nitpicky"),
            *("--quiet", "--doctree-dir", folder / "doctrees", ROOT / "docs", folder / "html"),
        ],
        # an address that answers nothing: whoever asks a network fails
        env={**os.environ, "https_proxy": "http://192.0.2.1:9", "http_proxy": "http://192.0.2.1:9"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return folder / "html"


@pytest.mark.parametrize("name", PAGES)
def test_page_is_quiet_accessible_and_fits_its_window(tab: Tab, site: Path, name: str) -> None:
    page = tab.open(site / f"{name}.html", others="file:")
    assert tab.problems == []
    assert tab.violations() == []
    # colours that change slowly have too little contrast on their way
    page.emulate_media(color_scheme="dark", reduced_motion="reduce")
    page.reload()
    assert tab.violations() == []
    for width in (390, 768, 1024, 1440):
        page.set_viewport_size({"width": width, "height": 900})
        assert page.evaluate("document.documentElement.scrollWidth") <= width


def test_search_finds_the_page_of_a_gate(tab: Tab, site: Path) -> None:
    page = tab.open(site / "search.html", others="file:")
    page.fill("main input[name=q]", "stuck_sensor")
    page.press("main input[name=q]", "Enter")
    page.wait_for_selector("#search-results li a")
    links = page.eval_on_selector_all("#search-results li a", "all => all.map(a => a.href)")
    assert any("reference/gates.html" in link for link in links)


def test_equations_are_mathml(tab: Tab, site: Path) -> None:
    page = tab.open(site / "explanation/film.html", others="file:")
    assert page.locator("math[display=block]").count() >= 4
    assert page.evaluate("document.querySelector('math mfrac').getBoundingClientRect().height") > 20
