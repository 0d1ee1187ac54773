"""The D-optimal approximate design over the motion box, with its certificate.

Maximise log det F, F = sum_i w_i A_i^T A_i, over states i of the box and weights w that add up to 1. Multiplicative
steps find the weights of given states; exchange steps bring in the states where the directional derivative is largest
and drop those without weight. By the general equivalence theorem (Kiefer and Wolfowitz 1960) every design G has
log det G <= log det F + u log(dmax / u), dmax being the largest derivative over the box.
"""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import partial
from time import process_time

import numpy as np

from cases.base.units import Array
from cases.schema import Case
from identification.machines.casadi_batch import over_samples
from identification.model.model import Model
from planner.bounds.certificate import Maximum, box_bounds, first_cells, maximise
from planner.bounds.features import CORNER_COORDINATES, Features

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
    logdet: float  # log det F, reference scaling
    dmax: float  # largest directional derivative over the box: proven, or the largest found
    certified: bool  # whether `dmax` is proven to the wanted gap

    def bound(self, size: int) -> float:
        """Upper bound of log det of every design: log det F + u log(dmax / u), for u parameters."""
        return self.logdet + size * float(np.log(self.dmax / size))


def optimal_design(
    features: Features, gap: float, deadline: float, progress: Callable[[str], None] = lambda _: None
) -> Design:
    """Finds the design over the box of a pose, with a proven largest derivative.

    Args:
        gap: wanted dmax / u - 1.
        deadline: `time.process_time()` at which to stop [s].
    """
    size = features.coefficients.shape[-1]

    def largest(inverse: Array, _: Array) -> Maximum:
        levels = size * (1.0 + gap), size * (1.0 + gap / 2)
        bounding = partial(box_bounds, features, features.form(inverse))
        upper, lower, points = maximise(bounding, *first_cells(features), *levels, deadline)
        return upper, lower, np.unique(np.round(points, 12), axis=0)[:EXCHANGED]

    return exchanged(features.matrices, _first_states(), largest, gap, deadline, progress)


def exchanged(
    matrices_of: Callable[[Array], Array],
    states: Array,
    largest: Callable[[Array, Array], Maximum],
    gap: float,
    deadline: float = np.inf,
    progress: Callable[[str], None] = lambda _: None,
) -> Design:
    """The design that weights of states, and states where the derivative is largest, lead to in turn.

    Args:
        matrices_of: states, shape (n, k) -> A in reference scaling, shape (n, 6, u).
        states: states to begin with, shape (n, k); together of full rank.
        largest: F^-1 and the states of a design -> where its derivative is largest.
    """
    weights = np.full(len(states), 1.0 / len(states))
    for number in range(ROUNDS):
        matrices = matrices_of(states)
        size = matrices.shape[2]
        products = np.einsum("nki,nkj->nij", matrices, matrices, optimize=True).reshape(len(matrices), -1)
        weights = improved_weights(products, weights, size, gap / 3)
        support = weights > NEGLIGIBLE
        states, weights = states[support], weights[support] / weights[support].sum()
        information = (weights @ products[support]).reshape(size, size)
        logdet = float(np.linalg.slogdet(information)[1])
        upper, lower, fresh = largest(np.linalg.inv(information), states)
        certified = bool(upper <= size * (1.0 + gap) * (1.0 + 1e-9))
        dmax = max(float(size), upper if certified else lower)
        value = max(float(size), upper if np.isfinite(upper) else lower)
        progress(f"log det {logdet:.4f}, about {size * np.log(value / size):.4f} more; {len(states)} states")
        if value <= size * (1.0 + gap) or process_time() >= deadline or not len(fresh) or number == ROUNDS - 1:
            break
        states = np.vstack([states, fresh])
        share = min(0.5, len(fresh) / len(states))
        weights = np.r_[weights * (1.0 - share), np.full(len(fresh), share / len(fresh))]
    return Design(states, weights, logdet, dmax, certified)


