"""Two walks by keyboard alone, counted: an export of Scope to a verdict, and recordings of a robot to its payload."""

import csv
import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import Browser, Locator, Page, expect

import hexcite as hx
from cases.scaffold import new_case
from cases.schema import Case, load_case
from tests.hexcite.page.served import Seen, address, patience
from tests.identification.recording.formats.test_twincat import exported

pytestmark = pytest.mark.slow
__all__ = ["address", "patience"]

FAR = 400  # stops of the tab key that a page has at most


class Walker:
    """Someone with a keyboard alone.

    Args:
        page: that they are at.
        keys: how many they pressed until now, texts counted by letters.
        acts: how often they decided something: a button, a choice, a text, a file.
    """

    def __init__(self, page: Page) -> None:
        self.page, self.keys, self.acts = page, 0, 0
        page.on("filechooser", lambda chooser: None)  # from now on: asked for by the first dialog, it would come late

    def press(self, key: str) -> None:
        self.page.keyboard.press(key)
        self.keys += 1

    def reach(self, wanted: Locator) -> None:
        """Goes to a control by the tab key."""
        wanted.first.wait_for()
        for _ in range(FAR):
            if wanted.first.evaluate("(each) => each === document.activeElement"):
                return
            self.press("Tab")
        raise AssertionError(f"{wanted} is not reached by the keyboard")

    def act(self, wanted: Locator) -> None:
        """Presses a button, or follows a link."""
        self.reach(wanted)
        self.press("Enter")
        self.acts += 1

    def write(self, wanted: Locator, text: str) -> None:
        """Types a text, or the beginning of a choice."""
        self.reach(wanted)
        self.page.keyboard.type(text)
        self.keys += len(text)
        self.acts += 1

    def choose(self, wanted: Locator, option: str) -> None:
        """Goes down, or up, in a menu to a choice."""
        self.reach(wanted)
        options = wanted.first.evaluate("(each) => [...each.options].map((option) => option.value || option.text)")
        way = options.index(option) - wanted.first.evaluate("(each) => each.selectedIndex")
        for _ in range(abs(way)):
            self.press("ArrowDown" if way > 0 else "ArrowUp")
        assert wanted.first.input_value() == option
        self.acts += 1

    def pick(self, among: Locator, value: str) -> None:
        """Goes to one of several buttons of which one is on."""
        self.reach(among)
        self.press("Space")
        for _ in range(among.count()):
            if self.page.evaluate("document.activeElement.value") == value:
                break
            self.press("ArrowDown")
        assert self.page.evaluate("[document.activeElement.value, document.activeElement.checked]") == [value, True]
        self.acts += 1

    def drop(self, file: Path) -> None:
        """Chooses a file in the dialog of the system."""
        self.reach(self.page.locator("#f-file"))
        with self.page.expect_file_chooser() as dialog:
            self.press("Enter")
        dialog.value.set_files(str(file))
        self.acts += 1


@pytest.fixture
def walker(browser: Browser, address: str, request: pytest.FixtureRequest) -> Iterator[Walker]:
    seen = Seen(browser, address)
    walker = Walker(seen.page)
    yield walker
    print(f"\n{request.node.name}: {walker.acts} decisions, {walker.keys} keys")
    assert seen.errors == []


def program_of(case: Case, folder: Path) -> hx.Program:
    """A proven program of a hand-made motion."""
    program = hx.write(hx.plan(case, hx.Manual()), "setpoints", file=folder / "made.csv")
    program.save(folder / "made.csv")
    return program


def recorded(case: Case, program: hx.Program, folder: Path, name: str, **how: int) -> tuple[list[str], np.ndarray]:
    """Head and rows of a run on the virtual controller."""
    hx.run(program, case, on="virtual", **how).save(folder / name)
    with (folder / name / "recording.csv").open(newline="") as stream:
        head, *rows = csv.reader(stream)
    return head, np.array(rows, dtype=float)


