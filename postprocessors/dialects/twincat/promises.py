"""What a TwinCAT or ISG kernel guarantees beyond a program's text."""

from cases.base.phrases import phrase
from cases.base.units import MS
from cases.controller import ControllerName, TwinCatAxes
from cases.schema import Case
from identification.limits.limit import LimitKind
from postprocessors.proof.guarantees import LONGEST_POINTS, SEVEN_SEGMENTS, Guarantees, trapezoid
from postprocessors.reading import Reading

OVERRIDE = phrase("override_twincat", "keep it at 100 % at most, or end it there in the PLC")


def twincat_guarantees(reading: Reading, case: Case) -> Guarantees:
    """Guarantees of TwinCAT, which chooses the curve between the points of a path; `#SLOPE` decides on the jerk."""
    settings = case.need_settings(TwinCatAxes, "a TwinCAT program")
    smooth = settings.slope == "TRAPEZ"
    return Guarantees(
        case,
        controller="TwinCAT",
        plan_for=ControllerName.TWINCAT,
        shortest_block=settings.shortest_block_ms * MS,
        longest_block=LONGEST_POINTS,
        enforced=frozenset(map(LimitKind, settings.controller_keeps)),
        law=SEVEN_SEGMENTS if smooth else trapezoid,
        jerk_time=0.0 if smooth else settings.shortest_block_ms * MS,
        override_remedy=OVERRIDE,
    )
