"""Solvers of CasADi on a program whose functions are NumPy's: CasADi only passes them on.

`ipopt` is an interior-point method with exact second derivatives. The two others are CasADi's `sqpmethod`, a sequence
of quadratic programs with a line search: `sqp` with exact second derivatives, made convex, and PIQP for the quadratic
programs; `active-set` with second derivatives of its own (BFGS, begun anew every ten steps) and DAQP, an active-set
method.
"""

from collections.abc import Callable, Sequence
from typing import Any

import casadi as ca
import numpy as np

from cases.base.units import Array, Indices
from planner.request import Solver
from planner.search.nlp import NonlinearProgram
from planner.search.record import SolverStatus

Watch = Callable[[float], bool]
"""Function of the objective, called at every iteration; a true answer stops the solver."""

Barrier = tuple[float, float, float]
"""First parameter of IPOPT's barrier, and the factor and the power with which it falls (0.2 and 1.5 by default)."""

INSIDE = 1e-4  # share of a limit by which an iterate may exceed it and still count
GAIN = 5e-4  # of the objective: 0.05 % of an efficiency in so many iterations is not worth their time
PATIENCE = {Solver.IPOPT: 8, Solver.SQP: 8, Solver.ACTIVE_SET: 20}  # steps without exact curvature gain less
FLAT = 4  # iterations without a gain after which steps that become too short are an end and no failure
STEPS = {Solver.IPOPT: 1, Solver.SQP: 1, Solver.ACTIVE_SET: 4}  # and there are as many more of them
LEAST_CURVATURE = 1e-6  # share of the largest eigenvalue to which others are raised


class NumpyFunction(ca.Callback):  # type: ignore[misc]
    """A NumPy function as CasADi's; it must live as long as the solver runs.

    Args:
        inputs: name and number of elements of each.
        outputs: name and sparsity of each.
        function: arrays of these lengths -> the non-zeros of each output.
        jacobian: derivative of a function that stands in an expression; takes inputs and outputs.
    """

    def __init__(
        self,
        name: str,
        inputs: Sequence[tuple[str, int]],
        outputs: Sequence[tuple[str, ca.Sparsity]],
        function: Callable[..., Sequence[Array]],
        jacobian: "NumpyFunction | None" = None,
    ) -> None:
        super().__init__()
        self.inputs, self.outputs, self.function, self.own_jacobian = inputs, outputs, function, jacobian
        self.construct(name, {})

    def get_n_in(self) -> int:
        """Number of inputs."""
        return len(self.inputs)

    def get_n_out(self) -> int:
        """Number of outputs."""
        return len(self.outputs)

    def get_name_in(self, k: int) -> str:
        """Name of an input."""
        return self.inputs[k][0]

    def get_name_out(self, k: int) -> str:
        """Name of an output."""
        return self.outputs[k][0]

    def get_sparsity_in(self, k: int) -> ca.Sparsity:
        """The dense pattern of an input."""
        return ca.Sparsity.dense(self.inputs[k][1], 1 if self.inputs[k][1] else 0)

    def get_sparsity_out(self, k: int) -> ca.Sparsity:
        """Sparsity of an output."""
        return self.outputs[k][1]

    def has_jacobian(self) -> bool:
        """Whether a Jacobian was given."""
        return self.own_jacobian is not None

    def get_jacobian(self, *_: Any) -> ca.Function:
        """The given Jacobian."""
        return self.own_jacobian

    def has_eval_buffer(self) -> bool:
        """True: memory is passed on as it is."""
        return True

    def eval_buffer(self, arguments: Sequence[memoryview | None], results: Sequence[memoryview | None]) -> int:
        """Writes the results into CasADi's own memory: conversions would take longer than the functions themselves."""
        try:
            values = self.function(
                *(
                    np.zeros(count) if a is None else np.frombuffer(a, dtype=float)  # CasADi's zeros
                    for a, (_, count) in zip(arguments, self.inputs, strict=True)
                )
            )
        except np.linalg.LinAlgError:
            return 1
        for result, value in zip(results, values, strict=True):
            if result is not None:
                np.frombuffer(result, dtype=float)[:] = value
        return 0


