"""What a generator of setpoints guarantees beyond its table."""

from cases.controller import Setpoints
from cases.schema import Case
from identification.limits.limit import LimitKind
from postprocessors.proof.guarantees import SEVEN_SEGMENTS, Guarantees
from postprocessors.reading import Reading


def setpoint_guarantees(reading: Reading, case: Case) -> Guarantees:
    """Guarantees for a table, which states its time exactly: all limits are proven from the rows."""
    settings = case.need_settings(Setpoints, "a setpoint table")
    enforced, cycle = frozenset(map(LimitKind, settings.controller_keeps)), settings.cycle
    return Guarantees(
        case, "setpoint generator", cycle, cycle, SEVEN_SEGMENTS, enforced, jerk_time=cycle, follows_paths=True,
        resolution=0.0, timing_remedy="write a row for each cycle (controller.setpoints.cycle_ms)",
    )  # fmt: skip
