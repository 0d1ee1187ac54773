"""A moving run of a wrist sensor: orientation and accelerometer instead of struts, each stream with a clock of its own.

All streams pass the same low-pass at their own rates and are read at the instants of the forces. The accelerometer
stands for the acceleration of the sensor's origin: its lever arm is neglected. How it is turned against the sensor by
small angles is estimated with the parameters, since without that the delay is arbitrary.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

from cases.base.errors import Code, IdentificationError, RecordingError
from cases.base.phrases import phrase
from cases.base.units import Array, Flags, Indices
from cases.schema import Case
from identification.estimation.fit import Robust
from identification.estimation.force_noise import turned
from identification.estimation.noise_mixtures import coloured_covariance
from identification.machines.machine import Kinematics
from identification.model.blocks import MASS
from identification.model.model import Model
from identification.recording.formats.clocks import lost_samples
from identification.recording.formats.table import Stream
from identification.recording.recording import Recording
from identification.samples.moving import BANDS, DELAY_STEP, MOST_OF_IT, calm
from identification.samples.moving_window import about_left_out, spoilt_by
from identification.samples.sample_checks import bridged
from identification.samples.samples import MOST_DELAY, MotionOfSamples, MovingSamples
from identification.signals import Filter, Residuals, white_noise

TURNING = 0.02  # [rad/s] from which the sensor counts as moving
LEAST_ROWS = 20


@dataclass(frozen=True, slots=True, kw_only=True)
class WristRun(MovingSamples):
    """A moving run of a wrist sensor, ready to be evaluated at any delay between forces and motion."""

    quaternion: CubicSpline  # quaternion of R over time, filtered
    specific_force: CubicSpline  # specific force in the axes of {P} over time, filtered [m/s^2]
    wide: "WristRun | None" = None  # the run in the widest band that all streams carry, for its delay
    # the run in a narrower band, in which its motion is known with next to no noise; None where it has none
    narrow: "WristRun | None" = None
    calm: bool = False  # whether next to nothing of its motion is noise of orientations and accelerometer
    nuisances: tuple[str, ...] = ("turn_x", "turn_y", "turn_z", "delay")

    def regressors(self, delay: float) -> Array:
        """A at the instants t_k - delay, shape (n, 6, u)."""
        return self._matrices(delay, self.specific_force(self.t - delay))

    def turning(self, t: Array) -> tuple[Array, Array, Array, Array]:
        """Motion at some instants: R, angular velocity and acceleration in {B}, specific force in {P}."""
        q, first, second = (self.quaternion(t, order) for order in range(3))
        conjugate = Rotation.from_quat(q).inv()
        size = np.linalg.norm(q, axis=1)[:, None]
        omega, alpha = (2.0 * _product(d / size, conjugate.as_quat()) for d in (first, second))
        return Rotation.from_quat(q).as_matrix(), omega, alpha, self.specific_force(t)

    def motion(self, delay: float) -> MotionOfSamples | None:
        """How the sensor turns and accelerates, in a band in which next to nothing of that is noise."""
        slow = self._slow(delay)
        if slow is None:
            return None
        turn, omega, alpha, specific = slow.turning(slow.t - delay)
        still = np.zeros_like(omega)
        acceleration = np.einsum("nij,nj->ni", turn, specific) + self.model.gravity
        pose = np.hstack([still, Rotation.from_matrix(turn).as_euler("xyz")])
        load = Kinematics(pose, np.hstack([still, omega]), np.hstack([acceleration, alpha]))
        return MotionOfSamples(self._known(), load, by_accelerometer=True)

    def columns(self, delay: float, values: Array, names: Sequence[str]) -> Array | None:
        """Columns of a fit at values u in `motion`, by names of parameters and nuisances, shape (n, 6, v)."""
        slow, known = self._slow(delay), (*self.model.names, *self.nuisances)
        return None if slow is None else slow.linearised(delay, values)[:, :, [known.index(name) for name in names]]

    def _slow(self, delay: float) -> "WristRun | None":
        """The run in its narrower band at the samples, or where that band begins and ends."""
        if self.narrow is None:
            return None
        splines = (self.narrow.quaternion, self.narrow.specific_force)
        first, last = max(spline.x[0] for spline in splines), min(spline.x[-1] for spline in splines)
        room = abs(DELAY_STEP)
        return replace(self.narrow, t=np.clip(self.t, first + delay + room, last + delay - room))

    def _known(self) -> Flags:
        """Samples beside which the narrower band has one, shape (n,)."""
        assert self.narrow is not None
        there = self.narrow.t
        after = np.clip(np.searchsorted(there, self.t), 1, len(there) - 1)
        nearest = np.minimum(np.abs(there[after] - self.t), np.abs(there[after - 1] - self.t))
        return np.asarray(nearest < self.narrow.step)

    def _matrices(self, delay: float, specific: Array) -> Array:
        turn, omega, alpha, _ = self.turning(self.t - delay)
        still = np.zeros_like(omega)
        acceleration = np.einsum("nij,nj->ni", turn, specific) + self.model.gravity
        return self.model.matrices(still, turn, np.hstack([still, omega]), np.hstack([acceleration, alpha]))

    def linearised(self, delay: float, values: Array) -> Array:
        """A, and how A u changes with small turns of the accelerometer and with the delay, shape (n, 6, u + 4)."""
        matrices = self.regressors(delay)
        specific = self.specific_force(self.t - delay)
        expected = matrices @ values
        columns = []
        for axis in np.eye(3):
            variation = specific + DELAY_STEP * np.cross(axis, specific)
            columns.append((self._matrices(delay, variation) @ values - expected) / DELAY_STEP)
        step = DELAY_STEP if delay < 0.0 else -DELAY_STEP
        columns.append((self.regressors(delay + step) @ values - expected) / step)
        return np.dstack([matrices, np.stack(columns, axis=2)])

    def robust_covariance(
        self, matrices: Array, residuals: Array, weights: Array, whitening: Array | None
    ) -> Robust | None:
        """Covariance of u for noise of any colour, shape (u, u), from A and residuals; None for short runs."""
        return coloured_covariance(turned(matrices, residuals, weights, self.places)._replace(sources=self.sources))

    def series(self, delay: float, values: Array) -> Residuals:
        """Forces as recorded at the evaluated samples beside the model's."""
        return Residuals(self.t, self.recorded, self.regressors(delay) @ values, self.step)


