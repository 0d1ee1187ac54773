"""Reads program files, each in the dialect that its suffix names."""

from pathlib import Path

from cases.errors import ProgramError
from postprocessors.reading.words import Reading
from postprocessors.writing import dialect_of_file


def read_text(file: Path) -> str:
    """The text of a program.

    Raises:
        ProgramError: it cannot be read.
    """
    try:
        return file.read_text(encoding="utf-8")
    except OSError as error:
        raise ProgramError(file, 0, 0, f"cannot be read ({error.strerror}); name a program file") from error
    except UnicodeDecodeError as error:
        raise ProgramError(file, 0, 0, "is not text; name a program file") from error


def read_program(file: Path) -> Reading:
    """Reads a program.

    Raises:
        ProgramError: it cannot be read or understood, with line and column.
    """
    return dialect_of_file(file.name).read(read_text(file), str(file))
