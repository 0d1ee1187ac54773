"""Values that are typed and not saved, in a real Chromium: no way off the stage loses them without a question."""

import re
from collections.abc import Callable
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Dialog, Page, expect

import hexcite as hx
from tests.hexcite.page.served import Seen, address, patience

pytestmark = pytest.mark.slow
__all__ = ["address", "patience"]

CLICK = "element => void setTimeout(() => element.click(), 0)"
"""Playwright's own click waits for the way that is not taken."""
WAYS: tuple[Callable[[Page], object], ...] = (
    lambda page: page.evaluate("void setTimeout(() => location.reload(), 0)"),
    lambda page: page.evaluate("void setTimeout(() => history.back(), 0)"),
    lambda page: page.get_by_role("link", name=re.compile("2 Plan")).evaluate(CLICK),
    lambda page: page.get_by_role("link", name="Next: Plan").evaluate(CLICK),
    lambda page: page.get_by_role("button", name="Deutsch").evaluate(CLICK),
)


def test_typed_values_are_not_lost_without_a_question(browser: Browser, address: str, root: Path) -> None:
    hx.new_case("mill", "hexapod", root / "mill")
    seen = Seen(browser, address)
    page, asked = seen.page, list[str]()

    def stay(dialog: Dialog) -> None:
        asked.append(dialog.type)
        dialog.dismiss()

    page.on("dialog", stay)
    page.goto(f"{address.split('/?')[0]}/m/+mill/machine")
    place = page.url
    nominal = page.locator('[id="t.nominal"]')
    nominal.evaluate("group => { group.open = true; }")
    mass = page.locator('[id="v.nominal.mass_kg"]')
    mass.click()
    mass.fill("12.5")
    for number, way in enumerate(WAYS, 1):
        way(page)
        for _ in range(200):
            if len(asked) == number:
                break
            page.wait_for_timeout(50)
        assert len(asked) == number
        assert page.url == place
        expect(mass).to_have_value("12.5")
    assert asked == ["beforeunload"] * len(WAYS)

    top = mass.bounding_box()
    page.get_by_role("button", name="Save", exact=True).click()
    expect(page.get_by_role("status").filter(has_text="Saved")).to_have_count(1)
    assert len(asked) == len(WAYS)  # what is being saved is not asked for
    assert "mass_kg = 12.5" in (root / "mill" / "case.toml").read_text()
    expect(nominal).to_have_attribute("open", "")  # the same groups are open, at the same place
    after = mass.bounding_box()
    assert top is not None
    assert after is not None
    assert after["y"] == pytest.approx(top["y"], abs=2.0)
    page.get_by_role("link", name=re.compile("2 Plan")).click()
    expect(page.get_by_role("heading", name="Plan", exact=True)).to_be_visible()
    assert len(asked) == len(WAYS)
    assert seen.errors == []
