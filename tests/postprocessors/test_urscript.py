"""URScript programs: the law of `movej` recomputed from the text, and every edit that would break the proof."""

import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cases.base.errors import CaseError, HexciteError, ProgramError
from cases.schema import load_case
from identification.limits.chain import chain_frames, sensor_motion
from identification.limits.limit import LimitKind, OwnMove, Status
from identification.limits.sensor_loads import Loads
from identification.motion.motion import Motion
from postprocessors.excitation import excitation_program
from postprocessors.program import Program, dialect
from postprocessors.proof.homing import predicted
from postprocessors.proof.proof import prove_program
from postprocessors.reading import Untimed
from postprocessors.writing import proven_program
from tests.helpers import examples, one_line
from tests.postprocessors.joint_walks import robot, walk

CASE = robot()
URSCRIPT = dialect("urscript")
LANGUAGE = URSCRIPT


def written(jerk: bool = False, speed: float = 1.0) -> Program:
    return proven_program(walk(CASE, jerk=jerk), CASE, URSCRIPT, "walk.script", ("a walk",), speed, ("jerk",))


TEXT = written().content.decode()
MOVEJ = re.compile(r"movej\(\[(.*)\], a=(.*), v=(.*), r=0\)")


def judged(text: str, case=CASE):
    reading = LANGUAGE.read(text.encode(), "walk.script", case)
    return prove_program(reading, LANGUAGE.guarantees(reading, case))


@pytest.mark.parametrize("jerk", [False, True])
@pytest.mark.parametrize("speed", [1.0, 0.1])
def test_moves_last_as_long_as_planned_by_the_trapezoid_of_the_text(jerk: bool, speed: float) -> None:
    """D / v + v / a for the joint that moves most, 2 sqrt(D / a) where v is not reached."""
    program = written(jerk, speed)
    before, _, text = program.content.decode().partition("digital_out(3, True)")
    text = text.partition("set_standard")[0]
    at = np.array([float(v) for v in MOVEJ.findall(before)[-1][0].split(",")])
    total = 0.0
    for q, a, v in MOVEJ.findall(text):
        end = np.array([float(word) for word in q.split(",")])
        way, a, v = np.abs(end - at).max(), float(a), float(v)
        total += way / v + v / a if way >= v**2 / a else 2.0 * np.sqrt(way / a)
        at = end
    assert total == pytest.approx(walk(CASE, jerk=jerk).duration / speed, rel=1e-6)
    assert program.proof.excitation == pytest.approx(total, rel=1e-9)


def test_a_planned_trapezoid_is_executed_as_it_is() -> None:
    planned = walk(CASE, jerk=False)
    moves = [part for part in written().reading.stretches if isinstance(part, Untimed) and part.trigger]
    for part, plan in zip(moves, planned.parts, strict=True):
        t = np.linspace(0.0, plan.duration, 200)
        made = predicted(part, LANGUAGE.guarantees(written().reading, CASE))
        np.testing.assert_allclose(made.at(t).coordinates, plan.at(t).coordinates, atol=1e-7)
        np.testing.assert_allclose(made.at(t[1:-1]).rates, plan.at(t[1:-1]).rates, atol=1e-6)


def test_only_the_jerk_of_the_ramps_is_nobodys() -> None:
    proof = written().proof
    assert proof.relies_on == ("jerk",)
    names = {str(c.of): str(c.status) for c in proof.limits.checks if c.binding}
    for name in ("angle", "joint angle", "angular velocity", "angular acceleration", "sensor force", "sensor moment"):
        assert names[name] == "proven"
    with pytest.raises(ProgramError, match="does not enforce jerk") as caught:
        proven_program(walk(CASE), CASE, URSCRIPT, "walk.script", ())
    one_line(caught.value)


def test_home_is_checked_first_and_what_is_left_taken_out_at_a_crawl() -> None:
    _, a, v = MOVEJ.findall(TEXT)[0]
    home, limits = CASE.need_motion("a test")
    assert float(v) == pytest.approx(np.radians(0.1))
    assert float(a) == pytest.approx((limits.jerk * CASE.controller.cycle / 2).min())
    place, within = written().reading.checked
    np.testing.assert_allclose(place, home, atol=1e-9)
    assert within == pytest.approx(np.full(6, np.radians(0.1)), rel=1e-6)
    assert TEXT.index("get_actual_joint_positions") < TEXT.index("movej")


