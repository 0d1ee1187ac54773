"""What every estimator returns, and noise as a case states it: of the pose, of sensors and of accelerations.

Errors that depend on the pose are a random function of the place in each channel, as `pose_noise` says.

A force sample errs by cov = diag(sigma_f^2) + G diag(sigma_a^2) G^T, where G = df/d(twist rate) holds the moved body:
vibration is measured in proportion to it, and by all sensors together. W = cov^-1 (24) is then right. As the noise of
accelerations is the same in all directions, cov depends on neither pose nor motion, only on the body. Errors of
strut lengths are not part of it: second derivatives make them grow with the square of the frequency, so that at the few
hertz of a motion they are below a hundredth of the residuals near the cut-off, and W is about the former.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from cases.errors import IdentificationError
from cases.sensors import PoseField, Sensors
from cases.units import Array
from identification.finding import Finding, Kind, note
from identification.model import Model
from identification.parameters import Selection


class Uncertain(NamedTuple):
    """A value and its standard deviation."""

    value: float
    std: float


class Filtered(NamedTuple):
    """Effect of a low-pass on white noise before the fit, and how many samples behind it are evaluated."""

    gain: float  # variance of filtered noise over that of recorded noise, the sum of the squared kernel
    stride: float  # recorded samples for each one that is evaluated


UNFILTERED = Filtered(1.0, 1)


class Regression(NamedTuple):
    """f = A u + noise: samples one after the other, for parameters u."""

    regressors: Array  # A_j, shape (n, 6, u)
    forces: Array  # shape (n, 6) [N, or N and N m]
    names: Sequence[str]  # names of the u columns
    # so many of the last columns are not parameters of the model: they are estimated too, and cost certainty, but rank
    # and condition are reported without them
    nuisance: int = 0
    filtered: Filtered = UNFILTERED  # what was done to regressors and forces before

    def residuals(self, values: Array) -> Array:
        """What u leaves of the forces, f - A u, shape (n, 6)."""
        return np.asarray(self.forces - self.regressors @ values)

    def whitened(self, whitening: Array | None) -> "Regression":
        """Both sides multiplied with the root of W, shape (6, 6); as they are where it is None."""
        if whitening is None:
            return self
        return self._replace(regressors=whitening @ self.regressors, forces=self.forces @ whitening.T)


EACH = (0, 1, 2, 3, 4, 5)  # channels that have the same noise carry the same number: here none


def squared_distances(places: Array, others: Array) -> Array:
    """Between places, shapes (n, d) and (m, d), shape (n, m)."""
    middle = others.mean(axis=0)
    first, second = places - middle, others - middle
    total = np.sum(first**2, axis=1)[:, None] + np.sum(second**2, axis=1)
    return np.asarray(np.maximum(total - 2.0 * first @ second.T, 0.0))


def matern(distance: Array) -> tuple[Array, Array]:
    """Matern's correlation of smoothness 3/2 at a distance in lengths, and its derivative by the length's logarithm."""
    scaled = np.sqrt(3.0) * distance
    fading = np.exp(-scaled)
    return (1.0 + scaled) * fading, scaled**2 * fading


def field_covariance(field: PoseField, struts: Array) -> Array:
    """Covariance of a channel's errors between places, shape (n, n) [N^2]; struts: shape (n, 6) [m]."""
    return field.size**2 * matern(np.sqrt(squared_distances(struts, struts)) / field.length)[0]


class Robust(NamedTuple):
    """Covariance of an estimate where noise is not white."""

    covariance: Array  # covariance of u, shape (u, u)
    findings: tuple[Finding, ...] = ()
    field: PoseField | None = None  # errors that depend on the pose, where the run shows them


@dataclass(frozen=True, slots=True)
class Fit:
    """An estimate of u."""

    values: Array  # u, shape (u,)
    covariance: Array  # s0^2 F^-1, (28), shape (u, u): right where the recorded noise is white
    covariance_robust: Array  # autocorrelation-robust, shape (u, u): right also where it is not
    s0: float  # (27), of the recorded forces; dimensionless where weights are given, else [N]
    freedom: float  # degrees of freedom of s0
    residuals: Array  # f - A u, shape (n, 6) [N, or N and N m]
    weights: Array  # diagonal of W for one sample, shape (6,)
    rank: int  # rank of the scaled regressor
    condition: float  # mu_1 / mu_u of the scaled regressor (26)
    # what the estimator did beside, as a constraint that bound, or a prior that moved it, and what speaks against it,
    # as a prior that disagrees, or a search that did not settle
    findings: tuple[Finding, ...] = ()
    field: PoseField | None = None  # errors that depend on the pose, where the run shows them


