"""What a recorded run should have done: the plan or the program that it followed."""

from typing import Any

import numpy as np

from cases.errors import ExecutionError
from cases.schema import Case
from cases.units import DEG, MM
from identification.model import identification_model
from identification.motion import Joined, Standstill, Trajectory
from identification.reference import reference_scaling
from identification.trajectories.strut_move import StrutMove
from planner.bounds.kept import box_bound
from planner.search.problem import mean_information
from postprocessors.program_file import Program
from postprocessors.proving.measured import measures_at_poses
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


def changed_motion(read: Program, case: Case, model_number: int) -> dict[str, Any]:
    """Figures of a program whose point-to-point moves are straight in the struts.

    Args:
        read: the program.
        case: its machine.
        model_number: number of the identification model that the plan is for.

    Returns:
        `off_path_mm`, `off_path_deg`: largest distance from the straight ways, of position and of (a, b, c);
        `d_efficiency`: of the changed excitation, None where the program measures standing still.
    """
    limits = case.need_machine("a program")[2].motion
    parts = stretches(read.reading)
    moves = [predicted(p, limits, read.guarantees) for p in parts if isinstance(p, Untimed) and p.in_struts]
    off = np.array([m.deviation for m in moves if isinstance(m, StrutMove)])
    efficiency = None
    if not measures_at_poses(parts):
        model = identification_model(case, model_number)
        information = mean_information(model, reference_scaling(case, model), planned_excitation(read, case))
        sign, logdet = np.linalg.slogdet(information)
        efficiency = box_bound(case, model).efficiency(float(logdet)) if sign > 0 else 0.0
    position, angle = off.max(axis=0)
    return {"off_path_mm": position / MM, "off_path_deg": angle / DEG, "d_efficiency": efficiency}
