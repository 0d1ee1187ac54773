"""What moves that are straight in the struts make of a plan: how far from its path they lead, and what they tell."""

from typing import Any

import numpy as np

from cases.schema import Case
from cases.units import DEG, MM
from identification.model import identification_model
from identification.reference import reference_scaling
from identification.trajectories.strut_move import StrutMove
from planner.bounds.kept import box_bound
from planner.runs.followed import planned_excitation
from planner.search.problem import mean_information
from postprocessors.files import Program
from postprocessors.proving.measured import measures_at_poses
from postprocessors.proving.predicted import predicted
from postprocessors.proving.stretches import Untimed, stretches


def changed_motion(read: Program, case: Case, model_number: int) -> dict[str, Any]:
    """Figures of a program whose point-to-point moves are straight in the struts.

    Args:
        read: the program.
        case: its machine.
        model_number: of the identification model that the plan is for.

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
