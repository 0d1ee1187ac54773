"""Noise of the residuals beside the noise that a case states, channel by channel, and when a run is doubtful for it."""

from collections.abc import Iterable

import numpy as np
from scipy.special import chdtri

from cases.base.phrases import Phrase, phrase
from cases.base.units import Array
from cases.schema import Case
from identification.estimation.fit import Fit
from identification.estimation.force_noise import products
from identification.finding import Finding, Kind, note, warning
from identification.model.model import expected_forces
from identification.model.stated_noise import noise_covariance
from identification.recording.recording import Recording
from identification.samples.samples import Fitted, MotionOfSamples, Samples
from identification.signals import white_noise
from identification.texts import two_digits

LOUD = 1.5  # times the stated noise: more than what a statement is usually wrong by, a fifth
FAR_ABOVE = 3.0  # times the stated noise: no statement is so wrong, the residuals have another cause
CHANCE = 1e-7  # probability of that excess in a channel by chance: standstills and short runs have few residuals
MUCH = 0.1  # rms of the residuals over that of what varies


def channel_words(case: Case, k: int) -> tuple[str, str]:
    """Name of a channel in the file, and its unit."""
    name, _, unit = case.sensor_frame.channels[k].rpartition("_")
    return case.recording.file_name(f"{name}_{unit}"), {"Nm": "N m"}.get(unit, unit)


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
    """Noise of each channel by its residuals, as white noise of the recorded forces, shape (6,) [N, or N and N m].

    Averages of standstills are taken for a single recorded sample: errors that do not average out are counted as noise
    where they are no larger than it.
    """
    return np.asarray(np.sqrt(6.0 * np.sum(fit.residuals**2, axis=0) * samples.filtered.stride / fit.freedom))


def clear_excess(fit: Fit, least: float) -> float:
    """Ratio of noise above which a channel is noisier than `least` times the stated noise, and not by chance."""
    freedom = max(fit.freedom / 6.0, 1.0)
    return least * float(np.sqrt(chdtri(freedom, CHANCE) / freedom))


ALL_BELOW = 1.1  # times the stated noise, that residuals behind the filter have where all of it lies below the cut-off
TOGETHER = 0.1  # mean square of the correlations of channels, from which they are disturbed together


def disturbed_together(residuals: Array) -> bool:
    """Whether residuals, shape (n, 6), are alike in several channels, as sensors with noise of their own never are.

    What moves the machine, pulls at it, or makes its motion uncertain reaches the channels together.
    """
    count = len(residuals)
    scaled = residuals / np.maximum(np.sqrt(np.mean(residuals**2, axis=0)), np.finfo(float).tiny)
    squares = ((scaled.T @ scaled / count) ** 2)[np.triu_indices(6, 1)]
    memory = np.mean([products(channel) for channel in scaled.T], axis=0) / count
    independent = count / (1.0 + 2.0 * float(np.sum(memory[1:] ** 2)))  # Bartlett 1946, of two series
    return bool(squares.mean() > TOGETHER and independent * squares.sum() > chdtri(len(squares), CHANCE))


def may_remember(samples: Samples, fit: Fit, recorded: Array, stated: Array) -> bool:
    """Whether sensors of the stated noise, which remembers, could leave such residuals.

    The noise of a recorded sample may all lie below the cut-off: then residuals behind the filter are as large as it.

    Args:
        recorded: forces as recorded, shape (m, 6).
        stated: standard deviation of a recorded force, shape (6,).
    """
    if not samples.nuisances or np.any(np.mean(fit.residuals**2, axis=0) > (ALL_BELOW * stated) ** 2):
        return False
    return not np.any(white_noise(recorded) > LOUD * stated) and not disturbed_together(fit.residuals)


def leaves_much(fit: Fit, forces: Array, case: Case) -> bool:
    """Whether a fit leaves a tenth or more of what varies in the forces, shape (n, 6), or in the moments among them."""
    units = (slice(0, 3), slice(3, 6)) if case.sensor_frame.has_moments else (slice(0, 6),)
    return any(np.mean(fit.residuals[:, u] ** 2) > MUCH**2 * np.mean(forces[:, u].var(axis=0)) for u in units)


def doubtful(samples: Samples, fit: Fit, case: Case, findings: Iterable[Finding]) -> bool:
    """Whether something speaks against a fit, so that other explanations of its run are worth a trial.

    That is a warning, as of residuals far above the stated noise, or a share of the forces that the model leaves.
    """
    if any(finding.severity == "warning" for finding in findings):
        return True
    return leaves_much(fit, samples.forces, case)


INSTANTS = 200  # of a run, at which noise of the drives is turned into forces


