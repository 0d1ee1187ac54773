"""The limits of one stretch of a program: proven from its text, enforced by the controller, or neither."""

from collections.abc import Iterable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from cases.base.errors import Code, ProgramError
from cases.chain import Box
from cases.schema import Case
from identification.limits.limit import Limit, LimitCheck, LimitKind, LimitReport, OwnMove, Status, worst_of
from identification.limits.proof import (
    PROOF_RATE,
    Limited,
    of_coordinates,
    of_mechanics,
    of_velocities,
    prove,
    prove_at,
    shares_at,
    worst_case,
)
from identification.motion.curves import PolynomialMotion, Tabulated
from identification.motion.motion import Array, Standstill, TimedPoints, Trajectory
from identification.motion.moves import CircularMove, StraightMove
from postprocessors.proof.guarantees import Guarantees
from postprocessors.proof.homing import at_a_crawl, predicted, way_home
from postprocessors.reading import Still, Stretch, Timed, Untimed

FEWEST, MOST = 64, 1000  # samples of a move that the controller times: smooth, whatever its duration
RATES = LimitKind.VELOCITY, LimitKind.STRUT_VELOCITY
SENSED = LimitKind.SENSOR_FORCE, LimitKind.SENSOR_MOMENT
BY_TIME_LAW = LimitKind.ACCELERATION, LimitKind.JERK, LimitKind.STRUT_ACCELERATION


def judge(part: Stretch, by: Guarantees) -> tuple[LimitReport, float]:
    """Limits of a stretch, on its own clock, and its duration [s].

    Timed paths and moves with the trigger on are excitations, with the box of `[limits.motion]`; moves without it take
    the machine to a place, with the limits of `[workspace]`, as the rows of a table, in which every move is timed.
    """
    if isinstance(part, Timed):
        return LimitReport(tuple(_timed(part, by))), part.points.duration
    if isinstance(part, Still):
        return LimitReport(()), part.duration
    if part.start is None:
        return LimitReport(tuple(way_home(part, by))), 0.0
    if part.within is not None:
        return LimitReport(tuple(at_a_crawl(part, by))), 0.0
    motion = predicted(part, by)
    if motion is None:
        return prove(Standstill(part.end, 0.0), by.case, 1.0, part.trigger), 0.0
    return LimitReport(tuple(_own_time(part, motion, by))), motion.duration


PARTS = 1e-3  # share of a cycle by which a block may differ from whole ones: rounding of F


def require_timing(part: Timed, by: Guarantees, file: str) -> None:
    """Raises ProgramError for a block that is below a cycle, and would last longer, or too long for a known law."""
    steps, shortest, longest = np.diff(part.points.times), by.shortest_block, by.longest_block
    cycles = steps / shortest if by.even_blocks else np.ones(1)
    timed = (steps >= shortest * (1 - 1e-6)) & (steps <= longest * (1 + 1e-6))
    if not (right := timed & (np.abs(cycles - np.round(cycles)) <= PARTS)).all():
        k = int(np.argmin(right))
        most = f"to {1e3 * longest:g} ms" if np.isfinite(longest) else "ms and more"
        times = f"{1e3 * shortest:g} {most}" + (" in whole cycles" if by.even_blocks else "")
        problem = f"the timed block takes {1e3 * steps[k]:.6g} ms; {by.controller} keeps times of {times}"
        raise ProgramError(
            file=file, line=part.lines[k], problem=problem, remedy=by.timing_remedy, code=Code.NOT_PROVEN
        )


def _timed(part: Timed, by: Guarantees) -> Iterable[LimitCheck]:
    """Checks of a timed path: values between its points are proven only where the controller follows the curve."""
    in_box = part.trigger or not isinstance(part.points, Tabulated)
    report = prove_path(part.points, by.case, in_box)
    if isinstance(part.points, PolynomialMotion):
        steps = tuple(joint_checks(part.points, by.limits, by.shortest_block))
        report = worst_of([report, LimitReport(steps)])
    for check in report.checks:
        kind = check.kind.family
        if kind in by.without and by.status_of(check.kind) is Status.LEFT_OUT:
            yield replace(check, status=Status.LEFT_OUT, binding=False)
        elif by.follows_paths:
            yield check
        elif kind in SENSED:
            yield by.sensed(check)
        elif kind in BY_TIME_LAW or (kind in RATES and not by.even_blocks):
            yield replace(check, status=by.status_of(check.kind))
        else:
            yield check


