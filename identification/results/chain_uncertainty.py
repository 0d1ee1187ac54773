"""How uncertain external forces are anywhere in the motion box of a machine: what an exported signal chain promises."""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import casadi as ca
import numpy as np
from scipy.spatial.transform import Rotation

from cases.base.units import Array
from cases.schema import Case
from identification.findings.left_out import LeftOut
from identification.machines.casadi_batch import over_samples
from identification.machines.hexapod import Hexapod
from identification.machines.machine import Kinematics, Machine
from identification.machines.of_case import machine_if_any
from identification.model.model import expected_forces
from identification.results.expected_residuals import Used, noise_left
from identification.results.frames import Place
from identification.results.result import Result
from identification.samples.samples import MotionOfSamples

STATES = 200  # of the machine, drawn in its motion box
SEED = 0  # of these draws
MOMENT = 1e-5  # [s] for the derivative of forces with the delay: far below what motions change in


class Anywhere(NamedTuple):
    """Expanded uncertainty (k = 2) of force and moment from outside in a frame, wherever the machine is."""

    expanded: Array  # U of each component where nothing acts from outside: the largest of many states, shape (6,)
    # what it has more by for 1 N or N m from outside of each component (columns), as root of a sum of squares, (6, 6)
    shares: Array
    counts: tuple[str, ...]  # kinds of causes that it counts
    not_counted: Sequence[str]  # kinds of tolerances that the case does not state
    states: int  # that it is the largest of

    def of(self, wrench: Array) -> Array:
        """U of each component where force and moment act from outside, shape (6,)."""
        return np.asarray(np.sqrt(self.expanded**2 + (self.shares * wrench) ** 2 @ np.ones(6)))


def anywhere(result: Result, place: Place) -> Anywhere:
    """The uncertainty of external forces of a machine in the motion box of its case.

    Counted are noise of the channels behind the filter of the case, noise of the parameters, the delay where it was
    estimated, and its tolerances. A case without a machine has random orientations at rest; one without limits of
    motion stands at home.
    """
    case = result.case_as_told
    motion = states_of(result, case)
    count = 1 if motion is None else len(motion.load.pose)
    none = np.zeros((count, 6))
    noise = noise_left(result)[1] ** 2
    late = None if motion is None else _late(result, case, motion)
    used = Used(result, case, np.arange(float(count)), none, motion, noise, late, (), None)
    into = np.broadcast_to(used.into(place), (count, 6, 6))
    parts = used.variances(place, into, none)
    resting = used.errors(slice(None), place, into, none).by_tolerance
    shares = np.zeros((6, 6))
    for k, axis in enumerate(np.eye(6)):
        wrenches = np.broadcast_to(axis, (count, 6))
        residuals: Array = np.asarray(np.linalg.solve(into, wrenches[:, :, None])[:, :, 0], dtype=float)
        pulled = replace(used, residuals=residuals)
        for key, factors in pulled.errors(slice(None), place, into, wrenches).by_tolerance.items():
            more = np.sum((factors - resting[key]) ** 2, axis=-1)
            shares[:, k] += more.max(axis=0)
    expanded = 2.0 * np.sqrt(sum(parts.values(), none).max(axis=0))
    counted = tuple(kind for kind, variance in parts.items() if variance.any())
    return Anywhere(expanded, 2.0 * np.sqrt(shares), counted, result.not_counted, count)


def states_of(result: Result, case: Case) -> MotionOfSamples | None:
    """States of a machine that are drawn in its motion box; None where the frame of the sensors stands."""
    if case.setup == "1a":
        return None
    draw, machine = np.random.default_rng(SEED), machine_if_any(case)
    known = np.ones(STATES, dtype=bool)
    if machine is None:
        angles = Rotation.random(STATES, random_state=draw).as_euler("xyz")
        still = np.zeros((STATES, 6))
        return MotionOfSamples(known, Kinematics(np.hstack([0.0 * angles, angles]), still, still))
    if case.limits is None:
        home = case.chain.home if case.chain is not None else _home(case)
        rows = np.nan_to_num(np.broadcast_to(home, (1, len(home))))
        return _moving(result, case, machine, rows, 0.0 * rows, 0.0 * rows)
    return _moving(result, case, machine, *_drawn(case)[:3])


def _drawn(case: Case) -> tuple[Array, Array, Array, Array]:
    """Coordinates, rates, accelerations and jerks anywhere within the limits of motion of a case, shapes (n, k)."""
    draw = np.random.default_rng(SEED)
    home, limits = case.need_motion("the uncertainty of exported forces")
    low, high = limits.coordinates
    shape = (STATES, len(home))
    at = home + draw.uniform(low, high, shape)
    most = (limits.rate, limits.acceleration, limits.jerk)
    rates, accelerations, jerks = (of * draw.uniform(-1.0, 1.0, shape) for of in most)
    return at, rates, accelerations, jerks


def _late(result: Result, case: Case, motion: MotionOfSamples) -> Array | None:
    """How the forces of states change with the delay, shape (n, 6) [1/s], under jerks that are drawn as the states are.

    None where they stand.
    """
    if case.limits is None or motion.machine is None:
        return None
    at, rates, accelerations, jerks = _drawn(case)
    later = (at + MOMENT * rates, rates + MOMENT * accelerations, accelerations + MOMENT * jerks)
    then = _moving(result, case, motion.machine, *later).load
    now, after = (expected_forces(result.model, load, result.values) for load in (motion.load, then))
    return np.asarray((now - after) / MOMENT)


def _home(case: Case) -> Array:
    assert case.hexapod is not None
    return case.hexapod.home.vector


def _moving(result: Result, case: Case, machine: Machine, at: Array, rates: Array, bends: Array) -> MotionOfSamples:
    """States at coordinates with their rates and accelerations, shapes (n, k)."""
    symbols = [ca.SX.sym(name, machine.count) for name in ("coordinates", "rates", "accelerations")]
    position, turn, twist, rate = machine.frame(*symbols)
    frame = ca.Function("frame", symbols, [ca.densify(v) for v in (position, turn, twist, rate)])
    positions, turns, twists, twist_rates = over_samples(frame, at, rates, bends)
    angles = Rotation.from_matrix(turns.reshape(-1, 3, 3)).as_euler("xyz")
    load = Kinematics(np.hstack([positions.reshape(-1, 3), angles]), twists.reshape(-1, 6), twist_rates.reshape(-1, 6))
    motion = MotionOfSamples(np.ones(len(at), dtype=bool), load, (at, rates, bends), machine)
    if not isinstance(machine, Hexapod):
        return motion
    struts = LeftOut.in_use(result.model, motion, result.values, np.zeros((len(at), 6)), case)
    return motion._replace(drives=struts.by_struts)
