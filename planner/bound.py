"""The information limit of a case: the D-optimal approximate design over the motion box.

Maximise log det sum_i w_i A_i^T A_i over states i of the box and weights w. By the general equivalence theorem (Kiefer
and Wolfowitz 1960) log det F* <= log det F + u log(dmax / u) for every F, dmax being the largest directional derivative
d(state) = trace(A F^-1 A^T) over the box. Here dmax comes from a multi-start search: the result is an estimate of that
bound, and says so; a certificate would need a proven global maximum.
"""

from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path

import casadi as ca
import numpy as np
from numpy.typing import NDArray
from platformdirs import user_cache_path

from cases.errors import FileProblem
from cases.files import json_text, read_json, write_text
from cases.schema import Case
from identification.evaluate import over_samples
from identification.model import Model
from identification.reference import BoxStates, reference_scaling

Array = NDArray[np.float64]

METHOD = "multiplicative algorithm with exchange; dmax by multi-start search, an estimate"
VERSION = 1  # of the method: a new one does not read old cache files
SEED = 0
FIRST_STATES = 3000
SEARCH_STARTS = 250
SEARCH_STEPS = 50
ROUNDS = 60
GAP = 1.5e-3  # stop when dmax <= u (1 + GAP): log det F* is then known to u GAP = 0.03, an efficiency to 0.15 %
WEIGHT_STEPS = 400
NEGLIGIBLE = 1e-7  # weights below are dropped from the design


@dataclass(frozen=True, slots=True)
class Bound:
    """An (estimated) upper bound of log det of the mean information, reference scaling, W = 1.

    Args:
        logdet: the bound, log det F + u log(dmax / u).
        dmax: largest directional derivative found.
        parameters: u.
        method: how dmax was found, and what that makes of the bound.
    """

    logdet: float
    dmax: float
    parameters: int
    method: str

    def efficiency(self, logdet: float) -> float:
        """D-efficiency of a motion with this log det of its mean information, between 0 and 1."""
        return float(np.exp((logdet - self.logdet) / self.parameters))


def box_bound(case: Case, model: Model, cache: Path | None = None) -> Bound:
    """The bound of a case and model with W = 1, from the cache if it was computed before.

    Args:
        case: gives the box.
        model: gives A.
        cache: folder of the cache; the user's cache folder unless given.
    """
    folder = cache if cache is not None else user_cache_path("hexcite") / "bounds"
    file = folder / f"{case.hash}-model{model.number}-equal-v{VERSION}.json"
    if file.is_file():
        try:
            return _read(file, len(model.parameters))
        except (FileProblem, KeyError, TypeError, ValueError):
            file.unlink(missing_ok=True)  # a cache holds nothing that cannot be computed again
    bound = compute_bound(case, model)
    with suppress(FileProblem):  # without a writable cache it is computed anew each time
        write_text(file, json_text(asdict(bound)))
    return bound


def _read(file: Path, size: int) -> Bound:
    """A bound from the cache; raises where it is not one of this model."""
    data = read_json(file, "hexcite plan")
    bound = Bound(float(data["logdet"]), float(data["dmax"]), int(data["parameters"]), str(data["method"]))
    if set(data) != set(asdict(bound)) or not (
        np.isfinite(bound.logdet) and bound.dmax > 0.0 and bound.parameters == size
    ):
        raise ValueError(f"{file}: holds no bound of {size} parameters")
    return bound


def compute_bound(case: Case, model: Model) -> Bound:
    """Computes the bound; see the module."""
    size = len(model.parameters)
    search = _Search(case, model, reference_scaling(case, model))
    draw = np.random.default_rng(SEED)
    states = _to_edges(draw.uniform(-1.0, 1.0, (FIRST_STATES, 18)), draw)
    weights = np.full(len(states), 1.0 / len(states))
    for _ in range(ROUNDS):
        products = _products(search.matrices(states))
        weights = _multiplicative(products, weights, size)
        used = weights > NEGLIGIBLE
        states, weights = states[used], weights[used] / weights[used].sum()
        information = (weights @ products[used]).reshape(size, size)
        inverse = np.linalg.inv(information)
        found, derivative = search.maximise(inverse, states, draw)
        dmax = float(derivative.max())
        if dmax <= size * (1.0 + GAP):
            break
        fresh = found[derivative > size]
        states = np.vstack([states, fresh])
        share = min(0.5, len(fresh) * 0.5 / len(states))
        weights = np.r_[weights * (1.0 - share), np.full(len(fresh), share / len(fresh))]
    logdet = float(np.linalg.slogdet(information)[1]) + size * float(np.log(dmax / size))
    return Bound(logdet, dmax, size, METHOD)


