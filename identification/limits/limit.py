"""What a case limits, by kind and place, and how close a motion comes to it."""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Any, NamedTuple

import numpy as np

from cases.base.phrases import NOTHING, Phrase, phrase
from cases.base.units import DEG, MM, Array

NAMED = "limit"
"""Code of a limit's name, with its strut, joint or body in brackets."""

# of every limit that motions leave unused: for the rounding of program words, the encoders' view of the motion, and
# what happens between the instants at which it is looked at
UNUSED_SHARE = 1e-3
TOLERANCE = 1e-6  # a limit counts as satisfied up to this share above it: rounding, not motion


class LimitKind(StrEnum):
    """What is limited, with the unit in which people read it and its scale from SI."""

    unit: str
    scale: float

    def __new__(cls, words: str, unit: str = "", scale: float = 1.0) -> "LimitKind":
        """One kind, equal to its words."""
        kind = str.__new__(cls, words)
        kind._value_, kind.unit, kind.scale = words, unit, scale
        return kind

    POSITION = "position", "mm", 1 / MM
    ANGLE = "angle", "deg", 1 / DEG
    WORKSPACE_POSITION = "workspace position", "mm", 1 / MM
    JOINT_POSITION = "joint position", "mm", 1 / MM
    JOINT_ANGLE = "joint angle", "deg", 1 / DEG
    VELOCITY = "velocity", "mm/s", 1 / MM
    ANGULAR_VELOCITY = "angular velocity", "deg/s", 1 / DEG
    ACCELERATION = "acceleration", "m/s^2"
    ANGULAR_ACCELERATION = "angular acceleration", "rad/s^2"
    JERK = "jerk", "m/s^3"
    ANGULAR_JERK = "angular jerk", "rad/s^3"
    STRUT_LENGTH = "strut length", "mm", 1 / MM
    STRUT_VELOCITY = "strut velocity", "m/s"
    STRUT_ACCELERATION = "strut acceleration", "m/s^2"
    BASE_JOINT_ANGLE = "base joint angle", "deg", 1 / DEG
    PLATFORM_JOINT_ANGLE = "platform joint angle", "deg", 1 / DEG
    SINGULARITY = "singularity", "% of det J^-1 at home", 100.0
    DISTANCE_FROM_BOX = "distance from", "mm", 1 / MM
    DISTANCE_BETWEEN_LINKS = "distance between links", "mm", 1 / MM
    JOINT_FORCE = "joint force", "N"
    JOINT_TORQUE = "joint torque", "N m"
    SENSOR_FORCE = "sensor force", "N"
    SENSOR_MOMENT = "sensor moment", "N m"
    FEED_TO_HOME = "feed to home", "mm/s", 1 / MM

    @property
    def family(self) -> "LimitKind":
        """The kind under which people accept it and controllers enforce it: for rotations that of translations."""
        return _FAMILIES.get(self, self)

    @property
    def least(self) -> bool:
        """Whether it is a lower limit alone: what comes closest to it is the smallest value."""
        return self in (
            LimitKind.SINGULARITY, LimitKind.DISTANCE_FROM_BOX, LimitKind.DISTANCE_BETWEEN_LINKS,
        )  # fmt: skip

    @property
    def kinetic(self) -> bool:
        """Whether it depends on a motion's time law; limits of geometry do not."""
        return self.family in KINETIC


_FAMILIES = {
    LimitKind.ANGULAR_VELOCITY: LimitKind.VELOCITY,
    LimitKind.ANGULAR_ACCELERATION: LimitKind.ACCELERATION,
    LimitKind.ANGULAR_JERK: LimitKind.JERK,
}
KINETIC = (
    LimitKind.VELOCITY, LimitKind.ACCELERATION, LimitKind.JERK, LimitKind.STRUT_VELOCITY, LimitKind.STRUT_ACCELERATION,
    LimitKind.SENSOR_FORCE, LimitKind.SENSOR_MOMENT, LimitKind.JOINT_TORQUE, LimitKind.JOINT_FORCE,
)  # fmt: skip
"""Families of limits that depend on a motion's time law."""


PLANNABLE_WITHOUT = (LimitKind.JERK,)
"""Families of limits that a plan may leave out by name: some controllers cannot keep them, and machines bear that."""


class OwnMove(StrEnum):
    """Moves that a controller times by itself: other names, so that predictions do not hide what is proven."""

    UNTIMED = "untimed moves"
    WAY_HOME = "way home"  # from an unknown pose


