"""A naive reading of programs, which shares nothing with the readers and judges what they call proven."""

import re

import numpy as np

from cases.schema import Case
from tests.postprocessors.independent import strut_lengths
from tests.postprocessors.other_dialects import CASE
from tests.postprocessors.programs import HOME


def naively_read(name: str, text: str) -> list[tuple[np.ndarray, np.ndarray, float, bool]]:
    """Start, end [mm, deg], feed per minute and whether the trigger is on, of each move after the first."""
    pose, feed, on, found = np.full(6, np.nan), np.nan, False, []
    for line in text.split("\n"):
        line = re.sub(r"[;(].*", "", line) if name != "sinumerik" else line.split(";")[0]
        if re.match(r"M6[24]|M100|DO .*=1", line) or re.match(r"M6[35]|M101|DO .*=0", line):
            on = re.match(r"M6[24]|M100|DO .*=1", line) is not None
        if re.match(r"G0?4 |[%#D$]|TRA|ORI|SOFT|FGROUP|o\d|IF|MSG|SETAL|ENDIF", line):
            continue
        words = {k: float(v) for k, v in re.findall(r"([XYZABCF])(?:2=)?(-?\d*\.?\d+)", line)}
        feed = words.pop("F", feed)
        if words:
            end = np.array([words.get(c, old) for c, old in zip("XYZABC", pose, strict=True)])
            if not np.isnan(pose).any():
                found.append((pose, end, feed, on))
            pose = end
    return found


def naive_share(name: str, text: str) -> float:
    """The largest share of a limit of poses, mean struts and feeds that a move uses; above 1 it is dangerous."""
    return share_of_moves(naively_read(name, text), CASE, np.array([1, 1, 1, 1, -1, 1]) if name == "twincat" else 1)


def share_of_moves(
    moves: list[tuple[np.ndarray, np.ndarray, float, bool]], case: Case, turned: np.ndarray | int = 1
) -> float:
    """The same of moves: start, end [mm, deg], feed per minute and whether the trigger is on.

    Args:
        moves: straight ones.
        case: its limits.
        turned: signs of the coordinates, where a controller counts an angle the other way round.
    """
    shares, limits = [0.0], case.limits.motion
    unit = np.repeat([1e-3, np.pi / 180], 3)
    for start, end, feed, on in moves:
        way = np.abs(end - start) * unit
        if not way.any():
            continue
        length = np.linalg.norm(way[:3]) if way[:3].any() else np.linalg.norm(way[3:])
        speed = feed / 60 * (1e-3 if way[:3].any() else np.pi / 180)
        shares.append(float(np.max(way * speed / length / limits.rate)))
        box = limits.coordinates[1] if on else np.r_[0.3, 0.3, np.inf, np.inf, np.inf, np.inf]
        shares.append(float(np.max(np.abs(end * unit - HOME) / box)))
        at = start + np.linspace(0.0, 1.0, 30)[:, None] * (end - start)
        lengths = strut_lengths(at * unit * turned, case)
        short, long = limits.strut_length
        shares.append(float(np.max(np.abs(lengths - (short + long) / 2) / ((long - short) / 2))))
    return max(shares)
