"""The words of TwinCAT CNC (ISG) programs, before any meaning: addresses, commands that begin with #, the % line."""

import re

from cases.errors import ProgramError
from postprocessors.reading.lines import each_word
from postprocessors.reading.modal import Word

_NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)"
_PROGRAM = re.compile(r"\s*%\s*(?P<local>L\s+)?(?P<name>[^\s(;\"\],#$]+)\s*$")
_BLOCK_NUMBER = re.compile(r"\s*N(?P<number>\d+)(?!\s*:)", re.IGNORECASE)
_COMMAND = re.compile(
    r"\s*#(?P<name>[A-Z]+(?:\s+[A-Z_]{2,}(?![A-Z0-9_]))*)\s*(?:\[(?P<items>(?:\"[^\"]*\"|[^\]\"])*)\])?\s*(?P<rest>.*?)\s*$",
    re.IGNORECASE,
)
_ITEM = re.compile(r"\"[^\"]*\"|[^,\s\"]+")
_REST = re.compile(rf"(?:(?P<value>{_NUMBER})|(?P<words>(?:[A-Z]{_NUMBER}\s*)+))$", re.IGNORECASE)
_WORD = re.compile(
    rf"\s*(?:(?P<letter>[A-Z])(?P<number>{_NUMBER})(?:\s*=\s*(?P<value>{_NUMBER}))?|(?P<bare>{_NUMBER}))", re.IGNORECASE
)
_REMEDIES = {
    "$": "jumps and loops are not proven; write the blocks out",
    "[": "labels are not read; remove it",
    "/": "skipped blocks are not proven; remove the block or its slash",
    "\\": "continued lines are not read; write one line",
}


def twincat_words(text: str, line: int, file: str) -> list[Word]:
    """The words of a line.

    Args:
        text: of the line, plain ASCII.
        line: its number, for messages.
        file: name of the program, for messages.

    Raises:
        ProgramError: anything that is no word of this language, with its column.
    """
    text = _without_comments(text)
    if text.lstrip().startswith("%"):
        match = _PROGRAM.match(text)
        column = len(text) - len(text.lstrip()) + 1
        if match is None:
            raise ProgramError(file, line, column, "cannot read the program's name; write % and a plain name")
        return [Word("%L" if match["local"] else "%", column, None, (match["name"],))]
    words: list[Word] = []
    position = 0
    if number := _BLOCK_NUMBER.match(text):
        words.append(Word("N", number.start("number"), float(number["number"])))
        position = number.end()
    if text[position:].lstrip().startswith("#"):
        return [*words, _command(text, position, line, file)]

    def word(match: re.Match[str], column: int) -> Word:
        return _word(match, column, line, file)

    def unreadable(column: int, bad: str) -> ProgramError:
        remedy = _REMEDIES.get(bad[:1], "words are a letter and a plain number")
        return ProgramError(file, line, column, f"cannot read {bad!r}; {remedy}")

    return [*words, *each_word(text, position, _WORD, word, unreadable)]


def _without_comments(text: str) -> str:
    """Comments as blanks: behind a semicolon, and in parentheses, which nest and need not be closed."""
    out: list[str] = []
    depth, inside = 0, False
    for k, character in enumerate(text):
        if depth == 0 and character == '"':
            inside = not inside
        if not inside:
            if depth == 0 and character == ";":
                return "".join(out) + " " * (len(text) - k)
            depth += character == "("
            if depth:
                depth -= character == ")"
                out.append(" ")
                continue
        out.append(character)
    return "".join(out)


def _command(text: str, position: int, line: int, file: str) -> Word:
    column = position + len(text[position:]) - len(text[position:].lstrip()) + 1
    match = _COMMAND.match(text, position)
    rest = _REST.match(match["rest"]) if match and match["rest"] else None
    if match is None or (match["rest"] and rest is None):
        raise ProgramError(file, line, column, f"cannot read the command {text[column - 1 : column + 20].strip()!r}")
    items = None if match["items"] is None else tuple(_ITEM.findall(match["items"].upper()))
    if rest is not None and rest["words"]:
        items = (*(items or ()), *rest["words"].upper().split())
    value = float(rest["value"]) if rest is not None and rest["value"] else None
    return Word("#" + " ".join(match["name"].upper().split()), column, value, items)


def _word(match: re.Match[str], column: int, line: int, file: str) -> Word:
    if match["bare"]:
        return Word("", column, float(match["bare"]))
    letter, number = match["letter"].upper(), match["number"]
    value = None if match["value"] is None else float(match["value"])
    if letter in "GM":
        if not number.isdigit():
            raise ProgramError(file, line, column, f"{letter}{number} has no plain number; correct it")
        return Word(f"{letter}{int(number)}", column, value)
    if value is not None:
        raise ProgramError(file, line, column, f"{letter}{number}= is no word here; write {letter} and its number")
    return Word(letter, column, float(number))
