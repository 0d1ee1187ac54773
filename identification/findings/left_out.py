"""How the forces of a run change with what its model leaves out; `alternatives` names it, one by one."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from cases.base.phrases import Phrase, phrase
from cases.base.units import DEG, MM, Array, Indices
from cases.machine import MotionLimits
from cases.schema import Case
from identification.machines.casadi_batch import over_samples
from identification.machines.hexapod import Hexapod
from identification.machines.machine import Kinematics
from identification.machines.serial_chain import SerialChain
from identification.model.blocks import RIGID
from identification.model.model import (
    Model,
    expected_forces,
    full_model,
    identification_model,
    regressors,
    static_model,
)
from identification.samples.samples import Fitted, MotionOfSamples, MovingSamples

STEP = 1e-6  # [m, rad and their rates, or a share] for derivatives of what is smooth over metres
FAINT = 1e-4  # of what varies in the forces, below which noise of the drives does not count


class Names(NamedTuple):
    """What a case calls channels, coordinates and drives."""

    channels: tuple[str, ...]
    coordinates: tuple[str, ...]
    drives: tuple[Phrase, ...]
    turns: tuple[bool, ...]  # whether drives are angles

    @classmethod
    def of(cls, case: Case) -> "Names":
        """Those of a case; channels as the file calls them."""
        channels = tuple(case.recording.file_name(name) for name in case.sensor_frame.channels)
        if case.chain is not None:
            turns = tuple(joint.turns for joint in case.chain.joints)
            return cls(channels, case.chain.names, drives_named(case), turns)
        return cls(channels, MotionLimits.labels, drives_named(case), (False,) * 6)


def drives_named(case: Case) -> tuple[Phrase, ...]:
    """Joints of a chain by their names, struts by their numbers."""
    if case.chain is not None:
        return tuple(phrase("joint_named", "joint {name}", name=name) for name in case.chain.names)
    return tuple(phrase("strut_numbered", "strut {number}", number=number) for number in range(1, 7))


@dataclass(frozen=True)
class LeftOut:
    """A fit with the motion of its samples: what alternatives are made of."""

    model: Model
    motion: MotionOfSamples
    values: Array  # u, shape (u,)
    t: Array  # shape (n,) [s]
    moves: bool  # whether the samples are of a motion, and not of standstills
    step: float  # time between samples [s]
    even: Indices  # samples whose neighbours are a step before and after, shape (m,)
    names: Names
    scale: Array | float = 1.0  # what forces and A of each sample are multiplied by in a fit, shape (n,)
    larger: Model | None = None  # a model with more parameters that the machine could be identified by
    columns: Array | None = None  # of the fit in this motion, shape (n, 6, v); None where drives say it
    bars: tuple[Array, Array] | None = None  # lower and upper ends of bars in {P}, shapes (6, 3) [m]
    beyond: Array | float = 0.0  # what channels read of a force from outside, beside the model's, shape (n, 6)

    @classmethod
    def in_use(cls, model: Model, motion: MotionOfSamples, values: Array, beyond: Array, case: Case) -> "LeftOut":
        """A model with its parameters in another motion, at whose samples channels read more than it, shape (n, 6)."""
        times, moves = np.arange(float(len(beyond))), motion.drives is not None
        none = np.zeros(0, dtype=np.int64)
        return cls(model, motion, values, times, moves, 1.0, none, Names.of(case), bars=_ends(case), beyond=beyond)

    @classmethod
    def of(cls, fitted: Fitted, motion: MotionOfSamples, case: Case) -> "LeftOut":
        """What alternatives of a fit are made of."""
        samples = fitted.samples
        even = np.zeros(0, dtype=np.int64)
        step, moves = 1.0, isinstance(samples, MovingSamples)
        if isinstance(samples, MovingSamples):
            close = np.diff(samples.places) == 1
            even, step = 1 + np.flatnonzero(close[1:] & close[:-1]), samples.step
        values = fitted.fit.values[: len(samples.model.names)]
        number = full_model(case) if isinstance(samples, MovingSamples) else static_model(case)
        if motion.by_accelerometer:  # larger models need positions
            number = RIGID
        columns = samples.columns(fitted.at, values, fitted.regression.names)
        larger = identification_model(case, number)
        more = None if set(larger.names) <= set(samples.model.names) else larger
        names = Names.of(case)
        return cls(
            samples.model,
            motion,
            values,
            samples.t,
            moves,
            step,
            even,
            names,
            samples.scale,
            more,
            columns,
            _ends(case),
        )

    @property
    def load(self) -> Kinematics:
        """Motion of {P}."""
        return self.motion.load

    @cached_property
    def turn(self) -> Array:
        """R, shape (n, 3, 3)."""
        return np.asarray(Rotation.from_euler("xyz", self.load.pose[:, 3:]).as_matrix())

    def forces(self, motion: Kinematics) -> Array:
        """Forces of the model in a motion, shape (n, 6)."""
        return expected_forces(self.model, motion, self.values)

    @cached_property
    def expected(self) -> Array:
        """Forces of the model, shape (n, 6)."""
        return self.forces(self.load)

    @cached_property
    def matrices(self) -> Array:
        """A, shape (n, 6, u)."""
        return regressors(self.model, self.load)

    @cached_property
    def of_load(self) -> Array:
        """Forces of the model without the offsets, shape (n, 6)."""
        offsets = [name.startswith("f_q0") for name in self.model.names]
        return np.asarray(self.matrices @ np.where(offsets, 0.0, self.values))

    def regressors(self, names: Sequence[str]) -> Array:
        """Columns of the fit in this motion, weighted, shape (n, 6, v); names: those of parameters and nuisances."""
        if self.columns is not None:
            return self.weighted(self.columns)
        count = len(self.model.names)
        orders = [{"delay": 1, "smoothing": 2}[name] for name in names[count:]]
        more = [self.derivative(self.expected, order)[:, :, None] for order in orders]
        return self.weighted(np.concatenate([self.matrices, *more], axis=2))

    def weighted(self, columns: Array) -> Array:
        """Effects on the forces as a fit sees them, shape (n, 6, k)."""
        return np.asarray(columns * (self.motion.known * self.scale)[:, None, None])

    @cached_property
    def by_place(self) -> Array:
        """How the forces change where the sensor lies further along its axes, shape (n, 6, 3) [1/m]."""
        m, still = self.load, np.zeros((len(self.t), 3))
        omega, alpha = m.twist[:, 3:], m.twist_rate[:, 3:]
        columns = []
        for axis in np.eye(3):
            arm = self.turn @ axis
            swing = np.cross(alpha, arm) + np.cross(omega, np.cross(omega, arm))
            moved = replace(
                m,
                pose=m.pose + STEP * np.hstack([arm, still]),
                twist=m.twist + STEP * np.hstack([np.cross(omega, arm), still]),
                twist_rate=m.twist_rate + STEP * np.hstack([swing, still]),
            )
            columns.append(self.change(moved))
        return np.stack(columns, axis=2)

    def by_links(self, chain: SerialChain) -> Array:
        """How the forces change with the place of each joint but the first, x, y, z each, shape (n, 6, k) [1/m]."""
        drives, m = self.motion.drives, self.load
        assert drives is not None
        (changes,) = over_samples(chain.by_links, *drives)
        moved = [
            replace(
                m,
                pose=m.pose + STEP * _linear(change[:, :3]),
                twist=m.twist + STEP * _linear(change[:, 3:6]),
                twist_rate=m.twist_rate + STEP * _linear(change[:, 6:]),
            )
            for change in changes[:, :, 3:].transpose(2, 0, 1)
        ]
        return np.stack([self.change(motion) for motion in moved], axis=2)

    @cached_property
    def by_axes(self) -> Array:
        """How the forces change where the sensor is turned about its axes, shape (n, 6, 3) [1/rad]."""
        columns = []
        for axis in np.eye(3):
            angles = (Rotation.from_matrix(self.turn) * Rotation.from_rotvec(STEP * axis)).as_euler("xyz")
            columns.append(self.change(replace(self.load, pose=np.hstack([self.load.pose[:, :3], angles]))))
        return np.stack(columns, axis=2)

    @cached_property
    def by_gravity(self) -> tuple[Array, Array]:
        """Three axes, the first along gravity, shape (3, 3), and how the forces change with what gravity has more along
        each of them, as a share of its size, shape (n, 6, 3); none of both where there is no gravity, or where an
        accelerometer measures it.
        """
        gravity = np.zeros(3) if self.motion.by_accelerometer else self.model.gravity
        size, axes = float(np.linalg.norm(gravity)), gravity_axes(gravity)
        columns, m = [np.zeros((len(self.t), 6, 0))], self.load
        for axis in axes:
            other = replace(m, twist_rate=m.twist_rate - STEP * size * np.r_[axis, np.zeros(3)])
            columns.append(self.change(other)[:, :, None])
        return axes, np.concatenate(columns, axis=2)

    @cached_property
    def by_clock(self) -> Array:
        """How the forces change with the rate of the motion's clock, shape (n, 6).

        Accelerations that were measured do not.
        """
        m, powers = self.load, np.repeat([0.0 if self.motion.by_accelerometer else 1.0, 1.0], 3)
        return self.change(
            replace(m, twist=m.twist * (1.0 + STEP), twist_rate=m.twist_rate * (1.0 + 2.0 * STEP * powers))
        )

    def change(self, motion: Kinematics) -> Array:
        """Change of the forces for a unit of what differs by `STEP`, shape (n, 6)."""
        return np.asarray((self.forces(motion) - self.expected) / STEP)

    @cached_property
    def into_channels(self) -> Array:
        """J^T, force and moment on the load in the axes of {P} -> channels, shape (n or 1, 6, 6)."""
        poses = self.load.pose if self.model.struts is not None else None
        rows = 1 if poses is None else len(self.t)
        columns = [self.model.wrenches(np.tile(axis, (rows, 1)), poses) for axis in np.eye(6)]
        return np.asarray(np.linalg.inv(np.stack(columns, axis=2)))

    def pulled(self, forces: Array) -> Array:
        """What channels read of forces on the origin of {P} along x, y and z of {B}, shape (n, 3) -> (n, 6, 3)."""
        local = self.turn.transpose(0, 2, 1) * forces[:, None, :]
        return np.asarray(self.into_channels[:, :, :3] @ local)

    def derivative(self, values: Array, order: int) -> Array:
        """Of series between neighbouring samples, zero where they have none, shape (n, 6)."""
        for _ in range(order // 2):
            values = self._neighbours(values, 1.0, -2.0, 1.0) / self.step**2
        return self._neighbours(values, -0.5, 0.0, 0.5) / self.step if order % 2 else values

    def _neighbours(self, values: Array, before: float, here: float, after: float) -> Array:
        """A weighted sum of each sample and its neighbours, zero where it has none."""
        new, e = np.zeros_like(values), self.even
        new[e] = before * values[e - 1] + here * values[e] + after * values[e + 1]
        return new

    @cached_property
    def by_drives(self) -> tuple[Array, Array, Array] | None:
        """How the forces change with place, speed and acceleration of each drive, shapes (n, 6, k)."""
        drives = self.motion.drives
        if drives is None:
            return None
        still = np.zeros((len(self.t), 6, drives[0].shape[1]))
        place, speed, acceleration = (
            np.stack([self.change(self.motion.moved(*_with(drives, order, k))) for k in range(still.shape[2])], 2)
            if order == 0 or self.moves
            else still
            for order in range(3)
        )
        return place, speed, acceleration

    @cached_property
    def by_scales(self) -> Array:
        """How the forces change with the scale of each drive, about its mean place, shape (n, 6, k)."""
        assert self.by_drives is not None
        assert self.motion.drives is not None
        (place, speed, acceleration), (q, v, a) = self.by_drives, self.motion.drives
        return np.asarray(place * (q - q.mean(axis=0))[:, None] + speed * v[:, None] + acceleration * a[:, None])

    def attenuation(self, w: Array) -> Array | None:
        """Sum of E^T W E u over the samples, E what noise of the drives adds to A on average, shape (u,).

        A^T W f = A^T W (A - E) u: noise of the drives pulls parameters down by F^-1 times that. None where it is not
        known, or too small to count. Noise of their accelerations alone counts, white before the filter.
        """
        drives, noise = self.motion.drives, self.motion.acceleration_noise
        if drives is None or noise is None or self.by_drives is None:
            return None
        total, forces = np.zeros(len(self.values)), np.sqrt(np.mean(self.expected.var(axis=0)))
        if np.sqrt(np.mean((self.by_drives[2] * noise) ** 2)) < FAINT * forces:
            return None
        for k in np.flatnonzero(noise > 0.0).tolist():
            noisy = self.motion.moved(*_with(drives, 2, k))
            change = (regressors(self.model, noisy) - self.matrices) / STEP * noise[k]
            total += np.tensordot(change, (change @ self.values) @ w, ((0, 1), (0, 1)))
        return total

    def by_joints(self, machine: Hexapod, ring: str, ways: Array) -> Array:
        """How the expected forces change where joints of a ring are moved in the case, shape (n, 6, 1).

        Args:
            machine: the hexapod; its struts then seem to have other lengths.
            ring: base or platform.
            ways: how its joints move for 1 m or rad, shape (6, 3).
        """
        assert self.by_drives is not None
        rings = {"base": machine.base, "platform": machine.platform}
        after = self.strut_motion(**(rings | {ring: rings[ring] + STEP * ways}))
        before = self.by_struts
        changes = (
            (by * ((old - new) / STEP)[:, None]).sum(axis=2, keepdims=True)
            for by, old, new in zip(self.by_drives, before, after, strict=True)
        )
        return np.asarray(sum(changes))

    @cached_property
    def by_struts(self) -> tuple[Array, Array, Array]:
        """`strut_motion` of the joints of the machine."""
        machine = self.motion.machine
        assert isinstance(machine, Hexapod)
        return self.strut_motion(machine.base, machine.platform)

    def strut_motion(self, base: Array, platform: Array) -> tuple[Array, Array, Array]:
        """Lengths, speeds and accelerations of struts between joints, shapes (6, 3), in the motion, shapes (n, 6)."""
        arms = platform @ self.turn.transpose(0, 2, 1)
        omega, alpha = self.load.twist[:, None, 3:], self.load.twist_rate[:, None, 3:]
        struts = self.load.pose[:, None, :3] + arms - base
        rates = self.load.twist[:, None, :3] + np.cross(omega, arms)
        bends = self.load.twist_rate[:, None, :3] + np.cross(alpha, arms) + np.cross(omega, np.cross(omega, arms))
        lengths = np.linalg.norm(struts, axis=2)
        speeds = np.sum(struts * rates, axis=2) / lengths
        return lengths, speeds, (np.sum(rates**2 + struts * bends, axis=2) - speeds**2) / lengths


def _ends(case: Case) -> tuple[Array, Array] | None:
    """Lower and upper ends of the bars of a sensor frame that has some."""
    bars = case.sensor_frame.bars
    return None if bars is None else (bars.lower.points, bars.upper.points)


def _linear(vectors: Array) -> Array:
    """Six coordinates of which the last three are 0, shape (n, 3) -> (n, 6)."""
    return np.hstack([vectors, np.zeros_like(vectors)])


def gravity_axes(gravity: Array) -> Array:
    """Three axes, the first along gravity, the others near axes of {B}, shape (3, 3); none where there is no gravity.

    They turn with gravity, and do not leap.
    """
    size = float(np.linalg.norm(gravity))
    if size == 0.0:
        return np.zeros((0, 3))
    along, main = gravity / size, int(np.argmax(np.abs(gravity)))
    second = np.eye(3)[(main + 1) % 3]
    second = second - (second @ along) * along
    second /= np.linalg.norm(second)
    return np.array([along, second, np.sign(along[main]) * np.cross(along, second)])


def structure_of(lower: Array, upper: Array) -> Array:
    """J^-T of bars between points, shape (6, 6)."""
    along = (upper - lower) / np.linalg.norm(upper - lower, axis=1)[:, None]
    return np.vstack([along.T, np.cross(lower, along).T])


def ring_changes(points: Array) -> Iterator[tuple[Phrase, Array, float, str]]:
    """How a ring of three pairs of points can be wrong: what, how they move for 1 m or rad, unit, and its word."""
    centre = points.mean(axis=0)
    arms = (points - centre) * [1.0, 1.0, 0.0]
    radius = np.linalg.norm(arms, axis=1)
    if not radius.all():
        return
    around = np.cross([0.0, 0.0, 1.0], arms)
    angles = np.arctan2(arms[:, 1], arms[:, 0])
    order = np.argsort(angles)
    gaps = np.diff(np.r_[angles[order], angles[order[0]] + 2.0 * np.pi])
    pairs = np.empty(6)
    pairs[order] = (-1.0, 1.0) * 3 if gaps[0::2].sum() < gaps[1::2].sum() else (1.0, -1.0) * 3
    yield phrase("radius", "radius"), arms / radius[:, None], MM, "mm"
    yield phrase("half_angle", "half-angle"), around * pairs[:, None], DEG, "deg"
    yield phrase("height", "height"), np.tile([0.0, 0.0, 1.0], (6, 1)), MM, "mm"


def _with(drives: tuple[Array, Array, Array], order: int, k: int) -> list[Array]:
    """Motion of drives with a little more in one derivative of one of them."""
    moved = list(drives)
    moved[order] = moved[order] + STEP * np.eye(drives[0].shape[1])[k]
    return moved


def in_channel(series: Array, k: int) -> Array:
    """A series, shape (n,), as a column in channel k alone, shape (n, 6, 1)."""
    return np.asarray((series[:, None] * np.eye(6)[k])[:, :, None])
