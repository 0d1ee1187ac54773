"""Estimates that know what the linear parameters stand for: physical parameters, and bodies of positive density.

A physical parameter that is known and not linear in u, such as a central inertia without its centre of gravity, takes
the non-linear form (18) in physical parameters p = (m, xC, I_C, f_q0, K), by its local Jacobian (`nonlinear`). (18) is
A u(p) with u(p) of (17): the regressor is the model's own, and A du/dp is the local Jacobian. With all parameters free
the estimate is the linear one, propagated. Least squares of a non-linear residual by Gauss-Newton steps with halving
(Nocedal & Wright 2006, section 10.3).

Physically consistent inertia is the least chi^2 among the parameters that some body of positive density has. Wensing,
Kim & Slotine 2018, IEEE Robot. Autom. Lett. 3(1):60: mass, first moment h and inertia belong to such a body if and only
if the pseudo-inertia matrix J = (Sigma h; h^T m), Sigma = 1/2 tr(I) 1 - I, is positive definite. J is linear in u, so
that the problem is convex; its size is that of u, whatever the length of the run.
"""

import warnings
from collections.abc import Callable, Mapping
from dataclasses import replace
from importlib import import_module
from typing import Any

import numpy as np
from scipy.special import fdtrc

from cases.errors import IdentificationError
from cases.units import Array
from identification.estimation.fit import Fit, Regression, column_scale, compress, fit_along
from identification.estimation.force_noise import with_kernel
from identification.finding import Kind, note, warning
from identification.model import Model
from identification.parameters import FIRST_MOMENT, INERTIA, INERTIA_INDEX, MASS, physical_form, require_names

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


# [m] rms distance of a body's mass from any plane through its centre of gravity, at least: of a sheet of thickness d
# d / sqrt(12), thinner than any tool or workpiece; above 0, since a body on the bound has no volume otherwise
THINNEST = 1e-3
UNLIKELY = 1e-3  # chance of so inconsistent an estimate below which it is reported
BODY = tuple(p.name for block in (MASS, FIRST_MOMENT, INERTIA) for p in block.parameters)
_NONE = "no consistent body was found"
ACCURACIES = (1e-9, 1e-7)  # of the solver: 1e-9 gives 1e-6 standard deviations, but is not always within its reach


def pseudo_inertia(body: Array) -> Array:
    """J of the ten parameters m, m xC, I11 I12 I13 I22 I23 I33 about the origin of {P}, shape (4, 4)."""
    inertia = np.zeros((3, 3))
    for (i, j), moment in zip(INERTIA_INDEX, body[4:], strict=True):
        inertia[i, j] = inertia[j, i] = moment
    second = 0.5 * np.trace(inertia) * np.eye(3) - inertia
    return np.block([[second, body[1:4, None]], [body[None, 1:4], body[None, :1]]])


def consistent(regression: Regression, free: Fit) -> tuple[Fit, float, float]:
    """The consistent estimate nearest to a free one, in chi^2.

    Its covariances, s0 and degrees of freedom are those of the free one: the projection onto a convex set that holds
    the truth brings the estimate nearer to it (in the metric of F), so that the confidence ellipsoid of (28) holds the
    truth at least as often (ours).

    Args:
        free: estimate of a Gauss-Markov estimator; chi^2 rises from it by (u - free)^T F (u - free), F and s0
            being in its covariance.

    Returns:
        The estimate, the rise of chi^2 by the constraint over s0^2, 0 where it did not bind, and the probability that
        noise makes a consistent body look as inconsistent as this or more, at most: a tiny one says that the model or
        the data are wrong, not that it is chance.

    Raises:
        IdentificationError: the model has no inertia, so that any positive mass is consistent; or no body is found.
    """
    names = list(regression.names)
    missing = [name for name in BODY if name not in names]
    if missing:
        raise IdentificationError(
            f"{', '.join(missing)} not in the model; physical consistency needs all of {', '.join(BODY)}: models 6 to 9"
        )
    index = [names.index(name) for name in BODY]
    basis = np.array([pseudo_inertia(unit) for unit in np.eye(len(BODY))])
    basis[0, :3, :3] -= THINNEST**2 * np.eye(3)  # Sigma_C >= m thinnest^2, as one LMI (Schur complement; ours)
    start = np.einsum("kij,k->ij", basis, free.values[index])
    if np.linalg.eigvalsh(start)[0] >= 0.0:
        return free, 0.0, 1.0
    # The covariance of the body alone moves the rest along: what is inconsistent has ten unknowns, in all models.
    root = _root(free.covariance)
    root = root @ np.linalg.qr(root[index].T)[0]
    step = _nearest(start, np.einsum("kij,kr->rij", basis, root[index]))
    values = free.values + root @ step
    if np.linalg.eigvalsh(pseudo_inertia(values[index]))[0] <= 0.0:
        raise IdentificationError(_NONE, "the data want a mass below zero; check the sense of the sensor")
    rise, freedoms = float(step @ step), np.linalg.matrix_rank(root[index] / _unit(free.covariance)[index, None])
    # The truth is consistent: it is at least as far from the free estimate as the nearest consistent one.
    p_value = float(fdtrc(freedoms, free.freedom, rise / freedoms))
    return replace(free, values=values, residuals=regression.residuals(values)), rise, p_value


