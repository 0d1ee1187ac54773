"""The page of `hexcite plan`: what it promises is what plan.json says, beside the case's own hand-made motion."""

from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from playwright.sync_api import Browser

from cases.schema import load_case
from planner.precision import std_text
from planner.reports.plan import beside_manual
from planner.request import Request
from tests.helpers import few
from tests.planner.browser import Opened, opened

PLOTS = {
    "limits", "position-translation", "jerk-rotation", "strut-lengths", "strut-velocities", "strut-accelerations",
    "sensor-forces", "information", "correlation", "qr",
}  # fmt: skip
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
    assert "0.00 of 12.00 s" in page.locator("#instant").inner_text()
    assert f"{planned['d_efficiency']:.3f}" in page.locator(".tiles").first.inner_text()
    assert (errors, requests) == ([], [])


def test_its_deviations_are_the_plans_and_the_hand_made_motions(planned: dict[str, Any], tab: Opened, cache: Path):
    case = load_case("hexapod")
    plan = SimpleNamespace(
        case=case, of_motion=(Request(), None), model=9, payloads=range(1), duration=planned["duration_s"]
    )
    other, *_ = beside_manual(plan)
    rows = tab.page.locator("table").first.locator("tr:has(td)").all_inner_texts()
    assert len(rows) == len(planned["predicted_std"]) == 20
    for row, (name, std) in zip(rows, planned["predicted_std"].items(), strict=True):
        scale = 1e3 if name in ("xC", "yC", "zC") else 1.0
        label, *words = row.strip().split("\t")
        assert label == name or f"({name})" in label
        assert words[0] == std_text(std * scale)
        assert words[1] == std_text(other[name] * scale)
        assert float(words[2]) == pytest.approx(other[name] / std, abs=6e-3)


def test_twice_the_time_is_worth_the_root_of_two():
    plan = SimpleNamespace(
        case=load_case("hexapod"), of_motion=(Request(), None), model=9, payloads=range(1), duration=12.0
    )
    once, twice = beside_manual(plan)[0], beside_manual(SimpleNamespace(**vars(plan) | {"duration": 24.0}))[0]
    assert twice["m"] == pytest.approx(once["m"] / 2**0.5)


def test_a_case_without_a_hand_made_motion_says_so(hexapod_file: Path):
    plan = SimpleNamespace(case=load_case(str(hexapod_file)), of_motion=(Request(), None), model=9, payloads=range(1))
    words = beside_manual(plan)
    assert isinstance(words, str)
    assert "no hand-made motion" in words
    assert "manual.toml" in words
