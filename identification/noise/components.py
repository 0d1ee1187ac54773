"""What noise the residuals of a run look like: of each kind of channel, and of accelerations felt with the body.

Sensors err each for itself, what shakes the body is felt by all of them together: the covariance of the channels tells
one from the other. cov = sum theta_k V_k is fitted in the metric of its own inverse, theta >= 0, which is the maximum
likelihood for Gaussian residuals where no theta is zero (Anderson 1973, Ann. Stat. 1:135). Whatever else the model
leaves is counted as one of them.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import nnls

from identification.estimation.fit import Fit
from identification.finding import Finding, Kind, note
from identification.model import Model
from identification.noise.stated import acceleration_to_force, inverse_root
from identification.runs.evaluation import Run

Array = NDArray[np.float64]

TURNS = 10  # of covariance and metric
LEAST = 100  # independent samples; with fewer the covariance is too uncertain to be taken apart
TELLING = 0.1  # share of the residuals' variance from which noise of accelerations is worth a word


@dataclass(frozen=True, slots=True)
class NoiseComponents:
    """Standard deviations of white noise of one recorded sample that would leave such residuals.

    Args:
        force: of a force channel [N].
        moment: of a moment channel of a force/torque sensor [N m]; None for bars.
        acceleration: of the origin of {P}, in each direction [m/s^2].
        angular: of the angular acceleration [rad/s^2].
        share: of the residuals' variance, in units of the channels' own, that the accelerations explain.
    """

    force: float
    moment: float | None
    acceleration: float
    angular: float
    share: float

    def finding(self, weights: str) -> Finding:
        """What is to be told of it, `weights` being those of the identification; keys as in the case."""
        moments = "" if self.moment is None else f" and {self.moment:.3g} N m"
        told = (
            f"the residuals look like noise of {self.force:.3g} N{moments} in the channels and of "
            f"{self.acceleration:.3g} m/s^2 and {self.angular:.3g} rad/s^2 in the accelerations: if that is the "
            "machine's, state it in [sensors] of the case (force_noise_N, acceleration_noise_m_s2, "
            "angular_acceleration_noise_rad_s2), for smaller deviations with --weights stated"
        )
        entries = {
            "force_noise_N": self.force,
            **({} if self.moment is None else {"moment_noise_Nm": self.moment}),
            "acceleration_noise_m_s2": self.acceleration,
            "angular_acceleration_noise_rad_s2": self.angular,
            "share_of_accelerations": self.share,
        }
        silent = self.share < TELLING or weights == "stated"
        return note(Kind.NOISE, "" if silent else told, noise_components=entries)


def noise_components(run: Run, fit: Fit, wrench: bool) -> NoiseComponents | None:
    """Takes the residuals of a run apart; None where they are too few.

    Args:
        run: that was fitted.
        fit: its values begin with u; its residuals are those of the forces behind the filter.
        wrench: whether the channels are three forces and three moments.
    """
    freedom = len(run.rows) * run.filter.noise_gain * run.filter.stride - len(fit.values) / 6
    if freedom < LEAST:
        return None
    found = fit.residuals.T @ fit.residuals * run.filter.stride / freedom
    if np.linalg.matrix_rank(found) < len(found):
        return None
    return _taken_apart(found, run.model, fit.values[: len(run.model.parameters)], wrench)


def _taken_apart(found: Array, model: Model, values: Array, wrench: bool) -> NoiseComponents:
    """The components of a covariance of the channels, shape (6, 6)."""
    felt = acceleration_to_force(model, values)
    kinds = [np.r_[np.ones(3), np.zeros(3)], np.r_[np.zeros(3), np.ones(3)]] if wrench else [np.ones(6)]
    parts = [np.diag(k) for k in kinds] + [felt[:, k] @ felt[:, k].T for k in (slice(0, 3), slice(3, 6))]
    covariance = found
    theta = np.zeros(len(parts))
    for _ in range(TURNS):
        root = inverse_root(covariance)
        columns = np.stack([(root @ part @ root.T).ravel() for part in parts], axis=1)
        size = np.linalg.norm(columns, axis=0)
        theta = nnls(columns / size, (root @ found @ root.T).ravel())[0] / size
        covariance = sum((t * part for t, part in zip(theta, parts, strict=True)), np.zeros((6, 6)))
        covariance = covariance + 1e-9 * np.diag(np.diag(found))  # positive definite also without noise of a channel
    shaken = np.diag(covariance - sum((t * np.diag(k) for t, k in zip(theta, kinds, strict=False)), np.zeros((6, 6))))
    std = np.sqrt(theta)
    return NoiseComponents(
        float(std[0]), float(std[1]) if wrench else None, float(std[-2]), float(std[-1]),
        float(np.mean(shaken / np.diag(covariance))),
    )  # fmt: skip