class Limit(NamedTuple):
    """Something that is limited, wherever in the machine."""

    kind: LimitKind
    box: str = ""  # name of the box from which a distance is limited
    move: OwnMove | None = None  # a kind of moves that the controller times by itself; None of all others

    def __str__(self) -> str:
        """Its name: `strut velocity`, `distance from vice`, `jerk, untimed moves`."""
        name = f"{self.kind} {self.box}" if self.box else f"{self.kind}"
        return f"{name}, {self.move}" if self.move else name

    def at(self, place: str) -> str:
        """Its name with the coordinate, strut, sensor or body that comes closest; an empty place adds nothing."""
        return f"{self} ({place})" if place else f"{self}"

    @classmethod
    def named(cls, name: str) -> "Limit":
        """The limit that files of version 0.2 have by name alone; raises ValueError where there is none."""
        for move in OwnMove:
            if name.endswith(f", {move}"):
                return cls.named(name.removesuffix(f", {move}"))._replace(move=move)
        start = f"{LimitKind.DISTANCE_FROM_BOX} "
        if name.startswith(start):
            return cls(LimitKind.DISTANCE_FROM_BOX, name.removeprefix(start))
        return cls(LimitKind(name))


@dataclass(frozen=True, slots=True)
class Quantity:
    """A limited quantity, one row an instant and one column a coordinate or strut."""

    of: Limit
    labels: tuple[str, ...]  # labels of the columns
    values: Array  # shape (n, k)
    limits: Array  # lower and upper limit of each column, twice the same where there is but one, shape (2, k)
    ratio: Array  # share of the limit that is used, infinite where a value is not a number, shape (n, k)

    @classmethod
    def between(cls, kind: LimitKind, labels: tuple[str, ...], values: Array, low: Array, high: Array) -> "Quantity":
        """Values, shape (n, k), between limits, shapes (k,) [SI].

        The share is the distance from their middle over half their width.
        """
        values = np.asfortranarray(values)  # column by column, or every operation below goes through rows of three
        ratio = values - (low + high) / 2
        np.abs(ratio, out=ratio)
        ratio /= np.where(high > low, (high - low) / 2, np.nan)  # nothing lies between limits that contradict
        if np.isnan(ratio.max()):
            ratio[np.isnan(ratio)] = np.inf
        return cls(Limit(kind), labels, values, np.stack([low, high]), ratio)

    @classmethod
    def clear(cls, of: Limit, labels: tuple[str, ...], values: Array, reach: Array | float) -> "Quantity":
        """Distances, shape (n, k) [m], which must not be below 0: the share falls from 1 there to 0 at `reach`."""
        ratio = np.nan_to_num(np.maximum(0.0, 1.0 - values / reach), nan=np.inf)
        return cls(of, labels, values, np.zeros((2, len(labels))), ratio)


class Status(StrEnum):
    """How a limit is ensured."""

    PROVEN = "proven"
    FOLLOWS = "follows from what the controller enforces"
    ENFORCED = "enforced by controller"
    NOT_ENFORCED = "NOT enforced"
    LEFT_OUT = "left out, as planned"
    STEPS = "steps, not limited by controller"  # of plans of versions up to 0.2, which had no such choice


