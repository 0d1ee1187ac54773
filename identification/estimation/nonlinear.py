"""Least squares of the non-linear form (18).

A physical parameter that is known and not linear in u, such as a central inertia without its centre of gravity, takes
the non-linear form (18) in physical parameters p = (m, xC, I_C, f_q0, K), by its local Jacobian (`nonlinear`). (18) is
A u(p) with u(p) of (17): the regressor is the model's own, and A du/dp is the local Jacobian. With all parameters free
the estimate is the linear one, propagated. Least squares of a non-linear residual by Gauss-Newton steps with halving
(Nocedal & Wright 2006, section 10.3).
"""

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from cases.errors import IdentificationError
from cases.units import Array
from identification.estimation.fit import Fit, Regression, column_scale, compress, fit_along
from identification.estimation.force_noise import with_kernel
from identification.finding import Kind, note
from identification.model import Model
from identification.parameters import physical_form, require_names

TOLERANCE = 1e-9  # of a standard deviation of each parameter
ROUNDING = 1e-14  # of the forces: smaller steps only move the last digits


def nonlinear(regression: Regression, model: Model, weights: Array, known: Mapping[str, float]) -> Fit:
    """Fit of u by Gauss-Newton in the physical parameters; rank and condition are those of the local Jacobian.

    It starts from 1 kg at the origin: with all parameters free u(p) is reached in a few steps from any mass but zero,
    since mass, first moments and inertia each become linear once the ones before them are right.

    Args:
        regression: regression of the model; columns beyond it (a delay) are estimated too.
        weights: diagonal of W for one sample, shape (6,).
        known: exact values of physical parameters, by name [SI].

    Raises:
        IdentificationError: a name that the model does not have, a value that is not finite, no free parameter, fewer
            forces than unknowns, parameters that the data do not determine, or a search that fails.
    """
    form = physical_form(model)
    names = [p.name for p in form.parameters]
    linear = [name for name in known if name in model.names and name not in names]
    if linear:
        raise IdentificationError(
            f"the estimator nonlinear knows physical parameters, not {', '.join(linear)}; fix {', '.join(names)}"
        )
    require_names(known, names)
    own = len(names)
    names += regression.names[own:]
    if not np.isfinite(list(known.values())).all() or known.get("m", 1.0) <= 0.0:
        raise IdentificationError("a known value must be finite, and a known mass above zero")
    free = np.array([name not in known for name in names])
    if not free.any():
        raise IdentificationError("all parameters are known; leave at least one to estimate")
    start = np.array([known.get(name, 1.0 if name == "m" else 0.0) for name in names])
    root, right, rest = compress(regression, weights)

    def full(theta: Array) -> tuple[Array, Array]:
        physical = start.copy()
        physical[free] = theta
        u, derivative = (value.full() for value in form.inverse(physical[:own]))
        jacobian = np.eye(len(names))
        jacobian[:own, :own] = derivative
        return np.r_[u[:, 0], physical[own:]], jacobian[:, free]

    def residual(theta: Array) -> tuple[Array, Array]:
        u, tangent = full(theta)
        return root @ u - right, root @ tangent

    noise = np.sqrt(rest / (regression.forces.size - len(names)))
    length = np.sqrt(rest + np.sum(right**2))
    solution, steps = gauss_newton(residual, start[free], float(TOLERANCE * noise + ROUNDING * length))
    u, tangent = full(solution)
    labels = [name for name, f in zip(names, free, strict=True) if f]
    fit = with_kernel(fit_along(regression, weights, root, u, tangent, labels), regression)
    return replace(fit, findings=(note(Kind.ESTIMATOR, f"nonlinear: {steps} Gauss-Newton steps"),))


Residual = Callable[[Array], tuple[Array, Array]]
"""theta, shape (p,) -> residuals, shape (k,), and their Jacobian, shape (k, p)."""

STEPS = 50
HALVINGS = 30
RESOLVED = 1e-10  # of |r|^2: less of it than a step promises may drown in rounding, and the step is taken unseen


def gauss_newton(residual: Residual, start: Array, tolerance: float) -> tuple[Array, int]:
    """The theta of least |r(theta)|^2, shape (p,), and the steps to it.

    Directions that nothing determines stay where they started: rank is the caller's to judge at the end.

    Args:
        start: theta, shape (p,).
        tolerance: length of a step, as the change of r that it predicts, below which it is the last. Where r is in
            standard deviations of the noise no parameter is then further from the minimum than so many of its own.

    Raises:
        IdentificationError: where the search ended is not a minimum.
    """
    at = np.asarray(start, dtype=float)
    r, jacobian = residual(at)
    if not np.isfinite(r).all() or not np.isfinite(jacobian).all():
        raise IdentificationError(
            "no minimum was found: the model has no finite value at the start; start from a mass above zero"
        )
    for steps in range(1, STEPS + 1):
        scale = column_scale(jacobian)
        step = scale * np.linalg.lstsq(jacobian * scale, -r, rcond=None)[0]
        predicted = float(np.linalg.norm(jacobian @ step))
        cost, share = float(r @ r), 1.0
        for _ in range(HALVINGS):
            new, new_jacobian = residual(at + share * step)
            finite = bool(np.isfinite(new).all() and np.isfinite(new_jacobian).all())
            if finite and (float(new @ new) < cost or predicted**2 <= max(tolerance**2, RESOLVED * cost)):
                break
            share /= 2.0
        else:
            raise IdentificationError(
                "no minimum was found: no step lowers chi^2 any more, yet the gradient is not zero; start nearer"
            )
        at, r, jacobian = at + share * step, new, new_jacobian
        if predicted <= tolerance:
            return at, steps
    raise IdentificationError(
        f"no minimum was found: the steps did not become small within {STEPS}; start nearer or give more known values"
    )
