"""The map of a machine's reach, and the picture of the case."""

from pathlib import Path

import numpy as np
import pytest

from cases.schema import Case, load_case
from hexcite._new_arm import new_arm
from hexcite.reports.drawing.plots import case_figure
from planner.box.reach import standing_ratios
from tests.driven.arms import ARMS
from tests.hexcite.command_line import call, refused


def test_reach_ends_where_the_struts_do(hexapod_case: Case) -> None:
    """Lifting the level platform straight up stretches all struts alike: their length says where the reach ends."""
    machine, _, limits = hexapod_case.need_machine("test")
    longest = limits.strut_length[1]
    flat = np.linalg.norm((machine.platform.points - machine.base.points)[0, :2])
    height = np.sqrt(longest**2 - flat**2)
    poses = np.tile(machine.home.vector, (2, 1))
    poses[:, 2] = height - 1e-6, height + 1e-6
    below, above = standing_ratios(hexapod_case, poses).max(axis=1)
    assert below < 1.0 < above
    assert above - below < 1e-4


def test_reach_is_as_symmetric_as_the_machine(hexapod_case: Case) -> None:
    """The built-in machine looks the same from three sides and in a mirror."""
    machine, _, _ = hexapod_case.need_machine("test")
    poses = np.tile(machine.home.vector, (3, 1))
    for k, angle in enumerate(np.deg2rad([20.0, 140.0, 260.0])):
        poses[k, :2] += 0.2 * np.array([np.cos(angle), np.sin(angle)])
    assert np.ptp(standing_ratios(hexapod_case, poses).max(axis=1)) < 1e-9
    poses[1, :2] = poses[0, :2] * [-1.0, 1.0]
    assert np.ptp(standing_ratios(hexapod_case, poses[:2]).max(axis=1)) < 1e-9


@pytest.mark.first(1)
@pytest.mark.parametrize("suffix", [".svg", ".png", ".PDF"])
def test_the_picture_is_written(suffix: str, tmp_path: Path) -> None:
    file = tmp_path / f"machine{suffix}"
    assert call("case", "show", "hexapod", "-o", file, "--json").json() == {"ok": True, "figure": str(file)}
    start = {".svg": b"<?xml", ".png": b"\x89PNG", ".PDF": b"%PDF"}[suffix]
    assert file.read_bytes().startswith(start)


def test_what_cannot_be_drawn(tmp_path: Path) -> None:
    assert "machine: is missing" in refused("case", "show", "ft_wrist")
    assert ".svg or .png or .pdf" in refused("case", "show", "hexapod", "-o", tmp_path / "machine.toml")


def test_a_robot_of_a_urdf_alone_is_drawn_with_its_joints_at_0(tmp_path: Path) -> None:
    """Neither home nor limits are stated; an elbow that cannot be at 0 is in the middle of its way."""
    arm = ARMS["franka_like"]
    (tmp_path / "robot.urdf").write_text(arm.urdf())
    file = new_arm("arm", tmp_path / "robot.urdf", "tool0", tmp_path / "arm", "ft")
    call("case", "show", file.parent, "-o", tmp_path / "arm.svg", "--json").json()
    space = case_figure(load_case(str(file))).axes[0]
    assert {text.get_text() for text in space.texts} >= {*arm.names, "sensor", "flange"}
    elbow = np.degrees(np.mean(arm.joints[3].end))
    assert f"joints without a home at 0, joint_4 at {elbow:.3g}" in space.get_title()
    (way,) = [line for line in space.get_lines() if line.get_label() == "joints and sensor"]
    x, y, z = (np.asarray(v) for v in way.get_data_3d())  # type: ignore[attr-defined]
    assert np.hypot(x[4] - x[3], z[4] - z[3]) == pytest.approx(82.5)  # from elbow to forearm
    assert np.allclose(y, 0.0)  # joints at 0 leave it in a plane


def test_a_new_case_is_checked_and_drawn(tmp_path: Path) -> None:
    made = call("case", "new", "mill", "-o", tmp_path / "mill", "--json").json()
    assert made["case"] == str(tmp_path / "mill" / "case.toml")
    assert call("case", "check", tmp_path / "mill", "--json").json()["ok"]
    assert "exists" in refused("case", "new", "mill", "-o", tmp_path / "mill")


def test_joints_and_sensors_are_numbered_to_be_compared_with_the_drawing(hexapod_case: Case) -> None:
    texts = [text.get_text() for text in case_figure(hexapod_case).axes[0].texts]
    assert [texts.count(str(k)) for k in range(1, 7)] == [3] * 6  # base joint, platform joint, sensor


def test_the_drawing_has_radii_heights_and_strut_lengths(hexapod_case: Case) -> None:
    machine, _, _ = hexapod_case.need_machine("test")
    figure = case_figure(hexapod_case)
    _, above, beside = figure.axes
    assert {"base: radius 700", "platform: radius 250"} <= {text.get_text() for text in above.texts}
    assert {"base: z = 0", "platform: z = 900"} <= {text.get_text() for text in beside.texts}
    home = machine.platform.points + machine.home.vector[:3]  # level
    for length in np.linalg.norm(home - machine.base.points, axis=1) * 1e3:
        assert f"{length:.4g}" in figure.get_supxlabel()


def test_joints_that_lie_above_each_other_are_named_together() -> None:
    _, above, _ = case_figure(load_case("ur10_wrist")).axes
    assert any(text.get_text().startswith("base, shoulder") for text in above.texts)
