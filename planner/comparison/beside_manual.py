"""What the case's own hand-made motion would tell under the same noise: the yardstick beside every optimised plan."""

from typing import NamedTuple

import numpy as np

from cases.errors import HexciteError
from identification.criteria import reference_scaling
from identification.model import identification_model
from planner.deviations import worst_std
from planner.families.manual import manual_motion, sequence_file
from planner.plans import Plan
from planner.search.problem import mean_information


class Beside(NamedTuple):
    """The hand-made motion's figures."""

    duration: float  # [s]
    std: dict[str, float]  # predicted standard deviation of each physical parameter, of one whole run [SI]
    averaging: bool = True  # whether errors average out where it is repeated; those that depend on the pose do not

    def at_equal_time(self, duration: float) -> dict[str, float]:
        """Deviations if the motion were repeated, or broken off, after another duration [s]."""
        times = float(np.sqrt(self.duration / duration)) if self.averaging else 1.0
        return {name: std * times for name, std in self.std.items()}


def beside_manual(plan: Plan) -> Beside | str:
    """The hand-made motion of the plan's case with the plan's model, noise and payload; or why there is none."""
    if not plan.of_motion[0].family.optimised:
        return "it is the motion itself"
    try:
        case = plan.case
        model = identification_model(case, plan.model)
        motion = manual_motion(case, sequence_file(case))
        scaling = reference_scaling(case, model)
        information = mean_information(model, scaling, motion)
        if np.linalg.matrix_rank(information) < len(scaling):
            return "the hand-made motion of this case does not determine all parameters of the model"
        worst = worst_std(case, model, scaling, motion, plan.payloads)
        return Beside(
            motion.duration, {name: std for name, (std, _) in worst.items()}, case.sensors.pose_error_N is None
        )
    except HexciteError as error:
        return f"there is no hand-made motion to compare with: {error.typed}"
