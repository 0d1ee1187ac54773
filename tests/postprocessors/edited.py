"""Programs to be edited, in each dialect, and edits that make every one of them dangerous."""

import re
from collections.abc import Callable
from functools import cache

import numpy as np

from identification.limits.proof import prove
from identification.motion.motion import Joined, Standstill, Trajectory
from identification.motion.moves import StraightMove
from planner.families.fourier import FourierFamily
from postprocessors.excitation import excitation_program
from postprocessors.program import dialect
from postprocessors.proof.proof import ProgramProof, prove_program
from tests.postprocessors.other_dialects import CASE, LINES_CASE
from tests.postprocessors.programs import HOME

LIMITS = CASE.limits.motion
FAR = HOME + np.r_[0.05, -0.03, 0.02, 0.1, -0.05, 0.1]
CASES = {"linuxcnc": CASE, "sinumerik": CASE, "sinumerik lines": LINES_CASE, "twincat": CASE}
NAMES = [n for n in CASES if n != "sinumerik lines"]


def proof(name: str, text: str) -> ProgramProof:
    language, case = dialect(name.split()[0]), CASES[name]
    reading = language.read(text.encode("latin-1"), "p", case)
    return prove_program(reading, language.guarantees(reading, case))


def written(name: str, motion: Trajectory) -> str:
    language, case = dialect(name.split()[0]), CASES[name]
    return language.write(language.prepare(excitation_program(motion, case), case), case).decode("ascii")


@cache
def moves(name: str) -> str:
    """There and back with a pause, at 90 % of the limits."""
    limits = [0.9 * v for v in (LIMITS.rate, LIMITS.acceleration, LIMITS.jerk)]
    there, back = StraightMove.fastest(HOME, FAR, *limits), StraightMove.fastest(FAR, HOME, *limits)
    return written(name, Joined((there, Standstill(FAR, 0.2), back)))


@cache
def path(name: str) -> str:
    """A Fourier motion of half a second that uses 85 % of its tightest limit."""
    family = FourierFamily(2, 0.5, 1, HOME, (LIMITS.coordinates[1] - LIMITS.coordinates[0]) / 2)
    unknowns = np.random.default_rng(1).normal(size=family.unknowns * 6)
    for _ in range(6):
        unknowns *= 0.85 / prove(family.motion(unknowns), CASE, 2000.0).worst_ratio
    return written(name, family.motion(unknowns))


def tenfold(match: re.Match[str]) -> str:
    return f"F{10 * float(match[1]):.6f}"


def changed(text: str, pattern: str, new: str | Callable[[re.Match[str]], str], which: int = 0) -> str:
    """The text with one match replaced; it must exist."""
    found = list(re.finditer(pattern, text, re.MULTILINE))
    assert found, f"{pattern!r} is not in the program"
    match = found[which]
    return text[: match.start()] + (match.expand(new) if isinstance(new, str) else new(match)) + text[match.end() :]


EVERY_DIALECT = {
    "a feed ten times as high": (r"F(\d{3,}\.\d+)$", tenfold),
    "the feed home ten times as high": (r" F3$", " F30"),
    "the turn home ten times as fast": (r" F0\.34$", " F3.4"),
    "home at a rapid": (r"^G0?1( .*)F3$", r"G0\1"),
    "no move home": (r"^.* F3\n", ""),
    "home left before it is reached": (r"X0 Y0 Z900 F3$", "X1 Y0 Z900 F3"),
    "a loose check of home": (r"0\.01$|0\.01(?=\])", "1"),
    "a check of another place": (r"-900(?=\])|-900(?=\))", "-800"),
    "a check of an axis twice": (r"(\[#<_|\$AA_IW\[|\.ABS\.)[yY]", r"\1X"),
    "one axis not checked": (r"(?s)^(o102 if|IF .ABS.\$AA_IW\[Y|\$IF ABS.V.A.ABS.Y).*?(o102 endif|\$?ENDIF)\n", ""),
    "a check without a stop": (r"^\(abort,.*\)\n|^M30\nENDIF|^#ERROR.*\n", ""),
    "the other way round": (r"\] gt 0.01|\)>0.01|\] > 0.01", "lt"),
    "a height below ground": (r"Z920", "Z-920"),
    "a height without its last digit": (r"Z920", "Z92"),
    "a coordinate without its decimal point": (r"(A2?=?5)\.7", r"\g<1>7"),
    "a position ten times as far": (r"X50 ", "X500 "),
    "axes exchanged": (r"X50 Y-30 Z920", "Z50 Y-30 X920"),
    "incremental coordinates": (r"\bG90\b", "G91"),
    "no kind of coordinates": (r"\bG90\b", ""),
    "feed per revolution": (r"\bG94\b", "G95"),
    "a second start in the middle": (r"(?s)(.*)", r"\1\1"),
    "no end": (r"^M(2|30)$", ""),
}
