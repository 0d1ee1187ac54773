"""CasADi functions over many samples at once, orientations as CasADi expressions, and machines made of both.

Few samples go through CasADi's own interpreter: `Function.map` with `.full()` costs five times the evaluation itself, a
FunctionBuffer costs nothing on top. Of many samples each instruction of the function is one NumPy operation on a few
thousand of them, which is three to eight times as fast: the interpreter's overhead is paid once for all of them.
CasADi is column-major: one column a sample, so that memory order equals NumPy's rows.

A machine leads from its coordinates to the frame that carries the load. Coordinates are what motions are planned in,
drives what encoders measure: the pose and the struts of a hexapod, for a chain both the positions of its joints. A new
kind of machine is a class with the members of `Machine`, and a line in `model.machine_of`.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Protocol

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike, NDArray

from cases.base.units import Array
from cases.schema import Case
from identification.limits.limit import LimitKind

FrameMotion = tuple[ca.SX, ca.SX, ca.SX, ca.SX]
"""Motion of the frame {P} of the load in {B}: position of its origin [m], R, twist [m/s, rad/s] and twist rate."""
CHUNK = 1000  # samples a call of the interpreter, whose results then stay in the cache of the processor
PART = 6000  # samples that an instruction is executed for at once

_OPERATIONS: dict[int, Callable[..., Any]] = {
    ca.OP_ASSIGN: np.positive, ca.OP_ADD: np.add, ca.OP_SUB: np.subtract, ca.OP_MUL: np.multiply, ca.OP_DIV: np.divide,
    ca.OP_NEG: np.negative, ca.OP_SQ: np.square, ca.OP_SQRT: np.sqrt, ca.OP_INV: np.reciprocal, ca.OP_SIN: np.sin,
    ca.OP_COS: np.cos, ca.OP_ATAN2: np.arctan2, ca.OP_FABS: np.abs, ca.OP_FMIN: np.fmin, ca.OP_FMAX: np.fmax,
}  # fmt: skip
_KNOWN = {*_OPERATIONS, ca.OP_TWICE, ca.OP_CONST, ca.OP_INPUT, ca.OP_OUTPUT}


def over_samples(function: ca.Function, *arguments: ArrayLike) -> list[Array]:
    """Values of a function of dense column vectors, given as arrays of shape (n, length), for each sample.

    One array for each output: shape (n, rows) for vectors, (n, rows, columns) for matrices.
    """
    inputs = [np.ascontiguousarray(a, dtype=float) for a in arguments]
    count = inputs[0].shape[0]
    for k, value in enumerate(inputs):
        if value.shape != (count, function.size1_in(k)):
            raise ValueError(
                f"{function.name()}: input {k} has shape {value.shape}, expected {(count, function.size1_in(k))}"
            )
    # A matrix leaves CasADi column by column: shape (n, columns, rows) in C order, transposed at the end.
    outputs = [np.empty((count, function.size2_out(k), function.size1_out(k))) for k in range(function.n_out())]
    program = _program(function) if count > CHUNK else None
    if program is not None:
        for start in range(0, count, PART):
            _execute(program, [v[start : start + PART] for v in inputs], [r[start : start + PART] for r in outputs])
    else:
        for start in range(0, count, CHUNK):
            stop = min(start + CHUNK, count)
            buffer, evaluate = _mapped(function, stop - start).buffer()
            for k, value in enumerate(inputs):
                buffer.set_arg(k, value[start:stop].data)
            for k, result in enumerate(outputs):
                buffer.set_res(k, result[start:stop].data)
            evaluate()
    return [r[:, 0, :] if r.shape[1] == 1 else r.transpose(0, 2, 1) for r in outputs]


@lru_cache(maxsize=64)
def _mapped(function: ca.Function, count: int) -> ca.Function:
    return function.map(count)


_Program = tuple[tuple[tuple[int, Sequence[int], Sequence[int], float], ...], int]
"""Instructions (operation, inputs, outputs, constant), and how many places their results need."""


@lru_cache(maxsize=64)
def _program(function: ca.Function) -> _Program | None:
    """An SX function as a list; None where an instruction is not known here."""
    if not function.is_a("SXFunction"):
        return None
    count = range(function.n_instructions())
    operations = [function.instruction_id(k) for k in count]
    if not _KNOWN.issuperset(operations):
        return None
    constants = [function.instruction_constant(k) if operations[k] == ca.OP_CONST else 0.0 for k in count]
    operands, targets = (
        [list(of(k)) for k in count] for of in (function.instruction_input, function.instruction_output)
    )
    return tuple(zip(operations, operands, targets, constants, strict=True)), function.sz_w()


def _execute(program: _Program, inputs: list[Array], outputs: list[Array]) -> None:
    """Runs a program for some samples: inputs of shape (n, length), outputs of shape (n, columns, rows)."""
    (instructions, size), count = program, len(inputs[0])
    arguments = [np.ascontiguousarray(v.T) for v in inputs]
    results = [np.zeros((r.shape[1] * r.shape[2], count)) for r in outputs]
    memory = list(np.empty((size, count)))
    places = memory.copy()
    for operation, operands, targets, constant in instructions:
        if operation == ca.OP_OUTPUT:
            results[targets[0]][targets[1]] = places[operands[0]]
            continue
        to = targets[0]
        if operation == ca.OP_INPUT:
            places[to] = arguments[operands[0]][operands[1]]
            continue
        if operation == ca.OP_CONST:
            memory[to].fill(constant)
        elif operation == ca.OP_TWICE:
            np.add(places[operands[0]], places[operands[0]], out=memory[to])
        elif len(operands) == 1:
            _OPERATIONS[operation](places[operands[0]], out=memory[to])
        else:
            _OPERATIONS[operation](places[operands[0]], places[operands[1]], out=memory[to])
        places[to] = memory[to]  # not before: an operand may have stood there
    for result, output in zip(results, outputs, strict=True):
        output.reshape(count, -1)[:] = result.T


def rotation(rpy: ca.SX) -> ca.SX:
    """R = Rz(yaw) Ry(pitch) Rx(roll) of roll, pitch, yaw [rad], shape (3,) -> (3, 3)."""
    sr, cr = ca.sin(rpy[0]), ca.cos(rpy[0])
    sp, cp = ca.sin(rpy[1]), ca.cos(rpy[1])
    sy, cy = ca.sin(rpy[2]), ca.cos(rpy[2])
    return ca.vertcat(
        ca.horzcat(cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr),
        ca.horzcat(sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr),
        ca.horzcat(-sp, cp * sr, cp * cr),
    )


def rate_matrix(rpy: ca.SX) -> ca.SX:
    """The matrix of (39), shape (3, 3): times (roll', pitch', yaw') it is omega in {B}."""
    sp, cp = ca.sin(rpy[1]), ca.cos(rpy[1])
    sy, cy = ca.sin(rpy[2]), ca.cos(rpy[2])
    return ca.vertcat(
        ca.horzcat(cp * cy, -sy, 0),
        ca.horzcat(cp * sy, cy, 0),
        ca.horzcat(-sp, 0, 1),
    )


def twist(pose: ca.SX, rates: ca.SX) -> ca.SX:
    """(37): velocity of the origin of {P} and angular velocity, both in {B}, shape (6,) [m/s, rad/s]."""
    return ca.vertcat(rates[:3], rate_matrix(pose[3:]) @ rates[3:])


def twist_rate(pose: ca.SX, rates: ca.SX, accelerations: ca.SX) -> ca.SX:
    """(38): time derivative of the twist, shape (6,) [m/s^2, rad/s^2]."""
    matrix = rate_matrix(pose[3:])
    matrix_rate = ca.reshape(ca.jtimes(ca.vec(matrix), pose[3:], rates[3:]), 3, 3)
    return ca.vertcat(accelerations[:3], matrix @ accelerations[3:] + matrix_rate @ rates[3:])


def pose_rates(pose: ca.SX, motion: ca.SX) -> ca.SX:
    """Time derivatives of a pose from its twist, shape (6,) [m/s, rad/s]: (37) solved for them."""
    return ca.vertcat(motion[:3], ca.solve(rate_matrix(pose[3:]), motion[3:]))


def gibbs(turn: ca.SX) -> ca.SX:
    """Gibbs vector tan(angle/2) axis of a rotation matrix, shape (3,) [-].

    From R - R^T = 2 sin(angle) S(axis) and tan(angle/2) = sin(angle) / (1 + cos(angle)); singular only at half a turn.
    """
    twice_sine_axis = ca.vertcat(turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1])
    return twice_sine_axis / (1 + turn[0, 0] + turn[1, 1] + turn[2, 2])


