"""Six kinds of machines and their runs, sound as recorded; made by plants that share no code with hexcite."""

import copy
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from cases.schema import Case
from identification.recording.recording import Recording
from tests.bench.machines.description import Hexapod
from tests.bench.machines.description import case_tables as tables_of_hexapod
from tests.damaged.runs import GRIPPER, Machine, Waves, robot
from tests.machines_in_numpy import Motion, plant_of, tables_of

Array = NDArray[np.float64]
RATE, DURATION, DELAY = 500.0, 6.0, 0.003  # [1/s], [s], [s]
POSES = 36  # standstills of a sensor on a wrist


FOREIGN = Hexapod(
    title="Hexapod drawn by its maker, platform joints below the origin of its platform",
    base=(455.0, 13.0), platform=(185.0, 41.0), home=(0.0, 0.0, 585.0, 0.0, 0.0, 0.0), struts=(520.0, 760.0),
    box=(110.0, 110.0, 60.0, 15.0, 15.0, 18.0),
    rates=(350.0, 55.0), accelerations=(4.0, 7.0), jerks=(80.0, 140.0), drives=(0.6, 8.0),
    frame=(118.0, 146.0, 118.0), range_N=2000.0, mass=38.0, height=170.0, gyration=150.0,
)  # fmt: skip


def _foreign() -> dict[str, Any]:
    tables = copy.deepcopy(tables_of_hexapod("foreign", FOREIGN))
    tables["machine"]["platform"]["ring"]["z_mm"] = -38.0
    for ring in ("base", "platform"):
        tables["machine"][ring]["ring"]["pair_centres_deg"] = [30.0, 150.0, 270.0]
    bars = tables["sensor_frame"]["bars"]
    bars["lower"]["ring"] |= {"z_mm": 14.0, "half_angle_deg": 17.0}
    bars["upper"]["ring"] |= {"z_mm": 131.0, "half_angle_deg": 46.0}
    tables["simulation"] |= {"force_noise_N": 0.8, "encoder_resolution_um": 0.5}
    tables["sensors"] |= {"force_noise_N": 0.8}
    return tables


TABLES: Mapping[str, Callable[[], Mapping[str, Any]]] = {
    "hexapod": lambda: tables_of("hexapod"),
    "foreign": _foreign,
    "ur10_wrist": lambda: tables_of("ur10_wrist"),
    "panda": lambda: robot("panda"),
    "five_axis_table": lambda: tables_of("five_axis_table"),
}
WRIST = "ft_wrist"
NAMES = (*TABLES, WRIST)


@cache
def machine(name: str) -> Machine:
    """A machine that moves, by its name."""
    tables = TABLES[name]()
    return Machine(name, tables, Case.model_validate(tables).found_at(name), plant_of(tables), RATE)


@cache
def wrist_case() -> Case:
    """The sensor on a wrist, whose file has three angles: roll, pitch and yaw."""
    tables = copy.deepcopy(dict(tables_of(WRIST)))
    tables["recording"] = {"columns": {"a_deg": "A", "b_deg": "B", "c_deg": "C"}}
    return Case.model_validate(tables).found_at(WRIST)


@dataclass(frozen=True)
class Run:
    """A sound run, and what its machine did."""

    name: str
    case: Case
    recording: Recording
    motion: Motion | None  # where the machine moved, at the instants of the forces
    weight: Array  # what the sensors read of the load's weight, shape (n, 6)
    turns: Array  # R at the instants of the forces, shape (n, 3, 3)


def run(name: str, seed: int, duration: float = DURATION) -> Run:
    """A sound run of a machine; seeds differ in motion and noise."""
    return _standing(seed) if name == WRIST else _moving(machine(name), seed, duration)


def _moving(of: Machine, seed: int, duration: float) -> Run:
    draw = np.random.default_rng([seed, 7])
    t = np.arange(round(duration * of.rate)) / of.rate
    way = Waves(of, seed, duration)
    drives, late = of.plant.drives(way(t)), of.plant.motion(way, t - DELAY)
    simulation = of.tables["simulation"]
    slides = np.array([joint.slides for joint in getattr(of.plant, "joints", ())] or [True] * 6)
    steps = np.where(
        slides,
        simulation.get("encoder_resolution_um", 0.0) * 1e-6,
        np.radians(simulation.get("encoder_resolution_mdeg", 0.0) * 1e-3),
    )
    drives = np.where(steps > 0.0, np.round(drives / np.maximum(steps, 1e-12)) * steps, drives)
    forces = of.plant.forces(late) + of.noise * draw.normal(size=(len(t), 6))
    standing = replace(late, **{name: np.zeros_like(late.p) for name in ("velocity", "acceleration", "omega", "alpha")})
    weight = of.plant.channels(of.plant.wrench(standing))
    recording = Recording("run.csv", t, drives, None, forces, None, case=of.case)
    return Run(of.name, of.case, recording, late, weight, late.turn)


def _standing(seed: int) -> Run:
    case, draw = wrist_case(), np.random.default_rng([seed, 11])
    angles = np.column_stack(
        [draw.uniform(-np.pi, np.pi, POSES), draw.uniform(-1.3, 1.3, POSES), draw.uniform(-np.pi, np.pi, POSES)]
    )
    turns = Rotation.from_euler("xyz", angles).as_matrix()
    weights = GRIPPER["mass_kg"] * np.einsum("nji,j->ni", turns, np.array(case.gravity))
    centre = np.array(GRIPPER["centre_of_gravity_mm"]) * 1e-3
    weight = np.column_stack([weights, np.cross(centre, weights)])
    offsets = np.array([3.0, -5.0, 8.0, 0.3, -0.2, 0.1])
    forces = weight + offsets + draw.normal(size=weight.shape) * np.repeat([0.04, 2e-3], 3)
    recording = Recording("run.csv", None, None, turns, forces, None, case=case)
    return Run(WRIST, case, recording, None, weight, turns)
