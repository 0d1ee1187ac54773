"""How small a condition number can be: the K-optimal design among those that a motion from rest to rest can have.

Maximise t with t 1 <= F <= 1, F the sum of w_i A_i^T A_i over states i of the motion box, w >= 0 and the moment
constraints of `planner.bounds.features`, which do not depend on the scale of w: K is then t^-1/2. Convex over given
states (Clarabel). With Y and Z the multipliers of both bounds on F, a state has something to give where
trace((Y - Z) A_i^T A_i) less the multipliers of the moments is positive: the largest of these come in, round by round.

The design is attained; the best one may be a little better yet: the states that come in are found by climbing.
"""

import warnings
from importlib import import_module
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cases.schema import Case
from identification.criteria import reference_scaling
from identification.model import identification_model
from planner.bounds.certificate import TightDerivative
from planner.bounds.features import Features, box_features, lagrangian, monomials, motion_moments
from planner.bounds.tight import climbed_from

Array = NDArray[np.float64]

SEED = 0
FIRST_STATES = 1500
LEVELS = (-1.0, -0.5, 0.0, 0.5, 1.0)
IRRELEVANT = slice(6, 9)  # rates of x, y, z
ROUNDS = 12
NEGLIGIBLE = 1e-7  # weights below are dropped
FRESH = 300  # states that come in at once, at most


class _Solved(NamedTuple):
    weights: Array
    condition: float
    inner: Array
    multipliers: Array


def least_condition(case: Case, number: int, rounds: int = ROUNDS) -> float:
    """The smallest condition number, reference scaling, of a design found.

    Args:
        case: gives box and limits.
        number: of the model.
        rounds: of the exchange; each makes it smaller.
    """
    model = identification_model(case, number)
    features = box_features(case, model, reference_scaling(case, model))
    moments, draw = motion_moments(case, features), np.random.default_rng(SEED)
    states = draw.choice(LEVELS, (FIRST_STATES, 18))
    states[:, IRRELEVANT] = 0.0
    solved = _solve(features, moments, states)
    for _ in range(rounds):
        derivative = TightDerivative(features, features.form(solved.inner), solved.multipliers)
        used = solved.weights > NEGLIGIBLE * solved.weights.max()
        climbed, values = climbed_from(derivative, states[used], draw)
        states = np.vstack([states[used], climbed[np.argsort(-values)[:FRESH]]])
        solved = _solve(features, moments, states)
    return solved.condition


def _solve(features: Features, moments: tuple[Array, Array], states: Array) -> _Solved:
    cp: Any = import_module("cvxpy")

    size = features.coefficients.shape[-1]
    matrices = features.matrices(states)
    products = np.einsum("nki,nkj->nij", matrices, matrices, optimize=True).reshape(len(states), -1)
    of_states = monomials(states)
    weights, smallest = cp.Variable(len(states), nonneg=True), cp.Variable()
    information = cp.reshape(products.T @ weights, (size, size), order="C")
    information = (information + information.T) / 2
    bounds = [information >> smallest * np.eye(size), information << np.eye(size)]
    equal = (of_states @ moments[0].T).T @ weights == 0
    at_most = (of_states @ moments[1].T).T @ weights <= 0
    problem = cp.Problem(cp.Maximize(smallest), [*bounds, equal, at_most])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of inaccuracy: what comes out is evaluated anew
        problem.solve(solver=cp.CLARABEL)
    found = np.maximum(weights.value, 0.0)
    eigenvalues = np.linalg.eigvalsh((found @ products).reshape(size, size))
    inner = bounds[0].dual_value - bounds[1].dual_value
    multipliers = lagrangian(moments, equal.dual_value, at_most.dual_value)
    return _Solved(found, float(np.sqrt(eigenvalues[-1] / eigenvalues[0])), (inner + inner.T) / 2, multipliers)
