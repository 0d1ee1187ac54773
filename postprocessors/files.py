"""Reads program files, each in the dialect that its suffix names."""

from pathlib import Path
from typing import NamedTuple

from cases.errors import ProgramError
from cases.files import another_kind
from cases.schema import Case
from postprocessors.dialects import Dialect, dialect_of_file
from postprocessors.dialects import dialect as dialect_named
from postprocessors.proving.guarantees import Guarantees
from postprocessors.reading.words import Reading


class ProgramFile(NamedTuple):
    """A program file and what it says; whatever judges or runs it uses this content, not the file a second time.

    Args:
        path: of the file.
        dialect: that its suffix names.
        content: byte by byte.
        reading: what it says.
        guarantees: what the controller answers for.
    """

    path: Path
    dialect: Dialect
    content: bytes
    reading: Reading
    guarantees: Guarantees


def read_program(file: Path, case: Case, name: str | None = None) -> ProgramFile:
    """Reads a program.

    Args:
        file: to read.
        case: that it is for.
        name: of its dialect; None for the one that the suffix names.

    Raises:
        ProgramError: it cannot be read or understood, with line and column.
        CaseError: the case lacks what its dialect needs.
    """
    if other := another_kind(file, ""):
        raise ProgramError(file, 0, 0, f"{other}; here a program file is wanted, such as hexcite post writes")
    dialect = dialect_of_file(str(file)) if name is None else dialect_named(name)
    try:
        content = file.read_bytes()
    except OSError as error:
        raise ProgramError(file, 0, 0, f"cannot be read ({error.strerror}); name a program file") from error
    language = dialect.load(file.suffix.lower())
    reading = language.read(content, str(file), case)
    return ProgramFile(file, dialect, content, reading, language.guarantees(reading, case))
