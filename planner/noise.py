"""The expected noise of a run, as the case states it, and its effect on the information of a motion.

Errors of force sensors do not depend on which body moves; noise of accelerations acts on that body, so that payloads
change it. A motion is planned for the weights that its identification will use, and its standard deviations are
predicted for these weights and this noise, whether the weights are right for it or not.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from cases.schema import Case
from cases.sensors import PoseField
from identification.estimation.criteria import information as information_over
from identification.estimation.pose_field import matern, squared_distances
from identification.machines.casadi_batch import over_samples
from identification.machines.hexapod import Hexapod
from identification.model.model import Model, identification_model
from identification.model.parameters import nominal_parameters
from identification.model.stated_noise import noise_covariance, whitening_of
from identification.motion.motion import Array, Trajectory

DEFAULT_NOISE = 1.0  # [N] noise where the case states none of its sensors
UNITS = (slice(0, 3), slice(3, 6))  # forces and moments of a force/torque sensor


@dataclass(frozen=True, slots=True)
class ExpectedNoise:
    """White noise of one force sample."""

    sensors: float  # standard deviation of a force sensor alone [N]
    channels: Array  # covariance of the channels with noise of the accelerations, shape (6, 6) [N^2, ..]
    weights: str  # weights of the identification, as in `cases.sensors`
    shaken: bool  # whether the case states noise of the accelerations

    @property
    def std(self) -> Array:
        """Standard deviation of each channel, shape (6,) [N, or N and N m]."""
        return np.asarray(np.sqrt(np.diag(self.channels)))

    @property
    def whitening(self) -> Array | None:
        """Root of W in units of the sensors' noise, shape (6, 6); None for W = 1."""
        if self.weights == "equal":
            return None
        if self.weights == "stated":
            return self.sensors * whitening_of(self.channels)
        variance = np.diag(self.channels)
        if self.weights == "per_unit":
            variance = np.repeat([variance[unit].mean() for unit in UNITS], 3)
        return np.diag(self.sensors / np.sqrt(variance))

    @property
    def scatter(self) -> Array | None:
        """R, shape (6, 6), with R^T R = W C W, C the noise, in the sensors' units: the score scatters by A^T R^T R A.

        None where W is right for the noise, when that is the information itself.
        """
        whitening = np.eye(6) if self.whitening is None else self.whitening
        covariance = whitening @ self.channels @ whitening.T / self.sensors**2
        if np.allclose(covariance, np.eye(6), atol=1e-9):
            return None
        return np.asarray(np.linalg.cholesky(self.channels).T / self.sensors @ whitening.T @ whitening)


def sensor_noise(case: Case) -> float:
    """Standard deviation of a force sensor: as the case states it, else of its simulated machine [N]."""
    if case.sensors.force_noise_N is not None:
        return case.sensors.force_noise_N
    return case.simulation.force_noise_N if case.simulation is not None else DEFAULT_NOISE


def expected_noise(case: Case, model: Model, payload: int = 0, weights: str | None = None) -> ExpectedNoise:
    """The noise of a run, as a case states it.

    Args:
        payload: number of the case's payloads that are mounted on the nominal body.
        weights: weights of the identification; None for those of the case.

    Raises:
        CaseError: noise of accelerations without a nominal body, or fewer payloads.
    """
    weights = weights or case.sensors.weights
    one, sensors = sensor_noise(case), case.sensors
    if sensors.force_noise is None:  # no noise for weights is stated
        return ExpectedNoise(one, one**2 * np.eye(6), "equal", False)
    if sensors.acceleration_noise is None:
        return ExpectedNoise(one, np.diag(sensors.force_noise**2), weights, False)
    covariance = noise_covariance(model, sensors, nominal_parameters(model, case.body(payload)))
    return ExpectedNoise(one, covariance, weights, True)


def standing_model(case: Case, number: int) -> Model:
    """The model of averaged standstills; of a force/torque sensor as its stated noise weighs forces and moments.

    Raises:
        IdentificationError: no such model.
    """
    model, noise = identification_model(case, number), case.sensors.force_noise
    if noise is None or case.sensors.weights == "equal" or not case.sensor_frame.has_moments:
        return model
    return seen_through(model, sensor_noise(case) * np.diag(1.0 / noise))


def seen_through(model: Model, root: Array | None) -> Model:
    """The model whose information is A^T W A, W the square of `root`, shape (6, 6); the model itself where None."""
    return model if root is None else replace(model, whitening=root)


MOST_SAMPLES = 3000  # of a motion, between which errors are compared: a hexapod then moves less than a length each
BLOCK = 500  # samples whose correlations with all others are in memory at once


