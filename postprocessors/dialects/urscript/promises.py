"""What the controller of a robot guarantees beyond a program's text."""

from cases.controller import ControllerName
from cases.schema import Case
from postprocessors.proof.guarantees import Guarantees, trapezoid
from postprocessors.reading import Reading


def urscript_guarantees(reading: Reading, case: Case) -> Guarantees:
    """Guarantees of a robot: the text states speed and acceleration of each trapezoid; only its jerk is not proven."""
    cycle = case.need_controller("a URScript program").cycle
    return Guarantees(case, "the robot", 0.0, 0.0, trapezoid, jerk_time=cycle, plan_for=ControllerName.URSCRIPT)
