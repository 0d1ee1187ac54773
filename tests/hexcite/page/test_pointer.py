"""Mouse and fingers on the picture of a robot, in a real Chromium: they turn it, zoom, and choose a link."""

from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, Frame, Page, expect

from tests.hexcite.page.served import Seen, address, patience

pytestmark = pytest.mark.slow
__all__ = ["address", "patience"]

LINKS = (("l1", (0, 0, 0.3)), ("l2", (0.1, 0, 0.2)), ("l3", (0.4, 0, 0.1)), ("tool0", (0.3, 0, -0.1)))
"""Links with their origins in the one before [m]: an arm in a plane."""
PLACES = """() => {
  const div = document.getElementById("machine"), scene = div._fullLayout.scene._scene;
  const { x, y, z, text } = div.data.at(-1), rows = [0, 1, 2, 3];
  const { model, view, projection } = scene.glplot.cameraParams, box = scene.container.getBoundingClientRect();
  const times = (m, v) => rows.map((row) => rows.reduce((sum, k) => sum + m[4 * k + row] * v[k], 0));
  return Object.fromEntries(text.map((name, k) => {
    const point = [x, y, z].map((values, axis) => values[k] * scene.dataScale[axis]);
    const at = [model, view, projection].reduce((v, m) => times(m, v), [...point, 1]);
    return [name, [box.left + (0.5 + at[0] / at[3] / 2) * box.width, box.top + (0.5 - at[1] / at[3] / 2) * box.height]];
  }));
}"""
EYE = "() => Object.values(document.getElementById('machine')._fullLayout.scene._scene.getCamera().eye)"


class Picture:
    """The picture of a robot, and where its links are on the page."""

    def __init__(self, page: Page) -> None:
        self.page = page
        page.frame_locator(".space iframe").locator("html[data-scenes]").wait_for()
        self.frame: Frame = next(frame for frame in page.frames if frame.url.endswith("/space"))
        box = page.locator(".space iframe").bounding_box()
        assert box is not None
        self.corner, self.size = (box["x"], box["y"]), (box["width"], box["height"])
        self.middle = (box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)

    def eye(self) -> list[float]:
        """Where the camera is, once it has come to rest."""
        before: Any = None
        while before != (now := self.frame.evaluate(EYE)):
            before = now
            self.page.wait_for_timeout(400)
        return [float(each) for each in now]

    def link(self, name: str) -> tuple[float, float]:
        """A link's place on the page, a little beside its middle."""
        self.eye()
        x, y = self.frame.evaluate(PLACES)[name]
        assert 0.0 < x < self.size[0]
        assert 0.0 < y < self.size[1]
        return self.corner[0] + x + 5.0, self.corner[1] + y - 4.0


def length(eye: list[float]) -> float:
    return float(sum(each * each for each in eye) ** 0.5)


@pytest.fixture
def robot(root: Path) -> str:
    """The file of an arm, in the folder of the page."""
    parts = ['<robot name="arm"><link name="base_link"/>', *(f'<link name="{name}"/>' for name, _ in LINKS)]
    parent = "base_link"
    for name, origin in LINKS:
        kind = "fixed" if name == "tool0" else "revolute"
        parts.append(
            f'<joint name="to_{name}" type="{kind}"><parent link="{parent}"/><child link="{name}"/><axis xyz="0 1 0"/>'
            f'<origin xyz="{" ".join(map(str, origin))}"/><limit lower="-3" upper="3" effort="9" velocity="1"/></joint>'
        )
        parent = name
    (root / "arm.urdf").write_text("".join([*parts, "</robot>"]))
    return "/urdf/arm.urdf"


def test_a_mouse_turns_zooms_and_chooses_the_flange(browser: Browser, address: str, robot: str) -> None:
    seen = Seen(browser, address)
    page = seen.page
    page.goto(address.split("/?")[0] + robot)
    picture, menu = Picture(page), page.locator("#f-flange")
    expect(menu).to_have_value("tool0")
    before = picture.eye()
    x, y = picture.middle
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 80, y + 20, steps=8)
    page.mouse.up()
    turned = picture.eye()
    assert max(abs(a - b) for a, b in zip(before, turned, strict=True)) > 0.2
    assert length(turned) == pytest.approx(length(before), rel=0.05)
    expect(menu).to_have_value("tool0")  # a drag chooses nothing
    page.mouse.wheel(0, -40)  # is the page's own
    assert length(picture.eye()) == pytest.approx(length(turned), rel=1e-6)
    page.keyboard.down("Control")
    page.mouse.wheel(0, -40)
    assert length(picture.eye()) < 0.97 * length(turned)
    page.mouse.wheel(0, 40)
    page.keyboard.up("Control")
    for name in ("l1", "l3", "base_link", "tool0"):
        page.mouse.click(*picture.link(name))
        expect(menu).to_have_value(name)
    menu.select_option("l2")  # by the keyboard, the picture follows
    page.mouse.click(picture.corner[0] + 5, picture.corner[1] + picture.size[1] - 5)  # nothing is there
    expect(menu).to_have_value("l2")
    assert seen.errors == []


def test_fingers_turn_zoom_and_choose_the_flange(browser: Browser, address: str, robot: str) -> None:
    seen = Seen(browser, address, 390, has_touch=True)
    page = seen.page
    page.goto(address.split("/?")[0] + robot)
    picture, menu = Picture(page), page.locator("#f-flange")
    page.touchscreen.tap(*picture.link("l2"))
    expect(menu).to_have_value("l2")
    device, (x, y) = page.context.new_cdp_session(page), picture.middle

    def move(*ways: list[tuple[float, float]]) -> None:
        """Moves fingers along their ways, which have the same number of points."""
        for k, points in enumerate(zip(*ways, strict=True)):
            fingers = [{"x": px, "y": py, "id": number} for number, (px, py) in enumerate(points)]
            kind = "touchMove" if k else "touchStart"
            device.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": fingers})
        device.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})

    before = picture.eye()
    move([(x + 10 * k, y) for k in range(8)])
    turned = picture.eye()
    assert max(abs(a - b) for a, b in zip(before, turned, strict=True)) > 0.2
    move([(x - 30 - 5 * k, y) for k in range(8)], [(x + 30 + 5 * k, y) for k in range(8)])
    nearer = picture.eye()
    assert length(nearer) < 0.8 * length(turned)
    assert [a / length(nearer) for a in nearer] == pytest.approx([a / length(turned) for a in turned], abs=0.02)
    expect(menu).to_have_value("l2")
    assert seen.errors == []
