"""Every stage for people who see, point or move otherwise: names and roles, keyboard, large targets, no motion."""

import re
import shutil
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, Page, expect

from tests.hexcite.page.served import Seen, address, patience

pytestmark = pytest.mark.slow
__all__ = ["address", "patience"]

STAGES = ("machine", "plan", "program", "data", "result", "use")
FOCUSABLE = 'a[href], button, input:not([type="hidden"]), select, summary, textarea, [tabindex="0"]'
OPENED = "for (const each of document.querySelectorAll('details:not([data-frame])')) each.open = true"
ROLES = {
    "link", "button", "textbox", "combobox", "MenuListPopup", "option", "menuitem", "radio", "checkbox",
    "DisclosureTriangle", "DisclosureTriangleGrouped", "region", "slider", "spinbutton", "Iframe", "LabelText",
}  # fmt: skip


@pytest.fixture
def root(calibrated: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(calibrated, tmp_path / "root"))


@pytest.fixture
def pages(browser: Browser, address: str, root: Path) -> Iterator[tuple[Seen, list[str]]]:
    """A window, and the addresses of the start page and all stages of a machine that has been through them."""
    seen, base = Seen(browser, address), address.split("/?")[0]
    (root / "trace.csv").write_bytes((root / "rec" / "recording.csv").read_bytes())
    seen.page.goto(f"{base}/m/+mill/data?recording=trace.csv")
    seen.page.get_by_role("button", name="How is it read?").click()
    expect(seen.page.locator(".reading")).to_be_visible()
    stages = [f"{base}/m/+mill/{stage}{'?recording=trace.csv' if stage == 'data' else ''}" for stage in STAGES]
    yield seen, [f"{base}/", *stages, f"{base}/m/ur10_wrist/machine"]
    assert seen.errors == []


def tree(page: Page) -> list[dict[str, Any]]:
    """Nodes of Chromium's accessibility tree, those that are ignored apart."""
    session = page.context.new_cdp_session(page)
    session.send("Accessibility.enable")
    nodes = session.send("Accessibility.getFullAXTree")["nodes"]
    return [
        {
            "role": node["role"]["value"],
            "name": str(node.get("name", {}).get("value", "")).strip(),
            **{entry["name"]: entry["value"].get("value") for entry in node.get("properties", ())},
        }
        for node in nodes
        if not node.get("ignored") and "role" in node
    ]


def test_all_that_can_be_used_has_a_name_and_a_role(pages: tuple[Seen, list[str]]):
    seen, addresses = pages
    titles = set()
    for where in addresses:
        seen.page.goto(where)
        seen.page.evaluate(OPENED)
        nodes = tree(seen.page)
        usable = [node for node in nodes if node.get("focusable") and node["role"] not in ("RootWebArea", "main")]
        assert len(usable) > 5, where
        assert [node for node in usable if not node["name"]] == [], where
        assert {node["role"] for node in usable} <= ROLES, where
        assert [node for node in nodes if node["role"] in ("image", "img") and not node["name"]] == [], where
        levels = [int(node["level"]) for node in nodes if node["role"] == "heading"]
        assert levels[0] == 1, where
        assert levels.count(1) == 1, where
        assert all(below <= above + 1 for above, below in pairwise(levels)), where
        roles = [node["role"] for node in nodes]
        assert roles.count("main") == roles.count("banner") == 1, where
        assert where.endswith("/") or "navigation" in roles, where
        assert seen.page.evaluate("document.documentElement.lang") == "en"
        titles.add(seen.page.title())
    assert len(titles) == len(addresses)


