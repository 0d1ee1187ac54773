"""The one family of errors that hexcite raises on purpose: one line with place, value, limit and remedy."""

import difflib
import re
from collections.abc import Iterable, Mapping, Sequence
from copy import copy
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import Any, NamedTuple, Self

from cases.base.phrases import Phrase, again, enumerated, parts_of, phrase, said

ALSO = "; also: "  # between problems of one error
MOST_PROBLEMS = 50  # of one error; a file with more of them is of another kind, or damaged by a program


def first_problems(problems: Sequence[str]) -> tuple[Phrase, ...]:
    """The problems; of very many the first ones, and how many others there are.

    >>> first_problems(["a is wrong"] * 60)[-1]
    'has 11 more problems; correct these first'
    """
    others = len(problems) - MOST_PROBLEMS + 1
    if others <= 1:
        return tuple(map(said, problems))
    more = phrase("more_problems", "has {count} more problems; correct these first", count=others)
    return *map(said, problems[: MOST_PROBLEMS - 1]), more


class Write(NamedTuple):
    """A key of a case file with the value that it is to get."""

    place: tuple[str | int, ...]  # keys from the top of the file, and numbers from 0 in lists of tables
    value: Any  # as JSON has it; None: the key goes
    # standard deviation of a value that was estimated, or of its numbers in the same form; None where it was not
    deviation: Any = None


@dataclass(frozen=True, slots=True)
class Remedy:
    """Keys of a case that mend something.

    Args:
        words: what is wrong where they mend it, a clause.
        keys: what to write.
        phrase: entries of the words by their code; None where they have none.
    """

    words: str
    keys: tuple[Write, ...]
    phrase: Mapping[str, Any] | None = None

    def __post_init__(self) -> None:
        """Keeps the code of the words."""
        if isinstance(self.words, Phrase) and self.phrase is None:
            object.__setattr__(self, "phrase", self.words.to_json(printable))

    def to_json(self) -> dict[str, Any]:
        """Entries for programs."""
        entries: dict[str, Any] = {
            "words": self.words,
            "keys": [[list(write.place), write.value] for write in self.keys],
            "deviations": [write.deviation for write in self.keys],
        }
        return entries if self.phrase is None else entries | {"phrase": dict(self.phrase)}


class Code(StrEnum):
    """Kind of an error, for programs: what is wrong, whatever words say it."""

    MISSING = "missing"  # something that is needed is not stated, or not in the file
    UNKNOWN = "unknown"  # a name that nothing has
    WRONG_KIND = "wrong_kind"  # a value, text or file of another kind than is expected
    OUT_OF_RANGE = "out_of_range"
    CONTRADICTION = "contradiction"  # two statements that exclude each other, or one that is given twice
    UNIT = "unit"  # units, scales and orders of angles
    CLOCK = "clock"  # time stamps, rates and clocks that differ
    TRIGGER = "trigger"
    EXISTS = "exists"  # something stands there that would be replaced
    NOT_WRITABLE = "not_writable"
    UNREADABLE = "unreadable"  # the system or the encoding forbids to read it
    DAMAGED = "damaged"  # cut off, not complete, or not what its format says
    CHANGED = "changed"  # changed by hand since it was written
    STALE = "stale"  # its case has changed since
    VERSION = "version"  # of another version of the format
    OTHER_SOURCE = "other_source"  # of another machine, case, recording or result
    SYNTAX = "syntax"  # a program that cannot be read
    NOT_PROVEN = "not_proven"
    INFEASIBLE = "infeasible"  # no motion or pose inside the limits
    NO_EXCITATION = "no_excitation"  # the data do not determine the parameters
    TOO_FEW = "too_few"  # samples, poses or standstills
    NO_CONVERGENCE = "no_convergence"
    MISFIT = "misfit"  # data that the model cannot have produced
    NOT_SUPPORTED = "not_supported"  # what a machine, controller or format cannot do
    NOT_INSTALLED = "not_installed"
    RUN_FAILED = "run_failed"  # a controller, worker or other program failed
    INTERNAL = "internal"  # a bug of ours; report it


class Said(NamedTuple):
    """The parts of an error's message, with names of options as `option` writes them."""

    place: str
    problem: str
    remedy: str


