"""A real Chromium for the tests of pages, without any network; skipped with the reason where there is none."""

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

import pytest
from playwright.sync_api import Browser, Page, sync_playwright

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
FLAGS = (
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync", "--enable-unsafe-swiftshader",
)  # fmt: skip
PATIENCE = 300_000.0  # [ms] no more than a way to end: a busy computer without graphics draws slowly
DRAWN = "document.documentElement.dataset.drawn"  # the page's script says when every figure stands


class Opened(NamedTuple):
    """A page in a browser, what its console called errors so far, and what it asked the network for."""

    page: Page
    errors: list[str]
    requests: list[str]


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    """One browser for all tests of a worker."""
    if CHROMIUM is None:
        if os.environ.get("HEXCITE_REQUIRE_CHROMIUM") == "1":
            pytest.fail("HEXCITE_REQUIRE_CHROMIUM=1, but chromium is not installed")
        pytest.skip("chromium is not installed")
    with sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=CHROMIUM, args=list(FLAGS), timeout=PATIENCE)
        yield browser
        browser.close()


@contextmanager
def opened(browser: Browser, file: Path, width: int = 1400, scheme: str = "light") -> Iterator[Opened]:
    """A page file, drawn completely."""
    page = browser.new_page(viewport={"width": width, "height": 900}, color_scheme=scheme)
    page.set_default_timeout(PATIENCE)
    errors: list[str] = []
    requests: list[str] = []
    page.on("console", lambda message: errors.append(message.text) if message.type == "error" else None)
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.on("request", lambda request: requests.append(request.url))
    try:
        page.goto(file.resolve().as_uri())
        page.wait_for_function(DRAWN)
        yield Opened(page, errors, [url for url in requests if not url.startswith(("file:", "data:", "blob:"))])
    finally:
        page.close()
