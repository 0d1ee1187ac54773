"""Reads URScript programs: the statements that an excitation needs, and an error for all else.

Meanings follow Universal Robots' script manual: `a` and `v` of `movej` are those of the leading joint, a time overrides
both, a blend radius of 0 stops at the point; outputs switch when the statement before has ended.
"""

import re

import numpy as np

from cases.controller import UrScript
from cases.errors import ProgramError
from cases.schema import Case
from postprocessors.reading import NUMBER, Grouping, Reading, program_lines

JOINTS = 6
LARGEST = 1e4  # rad, rad/s, rad/s^2, s: no robot has such numbers
LONGEST_LINE = 4096
_BEGIN = re.compile(r"def ([A-Za-z]\w*)\(\):\s*$")
_CALL = re.compile(r"(\w+)\((.*)\)\s*$")
_NUMBER = re.compile(rf"{NUMBER}(?:[eE][+-]?\d+)?")
_PARTS = re.compile(r"\s*(?:(\w+)\s*=\s*)?(\[[^\[\]]*\]|[^,\[\]=]+?)\s*(?:,|$)")
_REMEDY = {
    "servoj": "a loop of its own that lags behind and cannot be proven; use movej with a, v and r=0",
    "movel": "straight in space, which this chain's joints are not planned for; use movej",
    "movep": "blended; use movej with a, v and r=0",
    "speedj": "without an end that is known; use movej with a, v and r=0",
}


# statement -> names of its arguments in their order
_ARGUMENTS = {"movej": ("q", "a", "v", "t", "r"), "sleep": ("t",), "set_standard_digital_out": ("n", "b")}

Place = tuple[str, int, int]
"""File, line and column, for messages."""


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
        place = file, line, 0
        if ended:
            raise ProgramError(*place, "a statement after the end of the program; `end` must be last")
        if blocks == 1:
            if not _BEGIN.match(code):
                raise ProgramError(*place, "the program does not begin with `def NAME():` in the first column; add it")
        elif code == "end":
            ended = True
        elif not code[0].isspace():
            raise ProgramError(*place, "a statement in the first column, where the program ends; indent it")
        else:
            _statement(code, place, settings, motions)
    if not ended:
        raise ProgramError(file, 0, 0, "no `end` in the first column; the file is truncated or not URScript")
    return motions.reading(blocks)


def _statement(code: str, place: Place, settings: UrScript, motions: Grouping) -> None:
    """Executes an indented statement."""
    file, line, _ = place
    start = file, line, len(code) - len(code.lstrip()) + 1
    call = _CALL.match(code.strip())
    if call is None:
        raise ProgramError(*start, f"{code.strip()[:24]!r} is not a statement of an excitation; remove it")
    name = call[1]
    if name not in _ARGUMENTS:
        raise ProgramError(*start, f"{name} is {_REMEDY.get(name, 'not a statement of an excitation; remove it')}")
    arguments = _named(name, call[2], start)
    match name:
        case "movej":
            _movej(arguments, place, motions)
        case "sleep":
            duration = _number(arguments.get("t"), "the time of sleep", place)
            if duration < 0.0:
                raise ProgramError(*place, "sleep needs a time in seconds that is not negative; correct it")
            motions.pause(line, duration)
        case _:
            output, word = arguments.get("n"), arguments.get("b")
            if output != str(settings.trigger_output):
                own = f"{settings.trigger_output} (controller.urscript.trigger_output)"
                raise ProgramError(*place, f"output {output} is not the trigger's, {own}")
            if word not in ("True", "False"):
                raise ProgramError(*place, f"an output is True or False, not {word}; correct it")
            motions.switch(line, word == "True", at_once=True)


def _named(call: str, text: str, place: Place) -> dict[str, str]:
    """Arguments by name; those without a name are first, in their order."""
    names, values, position = _ARGUMENTS[call], dict[str, str](), 0
    while position < len(text):
        part = _PARTS.match(text, position)
        if part is None or (text[part.end() - 1] == "," and not text[part.end() :].strip()):
            problem = f"cannot read the arguments of {call} from {text[position : position + 20]!r} on"
            raise ProgramError(*place, problem)
        name = part[1] or (names[len(values)] if len(values) < len(names) else "")
        if name not in names or name in values:
            problem = f"{call} has no argument {name or part[2]!r} here; it has {', '.join(names)}"
            raise ProgramError(*place, problem)
        values[name] = part[2].strip()
        position = part.end()
    return values


def _number(word: str | None, of: str, place: Place) -> float:
    if word is None:
        raise ProgramError(*place, f"{of} is not stated, and the robot's own value is not known; state it")
    if not _NUMBER.fullmatch(word) or abs(float(word)) > LARGEST:
        raise ProgramError(*place, f"{of} = {word} is not a plain number below {LARGEST:g}; correct it")
    return float(word)


def _movej(arguments: dict[str, str], place: Place, motions: Grouping) -> None:
    words = arguments.get("q", "")
    if not words.startswith("["):
        problem = "movej needs joint positions [q1, .., q6] in radians; a pose p[..] leaves the joints open"
        raise ProgramError(*place, problem)
    joints = enumerate(words[1:-1].split(","), 1)
    end = np.array([_number(word.strip(), f"joint {k}", place) for k, word in joints])
    if len(end) != JOINTS:
        raise ProgramError(*place, f"movej has {len(end)} joints, the robot has {JOINTS}")
    if _number(arguments.get("t", "0"), "t", place) != 0.0:
        problem = "movej with a time t, which outranks a and v and whose ramps are not known; leave t out"
        raise ProgramError(*place, problem)
    if _number(arguments.get("r", "0"), "r", place) != 0.0:
        raise ProgramError(*place, "movej with a blend radius r: moves that overlap are skipped; write r=0")
    acceleration, speed = (_number(arguments.get(key), f"{key} of movej", place) for key in ("a", "v"))
    if not (acceleration > 0.0 and speed > 0.0):
        raise ProgramError(*place, "movej needs a and v above 0; correct them")
    leading = range(JOINTS) if motions.pose is None else [int(np.argmax(np.abs(end - motions.pose)))]
    motions.move(place[1], end, speed, linear=False, exact=True, law=(tuple(leading), acceleration))
