"""The machine in 3-D: what is drawn stands where the kinematics say, of a hexapod and of chains, moving and posing."""

from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import Browser
from scipy.spatial.transform import Rotation

from cases.schema import load_case
from hexcite.reports.drawing.scene import Part, Scene, moving_machine, posing_machine
from hexcite.reports.drawing.still import machine_figure, machine_picture
from hexcite.reports.page import Head, page, section
from identification.limits.chain import chain_frames
from identification.motion.motion import StandingPoses
from tests.chains import chain_case
from tests.helpers import Harmonic, few
from tests.hexcite.browser import opened


def part(scene: Scene, name: str) -> Part:
    return next(each for each in scene.parts if each.name == name)


def around_home(joints: int, count: int) -> np.ndarray:
    home = chain_case(joints).chain.home
    return home + 0.2 * np.random.default_rng(joints).normal(size=(count, joints))


@pytest.mark.parametrize("joints", few(6, 5, 7))
def test_joints_of_a_chain_are_drawn_where_its_frames_are(joints: int):
    poses = around_home(joints, 4)
    scene = posing_machine(chain_case(joints), poses)
    frames = chain_frames(StandingPoses(poses).at(np.arange(4.0)), chain_case(joints).chain)
    for k in range(4):
        (drawn,) = part(scene, "joints and sensor").placed(scene, k)
        np.testing.assert_allclose(drawn[1:], [1e3 * place[k, :3, 3] for place, _, _ in frames], atol=1e-9)
        assert drawn[0].tolist() == [0.0, 0.0, 0.0]
    np.testing.assert_allclose(scene.path, 1e3 * frames[-1][0][:, :3, 3], atol=1e-9)


def test_all_that_moves_stays_inside_the_picture():
    for scene in (
        posing_machine(chain_case(7), around_home(7, 5)),
        moving_machine(load_case("hexapod"), Harmonic(seed=3, duration=2.0)),
    ):
        points = np.vstack(
            [line for k in (0, len(scene.t) - 1) for each in scene.parts for line in each.placed(scene, k)]
        )
        assert np.all(points >= scene.ends[:, 0] - 1e-6)
        assert np.all(points <= scene.ends[:, 1] + 1e-6)


def test_struts_join_base_and_platform():
    case = load_case("hexapod")
    scene = moving_machine(case, Harmonic(seed=3, duration=2.0))
    base = case.hexapod.base.points * 1e3
    for strut, foot in zip(part(scene, "struts").placed(scene, 40), base, strict=True):
        assert strut[0] == pytest.approx(foot)
    lengths = [np.linalg.norm(strut[1] - strut[0]) for strut in part(scene, "struts").placed(scene, 40)]
    platform = part(scene, "platform").placed(scene, 40)[0]
    assert lengths == pytest.approx(np.linalg.norm(platform[:6] - base, axis=1))


@pytest.mark.first(1)
@pytest.mark.parametrize("joints", few(6, 5))
@pytest.mark.repeats
def test_a_chain_moves_on_its_page(browser: Browser, joints: int, tmp_path: Path):
    """The page turns the parts with its own code: they stand where this module places them."""
    scene = posing_machine(chain_case(joints), around_home(joints, 6))
    file = tmp_path / "chain.html"
    file.write_text(page("chain", Head("Fine.", True, "arm"), "", (), (), section("machine", scene)), encoding="utf-8")
    name, scrub = "joints and sensor", "document.getElementById('scrub')"
    with opened(browser, file, 400) as tab:
        tab.page.evaluate(f"(() => {{ {scrub}.value = 4; {scrub}.dispatchEvent(new Event('input')); }})()")
        tab.page.wait_for_timeout(300)
        drawn = tab.page.evaluate(
            "name => (({x, y, z}) => [x, y, z])(document.getElementById('machine').data.find(d => d.name === name))",
            name,
        )
        (expected,) = part(scene, name).placed(scene, 4)
        np.testing.assert_allclose(np.array(drawn, dtype=float).T[:-1], expected, atol=1e-2)
        assert "pose 5 of 6" in tab.page.locator("#instant").inner_text()
        assert tab.errors == []


@pytest.mark.slow
def test_printed_poses_are_numbered():
    text = machine_picture(posing_machine(chain_case(6), around_home(6, 12)))
    assert "pose 1" in text
    assert "pose 12" in text


def test_poses_are_shown_with_their_orientations_as_in_figure_4():
    """Three unit vectors of a length at every pose, from its origin, turned as the platform is; none along a motion."""
    case = load_case("hexapod")
    poses = case.machine.home.vector + np.array([[0.1, 0.0, 0.0, 0.2, -0.1, 0.3], [-0.1, 0.05, 0.02, 0.0, 0.3, 0.0]])
    scene = posing_machine(case, poses)
    triads = [part for part in scene.parts if "at the poses" in part.name]
    assert [part.name[0] for part in triads] == ["x", "y", "z"]
    for number, pose in enumerate(poses):
        turn = Rotation.from_euler("xyz", pose[3:]).as_matrix()
        for k, part in enumerate(triads):
            line, frames = part.lines[number]
            assert set(frames) == {0}  # in {B}, where it stays
            assert line[0] == pytest.approx(1e3 * pose[:3])
            assert (line[1] - line[0]) / np.linalg.norm(line[1] - line[0]) == pytest.approx(turn[:, k])
    moving = moving_machine(case, Harmonic(seed=3, duration=2.0))
    assert not [part for part in moving.parts if "at the poses" in part.name]


def test_the_legend_of_a_picture_of_poses_is_not_cut():
    case = load_case("hexapod")
    figure = machine_figure(posing_machine(case, np.tile(case.need_motion("poses")[0], (6, 1))))
    figure.canvas.draw()
    (legend,) = figure.legends
    assert len(legend.get_texts()) == 7
    assert legend.get_window_extent().x1 <= figure.bbox.x1  # type: ignore[no-untyped-call]
