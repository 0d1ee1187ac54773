"""The words of SINUMERIK programs, before any meaning: addresses, keywords, calls, lists and synchronised actions."""

import re

from cases.errors import ProgramError
from postprocessors.reading.lines import each_word
from postprocessors.reading.modal import Word

_NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)"
_PROGRAM = re.compile(r"%_N_(?P<name>[A-Z0-9_]+)_(?:MPF|SPF)\s*$", re.IGNORECASE)
_BLOCK_NUMBER = re.compile(r"\s*N(?P<number>\d+)", re.IGNORECASE)
_ACTION = re.compile(
    r"\s*(?:IDS?\s*=\s*\d+\s+)?(?P<condition>(?:WHENEVER|WHEN|FROM|EVERY)\b.*\S)?\s*\bDO\s+(?P<action>\S.*?)\s*$",
    re.IGNORECASE,
)
_ASSIGNMENT = re.compile(r"(?P<name>\$?[A-Z_]+[A-Z0-9_]*)(?:\[(?P<index>[A-Z0-9_]+)\])?\s*=\s*(?P<value>[^=\s]+)$")
_WORD = re.compile(
    rf"""\s*(?:
      (?P<list>[A-Z]+\d*)\[\s*(?P<index>[A-Z0-9_]+)\s*\]\s*=\s*(?:\((?P<items>[^()]*)\)|(?P<item>{_NUMBER}))
    | (?P<assigned>[A-Z]+\d*)\s*=\s*(?:(?P<value>{_NUMBER})|(?P<quoted>'[BH]?[0-9A-F]+')|(?P<call>[A-Z]+\([^()]*\)))
    | (?P<text>MSG)\s*\((?:"[^"]*")?\)
    | (?P<keyword>[A-Z_]{{2,}}[A-Z0-9_]*)(?:\((?P<arguments>[A-Z0-9_,.\s]*)\))?
    | (?P<letter>[A-Z])(?P<number>{_NUMBER})
    )""",
    re.IGNORECASE | re.VERBOSE,
)


def sinumerik_words(text: str, line: int, file: str) -> list[Word]:
    """The words of a line.

    Args:
        text: of the line, plain ASCII.
        line: its number, for messages.
        file: name of the program, for messages.

    Raises:
        ProgramError: anything that is no word of this language, with its column.
    """
    text = _without_comment(text)
    if line == 1 and (match := _PROGRAM.match(text)):
        return [Word("%", 1, arguments=(match["name"].upper(),))]
    words: list[Word] = []
    position = 0
    if match := _BLOCK_NUMBER.match(text):
        words.append(Word("N", match.start("number"), float(match["number"])))
        position = match.end()
    if action := _ACTION.match(text, position):
        column = action.start("action") + 1
        return [*words, _action(action["action"].upper(), action["condition"], line, column, file)]

    def word(match: re.Match[str], column: int) -> Word:
        return _word(match, column, line, file)

    def unreadable(column: int, bad: str) -> ProgramError:
        return ProgramError(file, line, column, f"cannot read {bad!r}; {_remedy(bad)}")

    return [*words, *each_word(text, position, _WORD, word, unreadable)]


def _without_comment(text: str) -> str:
    """Up to the first semicolon that stands in no string."""
    inside = False
    for k, character in enumerate(text):
        inside ^= character == '"'
        if character == ";" and not inside:
            return text[:k]
    return text


def _word(match: re.Match[str], column: int, line: int, file: str) -> Word:
    if match["list"]:
        items = match["items"] if match["items"] is not None else match["item"]
        return Word(match["list"].upper(), column, None, _items(items), match["index"].upper())
    if match["assigned"]:
        value = None if match["value"] is None else float(match["value"])
        written = match["quoted"] or match["call"]
        return Word(match["assigned"].upper() + "=", column, value, None if written is None else (written.upper(),))
    if match["text"]:
        return Word("MSG", column)
    if match["keyword"]:
        arguments = None if match["arguments"] is None else _items(match["arguments"])
        return Word(match["keyword"].upper(), column, None, arguments)
    letter, number = match["letter"].upper(), match["number"]
    if letter in "GM":
        if not number.isdigit():
            raise ProgramError(file, line, column, f"{letter}{number} has no plain number; correct it")
        return Word(f"{letter}{int(number)}", column)
    return Word(letter, column, float(number))


def _items(text: str) -> tuple[str, ...]:
    return tuple(item.strip().upper() for item in text.split(","))


def _action(text: str, condition: str | None, line: int, column: int, file: str) -> Word:
    match = _ASSIGNMENT.match(text)
    if match is None:
        raise ProgramError(file, line, column, f"cannot read the action {text!r}; it assigns one value: $A_OUT[1]=1")
    return Word("DO", column, None, (match["name"], match["index"] or "", match["value"]), condition)


def _remedy(bad: str) -> str:
    if bad.startswith("("):
        return "parentheses are no comment here; write ; before a comment"
    if bad.startswith("/"):
        return "skipped blocks are not proven; remove the block or its slash"
    return "words are a letter and a number, NAME=number, or a keyword"
