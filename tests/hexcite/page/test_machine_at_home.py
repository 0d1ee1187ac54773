"""A machine while its values are typed: its scene in 3-D, distances at home, links of a URDF, limits that light."""

import base64
import json
import re
import time
from pathlib import Path

import numpy as np
import pytest
from starlette.testclient import TestClient

import hexcite as hx
from hexcite.reports.drawing.scene import moving_machine, standing_machine, with_limits
from planner.families.manual import in_turn
from tests.helpers import SHORT_MOVES

URDF = """<robot name="two"><link name="world"/><link name="upper"/><link name="{wrist}"/><link name="tool0"/>
<joint name="swing" type="revolute"><parent link="world"/><child link="upper"/><origin xyz="0 0 0.4"/>
<axis xyz="0 1 0"/>
<limit lower="-2" upper="2" velocity="1" effort="50"/></joint>
<joint name="turn" type="revolute"><parent link="upper"/><child link="{wrist}"/><origin xyz="0.3 0 0"/>
<axis xyz="1 0 0"/>
<limit lower="-3" upper="3" velocity="1" effort="50"/></joint>
<joint name="fix" type="fixed"><parent link="{wrist}"/><child link="tool0"/><origin xyz="0.1 0 0"/></joint></robot>"""


def scene_in(html: str) -> dict:
    """The scene that an answer carries for the frame."""
    found = re.search(r'<script type="application/json" id="scene">(.*?)</script>', html, re.DOTALL)
    return json.loads(found[1])


def placed(scene: dict, name: str) -> np.ndarray:
    """Where a label is, shape (3,) [mm]."""
    frames = np.frombuffer(base64.b64decode(scene["frames"]["bdata"]), "<f4").reshape(-1, scene["moving"], 3, 4)[0]
    _, point, frame = next(label for label in scene["labels"] if label[0] == name)
    place = np.eye(4)[:3] if frame == 0 else frames[frame - 1]
    return place[:, :3] @ point + place[:, 3]


def preview(client: TestClient, machine: str, **fields: str) -> str:
    answer = client.post(f"/m/{machine}/do/preview", data=fields)
    assert answer.status_code == 200
    return answer.text


def test_a_slider_moves_the_arm_and_its_distances_follow(client: TestClient):
    """The upper arm laid down goes into the floor: the answer says so, with the distance below 0."""
    before = preview(client, "ur10_wrist")
    after = preview(client, "ur10_wrist", **{"v.machine.chain.joints[1].home_deg": "10.0"})
    assert placed(scene_in(before), "elbow")[2] > 600.0
    assert placed(scene_in(after), "elbow")[2] < 100.0
    row = r'<tr class="(\w+)"><td class="word">distance from floor \(upper arm\)</td><td>([-\d.]+) mm'
    marks = [re.search(row, html).groups() for html in (before, after)]
    assert marks[0][0] != "hit"
    assert marks[1][0] == "hit"
    assert float(marks[1][1]) < 0.0 < float(marks[0][1])


def test_a_turned_sensor_shows_its_axes_elsewhere(client: TestClient, root: Path):
    """By 90 degrees about z its x axis points where its y axis did."""
    hx.new_case("mine", like="ur10_wrist", folder=root / "mine")
    still = scene_in(preview(client, "+mine"))
    rpy = "machine.chain.sensor.rpy_deg"
    turned = scene_in(preview(client, "+mine", **{f"w.{rpy}": "[0.0, 0.0, 90.0]", f"on.{rpy}": "1"}))
    assert placed(turned, "x sensor") == pytest.approx(placed(still, "y sensor"), abs=0.1)
    assert placed(turned, "z sensor") == pytest.approx(placed(still, "z sensor"), abs=0.1)


def test_an_arm_that_is_not_complete_yet_has_a_picture_and_sliders(client: TestClient, root: Path):
    """The sense of its sensor is not stated, so that it is no case yet; its joints move all the same."""
    (root / "two.urdf").write_text(URDF.format(wrist="wrist"))
    hx.new_arm("two", root / "two.urdf", "tool0", root / "two")
    page = client.get("/m/+two/machine").text
    assert "sense" in page
    assert page.count('data-field="machine.chain.joints[') == 2
    straight = scene_in(page)
    assert placed(straight, "turn") == pytest.approx([300.0, 0.0, 400.0])
    home = "machine.chain.joints[0].home_deg"
    bent = scene_in(preview(client, "+two", **{f"w.{home}": "-90.0", f"on.{home}": "1"}))
    assert placed(bent, "turn") == pytest.approx([0.0, 0.0, 700.0], abs=1e-3)


