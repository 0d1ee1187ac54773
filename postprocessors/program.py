"""Programs and the languages of controllers: functions that write and read them, and the controllers' guarantees."""

import re
from collections import Counter
from collections.abc import Collection
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

from cases.base.atomic import atomic_file
from cases.base.doors import checks
from cases.base.errors import Code, FileProblem, HexciteError, ProgramError, choice
from cases.base.file_reading import read_whole
from cases.base.output_places import check_file
from cases.base.units import as_html
from cases.controller import ControllerName
from cases.readiness import languages_of, require_machine
from cases.schema import Case
from identification.limits.limit import PLANNABLE_WITHOUT, LimitKind
from identification.texts import limit_lines
from postprocessors.dialects.dialect import Dialect
from postprocessors.dialects.joint_trajectory.dialect import JOINT_TRAJECTORY
from postprocessors.dialects.linuxcnc.dialect import LINUXCNC
from postprocessors.dialects.setpoints.dialect import SETPOINTS
from postprocessors.dialects.sinumerik.dialect import SINUMERIK
from postprocessors.dialects.twincat.dialect import TWINCAT
from postprocessors.dialects.urscript.dialect import URSCRIPT
from postprocessors.proof.guarantees import Guarantees
from postprocessors.proof.proof import ProgramProof, prove_program
from postprocessors.reading import Reading

DIALECTS: dict[str, Dialect] = {
    d.name: d for d in (LINUXCNC, SINUMERIK, TWINCAT, URSCRIPT, SETPOINTS, JOINT_TRAJECTORY)
}
"""In the order in which they are taken where none is named, if the case has their settings."""


def dialect(name: str) -> Dialect:
    """The dialect of a name; raises HexciteError, which lists the known ones, where there is none."""
    if name not in DIALECTS:
        raise HexciteError(problem=f"dialect {name!r} is unknown", remedy=choice(name, DIALECTS), code=Code.UNKNOWN)
    return DIALECTS[name]


def dialect_of_file(file: str) -> Dialect:
    """The dialect of the suffix of a program's file; raises ProgramError where none has it."""
    for dialect in DIALECTS.values():
        if file.lower().endswith(dialect.suffixes):
            return dialect
    suffixes = ", ".join(s for d in DIALECTS.values() for s in d.suffixes)
    raise ProgramError(
        file=file, problem="the suffix names no controller", remedy=f"programs end in {suffixes}", code=Code.UNKNOWN
    )


@dataclass(frozen=True, eq=False, repr=False)
class Program:
    """A program and its reading; proof and run use this content and do not read the file again.

    >>> program = hx.read_program("run.mpf", hx.load_case("hexapod"))
    >>> program
    Program run.mpf for hexapod: sinumerik, ... blocks, 4.95 s
    limits: proven; SINUMERIK enforces: acceleration, jerk, strut acceleration
    """

    path: Path  # path of the file, or the name that it was written for
    dialect: Dialect  # its language
    content: bytes  # byte by byte
    reading: Reading  # its content as motions
    guarantees: Guarantees  # guarantees of the controller
    case: Case  # case that it is for
    remarks: tuple[str, ...] = ()  # remarks beside its proof
    proven: ProgramProof | None = None  # its proof, where it is known from its making

    @cached_property
    def proof(self) -> ProgramProof:
        """The proof of its limits; raises ProgramError where the motion is not defined."""
        return self.proven or prove_program(self.reading, self.guarantees)

    @property
    def text(self) -> str:
        """Its content as text."""
        return self.content.decode("utf-8", errors="replace")

    def save(self, file: Path | str, overwrite: bool = False) -> None:
        """Writes the program.

        Raises:
            FileProblem: the suffix is wrong, the file exists, or the place cannot be written.
        """
        path = Path(file)
        check_file(path, [self.path.suffix.lower()], overwrite=overwrite)
        with atomic_file(path) as part:
            part.write_bytes(self.content)

    @classmethod
    @checks
    def load(cls, file: Path | str, case: Case) -> "Program":
        """The program of a file; see `read_program`."""
        return read_program(file, case)

    def __repr__(self) -> str:
        """A few lines: dialect, duration and verdict."""
        unit = "rows" if self.dialect.name == ControllerName.SETPOINTS else "blocks"
        size = f"{self.reading.blocks} {unit}, {self.proof.duration:.2f} s"
        name = f"Program {self.path.name} for {self.case.name}"
        return f"{name}: {self.dialect.name}, {size}\nlimits: {self.proof.verdict}"

    def __str__(self) -> str:
        """Its limits as read back, the worst line that exceeds each, and the verdict."""
        violations = self.proof.violations
        worst = {v.kind.family: v for v in reversed(violations)}  # of each limit the worst stands first
        lines = limit_lines(self.proof.limits.checks)
        for limit, count in Counter(v.kind.family for v in violations).items():
            others = f" ({count - 1} more line{'s exceed' if count > 2 else ' exceeds'} it)" if count > 1 else ""
            lines.append(f"line {worst[limit].line}: {worst[limit].sentence()}{others}")
        return "\n".join([*lines, repr(self)])

    _repr_html_ = as_html


_LEAVES_OUT = re.compile(rb"^[;#(\- ]*(?:note: )?leaves out as planned: ([a-z]+(?:, [a-z]+)*)", re.MULTILINE)


def leaving_out(families: Collection[str]) -> tuple[str, ...]:
    """The line of a program's header that names what its plan leaves out; none where it leaves nothing out."""
    return (f"leaves out as planned: {', '.join(families)}",) if families else ()


def left_out(content: bytes) -> frozenset[LimitKind]:
    """Families of limits that a program says its plan leaves out."""
    names = {name.decode() for line in _LEAVES_OUT.findall(content) for name in line.split(b", ")}
    return frozenset(kind for kind in PLANNABLE_WITHOUT if kind in names)


def require_language(case: Case, language: Dialect, choose: str = "name a program of") -> None:
    """Raises CaseError where programs of a language are for other machines than that of the case.

    Args:
        case: case with the machine.
        language: the language.
        choose: what to do, before the names of languages for that machine.
    """
    others = " or ".join(name for name in languages_of(case) if name in DIALECTS)
    require_machine(case, language.name, f"{choose} {others}")


MOST_PROGRAM = 1 << 29  # bytes of a program that is read; those of the longest motions stay far below


def read_program(file: Path | str, case: Case, name: str | None = None) -> Program:
    """Reads a program.

    >>> str(hx.read_program("run.mpf", hx.load_case("hexapod")).dialect.name)
    'sinumerik'

    Args:
        name: name of its dialect; None for the one of the suffix.

    Raises:
        ProgramError: it cannot be read or understood, with line and column.
        CaseError: the case lacks what its dialect needs.
    """
    path = Path(file)
    spoken = dialect_of_file(str(path)) if name is None else dialect(name)
    require_language(case, spoken)
    try:
        content = read_whole(path, MOST_PROGRAM)
    except FileProblem as error:
        raise ProgramError(
            file=path, problem=error.problem, remedy="name a program file", code=Code.UNREADABLE
        ) from error
    reading = spoken.read(content, str(path), case)
    guarantees = replace(spoken.guarantees(reading, case), without=left_out(content))
    return Program(path, spoken, content, reading, guarantees, case)
