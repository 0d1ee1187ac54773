"""The one family of errors that hexcite raises on purpose: one line with place, value, limit and remedy."""

import difflib
import re
from collections.abc import Iterable, Sequence
from copy import copy
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple, Self

ALSO = "; also: "  # between problems of one error


class Write(NamedTuple):
    """A key of a case file with the value that it is to get."""

    place: tuple[str | int, ...]  # keys from the top of the file, and numbers from 0 in lists of tables
    value: Any  # as JSON has it; None: the key goes


@dataclass(frozen=True, slots=True)
class Remedy:
    """Keys of a case that mend something.

    Args:
        words: what is wrong where they mend it, a clause.
        keys: what to write.
    """

    words: str
    keys: tuple[Write, ...]

    def to_json(self) -> dict[str, Any]:
        """Entries for programs."""
        return {"words": self.words, "keys": [[list(write.place), write.value] for write in self.keys]}


class HexciteError(Exception):
    """Root of all errors that a user can cause and mend: `PLACE: PROBLEM; REMEDY` in one line.

    Args:
        place: file with line, key or column, or an option; where nothing else is given, the whole message.
        problem: which value is wrong there, and its limit; without `remedy` it ends in one, after a semicolon.
        remedy: what the reader can do.
    """

    quantity: str = ""
    """Key of the case, or parameter, that the value is of; empty where it has none."""
    doubtful: bool = False
    """Whether its cause may be that data were read as they are not meant, or a case that is not the machine's."""
    remedies: tuple[Remedy, ...] = ()
    """Keys of the case that would mend it, each remedy tried before it is named; empty where no key does."""

    def __init__(self, place: object, problem: str = "", remedy: str = "") -> None:
        self.place, self.problem = (str(place), problem) if problem else ("", str(place))
        self.remedy = remedy or self.problem.rpartition("; ")[2] * ("; " in self.problem)
        message = f"{self.problem}; {remedy}" if remedy else self.problem
        super().__init__(f"{self.place}: {message}" if self.place else message)
        self.problem, self.remedy = _of_arguments(self.problem), _of_arguments(self.remedy)
        if self.place.startswith("--"):  # an option; the name of a file is nobody's to change, whatever it holds
            self.place = _of_arguments(self.place)

    def at(self, source: str) -> Self:
        """The same error with its file in front, which the mathematics does not know."""
        error = copy(self)
        if source not in str(self):
            error.args = (f"{source}: {self.args[0]}",)
            error.place = f"{source}: {self.place}" if self.place else source
        return error

    def beside(self, doubts: Iterable[str]) -> Self:
        """The same error with what else is doubtful, which may be its cause, behind it."""
        error = copy(self)
        said = tuple(doubts)
        error.args, error.remedy = (ALSO.join([self.args[0], *said]),), ALSO.join([self.remedy, *said])
        return error

    def in_doubt(self) -> Self:
        """The same error, of which the cause is to be looked for."""
        self.doubtful = True
        return self

    def __str__(self) -> str:
        """One printable line, whatever names and values it quotes; options are named as arguments of the library."""
        line, place = self.typed, printable(self.place)
        kept = len(place) if line.startswith(place) else 0
        return line[:kept] + _of_arguments(line[kept:])

    @property
    def typed(self) -> str:
        """The same line with options as they are typed on the command line."""
        return _LONG.sub(lambda word: f"{word[0][:_SHOWN]}..{word[0][-_SHOWN:]}", printable(super().__str__()))

    @property
    def lines(self) -> tuple[str, ...]:
        """Its printable lines, one for each thing that is wrong, each with its place."""
        return (self.typed,)

    def __reduce__(self) -> tuple[Any, ...]:
        """Its class and its parts, for copies and on its way out of a worker process."""
        return type(self).__new__, (type(self),), vars(self) | {"args": self.args}


_OPTION = re.compile(r"hexcite [a-z][^,;:)]*|(?<![\w-])--(?P<name>[a-z]+(-[a-z]+)*)| with -o\b")
"""A command of ours, which stays, or an option."""


