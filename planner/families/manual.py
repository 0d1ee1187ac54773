"""Hand-made excitations: the moves, circles and pauses of a file, or its poses, as fast as the limits allow."""

import math
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Annotated, ClassVar, Literal

import numpy as np
from pydantic import Field, model_validator

from cases.base.errors import Code, FileProblem, InfeasiblePlan
from cases.base.file_reading import MOST_TABLE, read_whole
from cases.base.units import Array
from cases.machine import POSE
from cases.schema import Case
from cases.tables import Number, Part, Positive, find_case, own_units, read_tables, si
from identification.limits.limit import UNUSED_SHARE
from identification.limits.proof import kinetic_shares, of_coordinates, of_mechanics, prove, prove_at
from identification.motion.motion import Joined, StandingPoses, Standstill, Trajectory
from identification.motion.moves import Plane, StraightMove, fastest_circle

SLOWEST = 0.02  # share of the speed; a move that needs less cannot be made at all
BISECTIONS = 12
RATE = 2000.0  # [1/s]
PLACES = 9  # places on the way of a step that are checked before it is timed
MOST_STEPS = 1000
SHARES = (1.0, 0.75, 0.5, 0.25, 0.1)  # of the way of a coordinate
STILL = 1e-9  # [m, rad] distance below which poses are the same

Build = Callable[[float], Trajectory]


class ManualStep(Part):
    """A straight move to a pose relative to home, a full circle, or a pause."""

    x_mm: Number = 0.0
    y_mm: Number = 0.0
    z_mm: Number = 0.0
    a_deg: Number = 0.0
    b_deg: Number = 0.0
    c_deg: Number = 0.0
    circle: Literal["XY", "ZX", "YZ"] | None = None
    """A full circle in this plane; its centre lies at `radius_mm` from its start, against the plane's first axis."""
    radius_mm: Positive | None = None
    pause_s: Positive | None = None
    speed: Annotated[float, Field(strict=True, gt=0.0, le=1.0)] = 1.0
    """Share of the limits of velocity; accelerations take its square, jerks its cube."""

    @model_validator(mode="after")
    def _one_kind(self) -> "ManualStep":
        fields = self.model_fields_set
        pose = fields & set(POSE)
        if (self.circle is None) != (self.radius_mm is None):
            raise ValueError("a circle needs circle and radius_mm, a move neither")
        if sum((bool(pose), self.circle is not None, self.pause_s is not None)) > 1:
            raise ValueError("a step is a move, a circle or a pause, not several; make separate steps")
        return self

    offset: ClassVar = si(*POSE)
    """Pose relative to home, shape (6,) [m, rad]."""


class Steps(Part):
    """A hand-made excitation: it begins and ends standing at home."""

    title: str
    steps: Annotated[tuple[ManualStep, ...], Field(min_length=1, max_length=MOST_STEPS)]


_WANTED = "name a TOML file of steps or a CSV of poses"


def load_sequence(file: Path, columns: Sequence[str] = POSE) -> Steps:
    """Reads a sequence from a TOML file, for a machine whose coordinates, `columns`, are the pose of a platform.

    Raises:
        FileProblem: it is not there, or the machine has other coordinates.
        CaseError: it describes no sequence; the message names the step.
    """
    if tuple(columns) != POSE:
        raise FileProblem(
            place=file,
            problem="holds steps of a platform",
            remedy=f"name a CSV of poses with {', '.join(columns)}",
            code=Code.WRONG_KIND,
        )
    if not file.is_file():
        reason = "Is a directory" if file.is_dir() else "No such file or directory"
        raise FileProblem(place=file, problem=f"cannot be read ({reason})", remedy=_WANTED, code=Code.UNREADABLE)
    return read_tables(Steps, file)


