"""Between the linear parameters u of (17) and the physical ones: centre of gravity and inertia about it.

I_P = I_PC + m S(xC)^T S(xC), the parallel-axis theorem; the line under (5) prints it with the other sign.
"""

from dataclasses import dataclass

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike, NDArray

from cases.sensors import RigidBody, Truth
from identification.model import Model
from identification.pose import skew
from identification.regressor_blocks import FIRST_MOMENT, INERTIA, MASS, Parameter

Array = NDArray[np.float64]

_INERTIA_INDEX = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))
_CENTRE = (Parameter("xC", "m"), Parameter("yC", "m"), Parameter("zC", "m"))
_CENTRAL_INERTIA = tuple(Parameter(f"IC{i + 1}{j + 1}", "kg m^2") for i, j in _INERTIA_INDEX)


@dataclass(frozen=True)
class PhysicalForm:
    """Physical parameters of a model and the map to them."""

    parameters: tuple[Parameter, ...]  # names and units; mass first, as in u
    map: ca.Function  # u -> (physical parameters, their derivative with respect to u)

    def of(self, linear: ArrayLike, covariance: ArrayLike) -> tuple[Array, Array]:
        """Physical parameters and their covariance, propagated to first order.

        Args:
            linear: u, shape (u,).
            covariance: covariance of u, shape (u, u).
        """
        values, jacobian = (r.full() for r in self.map(np.asarray(linear, dtype=float)))
        return values[:, 0], jacobian @ np.asarray(covariance) @ jacobian.T


def physical_form(model: Model) -> PhysicalForm:
    """The physical form of a model's parameters: centre of gravity for first moments, central inertia for inertia."""
    u = ca.SX.sym("u", len(model.parameters))
    if MASS not in model.blocks:  # offsets alone
        return PhysicalForm(model.parameters, ca.Function("physical", [u], [u, ca.SX.eye(len(model.parameters))]))
    mass = u[model.names.index(MASS.parameters[0].name)]
    first = model.names.index(FIRST_MOMENT.parameters[0].name)
    centre = u[first : first + 3] / mass
    values: list[ca.SX] = []
    parameters: list[Parameter] = []
    start = 0
    for block in model.blocks:
        part = u[start : start + len(block.parameters)]
        start += len(block.parameters)
        if block is FIRST_MOMENT:
            values.append(centre)
            parameters += _CENTRE
        elif block is INERTIA:
            steiner = mass * skew(centre).T @ skew(centre)
            values.append(part - ca.vertcat(*(steiner[i, j] for i, j in _INERTIA_INDEX)))
            parameters += _CENTRAL_INERTIA
        else:
            values.append(part)
            parameters += block.parameters
    physical = ca.vertcat(*values)
    return PhysicalForm(tuple(parameters), ca.Function("physical", [u], [physical, ca.jacobian(physical, u)]))


def body_parameters(body: RigidBody) -> dict[str, float]:
    """The components of u that a rigid body determines, by name."""
    centre = body.centre_of_gravity
    cross = np.array([[0.0, -centre[2], centre[1]], [centre[2], 0.0, -centre[0]], [-centre[1], centre[0], 0.0]])
    inertia = body.inertia + body.mass_kg * cross.T @ cross
    known = {"m": body.mass_kg}
    known |= {f"m{c}C": float(body.mass_kg * v) for c, v in zip("xyz", centre, strict=True)}
    return known | {f"I{i + 1}{j + 1}": float(inertia[i, j]) for i, j in _INERTIA_INDEX}


def nominal_parameters(model: Model, body: RigidBody) -> Array:
    """U of (17) with what is known before a run, shape (u,): the body and the struts; offsets and error terms are 0."""
    known = with_struts(model, body_parameters(body))
    return np.array([known.get(name, 0.0) for name in model.names])


def with_struts(model: Model, body: dict[str, float]) -> dict[str, float]:
    """What is known of a body, with what the struts add where sensors sit in them, by name."""
    return body if model.struts is None else model.struts.with_struts(body, model.needs_motion)


def linear_parameters(model: Model, truth: Truth) -> Array:
    """U of (17) for a simulated machine whose compensation is K5, shape (u,).

    Raises:
        KeyError: the model has parameters (K1, K3, K4) that the simulated machine has no values for.
    """
    factors = truth.compensation
    known = with_struts(model, body_parameters(truth.body)) | {
        f"f_q0_{k + 1}": v for k, v in enumerate(truth.offsets_N)
    }
    known |= {"k0": factors.k0_N_m, "k1": factors.k1_Nm_m, "k2": factors.k2_N, "k3": factors.k3_Nm}
    return np.array([known[name] for name in model.names])
