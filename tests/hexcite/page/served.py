"""The page served by a process of its own, and what a real Chromium saw of it."""

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, Page, expect

from tests.hexcite.browser import PATIENCE


@contextmanager
def serving(root: Path) -> Iterator[tuple[subprocess.Popen[str], str]]:
    """A server of a folder, with its address."""
    command = [sys.executable, "-P", "-m", "hexcite.cli.guest", str(os.getpid()), "page", str(root), "--no-browser"]
    with subprocess.Popen(command, cwd=root, stdout=subprocess.PIPE, text=True) as server:
        assert server.stdout is not None
        try:
            yield server, server.stdout.readline().split()[-1]
        finally:
            server.kill()


@pytest.fixture
def address(root: Path) -> Iterator[str]:
    """The address of a server of its own, ended by Ctrl-C."""
    with serving(root) as (server, address):
        yield address
        server.send_signal(signal.SIGINT)
        assert server.wait(60) == 0


class Seen:
    """A page, and what its console called errors."""

    def __init__(self, browser: Browser, address: str, width: int = 1280, scheme: str = "light", **more: Any) -> None:
        size = {"width": width, "height": 900}
        context = browser.new_context(**{"viewport": size, "color_scheme": scheme, "locale": "en-GB"} | more)
        self.page: Page = context.new_page()
        self.page.set_default_timeout(PATIENCE)
        self.errors: list[str] = []
        self.requests: list[str] = []
        self.page.on("console", lambda said: self.errors.append(said.text) if said.type == "error" else None)
        self.page.on("pageerror", lambda error: self.errors.append(str(error)))
        self.page.on("request", lambda request: self.requests.append(request.url))
        self.page.goto(address)
        self.shots = os.environ.get("HEXCITE_SHOTS")

    def shot(self, name: str) -> None:
        """A picture for people, where the environment says where."""
        assert self.page.evaluate("document.documentElement.scrollWidth <= innerWidth"), name
        if self.shots:
            self.page.screenshot(path=Path(self.shots) / f"{name}.png")


@pytest.fixture(autouse=True)
def patience() -> None:
    expect.set_options(timeout=PATIENCE)
