"""LinuxCNC's own idioms are read; words of other controllers that mean something else here are refused by name."""

from collections.abc import Callable

import pytest

from cases.base.errors import ProgramError
from tests.helpers import one_line
from tests.postprocessors.programs import read_linuxcnc, typed
from tests.postprocessors.reported import Move, Pause, Switch, reports

SKELETON = """(hexapod skeleton)
; semicolon comment
G17 G21 G40 G49 G54 G80 G90 G91.1 G94
G92.1
G64 P0.02 Q0
G0 X0 Y0 Z0 A0 B0 C0
G4 P0.25
M62 P0
G1 X1 Y0.5 Z0.2 A0.1 B-0.2 C0.3 F600
X2 Y1 Z0.4 A0.2 B-0.4 C0.6
G93 G1 X3 Y1.5 Z0.6 A0.3 B-0.6 C0.9 F120
X4 A0.4 F60
G1 A1.0 F60
G94 F600
G1 A2 B2 C2
M63 P0
G0 Z5
M2
"""


def test_the_skeleton_of_a_program_reads_with_its_times_feeds_and_switches():
    events = reports(read_linuxcnc, SKELETON, "p.ngc")
    moves = [e for e in events if isinstance(e, Move)]
    assert [m.duration for m in moves] == [None, None, None, 0.5, 1.0, 1.0, None, None]  # 60 / F seconds
    assert [m.feed is None for m in moves] == [True, False, False, True, True, True, False, True]  # rapids have none
    assert moves[1].feed == pytest.approx(600e-3 / 60)
    assert [e.duration for e in events if isinstance(e, Pause)] == [0.25]
    assert [(e.on, e.at_once) for e in events if isinstance(e, Switch)] == [(True, False), (False, False)]


@pytest.mark.linuxcnc
def test_linuxcnc_reads_the_same_skeleton(rs274: Callable):
    assert not isinstance(rs274(SKELETON), str)


OF_OTHERS = {
    "#TRAFO ON": "cannot read '#TRAFO",
    "#HSC ON [BSPLINE PATH_DEV=0.02]": "cannot read '#HSC",
    "%HEXAPOD_ID": "cannot read '%HEX",
    "G04 3.0": "cannot read '3.0|G4 needs",
    "G04 X4.5": "G4 needs a duration",
    "G4 F1.5": "G4 needs a duration",
    "G60": "G60 is not read here",
    "G360": "G360 is not read here",
    "G9 X1": "G9 is not read here",
    "G71": "G71 is not read here",
    "G710": "G710 is not read here",
    "G162": "G162 is not read here",
    "G642": "G642 is not read here",
    "TRAORI": "cannot read 'TRAORI",
    "ORIWKS ORIRPY": "cannot read 'ORIWKS",
    "X=10": "cannot read 'X=10",
    "A2=10": "cannot read '=10|A2",
    "G1 X1 A3=0 F10": "cannot read '=0",
    'MSG("text")': "cannot read 'MSG",
    "FGROUP(X,Y,Z)": "cannot read 'FGROUP",
    "POLY PO[X]=(1,2.5,0.7)": "cannot read 'POLY",
    "COMPCAD": "cannot read 'COMPCAD",
    "G1 X1e-3 F10": "e-3|E-3",
    "G1 X1,5 F10": "cannot read ',5",
    "(a (b) c)": "cannot read",
    "M30 M17": "M17 is not read here",
}  # fmt: skip


@pytest.mark.parametrize("line", OF_OTHERS)
def test_a_word_of_another_controller_is_refused_with_its_place(line: str):
    with pytest.raises(ProgramError, match=OF_OTHERS[line]) as caught:
        read_linuxcnc(typed(line), "p.ngc")
    assert one_line(caught.value).startswith("p.ngc, line 4, column")


def test_g21_sets_millimetres_here_and_inverse_time_is_no_time_in_seconds():
    """Elsewhere G21 mirrors, and F after G93 is the time itself: 20 would then be 20 s, not 3."""
    move = reports(read_linuxcnc, typed("G64 P1 Q0\nG93 G1 X5 F20"), "p.ngc")[-1]
    assert (move.duration, move.feed) == (3.0, None)
