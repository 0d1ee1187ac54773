"""Edits that leave a program's syntax intact and make it dangerous: refused, or said of the program in plain words.

What is nevertheless called proven is judged again by a naive reading of its words that shares nothing with the readers.
"""

import re
from collections.abc import Callable
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cases.errors import ProgramError
from identification.limits import prove
from identification.motion import Joined, Standstill
from identification.trajectories.profile import StraightMove
from planner.families.fourier import FourierFamily
from postprocessors.composing import excitation_program
from postprocessors.dialects import dialect
from postprocessors.proving.proof import ProgramProof, prove_program
from tests.helpers import one_line
from tests.postprocessors.independent import strut_lengths
from tests.postprocessors.other_dialects import CASE, LINES_CASE
from tests.postprocessors.programs import HOME

LIMITS = CASE.limits.motion
FAR = HOME + np.r_[0.05, -0.03, 0.02, 0.1, -0.05, 0.1]
CASES = {"linuxcnc": CASE, "sinumerik": CASE, "sinumerik lines": LINES_CASE, "twincat": CASE}
NAMES = [n for n in CASES if n != "sinumerik lines"]


def proof(name: str, text: str) -> ProgramProof:
    language, case = dialect(name.split()[0]).load(), CASES[name]
    reading = language.read(text.encode("latin-1"), "p", case)
    return prove_program(reading, case, language.guarantees(reading, case))


@cache
def moves(name: str) -> str:
    """There and back with a pause, at 90 % of the limits."""
    limits = [0.9 * v for v in (LIMITS.rate, LIMITS.acceleration, LIMITS.jerk)]
    there, back = StraightMove.fastest(HOME, FAR, *limits), StraightMove.fastest(FAR, HOME, *limits)
    program = excitation_program(Joined((there, Standstill(FAR, 0.2), back)), CASES[name], ())
    return dialect(name.split()[0]).load().write(program, CASES[name]).decode("ascii")


@cache
def path(name: str) -> str:
    """A Fourier motion of half a second that uses 85 % of its tightest limit."""
    family = FourierFamily(2, 0.5, 1, HOME, (LIMITS.pose[1] - LIMITS.pose[0]) / 2, 12)
    unknowns = np.random.default_rng(1).normal(size=family.unknowns * 6)
    for _ in range(6):
        unknowns *= 0.85 / prove(family.motion(unknowns), CASE, 2000.0).worst_ratio
    program = excitation_program(family.motion(unknowns), CASES[name], ())
    return dialect(name.split()[0]).load().write(program, CASES[name]).decode("ascii")


def tenfold(match: re.Match[str]) -> str:
    return f"F{10 * float(match[1]):.6f}"


def changed(text: str, pattern: str, new: str | Callable[[re.Match[str]], str], which: int = 0) -> str:
    """The text with one match replaced; it must exist."""
    found = list(re.finditer(pattern, text, re.MULTILINE))
    assert found, f"{pattern!r} is not in the program"
    match = found[which]
    return text[: match.start()] + (match.expand(new) if isinstance(new, str) else new(match)) + text[match.end() :]


def refused(name: str, text: str) -> bool:
    try:
        return not proof(name, text).ok
    except ProgramError as error:
        return bool(one_line(error))


@pytest.mark.parametrize("name", CASES)
def test_the_programs_before_the_edits_are_proven(name: str):
    assert proof(name, moves(name)).ok
    assert proof(name, path(name)).ok


