"""Recorded runs of machines, sound or damaged, whose truth is known: what findings and deviations are judged by."""

import copy
import tomllib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from scipy.interpolate import PPoly
from scipy.signal import lfilter

from cases.base.units import Flags
from cases.schema import Case
from identification.recording.recording import Recording
from tests.bench.machines.description import case_tables
from tests.bench.machines.designed import DESIGNED
from tests.bench.machines.drawn import drawn
from tests.machines_in_numpy import Array, ChainPlant, HexapodPlant, Motion, Table, plant_of, tables_of

REST = 0.35  # [s] at both ends of a run
BUILT_IN = {"hexapod": 500.0, "ur10_wrist": 500.0, "five_axis_table": 500.0}
"""Built-in machines, and how often their runs here are sampled [1/s]."""
ROBOTS = Path(__file__).parents[1] / "bench" / "robots"
GRIPPER = {
    "mass_kg": 1.7,
    "centre_of_gravity_mm": [6.0, -9.0, 63.0],
    "inertia_kg_m2": [5e-3, 2e-4, -3e-4, 4.6e-3, 1e-4, 3e-3],
}
"""What robots carry here."""
DRAWN = {"desktop": 500.0, "mill": 500.0, "flat": 500.0}


@dataclass(frozen=True)
class Machine:
    """A machine with its case."""

    name: str
    tables: Table
    case: Case
    plant: HexapodPlant | ChainPlant
    rate: float  # samples a second

    @property
    def noise(self) -> Array:
        """Standard deviation of each channel, as the case states it, shape (6,) [N, or N and N m]."""
        return _noise_of(self.tables["simulation"])

    @property
    def limits(self) -> tuple[Array, Array, Array, Array]:
        """Of each coordinate: half of its stroke about home, velocity, acceleration, jerk, shapes (k,) [SI]."""
        motion = self.tables["limits"]["motion"]
        if isinstance(self.plant, HexapodPlant):
            box = [motion[key] for key in ("x_mm", "y_mm", "z_mm", "a_deg", "b_deg", "c_deg")]
            half = np.array([min(-low, high) for low, high in box]) * _SIX
            rates = np.r_[motion["velocity_mm_s"], motion["angular_velocity_deg_s"]] * _SIX
            accelerations = np.r_[motion["acceleration_m_s2"], motion["angular_acceleration_rad_s2"]]
            return half, rates, accelerations, np.r_[motion["jerk_m_s3"], motion["angular_jerk_rad_s3"]]
        rows = [_of_joint(joint) for joint in motion["joints"]]
        half, rates, accelerations, jerks = (np.array(column) for column in zip(*rows, strict=True))
        return half, rates, accelerations, jerks

    @property
    def home(self) -> Array:
        """Coordinates at home, shape (k,)."""
        if isinstance(self.plant, HexapodPlant):
            home = self.tables["machine"]["home"]
            return np.array([home[key] for key in ("x_mm", "y_mm", "z_mm", "a_deg", "b_deg", "c_deg")]) * _SIX
        joints = self.tables["machine"]["chain"]["joints"]
        return np.array([j["home_mm"] * 1e-3 if "home_mm" in j else np.radians(j["home_deg"]) for j in joints])

    @property
    def truth(self) -> dict[str, float]:
        """The true physical parameters by name."""
        return truth_of(self.plant)


def _noise_of(simulation: Table) -> Array:
    force = simulation["force_noise_N"]
    return np.array([force] * 3 + [simulation.get("moment_noise_Nm", force)] * 3)


_SIX = np.array([1e-3] * 3 + [np.pi / 180.0] * 3)


def _of_joint(joint: Table) -> tuple[float, float, float, float]:
    slides = "position_mm" in joint
    low, high = joint["position_mm"] if slides else joint["position_deg"]
    unit = 1e-3 if slides else np.pi / 180.0
    rate = joint["velocity_mm_s"] * 1e-3 if slides else joint["velocity_deg_s"] * np.pi / 180.0
    keys = ("acceleration_m_s2", "jerk_m_s3") if slides else ("acceleration_rad_s2", "jerk_rad_s3")
    return min(-low, high) * unit, rate, joint[keys[0]], joint[keys[1]]


