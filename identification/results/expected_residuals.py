"""A recording as a result sees it: forces less those that are expected, and how far both may be off."""

from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from scipy.spatial.transform import Rotation

from cases.base.units import Array
from cases.schema import Case
from identification.finding import Finding
from identification.findings.left_out import LeftOut
from identification.findings.off_case import without
from identification.machines.machine import Kinematics
from identification.model.model import regressors
from identification.recording.recording import Recording
from identification.results.expected_errors import Errors, effects_in, errors_of, stated_sizes, turns_in
from identification.results.frames import Place, mounting_by
from identification.results.result import Result
from identification.samples.clocks import on_one_clock
from identification.samples.moving import MovingRun
from identification.samples.moving_window import moving_run
from identification.samples.sample_checks import unmeasured
from identification.samples.samples import MotionOfSamples
from identification.samples.standstills import standstills
from identification.signals import decimated, white_noise

PIECE = 4_000  # samples whose errors are computed together: limits the memory
NOISE, DELAY = "noise", "delay"  # kinds of causes beside those of parameters


@dataclass(frozen=True, slots=True)
class Used:
    """Samples of a recording with what a result expects of them."""

    result: Result
    case: Case  # of the machine as its run told it
    t: Array  # shape (n,) [s]
    residuals: Array  # forces less those that are expected, shape (n, 6) [N, or N and N m]
    motion: MotionOfSamples | None  # how the load moves; None where the frame of the sensors stands
    noise: Array  # variance of a force by noise, shape (6,)
    late: Array | None  # how forces change with the delay, shape (n, 6) [1/s]; None where nothing moves
    findings: tuple[Finding, ...]
    origin: Fraction | None

    def into(self, place: Place) -> Array:
        """What turns residuals into force and moment from outside about and along a frame, shape (n or 1, 6, 6)."""
        model, poses = self.result.model, None if self.motion is None else self.motion.load.pose
        rows = 1 if model.struts is None else len(self.t)
        columns = [model.wrenches(np.tile(axis, (rows, 1)), poses) for axis in np.eye(6)]
        out = -np.stack(columns, axis=2)
        if place.fixed:
            return np.asarray(place.map @ out)
        return np.asarray(_both(self.turns) @ out)

    @property
    def turns(self) -> Array:
        """Axes of {P} in {B}, shape (n, 3, 3)."""
        assert self.motion is not None
        return np.asarray(Rotation.from_euler("xyz", self.motion.load.pose[:, 3:]).as_matrix())

    def variances(self, place: Place, into: Array, wrenches: Array) -> dict[str, Array]:
        """Variances of force and moment in a frame by kinds of causes, shapes (n, 6).

        Args:
            place: the frame.
            into: `into` of it.
            wrenches: what it makes of the residuals, shape (n, 6).
        """
        into = np.broadcast_to(into, (len(self.t), 6, 6))
        parts: dict[str, list[Array]] = {}
        for begin in range(0, len(self.t), PIECE):
            piece = slice(begin, begin + PIECE)
            for kind, variance in self._piece(piece, place, into[piece], wrenches[piece]).items():
                parts.setdefault(kind, []).append(variance)
        return {kind: np.concatenate(of) for kind, of in parts.items()}

    def _piece(self, piece: slice, place: Place, into: Array, wrenches: Array) -> dict[str, Array]:
        variances, delay = {NOISE: (into**2) @ self.noise}, self.result.record.delay_s
        if self.late is not None and delay is not None:
            variances[DELAY] = (np.einsum("nij,nj->ni", into, self.late[piece]) * delay.std) ** 2
        return variances | self.errors(piece, place, into, wrenches).variances

    def errors(self, piece: slice, place: Place, into: Array, wrenches: Array) -> Errors:
        """Errors of force and moment in a frame that all samples have in common; arguments as of `variances`.

        Args:
            piece: samples, of which `into` and `wrenches` are.
        """
        result, effects = self.result, dict[str, Array]()
        if self.motion is None:
            still = np.zeros((1, 6))
            return errors_of(result, into @ regressors(result.model, Kinematics(still, still, still)), effects)
        motion = self.motion.at(piece)
        left_out = LeftOut.in_use(result.model, motion, result.values, self.residuals[piece], self.case)
        effects = {key: into @ of for key, of in effects_in(left_out, result).items()}
        if not place.fixed:
            for key, turn in turns_in(left_out, result).items():
                effects[key] -= _turned(turn, wrenches)
        elif place.name != "sensor":
            sizes = stated_sizes(result)
            for key, columns in mounting_by(place, wrenches).items():
                if key in effects:
                    effects[key] -= sizes[key] * columns
        return errors_of(result, into @ regressors(result.model, motion.load), effects)


def _turned(turns: Array, wrenches: Array) -> Array:
    """How forces and moments change that turn, by small turns, shapes (n, 3, k) and (n, 6) -> (n, 6, k)."""
    halves = [np.cross(turns, wrenches[:, half, None], axis=1) for half in (slice(0, 3), slice(3, 6))]
    return np.concatenate(halves, axis=1)


def _both(turns: Array) -> Array:
    """Turns, shape (n, 3, 3), of force and moment alike, shape (n, 6, 6)."""
    whole = np.zeros((len(turns), 6, 6))
    whole[:, :3, :3] = whole[:, 3:, 3:] = turns
    return whole


def used_samples(recording: Recording, result: Result, whole: bool) -> Used:
    """A recording as a result sees it, of a moving run behind the filter of the case; errors as of `force`."""
    model = result.model
    recording, case = without(on_one_clock(recording, result.case), result.case, result.sizes)
    findings = unmeasured(recording)
    measured, behind = noise_left(result)
    white = white_noise(recording.forces[~recording.bad])
    if recording.t is None or case.setup == "1a":
        still = standstills(recording, case, model)
        # rows may be averages: then residuals of averages say more than the noise of a sample
        noise = np.maximum(white, behind if result.record.delay_s is None else measured) ** 2
        origin = None
        motion, residuals = still.standing, still.recorded - still.matrices @ result.values
        return Used(result, case, still.t, residuals, motion, noise, None, findings, origin)
    run = moving_run(recording, case, model, whole)
    motion = motion_of(run, result.delay)
    residuals = run.forces - regressors(model, motion.load) @ result.values
    noise = np.maximum(run.filter.noise_gain * white**2, behind**2)
    late = run.linearised(result.delay, result.values)[:, :, -1]
    return Used(result, case, run.t, residuals, motion, noise, late, findings + run.window, recording.origin)


def motion_of(run: MovingRun, delay: float) -> MotionOfSamples:
    """How the load moves at the samples of a run, with its drives, behind the filter of the case."""
    assert run.recording.drives is not None
    place, speed, acceleration = decimated(
        run.filter, run.recording.drives, run.rows, [(order, delay) for order in range(3)]
    )
    known = np.ones(len(run.rows), dtype=bool)
    return MotionOfSamples(known, run.kinematics(delay), (place, speed, acceleration), run.machine)


def noise_left(result: Result) -> tuple[Array, Array]:
    """What the run of a result left in each channel: as white noise of a sample, and as it was evaluated, shapes (6,).

    Zero where the result does not say; residuals of the forces as recorded where it does not say how it evaluated them.
    """
    entries = result.record.channel_noise or {}
    measured = np.array(entries.get("measured", np.zeros(6)), dtype=float)
    return measured, np.array(entries.get("evaluated", np.zeros(6)), dtype=float)
