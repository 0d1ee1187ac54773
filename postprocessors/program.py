"""The neutral program: what a controller shall do, block by block, before any dialect."""

from dataclasses import dataclass, replace
from itertools import groupby

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cases.errors import HexciteError
from cases.schema import Case
from identification.motion import Joined, Measurement, Motion, Standstill, Trajectory
from identification.trajectories.circle import CircularMove
from identification.trajectories.polynomial import PolynomialMotion, polynomials_of
from identification.trajectories.profile import StraightMove

Array = NDArray[np.float64]

SAME = 1e-8  # [m, rad] two poses are one, below the last decimal of any program
APPROACH_SHARE = 0.3  # of the motion limits, between home and the start: nobody needs that move to be fast


@dataclass(frozen=True, slots=True)
class Comment:
    """A remark for people.

    Args:
        text: any; dialects wrap it and replace what their controller cannot read.
    """

    text: str


@dataclass(frozen=True, slots=True)
class ToHome:
    """A straight move to home at a safe feed from wherever the machine stands.

    Args:
        pose: home, shape (6,) [m, rad].
        feed: along the path of the origin [m/s].
    """

    pose: Array
    feed: float


@dataclass(frozen=True, slots=True)
class PointToPoint:
    """A straight move in the six coordinates from rest to rest, exact stop at its end.

    Controllers know feeds, not durations: a dialect writes the feed that makes its controller's own time law, under the
    limits of the case, take as long as planned.

    Args:
        move: where from, where to, and the planned time law.
    """

    move: StraightMove

    @property
    def feed(self) -> float:
        """Largest speed of the planned move: of the origin [m/s], or of the angles where the origin rests [rad/s]."""
        return self.move.profile.peak_velocity * self.length

    @property
    def length(self) -> float:
        """Way of the origin [m], or of the angles where the origin rests [rad]: what feeds count."""
        way = self.move.end - self.move.start
        linear = float(np.linalg.norm(way[:3]))
        return linear if linear > 0.0 else float(np.linalg.norm(way[3:]))


@dataclass(frozen=True, slots=True)
class StrutPointToPoint:
    """A move straight in the struts from rest to rest, exact stop at its end: another path than planned.

    Its dialect writes the feed with which it takes as long as planned, or longer where its own path needs that.

    Args:
        planned: where from, where to, and the time law planned for the straight way.
    """

    planned: StraightMove


@dataclass(frozen=True, slots=True)
class Arc:
    """A circular move in a coordinate plane from rest to rest, exact stop at its end; full circles too.

    Args:
        move: where from, about what, how far, and the planned time law.
    """

    move: CircularMove

    @property
    def feed(self) -> float:
        """Largest speed of the origin in the planned move [m/s]."""
        return self.move.profile.peak_velocity * self.move.length


@dataclass(frozen=True, slots=True)
class TimedPath:
    """Poses to be passed at given times, from rest at the pose before to rest at the last.

    Args:
        name: what it is for.
        times: shape (k,), increasing, the first 0 [s].
        poses: shape (k, 6), the first is where the machine stands [m, rad].
        source: the motion that was sampled, on the clock of `times`, for dialects that can carry more than points.
    """

    name: str
    times: Array
    poses: Array
    source: Trajectory | None = None


@dataclass(frozen=True, slots=True)
class SplinePath:
    """Polynomial pieces, one after the other, from rest to rest: the exact path and time law of a spline.

    Args:
        name: what it is for.
        motion: its pieces, each with its duration.
    """

    name: str
    motion: PolynomialMotion


@dataclass(frozen=True, slots=True)
class Dwell:
    """Standing still.

    Args:
        duration: [s].
    """

    duration: float


@dataclass(frozen=True, slots=True)
class Trigger:
    """The recording's trigger, switched while the machine stands."""

    on: bool


Block = Comment | ToHome | PointToPoint | StrutPointToPoint | Arc | TimedPath | SplinePath | Dwell | Trigger


@dataclass(frozen=True, slots=True)
class Program:
    """A program.

    Args:
        header: comment lines that say where it comes from and what it was proven against.
        blocks: in order.
    """

    header: tuple[str, ...]
    blocks: tuple[Block, ...]

    @property
    def paths(self) -> tuple[TimedPath, ...]:
        """Its timed paths."""
        return tuple(b for b in self.blocks if isinstance(b, TimedPath))


def straight_in_struts(program: Program) -> Program:
    """The program with its point-to-point moves straight in the struts.

    Raises:
        HexciteError: it has none.
    """
    blocks = tuple(StrutPointToPoint(b.move) if isinstance(b, PointToPoint) else b for b in program.blocks)
    if blocks == program.blocks:
        raise HexciteError(
            "the plan has no point-to-point moves that could be straight in the struts; leave out --ptp-struts"
        )
    return replace(program, blocks=blocks)


def moves_as_polynomials(program: Program) -> Program:
    """The program with each run of point-to-point moves as one spline: the same path and time law, in cubic pieces."""
    blocks: list[Block] = []
    for together, group in groupby(program.blocks, lambda b: isinstance(b, PointToPoint)):
        found = list(group)
        if together:
            moves = [b.move for b in found if isinstance(b, PointToPoint)]
            found = [SplinePath("moves", polynomials_of(moves))]
        blocks += found
    return replace(program, blocks=tuple(blocks))


