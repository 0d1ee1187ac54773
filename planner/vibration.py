"""Effect of a structural mode on a planned motion: forces that no identification model contains, and their errors.

A run is evaluated behind a low-pass, with its delay estimated, and its smoothing where the run determines it; the
forces of the vibration pass the same least squares. Steps of acceleration excite a mode more than ramps do, but
carry more information: which of the two is better follows from the errors to be expected of both.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from cases.schema import Case
from identification.criteria import reference_scaling
from identification.hexapod import Hexapod
from identification.model import Model, identification_model, regressors
from identification.motion import Array, Joined, Standstill, Trajectory
from identification.parameters import nominal_parameters, physical_form
from identification.trajectories.executed import Execution, mode_frequency, vibrating
from identification.trajectories.moves import StraightMove, has_steps
from planner.noise import expected_noise
from planner.plan_figures import predicted_std_of

if TYPE_CHECKING:
    from identification.signals import Filter

STEPS, LIMITED_JERK = "steps of acceleration", "limited jerk"  # time laws of moves
LARGE = 1.5  # ratio to the predicted standard deviations from which errors are worth another evaluation
REST = 0.3  # [s] standstill before and after, longer than the filter and most of the ringing


@dataclass(frozen=True, slots=True)
class Vibration:
    """Errors to be expected of a motion on a machine with a structural mode."""

    frequency: float  # frequency of the mode with what is mounted [Hz]
    # errors to be expected of each physical parameter: predicted standard deviation and the error that the mode causes,
    # root of the sum of squares, by name [SI]
    errors: dict[str, float]
    times: float  # errors over predicted standard deviations, geometric mean
    s0: float  # residual of a force sample that identification will report, errors that depend on the pose included [N]

    def over(self, other: "Vibration") -> float:
        """Errors over those of another motion, geometric mean."""
        return mean_ratio(self.errors, other.errors)


def least_shaken(motions: Sequence[tuple[str, Vibration]]) -> tuple[str, ...]:
    """A sentence that names the motion with the smallest errors on a machine with a structural mode; or nothing."""
    if len(motions) < 2 or len({frozenset(v.errors) for _, v in motions}) > 1:
        return ()
    best, least = min(motions, key=lambda pair: pair[1].over(motions[0][1]))
    others = ", ".join(f"{name} {v.over(least):.2f} times as much" for name, v in motions if name != best)
    return (
        f"on a machine with a structural mode at {least.frequency:.3g} Hz (simulation.disturbances) {best} is expected "
        f"to err least: {others}",
    )


def mean_ratio(one: dict[str, float], other: dict[str, float]) -> float:
    """Geometric mean of the ratios of values of the same names."""
    return float(np.exp(np.mean([np.log(one[name] / other[name]) for name in one])))


def with_other_law(motion: Joined, case: Case) -> Joined:
    """The same moves as fast as the limits of the coordinates allow: with the limits of jerk where they had none, and
    without where they had them."""
    box = case.need_motion("planning")[1]
    limits = (box.rate, box.acceleration, *((box.jerk,) if has_steps(motion) else ()))
    parts = [
        StraightMove.fastest(part.start, part.end, *limits) if isinstance(part, StraightMove) else part
        for part in motion.parts
    ]
    return Joined(tuple(parts))


def vibration(case: Case, number: int, motion: Trajectory, payload: int, seconds: float) -> Vibration | None:
    """Errors of a motion on the simulated machine of a case; None where the case states no mode or no filter.

    Args:
        payload: number of payloads that are mounted.
        seconds: measuring time of the white noise: motions are compared at equal time [s].
    """
    cutoff = case.recording.filter_cutoff_Hz
    if cutoff is None or case.simulation is None or case.simulation.disturbances is None:
        return None
    model = identification_model(case, number)
    disturbances = case.simulation.disturbances
    weights = () if case.payloads is None else case.payloads.weights[:payload]
    load = sum(weight.mass_kg for weight in weights)
    frequency = mode_frequency(disturbances, case.simulation.parameters.body.mass_kg, load)
    cycle = case.need_controller("the vibration of a machine").cycle
    noise = expected_noise(case, model, payload)
    u = nominal_parameters(model, case.body(payload))
    still = [Standstill(pose, REST) for pose in motion.at([0.0, motion.duration]).pose]
    run = Joined((still[0], motion, still[1]))
    from identification.signals import Filter  # SciPy, which plans without a mode do without

    low_pass, damping = Filter(cutoff, cycle), disturbances.mode_damping
    columns, added = _evaluated(Hexapod.of(case), model, run, u, low_pass, frequency, damping)
    of_load = load * float(np.linalg.norm(case.gravity)) * disturbances.pose_error_of_load
    by_pose = np.hypot(disturbances.pose_error_N, of_load)
    floor = float(np.sqrt(noise.sensors**2 + by_pose**2 / low_pass.noise_gain))  # slow errors pass the filter whole
    shift, s0 = _shift(columns[:, :-1], added, floor, low_pass)
    if _determines_smoothing(columns, u, s0, low_pass):
        shift, s0 = _shift(columns, added, floor, low_pass)
    shift = shift[: len(u)]
    form, none = physical_form(model), np.zeros((len(u), len(u)))
    errors = form.of(u + shift, none)[0] - form.of(u, none)[0]
    share = float(np.sqrt(motion.duration / seconds))  # of white noise, which averages out over time
    at_equal_time = replace(noise, sensors=share * noise.sensors, channels=share**2 * noise.channels)
    white = predicted_std_of(case, model, reference_scaling(case, model), motion, at_equal_time, payload)
    deviations = {
        p.name: float(np.hypot(white[p.name], error)) for p, error in zip(form.parameters, errors, strict=True)
    }
    return Vibration(frequency, deviations, mean_ratio(deviations, white), s0)


def _determines_smoothing(columns: Array, u: Array, s0: float, low_pass: "Filter") -> bool:
    """Whether identification estimates the smoothing too, by its own rule: differences of evaluated samples decide."""
    from identification.runs.evaluation import SAMPLED  # all of identification, which most plans do without

    step, matrices = low_pass.stride * low_pass.step, columns[:, : len(u)].reshape(-1, 6, len(u))
    expected = matrices @ u
    slope = (expected[2:] - expected[:-2]) / (2.0 * step)
    bend = (expected[2:] - 2.0 * expected[1:-1] + expected[:-2]) / step**2
    rows = np.concatenate([matrices[1:-1], slope[:, :, None], bend[:, :, None]], axis=2)
    triangle = np.asarray(np.linalg.qr(rows.reshape(-1, rows.shape[2]), mode="r"))
    return bool(s0 / np.sqrt(low_pass.stride) < SAMPLED * low_pass.step**2 * abs(triangle[-1, -1]))


def _shift(columns: Array, added: Array, noise: float, low_pass: "Filter") -> tuple[Array, float]:
    """Shift of each unknown by added forces, and the residual of a force sample beside its noise [N]."""
    size = np.linalg.norm(columns, axis=0)
    answer, *_ = np.linalg.lstsq(columns / size, added, rcond=None)
    residuals = added - (columns / size) @ answer
    return answer / size, float(np.sqrt(noise**2 + np.mean(residuals**2) / low_pass.noise_gain))


def _evaluated(
    hexapod: Hexapod, model: Model, run: Joined, u: Array, low_pass: "Filter", frequency: float, damping: float
) -> tuple[Array, Array]:
    """Columns of the least squares, those of delay and smoothing the last two, shape (n, u + 2), and the forces that
    the vibration adds, shape (n,), both of the excitation behind the filter."""
    step = low_pass.step
    t = np.arange(int(np.ceil(run.duration / step)) + 1) * step
    lengths = hexapod.strut_lengths(run.at(np.minimum(t, run.duration)).pose)
    execution = Execution.of_set_points(hexapod, step, lengths)
    t = t[t <= execution.duration]
    struts, kinematics = execution.struts(t), execution.kinematics(t)
    vibrating_motion = replace(kinematics, twist_rate=vibrating(kinematics.twist_rate, step, frequency, damping))
    rigid = regressors(model, kinematics) @ u
    added = low_pass.apply(regressors(model, vibrating_motion) @ u - rigid)
    inside = t[low_pass.margin : -low_pass.margin]
    rows = np.flatnonzero((inside >= REST) & (inside <= run.duration - REST))[:: low_pass.stride]
    matrices = regressors(model, hexapod.kinematics(*(low_pass.apply(struts, order)[rows] for order in range(3))))
    nuisances = [low_pass.apply(rigid, order)[rows, :, None] for order in (1, 2)]
    columns = np.concatenate([matrices, *nuisances], axis=2)
    return columns.reshape(-1, columns.shape[2]), added[rows].ravel()


@dataclass(frozen=True, slots=True)
class BothLaws:
    """Point-to-point moves on a machine with a structural mode, as planned and under the other time law."""

    steps: bool  # whether the accelerations of the plan step; those of the other do not, or the other way round
    own: Vibration
    other: Vibration  # errors of the same moves as fast as the other law allows, at equal measuring time

    @property
    def better(self) -> str:
        """The law with the smaller errors to be expected."""
        return STEPS if self.steps == (self.own.over(self.other) <= 1.0) else LIMITED_JERK

    @property
    def sentence(self) -> str:
        """The comparison in a sentence for people."""
        law, other = (LIMITED_JERK, STEPS)[:: -1 if self.steps else 1]
        text = (
            f"on a machine with a mode at {self.own.frequency:.3g} Hz (simulation.disturbances), errors to be expected "
            f"with {law} are {self.own.times:.2f} times the predicted standard deviations (geometric mean); the same "
            f"moves with {other}, at equal time, would have {1.0 / self.own.over(self.other):.2f} times these errors: "
            f"{self.better} {'is' if self.better == LIMITED_JERK else 'are'} better there"
        )
        if self.steps == (self.better == LIMITED_JERK):
            text += ": plan --family spline, which needs no steps" if self.steps else ": plan --for linuxcnc"
        return text

    def to_json(self) -> dict[str, Any]:
        """Entries of `plan.json`."""
        return {
            "mode_Hz": self.own.frequency,
            "steps": self.steps,
            "expected_errors": self.own.errors,
            "times_predicted_std": self.own.times,
            "s0_N": self.own.s0,
            "other_law_errors": self.other.errors,
            "over_other_law": self.own.over(self.other),
            "better": self.better,
        }


def both_laws(case: Case, number: int, motion: Trajectory, payload: int) -> BothLaws | None:
    """Errors by both time laws of point-to-point moves on a machine that is not stiff.

    None for other motions, and where the case states no mode.
    """
    if not isinstance(motion, Joined) or not all(isinstance(part, StraightMove) for part in motion.parts):
        return None
    own = vibration(case, number, motion, payload, motion.duration)
    other = vibration(case, number, with_other_law(motion, case), payload, motion.duration)
    return None if own is None or other is None else BothLaws(has_steps(motion), own, other)