@dataclass(frozen=True, slots=True)
class LimitCheck:
    """The worst approach to one limit."""

    of: Limit
    place: str  # coordinate, strut, sensor or body that came closest; empty where there is but one
    worst: float  # the value there, in `unit`
    limit: float  # the limit it came closest to, in `unit`
    unit: str  # unit of both
    ratio: float  # share of the limit that is used; the limit is satisfied up to 1
    time: float  # when [s]
    status: Status
    # whether the motion itself is responsible for it; not where a controller's own law is only predicted
    binding: bool = True
    # lower and upper limit, in `unit`, where there are two; the share is counted from the middle between them
    bounds: tuple[float, float] | None = None
    line: int = 0  # line of the program; 0 of a motion that is not a program's

    @property
    def name(self) -> str:
        """Limit, with the coordinate or strut that came closest."""
        return self.of.at(self.place)

    @property
    def kind(self) -> LimitKind:
        """What is limited."""
        return self.of.kind

    @property
    def closeness(self) -> float:
        """How close it is to its limit, to compare two of one limit: by the share, of least values by the value."""
        return -self.worst if self.kind.least and math.isfinite(self.ratio) else self.ratio

    @property
    def two_sided(self) -> bool:
        """Whether it lies between two ends of which one is not minus the other, as lengths of struts do."""
        return self.bounds is not None and self.bounds[0] != -self.bounds[1]

    @property
    def room(self) -> float | None:
        """What is left to the nearer end, or to the least value, in `unit`; below 0 beyond it; None of other limits.

        There a share says nothing that a reader could compare: it is counted from a middle, or from far away.
        """
        if self.kind.least:
            return self.worst - self.limit
        if self.bounds is None or not self.two_sided:
            return None
        return min(self.worst - self.bounds[0], self.bounds[1] - self.worst)

    @property
    def kept(self) -> bool:
        """Whether the limit is satisfied, as far as the motion itself is responsible for it."""
        return not self.binding or self.ratio <= 1.0 + TOLERANCE

    def sentence(self, timed: bool = True) -> Phrase:
        """One phrase with value and limit, and the time where it matters."""
        digits = next(d for d in range(4, 18) if f"{self.worst:.{d}g}" != f"{self.limit:.{d}g}" or d == 17)
        at = phrase("at_time", " at {time} s", time=f"{self.time:.3f}") if timed else NOTHING
        values = {"limit": phrase(NAMED, "{name}", name=self.name), "worst": f"{self.worst:.{digits}g}"}
        values |= {"unit": self.unit, "at": at, "bound": f"{self.limit:.4g}"}
        if self.kind.least:
            return phrase("limit_falls", "{limit} falls to {worst} {unit}{at}, at least {bound}", **values)
        return phrase("limit_reaches", "{limit} reaches {worst} {unit}{at}, limit {bound}", **values)

    def to_json(self) -> dict[str, Any]:
        """The object that `LimitReport.to_json` holds under the limit's name."""
        move = None if self.of.move is None else str(self.of.move)
        entry: dict[str, Any] = {"kind": str(self.kind), "box": self.of.box, "move": move, "place": self.place}
        entry |= {"at": self.name, "worst": self.worst, "limit": self.limit, "unit": self.unit, "ratio": self.ratio}
        entry |= {"time_s": self.time, "status": str(self.status)}
        return entry if self.bounds is None else entry | {"bounds": list(self.bounds)}

    @classmethod
    def of_json(cls, name: str, entry: Mapping[str, Any]) -> "LimitCheck":
        """The check from a limit's name and what `to_json` made; errors as `LimitReport.of_json`."""
        bounds, status, at = entry.get("bounds"), Status(entry["status"]), str(entry["at"])
        if "kind" in entry:
            move = None if entry["move"] is None else OwnMove(entry["move"])
            of, place = Limit(LimitKind(entry["kind"]), str(entry["box"]), move), str(entry["place"])
        else:  # of version 0.2
            of, place = Limit.named(name), at.removeprefix(name).removeprefix(" (").removesuffix(")")
        worst, limit, ratio, time = (float(entry[key]) for key in ("worst", "limit", "ratio", "time_s"))
        binding = status not in (Status.LEFT_OUT, Status.STEPS)
        return cls(
            of, place, worst, limit, str(entry["unit"]), ratio, time, status, binding,
            None if bounds is None else (float(bounds[0]), float(bounds[1])),
        )  # fmt: skip


@dataclass(frozen=True, slots=True)
class LimitReport:
    """All limits of a motion, worst case each."""

    checks: tuple[LimitCheck, ...]

    @property
    def kept(self) -> bool:
        """Whether every limit is satisfied."""
        return all(c.kept for c in self.checks)

    @property
    def violations(self) -> tuple[LimitCheck, ...]:
        """The limits that are exceeded, the worst first."""
        return tuple(sorted((c for c in self.checks if not c.kept), key=lambda c: -c.ratio))

    @property
    def worst_ratio(self) -> float:
        """Largest share that is used of a limit for which the motion is responsible."""
        return max(c.ratio for c in self.checks if c.binding)

    def later(self, time: float) -> "LimitReport":
        """The same report on a clock on which the motion starts at some time [s]."""
        return LimitReport(tuple(replace(check, time=check.time + time) for check in self.checks))

    def to_json(self) -> dict[str, dict[str, Any]]:
        """One object for each limit, by name."""
        return {str(c.of): c.to_json() for c in self.checks}

    @classmethod
    def of_json(cls, data: Mapping[str, Mapping[str, Any]]) -> "LimitReport":
        """The report that `to_json` wrote; raises KeyError, TypeError or ValueError where an entry is damaged."""
        return cls(tuple(LimitCheck.of_json(name, entry) for name, entry in data.items()))


def worst_of(reports: Iterable[LimitReport]) -> LimitReport:
    """The worst of each limit over several stretches of motion; proven only where it is in all of them."""
    worst: dict[Limit, LimitCheck] = {}
    for report in reports:
        for check in report.checks:
            previous = worst.setdefault(check.of, check)
            if check.closeness > previous.closeness:
                previous, check = check, previous
            weaker = max(previous.status, check.status, key=list(Status).index)
            worst[check.of] = previous if weaker is previous.status else replace(previous, status=weaker)
    return LimitReport(tuple(worst.values()))
