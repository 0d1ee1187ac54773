"""A walk through all stages in a real Chromium with an arm that the project knows from its URDF file alone.

Between the downloaded program and the dropped recordings stands nothing of hexcite: a trajectory is interpreted as the
maker of its controller describes it, MuJoCo moves the arm with friction and drives that lag.
"""

import re
from math import pi
from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import Browser, Page, expect

from tests.driven import controllers, recorders
from tests.driven.arms import HALF, Arm, Joint, Load
from tests.driven.plant import drive
from tests.hexcite.page.served import Seen, address, patience

pytestmark = pytest.mark.slow
__all__ = ["address", "patience"]

_SHOULDER, _ELBOW, _WRIST = (2.967, 2.094), (1.484, 320.0), (2.356, 40.0)
ARM = Arm(  # dimensions, ends, speeds and torques as published for KUKA's LBR iiwa 14
    "lbr_like",
    (
        Joint((0.0, 0.0, 0.1575), (0.0, 0.0, 0.0), (-_SHOULDER[0], _SHOULDER[0]), *_ELBOW, 4.0),
        Joint((0.0, 0.0, 0.2025), (HALF, 0.0, pi), (-_SHOULDER[1], _SHOULDER[1]), *_ELBOW, 4.0),
        Joint((0.0, 0.2045, 0.0), (HALF, 0.0, pi), (-_SHOULDER[0], _SHOULDER[0]), 1.745, 176.0, 3.0),
        Joint((0.0, 0.0, 0.2155), (HALF, 0.0, 0.0), (-_SHOULDER[1], _SHOULDER[1]), 1.309, 176.0, 2.7),
        Joint((0.0, 0.1845, 0.0), (-HALF, pi, 0.0), (-_SHOULDER[0], _SHOULDER[0]), 2.269, 110.0, 1.7),
        Joint((0.0, 0.0, 0.2155), (HALF, 0.0, 0.0), (-_SHOULDER[1], _SHOULDER[1]), *_WRIST, 1.8),
        Joint((0.0, 0.081, 0.0), (-HALF, pi, 0.0), (-3.054, 3.054), *_WRIST, 0.3),
    ),
    ((0.0, 0.0, 0.045), (0.0, 0.0, 0.0)),
    ((0.0, 0.0, 0.0375), (0.0, 0.0, -pi / 4)),
    tuple(np.radians([0.0, 30.0, 0.0, -80.0, 0.0, 60.0, 0.0]).tolist()),
    0.5,
)
GUESS = Load(0.8, (0.0, 0.0, 0.04), (0.002, 0.0, 0.0, 0.001, 0.0, 0.002))  # of the hand, as its file has it
HAND = Load(0.73, (-0.002, 0.003, 0.041), (0.0025, 0.0001, 0.0, 0.0006, 0.0, 0.0022))
BLOCK = Load(0.62, (0.011, -0.007, 0.152), (0.0009, 0.00005, -0.00002, 0.0011, 0.00004, 0.0007))


def together(*bodies: Load) -> Load:
    """The body that some bodies are, joined."""
    mass = sum(body.mass for body in bodies)
    centre = sum(body.mass * np.array(body.centre) for body in bodies) / mass
    tensor = np.zeros((3, 3))
    for body in bodies:
        xx, xy, xz, yy, yz, zz = body.inertia
        off = np.array(body.centre) - centre
        tensor += [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]
        tensor += body.mass * (off @ off * np.eye(3) - np.outer(off, off))
    (x, y, z), (xx, xy, xz, yy, yz, zz) = centre.tolist(), tensor[np.triu_indices(3)].tolist()
    return Load(mass, (x, y, z), (xx, xy, xz, yy, yz, zz))


def switched_on(page: Page, key: str, value: str) -> None:
    """States a value of the machine that its file does not have yet."""
    page.evaluate("for (const each of document.querySelectorAll('details')) each.open = true")
    page.locator(f'[name="on.{key}"]').check()
    field = page.locator(f'[id="w.{key}"]')
    if field.evaluate("(each) => each.tagName") == "SELECT":
        field.select_option(value)
    else:
        field.fill(value)


