"""Sensors in the struts of a hexapod (setup 2x): the structure matrix of its own struts, and what the struts add.

A strut is a tube that turns about its base joint B (universal) and a rod that slides in it and ends in the platform
joint P (ball), both slender: moments of inertia about the strut's own axis do not count. n points from B to P, l is the
length. What counts of a rod is its mass mu, its first moment h from P towards B and its moment of inertia about P; of a
tube its first moment d from B and its moment of inertia about B; of the two moments of inertia the sum k.

A sensor at the drive's end carries the whole rod. Then a rod's mass cannot be separated from a point mass in its
platform joint, and mass, first moments and inertia of the body are those of the platform with the rods lumped there. A
sensor at the platform's end carries the platform alone, with mu as a parameter. A positive force pushes the platform.

Derived from Lagrange's equations; the tests derive them again by automatic differentiation.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property, partial

import casadi as ca
import numpy as np

from cases.base.units import Array
from cases.sensors import StrutSensors
from identification.machines.hexapod import Hexapod
from identification.machines.rotations import rotation
from identification.model.blocks import Block, Parameter, State, StrutState

_Wrench = Callable[[State, StrutState], ca.SX]
"""Force and moment on the platform for a unit of a strut's parameter, shape (6,)."""
SLOW = 1e-3  # [rad/s] below which Coulomb friction of a joint, which has no value at rest, grows with the rate


@dataclass(frozen=True)
class StrutLayout:
    """Sensors in the struts of a hexapod."""

    hexapod: Hexapod
    sensors: StrutSensors  # where in the struts they sit, and nominal values of the struts

    def blocks(self, moving: bool) -> tuple[Block, ...]:
        """What the struts add to the regressor; of standstills no inertia and no friction, and `d` is then d less h."""
        s, at_drive = self.sensors, self.sensors.at == "drive"
        if moving:
            return strut_blocks(at_drive, s.each, s.viscous_friction_Nms is not None, s.coulomb_friction_Nm is not None)
        still = strut_blocks(at_drive, s.each)
        return (*([] if at_drive else still[:1]), still[-1])

    def structure_at(self, pose: ca.SX) -> ca.SX:
        """J^-T at a pose, shape (6, 6)."""
        none, still = ca.SX.zeros(3), ca.SX.zeros(6)
        state = State(none[0], none[1], none, none, none, none, none)
        position, turn = pose[:3], rotation(pose[3:])
        return structure(moving_struts(state, self.hexapod, position, turn, still, still, np.zeros(3)))

    @cached_property
    def structure_at_home(self) -> Array:
        """J^-T where the platform is at home, shape (6, 6)."""
        return np.asarray(ca.DM(self.structure_at(ca.SX(ca.DM(self.hexapod.home)))).full())

    def with_struts(self, body: Mapping[str, float], moving: bool) -> dict[str, float]:
        """Nominal values of all that a model with these blocks has, by name, from those of the body."""
        s = self.sensors
        values = dict(body)
        if s.at == "drive":
            for x, y, z in self.hexapod.platform:
                lumped = {"m": 1.0, "mxC": x, "myC": y, "mzC": z, "I11": y**2 + z**2, "I12": -x * y, "I13": -x * z}
                lumped |= {"I22": x**2 + z**2, "I23": -y * z, "I33": x**2 + y**2}
                for name, value in lumped.items():
                    values[name] = values.get(name, 0.0) + s.rod_mass_kg * float(value)
        (base, joint), (base_torque, joint_torque) = (
            s.viscous_friction_Nms or (0.0, 0.0),
            s.coulomb_friction_Nm or (0.0, 0.0),
        )
        net = s.tube_first_moment_kg_m - (0.0 if moving else s.rod_first_moment_kg_m)
        rods = {"mu": s.rod_mass_kg, "h": s.rod_first_moment_kg_m, "k": s.inertia_kg_m2, "d": net}
        rods |= {"cB": base, "cP": joint, "tB": base_torque, "tP": joint_torque}
        return values | rods | {f"{name}_{k}": value for name, value in rods.items() for k in range(1, 7)}


