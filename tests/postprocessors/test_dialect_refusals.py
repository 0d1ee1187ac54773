"""What the readers of SINUMERIK and TwinCAT programs do not understand they refuse, with line, column and remedy."""

import re

import pytest

from cases.base.errors import CaseError, ProgramError
from cases.schema import Case
from postprocessors.program import dialect
from tests.helpers import one_line
from tests.postprocessors.changed_case import changed
from tests.postprocessors.other_dialects import BOTH, CASE, SINUMERIK, TWINCAT, Typed, smooth_points

# what the body's last line is -> column that is named (0: the line as a whole), what the message says
SINUMERIK_WRONG: dict[str, tuple[int, str]] = {
    "G1 X1 F0": (7, "feed F0 is not positive"),
    "G94\nG1 X1": (4, "G1 without a feed"),
    "G1 X1 X2 F10": (7, "X1 and X2 in one block exclude each other"),
    "G1 G0 X1": (4, "G1 and G0 in one block exclude each other|G0 and G1"),
    "G64\nG1 X1 F10": (0, "without exact stop is blended into the next.*write .*G60"),
    "G93 G64\nG1 X1": (4, "G1 without F under G93"),
    "G93\nG1 X1 F600": (0, "a timed block under exact stop.*write G64"),
    "G64 G93\nG1 X1 F600\nG94 G60\nG1 X2 F60": (4, "the path before runs into this move"),
    "POLY PO[X]=(1,2) F600": (6, "a POLY block under G64 and G93 takes POLY"),
    "G64\nPO[X]=(1,2) F600": (1, "a POLY block under G64 and G93 takes POLY"),
    "G64\nPOLY PO[X]=(1,2) F600": (6, "a POLY block under G64 and G93 takes POLY"),
    "G64 G93\nPOLY PO[X]=(1,2)": (6, "a POLY block under G64 and G93 takes POLY"),
    "G64 G93\nPOLY PO[X]=(1,2) Y3 F600": (6, "a POLY block under G64 and G93 takes POLY"),
    "G64 G93\nPOLY PO[U]=(1,2) F600": (6, "a POLY block under G64 and G93 takes POLY"),
    "G64 G93\nPOLY PO[X]=(1,2) PO[X]=(1) F600": (
        18,
        r"PO\[X\]\(1,2\) and PO\[X\]\(1\) in one block exclude each other",
    ),
    "G64 G93\nPOLY PO[X]=(1,2,3,4,5,6) F600": (6, "a POLY block under G64 and G93 takes POLY"),
    "G64 G93\nPOLY PO[X]=(1,a) F600": (8, r"cannot read '\[X\]=\(1,a\) F6'"),
    "G64 G93\nPOLY PO[X]=(1,2) PL=0 F600": (6, "a POLY block under G64 and G93 takes POLY"),
    "PL=1 G1 X1 F10": (1, "a POLY block under G64 and G93 takes POLY"),
    "G642 G93 COMPCAD\nG1 X1 F600 M8": (12, "M8 is not read here"),
    "G642 G93 COMPCAD\nG1 X1 F600 SOFT": (12, "the compressor takes nothing but G1, coordinates and F"),
    "G1.0 X1 F10": (1, "G1.0 is not read here"),
    "G1.0000001 X1 F10": (1, "G1.0000001 is not read here"),
    "CTOL=1": (1, "CTOL is not above 0 and at most 0.02, the tolerance of the case"),
    "G1 I1 X1 F10": (4, "coordinates need G0 or G1"),
    "G2 X1 F10": (4, "the arc has radius .*in its plane"),
    "G2 X1 Y1 K1 I1 F10": (4, "the arc has radius .*in its plane"),
    "G2 X1 Y1 I5 F10": (4, "the arc has radius .*in its plane"),
    "G18 G2 X1 Y1 I5 F10": (8, "the arc has radius .*in its plane"),
    "DO $A_OUT[2]=1\nG1 X1 F10": (1, r"DO\(\$A_OUT\[2\]=1\) is not read here"),
    "DO $R1=$AC_TIME\nG1 X1 F10": (1, r"DO\(\$R1=\$AC_TIME\) is not read here"),
    "WHEN $A_IN[1]==1 DO $A_OUT[1]=1\nG1 X1 F10": (6, "cannot read"),
    "DO $A_OUT[1]": (1, r"DO\(\$A_OUT\[1\]\) is not read here"),
    "DO $A_OUT[1]=1": (0, r"waits for a next motion that never comes; write a dwell after it"),
    "G4 F-1": (1, "G4 needs a duration"),
    "G4 F2000000": (1, "a duration of 0 to 1e"),
    "G4 F1 X1": (7, "block of its own"),
    "TRAORI(2)": (1, r"TRAORI\(2\) is not read here"),
    "TRAFOOF\nG1 X1 F10": (4, "a move before TRAORI"),
    "WAITM(1,1,2)": (1, r"WAITM\(1,1,2\) is not read here; remove"),
    "R1=5": (1, "R1=5 is not read here"),
    "/G1 X1 F10": (1, "cannot read '/G1 X1 F10'"),
    "G1 X=5 F10": (4, "X=5 is not read here"),
    "G1 X=IC(5) F10": (4, "cannot read"),
    "G1 A2=IC(5) F10": (6, "cannot read"),
    "G1 XNaN F10": (4, "XNAN is not read here"),
    "G1 X10000000 F10": (4, r"X1e\+07 is not a number of a machine's size"),
    "%_N_2_MPF": (1, "cannot read"),
    "ASPLINE X1 Y1": (1, "ASPLINE is not read here"),
    "G1 X1 F10 G90 G91": (15, "G91 is not read here"),
    "G1 X1 F10 G60 G64": (15, "exclude each other"),
    "M17": (1, "M17 is not read here"),
    "PTP": (1, "PTP is not read here"),
    "TRAFOOF\nM30\nG1 X1 F10": (1, "after the end of the program"),
    "M30": (1, "the transformation is still on; write TRAFOOF"),
    "G1 X1 F10 DO $A_OUT[1]=1": (1, "DO.* stands in a block of its own"),
}
TWINCAT_WRONG: dict[str, tuple[int, str]] = {
    "G01 G60 X1 F0": (12, "feed F0 is not positive"),
    "G94\nG01 G60 X1": (9, "G1 without a feed"),
    "G01 G60 X1 X2 F10": (12, "X1 and X2 in one block exclude each other"),
    "G00 G01 G60 X1": (5, "exclude each other"),
    "G01 X1 F10": (0, "without exact stop .* its path is not known; write .*G60"),
    "G93\nG01 G60 X1 F1": (9, "G93 and a time belong to the points of a path"),
    "#SPLINE ON": (1, "#SPLINE ON opens a path of points behind #SPLINE TYPE AKIMA"),
    "#SPLINE TYPE BSPLINE": (1, "#SPLINE TYPE BSPLINE is not read here"),
    "#SPLINE TYPE AKIMA\n#SPLINE ON\nG93\nG01 X1 F1\n#SPLINE OFF": (1, "a path has 3 points or more"),
    "#SPLINE TYPE AKIMA\n#SPLINE ON\nG01 X1 F1": (5, "G93 and a time belong to the points of a path"),
    "#SPLINE TYPE AKIMA\n#SPLINE ON\nG93\nG01 X1": (5, "the block's time in seconds"),
    "#SPLINE TYPE AKIMA\n#SPLINE ON\n#HSC ON [BSPLINE PATH_DEV=0.01 TRACK_DEV=0.01]": (1, "within a path of points"),
    "#SPLINE TYPE AKIMA\n#SPLINE ON\nM100": (1, "M100 within a path of points"),
    "#SPLINE TYPE AKIMA\n#SPLINE ON\nG04 1": (1, "G4 within a path of points"),
    "#SPLINE TYPE AKIMA\n#SPLINE ON\nG93\nG01 X1 G60 F1\nG01 X2 F1": (
        5,
        "G93 and a time belong to the points of a path",
    ),
    "#SPLINE TYPE AKIMA\n#SPLINE ON\nG93\nG01 X1 F1\nG01 X2 F1\n#SPLINE OFF\nM100": (1, "a path has 3 points or more"),
    "#SPLINE OFF": (1, "#SPLINE OFF is not read here"),
    "#HSC ON": (1, r"not what the case says; write #HSC ON \[BSPLINE PATH_DEV=0\.02 TRACK_DEV=0\.05\]"),
    "#HSC ON [BSPLINE PATH_DEV=1 TRACK_DEV=0.05]": (
        1,
        r"not what the case says; write #HSC ON \[BSPLINE PATH_DEV=0\.02 TRACK_DEV=0\.05\]",
    ),
    "G261": (1, "G261 opens a path of points behind #CONTOUR MODE"),
    "#CONTOUR MODE [DEV, PATH_DEV=5]": (
        1,
        r"not what the case says; write #CONTOUR MODE \[DEV PATH_DEV=0\.02 TRACK_DEV=0\.05\]",
    ),
    "#KIN ID[6]": (1, "not what the case says"),
    "#KIN ID[5]": (1, "the kinematics cannot change while the transformation is on"),
    '#MSG ["a"]\n' * 11: (1, "the controller stops at 10 messages that nobody reads"),
    "G+1 G60 X1 F10": (1, r"G\+1 is not read here"),
    "#SLOPE [TYPE=STEP]": (1, "not what the case says"),
    "#SLOPE DEFAULT": (1, "#SLOPE DEFAULT is not read here"),
    "#PTP ON": (1, "#PTP ON is not read here"),
    "#TRAFO OFF\nG01 G60 X1 F10": (9, "a move before #TRAFO ON"),
    "#WAIT": (1, "#WAIT is not read here"),
    "#": (1, r"cannot read '\#'"),
    "G04": (1, r"G4 needs a duration of 0 to 1e\+06 s"),
    "G04 -1": (1, "needs a duration of 0 to"),
    "#TIME": (1, "#TIME is not read here"),
    "M100 G01 G60 X1 F1": (6, "M100 stands in a block of its own"),
    "M99": (1, "M99 is not read here"),
    "M3": (1, "M3 is not read here"),
    "G03 G60 X1 F10": (9, "the arc has radius .*in its plane"),
    "G03 X2 I1 F10": (0, "without exact stop .* write .*G60"),
    "$IF V.P.A == 1": (1, r"cannot read '\$IF V\.P\.A =='"),
    "[LABEL]": (1, r"cannot read '\[LABEL\]'"),
    "X1 \\": (4, "cannot read"),
    "/G01 X1": (1, "cannot read '/G01 X1'"),
    "N20: G01 X1": (4, "cannot read ': G01"),
    "V.P.X = 1": (1, "cannot read"),
    "%SECOND": (1, "cannot read '%SECOND'"),
    "% L SUB": (1, "cannot read '% L SUB'"),
    "G01 X1.2.3 G60 F1": (9, r"0\.3 is not read here"),
    "#TRAFO OFF\nM30\nG01 X1": (1, "after the end of the program"),
    "M30": (1, "the transformation is still on; write #TRAFO OFF"),
    "G01 G60 X1 F10 #FGROUP [A,B,C]": (1, "#FGROUP stands in a block of its own"),
}
TABLE = [(SINUMERIK, line, *found) for line, found in SINUMERIK_WRONG.items()]
TABLE += [(TWINCAT, line, *found) for line, found in TWINCAT_WRONG.items()]
both = pytest.mark.parametrize("typed", BOTH, ids=lambda t: t.name)


