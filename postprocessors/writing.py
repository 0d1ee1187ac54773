"""From a planned motion to a program's text that has been read back and proven; this module returns nothing else."""

from collections.abc import Callable, Collection
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from cases.base.errors import Code, ProgramError
from cases.base.phrases import phrase
from cases.base.units import DEG, MM
from cases.schema import Case
from identification.limits.limit import NAMED, UNUSED_SHARE, LimitKind
from identification.limits.proof import FORCE_RATE, mechanical_pace, slowed_for_forces
from identification.motion.curves import PolynomialMotion
from identification.motion.motion import Array, Joined, Standstill, Trajectory
from identification.motion.moves import CircularMove, StraightMove
from identification.texts import bounds_text
from postprocessors.blocks import Block, Blocks, TimedPath, ToHome, Trigger, timed_path
from postprocessors.dialects.block_writer import LEAST_WAY
from postprocessors.dialects.dialect import Dialect
from postprocessors.program import Program, left_out
from postprocessors.proof.guarantees import Guarantees
from postprocessors.proof.proof import ProgramProof, override_remarks, prove_program, remarks
from postprocessors.reading import Reading, Stretch, Timed, Untimed

# Twice the last decimal of the words: the program as read back must be the plan, up to rounding [m or rad].
ROUNDING = max(1e-5 * MM, 1e-6 * DEG)


def proven_program(
    trajectory: Trajectory,
    case: Case,
    dialect: Dialect,
    file: Path | str,
    header: tuple[str, ...],
    speed: float = 1.0,
    accepted: Collection[str] = (),
) -> Program:
    """Writes a program and proves what it wrote.

    Args:
        trajectory: the excitation, from rest to rest.
        case: machine, limits, controller.
        file: name of the program.
        header: comment lines, those of `leaving_out` too, which the proof reads there; the proven limits are added.
        speed: share of the planned speed, above 0 and at most 1.
        accepted: families of limits that may stay without enforcement.

    Raises:
        ProgramError: the text, as read back, is not the planned motion, exceeds a limit, or relies on one that nobody
            enforces and that is not accepted.
        CaseError: the case has no machine or no controller.
    """
    path = Path(file)
    named = case if speed == 1.0 else case.named_slow()

    def read_back(slower: float) -> _ReadBack:
        return _read_back(trajectory, case, dialect, path, header, speed * slower, named)

    made = read_back(1.0)
    made, slowed = _slowed(made, read_back) if made.proof.violations else (made, ())
    program, reading, guarantees, proof = made
    proof.require_accepted(accepted)
    if dialect.same is None:
        _require_same(program, reading, guarantees)
    else:
        dialect.same(program, reading, case)
    findings = (*_findings(proof), *slowed, *override_remarks(reading, guarantees))
    content = dialect.form(dialect.write((*header, *findings, *program), named), path.suffix.lower(), case)
    again = dialect.read(content, str(path), case)
    if not _same_stretches(again, reading):
        raise ProgramError(
            file=path, problem="the header changes how the program reads", remedy="report this", code=Code.INTERNAL
        )
    proven = replace(proof, remarks=tuple(remarks(again, guarantees))).at_lines(_moved_lines(reading, again))
    return Program(path, dialect, content, again, guarantees, case, remarks=slowed, proven=proven)


class _ReadBack(NamedTuple):
    """A motion as blocks, and what is read back from them."""

    program: Blocks
    reading: Reading
    guarantees: Guarantees
    proof: ProgramProof


def _read_back(
    trajectory: Trajectory, case: Case, dialect: Dialect, path: Path, header: tuple[str, ...], speed: float, named: Case
) -> _ReadBack:
    """Writes a program, reads it back and proves it; `named` is the case with the program's names."""
    promised = dialect.guarantees(Reading(file=str(path), stretches=(), blocks=0), case)
    blocks = excitation_program(trajectory, case, speed, promised)
    program = _without_nothing(dialect.prepare(blocks, case), promised.resolution, case)
    written = dialect.write((*header, *program), named)
    text = dialect.form(written, path.suffix.lower(), case)
    if lost := left_out(written) - left_out(text):
        raise ProgramError(
            file=path,
            problem=f"files that end in {path.suffix} hold no comment, which must say that the plan leaves out "
            f"{', '.join(sorted(lost))}",
            remedy=f"write {path.with_suffix(dialect.suffix).name}",
            code=Code.NOT_SUPPORTED,
        )
    reading = dialect.read(text, str(path), case)
    guarantees = replace(dialect.guarantees(reading, case), without=left_out(text))
    return _ReadBack(program, reading, guarantees, prove_program(reading, guarantees))


