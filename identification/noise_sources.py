"""What s0 of a moving run consists of, and how noise of the accelerations attenuates the parameters.

Errors e of the strut lengths reach the regressor almost only by their second derivative: behind the filter lengths and
velocities err by less than a hundredth of what matters. A is affine in the accelerations, so that dA/dq'' is exact.
With forces f = A u, a regressor A + dA and D = E[dA^T W dA], the estimate is drawn by
-((A + dA)^T W (A + dA) - D)^-1 D times itself for long runs (Fuller, Measurement Error Models, 1987, section 2.2).
"""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cases.sensors import Sensors
from identification.evaluate import over_samples
from identification.evaluation import Run
from identification.fit import Fit
from identification.hexapod import Kinematics
from identification.model import regressors
from identification.parameters import PhysicalForm

Array = NDArray[np.float64]

MOST_LOST = 0.5  # of what a run seems to tell of a parameter; beyond, the estimate of the bias itself is too uncertain
EXCESS = 1.25  # of s0^2 explained by what is stated: more is no chance, the statement is too pessimistic
GIVEN = 1e-9  # standard deviation over value below which a parameter was given, and only rounding is left


class Attenuation(NamedTuple):
    """By how much noise of the accelerations draws a parameter; estimated, and not taken out of its value.

    Args:
        bias: expected estimate less the true value [SI].
        relative: bias over the value; None where that is zero.
        of_std: bias over the standard deviation that is reported; None for what is given.
    """

    bias: float
    relative: float | None
    of_std: float | None


@dataclass(frozen=True, slots=True)
class NoiseSources:
    """Shares of s0^2; estimates, since s0 is one.

    Args:
        force_sensors: of the stated noise of the forces; None where none is stated.
        accelerations: of what the stated noise of the struts does to the forces expected; None where none is stated.
        acceleration_std: of a strut acceleration behind the filter [m/s^2]; None where none is stated.
        equivalent_force_noise: white noise of the recorded forces that leaves as large residuals as that of the
            accelerations, in units of s0; None where none is stated. Errors of struts reach the accelerations mostly
            near the cut-off, where the motion tells nothing: they scatter the parameters far less than such white
            noise, which is what `std_robust` beside (28) shows.
        bias: of u by noise of the accelerations, shape (u,); None where none is stated, or so much that it makes
            up half of what the run tells of a parameter.
    """

    force_sensors: float | None
    accelerations: float | None
    acceleration_std: float | None
    equivalent_force_noise: float | None
    bias: Array | None

    @property
    def explained(self) -> float:
        """Share of s0^2 that stated noise explains; above 1 where more is stated than there is."""
        return (self.force_sensors or 0.0) + (self.accelerations or 0.0)

    @property
    def doubts(self) -> list[str]:
        """What speaks against the statement of the case."""
        doubts = []
        if self.accelerations is not None and self.bias is None:
            doubts.append(
                "the stated noise of the struts would make up half or more of what the run tells of a parameter, whose "
                "attenuation is not told: check sensors.encoder_resolution_um and strut_noise_um"
            )
        if self.explained > EXCESS:
            doubts.append(
                f"the noise that the case states explains {100 * self.explained:.0f} % of s0^2: there is less of it; "
                "check sensors.force_noise_N, sensors.encoder_resolution_um and sensors.strut_noise_um"
            )
        return doubts

    def to_json(self) -> dict[str, Any]:
        """All but the bias, which is told for physical parameters."""
        return {
            "force_sensors": self.force_sensors,
            "accelerations": self.accelerations,
            "unexplained": 1.0 - self.explained,
            "strut_acceleration_std_m_s2": self.acceleration_std,
            "equivalent_force_noise": self.equivalent_force_noise,
        }


def noise_sources(run: Run, fit: Fit, delay: float, sensors: Sensors) -> NoiseSources:
    """Compares what a case states about its noise with what a Gauss-Markov fit left.

    Args:
        run: that was fitted.
        fit: its values begin with u; its covariance is (28).
        delay: of the forces [s].
        sensors: with noise of forces, of struts or both.
    """
    squared = max(fit.s0**2, np.finfo(float).tiny)
    force_share = None
    if sensors.force_noise is not None:
        force_share = float(np.mean(fit.weights * sensors.force_noise**2)) / squared
    if sensors.strut_variance is None:
        return NoiseSources(force_share, None, None, None, None)
    variance = sensors.strut_variance * run.filter.acceleration_noise_gain
    unknowns = len(run.model.parameters)
    estimated, samples = fit.values[:unknowns], len(run.rows)
    inverse = fit.covariance[:unknowns, :unknowns] * run.filter.stride / squared  # F^-1; singular where some are given
    moment = np.zeros((unknowns, unknowns))  # D
    for change in acceleration_effects(run, run.kinematics(delay)):
        moment += variance * np.einsum("nku,k,nkv->uv", change, fit.weights, change, optimize=True)
    lost = inverse @ moment
    bias: Array | None = None
    if float(np.linalg.eigvals(lost).real.max()) < MOST_LOST:
        bias = np.asarray(-np.linalg.solve(np.eye(unknowns) - lost, lost @ estimated))
    true = estimated if bias is None else estimated - bias
    # Of dA u the fit hides what it is drawn by: u^T D u + u^T D b is left.
    equivalent = float(true @ moment @ estimated) / (6 * samples * run.filter.noise_gain)
    return NoiseSources(
        force_share, equivalent / squared, float(np.sqrt(variance)), float(np.sqrt(max(equivalent, 0.0))), bias
    )


def acceleration_effects(run: Run, motion: Kinematics) -> list[Array]:
    """dA/dq''_s for each strut s, shape (n, 6, u) [per m/s^2]; exact, A is affine in the accelerations."""
    here = regressors(run.model, motion)
    to_twist_rate = np.linalg.inv(over_samples(run.hexapod.inverse_jacobian, motion.pose)[1])
    return [
        regressors(run.model, Kinematics(motion.pose, motion.twist, motion.twist_rate + to_twist_rate[:, :, s])) - here
        for s in range(6)
    ]


def attenuation_of(form: PhysicalForm, u: Array, bias: Array, std: Array) -> dict[str, Attenuation]:
    """The bias of u as that of physical parameters.

    Args:
        form: of the model.
        u: as estimated, shape (u,).
        bias: of it, shape (u,).
        std: of the physical parameters as reported, shape (parameters,).
    """
    nothing = np.zeros((len(u), len(u)))
    values = form.of(u, nothing)[0]
    drawn = values - form.of(u - bias, nothing)[0]
    return {
        p.name: Attenuation(float(b), float(b / v) if v != 0.0 else None, float(b / s) if s > GIVEN * abs(v) else None)
        for p, v, b, s in zip(form.parameters, values, drawn, std, strict=True)
    }