def test_an_export_of_scope_with_exchanged_struts_to_a_verdict(walker: Walker, root: Path, tmp_path: Path) -> None:
    file = new_case("mill", "hexapod", root / "mill")  # another machine than the built-in one
    file.write_text(file.read_text().replace("radius_mm = 700.0", "radius_mm = 690.0", 1))
    case = load_case(str(file))
    head, rows = recorded(case, program_of(case, tmp_path), tmp_path, "rec", seed=1)
    of = {name: rows[:, head.index(name)] for name in head}
    struts = [f"MAIN.strut[{k}]" for k in (5, 2, 3, 4, 1, 6)]  # 1 and 5 are exchanged
    forces = [f"force {k}" for k in range(1, 7)]
    stamps = 1e3 * of["t_s"]
    text = exported(
        [(struts, stamps, np.column_stack([of[f"l{k}_mm"] for k in range(1, 7)])),
         ([*forces, "trigger"], stamps, np.column_stack([*(of[f"f{k}_N"] for k in range(1, 7)), of["trigger"]]))]
    )  # fmt: skip
    (tmp_path / "scope.csv").write_text(text)

    page = walker.page
    page.reload()  # the machine was made meanwhile
    walker.act(page.get_by_role("link", name=re.compile("^mill")))
    walker.act(page.get_by_role("link", name=re.compile("4 Data")))
    walker.drop(tmp_path / "scope.csv")
    walker.act(page.get_by_role("button", name="Take the proposal into the case, and identify"))
    expect(page.locator(".job .error")).to_contain_text("struts 1 and 5 are exchanged")
    walker.act(page.get_by_role("button", name=re.compile("^Accept")))
    expect(page.locator(".verdict.good")).to_be_visible()
    mass = page.locator(".parameters tr", has_text="mass (m)").locator("td").nth(1).inner_text()
    assert float(mass) == pytest.approx(33.0, abs=0.05)
    assert walker.acts == 5


def test_recordings_of_a_robot_to_its_payload(walker: Walker, root: Path, tmp_path: Path) -> None:
    case = load_case("ur10_wrist")
    program = program_of(case, tmp_path)
    for name, seed, payload in (("empty", 1, 0), ("loaded", 2, 1)):
        head, rows = recorded(case, program, tmp_path, name, seed=seed, payload=payload)
        names = [re.sub(r"^q(\d)_deg$", lambda found: f"actual_q_{int(found[1]) - 1}", name) for name in head]
        names = [re.sub("^t_s$", "timestamp", name) for name in names]
        turned = [column.startswith("actual_q") for column in names]
        table = np.where(turned, np.deg2rad(rows), rows)  # as the robot's interface has them
        with (tmp_path / f"{name}.csv").open("w", newline="") as stream:
            csv.writer(stream).writerows([names, *table.tolist()])

    page = walker.page
    walker.write(page.get_by_label(re.compile("^Name")), "arm")
    walker.pick(page.locator("input[name=like]"), "ur10_wrist")
    walker.act(page.get_by_role("button", name="Make it"))
    for file in ("empty", "loaded"):
        expect(page.get_by_role("link", name=re.compile("4 Data"))).to_be_visible()
        walker.act(page.get_by_role("link", name=re.compile("4 Data")))
        walker.drop(tmp_path / f"{file}.csv")
        expect(page.get_by_text("The file is read with these settings.")).to_be_visible()
        first = file == "empty"
        name = "Take the proposal into the case, and identify" if first else "Identify the parameters"
        walker.act(page.get_by_role("button", name=name))
        expect(page.locator(".verdict")).to_be_visible()
    walker.choose(page.locator("#f-before"), "empty-result")
    walker.choose(page.locator("#f-after"), "loaded-result")
    walker.act(page.get_by_role("button", name="Compute the payload"))
    expect(page.locator("table.payload")).to_be_visible()
    mass = page.locator("table.payload tr", has_text="mass (m)").locator("td")
    truth = 0.5  # of the case's weight
    assert abs(float(mass.nth(1).inner_text()) - truth) < 4.0 * float(mass.nth(2).inner_text())
    assert (root / "loaded-result-payload.html").is_file()
    assert walker.acts == 12
