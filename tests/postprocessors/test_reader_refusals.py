"""What the reader does not understand it refuses, with line, column and remedy: half understood proves nothing."""

import re

import pytest

from cases.base.errors import ProgramError
from postprocessors.dialects.linuxcnc.read import LONGEST_LINE
from tests.helpers import one_line
from tests.postprocessors.programs import FIRST, read_linuxcnc, typed

# what line FIRST is -> column that is named (0: the line as a whole), what the message says
WRONG: dict[str, tuple[int, str]] = {
    "G20": (1, "G20 is not read here"),
    "G91": (1, "G91 is not read here"),
    "G1 X1 G91 F10": (7, "G91 is not read here"),
    "G17 G4 P2 G3 X0 Y2 I1 F10": (8, "P counts turns beside G3"),
    "G17 M64 P0 G2 X0 Y2 I1 F10": (9, "P counts turns beside G2"),
    "G17 G3 P1 X0 Y0 I1 F10": (8, "P counts turns beside G3"),
    "G17 G3 X0 Y-0.00000009 I50 J0 F10": (8, "ends next to where it begins; leave X, Y, Z out"),
    "G90.1": (1, r"G90\.1 is not read here"),
    "G7": (1, "G7 is not read here"),
    "G61\nG1 X1 F10\nG1 X2 F10": (4, r"under G61 the move before may run into this one; write G61\.1"),
    "G61\nG1 X10 F10\nG1 X20 Y1 F10": (4, "under G61 the move before may run"),
    "G61\nG1 A1 F10\nG1 A2 F10": (4, "under G61 the move before may run"),
    "G61\nG1 X1 F10\nG17 G3 X1 I1 F10": (8, "under G61 the move before may run"),
    "G17 G2 X1 F10": (8, "the arc has radius .*in its plane"),
    "G17 G03 X1 Y1 K1 F10": (9, "the arc has radius .*in its plane"),
    "G17 G2 X2 I1.1 J0 F10": (8, "the arc has radius .*in its plane"),
    "G17 G2 X2 Z901 I1 J0 F10": (8, "the arc has radius .*in its plane"),
    "G18 G3 I0 K0 F10": (8, "the arc has radius .*in its plane"),
    "G17 G93 G2 I1 F10": (12, "an arc needs a known start, a plane"),
    "G1 X1 I1 F10": (4, "coordinates need G0 or G1"),
    "G17 G2 R1 X1 F10": (8, "R1 is not read here"),
    "G60 X1": (1, "G60 is not read here"),
    "G71": (1, "G71 is not read here"),
    "G92.2": (1, r"G92\.2 is not read here"),
    "G5": (1, "G5 is not read here"),
    "G53 G0 X1": (1, "G53 is not read here"),
    "G55": (1, "G55"),
    "G92 X0": (1, "G92"),
    "G28": (1, "G28"),
    "G1.5 X1 F10": (1, r"G1\.5 is not read here"),
    "M3 S1000": (1, "M3 is not read here"),
    "M5": (1, "M5 is not read here"),
    "M0 G1 X1 F10": (4, "M0 stands in a block of its own"),
    "G1 X1 F10 M1": (1, "M1 stands in a block of its own"),
    "M6 T1": (1, "M6 is not read here"),
    "M66 P0 L3 Q5": (1, "M66 is not read here"),
    "G1 X1 F10 N10": (11, "N10 is not read here; remove"),
    "N10 N20 G1 X1 F10": (5, "N20 is not read here; remove"),
    "N-1 G1 X1 F10": (1, "N-1 is not read here; remove"),
    "N10. G1 X1 F10": (4, "cannot read '. G1"),
    "G1 U1 F10": (4, "U1 is not read here"),
    "G0 G1 X1 F10": (4, "G0 and G1 in one block"),
    "G1 X1 X2 F10": (7, "X1 and X2 in one block exclude each other"),
    "G1 X1 F10 F20": (11, "F10 and F20 in one block exclude each other"),
    "G1 X1 F0": (7, "F0 is not positive"),
    "G1 X1 F-10": (7, "F-10 is not positive"),
    "G94\nG1 X1": (4, "G1 without a feed"),
    "G93\nG1 X1": (4, "without F under G93.*F = 60 / seconds"),
    "G93\nF10\nX1": (1, "without F under G93"),
    "G64 P1 Q0 G93\nX1 F10\nG94\nX2": (1, "without a feed"),
    "G1 X1e1 F10": (6, "E1 is not read here"),
    "G1 X1E-3 F10": (6, "cannot read 'E-3|E-3 is not"),
    "G1 X1,5 F10": (6, "cannot read ',5 F10'"),
    "G1 X F10": (4, "cannot read 'X F10'"),
    "G1 X--1 F10": (4, "cannot read 'X--1"),
    "G1 X+-1 F10": (4, "cannot read"),
    "G1 X. F10": (4, r"cannot read 'X\."),
    "G1 X1.2.3 F10": (8, r"cannot read '\.3"),
    "G1 XNaN F10": (4, "cannot read 'XNaN"),
    "G1 Xinf F10": (4, "cannot read 'Xinf"),
    "G1 X1 F1_000": (9, "cannot read '_000"),
    "G1 X0x10 F10": (6, "cannot read 'x10|X10|second X"),
    "G1 X[1+1] F10": (4, r"cannot read 'X\[1"),
    "#1=5": (1, "cannot read '#1=5'"),
    "O100 sub": (6, "cannot read 'sub'"),
    "/G1 X1 F10": (1, "cannot read '/G1"),
    "G1 X1 F10 (to the right": (11, r"cannot read '\(to the"),
    "(a (nested) comment)": (1, r"cannot read '\(a \(nest"),
    "G1 X1 F10 a comment)": (11, r"cannot read 'a comment\)'"),
    "%": (1, "cannot read '%'; remove"),
    "P1": (1, "P1 is not read here"),
    "G1 X1 F10 Q1": (11, "Q1 is not read here"),
    "G4": (1, "G4 needs a duration.*G4 P0.3"),
    "G4 X2": (1, "G4 needs a duration"),
    "G4 P-1": (1, "G4 needs a duration of 0 to"),
    "M62": (1, "M62 needs P0"),
    "M62 P1": (1, "M62 needs P0"),
    "M65 P-1": (1, "M65 needs P0"),
    "M64 P0.5": (1, "M64 needs P0"),
    "G1 X1 F10\x00": (10, r"character '\\x00' is not plain ASCII"),
}


