"""The optimal excitation problem of a family: its program with every limit that can bind.

Limits that are non-linear in the coordinates are CasADi expressions: those of the machine, and sensor forces. Each is
in units of itself and satisfied where every component lies between -1 and 1. `identification.limits.proof` proves them
by other means.
"""

from functools import lru_cache

import casadi as ca
import numpy as np

from cases.base.units import Array
from cases.schema import Case
from identification.estimation.criteria import box_middle
from identification.limits.limit import LimitKind
from identification.limits.sensor_loads import SHARE
from identification.machines.of_case import machine_of
from identification.model.model import Model, identification_model
from identification.model.parameters import nominal_parameters
from identification.motion.motion import Trajectory
from planner.families.family import Family
from planner.families.rows import StateRows
from planner.families.states import Kernel, state_size
from planner.noise import PoseErrors
from planner.search.nlp import NonlinearProgram, regressor_kernel
from planner.search.objective import FieldByStates

CHECK_RATE = 1000.0  # [1/s] rate at which a motion is checked between the constrained instants


Limits = tuple[tuple[LimitKind, int, Kernel], ...]
"""Limits by kinds: the order of the derivative with which those of a kind grow most (0 poses, 1 velocities, 2
accelerations), and state -> shares of these limits."""


def largest_shares(program: NonlinearProgram, motion: Trajectory, case: Case) -> tuple[float, ...]:
    """The largest share of each limit along the whole motion: rows constrain it at some instants only.

    One number for each order of the coordinates (pose, rates, accelerations, jerks), then one for each of the program's
    non-linear limits.
    """
    box, (middle, half) = case.need_motion("planning")[1], box_middle(case)
    samples = motion.at(np.linspace(0.0, motion.duration, max(2, int(motion.duration * CHECK_RATE))))
    pose = (samples.coordinates - middle) / half
    shares = [pose, samples.rates / box.rate, samples.accelerations / box.acceleration, samples.jerks / box.jerk]
    states = np.hstack([samples.coordinates, samples.rates, samples.accelerations, np.zeros((len(pose), 1))])
    shares += [kernel.values(states) for kernel in program.limits]
    return tuple(float(np.abs(share).max()) for share in shares)


def build_program(
    case: Case,
    model: Model,
    family: Family,
    scaling: Array,
    margin: float,
    errors: PoseErrors | None = None,
    known: Array | None = None,
) -> NonlinearProgram:
    """The program of criterion D with every limit of a family that can bind.

    Args:
        scaling: reference scaling, shape (u,).
        margin: share of each limit that stays unused.
        errors: errors of the pose, which the information counts.
        known: information of earlier results, in units of the mean information, shape (u, u).
    """
    layout, limits, states = family.layout(case, margin), near_limits(case), _extreme_states(case)
    first, rows = [], []
    for _, order, kernel in limits:
        binds = np.abs(kernel.values(states)).max(axis=0) > BINDS
        peaks = np.repeat(layout.peaks[order][:, :, None], kernel.size, axis=2)
        rows.append(StateRows(layout.critical, kernel, peaks & binds, 1.0 - margin))
        if order == 0 and (standing := layout.standing) is not None:
            shape = *standing.at(np.zeros(len(layout.lower))).shape[:2], kernel.size
            first.append(StateRows(standing, kernel, np.ones(shape, dtype=bool), 1.0 - margin))
    return NonlinearProgram(
        layout.states,
        regressor_kernel(model, scaling),
        (*layout.rows, *first, *rows),
        layout.lower,
        layout.upper,
        errors=None if errors is None else FieldByStates(errors, family.duration),
        known=known,
        limits=tuple(kernel for _, _, kernel in limits),
        own=len(layout.rows),
    )


RIGID_BODY = 6  # the smallest model with mass, first moments and inertia
CANDIDATES = 4000  # states of the box that show which limits can bind
NEAR = 0.9  # largest share in the box below which the optimiser need not constrain a limit: the proof checks it
NEARLY = 0.75  # the same of one joint or sensor beside others that come nearer: random states seldom find its largest
OF_LOADS = (LimitKind.JOINT_TORQUE, LimitKind.SENSOR_FORCE)  # accelerations and each load cause them
BINDS = 1.05  # share from which a limit is constrained from the start; others are where they come close
SEED = 7