def wrist_run(
    recording: Recording, case: Case, model: Model, cutoff: float | None = None, turning_cutoff: float | None = None
) -> WristRun:
    """A moving run with its window: from the first turn out of rest to rest again.

    Args:
        recording: recording with forces, rotation matrices and an accelerometer.
        cutoff: cutoff of the filter [Hz]; by default the case's.
        turning_cutoff: the same of the orientations alone, whose noise in a wide band would be taken for accelerations.

    Raises:
        RecordingError: a stream or the filter is missing, or too slow or too short for it.
        IdentificationError: the sensor does not turn, or the model needs the position.
    """
    (turning, rotations), (accelerometer, readings) = _streams(recording)
    if model.needs_position or MASS not in model.blocks:
        raise IdentificationError(
            problem=f"model {model.number} needs the platform's position",
            remedy="choose model 0 or 6",
            code=Code.NOT_SUPPORTED,
        )
    cutoff = case.recording.filter_cutoff_Hz if cutoff is None else cutoff
    if cutoff is None:
        raise RecordingError(
            problem=phrase("filter_needed", "a moving run needs a filter"),
            remedy=phrase("state_cutoff", "set recording.filter_cutoff_Hz in the case"),
            code=Code.MISSING,
        )
    # Without inertia, orientations only say where the sensor turns: their own band is enough for that.
    band = (turning_cutoff or cutoff) if model.needs_motion else min(cutoff, widest_band(turning))
    t, low_pass = _filter(recording, cutoff)
    inner = slice(low_pass.margin, len(t) - low_pass.margin)
    lost, t = lost_samples(recording.t), t[inner]
    recorded = bridged(recording.forces, recording.bad)
    smooth = low_pass.apply(recorded)
    quaternion, without_turn = _smooth(turning, _quaternions(rotations), band, t)
    specific, unmoved = _smooth(accelerometer, readings, cutoff, t)
    invalid = spoilt_by(recording.bad, lost, low_pass) | without_turn | unmoved
    speed = 2.0 * np.linalg.norm(quaternion(np.clip(t, quaternion.x[0], quaternion.x[-1]), 1), axis=1)
    speed[invalid] = 0.0
    window = _window(t, speed, quaternion, specific)
    missing = lost[low_pass.margin + window[:-1]].sum() if len(window) else 0
    share = float(np.sum(invalid[window])) + float(missing)
    rows = window[~invalid[window]]
    warnings = about_left_out(recording.source, share / max(len(window) + int(missing), 1), low_pass)
    samples = rows[:: low_pass.stride]
    if len(samples) < LEAST_ROWS:
        raise RecordingError(
            problem=phrase("short_overlap", "the streams overlap for too short a time behind the filter"),
            remedy=phrase("record_longer", "record longer"),
            code=Code.TOO_FEW,
        )
    quiet = _quiet(turning, accelerometer, cutoff, model)
    return WristRun(
        model=model, filter=low_pass, calm=quiet, t=t[samples], forces=smooth[samples],
        recorded=recorded[inner][samples], quaternion=quaternion, specific_force=specific, recorded_count=len(rows),
        window=warnings,
    )  # fmt: skip


