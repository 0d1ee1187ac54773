"""A program file as lines of plain ASCII that its controller can take, and a line as words."""

import math
import re
from collections.abc import Callable, Iterator
from typing import TypeVar

from cases.errors import ProgramError

Found = TypeVar("Found")

_INK = re.compile(r"\S")


def program_lines(text: str, file: str, longest: int, most: float = math.inf) -> list[str]:
    """The lines of a program; only line feeds end one.

    Args:
        text: of the program, one character a byte (latin-1), so that columns are right whatever the encoding really is.
        file: its name, for messages.
        longest: most characters that the controller takes in a line.
        most: most lines with content that its memory holds.

    Raises:
        ProgramError: a character that is no plain ASCII, a line too long, too many lines; with line and column.
    """
    lines = text.replace("\r\n", "\n").split("\n")
    used = 0
    for number, line in enumerate(lines, start=1):
        if not line.isascii() or not line.replace("\t", " ").isprintable():
            column = next(k for k, c in enumerate(line) if c != "\t" and not " " <= c <= "~")
            raise ProgramError(
                file, number, column + 1, f"character {line[column]!r} is not plain ASCII; remove or replace it"
            )
        if len(line) > longest:
            raise ProgramError(file, number, 0, f"{len(line)} characters, the controller takes {longest}; split it")
        used += bool(line.strip())
        if used > most:
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
        text: of the line.
        position: where to begin.
        pattern: of a word with blanks before it.
        found: makes something of a match and its column.
        unreadable: makes an error of the column and the first characters of what is no word.

    Raises:
        ProgramError: something is no word.
    """
    while (ink := _INK.search(text, position)) is not None:
        match = pattern.match(text, position)
        if match is None:
            raise unreadable(ink.start() + 1, text[ink.start() : ink.start() + 12].rstrip())
        yield found(match, ink.start() + 1)
        position = match.end()
