"""Proves a program's text inside the limits of a case, or says at which line it is not."""

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from cases.errors import ProgramError
from cases.schema import Case
from cases.units import MM
from identification.limits import PROOF_RATE, LimitCheck, LimitReport, Status, prove, prove_at, worst_of
from identification.motion import Array, Motion, Standstill
from postprocessors.reading.words import Reading
from postprocessors.stretches import Still, Stretch, Timed, Untimed, stretches

SAMPLES_A_BLOCK = 100
SAMPLES_A_LINE = 1000.0  # for moves at constant speed: straight lines need no fine grid
BY_CONTROLLER = {"acceleration", "angular acceleration", "strut acceleration"}
FROM_UNKNOWN = {"angular velocity": Status.ENFORCED, "strut velocity": Status.NOT_ENFORCED}
BY_NOBODY = {"jerk", "angular jerk"}


@dataclass(frozen=True, slots=True)
class Violation:
    """A limit that the program passes.

    Args:
        line: of the program.
        check: which limit, and by how much.
    """

    line: int
    check: LimitCheck

    def sentence(self) -> str:
        """Line, value and limit."""
        return f"line {self.line}: {self.check.sentence()}"


@dataclass(frozen=True, slots=True)
class ProgramProof:
    """What the proof found.

    Args:
        file: the program.
        blocks: lines that hold words.
        duration: of everything whose duration is known [s].
        excitation: duration of the motion with the trigger on [s].
        limits: worst case of each limit.
        violations: limits that are passed, the worst first.
    """

    file: str
    blocks: int
    duration: float
    excitation: float
    limits: LimitReport
    violations: tuple[Violation, ...]

    @property
    def ok(self) -> bool:
        """Whether every limit that the program itself is answerable for is kept."""
        return not self.violations

    def require(self) -> None:
        """Raises ProgramError, naming line, value and limit, unless the proof holds."""
        if self.violations:
            first = self.violations[0]
            more = f" ({len(self.violations) - 1} more)" if len(self.violations) > 1 else ""
            raise ProgramError(
                self.file, first.line, 0, f"{first.check.sentence()}; slow down or change the move{more}"
            )


@dataclass(frozen=True, slots=True)
class _ConstantSpeed:
    """A straight line in the coordinates at constant rates; its ends are the controller's."""

    start: Array
    end: Array
    duration: float

    def at(self, t: ArrayLike) -> Motion:
        time = np.asarray(t, dtype=float)
        way = self.end - self.start
        pose = self.start + (time / self.duration)[:, None] * way
        none = [np.zeros((len(time), 6)) for _ in range(2)]
        return Motion(time, pose, np.tile(way / self.duration, (len(time), 1)), *none)


def prove_program(reading: Reading, case: Case) -> ProgramProof:
    """Proves a program that was read.

    Timed paths are proven at 10 kHz, or at a hundred samples a block where blocks are longer than 10 ms, under the
    assumption that the controller passes the points at their times along the quintic spline through them. Moves whose
    time law is the controller's are proven in their geometry and speed; their acceleration is the controller's to keep,
    if its own limits are those of the case, and their jerk nobody's.

    Raises:
        ProgramError: the motion is not defined.
        CaseError: the case has no machine.
    """
    parts = stretches(reading, case)
    if not any(isinstance(p, Timed | Untimed) for p in parts):
        raise ProgramError(reading.file, 0, 0, "contains no motion; is this the right file?")
    clock, excitation = 0.0, 0.0
    reports: list[LimitReport] = []
    violations: list[Violation] = []
    for part in parts:
        report, duration = _judge(part, case, clock)
        reports.append(report)
        violations += [Violation(_line(part, v.time - clock), v) for v in report.violations]
        clock += duration
        excitation += duration if _excites(part) else 0.0
    worst_first = tuple(sorted(violations, key=lambda v: -v.check.ratio))
    return ProgramProof(reading.file, reading.blocks, clock, excitation, worst_of(reports), worst_first)


def _excites(part: Stretch) -> bool:
    return part.trigger and not isinstance(part, Still)


def _line(part: Stretch, time: float) -> int:
    return part.line_at(time) if isinstance(part, Timed) else part.line


def _judge(part: Stretch, case: Case, clock: float) -> tuple[LimitReport, float]:
    if isinstance(part, Timed):
        return prove_at(part.points, case, _instants(part), clock), part.points.duration
    if isinstance(part, Still):
        return LimitReport(()), part.duration
    return _untimed(part, case, clock), part.duration or 0.0


def _instants(part: Timed) -> Array:
    """10 kHz in blocks of up to 10 ms, a hundred instants in each longer one: slow programs need no fine grid."""
    steps = np.diff(part.points.times)
    counts = np.clip(np.ceil(steps * PROOF_RATE - 1e-9), 1, SAMPLES_A_BLOCK).astype(int)
    first = np.repeat(np.cumsum(counts) - counts, counts)
    share = (np.arange(counts.sum()) - first) / np.repeat(counts, counts)
    inside = np.repeat(part.points.times[:-1], counts) + share * np.repeat(steps, counts)
    return np.append(inside, part.points.times[-1])


def _untimed(part: Untimed, case: Case, clock: float) -> LimitReport:
    """Geometry and speed; what depends on the controller's time law says who answers for it."""
    if part.start is None or part.duration is None or part.duration == 0.0:
        report = prove(Standstill(part.end, 0.0), case, 1.0, clock)
        if part.start is not None:
            return LimitReport(tuple(_relabelled(report.checks, case)))
        # What turns on the way from an unknown pose turns as fast as it must: the axis limits of the controller hold.
        checks = [
            replace(c, name=f"{kind}, untimed moves", ratio=0.0, status=FROM_UNKNOWN[kind])
            if kind in FROM_UNKNOWN
            else c
            for c, kind in ((c, c.name.split(" (")[0]) for c in _relabelled(report.checks, case))
        ]
        return LimitReport((*checks, *_speed_checks(part, case, clock)))
    line = _ConstantSpeed(part.start, part.end, part.duration)
    return LimitReport(tuple(_relabelled(prove(line, case, SAMPLES_A_LINE / part.duration, clock).checks, case)))


def _speed_checks(part: Untimed, case: Case, clock: float) -> Iterable[LimitCheck]:
    """The feed of a move from an unknown pose against the lowest velocity limit: it may run along any axis."""
    if part.feed is None:
        return
    limits = case.need_machine("the check of a program")[2].motion
    lowest = float(limits.rate[:3].min())
    name = "velocity (feed to home)"
    yield LimitCheck(name, part.feed / MM, lowest / MM, "mm/s", part.feed / lowest, clock, Status.PROVEN)


def _relabelled(checks: Iterable[LimitCheck], case: Case) -> Iterable[LimitCheck]:
    """Kinetic limits of moves that the controller times, under names of their own: they must not hide proven ones."""
    headroom = case.need_controller("the check of a program").linuxcnc.acceleration_headroom
    for check in checks:
        kind = check.name.split(" (")[0]
        if kind in BY_NOBODY:
            yield replace(check, name=f"{kind}, untimed moves", ratio=0.0, status=Status.NOT_ENFORCED)
        elif kind in BY_CONTROLLER:
            struts = kind.startswith("strut")
            status = Status.ENFORCED if headroom <= 1.0 and not struts else Status.NOT_ENFORCED
            yield replace(check, name=f"{kind}, untimed moves", ratio=0.0, status=status)
        else:
            yield check