def _streams(recording: Recording) -> tuple[tuple[Stream, Array], tuple[Stream, Array]]:
    """The streams that have rotation matrices, and readings of an accelerometer, with these.

    Raises RecordingError where one is missing.
    """
    turning, accelerometer = recording.stream_with("rotations"), recording.stream_with("specific_forces")
    if turning is None or accelerometer is None or turning.rotations is None or accelerometer.specific_forces is None:
        raise RecordingError(
            place=recording.source,
            problem=phrase(
                "accelerometer_needed",
                "a moving run without positions of drives needs rotation matrices and an accelerometer",
            ),
            remedy=phrase(
                "add_file", "add the file that has them, or remove t_s if each row is an averaged standstill"
            ),
            code=Code.MISSING,
        )
    return (turning, turning.rotations), (accelerometer, accelerometer.specific_forces)


def _quaternions(rotations: Array) -> Array:
    """Quaternions of rotation matrices, shape (n, 4), without changes of sign between neighbours."""
    quaternions = Rotation.from_matrix(rotations).as_quat()
    flips = np.cumprod(np.r_[1.0, np.sign(np.sum(quaternions[1:] * quaternions[:-1], axis=1))])
    return np.asarray(quaternions * flips[:, None])


def _window(t: Array, speed: Array, *signals: CubicSpline) -> Indices:
    """Samples from the first turn out of rest to rest again, at which all signals are known at any delay.

    Args:
        t: instants of the samples, shape (n,) [s].
        speed: angular speed there [rad/s].
    """
    moving = np.flatnonzero(speed > TURNING)
    if not len(moving):
        raise IdentificationError(
            problem=phrase("does_not_turn", "the sensor does not turn"),
            remedy=phrase("record_motion", "record a motion, or remove t_s from averaged standstills"),
            code=Code.NO_EXCITATION,
        )
    first, last = max(signal.x[0] for signal in signals), min(signal.x[-1] for signal in signals)
    inside = (t >= first + MOST_DELAY) & (t <= last - MOST_DELAY)
    inside[: moving[0]] = False
    inside[moving[-1] + 1 :] = False
    return np.flatnonzero(inside)


