"""The D-optimal approximate design over the motion box, with its certificate.

Maximise log det F, F = sum_i w_i A_i^T A_i, over states i of the box and weights w that add up to 1. Multiplicative
steps find the weights of given states; exchange steps bring in the states where the directional derivative is largest
and drop those without weight. By the general equivalence theorem (Kiefer and Wolfowitz 1960) every design G has
log det G <= log det F + u log(dmax / u), dmax being the largest derivative over the box.
"""

from collections.abc import Callable
from dataclasses import dataclass
from time import process_time

import numpy as np
from numpy.typing import NDArray

from cases.schema import Case
from identification.model import Model
from identification.symbolic import over_samples
from planner.bounds.branch import maximise
from planner.bounds.certificate import BoxDerivative, first_cells
from planner.bounds.features import CORNER_COORDINATES, Features

Array = NDArray[np.float64]

SEED = 0
FIRST_STATES = 1000
EXCHANGED = 100  # states brought in at once, at most
STEPS = 2000  # multiplicative steps between two exchanges, at most
NEGLIGIBLE = 1e-6  # weights below are dropped from the design


@dataclass(frozen=True, slots=True)
class Design:
    """A design and how far it may be from the best."""

    states: Array  # as shares of the half widths of the box, shape (n, 18)
    weights: Array  # shape (n,), adding up to 1
    attained: float  # log det F, reference scaling; of a tight one the largest of all designs that were found
    logdet: float  # the same, or log det F of the dual point, from which the bound counts
    dmax: float  # largest directional derivative (tight: Lagrangian) over the box: proven, or the largest that was met
    proven: float  # no larger one is there; infinite where nothing is proven
    certified: bool  # whether `dmax` is proven to the wanted gap


def optimal_design(
    features: Features, gap: float, deadline: float, progress: Callable[[str], None] = lambda _: None
) -> Design:
    """Finds the design.

    Args:
        gap: wanted dmax / u - 1.
        deadline: `time.process_time()` at which to stop [s].
    """
    size = features.coefficients.shape[-1]
    states = _first_states()
    weights = np.full(len(states), 1.0 / len(states))
    levels = size * (1.0 + gap), size * (1.0 + gap / 2)
    while True:
        products = _products(features.matrices(states))
        weights = improved_weights(products, weights, size, gap / 3)
        support = weights > NEGLIGIBLE
        states, weights = states[support], weights[support] / weights[support].sum()
        information = (weights @ products[support]).reshape(size, size)
        logdet = float(np.linalg.slogdet(information)[1])
        derivative = BoxDerivative(features, features.form(np.linalg.inv(information)))
        maximum = maximise(derivative, *first_cells(features), *levels, deadline, progress)
        room = size * float(np.log(max(maximum.upper, size) / size))
        progress(f"log det {logdet:.4f}, at most {room:.4f} more; {len(states)} states")
        if maximum.upper <= levels[0] or process_time() >= deadline or not len(maximum.points):
            certified = maximum.upper <= levels[0] * (1.0 + 1e-9)
            dmax = max(float(size), maximum.upper if certified else maximum.lower)
            return Design(states, weights, logdet, logdet, dmax, max(float(size), maximum.upper), certified)
        fresh = np.unique(np.round(maximum.points, 12), axis=0)[:EXCHANGED]
        states = np.vstack([states, fresh])
        share = min(0.5, len(fresh) / len(states))
        weights = np.r_[weights * (1.0 - share), np.full(len(fresh), share / len(fresh))]


def _first_states() -> Array:
    """Random states on corners, edges and middles: there the derivative has its maxima."""
    draw = np.random.default_rng(SEED)
    states = draw.choice([-1.0, 0.0, 1.0], (FIRST_STATES, 18))
    states[:, CORNER_COORDINATES] = draw.choice([-1.0, 1.0], (FIRST_STATES, len(CORNER_COORDINATES)))
    states[:, [2, 6, 7, 8]] = 0.0  # z and the rates of x, y, z do not matter
    return states


def _products(matrices: Array) -> Array:
    """A_i^T A_i of each state as a row, shape (n, u * u)."""
    return np.asarray(np.einsum("nki,nkj->nij", matrices, matrices, optimize=True).reshape(len(matrices), -1))


def improved_weights(products: Array, weights: Array, size: int, gap: float, steps: int = STEPS) -> Array:
    """w_i <- w_i d_i / u, which never lowers log det F (Titterington 1976), until max d <= u (1 + gap).

    Args:
        products: A_i^T A_i of each state as a row, shape (n, u * u).
        weights: weights to start from, shape (n,), adding up to 1.
        size: u.
    """
    for step in range(steps):
        inverse = np.linalg.inv((weights @ products).reshape(size, size))
        derivative = products @ inverse.ravel()
        weights = weights * derivative / size
        if derivative.max() <= size * (1.0 + gap):
            break
        if step % 100 == 99:  # what has no weight left costs time only
            support = weights > NEGLIGIBLE * weights.max()
            if support.mean() < 0.8:
                support_weights = improved_weights(products[support], weights[support], size, gap, steps - step - 1)
                weights = np.zeros(len(weights))
                weights[support] = support_weights
                break
    return np.asarray(weights / weights.sum())


