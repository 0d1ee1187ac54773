"""JSON and scripts of joint trajectories hold the message of the YAML, and a script moves nothing from elsewhere."""

import contextlib
import io
import json
import re
from functools import cache
from typing import Any

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from cases.base.errors import CaseError, Code, HexciteError, ProgramError
from cases.controller import Ros2
from cases.schema import Case
from postprocessors.program import Program, dialect, leaving_out
from postprocessors.writing import proven_program
from tests.driven.fake_ros import Ros
from tests.helpers import examples, one_line
from tests.postprocessors.joint_walks import ROBOT, walk

LANGUAGE = dialect("ros2")
HOME = ROBOT.need_motion("a test")[0]
NAMES = ROBOT.chain.names


def with_settings(**keys: Any) -> Case:
    controller = ROBOT.controller.model_copy(update={"ros2": Ros2(**keys)})
    return ROBOT.model_copy(update={"controller": controller})


def written(suffix: str, case: Case = ROBOT) -> Program:
    return proven_program(walk(ROBOT), case, LANGUAGE, f"walk{suffix}", ("a walk",))


@cache
def form(suffix: str) -> Program:
    return written(suffix)


def ran(script: Program, ros: Ros, *arguments: str) -> str:
    """What the script prints, and why it ends, on a robot."""
    said = io.StringIO()
    with ros.installed(), pytest.MonkeyPatch.context() as patch, contextlib.redirect_stdout(said):
        patch.setattr("sys.argv", ["walk.py", *arguments])
        patch.setattr("time.sleep", lambda seconds: None)
        try:
            exec(compile(script.content, "walk.py", "exec"), {"__name__": "__main__"})
        except SystemExit as end:
            said.write(str(end.code))
    return said.getvalue()


@pytest.mark.parametrize("suffix", [".json", ".py"])
def test_each_form_reads_back_as_the_same_motion(suffix: str) -> None:
    program = form(suffix)
    again = LANGUAGE.read(program.content, str(program.path), ROBOT)
    for one, other in zip(again.stretches, form(".yaml").reading.stretches, strict=True):
        assert type(one) is type(other)
        if hasattr(one, "points"):
            t = np.linspace(0.0, one.points.duration, 50)
            np.testing.assert_array_equal(one.points.at(t).coordinates, other.points.at(t).coordinates)
    assert program.proof.verdict == form(".yaml").proof.verdict


@pytest.mark.parametrize("line", [1, 2])
def test_a_script_cannot_state_an_encoding_in_which_comments_are_statements(line: int) -> None:
    lines = form(".py").content.decode().split("\n")
    lines[line:line] = ["# coding: raw_unicode_escape", "# \\u000amoved = True #"]
    attack = "\n".join(lines).encode()
    if line == 1:
        with pytest.raises(ProgramError, match=r"changed") as caught:
            LANGUAGE.read(attack, "walk.py", ROBOT)
        assert (caught.value.code, caught.value.line) == (Code.CHANGED, 2)
    else:
        LANGUAGE.read(attack, "walk.py", ROBOT)
        namespace = {"__name__": "read"}
        with Ros(NAMES, HOME).installed():
            exec(compile(attack, "walk.py", "exec"), namespace)
        assert "moved" not in namespace


def test_what_a_plan_leaves_out_is_not_lost_in_json() -> None:
    """JSON has no comments: such a file could never be proven again."""
    case = ROBOT.model_copy(update={"controller": ROBOT.controller.model_copy(update={"ros2": Ros2()})})
    with pytest.raises(ProgramError, match="jerk") as caught:
        proven_program(walk(case), case, LANGUAGE, "walk.json", ("a walk", *leaving_out(("jerk",))))
    assert caught.value.code == Code.NOT_SUPPORTED
    assert "walk.yaml" in str(caught.value)
    proven_program(walk(case), case, LANGUAGE, "walk.yaml", ("a walk", *leaving_out(("jerk",))))


def test_json_is_the_message_and_nothing_else() -> None:
    assert json.loads(form(".json").content) == yaml.safe_load(form(".yaml").content)