@pytest.mark.parametrize(
    ("typed", "line", "column", "words"), TABLE, ids=[f"{t.name}: {line[-40:]}" for t, line, *_ in TABLE]
)
def test_a_word_that_is_not_understood_is_named_with_line_and_column(typed: Typed, line: str, column: int, words: str):
    with pytest.raises(ProgramError, match=words) as caught:
        typed.read(typed.text(line))
    said = one_line(caught.value)
    assert re.match(rf"p, line \d+{f', column {column}' if column else ''}: ", said), said
    assert typed.first <= caught.value.line <= typed.first + line.count("\n") + 1


@both
def test_without_its_end_a_program_is_not_read(typed: Typed):
    with pytest.raises(ProgramError, match=r"no M30.*truncated"):
        typed.read(typed.head)


@both
def test_every_line_of_the_frame_is_needed(typed: Typed):
    """What it leaves undefined is named; a program's name alone may be missing."""
    lines = typed.text(f"G1 G60 X1 {typed.angle}1 F3000").splitlines()
    typed.read("\n".join(lines[1:]))
    for k in range(1, typed.first - 1):
        with pytest.raises(ProgramError, match=r"a move before|only after|leaves Y open|#TRAFO ON before"):
            typed.read("\n".join(lines[:k] + lines[k + 1 :]))