@dataclass(frozen=True, slots=True)
class Slowed:
    """A motion at a share of its speed: the same path, everything else slower.

    Args:
        motion: at full speed.
        speed: share of it, above 0.
    """

    motion: Trajectory
    speed: float

    @property
    def duration(self) -> float:
        """Duration [s]."""
        return self.motion.duration / self.speed

    def at(self, t: ArrayLike) -> Motion:
        """The motion at times t, shape (n,) [s]."""
        time = np.asarray(t, dtype=float)
        fast = self.motion.at(np.clip(time * self.speed, 0.0, self.motion.duration))
        s = self.speed
        return Motion(time, fast.pose, fast.rates * s, fast.accelerations * s**2, fast.jerks * s**3)


def _block_ends(trajectory: Trajectory, block: float) -> Array:
    knots = trajectory.times if isinstance(trajectory, PolynomialMotion) else np.array([0.0, trajectory.duration])
    counts = np.ceil(np.diff(knots) / block - 1e-9).astype(int).clip(1 if len(knots) > 2 else 2)
    steps = zip(knots, knots[1:], counts, strict=False)
    return np.append(np.concatenate([np.linspace(a, b, n, endpoint=False) for a, b, n in steps]), knots[-1])


def timed_path(name: str, trajectory: Trajectory, block: float, speed: float) -> TimedPath:
    """A trajectory as equally timed poses; of a spline the ends of its pieces are among them.

    Args:
        name: what it is for.
        trajectory: from rest to rest.
        block: duration of a block at full speed, at most [s].
        speed: share of the planned speed; 0.1 takes ten times as long.
    """
    times = _block_ends(trajectory, block)
    source = trajectory if speed == 1.0 else Slowed(trajectory, speed)
    return TimedPath(name, times / speed, trajectory.at(times).pose, source)


def motion_blocks(name: str, trajectory: Trajectory, block: float, speed: float) -> tuple[Block, ...]:
    """What a motion is to a controller.

    Straight and circular moves stay what they are, joined motions become their parts in order, standstills dwells,
    polynomials splines, measurements dwells with the trigger on in the second; whatever else becomes a timed path.

    Args:
        name: what it is for.
        trajectory: from rest to rest.
        block: duration of a block of a timed path at full speed, at most [s].
        speed: share of the planned speed.
    """
    if isinstance(trajectory, Joined):
        return tuple(b for part in trajectory.parts for b in motion_blocks(name, part, block, speed))
    if isinstance(trajectory, StraightMove):
        return (PointToPoint(replace(trajectory, profile=trajectory.profile.slowed(speed))),)
    if isinstance(trajectory, CircularMove):
        return (Arc(replace(trajectory, profile=trajectory.profile.slowed(speed))),)
    if isinstance(trajectory, Standstill):
        return (Dwell(trajectory.duration),)  # as long at any speed
    if isinstance(trajectory, Measurement):
        settle = (Dwell(trajectory.settle),) if trajectory.settle > 0.0 else ()
        return (*settle, Trigger(True), Dwell(trajectory.average), Trigger(False))
    if isinstance(trajectory, PolynomialMotion):
        return (SplinePath(name, trajectory.slowed(speed)),)
    return (timed_path(name, trajectory, block, speed),)


def excitation_program(trajectory: Trajectory, case: Case, header: tuple[str, ...], speed: float = 1.0) -> Program:
    """Home, approach, settle, the excitation between trigger on and off, settle, back home.

    Where the motion contains measurements, the trigger is on in these alone: moves between them only take the machine
    to a place.

    Approach and return are point-to-point moves where the excitation consists of such moves, else timed paths: a
    controller that is set up to follow dense paths may accelerate as hard as it can in a move that it times itself.

    Args:
        trajectory: the excitation, from rest to rest.
        case: home, limits and controller settings.
        header: comment lines.
        speed: share of the planned speed.

    Raises:
        CaseError: the case has no machine or no controller.
    """
    machine, _, limits = case.need_machine("a program")
    controller = case.need_controller("a program")
    home = machine.home.vector
    first, last = trajectory.at([0.0, trajectory.duration]).pose
    blocks: list[Block] = [ToHome(home, controller.safe_feed * min(1.0, speed))]
    excitation = motion_blocks("excitation", trajectory, controller.block, speed)
    own_time = not any(isinstance(b, TimedPath | SplinePath) for b in excitation)

    def straight(name: str, start: Array, end: Array) -> None:
        if np.max(np.abs(end - start)) < SAME:
            return
        box = limits.motion
        share = [APPROACH_SHARE * limit for limit in (box.rate, box.acceleration, box.jerk)]
        move = StraightMove.fastest(start, end, *share)
        if own_time:
            blocks.extend([Comment(name), *motion_blocks(name, move, controller.block, speed)])
        else:
            blocks.append(timed_path(name, move, controller.block, speed))

    straight("approach", home, first)
    if any(isinstance(b, Trigger) for b in excitation):
        blocks += excitation
    else:
        blocks += [Dwell(controller.settle_s), Trigger(True), *excitation, Trigger(False), Dwell(controller.settle_s)]
    straight("return", last, home)
    return Program(header, tuple(blocks))
