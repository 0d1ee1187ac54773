"""What an identification reports: parameters in both forms with standard deviations, and how well the model fits."""

from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from scipy.fft import rfft, rfftfreq
from scipy.special import stdtrit

from cases.schema import Case
from cases.units import Array, as_html
from identification.criteria import Identifiability, analyse
from identification.estimation.biases import AccelerometerBias
from identification.estimation.estimators import Method
from identification.estimation.fit import Fit, Uncertain
from identification.finding import Finding, Severity, quantities_of, sentences
from identification.fitting import Fitted, excerpt
from identification.model import Model, expected_forces
from identification.parameters import physical_form
from identification.runs.averaging import PeriodicRun
from identification.runs.evaluation import Run
from identification.runs.noise_sources import NoiseSources, attenuation_of
from identification.runs.wrist import WristRun
from identification.samples import Samples, Standstills


class Value(NamedTuple):
    """An estimated parameter: SI value, standard deviation by (28), autocorrelation-robust one, and unit."""

    value: float
    std: float
    std_robust: float
    unit: str

    @property
    def reported(self) -> float:
        """The larger of the two standard deviations, which is what people are shown."""
        return max(self.std, self.std_robust)

    def interval(self, freedom: float, level: float = 0.95) -> tuple[float, float]:
        """Confidence interval from the reported standard deviation: what is printed, and what coverage rates."""
        half = float(stdtrit(freedom, 0.5 + level / 2)) * self.reported
        return self.value - half, self.value + half

    def _repr_html_(self) -> str:
        return as_html(self)


@dataclass(frozen=True, slots=True)
class Estimate:
    """The result of an identification."""

    case: Case
    source: str  # the recording
    how: Method
    # u alone, without nuisances; `s0` of a moving run is that of the noise in the pass band, as white noise of the
    # recorded forces; `residuals`, not saved, are those behind the filter; `weights` are ones where only ratios count
    fit: Fit
    evaluated: Samples  # samples that it was made from
    residuals: Array  # recorded forces less the model, shape (n, 6) [N, or N and N m]
    delay: Uncertain | None  # delay of the forces [s], where it was estimated
    noise: NoiseSources | None  # what s0 consists of, where the case states noise
    accelerometer: AccelerometerBias | None  # its biases, where standstills have its readings
    physical: dict[str, Value]  # physical parameters by name
    # attenuation of physical parameters by name, where the case states noise of the struts
    attenuation: dict[str, dict[str, float | None]] | None
    findings: tuple[Finding, ...]  # what speaks against it, and what is good to know

    @property
    def model(self) -> Model:
        """The model that was identified."""
        return self.evaluated.model

    @property
    def at(self) -> float:
        """The delay, 0 where nothing moves [s]."""
        return 0.0 if self.delay is None else self.delay.value

    @property
    def residual_rms(self) -> Array:
        """Residuals' rms of each channel, shape (6,) [N, or N and N m]."""
        return np.asarray(np.sqrt(np.mean(self.residuals**2, axis=0)))

    @property
    def s0_N(self) -> float:
        """Rms residual of the recorded forces, over the channels in newtons [N]."""
        newtons = slice(0, 3 if self.case.sensor_frame.has_moments else 6)
        return float(np.sqrt(np.mean(self.residuals[:, newtons] ** 2)))

    @property
    def warnings(self) -> tuple[str, ...]:
        """Sentences that people should act on."""
        return sentences(self.findings, Severity.WARNING)

    @property
    def notes(self) -> tuple[str, ...]:
        """Sentences that are good to know."""
        return sentences(self.findings, Severity.NOTE)

    @property
    def quantities(self) -> dict[str, Any]:
        """Entries of the findings for programs, by their keys in result files."""
        return quantities_of(self.findings)


def physical_values(model: Model, u: Array, covariance: Array, robust: Array) -> dict[str, Value]:
    """Physical parameters by name.

    Args:
        u: linear parameters, shape (u,).
        covariance: covariance of these by (28), shape (u, u).
        robust: the autocorrelation-robust one.
    """
    form = physical_form(model)
    values, white = form.of(u, covariance)
    std, std_robust = (np.sqrt(np.diag(c).clip(0.0)) for c in (white, form.of(u, robust)[1]))
    return {
        p.name: Value(float(v), float(s), float(r), p.unit)
        for p, v, s, r in zip(form.parameters, values, std, std_robust, strict=True)
    }


