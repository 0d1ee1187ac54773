"""Reads URScript programs: the statements that an excitation needs, and an error for all else.

Meanings follow Universal Robots' script manual: `a` and `v` of `movej` are those of the leading joint, a time overrides
both, a blend radius of 0 stops at the point; outputs switch when the statement before has ended.
"""

import math
import re
from collections.abc import Callable
from typing import NoReturn

import numpy as np

from cases.controller import UrScript
from cases.errors import ProgramError
from cases.schema import Case
from postprocessors.reading import Grouping, Reading, program_lines

JOINTS = 6
LARGEST = 1e4  # rad, rad/s, rad/s^2, s: no robot has such numbers
LONGEST_LINE = 4096
_BEGIN = re.compile(r"def ([A-Za-z]\w*)\(\):\s*$")
_CALL = re.compile(r"(\w+)\((.*)\)\s*$")
_NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?")
_PARTS = re.compile(r"\s*(?:(\w+)\s*=\s*)?(\[[^\[\]]*\]|[^,\[\]=]+?)\s*(?:,|$)")
_REMEDY = {
    "servoj": "a loop of its own that lags behind and cannot be proven; use movej with a, v and r=0",
    "movel": "straight in space, which this chain's joints are not planned for; use movej",
    "movep": "blended; use movej with a, v and r=0",
    "speedj": "without an end that is known; use movej with a, v and r=0",
}


def read_urscript(content: bytes, file: str, case: Case) -> Reading:
    """Reads a program, see `Language.read`."""
    settings = case.need_settings(UrScript, "a URScript program")
    chain, limits = case.need_chain("a URScript program")
    if len(chain.joints) != JOINTS or not limits.turns.all():
        problem = f"URScript moves {JOINTS} joints that turn; case {case.name} has others, choose another dialect"
        raise ProgramError(file, 0, 0, problem)
    return _Interpreter(file, settings).read(program_lines(content, file, LONGEST_LINE))


class _Interpreter:
    def __init__(self, file: str, settings: UrScript) -> None:
        self.file, self.settings = file, settings
        self.line, self.blocks = 0, 0
        self.begun = self.ended = False
        self.pose: np.ndarray | None = None
        self.motions = Grouping(file)
        # statement -> what it does, and the names of its arguments in their order
        self.statements: dict[str, tuple[Callable[[dict[str, str]], None], tuple[str, ...]]] = {
            "movej": (self._movej, ("q", "a", "v", "t", "r")),
            "sleep": (self._sleep, ("t",)),
            "set_standard_digital_out": (self._output, ("n", "b")),
        }

    def fail(self, problem: str, column: int = 0) -> NoReturn:
        raise ProgramError(self.file, self.line, column, problem)

    def read(self, lines: list[str]) -> Reading:
        for self.line, text in enumerate(lines, start=1):
            code = text.split("#", 1)[0].rstrip()
            if code.strip():
                self.blocks += 1
                self._line(code)
        if not self.ended:
            raise ProgramError(self.file, 0, 0, "no `end` in the first column; the file is truncated or not URScript")
        return self.motions.reading(self.blocks)

    def _line(self, code: str) -> None:
        if self.ended:
            self.fail("a statement after the end of the program; `end` must be last")
        if not self.begun:
            if not _BEGIN.match(code):
                self.fail("the program does not begin with `def NAME():` in the first column; add it")
            self.begun = True
        elif code == "end":
            self.ended = True
        elif not code[0].isspace():
            self.fail("a statement in the first column, where the program ends; indent it")
        else:
            self._statement(code.strip(), len(code) - len(code.lstrip()) + 1)

    def _statement(self, code: str, column: int) -> None:
        call = _CALL.match(code)
        if call is None:
            self.fail(f"{code[:24]!r} is not a statement of an excitation; remove it", column)
        name = call[1]
        if name not in self.statements:
            self.fail(f"{name} is {_REMEDY.get(name, 'not a statement of an excitation; remove it')}", column)
        execute, names = self.statements[name]
        execute(self._named(name, names, call[2], column))

    def _named(self, call: str, names: tuple[str, ...], text: str, column: int) -> dict[str, str]:
        """Arguments by name; those without a name are first, in their order."""
        values, position = dict[str, str](), 0
        while position < len(text):
            part = _PARTS.match(text, position)
            if part is None or (text[part.end() - 1] == "," and not text[part.end() :].strip()):
                self.fail(f"cannot read the arguments of {call} from {text[position : position + 20]!r} on", column)
            name = part[1] or (names[len(values)] if len(values) < len(names) else "")
            if name not in names or name in values:
                self.fail(f"{call} has no argument {name or part[2]!r} here; it has {', '.join(names)}", column)
            values[name] = part[2].strip()
            position = part.end()
        return values

    def _number(self, word: str | None, of: str) -> float:
        if word is None:
            self.fail(f"{of} is not stated, and the robot's own value is not known; state it")
        if not _NUMBER.fullmatch(word) or abs(float(word)) > LARGEST:
            self.fail(f"{of} = {word} is not a plain number below {LARGEST:g}; correct it")
        return float(word)

    def _movej(self, arguments: dict[str, str]) -> None:
        words = arguments.get("q", "")
        if not words.startswith("["):
            self.fail("movej needs joint positions [q1, .., q6] in radians; a pose p[..] leaves the joints open")
        end = np.array([self._number(word.strip(), f"joint {k}") for k, word in enumerate(words[1:-1].split(","), 1)])
        if len(end) != JOINTS:
            self.fail(f"movej has {len(end)} joints, the robot has {JOINTS}")
        if "t" in arguments and self._number(arguments["t"], "t") != 0.0:
            self.fail("movej with a time t, which outranks a and v and whose ramps are not known; leave t out")
        if self._number(arguments.get("r", "0"), "r") != 0.0:
            self.fail("movej with a blend radius r: moves that overlap are skipped; write r=0")
        acceleration, speed = (self._number(arguments.get(key), f"{key} of movej") for key in ("a", "v"))
        if not (acceleration > 0.0 and speed > 0.0):
            self.fail("movej needs a and v above 0; correct them")
        leading = range(JOINTS) if self.pose is None else [int(np.argmax(np.abs(end - self.pose)))]
        self.pose = end
        self.motions.move(self.line, end, speed, linear=False, exact=True, law=(tuple(leading), acceleration))

    def _sleep(self, arguments: dict[str, str]) -> None:
        duration = self._number(arguments.get("t"), "the time of sleep")
        if not 0.0 <= duration < math.inf:
            self.fail("sleep needs a time in seconds that is not negative; correct it")
        self.motions.pause(self.line, duration)

    def _output(self, arguments: dict[str, str]) -> None:
        output = self.settings.trigger_output
        if arguments.get("n") != str(output):
            self.fail(
                f"output {arguments.get('n')} is not the trigger's, {output} (controller.urscript.trigger_output)"
            )
        if arguments.get("b") not in ("True", "False"):
            self.fail(f"an output is True or False, not {arguments.get('b')}; correct it")
        self.motions.switch(self.line, arguments["b"] == "True", at_once=True)
