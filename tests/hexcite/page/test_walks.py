"""From a drawing, and from a robot's file, to a proven program: in a real Chromium, its clicks and fields counted."""

import re
from collections.abc import Callable
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Locator, expect

from tests.hexcite.browser import browser
from tests.hexcite.page.test_in_browser import Seen, address, patience

pytestmark = pytest.mark.slow
__all__ = ["address", "browser", "patience"]

DRAWING = {  # of a hexapod that is not built in: value as the drawing has it, and its unit where that is another one
    "machine.base.ring.radius_mm": ("640", ""),
    "machine.base.ring.half_angle_deg": ("28", "included_angle_deg:deg"),
    "machine.platform.ring.radius_mm": ("0.23", "radius_mm:m"),
    "machine.platform.ring.half_angle_deg": ("92", "included_angle_deg:deg"),
    "machine.home.z_mm": ("850", ""),
    "workspace.strut_length_mm": ("[600, 1500]", ""),
    "limits.motion.strut_length_mm": ("[650, 1420]", ""),
    "limits.motion.acceleration_m_s2": ("[5000, 5000, 5000]", "acceleration_m_s2:mm/s²"),
    "nominal.mass_kg": ("28,4", ""),
}
ARM = """<robot name="arm"><link name="base"/>{links}<link name="tool0"/>
<joint name="fix" type="fixed"><parent link="l6"/><child link="tool0"/><origin xyz="0 0 0.08"/></joint></robot>"""
JOINT = """<link name="l{k}"/><joint name="j{k}" type="revolute"><parent link="{parent}"/><child link="l{k}"/>
<origin xyz="{xyz}" rpy="{rpy}"/><axis xyz="0 0 1"/><limit lower="-3" upper="3" velocity="2.5" effort="100"/></joint>"""
PLACES = (
    ("0 0 0.2", "0 0 0"), ("0 0 0", "1.5708 0 0"), ("0.5 0 0", "0 0 0"), ("0.45 0 0", "0 0 0"),
    ("0 0 0.12", "-1.5708 0 0"), ("0 0 0.1", "1.5708 0 0"),
)  # fmt: skip


class Walk(Seen):
    """A page, with what a person has done on it."""

    clicks = 0
    fields = 0

    def click(self, what: Locator) -> None:
        """Presses a button, a link or a box."""
        what.click()
        self.clicks += 1

    def fill(self, what: Locator, value: str) -> None:
        """Types a value."""
        what.fill(value)
        self.fields += 1

    def choose(self, what: Locator, value: str) -> None:
        """Chooses in a menu."""
        what.select_option(value)
        self.fields += 1

    def field(self, name: str) -> Locator:
        """The field of a value, in whatever part of the form; opened where it is closed."""
        own = self.page.locator(f'[id="v.{name}"], [id="w.{name}"]')
        closed = own.locator("xpath=ancestor::details[not(@open)]")
        while closed.count():
            self.click(closed.first.locator("> summary"))
        return own

    def button(self, name: str | re.Pattern[str]) -> Locator:
        """A button by its words."""
        return self.page.get_by_role("button", name=name)

    def to_a_program(self, dialect: str, after_plan: Callable[[], None] = lambda: None) -> None:
        """From a saved machine through a quick search to a proven program that is downloaded."""
        page = self.page
        self.click(page.get_by_role("link", name="Next: Plan"))
        self.fill(page.get_by_label("Seconds of the motion"), "8")
        after_plan()
        self.click(self.button("Search"))
        self.click(page.get_by_role("link", name="Next: Program"))
        self.choose(page.locator("#f-dialect"), dialect)
        self.click(self.button("Write and prove"))
        expect(page.locator(".good")).to_contain_text("proven")
        expect(page.get_by_role("heading", name="How to record on this control")).to_be_visible()
        with page.expect_download() as download:
            self.click(page.get_by_role("link", name=re.compile("Download")))
        assert Path(download.value.path()).stat().st_size > 1000

    def told(self, what: str) -> None:
        """Prints what it took."""
        print(f"{what}: {self.clicks} clicks, {self.fields} fields")


def test_a_foreign_hexapod_from_its_drawing_to_a_proven_program(browser: Browser, address: str, root: Path):
    walk = Walk(browser, address)
    page = walk.page
    walk.fill(page.locator("#f-name"), "stewart")
    walk.choose(page.locator("#f-like"), "hexapod")
    walk.click(walk.button("Make it"))
    expect(page.get_by_role("heading", name="Machine", exact=True)).to_be_visible()
    lengths = page.locator(".lengths b")
    before = lengths.first.inner_text()
    for name, (value, unit) in DRAWING.items():
        own = walk.field(name)
        walk.fill(own, value)
        if unit:
            walk.choose(page.locator(f'[name="u.{name}"]'), unit)
    expect(lengths.first).not_to_have_text(before)
    walk.click(walk.button("Save"))
    expect(page.get_by_role("status").first).to_contain_text("Saved")
    content = (root / "stewart" / "case.toml").read_text()
    assert "included_angle_deg = 28.0" in content
    assert "radius_mm = 230.0" in content
    assert re.search(r"acceleration_m_s2 = \[\s*5(\.0)?,", content)
    walk.to_a_program("sinumerik")
    page.go_back()
    page.get_by_role("link", name=re.compile("2 Plan")).click()
    expect(page.get_by_text("stewart-manual").first).to_be_visible()
    walk.told("foreign hexapod")
    assert walk.errors == []
    assert walk.clicks <= 12
    assert walk.fields <= 2 * len(DRAWING) + 5