def test_the_script_sends_the_trajectory_from_where_it_begins() -> None:
    ros = Ros(NAMES, HOME + np.radians(0.05))
    assert ran(form(".py"), ros).endswith("done\n0")
    assert ros.server == "/joint_trajectory_controller/follow_joint_trajectory"
    sent, message = ros.trajectory, yaml.safe_load(form(".yaml").content)
    assert sent["joint_names"] == message["joint_names"]
    for ours, theirs in zip(sent["points"], message["points"], strict=True):
        assert ours["positions"] == theirs["positions"]
        assert ours["accelerations"] == theirs["accelerations"]
        assert ours["time_from_start"].items() >= theirs["time_from_start"].items()


@pytest.mark.parametrize(
    ("ros", "words"),
    [
        (
            Ros(NAMES, HOME + np.radians([0, 0, 0.2, 0, 0, 0])),
            rf"{NAMES[2]} stands at .* deg, the trajectory begins at",
        ),
        (Ros(NAMES, HOME + np.array([np.nan, 0, 0, 0, 0, 0])), rf"{NAMES[0]} stands at nan"),
        (Ros(NAMES, HOME, speed=1e-3), "still moving"),
    ],
    ids=["elsewhere", "unknown", "moving"],
)
def test_from_elsewhere_nothing_moves(ros: Ros, words: str) -> None:
    assert re.search(words, said := ran(form(".py"), ros))
    assert "othing was sent" in said
    assert not ros.goals


def test_a_joint_that_is_not_heard_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = iter(range(10**6))
    monkeypatch.setattr("time.monotonic", lambda: next(clock))
    ros = Ros(NAMES[:-1], HOME[:-1])
    assert re.search(rf"no position of {NAMES[-1]} .*nothing was sent", ran(form(".py"), ros))
    assert not ros.goals


def test_check_alone_sends_nothing() -> None:
    ros = Ros(NAMES, HOME)
    assert "stands where the trajectory begins" in ran(form(".py"), ros, "--check")
    assert not ros.goals


def test_a_failure_of_the_controller_ends_the_script_with_its_words() -> None:
    assert "error -4: off its path" in ran(form(".py"), Ros(NAMES, HOME, code=-4))


def test_settings_of_the_controller_are_in_the_goal_and_in_the_remarks() -> None:
    case = with_settings(
        controller="arm_controller", path_tolerance_deg=2.0, goal_tolerance_deg=0.5, goal_time_s=1.5,
        controller_keeps=("velocity",),
    )  # fmt: skip
    program = written(".py", case)
    remarks = " ".join(program.proof.remarks)
    for words in ("more than 2 deg off its path", "more than 0.5 deg off its goal", "1.5 s late", "enforces velocity"):
        assert words in remarks
    ran(program, ros := Ros(NAMES, HOME))
    (goal,) = ros.goals
    assert ros.server == "/arm_controller/follow_joint_trajectory"
    assert [t.position for t in goal.path_tolerance] == pytest.approx([np.radians(2.0)] * 6)
    assert [t.name for t in goal.goal_tolerance] == list(NAMES)
    assert (goal.goal_time_tolerance.sec, goal.goal_time_tolerance.nanosec) == (1, 500_000_000)


# Shares of the way in the time 1, as the controller joins two points at rest: by degree five, three and one.
WAYS = {
    ("position", "velocity", "acceleration"): np.polynomial.Polynomial([0, 0, 0, 10, -15, 6]),
    ("position", "velocity"): np.polynomial.Polynomial([0, 0, 3, -2]),
    ("position",): np.polynomial.Polynomial([0, 1]),
}
STEPS = ("speeds step", "accelerations step", "")  # what steps at its ends: the first derivative that is not 0 there


