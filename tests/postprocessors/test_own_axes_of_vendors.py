"""SINUMERIK and TwinCAT programs of a machine whose axes are its joints: what F counts, and what is refused."""

import re
from typing import Any

import numpy as np
import pytest

from cases.base.errors import HexciteError, ProgramError
from cases.schema import Case, load_case
from identification.motion.motion import Joined, Standstill
from identification.motion.moves import StraightMove
from postprocessors.program import dialect
from postprocessors.proof.homing import predicted
from postprocessors.proof.proof import prove_program
from postprocessors.reading import Still, Untimed
from postprocessors.writing import proven_program
from tests.helpers import one_line, polynomials_of
from tests.postprocessors.joint_walks import walk

KEEPS = ["velocity", "acceleration", "jerk"]
SETTINGS = {
    "sinumerik": {
        "program_name": "HEXCITE", "trigger_output": 1, "shortest_block_ms": 4.0, "most_blocks": 5000,
        "controller_keeps": KEEPS,
    },
    "twincat": {
        "program_name": "hexcite", "slope": "TRAPEZ", "trigger_on_m": 100, "trigger_off_m": 101,
        "shortest_block_ms": 2.0, "most_blocks": 5000, "controller_keeps": KEEPS,
    },
}  # fmt: skip
FILES = {"sinumerik": "walk.mpf", "twincat": "walk.nc"}
BOTH = pytest.mark.parametrize("name", list(FILES))


def made(endless: bool = False, **settings: object) -> Case:
    data = load_case("five_axis_table").model_dump(mode="json", exclude_unset=True)
    data["controller"] |= SETTINGS | settings
    if not endless:
        data["machine"]["chain"]["joints"][4] |= {"kind": "revolute", "position_deg": [-720.0, 720.0]}
    return Case.model_validate(data).found_at("five_axis_table")


CASE = made()
TEXTS = {
    name: proven_program(walk(CASE), CASE, dialect(name), FILES[name], ("a walk",)).content.decode() for name in FILES
}


def read(name: str, text: str, case: Case = CASE):
    return dialect(name).read(text.encode(), FILES[name], case)


@BOTH
def test_every_move_lasts_as_planned_and_all_limits_are_proven_or_enforced(name: str) -> None:
    reading = read(name, TEXTS[name])
    guarantees = dialect(name).guarantees(reading, CASE)
    moves = [part for part in reading.stretches if isinstance(part, Untimed) and part.within is None]
    lasting = [predicted(part, guarantees).duration for part in moves]
    assert lasting[1:-1] == pytest.approx([part.duration for part in walk(CASE).parts], rel=1e-6)
    proof = prove_program(reading, guarantees)
    assert proof.ok
    assert proof.relies_on == ()


@BOTH
def test_f_counts_lengths_in_mm_and_turns_in_degrees_as_the_text_says(name: str) -> None:
    """By hand from the text: with the axes of the last group, F over the way is one over the time at full speed."""
    home, box = CASE.need_motion("a test")
    turned = home + np.array([0.0, 0.0, 0.0, 0.3, -0.5])
    limits = 0.9 * box.rate, 0.9 * box.acceleration, 0.9 * box.jerk
    first: Any = walk(CASE).parts[0]
    there = [StraightMove.fastest(a, b, *limits) for a, b in ((home, turned), (turned, first.start))]
    motion = Joined((*there, *walk(CASE).parts))
    text = proven_program(motion, CASE, dialect(name), FILES[name], ()).content.decode()
    lines, reading = text.splitlines(), read(name, text)
    moves = {part.line: part for part in reading.stretches if isinstance(part, Untimed) and part.within is None}
    group: list[str] = []
    counted: set[str] = set()
    place: dict[str, float] = {}
    for number, line in enumerate(lines, 1):
        if found := re.match(r"#?FGROUP ?[(\[](.*)[)\]]", line):
            group = found[1].split(",")
        if not line.startswith("G1 ") and not line.startswith("G01 "):
            continue
        words = {w[0]: float(w[1:]) for w in line.split() if w[0] in "XYZACF"}
        if number in moves:
            way = np.linalg.norm([words[a] - place[a] for a in group])
            assert moves[number].feed / moves[number].length == pytest.approx(words["F"] / 60 / way, rel=1e-9)
            counted.add(",".join(group))
        place |= {a: words[a] for a in "XYZAC" if a in words}
    assert counted == {"A,C", "X,Y,Z"}


