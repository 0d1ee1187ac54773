"""A recording made ready for regression: regressors and forces on the samples that are evaluated.

Standstills go in as they are. Forces and struts of a moving run pass the same zero-phase low-pass, which also
differentiates the struts: what a controller's blocks and the encoders' steps add above the cut-off then disturbs
neither side. What is left is kept at the rate that it still needs.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cases.errors import IdentificationError, RecordingError
from cases.schema import Case
from identification.estimation.fit import Filtered
from identification.findings.plausibility import Scan, bridged
from identification.formats.lost import MOST_PUT_BACK
from identification.hexapod import Hexapod, Kinematics, StrutsDoNotClose
from identification.long.decimation import decimated
from identification.model import Model, regressors
from identification.noise.coloured import coloured_covariance
from identification.recording import Recording
from identification.signals import Filter

Array = NDArray[np.float64]

LEAST_TRAVEL = 1e-4  # [m] of the struts; below, the pose counts as constant
MOST_DELAY = 0.04  # [s] between forces and motion that is looked for, either way
MOVING = 1e-3  # [m/s] strut speed from which the machine counts as moving, where there is no trigger
SMOOTHING_STEP = 1e-3  # [s] for the second derivative: far below the periods that pass
DELAY_STEP = 1e-5  # [s] for the derivative with respect to the delay: far below what the filter lets pass
SMALLER_UNITS = {"ms": 1e-3, "us": 1e-6}  # of clocks [s]
MOST_RATE = 20e3  # a fifth of the samples a second that a recorder of forces takes at most [1/s]
MOST_LEFT_OUT = 0.5  # of the motion, by damage and the filter's reach around it
MOST_BRIDGED = (
    MOST_PUT_BACK  # bad samples in a row that a straight line replaces; the filter makes nothing of the difference
)


@dataclass(frozen=True, slots=True)
class Standstills:
    """Averaged standstills: nothing moves, nothing is filtered.

    Args:
        forces: shape (n, 6) [N, or N and N m].
        regressors: A, shape (n, 6, u).
    """

    forces: Array
    regressors: Array

    @property
    def samples(self) -> int:
        """Recorded samples that are evaluated."""
        return len(self.forces)


@dataclass(frozen=True, slots=True)
class Run:
    """A moving run, ready to be evaluated at any delay between forces and motion.

    Args:
        recording: with struts and a clock.
        model: gives A.
        hexapod: kinematics.
        filter: for both sides.
        rows: samples that are evaluated, counted after the filter's margin, shape (n,).
        samples: recorded samples of the window that they stand for.
        warnings: sentences about the window.
        smoothing: whether it is estimated by how much more the forces are smoothed than the motion.
        spoilt: filtered samples that feel damage or a gap, shape (samples of the recording less two margins,).
    """

    recording: Recording
    model: Model
    hexapod: Hexapod
    filter: Filter
    rows: NDArray[np.int64]
    samples: int
    warnings: tuple[str, ...] = ()
    smoothing: bool = False
    spoilt: NDArray[np.bool_] | None = None

    @property
    def t(self) -> Array:
        """Time of the evaluated samples, shape (n,) [s]."""
        assert self.recording.t is not None
        return self.recording.t[self.filter.margin + self.rows]

    @property
    def step(self) -> float:
        """Time between evaluated samples [s]."""
        return self.filter.step * self.filter.stride

    @property
    def places(self) -> NDArray[np.int64]:
        """Of the evaluated samples in a series of equal steps, shape (n,): sections and gaps are no neighbours."""
        lost = np.r_[0, np.cumsum(self.recording.lost)][self.filter.margin + self.rows]
        rows = self.rows + lost - lost[0]
        return np.asarray(np.floor((rows - rows[0]) / self.filter.stride + 0.5), dtype=np.int64)

    @property
    def filtered(self) -> Filtered:
        """What the filter did to white noise."""
        return Filtered(self.filter.noise_gain, self.filter.stride)

    @property
    def recorded_forces(self) -> Array:
        """Forces as recorded at the evaluated samples, shape (n, 6)."""
        return self.recording.forces[self.filter.margin + self.rows]

    @property
    def forces(self) -> Array:
        """The same behind the filter."""
        return decimated(self.filter, self.recording.forces, self.rows, [(0, 0.0)])[0]

    def regressors(self, delay: float) -> Array:
        """A at the instants t_k - delay, shape (n, 6, u)."""
        return regressors(self.model, self.kinematics(delay))

    def kinematics(self, delay: float) -> Kinematics:
        """Motion of the platform at the instants t_k - delay, of n samples."""
        return self.kinematics_at(delay)[0]

    def kinematics_at(self, *delays: float) -> list[Kinematics]:
        """The same at several delays; from the second one on poses are found from those at the first.

        Raises:
            StrutsDoNotClose: with the place in the file.
        """
        assert self.recording.struts is not None
        wanted = [(order, delay) for delay in delays for order in range(3)]
        motions = decimated(self.filter, self.recording.struts, self.rows, wanted)
        found: list[Kinematics] = []
        try:
            for k, delay in enumerate(delays):
                near = self.hexapod.earlier(found[0], delay - delays[0]) if found else None
                lengths, velocities, accelerations = motions[3 * k : 3 * k + 3]
                found.append(self.hexapod.kinematics(lengths, velocities, accelerations, near))
            return found
        except StrutsDoNotClose as error:  # say where in the file it is
            row = int(self.filter.margin + self.rows[error.sample])
            raise StrutsDoNotClose(row, error.lengths, self.recording.lines.place(row)) from error

    def effect_of_delay(self, delay: float, matrices: Array, values: Array) -> Array:
        """How the expected forces A u change with the delay, shape (n, 6) [N/s, or N/s and N m/s].

        By shifting the filter, not by differences of neighbouring samples, between which the window may have a gap.

        Args:
            delay: where [s].
            matrices: A there, shape (n, 6, u).
            values: u, shape (u,).
        """
        shifted = inwards(delay)
        return np.asarray((self.regressors(shifted) - matrices) @ values / (shifted - delay))

    def linearised(self, delay: float, values: Array) -> tuple[Array, Array]:
        """A, shape (n, 6, u), and the columns of the nuisances at values u, shape (n, 6, nuisances)."""
        here, there = self.kinematics_at(delay, inwards(delay))
        matrices = regressors(self.model, here)
        late = (regressors(self.model, there) - matrices) @ values / (inwards(delay) - delay)
        return matrices, self._columns(delay, matrices, values, late)

    @property
    def nuisances(self) -> tuple[str, ...]:
        """Names of what is estimated beside the model."""
        return ("smoothing", "delay") if self.smoothing else ("delay",)

    def nuisance_columns(self, delay: float, matrices: Array, values: Array) -> Array:
        """Their columns, shape (n, 6, nuisances)."""
        return self._columns(delay, matrices, values, self.effect_of_delay(delay, matrices, values))

    def _columns(self, delay: float, matrices: Array, values: Array, late: Array) -> Array:
        if not self.smoothing:
            return late[:, :, None]
        return np.stack([self.effect_of_smoothing(delay, matrices, values), late], axis=2)

    def effect_of_smoothing(self, delay: float, matrices: Array, values: Array) -> Array:
        """Second derivative of the expected forces A u with respect to time, shape (n, 6) [N/s^2, N m/s^2].

        Args:
            delay: where [s].
            matrices: A there, shape (n, 6, u).
            values: u, shape (u,).
        """
        room = MOST_DELAY - SMOOTHING_STEP  # where the filter still reaches to both sides
        middle = float(np.clip(delay, -room, room))
        here = matrices if middle == delay else self.regressors(middle)
        around = self.regressors(middle + SMOOTHING_STEP) + self.regressors(middle - SMOOTHING_STEP)
        return np.asarray((around - 2.0 * here) @ values / SMOOTHING_STEP**2)

    @property
    def noise_correlation(self) -> float:
        """Of white noise behind the filter, between evaluated samples."""
        return self.filter.noise_correlation

    def left(self, matrices: Array, values: Array) -> Array:
        """Recorded forces less the model, A u, at the evaluated samples, shape (n, 6)."""
        return np.asarray(self.recorded_forces - matrices @ values)

    def robust_covariance(
        self, matrices: Array, residuals: Array, weights: Array, whitening: Array | None
    ) -> Array | None:
        """Covariance of u for noise of any colour, shape (u, u), from A and residuals; None for short runs."""
        return coloured_covariance(matrices, residuals, weights, self.places)

    def without(self, left_out: NDArray[np.bool_]) -> "Run":
        """The run without some of its evaluated samples, shape (n,)."""
        share = 1.0 - float(left_out.mean())
        return replace(self, rows=self.rows[~left_out], samples=round(self.samples * share))


def inwards(delay: float) -> float:
    """A delay next to a given one [s], on the side where the filter reaches."""
    return delay + DELAY_STEP if delay < 0.0 else delay - DELAY_STEP


def standstills(recording: Recording, case: Case, model: Model, found: Scan | None = None) -> Standstills:
    """Regressors of averaged standstills.

    Args:
        recording: one row a standstill.
        case: machine.
        model: gives A.
        found: rows to leave out.

    Raises:
        IdentificationError: the model needs what the recording does not have, or the struts cannot close.
    """
    require_position(recording, model)
    used = np.ones(len(recording.forces), dtype=bool) if found is None else ~found.bad
    still = np.zeros((int(used.sum()), 6))
    count, forces = len(still), recording.forces[used]
    if recording.struts is not None:
        try:
            poses = Hexapod.of(case).poses(recording.struts[used])
        except StrutsDoNotClose as error:
            row = int(np.flatnonzero(used)[error.sample])
            raise StrutsDoNotClose(row, error.lengths, recording.lines.place(row)) from error
        return Standstills(forces, regressors(model, Kinematics(poses, still, still)))
    assert recording.rotations is not None  # the reader admits no recording without a pose
    matrices = model.matrices(np.zeros((count, 3)), recording.rotations[used], still, still)
    return Standstills(forces, matrices)


def moving_run(recording: Recording, case: Case, model: Model, whole: bool = False, found: Scan | None = None) -> Run:
    """A moving run with its window found.

    Args:
        recording: with struts and a clock.
        case: machine and filter.
        model: gives A.
        whole: evaluate all samples, not only the excitation.
        found: samples that may not be used; what their values did to the filter is left out with them.

    Raises:
        RecordingError: no struts, no filter in the case, a filter that does not fit the rate, a trigger that is never
        on.
        IdentificationError: the pose is constant.
    """
    require_position(recording, model)
    if recording.struts is None:
        raise RecordingError(
            f"{recording.source}: has a clock and rotation matrices; moving runs are evaluated from struts only, "
            "remove t_s if each row is an averaged standstill"
        )
    low_pass = checked_filter(recording, case)
    count = len(recording.struts) - 2 * low_pass.margin
    warnings: tuple[str, ...] = ()
    bad = np.zeros(len(recording.forces), dtype=bool) if found is None else found.bad
    spoilt = spoilt_by(bad, recording.lost, low_pass)
    if bad.any():
        recording = replace(recording, struts=bridged(recording.struts, bad), forces=bridged(recording.forces, bad))
    assert recording.struts is not None
    if whole:
        low_pass.apply(recording.struts)  # raises where the run is shorter than the filter
        window = np.arange(max(count, 0))
    else:
        window, warnings = _window(recording, low_pass)
    together = np.flatnonzero(np.diff(window) == 1)
    lost = int(recording.lost[low_pass.margin + window[together]].sum())
    share = 1.0 - float(np.sum(~spoilt[window])) / (len(window) + lost)
    warnings += about_left_out(recording.source, share, low_pass)
    window = window[~spoilt[window]]
    rows = window[:: low_pass.stride]
    if len(rows) < 2:
        raise IdentificationError(
            f"{recording.source}: {len(window)} samples of motion are {len(rows)} independent ones behind a "
            f"{low_pass.cutoff:g} Hz filter; record longer"
        )
    return Run(recording, model, Hexapod.of(case), low_pass, rows, len(window), warnings, spoilt=spoilt)


def checked_filter(recording: Recording, case: Case) -> Filter:
    """The low-pass of a case at the rate of a recording.

    Raises:
        RecordingError: the case has none, it does not fit the rate, or the clock is not uniform.
    """
    cutoff = case.recording.filter_cutoff_Hz
    if cutoff is None:
        raise RecordingError(
            f"{recording.source}: a moving run needs a filter; set recording.filter_cutoff_Hz in the case"
        )
    if len(recording.forces) < 2:
        raise RecordingError(f"{recording.source}: {len(recording.forces)} sample is no run; record longer")
    step = recording.step
    if not cutoff < 0.2 / step:
        raise RecordingError(
            f"{recording.source}: filter_cutoff_Hz = {cutoff:g} is too high for {1 / step:.4g} samples a second; at "
            f"most {0.2 / step:.4g}{_other_clock(step, cutoff)}"
        )
    return Filter(cutoff, step, MOST_DELAY)


def _other_clock(step: float, cutoff: float) -> str:
    """What to add where the time stamps make sense in a smaller unit."""
    for unit, factor in SMALLER_UNITS.items():
        if cutoff < 0.2 / (step * factor) < MOST_RATE:
            return f"; time stamps {step:.3g} s apart seem to be in {unit}: set recording.clock.unit = '{unit}'"
    return ""


def spoilt_by(bad: NDArray[np.bool_], lost: NDArray[np.int64], low_pass: Filter) -> NDArray[np.bool_]:
    """Filtered samples that feel more than a short bridge of bad ones, or reach across a gap, shape (n - 2 margin,).

    Args:
        bad: samples that may not be used, shape (n,).
        lost: how many are missing between each and the next, shape (n - 1,).
        low_pass: the filter; each section between gaps is filtered by itself.
    """
    count, margin = len(bad), low_pass.margin
    change = np.zeros(count + 1, dtype=np.int64)
    cuts = 1 + np.flatnonzero(lost)
    np.add.at(change, np.maximum(cuts - margin, 0), 1)
    np.add.at(change, np.minimum(cuts + margin, count), -1)
    ends = {0, count, *cuts.tolist()}  # of sections, beyond which there is nothing to bridge to
    edges = np.flatnonzero(np.diff(np.r_[False, bad, False].astype(np.int8)))
    for first, end in zip(edges[::2], edges[1::2], strict=True):
        if end - first > MOST_BRIDGED or first in ends or end in ends:
            change[max(first - margin, 0)] += 1
            change[min(end + margin, count)] -= 1
    spoilt = np.cumsum(change)[:-1] > 0
    return np.asarray(spoilt[margin : count - margin])


def about_left_out(source: str, share: float, low_pass: Filter) -> tuple[str, ...]:
    """What to say where damage, with the filter's reach around it, takes a share of the motion.

    Raises:
        RecordingError: it takes too much.
    """
    reach = low_pass.margin * low_pass.step
    if share > MOST_LEFT_OUT:
        raise RecordingError(
            f"{source}: damage, with the filter's reach of {reach:.3g} s on either side, takes {100 * share:.3g} % of "
            f"the motion, at most {100 * MOST_LEFT_OUT:g} % may be left out; record again"
        )
    if share <= 0.0:
        return ()
    return (
        f"{100 * share:.2g} % of the motion is left out: damage longer than {MOST_BRIDGED} samples, gaps, and "
        f"{reach:.3g} s on either side, as far as the filter reaches",
    )


def require_position(recording: Recording, model: Model) -> None:
    """Raises IdentificationError where a model needs the position and the recording has none."""
    if model.needs_position and recording.struts is None:
        raise IdentificationError(
            f"{recording.source}: model {model.number} needs the platform's position, the recording has orientations "
            "only; choose model 0 or 6, or record the struts"
        )


def _window(recording: Recording, low_pass: Filter) -> tuple[NDArray[np.int64], tuple[str, ...]]:
    """Samples with the trigger on; without a trigger from the first movement out of rest to rest again."""
    assert recording.struts is not None
    margin = low_pass.margin
    speed = low_pass.apply(recording.struts, 1)  # raises where the run is shorter than the filter
    warnings: tuple[str, ...] = ()
    if recording.trigger is not None:
        rows = np.flatnonzero(recording.trigger[margin:-margin])
        if not len(rows):
            raise RecordingError(f"{recording.source}, trigger: is never 1; record with the trigger or leave it out")
    else:
        moving = np.flatnonzero(np.abs(speed).max(axis=1) > MOVING)
        rows = np.arange(moving[0], moving[-1] + 1) if len(moving) else np.arange(len(speed))
        if not len(moving):
            warnings = (
                f"the struts are never faster than {MOVING * 1e3:g} mm/s, so that all of the recording is evaluated; "
                "record a trigger where only a part is meant",
            )
    travel = np.ptp(recording.struts[margin + rows], axis=0).max()
    if travel < LEAST_TRAVEL:
        raise IdentificationError(
            f"{recording.source}: the pose is constant (struts move by {travel * 1e3:.3g} mm, at least "
            f"{LEAST_TRAVEL * 1e3:g} mm are needed); record the excitation, or remove t_s from averaged standstills"
        )
    return rows, warnings
