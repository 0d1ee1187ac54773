"""POLY blocks of SINUMERIK: a polynomial of at most degree five for each axis, and one time for all."""

import math
import re

import numpy as np

from cases.controller import Sinumerik
from cases.units import MINUTE
from postprocessors.reading.modal import LARGEST, ModalState, Word
from postprocessors.reading.words import Polynomial

COEFFICIENTS = 4  # of a piece beside its end: a2 to a5

_NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)$")


def polynomial(
    state: ModalState, settings: Sinumerik, seen: dict[str, Word], pieces: list[Word], first: Word
) -> Polynomial:
    """X = a0 + a1 p + .. + a5 p^5 for p from 0 to PL, a1 from the end; p is assumed to pass evenly in time.

    Args:
        state: of the controller; its pose becomes the piece's end.
        settings: of the case.
        seen: words of the block but PO.
        pieces: the PO words.
        first: word of the motion, for messages.

    Raises:
        ProgramError: no polynomial that the controller takes, or one that does not keep its time.
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
    moved: set[str] = set()
    for word in pieces:
        if word.selector not in axes or word.selector in moved:
            state.fail(word, f"PO[{word.selector}] is not one of the six axes {', '.join(axes)}, each once; correct it")
        moved.add(word.selector)
        k = axes.index(word.selector)
        end[k], higher = _piece(state, settings, word)
        coefficients[2 : 2 + len(higher), k] = [a * length**i for i, a in enumerate(higher, start=2)]
    coefficients[1] = end - coefficients[0] - coefficients[2:].sum(axis=0)
    duration = MINUTE / float(seen["F"].value or math.nan)
    state.pose = end
    return Polynomial(state.line, coefficients * state.scale, duration)


def _piece(state: ModalState, settings: Sinumerik, word: Word) -> tuple[float, list[float]]:
    items = word.arguments or ()
    bad = next((item for item in items if _NUMBER.match(item) is None or abs(float(item)) > LARGEST), None)
    if bad is not None:
        state.fail(word, f"{bad!r} in PO[{word.selector}] is no plain number of a machine's size; correct it")
    end, *higher = (float(item) for item in items)
    if len(higher) > settings.poly_degree - 1:
        degree = settings.poly_degree
        state.fail(word, f"PO[{word.selector}] has degree {len(higher) + 1}, the controller takes {degree}")
    return end, higher
