"""What s0 of a moving run consists of, and how noise of the accelerations attenuates the parameters.

Errors e of the strut lengths reach the regressor almost only by their second derivative: behind the filter lengths and
velocities err by less than a hundredth of what matters. A is affine in the accelerations, so that dA/dq'' is exact.
With forces f = A u, a regressor A + dA and D = E[dA^T W dA], the estimate is biased by
-((A + dA)^T W (A + dA) - D)^-1 D times itself for long runs (Fuller, Measurement Error Models, 1987, section 2.2).
Stated noise of the accelerations themselves leaves the same residuals whether the accelerations that are evaluated err
or the platform vibrates; only the former biases the estimate, so that the reported bias is the largest there can be.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from cases.sensors import Sensors
from cases.units import Array
from identification.estimation.fit import Fit
from identification.finding import Finding, Kind, warning
from identification.model import Model, regressors
from identification.parameters import PhysicalForm
from identification.samples import Samples
from identification.symbolic import Kinematics

MOST_LOST = 0.5  # of a run's apparent information on a parameter; beyond, the estimate of the bias is too uncertain
EXCESS = 1.25  # of s0^2 explained by what is stated: more is not chance, the statement is too pessimistic
GIVEN = 1e-9  # standard deviation over value below which a parameter was given, and the rest is rounding


@dataclass(frozen=True, slots=True)
class NoiseSources:
    """Shares of s0^2; estimates, since s0 is one."""

    force_sensors: float | None  # share of the stated noise of the forces; None where none is stated
    # share of what the stated noise of struts and accelerations does to the forces; None where none is stated
    accelerations: float | None
    # bias of u by noise of the accelerations, shape (u,); None where none is stated, or so much that it makes up half
    # of the run's information on a parameter
    bias: Array | None

    @property
    def explained(self) -> float:
        """Share of s0^2 that stated noise explains; above 1 where more is stated than there is."""
        return (self.force_sensors or 0.0) + (self.accelerations or 0.0)

    @property
    def findings(self) -> list[Finding]:
        """Findings against the noise that the case states."""
        sentences = []
        if self.accelerations is not None and self.bias is None:
            sentences.append(
                "the stated noise of struts or accelerations would make up half or more of the information about a "
                "parameter, whose attenuation is not reported: check sensors.encoder_resolution_um, strut_noise_um and "
                "acceleration_noise_m_s2"
            )
        if self.explained > EXCESS:
            sentences.append(
                f"the noise that the case states explains {100 * self.explained:.0f} % of s0^2: there is less of it; "
                "check sensors.force_noise_N, encoder_resolution_um, strut_noise_um and acceleration_noise_m_s2"
            )
        return [warning(Kind.NOISE, sentence) for sentence in sentences]

    def to_json(self) -> dict[str, Any]:
        """All but the bias, which is reported for physical parameters."""
        return {
            "force_sensors": self.force_sensors,
            "accelerations": self.accelerations,
            "unexplained": 1.0 - self.explained,
        }


def noise_sources(
    samples: Samples, fit: Fit, w: Array, delay: float, sensors: Sensors, averaged: float
) -> NoiseSources:
    """Compares what a case states about its noise with the residuals of a Gauss-Markov fit.

    Args:
        fit: its values begin with u; its covariance is (28).
        w: W for one sample, shape (6, 6).
        delay: delay of the forces [s].
        averaged: samples of the forces that were averaged for one of the recording.
    """
    squared = max(fit.s0**2, np.finfo(float).tiny)
    force_share = None
    if sensors.force_noise is not None:  # of the recorded samples, of which some were averaged for one of the fit
        force_share = float(np.mean(np.diag(w) * sensors.force_noise**2)) / averaged / squared
    stated = sensors.strut_variance is not None or sensors.acceleration_noise is not None
    moment = samples.regressor_noise(w, delay, sensors) if stated else None
    if moment is None:
        return NoiseSources(force_share, None, None)
    unknowns = len(moment)
    estimated = fit.values[:unknowns]
    inverse = fit.covariance[:unknowns, :unknowns] * samples.filtered.stride / squared  # F^-1; singular: some are given
    lost = inverse @ moment
    bias: Array | None = None
    if float(np.linalg.eigvals(lost).real.max()) < MOST_LOST:
        bias = np.asarray(-np.linalg.solve(np.eye(unknowns) - lost, lost @ estimated))
    true = estimated if bias is None else estimated - bias
    # The fit hides the part of dA u that biases it: u^T D u + u^T D b remains in the residuals.
    equivalent = float(true @ moment @ estimated) / (6 * len(samples.t) * samples.filtered.gain)
    return NoiseSources(force_share, equivalent / squared, bias)


def regressor_squares(model: Model, motion: Kinematics, directions: Array, w: Array) -> Array:
    """Expected sum of dA^T W dA, shape (u, u), where each column of `directions` is an independent error.

    Args:
        motion: motion of n samples.
        directions: what an error of one standard deviation adds to the twist rate, shape (n, 6, k).
        w: W for one sample, shape (6, 6).
    """
    matrices = regressors(model, motion)
    squares = np.zeros((matrices.shape[2],) * 2)
    for change in np.moveaxis(directions, 2, 0):
        effect = regressors(model, replace(motion, twist_rate=motion.twist_rate + change)) - matrices
        squares += np.einsum("nku,kl,nlv->uv", effect, w, effect, optimize=True)
    return squares


def attenuation_of(form: PhysicalForm, u: Array, bias: Array, std: Array) -> dict[str, dict[str, float | None]]:
    """Estimated bias of physical parameters by noise of the accelerations; their values are not corrected by it.

    For each the expected estimate less the true value [SI]; that over the value, None where it is zero; and over the
    standard deviation that is reported, None for what is given.

    Args:
        u: estimated parameters, shape (u,).
        bias: bias of it, shape (u,).
        std: standard deviation of the physical parameters as reported, shape (parameters,).
    """
    nothing = np.zeros((len(u), len(u)))
    values = form.of(u, nothing)[0]
    reference = values - form.of(u - bias, nothing)[0]
    return {
        p.name: {
            "bias": float(b),
            "relative": float(b / v) if v != 0.0 else None,
            "of_std": float(b / s) if s > GIVEN * abs(v) else None,
        }
        for p, v, b, s in zip(form.parameters, values, reference, std, strict=True)
    }