def solve(
    program: NonlinearProgram,
    start: Array,
    iterations: int,
    watch: Watch,
    barrier: Barrier | None = None,
    solver: Solver = Solver.IPOPT,
    beyond: Callable[[Array], bool] | None = None,
) -> tuple[Array, SolverStatus, int]:
    """Solves a program from a start, which need not be inside its limits.

    Args:
        start: shape (n,).
        iterations: number of iterations at most, of a solver with exact second derivatives; others have as many more
            as they need.
        watch: called with the objective of each iteration.
        barrier: of IPOPT; None where it shall adapt.
        solver: which of CasADi's.
        beyond: whether an iterate exceeds what the program does not limit; it ends the solver, and counts no more.

    Returns:
        The unknowns, of a solver that did not converge the best inside the limits, of one that came `beyond` those of
        the iterate before that; its status; its iterations.
    """
    bounds, n = program.row_bounds, program.unknowns
    count = len(bounds[0])
    number = ca.Sparsity.dense(1, 1)
    best, best_unknowns, settled, passed = np.inf, start, False, 0
    before, crossed = start, False  # the iterate before, and whether the present one is beyond
    latest: list[float] = []
    patience = PATIENCE[solver]

    def iterate(unknowns: Array, value: Array, rows: Array, *_: Array) -> Sequence[Array]:
        """Remembers the best inside the bounds, stops where the gain is small. IPOPT would swallow an exception."""
        nonlocal best, best_unknowns, settled, passed, before, crossed
        objective, passed = float(value[0]), passed + 1
        crossed = crossed or (beyond is not None and beyond(unknowns))
        if crossed:
            watch(objective)
            return (np.ones(1),)
        before = unknowns.copy()
        inside = (bounds[0] - rows).max(initial=0.0) < INSIDE and (rows - bounds[1]).max(initial=0.0) < INSIDE
        if inside and objective < best:
            best, best_unknowns = objective, unknowns.copy()
        latest[:] = [*latest[-patience:], objective if inside else np.inf]
        settled = len(latest) > patience and max(latest) < min(latest) + GAIN
        return (np.array([float(watch(objective) or settled)]),)

    sizes = {"f": 1, "x": n, "lam_x": n, "g": count, "lam_g": count}
    outputs = [(ca.nlpsol_out(k), sizes.get(ca.nlpsol_out(k), 0)) for k in range(ca.nlpsol_n_out())]
    nlp = NumpyFunction(
        "nlp",
        [("x", n), ("p", 0)],
        [("f", number), ("g", ca.Sparsity.dense(count, 1))],
        lambda at, _: (np.array([program.value(at)]), program.row_values(at)),
    )
    settings = {
        **(_for_ipopt(program, barrier) if solver is Solver.IPOPT else _for_sqp(program, solver)),
        **_QUIET,
        "iteration_callback": NumpyFunction("watch", outputs, [("stop", number)], iterate),
    }
    most = iterations * STEPS[solver]
    if solver is Solver.IPOPT:
        settings["ipopt"] |= {"max_iter": most}
    else:
        settings["max_iter"] = most
    method = ca.nlpsol("solver", "ipopt" if solver is Solver.IPOPT else "sqpmethod", nlp, settings)
    answer = method(x0=start, lbx=program.lower, ubx=program.upper, lbg=bounds[0], ubg=bounds[1])
    status, steps = _ended(method, passed)
    if crossed:
        return before, SolverStatus.BEYOND, steps
    at_rest = len(latest) > FLAT and max(latest[-FLAT:]) < min(latest[-FLAT:]) + GAIN
    if settled or (status is SolverStatus.SHORT_STEP and at_rest):
        status = SolverStatus.SETTLED
    better = settled or best < float(answer["f"]) or not status.converged
    last = best_unknowns if np.isfinite(best) and better else answer["x"].full()[:, 0]
    return last, status, steps


def _ended(method: ca.Function, passed: int) -> tuple[SolverStatus, int]:
    """Status and iterations; CasADi has no statistics of an SQP method whose first quadratic program failed."""
    try:
        stats = method.stats()
    except RuntimeError:
        return SolverStatus.FAILED, passed
    return SolverStatus(stats["return_status"]), int(stats["iter_count"])