def _own_time(part: Untimed, motion: StraightMove | CircularMove, by: Guarantees) -> Iterable[LimitCheck]:
    """Checks of a move: geometry and programmed speed are proven; values from the controller's law are predicted.

    Where the text states the acceleration too, the law is the text's, and all but the jerk is proven.
    """
    count = int(np.clip(np.ceil(motion.duration * PROOF_RATE), FEWEST, MOST))
    report = prove_at(motion, by.case, np.linspace(0.0, motion.duration, count + 1), part.trigger)
    limits = {c.kind: c for c in _asked(part, motion, by)}

    def lawful(check: LimitCheck) -> Status:  # how accelerations are shared in an arc is less well known
        return by.lawful(check) if isinstance(motion, StraightMove) else by.status_of(check.kind)

    for check in report.checks:
        family = check.kind.family
        if part.acceleration is not None and family is not LimitKind.JERK:
            yield check
            continue
        match family:
            case LimitKind.VELOCITY:
                yield by.prediction(check) if part.feed is None else limits[check.kind]
            case LimitKind.STRUT_VELOCITY:
                fastest = limits.get(check.kind)
                if fastest is None or not fastest.kept:
                    yield by.prediction(check, status=lawful(check))
                elif part.feed is None:  # the fastest within the enforced rates of all coordinates
                    yield by.prediction(fastest, status=Status.ENFORCED)
                else:
                    yield fastest  # the check at full feed everywhere on the way
            case LimitKind.ACCELERATION | LimitKind.STRUT_ACCELERATION:
                yield by.prediction(check, status=lawful(check))
            case LimitKind.SENSOR_FORCE | LimitKind.SENSOR_MOMENT:
                yield by.sensed(check, OwnMove.UNTIMED, lawful(check))
            case LimitKind.JOINT_TORQUE | LimitKind.JOINT_FORCE:
                yield by.prediction(check, status=lawful(check))
            case LimitKind.JERK:
                yield _jerk(check, motion, by)
            case _:
                yield check


def _jerk(check: LimitCheck, motion: Trajectory, by: Guarantees) -> LimitCheck:
    """The check of jerk: without a jerk limit accelerations step within a cycle, by twice the peak at a reversal."""
    cycle = by.jerk_time
    if cycle <= 0.0:
        return by.prediction(check)
    axes = by.limits.turns if check.kind is LimitKind.ANGULAR_JERK else ~by.limits.turns
    peak = np.abs(motion.at(np.linspace(0.0, motion.duration, FEWEST + 1)).accelerations).max(axis=0)
    steps = 2.0 * peak[axes] / cycle
    limit = by.limits.jerk[axes]
    k = int(np.argmax(steps / limit))
    ratio = float(steps[k] / limit[k])
    return by.prediction(replace(check, worst=float(steps[k]), limit=float(limit[k]), ratio=ratio))


def _asked(part: Untimed, motion: StraightMove | CircularMove, by: Guarantees) -> Iterable[LimitCheck]:
    """Velocities at the programmed feed from end to end, whether or not the controller slows down.

    For a rapid, velocities at the limits of the coordinates, if the controller enforces these.
    """
    if part.feed is not None:
        speed = part.feed / part.length
    elif LimitKind.VELOCITY in by.enforced and isinstance(motion, StraightMove):
        way = np.abs(motion.end - motion.start)
        speed = float(np.min(by.limits.rate[way > 0.0] / way[way > 0.0]))
    else:
        return
    t = np.linspace(0.0, 1.0 / speed, FEWEST + 1)
    none = np.zeros_like(t)
    for quantity in of_velocities(motion.along(t, (t * speed, none + speed, none, none)), by.case):
        yield worst_case(quantity, t)


