"""Identification models of Table 2, and model 3 with inertia: the regressor A of f_q = A u, (17) and (21).

A model is a list of blocks; planner, estimator and simulation share it.
"""

from dataclasses import dataclass
from functools import cached_property

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike

from cases.base.errors import Code, IdentificationError
from cases.base.units import Array
from cases.schema import Case
from identification.machines.casadi_batch import over_samples
from identification.machines.hexapod import Hexapod
from identification.machines.machine import Kinematics, Machine
from identification.machines.of_case import machine_if_any
from identification.machines.rotations import gibbs, rotation
from identification.model.blocks import (
    ERROR_TERMS,
    INERTIA,
    K1,
    K2,
    MODELS,
    OFFSETS,
    RIGID,
    WRENCH_OFFSETS,
    Block,
    Parameter,
    State,
)
from identification.model.strut_sensors import StrutLayout, moving_struts, structure


@dataclass(frozen=True)
class Model:
    """An identification model of one sensor frame.

    >>> model = hx.Result.load("empty-result").model
    >>> model.number, model.names[:4]
    (9, ['m', 'mxC', 'myC', 'mzC'])
    """

    number: int  # its number in Table 2
    blocks: tuple[Block, ...]  # its blocks, in the order of (17)
    structure: Array  # J^-T of the sensor frame, shape (6, 6)
    gravity: Array  # gravitational acceleration in {B}, shape (3,) [m/s^2]
    whitening: Array | None = None  # root of W that multiplies all rows of A, shape (6, 6); None for W = 1
    machine: Machine | None = None  # machine in whose coordinates motions are planned; None where none are
    # where the sensors sit in the struts: then J^-T depends on the pose, and `structure` is that at home
    struts: StrutLayout | None = None

    @property
    def coordinates(self) -> int:
        """Number n of coordinates of the machine."""
        return self._moved.count

    @property
    def _moved(self) -> Machine:
        if self.machine is None:
            raise IdentificationError(
                problem="motions are planned for machines only",
                remedy="the case has none that moves the sensors",
                code=Code.NOT_SUPPORTED,
            )
        return self.machine

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The components of u, in the order of (17)."""
        return tuple(p for block in self.blocks for p in block.parameters)

    @property
    def names(self) -> list[str]:
        """Names of the parameters."""
        return [p.name for p in self.parameters]

    @property
    def needs_position(self) -> bool:
        """Whether the position of the platform enters, not only its orientation."""
        return K1 in self.blocks or K2 in self.blocks or self.struts is not None

    @property
    def needs_motion(self) -> bool:
        """Whether the model has parameters that no standstill can excite."""
        return INERTIA in self.blocks

    def expression(self, position: ca.SX, turn: ca.SX, motion: ca.SX, motion_rate: ca.SX) -> ca.SX:
        r"""A of (21) for one sample, shape (6, u), written once for planner, estimator and exported code.

        .. math::
            A u = J^T \begin{pmatrix} m s + (S(\alpha) + S(\omega)^2) m c \\
            m c \times s + I \alpha + \omega \times I \omega \end{pmatrix} + f_{q0} + f_K,
            \qquad s = R^T (\dot{v} - g)

        in the axes of {P}: mass m, first moment m c, inertia I about the origin, offsets and elastic deformation, all
        of them linear in u; S(a) b = a x b.

        Args:
            position: origin of {P} in {B}, shape (3,) [m].
            turn: R, shape (3, 3).
            motion: twist in {B}, shape (6,) [m/s, rad/s].
            motion_rate: its time derivative, shape (6,) [m/s^2, rad/s^2].
        """
        gravity, omega, alpha = turn.T @ ca.DM(self.gravity), turn.T @ motion[3:], turn.T @ motion_rate[3:]
        specific = turn.T @ motion_rate[:3] - gravity
        state = State(position[0], position[1], gibbs(turn), gravity, specific, omega, alpha)
        if self.struts is not None:
            state = moving_struts(state, self.struts.hexapod, position, turn, motion, motion_rate, self.gravity)
        return self.at_state(state)

    def at_state(self, state: State) -> ca.SX:
        """A of (21) from what it depends on, shape (6, u)."""
        cartesian = ca.horzcat(ca.SX(6, 0), *(b.columns(state) for b in self.blocks if b.cartesian))
        if not state.struts:
            at_sensors = ca.DM(np.linalg.inv(self.structure)) @ cartesian  # J^T
        else:
            at_sensors = ca.solve(structure(state), cartesian)
        widths = np.cumsum([0, *(len(b.parameters) for b in self.blocks if b.cartesian)])
        through = iter(ca.horzsplit(at_sensors, [int(w) for w in widths]))
        columns = [next(through) if b.cartesian else b.columns(state) for b in self.blocks]
        matrix = ca.horzcat(ca.SX(6, 0), *columns)
        return ca.densify(matrix if self.whitening is None else ca.DM(self.whitening) @ matrix)

    @cached_property
    def regressor(self) -> ca.Function:
        """(position, R column by column, twist, twist rate) -> A."""
        position, turn = ca.SX.sym("position", 3), ca.SX.sym("rotation", 9)
        motion, motion_rate = ca.SX.sym("twist", 6), ca.SX.sym("twist_rate", 6)
        matrix = self.expression(position, ca.reshape(turn, 3, 3), motion, motion_rate)
        return ca.Function("regressor", [position, turn, motion, motion_rate], [matrix], {"cse": True})

    @cached_property
    def pose_regressor(self) -> ca.Function:
        """(pose, twist, twist rate) -> A."""
        pose, motion, motion_rate = (ca.SX.sym(n, 6) for n in ("pose", "twist", "twist_rate"))
        matrix = self.expression(pose[:3], rotation(pose[3:]), motion, motion_rate)
        return ca.Function("pose_regressor", [pose, motion, motion_rate], [matrix], {"cse": True})

    @cached_property
    def pose_forces(self) -> ca.Function:
        """(pose, twist, twist rate, u) -> A u."""
        pose, motion, motion_rate = (ca.SX.sym(n, 6) for n in ("pose", "twist", "twist_rate"))
        u = ca.SX.sym("u", len(self.parameters))
        forces = self.expression(pose[:3], rotation(pose[3:]), motion, motion_rate) @ u
        return ca.Function("pose_forces", [pose, motion, motion_rate, u], [forces], {"cse": True})

    def structure_at(self, pose: ca.SX) -> ca.SX:
        """J^-T: six sensor forces -> force and moment on the platform in {P}, shape (6, 6)."""
        return ca.SX(ca.DM(self.structure)) if self.struts is None else self.struts.structure_at(pose)

    @cached_property
    def _wrench(self) -> ca.Function:
        pose, forces = ca.SX.sym("pose", 6), ca.SX.sym("forces", 6)
        return ca.Function("wrench", [pose, forces], [self.structure_at(pose) @ forces])

    def wrenches(self, forces: Array, poses: Array | None) -> Array:
        """Force and moment on the platform of sensor forces, about the origin of {P} and in its axes, shapes (n, 6).

        Raises ValueError for sensors in struts without poses [m, rad].
        """
        if self.struts is None:
            return np.asarray(forces @ self.structure.T)
        if poses is None:
            raise ValueError("forces in struts become a force on the platform at known poses only; give poses")
        return over_samples(self._wrench, poses, forces)[0]

    @cached_property
    def coordinate_regressor(self) -> ca.Function:
        """(coordinates, rates, accelerations) -> A, in the coordinates in which motions are planned."""
        state = [ca.SX.sym(name, self.coordinates) for name in ("coordinates", "rates", "accelerations")]
        matrix = self.expression(*self._moved.frame(*state))
        return ca.Function("coordinate_regressor", state, [matrix], {"cse": True})

    def matrices(self, positions: ArrayLike, rotations: ArrayLike, twists: ArrayLike, rates: ArrayLike) -> Array:
        """A for every sample, shape (n, 6, u); arguments as of `expression`, with n rows."""
        columns = np.asarray(rotations, dtype=float).transpose(0, 2, 1).reshape(-1, 9)
        return over_samples(self.regressor, positions, columns, twists, rates)[0]


def regressors(model: Model, kinematics: Kinematics) -> Array:
    """A for every sample of a motion, shape (n, 6, u)."""
    return over_samples(model.pose_regressor, kinematics.pose, kinematics.twist, kinematics.twist_rate)[0]


def expected_forces(model: Model, kinematics: Kinematics, values: Array) -> Array:
    r"""Forces :math:`A u` (23) for every sample of a motion, shape (n, 6) [N, or N and N m]."""
    u = np.broadcast_to(values, (len(kinematics.pose), len(values)))
    return over_samples(model.pose_forces, kinematics.pose, kinematics.twist, kinematics.twist_rate, u)[0]


def full_model(case: Case) -> int:
    """Number in Table 2 of the model with all that a motion of a machine can determine.

    9, without error terms 6; 0, the offsets, in setup 1a, where nothing moves.
    """
    if case.setup == "1a":
        return 0
    machine = machine_if_any(case)
    return RIGID if case.sensor_frame.struts is not None or not (machine is None or machine.elastic) else 9


def static_model(case: Case) -> int:
    """Number in Table 2 of the model with all that standstills of a machine can determine: 5, without error terms 0."""
    return 5 if full_model(case) == 9 else 0


def identification_model(case: Case, number: int) -> Model:
    """The model of Table 2 for the sensor frame of a case.

    Args:
        number: number in Table 2; in setup 1a, where nothing moves, model 0 is the offsets alone.

    Raises:
        IdentificationError: no such model; the message lists what there is.
        CaseError: the case does not say how its force/torque sensor reads.
    """
    case.need_sense()
    if number not in MODELS:
        raise IdentificationError(
            problem=f"model {number} is not one of Table 2",
            remedy=f"choose {', '.join(map(str, MODELS))} (10: model 3 with inertia)",
            code=Code.UNKNOWN,
        )
    blocks = MODELS[number]
    if case.setup == "1a":
        if number != 0:
            raise IdentificationError(
                problem="in setup 1a the sensor frame does not move: only its offsets f_q0 are identified, by model 0",
                remedy="weigh what is put on it with hexcite payload, from a result without and one with it",
                code=Code.NOT_SUPPORTED,
            )
        blocks = (OFFSETS,)
    if case.sensor_frame.has_moments:
        blocks = tuple(WRENCH_OFFSETS if b is OFFSETS else b for b in blocks)
    struts = None
    if case.sensor_frame.struts is not None:
        struts = StrutLayout(Hexapod.of(case), case.sensor_frame.struts)
        blocks = (*blocks, *struts.blocks(INERTIA in blocks))
    frame = case.sensor_frame.structure if struts is None else struts.structure_at_home
    model = Model(number, blocks, frame, case.gravity, machine=machine_if_any(case), struts=struts)
    rigid = struts is not None or not (model.machine is None or model.machine.elastic)
    if rigid and set(model.blocks) & set(ERROR_TERMS):
        raise IdentificationError(
            problem=f"model {number} has error terms (K1 to K5) of sensors in a hexapod's platform",
            remedy=f"with other sensors choose model {RIGID}, or 0 for standstills",
            code=Code.NOT_SUPPORTED,
        )
    return model