def estimate_of(
    fitted: Fitted,
    source: str,
    case: Case,
    noise: NoiseSources | None,
    accelerometer: AccelerometerBias | None,
    findings: tuple[Finding, ...],
) -> Estimate:
    """The estimate of a fit; columns of the fit beyond the model's parameters are nuisances, which it leaves out."""
    fit, model = fitted.fit, fitted.samples.model
    own = slice(len(model.parameters))
    u, white, robust = fit.values[own], fit.covariance[own, own], fit.covariance_robust[own, own]
    fit = replace(fit, values=u, covariance=white, covariance_robust=robust)
    physical = physical_values(model, u, white, robust)
    attenuation = None
    if noise is not None and noise.bias is not None:
        reported = np.array([value.reported for value in physical.values()])
        attenuation = attenuation_of(physical_form(model), u, noise.bias, reported)
    return Estimate(
        case, source, fitted.method, fit, fitted.samples, fitted.residuals, fitted.delay, noise, accelerometer,
        physical, attenuation, findings,
    )  # fmt: skip


MOST_SAMPLES = 60_000  # of the recording: a minute at 1 kHz says what its forces look like, and hours do not fit
SEGMENT = 1024  # samples of a periodogram: 1 Hz at 1 kHz


@dataclass(frozen=True, slots=True)
class Residuals:
    """Recorded forces and the model's, at every recorded sample of the excitation (standstills: at each of them)."""

    t: Array  # time, shape (n,) [s]; of standstills their number from 1
    forces: Array  # as recorded, shape (n, 6) [N, or N and N m]
    predicted: Array  # A u behind the evaluation's filter, the delay compensated, shape (n, 6)
    step: float | None  # time between samples [s]; None for standstills
    # the forces as the estimator saw them, behind the evaluation's filter, shape (n, 6); None where it saw them as
    # recorded, or averaged in another way
    filtered: Array | None = None

    @property
    def values(self) -> Array:
        """Recorded less predicted, shape (n, 6)."""
        return np.asarray(self.forces - self.predicted)

    @property
    def explained(self) -> Array:
        """The forces that the model had to explain: behind the filter where there is one, shape (n, 6)."""
        return self.forces if self.filtered is None else self.filtered

    @property
    def evaluated(self) -> Array:
        """Residuals of these, shape (n, 6)."""
        return np.asarray(self.explained - self.predicted)

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
    """Recorded forces of a run beside those of its own estimate, at most the first `MOST_SAMPLES`."""
    samples, delay, u = estimate.evaluated, estimate.at, estimate.fit.values
    if isinstance(samples, Standstills):
        return Residuals(samples.t, samples.recorded, samples.matrices @ u, None)
    if isinstance(samples, WristRun):
        values, step = samples.regressors(delay) @ u, samples.filter.step * samples.filter.stride
        return Residuals(samples.t, samples.recorded_forces, values, step)
    if isinstance(samples, PeriodicRun):
        assert samples.recording.t is not None
        t = samples.recording.t[samples.used][:MOST_SAMPLES]
        expected = samples.predicted(samples.regressors(delay) @ u, t)
        return Residuals(t, samples.recording.forces[samples.used][:MOST_SAMPLES], expected, samples.recording.step)
    assert isinstance(samples, Run)
    rows = np.arange(samples.rows[0], samples.rows[-1] + 1)
    every = replace(samples, rows=(rows if samples.spoilt is None else rows[~samples.spoilt[rows]])[:MOST_SAMPLES])
    predicted = expected_forces(every.model, every.kinematics(delay), u)
    return Residuals(every.t, every.recorded_forces, predicted, samples.filter.step, every.forces)


def identifiability_of(estimate: Estimate) -> Identifiability:
    """Which of the estimated parameters the run determines, alone and together (section 5)."""
    samples = excerpt(estimate.evaluated)
    selection = estimate.how.selection(samples.model)
    return analyse(samples.regressors(estimate.at) @ selection.basis, selection.names)
