"""Noise of forces that a case states, as a model's forces have it: its covariance, and the weights that follow."""

import numpy as np

from cases.base.units import Array
from cases.sensors import Sensors
from identification.model.model import Model


def noise_covariance(model: Model, sensors: Sensors, values: Array) -> Array:
    """Covariance of a force sample at u, by sensors that state noise of forces at least, shape (6, 6)."""
    force, acceleration = sensors.force_noise, sensors.acceleration_noise
    assert force is not None
    effects = acceleration_to_force(model, values) * (np.zeros(6) if acceleration is None else acceleration)
    return np.asarray(np.diag(force**2) + effects @ effects.T)


def acceleration_to_force(model: Model, values: Array) -> Array:
    """G = df/d(twist rate) at u where {P} and {B} have the same axes, shape (6, 6); exact, A is affine in that rate."""
    still, rotations = np.zeros((7, 6)), np.broadcast_to(np.eye(3), (7, 3, 3))
    matrices = model.matrices(still[:, :3], rotations, still, np.vstack([np.zeros(6), np.eye(6)]))
    forces = matrices @ values
    return np.asarray((forces[1:] - forces[0]).T)


def whitening_of(covariance: Array) -> Array:
    """C with C covariance C^T = 1, shape (6, 6), lower triangular; newtons and newton metres are scaled apart."""
    std = np.sqrt(np.diag(covariance))
    return np.asarray(np.linalg.inv(np.linalg.cholesky(covariance / np.outer(std, std))) / std)
