"""What the standard deviations of an estimate are in truth, on a simulated machine that errs with the pose.

Errors that depend on the pose repeat wherever a motion comes back to it. Deviations that are estimated from one run
infer their size and length from its residuals; here both are known.
"""

import numpy as np

from cases.schema import Case
from cases.sensors import Disturbances
from identification.loaded import pose_covariance
from identification.model import identification_model
from identification.parameters import physical_form
from identification.result import Estimate
from planner.validation.answer import LinearAnswer


def true_deviations(
    case: Case, answer: LinearAnswer, estimate: Estimate, disturbances: Disturbances, load: float
) -> dict[str, float]:
    """Standard deviations of parameters over machines that differ in their pose errors, by name [SI].

    The errors of the pose have the covariance that the simulated machine draws them from; all the rest is white, as
    (28) has it.

    Args:
        case: with a simulated machine.
        answer: of the estimate to forces.
        estimate: by least squares.
        disturbances: of the machine.
        load: mass of the weights on it [kg].
    """
    model = identification_model(case, estimate.model, estimate.terms)
    home = case.need_machine("a validation")[0].home.vector
    weight = load * float(np.linalg.norm(case.gravity))
    common = pose_covariance(disturbances, home, answer.poses, weight)
    covariance = sum(part @ common @ part.T for part in np.moveaxis(answer.answer, 2, 0))
    form = physical_form(model)
    _, by_pose = form.of(estimate.values, np.asarray(covariance))
    return {
        p.name: float(np.sqrt(variance + estimate.physical[p.name].std ** 2))
        for p, variance in zip(form.parameters, np.diag(by_pose), strict=True)
    }