@dataclass(frozen=True, slots=True)
class PoseErrors:
    """Errors that depend on the pose beside white noise.

    Errors of encoders, joints and frame are the same whenever a motion returns to a place: they do not average out
    there. Identification weighs samples alike all the same: weights that count on such errors would rest on small
    differences at one place, which vibration falsifies (on the built-in hexapod it would bias the mass by 1 %). Its
    estimate then scatters by F^-1 M F^-1, where M = F + sum_ij A_i^T C_ij A_j and C is the covariance of the errors in
    units of the noise, and S = F M^-1 F takes the place of F: without errors it is F, and it is never more than the
    information of the best estimate, in which the errors are marginalised, sum_ij A_i^T ((1 + C)^-1)_ij A_j.
    """

    hexapod: Hexapod  # its strut lengths distinguish places
    field: PoseField
    rate: float  # variance of a channel's error over that of its noise, times samples a second [1/s]
    # R R^T, with R the root of W by which the regressors are multiplied; None for W = 1, shape (6, 6)
    mixing: Array | None = None

    @classmethod
    def of(cls, case: Case, noise: ExpectedNoise) -> "PoseErrors | None":
        """The pose errors of a case, for a run at its rate with the weights of `noise`; None where it states none."""
        field = case.sensors.pose_field
        if field is None:
            return None
        mixing = None if noise.whitening is None else noise.whitening @ noise.whitening.T
        rate = case.recording.rate_Hz * (field.size / noise.sensors) ** 2
        return cls(Hexapod.of(case), field, rate, mixing)

    def correlation(self, struts: Array, others: Array) -> Array:
        """Correlation of the errors between places, shapes (n, 6) and (m, 6) [m], shape (n, m)."""
        return matern(np.sqrt(squared_distances(struts, others)) / self.field.length)[0]

    def scatter(self, regressors: Array, struts: Array, duration: float) -> Array:
        """sum_ij A_i^T C_ij A_j over samples of equal shares, in units of the mean information, shape (u, u).

        Args:
            regressors: regressors of the samples, shape (n, 6, u).
            struts: strut lengths of the samples, shape (n, 6) [m].
            duration: duration that the samples represent [s].
        """
        rows = regressors if self.mixing is None else self.mixing @ regressors
        flat, count = rows.reshape(len(rows), -1), len(rows)
        total = np.zeros((regressors.shape[2],) * 2)
        for first in range(0, count, BLOCK):
            block = slice(first, first + BLOCK)
            answer = (self.correlation(struts[block], struts) @ flat).reshape(-1, *rows.shape[1:])
            total += np.tensordot(regressors[block], answer, ((0, 1), (0, 1)))
        return np.asarray(self.rate * duration / count**2 * (total + total.T) / 2.0)

    def scatter_of(self, model: Model, scaling: Array, motion: Trajectory) -> Array:
        """The scatter for a motion, shape (u, u).

        Args:
            model: gives A, multiplied with the root of W.
            scaling: diagonal of H, shape (u,).
        """
        count = min(MOST_SAMPLES, max(2, int(np.ceil(motion.duration * 1000.0))))
        states = motion.at((np.arange(count) + 0.5) * motion.duration / count)
        matrices = over_samples(model.coordinate_regressor, states.coordinates, states.rates, states.accelerations)[0]
        struts = self.hexapod.strut_lengths(states.coordinates)
        return self.scatter(matrices.reshape(count, 6, -1) * scaling, struts, motion.duration)


def of_estimate(information: Array, scatter: Array) -> Array:
    """S = F M^-1 F, the inverse of the covariance of an estimate by F whose score scatters by M, shape (u, u)."""
    answer = information @ np.linalg.solve(scatter, information)
    return np.asarray((answer + answer.T) / 2.0)


def counted_information(
    information: Callable[[Array | None], Array], noise: ExpectedNoise, by_pose: Array | None
) -> Array:
    """The information of an estimate with given weights: S where the weights do not suit the noise, shape (u, u).

    Args:
        information: root R of weights, shape (6, 6), None for 1 -> mean of H A^T R^T R A H.
        by_pose: part of errors of the pose in the scatter of the score, shape (u, u); None for no such errors.
    """
    weighted = information(noise.whitening)
    scattered = None if noise.scatter is None else information(noise.scatter)
    if by_pose is not None:
        scattered = (weighted if scattered is None else scattered) + by_pose
    return weighted if scattered is None else of_estimate(weighted, scattered)


def information_of_known(covariance: Array, scaling: Array, variance: float) -> Array:
    """Information of earlier results in units of that of what is planned, shape (u, u).

    Args:
        covariance: of u by their noise, shape (u, u) [SI].
        scaling: diagonal of H, shape (u,).
        variance: of a force sensor's noise, where information is a sum over samples; over their number where it is a
            mean of them [N^2].
    """
    scaled = covariance / np.outer(scaling, scaling)
    return np.asarray(variance * np.linalg.inv((scaled + scaled.T) / 2.0))


def information_of(model: Model, scaling: Array, trajectory: Trajectory, errors: PoseErrors | None) -> Array:
    """Mean information, reduced by errors of the pose; all of it where there are none, shape (u, u)."""
    plain = mean_information(model, scaling, trajectory)
    if errors is None:
        return plain
    return of_estimate(plain, plain + errors.scatter_of(model, scaling, trajectory))


def mean_information(model: Model, scaling: Array, trajectory: Trajectory, rate: float = 1000.0) -> Array:
    """Time average of H A^T A H over a trajectory, shape (u, u); W = 1.

    Args:
        scaling: diagonal of H, shape (u,).
        rate: samples a second [1/s].
    """
    count = max(2, int(np.ceil(trajectory.duration * rate)))
    motion = trajectory.at((np.arange(count) + 0.5) * trajectory.duration / count)
    return information_over(model, scaling, (motion.coordinates, motion.rates, motion.accelerations))
