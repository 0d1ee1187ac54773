"""Between the linear parameters u of (17) and the physical ones: centre of gravity and inertia about it.

I_P = I_PC + m S(xC)^T S(xC), the parallel-axis theorem; the line under (5) prints it with the other sign.

Partial identification (section 4): some parameters are known or left out, the rest is estimated. A known centre of
gravity ties a first moment to the mass, so that u = u0 + B v with the remaining parameters v: the problem stays linear.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike

from cases.base.errors import Code, IdentificationError, choice, option
from cases.base.units import Array, Flags
from cases.sensors import RigidBody, Truth
from identification.model.blocks import FIRST_MOMENT, INERTIA, MASS, OFFSETS, Parameter

if TYPE_CHECKING:
    from identification.model.model import Model


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
            raise IdentificationError(
                problem=f"{name!r} is not a parameter here",
                remedy=choice(name, valid, "choose from"),
                code=Code.UNKNOWN,
            )


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
                problem=f"{name} = {value:g} cannot be a known value",
                remedy="give a finite number, a mass above 0",
                code=Code.OUT_OF_RANGE,
            )
    constants = {**known, **dict.fromkeys(dropped, 0.0)}
    pairs = list(zip(model.names, form, strict=True))
    for linear, physical in pairs:
        if (linear in known) + (physical in known and physical != linear) + (linear in dropped) > 1:
            raise IdentificationError(
                problem=f"{linear} is given twice (as {physical}, or also left out)",
                remedy="give it once",
                code=Code.CONTRADICTION,
            )
    names = tuple(linear for linear, physical in pairs if linear not in constants and physical not in constants)
    if not names:
        raise IdentificationError(
            problem="all parameters are known", remedy="leave at least one to estimate", code=Code.CONTRADICTION
        )
    if "m" in dropped:
        raise IdentificationError(
            problem="m cannot be left out: a body without mass has no centre of gravity",
            remedy="keep it, or give its value where it is known",
            code=Code.CONTRADICTION,
        )
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
                problem=f"{physical} about the centre of gravity cannot be fixed: the problem is not linear",
                remedy=f"fix {linear}, "
                f"about the origin of {{P}}, give it as a prior, or take the non-linear form "
                f"({option('nonlinear', 'estimator nonlinear')})",
                code=Code.NOT_SUPPORTED,
            )
    return np.array(list(rows.values()))