def directional(matrices: Array, inverse: Array) -> Array:
    """Directional derivative trace(A F^-1 A^T) of states, shape (n,), from A, shape (n, 6, u), and F^-1."""
    root = np.linalg.cholesky((inverse + inverse.T) / 2)
    return np.asarray(np.square(matrices @ root).sum(axis=(1, 2)))


def _first_states() -> Array:
    """Random states on corners, edges and middles: there the derivative has its maxima."""
    draw = np.random.default_rng(SEED)
    states = draw.choice([-1.0, 0.0, 1.0], (FIRST_STATES, 18))
    states[:, CORNER_COORDINATES] = draw.choice([-1.0, 1.0], (FIRST_STATES, len(CORNER_COORDINATES)))
    states[:, [2, 6, 7, 8]] = 0.0  # z and the rates of x, y, z do not matter
    return states


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
        if step % 100 == 99:  # states without weight only cost time
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

    `optimal_design` proves its answer for coordinates that are a pose. Here the largest directional derivative is
    searched for, coordinate by coordinate from many states, and nothing excludes a larger one. d is convex in the
    accelerations, so that these are at their limits.

    Args: see `optimal_design`; scaling is the reference scaling, shape (u,).
    """
    home, box = case.need_motion("the information limit")
    middle = np.concatenate([home + box.coordinates.mean(axis=0), np.zeros(2 * len(home))])
    half = np.concatenate([np.ptp(box.coordinates, axis=0) / 2, box.rate, box.acceleration])

    def matrices_of(shares: Array) -> Array:
        """A in reference scaling of states as shares of the half widths, shape (n, 6, u)."""
        states = np.split(middle + half * shares, 3, axis=1)
        return over_samples(model.coordinate_regressor, *states)[0].reshape(len(shares), 6, -1) * scaling

    draw, size, n = np.random.default_rng(SEED), len(scaling), len(home)

    def variations() -> Iterator[Variation]:
        for sweep in range(SWEEPS):
            for k in draw.permutation(3 * n):
                yield (k, (-1.0, 1.0), ()) if k >= 2 * n else (k, () if sweep else LEVELS, CLIMBS)

    def largest(inverse: Array, known: Array) -> Maximum:
        def derivative(shares: Array) -> Array:
            return directional(matrices_of(shares), inverse)

        points, values = climb(derivative, _drawn(draw, RANDOM, n), CLIMBERS, known, variations())
        return np.inf, float(values.max()), points[values > size * (1.0 + gap / 2)]

    return exchanged(matrices_of, _drawn(draw, FIRST_SEARCHED, n), largest, gap, deadline, progress)


Variation = tuple[int, tuple[float, ...], tuple[float, ...]]
"""A coordinate of a state, the values that it takes, and steps up and down from these, as shares of the half width."""


def climb(
    function: Callable[[Array], Array],
    pool: Array,
    most: int,
    known: Array,
    variations: Iterable[Variation],
) -> tuple[Array, Array]:
    """Distinct local maxima of a function, coordinate by coordinate from many states.

    Args:
        function: states, shape (n, k) -> values, shape (n,).
        pool: states as shares of the half widths, shape (n, k), of which the best `most` are starts.
        known: further starts, shape (m, k).

    Returns:
        States, shape (n, k), and values, shape (n,).
    """
    states = np.vstack([pool[np.argsort(-function(pool))[:most]], known])
    values = function(states)

    def attempt(k: int, level: Array | float) -> None:
        trial = states.copy()
        trial[:, k] = np.clip(level, -1.0, 1.0)
        new = function(trial)
        better = new > values + 1e-9
        states[better], values[better] = trial[better], new[better]

    for k, levels, steps in variations:
        for level in levels:
            attempt(k, level)
        for step in steps:
            attempt(k, states[:, k] + step)
            attempt(k, states[:, k] - step)
    _, first = np.unique(np.round(states, 3), axis=0, return_index=True)
    return states[first], values[first]
