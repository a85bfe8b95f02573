"""The documentation site, built and opened in a browser: no message, no request, search, access.

Nightly, because the build takes a minute. Needs what `make docs` installs, and chromium.
"""

import importlib.util
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from browsers import CHROMIUM, QUIET
from campaigns import ROOT

if sys.platform != "linux" or importlib.util.find_spec("sphinx") is None:
    pytest.skip("the site is tested on Linux after `make docs`", allow_module_level=True)
from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import Browser, sync_playwright

if CHROMIUM is None:
    pytest.skip("there is no chromium (.ci/tools installs it)", allow_module_level=True)
pytestmark = pytest.mark.nightly

PAGES = (
    *("index", "tutorials/first-csv", "how-to/describe-logs", "reference/gates"),
    *("reference/api", "reference/glossary", "reference/tables"),
    *("explanation/findings", "report", "reference/configuration/config"),
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


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=QUIET)
        yield browser
        browser.close()


@pytest.mark.parametrize("name", PAGES)
def test_page_is_quiet_accessible_and_fits_its_window(
    browser: Browser, site: Path, name: str
) -> None:
    page = browser.new_page(viewport={"width": 1280, "height": 900})
    said, asked = [], []
    page.on(
        "console", lambda message: said.append(message.text) if message.type == "error" else None
    )
    page.on("pageerror", lambda error: said.append(str(error)))
    page.on("request", lambda request: asked.append(request.url))
    page.goto((site / f"{name}.html").as_uri())
    assert said == []
    assert [url for url in asked if not url.startswith(("file:", "data:", "blob:"))] == []
    found = Axe().run(page).response["violations"]
    assert [(each["id"], each["nodes"][0]["html"][:200]) for each in found] == []
    for width in (390, 768, 1280):
        page.set_viewport_size({"width": width, "height": 900})
        assert page.evaluate("document.documentElement.scrollWidth") <= width
    page.close()


def test_search_finds_the_page_of_a_gate(browser: Browser, site: Path) -> None:
    page = browser.new_page()
    page.goto((site / "search.html").as_uri())
    page.fill("main input[name=q]", "stuck_sensor")
    page.press("main input[name=q]", "Enter")
    page.wait_for_selector("#search-results li a")
    links = page.eval_on_selector_all("#search-results li a", "all => all.map(a => a.href)")
    assert any("reference/gates.html" in link for link in links)


def test_equations_are_mathml(browser: Browser, site: Path) -> None:
    page = browser.new_page()
    page.goto((site / "explanation/film.html").as_uri())
    assert page.locator("math[display=block]").count() >= 4
    assert page.evaluate("document.querySelector('math mfrac').getBoundingClientRect().height") > 20