@dataclass(frozen=True, slots=True)
class StatedNoise:
    """White noise of one recorded sample."""

    model: Model  # model that turns accelerations into forces
    force: Array  # standard deviation of each channel, shape (6,) [N, or N and N m]
    acceleration: Array  # acceleration of each component of the twist rate, shape (6,) [m/s^2, rad/s^2]

    @classmethod
    def of(cls, model: Model, sensors: Sensors) -> "StatedNoise":
        """The noise that a case states.

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

    def covariance(self, values: Array) -> Array:
        """Covariance of a force sample of the body with parameters u, shape (6, 6) [N^2, N^2 m ..]."""
        effects = acceleration_to_force(self.model, values) * self.acceleration
        return np.asarray(np.diag(self.force**2) + effects @ effects.T)

    def whitening(self, values: Array) -> Array:
        """Matrix that makes the noise of a force sample white with variance 1, shape (6, 6): W is its square, (24)."""
        return whitening_of(self.covariance(values))

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
    """G = df/d(twist rate) at u where {P} and {B} have the same axes, shape (6, 6); exact, A is affine in that rate."""
    still, rotations = np.zeros((7, 6)), np.broadcast_to(np.eye(3), (7, 3, 3))
    matrices = model.matrices(still[:, :3], rotations, still, np.vstack([np.zeros(6), np.eye(6)]))
    forces = matrices @ values
    return np.asarray((forces[1:] - forces[0]).T)


def whitening_of(covariance: Array) -> Array:
    """C with C covariance C^T = 1, shape (6, 6), lower triangular; newtons and newton metres are scaled apart."""
    std = np.sqrt(np.diag(covariance))
    return np.asarray(np.linalg.inv(np.linalg.cholesky(covariance / np.outer(std, std))) / std)


TURNS = 3  # of weights and parameters; the weights need the parameters to a percent only
ROUNDS = 10  # of covariance and metric
LEAST = 100  # independent samples; with fewer the covariance is too uncertain to be taken apart
TELLING = 0.1  # share of the residuals' variance from which noise of accelerations is worth a word


def noise_components(fit: Fit, model: Model, filtered: Filtered, wrench: bool, weights: str) -> list[Finding]:
    """Takes the residuals of a run apart: noise that would leave such ones; nothing where they are too few.

    Args:
        fit: its values begin with u; its residuals are those of the forces behind the filter.
        wrench: whether the channels are three forces and three moments.
        weights: weights of the identification.
    """
    freedom = len(fit.residuals) * filtered.gain * filtered.stride - len(fit.values) / 6
    if freedom < LEAST:
        return []
    covariance = fit.residuals.T @ fit.residuals * filtered.stride / freedom
    if np.linalg.matrix_rank(covariance) < len(covariance):
        return []
    (force, *moment, acceleration, angular), share = components_of(
        covariance, model, fit.values[: len(model.parameters)], wrench
    )
    moments = f" and {moment[0]:.3g} N m" if wrench else ""
    sentence = (
        f"the residuals look like noise of {force:.3g} N{moments} in the channels and of {acceleration:.3g} m/s^2 and "
        f"{angular:.3g} rad/s^2 in the accelerations: if that is the machine's, state it in [sensors] of the case "
        "(force_noise_N, acceleration_noise_m_s2, angular_acceleration_noise_rad_s2), for smaller deviations with "
        "--weights stated; the vibration of a structure looks alike, and identify --flexible estimates its mode"
    )
    entries = {
        "force_noise_N": force,
        **({"moment_noise_Nm": moment[0]} if wrench else {}),
        "acceleration_noise_m_s2": acceleration,
        "angular_acceleration_noise_rad_s2": angular,
        "share_of_accelerations": share,
    }
    silent = share < TELLING or weights == "stated"
    return [note(Kind.NOISE, "" if silent else sentence, noise_components=entries)]


def components_of(total: Array, model: Model, values: Array, wrench: bool) -> tuple[list[float], float]:
    """White noise of one recorded sample that makes a covariance of the channels, shape (6, 6).

    Returns:
        Standard deviations of a force channel [N], of a moment channel where there are such [N m], of the acceleration
        of the origin of {P} in each direction [m/s^2] and of the angular acceleration [rad/s^2]; and the share of the
        variance, in units of the channels' own, that the accelerations explain.
    """
    from scipy.optimize import nnls  # half a second, which those that simulate or weigh can do without

    effects = acceleration_to_force(model, values)
    kinds = [np.r_[np.ones(3), np.zeros(3)], np.r_[np.zeros(3), np.ones(3)]] if wrench else [np.ones(6)]
    parts = [np.diag(k) for k in kinds] + [effects[:, k] @ effects[:, k].T for k in (slice(0, 3), slice(3, 6))]
    covariance = total
    theta = np.zeros(len(parts))
    for _ in range(ROUNDS):
        root = whitening_of(covariance)
        columns = np.stack([(root @ part @ root.T).ravel() for part in parts], axis=1)
        size = np.linalg.norm(columns, axis=0)
        theta = nnls(columns / size, (root @ total @ root.T).ravel())[0] / size
        covariance = sum((t * part for t, part in zip(theta, parts, strict=True)), np.zeros((6, 6)))
        covariance = covariance + 1e-9 * np.diag(np.diag(total))  # positive definite also without noise of a channel
    remainder = np.diag(
        covariance - sum((t * np.diag(k) for t, k in zip(theta, kinds, strict=False)), np.zeros((6, 6)))
    )
    return np.sqrt(theta).tolist(), float(np.mean(remainder / np.diag(covariance)))
