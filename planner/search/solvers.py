"""The solvers by name: IPOPT (interior point), SQP with an active-set method for its steps, SciPy's SLSQP.

What a solver says of itself is recorded, never relied on: `planner.search.solving` rates what comes out. Each solver
can be stopped between iterations and then returns what it has reached.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from planner.search.last_words import last_words
from planner.search.problem import Constraints

Array = NDArray[np.float64]

TOLERANCE = 1e-4  # of an objective of order one: 0.01 % of a standard deviation; limited-memory IPOPT stalls below


@dataclass(frozen=True)
class Program:
    """Minimise `objective` over `unknowns` within bounds and constraints.

    Args:
        unknowns: the symbol, shape (n,).
        objective: an expression.
        constraints: rows with their derivatives.
        lower: of each unknown.
        upper: of each unknown.
        hessian: (unknowns, nothing, factor of the objective, multipliers of the rows) -> upper triangle of the second
            derivative of the Lagrangian; None where it is to be approximated. IPOPT uses it.
        barrier: with second derivatives, the height of the barrier before the limits with which IPOPT begins.
    """

    unknowns: ca.MX
    objective: ca.MX
    constraints: Constraints
    lower: Array
    upper: Array
    hessian: ca.Function | None = None
    barrier: float = 1e-2


@dataclass(frozen=True, slots=True)
class Reached:
    """Where a solver ended.

    Args:
        unknowns: shape (n,).
        status: its last words.
        converged: whether it says that it is done.
        iterations: taken.
    """

    unknowns: Array
    status: str
    converged: bool
    iterations: int


class Watch(Protocol):
    """Is told of every iteration; says whether to stop."""

    def __call__(self, objective: float) -> bool:
        """Takes the objective of the iteration; true stops the solver."""
        ...


Solver = Callable[[Program, Array, int, Watch], Reached]


class _Callback(ca.Callback):  # type: ignore[misc]
    """CasADi's iteration callback around a `Watch`; an exception in it would be swallowed by IPOPT."""

    def __init__(self, size: int, rows: int, watch: Watch) -> None:
        super().__init__()
        self.size, self.rows, self.watch = size, rows, watch
        self.construct("watch", {})

    def get_n_in(self) -> int:
        return int(ca.nlpsol_n_out())

    def get_n_out(self) -> int:
        return 1

    def get_name_in(self, k: int) -> str:
        return str(ca.nlpsol_out(k))

    def get_name_out(self, k: int) -> str:
        return "stop"

    def get_sparsity_in(self, k: int) -> Any:
        name = ca.nlpsol_out(k)
        rows = {"f": 1, "x": self.size, "lam_x": self.size, "g": self.rows, "lam_g": self.rows}.get(name, 0)
        return ca.Sparsity.dense(rows, 1 if rows else 0)

    def eval(self, arguments: list[Any]) -> list[float]:
        return [float(self.watch(float(arguments[1])))]


def _casadi(plugin: str, options: dict[str, Any], exact: dict[str, Any]) -> Solver:
    def solve(program: Program, start: Array, iterations: int, watch: Watch) -> Reached:
        x, c = program.unknowns, program.constraints
        p = ca.MX.sym("p", 0)
        rows, names = [c.rows, c.jacobian], ["g", "jac_g_x"]
        if plugin == "ipopt":
            derivatives = {"jac_g": ca.Function("nlp_jac_g", [x, p], rows, ["x", "p"], names)}
            if program.hessian is not None:
                derivatives["hess_lag"] = program.hessian
        else:
            slope = ca.densify(ca.gradient(program.objective, x))
            everything = [program.objective, slope, *rows]
            derivatives = {
                "jac_fg": ca.Function("nlp_jac_fg", [x, p], everything, ["x", "p"], ["f", "grad_f_x", *names])
            }
        callback = _Callback(x.shape[0], c.rows.shape[0], watch)
        common = {**derivatives, **_COMMON, "iteration_callback": callback}
        limit = {**options, "max_iter": iterations}
        if program.hessian is not None:
            limit = {**limit, **exact, "mu_init": program.barrier, **(_PUSH if program.barrier < FAR else {})}
        limit = {"ipopt": limit} if plugin == "ipopt" else limit
        solver = ca.nlpsol("solver", plugin, {"x": x, "f": program.objective, "g": c.rows}, {**common, **limit})
        at, taken = start, 0
        while True:
            answer = solver(x0=at, lbx=program.lower, ubx=program.upper, lbg=c.lower, ubg=c.upper)
            stats = solver.stats()
            at, taken = answer["x"].full()[:, 0], taken + int(stats["iter_count"])
            stuck = stats["return_status"] == STUCK and stats["iter_count"] > 1
            if not stuck or taken >= iterations or not np.isfinite(at).all():
                break
        if stats["return_status"] == STUCK and multipliers_balance(program, at):
            return Reached(at, BALANCED, True, taken)
        return Reached(at, last_words(stats["return_status"]), bool(stats["success"]), taken)

    return solve


