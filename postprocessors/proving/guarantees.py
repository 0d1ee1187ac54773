"""What a controller answers for, beyond what a program's text fixes: limits of its own, its time law, its accuracy."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace

from cases.schema import Case
from identification.limit import LimitCheck, LimitKind, OwnMove, Status
from identification.limited_quantities import Box
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
    enforced: frozenset[LimitKind]  # families of limits that it keeps by itself, whatever the program asks for
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

    def answer(self, kind: LimitKind) -> Status:
        """Who keeps a limit in a motion that the controller times."""
        return Status.ENFORCED if kind.family in self.guarantees.enforced else Status.NOT_ENFORCED

    def own(self, check: LimitCheck, move: OwnMove = OwnMove.UNTIMED, status: Status | None = None) -> LimitCheck:
        """A limit in a move that the controller times: a prediction, for which the text is not answerable."""
        verdict = self.answer(check.kind) if status is None else status
        return replace(check, of=check.of._replace(move=move), status=verdict, binding=False)

    def forces_kept(
        self, kind: LimitKind, bound: Callable[[ForceBounds], Iterable[LimitCheck]], move: OwnMove | None = None
    ) -> LimitCheck | None:
        """Proven sensor forces or moments; None where what the controller lets pass could be too much for the sensors.

        No controller knows forces of sensors. They are bounded where it keeps velocities and accelerations.
        """
        if self.forces is None or not {LimitKind.VELOCITY, LimitKind.ACCELERATION} <= self.guarantees.enforced:
            return None
        check = next((c for c in bound(self.forces) if c.kind is kind), None)
        return None if check is None or check.ratio > 1.0 else replace(check, of=check.of._replace(move=move))