FIRST, SECOND = (m.group() for m in list(MOVEJ.finditer(TEXT))[2:4])
MOVE = r"'movej\(.* is not read here; remove or replace it: .*movej\(\[q1, .., q6\], a=.., v=.., r=0\) with plain"
REFUSED = {
    "a time": (FIRST, FIRST.replace("r=0", "t=2.0, r=0"), MOVE),
    "a blend": (FIRST, FIRST.replace("r=0", "r=0.05"), MOVE),
    "no acceleration": (FIRST, re.sub(r" a=[^,]*,", "", FIRST), MOVE),
    "no speed": (FIRST, re.sub(r" v=[^,]*,", "", FIRST), MOVE),
    "negative speed": (FIRST, FIRST.replace("v=", "v=-"), MOVE),
    "five joints": (FIRST, re.sub(r"\[[^,]*, ", "[", FIRST), MOVE),
    "a pose": (FIRST, FIRST.replace("movej([", "movej(p["), MOVE),
    "an expression": (FIRST, FIRST.replace("[", "[1+"), MOVE),
    "twice a": (FIRST, FIRST.replace("v=", "a="), MOVE),
    "servoj": (FIRST, FIRST.replace("movej", "servoj"), "'servoj.* is not read here"),
    "movel": (FIRST, FIRST.replace("movej", "movel"), "'movel.* is not read here"),
    "something else": (FIRST, "textmsg(1)", r"'textmsg\(1\)' is not read here"),
    "an assignment": (FIRST, "x = 1", "'x = 1' is not read here"),
    "another output": ("digital_out(3, True)", "digital_out(4, True)", r"out\(4, True\)' is not read here"),
    "half on": ("digital_out(3, True)", "digital_out(3, 0.5)", r"out\(3, 0.5\)' is not read here"),
    "asleep backwards": ("sleep(0.3)", "sleep(-0.3)", r"'sleep\(-0.3\)' is not read here"),
    "no end": ("\nend\n", "\n", "truncated, or not begun and ended"),
    "no beginning": ("def walk():\n", "", "truncated, or not begun and ended"),
    "not indented": (f"  {SECOND}", SECOND, "indented movej"),
    "after the end": ("\nend\n", "\nend\nmovej([0])\n", "truncated, or not begun and ended"),
    "an end in the middle": (FIRST, f"{FIRST}\nend", "'end' is not read here"),
    "not ASCII": (FIRST, FIRST.replace("0", "\N{DEGREE SIGN}", 1), "not plain ASCII"),
    "too large": (FIRST, re.sub(r"a=[\d.]+", "a=1e9", FIRST), MOVE),
}


@pytest.mark.parametrize("what", REFUSED)
def test_what_is_not_understood_is_refused_with_its_line(what: str) -> None:
    old, new, words = REFUSED[what]
    assert old in TEXT
    with pytest.raises(ProgramError, match=words) as caught:
        judged(TEXT.replace(old, new, 1))
    one_line(caught.value)


PASSED = {
    "too fast": (r" v=[\d.]+", " v=9.0", "velocity"),
    "too hard": (r" a=[\d.]+", " a=9.0", "acceleration"),
    "out of the box": (r"\[[-\d.]+,", "[2.5,", "angle"),
    "beyond the joint's end": (r"(\[[^,]*,[^,]*), [-\d.]+,", r"\1, -3.2,", "angle"),
}


@pytest.mark.parametrize("what", PASSED)
def test_an_edit_beyond_a_limit_is_a_violation_in_its_line(what: str) -> None:
    pattern, new, limit = PASSED[what]
    text = TEXT.replace(FIRST, re.sub(pattern, new, FIRST))
    line = 1 + text[: text.index(re.sub(pattern, new, FIRST))].count("\n")
    proof = judged(text)
    assert not proof.ok
    assert any(v.line in (line, line + 1) and limit in v.name for v in proof.violations)


CHECKED = {
    "another place": (r"standing\[1\][+-][\d.]+", "standing[1]-3.1", "does not go to the checked place"),
    "a loose check": (r"> 0\.0017\d+:", "> 0.5:", "a check within 0.5 rad is none"),
    "a joint twice": (r"standing\[2\]", "standing[1]", "no check of joint 2"),
    "the other way round": (r"\) > ", ") < ", "no check of joint 0"),
    "no stop": (r" +halt\n", "", "no check of joint 0"),
    "a target in place of the angle": ("get_actual_joint", "get_target_joint", "is not read here"),
    "a check that is not asked for": (r" +standing = .*\n", "", "is not read here"),
}


@pytest.mark.parametrize("what", CHECKED)
def test_a_check_of_home_in_another_form_is_refused(what: str) -> None:
    pattern, new, words = CHECKED[what]
    text = re.sub(pattern, new, TEXT, count=1)
    assert text != TEXT
    with pytest.raises(ProgramError, match=words) as caught:
        judged(text)
    one_line(caught.value)


