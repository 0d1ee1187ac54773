"""Who answers for a limit that a controller's own time law decides."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace

from cases.schema import Case
from identification.limited import Box
from identification.limits import LimitCheck, Status
from postprocessors.proving.forces import ForceBounds
from postprocessors.proving.guarantees import Guarantees, family

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
        found = self.answer(check.name) if status is None else status
        return replace(check, name=_renamed(check.name, where), status=found, binding=False)

    def forces_kept(
        self, kind: str, bound: Callable[[ForceBounds], Iterable[LimitCheck]], where: str = ""
    ) -> LimitCheck | None:
        """Proven sensor forces or moments; None where what the controller lets pass could be too much for the sensors.

        No controller knows forces of sensors. They are bounded where it keeps velocities and accelerations.
        """
        if self.forces is None or not {"velocity", "acceleration"} <= self.guarantees.enforced:
            return None
        check = next(c for c in bound(self.forces) if family(c.name) == kind)
        return replace(check, name=_renamed(check.name, where)) if check.ratio <= 1.0 else None


def _renamed(name: str, addition: str) -> str:
    kind, _, where = name.partition(" (")
    return f"{kind}{addition} ({where}" if where else f"{kind}{addition}"
