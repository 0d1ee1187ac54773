"""Point-to-point moves, straight in the struts, as SINUMERIK and TwinCAT write them."""

import math

from cases.controller import PointToPointDrives
from postprocessors.reading.modal import ModalState, Word
from postprocessors.reading.words import Array, Move, Timing


def read_strut_move(
    state: ModalState, drives: PointToPointDrives | None, word: str, seen: dict[str, Word], first: Word, end: Array
) -> Move:
    """A move to a pose, shape (6,) as written. F under G94 would count axes that differ from machine to machine.

    Args:
        state: state of the controller.
        drives: what the case says of them.
        word: word that switches these moves on, for messages.
        seen: words of the block.
        first: first of its coordinates.
        end: where it leads.

    Raises:
        ProgramError: what moves the struts is not the block's time, nor a rapid.
    """
    rapid, spelling = state.active("G0"), state.spelling
    if not rapid and drives is not None and drives.feed == "rapid":
        key = f"controller.{spelling.name.lower()}.ptp.feed"
        state.fail(first, f"{key} says that moves under {word} are rapids; write {spelling.rapid}")
    if not rapid and not (state.active("G93") and "F" in seen):
        said = f"what F counts under {word} differs from machine to machine"
        state.fail(first, f"{said}; write G93 and {spelling.block_time}")
    timing, value = state.timing(seen, end, first)
    if rapid:
        return state.straight(end, timing, math.nan, True, in_struts=True)
    return state.straight(end, Timing.FEED, 1.0 / value, True, in_struts=True)
