"""Lines and words of a program's text, and its axes, before any meaning."""

import math
import re
from collections.abc import Callable, Iterator
from typing import TypeVar

from cases.chain import Chain
from cases.errors import ProgramError

Found = TypeVar("Found")

_INK = re.compile(r"\S")


def program_lines(text: str, file: str, longest: int, most: float = math.inf) -> list[str]:
    """The lines of a program; only line feeds end one.

    Args:
        text: text of the program, one character a byte (latin-1), so that columns are right whatever the encoding
            really is.
        longest: most characters that the controller takes in a line.
        most: most lines with content that its memory holds.

    Raises:
        ProgramError: a character that is not plain ASCII, a line too long, too many lines; with line and column.
    """
    lines = text.replace("\r\n", "\n").split("\n")
    count = 0
    for number, line in enumerate(lines, start=1):
        if not line.isascii() or not line.replace("\t", " ").isprintable():
            column = next(k for k, c in enumerate(line) if c != "\t" and not " " <= c <= "~")
            raise ProgramError(
                file, number, column + 1, f"character {line[column]!r} is not plain ASCII; remove or replace it"
            )
        if len(line) > longest:
            raise ProgramError(file, number, 0, f"{len(line)} characters, the controller takes {longest}; split it")
        count += bool(line.strip())
        if count > most:
            raise ProgramError(
                file,
                number,
                0,
                f"more than {most} blocks, which is what the controller's memory holds (most_blocks); make the program "
                "shorter, its timed blocks longer, or the memory larger",
            )
    return lines


def each_word(
    text: str,
    position: int,
    pattern: re.Pattern[str],
    found: Callable[[re.Match[str], int], Found],
    unreadable: Callable[[int, str], ProgramError],
) -> Iterator[Found]:
    """What stands in a line from a position on, word by word.

    Args:
        unreadable: makes an error of the column and the first characters of what is not a word.

    Raises:
        ProgramError: something is not a word.
    """
    while (ink := _INK.search(text, position)) is not None:
        match = pattern.match(text, position)
        if match is None:
            raise unreadable(ink.start() + 1, text[ink.start() : ink.start() + 12].rstrip())
        yield found(match, ink.start() + 1)
        position = match.end()


def axis_letters(chain: Chain, controller: str, file: str, endless: bool = True) -> str:
    """The axis of each joint of a chain, which is the joint's name.

    Args:
        endless: whether its axes that turn without end count their turns.

    Raises:
        ProgramError: a joint whose name is not an axis of its kind, or whose turns the controller does not count.
    """
    for joint in chain.joints:
        letters = "ABC" if joint.turns else "XYZ"
        if joint.name not in tuple(letters):
            problem = f"joint {joint.name} {'turns' if joint.turns else 'slides'} and is not an axis of {controller}"
            remedy = (
                f"name it {', '.join(letters)} in machine.chain, or write with --dialect urscript, ros2 or setpoints"
            )
            raise ProgramError(file, 0, 0, f"{problem}; {remedy}")
        if joint.kind == "continuous" and not endless:
            problem = (
                f"joint {joint.name} turns without end: as a modulo axis it would not count its turns on {controller}"
            )
            remedy = 'set the axis up without modulo, and state it as kind = "revolute" with position_deg'
            raise ProgramError(file, 0, 0, f"{problem}; {remedy}")
    return "".join(chain.names)
