"""LinuxCNC's own interpreter as the judge: it accepts what is written here, and understands it as the reader does."""

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from cases.base.errors import ProgramError
from cases.base.units import DEG, MINUTE, MM
from cases.schema import Case
from postprocessors.blocks import Blocks, ToHome
from tests.helpers import examples
from tests.postprocessors.programs import HEAD, HOME, linuxcnc_text, programs, read_linuxcnc, small_excitation, typed
from tests.postprocessors.reported import Move, Pause, Switch, reports

pytestmark = pytest.mark.linuxcnc
SAME_FOLDER = settings(max_examples=examples(25), suppress_health_check=[HealthCheck.function_scoped_fixture])

LINES = ["G0 X1", "G1 X5 A2 F100", "A7 F60", "X0 Y0 Z900", "G61.1", "G64", "G64 P1 Q0", "G93", "G94 F50", "G4 P0.25"]
LINES += ["M64 P0", "M65 P0", "M62 P0", "M63 P0", "G93 G1 B1 F30", "F10", "(c) Y3 (d) F.5 ; e", "g1x+2.f20."]


def meaning(text: str) -> list[tuple]:
    """What the reader understands, in the controller's words: target in mm and degrees, mode, feed per minute."""
    said: list[tuple] = []
    pose = np.full(6, np.nan)
    for event in reports(read_linuxcnc, text, "p.ngc"):
        if isinstance(event, Pause):
            said.append(("DWELL", event.duration))
        elif isinstance(event, Switch):
            queue = "AUX" if event.at_once else "MOTION"
            said.append((f"{'SET' if event.on else 'CLEAR'}_{queue}_OUTPUT_BIT",))
        elif isinstance(event, Move):
            end = event.end / np.r_[np.full(3, MM), np.full(3, DEG)]
            way = np.abs(end - pose)
            length = np.linalg.norm(way[:3]) if np.linalg.norm(way[:3]) > 1e-6 else np.linalg.norm(way[3:])
            unit = MM if np.isnan(pose).any() or np.linalg.norm(way[:3]) > 1e-6 else DEG
            timed = event.duration is not None
            # In inverse time the interpreter never goes below 0.1 per minute.
            feed = max(0.1, length / event.duration * MINUTE) if timed else (event.feed or np.nan) * MINUTE / unit
            said.append(("FEED" if timed or event.feed is not None else "TRAVERSE", event.exact, feed, *end))
            pose = end
    return said


def interpreted(commands: list[tuple[str, list[float]]]) -> list[tuple]:
    """The same from the interpreter's output, which has four decimals."""
    said: list[tuple] = []
    feed, exact = 0.0, False
    for name, numbers in commands:
        if name == "SET_FEED_RATE":
            feed = numbers[0]
        elif name == "SET_MOTION_CONTROL_MODE":
            exact = not numbers  # CANON_EXACT_PATH has no tolerance
        elif name.startswith("STRAIGHT_"):
            said.append((name.removeprefix("STRAIGHT_"), exact, feed, *numbers))
        elif name == "DWELL":
            said.append((name, numbers[0]))
        elif name.endswith("_OUTPUT_BIT"):
            said.append((name,))
    return said


def require_same(text: str, commands: list[tuple[str, list[float]]] | str) -> None:
    assert not isinstance(commands, str), commands
    ours, theirs = meaning(text), interpreted(commands)
    assert [m[0] for m in ours] == [m[0] for m in theirs]
    for mine, other in zip(ours, theirs, strict=True):
        if mine[0] == "TRAVERSE":
            mine, other = mine[3:], other[3:]
        assert list(mine[1:]) == pytest.approx(list(other[1:]), rel=1e-6, abs=0.51e-4)


@SAME_FOLDER
@given(program=programs())
def test_every_program_that_is_written_is_accepted_and_means_what_the_reader_says(program: Blocks, rs274: Callable):
    text = linuxcnc_text(program)
    require_same(text, rs274(text))


def test_an_excitation_is_accepted_and_means_what_the_reader_says(hexapod_case: Case, rs274: Callable):
    text = small_excitation(hexapod_case)
    require_same(text, rs274(text))


@SAME_FOLDER
@given(lines=st.lists(st.sampled_from(LINES), max_size=12))
def test_lines_in_any_order_mean_to_the_reader_what_they_mean_to_the_controller(lines: list[str], rs274: Callable):
    text = typed("\n".join(lines))
    try:
        meaning(text)
    except ProgramError:
        return  # the reader may be stricter
    require_same(text, rs274(text))


@pytest.mark.parametrize(
    "line", ["G61 G64", "G93 G94", "G21 G21", "G17 G17", "M62 P0 Q1", "G4 P1 Q1", "G80\nX1", "G1 X1 F1 G80 G0"]
)
def test_what_the_controller_refuses_is_not_called_proven(line: str, rs274: Callable):
    assert isinstance(rs274(typed(line)), str), "the controller accepts it: not a test"
    with pytest.raises(ProgramError, match=r"line [45]"):
        read_linuxcnc(typed(line), "p.ngc")


def test_what_is_said_here_of_the_interpreter_is_what_it_says(rs274: Callable):
    """The judge itself: a program that is wrong is refused with the line."""
    assert "Cannot do g1 with zero feed rate" in rs274(typed("G94\nG1 X1"))
    assert interpreted(rs274(f"{HEAD}M2\n")) == [("FEED", True, 3000.0, 0.0, 0.0, 900.0, 0.0, 0.0, 0.0)]


@pytest.mark.parametrize(
    ("before", "said"),
    [("G0 X0.02", "X is at 0.02"), ("G0 C-360", "C is at -360"), ("G92 Z5\nG0 Z900\nG20", "Z is at 1795"),
     ("G10 L2 P1 Y1", "G54 is not zero"), ("G10 L2 P1 R5", "G54 is not zero")],
)  # fmt: skip
def test_its_interpreter_stops_our_programs_where_the_machine_does_not_stand_at_home(
    before: str, said: str, rs274: Callable
):
    text = linuxcnc_text(("a header", ToHome(HOME, 0.05)))
    assert not isinstance(rs274(text), str)
    assert said in rs274(f"{before}\n{text}")


def test_its_interpreter_goes_on_within_the_tolerance(rs274: Callable):
    text = linuxcnc_text(("a header", ToHome(HOME, 0.05)))
    assert rs274(f"G0 X0.009 B-0.009\n{text}")[-1][0] == rs274(text)[-1][0]