def truth_of(plant: HexapodPlant | ChainPlant) -> dict[str, float]:
    """Physical parameters of a plant's load, its offsets and elasticity, by name."""
    body = plant.body
    values = {"m": body.mass} | {f"{axis}C": float(v) for axis, v in zip("xyz", body.centre, strict=True)}
    values |= {f"IC{i + 1}{j + 1}": float(body.inertia[i, j]) for i in range(3) for j in range(i, 3)}
    values |= {f"f_q0_{k + 1}": float(v) for k, v in enumerate(plant.offsets)}
    if isinstance(plant, HexapodPlant):
        values |= {f"k{k}": float(v) for k, v in enumerate(plant.elasticity)}
    return values


HEXAPOD, CHAIN = "hexapod_", "chain_"  # before the seeds of drawn machines
LENGTHS, LOADS, NOISES = (0.6, 1.5), (0.4, 2.5), (0.3, 3.0)  # of what a chain is drawn from, times what it has


@cache
def machine(name: str) -> Machine:
    """A built-in machine, a hexapod or robot of the bench, or a drawn one, by name: `hexapod_SEED`, `chain_SEED`."""
    if name.startswith(HEXAPOD):
        tables: Mapping[str, Any] = case_tables(name, drawn(int(name.removeprefix(HEXAPOD))))
    elif name.startswith(CHAIN):
        tables = _drawn_chain(int(name.removeprefix(CHAIN)))
    elif (ROBOTS / name).is_dir():
        tables = robot(name)
    else:
        tables = tables_of(name) if name in BUILT_IN else case_tables(name, DESIGNED[name])
    case = Case.model_validate(tables).found_at(name)
    return Machine(name, tables, case, plant_of(tables), (BUILT_IN | DRAWN).get(name, 500.0))


def robot(name: str) -> Table:
    """Tables of one of the bench's robots with a gripper, which can be simulated."""
    tables = tomllib.loads((ROBOTS / name / "case.toml").read_text(encoding="utf-8"))
    tables["simulation"] = {
        "source": "assumed", "encoder_resolution_um": 0.0, "encoder_resolution_mdeg": 1.0, "encoder_rate_Hz": 500.0,
        "force_noise_N": 0.5, "moment_noise_Nm": 0.02, "force_delay_ms": 3.0,
        "parameters": {"offsets_N": [2.1, -4.0, 6.5, 0.2, -0.3, 0.1], "body": GRIPPER},
    }  # fmt: skip
    tables["nominal"] = {**tables.get("nominal", {}), "mass_kg": GRIPPER["mass_kg"]}
    return tables


def _drawn_chain(seed: int) -> Table:
    """A robot or a table like a built-in one, with other links, another sensor, load, and noise."""
    draw = np.random.default_rng(seed)

    def times(low: float, high: float) -> float:
        return float(np.exp(draw.uniform(np.log(low), np.log(high))))

    tables: Any = copy.deepcopy(tables_of(str(draw.choice(["ur10_wrist", "five_axis_table"]))))
    chain, simulation = tables["machine"]["chain"], tables["simulation"]
    for joint in chain["joints"]:
        if "origin_mm" in joint:
            joint["origin_mm"] = [times(*LENGTHS) * v for v in joint["origin_mm"]]
    chain["sensor"]["origin_mm"] = [times(*LENGTHS) * v for v in chain["sensor"]["origin_mm"]]
    size, loudness = times(*LOADS), times(*NOISES)
    body = simulation["parameters"]["body"]
    body["mass_kg"] *= size
    tables["nominal"]["mass_kg"] *= size
    body["inertia_kg_m2"] = [size * v for v in body["inertia_kg_m2"]]
    body["centre_of_gravity_mm"] = [v + float(draw.uniform(-20.0, 20.0)) for v in body["centre_of_gravity_mm"]]
    simulation["parameters"]["offsets_N"] = [float(draw.normal(0.0, 10.0 * v)) for v in _noise_of(simulation)]
    for table in (simulation, tables["sensors"]):
        for key in ("force_noise_N", "moment_noise_Nm"):
            table[key] *= loudness
    return tables


