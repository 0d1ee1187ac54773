"""Tables of the stage Plan in a real Chromium: no number, unit or verdict is cut off beside another table."""

from pathlib import Path

import pytest
from playwright.sync_api import Browser

import hexcite as hx
from tests.hexcite.page.served import Seen, address, patience

pytestmark = pytest.mark.slow
__all__ = ["address", "patience"]

CUT = """() => [...document.querySelectorAll("main .scroll")].filter((each) => each.checkVisibility())
  .flatMap((scroll) => [...scroll.querySelectorAll("th, td")]
    .filter((cell) => cell.getBoundingClientRect().right > scroll.getBoundingClientRect().right + 1)
    .map((cell) => cell.textContent.trim()))"""


@pytest.mark.parametrize("name", ["hexapod", "ur10_wrist"])
def test_no_cell_is_cut_off_beside_another_table(browser: Browser, address: str, root: Path, name: str) -> None:
    hx.plan(hx.load_case(name), hx.Manual()).save(root / "by-hand")
    seen = Seen(browser, address)
    seen.page.goto(f"{address.split('/?')[0]}/m/{name}/plan?plan=by-hand")
    assert seen.page.locator("main .scroll td").count() > 20
    seen.shot(f"{name}-tables")
    assert seen.page.evaluate(CUT) == []
    assert seen.errors == []
