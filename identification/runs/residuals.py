"""Forces of a run beside what the identified model says, sample by sample, and the spectrum of what is left."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.fft import rfft, rfftfreq

from identification.periodic.averaging import PeriodicRun
from identification.result import Estimate
from identification.runs.evaluation import Run
from identification.runs.wrist import WristRun
from identification.samples import Standstills

Array = NDArray[np.float64]

MOST_SAMPLES = 60_000  # of the recording: a minute at 1 kHz says what its forces look like, and hours do not fit
SEGMENT = 1024  # samples of a periodogram: 1 Hz at 1 kHz


@dataclass(frozen=True, slots=True)
class Residuals:
    """Recorded forces and the model's, at every recorded sample of the excitation (standstills: at each of them)."""

    t: Array  # time, shape (n,) [s]; of standstills their number from 1
    forces: Array  # as recorded, shape (n, 6) [N, or N and N m]
    predicted: Array  # A u behind the evaluation's filter, the delay put right, shape (n, 6)
    step: float | None  # time between samples [s]; None for standstills
    # the forces as the estimator saw them, behind the evaluation's filter, shape (n, 6); None where it saw them as
    # recorded, or averaged in another way
    filtered: Array | None = None

    @property
    def values(self) -> Array:
        """Recorded less predicted, shape (n, 6)."""
        return np.asarray(self.forces - self.predicted)

    @property
    def seen(self) -> Array:
        """The forces that the model had to explain: behind the filter where there is one, shape (n, 6)."""
        return self.forces if self.filtered is None else self.filtered

    @property
    def left(self) -> Array:
        """What the model leaves of them, shape (n, 6)."""
        return np.asarray(self.seen - self.predicted)

    def spectrum(self) -> tuple[Array, Array]:
        """Amplitude spectral density of each channel, by Welch's method, shapes (k,) [Hz] and (k, 6) [N/sqrt(Hz)].

        Periodograms of segments under a Hann window that overlap by half, each less its mean, are averaged.

        Raises:
            ValueError: standstills have no spectrum.
        """
        if self.step is None:
            raise ValueError("standstills have no spectrum")
        size = min(SEGMENT, len(self.t))
        overlapping = np.lib.stride_tricks.sliding_window_view(self.values, size, axis=0)[:: size - size // 2]
        window = np.hanning(size + 1)[:-1]
        spectra = rfft((overlapping - overlapping.mean(axis=2, keepdims=True)) * window)
        power = np.mean(np.abs(spectra) ** 2, axis=0).T * self.step / np.sum(window**2)
        power[1 : (size + 1) // 2] *= 2.0  # of the frequencies below zero; those in the middle have no such twin
        return rfftfreq(size, self.step), np.sqrt(power)


def residuals_of(estimate: Estimate) -> Residuals:
    """What a run recorded beside what its own estimate says, at most the first `MOST_SAMPLES`."""
    samples = estimate.evaluated
    delay = 0.0 if estimate.delay is None else estimate.delay.value
    if isinstance(samples, Standstills):
        return Residuals(samples.t, samples.recorded, samples.matrices @ estimate.values, None)
    if isinstance(samples, WristRun):
        values, step = samples.regressors(delay) @ estimate.values, samples.filter.step * samples.filter.stride
        return Residuals(samples.t, samples.recorded_forces, values, step)
    if isinstance(samples, PeriodicRun):
        assert samples.recording.t is not None
        t = samples.recording.t[samples.used][:MOST_SAMPLES]
        expected = samples.predicted(samples.regressors(delay) @ estimate.values, t)
        return Residuals(t, samples.recording.forces[samples.used][:MOST_SAMPLES], expected, samples.recording.step)
    assert isinstance(samples, Run)
    rows = np.arange(samples.rows[0], samples.rows[-1] + 1)
    every = replace(samples, rows=(rows if samples.spoilt is None else rows[~samples.spoilt[rows]])[:MOST_SAMPLES])
    predicted = every.regressors(delay) @ estimate.values
    return Residuals(every.t, every.recorded_forces, predicted, samples.filter.step, every.forces)