def load_poses(file: Path, columns: Sequence[str] = POSE) -> Array:
    """Reads poses from a CSV file with a column for each coordinate: of a platform absolute in {B}, or of joints.

    Shape (n, columns) [m or rad]; names of columns end in mm or deg.

    Raises:
        FileProblem: it cannot be read, columns are missing, or a row holds no numbers.
    """
    try:
        lines = read_whole(file, MOST_TABLE).decode().splitlines()
    except FileProblem as error:
        raise FileProblem(place=file, problem=error.problem, remedy=_WANTED, code=Code.UNREADABLE) from error
    except UnicodeDecodeError as error:
        raise FileProblem(
            place=file, problem=f"cannot be read ({error})", remedy=_WANTED, code=Code.UNREADABLE
        ) from error
    rows = [line.split(",") for line in lines if line.strip() and not line.startswith("#")]
    header = [cell.strip() for cell in rows[0]] if rows else []
    missing = [c for c in columns if c not in header]
    if missing:
        raise FileProblem(
            place=file,
            problem=f"column {missing[0]} is missing",
            remedy=f"the first line must name {', '.join(columns)}",
            code=Code.MISSING,
        )
    if not 1 <= len(rows) - 1 <= MOST_STEPS:
        raise FileProblem(
            place=file,
            problem=f"holds {len(rows) - 1} poses",
            remedy=f"1 to {MOST_STEPS} make an excitation",
            code=Code.OUT_OF_RANGE,
        )
    poses = []
    for number, row in enumerate(rows[1:], start=1):
        try:
            values = [float(row[header.index(c)]) for c in columns]
        except (ValueError, IndexError):
            values = [float("nan")]
        if not np.isfinite(values).all():
            raise FileProblem(
                place=file,
                problem=f"pose {number} holds no {len(columns)} numbers",
                remedy="mend that line",
                code=Code.WRONG_KIND,
            )
        poses.append(values)
    return np.asarray(np.array(poses) * own_units(columns))


def sequence_file(case: Case) -> Path | None:
    """The sequence that comes with a case; None where it has none."""
    file = find_case(case.origin).parent / "manual.toml"
    return file if file.is_file() else None


def in_turn(case: Case) -> Joined:
    """What people drive by hand where nobody wrote a sequence: each coordinate to both ends of its way, then all.

    Of each way as much as the limits of the machine allow: all of it, or the largest of SHARES. A coordinate that
    cannot move alone is left out.

    Raises:
        InfeasiblePlan: nothing can move.
    """
    home, limits = case.need_motion("a manual motion")
    ends = np.array(limits.coordinates) * (1.0 - UNUSED_SHARE)
    parts: list[Trajectory] = []
    for moved in (*np.eye(len(home)), np.ones(len(home))):
        for share in SHARES:
            low, high = home + share * moved * ends
            try:
                parts += [
                    fastest_within_limits(case, build, "", "") for _, build in _through(home, [high, low, home], case)
                ]
            except InfeasiblePlan:
                continue
            break
    if not parts:
        raise InfeasiblePlan(
            place="a manual motion",
            problem="no coordinate can move from home",
            remedy="write manual.toml",
            code=Code.INFEASIBLE,
        )
    return Joined(tuple(parts))


def manual_motion(case: Case, file: Path) -> Joined:
    """The motion of a file of steps (TOML) or of poses (CSV), from home to home.

    Raises:
        FileProblem, CaseError: the file cannot be used.
        InfeasiblePlan: a step leaves the limits however slow it is.
    """
    home, limits = case.need_motion("a manual motion")
    if file.suffix.lower() == ".csv":
        builds = _through(home, [*load_poses(file, limits.columns), home], case)
    else:
        builds = _steps(load_sequence(file), home, case)
    remedy = "choose another pose or a smaller circle"
    parts = [fastest_within_limits(case, build, f"{file}: step {number}", remedy) for number, build in builds]
    if not any(not isinstance(p, Standstill) for p in parts):
        raise FileProblem(
            place=file, problem="nothing moves", remedy="name poses away from home", code=Code.NO_EXCITATION
        )
    return Joined(tuple(parts))


