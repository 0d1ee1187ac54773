"""The D-optimal design among those that a motion from rest to rest can have: box, moment constraints, a dual bound.

For every design G that meets the constraints, every positive definite F and all multipliers of the constraints, with
h = d - l over the box: trace(F^-1 G) = mean d <= max h, since mean l <= 0. Concavity of log det, and the best factor on
F, give log det G <= log det F + u log(max h / u). Convex optimisation over given states (log det, Clarabel) gives F and
the multipliers; states where h is large come in, until max h is near u. The least bound of all rounds counts.
"""

import warnings
from collections.abc import Callable
from importlib import import_module
from time import process_time
from typing import Any

import numpy as np

from cases.errors import HexciteError
from cases.schema import Case
from cases.units import Array
from planner.bounds.branch import maximise
from planner.bounds.certificate import TightDerivative, first_tight_cells
from planner.bounds.design import Design, climb
from planner.bounds.features import Features, lagrangian, monomials, motion_moments

SEED = 0
FIRST_STATES = 1000
CLIMBERS = 400  # states from which h is climbed in a round
RANDOM = 8000  # states among which these are chosen
SWEEPS = 4
NEGLIGIBLE = 1e-7  # weights below are dropped
ROUNDS = 60
KEPT = 0.6  # share of the best dual point so far in the next one: without it the multipliers oscillate between rounds
MOST_KEPT = 400  # states that go from one round into the next
SEARCHING = 0.6  # share of the time; the rest is for the proof
LEVELS = (-1.0, -0.5, 0.0, 0.5, 1.0)
STEPS = (0.15, 0.05, 0.015)
_ACTIVE = (0, 1, 2, 3, 4, 5, 9, 10, 11, 12, 13, 14, 15, 16, 17)  # rates of x, y, z are eliminated


def tight_design(
    case: Case,
    features: Features,
    gap: float,
    deadline: float,
    progress: Callable[[str], None] = lambda _: None,
    rounds: int = ROUNDS,
    aim: float | None = None,
) -> Design:
    """Finds the design, its bound and, as far as time allows, the proof.

    Args:
        gap: how far the proven maximum may lie above the largest value that was found, as a share, to count as proven.
        deadline: `time.process_time()` at which to stop [s]; the last part is for the proof.
        rounds: rounds of the exchange, at most; each makes the bound tighter.
        aim: the gap at which search and proof end before their time; by default `gap`.
    """
    aim = gap if aim is None else aim
    size = features.coefficients.shape[-1]
    moments = motion_moments(case, features)
    draw = np.random.default_rng(SEED)
    states = _candidates(FIRST_STATES, draw)
    enough = process_time() + SEARCHING * (deadline - process_time())
    best: tuple[float, Array, Array, float] | None = None
    attained = -np.inf
    for _ in range(rounds):
        try:
            weights, multipliers = _best_weights(features, moments, states)
        except HexciteError:
            if best is None:
                raise
            break  # the best dual point until now gives a bound all the same
        solved = states, weights
        matrices = features.matrices(states)
        information = np.einsum("n,nki,nkj->ij", weights, matrices, matrices, optimize=True)
        attained = max(attained, float(np.linalg.slogdet(information)[1]))
        inverse = np.linalg.inv(information)
        gradient = TightDerivative(features, features.form(inverse), multipliers)
        if best is not None:
            inverse = KEPT * best[1] + (1.0 - KEPT) * inverse
            multipliers = KEPT * best[2] + (1.0 - KEPT) * multipliers
        derivative = TightDerivative(features, features.form(inverse), multipliers)
        support = weights > NEGLIGIBLE
        climbed, values = climbed_from(derivative, states[support], draw)
        largest = float(values.max())
        bound = size * float(np.log(largest / size)) - float(np.linalg.slogdet(inverse)[1])
        if best is None or bound < best[0]:
            best = (bound, inverse, multipliers, largest)
        progress(f"log det between {attained:.4f} and about {best[0]:.4f}; {int(support.sum())} states")
        if best[0] - attained <= size * aim / 2 or process_time() > enough:
            break
        value = np.where(support, np.inf, gradient.at(states))
        indices = np.argsort(-value)[:MOST_KEPT]
        states = np.vstack([states[indices], climbed[gradient.at(climbed) > size]])
    assert best is not None
    _, inverse, multipliers, largest = best
    derivative = TightDerivative(features, features.form(inverse), multipliers)
    logdet = -float(np.linalg.slogdet(inverse)[1])
    lower_bound = max(size, largest)
    upper, lower, _ = maximise(
        derivative, *first_tight_cells(features), lower_bound * (1.0 + aim), lower_bound, deadline, progress
    )
    certified = upper <= max(lower_bound, lower) * (1.0 + gap) * (1.0 + 1e-9)
    dmax = upper if certified else max(largest, lower)
    return Design(*solved, attained, logdet, max(dmax, size), max(upper, size), certified)


def _candidates(count: int, draw: np.random.Generator) -> Array:
    """Random states on corners, edges and in between: accelerations need not be at their limits."""
    states = draw.choice([-1.0, 1.0], (count, 18))
    states[:, 3:6] = draw.choice(LEVELS, (count, 3))
    states[:, 9:12] = draw.choice([-1.0, 0.0, 1.0], (count, 3))
    between = draw.random((count, 1)) < 0.6
    states[:, 12:] = np.where(between, draw.choice(LEVELS, (count, 6)), states[:, 12:])
    states[:, 6:9] = 0.0
    return states


def _best_weights(features: Features, moments: tuple[Array, Array], states: Array) -> tuple[Array, Array]:
    """Weights that maximise log det under the constraints, and the Lagrangian of these."""
    cp: Any = import_module("cvxpy")  # takes 2 s to import, and has no types

    size = features.coefficients.shape[-1]
    matrices = features.matrices(states)
    products = np.einsum("nki,nkj->nij", matrices, matrices, optimize=True).reshape(len(states), -1)
    weights = cp.Variable(len(states), nonneg=True)
    information = cp.reshape(products.T @ weights, (size, size), order="C")
    of_states = monomials(states)
    equal = (of_states @ moments[0].T).T @ weights == 0
    at_most = (of_states @ moments[1].T).T @ weights <= 0
    total = cp.sum(weights) == 1
    problem = cp.Problem(cp.Maximize(cp.log_det((information + information.T) / 2)), [total, equal, at_most])
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # inaccurate multipliers give a bound too, and the proof checks it
            problem.solve(solver=cp.CLARABEL)
    except cp.SolverError as error:
        raise HexciteError(f"the tight information limit was not found (Clarabel: {error})") from error
    if weights.value is None:
        raise HexciteError(f"the tight information limit was not found (Clarabel: {problem.status})")
    solution = np.maximum(weights.value, 0.0)
    return solution / solution.sum(), lagrangian(moments, equal.dual_value, at_most.dual_value)


def climbed_from(derivative: TightDerivative, known: Array, draw: np.random.Generator) -> tuple[Array, Array]:
    """Distinct local maxima of h, from random states and known ones.

    Args:
        known: states to start from too, as shares of the box, shape (k, 18).
        draw: source of the other starts.

    Returns:
        States, shape (n, 18), and values, shape (n,).
    """
    variations = (
        (k, LEVELS, STEPS) if 3 <= k < 12 else (k, (-1.0, 1.0), ())
        for _ in range(SWEEPS)
        for k in draw.permutation(_ACTIVE)
    )
    return climb(derivative.at, _candidates(RANDOM, draw), CLIMBERS, known, variations, range(12, 18))
