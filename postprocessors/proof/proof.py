"""Proves that a program's text is inside the limits of a case, or names the line where it is not."""

import math
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from cases.base.errors import Code, NotProven, ProgramError, Violation, choice, option
from cases.base.phrases import Phrase, enumerated, phrase
from cases.base.units import DEG, MM
from cases.chain import Box
from cases.controller import ControllerName
from identification.limits.limit import (
    KINETIC,
    NAMED,
    TOLERANCE,
    LimitCheck,
    LimitKind,
    LimitReport,
    Status,
    worst_of,
)
from identification.motion.motion import Array
from postprocessors.proof.guarantees import Guarantees, WayToFirst
from postprocessors.proof.judging import judge, require_timing
from postprocessors.reading import Reading, Still, Stretch, Timed, Untimed

MOST_TIMES = 10.0  # multiple of a limit above which the number itself does not matter


@dataclass(frozen=True, slots=True)
class ProgramProof:
    """The proof of a program."""

    file: str  # name of the program
    controller: str  # controller that would run it
    duration: float  # duration of everything whose duration is known [s]
    excitation: float  # duration of the motion with the trigger on [s]
    limits: LimitReport  # worst case of each limit
    violations: tuple[LimitCheck, ...]  # limits that are exceeded, with their lines, the worst first
    remarks: tuple[str, ...]  # remarks beside the limits: where it begins and ends
    # the worst limit of lines: of every move whose time the controller decides, and of a path that the program times,
    # those lines in which one of its limits comes closest
    of_lines: tuple[LimitCheck, ...] = ()
    plan_for: ControllerName | None = None  # name by which moves are planned for that controller

    @property
    def ok(self) -> bool:
        """Whether every limit that depends on the program alone is satisfied."""
        return not self.violations

    @property
    def relies_on(self) -> tuple[LimitKind, ...]:
        """Families of limits that nobody enforces, in the order of the report: `jerk`, `strut acceleration`."""
        return self._families(Status.NOT_ENFORCED)

    @property
    def without(self) -> tuple[LimitKind, ...]:
        """Families of limits that the plan of the program leaves out, and says so: `jerk`."""
        return self._families(Status.LEFT_OUT)

    def _families(self, status: Status) -> tuple[LimitKind, ...]:
        return tuple(dict.fromkeys(c.kind.family for c in self.limits.checks if c.status is status))

    @property
    def verdict(self) -> str:
        """The proof in one line, which claims no more than was proven."""
        if self.violations:
            return "NOT proven"
        left_out = f", without {', '.join(self.without)} as planned" if self.without else ""
        families = [kind for kind in self._families(Status.ENFORCED) if kind not in self.relies_on]
        exceeded = self._exceeded
        within = [kind for kind in self.relies_on if kind not in exceeded]
        phrases = {
            f"{self.controller} enforces": families,
            "nobody enforces": within,
            "EXCEEDED, as predicted, and nobody enforces": exceeded.values(),
        }
        clauses = (f"{phrase}: {', '.join(names)}" for phrase, names in phrases.items() if names)
        return "; ".join([f"proven{left_out}", *clauses])

    @property
    def _exceeded(self) -> dict[LimitKind, str]:
        """Limits that nobody enforces and the motion is predicted to exceed, each with its share in words."""
        nobodys = [c for c in self.limits.checks if c.status is Status.NOT_ENFORCED]
        worst = {kind: max(c.ratio for c in nobodys if c.kind.family is kind) for kind in self.relies_on}
        return {
            kind: f"{kind} ({f'{100 * ratio:.0f} %' if ratio <= MOST_TIMES else 'more than ten times'})"
            for kind, ratio in worst.items()
            if ratio > 1.0 + TOLERANCE
        }

    def require_accepted(self, accepted: Collection[str]) -> None:
        """Raises ProgramError unless the proof holds and every limit that nobody enforces is accepted by name.

        Args:
            accepted: families of limits, as in `relies_on`; a hyphen counts as a blank.
        """
        self.require()
        names = {name.strip().lower().replace("-", " ") for name in accepted}
        if unknown := sorted(names - set(KINETIC)):
            raise ProgramError(
                file=self.file,
                problem=f"{option('accept')} {unknown[0]!r} names no such limit",
                remedy=choice(unknown[0], KINETIC, "choose from"),
                code=Code.UNKNOWN,
            )
        open_ = [name for name in self.relies_on if name not in names]
        if open_:
            exceeded = [words for name, words in self._exceeded.items() if name in open_]
            problem = "{controller} does not enforce {limits} in this motion, and nothing else does; {predicted}"
            predicted = (
                phrase("exceeded_as_predicted", "EXCEEDED, as predicted: {limits}", limits=", ".join(exceeded))
                if exceeded
                else phrase("none_exceeded", "none is predicted to be exceeded")
            )
            accept = f"{option('accept')} {','.join(name.replace(' ', '-') for name in open_)}"
            limits = enumerated("comma", [phrase(NAMED, "{name}", name=name) for name in open_])
            raise ProgramError(
                file=self.file,
                problem=phrase(
                    "nobody_enforces", problem, controller=self.controller, limits=limits, predicted=predicted
                ),
                remedy=self._planned(open_, accept),
                code=Code.NOT_PROVEN,
            )

    def _planned(self, families: Collection[LimitKind], accept: str) -> Phrase:
        """The remedy that needs no `--accept`: a plan that leaves the jerk out, or none where that is not enough."""
        if LimitKind.JERK not in families:
            return phrase("write_with", "write it with {accept} if the machine can bear it", accept=accept)
        made_for = "" if self.plan_for is None else f"{option('controller', 'for')} {self.plan_for} "
        return phrase(
            "plan_without_jerk",
            "plan moves for it with {family} {made_for}{without} jerk (poses with {without} jerk), or write this one "
            "with {accept} if the machine can bear it",
            family=option("family PointToPoint", "family ptp"),
            made_for=made_for,
            without=option("without"),
            accept=accept,
        )

    def require(self) -> None:
        """Raises NotProven, naming line, value and limit, unless the proof holds."""
        if self.violations:
            first = self.violations[0]
            faster = first.kind.kinetic or first.kind is LimitKind.FEED_TO_HOME
            raise NotProven(
                file=self.file,
                violations=self.exceeded,
                remedy=phrase("slow_down", "slow down or change the move")
                if faster
                else phrase("change_move", "change the move"),
            )

    def at_lines(self, lines: Mapping[int, int]) -> "ProgramProof":
        """The same proof of a text whose lines have other numbers: line as proven -> line there."""

        def moved(checks: tuple[LimitCheck, ...]) -> tuple[LimitCheck, ...]:
            return tuple(replace(check, line=lines[check.line]) for check in checks)

        return replace(self, violations=moved(self.violations), of_lines=moved(self.of_lines))

    def lines_to_json(self) -> list[dict[str, Any]]:
        """What `of_lines` says, an object a line: number, limit, share that is used, and whether it is enforced."""
        return [
            {"line": check.line, "limit": check.name, "ratio": check.ratio, "status": str(check.status)}
            for check in self.of_lines
        ]

    @property
    def exceeded(self) -> tuple[Violation, ...]:
        """The violations in words."""
        return tuple(Violation(v.line, str(v.kind.family), v.sentence()) for v in self.violations)


