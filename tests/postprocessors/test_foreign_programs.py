"""What foreign programs bring: numbers of blocks, percent signs, stops for the operator, comments, traces."""

import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cases.base.errors import ProgramError
from cases.schema import Case
from hexcite._run import carried_out
from hexcite._write import require_proven
from identification.motion.motion import Joined, Standstill
from identification.motion.moves import StraightMove, unit_profile
from postprocessors.excitation import excitation_program
from postprocessors.program import Program, dialect, read_program
from postprocessors.reading import Reading
from postprocessors.writing import proven_program
from tests.postprocessors.changed_case import changed
from tests.postprocessors.other_dialects import BOTH, CASE, LINUXCNC, SINUMERIK, TWINCAT, Typed
from tests.postprocessors.programs import FIRST, HOME, read_linuxcnc, typed

EVERY = [LINUXCNC, *BOTH]
GOLDEN = Path(__file__).parents[1] / "golden_dialects"
every = pytest.mark.parametrize("typed_as", EVERY, ids=lambda t: t.name)
BODY = {"linuxcnc": "G1 X1 F600\nG4 P0.2\nG1 X0 F600", "sinumerik": "G1 X1 F600\nG4 F0.2\nG1 X0 F600",
        "twincat": "G01 G60 X1 F600\nG04 0.2\nG01 G60 X0 F600"}  # fmt: skip


def numbered(text: str, step: int) -> str:
    """The lines of a program with numbers, but for its title, comments and lines without words."""
    lines = text.splitlines()
    return "\n".join(
        f"N{step * (k + 1)} {line}" if line.strip() and not line.startswith((";", "(", "%")) else line
        for k, line in enumerate(lines)
    )


def same(one: Reading, other: Reading) -> bool:
    with np.printoptions(floatmode="unique"):
        return repr(replace(one, blocks=0)) == repr(replace(other, blocks=0))


@every
@given(step=st.integers(1, 500))
def test_numbers_of_blocks_change_nothing(typed_as: Typed, step: int):
    text = typed_as.text(BODY[typed_as.name])
    assert same(typed_as.read(numbered(text, step)), typed_as.read(text))


@pytest.mark.parametrize(
    ("typed_as", "file"), [(SINUMERIK, "lines.mpf"), (TWINCAT, "akima.nc"), (LINUXCNC, "../golden/excitation.ngc")]
)
def test_numbers_of_blocks_may_stand_before_a_check_of_home(typed_as: Typed, file: str):
    """A control that numbers the blocks of a program numbers these lines too."""
    text = (GOLDEN / file).read_text()
    assert re.search(r"^(\$?IF|o\d+ if)", text, re.MULTILINE)
    of_numbered, of_plain = typed_as.read(numbered(text, 10)), typed_as.read(text)
    assert [(type(part), part.line) for part in of_numbered.stretches] == [
        (type(part), part.line) for part in of_plain.stretches
    ]
    assert of_numbered.blocks == of_plain.blocks
    loose = re.sub(r"(>|gt)( ?)0\.01", r"\1\g<2>777", text)
    with pytest.raises(ProgramError, match="within 777"):
        typed_as.read(numbered(loose, 10))


@pytest.mark.parametrize("before", ["", "\n\n", "  "])
@pytest.mark.parametrize(("end", "after"), [("M2\n", "%\n"), ("", " % "), ("M30\n", "%"), ("M2\n", "")])
def test_percent_signs_around_a_program_change_nothing(before: str, end: str, after: str):
    text = typed(BODY["linuxcnc"])
    enclosed = f"{before}%\n{typed(BODY['linuxcnc'], end=end)}{after}"
    above = enclosed.count("\n", 0, enclosed.index("G21"))
    read, plain = read_linuxcnc(enclosed, "p.ngc"), read_linuxcnc(text, "p.ngc")
    assert [part.line - above for part in read.stretches] == [part.line for part in plain.stretches]
    lined_up = replace(read, stretches=tuple(replace(part, line=part.line - above) for part in read.stretches))
    assert same(lined_up, plain)


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        ("(a comment)\n%\n{}M2\n%\n", 2, "cannot read '%'; remove"),
        ("%\n{}%\nG1 X200 F600\n", 7, "text behind the %"),
        ("%\n{}", 0, "no M2 at the end"),
        ("%HEXA\n{}M2\n", 1, "cannot read '%HEXA'; remove"),
    ],
)
def test_a_percent_sign_elsewhere_is_refused(text: str, line: int, words: str):
    body = typed("G1 X1 F600", end="")
    with pytest.raises(ProgramError, match=re.escape(words)) as caught:
        read_linuxcnc(text.format(body), "p.ngc")
    assert caught.value.line == line