@dataclass(frozen=True)
class Waves:
    """Sums of sines in every coordinate from rest to rest, within the machine's limits."""

    of: Machine
    seed: int
    duration: float = 8.0  # [s], rests included
    size: float = 0.8  # share of the limits

    def __call__(self, t: Array) -> Array:
        """Coordinates at times t, shape (n, k)."""
        half, rates, accelerations, _ = self.of.limits
        draw = np.random.default_rng(self.seed)
        count = len(half)
        span = self.duration - 2 * REST
        frequencies = draw.uniform(0.25, 1.6, (3, count)) * np.minimum(1.0, accelerations / (12.0 * half)) ** 0.5
        phases, weights = draw.uniform(0.0, 2 * np.pi, (3, count)), draw.uniform(0.5, 1.0, (3, count))
        omega = 2 * np.pi * frequencies
        weights = weights / omega**1.5
        most = np.max([weights.sum(0) / half, (weights * omega).sum(0) / rates], axis=0)
        most = np.maximum(most, (weights * omega**2).sum(0) / accelerations)
        weights = self.size * weights / most
        inside = np.clip((t - REST) / span, 0.0, 1.0)
        rise = np.clip(inside * span / 1.0, 0.0, 1.0), np.clip((1.0 - inside) * span / 1.0, 0.0, 1.0)
        window = np.prod([s**4 * (35.0 + s * (-84.0 + s * (70.0 - 20.0 * s))) for s in rise], axis=0)
        waves = np.sum(weights * np.sin(omega * t[:, None, None] + phases), axis=1)
        return np.asarray(self.of.home + window[:, None] * waves)


@dataclass(frozen=True)
class Moves:
    """Moves of seven segments between random places, each with all coordinates at once, from rest to rest."""

    of: Machine
    seed: int
    duration: float = 8.0
    size: float = 0.8

    def __call__(self, t: Array) -> Array:
        """Coordinates at times t, shape (n, k)."""
        return np.asarray(self._path()(np.clip(t, 0.0, self.duration)))

    def _path(self) -> PPoly:
        half, rates, accelerations, jerks = self.of.limits
        draw = np.random.default_rng(self.seed)
        home = self.of.home
        place, at, breaks, pieces = home, REST, [0.0, REST], [_constant(home)]
        while True:
            target = home + self.size * half * draw.uniform(-1.0, 1.0, len(half))
            way = np.abs(target - place)
            share = _SHARE  # of a move that each ramp of acceleration takes
            peak_a = 1.0 / (2 * share * (1 - 2 * share) * (1 - share)) * 2 * share
            needs = [(way / rates / (1 - 2 * share)).max(), np.sqrt((way / accelerations * peak_a).max())]
            needs.append(np.cbrt((way / jerks * peak_a / share).max()))
            length = 1.05 * max(needs) / self.size
            last = at + length > self.duration - REST
            if last:
                break
            starts, laws = _seven(share)
            for start, end, law in zip(starts[:-1], starts[1:], laws, strict=True):
                breaks.append(at + end * length)
                scaled = law / length ** np.arange(3, -1, -1)[:, None]
                pieces.append(scaled * (target - place) + np.array([[0.0], [0.0], [0.0], [1.0]]) * place)
                del start
            place, at = target, at + length
        breaks.append(max(self.duration, at) + 1.0)
        pieces.append(_constant(place))
        return PPoly(np.stack(pieces, axis=1), np.array(breaks))


def reached(of: Machine, way: Waves | Moves) -> bool:
    """Whether struts are long and short enough for a motion, of chains all are, and sensors read what it makes."""
    now = of.plant.motion(way, np.arange(0.0, way.duration, 0.02))
    sensors = of.tables["sensors"]
    most = np.array(
        [sensors.get("range_N", np.inf)] * 3 + [sensors.get("range_Nm", sensors.get("range_N", np.inf))] * 3
    )
    if np.any(np.abs(of.plant.forces(now, 0.0)) > OF_RANGE * most):
        return False
    if not isinstance(of.plant, HexapodPlant):
        return True
    low, high = np.array(of.tables["workspace"]["strut_length_mm"]) * 1e-3
    lengths = of.plant.drives(now.q)
    return bool(np.all((lengths > low) & (lengths < high)))


OF_RANGE = 0.9  # of the sensors, that a motion may use
_SHARE = 0.12


def _constant(place: Array) -> Array:
    return np.vstack([np.zeros((3, len(place))), place])


@cache
def _seven(share: float) -> tuple[Array, list[Array]]:
    """A way of 1 in a time of 1: where its seven segments begin and end, and their cubics, highest power first."""
    lengths = np.array([share, 0.5 - 2 * share - 0.1, share, 0.2, share, 0.5 - 2 * share - 0.1, share])
    jerks = np.array([1.0, 0.0, -1.0, 0.0, -1.0, 0.0, 1.0])
    state, states = np.zeros(3), []
    for length, jerk in zip(lengths, jerks, strict=True):
        states.append((jerk / 6, state[2] / 2, state[1], state[0]))
        s, v, a = state
        state = np.array(
            [
                s + v * length + a * length**2 / 2 + jerk * length**3 / 6,
                v + a * length + jerk * length**2 / 2,
                a + jerk * length,
            ]
        )
    laws = [np.array(law)[:, None] / state[0] for law in states]
    return np.r_[0.0, np.cumsum(lengths)], laws


