"""The page of `hexcite plan`: what it promises is what plan.json says."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser

from identification.texts import std_text
from tests.helpers import few
from tests.hexcite.browser import Opened, opened

PLOTS = {"position-translation", "acceleration-rotation"}
SCREENS = {"a phone by night": (400, "dark"), "a wide screen by day": (1400, "light")}
FITS = "document.documentElement.scrollWidth <= window.innerWidth"


@pytest.fixture(scope="module", params=few(*SCREENS))
def tab(request: pytest.FixtureRequest, planned: dict[str, Any], browser: Browser) -> Iterator[Opened]:
    """The page on a screen of this width, by day or by night."""
    with opened(browser, Path(planned["report"]), *SCREENS[request.param]) as tab:
        yield tab


def test_a_plan_has_its_page(tab: Opened, planned: dict[str, Any]):
    page, errors, requests = tab
    assert page.evaluate(FITS)
    shown = set(page.evaluate("[...document.querySelectorAll('.plot')].map(e => e.id)"))
    assert {f"plot-{name}" for name in PLOTS} <= shown
    bars = page.locator(".bars .value").all_inner_texts()
    assert any("m/s, limit ±1; proven" in bar for bar in bars)  # the case's limit of the struts' velocity
    assert f"0.00 of {planned['duration_s']:.2f} s" in page.locator("#instant").inner_text()
    assert f"{planned['d_efficiency']:.3f}" in page.locator(".tiles").first.inner_text()
    assert (errors, requests) == ([], [])


def test_its_deviations_are_the_plans(planned: dict[str, Any], tab: Opened):
    rows = tab.page.locator("table").first.locator("tr:has(td)").all_inner_texts()
    assert len(rows) == len(planned["predicted_std"]) == 20
    for row, (name, std) in zip(rows, planned["predicted_std"].items(), strict=True):
        scale = 1e3 if name in ("xC", "yC", "zC") else 1.0
        label, *words = row.strip().split("\t")
        assert label == name or f"({name})" in label
        assert words[0] == std_text(std * scale)