@both
def test_characters_that_are_no_ascii_are_named_with_their_column(typed: Typed):
    with pytest.raises(ProgramError, match=r"line 2, column 4: .*'é'.*ASCII"):
        typed.language.read(b"; a\nG1 \xe9\n", "p", CASE)


@both
def test_lines_longer_than_the_controller_takes_are_refused(typed: Typed):
    limit = {"sinumerik": 512, "twincat": 4096}[typed.name]
    fits = "; " + "x" * (limit - 2)
    typed.read(typed.text(f"{fits}\nG1 G60 X1 {typed.angle}1 F3000"))
    with pytest.raises(ProgramError, match=rf"\b{limit + 1} characters, .*\b{limit}\b"):
        typed.read(typed.text(fits + "x"))


@both
def test_more_blocks_than_the_memory_holds_are_refused(typed: Typed):
    small = changed(CASE, **{f"controller__{typed.name}__most_blocks": 20})
    with pytest.raises(ProgramError, match=r"20 blocks, .*most_blocks.*shorter"):
        typed.read(typed.text("G1 G60 X1 F300\n" * 20), small)


@pytest.mark.parametrize("name", ["sinumerik", "twincat", "setpoints"])
def test_a_case_without_settings_of_a_dialect_is_told_the_missing_table(name: str):
    controller = CASE.controller.model_copy(update={name: None})
    case = CASE.model_copy(update={"controller": controller})
    with pytest.raises(CaseError, match=rf"case hexapod: controller\.{name}: .*missing.*dialect {name}\b"):
        dialect(name).read(b"M30\n", "p", case)


