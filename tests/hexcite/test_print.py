"""Pages on paper: each is printed as it stands, with nothing cut off, nothing to press, no figure that is not drawn."""

import io
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, Page
from pypdf import PdfReader

import hexcite as hx
from cases.schema import load_case
from tests.hexcite.browser import DRAWN
from tests.hexcite.page.conftest import calibrated
from tests.hexcite.page.served import address

pytestmark = pytest.mark.slow
__all__ = ["address", "calibrated"]

MARGIN = 10.0  # [mm]
PAPERS = {"A4": (210.0, 297.0), "Letter": (215.9, 279.4)}  # [mm]
STAGES = ("machine", "plan", "program", "data", "result", "use")
CUT = """() => {
    const width = document.documentElement.clientWidth;
    const cut = (each) => {
        const box = each.getBoundingClientRect(), style = getComputedStyle(each);
        const outside = box.width > 1 && box.height > 1 && (box.right > width + 1 || box.left < -1);
        return outside || (style.overflowX !== "visible" && each.scrollWidth > each.clientWidth + 2)
            || (style.overflowY !== "visible" && each.scrollHeight > each.clientHeight + 2);
    };
    const seen = [...document.querySelectorAll("body *")]
        .filter((each) => each.checkVisibility() && !each.closest("svg") && !each.matches(".unseen, .hidden"));
    return seen.filter(cut).map((each) => each.outerHTML.slice(0, 120));
}"""
BROKEN = r"""() => {
    const lines = (cell) => {
        const range = document.createRange();
        range.selectNodeContents(cell);
        return new Set([...range.getClientRects()].map((box) => Math.round(box.top))).size;
    };
    return [...document.querySelectorAll("td")].filter((cell) => cell.checkVisibility() && lines(cell) > 1)
        .map((cell) => cell.textContent.trim()).filter((text) => /^[-+\u2212]?[0-9.e+-]+$/.test(text));
}"""
CONTROLS = """() => [...document.querySelectorAll(
    "button, [type=file], :not(.checklist *)[type=checkbox], [type=radio], [type=range], iframe, .player,"
    + " .modebar, .plot.live")]
    .filter((each) => each.checkVisibility()).map((each) => each.outerHTML.slice(0, 120))"""


def require_whole(page: Page, name: str, heading: str) -> None:
    """Prints a page on each paper; `heading`: what its last words are under."""
    page.emulate_media(media="print")
    for paper, (width, height) in PAPERS.items():
        size = {"width": int((width - 2 * MARGIN) / 25.4 * 96), "height": int((height - 2 * MARGIN) / 25.4 * 96)}
        page.set_viewport_size(size)
        assert page.evaluate(CUT) == [], (name, paper)
        assert page.evaluate(BROKEN) == [], (name, paper)
        assert page.evaluate(CONTROLS) == [], (name, paper)
        margin: Any = dict.fromkeys(("top", "bottom", "left", "right"), f"{MARGIN:g}mm")
        document = PdfReader(io.BytesIO(page.pdf(format=paper, margin=margin)))
        box = document.pages[0].mediabox
        assert (float(box.width), float(box.height)) == pytest.approx((width / 25.4 * 72, height / 25.4 * 72), abs=1.5)
        text = " ".join(" ".join(sheet.extract_text() for sheet in document.pages).split())
        assert "being drawn" not in text, (name, paper)
        assert heading in text, (name, paper)
    page.emulate_media(media="screen")


@pytest.fixture(scope="module")
def reports(calibrated: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Pages of a plan, poses, a result, forces, a payload, a history and a comparison."""
    folder, case = tmp_path_factory.mktemp("reports"), load_case(str(calibrated / "mill" / "case.toml"))
    plan, result = hx.Plan.load(calibrated / "plan"), hx.Result.load(calibrated / "res", case)
    run = hx.Recording.load(calibrated / "rec", case)
    program = hx.write(plan, "sinumerik", file=folder / "made.mpf")
    program.save(folder / "made.mpf")
    hx.run(program, case, on="virtual", seed=2, payload=1).save(folder / "rec")
    hx.identify(hx.Recording.load(folder / "rec", case)).save(folder / "loaded")
    loaded = hx.Result.load(folder / "loaded", case)
    values: dict[str, Callable[[], Any]] = {
        "plan": lambda: plan,
        "poses": lambda: hx.plan_poses(case, count=6),
        "result": lambda: hx.identify(run),
        "force": lambda: hx.force(run, result),
        "payload": lambda: hx.payload(result, loaded),
        "history": lambda: hx.history([calibrated / "res", folder / "loaded"]),
        "comparison": lambda: hx.compare([calibrated / "plan", calibrated / "res"], case),
    }
    for name, value in values.items():
        hx.report(value(), folder / f"{name}.html")
    return {name: folder / f"{name}.html" for name in values}


@pytest.mark.parametrize("name", ["plan", "poses", "result", "force", "payload", "history", "comparison"])
def test_a_report_is_printed_whole(browser: Browser, reports: dict[str, Path], name: str) -> None:
    page = browser.new_page()
    page.goto(reports[name].as_uri())
    page.wait_for_function(DRAWN)
    require_whole(page, name, "Inputs and versions")
    page.close()


@pytest.fixture
def root(calibrated: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(calibrated, tmp_path / "root"))


def test_stages_of_the_guided_page_are_printed_whole(browser: Browser, address: str, root: Path) -> None:
    page = browser.new_page(locale="en-GB")
    page.goto(address)
    require_whole(page, "start", "Which machine?")
    for stage in STAGES:
        page.goto(f"{address.split('/?')[0]}/m/+mill/{stage}")
        page.evaluate("for (const each of document.querySelectorAll('details:not([data-frame])')) each.open = true")
        require_whole(page, stage, page.locator("h1").inner_text())
