"""Blocks of columns of the regressor, and the models of Table 2 made of them."""

from collections.abc import Callable
from typing import NamedTuple

import casadi as ca


class Parameter(NamedTuple):
    """A component of u: name and SI unit."""

    name: str
    unit: str


class StrutState(NamedTuple):
    """Motion of a strut with the platform, in {P}, as expressions."""

    joint: ca.SX  # platform joint, shape (3,) [m]
    direction: ca.SX  # n from base to platform joint, shape (3,)
    turning: ca.SX  # n', shape (3,) [1/s]
    specific: ca.SX  # acceleration of the platform joint less gravity, shape (3,) [m/s^2]
    length: ca.SX  # l [m]
    speed: ca.SX  # l' [m/s]


class State(NamedTuple):
    """What the regressor of one sample depends on, as expressions."""

    x: ca.SX  # position of the platform along the x axis of {B} [m]
    y: ca.SX  # the same along y [m]
    gibbs: ca.SX  # Gibbs vector of R, shape (3,) [-]
    gravity: ca.SX  # gravitational acceleration in {P}, shape (3,) [m/s^2]
    specific: ca.SX  # acceleration of the origin of {P} less gravity, in {P}, shape (3,) [m/s^2]
    omega: ca.SX  # angular velocity in {P}, shape (3,) [rad/s]
    alpha: ca.SX  # angular acceleration in {P}, shape (3,) [rad/s^2]
    struts: tuple[StrutState, ...] = ()  # none where the sensors do not sit in them


class Block(NamedTuple):
    """Columns of the regressor that belong together.

    Equations (12) to (15), (19), (20) and (22), written once as CasADi expressions; a model chooses among them. Units
    of the compensation factors: CONVENTIONS (the paper's "N/mm" must read N/m).
    """

    parameters: tuple[Parameter, ...]  # one for each column
    # state -> forces and moments on the platform (Cartesian) or at the sensors, shape (6, columns)
    columns: Callable[[State], ca.SX]
    cartesian: bool  # whether `columns` still has to go through J^T to the sensors


def _inertia_operator(omega: ca.SX) -> ca.SX:
    """L of (20): I omega = L(omega) (I11, I12, I13, I22, I23, I33), shape (3, 6)."""
    w1, w2, w3 = omega[0], omega[1], omega[2]
    return ca.vertcat(
        ca.horzcat(w1, w2, w3, 0, 0, 0),
        ca.horzcat(0, w1, 0, w2, w3, 0),
        ca.horzcat(0, 0, w1, 0, w2, w3),
    )


def _first_moment(s: State) -> ca.SX:
    return ca.vertcat(ca.skew(s.alpha) + ca.skew(s.omega) @ ca.skew(s.omega), ca.skew(s.specific).T)


def _inertia(s: State) -> ca.SX:
    return ca.vertcat(ca.SX.zeros(3, 6), _inertia_operator(s.alpha) + ca.skew(s.omega) @ _inertia_operator(s.omega))


def _along_axes(x: ca.SX, y: ca.SX, moment_x: ca.SX, moment_y: ca.SX) -> ca.SX:
    """A column of forces and one of moments, in the plane of {P}, shape (6, 2)."""
    return ca.horzcat(ca.vertcat(x, y, 0, 0, 0, 0), ca.vertcat(0, 0, 0, moment_x, moment_y, 0))


def _per_sensor(letter: str, columns: str, unit: str, of_each: Callable[[State], ca.SX]) -> Block:
    """A block of factors of its own for each sensor: `of_each` of the state, shape (1, columns)."""
    names = (f"{letter}_{sensor}{c}" for sensor in range(1, 7) for c in columns)
    return Block(tuple(Parameter(n, unit) for n in names), lambda s: ca.kron(ca.SX.eye(6), of_each(s)), False)


# the columns of (19)
MASS = Block((Parameter("m", "kg"),), lambda s: ca.vertcat(s.specific, ca.SX.zeros(3)), True)


FIRST_MOMENT = Block(tuple(Parameter(f"m{c}C", "kg m") for c in "xyz"), _first_moment, True)


INERTIA = Block(tuple(Parameter(f"I{c}", "kg m^2") for c in ("11", "12", "13", "22", "23", "33")), _inertia, True)


OFFSETS = Block(tuple(Parameter(f"f_q0_{k}", "N") for k in range(1, 7)), lambda _: ca.SX.eye(6), False)


K1 = _per_sensor("K1", "xy", "N/m", lambda s: ca.horzcat(s.x, s.y))  # (12)


K2 = Block(  # (22); (13) has the other sign for k1
    (Parameter("k0", "N/m"), Parameter("k1", "N m/m")), lambda s: _along_axes(s.x, s.y, s.y, -s.x), True
)


K3 = _per_sensor("K3", "xyz", "N s^2/m", lambda s: s.gravity.T)  # the rotation-matrix form that section 3 warns of


K4 = _per_sensor("K4", "xyz", "N", lambda s: s.gibbs.T)  # (14)


K5 = Block(  # (15)
    (Parameter("k2", "N"), Parameter("k3", "N m")),
    lambda s: _along_axes(-s.gibbs[1], s.gibbs[0], s.gibbs[0], s.gibbs[1]),
    True,
)


# A force/torque sensor's last three channels are moments.
WRENCH_OFFSETS = OFFSETS._replace(
    parameters=tuple(Parameter(p.name, "N" if k < 3 else "N m") for k, p in enumerate(OFFSETS.parameters))
)


RIGID = 6  # the model of a rigid body and offsets


_STATIC = (MASS, FIRST_MOMENT, OFFSETS)


_DYNAMIC = (MASS, FIRST_MOMENT, INERTIA, OFFSETS)


# Table 2; models 4 and 8 have 18 orientation factors (K4), as their counts say. 10 is not in the table: model 3 with
# inertia, which motions determine (section 5)
MODELS: dict[int, tuple[Block, ...]] = {
    0: _STATIC,
    1: (*_STATIC, K1),
    2: (*_STATIC, K2),
    3: (*_STATIC, K2, K3),
    4: (*_STATIC, K2, K4),
    5: (*_STATIC, K2, K5),
    6: _DYNAMIC,
    7: (*_DYNAMIC, K2),
    8: (*_DYNAMIC, K2, K4),
    9: (*_DYNAMIC, K2, K5),
    10: (*_DYNAMIC, K2, K3),
}


ERROR_TERMS = (K1, K2, K3, K4, K5)
"""Forms of the error compensation, (10) to (15)."""