def test_the_keyboard_reaches_all_in_order_and_is_trapped_nowhere(pages: tuple[Seen, list[str]]):
    seen, addresses = pages
    page = seen.page
    for where in addresses:
        page.goto(where)
        if "machine" not in where:  # whose several hundred fields are closed by section
            page.evaluate(OPENED)
        page.evaluate(
            f"""window.choice = (of) => {{  // of the buttons of a choice the chosen one, or the first
                const all = [...document.querySelectorAll("input[type=radio]")].filter((each) => each.form === of.form
                    && each.name === of.name);
                return all.find((each) => each.checked) ?? all[0];
            }};
            window.stops = [...document.querySelectorAll('{FOCUSABLE}')].filter((each) => each.checkVisibility()
                && !each.disabled && !(each.type === "radio" && each !== choice(each)))"""
        )
        count = page.evaluate("stops.length")
        where_is = "[stops.indexOf(document.activeElement), document.activeElement.tagName]"
        visited = list[int]()
        for _ in range(count + 10):
            page.keyboard.press("Tab")
            k, tag = page.evaluate(where_is)
            if tag == "BODY" or (k == 0 and visited):
                break
            if tag != "IFRAME":  # which has stops of its own
                visited.append(k)
        assert visited == list(range(count)), where
        page.evaluate("stops[3].focus()")
        page.keyboard.press("Shift+Tab")
        assert page.evaluate(where_is)[0] == 2, where
        outline = page.evaluate("getComputedStyle(document.activeElement).outlineStyle")
        assert outline != "none", where
    page.goto(addresses[1])
    page.keyboard.press("Tab")
    page.keyboard.press("Enter")  # past the stages
    assert page.evaluate("document.activeElement.id") == "content"


@pytest.mark.parametrize("language", ["en-GB", "de-DE"])
def test_targets_are_large_enough_for_a_finger(browser: Browser, address: str, root: Path, language: str):
    seen = Seen(browser, address, 390, "dark", locale=language, has_touch=True)
    base = address.split("/?")[0]
    for where in (f"{base}/", *(f"{base}/m/+mill/{stage}" for stage in STAGES), f"{base}/m/ur10_wrist/machine"):
        seen.page.goto(where)
        seen.page.evaluate(OPENED)
        seen.shot(f"touch-{language}-{where.rpartition('/')[2] or 'start'}")
        small = seen.page.evaluate(
            f"""[...document.querySelectorAll('{FOCUSABLE}')].filter((each) => each.checkVisibility()
                && !each.matches('.scroll, pre')).map((each) => {{
                const label = each.matches('[type="radio"], [type="checkbox"]') && each.closest('label');
                const box = (label || each).getBoundingClientRect();
                return [each.outerHTML.slice(0, 80), box.width, box.height];
            }}).filter(([, width, height]) => width < 44 || height < 44)"""
        )
        assert small == [], where


def test_progress_is_told_seldom_and_the_keyboard_stays_where_it_is(browser: Browser, address: str, root: Path):
    seen = Seen(browser, address, reduced_motion="reduce")
    page = seen.page
    page.goto(f"{address.split('/?')[0]}/m/+mill/plan")
    page.get_by_label("Kind of motion").select_option("ptp")
    page.get_by_label(re.compile("thorough")).check()
    page.get_by_role("button", name="Search").focus()
    page.keyboard.press("Enter")
    told = page.locator("#told")
    expect(told).to_contain_text("hexcite plan: under way")
    assert told.get_attribute("role") == "status"
    page.evaluate(
        """window.said = []; window.swaps = 0;
        new MutationObserver(() => said.push(document.getElementById("told").textContent))
            .observe(document.getElementById("told"), { childList: true });
        new MutationObserver(() => { swaps += 1; })
            .observe(document.querySelector(".job"), { childList: true })"""
    )
    page.get_by_role("button", name="Stop and keep the best").focus()
    page.evaluate("new Promise((done) => setInterval(() => swaps > 3 && done(), 100))")
    assert page.evaluate("said.length <= 1 + swaps / 2")
    assert page.evaluate("document.activeElement.textContent.trim()") == "Stop and keep the best"
    assert page.evaluate("document.getAnimations().filter((each) => each.playState === 'running').length") == 0
    page.keyboard.press("Enter")
    expect(page.locator(".cards a", has_text=re.compile("mill-ptp")).first).to_be_visible()
    assert seen.errors == []
