"""The nearest body that can exist to an estimate, and that keeps the bounds of a case.

A body of positive mass has a pseudo-inertia (Wensing, Kim and Slotine 2018, IEEE RA-L 3:60) without negative
eigenvalues, J = (S h; h^T m) with first moments h and S = 1/2 tr(I) 1 - I about the same point: then its mass spreads
along no axis by less than nothing, which the triangle inequalities of principal moments say too. Nearest is by the
covariance of the estimate: the u of least (u - u^)^T C^-1 (u - u^) with J(u) >= 0, a semidefinite program.
"""

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np
from pydantic import BaseModel, NonNegativeFloat
from scipy.special import chdtrc

from cases.base.units import Array
from cases.bounds import BodyBox, Bounds
from identification.estimation.covariances import Free, larger_of
from identification.model.blocks import FIRST_MOMENT, INERTIA, MASS
from identification.model.model import Model
from identification.model.parameters import INERTIA_INDEX, physical_form

BODY_MARGIN = 1e-6  # of the radius of gyration squared: how far inside a body stays, so that rounding leaves it one
BINDS = 1e-5  # of the same, and of the extent of a bound, up to which one counts as reached
INERTIA_HOLDS = "inertia"
MASS_HOLDS = "mass"
IMPOSSIBLE = 3e-5  # chance of a distance, below which noise does not make it: of one constraint 4 deviations
RAREST = 1e-6  # chance below which its figure says nothing more to a reader
STATIC = 4  # parameters of a body whose inertia is not determined


class NearestBody(BaseModel, strict=True, frozen=True, allow_inf_nan=False):
    """Parameters of the nearest body that can exist; those of the estimate where it can.

    Args:
        linear: all of u, shape (u,) [SI]; others than the body's move with it, as they are correlated.
        parameters: physical parameters by name [SI].
        distance: from the estimate, in its deviations: root of (u - u^)^T C^-1 (u - u^); 0 where the estimate is one.
        degrees_of_freedom: of the constraints that are reached.
        p_at_most: chance that noise takes the estimate of this very body so far off or further, from above: half of
            that of chi-square with one degree of freedom less, and half of that with all. For one constraint that is
            right to first order. 1 where the estimate is one.
        broken: what the estimate does not keep: inertia, mass, or keys of [bounds].
    """

    linear: tuple[float, ...]
    parameters: Mapping[str, float]
    distance: NonNegativeFloat
    degrees_of_freedom: int
    p_at_most: float
    broken: tuple[str, ...]

    @property
    def moved(self) -> bool:
        """Whether it differs from the estimate."""
        return bool(self.broken)

    @property
    def impossible(self) -> bool:
        """Whether noise does not take the inertia of a body so far off."""
        return INERTIA_HOLDS in self.broken and self.p_at_most < IMPOSSIBLE

    @property
    def words(self) -> str:
        """What an estimate does not keep, and how far the nearest body that can exist is."""
        what = {INERTIA_HOLDS: "no body has the estimated inertia", MASS_HOLDS: "no body has the estimated mass"}
        broken = " and ".join(what.get(name, f"the estimate does not keep {name}") for name in self.broken)
        nearest = f"the nearest body that can exist is {self.distance:.2g} deviations off"
        rare = f"p at most {self.p_at_most:.2g}" if self.p_at_most >= RAREST else f"p below {RAREST:.0e}"
        return f"{broken}; {nearest} ({rare})"


class _Constraint(NamedTuple):
    """row @ b + shift >= 0 of parameters b of a body."""

    name: str
    row: Array  # shape (b,), over the scale of its unit
    shift: float = 0.0

    def slack(self, b: Array) -> float:
        """How far inside, as a share of its scale."""
        return float(self.row @ b) + self.shift


