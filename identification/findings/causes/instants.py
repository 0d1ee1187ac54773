"""Some instants of a run, on which hypotheses are tried: forces at several delays, the motion, the noise of both."""

from collections.abc import Hashable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline

from cases.base.units import Array, Flags, Indices
from cases.schema import Case
from identification.machines.machine import Machine
from identification.machines.of_case import machine_of
from identification.model.model import Model
from identification.recording.recording import Recording
from identification.samples.moving_window import spoilt_by
from identification.samples.sample_checks import bridged
from identification.samples.samples import MOST_DELAY
from identification.samples.wrist import wrist_run
from identification.signals import Filter, decimated, white_noise

INSTANTS = 120  # at which hypotheses are tried
FEWEST = 60  # forces beyond the unknowns, below which nothing is tried
DELAYS = np.linspace(-0.9, 0.9, 37) * MOST_DELAY  # [s] between forces and motion; between them residuals are a parabola
COARSE = 3  # of them every third is enough to begin with
MOST_ROWS = 40_000  # of a long run, from its first movement on
SLOWEST = 0.05  # of the largest speed of a drive, from which on the machine moves
SHARE = 0.01  # of what varies in forces and moments: what is left at standstills, where no noise shows
LEAST_MARGINS = 3.0  # margins of the filter that a run is long, at least


@dataclass(frozen=True, slots=True, kw_only=True)
class Turning:
    """The motion of a sensor whose orientation was recorded."""

    rotations: Array  # R, shape (n, 3, 3)
    omega: Array  # angular velocity in {B}, shape (n, 3) [rad/s]
    alpha: Array  # angular acceleration in {B}, shape (n, 3) [rad/s^2]
    specific: Array | None  # specific force by an accelerometer, in {P}, shape (n, 3) [m/s^2]; None where it stands


@dataclass(frozen=True, slots=True)
class Memory:
    """What was computed once for some instants, and is asked for again: trials share motions, cases and tables."""

    of_instants: dict[Hashable, Any] = field(default_factory=dict)
    of_run: dict[Hashable, Any] = field(default_factory=dict)  # that parts of the instants share

    def of_part(self) -> "Memory":
        """For other instants of the same run."""
        return Memory(of_run=self.of_run)