LONGER = 0.01  # share of its duration by which an excitation may last longer, so that its own points keep limits
INSIDE = 1e-5  # share of a limit that is left then
TRIES = 3
ORDERS = {
    LimitKind.VELOCITY: 1, LimitKind.STRUT_VELOCITY: 1, LimitKind.ACCELERATION: 2, LimitKind.STRUT_ACCELERATION: 2,
    LimitKind.JERK: 3,
}  # fmt: skip
"""Powers of a motion's speed with which limited quantities grow."""


def _slowed(first: _ReadBack, read_back: Callable[[float], _ReadBack]) -> tuple[_ReadBack, tuple[str, ...]]:
    """A program that is slower by so little as its own points need, and the remark on that; else the first one.

    A controller goes through the points of a path as it does, which differs from the plan between them: where jerk
    steps in a plan that uses all of its limit, by up to a percent.
    """
    made, share = first, 1.0
    for _ in range(TRIES):
        orders = [ORDERS.get(check.kind.family) for check in made.proof.violations]
        if None in orders:
            return first, ()
        share *= min(
            ((1.0 - INSIDE) / check.ratio) ** (1.0 / order)
            for check, order in zip(made.proof.violations, orders, strict=True)
            if order is not None
        )
        if share * (1.0 + LONGER) < 1.0:
            return first, ()
        made = read_back(share)
        longer = made.proof.excitation / first.proof.excitation - 1.0  # controllers round to cycles of theirs
        if longer > LONGER:
            return first, ()
        if not made.proof.violations:
            worst = first.proof.violations[0]
            remark = phrase(
                "slowed_for_points",
                "{share} % slower than planned: at the plan's speed its points would take {limit} to {ratio} % of its "
                "limit",
                share=f"{100.0 * longer:.2g}",
                limit=phrase(NAMED, "{name}", name=worst.name),
                ratio=f"{100.0 * worst.ratio:.2f}",
            )
            return made, (remark,)
    return first, ()


def _without_nothing(program: Blocks, resolution: float, case: Case) -> Blocks:
    """The program without moves whose ends the control cannot tell apart, by its `resolution` [mm, deg]."""
    least = 2.0 * resolution * np.where(case.need_motion("a program")[1].turns, DEG, MM)
    return tuple(b for b in program if not (isinstance(b, StraightMove) and np.all(np.abs(b.end - b.start) <= least)))


PLUS_MINUS, PLAIN = "±", "+-"  # headers are plain ASCII


def _findings(proof: ProgramProof) -> tuple[str, ...]:
    """Lines of the header on the proof, which claim no more than was proven."""
    lines = [f"duration {proof.duration:.3f} s, excitation {proof.excitation:.3f} s", f"limits: {proof.verdict}"]
    for check in proof.limits.checks:
        text = f"{check.worst:.5g} {check.unit}, allowed {bounds_text(check).replace(PLUS_MINUS, PLAIN)}"
        lines.append(f"{check.name}: {text}; {check.status}{'' if check.binding else ' (predicted)'}")
    return tuple(lines)


def _same_stretches(one: Reading, other: Reading) -> bool:
    """Whether two readings are equal to the last bit, but for line numbers."""

    def values(part: Stretch) -> list[object]:
        if isinstance(part, Timed):
            at = part.points.at(part.points.times)
            arrays = part.points.times, at.coordinates, at.rates, at.accelerations, at.jerks
            return [type(part.points), part.trigger, *(array.tobytes() for array in arrays)]
        with np.printoptions(floatmode="unique"):
            return [repr(replace(part, line=0))]

    return [*map(values, one.stretches)] == [*map(values, other.stretches)]


def _moved_lines(one: Reading, other: Reading) -> dict[int, int]:
    """Lines of the stretches of a reading -> those of the same stretches in another one."""

    def lines(reading: Reading) -> list[int]:
        return [line for part in reading.stretches for line in (part.lines if isinstance(part, Timed) else [part.line])]

    return dict(zip(lines(one), lines(other), strict=True))