def consistent_of(regression: Regression, free: Fit) -> Fit:
    """The same, and whether the constraint bound."""
    fit, rise, p_value = consistent(regression, free)
    sentence = "consistent: the estimate is that of a real body, the constraint did not bind"
    if rise:
        sentence = f"consistent: the constraint bound and raised chi^2 by {rise:.3g} s0^2; chance does so in at most "
        sentence += f"{100 * p_value:.2g} % of runs"
    findings = (*fit.findings, note(Kind.ESTIMATOR, sentence))
    if rise and p_value < UNLIKELY:
        far = "no real body is near what the data say; model or data are wrong"
        findings = (*findings, warning(Kind.ESTIMATOR, far))
    return replace(fit, findings=findings)


def _unit(covariance: Array) -> Array:
    """Standard deviation of each parameter, 1 where it is fixed, shape (u,)."""
    std = np.sqrt(np.diag(covariance))
    return np.where(std > 0.0, std, 1.0)


def _root(covariance: Array) -> Array:
    """S with S S^T = covariance, shape (u, r), r < u where parameters are fixed."""
    unit = _unit(covariance)
    variances, directions = np.linalg.eigh(covariance / np.outer(unit, unit))
    significant = variances > len(unit) * np.finfo(float).eps * variances[-1]
    return np.asarray(unit[:, None] * directions[:, significant] * np.sqrt(variances[significant]))


def _nearest(start: Array, slopes: Array) -> Array:
    """The shortest z, shape (r,), with start + sum z_k slopes_k, shapes (4, 4) and (r, 4, 4), positive semidefinite."""
    # Loaded here: it takes a second, and most estimates are consistent without it. Its types stop half way.
    cp: Any = import_module("cvxpy")

    # A congruence keeps definiteness; kg, kg m and kg m^2 become numbers about 1.
    size = 1.0 / np.sqrt(np.abs(np.diag(start)) + np.linalg.norm(np.diagonal(slopes, axis1=1, axis2=2), axis=0))
    scaled, flat = start * np.outer(size, size), (slopes * np.outer(size, size)).reshape(len(slopes), 16)
    z = cp.Variable(len(slopes))
    matrix = cp.reshape(flat.T @ z, (4, 4), order="C") + scaled
    problem = cp.Problem(cp.Minimize(cp.sum_squares(z)), [matrix >> 0])
    for accuracy in ACCURACIES:
        tolerances = {"tol_gap_abs": accuracy, "tol_gap_rel": accuracy, "tol_feas": accuracy}
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # what cvxpy warns of is in the status
                problem.solve(solver=cp.CLARABEL, **tolerances)
        except cp.SolverError as error:
            raise IdentificationError(f"{_NONE}: Clarabel: {error}".splitlines()[0]) from error
        if problem.status == cp.OPTIMAL:
            return np.asarray(z.value, dtype=float)
    raise IdentificationError(_NONE, f"Clarabel ends with {problem.status}; the free estimate is too far from any body")
