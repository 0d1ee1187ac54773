"""The words of SINUMERIK programs, before any meaning: addresses, keywords, calls, lists and synchronised actions."""

import math
import re

import numpy as np

from cases.controller import Sinumerik
from cases.errors import ProgramError
from cases.units import MINUTE
from postprocessors.reading import NUMBER, TimedBlock, each_word
from postprocessors.reading.modal import LARGEST, ModalState, Word

LONGEST_LINE = 512

# Modal words, of which two of a group in a block are an error to the controller.
GROUPS: tuple[tuple[str, ...], ...] = (
    ("G0", "G1", "G2", "G3", "POLY"),
    ("G17", "G18", "G19"),
    ("G90",),
    ("G710",),
    ("G93", "G94"),
    ("G60", "G64", "G642"),
    ("G40",),
    ("G500",),
    ("COMPOF", "COMPCAD"),
    ("SOFT",),
    ("FFWON", "FFWOF"),
    ("DYNNORM", "DYNPOS"),
    ("ORIWKS",),
    ("ORIRPY",),
    ("ORIAXES",),
    ("CP",),
)

OTHERS = {
    word: reason
    for words, reason in (
        ("G20 G21 G70 G71 G700", "not the unit of lengths and feeds here; write G710 for millimetres"),
        ("G9 G61", "no exact stop that lasts; write G60 for exact stop"),
        ("G91", "incremental coordinates; write G90"),
        ("G95", "feed per revolution; write G94 or G93"),
        ("G54", "a frame that the proof does not know; write G500"),
        ("BRISK DRIVE", "without jerk limit; write SOFT"),
        ("ORIEULER ORIRPY2", "another order of rotations; write ORIRPY"),
        ("ORIMKS", "relative to the machine, not the workpiece; write ORIWKS"),
        ("ORIVECT ORIPLANE", "a turn on a great circle, not along the angles; write ORIAXES"),
        ("PTP PTPG0", "straight in the machine's axes, another path; write CP"),
        ("ASPLINE BSPLINE CSPLINE", "a spline whose time law nobody states; write POLY"),
        ("M17", "the end of a subprogram; write M30"),
        ("M62 M63 M64 M65", "no output here; write DO $A_OUT[n]=1 or =0"),
        ("X= Y= Z= A= B= C= F=", "not read here as an assignment; write the letter and its number"),
        ("P", "not a word of an excitation; G4 takes seconds as F"),
    )
    for word in words.split()
}


_COMMENT = re.compile(r'^((?:[^";]|"[^"]*+"?+)*+);.*$')  # from the first semicolon outside a string on
_PROGRAM = re.compile(r"%_N_(?P<name>[A-Z0-9_]+)_(?:MPF|SPF)\s*$", re.IGNORECASE)
_BLOCK_NUMBER = re.compile(r"\s*N(?P<number>\d+)", re.IGNORECASE)
_ACTION = re.compile(r"\s*DO\s+(?P<action>\S.*?)\s*$", re.IGNORECASE)
_WORD = re.compile(
    rf"""\s*(?:
      (?P<list>PO|FGREF)\[\s*(?P<index>[A-Z0-9_]+)\s*\]\s*=\s*(?:\((?P<items>[^()]*)\)|(?P<item>{NUMBER}))
    | (?P<assigned>[A-Z]+\d*)\s*=\s*(?P<value>{NUMBER})
    | (?P<text>MSG)\s*\((?:"[^"]*")?\)
    | (?P<keyword>[A-Z_]{{2,}}[A-Z0-9_]*)(?:\((?P<arguments>[A-Z0-9_,.\s]*)\))?
    | (?P<letter>[A-Z])(?P<number>{NUMBER})
    )""",
    re.IGNORECASE | re.VERBOSE,
)


