"""The platform with weights on it, and what disturbs the machine that carries it."""

from collections.abc import Sequence
from functools import reduce
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cases.errors import CaseError
from cases.schema import Case
from cases.sensors import Disturbances, RigidBody, Truth, together
from identification.trajectories.executed import DriveExecution, Execution

Array = NDArray[np.float64]

WAVES = 48  # of which a pose error is made
RIPPLE_STEP = 1e-3  # [s] between the samples of the ripple


class Circumstances(NamedTuple):
    """What is mounted on the simulated machine, and what disturbs it."""

    weights: tuple[RigidBody, ...] = ()
    disturbances: Disturbances | None = None  # None: an ideal structure, only sensors and encoders are imperfect

    @property
    def load(self) -> float:
        """Mass of the weights [kg]."""
        return sum(w.mass_kg for w in self.weights)


UNDISTURBED = Circumstances()


def circumstances(case: Case, weights: int, disturbed: bool) -> Circumstances:
    """The first `weights` weights of a case mounted on its machine, with or without its disturbances.

    Raises:
        CaseError: the case has fewer weights, or no disturbances.
    """
    payloads = () if case.payloads is None else case.payloads.weights
    if not 0 <= weights <= len(payloads):
        raise CaseError(f"case {case.name}", "payloads.weights", f"are {len(payloads)}; {weights} cannot be mounted")
    disturbances = case.need_simulation("a run").disturbances
    if disturbed and disturbances is None:
        case.missing("simulation.disturbances", "a run with disturbances")
    return Circumstances(payloads[:weights], disturbances if disturbed else None)


def joined_body(bodies: Sequence[RigidBody]) -> RigidBody:
    """One rigid body made of several: masses, first moments and inertias about the origin of {P} add."""
    return reduce(together, bodies)


def loaded_truth(truth: Truth, weights: Sequence[RigidBody]) -> Truth:
    """The parameters of a machine with weights on its platform; offsets and compensation stay."""
    return truth.model_copy(update={"body": joined_body((truth.body, *weights))}) if weights else truth


def mode_frequency(truth: Truth, around: Circumstances) -> float:
    """Frequency of the structural mode: its stiffness is the structure's, its mass what is moved [Hz]."""
    assert around.disturbances is not None
    mass = truth.body.mass_kg
    return float(around.disturbances.mode_Hz * np.sqrt(mass / (mass + around.load)))


def vibrating(accelerations: Array, step: float, frequency: float, damping: float) -> Array:
    """Accelerations of a platform behind a spring and a damper, driven by those of the drives.

    Transfer function (2 d w s + w^2) / (s^2 + 2 d w s + w^2), exact for accelerations that are linear between samples.

    Args:
        accelerations: accelerations of the drives, from rest, shape (n, k).
        step: step between samples [s].
        frequency: frequency of the undamped mode [Hz].
        damping: share of the critical one.
    """
    from scipy.signal import cont2discrete, lfilter

    w = 2.0 * np.pi * frequency
    numerator, denominator = np.array([2.0 * damping * w, w**2]), np.array([1.0, 2.0 * damping * w, w**2])
    discrete = cont2discrete((numerator, denominator), step, method="foh")
    return np.asarray(lfilter(np.ravel(discrete[0]), discrete[1], accelerations, axis=0))


def rippled(execution: Execution, disturbances: Disturbances, seed: int) -> Execution:
    """The execution with a ripple of the struts on top, which encoders and sensors both see.

    Args:
        disturbances: rms and band of the ripple, which grows with the speed, as errors of screws and gears make it.
    """
    if disturbances.ripple == 0.0:
        return execution
    from scipy.signal import butter, sosfiltfilt

    t = np.arange(0.0, execution.duration + 2 * RIPPLE_STEP, RIPPLE_STEP)
    inside = np.clip(t, 0.0, execution.duration)
    lengths, speeds = execution.struts(inside), execution.struts(inside, 1)
    draw = np.random.default_rng([seed, 1])
    band = (0.05 * disturbances.strut_velocity_band_Hz, disturbances.strut_velocity_band_Hz)
    sections = butter(3, band, btype="bandpass", fs=1.0 / RIPPLE_STEP, output="sos")
    velocity = sosfiltfilt(sections, draw.normal(size=lengths.shape), axis=0)
    velocity *= disturbances.ripple * speeds / np.sqrt(np.mean(velocity**2, axis=0))
    return DriveExecution.of_log(execution.machine, RIPPLE_STEP, lengths + np.cumsum(velocity, axis=0) * RIPPLE_STEP)


class PoseFields(NamedTuple):
    """Force errors that depend on the pose: two smooth random fields of the machine."""

    platform: Array  # error of each sensor that the platform brings along, shape (n, 6) [N]
    load: Array  # the same for each newton that is mounted, shape (n, 6) [N/N]

    def of(self, weight: float) -> Array:
        """Error of each sensor with something of a weight [N] on the platform, shape (n, 6) [N]."""
        return np.asarray(self.platform + weight * self.load)


def pose_fields(disturbances: Disturbances, home: Array, poses: Array) -> PoseFields:
    """The errors in poses.

    Args:
        home: pose from which the machine's poses are counted, shape (6,) [m, rad].
        poses: shape (n, 6) [m, rad].
    """
    reduced = (poses - home) / _lengths(disturbances)
    fields = []
    for k, size in enumerate((disturbances.pose_error_N, disturbances.pose_error_of_load)):
        draw = np.random.default_rng([disturbances.pose_error_seed, k])
        waves, phases = draw.normal(size=(6, WAVES)), draw.uniform(0.0, 2 * np.pi, (6, WAVES))
        angle = reduced @ waves  # cos(angle + phase) of six phases, by the sum formula: a third of the cosines
        field = np.cos(angle) @ np.cos(phases).T - np.sin(angle) @ np.sin(phases).T
        fields.append(size * np.sqrt(2.0 / WAVES) * field)
    return PoseFields(*fields)


def pose_covariance(disturbances: Disturbances, home: Array, poses: Array, weight: float) -> Array:
    """Covariance over machines of a sensor's error between poses, shape (n, n) [N^2].

    Args:
        home: pose from which the machine's poses are counted, shape (6,) [m, rad].
        poses: shape (n, 6) [m, rad].
        weight: weight of what is on the platform [N].
    """
    reduced = (poses - home) / _lengths(disturbances)
    size = np.sum(reduced**2, axis=1)
    squares = np.maximum(size[:, None] + size - 2.0 * reduced @ reduced.T, 0.0)
    variance = disturbances.pose_error_N**2 + (weight * disturbances.pose_error_of_load) ** 2
    return np.asarray(variance * np.exp(-squares / 2.0))


def _lengths(disturbances: Disturbances) -> Array:
    return np.repeat([disturbances.pose_error_length, disturbances.pose_error_angle], 3)
