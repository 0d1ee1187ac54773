"""Zero-phase low-pass filters that also differentiate and shift in time, as one family of FIR kernels.

The kernel is an ideal low-pass under a Nuttall window, known as a function of time: its derivatives differentiate,
its argument shifts by fractions of a sample. Position, velocity and acceleration of a signal so pass the same filter.

At the samples that are wanted, one transform of the signals serves all kernels and is folded to their rate: every s-th
sample of a circular convolution of length N = s M has the spectrum of the whole folded to M, (1/s) times the sum over a
of X(q + a M) H(q + a M) e^(2 pi i p (q + a M) / N) with the phase p (Crochiere & Rabiner 1983, chapter 2): the way back
costs a transform of M, not of N. Signals go through in overlapping parts (overlap-save), so that memory stays small.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from math import comb
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.fft import fft, irfft, next_fast_len, rfft, rfftfreq

from cases.base.errors import Code, RecordingError
from cases.base.phrases import phrase
from cases.base.units import Array, Indices

Spectrum = NDArray[np.complex128]

# Nuttall's four-term window with continuous first derivative (A. Nuttall, IEEE Trans. ASSP 29 (1981) 84): side lobes
# below -93 dB, and no step at its ends, which sampled second derivatives would show.
_WINDOW = (0.355768, 0.487396, 0.144232, 0.012604)
# The main lobe of the window is 4 / half length wide: at 4 / cut-off the transition spans half to one and a half cut-
# offs.
_HALF_LENGTH = 4.0
_ROUNDING = 1e-6  # of a step
PART = 1 << 14  # samples transformed at once: they stay in the cache of the processor


class Filter(NamedTuple):
    """A low-pass for signals sampled at equal steps."""

    cutoff: float  # frequency of half gain [Hz]; gain 1 within 1e-4 below half of it, 0 above one and a half
    step: float  # time between samples [s]
    reach: float = 0.04  # largest delay, either way, that `apply` will be asked for [s]

    @property
    def margin(self) -> int:
        """Samples lost at each end."""
        # Steps are means of time stamps: their rounding is not to decide over a sample.
        return int(np.ceil((_HALF_LENGTH / self.cutoff + self.reach) / self.step - _ROUNDING)) + 1

    @property
    def stride(self) -> int:
        """Every so many filtered samples hold all of the filtered signal: nothing passes above 1.5 cut-offs."""
        return max(1, int(1.0 / (3.0 * self.cutoff * self.step)))

    @property
    def noise_gain(self) -> float:
        """Variance of filtered white noise over that of the noise."""
        return float(np.sum(self.kernel(0, 0.0) ** 2))

    @property
    def noise_correlation(self) -> float:
        """Correlation of white noise behind the filter between samples that are `stride` apart."""
        kernel = self.kernel(0, 0.0)
        return float(kernel[self.stride :] @ kernel[: -self.stride] / np.sum(kernel**2))

    def _kernel(self, order: int, shift: float) -> Array:
        """Derivative `order` of the impulse response at multiples of `step` less `shift` [s], shape (2 margin + 1,)."""
        half = _HALF_LENGTH / self.cutoff
        t: Array = np.arange(-self.margin, self.margin + 1) * np.float64(self.step) - shift
        sinc = _sinc_derivatives(t, 2 * np.pi * self.cutoff)
        w = np.pi / half * np.arange(len(_WINDOW))
        kernel = np.zeros_like(t)
        for k in range(order + 1):  # Leibniz's rule; the k-th derivative of a cosine is a cosine k quarter turns ahead
            window = np.cos(np.outer(t, w) + k * np.pi / 2) @ (np.array(_WINDOW) * w**k)
            kernel += comb(order, k) * sinc[order - k] * window
        return np.where(np.abs(t) < half, kernel, 0.0)

    def kernel(self, order: int, shift: float) -> Array:
        """The sampled kernel of a derivative, corrected to give constants, slopes and curvatures exactly.

        Of order 0, 1 or 2, shape (2 margin + 1,); `shift` is the delay of the result [s]. Sampling changes the response
        by nearly the same amount over the whole pass band, so the error at frequency zero is removed in the shape of
        the lower-order kernels.
        """
        t = np.arange(-self.margin, self.margin + 1) * self.step
        smooth = self._kernel(0, shift)
        smooth /= smooth.sum()
        if order == 0:
            return smooth
        slope = self._kernel(1, shift)
        slope -= slope.sum() * smooth
        slope /= -(slope @ t)
        if order == 1:
            return slope
        curvature = self._kernel(2, shift)
        curvature -= curvature.sum() * smooth
        curvature += (curvature @ t) * slope
        return np.asarray(curvature / (curvature @ t**2 / 2))

    def autocovariance(self, order: int) -> Array:
        """Autocovariance of a derivative of filtered white noise, in steps of `stride`, 1 at lag zero, shape (l,)."""
        kernel = self.kernel(order, 0.0)
        ends = range(len(kernel), 0, -self.stride)
        lagged = np.array([kernel[:end] @ kernel[len(kernel) - end :] for end in ends])
        return np.asarray(lagged / lagged[0])

    def require(self, values: Array, delay: float) -> None:
        """Raises RecordingError for fewer values than the filter is long, ValueError for a delay [s] out of reach."""
        if abs(delay) > self.reach:
            raise ValueError(f"delay {delay:g} s is beyond the filter's reach of {self.reach:g} s")
        if len(values) <= 2 * self.margin + 1:
            raise RecordingError(
                problem=phrase(
                    "few_for_filter",
                    "{count} samples are too few for a {cutoff} Hz filter, which needs more than {needed}",
                    count=len(values),
                    cutoff=f"{self.cutoff:g}",
                    needed=2 * self.margin + 1,
                ),
                remedy=phrase("longer_or_cutoff", "record longer or raise filter_cutoff_Hz"),
                code=Code.TOO_FEW,
            )

    def apply(self, values: Array, order: int = 0, delay: float = 0.0) -> Array:
        """The filtered signal or its derivative, `delay` earlier than sampled, shape (n - 2 margin, channels).

        Args:
            values: shape (n, channels).
            order: 0, 1 or 2: of the time derivative.
            delay: the result at sample k belongs to the instant t_k - delay [s]; at most `reach` either way.

        Raises RecordingError for fewer samples than the filter is long.
        """
        return decimated(self, values, np.arange(len(values) - 2 * self.margin), [(order, delay)])[0]


def _sinc_derivatives(t: Array, w: float) -> tuple[Array, Array, Array]:
    """sin(w t) / (pi t) and its first two derivatives; series where w t is small."""
    x = w * t
    small = np.abs(x) < 1e-2
    y = np.where(small, 1.0, x)
    s, c = np.sin(y), np.cos(y)
    value = np.where(small, 1 - x**2 / 6 + x**4 / 120, s / y)
    first = np.where(small, -x / 3 + x**3 / 30, (c - s / y) / y)
    second = np.where(small, -1 / 3 + x**2 / 10 - x**4 / 168, -s / y - 2 * (c - s / y) / y**2)
    gain = w / np.pi
    return gain * value, gain * w * first, gain * w**2 * second


def decimated(low_pass: Filter, values: Array, rows: Indices, wanted: Sequence[tuple[int, float]]) -> list[Array]:
    """The filtered signal, shape (n, channels), or derivatives of it, for each of the wanted orders and delays [s].

    Each of shape (k, channels): of filtered samples, ascending, counted after the filter's margin, shape (k,). Raises
    RecordingError for fewer samples than the filter is long.
    """
    for _, delay in wanted:
        low_pass.require(values, delay)
    stride, reach = low_pass.stride, 2 * low_pass.margin
    count = next_fast_len(-(-min(len(values), max(PART, 4 * reach)) // stride), real=True)
    size = count * stride
    responses = [_response(low_pass, count, order, delay) for order, delay in wanted]
    mean = values.mean(axis=0)  # keeps rounding small against the oscillation, not against 1 m of strut
    results = [np.empty((len(rows), values.shape[1])) for _ in wanted]
    for begin in range(0, len(values) - reach, size - reach):
        first, end = np.searchsorted(rows, (begin, begin + size - reach))
        if first == end:
            continue
        part = np.zeros((values.shape[1], size))
        signals = values[begin : begin + size]
        part[:, : len(signals)] = (signals - mean).T
        spectrum = fft(part).reshape(-1, stride, count)[:, :, : count // 2 + 1]
        at = rows[first:end] - begin + reach
        phases = at % stride
        for phase in np.unique(phases):
            places = np.flatnonzero(phases == phase)
            components = spectrum * _turn(stride, count, int(phase))
            for result, response in zip(results, responses, strict=True):
                series = irfft(np.einsum("cam,am->cm", components, response), count)
                result[first + places] = series[:, at[places] // stride].T
    for result, (order, _) in zip(results, wanted, strict=True):
        if order == 0:
            result += mean
    return results


@lru_cache(maxsize=32)
def _response(low_pass: Filter, count: int, order: int, delay: float) -> Spectrum:
    """H / s at the frequencies that fold together, shape (stride, count // 2 + 1)."""
    kernel = low_pass.kernel(order, delay)
    spectrum = fft(kernel, count * low_pass.stride).reshape(low_pass.stride, count)
    return np.asarray(spectrum[:, : count // 2 + 1] / low_pass.stride)


@lru_cache(maxsize=32)
def _turn(stride: int, count: int, phase: int) -> Spectrum:
    """e^(2 pi i p (q + a M) / N), shape (stride, count // 2 + 1)."""
    index = np.arange(stride)[:, None] * count + np.arange(count // 2 + 1)
    return np.asarray(np.exp(2j * np.pi * ((phase * index) % (stride * count)) / (stride * count)))


DIFFERENCES = 8  # repeated differences of a signal, which leave its noise, but nothing of a slow motion
NORMAL_MEDIAN = 0.6745  # median size of a normal variable in standard deviations


def white_noise(signals: Array) -> Array:
    """Standard deviation of the white noise in each of some signals, shape (n, channels) -> (channels,)."""
    if len(signals) <= DIFFERENCES:
        return np.zeros(signals.shape[1])
    changes = np.median(np.abs(np.diff(signals, DIFFERENCES, axis=0)), axis=0)  # few leaps do not count
    return np.asarray(changes / (NORMAL_MEDIAN * np.sqrt(comb(2 * DIFFERENCES, DIFFERENCES))))


# Samples of a long run that stand for it where their number only costs time: two minutes behind 20 Hz.
FAIR_PART = 8_000
STRETCHES = 8  # number of stretches that hold them


def fair_part(count: int, times: float = 1) -> Indices:
    """Indices of a part of so many samples that stands for all of them: stretches at equal distances, or all."""
    most = int(times * FAIR_PART)
    if count <= most:
        return np.arange(count)
    size = most // STRETCHES
    return np.concatenate([k + np.arange(size) for k in np.linspace(0, count - size, STRETCHES).astype(np.int64)])


MOST_SAMPLES = 60_000  # of a series: a minute at 1 kHz says what forces look like, and hours do not fit
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

    def spectrum(self, segment: int = SEGMENT) -> tuple[Array, Array]:
        """Amplitude spectral density of each channel, by Welch's method, shapes (k,) [Hz] and (k, 6) [N/sqrt(Hz)].

        Args:
            segment: samples of which a spectrum is taken, at most; the mean of all is returned.
        """
        assert self.step is not None, "standstills have no spectrum"
        size = min(segment, len(self.t))  # segments under a Hann window that overlap by half, each less its mean
        overlapping = np.lib.stride_tricks.sliding_window_view(self.values, size, axis=0)[:: size - size // 2]
        window = np.hanning(size + 1)[:-1]
        spectra = rfft((overlapping - overlapping.mean(axis=2, keepdims=True)) * window)
        power = np.mean(np.abs(spectra) ** 2, axis=0).T * self.step / np.sum(window**2)
        power[1 : (size + 1) // 2] *= 2.0  # of the frequencies below zero; those in the middle have no such twin
        return rfftfreq(size, self.step), np.sqrt(power)  # scipy.signal has the same, and loads for half a second
