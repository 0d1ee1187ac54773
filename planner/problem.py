"""The D-optimal excitation problem of a family that is linear in its unknowns, as a non-linear program.

Every motion family that maps its unknowns linearly to samples (Fourier series, B-splines) shares it. Limits on
coordinates are linear rows; those that the family proves to be implied by others are left out. Strut limits are
non-linear and bind at few samples: they enter only for the samples that are named.
"""

from dataclasses import dataclass
from typing import Protocol

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from cases.schema import Case
from identification.evaluate import over_samples
from identification.hexapod import Hexapod
from identification.model import Model
from identification.motion import Trajectory
from planner.information import log_determinant, sample_information

Array = NDArray[np.float64]


class LinearFamily(Protocol):
    """Motions whose coordinates are linear in their unknowns, around home, in half widths of the box."""

    @property
    def unknowns(self) -> int:
        """Unknowns of each coordinate, q."""
        ...

    def maps(self) -> tuple[Array, Array, Array, Array]:
        """Matrices (K, q) from unknowns to value, rate, acceleration and jerk on the grid, in box half widths."""
        ...

    def growth(self) -> float:
        """A bound g with max|x'| <= g max|x| for every motion of the family [1/s]; infinity where there is none."""
        ...

    def motion(self, unknowns: Array) -> Trajectory:
        """The motion of unknowns of shape (q * 6,)."""
        ...


@dataclass(frozen=True)
class Problem:
    """A program in unknowns of shape (q * 6,), row by row: minimise `objective` subject to -1 <= `rows` <= 1.

    Args:
        unknowns: the symbol.
        objective: -log det F / u, F the mean information over the grid in reference scaling.
        rows: linear rows in units of their limits.
        strut_motion: strut lengths, velocities and accelerations over the grid in units of their limits, a Function to
            (18, K).
    """

    unknowns: ca.MX
    objective: ca.MX
    rows: ca.MX
    strut_motion: ca.Function

    def with_struts(self, active: NDArray[np.bool_]) -> ca.MX:
        """Rows with the strut limits where `active`, shape (18, K), is set."""
        columns = np.flatnonzero(active.any(axis=0))
        if not len(columns):
            return self.rows
        values = ca.vec(self.strut_motion(self.unknowns)[:, columns.tolist()])
        return ca.vertcat(self.rows, values[np.flatnonzero(active[:, columns].T).tolist()])


def strut_shares(problem: Problem, unknowns: Array) -> Array:
    """Share of each strut limit that is used at each sample of the grid, shape (18, K)."""
    return np.asarray(np.abs(problem.strut_motion(unknowns).full()))


def build_problem(case: Case, model: Model, family: LinearFamily, scaling: Array) -> Problem:
    """Builds the program.

    Args:
        case: machine and limits.
        model: parameters to be identified.
        family: what the unknowns mean.
        scaling: reference scaling, shape (u,).
    """
    machine, workspace, limits = case.need_machine("planning")
    box = limits.motion
    half, middle = (box.pose[1] - box.pose[0]) / 2, (box.pose[1] + box.pose[0]) / 2
    maps = [ca.sparsify(ca.DM(m)) for m in family.maps()]
    count = maps[0].shape[0]
    unknowns = ca.MX.sym("unknowns", family.unknowns * 6)
    table = ca.reshape(unknowns, 6, family.unknowns).T
    shares = [m @ table for m in maps]  # (K, 6) in half widths of the box
    to_si = ca.diag(ca.DM(half))
    pose = shares[0] @ to_si + ca.repmat(ca.DM(machine.home.vector + middle).T, count, 1)
    samples = (pose.T, (shares[1] @ to_si).T, (shares[2] @ to_si).T)

    mean = ca.sum2(sample_information(model, scaling).map(count)(*samples)) / count
    objective = -log_determinant(len(scaling))(mean) / len(scaling)

    rows = [ca.vec(shares[0])]
    reached = np.ones(6)  # what is known to bound the derivative before, in half widths
    for share, limit in zip(shares[1:], (box.rate, box.acceleration, box.jerk), strict=True):
        reached = family.growth() * reached
        own = limit / half
        needed = np.flatnonzero(reached > own).tolist()
        reached = np.minimum(reached, own)
        if needed:
            rows.append(ca.vec((share @ ca.diag(ca.DM(1.0 / own)))[:, needed]))

    length, velocity, acceleration = Hexapod.of(case).strut_motion.map(count)(*samples)
    shortest = max(box.strut_length[0], workspace.strut_length[0])
    longest = min(box.strut_length[1], workspace.strut_length[1])
    struts = ca.vertcat(
        (length - (longest + shortest) / 2) / ((longest - shortest) / 2),
        velocity / box.strut_velocity_m_s,
        acceleration / box.strut_acceleration_m_s2,
    )
    return Problem(unknowns, objective, ca.vertcat(*rows), ca.Function("struts", [unknowns], [struts]))


def mean_information(model: Model, scaling: Array, trajectory: Trajectory, rate: float = 1000.0) -> Array:
    """Time average of H A^T A H over a trajectory, shape (u, u); W = 1.

    Args:
        model: gives A.
        scaling: diagonal of H, shape (u,).
        trajectory: the whole excitation.
        rate: samples a second [1/s].
    """
    count = max(2, int(np.ceil(trajectory.duration * rate)))
    motion = trajectory.at((np.arange(count) + 0.5) * trajectory.duration / count)
    matrices = over_samples(model.coordinate_regressor, motion.pose, motion.rates, motion.accelerations)[0]
    rows = matrices.reshape(-1, len(scaling)) * scaling
    return np.asarray(rows.T @ rows / count)