def sinumerik_words(text: str, line: int, file: str) -> list[Word]:
    """The words of a line; raises ProgramError for anything that is not a word of this language."""
    text = _COMMENT.sub(r"\1", text)
    if line == 1 and (match := _PROGRAM.match(text)):
        return [Word("%", 1, arguments=(match["name"].upper(),))]
    words: list[Word] = []
    position = 0
    if match := _BLOCK_NUMBER.match(text):
        words.append(Word("N", match.start("number"), float(match["number"])))
        position = match.end()
    if action := _ACTION.match(text, position):
        assignment = "".join(action["action"].upper().split())
        return [*words, Word("DO", action.start("action") + 1, None, (assignment,))]
    found = each_word(text, position, _WORD, (file, line), _remedy)
    return [*words, *(_word(match, column, line, file) for match, column in found)]


def _word(match: re.Match[str], column: int, line: int, file: str) -> Word:
    if match["list"]:
        items = match["items"] if match["items"] is not None else match["item"]
        return Word(match["list"].upper(), column, None, _items(items), match["index"].upper())
    if match["assigned"]:
        return Word(match["assigned"].upper() + "=", column, float(match["value"]))
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


def _remedy(bad: str) -> str:
    if bad.startswith("("):
        return "parentheses are not comments here; write ; before a comment"
    if bad.startswith("/"):
        return "skipped blocks are not proven; remove the block or its slash"
    return "words are a letter and a number, NAME=number, or a keyword"


COEFFICIENTS = 4  # coefficients of a piece beside its end: a2 to a5

_COEFFICIENT = re.compile(f"{NUMBER}$")


def polynomial(
    state: ModalState, settings: Sinumerik, seen: dict[str, Word], pieces: list[Word], first: Word
) -> TimedBlock:
    """Reads X = a0 + a1 p + .. + a5 p^5 for p from 0 to PL, a1 from the end; p is assumed to be linear in time.

    Refuses what the controller does not accept, or what would not last its time. The state's pose becomes its end.
    """
    if not state.active("POLY"):
        state.fail(first, "PO without POLY; add POLY")
    other = next((seen[name] for name in (*state.axes, "I", "J", "K") if name in seen), None)
    if other is not None:
        state.fail(other, f"{other.name.rstrip('=')} under POLY is a straight line among polynomials; write PO[ ]")
    if state.active("COMPCAD"):
        state.fail(first, "POLY under the compressor; write COMPOF before")
    if not state.active("G64"):
        state.fail(first, "POLY under exact stop or rounding does not keep its time; write G64")
    if not state.active("G93") or "F" not in seen:
        state.fail(first, "POLY without a time of its own; write G93 and F = 60 / seconds in the block")
    if len(pieces) > settings.poly_axes:
        state.fail(pieces[-1], f"{len(pieces)} axes in a POLY block, the controller takes {settings.poly_axes}")
    length = float(seen["PL="].value or 0.0) if "PL=" in seen else 1.0
    if not length > 0.0:
        state.fail(seen["PL="], "PL is not positive; correct it")
    coefficients = np.zeros((COEFFICIENTS + 2, 6))
    coefficients[0] = state.pose
    end = state.pose.copy()
    axes = ("X", "Y", "Z", *settings.orientation_axes)
    selectors: set[str] = set()
    for word in pieces:
        if word.selector not in axes or word.selector in selectors:
            state.fail(word, f"PO[{word.selector}] is not one of the six axes {', '.join(axes)}, each once; correct it")
        selectors.add(word.selector)
        k = axes.index(word.selector)
        items = word.arguments or ()
        bad = next((item for item in items if _COEFFICIENT.match(item) is None or abs(float(item)) > LARGEST), None)
        if bad is not None:
            state.fail(word, f"{bad!r} in PO[{word.selector}] is not a plain number of a machine's size; correct it")
        end[k], *higher = map(float, items)
        if len(higher) > (degree := settings.poly_degree) - 1:
            state.fail(word, f"PO[{word.selector}] has degree {len(higher) + 1}, the controller takes {degree}")
        coefficients[2 : 2 + len(higher), k] = [a * length**i for i, a in enumerate(higher, start=2)]
    coefficients[1] = end - coefficients[0] - coefficients[2:].sum(axis=0)
    duration = MINUTE / float(seen["F"].value or math.nan)
    state.pose = end
    return state.line, duration, end * state.scale, coefficients * state.scale
