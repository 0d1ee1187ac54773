"""Between the linear parameters u of (17) and the physical ones: centre of gravity and inertia about it.

I_P = I_PC + m S(xC)^T S(xC), the parallel-axis theorem; the line under (5) prints it with the other sign.

Partial identification (section 4): some parameters are known or left out, the rest is estimated. A known centre of
gravity ties a first moment to the mass, so that u = u0 + B v with the remaining parameters v: the problem stays linear.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike

from cases.base.errors import IdentificationError, choice
from cases.base.units import Array, Flags
from cases.sensors import RigidBody, Truth

if TYPE_CHECKING:
    from identification.model.model import Model


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


INERTIA_INDEX = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))  # of the six components of an inertia
_CENTRE = (Parameter("xC", "m"), Parameter("yC", "m"), Parameter("zC", "m"))
_CENTRAL_INERTIA = tuple(Parameter(f"IC{i + 1}{j + 1}", "kg m^2") for i, j in INERTIA_INDEX)


@dataclass(frozen=True)
class PhysicalForm:
    """Physical parameters of a model, and the map to them."""

    parameters: tuple[Parameter, ...]  # names and units; mass first, as in u
    map: ca.Function  # u -> (physical parameters, their derivative with respect to u)

    def of(self, linear: ArrayLike, covariance: ArrayLike) -> tuple[Array, Array]:
        """Physical parameters and their covariance, to first order, from those of u, shapes (u,) and (u, u)."""
        values, jacobian = (r.full() for r in self.map(np.asarray(linear, dtype=float)))
        return values[:, 0], jacobian @ np.asarray(covariance) @ jacobian.T


def physical_form(model: "Model") -> PhysicalForm:
    """The physical form of a model's parameters: centre of gravity for first moments, central inertia for inertia."""
    u = ca.SX.sym("u", len(model.parameters))
    physical, parameters = ca.SX(u), list(model.parameters)
    if MASS in model.blocks:  # else offsets alone
        mass, start = model.names.index("m"), model.names.index(FIRST_MOMENT.parameters[0].name)
        first = slice(start, start + 3)
        physical[first], parameters[first] = u[first] / u[mass], _CENTRE
        if INERTIA in model.blocks:
            start = model.names.index(INERTIA.parameters[0].name)
            second = slice(start, start + 6)
            physical[second] -= _parallel_axes(u[mass], physical[first])
            parameters[second] = _CENTRAL_INERTIA
    return PhysicalForm(tuple(parameters), ca.Function("physical", [u], [physical, ca.jacobian(physical, u)]))


def _parallel_axes(mass: ca.SX, centre: ca.SX) -> ca.SX:
    """M S(xC)^T S(xC) in the order of `INERTIA_INDEX`, shape (6,)."""
    square = mass * ca.skew(centre).T @ ca.skew(centre)
    return ca.vertcat(*(square[i, j] for i, j in INERTIA_INDEX))


def body_parameters(body: RigidBody) -> dict[str, float]:
    """The components of u that a rigid body determines, by name."""
    centre = body.centre_of_gravity
    cross = np.array([[0.0, -centre[2], centre[1]], [centre[2], 0.0, -centre[0]], [-centre[1], centre[0], 0.0]])
    inertia = body.inertia + body.mass_kg * cross.T @ cross
    values = {"m": body.mass_kg}
    values |= {f"m{c}C": float(body.mass_kg * v) for c, v in zip("xyz", centre, strict=True)}
    return values | {f"I{i + 1}{j + 1}": float(inertia[i, j]) for i, j in INERTIA_INDEX}


def nominal_parameters(model: "Model", body: RigidBody) -> Array:
    """Nominal parameters u of (17), shape (u,): those of the body and the struts; offsets and error terms are 0."""
    values = _with_struts(model, body)
    return np.array([values.get(name, 0.0) for name in model.names])


def offset_columns(model: "Model") -> list[int]:
    """Places of the offsets f_q0 in u."""
    return [model.names.index(p.name) for p in OFFSETS.parameters]


def _with_struts(model: "Model", body: RigidBody) -> dict[str, float]:
    """Known values of a body, with those of the struts where sensors sit in them, by name."""
    values = body_parameters(body)
    return values if model.struts is None else model.struts.with_struts(values, model.needs_motion)


def linear_parameters(model: "Model", truth: Truth) -> Array:
    """Parameters u of (17) for a simulated machine whose compensation is K5, shape (u,).

    Raises:
        KeyError: the model has parameters (K1, K3, K4) that the simulated machine has no values for.
    """
    factors = truth.compensation
    values = _with_struts(model, truth.body) | {f"f_q0_{k + 1}": v for k, v in enumerate(truth.offsets_N)}
    values |= {"k0": factors.k0_N_m, "k1": factors.k1_Nm_m, "k2": factors.k2_N, "k3": factors.k3_Nm}
    return np.array([values[name] for name in model.names])


