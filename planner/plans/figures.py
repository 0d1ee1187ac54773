"""Figures of a plan: predicted standard deviations of one run, information, and the record of its search.

Fields of `Worth` and `PoseWorth` have the names of their entries in `plan.json`.
"""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from itertools import zip_longest
from typing import Any

import numpy as np
from pydantic import TypeAdapter

from cases.base.phrases import again, said
from cases.schema import Case
from identification.estimation.criteria import Criterion, reference_scaling, singular_values, total_information
from identification.estimation.pose_field import field_covariance
from identification.limits.limit import LimitReport
from identification.machines.hexapod import Hexapod
from identification.model.model import Model
from identification.model.parameters import nominal_parameters
from identification.motion.motion import Array, Trajectory
from planner.bounds.bound import Bound
from planner.noise import (
    ExpectedNoise,
    PoseErrors,
    counted_information,
    expected_noise,
    information_of,
    mean_information,
    seen_through,
    sensor_noise,
)
from planner.plans.prediction import Prediction, tolerated_at_poses, tolerated_in_motion
from planner.search.record import Failed, StartRecord


@dataclass(frozen=True, slots=True)
class Worth:
    """Figures of a planned motion, and the record of its search."""

    starts: tuple[StartRecord, ...]  # starts with a feasible motion, the best first
    failed_starts: tuple[Failed, ...]  # the others, with the reason
    criterion_value: float  # the criterion of Table 4, to be maximised, in reference scaling
    logdet: float  # log det of the mean information, reference scaling, W = 1
    condition: float  # mu_1 / mu_u, reference scaling
    bound: Bound
    # standard deviation of a sample of each channel behind the predictions [N, or N and N m]
    assumed_noise_of_channels: tuple[float, ...]
    noise_of_accelerations: bool  # whether noise of the accelerations is included
    weights: str  # weights of the identification that predictions assume
    weaknesses: tuple[str, ...]  # why another plan would carry more information
    notes: tuple[str, ...]  # notes for the user before running it
    # D-efficiency of the best motion of each family, the best first, where the family was chosen by trying
    tried: dict[str, float] = field(default_factory=dict)

    @property
    def d_efficiency(self) -> float:
        """D-efficiency against the box bound."""
        return self.bound.efficiency(self.logdet)

    def to_json(self) -> dict[str, Any]:
        """Entries of `plan.json`."""
        phrases = {f"{name}_phrases": [said(words).to_json() for words in getattr(self, name)] for name in _WORDED}
        return asdict(self) | phrases | {"d_efficiency": self.d_efficiency}

    @classmethod
    def of_json(cls, entries: Mapping[str, Any]) -> "Worth":
        """The value of these entries; raises ValidationError for what they cannot be."""
        worth = TypeAdapter(cls).validate_python(entries)
        weaknesses, notes = (_sentences(getattr(worth, name), entries.get(f"{name}_phrases")) for name in _WORDED)
        return replace(worth, weaknesses=weaknesses, notes=notes)


def _sentences(sentences: Sequence[str], phrases: object) -> tuple[str, ...]:
    """Sentences of a file with their codes, where it has them."""
    codes = phrases if isinstance(phrases, list) else []
    return tuple(again(words, code) for words, code in zip_longest(sentences, codes[: len(sentences)]))


_WORDED = ("weaknesses", "notes")
"""Fields of sentences."""


@dataclass(frozen=True, slots=True)
class PoseWorth:
    """Figures of a set of poses."""

    remark: str  # result of the choice, in words
    candidates: int  # number of valid poses to choose from
    travel_s: float  # time of the moves [s]
    criterion_value: float  # criterion of Table 4, to be maximised: mean information, reference scaling
    condition: float  # mu_1 / mu_u, reference scaling
    efficiency: float  # lower bound of the D-efficiency against every design over the candidates; certified
    select_s: float  # time spent on choosing [s]

    def to_json(self) -> dict[str, Any]:
        """Entries of `plan.json`."""
        return asdict(self)


BINDING = 0.99  # share of a limit from which it determines the motion


def bound_by(limits: LimitReport) -> list[str]:
    """The limits that determine a motion."""
    return [c.name for c in limits.checks if c.binding and c.ratio > BINDING]


def noise_covariance(case: Case, scaling: Array, information: Array, duration: float, noise: float) -> Array:
    """Covariance of u for one run at the rate of the case, by noise, shape (u, u).

    Args:
        scaling: diagonal of H, shape (u,).
        information: mean of H A^T W A H, or that `of_estimate` where W is not right for the noise, shape (u, u).
        duration: duration of the motion [s].
        noise: standard deviation of a force sample [N]; W is in units of noise^-2.
    """
    covariance = noise**2 / (duration * case.recording.rate_Hz) * np.linalg.inv(information)
    return np.asarray(covariance * np.outer(scaling, scaling))