@pytest.mark.parametrize("interfaces", WAYS)
def test_the_way_to_the_first_point_is_the_one_that_the_controller_makes(interfaces: tuple[str, ...]) -> None:
    """From as far off as it says some derivative reaches a tenth of its limit, and none more."""
    case = with_settings(state_interfaces=interfaces)
    (remark,) = (words for words in written(".yaml", case).proof.remarks if "it is taken there in 3 s" in words)
    way = np.radians(float(re.search(r"further than (\S+) deg", remark)[1]))
    assert "further" in remark
    share, t = WAYS[interfaces], np.linspace(0.0, 1.0, 4001)
    box, used = case.limits.motion, []
    for order, limits in enumerate((box.rate, box.acceleration, box.jerk), 1):
        used.append(np.abs(share.deriv(order)(t)).max() * way / 3.0**order / (0.1 * limits.min()))
        if abs(share.deriv(order)(0.0)) > 0.0:
            break  # what follows is without bound
    assert max(used[: len(interfaces)]) == pytest.approx(1.0, rel=0.01)
    assert STEPS[len(interfaces) - 1] in remark


@pytest.mark.repeats
def test_what_the_controller_does_by_its_own_settings_is_said() -> None:
    ways = {
        "a control loop follows": {"command_interfaces": ("velocity",)},
        "from its last command": {"interpolate_from_desired_state": True},
        "slower than planned": {"speed_scaling": True},
        "off its path, at once": {"path_tolerance_deg": 2.0},
        "off its path, slowing down": {"path_tolerance_deg": 2.0, "decelerate_on_cancel": True},
    }
    blind = {"path_tolerance_deg": 2.0, "decelerate_on_cancel": True, "state_interfaces": ("position",)}
    assert "off its path, at once" in " ".join(written(".yaml", with_settings(**blind)).proof.remarks)
    plain = " ".join(written(".yaml", with_settings()).proof.remarks)
    for words, keys in ways.items():
        assert words in " ".join(written(".yaml", with_settings(**keys)).proof.remarks)
        assert words not in plain


def test_a_controller_that_steps_from_point_to_point_gets_no_program() -> None:
    with pytest.raises(CaseError, match=r"controller\.ros2\.interpolation.*splines") as caught:
        written(".yaml", with_settings(interpolation="none"))
    one_line(caught.value)


def test_a_script_that_was_changed_is_refused_in_its_line() -> None:
    lines = form(".py").content.splitlines()
    (k,) = [k for k, line in enumerate(lines) if line.startswith(b"WITHIN")]
    lines[k] = b"WITHIN = [1.0] * 6"
    with pytest.raises(ProgramError, match="was changed") as caught:
        LANGUAGE.read(b"\n".join(lines) + b"\n", "walk.py", ROBOT)
    assert caught.value.line == k + 1
    one_line(caught.value)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        (b'"sec": 3', b'"sec": 3.5', "whole numbers"),
        (b'"sec": 3', b'"sec": -3', "whole numbers"),
        (b'"positions"', b'"position"', "positions"),
        (b'"points"', b'"headers": {}, "points"', "alone"),
        (b'"joint_names": [', b'"joint_names": ["other", ', "joint_names"),
        (b'"velocities": [0.0', b'"velocities": [NaN, 0.0', "not a number"),
        (b'"velocities": [', b'"velocities": [], "velocities": [', "twice"),
        (b'"velocities": [0', b'"velocities": [1', "rest"),
        (b"]}", b"]", "not JSON"),
    ],
)
def test_json_that_is_not_such_a_message_is_refused(old: bytes, new: bytes, words: str) -> None:
    assert old in form(".json").content
    with pytest.raises(ProgramError, match=words) as caught:
        LANGUAGE.read(form(".json").content.replace(old, new, 1), "walk.json", ROBOT)
    assert one_line(caught.value).startswith("walk.json, line ")


@settings(max_examples=examples(20))
@given(st.sampled_from([".json", ".py"]), st.floats(0.0, 1.0), st.integers(0, 30), st.text(max_size=20))
def test_damage_is_refused_in_one_line_or_judged(suffix: str, place: float, length: int, put: str) -> None:
    program = form(suffix)
    content, at = program.content, int(place * len(program.content))
    damaged = content[:at] + put.encode("utf-8", "replace") + content[at + length :]
    try:
        reading = LANGUAGE.read(damaged, str(program.path), ROBOT)
    except HexciteError as error:
        one_line(error)
    else:
        assert reading.stretches
