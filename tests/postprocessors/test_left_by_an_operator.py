"""What an operator may have left, and where LinuxCNC stops: what is proven is what it executes."""

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cases.base.errors import ProgramError
from cases.schema import Case
from hexcite._run import carried_out
from postprocessors.dialects.linuxcnc.promises import linuxcnc_guarantees
from postprocessors.dialects.linuxcnc.write import write_linuxcnc
from postprocessors.program import read_program
from postprocessors.proof.proof import prove_program
from tests.helpers import seeds
from tests.postprocessors.edited import moves as written_moves
from tests.postprocessors.edited import proof
from tests.postprocessors.programs import HEAD, linuxcnc_text, read_linuxcnc, typed
from tests.postprocessors.test_golden import PROGRAMS

LEFT = ["G20", "G90.1", "G91", "G93", "G7", "G18", "G64 P5", "G92 X50 Y20", "G55", "G43.1 Z30"]
SETTINGS = ("G21", "G90", "G94", "G40", "G49", "G54", "G92.1")


def moves(commands: Any) -> list:
    """Moves of a program as the interpreter sends them, each with the feed and the plane that are in force."""
    found, state = [], {}
    assert not isinstance(commands, str), commands
    for name, numbers in commands:
        if name.startswith(("STRAIGHT", "ARC", "DWELL")):
            found.append((name, numbers, dict(state)))
        elif name.startswith(("SET_FEED", "SELECT_PLANE", "SET_MOTION_CONTROL")):
            state[name.split("_XY")[0].split("_YZ")[0].split("_XZ")[0]] = (name, numbers)
    return found


@pytest.mark.linuxcnc
@pytest.mark.parametrize("left", LEFT)
@pytest.mark.parametrize("name", PROGRAMS)
def test_nothing_that_an_operator_left_changes_what_our_programs_do(name: str, left: str, rs274: Callable):
    text = linuxcnc_text(PROGRAMS[name]())
    assert len(moves(rs274(text))) > 3
    assert moves(rs274(f"{left}\n{text}")) == moves(rs274(text))


@pytest.mark.parametrize("word", SETTINGS)
def test_a_program_that_does_not_say_what_it_relies_on_is_refused(word: str):
    head = re.sub(rf"{re.escape(word)}(?![\d.]) ?", "", HEAD, count=1)
    assert head != HEAD
    with pytest.raises(ProgramError, match=rf"a move before a block with {re.escape(word)};") as caught:
        read_linuxcnc(typed("G1 X1 F600", head=head), "p.ngc")
    assert caught.value.line == 3


def test_what_it_relies_on_stands_in_a_block_before_its_first_move():
    """In one block LinuxCNC takes F before the unit."""
    with pytest.raises(ProgramError, match="a move before a block with G21 G90 G94"):
        read_linuxcnc("G21 G90 G94 G61.1 G40 G49 G54 G92.1 G1 X0 Y0 Z900 A0 B0 C0 F3000\nG1 X10 F3000\nM2\n", "p.ngc")


@pytest.mark.parametrize(
    ("words", "off"),
    [("", False), ("M50 P0", True), ("M49", True), ("M50", False), ("M50 P1", False), ("M50 P0\nM48", False)],
)
def test_a_feed_override_that_a_program_leaves_on_is_told(words: str, off: bool, hexapod_case: Case):
    """Before its first move, for all of them; where the knob ends at 100 % there is nothing to tell."""
    text = typed("G1 X1 F600", head=HEAD.replace("G61.1\n", f"G61.1\n{words}\n"))
    reading = read_linuxcnc(text, "p.ngc")
    assert reading.override_off is off
    told = [
        f"{case.need_controller('a test').most_override_percent}"
        for case in (hexapod_case, with_override(hexapod_case, 120.0), with_override(hexapod_case, 100.0))
        if any(
            "feed override above 100 %" in r for r in prove_program(reading, linuxcnc_guarantees(reading, case)).remarks
        )
    ]
    assert told == ([] if off else ["None", "120.0"])
    late = typed("M49\nG1 X1 F600")
    assert not read_linuxcnc(late, "p.ngc").override_off
    with pytest.raises(ProgramError, match="M52"):
        read_linuxcnc(typed("M52 P1\nG1 X1 F600"), "p.ngc")