def rpy(turn: ca.SX) -> ca.SX:
    """Roll, pitch, yaw of a rotation matrix with |pitch| < 90 degrees, shape (3,) [rad]."""
    return ca.vertcat(
        ca.atan2(turn[2, 1], turn[2, 2]),
        ca.atan2(-turn[2, 0], ca.sqrt(turn[2, 1] ** 2 + turn[2, 2] ** 2)),
        ca.atan2(turn[1, 0], turn[0, 0]),
    )


Share = tuple[LimitKind, int, ca.SX]
"""A limit beside those of the coordinates: its kind, the order of the derivative with which it grows (0 coordinates,
1 rates, 2 accelerations), and the shares that are used; it is satisfied between -1 and 1."""


@dataclass(frozen=True, slots=True)
class Kinematics:
    """Motion of the platform, one row a sample."""

    pose: Array  # (x, y, z, roll, pitch, yaw), shape (n, 6) [m, rad]
    twist: Array  # velocity of the origin of {P} and angular velocity in {B}, shape (n, 6) [m/s, rad/s]
    twist_rate: Array  # its time derivative, shape (n, 6) [m/s^2, rad/s^2]


class Machine(Protocol):
    """A machine that moves the frame of the load."""

    @property
    def count(self) -> int:
        """Number of coordinates n."""

    @property
    def of_pose(self) -> bool:
        """Whether its coordinates are the pose (x, y, z, roll, pitch, yaw) of the load's frame."""

    @property
    def elastic(self) -> bool:
        """Whether its sensors err with the pose as the error terms K1 to K5 say."""

    @property
    def turns(self) -> NDArray[np.bool_]:
        """Which drives measure angles, shape (n,)."""

    def frame(self, coordinates: ca.SX, rates: ca.SX, accelerations: ca.SX, /) -> FrameMotion:
        """Motion of the load's frame from coordinates and their derivatives, shapes (n,)."""

    def shares(self, case: Case, coordinates: ca.SX, rates: ca.SX, accelerations: ca.SX, /) -> list[Share]:
        """Limits of the case beside those of the coordinates, for the search; the proof has its own."""

    def positions(self, coordinates: Array) -> Array:
        """Positions of the origin of the load's frame, shape (k, 3) [m]."""

    def drives(self, coordinates: ArrayLike, /) -> Array:
        """Positions of the drives, which encoders measure, at coordinates, shape (k, n) [m or rad]."""

    def further_drives(
        self, case: Case, coordinates: Array, rates: Array, accelerations: Array, /
    ) -> tuple[list[Array], tuple[Array, Array]]:
        """Rates and accelerations of drives that are not the coordinates, shapes (k, d), and limits of both, (d,)."""

    def coordinates(self, drives: ArrayLike, /) -> Array:
        """The coordinates of measured drives, shapes (k, n) [m or rad]; raises IdentificationError without any."""

    def kinematics(
        self, drives: ArrayLike, velocities: ArrayLike, accelerations: ArrayLike, near: Array | None = None, /
    ) -> Kinematics:
        """Motion of the load's frame from that of the drives, shapes (k, n) [m or rad].

        Poses `near` those of the load's frame, shape (k, 6) [m, rad], are where a search for them may begin.
        Raises IdentificationError where no coordinates have such drives.
        """