EVERY_DIALECT = {
    "a feed ten times as high": (r"F(\d{3,}\.\d+)$", tenfold),
    "the feed home ten times as high": (r"F3000$", "F30000"),
    "home at a rapid": (r"^(?:G94 )?G0?1( .*)F3000$", r"G0\1"),
    "no way home": (r"^.*F3000\n", ""),
    "a height below ground": (r"Z920", "Z-920"),
    "a height without its last digit": (r"Z920", "Z92"),
    "a coordinate without its decimal point": (r"(A2?=?5)\.7", r"\g<1>7"),
    "a position ten times as far": (r"X50 ", "X500 "),
    "axes exchanged": (r"X50 Y-30 Z920", "Z50 Y-30 X920"),
    "incremental coordinates": (r"\bG90\b", "G91"),
    "no kind of coordinates": (r"\bG90\b", ""),
    "feed per revolution": (r"\bG94\b", "G95"),
    "a second start in the middle": (r"(?s)(.*)", r"\1\1"),
    "no end": (r"^M(2|30)$", ""),
}
OF_A_DIALECT = {
    "linuxcnc": {
        "inches": (r"\bG21\b", "G20"),
        "no unit": (r"\bG21\b", ""),
        "corners cut": (r"^G61$", "G64"),
        "no stop between moves": (r"^G61\n", ""),
        "shifted coordinates": (r"^G92\.1$", "G92 X10"),
        "another coordinate system": (r"\bG54\b", "G55", 1),
        "seconds of a dwell as coordinate": (r"G4 P0\.2", "G4 X0.2"),
        "SINUMERIK's unit": (r"\bG21\b", "G71"),
    },
    "sinumerik": {
        "inches": (r"\bG710\b", "G700"),
        "no unit": (r"\bG710\b", ""),
        "no transformation": (r"^TRAORI\n", ""),
        "another transformation": (r"^TRAORI$", "TRAORI(2)"),
        "Euler angles": (r"ORIRPY", "ORIEULER"),
        "no kind of angles": (r"ORIWKS ORIRPY\n", ""),
        "axes of the machine as angles": (r"A2=5", "A=5"),
        "no jerk limit": (r"\bSOFT\b", "BRISK"),
        "a zero offset": (r"\bG500\b", "G54"),
        "corners cut": (r"\bG60\b", "G64"),
        "feed of other axes": (r"FGROUP\(X,Y,Z\)", "FGROUP(X,A)"),
        "no feed axes": (r"FGROUP\(X,Y,Z\)\n", ""),
        "LinuxCNC's unit": (r"\bG710\b", "G21"),
    },
    "twincat": {
        "inches": (r"\bG71\b", "G70"),
        "no unit": (r"\bG71\b", ""),
        "mirrored axes": (r"\bG71\b", "G71 G21"),
        "no kinematics": (r"^#KIN ID\[5\]\n", ""),
        "other kinematics": (r"#KIN ID\[5\]", "#KIN ID[6]"),
        "no transformation": (r"^#TRAFO ON\n", ""),
        "no slope": (r"^#SLOPE.*\n", ""),
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
@pytest.mark.parametrize("word", ["X", "Y", "Z", "A", "B", "C"])
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
    "it does not end at home, where A is 0 deg, but to ": {
        "linuxcnc": (r"^G1 X0 Y0 Z900 A0 B0 C0 F1.*\n", ""),
        "sinumerik": (r"^G1 X0 Y0 Z900 A2=0 B2=0 C2=0 F2.*\n", ""),
        "twincat": (r"^G01 G60 X0 Y0 Z900 A0 B0 C0 F2.*\n", ""),
    },
    "the first move does not go home, where X is 0 mm, but to 5 mm": dict.fromkeys(
        NAMES, (r"X0 Y0 Z900(.*)F3000", r"X5 Y0 Z900\1F3000")
    ),
    "G49 missing before the first move": {"linuxcnc": ("G49 ", "")},
    "G92.1 missing before the first move": {"linuxcnc": (r"^G92\.1\n", "")},
}


@pytest.mark.parametrize(("remark", "name"), [(r, n) for r, edits in TOLD.items() for n in edits])
def test_what_passes_no_limit_is_told(remark: str, name: str):
    assert not any(remark in told for told in proof(name, moves(name)).remarks)
    result = proof(name, changed(moves(name), *TOLD[remark][name]))
    assert any(remark in told for told in result.remarks)


def naively_read(name: str, text: str) -> list[tuple[np.ndarray, np.ndarray, float, bool]]:
    """Start, end [mm, deg], feed per minute and whether the trigger is on, of each move after the first."""
    pose, feed, on, found = np.full(6, np.nan), np.nan, False, []
    for line in text.split("\n"):
        line = re.sub(r"[;(].*", "", line) if name != "sinumerik" else line.split(";")[0]
        if re.match(r"M6[24]|M100|DO .*=1", line) or re.match(r"M6[35]|M101|DO .*=0", line):
            on = re.match(r"M6[24]|M100|DO .*=1", line) is not None
        if re.match(r"G0?4 |[%#D]|TRA|ORI|SOFT|FGROUP", line):
            continue
        words = {k: float(v) for k, v in re.findall(r"([XYZABCF])(?:2=)?(-?\d*\.?\d+)", line)}
        feed = words.pop("F", feed)
        if words:
            end = np.array([words.get(c, old) for c, old in zip("XYZABC", pose, strict=True)])
            if not np.isnan(pose).any():
                found.append((pose, end, feed, on))
            pose = end
    return found


def naive_share(name: str, text: str) -> float:
    """The largest share of a limit of poses, mean struts and feeds that a move uses; above 1 it is dangerous."""
    shares = [0.0]
    unit = np.repeat([1e-3, np.pi / 180], 3)
    for start, end, feed, on in naively_read(name, text):
        way = np.abs(end - start) * unit
        if not way.any():
            continue
        length = np.linalg.norm(way[:3]) if way[:3].any() else np.linalg.norm(way[3:])
        speed = feed / 60 * (1e-3 if way[:3].any() else np.pi / 180)
        shares.append(float(np.max(way * speed / length / LIMITS.rate)))
        box = LIMITS.pose[1] if on else np.r_[0.3, 0.3, np.inf, np.inf, np.inf, np.inf]
        shares.append(float(np.max(np.abs(end * unit - HOME) / box)))
        at = start + np.linspace(0.0, 1.0, 30)[:, None] * (end - start)
        at = at * unit * ([1, 1, 1, 1, -1, 1] if name == "twincat" else 1)
        lengths = strut_lengths(at, CASE)
        short, long = LIMITS.strut_length
        shares.append(float(np.max(np.abs(lengths - (short + long) / 2) / ((long - short) / 2))))
    return max(shares)


DAMAGE = st.tuples(
    st.sampled_from(["digit", "sign", "point", "delete", "double", "swap", "word", "letter"]),
    st.integers(0, 10_000),
    st.integers(0, 9),
)


def edited(text: str, edits: list[tuple[str, int, int]]) -> str:
    """Numbers, words and lines edited so that the syntax mostly stays intact."""
    for kind, where, digit in edits:
        lines = text.rstrip("\n").split("\n")
        if kind in ("delete", "double", "swap"):
            k = where % (len(lines) - 1)
            lines[k : k + 2] = {"delete": [lines[k + 1]], "double": [lines[k]] * 2 + [lines[k + 1]]}.get(
                kind, [lines[k + 1], lines[k]]
            )
            text = "\n".join(lines) + "\n"
            continue
        pattern = {"word": r"\b[GM]\d+\b ?", "letter": r"[XYZABC](?=-?\d)"}.get(kind, r"(?<=[XYZABCF=])-?\d+(?:\.\d+)?")
        found = list(re.finditer(pattern, text))
        match = found[where % len(found)]
        old = match[0]
        k = where % len(old)
        new = {
            "digit": old[:k] + (str(digit) if old[k].isdigit() else old[k]) + old[k + 1 :],
            "sign": old[1:] if old[0] == "-" else f"-{old}",
            "point": f"{float(old) * 10 ** (digit % 3 - 1):.6f}" if kind == "point" else "",
            "word": "",
            "letter": "XYZABC"[digit % 6],
        }[kind]
        text = text[: match.start()] + new + text[match.end() :]
    return text


def judged(name: str, edits: list[tuple[str, int, int]]) -> None:
    text = edited(moves(name), edits)
    try:
        result = proof(name, text)
    except ProgramError as error:
        assert one_line(error).startswith("p")
        return
    if result.ok:
        assert naive_share(name, text) <= 1.0 + 1e-6, text


each = pytest.mark.parametrize("name", NAMES)


@each
@settings(max_examples=100, deadline=None)
@given(edits=st.lists(DAMAGE, min_size=1, max_size=3))
def test_what_is_proven_of_an_edited_program_holds_by_a_naive_reading_too(name: str, edits: list[tuple[str, int, int]]):
    judged(name, edits)


@pytest.mark.slow
@each
@settings(max_examples=3400, deadline=None)
@given(edits=st.lists(DAMAGE, min_size=1, max_size=5))
def test_ten_thousand_edits_of_numbers_words_and_lines(name: str, edits: list[tuple[str, int, int]]):
    judged(name, edits)


@each
def test_the_naive_judge_sees_what_is_dangerous(name: str):
    assert 0.3 < naive_share(name, moves(name)) <= 1.0
    for edit in ("a feed ten times as high", "a height below ground", "a position ten times as far"):
        assert naive_share(name, changed(moves(name), *EVERY_DIALECT[edit])) > 1.0