def moving_struts(
    state: State, hexapod: Hexapod, position: ca.SX, turn: ca.SX, twist: ca.SX, twist_rate: ca.SX, gravity: Array
) -> State:
    """A state with the motion of a hexapod's struts; arguments as of `Model.expression`, all in {B}."""
    velocity, omega, acceleration, alpha = twist[:3], twist[3:], twist_rate[:3], twist_rate[3:]
    struts = []
    for base, joint in zip(hexapod.base, hexapod.platform, strict=True):
        arm = turn @ ca.DM(joint)
        strut = position + arm - ca.DM(base)
        moving = velocity + ca.cross(omega, arm)
        length = ca.norm_2(strut)
        direction = strut / length
        speed = ca.dot(direction, moving)
        at_joint = acceleration + ca.cross(alpha, arm) + ca.cross(omega, ca.cross(omega, arm)) - ca.DM(gravity)
        vectors = (direction, (moving - speed * direction) / length, at_joint)
        n, turning, specific = (turn.T @ vector for vector in vectors)
        struts.append(StrutState(ca.SX(ca.DM(joint)), n, turning, specific, length, speed))
    return state._replace(struts=tuple(struts))


def structure(state: State) -> ca.SX:
    """The columns (n_i; p_i x n_i) in {P}: forces in the struts -> force and moment on the platform, shape (6, 6)."""
    return ca.horzcat(*(_wrench(strut, strut.direction) for strut in state.struts))


def strut_blocks(at_drive: bool, each: bool, viscous: bool = False, coulomb: bool = False) -> tuple[Block, ...]:
    """What the struts add to the regressor.

    Args:
        at_drive: whether sensors sit at the drive's end of the rods; at the platform's end otherwise.
        each: whether every strut has its own parameters; else all struts are alike.
        viscous: whether the joints have viscous friction.
        coulomb: whether the joints have Coulomb friction.
    """
    kinds: list[tuple[str, str, _Wrench]] = [] if at_drive else [("mu", "kg", _rod_mass)]
    kinds += [("h", "kg m", _first_moment_at_drive if at_drive else _first_moment)]
    kinds += [("k", "kg m^2", _inertia), ("d", "kg m", _tube)]
    if viscous:
        kinds += [(f"c{joint}", "N m s", partial(_friction, platform=joint == "P", coulomb=False)) for joint in "BP"]
    if coulomb:
        kinds += [(f"t{joint}", "N m", partial(_friction, platform=joint == "P", coulomb=True)) for joint in "BP"]
    return tuple(_block(name, unit, columns, each) for name, unit, columns in kinds)


def _block(name: str, unit: str, wrench: _Wrench, each: bool) -> Block:
    """The block of wrenches that each strut adds, shape (6, 6), or of their sum."""

    def columns(state: State) -> ca.SX:
        added = ca.horzcat(*(wrench(state, strut) for strut in state.struts))
        return added if each else ca.sum2(added)

    names = [f"{name}_{k}" for k in range(1, 7)] if each else [name]
    return Block(tuple(Parameter(name, unit) for name in names), columns, True)


def _wrench(strut: StrutState, force: ca.SX) -> ca.SX:
    """Force and moment about the origin of {P} of a force in the platform joint, shape (6,)."""
    return ca.vertcat(force, ca.cross(strut.joint, force))


def _across(strut: StrutState, vector: ca.SX) -> ca.SX:
    return vector - strut.direction * ca.dot(strut.direction, vector)


def _bending(state: State, strut: StrutState) -> ca.SX:
    """The part of n'' across the strut, shape (3,) [1/s^2]."""
    return (_across(strut, strut.specific + state.gravity) - 2 * strut.speed * strut.turning) / strut.length


def _rod_mass(_: State, strut: StrutState) -> ca.SX:
    return _wrench(strut, _across(strut, strut.specific))


def _first_moment(state: State, strut: StrutState) -> ca.SX:
    inert = -2 * strut.length * _bending(state, strut) - 2 * strut.speed * strut.turning
    return _wrench(strut, (inert + _across(strut, state.gravity)) / strut.length)


def _first_moment_at_drive(state: State, strut: StrutState) -> ca.SX:
    along = strut.direction * ca.dot(strut.turning, strut.turning)
    return _first_moment(state, strut) + _wrench(strut, along)


def _inertia(state: State, strut: StrutState) -> ca.SX:
    return _wrench(strut, _bending(state, strut) / strut.length)


def _tube(state: State, strut: StrutState) -> ca.SX:
    return _wrench(strut, -_across(strut, state.gravity) / strut.length)


def _friction(state: State, strut: StrutState, platform: bool, coulomb: bool) -> ca.SX:
    """Force and moment on the platform of friction in the strut's joint at the platform, or at the base."""
    rate = ca.cross(strut.direction, strut.turning) - (state.omega if platform else 0)
    moment = -rate / (ca.sqrt(ca.sumsqr(rate) + SLOW**2) if coulomb else 1)
    balance = _wrench(strut, ca.cross(strut.direction, moment) / strut.length)
    return balance + ca.vertcat(ca.SX(3, 1), moment) if platform else balance