class HexciteError(Exception):
    """Root of all errors that a user can cause and mend: `PLACE: PROBLEM; REMEDY` in one line.

    >>> try:
    ...     hx.load_case("hexapud")
    ... except hx.HexciteError as error:
    ...     print(error.code, error.place, error.problem, sep=" | ")
    unknown | hexapud | no such case

    Args:
        place: file with line, key or column, or an option; empty where there is none.
        problem: which value is wrong there, and its limit.
        remedy: what the reader can do; names of options are written by `option`.
        quantity: key of the case, or parameter, that the value is of; empty where it has none.
        code: kind of the error.
    """

    doubtful: bool = False
    """Whether its cause may be that data were read as they are not meant, or a case that is not the machine's."""
    remedies: tuple[Remedy, ...] = ()
    """Keys of the case that would mend it, each remedy tried before it is named; empty where no key does."""

    def __init__(
        self, *, problem: object, code: Code, place: object = "", remedy: str = "", quantity: str = ""
    ) -> None:
        message = f"{problem}; {remedy}" if remedy else str(problem)
        super().__init__(f"{place}: {message}" if str(place) else message)
        self.said = Said(str(place), problem if isinstance(problem, Phrase) else str(problem), remedy)
        self.quantity, self.code = quantity, code

    @property
    def place(self) -> str:
        """Where it is, in words of the library."""
        return in_python(self.said.place)

    @property
    def problem(self) -> str:
        """What is wrong there, in words of the library."""
        return in_python(self.said.problem)

    @property
    def remedy(self) -> str:
        """What the reader can do, in words of the library; empty where nothing is named."""
        return in_python(self.said.remedy)

    @property
    def message(self) -> str:
        """The whole message, to be part of another error's, in which options are still to be named."""
        return str(self.args[0])

    def at(self, source: str) -> Self:
        """The same error with its file in front, which the mathematics does not know."""
        error = copy(self)
        if source not in str(self):
            error.args = (f"{source}: {self.args[0]}",)
            place = f"{source}: {self.said.place}" if self.said.place else source
            error.said = self.said._replace(place=place)
        return error

    def beside(self, doubts: Iterable[str]) -> Self:
        """The same error with what else is doubtful, which may be its cause, behind it."""
        error = copy(self)
        sentences = tuple(doubts)
        error.args = (ALSO.join([self.args[0], *sentences]),)
        error.said = self.said._replace(remedy=enumerated("problems", [self.said.remedy, *sentences]))
        return error

    def without(self, code: str) -> Self:
        """The same error without the remedy of this code, where it names several: of a reader who has no such way.

        >>> remedies = ["identify again", phrase(AT_OWN_RISK, "go on at your own risk")]
        >>> error = HexciteError(problem="is old", remedy=enumerated("comma_or", remedies), code=Code.STALE)
        >>> print(error.without(AT_OWN_RISK))
        is old; identify again
        """
        others = [each for each in parts_of(said(self.said.remedy), "comma_or") if each.code != code]
        error = copy(self)
        error.said = self.said._replace(remedy=enumerated("comma_or", others))
        error.args = (whole_sentence(said(self.said.problem), self.said.place, error.said.remedy),)
        return error

    def in_doubt(self) -> Self:
        """The same error, of which the cause is to be looked for."""
        self.doubtful = True
        return self

    def __str__(self) -> str:
        """One printable line, whatever names and values it quotes; options are named as arguments of the library."""
        return _shown(in_python(super().__str__()))

    @property
    def typed(self) -> str:
        """The same line with options as they are typed on the command line."""
        return _shown(as_typed(super().__str__()))

    def to_json(self) -> dict[str, Any]:
        """Its parts for programs, with options as they are typed on the command line."""
        said = self.said._asdict()
        parts: dict[str, Any] = {key: printable(as_typed(text)) for key, text in said.items()}
        phrases = {
            key: text.to_json(lambda part: printable(as_typed(part)))
            for key, text in said.items()
            if isinstance(text, Phrase)
        }
        entries = {"code": str(self.code), **parts, "quantity": self.quantity}
        return entries | ({"phrases": phrases} if phrases else {})

    @property
    def lines(self) -> tuple[str, ...]:
        """Its printable lines, one for each thing that is wrong, each with its place."""
        return (self.typed,)

    @property
    def sentences(self) -> tuple[Phrase, ...]:
        """The same lines with their codes, for other languages."""
        return (_typed(whole_sentence(said(self.said.problem), self.said.place, self.said.remedy)),)

    def __reduce__(self) -> tuple[Any, ...]:
        """Its class and its parts, for copies and on its way out of a worker process."""
        return type(self).__new__, (type(self),), vars(self) | {"args": self.args}


def whole_sentence(problem: Phrase, place: str, remedy: str = "") -> Phrase:
    """A sentence with its place and its remedy, where it has them."""
    if remedy:
        problem = phrase("with_remedy", "{problem}; {remedy}", problem=problem, remedy=said(remedy))
    return phrase("at_place", "{place}: {problem}", place=place, problem=problem) if place else problem


AT_PLACE = "at_place"
"""Code of a sentence with its place."""
AT_OWN_RISK = "at_own_risk"
"""Code of a remedy that goes on although something speaks against it."""


def _typed(sentence: Phrase) -> Phrase:
    """A sentence with options as they are typed on the command line."""
    return again(_shown(as_typed(sentence)), sentence.to_json(lambda part: printable(as_typed(part))))


_SHOWN = 200  # characters at either end of a word that is shown in part
_LONG = re.compile(r"\S{1000,}")
"""A word that no reader wants whole, such as a number of a million digits."""


def _shown(text: str) -> str:
    return _LONG.sub(lambda word: f"{word[0][:_SHOWN]}..{word[0][-_SHOWN:]}", printable(text))


# Noncharacters of Unicode, which no text may hold, around the name of an option and around words of the command line.
_OPTION = re.compile("\ufdd0([^\ufdd0-\ufdd4]*)\ufdd4([^\ufdd0-\ufdd4]*)\ufdd1")
_TYPED_ONLY = re.compile("\ufdd2([^\ufdd0-\ufdd4]*)\ufdd3")


