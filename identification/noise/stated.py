"""How noise of sensors and accelerations that a case states reaches the forces, and the weights that follow.

A force sample errs by cov = diag(sigma_f^2) + G diag(sigma_a^2) G^T, where G = df/d(twist rate) holds the moved body:
what vibrates is felt in proportion to it, and by all sensors together. W = cov^-1 (24) is then right. As the noise of
accelerations is the same in all directions, cov depends on neither pose nor motion, only on the body.

Errors of strut lengths are not part of it: second derivatives make them grow with the square of the frequency, so that
at the few hertz of a motion they are below a hundredth of what is left near the cut-off, and W is about the former.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cases.errors import IdentificationError
from cases.sensors import Sensors
from identification.estimation.selection import Selection
from identification.model import Model

Array = NDArray[np.float64]

TURNS = 3  # of weights and parameters; the weights need the parameters to a percent only


@dataclass(frozen=True, slots=True)
class StatedNoise:
    """White noise of one recorded sample."""

    model: Model  # model that turns accelerations into forces
    force: Array  # standard deviation of each channel, shape (6,) [N, or N and N m]
    acceleration: Array  # acceleration of each component of the twist rate, shape (6,) [m/s^2, rad/s^2]

    @classmethod
    def of(cls, model: Model, sensors: Sensors) -> "StatedNoise":
        """What a case states.

        Raises:
            IdentificationError: it states no noise of forces.
        """
        if sensors.force_noise is None:
            raise IdentificationError(
                "weights stated: the case states no noise; give sensors.force_noise_N and acceleration_noise_m_s2, or "
                "choose the weights equal or per_channel"
            )
        acceleration = sensors.acceleration_noise
        return cls(model, sensors.force_noise, np.zeros(6) if acceleration is None else acceleration)

    def of_accelerations(self, values: Array) -> Array:
        """Covariance of the forces that noise of the accelerations alone makes, shape (6, 6) [N^2, N^2 m ..].

        Args:
            values: u, shape (u,).
        """
        effects = acceleration_to_force(self.model, values) * self.acceleration
        return np.asarray(effects @ effects.T)

    def covariance(self, values: Array) -> Array:
        """Covariance of a force sample, shape (6, 6) [N^2, N^2 m ..].

        Args:
            values: u, shape (u,).
        """
        return np.diag(self.force**2) + self.of_accelerations(values)

    def whitening(self, values: Array) -> Array:
        """What makes the noise of a force sample white and of variance 1, shape (6, 6): W is its square, (24)."""
        return inverse_root(self.covariance(values))

    def whitening_from(self, regressors: Array, forces: Array, selection: Selection) -> Array:
        """The same with u from the data themselves, in turns.

        Args:
            regressors: A_j, shape (n, 6, u).
            forces: shape (n, 6) [N, or N and N m].
        """
        whitening = np.diag(1.0 / self.force)
        for _ in range(TURNS):
            target = (forces - regressors @ selection.offset) @ whitening.T
            reduced = (whitening @ regressors @ selection.basis).reshape(-1, selection.basis.shape[1])
            free = np.linalg.lstsq(reduced, target.ravel(), rcond=None)[0]
            whitening = self.whitening(selection.offset + selection.basis @ free)
        return whitening


def acceleration_to_force(model: Model, values: Array) -> Array:
    """G = df/d(twist rate) where {P} and {B} have the same axes, shape (6, 6); exact, A is affine in the twist rate.

    Args:
        values: u, shape (u,).
    """
    still, rotations = np.zeros((7, 6)), np.broadcast_to(np.eye(3), (7, 3, 3))
    matrices = model.matrices(still[:, :3], rotations, still, np.vstack([np.zeros(6), np.eye(6)]))
    forces = matrices @ values
    return np.asarray((forces[1:] - forces[0]).T)


def inverse_root(covariance: Array) -> Array:
    """C with C covariance C^T = 1, shape (6, 6), lower triangular; newtons and newton metres are scaled apart."""
    std = np.sqrt(np.diag(covariance))
    return np.asarray(np.linalg.inv(np.linalg.cholesky(covariance / np.outer(std, std))) / std)