_COMMON = {
    "print_time": False,
    "show_eval_warnings": False,
    # The Lagrangian's gradient that CasADi builds besides is for sensitivities of the solution, which nobody asks for.
    "no_nlp_grad": True,
}
_IPOPT = {
    "hessian_approximation": "limited-memory",  # AD's exact Hessian costs 1.7 s an evaluation
    "limited_memory_max_history": 40,  # with the default of 6 half of the runs end in the iteration limit
    "tol": TOLERANCE,
    "print_level": 0,
    "sb": "yes",
}
# With exact second derivatives. The barrier falls slowly: following its minimum down from a height at which limits
# repel from afar leads from a random start to better optima than going straight to those limits that are near.
_IPOPT_EXACT = {
    "hessian_approximation": "exact",
    "tol": 1e-6,
    "mu_linear_decrease_factor": 0.3,
    "mu_superlinear_decrease_power": 1.05,
}
FAR = 1e-5  # barriers below it are for starts near an optimum, which must not be pushed away from their limits
_PUSH = dict.fromkeys(("bound_push", "bound_frac", "slack_bound_push", "slack_bound_frac"), 1e-6)
_SQP = {
    "qpsol": "daqp",
    "qpsol_options": {"error_on_fail": False},
    "hessian_approximation": "limited-memory",
    "tol_du": TOLERANCE,
    "tol_pr": TOLERANCE,
    "print_header": False,
    "print_iteration": False,
    "print_status": False,
    "error_on_fail": False,
}


# What SQP says when its quadratic program found no step though multipliers do not yet balance: the approximated Hessian
# has become useless. It goes on from there with a new one.
STUCK = "Search_Direction_Becomes_Too_Small"
# SciPy's status where linearised constraints contradict each other, and where a step leads uphill: such steps have led
# far outside. It goes on, with a new Hessian, from the last iterate that kept the constraints.
ASTRAY = (4, 8)
OUTSIDE = 1e-3  # of a constraint


BALANCED = "no step is left, multipliers balance"


def multipliers_balance(program: Program, at: Array) -> bool:
    """Whether a point keeps the constraints and multipliers of those that bind balance the slope of the objective.

    These are found by non-negative least squares: where more constraints bind than there are unknowns they are not
    unique, and those of an active-set method need not balance though others do (first-order conditions, Karush, Kuhn
    and Tucker).

    Args:
        program: with bounds on unknowns too.
        at: shape (n,).
    """
    from scipy.optimize import nnls

    x, c = program.unknowns, program.constraints
    together = [ca.densify(ca.gradient(program.objective, x)), c.rows, ca.densify(c.jacobian)]
    slope, values, slopes = (m.full() for m in ca.Function("together", [x], together)(at))
    rows = np.vstack([slopes, np.eye(len(at))])
    value, low, high = np.r_[values[:, 0], at], np.r_[c.lower, program.lower], np.r_[c.upper, program.upper]
    if np.any(value < low - TOLERANCE) or np.any(value > high + TOLERANCE):
        return False
    outwards = np.vstack([rows[value > high - TOLERANCE], -rows[value < low + TOLERANCE]])
    least = outwards.T @ nnls(outwards.T, -slope[:, 0])[0] if len(outwards) else 0.0
    return bool(np.abs(slope[:, 0] + least).max() < TOLERANCE)


class _Stopped(Exception):
    """Leaves SciPy's solver from its callback."""


def _slsqp(program: Program, start: Array, iterations: int, watch: Watch) -> Reached:
    from scipy.optimize import minimize

    x, c = program.unknowns, program.constraints
    value = ca.Function("value", [x], [program.objective, ca.densify(ca.gradient(program.objective, x))])
    rows = ca.Function("rows", [x], [c.rows])
    slopes = ca.Function("slopes", [x], [c.jacobian])
    equal = np.flatnonzero(c.lower == c.upper)
    bounded = np.flatnonzero(c.lower != c.upper)
    taken, latest, kept = 0, start, start

    def objective(at: Array) -> tuple[float, Array]:
        f, g = value(at)
        return float(f), g.full()[:, 0]

    def both_sides(at: Array) -> Array:
        g = rows(at).full()[bounded, 0]
        return np.asarray(np.concatenate([c.upper[bounded] - g, g - c.lower[bounded]]))

    def both_slopes(at: Array) -> Array:
        slope = slopes(at).full()[bounded]
        return np.concatenate([-slope, slope])

    def count(at: Array) -> None:
        nonlocal taken, latest, kept
        taken, latest = taken + 1, at.copy()
        g = rows(at).full()[:, 0]
        if np.all((g >= c.lower - OUTSIDE) & (g <= c.upper + OUTSIDE)):
            kept = latest
        if watch(float(value(at)[0])):
            raise _Stopped

    constraints: list[dict[str, Any]] = [{"type": "ineq", "fun": both_sides, "jac": both_slopes}]
    if len(equal):
        constraints.append(
            {
                "type": "eq",
                "fun": lambda at: rows(at).full()[equal, 0] - c.lower[equal],
                "jac": lambda at: slopes(at).full()[equal],
            }
        )
    bounds = None if np.isinf(program.lower).all() else list(zip(program.lower, program.upper, strict=True))
    at, begun = start, 0
    while True:
        try:
            done = minimize(
                objective, at, jac=True, method="SLSQP", bounds=bounds, constraints=constraints, callback=count,
                options={"maxiter": iterations - begun, "ftol": TOLERANCE / 10},
            )  # fmt: skip
        except _Stopped:
            return Reached(latest, "stopped", False, taken)
        begun += int(done.nit)
        if done.status not in ASTRAY or kept is at or begun >= iterations:
            return Reached(np.asarray(done.x), str(done.message).lower(), bool(done.success), begun)
        at = kept


SOLVERS: dict[str, Solver] = {
    "ipopt": _casadi("ipopt", _IPOPT, _IPOPT_EXACT),
    "sqp": _casadi("sqpmethod", _SQP, {}),
    "slsqp": _slsqp,
}