@dataclass(frozen=True, slots=True, kw_only=True)
class Instants:
    """Some instants of a run."""

    case: Case
    model: Model
    machine: Machine | None  # that the drives move; None where the orientation was recorded
    step: float | None  # between recorded samples [s]; None for standstills
    rows: Indices  # rows of the recording, shape (n,)
    t: Array | None = None  # their times, shape (n,) [s]; None for standstills
    delays: Array  # of the forces after the motion, shape (D,) [s]
    forces: Array  # recorded that much later, shape (D, n, 6) [N, or N and N m]
    # positions of the drives and two derivatives, shape (n, d); None where the orientation was recorded
    drives: tuple[Array, Array, Array] | None = None
    posed: bool = False  # whether these come from recorded poses, so that joints of a hexapod do not count
    turning: Turning | None = None
    noise: Array  # of the forces, as they are here, shape (6,): what the best of all models leaves
    least: Array  # the same as it was measured, never more, shape (6,); 0 where it was not
    shaking: tuple[Array, Array, Array] | None = None  # noise of the drives and of their derivatives, shape (n, d)
    weights: Array  # what forces and model are multiplied by, shape (n,)
    rough: bool = False  # whether they are to choose by: some of the instants, and of the delays
    memory: Memory = field(default_factory=Memory, compare=False, repr=False)

    def part(self, count: int) -> "Instants":
        """About so many of the instants, and some of the delays."""
        some = self.cut(slice(None, None, max(1, len(self.rows) // count)))
        return replace(some, delays=self.delays[::COARSE], forces=some.forces[::COARSE], rough=True)

    def cut(self, part: slice) -> "Instants":
        """Some of the instants."""
        drives = None if self.drives is None else (self.drives[0][part], self.drives[1][part], self.drives[2][part])
        turning = self.turning
        if turning is not None:
            turning = replace(
                turning, rotations=turning.rotations[part], omega=turning.omega[part], alpha=turning.alpha[part],
                specific=None if turning.specific is None else turning.specific[part],
            )  # fmt: skip
        return replace(
            self, rows=self.rows[part], t=None if self.t is None else self.t[part], forces=self.forces[:, part],
            drives=drives, turning=turning,
            weights=self.weights[part], shaking=None, memory=self.memory.of_part(),
        )  # fmt: skip


def instants_of(recording: Recording, case: Case, model: Model) -> Instants | None:
    """Some instants of a run; None where it has too few samples.

    Raises:
        RecordingError: the clock is not uniform, or streams are missing.
        IdentificationError: the sensor does not turn.
    """
    still = recording.t is None
    if recording.drives is not None:
        return _standing(recording, case, model) if still else _moving(recording, case, model)
    if recording.rotations is None and not recording.others:
        return None
    return _standing(recording, case, model) if still else _wrist(recording, case, model)


def _stated(case: Case) -> Array | None:
    """Noise of one recorded sample by the case, shape (6,); None where it states none."""
    if case.sensors.force_noise is not None:
        return case.sensors.force_noise
    if case.simulation is not None and np.all(case.simulation.force_noise > 0.0):
        return case.simulation.force_noise
    return None


def _spread(forces: Array, case: Case) -> Array:
    """What varies in forces and in moments, rms, shape (6,)."""
    variance = forces.var(axis=0)
    if case.sensor_frame.has_moments:
        return np.asarray(np.sqrt(np.repeat(variance.reshape(2, 3).mean(axis=1), 3)))
    return np.full(6, np.sqrt(variance.mean()))


def _pooled(noise: Array, case: Case) -> Array:
    """Noise of forces, and of moments, rms over the channels that have one unit, shape (6,)."""
    if case.sensor_frame.has_moments:
        return np.asarray(np.sqrt(np.repeat((noise**2).reshape(2, 3).mean(axis=1), 3)))
    return np.full(6, np.sqrt(np.mean(noise**2)))


def _floor(noise: Array, spread: Array) -> Array:
    """Noise that is nowhere so small that only rounding is seen."""
    return np.asarray(np.maximum(noise, np.maximum(1e-6 * spread, np.finfo(float).tiny)))


def _standing(recording: Recording, case: Case, model: Model) -> Instants | None:
    valid = np.flatnonzero(~recording.bad)
    valid = valid[:: max(1, -(-len(valid) // (4 * INSTANTS)))]
    forces = recording.forces[valid]
    if forces.size - len(model.names) < FEWEST:
        return None
    spread = _spread(forces, case)
    noise_of_case = _stated(case)
    noise = SHARE * spread if noise_of_case is None else np.minimum(noise_of_case, SHARE * spread)
    drives = turning = None
    if recording.drives is not None:
        places = recording.drives[valid]
        drives = places, np.zeros_like(places), np.zeros_like(places)
    elif recording.rotations is not None:
        none = np.zeros((len(valid), 3))
        turning = Turning(rotations=recording.rotations[valid], omega=none, alpha=none, specific=None)
    else:
        return None
    weights = np.ones(len(valid)) if recording.weights is None else recording.weights[valid]
    return Instants(
        case=case, model=model, machine=None if drives is None else machine_of(case), step=None, rows=valid,
        delays=np.zeros(1), forces=forces[None], drives=drives, posed=recording.poses is not None, turning=turning,
        noise=_floor(noise, spread), least=np.zeros(6), weights=weights / weights.max(),
    )  # fmt: skip


def _moving(recording: Recording, case: Case, model: Model) -> Instants | None:
    assert recording.drives is not None
    assert recording.t is not None
    count = len(recording.forces)
    if count < 2:
        return None
    low_pass = _filter(case, recording.step, count)
    if low_pass is None:
        return None
    bad, margin = recording.bad, low_pass.margin
    begin = _first_movement(recording.drives, count)
    part = slice(begin, min(begin + MOST_ROWS, count))
    struts, forces = bridged(recording.drives, bad)[part], bridged(recording.forces, bad)[part]
    usable = ~spoilt_by(bad, recording.lost, low_pass)[part.start : part.stop - 2 * margin]
    on = None if recording.trigger is None else recording.trigger[part][margin:-margin]
    every = np.arange(len(struts) - 2 * margin)
    speed = np.abs(decimated(low_pass, struts, every, [(1, 0.0)])[0])
    rows = _chosen(usable, on, speed)
    if len(rows) * 6 - len(model.names) < FEWEST:
        return None
    drives = decimated(low_pass, struts, rows, [(order, 0.0) for order in range(3)])
    shifted = decimated(low_pass, forces, rows, [(0, -delay) for delay in DELAYS])
    gain = low_pass.noise_gain
    white, shaken = _pooled(white_noise(forces), case), white_noise(struts)
    noise_of_case = _stated(case)
    noise = np.sqrt(gain) * (white if noise_of_case is None else np.maximum(white, noise_of_case))
    if case.sensors.pose_field is not None:
        noise = np.hypot(noise, case.sensors.pose_field.size)
    draw = np.random.default_rng(0).normal(size=struts.shape) * shaken
    shaking = decimated(low_pass, draw, rows, [(order, 0.0) for order in range(3)])
    spread = _spread(shifted[len(DELAYS) // 2], case)
    return Instants(
        case=case, model=model, machine=machine_of(case), step=low_pass.step, rows=begin + margin + rows,
        t=recording.t[begin + margin + rows], delays=DELAYS, forces=np.array(shifted),
        drives=(drives[0], drives[1], drives[2]), posed=recording.poses is not None,
        noise=_floor(noise, spread), least=white * np.sqrt(gain), shaking=(shaking[0], shaking[1], shaking[2]),
        weights=np.ones(len(rows)),
    )  # fmt: skip


def _filter(case: Case, step: float, count: int) -> Filter | None:
    """The low-pass of a case, as far as it fits the rate and the length of a run; None for a run that is too short."""
    highest = 0.2 / step
    cutoff = min(case.recording.filter_cutoff_Hz or 0.4 * highest, highest)
    for other in (cutoff, 0.4 * highest, highest):
        low_pass = Filter(max(other, cutoff), step, MOST_DELAY)
        if count > LEAST_MARGINS * 2 * low_pass.margin:
            return low_pass
    return None


def _first_movement(struts: Array, count: int) -> int:
    """A row shortly before the first movement of a long run; 0 of others."""
    if count <= MOST_ROWS:
        return 0
    away = np.abs(struts - struts[0]).max(axis=1)
    moved = int(np.argmax(away > SLOWEST * away.max()))
    return int(np.clip(moved - MOST_ROWS // 8, 0, count - MOST_ROWS))


def _chosen(usable: Flags, on: Flags | None, speed: Array) -> Indices:
    """Filtered samples at equal distances of those that can be used and in which the machine moves, shape (k,)."""
    moving = np.any(speed > SLOWEST * np.maximum(speed.max(axis=0), np.finfo(float).tiny), axis=1)
    for choice in (usable & moving & (True if on is None else on), usable & moving, usable):
        rows = np.flatnonzero(choice)
        if len(rows) >= INSTANTS:
            break
    return np.asarray(rows[np.linspace(0, len(rows) - 1, min(len(rows), INSTANTS)).astype(np.int64)])


def _wrist(recording: Recording, case: Case, model: Model) -> Instants | None:
    run = wrist_run(recording, case, model)
    places = np.arange(len(run.t))
    inner = places[(run.t >= run.t[0] + MOST_DELAY) & (run.t <= run.t[-1] - MOST_DELAY)]
    if len(inner) < 4:
        return None
    rows = inner[np.linspace(0, len(inner) - 1, min(len(inner), INSTANTS)).astype(np.int64)]
    if len(rows) * 6 - len(model.names) < FEWEST:
        return None
    smooth = CubicSpline(run.t, run.forces)
    t = run.t[rows]
    turning = run.turning(t)
    assert recording.t is not None
    white = _pooled(white_noise(bridged(recording.forces, recording.bad)), case) * np.sqrt(run.filter.noise_gain)
    noise_of_case = _stated(case)
    noise = white if noise_of_case is None else np.maximum(white, noise_of_case * np.sqrt(run.filter.noise_gain))
    forces = np.array([smooth(t + delay) for delay in DELAYS])
    return Instants(
        case=case, model=model, machine=None, step=run.filter.step, rows=rows, t=t, delays=DELAYS, forces=forces,
        turning=Turning(rotations=turning[0], omega=turning[1], alpha=turning[2], specific=turning[3]),
        noise=_floor(noise, _spread(forces[len(DELAYS) // 2], case)), least=white, weights=np.ones(len(rows)),
    )  # fmt: skip
