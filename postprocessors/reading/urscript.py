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
_BEGIN = re.compile(r"def ([A-Za-z]\w*)\(\):\s*$")
_BLANKS = re.compile(r"\s*([\[\](),=])\s*")
# statement -> its form for people, and without blanks
_FORMS = {
    "movej": (
        "movej([q1, .., q6], a=.., v=.., r=0) with plain numbers: a time t would outrank a and v, blends skip moves",
        re.compile(rf"movej\(\[{','.join([FLOAT] * JOINTS)}\],a={FLOAT},v={FLOAT}(?:,r=0)?\)"),
    ),
    "sleep": ("sleep(seconds)", re.compile(rf"sleep\({FLOAT}\)")),
    "set_standard_digital_out": (
        "set_standard_digital_out(n, True) or (n, False)",
        re.compile(r"set_standard_digital_out\((\d+),(True|False)\)"),
    ),
}
_REMEDY = {
    "servoj": "a loop of its own that lags behind and cannot be proven; use movej",
    "movel": "straight in space, which this chain's joints are not planned for; use movej",
}


def read_urscript(content: bytes, file: str, case: Case) -> Reading:
    """Reads a program, see `Dialect.read`."""
    settings = case.need_settings(UrScript, "a URScript program")
    chain, limits = case.need_chain("a URScript program")
    if len(chain.joints) != JOINTS or not limits.turns.all():
        problem = f"URScript moves {JOINTS} joints that turn; case {case.name} has others, choose another dialect"
        raise ProgramError(file, 0, 0, problem)
    motions, blocks, ended = Grouping(file), 0, False
    for line, text in enumerate(program_lines(content, file, LONGEST_LINE), start=1):
        code = text.split("#", 1)[0].rstrip()
        if not code:
            continue
        blocks += 1
        if ended:
            raise motions.error(line, "a statement after the end of the program; `end` must be last")
        if blocks == 1:
            if not _BEGIN.match(code):
                problem = "the program does not begin with `def NAME():` in the first column; add it"
                raise motions.error(line, problem)
        elif code == "end":
            ended = True
        elif not code[0].isspace():
            raise motions.error(line, "a statement in the first column, where the program ends; indent it")
        else:
            _statement(_BLANKS.sub(r"\1", code.strip()), line, settings.trigger_output, motions)
    if not ended:
        raise ProgramError(file, 0, 0, "no `end` in the first column; the file is truncated or not URScript")
    return motions.reading(blocks)


def _statement(code: str, line: int, output: int, motions: Grouping) -> None:
    """Executes a statement without blanks around brackets, commas and equals signs."""
    name = code.partition("(")[0]
    if name not in _FORMS:
        reason = _REMEDY.get(name, "not a statement of an excitation; remove it")
        raise motions.error(line, f"{name[:24]} is {reason}")
    form, pattern = _FORMS[name]
    if (match := pattern.fullmatch(code)) is None:
        raise motions.error(line, f"cannot read this {name}; write {form}")
    if name == "set_standard_digital_out":
        if int(match[1]) != output:
            problem = f"output {match[1]} is not the trigger's, {output} (controller.urscript.trigger_output)"
            raise motions.error(line, problem)
        motions.switch(line, match[2] == "True", at_once=True)
        return
    values = np.array(match.groups(), dtype=float)
    if np.abs(values).max() > LARGEST or (values[JOINTS:] <= 0.0).any() or (name == "sleep" and values[0] < 0.0):
        problem = f"a number of this {name} is not below {LARGEST:g}, or a, v or a time is not positive; correct it"
        raise motions.error(line, problem)
    if name == "sleep":
        motions.pause(line, float(values[0]))
        return
    end, (acceleration, speed) = values[:JOINTS], map(float, values[JOINTS:])
    leading = range(JOINTS) if motions.pose is None else [int(np.argmax(np.abs(end - motions.pose)))]
    motions.move(line, end, speed, linear=False, exact=True, law=(tuple(leading), acceleration))
