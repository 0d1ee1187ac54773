"""Machines that measure force, in NumPy alone: they share no code with hexcite and are built from the tables of a case.

A plant places the frame of its load for values of its coordinates. Velocities and accelerations follow by central
differences of that function, forces by Newton and Euler, the encoders by geometry.
"""

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Table = Mapping[str, Any]

STEP = 5e-4  # [s] of the central differences
STENCIL = np.arange(-3, 4)
FIRST = np.array([-1.0, 9.0, -45.0, 0.0, 45.0, -9.0, 1.0]) / 60.0
SECOND = np.array([2.0, -27.0, 270.0, -490.0, 270.0, -27.0, 2.0]) / 180.0


def tables_of(case: str) -> Table:
    """The tables of a built-in case's file."""
    path = Path(__file__).parents[1] / "cases" / case / "case.toml"
    return tomllib.loads(path.read_text(encoding="utf-8"))


class Coordinates(Protocol):
    """Coordinates of a machine over time."""

    def __call__(self, t: Array) -> Array:
        """Values at times t, shape (n,) [s], shape (n, k) [m or rad]."""


@dataclass(frozen=True)
class Body:
    """A rigid body in the axes of {P}."""

    mass: float  # [kg]
    centre: Array  # centre of gravity, shape (3,) [m]
    inertia: Array  # about the centre of gravity, shape (3, 3) [kg m^2]

    def wrench(self, specific: Array, omega: Array, alpha: Array) -> Array:
        """Force and moment about the origin that move it, shape (n, 6).

        Args:
            specific: acceleration of the origin less gravity, like the others in the axes of {P}, shape (n, 3).
            omega: angular velocity.
            alpha: angular acceleration.
        """
        swing = np.cross(alpha, self.centre) + np.cross(omega, np.cross(omega, self.centre))
        force = self.mass * (specific + swing)
        spin = alpha @ self.inertia.T + np.cross(omega, omega @ self.inertia.T)
        return np.hstack([force, spin + np.cross(self.centre, force)])

    def and_point(self, mass: float, place: Array) -> "Body":
        """The body with a point mass [kg] fixed at a place, shape (3,) [m]."""
        total = self.mass + mass
        centre = (self.mass * self.centre + mass * place) / total
        inertia = self.inertia.copy()
        for part, where, own in ((self.mass, self.centre, 1.0), (mass, place, 0.0)):
            arm = where - centre
            inertia = inertia + part * (arm @ arm * np.eye(3) - np.outer(arm, arm))
            del own
        return Body(total, centre, inertia)


@dataclass(frozen=True)
class Motion:
    """Motion of {P} at some instants: place in {B}, what moves in the axes of {B}."""

    t: Array  # [s], shape (n,)
    q: Array  # coordinates, shape (n, k)
    q_rate: Array
    p: Array  # shape (n, 3) [m]
    turn: Array  # R, shape (n, 3, 3)
    velocity: Array
    acceleration: Array
    omega: Array
    alpha: Array


def vee(matrices: Array) -> Array:
    """Vectors of skew matrices, shape (n, 3, 3) -> (n, 3)."""
    odd = (matrices - matrices.transpose(0, 2, 1)) / 2.0
    return np.stack([odd[:, 2, 1], odd[:, 0, 2], odd[:, 1, 0]], axis=1)


