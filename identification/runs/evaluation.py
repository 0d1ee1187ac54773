"""What is evaluated of a recording: regressors and forces, of standstills or at any delay of a moving run.

Forces and struts of a moving run pass the same zero-phase low-pass, which also differentiates the struts: what a
controller's blocks and the encoders' steps add above the cut-off then disturbs neither side. What is left is kept at
the rate that it still needs.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from identification.estimation.fit import Filtered, Robust
from identification.hexapod import Hexapod, Kinematics, StrutsDoNotClose
from identification.long.decimation import decimated
from identification.model import Model, regressors
from identification.noise.by_pose import covariance_by_pose
from identification.noise.coloured import coloured_covariance
from identification.noise.turned import turned
from identification.recording import Recording
from identification.signals import Filter

Array = NDArray[np.float64]

MOST_DELAY = 0.04  # [s] between forces and motion that is looked for, either way
SMOOTHING_STEP = 1e-3  # [s] for the second derivative: far below the periods that pass
DELAY_STEP = 1e-5  # [s] for the derivative with respect to the delay: far below what the filter lets pass


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
        """The same behind the filter, shape (n, 6) [N, or N and N m]."""
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
    ) -> Robust | None:
        """Covariance of u for noise of any colour and errors of the pose, from A and residuals; None for short runs."""
        found = turned(matrices, residuals, weights, self.places)
        assert self.recording.struts is not None
        placed = covariance_by_pose(found, self.recording.struts[self.filter.margin + self.rows])
        if placed is not None:
            return Robust(placed.covariance, (placed.note,), placed.field(residuals) if whitening is None else None)
        coloured = coloured_covariance(found)
        return None if coloured is None else Robust(coloured)

    def without(self, left_out: NDArray[np.bool_]) -> "Run":
        """The run without some of its evaluated samples, shape (n,)."""
        share = 1.0 - float(left_out.mean())
        return replace(self, rows=self.rows[~left_out], samples=round(self.samples * share))


def inwards(delay: float) -> float:
    """A delay next to a given one [s], on the side where the filter reaches."""
    return delay + DELAY_STEP if delay < 0.0 else delay - DELAY_STEP