def narrow_run(recording: Recording, case: Case, model: Model) -> WristRun | None:
    """A moving run in a band in which next to nothing of its motion is noise; None where it has none.

    It is at most half of that of the fit, for residuals have that noise too.

    Args:
        recording: as for `wrist_run`.
        case: as for `wrist_run`; its cut-off is that of the fit.
        model: as for `wrist_run`.
    """
    cutoff, t = case.recording.filter_cutoff_Hz, recording.t
    if cutoff is None or t is None:
        return None
    for factor in BANDS:
        try:
            run = wrist_run(recording, case, model, cutoff / factor)
        except (RecordingError, IdentificationError):
            break
        if np.ptp(run.t) < MOST_OF_IT * np.ptp(t):
            break
        if run.calm:
            return run
    return None


def _quiet(turning: Stream, accelerometer: Stream, cutoff: float, model: Model) -> bool:
    """Whether next to nothing of a motion is noise of the streams that say it."""
    specific_forces, (_, low_pass) = accelerometer.specific_forces, _filter(accelerometer, cutoff)
    assert specific_forces is not None
    alike = np.zeros(3, dtype=bool)
    if not calm(low_pass, specific_forces, white_noise(specific_forces), alike, order=0):
        return False
    if not model.needs_motion:
        return True
    assert turning.rotations is not None
    axes, (_, low_pass) = turning.rotations.reshape(-1, 9), _filter(turning, cutoff)
    return calm(low_pass, axes, white_noise(axes), np.zeros(9, dtype=bool))


def _smooth(stream: Stream, values: Array, cutoff: float, at: Array) -> tuple[CubicSpline, Flags]:
    """A stream behind the filter, and whether damage or a gap disturbs it beside some instants, shape (n,)."""
    t, low_pass = _filter(stream, cutoff)
    signal = CubicSpline(t[low_pass.margin : len(t) - low_pass.margin], low_pass.apply(bridged(values, stream.bad)))
    spoilt = spoilt_by(stream.bad, lost_samples(stream.t), low_pass)
    after = np.clip(np.searchsorted(signal.x, at), 1, len(signal.x) - 1)
    return signal, np.asarray(spoilt[after] | spoilt[after - 1])


def _filter(stream: Stream, cutoff: float) -> tuple[Array, Filter]:
    """Sampling instants of a stream, and its filter."""
    t, step = _equal_steps(stream)
    if not 1.5 * cutoff < 0.5001 / step:
        raise RecordingError(
            place=stream.source,
            problem=f"{1 / step:.4g} samples a second are too few for filter_cutoff_Hz = {cutoff:g}",
            remedy=f"at most {1 / (3 * step):.3g}",
            code=Code.CLOCK,
        )
    return t, Filter(cutoff, step, MOST_DELAY)


def widest_band(*streams: Stream) -> float:
    """Highest cut-off at which the filter removes all above half the rate of every stream [Hz].

    In it a delay is estimated: at low frequencies it looks like a turn of the accelerometer about the axis of the
    motion, and what the sensors err by with the orientation passes for it; vibration and jerks of a machine do not.
    """
    return min(1.0 / (3.0 * _equal_steps(stream)[1]) for stream in streams)


def _equal_steps(stream: Stream) -> tuple[Array, float]:
    """Sampling instants of a stream, and their step [s]."""
    if stream.t is None or len(stream.t) < LEAST_ROWS:
        raise RecordingError(
            place=stream.source,
            problem=phrase("few_stamps", "has too few samples with time stamps for a moving run"),
            remedy=phrase("record_longer", "record longer"),
            code=Code.TOO_FEW,
        )
    return stream.t, stream.step


def _product(a: Array, b: Array) -> Array:
    """Vector part of the quaternion product a b, scalar last, shape (n, 3)."""
    return np.asarray(a[:, 3:] * b[:, :3] + b[:, 3:] * a[:, :3] + np.cross(a[:, :3], b[:, :3]))
