"""Edits that leave a program's syntax intact and make it dangerous: refused, or said of the program in plain words."""

import re

import pytest

from cases.base.errors import ProgramError
from tests.helpers import few, one_line
from tests.postprocessors.edited import CASES, EVERY_DIALECT, NAMES, changed, moves, path, proof, tenfold


def refused(name: str, text: str) -> bool:
    try:
        return not proof(name, text).ok
    except ProgramError as error:
        return bool(one_line(error))


@pytest.mark.parametrize("name", CASES)
def test_the_programs_before_the_edits_are_proven(name: str):
    assert proof(name, moves(name)).ok
    assert proof(name, path(name)).ok


OF_A_DIALECT = {
    "linuxcnc": {
        "inches": (r"\bG21\b", "G20"),
        "no unit": (r"\bG21\b", ""),
        "corners cut": (r"^G61\.1$", "G64"),
        "an offset that is not checked in the form": (r"abs\[#5221\]", "abs[#5222]"),
        "a text that LinuxCNC executes": (r"^\(abort,.*\)$", "(abort,#1)"),
        "no stop between moves": (r"^G61\.1\n", ""),
        "shifted coordinates": (r"^G92\.1$", "G92 X10"),
        "another coordinate system": (r"\bG54\b", "G55"),
        "seconds of a dwell as coordinate": (r"G4 P0\.2", "G4 X0.2"),
        "SINUMERIK's unit": (r"\bG21\b", "G71"),
    },
    "sinumerik": {
        "inches": (r"\bG710\b", "G700"),
        "no unit": (r"\bG710\b", ""),
        "a tool": (r"^D0$", "D1"),
        "no word on the tool": (r"^D0\n", ""),
        "a shift": (r"^TRANS$", "TRANS X10"),
        "no word on shifts": (r"^TRANS\n", ""),
        "a check without the basic system in another form": (r"AA_IB\[X\]-0", "AA_IB[X]-1"),
        "no transformation": (r"^TRAORI\n", ""),
        "another transformation": (r"^TRAORI$", "TRAORI(2)"),
        "Euler angles": (r"ORIRPY", "ORIEULER"),
        "no kind of angles": (r"ORIWKS ORIRPY\n", ""),
        "axes of the machine as angles": (r"A2=5", "A=5"),
        "no jerk limit": (r"\bSOFT\b", "BRISK"),
        "a zero offset": (r"\bG500\b", "G54"),
        "a check of what was planned ahead": (r"^STOPRE\n", ""),
        "an alarm of the builder": (r"SETAL\(65", "SETAL(61"),
        "corners cut": (r"\bG60\b", "G64"),
        "feed of other axes": (r"FGROUP\(X,Y,Z\)", "FGROUP(X,A)"),
        "no feed axes": (r"FGROUP\(X,Y,Z\)\n", ""),
        "LinuxCNC's unit": (r"\bG710\b", "G21"),
    },
    "twincat": {
        "inches": (r"\bG71\b", "G70"),
        "no unit": (r"\bG71\b", ""),
        "mirrored axes": (r"\bG71\b", "G71 G21"),
        "no word on zero offsets": (r"G53 ", ""),
        "a zero offset": (r"\bG53\b", "G54"),
        "mirrored axes as LinuxCNC's millimetres": (r"\bG20\b", "G21"),
        "a check of another place without offsets": (r"ACT_POS\.X-0", "ACT_POS.X-1"),
        "no kinematics": (r"^#KIN ID\[5\]\n", ""),
        "other kinematics": (r"#KIN ID\[5\]", "#KIN ID[6]"),
        "no transformation": (r"^#TRAFO ON\n", ""),
        "no slope": (r"^#SLOPE.*\n", ""),
        "a check of what was programmed last": (r"^#CHANNEL INIT.*\n", ""),
        "a warning in place of an error": (r"RC=2", "RC=0"),
        "another slope": (r"TYPE=TRAPEZ", "TYPE=STEP"),
        "no exact stop": (r"G01 G60 X50", "G01 X50"),
        "LinuxCNC's exact stop": (r"G01 G60 X50", "G01 G61 X50"),
        "feed of other axes": (r"#FGROUP \[X,Y,Z\]", "#FGROUP [A,B,C]"),
        "an M function of somebody else": (r"^M100$", "M102"),
    },
}
EDITS_OF_MOVES = {(name, what): edit for name in NAMES for what, edit in (EVERY_DIALECT | OF_A_DIALECT[name]).items()}


