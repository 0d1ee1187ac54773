"""Standard deviations that one run of a motion will have, predicted from its information and the expected noise."""

from collections.abc import Sequence

import numpy as np

from cases.errors import HexciteError
from cases.schema import Case
from identification.criteria import CRITERIA, reference_scaling, singular_values
from identification.estimation.fit import PoseField
from identification.hexapod import Hexapod
from identification.model import Model, identification_model
from identification.motion import Array, Trajectory
from identification.parameters import nominal_parameters, physical_form
from planner.families.manual import manual_motion, sequence_file
from planner.noise import (
    ExpectedNoise,
    PoseErrors,
    expected_noise,
    information_of,
    mean_information,
    of_estimate,
    seen_through,
)
from planner.plans import Plan
from planner.poses.pose_criteria import total_information


def predicted_std(
    case: Case,
    model: Model,
    scaling: Array,
    information: Array,
    duration: float,
    noise: float,
    payload: int = 0,
) -> dict[str, float]:
    """Standard deviations of the physical parameters for one run at the rate of the case.

    Expected is the nominal body with a number of payloads.

    Args:
        scaling: diagonal of H, shape (u,).
        information: mean of H A^T W A H, or that `of_estimate` where W is not right for the noise, shape (u, u).
        duration: [s].
        noise: standard deviation of a force sample [N], 1 / sqrt of what W is in units of.

    Raises:
        CaseError: the case has no nominal body.
    """
    covariance = noise**2 / (duration * case.recording.rate_Hz) * np.linalg.inv(information)
    return _physical_std(case, model, covariance * np.outer(scaling, scaling), payload)


def predicted_std_at_poses(
    case: Case, model: Model, scaling: Array, regressors: Array, poses: Array, noise: float
) -> dict[str, float]:
    """Standard deviations of the physical parameters from averaged standstills.

    Args:
        case: gives the nominal body, and errors that depend on the pose.
        scaling: scaling of its columns, shape (u,).
        regressors: regressors of the poses, scaled, shape (n, 6, u).
        poses: shape (n, 6) [m, rad].
        noise: standard deviation of an averaged force [N].

    Raises:
        CaseError: the case has no nominal body.
    """
    inverse = np.linalg.inv(total_information(regressors))
    covariance = noise**2 * inverse
    if (field := PoseField.of(case.sensors)) is not None:
        by_pose = field.covariance(Hexapod.of(case).strut_lengths(poses))
        covariance = covariance + inverse @ sum(a.T @ by_pose @ a for a in regressors.transpose(1, 0, 2)) @ inverse
    return _physical_std(case, model, covariance * np.outer(scaling, scaling))


def _physical_std(case: Case, model: Model, covariance: Array, payload: int = 0) -> dict[str, float]:
    """Of the nominal body with a number of payloads, from the covariance of u, shape (u, u)."""
    form = physical_form(model)
    nominal = nominal_parameters(model, case.body(payload))  # the rest is linear: its values do not matter
    _, physical = form.of(nominal, covariance)
    std = np.sqrt(np.diag(physical))
    return {p.name: float(s) for p, s in zip(form.parameters, std, strict=True)}


def predicted_std_of(
    case: Case, model: Model, scaling: Array, motion: Trajectory, noise: ExpectedNoise, payload: int
) -> dict[str, float]:
    """Standard deviations of the physical parameters for one run of a motion, by rate, weights, noise and pose errors.

    Args:
        scaling: scaling of its columns, shape (u,).

    Raises:
        CaseError: the case has no nominal body.
    """
    information = mean_information(seen_through(model, noise.whitening), scaling, motion)
    scattered = None
    if noise.scatter is not None:
        scattered = mean_information(seen_through(model, noise.scatter), scaling, motion)
    errors = PoseErrors.of(case, noise)
    if errors is not None:
        scattered = information if scattered is None else scattered
        scattered = scattered + errors.scatter_of(seen_through(model, noise.whitening), scaling, motion)
    if scattered is not None:
        information = of_estimate(information, scattered)
    return predicted_std(case, model, scaling, information, motion.duration, noise.sensors, payload)


def worst_std(
    case: Case, model: Model, scaling: Array, motion: Trajectory, payloads: Sequence[int]
) -> dict[str, tuple[float, int]]:
    """Largest predicted standard deviation of each parameter over numbers of payloads, and the number that has it.

    Each run has the noise and weights of what is mounted; the fewest payloads count where several are alike.

    Args:
        scaling: scaling of its columns, shape (u,).

    Raises:
        CaseError: the case has no nominal body, or fewer payloads.
    """
    worst: dict[str, tuple[float, int]] = {}
    for payload in payloads:
        noise = expected_noise(case, model, payload)
        for name, std in predicted_std_of(case, model, scaling, motion, noise, payload).items():
            if name not in worst or std > worst[name][0] * (1.0 + 1e-6):
                worst[name] = (std, payload)
    return worst


def figures_of(
    case: Case, model: Model, motion: Trajectory, payloads: Sequence[int], criterion: str
) -> tuple[dict[str, float], ExpectedNoise, dict[str, tuple[float, int]]]:
    """What a motion is worth, with the most payloads mounted: entries of `plan.json`, the noise and `worst_std`.

    The criterion is of the information that the search maximised: by the weights of the case, and what errors of the
    pose leave.

    Raises:
        IdentificationError: the motion does not excite all parameters of the model.
        CaseError: the case has no nominal body, or fewer payloads.
    """
    scaling = reference_scaling(case, model)
    mu = singular_values(mean_information(model, scaling, motion), model.names)
    noise = expected_noise(case, model, payloads[-1])
    weighted, errors = mu, PoseErrors.of(case, noise)
    if noise.whitening is not None or errors is not None:
        left = information_of(seen_through(model, noise.whitening), scaling, motion, errors)
        weighted = singular_values(left, model.names)
    figures = {
        "logdet": CRITERIA["D"](mu),
        "condition": -CRITERIA["K"](mu),
        "criterion_value": CRITERIA[criterion](weighted),
        "assumed_noise_N": noise.sensors,
    }
    return figures, noise, worst_std(case, model, scaling, motion, payloads)


def beside_manual(plan: Plan) -> tuple[dict[str, float], float, bool] | str:
    """The hand-made motion of the plan's case with the plan's model, noise and payload; or why there is none.

    Returns:
        Predicted standard deviation of each physical parameter [SI] for as much measuring time as the plan's, repeated
        or broken off, where errors average out; else, where they depend on the pose, of one run; its duration [s];
        whether they average out.
    """
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
        averaging = case.sensors.pose_error_N is None
        times = float(np.sqrt(motion.duration / plan.duration)) if averaging else 1.0
        return {name: std * times for name, (std, _) in worst.items()}, motion.duration, averaging
    except HexciteError as error:
        return f"there is no hand-made motion to compare with: {error.typed}"