@pytest.mark.parametrize(
    ("key", "value", "words"),
    [
        ("sinumerik__program_name", "2FAST", "is not a"),
        ("sinumerik__program_name", "A" * 25, "is not a"),
        ("sinumerik__program_name", "AB\n", "is not a"),
        ("sinumerik__transformation", "TRAORI; G0 Z0", "is not a"),
        ("sinumerik__transformation_off", "TRAFOOF()", "is not a"),
        ("sinumerik__orientation_words", ("a2", "b2", "c2"), "is not a"),
        ("sinumerik__orientation_words", ("A3", "B3", "C3"), "A3, B3, C3 do not name three angles"),
        ("sinumerik__orientation_words", ("A2", "B2", "C6"), "do not name three angles"),
        ("sinumerik__orientation_words", ("LEAD", "TILT", "C2"), "do not name three angles"),
        ("sinumerik__orientation_words", ("I", "J", "K"), "do not name three angles"),
        ("sinumerik__orientation_words", ("A", "B", "B"), "do not name three angles"),
        ("sinumerik__orientation_words", ("X", "B", "C"), "do not name three angles"),
        ("twincat__program_name", "A B", "is not a"),
        ("twincat__program_name", ".A", "is not a"),
        ("twincat__trigger_on_m", 30, "means something else to the controller"),
        ("twincat__trigger_on_m", 101, "are both 101"),
        ("twincat__angle_sign_b", 0, "1"),
    ],
)
def test_settings_that_no_controller_takes_are_refused(key: str, value: object, words: str):
    with pytest.raises(ValueError, match=words):
        changed(CASE, **{f"controller__{key}": value})


def test_the_sign_of_b_is_that_of_the_case():
    """A small B in the text, and what it turns: the known pose that a machine must be tried with."""
    plus = changed(CASE, controller__twincat__angle_sign_b=1)
    text = TWINCAT.text("G01 G60 X1 B5 F300")
    for case, sign in ((CASE, -1.0), (plus, 1.0)):
        assert TWINCAT.read(text, case).stretches[-1].end[4] == pytest.approx(sign * 0.0872664626)


def test_a_step_between_polynomials_is_judged_as_what_it_is():
    """Rates that step from piece to piece are an acceleration and a jerk within one cycle."""
    smooth = "POLY PO[X]=(0.001,0,0.001) F600\nPOLY PO[X]=(0.002,0,-0.001) F600"
    step = "POLY PO[X]=(2) F600\nPOLY PO[X]=(4) F600"
    for body, ok in ((smooth, True), (step, False)):
        text = SINUMERIK.text(f"G64 G93\n{body}\nG94 G60 G1\nG4 F0.1")
        proof = SINUMERIK.proof(text)
        assert proof.ok is ok
    kinds = {v.name for v in proof.violations}
    assert {"acceleration (x, step between blocks)", "jerk (x, step between blocks)"} <= kinds


@both
def test_a_motion_that_passes_a_limit_is_named_with_its_line(typed: Typed):
    ok = typed.proof(typed.text(typed.timed(smooth_points(typed, "X", 20.0))))
    assert ok.ok
    bad = typed.proof(typed.text(typed.timed(smooth_points(typed, "X", 300.0))))
    assert "position (x)" in {v.name for v in bad.violations}
    with pytest.raises(ProgramError, match=r"p, line \d+: .* limit"):
        bad.require()


def test_limits_say_who_answers_for_them(hexapod_case: Case):
    nobody = changed(hexapod_case, controller__twincat__controller_keeps=())
    text = TWINCAT.text(TWINCAT.timed(smooth_points(TWINCAT, "X", 20.0)))
    status = {str(c.of): str(c.status) for c in TWINCAT.proof(text).limits.checks}
    assert status["jerk"] == "enforced by controller"
    assert status["position"] == "proven"
    status = {str(c.of): str(c.status) for c in TWINCAT.proof(text, nobody).limits.checks}
    assert status["jerk"] == "NOT enforced"
    assert status["position"] == "proven"