def nearest_body(
    model: Model, u: Array, covariance: Array, robust: Array, bounds: Bounds | None = None
) -> NearestBody | None:
    """The nearest body that can exist and keeps bounds; None where the model has none, or none keeps what is given.

    Models without inertia have a mass and a centre of gravity: any positive mass can exist. Of sensors that carry the
    rods of struts the body is that of platform and rods.

    Args:
        model: model of the parameters.
        u: estimate, shape (u,) [SI].
        covariance: by (28), shape (u, u); what was given does not vary.
        robust: the one that allows for noise with memory and tolerances, shape (u, u).
        bounds: of the body; None where there are none.
    """
    if MASS not in model.blocks:
        return None
    places = body_places(model)
    free = Free.of(covariance)
    wide = larger_of(free.down @ covariance @ free.down.T, free.down @ robust @ free.down.T)
    every = free.lift @ wide @ free.lift.T
    subspace = Free.of(every[np.ix_(places, places)])
    inside = subspace.down @ every[np.ix_(places, places)] @ subspace.down.T
    root = subspace.lift @ np.linalg.cholesky(inside)  # C = root root^T
    at = u[places]
    unit = _unit_of(at, np.sqrt(np.diag(every)[places]))
    constraints = tuple(_linear(unit, len(places), bounds))
    turn = unit.congruence
    broken = [c.name for c in constraints if c.slack(at) < 0.0]
    if len(places) > STATIC and np.linalg.eigvalsh(turn @ pseudo_inertia(at) @ turn.T)[0] < 0.0:
        broken.insert(0, INERTIA_HOLDS)
    broken = list(dict.fromkeys(broken))
    if not broken:
        return _body(model, u, 0.0, 0, ())
    y = _projected(at, root, turn, constraints, len(places) > STATIC)
    if y is None:
        return None
    body = at + root @ y
    reached = sum(c.slack(body) < BINDS for c in constraints)
    if len(places) > STATIC:
        flat = int(np.sum(np.linalg.eigvalsh(turn @ pseudo_inertia(body) @ turn.T) < BINDS))
        reached += flat * (flat + 1) // 2
    freedom = max(1, min(int(reached), root.shape[1]))
    others = every[:, places] @ np.linalg.pinv(root).T  # covariance of u and y
    others[places] = root
    return _body(model, u + others @ y, float(np.linalg.norm(y)), freedom, tuple(broken))


def body_places(model: Model) -> list[int]:
    """Places in u of mass, first moments and, where the model has it, inertia."""
    blocks = (MASS, FIRST_MOMENT, *((INERTIA,) if INERTIA in model.blocks else ()))
    return [model.names.index(p.name) for block in blocks for p in block.parameters]


def pseudo_inertia(b: Array) -> Array:
    """J of mass, first moments and inertia about the origin, shape (10,) -> (4, 4) [kg m^2, kg m, kg]."""
    inertia = np.zeros((3, 3))
    for (i, j), value in zip(INERTIA_INDEX, b[4:], strict=True):
        inertia[i, j] = inertia[j, i] = value
    spread = 0.5 * np.trace(inertia) * np.eye(3) - inertia
    return np.block([[spread, b[1:4, None]], [b[None, 1:4], b[0]]])


class _Unit(NamedTuple):
    """Mass, place and length in which a body is of about unit size."""

    mass: float  # [kg]
    centre: Array  # shape (3,) [m]
    length: float  # [m]

    @property
    def congruence(self) -> Array:
        """T of T J T^T, about the centre and without units, shape (4, 4)."""
        root = np.sqrt(self.mass)
        upper = np.hstack([np.eye(3), -self.centre[:, None]]) / (root * self.length)
        return np.vstack([upper, [0.0, 0.0, 0.0, 1.0 / root]])


def _unit_of(b: Array, deviations: Array) -> _Unit:
    """Of parameters of a body, possible or not, and their deviations, shapes (b,)."""
    mass = float(b[0]) if b[0] > 0.0 else max(abs(float(b[0])), float(deviations[0]), 1e-9)
    centre = b[1:4] / b[0] if b[0] > 0.0 else np.zeros(3)
    if len(b) == STATIC:
        return _Unit(mass, centre, 1.0)
    spread = 0.5 * float(b[4] + b[7] + b[9]) - mass * float(centre @ centre)  # of the mass about its centre
    size = max(abs(spread), float(np.linalg.norm(deviations[4:])), 1e-12)
    return _Unit(mass, centre, float(np.sqrt(size / mass)))