def _limits(case: Case, speed: float) -> tuple[Array, Array, Array]:
    box = case.need_motion("a manual motion")[1]
    share = speed * (1.0 - UNUSED_SHARE)
    return box.rate * share, box.acceleration * share**2, box.jerk * share**3


def _move(case: Case, start: Array, end: Array, speed: float) -> Build:
    return lambda slower: StraightMove.fastest(start, end, *_limits(case, speed * slower))


def _through(home: Array, poses: list[Array], case: Case) -> Iterable[tuple[int, Build]]:
    at = home
    for number, pose in enumerate(poses, start=1):
        if np.abs(pose - at).max() > STILL:
            yield number, _move(case, at, pose, 1.0)
            at = pose


def _steps(sequence: Steps, home: Array, case: Case) -> Iterable[tuple[int, Build]]:
    at = home
    for number, step in enumerate(sequence.steps, start=1):
        if step.pause_s is not None:
            yield number, _pause(at, step.pause_s)
        elif step.circle is not None and step.radius_mm is not None:
            yield number, _circle(case, at, Plane(step.circle), step.radius_mm * 1e-3, step.speed)
        else:
            end = home + step.offset
            if np.abs(end - at).max() > STILL:
                yield number, _move(case, at, end, step.speed)
                at = end
    if np.abs(home - at).max() > STILL:
        yield len(sequence.steps) + 1, _move(case, at, home, 1.0)


def _pause(pose: Array, duration: float) -> Build:
    return lambda _: Standstill(pose, duration)


def _circle(case: Case, start: Array, plane: Plane, radius: float, speed: float) -> Build:
    first, second, _ = plane.axes
    centre = np.array([start[first] - radius, start[second]])
    return lambda slower: fastest_circle(start, plane, centre, 2 * np.pi, *_limits(case, speed * slower))


def fastest_within_limits(case: Case, build: Build, place: str, remedy: str) -> Trajectory:
    """A motion at full speed if it satisfies every limit, else slowed until it does.

    Args:
        build: share of the speed -> the motion.
        place: name of the motion, for messages.
        remedy: what to do where no speed helps.

    Raises:
        InfeasiblePlan: no speed helps.
    """
    way = build(1.0)
    _require_reach(way, case, place, remedy)
    if isinstance(way, Standstill):
        return way

    def satisfies(slower: float) -> bool:
        return prove(build(slower), case, RATE).worst_ratio <= 1.0 - UNUSED_SHARE / 2

    if satisfies(1.0):
        return way
    shares = kinetic_shares(way, case, np.linspace(0.0, way.duration, math.ceil(way.duration * RATE)))
    most = max(float(share.max()) ** (1 / power) for power, share in enumerate(shares, start=1))
    high = max(
        (1.0 - UNUSED_SHARE) / most, SLOWEST
    )  # the same way in more time: shares shrink with powers of the speed
    if satisfies(high):
        return build(high)
    low = SLOWEST  # forces of sensors do not shrink so
    if not satisfies(low):
        worst = prove(build(low), case, RATE).violations
        words = worst[0].sentence() if worst else "a limit is all but used up"
        raise InfeasiblePlan(place=place, problem=words, remedy=remedy, code=Code.INFEASIBLE)
    for _ in range(BISECTIONS):
        middle = (low + high) / 2
        low, high = (middle, high) if satisfies(middle) else (low, middle)
    return build(low)


def _require_reach(way: Trajectory, case: Case, place: str, remedy: str) -> None:
    """Raises InfeasiblePlan where standing somewhere on the way exceeds a limit: no pace helps, nor is it timed."""
    poses = way.at(np.linspace(0.0, way.duration, PLACES)).coordinates
    for limited in (of_coordinates, of_mechanics):  # values of the latter may overflow miles away
        report = prove_at(StandingPoses(poses), case, np.arange(float(len(poses))), limited=limited)
        if not report.kept:
            worst = report.violations[0].sentence(timed=False)
            raise InfeasiblePlan(place=place, problem=worst, remedy=remedy, code=Code.INFEASIBLE)