def off_the_plan(guarantees: Guarantees) -> float:
    """By how much a coordinate may end off the plan [m, rad]: the end is rounded, and what is too little stays."""
    return ROUNDING + max(1.5 * guarantees.resolution * max(MM, DEG), LEAST_WAY * MM)


def _require_same(program: Blocks, reading: Reading, guarantees: Guarantees) -> None:
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


SAME = 1e-8  # [m, rad] distance of equal poses, below the last decimal of any program
APPROACH_SHARE = 0.3  # share of the motion limits between home and the start: that move need not be fast


def motion_blocks(name: str, trajectory: Trajectory, block: float, speed: float) -> tuple[Block, ...]:
    """Blocks of a motion for a controller.

    Straight and circular moves and standstills stay as they are, joined motions become their parts in order,
    polynomials splines, measured standstills two with the trigger on in the second; all others become a timed path.

    Args:
        block: duration of a block of a timed path at full speed, at most [s].
        speed: share of the planned speed.
    """
    if isinstance(trajectory, Joined):
        return tuple(b for part in trajectory.parts for b in motion_blocks(name, part, block, speed))
    if isinstance(trajectory, StraightMove | CircularMove):
        return (replace(trajectory, profile=trajectory.profile.slowed(speed)),)
    if isinstance(trajectory, Standstill) and not trajectory.average:
        return (trajectory,)  # the same duration at any speed
    if isinstance(trajectory, Standstill):
        settle = (Standstill(trajectory.coordinates, trajectory.settle),) if trajectory.settle > 0.0 else ()
        return (*settle, Trigger(True), Standstill(trajectory.coordinates, trajectory.average), Trigger(False))
    if isinstance(trajectory, PolynomialMotion):
        return (timed_path(name, trajectory.slowed(speed), block, 1.0),)
    return (timed_path(name, trajectory, block, speed),)


SLOWER, ATTEMPTS = 0.8, 20  # share of the speed of an approach that is too hard by its controller's law, and tries


def _gentle(move: StraightMove, by: Guarantees) -> StraightMove:
    """A move that struts, sensors and joints bear as its controller makes it; itself where slowness does not help.

    A controller accelerates as hard as its set-up allows, however low the feed: with limited jerk it then comes less
    far.
    """
    slower = move
    for _ in range(ATTEMPTS):
        if mechanical_pace(by.lasting(slower), by.case, FORCE_RATE) <= 1.0 - UNUSED_SHARE:
            return slower
        slower = replace(slower, profile=slower.profile.slowed(SLOWER))
    return move


def excitation_program(trajectory: Trajectory, case: Case, speed: float = 1.0, by: Guarantees | None = None) -> Blocks:
    """The program: home, approach, settle, the excitation between trigger on and off, settle, back home.

    Where the motion contains measurements, the trigger is on in these alone: moves between them only take the machine
    to a place.

    Approach and return are point-to-point moves where the excitation consists of such moves, else timed paths: a
    controller that is set up to follow dense paths may accelerate as hard as it can in a move that it times itself.

    Args:
        speed: share of the planned speed.
        by: what the controller guarantees, by whose law approach and return then satisfy limits too.
    """
    home, box = case.need_motion("a program")
    controller = case.need_controller("a program")
    safe = controller.safe_feed if box.of_pose else controller.safe_share
    first, last = trajectory.at([0.0, trajectory.duration]).coordinates
    blocks: list[Block] = [ToHome(home, safe * min(1.0, speed))]
    excitation = motion_blocks("excitation", trajectory, controller.block, speed)
    own_time = not any(isinstance(b, TimedPath) for b in excitation)

    def straight(name: str, start: Array, end: Array) -> None:
        if np.max(np.abs(end - start)) < SAME:
            return
        share = [APPROACH_SHARE * limit for limit in (box.rate, box.acceleration, box.jerk)]
        move = slowed_for_forces(StraightMove.fastest(start, end, *share), case)
        if own_time:
            if by is not None and LimitKind.ACCELERATION in by.enforced:
                move = _gentle(move, by)
            blocks.extend([name, *motion_blocks(name, move, controller.block, speed)])
        else:
            blocks.append(timed_path(name, move, controller.block, speed))

    straight("approach", home, first)
    if any(isinstance(b, Trigger) for b in excitation):
        blocks += excitation
    else:
        before, after = (Standstill(pose, controller.settle_s) for pose in (first, last))
        blocks += [before, Trigger(True), *excitation, Trigger(False), after]
    straight("return", last, home)
    return tuple(blocks)