REFUSED = {
    "sinumerik": {
        "a transformation": ("TRAFOOF", "TRAORI", "TRAORI"),
        "another measure of a degree": ("FGREF[A]=57.29578", "FGREF[A]=100", "FGREF[A]=100 is not read"),
        "an index where none is": ("G60", "G60[X]=(1)", "[X]=(1)"),
        "a measure that is no number": ("FGREF[A]=57.29578", "FGREF[A]=(R)", "cannot read '[A]=(R)"),
        "no measure": ("FGREF[C]=57.29578\n", "", "FGREF"),
        "a group that is not that of the move": ("FGROUP(X,Y,Z)", "FGROUP(A,C)", "FGROUP"),
        "turns home that count lengths": ("FGROUP(A,C)", "FGROUP(X,Y,Z)", "FGROUP"),
        "a blend": ("G60", "G64", "G64"),
        "no exact stop": ("G60", "", "add G60"),
        "a time": ("G94", "G93", "G93"),
        "no jerk limit": ("SOFT", "BRISK", "BRISK"),
        "an arc": ("G1 X", "G2 X", "G2"),
        "another output": ("$A_OUT[1]", "$A_OUT[2]", "$A_OUT[2]=1) is not read"),
    },
    "twincat": {
        "a transformation": ("#TRAFO OFF", "#TRAFO ON", "#TRAFO ON"),
        "a group that is not that of the move": ("#FGROUP [X,Y,Z]", "#FGROUP [A,C]", "#FGROUP"),
        "turns home that count lengths": ("#FGROUP [A,C]", "#FGROUP [X,Y,Z]", "#FGROUP"),
        "no exact stop": ("G01 G60 X", "G01 X", "G60"),
        "another slope": ("TRAPEZ", "STEP", "SLOPE"),
        "an arc": ("G01 G60 X", "G02 G60 X", "G2"),
        "a curve": ("#TRAFO OFF", "#TRAFO OFF\n#SPLINE ON", "SPLINE"),
        "another output": ("M100", "M102", "M102"),
    },
}


@pytest.mark.parametrize(("name", "what"), [(name, what) for name, found in REFUSED.items() for what in found])
def test_what_the_proof_does_not_cover_is_refused_with_its_line(name: str, what: str) -> None:
    old, new, word = REFUSED[name][what]
    assert old in TEXTS[name]
    with pytest.raises(ProgramError) as caught:
        read(name, TEXTS[name].replace(old, new, 1))
    assert word in one_line(caught.value)


@BOTH
def test_standstills_switch_the_trigger_at_each(name: str) -> None:
    home, box = CASE.need_motion("a test")
    away = home + 0.5 * box.coordinates[1]
    there = StraightMove.fastest(home, away, 0.9 * box.rate, 0.9 * box.acceleration, 0.9 * box.jerk)
    back = StraightMove.fastest(away, home, 0.9 * box.rate, 0.9 * box.acceleration, 0.9 * box.jerk)
    motion = Joined((Standstill(home, 0.5, 1.0), there, Standstill(away, 0.5, 1.0), back))
    program = proven_program(motion, CASE, dialect(name), FILES[name], ())
    pauses = [part.duration for part in program.reading.stretches if isinstance(part, Still)]
    assert pauses == [0.5, 1.0, 0.5, 1.0]


@BOTH
def test_paths_endless_axes_and_foreign_settings_are_one_line_each(name: str) -> None:
    language = dialect(name)
    with pytest.raises(HexciteError, match="from rest to rest") as caught:
        proven_program(polynomials_of(walk(CASE).parts), CASE, language, FILES[name], ())
    one_line(caught.value)
    endless = made(endless=True)
    with pytest.raises(ProgramError, match=r"joint C .*without end.*position_deg") as caught:
        proven_program(walk(endless), endless, language, FILES[name], ())
    one_line(caught.value)
    hexapods = load_case("hexapod").controller
    with pytest.raises(ValueError, match=f"controller.{name}.*hexapod"):
        made(**{name: getattr(hexapods, name).model_dump(mode="json")})
