"""Runs that repeat themselves: averaged over their periods, differentiated and filtered as Fourier series.

Struts become a Fourier series whose derivatives are analytic; forces and regressors are reduced to the same harmonics
(Swevers, Ganseman, Tukel, De Schutter & Van Brussel 1997, IEEE Trans. Robotics and Automation 13:730). What is fitted
are the 2 H + 1 values of that at equal steps of one period: the transform to them is orthogonal, so that white noise
stays white. What differs between periods is noise whatever the model says, and gives the robust covariance.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import ClassVar

import numpy as np
from scipy.fft import irfft, rfft
from scipy.ndimage import binary_opening
from scipy.special import fdtrc

from cases.errors import IdentificationError, RecordingError
from cases.schema import Case
from cases.sensors import Sensors
from cases.units import Array, Flags
from identification.estimation.fit import Filtered, Fit, Robust, orthonormal
from identification.finding import Finding, Kind, note, warning
from identification.hexapod import Hexapod, StrutsDoNotClose
from identification.model import Model, regressors
from identification.recording import Recording
from identification.runs.evaluation import DELAY_STEP
from identification.runs.fourier_series import FourierSeries, fit_series
from identification.runs.noise_sources import acceleration_effects, series_squares, twist_rate_squares
from identification.runs.periods import (
    FEWEST,
    each_period,
    kept_periods,
    noise_spectra,
    rows_of_periods,
    telling_harmonics,
)
from identification.runs.preparation import LEAST_TRAVEL, MOST_BRIDGED, checked_filter, require_on, require_position
from identification.runs.repeating import RepeatingPart, find_part, given_part
from identification.runs.sample_checks import bridged
from identification.samples import Conditioning, PlainSamples
from identification.signals import MOST_SAMPLES, Residuals, stretches
from identification.symbolic import Kinematics

FINER = 6  # regressors are computed at so many times the evaluated instants: their harmonics must not fold back
BESIDE = 15  # harmonics of the struts above those of the forces that reach the regressor, mixed with the slow ones
SAME_STEP = 0.2  # of an encoder's step, by which struts of periods differ if their steps are the same; else 0.4 or more
MODEL_ERROR = 1.5  # times the scatter of the periods, from which residuals are reported
UNLIKELY = 1e-3  # chance of so large a ratio by noise alone


@dataclass(frozen=True)
class PeriodicRun(PlainSamples):
    """A repeating run, ready to be evaluated at any delay between forces and motion."""

    model: Model
    hexapod: Hexapod
    recording: Recording
    part: RepeatingPart  # part that repeats
    used: Flags  # recorded samples of the periods that are evaluated, shape (n of the recording,)
    # their motion, with some harmonics more than the forces: oscillations mix in the regressor [m]
    struts: FourierSeries
    forces_series: FourierSeries  # Fourier series of the forces, of H harmonics [N, or N and N m]
    # coefficients of the forces of each period, shape (periods, 2 H + 1 or more, 6); None where there is one period
    scatter: Array | None
    chosen: bool  # whether the number of harmonics was chosen here
    limited: bool  # whether the filter's cut-off bounded it
    window: tuple[Finding, ...] = ()
    nuisances: ClassVar[tuple[str, ...]] = ("delay",)  # estimated beside the model
    consecutive: ClassVar[bool] = False  # averages; periods that a contact disturbs are left out before
    noise_stated: ClassVar[bool] = True
    wide: ClassVar[None] = None  # the delay is estimated with the parameters
    scale: ClassVar[float] = 1.0
    noise_correlation: ClassVar[float] = 0.0  # of white noise between evaluated instants: none

    @property
    def samples(self) -> int:
        """Recorded samples that are evaluated."""
        return int(self.used.sum())

    @property
    def points(self) -> int:
        """Evaluated instants of the period, 2 H + 1."""
        return 2 * self.harmonics + 1

    @property
    def harmonics(self) -> int:
        """H, of forces and regressor."""
        return self.forces_series.harmonics

    @property
    def t(self) -> Array:
        """Evaluated instants, shape (2 H + 1,) [s]."""
        return self._instants(self.points)

    @property
    def filtered(self) -> Filtered:
        """Effect of averaging on white noise."""
        return Filtered(self.points / self.samples, self.samples / self.points)

    @cached_property
    def forces(self) -> Array:
        """Forces at the evaluated instants, shape (2 H + 1, 6)."""
        return self.forces_series.at(self.t)

    def _instants(self, count: int) -> Array:
        return np.asarray(self.struts.start + self.struts.period * np.arange(count) / count)

    def regressors(self, delay: float) -> Array:
        """A at the instants less the delay, reduced to the harmonics, shape (2 H + 1, 6, u)."""
        fine = regressors(self.model, self.kinematics(delay, FINER))
        spectrum = rfft(fine, axis=0)[: self.harmonics + 1]
        return np.asarray(irfft(spectrum, self.points, axis=0) / FINER)

    def kinematics(self, delay: float, finer: int = 1) -> Kinematics:
        """Motion of the platform at the evaluated instants, or at so many times as many, less the delay."""
        t = self._instants(finer * self.points)
        try:
            return self.hexapod.kinematics(*(self.struts.at(t - delay, k) for k in range(3)))
        except StrutsDoNotClose as error:
            row = int(np.searchsorted(self._clock, t[error.sample]))
            raise StrutsDoNotClose(row, error.lengths, self.recording.lines.place(row)) from error

    @property
    def _clock(self) -> Array:
        assert self.recording.t is not None
        return self.recording.t

    def linearised(self, delay: float, values: Array) -> Array:
        """A, and how the expected forces A u change with the delay, shape (2 H + 1, 6, u + 1)."""
        change = (self.regressors(delay + DELAY_STEP) - self.regressors(delay - DELAY_STEP)) @ values
        return np.dstack([self.regressors(delay), change / (2.0 * DELAY_STEP)])

    def residuals(self, matrices: Array, values: Array) -> Array:
        """Recorded forces less the model behind the filter, at all samples of the periods, shape (samples, 6)."""
        return np.asarray(self.recording.forces[self.used] - self.predicted(matrices @ values, self._clock[self.used]))

    def predicted(self, expected: Array, t: Array) -> Array:
        """Expected forces of the evaluated instants, shape (2 H + 1, 6), at any others, shape (n, 6)."""
        return fit_series(self.t, expected, self.struts.period, self.struts.start, self.harmonics).at(t)

    def regressor_noise(self, w: Array, delay: float, sensors: Sensors) -> tuple[Array, float]:
        """Effect of stated noise on A.

        Steps of encoders are averaged over periods like noise where the struts do not repeat to a part of a step; where
        they do, the steps repeat with them.
        """
        squares = twist_rate_squares(self.model, self.kinematics(delay), w, sensors, self.filtered.gain)
        if sensors.strut_variance is None:
            return squares, 0.0
        periods = 1 if self.scatter is None else len(self.scatter)
        repeats = periods if self.part.misfit < SAME_STEP * sensors.strut_step else 1
        recorded = sensors.strut_variance + (repeats - 1) * sensors.strut_step**2 / 12.0
        orders = np.arange(-self.struts.harmonics, self.struts.harmonics + 1)
        power = np.asarray(recorded / self.samples * (orders * self.struts.omega) ** 4.0, dtype=np.float64)
        effects = acceleration_effects(self.hexapod, self.model, self.kinematics(delay, FINER))
        return squares + self.points * series_squares(effects, power, self.harmonics, w), float(power.sum())

    def series(self, delay: float, values: Array) -> Residuals:
        """Forces of the first evaluated periods beside the model's behind the filter."""
        t, forces = (series[self.used][:MOST_SAMPLES] for series in (self._clock, self.recording.forces))
        return Residuals(t, forces, self.predicted(self.regressors(delay) @ values, t), self.recording.step)

    def robust_covariance(
        self, matrices: Array, residuals: Array, weights: Array, whitening: Array | None
    ) -> Robust | None:
        """Covariance of u from the scatter between periods, shape (u, u): right for stationary noise of any colour.

        Args:
            matrices: A, whitened where there is a whitening, shape (2 H + 1, 6, u).
            residuals: not needed, for noise is what does not repeat.
            weights: diagonal of W of these, shape (6,).
            whitening: whitening of the forces, shape (6, 6).
        """
        if self.scatter is None:
            return None
        _, half = orthonormal(matrices, weights)
        response = rfft((matrices * weights[:, None]) @ half, axis=0) / len(matrices)
        spectra = noise_spectra(self.scatter, self.harmonics, len(matrices))
        if whitening is not None:
            spectra = whitening @ spectra @ whitening.T
        share = np.where(np.arange(len(spectra)) == 0, 1.0, 2.0)
        meat = np.einsum("h,hki,hkl,hlj->ij", share, response.conj(), spectra, response).real
        return Robust(np.asarray(half @ (meat + meat.T) / 2.0 @ half.T))

    def without(self, left_out: Flags) -> "PeriodicRun":
        """The run itself: whole periods were left out before, see `kept_periods`."""
        del left_out
        return self

    def findings(self, fit: Fit, w: Array) -> tuple[Finding, ...]:
        """Findings: what repeats, how it was evaluated, and residuals beyond what does not repeat."""
        p, t, scatter = self.part, self._clock[self.used], self.scatter
        count, noise = 1, None
        if scatter is not None:  # what does not repeat, as covariance of white noise
            count, noise = len(scatter), noise_spectra(scatter, self.harmonics, 1).real.mean(axis=0) * self.samples
        repeats = (
            f"struts repeat within {p.misfit * 1e3:.2g} mm rms, {100 * p.relative:.2g} % of their motion"
            if p.periods > 1
            else f"struts end within {p.misfit * 1e3:.2g} mm of where they began"
        )
        reason = "as given"
        if self.chosen:
            reason = "all below filter_cutoff_Hz" if self.limited else "as many as stand out of the struts' noise"
        averaged = f"{count} periods of {p.period:.6g} s averaged" if count > 1 else f"1 period of {p.period:.6g} s"
        entries = {
            "period_s": p.period,
            "periods": count,
            "periods_found": p.periods,
            "from_s": float(t[0]),
            "to_s": float(t[-1]),
            "harmonics": self.harmonics,
            "harmonics_chosen": self.chosen,
            "misfit_m": p.misfit,
            "misfit_of_motion": p.relative,
            "noise_between_periods": None if noise is None else np.sqrt(np.diag(noise)).tolist(),
        }
        sentence = (
            f"forces and regressor as {self.harmonics} harmonics, up to {self.harmonics / p.period:.3g} Hz, {reason}"
        )
        findings = [
            note(Kind.WINDOW, f"periodic: {averaged}, from {t[0]:.3f} to {t[-1]:.3f} s; {repeats}", periodic=entries),
            note(Kind.WINDOW, f"{sentence}; velocities and accelerations from the Fourier series of the struts"),
        ]
        if noise is None:
            return tuple(findings)
        ratio = fit.s0**2 / max(float(np.trace(w @ noise)) / 6.0, np.finfo(float).tiny)
        chance = float(fdtrc(fit.freedom, 6 * (count - 1) * self.points, ratio))
        if ratio >= MODEL_ERROR**2 and chance <= UNLIKELY:
            sentence = (
                f"what the model leaves of the forces is {np.sqrt(ratio):.1f} times what differs between periods: "
            )
            sentence += "it repeats, so it is not noise but an error of the model, the geometry or the encoders"
            findings.append(warning(Kind.MODEL, sentence))
        return tuple(findings)


