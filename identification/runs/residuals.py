"""Forces of a run beside what the identified model says, sample by sample, and the spectrum of what is left."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.fft import rfft, rfftfreq

from cases.schema import Case
from identification.findings.plausibility import scan
from identification.model import identification_model
from identification.periodic.averaging import periodic_run
from identification.recording import Recording
from identification.result import Estimate
from identification.runs.evaluation import MOST_DELAY
from identification.runs.preparation import moving_run, standstills
from identification.runs.wrist import wrist_run

Array = NDArray[np.float64]

MOST_SAMPLES = 60_000  # of the recording: a minute at 1 kHz says what its forces look like, and hours do not fit
SEGMENT = 1024  # samples of a periodogram: 1 Hz at 1 kHz


@dataclass(frozen=True, slots=True)
class Residuals:
    """Recorded forces and the model's, at every recorded sample of the excitation (standstills: at each of them).

    Args:
        t: time, shape (n,) [s]; of standstills their number from 1.
        forces: as recorded, shape (n, 6) [N, or N and N m].
        predicted: A u behind the evaluation's filter, the delay put right, shape (n, 6).
        step: time between samples [s]; None for standstills.
        filtered: the forces as the estimator saw them, behind the evaluation's filter, shape (n, 6); None where it saw
            them as recorded, or averaged in another way.
    """

    t: Array
    forces: Array
    predicted: Array
    step: float | None
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


def residuals_of(recording: Recording, case: Case, estimate: Estimate) -> Residuals:
    """What a run recorded beside what its own estimate says, at most the first `MOST_SAMPLES`.

    Args:
        recording: the run of the estimate.
        case: its case.
        estimate: gives model, parameters and delay.
    """
    model = identification_model(case, estimate.model, estimate.terms)
    if recording.t is None or case.setup == "1a":
        data = standstills(recording, case, model, scan(recording, case))
        count = np.arange(1.0, data.samples + 1.0)
        return Residuals(count, data.forces, data.regressors @ estimate.values, None)
    if recording.struts is None:
        wrist = wrist_run(recording, case, model, MOST_DELAY, estimate.how.biases, bad=scan(recording, case).bad)
        values = wrist.regressors(estimate.delay.value if estimate.delay else 0.0) @ estimate.values
        return Residuals(wrist.t, wrist.recorded_forces, values, wrist.filter.step * wrist.filter.stride)
    if estimate.conditioning.periodic is not None:
        periodic = periodic_run(recording, case, model, estimate.conditioning.periodic, scan(recording, case))
        t = recording.t[periodic.used][:MOST_SAMPLES]
        expected = periodic.regressors(estimate.delay.value if estimate.delay else 0.0) @ estimate.values
        recorded = recording.forces[periodic.used][:MOST_SAMPLES]
        return Residuals(t, recorded, periodic.predicted(expected, t), recording.step)
    run = moving_run(recording, case, model, found=scan(recording, case))
    rows = np.arange(run.rows[0], run.rows[-1] + 1)
    every = replace(run, rows=(rows if run.spoilt is None else rows[~run.spoilt[rows]])[:MOST_SAMPLES])
    predicted = every.regressors(estimate.delay.value if estimate.delay else 0.0) @ estimate.values
    return Residuals(every.t, every.recorded_forces, predicted, run.filter.step, every.forces)