def prediction_at_poses(
    case: Case, model: Model, scaling: Array, regressors: Array, poses: Array, noise: float, values: Array | None = None
) -> Prediction:
    """What averaged standstills promise.

    Args:
        case: gives errors that depend on the pose, and tolerances.
        model: as the estimate weighs it.
        scaling: scaling of its columns, shape (u,).
        regressors: regressors of the poses, scaled, shape (n, 6, u).
        poses: shape (n, 6) [m, rad].
        noise: standard deviation of an averaged force [N].
        values: u for which it is, shape (u,); that of the nominal body unless given.
    """
    inverse = np.linalg.inv(total_information(regressors))
    covariance = np.asarray(noise**2 * inverse, dtype=np.float64)
    if (field := case.sensors.pose_field) is not None:
        by_pose = field_covariance(field, Hexapod.of(case).strut_lengths(poses))
        covariance = covariance + inverse @ sum(a.T @ by_pose @ a for a in regressors.transpose(1, 0, 2)) @ inverse
    covariance = np.asarray(covariance * np.outer(scaling, scaling), dtype=np.float64)
    plain = replace(model, whitening=None)
    values = nominal_parameters(plain, case.body(0)) if values is None else values
    if case.tolerances is None:
        return Prediction(plain, values, covariance).with_bounds(case.bounds)
    one, noise_of_case = sensor_noise(case), case.sensors.force_noise
    expected = ExpectedNoise(one, one**2 * np.eye(6), "equal", False)
    if model.whitening is not None and noise_of_case is not None:
        expected = ExpectedNoise(one, np.diag(noise_of_case**2), "stated", False)
    more = tolerated_at_poses(case, plain, values, poses, covariance, expected, noise)
    prediction = Prediction(plain, values, covariance + more.noise, more.biases, more.lasting)
    return prediction.with_bounds(case.bounds)


def prediction_of(
    case: Case,
    model: Model,
    scaling: Array,
    motion: Trajectory,
    noise: ExpectedNoise,
    payload: int,
    values: Array | None = None,
) -> Prediction:
    """What a run of a motion promises, by rate, weights, noise, errors that depend on the pose, and tolerances.

    Args:
        payload: number of payloads that are mounted on the nominal body.
        values: u for which it is, shape (u,); that of this body unless given.
    """
    errors = PoseErrors.of(case, noise)
    by_pose = None
    if errors is not None:
        by_pose = errors.scatter_of(seen_through(model, noise.whitening), scaling, motion)
    information = counted_information(
        lambda root: mean_information(seen_through(model, root), scaling, motion), noise, by_pose
    )
    covariance = noise_covariance(case, scaling, information, motion.duration, noise.sensors)
    values = nominal_parameters(model, case.body(payload)) if values is None else values
    bounds = None if payload else case.bounds  # they are of the body alone
    if case.tolerances is None:
        return Prediction(model, values, covariance).with_bounds(bounds)
    more = tolerated_in_motion(case, model, values, motion, covariance, noise)
    return Prediction(model, values, covariance + more.noise, more.biases, more.lasting).with_bounds(bounds)


def predictions_of(
    case: Case, model: Model, scaling: Array, motion: Trajectory, payloads: Sequence[int]
) -> tuple[Prediction, ...]:
    """What runs of a motion promise, one for each number of payloads, with the noise and weights of what is mounted."""
    return tuple(prediction_of(case, model, scaling, motion, expected_noise(case, model, n), n) for n in payloads)


def figures_of(
    case: Case, model: Model, motion: Trajectory, payload: int, criterion: Criterion
) -> tuple[dict[str, float], ExpectedNoise]:
    """Figures of a motion with a number of payloads mounted: entries of `plan.json`, and the noise.

    The criterion is of the information that the search maximised: with the weights of the case, and reduced by errors
    of the pose.

    Raises:
        IdentificationError: the motion does not excite all parameters of the model.
    """
    scaling = reference_scaling(case, model)
    mu = singular_values(mean_information(model, scaling, motion), model.names)
    noise = expected_noise(case, model, payload)
    weighted, errors = mu, PoseErrors.of(case, noise)
    if noise.whitening is not None or errors is not None:
        information = information_of(seen_through(model, noise.whitening), scaling, motion, errors)
        weighted = singular_values(information, model.names)
    figures = {
        "logdet": Criterion.D.of_singular_values(mu),
        "condition": -Criterion.K.of_singular_values(mu),
        "criterion_value": Criterion(criterion).of_singular_values(weighted),
        "assumed_noise_N": noise.sensors,
    }
    return figures, noise
