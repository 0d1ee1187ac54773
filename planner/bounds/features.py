"""The information of one state as a quadratic form, and what the states of every motion satisfy on average.

A (21) is affine in 21 features of a state: 1; x, y; the Gibbs vector, gravity, specific acceleration and angular
acceleration in {P}; and the six products of the angular velocity in {P}. So the directional derivative of log det,
d = trace(A F^-1 A^T), is a convex quadratic form y^T Q y of these features y. For given angles the features are affine
in x, y and the six accelerations, and in the six products of the angular rates: y = T(angles) s, s = (1; x, y and
accelerations as shares of their limits; products of the angular rates).

Moment constraints on designs: what every motion from rest to rest satisfies on average, whatever its shape.
Means are time averages over the whole motion; q, v, a are the six coordinates, their rates and accelerations; q counts
from the middle of the box. At both ends v and a are zero; the pose may be another one. Every mean of a derivative of a
quantity that ends with the value it began with is zero:

- mean a_i = 0, for v_i is zero at both ends.
- mean (v_i v_j + q_i a_j) = 0 for every ordered pair, for q_i v_j is zero at both ends.
- mean (v_i a_j + a_i v_j) = 0, for v_i v_j is.

Motions that are closed, ending in the pose and at the velocity in which they began, satisfy the same, for these
products return, and two more:

- mean v_i = 0, for q_i returns.
- mean (q_i v_j + v_i q_j) = 0, for q_i q_j returns.

With a limit J on |a_i'|, a limit A on |a_i| and a limit V on |v_i|:

- mean a_i^2 <= c A^2. Proof: between two zeros of a_i its area is a change of v_i, at most 2 V. Among all courses
  with slopes up to J, heights up to A and a given area S the trapezoid (triangle, where A is not reached) has the
  largest mean square, and that mean square grows with S: take S = 2 V. With r = A / J and h = 2 V / A - r it rises
  for r, holds A for h and falls for r: mean square (h + 2 r / 3) / (h + 2 r) A^2 for h >= 0. For h < 0 the triangle
  has the height sqrt(2 V J) and a third of its square as mean: c = 2 V J / (3 A^2). Both cases agree at h = 0.

The regressor depends on v only through products of the angular rates: a design stays as informative, and satisfies the
constraints that are even in v, when half of its weight moves to the states with -v. There the means that are odd in v
(mean v, mean (q v + v q), mean (v a + a v)) vanish by themselves: these constraints exclude no information matrix.
Rates of x, y, z enter nothing else. What the others demand of the rest, once those rates are eliminated, is

- mean (q_i a_j - q_j a_i) = 0 where i or j is one of x, y, z: both ordered pairs have the same mean of v_i v_j.
- -V_i^2 <= mean q_i a_i <= 0 for x, y, z: it is the mean of -v_i^2.
"""

from dataclasses import dataclass

import casadi as ca
import numpy as np

from cases.schema import Case
from cases.units import Array
from identification.model import Model
from identification.parameters import State
from identification.symbolic import gibbs, over_samples, rotation, twist, twist_rate

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
    middle = np.r_[machine.home.vector + box.pose.mean(axis=0), np.zeros(12)]
    half = np.r_[(box.pose[1] - box.pose[0]) / 2, box.rate, box.acceleration]
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


ANGLES = (3, 4, 5)


def mean_square_share(rate: Array, acceleration: Array, jerk: Array) -> Array:
    """The c of mean a^2 <= c A^2, from the limits V, A, J, all of one shape; see the module."""
    rise = acceleration / jerk
    hold = 2.0 * rate / acceleration - rise
    with np.errstate(invalid="ignore", divide="ignore"):
        trapezoid = (hold + 2.0 * rise / 3.0) / (hold + 2.0 * rise)
        return np.asarray(np.where(hold >= 0.0, trapezoid, 2.0 * rate * jerk / (3.0 * acceleration**2)))


LINEAR, MIXED, RATES, SQUARES, CONSTANT = slice(6), slice(6, 42), slice(42, 51), slice(51, 57), 57  # of `monomials`


def monomials(shares: Array) -> Array:
    """a_j, q_i a_j, v_i v_j of the angles, a_i^2 and 1 of states as shares of the box, shape (n, 58)."""
    q, v, a = shares[:, :6], shares[:, 9:12], shares[:, 12:]
    mixed = (q[:, :, None] * a[:, None, :]).reshape(-1, 36)
    rates = (v[:, :, None] * v[:, None, :]).reshape(-1, 9)
    return np.hstack([a, mixed, rates, a**2, np.ones((len(shares), 1))])


def motion_moments(case: Case, features: Features) -> tuple[Array, Array]:
    """Coefficients of `monomials` whose means over a motion are zero, and whose are at most zero, shapes (m, 58)."""
    limits = case.need_machine("the information limit")[2]
    half = features.half
    product = half[:6, None] * half[None, 12:]  # of q_i a_j
    equal, at_most = [], []

    def row(places: dict[int, float]) -> Array:
        values = np.zeros(58)
        values[list(places)] = list(places.values())
        return values

    equal += [row({i: 1.0}) for i in range(6)]
    for i in range(6):
        for j in range(6):
            first, second = 6 + 6 * i + j, 6 + 6 * j + i
            if i in ANGLES and j in ANGLES:
                rate = half[6 + i] * half[6 + j] / product[i, j]
                equal.append(row({first: 1.0, 42 + 3 * (i - 3) + j - 3: rate}))
            elif i < j:
                size = np.sqrt(product[i, j] * product[j, i])
                equal.append(row({first: product[i, j] / size, second: -product[j, i] / size}))
            elif i == j:
                at_most += [row({first: 1.0}), row({first: -1.0, CONSTANT: -(limits.rate[i] ** 2) / product[i, i]})]
    share = mean_square_share(limits.rate, limits.acceleration, limits.jerk)
    at_most += [row({51 + i: 1.0, CONSTANT: -share[i]}) for i in range(6)]
    return np.array(equal), np.array(at_most)


def lagrangian(moments: tuple[Array, Array], of_equal: Array, of_at_most: Array) -> Array:
    """Multipliers of all constraints as one function of the state, whose mean is at most 0 for every such motion.

    Those of inequalities below 0 are rounding and become 0. It is returned as coefficients of `monomials`, shape (58,).
    """
    return np.asarray(of_equal @ moments[0] + np.maximum(of_at_most, 0.0) @ moments[1])