_CENTRES = tuple(p.name for p in _CENTRE)


class Selection(NamedTuple):
    """Which parameters of a model are estimated, and how u follows from them: u = offset + basis @ free."""

    names: tuple[str, ...]  # names of the free parameters, in the order of (17)
    offset: Array  # u0, shape (u,)
    basis: Array  # B, shape (u, free)


def require_names(given: Iterable[str], valid: Sequence[str]) -> None:
    """Raises IdentificationError, listing the valid names, where a given name is not among them."""
    for name in given:
        if name not in valid:
            raise IdentificationError(f"{name!r} is not a parameter here; {choice(name, valid, 'choose from')}")


def select(model: "Model", known: Mapping[str, float], dropped: Iterable[str] = ()) -> Selection:
    """Chooses what is estimated.

    Args:
        known: values of parameters by linear name (m, mxC, I11..) or place of the centre of gravity (xC..) [SI], taken
            as exact (uncertain ones, and inertia about the centre of gravity: `priors`).
        dropped: linear parameters whose columns are left out, as if their value were zero.

    Raises:
        IdentificationError: a name that the model does not have, with those that it has; a value that is not finite;
            a parameter given twice; a body without mass; no parameter to estimate.
    """
    form, dropped = [p.name for p in physical_form(model).parameters], tuple(dropped)
    require_names(known, list(dict.fromkeys([*model.names, *form])))
    require_names(dropped, model.names)
    for name, value in known.items():
        if not np.isfinite(value) or (name == "m" and value <= 0.0):
            raise IdentificationError(
                f"{name} = {value:g} cannot be a known value; give a finite number, a mass above 0"
            )
    constants = {**known, **dict.fromkeys(dropped, 0.0)}
    pairs = list(zip(model.names, form, strict=True))
    for linear, physical in pairs:
        if (linear in known) + (physical in known and physical != linear) + (linear in dropped) > 1:
            raise IdentificationError(f"{linear} is given twice (as {physical}, or also left out); give it once")
    names = tuple(linear for linear, physical in pairs if linear not in constants and physical not in constants)
    if not names:
        raise IdentificationError("all parameters are known; leave at least one to estimate")
    if "m" in dropped:
        raise IdentificationError("m cannot be left out: a body without mass has no centre of gravity; choose model 0")
    rows = _rows(pairs, constants, names)
    return Selection(names, rows[:, 0], rows[:, 1:])


def require_physical(model: "Model", known: Iterable[str]) -> None:
    """Raises IdentificationError, with the physical names, for names of known parameters that are not physical."""
    require_names(known, [p.name for p in physical_form(model).parameters])


def tangent_at(model: "Model", physical: Array, fixed: Flags) -> Selection:
    """The local Jacobian of (18) at physical parameters, shape (u,): u = offset + basis @ those that are not fixed.

    Args:
        fixed: which of them are, shape (u,).
    """
    form = physical_form(model)
    u = _linear_of(model)(physical).full()[:, 0]
    basis = np.linalg.inv(form.map(u)[1].full())[:, ~fixed]  # du/dp
    names = tuple(p.name for p, known in zip(form.parameters, fixed, strict=True) if not known)
    return Selection(names, np.asarray(u - basis @ physical[~fixed]), basis)


def _linear_of(model: "Model") -> ca.Function:
    """Physical parameters -> u, the inverse of `physical_form`."""
    p = ca.SX.sym("p", len(model.parameters))
    u = ca.SX(p)
    if MASS in model.blocks:
        mass, start = model.names.index("m"), model.names.index(FIRST_MOMENT.parameters[0].name)
        u[start : start + 3] = p[mass] * p[start : start + 3]
        if INERTIA in model.blocks:
            second = model.names.index(INERTIA.parameters[0].name)
            u[second : second + 6] += _parallel_axes(p[mass], p[start : start + 3])
    return ca.Function("linear", [p], [u])


def _rows(pairs: Sequence[tuple[str, str]], constants: Mapping[str, float], names: Sequence[str]) -> Array:
    """(u0 B), shape (u, 1 + free), built in the order of (17): mass, first moments, inertia."""
    rows: dict[str, Array] = {}
    one = np.eye(1 + len(names))
    for linear, physical in pairs:
        if linear in constants:
            rows[linear] = constants[linear] * one[0]
        elif physical not in constants:
            rows[linear] = one[1 + names.index(linear)]
        elif physical in _CENTRES:
            rows[linear] = constants[physical] * rows["m"]
        else:
            raise IdentificationError(
                f"{physical} about the centre of gravity cannot be fixed: the problem is not linear; fix {linear}, "
                "about the origin of {P}, give it as a prior, or take the non-linear form (--estimator nonlinear)"
            )
    return np.array(list(rows.values()))
