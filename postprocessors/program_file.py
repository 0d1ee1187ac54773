"""A program's text with what it says: read from a file in the dialect that its suffix names, or written and proven."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from cases.errors import ProgramError
from cases.files import another_kind, atomic_file, check_file
from cases.schema import Case
from cases.units import as_html
from postprocessors.dialects import Dialect, dialect_of_file
from postprocessors.dialects import dialect as dialect_named
from postprocessors.proving.guarantees import Forecast, Guarantees
from postprocessors.proving.proof import ProgramProof, prove_program
from postprocessors.reading import Reading


@dataclass(frozen=True, eq=False, repr=False)
class Program:
    """A program and what it says; whatever judges or runs it uses this content, not the file a second time.

    Args:
        path: path of the file, or the name that it was written for.
        dialect: its language.
        content: byte by byte.
        reading: what it says.
        guarantees: what the controller answers for.
        case: case that it is for.
        remarks: what to know of it beside its proof.
    """

    path: Path
    dialect: Dialect
    content: bytes
    reading: Reading
    guarantees: Guarantees
    case: Case
    remarks: tuple[str, ...] = ()

    @cached_property
    def proof(self) -> ProgramProof:
        """The proof of its limits; raises ProgramError where the motion is not defined."""
        return prove_program(self.reading, self.case, self.guarantees)

    @property
    def forecast(self) -> Forecast:
        """What its controller will make of its time."""
        return self.dialect.load().forecast(self.reading, self.case)

    @property
    def text(self) -> str:
        """Its content; of a Parquet table nothing that can be read."""
        return self.content.decode("utf-8", errors="replace")

    def save(self, file: Path | str, overwrite: bool = False) -> None:
        """Writes the program.

        Raises:
            FileProblem: wrong suffix, something stands there, or the place cannot be written.
        """
        path = Path(file)
        check_file(path, [self.path.suffix.lower()], overwrite=overwrite)
        with atomic_file(path) as part:
            part.write_bytes(self.content)

    @classmethod
    def load(cls, file: Path | str, case: Case) -> "Program":
        """The program of a file; see `read_program`."""
        return read_program(file, case)

    def __repr__(self) -> str:
        """A few lines: what it is, how long it takes, and its proof."""
        unit = "rows" if self.dialect.name == "setpoints" else "blocks"
        size = f"{self.reading.blocks} {unit}, {self.proof.duration:.2f} s"
        return "\n".join(
            [
                f"Program {self.path.name} for {self.case.name}: {self.dialect.name}, {size}",
                f"limits: {self.proof.verdict}",
            ]
        )

    def _repr_html_(self) -> str:
        return as_html(repr(self))


def read_program(file: Path | str, case: Case, name: str | None = None) -> Program:
    """Reads a program.

    Args:
        file: file to read.
        case: case that it is for.
        name: name of its dialect; None for the one that the suffix names.

    Raises:
        ProgramError: it cannot be read or understood, with line and column.
        CaseError: the case lacks what its dialect needs.
    """
    path = Path(file)
    if other := another_kind(path, ""):
        raise ProgramError(path, 0, 0, f"{other}; here a program file is wanted, such as hexcite post writes")
    dialect = dialect_of_file(str(path)) if name is None else dialect_named(name)
    try:
        content = path.read_bytes()
    except OSError as error:
        raise ProgramError(path, 0, 0, f"cannot be read ({error.strerror}); name a program file") from error
    language = dialect.load(path.suffix.lower())
    reading = language.read(content, str(path), case)
    return Program(path, dialect, content, reading, language.guarantees(reading, case), case)
