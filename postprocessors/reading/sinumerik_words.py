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

# Two words of one modal group in a block are an error to the controller.
GROUPS: tuple[tuple[str, ...], ...] = (
    ("G0", "G1", "G2", "G3", "POLY", "ASPLINE", "BSPLINE", "CSPLINE"),
    ("G17", "G18", "G19"),
    ("G90", "G91"),
    ("G70", "G71", "G700", "G710"),
    ("G93", "G94", "G95"),
    ("G60", "G64", "G641", "G642", "G643", "G644", "G645"),
    ("G40", "G41", "G42"),
    ("G500", "G54", "G55", "G56", "G57"),
    ("COMPOF", "COMPON", "COMPCURV", "COMPCAD", "COMPSURF"),
    ("BRISK", "SOFT", "DRIVE"),
    ("FFWON", "FFWOF"),
    ("DYNNORM", "DYNPOS", "DYNROUGH", "DYNSEMIFIN", "DYNFINISH", "DYNPREC"),
    ("ORIWKS", "ORIMKS"),
    ("ORIEULER", "ORIRPY", "ORIRPY2", "ORIVIRT1", "ORIVIRT2"),
    ("ORIAXES", "ORIVECT", "ORIPLANE"),
    ("PTP", "PTPG0", "CP"),
    ("G4",),
    ("M2", "M17", "M30"),
)

# Words that a proven program may hold; those that change nothing it relies on need no more than this.
NEUTRAL = {"G40", "FFWON", "FFWOF", "DYNNORM", "DYNPOS", "MSG", "N"}
MODAL = {
    *("G0", "G1", "G2", "G3", "POLY", "G17", "G18", "G19", "G90", "G710", "G93", "G94", "G60", "G64", "G642"),
    *("G500", "COMPOF", "COMPCAD", "SOFT", "ORIWKS", "ORIRPY", "ORIAXES", "CP"),
}

REMEDY = {
    "G20": "no inches here but unknown to SINUMERIK; write G710 for millimetres",
    "G21": "unknown to SINUMERIK; write G710 for millimetres",
    "G70": "inches; write G710",
    "G71": "millimetres for the geometry alone, not for feeds; write G710",
    "G700": "inches; write G710",
    "G61": "not used here; write G60 for exact stop",
    "G9": "an exact stop in this block alone; write G60",
    "G80": "not a cancel of cycles here; remove it",
    "G91": "incremental coordinates; write G90",
    "G95": "feed per revolution; write G94 or G93",
    "G54": "a frame that the proof does not know; write G500",
    "BRISK": "without jerk limit; write SOFT",
    "DRIVE": "without jerk limit; write SOFT",
    "ORIEULER": "another order of rotations; write ORIRPY",
    "ORIRPY2": "another order of rotations; write ORIRPY",
    "ORIMKS": "relative to the machine, not the workpiece; write ORIWKS",
    "ORIVECT": "a turn on a great circle, not along the angles; write ORIAXES",
    "ORIPLANE": "a turn on a great circle, not along the angles; write ORIAXES",
    "PTP": "straight in the machine's axes, another path; write CP",
    "PTPG0": "straight in the machine's axes in rapid moves; write CP",
    "STAT=": "a choice among assemblies, of which a hexapod has one; remove it",
    "TU=": "a choice among turns, of which struts have none; remove it",
    "RTLIOF": "ignored while a transformation is active; remove it",
    "ASPLINE": "a spline whose time law nobody states; write POLY",
    "BSPLINE": "a spline whose time law nobody states; write POLY",
    "CSPLINE": "a spline whose time law nobody states; write POLY",
    "STOPRE": "a stop of the look-ahead; remove it",
    "M17": "the end of a subprogram; write M30",
    "M62": "no output here; write DO $A_OUT[n]=1",
    "M63": "no output here; write DO $A_OUT[n]=0",
    "M64": "no output here; write DO $A_OUT[n]=1",
    "M65": "no output here; write DO $A_OUT[n]=0",
    "P": "not a word of an excitation; G4 takes seconds as F",
}


_PROGRAM = re.compile(r"%_N_(?P<name>[A-Z0-9_]+)_(?:MPF|SPF)\s*$", re.IGNORECASE)
_BLOCK_NUMBER = re.compile(r"\s*N(?P<number>\d+)", re.IGNORECASE)
_ACTION = re.compile(
    r"\s*(?:IDS?\s*=\s*\d+\s+)?(?P<condition>(?:WHENEVER|WHEN|FROM|EVERY)\b.*\S)?\s*\bDO\s+(?P<action>\S.*?)\s*$",
    re.IGNORECASE,
)
_ASSIGNMENT = re.compile(r"(?P<name>\$?[A-Z_]+[A-Z0-9_]*)(?:\[(?P<index>[A-Z0-9_]+)\])?\s*=\s*(?P<value>[^=\s]+)$")
_WORD = re.compile(
    rf"""\s*(?:
      (?P<list>[A-Z]+\d*)\[\s*(?P<index>[A-Z0-9_]+)\s*\]\s*=\s*(?:\((?P<items>[^()]*)\)|(?P<item>{NUMBER}))
    | (?P<assigned>[A-Z]+\d*)\s*=\s*(?:(?P<value>{NUMBER})|(?P<quoted>'[BH]?[0-9A-F]+')|(?P<call>[A-Z]+\([^()]*\)))
    | (?P<text>MSG)\s*\((?:"[^"]*")?\)
    | (?P<keyword>[A-Z_]{{2,}}[A-Z0-9_]*)(?:\((?P<arguments>[A-Z0-9_,.\s]*)\))?
    | (?P<letter>[A-Z])(?P<number>{NUMBER})
    )""",
    re.IGNORECASE | re.VERBOSE,
)


def sinumerik_words(text: str, line: int, file: str) -> list[Word]:
    """The words of a line; raises ProgramError for anything that is not a word of this language."""
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

    found = each_word(text, position, _WORD, (file, line), _remedy)
    return [*words, *(_word(match, column, line, file) for match, column in found)]


def _without_comment(text: str) -> str:
    """The text up to the first semicolon outside a string."""
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
    if np.isnan(state.pose).any():
        state.fail(first, "a polynomial starts from an unknown pose; first move home at a feed (G94)")
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
