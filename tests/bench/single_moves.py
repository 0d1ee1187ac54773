"""What single rest-to-rest moves can carry: an estimate of how far optimised point-to-point motions are from the best.

The D-optimal approximate design over all straight moves inside the limits (start, end and times free, struts' lengths,
velocities and accelerations held at seven instants of each). A motion of moves is such a design: its information is
the mean over its moves, weighted with their times. So no point-to-point motion of any number of moves or duration
carries more than the best design. A move and its reverse carry the same.

What it leaves out is that moves must follow each other: a real motion of 12 s spends moves on the way from one corner
of the box to the next. How much that costs is told of an optimised plan. With D the design's information,
log det F <= log det D + u (mean of trace(D^-1 F_move) / u - 1) by concavity: the mean is what the plan's moves carry of
what those of the design do: less on the way from corner to corner. What is missing beyond that is their balance.
What it does not prove: moves are sought by local solves from random starts, so that the largest
directional derivative is the largest that was found, and the upper figure an estimate. The lower one is attained.
"""

from dataclasses import dataclass
from time import process_time

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from cases.schema import Case, load_case
from identification.estimation.criteria import reference_scaling
from identification.model.model import Model, identification_model
from planner.bounds.bound import information_limit
from planner.bounds.design import improved_weights
from planner.families.ptp import CRITICAL_POINTS, INFORMATION_POINTS, PointToPointFamily, state_of_move
from planner.search.problem import state_limits
from planner.search.rounds import seeds_of
from planner.search.solving import Task, run_start

Array = NDArray[np.float64]

MOVES, DURATION = 40, 12.0  # of the plan that gives the first moves; times count in its mean move
ROUNDS, STARTS = 8, 40
NEGLIGIBLE = 1e-4  # weights below are dropped
STRUTS = 3  # groups of the non-linear limits: lengths, velocities, accelerations
LONGEST = 4.0  # time of a phase, in mean moves
MOVED = 0.4  # share of the coordinates in which a new start differs from a known move, and by how much
FULL = 0.97  # share of what the design's moves carry, from which a plan's move counts as one of them
BETTER = 1.0005  # of the directional derivative: what a new move must promise