FINE, ROUGH, ROUGH_RATE = 100, 10, 4000.0  # most instants in a block, of both grids, and in a second of the rough one
# Share of a limit from which a block has a fine grid, and how many of the worst have.
NEAR_LIMIT, WORST_BLOCKS = 0.9, 30


def prove_path(motion: TimedPoints | PolynomialMotion | Tabulated, case: Case, in_box: bool) -> LimitReport:
    """Checks every limit of a timed path, at most at 10 kHz and at a hundred instants a block.

    Slow programs need no finer grid. Blocks that stay far from a limit, and from what the path reaches elsewhere, are
    judged by a tenth of that: those of the coordinates and those of the mechanics, which rarely come near together.

    Args:
        in_box: whether it must keep the pose box of `[limits.motion]`.
    """
    reports = []
    for limited in (of_coordinates, of_mechanics):
        for instants in _critical_instants(motion, motion.times, case, in_box, limited):
            reports.append(prove_at(motion, case, instants, in_box, limited))
    return worst_of(reports)


def _critical_instants(motion: Trajectory, times: Array, case: Case, in_box: bool, limited: Limited) -> list[Array]:
    """Instants that include the worst of each limit and all that are near one [s], without gaps in each array.

    What is between two instants is judged by both: those of blocks with others between them do not belong together.
    """
    rough, starts = _grid(times, ROUGH, ROUGH_RATE)
    shares = np.maximum.reduceat(shares_at(motion, case, rough, in_box, limited), starts, axis=0)
    blocks = np.asarray((shares >= NEAR_LIMIT).any(axis=1))
    blocks[np.argsort(shares, axis=0)[-WORST_BLOCKS:]] = True
    fine, starts = _grid(times, FINE, PROOF_RATE)
    bounds = np.append(starts, len(fine) - 1)
    edges = np.flatnonzero(np.diff(blocks.astype(int), prepend=0, append=0))  # of runs of such blocks
    return [fine[bounds[first] : bounds[end] + 1] for first, end in edges.reshape(-1, 2)]


def _grid(times: Array, most: int, rate: float) -> tuple[Array, NDArray[np.int64]]:
    """Instants at a rate [1/s], but at most `most` a block, and the index of the first of each block."""
    steps = np.diff(times)
    counts = np.clip(np.ceil(steps * rate - 1e-9), 1, most).astype(np.int64)
    starts = np.cumsum(counts) - counts
    share = (np.arange(counts.sum()) - np.repeat(starts, counts)) / np.repeat(counts, counts)
    return np.append(np.repeat(times[:-1], counts) + share * np.repeat(steps, counts), times[-1]), starts


def joint_checks(motion: PolynomialMotion, limits: Box, cycle: float) -> Iterable[LimitCheck]:
    """Accelerations and jerks by steps between pieces, at rest before the first and after the last.

    A step dv of a rate within a cycle c is an acceleration of dv / c and, up and down again, a jerk of 2 dv / c^2; a
    step da of an acceleration is a jerk of da / c.
    """
    rest = np.zeros((1, len(limits.rate)))
    dv, da = (
        np.abs(np.vstack([motion.at_starts(order), rest]) - np.vstack([rest, motion.at_ends(order)]))
        for order in (1, 2)
    )
    jerks = np.maximum(da / cycle, 2 * dv / cycle**2)
    for kinds, values, most in (
        ((LimitKind.ACCELERATION, LimitKind.ANGULAR_ACCELERATION), dv / cycle, limits.acceleration),
        ((LimitKind.JERK, LimitKind.ANGULAR_JERK), jerks, limits.jerk),
    ):
        for kind, axes in zip(kinds, (~limits.turns, limits.turns), strict=True):
            if axes.any():
                ratio = np.where(axes, np.nan_to_num(values / most, nan=np.inf), -1.0)
                row, k = np.unravel_index(int(np.argmax(ratio)), ratio.shape)
                worst = float(values[row, k]), float(most[k]), kind.unit, float(ratio[row, k])
                place, time = f"{limits.labels[k]}, step between blocks", float(motion.times[row])
                yield LimitCheck(Limit(kind), place, *worst, time, Status.PROVEN)
