"""Simulates what sensors and encoders record of an executed motion, with weights mounted and what disturbs a machine.

No inverse crime: forces follow from the continuous motion, and the recording is delayed, sampled between encoder
cycles, quantised and noisy. Ripple, vibration and errors that depend on the pose are in no identification model.
"""

from collections.abc import Sequence
from functools import reduce
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from cases.base.errors import CaseError, Code
from cases.base.units import DEG, MM, Array
from cases.schema import Case
from cases.sensors import Disturbances, RigidBody, Truth, together
from identification.machines.executed import Execution, mode_frequency, rippled, vibrating
from identification.machines.machine import Kinematics
from identification.machines.of_case import machine_of
from identification.model.model import expected_forces, full_model, identification_model
from identification.model.parameters import linear_parameters, physical_form
from identification.model.stated_noise import acceleration_to_force
from identification.recording.recording import Recording

if TYPE_CHECKING:
    from identification.results.estimate import Estimate  # plans simulate, and load nothing of identification

WAVES = 48  # number of waves that make a pose error


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

    Raises CaseError where the case has fewer weights, or no disturbances.
    """
    payloads = () if case.payloads is None else case.payloads.weights
    if not 0 <= weights <= len(payloads):
        raise CaseError(
            file=f"case {case.name}",
            key="payloads.weights",
            problem=f"are {len(payloads)}",
            remedy=f"{weights} cannot be mounted: choose 0 to {len(payloads)}",
            code=Code.OUT_OF_RANGE,
        )
    disturbances = case.need_simulation("a run").disturbances
    if disturbed and disturbances is None:
        case.missing("simulation.disturbances", "a run with disturbances")
    return Circumstances(payloads[:weights], disturbances if disturbed else None)


def loaded_truth(truth: Truth, weights: Sequence[RigidBody]) -> Truth:
    """The parameters of a machine with weights on its platform; offsets and compensation stay."""
    return truth.model_copy(update={"body": reduce(together, weights, truth.body)}) if weights else truth


def pose_fields(disturbances: Disturbances, home: Array, poses: Array) -> Array:
    """Force errors that depend on the pose: two smooth random fields of the machine, shape (2, n, 6).

    The first is that of the platform itself [N], the second that of each newton that is mounted on it. Poses, shape (n,
    6) [m, rad], count from home.
    """
    reduced = (poses - home) / _lengths(disturbances)
    fields = []
    for k, size in enumerate((disturbances.pose_error_N, disturbances.pose_error_of_load)):
        draw = np.random.default_rng([disturbances.pose_error_seed, k])
        waves, phases = draw.normal(size=(6, WAVES)), draw.uniform(0.0, 2 * np.pi, (6, WAVES))
        angle = reduced @ waves  # cos(angle + phase) of six phases, by the sum formula: a third of the cosines
        field = np.cos(angle) @ np.cos(phases).T - np.sin(angle) @ np.sin(phases).T
        fields.append(size * np.sqrt(2.0 / WAVES) * field)
    return np.array(fields)


def _lengths(disturbances: Disturbances) -> Array:
    return np.repeat([disturbances.pose_error_length_mm * MM, disturbances.pose_error_angle_deg * DEG], 3)


def force_parts(case: Case, motion: Kinematics, step: float, around: Circumstances) -> Array:
    """Parts of the true forces of a motion, shape (3, n, 6) [N], whose sum they are.

    (18) of the motion that the drives made at n instants, a step [s] apart, what the vibration of the structure adds,
    and the error that depends on the pose. Raises CaseError where the case describes no simulated machine.
    """
    simulation = case.need_simulation("the simulation of sensor forces")
    model = identification_model(case, full_model(case))
    u = linear_parameters(model, loaded_truth(simulation.parameters, around.weights))
    rigid = expected_forces(model, motion, u)
    disturbances = around.disturbances
    if disturbances is None:
        return np.array([rigid, np.zeros_like(rigid), np.zeros_like(rigid)])
    home = case.need_machine("the simulation of sensor forces")[0].home.vector
    fields = pose_fields(disturbances, home, motion.pose)
    frequency = mode_frequency(disturbances, simulation.parameters.body.mass_kg, around.load)
    vibration = Kinematics(
        motion.pose, motion.twist, vibrating(motion.twist_rate, step, frequency, disturbances.mode_damping)
    )
    weight = around.load * float(np.linalg.norm(case.gravity))
    return np.array([rigid, expected_forces(model, vibration, u) - rigid, fields[0] + weight * fields[1]])


def simulate_recording(
    case: Case,
    execution: Execution,
    trigger_times: Array,
    seed: int,
    source: str = "simulation",
    around: Circumstances = UNDISTURBED,
) -> Recording:
    """What the machine would have recorded of an executed motion.

    Args:
        trigger_times: start and end of each time the trigger was on, shape (k, 2) [s].
        source: name of the recording, for messages.
    """
    simulation = case.need_simulation("the simulation of sensor forces")
    if around.disturbances is not None:
        execution = rippled(execution, around.disturbances, seed)
    step = 1.0 / simulation.encoder_rate_Hz
    t: Array = np.arange(int(np.floor(execution.duration / step + 1e-9)) + 1) * np.float64(step)
    delay = simulation.force_delay + simulation.force_sampling_offset_cycles * step
    struts, motion = execution.drives(t), execution.kinematics(np.clip(t - delay, 0.0, execution.duration))
    forces = force_parts(case, motion, step, around).sum(axis=0)
    draw = np.random.default_rng(seed)
    forces += draw.normal(size=forces.shape) * simulation.force_noise
    if simulation.acceleration_noise.any():
        model = identification_model(case, full_model(case))
        u = linear_parameters(model, loaded_truth(simulation.parameters, around.weights))
        forces += simulation.acceleration_noise * draw.normal(size=forces.shape) @ acceleration_to_force(model, u).T
    trigger = np.zeros(len(t), dtype=bool)
    for start, end in trigger_times:
        trigger |= (t >= start) & (t < end)
    steps = np.where(machine_of(case).turns, simulation.turning_resolution, simulation.encoder_resolution)
    read = np.where(steps > 0.0, np.round(struts / np.where(steps > 0.0, steps, 1.0)) * steps, struts)
    return Recording(source, t, read, None, forces, trigger)


def truth_rows(case: Case, estimate: "Estimate") -> list[dict[str, Any]]:
    """Truth, estimate, reported standard deviation and error of each physical parameter [SI].

    Raises CaseError without a simulation.
    """
    model = estimate.model
    u = linear_parameters(model, case.need_simulation("the comparison with the truth").parameters)
    truth, _ = physical_form(model).of(u, np.zeros((len(u), len(u))))
    rows = []
    for true, (name, value) in zip(truth, estimate.physical.items(), strict=True):
        rows_by_name = {
            "truth": float(true),
            "estimate": value.value,
            "std": value.reported,
            "error": value.value - float(true),
        }
        rows.append({"name": name, "unit": value.unit} | rows_by_name)
    return rows