@pytest.mark.parametrize(("most", "written"), [(None, True), (120.0, True), (100.0, False)])
def test_programs_switch_the_override_off_where_the_knob_goes_beyond_100_percent(
    most: float | None, written: bool, hexapod_case: Case
):
    text = write_linuxcnc(PROGRAMS["one_of_each.ngc"](), with_override(hexapod_case, most)).decode("ascii")
    assert ("\nM50 P0\n" in text) is written
    assert not written or text.index("(abort,Not at home: C") < text.index("M50 P0") < text.index("\nG1 ")


@pytest.mark.parametrize("name", ["sinumerik", "twincat"])
def test_controls_whose_programs_cannot_switch_an_override_off_come_with_a_remark(name: str):
    assert [r for r in proof(name, written_moves(name)).remarks if "feed override above 100 %" in r]


def with_override(case: Case, most: float | None) -> Case:
    data = case.model_dump(exclude_none=True)
    data["controller"] |= {} if most is None else {"most_override_percent": most}
    return Case.model_validate(data)


def test_an_arc_needs_relative_centres_to_be_said():
    arc = "G17 G3 X0 Y0 I20 J0 F600"
    read_linuxcnc(typed(arc), "p.ngc")
    with pytest.raises(ProgramError, match=r"an arc before a block with G91\.1"):
        read_linuxcnc(typed(arc, head=HEAD.replace(" G91.1", "")), "p.ngc")


@pytest.mark.parametrize("turn", [0.0, 10.0, 40.0, 90.0, 180.0])
@pytest.mark.parametrize("between", ["", "G4 P0.1\n", "M0\n"])
def test_under_g61_moves_are_read_where_they_turn_or_wait(turn: float, between: str):
    x, y = 20 * np.cos(np.radians(turn)), 20 * np.sin(np.radians(turn))
    text = typed(f"G61\nG1 X20 F600\n{between}G1 X{20 + x:.4f} Y{y:.4f} F600")
    if between or turn > 30.0:
        assert len(read_linuxcnc(text, "p.ngc").stretches) == 3 + bool(between)
    else:
        with pytest.raises(ProgramError, match=r"write G61\.1, or G4 P0\.1"):
            read_linuxcnc(text, "p.ngc")


@pytest.mark.linuxcnc
@seeds(3)
def test_linuxcnc_takes_as_long_as_is_proven_also_where_moves_are_in_one_direction(
    seed: int, hexapod_case: Case, tmp_path: Path
):
    """Steps of some millimetres in random directions, many of them on from the one before: it stops after each."""
    draw = np.random.default_rng(seed)
    place, way, lines = np.zeros(6), np.zeros(6), []
    for _ in range(25):
        if draw.random() < 0.4 or not way.any():
            way = draw.choice([-1.0, 0.0, 1.0], 6) * [5.0, 5.0, 3.0, 0.5, 0.5, 0.5] * (draw.random(6) < 0.5)
        if np.any(np.abs(place + way) > [60, 60, 20, 8, 8, 8]) or not way.any():
            way = -way
            continue
        place = place + way
        words = " ".join(
            f"{letter}{v + (900 if letter == 'Z' else 0):.3f}" for letter, v in zip("XYZABC", place, strict=True)
        )
        lines.append(f"G1 {words} F{draw.uniform(300, 3000):.1f}")
    file = tmp_path / "p.ngc"
    file.write_text(typed("\n".join(["G4 P0.3", "M64 P0", *lines, "M65 P0", "G4 P0.3"])))
    program = read_program(file, hexapod_case)
    run = carried_out(program, hexapod_case, "linuxcnc")
    assert run.excitation == pytest.approx(program.proof.excitation, rel=0.02, abs=0.005 * len(lines))