def prove_program(reading: Reading, guarantees: Guarantees) -> ProgramProof:
    """Proves a program that was read: timed paths at up to 10 kHz, moves whose time law is the controller's in geometry
    and feed, with the rest predicted.

    Raises:
        ProgramError: the motion is not defined, or a timed block is shorter or longer than the controller can time.
    """
    if not any(isinstance(part, Timed | Untimed) for part in reading.stretches):
        raise ProgramError(
            file=reading.file,
            problem=phrase("no_motion_in_program", "contains no motion"),
            remedy=phrase("right_file", "is this the right file?"),
            code=Code.WRONG_KIND,
        )
    clock, excitation = 0.0, 0.0
    reports: list[LimitReport] = []
    violations: list[LimitCheck] = []
    of_lines: dict[int, LimitCheck] = {}
    for part in reading.stretches:
        if isinstance(part, Timed):
            require_timing(part, guarantees, reading.file)
        report, duration = judge(part, guarantees)
        checks = [replace(check, line=_line_of(part, check), time=check.time + clock) for check in report.checks]
        violations += [check for check in checks if not check.kept]
        for check in checks:
            if math.isfinite(check.ratio) and check.ratio > getattr(of_lines.get(check.line), "ratio", -math.inf):
                of_lines[check.line] = check
        reports.append(report.later(clock))
        clock += duration
        excitation += duration if part.trigger and not isinstance(part, Still) else 0.0
    worst_first = tuple(sorted(violations, key=lambda v: -v.ratio))
    return ProgramProof(
        reading.file,
        guarantees.controller,
        clock,
        excitation,
        worst_of(reports),
        worst_first,
        tuple(remarks(reading, guarantees)),
        tuple(of_lines[line] for line in sorted(of_lines)),
        guarantees.plan_for,
    )


def _line_of(part: Stretch, check: LimitCheck) -> int:
    """The line in which a limit of a stretch comes closest."""
    return part.line_at(check.time) if isinstance(part, Timed) else part.line


AT_HOME = 1e-5 * MM, 1e-6 * DEG  # the last decimal of a program