@pytest.mark.linuxcnc
@pytest.mark.parametrize("wrap", ["%\n{}\n%\n", "%\n{}\nM2\n", "\n %\n{}\nM2\n%\n", "{}\nM30\n"])
def test_linuxcnc_takes_the_same_moves_with_numbers_and_percent_signs(wrap: str, rs274: Callable):
    plain = typed(BODY["linuxcnc"])
    moves = [c for c in rs274(plain) if c[0].startswith(("STRAIGHT", "DWELL"))]
    other = wrap.format(numbered(typed(BODY["linuxcnc"], end="").rstrip(), 10))
    assert len(moves) == 4
    assert [c for c in rs274(other) if c[0].startswith(("STRAIGHT", "DWELL"))] == moves
    read_linuxcnc(other, "p.ngc")


@every
@pytest.mark.parametrize("word", ["M0", "M01"])
def test_a_stop_for_the_operator_stands_and_is_said(typed_as: Typed, word: str):
    body = BODY[typed_as.name].splitlines()
    text = typed_as.text("\n".join([*body[:1], f"N7 {word}", *body[1:]]))
    reading = typed_as.read(text)
    assert reading.stops == (typed_as.first + 1,)
    assert [p.duration for p in reading.stretches if hasattr(p, "duration") and p.line == typed_as.first + 1] == [0.0]
    remarks = typed_as.proof(text).remarks
    assert [r for r in remarks if f"line {typed_as.first + 1}: the machine waits for its operator" in r]


@pytest.mark.parametrize("word", ["M0", "M1"])
def test_a_stop_within_a_path_of_points_is_refused(word: str):
    path = TWINCAT.timed([TWINCAT.point(0.1, f"X{k}") for k in (1, 2, 1, 0)]).splitlines()
    with pytest.raises(ProgramError, match=f"{word} within a path of points"):
        TWINCAT.read(TWINCAT.text("\n".join([*path[:5], word, *path[5:]])))


def test_the_virtual_controller_runs_a_program_with_numbers_stops_and_percent_signs(hexapod_case: Case, tmp_path):
    assert ran(hexapod_case, tmp_path, "virtual") == pytest.approx(2.107, abs=0.01)


@pytest.mark.linuxcnc
@pytest.mark.slow
def test_linuxcnc_runs_a_program_with_numbers_stops_and_percent_signs(hexapod_case: Case, tmp_path):
    assert ran(hexapod_case, tmp_path, "linuxcnc") == pytest.approx(2.107, abs=0.02)


def ran(case: Case, folder, on: str) -> float:
    """How long the excitation takes: two moves of a second and a ramp each, and 0.1 s behind the stop between them."""
    body = ["G4 P0.3", "M64 P0", "G4 P0.2 (settle)", "G1 X20 F1200", "M0", "g4 p0.1", "G1 X0 F1200", "M65 P0", "G4 P.3"]
    text = numbered(typed("\n".join(body), end="").rstrip(), 10)
    file = folder / "p.ngc"
    file.write_text(f"%\n{text}\n%\n")
    program = read_program(file, case)
    require_proven(program, case)
    return carried_out(program, case, on).excitation


# Comments

EXECUTED = [
    *("(LOGOPEN,/tmp/x)", "( logappend , x)", "(LOG,x)", "(LOGCLOSE)", "(PROBEOPEN x.txt)", "(probeclose)"),
    *("(ABORT,stop)", "(PRINT,#5220)", "(DEBUG,#1)", "(py,import os)", ";py,import os", "; PY,x", ";PYRUN,x"),
    *("(pyreload)", "(system,ls)", "(AXIS,hide)", "(new_word,x)", "(a;py,import os) ;b", "(say ;LOGOPEN,x) ; (c)"),
]
HARMLESS = [
    "(to home, then on)", "(MSG, keep the way clear)", "(msg,x)", "(- LOGOPEN,x)", "(10, 20)", "; to home", ";", "()",
    "(the log, closed)", "; (py, x)", "(say ;LOGOPEN,x)", "(Spindle: none)", ";--- py,",
]  # fmt: skip


@pytest.mark.parametrize("comment", EXECUTED)
@pytest.mark.parametrize("before", ["", "G1 X1 F600 "])
def test_a_comment_that_linuxcnc_may_execute_is_refused_with_its_place(comment: str, before: str):
    with pytest.raises(ProgramError, match="LinuxCNC may execute the comment") as caught:
        read_linuxcnc(typed(f"{before}{comment}"), "p.ngc")
    assert caught.value.line == FIRST


@pytest.mark.parametrize("comment", HARMLESS)
def test_other_comments_are_read(comment: str):
    assert same(read_linuxcnc(typed(f"{comment}\nG1 X1 F600"), "p.ngc"), read_linuxcnc(typed("\nG1 X1 F600"), "p.ngc"))


@pytest.mark.linuxcnc
@pytest.mark.parametrize("comment", HARMLESS)
def test_linuxcnc_does_nothing_with_them(comment: str, rs274: Callable):
    shown = {"COMMENT", "MESSAGE"}
    plain = [c for c in rs274(typed("G1 X1 F600")) if c[0] not in shown]
    assert [c for c in rs274(typed(f"{comment}\nG1 X1 F600")) if c[0] not in shown] == plain