_SHOWN = 200  # characters at either end of a word that is shown in part
_LONG = re.compile(r"\S{1000,}")
"""A word that no reader wants whole, such as a number of a million digits."""


def _of_arguments(text: str) -> str:
    """A text with options as arguments: time_limit for --time-limit."""
    return _OPTION.sub(lambda m: m[0] if m[0].startswith("hexcite") else (m["name"] or "").replace("-", "_"), text)


def choice(typed: str, known: Iterable[str], words: str = "choose") -> str:
    """The remedy for a name that is not known: the nearest one, where one is near, and all."""
    names = [*known]
    folded = {name.lower(): name for name in names}
    near = difflib.get_close_matches(typed.lower(), folded, n=1)
    return f"did you mean {folded[near[0]]}? {words} {', '.join(names)}" if near else f"{words} {', '.join(names)}"


def printable(text: str) -> str:
    """A text in one line, with control characters, line breaks and other marks that no paper shows as escapes."""
    return "".join(c if c.isprintable() else repr(c)[1:-1] for c in text)


_CONTROLS = re.compile(
    "[\\x00-\\x08\\x0b-\\x1f\\x7f-\\x9f\\u200e\\u200f\\u2028-\\u202e\\u2066-\\u2069\\ufeff\\ud800-\\udfff]"
)
"""Characters that steer a terminal or a browser, or turn the order of letters; none of them is shown."""


def legible(text: str) -> str:
    """A text of any number of lines with such characters as escapes, whatever names of files or channels it holds."""
    return _CONTROLS.sub(lambda character: repr(character[0])[1:-1], text)


class CaseError(HexciteError, ValueError):
    """A case file does not describe a usable machine; `problems` are all that were found, each with its dotted key."""

    def __init__(self, file: Path | str, key: str, problem: str, problems: tuple[str, ...] = ()) -> None:
        super().__init__(f"{file}: {key}" if key else file, problem)
        self.file, self.key, self.quantity, self.problems = file, key, key, problems

    @property
    def lines(self) -> tuple[str, ...]:
        """Its printable lines, one for each problem."""
        several = len(self.problems) > 1
        return tuple(printable(f"{self.file}: {p}") for p in self.problems) if several else (self.typed,)


class RecordingError(HexciteError, ValueError):
    """A recording cannot be used; the message names file and row or column."""


class IdentificationError(HexciteError, ValueError):
    """The data do not determine the parameters that were asked for."""


class InfeasiblePlan(HexciteError, ValueError):
    """No motion inside the limits was found; the message says which limit stands in the way."""


class ProgramError(HexciteError, ValueError):
    """A CNC program cannot be read or is not proven inside the limits; line and column count from 1, 0: no one."""

    def __init__(self, file: Path | str, line: int, column: int, problem: str) -> None:
        self.file, self.line, self.column = file, line, column
        place = f"{file}, line {line}" if line else str(file)
        super().__init__(f"{place}, column {column}" if column else place, problem)


class Violation(NamedTuple):
    """A limit that a program exceeds."""

    line: int  # of the program
    limit: str  # family of the limit
    sentence: str  # value, limit and time in words


class NotProven(ProgramError):
    """A program exceeds limits; `violations` are all of them, the worst first."""

    def __init__(self, file: Path | str, violations: Sequence[Violation], remedy: str) -> None:
        worst, more = violations[0], len(violations) - 1
        others = f" ({more} more: --all of post and check shows them)" if more else ""
        super().__init__(file, worst.line, 0, f"{worst.sentence}; {remedy}{others}")
        self.violations = tuple(violations)


class FileProblem(HexciteError, OSError):
    """A file or folder cannot be read or written."""

    @classmethod
    def of(cls, error: OSError) -> HexciteError:
        """What the system says of a file, as such an error; one that is of hexcite already stays as it is."""
        if isinstance(error, HexciteError):
            return error
        place = "the system" if error.filename is None else str(error.filename)
        reason = error.strerror or str(error) or type(error).__name__
        return cls(place, f"cannot be used ({reason})", "name another file or place")


class Interrupted(BaseException):
    """Ctrl-C, with what the user reads; the command-line library has a word of its own for KeyboardInterrupt."""