def remarks(reading: Reading, guarantees: Guarantees) -> Iterator[str]:
    """Remarks beside the limits, one sentence each; raises CaseError where the case has no machine."""
    case = guarantees.case
    home, limits = case.need_motion("the check of a program")
    moves = [part for part in reading.stretches if not isinstance(part, Still)]
    first = moves[0]
    if isinstance(first, Untimed) and first.start is None:
        sensed = "" if case.sensor_frame.struts is None or case.sensors.range is None else "forces in struts, "
        yield (
            f"line {first.line}: from wherever the machine stands its way is not known, and neither are struts, "
            f"{sensed}joints and boxes on it; keep it clear"
        )
        if distance := _away(first.end, home, limits):
            yield f"line {first.line}: the first move does not go home, {distance}"
    elif reading.checked is not None:
        yield _stops_elsewhere(*reading.checked, home, limits)
    elif reading.start is not None and reading.start_time > 0.0:
        yield _taken_home(reading.start_time, guarantees)
    elif reading.start is not None:
        yield "the machine must stand at home when it starts"
    last = moves[-1]
    end = last.end if isinstance(last, Untimed) else last.points.at([last.points.duration]).coordinates[0]
    if distance := _away(end, home, limits):
        yield f"the program does not end at home, {distance}"
    yield from override_remarks(reading, guarantees)
    yield from guarantees.own_rules
    if reading.stops:
        lines = f"line{'s' if len(reading.stops) > 1 else ''} {', '.join(map(str, reading.stops))}"
        yield f"{lines}: the machine waits for its operator, who must not move it; the recording goes on meanwhile"
    if reading.left_on:
        yield f"line {reading.left_on}: the trigger is never switched off again"
    elif not any(part.trigger for part in reading.stretches):
        yield "the trigger is never switched on: a recording would not know what to evaluate"


def override_remarks(reading: Reading, guarantees: Guarantees) -> Iterator[str]:
    """What to do about a feed override that may make the motion faster than what is proven; nothing where none can."""
    controller = guarantees.case.need_controller("a program")
    if guarantees.override_remedy and not reading.override_off and controller.overdriven:
        yield phrase(
            "override_faster",
            "a feed override above 100 % makes it faster than what is proven; {remedy}",
            remedy=guarantees.override_remedy,
        )


_STEPS = {
    WayToFirst.SMOOTH: "",
    WayToFirst.ACCELERATIONS_STEP: "; accelerations step at both ends of that way",
    WayToFirst.RATES_STEP: "; speeds step at both ends of that way",
}


def _taken_home(time: float, guarantees: Guarantees) -> str:
    """The remark on a controller that goes to home in some time [s], from wherever the machine stands."""
    case, kind = guarantees.case, guarantees.to_first
    _, limits = case.need_motion("the check of a program")
    share = case.need_controller("the check of a program").safe_share
    near = [
        share * limit * time**order / peak
        for order, (limit, peak) in enumerate(
            zip((limits.rate, limits.acceleration, limits.jerk), kind.value, strict=False), 1
        )
    ]
    way = np.min(near, axis=0)
    lengths = [
        (way[axes].min() / unit, name)
        for axes, unit, name in ((limits.turns, DEG, "deg"), (~limits.turns, MM, "mm"))
        if axes.any()
    ]
    ways = " and ".join(f"{length:.3g} {name}" for length, name in lengths)
    return (
        f"the machine must stand at home when it starts: from where it stands it is taken there in {time:.3g} s, at no "
        f"more than {100 * share:.3g} % of its limits only if no joint is further than {ways} from home{_STEPS[kind]}"
    )


def _stops_elsewhere(pose: Array, within: Array, home: Array, limits: Box) -> str:
    """The remark on a program that checks where the machine stands."""
    near = " and ".join(
        f"{within[axes].max() / unit:.2g} {name}"
        for axes, unit, name in ((~limits.turns, MM, "mm"), (limits.turns, DEG, "deg"))
        if axes.any()
    )
    if distance := _away(pose, home, limits):
        return f"the program stops unless it starts within {near} of its own first place, not of home, {distance}"
    return f"the program stops unless the machine stands at home, within {near}"


def _away(pose: Array, home: Array, limits: Box) -> str:
    off = np.abs(pose - home) / np.where(limits.turns, AT_HOME[1], AT_HOME[0])
    if np.all(off <= 1.0):
        return ""
    k = int(np.argmax(off))
    unit, name = (DEG, "deg") if limits.turns[k] else (MM, "mm")
    label = limits.labels[k].upper() if len(limits.labels[k]) == 1 else limits.labels[k]
    return f"where {label} is {home[k] / unit:g} {name}, but to {pose[k] / unit:g} {name}"
