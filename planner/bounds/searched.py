"""The D-optimal approximate design over the box of any machine's coordinates, with dmax by search: an estimate.

What `planner.bounds.design` proves it proves for coordinates that are a pose. Here the largest directional derivative
is climbed to, coordinate by coordinate from many states, and nothing excludes a larger one. d is convex in the
accelerations, so that these are at their limits.
"""

from collections.abc import Callable
from time import process_time

import numpy as np
from numpy.typing import NDArray

from cases.schema import Case
from identification.evaluate import over_samples
from identification.model import Model
from planner.bounds.branch import Maximum
from planner.bounds.design import NEGLIGIBLE, SEED, Design, improved_weights

Array = NDArray[np.float64]

FIRST_STATES = 1500
RANDOM = 4000  # states among which those to climb from are chosen
CLIMBERS = 150
SWEEPS = 3  # over all coordinates
LEVELS = (-1.0, -0.5, 0.0, 0.5, 1.0)
STEPS = (0.15, 0.03)  # shares of a half width
ROUNDS = 40


class _Box:
    """Regressors of states that are given as shares of the half widths of the box."""

    def __init__(self, case: Case, model: Model, scaling: Array) -> None:
        home, box = case.need_motion("the information limit")
        self.count, self.model, self.scaling = len(home), model, scaling
        none = np.zeros(2 * self.count)
        self.middle = np.concatenate([home + box.pose.mean(axis=0), none])
        self.half = np.concatenate([np.ptp(box.pose, axis=0) / 2, box.rate, box.acceleration])

    def matrices(self, shares: Array) -> Array:
        """A in reference scaling, shape (n, 6, u)."""
        states = np.split(self.middle + self.half * shares, 3, axis=1)
        return over_samples(self.model.coordinate_regressor, *states)[0].reshape(len(shares), 6, -1) * self.scaling

    def drawn(self, draw: np.random.Generator, count: int) -> Array:
        """Random states, most of them on corners, edges and middles."""
        n = self.count
        shares = draw.choice(LEVELS, (count, 3 * n))
        shares[:, 2 * n :] = draw.choice([-1.0, 1.0], (count, n))
        return shares


def searched_design(
    case: Case, model: Model, scaling: Array, gap: float, deadline: float, progress: Callable[[str], None]
) -> Design:
    """Finds the design.

    Args:
        scaling: reference scaling, shape (u,).
        gap: wanted dmax / u - 1.
        deadline: `time.process_time()` at which to stop [s].
        progress: is told the state of things now and then.
    """
    box, draw = _Box(case, model, scaling), np.random.default_rng(SEED)
    size = len(scaling)
    states = box.drawn(draw, FIRST_STATES)
    weights = np.full(len(states), 1.0 / len(states))
    for number in range(ROUNDS):
        matrices = box.matrices(states)
        products = np.einsum("nki,nkj->nij", matrices, matrices, optimize=True).reshape(len(states), -1)
        weights = improved_weights(products, weights, size, gap / 3)
        used = weights > NEGLIGIBLE
        states, weights = states[used], weights[used] / weights[used].sum()
        information = (weights @ products[used]).reshape(size, size)
        logdet = float(np.linalg.slogdet(information)[1])
        climbed, values = _climbed(box, np.linalg.inv(information), states, draw)
        dmax = float(values.max())
        progress(f"log det {logdet:.4f}, about {size * np.log(max(dmax / size, 1.0)):.4f} more; {len(states)} states")
        fresh = climbed[values > size * (1.0 + gap / 2)]
        if dmax <= size * (1.0 + gap) or process_time() >= deadline or number == ROUNDS - 1:
            break
        states = np.vstack([states, fresh])
        share = min(0.5, len(fresh) / len(states))
        weights = np.r_[weights * (1.0 - share), np.full(len(fresh), share / len(fresh))]
    return Design(states, weights, logdet, Maximum(np.inf, dmax, climbed, 0))


def _climbed(box: _Box, inverse: Array, known: Array, draw: np.random.Generator) -> tuple[Array, Array]:
    """Distinct local maxima of d = trace(A F^-1 A^T) and their values, from random and known states."""
    root = np.linalg.cholesky((inverse + inverse.T) / 2)

    def value(shares: Array) -> Array:
        return np.asarray(np.square(box.matrices(shares) @ root).sum(axis=(1, 2)))

    random = box.drawn(draw, RANDOM)
    states = np.vstack([random[np.argsort(-value(random))[:CLIMBERS]], known])
    values = value(states)

    def attempt(k: int, level: Array | float) -> None:
        moved = states.copy()
        moved[:, k] = np.clip(level, -1.0, 1.0)
        new = value(moved)
        better = new > values + 1e-9
        states[better], values[better] = moved[better], new[better]

    for sweep in range(SWEEPS):
        for k in draw.permutation(3 * box.count):
            accelerates = k >= 2 * box.count
            for level in (-1.0, 1.0) if accelerates else LEVELS if sweep == 0 else ():
                attempt(k, level)
            for step in () if accelerates else STEPS:
                attempt(k, states[:, k] + step)
                attempt(k, states[:, k] - step)
    _, first = np.unique(np.round(states, 3), axis=0, return_index=True)
    return states[first], values[first]
