"""The information of one state as a quadratic form of features.

A (21) is affine in 21 features of a state: 1; x, y; the Gibbs vector, gravity, specific acceleration and angular
acceleration in {P}; and the six products of the angular velocity in {P}. So the directional derivative of log det,
d = trace(A F^-1 A^T), is a convex quadratic form y^T Q y of these features y. For given angles the features are affine
in x, y and the six accelerations, and in the six products of the angular rates: y = T(angles) s, s = (1; x, y and
accelerations as shares of their limits; products of the angular rates).
"""

from dataclasses import dataclass

import casadi as ca
import numpy as np

from cases.base.units import Array
from cases.schema import Case
from identification.machines.casadi_batch import over_samples
from identification.machines.rotations import gibbs, rotation, twist, twist_rate
from identification.model.blocks import State
from identification.model.model import Model

PAIRS = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))  # products of three components, as the features list them
GIBBS = slice(3, 6)
PRODUCTS = slice(15, 21)
CORNER_COORDINATES = (0, 1, *range(12, 18))  # of a state (pose, rates, accelerations): x, y and the accelerations
CORNERS = len(CORNER_COORDINATES)


@dataclass(frozen=True)
class Features:
    """Features of a case and model."""

    coefficients: Array  # W^1/2 A = sum_k y_k coefficients[k], in reference scaling, shape (21, 6, u)
    table: ca.Function  # angles (3,) -> T, shape (21, 15)
    middle: Array  # middle of the box: x, y, z, roll, pitch, yaw, then 12 zeros, shape (18,) [m, rad]
    half: Array  # half widths of the box, shape (18,) [SI]

    def form(self, inverse: Array) -> Array:
        """Q of d = y^T Q y, shape (21, 21).

        Args:
            inverse: F^-1, shape (u, u).
        """
        return np.asarray(np.einsum("kai,ij,laj->kl", self.coefficients, inverse, self.coefficients, optimize=True))

    def tables(self, angles: Array) -> Array:
        """T at angles of shape (n, 3) [rad]; shape (n, 21, 15)."""
        return over_samples(self.table, angles)[0]

    def of(self, shares: Array) -> Array:
        """Features of states given as shares of the half widths of the box, shape (n, 18) -> (n, 21)."""
        states = self.middle + self.half * shares
        rates = states[:, 9:12]
        products = np.column_stack([rates[:, i] * rates[:, j] for i, j in PAIRS])
        s = np.column_stack([np.ones(len(states)), shares[:, CORNER_COORDINATES], products])
        return np.asarray(np.einsum("nij,nj->ni", self.tables(states[:, 3:6]), s))

    def matrices(self, shares: Array) -> Array:
        """A in reference scaling of states given as shares, shape (n, 6, u)."""
        return np.asarray(np.einsum("nk,kai->nai", self.of(shares), self.coefficients, optimize=True))


def box_features(case: Case, model: Model, scaling: Array) -> Features:
    """The features of a case and model, in a reference scaling of shape (u,)."""
    machine, _, box = case.need_machine("the information limit")
    middle = np.r_[machine.home.vector + box.coordinates.mean(axis=0), np.zeros(12)]
    half = np.r_[(box.coordinates[1] - box.coordinates[0]) / 2, box.rate, box.acceleration]
    return Features(_coefficients(model) * scaling, _table(model, middle, half), middle, half)


def _coefficients(model: Model) -> Array:
    """Coefficients of the features, computed by evaluating A where single features are 1."""
    vector = ca.SX.sym("features", 17)  # x, y, then five vectors, the angular velocity last
    x, y, orientation, gravity, specific, alpha, omega = ca.vertsplit(vector, [0, 1, 2, 5, 8, 11, 14, 17])
    matrix = model.at_state(State(x, y, orientation, gravity, specific, omega, alpha))
    function = ca.Function("at_features", [vector], [matrix])
    corners = np.vstack([np.eye(17), *((np.eye(17)[14 + i] + np.eye(17)[14 + j])[None] for i, j in PAIRS)])
    constant, *values = over_samples(function, np.vstack([np.zeros(17), corners]))[0]
    single = np.array(values[:17]) - constant
    products = [
        single[14 + i] if i == j else values[17 + k] - constant - single[14 + i] - single[14 + j]
        for k, (i, j) in enumerate(PAIRS)
    ]
    return np.array([constant, *single[:14], *products])


def _table(model: Model, middle: Array, half: Array) -> ca.Function:
    """The function T(angles): derivatives of the features with respect to the quantities in which they are affine."""
    angles, corner, rates = ca.SX.sym("angles", 3), ca.SX.sym("corner", CORNERS), ca.SX.sym("rates", 3)
    x, y = (middle[k] + half[k] * corner[k] for k in (0, 1))
    pose = ca.vertcat(x, y, 0, angles)
    every_rate = ca.vertcat(ca.SX.zeros(3), rates)
    turn, gravity = rotation(angles), ca.DM(model.gravity)
    omega = turn.T @ twist(pose, every_rate)[3:]
    motion_rate = twist_rate(pose, every_rate, ca.DM(half[12:]) * corner[2:])
    features = ca.vertcat(
        1, x, y, gibbs(turn), turn.T @ gravity, turn.T @ (motion_rate[:3] - gravity), turn.T @ motion_rate[3:],
        *[omega[i] * omega[j] for i, j in PAIRS],
    )  # fmt: skip
    still = (ca.vertcat(corner, rates), ca.DM.zeros(CORNERS + 3))
    columns = [features, ca.jacobian(features, corner)]
    for i, j in PAIRS:
        second = ca.jacobian(ca.jacobian(features, rates[i]), rates[j])
        columns.append(second / 2 if i == j else second)
    return ca.Function("table", [angles], [ca.densify(ca.substitute(ca.horzcat(*columns), *still))], {"cse": True})
