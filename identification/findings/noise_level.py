"""Noise of the residuals beside the noise that a case states, channel by channel, and when a run is doubtful for it."""

from collections.abc import Iterable

import numpy as np
from scipy.special import chdtri

from cases.schema import Case
from cases.units import Array
from identification.estimation.fit import Fit
from identification.finding import Finding
from identification.model import noise_covariance
from identification.samples import Samples

LOUD = 1.5  # times the stated noise: more than what a statement is usually wrong by, a fifth
FAR_ABOVE = 3.0  # times the stated noise: no statement is so wrong, the residuals have another cause
CHANCE = 1e-7  # probability of that excess in a channel by chance: standstills and short runs have few residuals
MUCH = 0.1  # rms of the residuals over that of what varies


def stated_noise(samples: Samples, fit: Fit, case: Case) -> Array | None:
    """Standard deviation of a recorded force in each channel by the case, shape (6,) [N, or N and N m].

    That of `[sensors]`, with what noise of accelerations and errors of the pose add to it; where it states no noise of
    forces, that of the simulated machine. None where the case states neither.
    """
    sensors, field = case.sensors, case.sensors.pose_field
    if sensors.force_noise is None:
        if case.simulation is None or not np.all(case.simulation.force_noise > 0.0):
            return None
        variance = case.simulation.force_noise**2
    else:
        variance = np.diag(noise_covariance(samples.model, sensors, fit.values[: len(samples.model.names)]))
    return np.asarray(np.sqrt(variance + (0.0 if field is None else field.size**2)))


def noise_of_channels(samples: Samples, fit: Fit) -> Array:
    """Noise of each channel by its residuals, as white noise of the recorded forces, shape (6,) [N, or N and N m]."""
    return np.asarray(np.sqrt(6.0 * np.sum(fit.residuals**2, axis=0) * samples.filtered.stride / fit.freedom))


def noise_excess(samples: Samples, fit: Fit, case: Case) -> Array | None:
    """Noise of each channel by its residuals over what the case states, shape (6,); None where it states none.

    Averages of standstills are compared with a single recorded sample: errors that do not average out are counted as
    noise where they are no larger than it.
    """
    stated = stated_noise(samples, fit, case)
    return None if stated is None else noise_of_channels(samples, fit) / stated


def clear_excess(fit: Fit, least: float) -> float:
    """Ratio of noise above which a channel is noisier than `least` times the stated noise, and not by chance."""
    freedom = max(fit.freedom / 6.0, 1.0)
    return least * float(np.sqrt(chdtri(freedom, CHANCE) / freedom))


def leaves_much(fit: Fit, forces: Array, case: Case) -> bool:
    """Whether a fit leaves a tenth or more of what varies in the forces, shape (n, 6), or in the moments among them."""
    units = (slice(0, 3), slice(3, 6)) if case.sensor_frame.has_moments else (slice(0, 6),)
    return any(np.mean(fit.residuals[:, u] ** 2) > MUCH**2 * np.mean(forces[:, u].var(axis=0)) for u in units)


def doubtful(samples: Samples, fit: Fit, case: Case, findings: Iterable[Finding]) -> bool:
    """Whether something speaks against a fit, so that other explanations of its run are worth a trial.

    That is a warning, a channel whose residuals are clearly noisier than the case states, or a share of the forces that
    the model leaves.
    """
    if any(finding.severity == "warning" for finding in findings):
        return True
    excess = noise_excess(samples, fit, case)
    if excess is not None and float(excess.max()) > clear_excess(fit, LOUD):
        return True
    return leaves_much(fit, samples.forces, case)