def without_check(text: str) -> str:
    """The same program, to home from wherever the robot stands."""
    return re.sub(r"(?s)  standing = .*\n  end\n", "", text)


def test_from_anywhere_a_fast_first_move_is_a_violation() -> None:
    text = without_check(TEXT)
    share, (_, limits) = CASE.controller.safe_share, CASE.need_motion("a test")
    assert not any("feed to home" in v.name for v in judged(text).violations)
    fast = text.replace("v=0.001745329252", f"v={1.1 * share * limits.rate.min()}")
    assert any("feed to home" in v.name for v in judged(fast).violations)


def test_blanks_and_the_blend_of_none_may_be_left_out() -> None:
    q, a, v = MOVEJ.match(FIRST).groups()
    for form in (f"movej( [{q}],a = {a} , v={v})", f"movej([{q.replace(' ', '')}],a={a},v={v},r=0)"):
        assert judged(TEXT.replace(FIRST, form)).duration == pytest.approx(judged(TEXT).duration)


def test_arguments_without_names_or_in_another_order_are_refused() -> None:
    q, a, v = MOVEJ.match(FIRST).groups()
    for form in (
        f"movej([{q}], {a}, {v})",
        f"movej([{q}], v={v}, a={a}, r=0)",
        f"movej([{q.replace('.', '. ', 1)}], a={a}, v={v})",
    ):
        with pytest.raises(ProgramError, match=r"movej.* is not read here"):
            judged(TEXT.replace(FIRST, form))


def test_a_case_of_another_machine_is_refused() -> None:
    with pytest.raises(CaseError, match=r"controller\.urscript: is missing"):
        LANGUAGE.read(TEXT.encode(), "walk.script", load_case("hexapod"))


@pytest.mark.slow
@settings(max_examples=examples(40), deadline=None, derandomize=True)
@given(
    st.integers(0, len(TEXT) - 1), st.integers(1, 12), st.sampled_from(["", "0", ",", "(", "]", "\n", "#", "e", "."])
)
def test_a_damaged_program_is_refused_in_one_line_or_judged(start: int, length: int, put: str) -> None:
    try:
        judged(TEXT[:start] + put + TEXT[start + length :])
    except ProgramError as error:
        one_line(error)


def test_a_joint_that_turns_without_end_is_refused() -> None:
    """Which of its turns the robot stands on is not known, and `movej` would wind all of them up."""
    chain = CASE.machine.chain
    last = chain.joints[-1].model_copy(update={"kind": "continuous", "position_deg": None})
    machine = CASE.machine.model_copy(update={"chain": chain.model_copy(update={"joints": (*chain.joints[:-1], last)})})
    with pytest.raises(HexciteError, match=f"joint {last.name} .*without end.*position_deg") as caught:
        LANGUAGE.write(excitation_program(walk(CASE), CASE), CASE.model_copy(update={"machine": machine}))
    one_line(caught.value)


@pytest.mark.parametrize("share", [0.02, 0.5, 0.999])
def test_from_anywhere_sensors_are_judged_at_the_acceleration_that_the_text_states(share: float) -> None:
    """No pose at the stated speed and acceleration of all joints loads the sensors more than the bound says."""
    home, box = CASE.need_motion("a test")
    speed, acceleration = 0.05 * float(box.rate.min()), share * float(box.acceleration.min())
    to_home = f"  movej([{', '.join(f'{q:.9f}' for q in home)}], a={acceleration:.6f}, v={speed:.6f}, r=0)"
    proof = judged(f"def p():\n{to_home}\nend\n")
    bounds = {c.kind: c for c in proof.limits.checks if c.of.move is OwnMove.WAY_HOME}
    assert LimitKind.SENSOR_FORCE in bounds
    rng = np.random.default_rng(0)
    poses = home + rng.uniform(-np.pi, np.pi, (4000, len(home)))
    rates, accelerations = (rng.choice([-1.0, 1.0], poses.shape) * most for most in (speed, acceleration))
    motion = Motion(np.zeros(len(poses)), poses, rates, accelerations, np.zeros_like(poses))
    loads = Loads.of(CASE)
    forces = np.abs(loads.forces(motion, *sensor_motion(chain_frames(motion, CASE.chain))))
    for kind, channels in ((LimitKind.SENSOR_FORCE, ~loads.moments), (LimitKind.SENSOR_MOMENT, loads.moments)):
        used = float((forces / loads.limit)[..., channels].max())
        assert used <= bounds[kind].ratio
        assert used <= 1.0 or bounds[kind].status is not Status.PROVEN