@dataclass(frozen=True)
class Moves:
    """Single moves: 15 unknowns, start and end in half widths of the box and three times in mean moves.

    Args:
        family: whose moves they are.
        information: unknowns -> lower triangle of the mean information.
        search: solver for the largest directional derivative, given the weights of that triangle.
    """

    family: PointToPointFamily
    information: ca.Function
    search: ca.Function

    @classmethod
    def of(cls, case: Case, model: Model, scaling: Array) -> "Moves":
        """Those of a case."""
        family = PointToPointFamily.of(case, MOVES, DURATION)
        x, weights = ca.SX.sym("x", 15), ca.SX.sym("weights", len(scaling) * (len(scaling) + 1) // 2)
        start, end = (ca.DM(family.middle) + ca.DM(family.half) * x[k : k + 6] for k in (0, 6))
        tj, th, tc = (x[k] for k in (12, 13, 14))
        lengths = (tj, th, tj, tc, tj, th, tj)
        total = 4 * tj + 2 * th + tc
        total_information = ca.SX(0)
        for phase, share in INFORMATION_POINTS:
            state = state_of_move(start, end, x[12:] * family.unit, (phase, share))
            scaled = model.coordinate_regressor.call(list(state), True, False)[0] @ ca.diag(ca.DM(scaling))
            total_information += lengths[phase] / ((1 if phase % 2 else 2) * total) * (scaled.T @ scaled)
        triangle = ca.densify(total_information)[ca.Sparsity.lower(len(scaling)).find()]
        velocity = (x[6:12] - x[:6]) / (2 * tj + th + tc)
        peaks = (velocity, velocity / (tj + th), velocity / (tj + th) / tj)
        scales = (family.half / limit / family.unit**order for order, limit in enumerate(family.limits, start=1))
        rows = [ca.DM(scale) * peak for scale, peak in zip(scales, peaks, strict=True)]
        critical = [ca.vertcat(*state_of_move(start, end, x[12:] * family.unit, at), 0) for at in CRITICAL_POINTS]
        for _, _, kernel in state_limits(case)[:STRUTS]:
            limit = ca.Function("limit", [kernel.variables], [kernel.expression])
            rows += [limit(state) for state in critical]
        value, limits = ca.cse([-ca.dot(weights, triangle), ca.vertcat(*rows)])
        problem = {"x": x, "p": weights, "f": value, "g": limits}
        quiet = {"print_level": 0, "sb": "yes", "hessian_approximation": "limited-memory", "max_iter": 300}
        options = {"ipopt": quiet, "print_time": False, "show_eval_warnings": False}
        solver = ca.nlpsol("search", "ipopt", problem, options)
        return cls(family, ca.Function("information", [x], [triangle], {"cse": True}), solver)

    def products(self, moves: Array, size: int) -> Array:
        """Mean information of each move as a row, shape (n, u u)."""
        triangles = self.information.map(len(moves))(moves.T).full()
        row, column = (np.array(k) for k in ca.Sparsity.lower(size).get_triplet())
        full = np.zeros((len(moves), size, size))
        full[:, row, column] = full[:, column, row] = triangles.T
        return full.reshape(len(moves), -1)

    def best(self, starts: Array, inverse: Array) -> tuple[Array, Array]:
        """Local maxima of trace(F^-1 A^T A) inside the limits: moves and values."""
        row, column = (np.array(k) for k in ca.Sparsity.lower(len(inverse)).get_triplet())
        weights = np.where(row == column, 1.0, 2.0) * inverse[row, column]
        shortest = 3 * self.family.cycle / self.family.unit
        lower, upper = np.r_[-np.ones(12), shortest, 0.0, 0.0], np.r_[np.ones(12), np.full(3, LONGEST)]
        moves, values = [], []
        for start in starts:
            answer = self.search(x0=start, p=weights, lbx=lower, ubx=upper, lbg=-1.0, ubg=1.0)
            if np.abs(answer["g"].full()).max() <= 1.0 + 1e-6:
                moves.append(answer["x"].full()[:, 0])
                values.append(-float(answer["f"]))
        return np.array(moves).reshape(-1, 15), np.array(values)


def _percent(share: float) -> str:
    return f"{100 * share:.0f} %"


def single_moves_rows() -> list[list[str]]:
    """Rows of the table of figures."""
    began = process_time()
    case = load_case("hexapod")
    model = identification_model(case, 9)
    bound, scaling = information_limit(case, model), reference_scaling(case, model)
    size, draw = len(scaling), np.random.default_rng(0)
    moves = Moves.of(case, model, scaling)
    plan = run_start(Task(case, 9, moves.family, "D", seeds_of(0, 1)[0]))
    points, times = moves.family.split(plan.unknowns)
    walked = known = np.hstack([points[:-1], points[1:], times])
    weights = np.full(len(known), 1.0 / len(known))
    upper = np.inf
    for _ in range(ROUNDS):
        products = moves.products(known, size)
        weights = improved_weights(products, weights, size, 1e-4)
        used = weights > NEGLIGIBLE
        known, weights = known[used], weights[used] / weights[used].sum()
        information = (weights @ products[used]).reshape(size, size)
        attained = bound.efficiency(float(np.linalg.slogdet(information)[1]))
        starts = known[draw.integers(0, len(known), STARTS)].copy()
        turned = draw.random((STARTS, 12)) < MOVED
        starts[:, :12] = np.where(turned, draw.uniform(-1.0, 1.0, (STARTS, 12)), starts[:, :12])
        found, values = moves.best(starts, np.linalg.inv(information))
        upper = min(upper, attained * max(values.max(), size) / size)
        better = found[values > size * BETTER]
        if not len(better):
            break
        share = 0.2
        known = np.vstack([known, better])
        weights = np.r_[weights * (1.0 - share), np.full(len(better), share / len(better))]
    carried = moves.products(walked, size) @ np.linalg.inv(information).ravel() / size
    shares = times @ [4.0, 2.0, 1.0]
    shares /= shares.sum()
    most = attained * np.exp(shares @ carried - 1.0)
    full = carried > FULL
    durations = moves.family.unit * (known @ np.r_[np.zeros(12), 4.0, 2.0, 1.0])
    return [
        ["point-to-point moves, d_efficiency of the best design of single moves that was found", f"{attained:.3f}", ""],
        ["  more than that is not expected of any motion of moves (estimate)", f"{upper:.3f}", ""],
        ["  durations of these moves", f"{durations.min():.2f} to {durations.max():.2f} s", ""],
        ["a plan of 40 moves in 12 s, one start, d_efficiency", f"{bound.efficiency(plan.record.logdet):.3f}", ""],
        [
            f"  time in moves that carry {_percent(FULL)} of the design's or more",
            _percent(float(shares[full].sum())),
            "",
        ],
        [
            "  the others, on the way between them, carry",
            _percent(float(np.average(carried[~full], weights=shares[~full]))),
            "",
        ],
        ["  no balance of its moves could be worth more than", f"{most:.3f}", ""],
        ["  time", f"{process_time() - began:.0f} s CPU", ""],
    ]
