"""The words of TwinCAT CNC (ISG) programs, before any meaning: addresses, commands that begin with #, the % line."""

import re

from cases.errors import ProgramError
from postprocessors.reading import NUMBER, each_word
from postprocessors.reading.modal import Word

LONGEST_LINE = 4096  # beyond it: error 20301
MOST_MESSAGES = 10  # unread ones stop the controller

# Modal words, of which two of a group in a block are an error to the controller.
GROUPS: tuple[tuple[str, ...], ...] = (
    ("G0", "G1", "G2", "G3"),
    ("G17", "G18", "G19"),
    ("G90",),
    ("G71",),
    ("G93", "G94"),
    ("G162",),
    ("G260", "G261"),
    ("G359", "G360"),
)

OTHERS = {
    word: reason
    for words, reason in (
        ("G20 G21 G22 G23", "mirroring here; write G71 for millimetres"),
        ("G70", "inches; write G71"),
        ("G9 G61", "a way of passing corners here, not an exact stop; write G60"),
        ("G64", "unknown here; write #SPLINE ON, #HSC ON or #CONTOUR MODE and G261"),
        ("G91", "incremental coordinates; write G90"),
        ("G95 G194", "another kind of feed; write G94 or G93"),
        ("G161", "absolute arc centres; write G162"),
        ("G54", "a zero offset that the proof does not know; remove it"),
        ("M17 M29", "the end of a subprogram; write M30"),
        ("M62 M63 M64 M65", "no output here; write the trigger's M function"),
    )
    for word in words.split()
}
OTHERS["#SPLINE TYPE BSPLINE"] = "a curve near its points, not through them; write #SPLINE TYPE AKIMA"


_PROGRAM = re.compile(r"\s*%\s*(?P<local>L\s+)?(?P<name>[^\s(;\"\],#$]+)\s*$")
_BLOCK_NUMBER = re.compile(r"\s*N(?P<number>\d+)(?!\s*:)", re.IGNORECASE)
_COMMAND = re.compile(
    r"\s*#(?P<name>[A-Z]+(?:\s+[A-Z_]{2,}(?![A-Z0-9_]))*)\s*(?:\[(?P<items>(?:\"[^\"]*\"|[^\]\"])*)\])?\s*(?P<rest>.*?)\s*$",
    re.IGNORECASE,
)
_ITEM = re.compile(r"\"[^\"]*\"|[^,\s\"]+")
_REST = re.compile(rf"(?:(?P<value>{NUMBER})|(?P<words>(?:[A-Z]{NUMBER}\s*)+))$", re.IGNORECASE)
_WORD = re.compile(
    rf"\s*(?:(?P<letter>[A-Z])(?P<number>{NUMBER})(?:\s*=\s*(?P<value>{NUMBER}))?|(?P<bare>{NUMBER}))", re.IGNORECASE
)
_REMEDIES = {
    "$": "jumps and loops are not proven; write the blocks out",
    "[": "labels are not read; remove it",
    "/": "skipped blocks are not proven; remove the block or its slash",
    "\\": "continued lines are not read; write one line",
}


def twincat_words(text: str, line: int, file: str) -> list[Word]:
    """The words of a line; raises ProgramError for anything that is not a word of this language."""
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

    def remedy(bad: str) -> str:
        return _REMEDIES.get(bad[:1], "words are a letter and a plain number")

    found = each_word(text, position, _WORD, (file, line), remedy)
    return [*words, *(_word(match, column, line, file) for match, column in found)]


def _without_comments(text: str) -> str:
    """The text with comments as blanks: behind a semicolon, and in parentheses, which nest and need not be closed."""
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
        raise ProgramError(file, line, column, f"{letter}{number}= is not a word here; write {letter} and its number")
    return Word(letter, column, float(number))