FIRST_SEARCHED = 1500
RANDOM = 4000  # states among which those to climb from are chosen
CLIMBERS = 150
SWEEPS = 3  # over all coordinates
LEVELS = (-1.0, -0.5, 0.0, 0.5, 1.0)
CLIMBS = (0.15, 0.03)  # shares of a half width
ROUNDS = 40


def _drawn(draw: np.random.Generator, count: int, n: int) -> Array:
    """Random states of n coordinates, most of them on corners, edges and middles, as shares of the half widths."""
    shares = draw.choice(LEVELS, (count, 3 * n))
    shares[:, 2 * n :] = draw.choice([-1.0, 1.0], (count, n))
    return shares


def searched_design(
    case: Case, model: Model, scaling: Array, gap: float, deadline: float, progress: Callable[[str], None]
) -> Design:
    """The design over the box of any machine's coordinates, with dmax by search: an estimate.

    What `optimal_design` proves it proves for coordinates that are a pose. Here the largest directional derivative is
    climbed to, coordinate by coordinate from many states, and nothing excludes a larger one. d is convex in the
    accelerations, so that these are at their limits.

    Args:
        scaling: reference scaling, shape (u,).
        gap: wanted dmax / u - 1.
        deadline: `time.process_time()` at which to stop [s].
    """
    home, box = case.need_motion("the information limit")
    middle = np.concatenate([home + box.pose.mean(axis=0), np.zeros(2 * len(home))])
    half = np.concatenate([np.ptp(box.pose, axis=0) / 2, box.rate, box.acceleration])

    def matrices_of(shares: Array) -> Array:
        """A in reference scaling of states as shares of the half widths, shape (n, 6, u)."""
        states = np.split(middle + half * shares, 3, axis=1)
        return over_samples(model.coordinate_regressor, *states)[0].reshape(len(shares), 6, -1) * scaling

    draw, size = np.random.default_rng(SEED), len(scaling)
    states = _drawn(draw, FIRST_SEARCHED, len(home))
    weights = np.full(len(states), 1.0 / len(states))
    for number in range(ROUNDS):
        matrices = matrices_of(states)
        products = np.einsum("nki,nkj->nij", matrices, matrices, optimize=True).reshape(len(states), -1)
        weights = improved_weights(products, weights, size, gap / 3)
        support = weights > NEGLIGIBLE
        states, weights = states[support], weights[support] / weights[support].sum()
        information = (weights @ products[support]).reshape(size, size)
        logdet = float(np.linalg.slogdet(information)[1])
        climbed, values = _climbed(matrices_of, np.linalg.inv(information), states, draw)
        dmax = float(values.max())
        progress(f"log det {logdet:.4f}, about {size * np.log(max(dmax / size, 1.0)):.4f} more; {len(states)} states")
        fresh = climbed[values > size * (1.0 + gap / 2)]
        if dmax <= size * (1.0 + gap) or process_time() >= deadline or number == ROUNDS - 1:
            break
        states = np.vstack([states, fresh])
        share = min(0.5, len(fresh) / len(states))
        weights = np.r_[weights * (1.0 - share), np.full(len(fresh), share / len(fresh))]
    return Design(states, weights, logdet, logdet, max(float(size), dmax), np.inf, False)


def _climbed(
    matrices_of: Callable[[Array], Array], inverse: Array, starts: Array, draw: np.random.Generator
) -> tuple[Array, Array]:
    """Distinct local maxima of d = trace(A F^-1 A^T) and their values, from random and known states."""
    n = starts.shape[1] // 3
    root = np.linalg.cholesky((inverse + inverse.T) / 2)

    def value(shares: Array) -> Array:
        return np.asarray(np.square(matrices_of(shares) @ root).sum(axis=(1, 2)))

    random = _drawn(draw, RANDOM, n)
    states = np.vstack([random[np.argsort(-value(random))[:CLIMBERS]], starts])
    values = value(states)

    def attempt(k: int, level: Array | float) -> None:
        trial = states.copy()
        trial[:, k] = np.clip(level, -1.0, 1.0)
        new = value(trial)
        better = new > values + 1e-9
        states[better], values[better] = trial[better], new[better]

    for sweep in range(SWEEPS):
        for k in draw.permutation(3 * n):
            accelerates = k >= 2 * n
            for level in (-1.0, 1.0) if accelerates else LEVELS if sweep == 0 else ():
                attempt(k, level)
            for step in () if accelerates else CLIMBS:
                attempt(k, states[:, k] + step)
                attempt(k, states[:, k] - step)
    _, first = np.unique(np.round(states, 3), axis=0, return_index=True)
    return states[first], values[first]
