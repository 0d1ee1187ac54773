"""Programs that can be read but whose motion nobody can know: refused with the line, never guessed."""

import pytest

from cases.base.errors import ProgramError
from cases.schema import Case
from tests.helpers import one_line
from tests.postprocessors.programs import parts, proof, there_and_back, timed, typed

FREE = "G21 G90 G94 G40 G49 G54 G92.1\n"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (
            typed("G64\nG93\nG1 X0 Y0 Z900 A0 B0 C0 F60", head=FREE),
            "line 4: a timed block starts from an unknown pose; first move home at a feed",
        ),
        (
            typed("G64\nG1 X5 F100\nG1 X6"),
            r"line 5: a move at a feed without exact stop is blended .*, its path is not known; write G61\.1",
        ),
        (typed("G1 X0 Y0 Z900 A0 B0 C0 F100", head=FREE), "line 2: a move at a feed without exact stop is blended"),
        (typed("G64\nG0 X5"), "line 5: a move at a feed without exact stop is blended"),
        (typed("", head=FREE), "contains no motion; is this the right file"),
        (typed("G4 P1\nM64 P0", head=FREE), "contains no motion"),
    ],
)
def test_motion_that_is_not_defined_is_refused(text: str, words: str, hexapod_case: Case):
    with pytest.raises(ProgramError, match=words) as caught:
        proof(text, hexapod_case)
    one_line(caught.value)


def test_timed_blocks_under_exact_stop_are_refused_since_the_controller_stops_at_each(hexapod_case: Case):
    """In G61 each block comes to rest: ten times the acceleration of the smooth path that would be proven."""
    text = typed(timed(there_and_back()).replace("G64 P1 Q0", "G61"))
    with pytest.raises(ProgramError, match=r"line 6: .*G64"):
        proof(text, hexapod_case)


def test_a_tolerance_that_lets_the_controller_cut_corners_at_will_is_refused(hexapod_case: Case):
    lines = there_and_back()
    assert proof(typed(timed(lines)), hexapod_case).ok
    for blend in ("G64 P50 Q0", "G64 P1 Q5", "G64 P1"):  # Q merges blocks, and without it is what P is
        with pytest.raises(ProgramError, match=r"line 4.*G64"):
            parts(typed(timed(lines).replace("G64 P1 Q0", blend)), hexapod_case)
