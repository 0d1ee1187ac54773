"""Reads URScript programs: the statements that an excitation needs, in one form each, and an error for all else.

Meanings follow Universal Robots' script manual: `a` and `v` of `movej` are those of the leading joint, a time overrides
both, a blend radius of 0 stops at the point; outputs switch when the statement before has ended.
"""

import re

import numpy as np

from cases.base.errors import Code, ProgramError
from cases.controller import UrScript
from cases.schema import Case
from postprocessors.reading import FLOAT, PLAIN, Grouping, Reading, Untimed, program_lines

JOINTS = 6
LARGEST = 1e4  # rad, rad/s, rad/s^2, s: no robot has such numbers
LONGEST_LINE = 4096
SHOWN = 60  # characters of a statement that an error repeats
_READS = (
    "a URScript program consists of `def NAME():`, the check of home as hexcite post writes it, indented "
    "movej([q1, .., q6], a=.., v=.., r=0) with plain numbers, never a time, sleep(seconds), "
    "set_standard_digital_out(n, True or False) with the case's output, and `end`"
)
_BLANKS = re.compile(r"\s*([\[\](),=])\s*")
_MOVE = re.compile(rf"movej\(\[{','.join([FLOAT] * JOINTS)}\],a={FLOAT},v={FLOAT}(?:,r=0)?\)")
_SLEEP = re.compile(rf"sleep\({FLOAT}\)")
_ASKS_WHERE = "standing=get_actual_joint_positions()"
_CHECK = re.compile(
    rf"if norm\(standing\[(?P<joint>[0-5])\](?P<place>[+-]{PLAIN})\)> (?P<within>{PLAIN}):\n"
    r'popup\("[^"\n]*","[^"\n]*",error=True,blocking=True\)\nhalt\nend'
)
_CHECK_LINES = 4
LOOSEST_CHECK = 0.01  # [rad] within which a program may check that the robot stands at a place


def read_urscript(content: bytes, file: str, case: Case) -> Reading:
    """Reads a program, see `Dialect.read`."""
    output = case.need_settings(UrScript, "a URScript program").trigger_output
    chain, limits = case.need_chain("a URScript program")
    if len(chain.joints) != JOINTS or not limits.turns.all():
        problem = f"URScript moves {JOINTS} joints that turn; case {case.name} has others"
        raise ProgramError(file=file, problem=problem, remedy="choose another dialect", code=Code.NOT_SUPPORTED)
    motions = Grouping(file)
    texts = (text.split("#", 1)[0].rstrip() for text in program_lines(content, file, LONGEST_LINE))
    lines = [(number, text, _BLANKS.sub(r"\1", text.strip())) for number, text in enumerate(texts, 1) if text]
    if not lines or not re.fullmatch(r"def [A-Za-z]\w*\(\):", lines[0][1]) or lines[-1][1] != "end":
        raise ProgramError(
            file=file,
            problem="truncated, or not begun and ended in the first column",
            remedy=_READS,
            code=Code.DAMAGED,
        )
    for line, text, code in _without_check(lines[1:-1], motions):
        switch = {f"set_standard_digital_out({output},{on})": on for on in (True, False)}.get(code)
        match = _MOVE.fullmatch(code) or _SLEEP.fullmatch(code)
        values = np.array(match.groups() if match else [np.inf], dtype=float)
        positive = values[JOINTS:] > 0.0 if len(values) > 1 else values >= 0.0
        if not text[0].isspace() or (switch is None and not (positive.all() and np.abs(values).max() <= LARGEST)):
            raise motions.error(line, f"{text.strip()[:SHOWN]!r} is not read here", f"remove or replace it: {_READS}")
        if switch is not None:
            motions.switch(line, switch, at_once=True)
        elif len(values) == 1:
            motions.pause(line, float(values[0]))
        else:
            end, (acceleration, speed) = values[:JOINTS], map(float, values[JOINTS:])
            leading = (
                range(JOINTS) if motions.coordinates is None else [int(np.argmax(np.abs(end - motions.coordinates)))]
            )
            within = None
            if motions.checked is not None and not any(isinstance(part, Untimed) for part in motions.stretches):
                leading, within = range(JOINTS), motions.checked[1]
                if np.any(np.abs(end - motions.checked[0]) > within):
                    raise motions.error(line, "the first move does not go to the checked place", "move there first")
            move = Untimed(
                line, None, end, speed, linear=False, counted=tuple(leading), acceleration=acceleration, within=within
            )
            motions.move(move, exact=True)
    return motions.reading(len(lines))


Lines = list[tuple[int, str, str]]
"""Number, text and statement without blanks, of each line with a statement."""


def _without_check(lines: Lines, motions: Grouping) -> Lines:
    """The lines behind a check of home at the begin, from which the robot then is not further than `checked`."""
    checked = 1 + _CHECK_LINES * JOINTS
    if not lines or lines[0][2] != _ASKS_WHERE or not all(text[0].isspace() for _, text, _ in lines[:checked]):
        return lines
    places: list[tuple[float, float]] = []
    while len(places) < JOINTS:
        first = 1 + _CHECK_LINES * len(places)
        statement = lines[first : first + _CHECK_LINES]
        match = _CHECK.fullmatch("\n".join(code for _, _, code in statement))
        place = lines[min(first, len(lines) - 1)][0]
        if match is None or int(match["joint"]) != len(places):
            raise motions.error(place, f"no check of joint {len(places)} as hexcite post writes it", "correct it")
        if not 0.0 < (within := float(match["within"])) <= LOOSEST_CHECK:
            raise motions.error(place, f"a check within {within:g} rad is none", f"check within {LOOSEST_CHECK:g}")
        places.append((-float(match["place"]), within))
    motions.stand_near(*np.array(places).T)
    return lines[checked:]