def noise_by_drives(fitted: Fitted, motion: MotionOfSamples | None) -> Array:
    """What noise of the recorded drives makes of the residuals of each channel, as white noise of the recorded forces.

    Through their accelerations alone, with the noise that the recording shows, shape (6,) [N, or N and N m]; zero where
    that is not known.

    Args:
        fitted: the fit.
        motion: how the load moves at its samples, or at a part of them; None where that is not known.
    """
    if motion is None or motion.drives is None or motion.acceleration_noise is None or not motion.known.any():
        return np.zeros(6)
    fit, model = fitted.fit, fitted.samples.model
    known = np.flatnonzero(motion.known)
    at = motion.at(known[:: -(-len(known) // INSTANTS)])
    assert at.drives is not None
    place, speed, acceleration = at.drives
    values = fit.values[: len(model.names)]
    still, power = expected_forces(model, at.moved(place, speed, acceleration), values), np.zeros(6)
    for axis, noise in zip(np.eye(acceleration.shape[1]), motion.acceleration_noise, strict=True):
        change = expected_forces(model, at.moved(place, speed, acceleration + axis), values) - still  # affine in it
        power += np.mean((noise * change) ** 2, axis=0)
    # residuals of that size are the noise of channels, as `noise_of_channels` has it
    return np.asarray(np.sqrt(6.0 * len(fit.residuals) * power * fitted.samples.filtered.stride / fit.freedom))


def louder_than_stated(
    recording: Recording, case: Case, fitted: Fitted, motion: MotionOfSamples | None = None
) -> list[Finding]:
    """Channels whose residuals are clearly noisier than the case states, the worst with its figures.

    Args:
        recording: the run.
        case: the case with which it was evaluated.
        fitted: the fit.
        motion: as of `noise_by_drives`.
    """
    fit, noise_of_case = fitted.fit, stated_noise(fitted.samples, fitted.fit, case)
    if noise_of_case is None:
        return []
    noise = noise_of_channels(fitted.samples, fit)
    excess, limit = noise / noise_of_case, clear_excess(fit, LOUD)
    worst = int(np.argmax(excess))
    if excess[worst] <= limit:
        return []
    sentence, (channel, unit) = _excess_words(noise, noise_of_case, limit, case), channel_words(case, worst)
    shaken = noise_by_drives(fitted, motion)
    entry = {
        "ratios": excess.tolist(), "channel": channel, "noise": float(noise[worst]), "unit": unit,
        "stated": float(noise_of_case[worst]), "by_drives": shaken.tolist(),
    }  # fmt: skip
    if may_remember(fitted.samples, fit, recording.forces[~recording.bad], noise_of_case):
        return [
            note(
                Kind.NOISE,
                phrase(
                    "noise_may_remember",
                    "{sentence}; no more than such noise with memory makes, which +- counts",
                    sentence=sentence,
                ),
                noise_excess=entry,
            )
        ]
    if np.all(noise <= limit * np.hypot(noise_of_case, shaken)):
        return [
            note(
                Kind.NOISE,
                phrase(
                    "noise_of_drives",
                    "{sentence}; noise of the recorded {drives} makes {shaken} {unit} of it by their accelerations, "
                    "which +- counts",
                    sentence=sentence,
                    drives=phrase(case.drive_words[0], case.drive_words[0]),
                    shaken=f"{shaken[worst]:.2g}",
                    unit=unit,
                ),
                noise_excess=entry,
            )
        ]
    far = float(np.max(np.sqrt(np.maximum(noise**2 - shaken**2, 0.0)) / noise_of_case)) > FAR_ABOVE
    if far:
        sentence = phrase(
            "noise_far_above",
            "{sentence}. Do not use the result before the cause is known (a dimension that is not the machine's, a "
            "long contact, a compensated wrench, a mode of the frame ..): look at residuals and spectrum in the report",
            sentence=sentence,
        )
    else:
        sentence = phrase(
            "noise_above",
            "{sentence}. Correct the stated noise, or look for the cause in the residuals in the report",
            sentence=sentence,
        )
    return [warning(Kind.NOISE, sentence, counted=not far, noise_excess=entry)]


def _excess_words(noise: Array, noise_of_case: Array, limit: float, case: Case) -> Phrase:
    """By how much noise of channels is above what the case states, shapes (6,), where it is by more than a ratio."""
    excess = noise / noise_of_case
    worst, *others = [k for k in np.argsort(-excess).tolist() if excess[k] > limit]
    channel, unit = channel_words(case, worst)
    key = "sensors" if case.sensors.force_noise is not None else "simulation"
    key += ".moment_noise_Nm" if unit == "N m" else ".force_noise_N"
    names = ", ".join(channel_words(case, k)[0] for k in others)
    return phrase(
        "noise_excess",
        "residuals of {channels} are {times} times the white noise that the case states: {noise} {unit} where {key} "
        "makes {stated} {unit}",
        channels=phrase("and_also", "{channel} (also {others})", channel=channel, others=names) if others else channel,
        times=two_digits(excess[worst]),
        noise=two_digits(noise[worst]),
        stated=f"{noise_of_case[worst]:.2g}",
        unit=unit,
        key=key,
    )
