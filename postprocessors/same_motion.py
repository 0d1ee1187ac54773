"""Whether a text, as it is read back, is the motion that was written, and whether two readings are the same."""

from dataclasses import replace

import numpy as np

from cases.base.errors import Code, ProgramError
from cases.base.units import DEG, MM
from identification.motion.curves import PolynomialMotion
from identification.motion.motion import Array
from identification.motion.moves import CircularMove, StraightMove
from postprocessors.blocks import Blocks, TimedPath, ToHome
from postprocessors.dialects.block_writer import LEAST_WAY
from postprocessors.proof.guarantees import Guarantees
from postprocessors.reading import Reading, Stretch, Timed, Untimed

# Twice the last decimal of the words: the program as read back must be the plan, up to rounding [m or rad].
ROUNDING = max(1e-5 * MM, 1e-6 * DEG)


def same_stretches(one: Reading, other: Reading) -> bool:
    """Whether two readings are equal to the last bit, but for line numbers."""

    def values(part: Stretch) -> list[object]:
        if isinstance(part, Timed):
            at = part.points.at(part.points.times)
            arrays = part.points.times, at.coordinates, at.rates, at.accelerations, at.jerks
            return [type(part.points), part.trigger, *(array.tobytes() for array in arrays)]
        with np.printoptions(floatmode="unique"):
            return [repr(replace(part, line=0))]

    return [*map(values, one.stretches)] == [*map(values, other.stretches)]


def moved_lines(one: Reading, other: Reading) -> dict[int, int]:
    """Lines of the stretches of a reading -> those of the same stretches in another one."""

    def lines(reading: Reading) -> list[int]:
        return [line for part in reading.stretches for line in (part.lines if isinstance(part, Timed) else [part.line])]

    return dict(zip(lines(one), lines(other), strict=True))


def off_the_plan(guarantees: Guarantees) -> float:
    """By how much a coordinate may end off the plan [m, rad]: the end is rounded, and what is too little stays."""
    return ROUNDING + max(1.5 * guarantees.resolution * max(MM, DEG), LEAST_WAY * MM)


def require_same(program: Blocks, reading: Reading, guarantees: Guarantees) -> None:
    """Raises unless the motion of the text is that of the program, block by block, point by point, at every instant.

    Polynomials may deviate from other motions by the tolerance of the controller.
    """
    off = off_the_plan(guarantees)
    written = [b for b in program if isinstance(b, TimedPath | StraightMove | CircularMove)]
    # The moves that take out what is left of the way home have no counterpart.
    moves = [s for s in reading.stretches if isinstance(s, Timed | Untimed)]
    read = [s for s in moves if isinstance(s, Timed) or s.within is None]
    if len(read) == len(moves) or reading.checked is None:
        raise ProgramError(
            file=reading.file,
            problem="the check that the machine stands at home is missing",
            remedy="report this",
            code=Code.INTERNAL,
        )
    if not np.all(np.abs(reading.checked[0] - _home_of(program)) <= ROUNDING):
        raise ProgramError(
            file=reading.file,
            problem="the program checks for another place than home",
            remedy="report this",
            code=Code.INTERNAL,
        )
    if len(read) != len(written):
        raise ProgramError(
            file=reading.file,
            problem=f"{len(read)} moves where {len(written)} were written",
            remedy="report this",
            code=Code.INTERNAL,
        )
    for block, stretch in zip(written, read, strict=True):
        if isinstance(block, TimedPath):
            same = isinstance(stretch, Timed) and _same_path(block, stretch, guarantees.tolerance, off)
        else:
            same = (
                isinstance(stretch, Untimed)
                and (stretch.arc is not None) == isinstance(block, CircularMove)
                and bool(np.all(np.abs(stretch.end - block.end) <= off))
            )
        if not same:
            raise ProgramError(
                file=reading.file,
                line=stretch.line,
                problem="the motion reads back differently",
                remedy="report this",
                code=Code.INTERNAL,
            )


def _home_of(program: Blocks) -> Array:
    return next(block.coordinates for block in program if isinstance(block, ToHome))


def _same_path(path: TimedPath, stretch: Timed, tolerance: Array, at_start: float) -> bool:
    """Whether a path is the planned one; it begins where the move before it ended."""
    times = stretch.points.times
    if isinstance(stretch.points, PolynomialMotion):
        off = np.abs(path.poses - stretch.points.at(np.minimum(path.times, times[-1])).coordinates)
        allowed = np.where(path.times[:, None] > 0.0, ROUNDING + tolerance, at_start)
        return bool(np.isclose(path.times[-1], times[-1], rtol=1e-7) and np.all(off <= allowed))
    if len(path.times) != len(times) or not np.allclose(path.times, times, rtol=1e-7, atol=1e-9):
        return False  # F has 6 decimals: 1e-10 of 10 ms a block
    off = np.abs(path.poses - stretch.points.at(times).coordinates)
    return bool(np.all(off[0] <= at_start) and np.all(off[1:] <= ROUNDING))