def test_an_arm_of_a_urdf_file_to_a_proven_program(browser: Browser, address: str, root: Path, tmp_path: Path):
    links = "".join(
        JOINT.format(k=k, parent="base" if k == 1 else f"l{k - 1}", xyz=xyz, rpy=rpy)
        for k, (xyz, rpy) in enumerate(PLACES, 1)
    )
    (tmp_path / "arm.urdf").write_text(ARM.format(links=links))
    walk = Walk(browser, address)
    page = walk.page
    page.get_by_label(re.compile("URDF file")).set_input_files(str(tmp_path / "arm.urdf"))
    walk.clicks += 1
    space = page.frame_locator("iframe")
    expect(space.locator("html[data-scenes]")).to_have_count(1)
    picked = "Plotly && document.getElementById('machine').emit('plotly_click', { points: [{ customdata: 'l5' }] })"
    frame = next(each for each in page.frames if each.url.endswith("/space"))
    frame.evaluate(picked)
    expect(page.locator("#f-flange")).to_have_value("l5")
    frame.evaluate(picked.replace("l5", "tool0"))
    walk.clicks += 1
    expect(page.locator("#f-flange")).to_have_value("tool0")
    walk.click(walk.button("Make it"))
    expect(page.get_by_role("heading", name="Machine", exact=True)).to_be_visible()

    walk.choose(walk.field("sensor_frame.transducer.sense"), "load_on_sensor")
    for k, angle in enumerate(("0", "60", "-90", "30", "90", "0")):
        walk.fill(walk.field(f"machine.chain.joints[{k}].home_deg"), angle)
    expect(page.locator("#s-2")).to_have_value("60")
    for name, value in (("force_noise_N", "0.5"), ("moment_noise_Nm", "0.02")):
        walk.fill(walk.field(f"sensors.{name}"), value)
    for k in range(6):
        for name, value in (("acceleration_rad_s2", "5"), ("jerk_rad_s3", "100")):
            walk.fill(walk.field(f"limits.motion.joints[{k}].{name}"), value)
        walk.click(page.locator(f'[name="on.limits.motion.joints[{k}]"]'))
    for name, value in (
        ("mass_kg", "2,2"), ("centre_of_gravity_mm", "[0, 0, 60]"), ("inertia_kg_m2", "[0.006, 0, 0, 0.006, 0, 0.003]"),
    ):  # fmt: skip
        walk.fill(walk.field(f"nominal.{name}"), value)
    walk.click(walk.button("Save"))
    expect(page.get_by_role("status").first).to_contain_text("Saved")
    walk.to_a_program("ros2")
    walk.told("arm of a URDF file")
    assert walk.errors == []
    assert walk.clicks <= 35
    assert walk.fields <= 30


def test_a_slider_of_a_joint_is_seen_and_written_when_saved(browser: Browser, address: str, root: Path):
    """The picture follows within the frame, distances beside it, and nothing is written before."""
    walk = Walk(browser, address, 390, "dark")
    page = walk.page
    walk.fill(page.locator("#f-name"), "arm")
    walk.choose(page.locator("#f-like"), "ur10_wrist")
    walk.click(walk.button("Make it"))
    expect(page.get_by_role("heading", name="Machine", exact=True)).to_be_visible()
    file = root / "arm" / "case.toml"
    before = file.read_bytes()
    page.locator("#s-2").fill("10")
    expect(page.locator("tr.hit", has_text="distance from floor (upper arm)")).to_be_visible()
    expect(page.locator('[id="v.machine.chain.joints[1].home_deg"]')).to_have_value("10.0")
    assert file.read_bytes() == before
    page.locator("#s-2").fill("-80")
    expect(page.locator("tr.hit")).to_have_count(0)
    walk.click(page.locator('[data-for="s-turn-z"][data-turn="90"]'))
    expect(page.locator('[id="w.machine.chain.sensor.rpy_deg"]')).to_have_value("[0.000, 0.000, 90.000]")
    walk.click(walk.button("Save"))
    expect(page.get_by_role("status").first).to_contain_text("Saved")
    assert "rpy_deg = [0.0, 0.0, 90.0]" in file.read_text()
    assert "home_deg = -80.0" in file.read_text()
    walk.shot("arm-1-machine")
    assert walk.errors == []