def state_limits(case: Case, loads: tuple[int, ...] = ()) -> Limits:
    """The non-linear limits of a case.

    Args:
        case: machine, limits and sensors.
        loads: numbers of payloads with which predicted sensor forces are limited, in this order.
    """
    n = len(box_middle(case)[0])
    state = ca.SX.sym("state", state_size(n))
    motion = state[:n], state[n : 2 * n], state[2 * n : 3 * n]
    groups = [
        *machine_of(case).shares(case, *motion),
        *((LimitKind.SENSOR_FORCE, 2, f) for f in _sensor_forces(case, loads, *motion)),
    ]
    names = machine_of(case).named_distances  # those of the first
    names = names + [""] * (len(groups) - len(names))
    return tuple(
        (kind, order, Kernel(state, share, name)) for (kind, order, share), name in zip(groups, names, strict=True)
    )


@lru_cache(maxsize=2)
def near_limits(case: Case) -> Limits:
    """The non-linear limits that come close somewhere in the motion box, judged by seeded states of it.

    Poses are uniform, and half of them at corners; rates and accelerations are at corners. Of forces and torques those
    of the joints and sensors count that come close themselves, and of several payloads those with which they are
    largest in at least one of the states. The limits of the last cases are kept, with the derivatives that were built
    of them: a process runs several starts of a search.
    """
    states = _extreme_states(case)
    near: list[tuple[LimitKind, int, Kernel]] = []
    by_load: dict[LimitKind, list[Kernel]] = {}
    loads = tuple(range(len(case.bodies))) if case.sensors.range is not None else ()
    for kind, order, kernel in state_limits(case, loads):
        if kind in OF_LOADS:
            by_load.setdefault(kind, []).append(kernel)
        elif np.abs(kernel.values(states)).max() > NEAR:
            near.append((kind, order, kernel))
    for kind, kernels in by_load.items():
        shares = np.abs([kernel.values(states) for kernel in kernels])
        if shares.max() > NEAR:
            largest = (shares == shares.max(axis=0)) & (shares > NEARLY)
            every = ca.vertcat(*(kernel.expression for kernel in kernels))
            chosen = np.flatnonzero(largest.any(axis=1).ravel()).tolist()
            near.append((kind, 2, Kernel(kernels[0].variables, every[chosen])))
    return tuple(near)


def standing_limits(case: Case) -> ca.Function:
    """Coordinates -> shares of the limits that a standstill uses, also of torques, and sensor forces with each load."""
    count = len(box_middle(case)[0])
    pose, still = ca.SX.sym("pose", count), ca.SX.zeros(count)
    loads = tuple(range(len(case.bodies))) if case.sensors.range is not None else ()
    of_machine = [share for _, _, share in machine_of(case).shares(case, pose, still, still)]
    shares = ca.vertcat(ca.SX(0, 1), *of_machine, *_sensor_forces(case, loads, pose, still, still))
    return ca.Function("standing_limits", [pose], [ca.densify(shares)], {"cse": True})


def _extreme_states(case: Case) -> Array:
    home, box = case.need_motion("planning")
    n = len(home)
    draw = np.random.default_rng(SEED)
    pose = draw.uniform(box.coordinates[0], box.coordinates[1], (CANDIDATES, n))
    corners = draw.random((CANDIDATES // 2, n)) < 0.5
    pose[::2] = np.where(corners, box.coordinates[0], box.coordinates[1])
    signs = draw.choice((-1.0, 1.0), (2, CANDIDATES, n))
    return np.hstack(
        [home + pose, signs[0] * box.rate, signs[1] * box.acceleration, np.zeros((CANDIDATES, state_size(n) - 3 * n))]
    )


def _sensor_forces(case: Case, loads: tuple[int, ...], pose: ca.SX, rates: ca.SX, accelerations: ca.SX) -> list[ca.SX]:
    """Shares of 80 % of the sensors' range: (18) with the columns of a rigid body alone, offsets and errors apart."""
    if not loads:
        return []
    if (most := case.sensors.range) is None:
        case.missing("sensors.range_N", "a limit of predicted sensor forces")
    model = identification_model(case, RIGID_BODY)
    regressor = model.coordinate_regressor.call([pose, rates, accelerations], True, False)[0]
    shares = []
    for count in loads:
        u = ca.DM(nominal_parameters(model, case.body(count)))
        shares.append(regressor @ u / ca.DM(SHARE * most))
    return shares