def option(name: str, typed: str = "") -> str:
    """The name of an option in the text of an error: `--time-limit` on the command line, `time_limit` in Python.

    Args:
        name: of the argument in Python.
        typed: name on the command line, without dashes, where that is another.
    """
    return f"\ufdd0{name}\ufdd4{typed or name.replace('_', '-')}\ufdd1"


WITH_OUTPUT = "\ufdd2 with -o\ufdd3"
"""How another place is named, said on the command line only."""


def as_typed(text: str) -> str:
    """A text with options as they are typed on the command line."""
    return _TYPED_ONLY.sub(r"\1", _OPTION.sub(r"--\2", text))


def in_python(text: str) -> str:
    """A text with options as arguments of the library."""
    return _TYPED_ONLY.sub("", _OPTION.sub(r"\1", text))


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

    def __init__(
        self,
        *,
        file: Path | str,
        problem: str,
        code: Code,
        key: str = "",
        remedy: str = "",
        problems: tuple[str, ...] = (),
    ) -> None:
        place = f"{file}: {key}" if key else file
        super().__init__(place=place, problem=problem, remedy=remedy, quantity=key, code=code)
        self.file, self.key, self.problems = file, key, problems

    @property
    def lines(self) -> tuple[str, ...]:
        """Its printable lines, one for each problem."""
        several = len(self.problems) > 1
        return tuple(_shown(as_typed(f"{self.file}: {p}")) for p in self.problems) if several else (self.typed,)

    @property
    def sentences(self) -> tuple[Phrase, ...]:
        """The same lines with their codes."""
        if len(self.problems) < 2:
            return super().sentences
        return tuple(_typed(whole_sentence(said(problem), str(self.file))) for problem in self.problems)

    def to_json(self) -> dict[str, Any]:
        """The same, with all problems, each a sentence."""
        return super().to_json() | {"problems": [printable(as_typed(problem)) for problem in self.problems]}


class RecordingError(HexciteError, ValueError):
    """A recording cannot be used; the message names file and row or column."""


class IdentificationError(HexciteError, ValueError):
    """The data do not determine the parameters that were asked for."""


class InfeasiblePlan(HexciteError, ValueError):
    """No motion inside the limits was found; the message says which limit stands in the way."""


class ProgramError(HexciteError, ValueError):
    """A CNC program cannot be read or is not proven inside the limits.

    Lines and columns are counted from 1; 0 means unknown.
    """

    def __init__(
        self, *, file: Path | str, problem: str, code: Code, line: int = 0, column: int = 0, remedy: str = ""
    ) -> None:
        self.file, self.line, self.column = file, line, column
        place = f"{file}, line {line}" if line else str(file)
        super().__init__(
            place=f"{place}, column {column}" if column else place, problem=problem, remedy=remedy, code=code
        )


class Violation(NamedTuple):
    """A limit that a program exceeds."""

    line: int  # of the program
    limit: str  # family of the limit
    sentence: str  # value, limit and time in words

    def to_json(self) -> dict[str, Any]:
        """Entries for programs."""
        entries = self._asdict()
        return entries | ({"phrase": self.sentence.to_json(printable)} if isinstance(self.sentence, Phrase) else {})


class NotProven(ProgramError):
    """A program exceeds limits; `violations` are all of them, the worst first."""

    def __init__(self, *, file: Path | str, violations: Sequence[Violation], remedy: str, listed: bool = False) -> None:
        worst, more = violations[0], len(violations) - 1
        advice = remedy
        if more and listed:
            advice = phrase("and_more_listed", "{remedy} ({more} more, as listed)", remedy=said(remedy), more=more)
        elif more:
            advice = phrase(
                "and_more",
                "{remedy} ({more} more: {all} shows them)",
                remedy=said(remedy),
                more=more,
                all=option("violations", "all"),
            )
        super().__init__(file=file, line=worst.line, problem=worst.sentence, remedy=advice, code=Code.NOT_PROVEN)
        self.violations = tuple(violations)
        self._advice = remedy

    def listed(self) -> "NotProven":
        """The same error where all violations are shown beside it."""
        return NotProven(file=self.file, violations=self.violations, remedy=self._advice, listed=True)


class FileProblem(HexciteError, OSError):
    """A file or folder cannot be read or written."""

    @classmethod
    def of(cls, error: OSError) -> HexciteError:
        """What the system says of a file, as such an error; one that is of hexcite already stays as it is."""
        if isinstance(error, HexciteError):
            return error
        place = "the system" if error.filename is None else str(error.filename)
        reason = error.strerror or str(error) or type(error).__name__
        return cls(
            place=place,
            problem=f"cannot be used ({reason})",
            remedy="name another file or place",
            code=Code.UNREADABLE,
        )


class Interrupted(BaseException):
    """Ctrl-C, with what the user reads; the command-line library has a word of its own for KeyboardInterrupt."""


UNTOUCHED = "interrupted; nothing was written"
"""What the command line says of a command that was interrupted before it wrote anything."""