@dataclass(frozen=True)
class Noise:
    """Noise of the forces, in multiples of what the case states."""

    size: float = 1.0  # of the white part
    memory: float = 0.0  # time over which further noise remembers [s]
    coloured: float = 0.0  # size of that noise
    hum: float = 0.0  # amplitude at 50 Hz
    step: float = 0.0  # of the channels' digits
    encoder: float = 1.0  # multiples of the case's steps of the encoders
    delay: float = 0.002  # by which forces are recorded later [s]


STATED = Noise()
QUIET = Noise(0.0, encoder=0.0, delay=0.0)

Drives = Callable[[Motion, Array, np.random.Generator], Array]


@dataclass(frozen=True)
class Change:
    """What makes a recording differ from that of a sound machine; None changes nothing."""

    plant: HexapodPlant | ChainPlant | None = None  # the machine as it is, where it is not as the case says
    pull: Callable[[Motion], Array] | None = None  # a further wrench on the load, in the axes of {P}, shape (n, 6)
    forces: Callable[[Motion, Array, np.random.Generator], Array] | None = None  # forces before noise -> as measured
    drives: Drives | None = None  # drives as they stand -> as measured
    clock: Callable[[Array], Array] | None = None  # instants -> stamps
    late: Array | float = 0.0  # further delay of each channel, shape (6,) [s]
    truth: dict[str, float] | None = None  # where parameters cannot be those of the plant


SOUND = Change()


def recorded(of: Machine, way: Waves | Moves, seed: int, noise: Noise = STATED, change: Change = SOUND) -> Recording:
    """What a machine records on its way."""
    draw = np.random.default_rng(seed)
    t = np.arange(round(way.duration * of.rate)) / of.rate
    plant = of.plant if change.plant is None else change.plant
    now = plant.motion(way, t)
    drives = plant.drives(now.q)
    lag = noise.delay + change.late
    moments = np.unique(lag)
    forces = np.zeros((len(t), 6))
    for moment in moments:
        then = now if moment == 0.0 else plant.motion(way, t - moment)
        own = plant.forces(then, 0.0 if change.pull is None else change.pull(then))
        if change.forces is not None:
            own = change.forces(then, own, np.random.default_rng([seed, 1]))
        channels = np.broadcast_to(lag, 6) == moment
        forces[:, channels] = own[:, channels]
    if change.drives is not None:
        drives = change.drives(now, drives, draw)
    simulation = of.tables["simulation"]
    steps = (
        np.where(
            _slides(of),
            simulation.get("encoder_resolution_um", 0.0) * 1e-6,
            simulation.get("encoder_resolution_mdeg", 0.0) * np.pi / 180e3,
        )
        * noise.encoder
    )
    drives = np.where(steps > 0.0, np.round(drives / np.maximum(steps, 1e-12)) * steps, drives)
    forces = forces + of.noise * (
        noise.size * draw.normal(size=forces.shape)
        + noise.hum * np.sin(2 * np.pi * 50.0 * t[:, None] + draw.uniform(0.0, 2 * np.pi, 6))
        + noise.coloured * _remembering(draw, len(t), noise.memory * of.rate)
    )
    if noise.step:
        forces = np.round(forces / (noise.step * of.noise)) * noise.step * of.noise
    stamps = t if change.clock is None else change.clock(t)
    return Recording("run.csv", stamps, drives, None, forces, None, case=of.case)


def _slides(of: Machine) -> Flags:
    if isinstance(of.plant, HexapodPlant):
        return np.ones(6, dtype=bool)
    return np.array([joint.slides for joint in of.plant.joints])


def _remembering(draw: np.random.Generator, count: int, steps: float) -> Array:
    """First-order noise of variance 1 that remembers so many samples, shape (n, 6)."""
    if steps <= 0.0:
        return np.zeros((count, 6))
    share, before = np.exp(-1.0 / steps), int(10 * steps) + 1
    white = draw.normal(size=(count + before, 6)) * np.sqrt(1.0 - share**2)
    return np.asarray(lfilter([1.0], [1.0, -share], white, axis=0)[before:])