@pytest.mark.parametrize(("name", "edit"), EDITS_OF_MOVES)
def test_an_edit_that_a_controller_would_run_into_or_understand_otherwise_is_refused(name: str, edit: str):
    assert refused(name, changed(moves(name), *EDITS_OF_MOVES[name, edit]))


POINTS = r"^(?:G0?1|POLY|X) ?.*F[\d.]+$"
PATHS = {
    "no inverse time": (r"G93", "", 0),
    "feeds per minute": (r"G93", "G94", 0),
    "a feed ten times as high": (r"F([\d.]+)$", tenfold, 15),
    "a line twice": (rf"({POINTS})", r"\1\n\1", 22),
    "a line lost": (rf"{POINTS}\n", "", 22),
    "two lines exchanged": (rf"({POINTS})\n({POINTS})", r"\2\n\1", 11),
}


@pytest.mark.parametrize("edit", PATHS)
@pytest.mark.parametrize("name", CASES)
def test_an_edit_in_a_timed_path_is_refused(name: str, edit: str):
    assert refused(name, changed(path(name), *PATHS[edit]))


@pytest.mark.parametrize("name", CASES)
def test_a_path_at_ten_times_its_speed_is_refused(name: str):
    factor = 0.1 if name == "twincat" else 10.0  # a time there, its inverse elsewhere
    before, mode, timed = path(name).partition("G93")
    assert refused(
        name, before + mode + re.sub(r"F([\d.]+)$", lambda m: f"F{float(m[1]) * factor:.9f}", timed, flags=re.M)
    )


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("word", few("Z", "B", "X", "Y", "A", "C", kept=2))
def test_one_coordinate_with_the_wrong_sign_within_a_path_is_refused(name: str, word: str):
    lines = path(name).split("\n")
    letter = rf"{word}2?=" if "lines" in name and word in "ABC" else word
    pattern = rf"PO\[{word}\]=\(" if name == "sinumerik" else letter
    values = [(k, m) for k, line in enumerate(lines) if (m := re.search(rf"({pattern})(-?)(\d[\d.]*)", line))]
    largest = 900.0 if word == "Z" else 0.0
    k, match = max((v for v in values if "G93" not in lines[v[0]]), key=lambda v: abs(float(v[1][3]) - largest))
    sign = "" if match[2] else "-"
    lines[k] = f"{lines[k][: match.start()]}{match[1]}{sign}{match[3]}{lines[k][match.end() :]}"
    assert refused(name, "\n".join(lines))


TOLD = {
    "the trigger is never switched off again": {
        "linuxcnc": (r"^M65 P0\n", ""),
        "sinumerik": (r"^DO .*=0\n", ""),
        "twincat": (r"^M101\n", ""),
    },
    "the trigger is never switched on": {
        "linuxcnc": (r"^M62 P0\n", ""),
        "sinumerik": (r"^DO .*=1\n", ""),
        "twincat": (r"^M100\n", ""),
    },
    "the program does not end at home, where A is 0 deg, but to ": {
        "linuxcnc": (r"^G1 X0 Y0 Z900 A0 B0 C0 F1.*\n", ""),
        "sinumerik": (r"^G1 X0 Y0 Z900 A2=0 B2=0 C2=0 F2.*\n", ""),
        "twincat": (r"^G01 G60 X0 Y0 Z900 A0 B0 C0 F2.*\n", ""),
    },
}


@pytest.mark.parametrize(("remark", "name"), [(r, n) for r, edits in TOLD.items() for n in edits])
def test_what_passes_no_limit_is_told(remark: str, name: str):
    assert not any(remark in told for told in proof(name, moves(name)).remarks)
    result = proof(name, changed(moves(name), *TOLD[remark][name]))
    assert any(remark in told for told in result.remarks)


@pytest.mark.parametrize("name", NAMES)
def test_a_program_that_checks_for_another_place_than_home_says_so(name: str):
    text = re.sub(r"(\[#<_x>|\$AA_I[WB]\[X\]|V\.A\.(?:ABS|ACT_POS)\.X)-0", r"\1-5", moves(name))
    result = proof(name, text.replace("X0 Y0 Z900 F3", "X5 Y0 Z900 F3"))
    assert any("where X is 0 mm, but to 5 mm" in told for told in result.remarks)
    assert not any("but to 5 mm" in told for told in proof(name, moves(name)).remarks)
