"""A program file as lines of plain ASCII that its controller can take."""

from cases.errors import ProgramError


def program_lines(content: bytes, file: str, longest: int, most: int) -> list[str]:
    """The lines of a program.

    Args:
        content: of the file.
        file: its name, for messages.
        longest: most characters that the controller takes in a line.
        most: most lines with content that its memory holds.

    Raises:
        ProgramError: a character that is no plain ASCII, a line too long, too many lines; with line and column.
    """
    # latin-1 maps bytes to characters one to one, so that columns are right whatever the encoding really is.
    lines = content.decode("latin-1").replace("\r\n", "\n").split("\n")
    used = 0
    for number, text in enumerate(lines, start=1):
        if not text.isascii() or not text.replace("\t", " ").isprintable():
            column = next(k for k, c in enumerate(text) if c != "\t" and not " " <= c <= "~")
            raise ProgramError(
                file, number, column + 1, f"character {text[column]!r} is not plain ASCII; remove or replace it"
            )
        if len(text) > longest:
            raise ProgramError(file, number, 0, f"{len(text)} characters, the controller takes {longest}; split it")
        used += bool(text.strip())
        if used > most:
            raise ProgramError(
                file,
                number,
                0,
                f"more than {most} blocks, which is what the controller's memory holds (most_blocks); make the program "
                "shorter, its timed blocks longer, or the memory larger",
            )
    return lines