def _to_edges(states: Array, draw: np.random.Generator) -> Array:
    """Moves the coordinates in which the derivative is convex (x, y, accelerations) to the faces of the box."""
    edged = states.copy()
    convex = [0, 1, *range(12, 18)]
    edged[:, convex] = np.where(draw.random((len(states), len(convex))) < 0.5, -1.0, 1.0)
    return edged


def _products(matrices: Array) -> Array:
    """A_i^T A_i of each state as a row, shape (n, u * u)."""
    return np.asarray(np.einsum("nki,nkj->nij", matrices, matrices, optimize=True).reshape(len(matrices), -1))


def _multiplicative(products: Array, weights: Array, size: int) -> Array:
    """w_i <- w_i d_i / u, which never lowers log det F (Titterington 1976)."""
    for _ in range(WEIGHT_STEPS):
        inverse = np.linalg.inv((weights @ products).reshape(size, size))
        derivative = products @ inverse.ravel()
        weights = weights * derivative / size
        if derivative.max() <= size * (1.0 + GAP / 10):
            break
    return np.asarray(weights / weights.sum())


class _Search:
    """Directional derivatives over the box, states as 18 shares of half widths from its middle."""

    def __init__(self, case: Case, model: Model, scaling: Array) -> None:
        machine, _, limits = case.need_machine("the information limit")
        box = limits.motion
        self.middle = np.r_[machine.home.vector + box.pose.mean(axis=0), np.zeros(12)]
        self.half = np.r_[(box.pose[1] - box.pose[0]) / 2, box.rate, box.acceleration]
        self.scaling = scaling
        self.model = model
        size = len(scaling)
        share, inverse = ca.SX.sym("share", 18), ca.SX.sym("inverse", size * size)
        state = ca.DM(self.middle) + ca.DM(self.half) * share
        matrix = model.coordinate_regressor(state[:6], state[6:12], state[12:]) @ ca.diag(ca.DM(scaling))
        factor = ca.reshape(inverse, size, size)
        derivative = ca.sum1(ca.vec((matrix @ factor) ** 2))
        self.function = ca.Function(
            "derivative",
            [share, inverse],
            [derivative, ca.densify(ca.gradient(derivative, share))],
            {"cse": True},
        )

    def matrices(self, shares: Array) -> Array:
        """Scaled regressors, shape (n, 6, u)."""
        values = self.middle + self.half * shares
        states = BoxStates(values[:, :6], values[:, 6:12], values[:, 12:])
        return over_samples(self.model.coordinate_regressor, *states)[0] * self.scaling

    def maximise(self, inverse: Array, known: Array, draw: np.random.Generator) -> tuple[Array, Array]:
        """Local maxima of the derivative by projected gradient steps from many starts; states and values."""
        factor: Array = np.asarray(np.linalg.cholesky(inverse), dtype=np.float64)
        random = _to_edges(draw.uniform(-1.0, 1.0, (20 * SEARCH_STARTS, 18)), draw)
        best = np.argsort(-self._values(random, factor))[:SEARCH_STARTS]
        shares = np.vstack([random[best], known])
        step = np.full(len(shares), 0.5)
        value, gradient = self._derivative(shares, factor)
        for _ in range(SEARCH_STEPS):
            norm = np.abs(gradient).max(axis=1, keepdims=True)
            trial = np.clip(shares + step[:, None] * gradient / np.maximum(norm, 1e-300), -1.0, 1.0)
            trial_value, trial_gradient = self._derivative(trial, factor)
            better = trial_value > value
            shares[better], value[better], gradient[better] = trial[better], trial_value[better], trial_gradient[better]
            step = np.where(better, np.minimum(step * 1.5, 2.0), step * 0.4)
        _, first = np.unique(np.round(shares, 3), axis=0, return_index=True)
        return shares[first], value[first]

    def _values(self, shares: Array, factor: Array) -> Array:
        rows = self.matrices(shares).reshape(-1, len(self.scaling)) @ factor
        return np.asarray(np.sum(rows**2, axis=1).reshape(len(shares), -1).sum(axis=1))

    def _derivative(self, shares: Array, factor: Array) -> tuple[Array, Array]:
        repeated = np.tile(factor.T.ravel(), (len(shares), 1))  # column by column, as CasADi reads it
        value, gradient = over_samples(self.function, shares, repeated)
        return value[:, 0], gradient
