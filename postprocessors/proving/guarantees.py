"""What a controller answers for, beyond what a program's text fixes: limits of its own, its time law, its accuracy."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace

from cases.schema import Case
from identification.limited import Box
from identification.limits import LimitCheck, Status
from identification.trajectories.profile import Profile, TimeLaw
from postprocessors.proving.forces import ForceBounds

Law = Callable[[float, float, float], TimeLaw]
"""How a controller covers a straight way from rest to rest.

Limits of velocity, acceleration and jerk on the share of the way [1/s, 1/s^2, 1/s^3] -> time law of that share, 0 to 1.
"""
ArcLaw = Callable[[float, float, float, float], TimeLaw]
"""The same for an arc, whose angle [rad] is the last argument: turning needs a part of the acceleration."""


def limits_jerk(law: Law) -> bool:
    """Whether a controller's law has a limit of jerk; without one its accelerations step."""
    profile = law(1.0, 1.0, 1.0)
    return not (isinstance(profile, Profile) and profile.jerk_time == 0.0)


@dataclass(frozen=True, slots=True)
class Guarantees:
    """A controller as set up for one case and one program."""

    controller: str  # its name, for messages
    shortest_block: float  # a timed block must not be shorter: the controller's cycle [s]
    longest_block: float  # a timed block must not be longer: beyond it nothing is known of its time law [s]
    # whether it passes timed points at their times along the assumed curve between them; then what a timed path reaches
    # is proven from the text, else only its geometry and rates are
    follows_paths: bool
    # whether it covers each timed block at that block's mean rates, or nearly so (a straight line in all coordinates,
    # at one feed): then rates are proven also where it does not follow the assumed curve
    even_blocks: bool
    enforced: frozenset[str]  # families of limits that it keeps by itself, whatever the program asks for; see `family`
    law: Law  # its time law in straight moves that it times itself, under the limits of the case
    arc_law: ArcLaw
    jerk_time: float  # within this time its accelerations step where its law has no jerk limit; 0 where it has one [s]
    whole_cycles: bool = False  # whether it leaves out what a timed block lasts beyond whole cycles
    block_key: str = "controller.block_ms"  # setting that the length of timed blocks comes from


@dataclass(frozen=True, slots=True)
class Forecast:
    """What a controller will make of a program's time, told before it runs."""

    stretch: float = 1.0  # predicted duration over planned duration of the excitation's timed paths
    remarks: tuple[str, ...] = ()  # what to know about it and what to change, one sentence each


def family(name: str) -> str:
    """The family of a limit by its name in a report: `angular jerk, untimed moves (b)` is of `jerk`."""
    return name.split(" (")[0].split(",")[0].removeprefix("angular ")


KINETIC = (
    "velocity", "acceleration", "jerk", "strut velocity", "strut acceleration", "sensor force", "sensor moment",
    "joint torque", "joint force",
)  # fmt: skip
"""Families of limits that depend on a controller's time law; those of geometry do not."""


UNTIMED = ", untimed moves"  # names apart what a controller does by itself, lest it hide what is proven


@dataclass(frozen=True, slots=True)
class Answering:
    """What a program is judged by."""

    case: Case
    guarantees: Guarantees
    file: str  # name of the program, for messages
    forces: ForceBounds | None  # bounds of the sensor forces; None where the case has no range or body

    @property
    def limits(self) -> Box:
        """Of excitations."""
        return self.case.need_motion("the check of a program")[1]

    def answer(self, name: str) -> Status:
        """Who keeps a limit, by its name in a report, in a motion that the controller times."""
        return Status.ENFORCED if family(name) in self.guarantees.enforced else Status.NOT_ENFORCED

    def own(self, check: LimitCheck, where: str = UNTIMED, status: Status | None = None) -> LimitCheck:
        """A limit in a move that the controller times: a prediction, for which the text is not answerable."""
        verdict = self.answer(check.name) if status is None else status
        return replace(check, name=_renamed(check.name, where), status=verdict, binding=False)

    def forces_kept(
        self, kind: str, bound: Callable[[ForceBounds], Iterable[LimitCheck]], where: str = ""
    ) -> LimitCheck | None:
        """Proven sensor forces or moments; None where what the controller lets pass could be too much for the sensors.

        No controller knows forces of sensors. They are bounded where it keeps velocities and accelerations.
        """
        if self.forces is None or not {"velocity", "acceleration"} <= self.guarantees.enforced:
            return None
        check = next((c for c in bound(self.forces) if family(c.name) == kind), None)
        return None if check is None or check.ratio > 1.0 else replace(check, name=_renamed(check.name, where))


def _renamed(name: str, addition: str) -> str:
    kind, _, place = name.partition(" (")
    return f"{kind}{addition} ({place}" if place else f"{kind}{addition}"
