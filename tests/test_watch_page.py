"""The page of `oilfilm watch` in a browser: legible, accessible, honest about its age."""

import shutil
import sys
from datetime import datetime, timedelta
from pathlib import Path

import pytest

from bad_logs import changed, csv
from campaigns import ROOT
from oilfilm.cli.watch_page import watch_page
from oilfilm.cli.watching import Watcher
from oilfilm.settings.resolve import resolve

if sys.platform != "linux":
    pytest.skip("pages are tested in Debian's chromium", allow_module_level=True)
from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import Page, sync_playwright

CHROMIUM = shutil.which("chromium") or shutil.which("google-chrome")
if CHROMIUM is None:
    pytest.skip("there is no chromium (.ci/tools installs it)", allow_module_level=True)


def test_page_is_accessible_legible_and_tells_when_it_is_old(tmp_path: Path) -> None:
    logs = tmp_path / "raw/demo"
    logs.mkdir(parents=True)
    (logs / "sound.csv").write_bytes(csv())
    reversed_ = changed("traction_force", lambda force: -force)
    (logs / "reversed.csv").write_bytes(csv(reversed_, inlet_temperature_c=50))
    watcher = Watcher(resolve(ROOT / "config", {"campaign": "demo"}), tmp_path / "raw", 1e-9)
    while watcher.waiting:
        list(watcher.look())
    now = datetime.now()
    for name, at in (("new", now), ("old", now - timedelta(minutes=2))):
        page = watch_page(watcher, watcher.notes, at)
        (tmp_path / f"{name}.html").write_text(page, encoding="utf-8")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        try:
            page = browser.new_page()
            requests: list[str] = []
            page.on("request", lambda request: requests.append(request.url))
            page.goto((tmp_path / "old.html").as_uri())
            assert page.locator("#stale").is_visible()
            page.goto((tmp_path / "new.html").as_uri())
            assert not page.locator("#stale").is_visible()
            assert {url.partition(":")[0] for url in requests} == {"file"}
            page.locator("#renew").uncheck()
            page.reload()
            assert not page.locator("#renew").is_checked()
            for width in (390, 1024):
                assert_legible(page, width)
        finally:
            browser.close()


def assert_legible(page: Page, width: int) -> None:
    page.set_viewport_size({"width": width, "height": 900})
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    found = Axe().run(page).response["violations"]
    assert [violation["id"] for violation in found] == []
    # the run to repeat is seen without scrolling
    assert page.locator(".what").bounding_box()["y"] < 600
    assert page.locator(".what").inner_text().startswith("Repeat oil 4102 at P = 1.25 GPa")