@dataclass(frozen=True, kw_only=True)
class Plant:
    """A machine with its load; `place` and `channels` are those of a kind of machine."""

    body: Body
    offsets: Array  # what the channels read without a load, shape (6,)
    gravity: Array  # in {B}, shape (3,) [m/s^2]

    def place(self, q: Array) -> tuple[Array, Array]:
        """Origin of {P} in {B} and R at coordinates, shapes (n, 3) and (n, 3, 3)."""
        raise NotImplementedError

    def drives(self, q: Array) -> Array:
        """What the encoders read at coordinates."""
        raise NotImplementedError

    def channels(self, wrench: Array) -> Array:
        """What the sensors read of a force and a moment on the load, about the origin of {P}, shape (n, 6)."""
        raise NotImplementedError

    def motion(self, coordinates: Coordinates, t: Array) -> Motion:
        """The motion of {P} at times t, shape (n,) [s]."""
        around = [coordinates(t + k * STEP) for k in STENCIL]
        places, turns = zip(*(self.place(q) for q in around), strict=True)
        velocity, rate, turning = (
            sum(c * v for c, v in zip(FIRST, values, strict=True)) / STEP for values in (places, around, turns)
        )
        acceleration, bending = (
            sum(c * v for c, v in zip(SECOND, values, strict=True)) / STEP**2 for values in (places, turns)
        )
        back = turns[3].transpose(0, 2, 1)
        omega, alpha = vee(turning @ back), vee(bending @ back)
        return Motion(t, around[3], rate, places[3], turns[3], velocity, acceleration, omega, alpha)

    def wrench(self, motion: Motion, body: Body | None = None) -> Array:
        """Force and moment on the load in the axes of {P}, shape (n, 6)."""
        into = motion.turn.transpose(0, 2, 1)
        specific, omega, alpha = (
            (into @ v[:, :, None])[:, :, 0] for v in (motion.acceleration - self.gravity, motion.omega, motion.alpha)
        )
        return (self.body if body is None else body).wrench(specific, omega, alpha)

    def deformation(self, motion: Motion) -> Array:
        """What the structure's elasticity adds, as a wrench, shape (n, 6); nothing here."""
        return np.zeros((len(motion.t), 6))

    def forces(self, motion: Motion, more: Array | float = 0.0) -> Array:
        """What the sensors read, with a further wrench on the load in the axes of {P}, shape (n, 6)."""
        return self.channels(self.wrench(motion) + self.deformation(motion) + more) + self.offsets


def _turn(axis: Array, angle: Array) -> Array:
    """Rodrigues' rotations about a unit vector by angles, shape (n,), shape (n, 3, 3)."""
    x, y, z = axis
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    s, c = np.sin(angle)[:, None, None], np.cos(angle)[:, None, None]
    return np.eye(3) + s * cross + (1.0 - c) * (cross @ cross)


def _rpy(angles: Array) -> Array:
    """Rz Ry Rx of angles, shape (n, 3) -> (n, 3, 3)."""
    x, y, z = (_turn(axis, angle) for axis, angle in zip(np.eye(3), angles.T, strict=True))
    return z @ y @ x


@dataclass(frozen=True, kw_only=True)
class HexapodPlant(Plant):
    """A hexapod whose platform carries its load by six bars, each with a sensor, or by a six-axis sensor."""

    base: Array  # joints in {B}, shape (6, 3) [m]
    platform: Array  # joints in {P}, shape (6, 3) [m]
    bars: tuple[Array, Array] | None  # lower and upper ends in {P}, shapes (6, 3) [m]
    sense: float  # of a six-axis sensor: -1 where it reads the load's pull
    elasticity: Array  # k0 [N/m], k1 [N m/m], k2 [N], k3 [N m], shape (4,)

    @classmethod
    def of(cls, tables: Table) -> "HexapodPlant":
        """The plant of a case's tables."""
        machine, frame, truth = tables["machine"], tables["sensor_frame"], tables["simulation"]["parameters"]
        bars = frame.get("bars")
        elastic = truth.get("compensation", {})
        return cls(
            body=_body(truth["body"]),
            offsets=np.array(truth["offsets_N"], dtype=float),
            gravity=np.array(tables["gravity_m_s2"], dtype=float),
            base=_joints(machine["base"]),
            platform=_joints(machine["platform"]),
            bars=None if bars is None else (_joints(bars["lower"]), _joints(bars["upper"])),
            sense=-1.0 if frame.get("transducer", {}).get("sense") == "load_on_sensor" else 1.0,
            elasticity=np.array([elastic.get(k, 0.0) for k in ("k0_N_m", "k1_Nm_m", "k2_N", "k3_Nm")]),
        )

    def place(self, q: Array) -> tuple[Array, Array]:
        """The platform's pose: position, and roll, pitch, yaw."""
        return q[:, :3], _rpy(q[:, 3:])

    def drives(self, q: Array) -> Array:
        """The lengths of the struts [m]."""
        p, turn = self.place(q)
        return np.asarray(np.linalg.norm(p[:, None] + self.platform @ turn.transpose(0, 2, 1) - self.base, axis=2))

    def channels(self, wrench: Array) -> Array:
        """Forces of the bars, each along its bar from the lower to the upper end; or the wrench itself."""
        if self.bars is None:
            return self.sense * wrench
        lower, upper = self.bars
        along = upper - lower
        along = along / np.linalg.norm(along, axis=1)[:, None]
        structure = np.vstack([along.T, np.cross(lower, along).T])
        return np.asarray(np.linalg.solve(structure, wrench.T).T)

    def deformation(self, motion: Motion) -> Array:
        """The elastic terms by position and by the Gibbs vector of R, as a wrench."""
        k0, k1, k2, k3 = self.elasticity
        x, y = motion.p[:, 0], motion.p[:, 1]
        odd = vee(motion.turn) * 2.0  # 2 sin(angle) axis
        trace = np.trace(motion.turn, axis1=1, axis2=2)
        phi = odd / (1.0 + trace)[:, None]  # tan(angle / 2) axis
        still = np.zeros(len(x))
        force = [k0 * x - k2 * phi[:, 1], k0 * y + k2 * phi[:, 0], still]
        return np.column_stack([*force, k1 * y + k3 * phi[:, 0], -k1 * x + k3 * phi[:, 1], still])