@pytest.mark.parametrize(
    ("typed_as", "line", "words"),
    [
        (SINUMERIK, ";$PATH=/_N_CST_DIR", "may act on"),
        (SINUMERIK, "; $PATH=/_N_CUS_DIR", "may act on"),
        (SINUMERIK, 'MSG("a" << R1)', "cannot read|not read"),
        (TWINCAT, "; a comment \\", "makes the next line a part"),
        (TWINCAT, "G01 G60 X1 F600 ; a \\  ", "makes the next line a part"),
        (TWINCAT, '#MSG ["X=%F", V.A.ABS.X]', "one text without formats"),
        (TWINCAT, '#MSG ["A", "B"]', "one text without formats"),
        (TWINCAT, '#MSG SYN ["A"]', "not read"),
    ],
)
def test_comments_and_messages_that_do_something_are_refused(typed_as: Typed, line: str, words: str):
    with pytest.raises(ProgramError, match=words) as caught:
        typed_as.read(typed_as.text(line))
    assert caught.value.line == typed_as.first


HOSTILE = st.text(st.sampled_from('py,;()\\"$PATH=/_N_CST_DIR%#[]{}MSGLOGOPEN \n\t\r\x1b\u2028ä'), max_size=60)


@every
@given(texts=st.lists(HOSTILE, max_size=5))
def test_whatever_names_hold_our_own_text_does_nothing(typed_as: Typed, texts: list[str]):
    program = (*texts, *excitation_program(Joined((there_and_back(),)), CASE))
    written = typed_as.language.write(program, CASE).decode("ascii")
    plain = typed_as.language.write(program[len(texts) :], CASE).decode("ascii")
    assert all(" " <= c <= "~" or c == "\n" for c in written)
    with np.printoptions(floatmode="unique"):
        motions = [repr([replace(p, line=0) for p in typed_as.read(text).stretches]) for text in (written, plain)]
    assert motions[0] == motions[1]
    assert not re.search(r";.*\\\s*$|;\s*\$(?!PATH=/_N_MPF_DIR)", written, re.MULTILINE)


# Traces of SINUMERIK

TRACED = changed(CASE, controller__sinumerik__trace=True)


def there_and_back() -> StraightMove:
    return StraightMove(HOME, HOME + np.array([0.02, 0, 0, 0, 0, 0]), unit_profile(0.1, 0.1, 0.1))


def program_for(case: Case) -> Program:
    spoken = dialect("sinumerik")
    motion = Joined((there_and_back(), Standstill(there_and_back().end, 0.2)))
    return proven_program(motion, case, spoken, "p.mpf", ("a trace",), accepted=("jerk", "strut velocity"))


def test_a_trace_begins_before_the_trigger_and_ends_after_it_where_the_case_says_so():
    lines = program_for(TRACED).text.splitlines()
    plain = program_for(CASE).text.splitlines()
    start, stop = lines.index("$AN_SLTRACE=1"), lines.index("$AN_SLTRACE=2")
    on, off = (next(k for k, line in enumerate(lines) if line == f"DO $A_OUT[1]={n}") for n in (1, 0))
    assert start < on < off < stop
    assert lines[start - 1] == lines[stop - 1] == "STOPRE"
    assert lines[start + 1].startswith("G4 F")  # stood still within the trace, before and after
    assert lines[stop - 2].startswith("G4 F")
    kept = [line for line in lines if line not in ("STOPRE", "$AN_SLTRACE=1", "$AN_SLTRACE=2")]
    assert without_hashes(kept) == without_hashes([line for line in plain if line != "STOPRE"])


def without_hashes(lines: list[str]) -> list[str]:
    return [line for line in lines if "controller settings" not in line]


@pytest.mark.parametrize("case", [CASE, TRACED], ids=["not asked for", "asked for"])
def test_a_program_that_starts_a_trace_is_read_whatever_the_case_says(case: Case):
    text = SINUMERIK.text("STOPRE\nN5 $AN_SLTRACE=1\nG1 X1 F600\nG4 F0.2\n$AN_SLTRACE = 2")
    plain = SINUMERIK.text("\n\nG1 X1 F600\nG4 F0.2\n")
    assert same(SINUMERIK.read(text, case), SINUMERIK.read(plain, case))


@pytest.mark.parametrize(
    ("body", "line", "words"),
    [
        ("$AN_SLTRACE=3", 0, "neither the start nor the end of a trace"),
        ("$AN_SLTRACE=1 G1 X1 F600", 0, "in a block of its own"),
        ("$AN_OTHER=1", 0, "cannot read .*; remove or replace it"),
        ("$A_OUT[1]=1", 0, "cannot read .*; remove or replace it"),
        ("{path}\nSTOPRE", 7, "while the machine moves on"),
    ],
)
def test_other_assignments_and_traces_in_motion_are_refused(body: str, line: int, words: str):
    points = [SINUMERIK.point(0.05, f"X{x}") for x in (1, 2, 1)]
    path = "\n".join([SINUMERIK.before, *points, "COMPOF", "G94", "G1"])
    with pytest.raises(ProgramError, match=words) as caught:
        SINUMERIK.read(SINUMERIK.text(body.format(path=path)))
    assert caught.value.line == SINUMERIK.first + line
