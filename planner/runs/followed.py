"""What a recorded run should have done: the plan or the program that it followed."""

from cases.errors import ExecutionError
from cases.schema import Case
from identification.motion import Joined, Standstill, Trajectory
from postprocessors.program_file import Program
from postprocessors.proving.predicted import predicted
from postprocessors.proving.stretches import Timed, Untimed, stretches


def planned_excitation(read: Program, case: Case) -> Trajectory:
    """The motion that the program asks for while its trigger is on.

    Raises:
        ExecutionError: nothing moves then.
    """
    limits = case.need_motion("a run")[1]
    excited: list[Trajectory] = []
    for part in stretches(read.reading):
        if not part.trigger:
            continue
        if isinstance(part, Timed):
            excited.append(part.points)
        elif isinstance(part, Untimed):
            motion = predicted(part, limits, read.guarantees)
            excited += [] if motion is None else [motion]
        elif excited and part.duration > 0.0:  # a pause between moves
            excited.append(Standstill(excited[-1].at([excited[-1].duration]).pose[0], part.duration))
    while excited and isinstance(excited[-1], Standstill):
        excited.pop()
    if not excited:
        raise ExecutionError(read.path, "nothing moves with the trigger on", "write it with hexcite post")
    return excited[0] if len(excited) == 1 else Joined(tuple(excited))
