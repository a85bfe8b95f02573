"""The browser of the tests: Debian's chromium or Chrome, quiet, without what it would download."""

import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

CHROMIUM = shutil.which("chromium") or shutil.which("google-chrome")
QUIET = (
    "--no-sandbox --disable-gpu --disable-quic --no-first-run --disable-sync "
    "--disable-background-networking --disable-component-update"
).split()
Page = Any  # of playwright, which is imported where it is needed


class Tab:
    """One page for all tests, with what its console says and its requests beyond files.

    To load a file anew takes a third of the time of a new page.
    """

    def __init__(self, page: Page) -> None:
        self.page = page
        self.problems: list[str] = []
        self.allowed: tuple[str, ...] = ()
        page.on("console", self._note_console_message)
        page.on("dialog", self._refuse_dialog)
        page.on("pageerror", lambda error: self.problems.append(str(error)))
        page.on("request", lambda request: self._note_request(request.url))

    def _note_console_message(self, message: Any) -> None:
        # the theme of the site logs what it does
        if message.type in ("error", "warning"):
            self.problems.append(message.text)

    def _refuse_dialog(self, dialog: Any) -> None:
        self.problems.append(f"the page ran {dialog.message}")
        dialog.dismiss()

    def _note_request(self, url: str) -> None:
        if not url.startswith(("data:", "blob:", *self.allowed)):
            self.problems.append(url)

    def open(self, file: Path, width: int = 1280, others: str = "") -> Page:
        """The page of a file as a new reader has it.

        Args:
            file: The file.
            width: Width of the window in pixels.
            others: Beginning of the addresses of other files that the page may load.
        """
        self.page.emulate_media(media="null", color_scheme="light")
        self.page.set_viewport_size({"width": width, "height": 900})
        # from the same page with another fragment it would only scroll
        self.page.goto("about:blank")
        self.problems.clear()
        self.allowed = file.as_uri(), others or file.as_uri()
        self.page.goto(file.as_uri())
        return self.page

    def violations(self) -> list[str]:
        """What keeps people from using the page, as axe finds it."""
        axe = pytest.importorskip("axe_playwright_python.sync_playwright").Axe()
        violations = []
        for rule in axe.run(self.page).response["violations"]:
            for node in rule["nodes"]:
                violations.append(f"{rule['id']}: {node['html'][:200]}")
        return violations


def open_tab() -> Iterator[Tab]:
    """A tab in a browser of its own, with an empty profile; skips where there is none."""
    if CHROMIUM is None:
        pytest.skip("there is no chromium (.ci/tools installs it)")
    with pytest.importorskip("playwright.sync_api").sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=QUIET)
        yield Tab(browser.new_page())
        browser.close()