def test_the_strut_that_is_too_long_at_home_is_marked(client: TestClient, root: Path):
    hx.new_case("mine", like="hexapod", folder=root / "mine")
    text = preview(client, "+mine", **{"v.machine.home.z_mm": "1500.0"})
    assert re.search(r'<tr class="hit"><td class="word">strut length \(strut \d\)', text)


def test_links_of_a_urdf_file_are_offered_those_most_moved_first_and_escaped(client: TestClient, root: Path):
    (root / "two.urdf").write_text(URDF.format(wrist="&lt;script&gt;alert(1)&lt;/script&gt;"))
    page = client.get("/urdf/two.urdf").text
    assert "<script>alert" not in page
    assert re.search(r'<option value="tool0" selected>', page)
    labels = {label[0]: label[1] for label in scene_in(page)["labels"]}
    assert labels["tool0"] == pytest.approx([400.0, 0.0, 400.0])
    assert labels["world"] == [0.0, 0.0, 0.0]
    (root / "bad.urdf").write_text("<robot><link name='a'/><link name='b'/><joint name='j' type='fixed'/></robot>")
    assert "joint j has the parent" in client.get("/urdf/bad.urdf").text
    assert client.get("/urdf/none.urdf").status_code == 404
    assert client.get("/urdf/..%2Fx.urdf").status_code == 404


def test_what_draws_in_3_d_has_an_origin_of_its_own_and_reaches_no_network(client: TestClient):
    answer = client.get("/space")
    policy = answer.headers["content-security-policy"]
    assert "sandbox allow-scripts;" in policy
    assert "default-src 'none'" in policy
    assert "connect-src" not in policy


def test_limits_that_bind_a_plan_light_where_the_proof_says(hexapod_case: hx.Case):
    """The largest share of each limit is that of the proof, and it stands at the instant of the proof."""
    from identification.limits.proof import prove

    motion = in_turn(hexapod_case)
    scene = with_limits(moving_machine(hexapod_case, motion), hexapod_case, motion)
    proof = {str(check.of): check for check in prove(motion, hexapod_case).checks}
    assert set(scene.used.names) == set(proof)
    for name, shares in zip(scene.used.names, scene.used.shares.T, strict=True):
        assert shares.max() == pytest.approx(proof[name].ratio, rel=0.02, abs=0.01)
    k = scene.used.names.index("strut velocity")
    shares = scene.used.shares[:, k]
    near = np.abs(scene.t - proof["strut velocity"].time) < 0.05
    assert shares[near].max() == pytest.approx(shares.max(), rel=0.01)


def test_the_motion_of_a_plan_is_sent_as_a_scene(client: TestClient, root: Path):
    plan = hx.plan(hx.load_case("hexapod"), hx.Manual(SHORT_MOVES))
    plan.save(root / "by-hand")
    scene = client.get("/m/hexapod/motion/by-hand").json()
    assert scene["moving"] == 1
    assert "velocity" in scene["used"]["names"]
    assert client.get("/m/hexapod/motion/another").status_code == 404


@pytest.mark.parametrize("name", ["hexapod", "ur10_wrist", "five_axis_table"])
def test_a_machine_at_home_is_drawn_whole(name: str):
    case = hx.load_case(name)
    scene = standing_machine(case)
    lines = np.vstack([line for part in scene.parts for line in part.placed(scene, 0)])
    assert (lines >= scene.ends[:, 0] - 1e-6).all()
    assert (lines <= scene.ends[:, 1] + 1e-6).all()
    assert np.ptp(scene.ends, axis=1).min() >= 0.49 * np.ptp(scene.ends, axis=1).max()


def test_an_answer_to_a_slider_takes_little(client: TestClient):
    """Less than the 0.2 s of a click, in processor time."""
    preview(client, "ur10_wrist")
    seconds = []
    for angle in range(5):
        begin = time.process_time()
        preview(client, "ur10_wrist", **{"v.machine.chain.joints[1].home_deg": f"{-95 + angle}"})
        seconds.append(time.process_time() - begin)
    assert min(seconds) < 0.2
