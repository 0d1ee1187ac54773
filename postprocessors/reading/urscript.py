"""Reads URScript programs: the statements that an excitation needs, in one form each, and an error for all else.

Meanings follow Universal Robots' script manual: `a` and `v` of `movej` are those of the leading joint, a time overrides
both, a blend radius of 0 stops at the point; outputs switch when the statement before has ended.
"""

import re

import numpy as np

from cases.controller import UrScript
from cases.errors import ProgramError
from cases.schema import Case
from postprocessors.reading import FLOAT, Grouping, Reading, program_lines

JOINTS = 6
LARGEST = 1e4  # rad, rad/s, rad/s^2, s: no robot has such numbers
LONGEST_LINE = 4096
SHOWN = 60  # characters of a statement that an error repeats
_READS = (
    "a URScript program consists of `def NAME():`, indented movej([q1, .., q6], a=.., v=.., r=0) with plain numbers, "
    "never a time, sleep(seconds), set_standard_digital_out(n, True or False) with the case's output, and `end`"
)
_BLANKS = re.compile(r"\s*([\[\](),=])\s*")
_MOVE = re.compile(rf"movej\(\[{','.join([FLOAT] * JOINTS)}\],a={FLOAT},v={FLOAT}(?:,r=0)?\)")
_SLEEP = re.compile(rf"sleep\({FLOAT}\)")


def read_urscript(content: bytes, file: str, case: Case) -> Reading:
    """Reads a program, see `Dialect.read`."""
    output = case.need_settings(UrScript, "a URScript program").trigger_output
    chain, limits = case.need_chain("a URScript program")
    if len(chain.joints) != JOINTS or not limits.turns.all():
        problem = f"URScript moves {JOINTS} joints that turn; case {case.name} has others, choose another dialect"
        raise ProgramError(file, 0, 0, problem)
    motions = Grouping(file)
    texts = (text.split("#", 1)[0].rstrip() for text in program_lines(content, file, LONGEST_LINE))
    lines = [(number, code) for number, code in enumerate(texts, 1) if code]
    if not lines or not re.fullmatch(r"def [A-Za-z]\w*\(\):", lines[0][1]) or lines[-1][1] != "end":
        raise ProgramError(file, 0, 0, f"truncated, or not begun and ended in the first column; {_READS}")
    for line, text in lines[1:-1]:
        code = _BLANKS.sub(r"\1", text.strip())
        switch = {f"set_standard_digital_out({output},{on})": on for on in (True, False)}.get(code)
        match = _MOVE.fullmatch(code) or _SLEEP.fullmatch(code)
        values = np.array(match.groups() if match else [np.inf], dtype=float)
        positive = values[JOINTS:] > 0.0 if len(values) > 1 else values >= 0.0
        if not text[0].isspace() or (switch is None and not (positive.all() and np.abs(values).max() <= LARGEST)):
            raise motions.error(line, f"{text.strip()[:SHOWN]!r} is not read here; remove or replace it: {_READS}")
        if switch is not None:
            motions.switch(line, switch, at_once=True)
        elif len(values) == 1:
            motions.pause(line, float(values[0]))
        else:
            end, (acceleration, speed) = values[:JOINTS], map(float, values[JOINTS:])
            leading = range(JOINTS) if motions.pose is None else [int(np.argmax(np.abs(end - motions.pose)))]
            motions.move(line, end, speed, linear=False, exact=True, law=(tuple(leading), acceleration))
    return motions.reading(len(lines))
