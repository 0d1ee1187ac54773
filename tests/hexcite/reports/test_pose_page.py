"""The page of `hexcite poses`: every pose can be stepped to, and what it promises is what the plan says."""

from pathlib import Path

import pytest
from playwright.sync_api import Browser

from identification.texts import std_text
from tests.hexcite.browser import opened
from tests.hexcite.command_line import call


@pytest.mark.slow
def test_a_pose_plan_has_its_page(tmp_path: Path, browser: Browser):
    answer = call(
        "poses", "hexapod", "--method", "backward", "--count", "12", "-o", tmp_path / "poses", "--json"
    ).json()
    with opened(browser, Path(answer["report"]), 400) as tab:
        assert tab.page.locator("#instant").inner_text() == "pose 1 of 12"
        assert tab.page.evaluate("document.documentElement.scrollWidth <= window.innerWidth")
        shown = tab.page.locator("table").first.inner_text()
        assert std_text(answer["predicted_std"]["m"]) in shown
        assert (tab.errors, tab.requests) == ([], [])