def periodic_run(recording: Recording, case: Case, model: Model, wish: Conditioning) -> PeriodicRun:
    """The part of a moving run that repeats itself, without periods in which long stretches are missing.

    Args:
        case: machine; its filter's cut-off bounds the harmonics.
        wish: period and harmonics, where they are given.

    Raises:
        RecordingError: no struts, no uniform clock, no period, none without damage, or too many harmonics.
        IdentificationError: the model needs what the recording does not have.
    """
    require_position(recording, model)
    if recording.struts is None:
        raise RecordingError(recording.source, "periodic evaluation needs struts", "leave --period out")
    low_pass = checked_filter(recording, case)
    gaps = np.flatnonzero(recording.lost)
    if len(gaps):
        raise RecordingError(
            f"{recording.source}, {recording.lines.place(int(gaps[0]) + 1)}",
            "samples are missing before this one, and periods are counted over the whole run",
            "cut it there, or leave --period out",
        )
    bad = recording.bad
    long = binary_opening(bad, np.ones(MOST_BRIDGED + 1))
    struts = bridged(recording.struts, bad & ~long)
    recording = replace(recording, struts=struts, forces=bridged(recording.forces, bad & ~long))
    t = recording.t
    assert t is not None
    window = np.arange(len(t))
    if recording.trigger is not None:
        longest = max(stretches(require_on(recording.source, recording.trigger)), key=lambda on: on.stop - on.start)
        window = window[longest]
    if np.ptp(struts[window], axis=0).max() < LEAST_TRAVEL:
        raise IdentificationError(recording.source, "the pose is constant; record the excitation")
    part = find_part(t, struts, window) if wish.period is None else given_part(t, struts, window, wish.period)
    most = int(1e-6 + min(low_pass.cutoff * part.period, (part.end - part.first) // (4 * part.periods) - BESIDE))
    if most < FEWEST or (wish.harmonics is not None and not 1 <= wish.harmonics <= most):
        raise RecordingError(
            f"--harmonics {wish.harmonics or FEWEST}",
            f"a period of {part.period:.4g} s holds {most} of them up to "
            f"filter_cutoff_Hz = {low_pass.cutoff:g}; give 1 to {max(most, 1)}",
        )
    periods = rows_of_periods(t, part)
    scatter = each_period(t, recording.forces, periods, part, most)
    numbers, warnings = kept_periods(recording, periods, scatter, long)
    periods, scatter = [periods[k] for k in numbers], scatter[numbers]
    rows, more = np.concatenate(periods), most + BESIDE
    used = np.zeros(len(t), dtype=bool)
    used[rows] = True
    motion = fit_series(t[rows], struts[rows], part.period, float(t[rows[0]]), more)
    count = telling_harmonics(motion, each_period(t, struts, periods, part, more), periods, t, struts)
    harmonics = wish.harmonics or min(count, most)
    motion = motion.truncated(harmonics + BESIDE)
    forces = fit_series(t[rows], recording.forces[rows], part.period, motion.start, most)
    return PeriodicRun(
        model, Hexapod.of(case), recording, part, used, motion, forces.truncated(harmonics),
        scatter if len(numbers) > 1 else None, wish.harmonics is None, harmonics == most, warnings,
    )  # fmt: skip