def described(page: Page) -> None:
    """From the dropped file to a machine that can be planned for."""
    page.locator('input.upload[data-to="/urdf/"]').set_input_files(
        {"name": "lbr.urdf", "mimeType": "text/xml", "buffer": ARM.urdf(GUESS.urdf).encode()}
    )
    expect(page.locator("#f-flange")).to_have_value("tool0")
    expect(page.locator("#f-sensor")).to_have_value("ft")
    page.get_by_role("button", name="Make it").click()
    page.locator('[name="on.joints"]').check()
    for k, home in enumerate(np.degrees(ARM.home)):
        page.locator(f'[id="w.machine.chain.joints[{k}].home_deg"]').fill(f"{home:.1f}")
    for column, value in (("position", "-28, 28"), ("acceleration", "4"), ("jerk", "60")):
        page.locator(f'input[data-column="{column}"]').fill(value)
    switched_on(page, "sensor_frame.transducer.sense", "load_on_sensor")
    switched_on(page, "sensors.force_noise_N", "0.3")
    switched_on(page, "sensors.moment_noise_Nm", "0.008")
    page.get_by_role("button", name="Save").click()
    expect(page.get_by_role("link", name="Next: Plan")).to_be_visible()


def identified(page: Page, file: Path) -> None:
    """From the dropped recording to its verdict."""
    page.get_by_role("link", name=re.compile("4 Data")).click()
    page.locator("#f-file").set_input_files(str(file))
    expect(page.get_by_text("The file is read with these settings.")).to_be_visible()
    take = page.get_by_role("button", name="Take the proposal into the case, and identify")
    (take if take.count() else page.get_by_role("button", name="Identify the parameters")).click()
    expect(page.locator(".verdict")).to_be_visible()


def test_from_a_urdf_file_to_payload_export_and_certificate(
    browser: Browser, address: str, root: Path, tmp_path: Path
) -> None:
    seen = Seen(browser, address)
    page = seen.page
    described(page)
    page.get_by_role("link", name="Next: Plan").click()
    page.get_by_label("Kind of motion").select_option("manual")
    page.get_by_role("button", name="Search").click()
    page.get_by_role("link", name="Next: Program").click()
    page.get_by_label("Controller").select_option("ros2")
    page.get_by_role("button", name="Write and prove").click()
    expect(page.locator(".good")).to_contain_text("proven")
    with page.expect_download() as download:
        page.get_by_role("link", name=re.compile("Download")).click()
    run = controllers.joint_trajectory(Path(download.value.path()).read_text(), ARM.names, np.array(ARM.home))

    for seed, (name, load) in enumerate({"empty": HAND, "loaded": together(HAND, BLOCK)}.items()):
        course = drive(ARM, load, run.at, run.duration + 0.5)
        identified(page, recorders.table(tmp_path / f"{name}.csv", course, seed))
    page.locator("#f-before").select_option("empty-result")
    page.locator("#f-after").select_option("loaded-result")
    page.get_by_role("button", name="Compute the payload").click()
    rows = page.locator("table.payload tr")
    truth = {"mass": BLOCK.mass, **{f"gravity {n}": 1e3 * v for n, v in zip("xyz", BLOCK.centre, strict=True)}}
    for words, value in truth.items():
        cells = rows.filter(has_text=words).locator("td")
        found, deviation = (float(cells.nth(k).inner_text()) for k in (1, 2))
        assert abs(found - value) < 4.0 * deviation, words
    page.locator("#f-payload-to").select_option("kuka")
    page.get_by_role("button", name="Compute the payload").click()
    text = page.locator("pre.text").inner_text()
    mass, z = (re.search(pattern, text) for pattern in (r"\{M ([\d.]+)", r"Z ([\d.]+)"))
    assert mass is not None
    assert z is not None
    assert float(mass[1]) == pytest.approx(BLOCK.mass, abs=0.02)
    assert float(z[1]) == pytest.approx(152.0 + 37.5, abs=5.0)  # from the flange

    page.get_by_role("link", name="Next: Use").click()
    page.locator("#f-to").select_option("urdf")
    page.get_by_role("button", name="Preview").click()
    expect(page.locator("pre.text").first).to_contain_text("<inertial>")
    page.locator("#c-operator").fill("A. Operator")
    page.get_by_role("button", name="Write the certificate").click()
    expect(page.locator(".good").filter(has_text=".pdf")).to_be_visible()
    (certificate,) = root.glob("*.pdf")
    assert certificate.read_bytes().startswith(b"%PDF")
    assert seen.errors == []