@dataclass(frozen=True)
class Joint:
    """A joint of a chain: where it stands on the one before it, and its axis."""

    origin: Array  # shape (3,) [m]
    turn: Array  # R, shape (3, 3)
    axis: Array  # unit vector, shape (3,)
    slides: bool


@dataclass(frozen=True, kw_only=True)
class ChainPlant(Plant):
    """A robot or a machine with axes one on the other, with a six-axis sensor at its end."""

    joints: tuple[Joint, ...]
    sensor: tuple[Array, Array]  # where the sensor stands on the last joint: origin, and R
    sense: float
    zeros: Array = field(default_factory=lambda: np.zeros(0))  # errors of the encoders' zeros, shape (k,)

    @classmethod
    def of(cls, tables: Table) -> "ChainPlant":
        """The plant of a case's tables."""
        chain, truth = tables["machine"]["chain"], tables["simulation"]["parameters"]
        return cls(
            body=_body(truth["body"]),
            offsets=np.array(truth["offsets_N"], dtype=float),
            gravity=np.array(tables["gravity_m_s2"], dtype=float),
            joints=tuple(
                Joint(*_frame(j), np.array(j["axis"]) / np.linalg.norm(j["axis"]), j["kind"] == "prismatic")
                for j in chain["joints"]
            ),
            sensor=_frame(chain["sensor"]),
            sense=-1.0 if tables["sensor_frame"]["transducer"]["sense"] == "load_on_sensor" else 1.0,
            zeros=np.zeros(len(chain["joints"])),
        )

    def place(self, q: Array) -> tuple[Array, Array]:
        """The sensor's frame for positions of the joints."""
        p, turn = np.zeros((len(q), 3)), np.broadcast_to(np.eye(3), (len(q), 3, 3))
        for joint, value in zip(self.joints, (q + self.zeros).T, strict=True):
            p, turn = p + turn @ joint.origin, turn @ joint.turn
            if joint.slides:
                p = p + turn @ joint.axis * value[:, None]
            else:
                turn = turn @ _turn(joint.axis, value)
        return p + turn @ self.sensor[0], turn @ self.sensor[1]

    def drives(self, q: Array) -> Array:
        """The positions of the joints [m or rad]."""
        return q

    def channels(self, wrench: Array) -> Array:
        """The wrench itself."""
        return self.sense * wrench


def _ring(ring: Table) -> Array:
    angles = [np.radians(c + s * ring["half_angle_deg"]) for c in ring["pair_centres_deg"] for s in (-1.0, 1.0)]
    height = ring["z_mm"]
    return np.array([[ring["radius_mm"] * np.cos(a), ring["radius_mm"] * np.sin(a), height] for a in angles]) * 1e-3


def _joints(table: Table) -> Array:
    return _ring(table["ring"]) if "ring" in table else np.array(table["points_mm"], dtype=float) * 1e-3


def _frame(table: Table) -> tuple[Array, Array]:
    angles = np.radians(np.array(table.get("rpy_deg", (0.0, 0.0, 0.0)), dtype=float))
    return np.array(table.get("origin_mm", (0.0, 0.0, 0.0)), dtype=float) * 1e-3, _rpy(angles[None])[0]


def _body(table: Table) -> Body:
    xx, xy, xz, yy, yz, zz = table["inertia_kg_m2"]
    inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    return Body(float(table["mass_kg"]), np.array(table["centre_of_gravity_mm"], dtype=float) * 1e-3, inertia)


def plant_of(tables: Table) -> HexapodPlant | ChainPlant:
    """The plant of a case's tables."""
    return ChainPlant.of(tables) if "chain" in tables["machine"] else HexapodPlant.of(tables)
