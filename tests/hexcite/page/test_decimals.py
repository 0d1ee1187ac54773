"""Decimal commas of the German page: in what it says, and never in what is typed, read by programs, or a name."""

import re
from html.parser import HTMLParser
from pathlib import Path

import pytest
from starlette.testclient import TestClient

from cases.scaffold import new_case
from hexcite.page.forms import _targets
from hexcite.texts.decimals import page_with_commas, with_commas


@pytest.mark.parametrize(
    ("written", "shown"),
    [
        ("558.74 mm", "558,74 mm"),
        ("von 0.5 bis 12.25.", "von 0,5 bis 12,25."),
        ("±0.012, -1.5e-05 und (\u22120.5)", "±0,012; -1,5e-05 und (\u22120,5)"),
        ("0.5, -1, 2.25 mm", "0,5; -1; 2,25 mm"),  # else nobody knows where a number ends
        ("Bestes 0.5, noch 20 s", "Bestes 0,5, noch 20 s"),
        ("Streben 1, 2 und 3", "Streben 1, 2 und 3"),
        ("recording.clock.period_ms = 0.5 senkt es um 0.5", "recording.clock.period_ms = 0.5 senkt es um 0,5"),
        ("etwa [0.0, 0.0, -9.81], 9.81", "etwa [0.0, 0.0, -9.81], 9,81"),
        ("flange = { origin_mm = [0.0, 1.5] }", "flange = { origin_mm = [0.0, 1.5] }"),
        ("mit --speed 0.1 auf 0.1", "mit --speed 0.1 auf 0,1"),
        ("'0.5' ist keine Zahl", "'0.5' ist keine Zahl"),
        ("plan-2.5, Lauf 1.5.csv, v0.3, 3.6.7, 127.0.0.1", "plan-2.5, Lauf 1.5.csv, v0.3, 3.6.7, 127.0.0.1"),
        ("LinuxCNC 2.9, ab Version 2.10", "LinuxCNC 2.9, ab Version 2.10"),
        ("G1 X12.5 Y0.25", "G1 X12.5 Y0.25"),
    ],
)
def test_numbers_of_a_text_have_commas_and_what_is_typed_or_named_has_points(written: str, shown: str):
    assert with_commas(written) == shown
    assert with_commas(shown) == shown


def test_a_page_keeps_code_fields_menus_names_and_quotations():
    kept = (
        '<code>x = 0.5</code><pre>G1 X1.5 0.5</pre><input value="0.5" placeholder="1.5"><option>0.5</option>'
        '<script>let a = 0.5;</script><style>a { width: 0.5em }</style><q lang="en">0.5 mm</q>'
        '<b translate="no">Lauf 0.5</b><polyline points="0.5,1.5"/>&#39;0.5&#39;'
    )
    assert page_with_commas(kept) == kept
    said = '<p title="0.5 mm" data-of="0.5">a &lt; 0.5 &amp; <b>1.5</b></p>'
    assert page_with_commas(said) == '<p title="0,5 mm" data-of="0.5">a &lt; 0,5 &amp; <b>1,5</b></p>'


class Filled(HTMLParser):
    """What the forms of a page would send: name and value of each field, and of each choice."""

    def __init__(self) -> None:
        super().__init__()
        self.values: list[tuple[str, str]] = []
        self.typed: dict[str, str] = {}
        self._menu = ""

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        about = dict(attrs)
        if tag in ("input", "button") and about.get("name"):
            self.values.append((about["name"] or "", about.get("value") or ""))
            if about.get("type") in (None, "hidden"):
                self.typed[about["name"] or ""] = about.get("value") or ""
        if tag == "select":
            self._menu = about.get("name") or ""
        if tag == "option":
            self.values.append((self._menu, about.get("value") or ""))

    def handle_data(self, data: str) -> None:
        if self.get_starttag_text() in ("<option>", "<option selected>") and data.strip():
            self.values[-1] = (self._menu, data)


def filled(client: TestClient, place: str, language: str) -> Filled:
    """What the forms of a stage hold in a language."""
    page = Filled()
    page.feed(client.get(place, headers={"accept-language": language}).text)
    page.values = [(name, value) for name, value in page.values if name != "language"]
    return page


def test_fields_hold_the_same_values_in_both_languages_and_are_taken_back_unchanged(client: TestClient, root: Path):
    new_case("mill", "hexapod", root / "mill")
    for stage in ("machine", "plan", "data"):
        values = filled(client, f"/m/+mill/{stage}", "en").values
        assert filled(client, f"/m/+mill/{stage}", "de").values == values
    before = (root / "mill" / "case.toml").read_text()
    typed = filled(client, "/m/+mill/machine", "de").typed
    typed = {name: value for name, value in typed.items() if value and not name.startswith(("w.", "on."))}
    assert sum(bool(re.fullmatch(r"-?\d+\.\d+", value)) for value in typed.values()) > 20
    page = client.get("/m/+mill/machine", headers={"accept-language": "de"}).text
    assert re.search(r"<b>\d+,\d+</b>", page)  # lengths at home, which people read
    assert client.post("/m/+mill/do/save", data=typed, headers={"accept-language": "de"}).status_code == 303
    assert (root / "mill" / "case.toml").read_text() == before


def test_accuracies_are_typed_with_points_or_commas():
    assert _targets("m=5g, zC=0.05mm") == ["m=5g", "zC=0.05mm"]
    assert _targets("m=5g; zC=0,05mm") == ["m=5g", "zC=0.05mm"]
    assert _targets("zC=0,05mm,m=5g") == ["zC=0.05mm", "m=5g"]
    assert _targets("") == []