def _for_ipopt(program: NonlinearProgram, barrier: Barrier | None) -> dict[str, Any]:
    """Derivatives and settings for IPOPT."""
    n, count = program.unknowns, len(program.row_bounds[0])
    table, order = _sparsity(count, n, *program.pattern)
    triangle, by_column = _sparsity(n, n, *program.hessian_pattern)
    vector, number = ca.Sparsity.dense(n, 1), ca.Sparsity.dense(1, 1)
    x, nothing = ("x", n), ("p", 0)

    def gradient(at: Array, _: Array) -> Sequence[Array]:
        return np.array([program.value(at)]), program.gradient(at)

    def jacobian(at: Array, _: Array) -> Sequence[Array]:
        return program.row_values(at), program.row_slopes(at)[order]

    def hessian(at: Array, _: Array, factor: Array, multipliers: Array) -> Sequence[Array]:
        return (program.hessian(at, float(factor[0]), multipliers)[by_column],)

    names = "mu_init", "mu_linear_decrease_factor", "mu_superlinear_decrease_power"
    falling = {"mu_strategy": "adaptive"} if barrier is None else dict(zip(names, barrier, strict=True))
    rows = ("g", ca.Sparsity.dense(count, 1))
    return {
        "grad_f": NumpyFunction("nlp_grad_f", [x, nothing], [("f", number), ("grad_f_x", vector)], gradient),
        "jac_g": NumpyFunction("nlp_jac_g", [x, nothing], [rows, ("jac_g_x", table)], jacobian),
        "hess_lag": NumpyFunction(
            "nlp_hess_l", [x, nothing, ("lam_f", 1), ("lam_g", count)], [("hess_gamma_x_x", triangle)], hessian
        ),
        "ipopt": _IPOPT | falling,
    }


def _for_sqp(program: NonlinearProgram, solver: Solver) -> dict[str, Any]:
    """Derivatives and settings for CasADi's sqpmethod."""
    n, count = program.unknowns, len(program.row_bounds[0])
    table, order = _sparsity(count, n, *program.pattern)
    whole, by_column = _sparsity(n, n, *np.nonzero(np.ones((n, n))))
    vector, number = ca.Sparsity.dense(n, 1), ca.Sparsity.dense(1, 1)
    x, nothing = ("x", n), ("p", 0)

    def slopes(at: Array, _: Array) -> Sequence[Array]:
        return (
            np.array([program.value(at)]),
            program.gradient(at),
            program.row_values(at),
            program.row_slopes(at)[order],
        )

    def convex_hessian(at: Array, _: Array, factor: Array, multipliers: Array) -> Sequence[Array]:
        """Eigenvalues that are negative, or small, are raised: quadratic programs must be convex."""
        dense = np.zeros((n, n))
        dense[program.hessian_pattern] = program.hessian(at, float(factor[0]), multipliers)
        values, vectors = np.linalg.eigh(dense, UPLO="U")
        raised = np.maximum(values, LEAST_CURVATURE * np.abs(values).max())
        return (((vectors * raised) @ vectors.T).ravel()[by_column],)

    both = [("f", number), ("grad_f_x", vector), ("g", ca.Sparsity.dense(count, 1)), ("jac_g_x", table)]
    settings: dict[str, Any] = {
        "jac_fg": NumpyFunction("nlp_jac_fg", [x, nothing], both, slopes),
        "qpsol": _QUADRATIC[solver],
        "qpsol_options": {"error_on_fail": False},
        "hessian_approximation": "exact" if solver is Solver.SQP else "limited-memory",
        "tol_du": _TOLERANCE,
        "tol_pr": _TOLERANCE,
        "print_header": False,
        "print_iteration": False,
        "print_status": False,
        "error_on_fail": False,
    }
    if solver is Solver.SQP:
        settings["hess_lag"] = NumpyFunction(
            "nlp_hess_l", [x, nothing, ("lam_f", 1), ("lam_g", count)], [("hess_gamma_x_x", whole)], convex_hessian
        )
    return settings


def _sparsity(rows: int, columns: int, row: Indices, column: Indices) -> tuple[ca.Sparsity, Indices]:
    """CasADi's pattern of a matrix, and in which order its values are stored: by columns."""
    order = np.lexsort((row, column))
    return ca.Sparsity.triplet(rows, columns, row[order].tolist(), column[order].tolist()), order


_QUADRATIC = {Solver.SQP: "piqp", Solver.ACTIVE_SET: "daqp"}
_TOLERANCE = 1e-6
_QUIET = {"print_time": False, "show_eval_warnings": False, "no_nlp_grad": True}
_MINIMUM_DEGREE = 0  # MUMPS's number of the ordering that takes a quarter less time for splines than what it chooses
_IPOPT = {
    "print_level": 0,
    "sb": "yes",
    "hessian_approximation": "exact",
    "tol": _TOLERANCE,
    "mumps_pivot_order": _MINIMUM_DEGREE,
    "mumps_permuting_scaling": 0,  # a matching before each analysis: a fifth of an iteration, and no other result
}
