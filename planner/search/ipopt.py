"""IPOPT on a program whose functions are NumPy's: CasADi only passes them on."""

from collections.abc import Callable, Sequence
from typing import Any

import casadi as ca
import numpy as np

from cases.units import Array, Indices
from planner.search import SolverStatus
from planner.search.program import NonlinearProgram

Watch = Callable[[float], bool]
"""Function of the objective, called at every iteration; a true answer stops the solver."""

Barrier = tuple[float, float, float]
"""First parameter of IPOPT's barrier, and the factor and the power with which it falls (0.2 and 1.5 by default)."""

INSIDE = 1e-4  # share of a limit by which an iterate may exceed it and still count
GAIN, PATIENCE = 2e-4, 8  # of the objective: 0.02 % of an efficiency in so many iterations is not worth their time


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
    program: NonlinearProgram, start: Array, iterations: int, watch: Watch, barrier: Barrier | None = None
) -> tuple[Array, SolverStatus, int]:
    """Solves a program from a start, which need not be inside its limits.

    Args:
        start: shape (n,).
        iterations: number of iterations at most.
        watch: called with the objective of each iteration.
        barrier: None where it shall adapt.

    Returns:
        The unknowns, of a solver that did not converge the best inside the limits; its status; its iterations.
    """
    bounds, n = program.row_bounds, program.unknowns
    count = len(bounds[0])
    table, order = _sparsity(count, n, *program.pattern)
    triangle, by_column = _sparsity(n, n, *program.hessian_pattern)
    vector, number = ca.Sparsity.dense(n, 1), ca.Sparsity.dense(1, 1)
    x, nothing = ("x", n), ("p", 0)

    def values(at: Array, _: Array) -> Sequence[Array]:
        return np.array([program.value(at)]), program.row_values(at)

    def gradient(at: Array, _: Array) -> Sequence[Array]:
        return np.array([program.value(at)]), program.gradient(at)

    def jacobian(at: Array, _: Array) -> Sequence[Array]:
        return program.row_values(at), program.row_slopes(at)[order]

    def hessian(at: Array, _: Array, factor: Array, multipliers: Array) -> Sequence[Array]:
        return (program.hessian(at, float(factor[0]), multipliers)[by_column],)

    both = [("f", number), ("g", ca.Sparsity.dense(count, 1))]
    functions = {
        "grad_f": NumpyFunction("nlp_grad_f", [x, nothing], [("f", number), ("grad_f_x", vector)], gradient),
        "jac_g": NumpyFunction("nlp_jac_g", [x, nothing], [both[1], ("jac_g_x", table)], jacobian),
        "hess_lag": NumpyFunction(
            "nlp_hess_l", [x, nothing, ("lam_f", 1), ("lam_g", count)], [("hess_gamma_x_x", triangle)], hessian
        ),
    }
    nlp = NumpyFunction("nlp", [x, nothing], both, values)
    best, best_unknowns, settled = np.inf, start, False
    latest: list[float] = []

    def iterate(unknowns: Array, value: Array, rows: Array, *_: Array) -> Sequence[Array]:
        """Remembers the best inside the bounds, stops where the gain is small. IPOPT would swallow an exception."""
        nonlocal best, best_unknowns, settled
        objective = float(value[0])
        inside = (bounds[0] - rows).max(initial=0.0) < INSIDE and (rows - bounds[1]).max(initial=0.0) < INSIDE
        if inside and objective < best:
            best, best_unknowns = objective, unknowns.copy()
        latest[:] = [*latest[-PATIENCE:], objective if inside else np.inf]
        settled = len(latest) > PATIENCE and max(latest) < min(latest) + GAIN
        return (np.array([float(watch(objective) or settled)]),)

    sizes = {"f": 1, "x": n, "lam_x": n, "g": count, "lam_g": count}
    outputs = [(ca.nlpsol_out(k), sizes.get(ca.nlpsol_out(k), 0)) for k in range(ca.nlpsol_n_out())]
    names = "mu_init", "mu_linear_decrease_factor", "mu_superlinear_decrease_power"
    falling = {"mu_strategy": "adaptive"} if barrier is None else dict(zip(names, barrier, strict=True))
    settings = {
        **functions,
        **_QUIET,
        "iteration_callback": NumpyFunction("watch", outputs, [("stop", number)], iterate),
        "ipopt": _IPOPT | falling | {"max_iter": iterations},
    }
    solver = ca.nlpsol("solver", "ipopt", nlp, settings)
    answer = solver(x0=start, lbx=program.lower, ubx=program.upper, lbg=bounds[0], ubg=bounds[1])
    stats = solver.stats()
    status = SolverStatus.SETTLED if settled else SolverStatus(stats["return_status"])
    better = settled or best < float(answer["f"]) or not status.converged
    last = best_unknowns if np.isfinite(best) and better else answer["x"].full()[:, 0]
    return last, status, int(stats["iter_count"])


def _sparsity(rows: int, columns: int, row: Indices, column: Indices) -> tuple[ca.Sparsity, Indices]:
    """CasADi's pattern of a matrix, and in which order its values are stored: by columns."""
    order = np.lexsort((row, column))
    return ca.Sparsity.triplet(rows, columns, row[order].tolist(), column[order].tolist()), order


_QUIET = {"print_time": False, "show_eval_warnings": False, "no_nlp_grad": True}
_MINIMUM_DEGREE = 0  # MUMPS's number of the ordering that takes a quarter less time for splines than what it chooses
_IPOPT = {
    "print_level": 0,
    "sb": "yes",
    "hessian_approximation": "exact",
    "tol": 1e-6,
    "mumps_pivot_order": _MINIMUM_DEGREE,
}
