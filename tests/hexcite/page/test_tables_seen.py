"""Tables of the stages in a real Chromium: no number, unit or verdict is cut off, on a screen or on a phone."""

import shutil
from pathlib import Path

import pytest
from playwright.sync_api import Browser, expect

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


@pytest.mark.parametrize("locale", ["de-DE", "en-GB"])
def test_no_cell_of_program_data_and_result_is_cut_off(
    browser: Browser, address: str, root: Path, calibrated: Path, locale: str
) -> None:
    for name in ("mill", "plan", "rec", "res"):
        shutil.copytree(calibrated / name, root / name)
    shutil.copytree(root / "res", root / "again")
    seen, stages = Seen(browser, address, locale=locale), f"{address.split('/?')[0]}/m/+mill"
    page = seen.page
    page.goto(f"{stages}/program?plan=plan")
    page.locator("#f-dialect").select_option("sinumerik")
    page.locator("form.fields .act button").click()
    expect(page.locator("table.limits")).to_be_visible()
    program = page.url
    page.goto(f"{stages}/data?recording=rec")
    page.locator('form[action$="/do/look"] button').click()
    expect(page.locator("form.reading")).to_be_visible()
    places = {"program": program, "data": page.url, "result": f"{stages}/result?result=res&other=again"}
    for width in (1280, 390):
        page.set_viewport_size({"width": width, "height": 900})
        for stage, place in {**places, "plan": f"{stages}/plan"}.items():
            page.goto(place)
            page.evaluate("for (const each of document.querySelectorAll('details:not([data-frame])')) each.open = true")
            seen.shot(f"{stage}-{width}-{locale}")
            assert page.evaluate(CUT) == [], f"{stage}, {width} pixels"
    assert page.locator("main .scroll td").count() > 20
    assert seen.errors == []
