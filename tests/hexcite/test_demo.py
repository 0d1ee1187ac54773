"""`hexcite demo`: the whole chain from one command to one page that needs no network."""

import re
from collections.abc import Callable
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser

from cases.schema import Case
from hexcite import _demo
from identification.texts import value_text
from planner import plan
from planner.families.settings import FamilySettings, Manual, PointToPoint
from planner.plans.plan import Plan
from tests.helpers import tells
from tests.hexcite.browser import opened
from tests.hexcite.command_line import call

pytestmark = pytest.mark.repeats  # its steps have tests of their own
PLOTS = ("errors", "forces", "residuals", "spectrum")
FETCHED = {"src", "href", "srcset", "data", "poster", "action", "background"}


class Page(HTMLParser):
    """What a browser would fetch for a page, the identifiers on it, and its text."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.fetched: list[str] = []
        self.ids: list[str] = []
        self.text = ""
        self.inside: list[str] = []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.inside.append(tag)
        for name, value in attrs:
            if name in FETCHED and value:
                self.fetched.append(value)
            if name == "style" and value:
                self.fetched += re.findall(r"url\((.*?)\)", value)
            if name == "id" and value:
                self.ids.append(value)

    def handle_endtag(self, tag: str) -> None:
        while self.inside and self.inside.pop() != tag:
            pass

    def handle_data(self, data: str) -> None:
        where = self.inside[-1] if self.inside else ""
        if where == "style":
            self.fetched += re.findall(r"url\((.*?)\)|@import\s+(\S+)", data)
        elif where != "script":
            self.text += data


def short(case: Case, family: FamilySettings, **settings: Any) -> Plan:
    """A plan of two thirds of a demo's duration, of half the moves."""
    if isinstance(family, Manual):
        return plan(case, family, **settings)
    own = replace(family, moves=20) if isinstance(family, PointToPoint) else family
    return plan(case, own, 8.0, **settings)


@pytest.fixture(scope="module", params=["short", pytest.param("whole", marks=pytest.mark.repeats)])
def demo(request: pytest.FixtureRequest, shared: Path, once: Callable[[str, Callable[[], Any]], Any]) -> dict[str, Any]:
    """The answer of a demo on the virtual controller."""
    name = f"{request.param}-demo"
    command = ("demo", "--on", "virtual", "-o", shared / name, "--json")
    with pytest.MonkeyPatch.context() as patch:
        if request.param == "short":
            patch.setattr(_demo, "motion", short)
        return once(name, lambda: call(*command).json())


@pytest.fixture(scope="module")
def page(demo: dict[str, Any]) -> Page:
    return Page(Path(demo["report"]).read_text(encoding="utf-8"))


def test_it_answers_with_each_step(demo: dict[str, Any]):
    assert {
        "report",
        "controller",
        "plan",
        "post",
        "check",
        "run",
        "identify",
        "truth",
        "motions",
        "comparison",
    } <= set(demo)
    assert demo["check"]["ok"]
    assert demo["check"]["relies_on"] == demo["check"]["without"] == []
    assert "EXCEEDED" not in demo["check"]["verdict"]
    for limit in demo["check"]["limits"].values():
        assert limit["ratio"] <= 1.0 + 1e-6, limit["at"]
    assert "virtual" in demo["controller"]


def test_every_estimate_lies_within_four_standard_deviations_of_the_truth(demo: dict[str, Any]):
    assert len(demo["truth"]) == 20
    worst = max(abs(r["error"]) / r["std"] for r in demo["truth"])
    assert worst == pytest.approx(demo["worst_error_in_std"])
    assert worst < 4.0
    for row in demo["truth"]:
        assert row["error"] == pytest.approx(row["estimate"] - row["truth"])


def test_it_leaves_everything_that_it_made(demo: dict[str, Any]):
    folder = Path(demo["report"]).parent
    own = {"plan", "excitation.mpf", "recording", "result"}
    assert {p.name for p in folder.iterdir()} == own | {"report.html", "manual", "fourier"}
    for name in ("manual", "fourier"):
        assert {p.name for p in (folder / name).iterdir()} == own


def test_a_hand_made_motion_a_series_and_moves_are_compared_as_planned_run_and_with_the_truth(
    demo: dict[str, Any], page: Page
):
    motions = {row["motion"]: row for row in demo["motions"]}
    assert list(motions) == ["manual motion", "Fourier series", "moves"]
    assert demo["left_out"] == []
    for row in motions.values():
        assert float(row["largest error in std"]) < 4.0
        assert float(row["s run"]) == pytest.approx(float(row["s planned"]), abs=0.1)
        assert row["motion"] in page.text
    planned = [float(row["D-efficiency planned"]) for row in motions.values()]
    assert planned == sorted(planned)
    assert demo["comparison"]["recommendation"]["level"] == "identified"
    assert len(demo["comparison"]["rows"]) == 3
    ratios = [float(row["deviations"].split()[0]) for row in motions.values()]
    assert min(ratios) == 1.0
    assert ratios[0] > ratios[-1]


def test_paths_timed_by_toppra_are_shorter_and_no_less_informative(demo: dict[str, Any]):
    assert [words.split()[0] for words in demo["faster"]] == ["manual", "Fourier"]
    for words in demo["faster"]:
        found = re.findall(r"([\d.]+) s, D-efficiency ([\d.]+)", words)
        (after, better), (before, own) = (map(float, each) for each in found)
        assert after < before
        assert better > own


def test_it_plans_moves_for_the_controller_whose_program_it_writes(demo: dict[str, Any]):
    assert demo["plan"]["family"] == "ptp"
    assert demo["plan"]["settings"]["made_for"] == "sinumerik"
    assert demo["run"]["d_efficiency"] > 0.95 * demo["plan"]["d_efficiency"]


def test_the_page_fetches_nothing(page: Page):
    assert [link for link in page.fetched if not str(link).startswith(("#", "data:"))] == []


def test_the_page_shows_every_plot_once(page: Page):
    assert [i for i in page.ids if i.startswith("plot-")] != []
    for name in PLOTS:
        assert page.ids.count(f"plot-{name}") == 1
    assert page.ids.count("machine") == 1


def test_the_page_says_what_is_simulated_and_what_the_controller_enforces(page: Page):
    said = " ".join(page.text.split())
    assert "Sensors and encoders are simulated" in said
    assert "virtual controller" in said
    assert "enforced by controller" in said
    assert "NOT enforced" not in said
    assert "EXCEEDED" not in said


def test_the_page_names_every_parameter_with_its_estimate(page: Page, demo: dict[str, Any]):
    for row in demo["truth"]:
        assert row["name"] in page.text
        scale = 1000 if row["unit"] == "m" else 1
        assert value_text(row["estimate"] * scale, row["std"] * scale) in page.text


def test_the_page_opens_in_a_browser(browser: Browser, demo: dict[str, Any]):
    with opened(browser, Path(demo["report"])) as tab:
        assert (tab.errors, tab.requests) == ([], [])
        assert tab.page.locator("#machine canvas").count() > 0


def test_the_page_counts_the_truths_inside_their_intervals(page: Page, demo: dict[str, Any]):
    inside = sum(abs(r["error"]) <= 1.96 * r["std"] for r in demo["truth"])
    assert tells(page.text, f"{inside} of 20 truths", "95 %")