@pytest.mark.parametrize("line", WRONG)
def test_a_word_that_is_not_understood_is_named_with_line_and_column(line: str):
    column, words = WRONG[line]
    with pytest.raises(ProgramError, match=words) as caught:
        read_linuxcnc(typed(line), "p.ngc")
    place = f"p.ngc, line {FIRST + line.count(chr(10))}"
    assert one_line(caught.value).startswith(f"{place}, column {column}: " if column else f"{place}: ")


@pytest.mark.parametrize(
    ("lines", "words"),
    [
        ([f"({'x' * LONGEST_LINE})", "G1 X\x07"], "line 2: 254 characters"),
        (["G1 X\x07", f"({'x' * LONGEST_LINE})", "\u00e9"], r"line 2, column 5: character '\\x07' is not plain"),
        (["", " \t", "(\u00e9)"], "line 4, column 2: character"),
    ],
)
def test_of_what_no_controller_reads_the_first_line_is_named(lines: list[str], words: str):
    with pytest.raises(ProgramError, match=words):
        read_linuxcnc("\n".join(["(first)", *lines, "M2"]), "p.ngc")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (
            "G1 X0 Y0 Z900 A0 B0 C0 F10\nM2",
            "p.ngc, line 1, column 4: a move before a block with G21 G90 G94 G40 G49 G54 G92.1",
        ),
        ("G90\nG1 X0 Y0 Z900 A0 B0 C0 F10\nM2", "line 2, column 4: a move before a block with G21 G94"),
        ("G21\nG1 X0 Y0 Z900 A0 B0 C0 F10\nM2", "line 2, column 4: a move before a block with G90 G94"),
        ("G21 G90 G94 G40 G49 G54 G92.1\nX0 Y0 Z900 A0 B0 C0 F10\nM2", "line 2, column 1: coordinates need G0 or G1"),
        (
            "G21 G90 G94 G40 G49 G54 G92.1\nG1 X0 Y0 Z900 A0 B0 F10\nM2",
            "line 2, column 4: the first move leaves C open; name all 6 coordinates",
        ),
        ("G21 G90 G94 G40 G49 G54 G92.1\nG0 X0\nM2", "line 2, column 4: the first move leaves Y open"),
        ("G21 G90 G93\nG1\nM2", "line 2, column 1: G1 without a motion in its block"),
        ("G21 G90 G94\nG17 G3\nM2", "line 2, column 5: G3 without a motion in its block"),
        ("G21 G90\nM2\nG1 X1 F10", "line 3, column 1: a word after the end of the program; M2 must be last"),
        ("G21 G90\nM2\nM2", "line 3, column 1: a word after the end"),
        ("G21 G90\n", "p.ngc: no M2 at the end; the file is truncated"),
        ("", "no M2 at the end"),
    ],
)
def test_a_program_without_its_frame_is_refused(text: str, words: str):
    with pytest.raises(ProgramError, match=re.escape(words)) as caught:
        read_linuxcnc(text, "p.ngc")
    one_line(caught.value)


def test_comments_may_follow_the_end():
    assert read_linuxcnc("G21 G90\nM2\n(no word)\n; none\n\n", "p.ngc").stretches == ()


def test_a_line_may_be_as_long_as_the_controller_reads_and_no_longer():
    filled = f"({'x' * (LONGEST_LINE - 2)})"
    read_linuxcnc(typed(filled), "p.ngc")
    with pytest.raises(ProgramError, match=r"line 4: 253 characters, .*252; split"):
        read_linuxcnc(typed(filled.replace("x", "xx", 1)), "p.ngc")


@pytest.mark.parametrize(
    ("what", "text"),
    [
        ("digits of another script", "G1 X\N{ARABIC-INDIC DIGIT ONE} F10"),
        ("blanks that are none to the controller", "G1 X1\N{NO-BREAK SPACE}F10"),
        ("a line break that is none to the controller", "G1 X1 F10\x0bY2"),
        ("another", "G1 X1 F10\x85Y2"),
        ("a third", "G1 X1 F10\N{LINE SEPARATOR}Y2"),
    ],
)
def test_characters_that_the_controller_takes_otherwise_are_refused(what: str, text: str):
    with pytest.raises(ProgramError, match="line 4"):
        read_linuxcnc(typed(text), "p.ngc")


@pytest.mark.parametrize("number", ["9" * 60, "9" * 200])
@pytest.mark.parametrize("letter", "XAF")
def test_a_number_that_no_machine_has_is_refused_not_carried_along(letter: str, number: str):
    line = "G1 X1 A1 F10".replace(f"{letter}1", letter + number)
    with pytest.raises(ProgramError, match="line 4"):
        read_linuxcnc(typed(line), "p.ngc")