def _linear(unit: _Unit, size: int, bounds: Bounds | None) -> Iterator[_Constraint]:
    """Of the mass, and of each bound."""
    one = np.eye(size)
    yield _Constraint(MASS_HOLDS, one[0] / unit.mass, 0.0)
    if bounds is None:
        return
    if bounds.mass_kg is not None:
        low, high = bounds.mass_kg
        yield _Constraint("bounds.mass_kg", one[0] / (high - low), -low / (high - low))
        yield _Constraint("bounds.mass_kg", -one[0] / (high - low), high / (high - low))
    for key in ("centre_of_gravity_mm", "body_mm"):
        box: BodyBox | None = getattr(bounds, key)
        if box is None:
            continue
        for k, (low, high) in enumerate(box.ends.T):
            scale = unit.mass * (high - low)
            yield _Constraint(f"bounds.{key}", (one[1 + k] - low * one[0]) / scale)
            yield _Constraint(f"bounds.{key}", (high * one[0] - one[1 + k]) / scale)
            if key == "body_mm" and size > STATIC:  # (x - low)(high - x), summed over the mass
                spread = 0.5 * (one[4] + one[7] + one[9]) - one[(4, 7, 9)[k]]
                inside = (low + high) * one[1 + k] - low * high * one[0] - spread
                yield _Constraint(f"bounds.{key}", inside / (scale * (high - low)))


def _projected(at: Array, root: Array, turn: Array, constraints: tuple[_Constraint, ...], whole: bool) -> Array | None:
    """The shortest y for which at + root y keeps all constraints, shape (y,); None where none does.

    Args:
        whole: whether the body has an inertia; then T J T^T has no negative eigenvalue either.
    """
    if not root.shape[1]:  # all of it was given
        return None
    import clarabel
    from scipy.sparse import csc_matrix

    rows = np.array([c.row for c in constraints])
    blocks = [-rows @ root]
    sides = [np.array([c.slack(at) for c in constraints]) - BODY_MARGIN]
    cones: list[Any] = [clarabel.NonnegativeConeT(len(rows))]
    if whole:
        columns = [_triangle(turn @ pseudo_inertia(column) @ turn.T) for column in root.T]
        blocks.append(-np.reshape(columns, (-1, 10)).T)
        sides.append(_triangle(turn @ pseudo_inertia(at) @ turn.T - BODY_MARGIN * np.eye(4)))
        cones.append(clarabel.PSDTriangleConeT(4))
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = 1e-10
    size = root.shape[1]
    quadratic, zero = csc_matrix(np.eye(size)), np.zeros(size)
    solver = clarabel.DefaultSolver(quadratic, zero, csc_matrix(np.vstack(blocks)), np.hstack(sides), cones, settings)
    solution = solver.solve()
    if solution.status not in (clarabel.SolverStatus.Solved, clarabel.SolverStatus.AlmostSolved):
        return None
    return np.array(solution.x)


def _triangle(square: Array) -> Array:
    """The upper triangle column by column, its products times root two, shape (4, 4) -> (10,)."""
    columns = [square[i, j] * (1.0 if i == j else np.sqrt(2.0)) for j in range(4) for i in range(j + 1)]
    return np.array(columns)


def _body(model: Model, u: Array, distance: float, freedom: int, broken: tuple[str, ...]) -> NearestBody:
    """A nearest body of u, shape (u,)."""
    form = physical_form(model)
    values = form.map(u)[0].full()[:, 0].tolist()
    above = 0.5 * (chdtrc(freedom - 1, distance**2) * (freedom > 1) + chdtrc(freedom, distance**2)) if broken else 1.0
    return NearestBody(
        linear=tuple(u.tolist()),
        parameters={p.name: v for p, v in zip(form.parameters, values, strict=True)},
        distance=distance,
        degrees_of_freedom=freedom,
        p_at_most=float(above),
        broken=broken,
    )
