"""The noise that a run will have, as the case states it, and what it makes of the information of a motion.

Force sensors err alike whatever moves; noise of accelerations is felt with the body that is moved, so that payloads
change it. A motion is planned for the weights that its identification will use, and its standard deviations are
predicted for these weights and this noise, whether the weights are right for it or not.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cases.schema import Case
from identification.model import Model, identification_model
from identification.noise.stated import StatedNoise, inverse_root
from identification.parameters import nominal_parameters

Array = NDArray[np.float64]

DEFAULT_NOISE = 1.0  # [N] where the case says nothing about its sensors
UNITS = (slice(0, 3), slice(3, 6))  # forces and moments of a force/torque sensor


@dataclass(frozen=True, slots=True)
class ExpectedNoise:
    """Of one force sample, white.

    Args:
        sensors: standard deviation of a force sensor alone [N].
        channels: covariance of the channels with noise of the accelerations, shape (6, 6) [N^2, ..].
        weights: how identification will weigh, as in `cases.sensors`.
        shaken: whether the case states noise of the accelerations.
    """

    sensors: float
    channels: Array
    weights: str
    shaken: bool

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
            return self.sensors * inverse_root(self.channels)
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
        left = whitening @ self.channels @ whitening.T / self.sensors**2
        if np.allclose(left, np.eye(6), atol=1e-9):
            return None
        return np.asarray(np.linalg.cholesky(self.channels).T / self.sensors @ whitening.T @ whitening)


def sensor_noise(case: Case) -> float:
    """Of a force sensor as the case states it, else as its simulated machine has it [N]."""
    if case.sensors.force_noise_N is not None:
        return case.sensors.force_noise_N
    return case.simulation.force_noise_N if case.simulation is not None else DEFAULT_NOISE


def expected_noise(case: Case, model: Model, payload: int = 0, weights: str | None = None) -> ExpectedNoise:
    """What a case says about the noise of a run.

    Args:
        case: case with noise stated or not.
        model: model that turns accelerations into forces.
        payload: number of the case's payloads that are mounted on the nominal body.
        weights: weights of the identification; None for those of the case.

    Raises:
        CaseError: noise of accelerations without a nominal body, or fewer payloads.
    """
    weights = weights or case.sensors.weights
    if case.sensors.force_noise is None:  # nothing is known to weigh by
        one = sensor_noise(case)
        return ExpectedNoise(one, one**2 * np.eye(6), "equal", False)
    noise = StatedNoise.of(model, case.sensors)
    if case.sensors.acceleration_noise is None:
        return ExpectedNoise(sensor_noise(case), np.diag(noise.force**2), weights, False)
    covariance = noise.covariance(nominal_parameters(model, case.body(payload)))
    return ExpectedNoise(sensor_noise(case), covariance, weights, True)


def standing_model(case: Case, number: int) -> Model:
    """The model of averaged standstills; of a force/torque sensor as its stated noise weighs forces and moments.

    Args:
        case: gives the sensors.
        number: number in Table 2.

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
