"""Hypotheses tried on instants of a run: the model is fitted under each of them, at every delay, and leaves residuals.

What changes the motion or the case gives regressors A of its own. With the orthonormal basis Q of their columns a fit
leaves |f|^2 - |Q^T f|^2, for recorded forces f of any order, sign or axes: one projection serves all hypotheses about
channels. The delay is found on the parabola through three delays of a grid.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from cases.base.errors import HexciteError
from cases.base.units import Array, Flags
from cases.schema import Case
from identification.estimation.fit import column_scale
from identification.findings.causes.hypothesis import (
    FAMILIES,
    RECORDED,
    SENSED,
    Family,
    Trial,
    case_of,
    channels_of,
    drives_of,
    pace_of,
)
from identification.findings.causes.instants import Instants
from identification.machines.casadi_batch import over_samples
from identification.machines.hexapod import kinematics_of_hexapods
from identification.machines.serial_chain import SerialChain
from identification.model.model import identification_model

AT_ONCE = 24_000  # samples whose regressors are in memory
STEPS = 9  # of Newton's method: under a right hypothesis home is near enough
FEWEST = 5  # instants that show whether a machine can have some drives
FEW = 6  # changes of the forces, from which on they share one projection
SINGULAR = 1e-9  # of the largest singular value of scaled regressors
CERTAIN = 3.0  # standard deviations below zero, from which on a mass is negative


class Outcome(NamedTuple):
    """What trials leave: rows are those that change motion or case, columns those that change forces alone."""

    residuals: Array  # rms residuals over the noise, shape (H, J); infinite where nothing fits, or no mass is so
    delays: Array  # at which they are least, shape (H, J) [s]
    masses: Array  # fitted mass, shape (H, J) [kg]; NaN where the model has none


class _Motion(NamedTuple):
    """Motion of the sensor of H trials at n instants."""

    positions: Array  # shape (H, n, 3) [m]
    rotations: Array  # R, shape (H, n, 3, 3)
    twists: Array  # shape (H, n, 6)
    rates: Array  # shape (H, n, 6), less what gravity is off by
    closed: Flags  # whether the machine can have such drives, shape (H,)


def tried(instants: Instants, changes: Sequence[Trial], channels: Sequence[Trial]) -> Outcome:
    """What each of some changes of motion or case leaves, together with each of some changes of the forces.

    Args:
        instants: they are tried on.
        changes: they may change forces too, before the others do.
        channels: they change forces alone. Of other bars, which change what the model expects of each sensor, residuals
            are those of the sensors of the case, near enough to choose by.
    """
    matrices = np.array([_of_sensors(instants, trial) for trial in channels])
    size = max(1, AT_ONCE // len(instants.rows))
    parts = [_tried(instants, changes[k : k + size], matrices) for k in range(0, len(changes), size)]
    return Outcome(*(np.concatenate(values) for values in zip(*parts, strict=True)))


def _of_sensors(instants: Instants, trial: Trial) -> Array:
    """What recorded forces are multiplied by where the case's own bars are taken for those of a trial, shape (6, 6)."""
    case = case_of(trial, instants.case, ("case",))
    if case.sensor_frame is instants.case.sensor_frame:
        return channels_of(trial)
    return np.asarray(np.linalg.solve(instants.model.structure, case.sensor_frame.structure) @ channels_of(trial))


def closing(instants: Instants, changes: Sequence[Trial]) -> list[Trial]:
    """Those of some changes under which the machine can have the recorded drives, at some instants."""
    few = instants.part(FEWEST)
    size = max(1, AT_ONCE // len(few.rows))
    parts = [changes[k : k + size] for k in range(0, len(changes), size)]
    closed = [_motion(few, part, [case_of(trial, few.case, ("case",)) for trial in part]).closed for part in parts]
    return [trial for trial, ok in zip(changes, np.concatenate(closed), strict=True) if ok] if changes else []


def _tried(instants: Instants, changes: Sequence[Trial], matrices: Array) -> Outcome:
    count = len(changes)
    regressors, motion = regressors_of(instants, changes)
    own = np.array([channels_of(trial) for trial in changes])
    noise = np.sqrt(np.einsum("hij,j->hi", own**2, instants.noise**2))  # of the forces that the changes make
    root = np.where(motion.closed[:, None, None], instants.weights[None, :, None] / noise[:, None, :], 0.0)
    rows = (regressors * root[:, :, :, None]).reshape(count, -1, regressors.shape[3])
    scale = np.array([column_scale(each) for each in rows])
    basis, triangle = np.linalg.qr(rows * scale[:, None, :])
    unknowns, delays, n = rows.shape[2], len(instants.delays), len(instants.rows)
    whole = basis.reshape(count, n, 6, unknowns) * root[:, :, :, None]
    forces = _forces(instants, changes, own, motion.rotations)  # shape (H or 1, D, n, 6)
    explained = _explained(whole, forces, matrices)
    right = forces.transpose(0, 2, 1, 3)
    weighted = right * instants.weights[None, :, None, None]
    products = np.einsum("hnda,hndb->hdab", weighted, weighted, optimize=True)
    sizes = np.einsum("jia,hdab,jib->hdji", matrices, products, matrices, optimize=True)
    total = np.einsum("hdji,hi->hdj", np.broadcast_to(sizes, (count, *sizes.shape[1:])), 1.0 / noise**2, optimize=True)
    left = np.maximum(total - np.sum(explained**2, axis=2), 0.0)
    least, place = _parabola(left / max(6 * n - unknowns, 1))
    shares = np.einsum("jia,a,i->ji", matrices**2, instants.noise**2, 1.0 / instants.noise**2)
    least = least / np.mean(shares, axis=1)  # noise that the matrices make of that of the forces
    mass = _mass(instants, triangle, scale, explained, place, least)
    residuals = np.where(motion.closed[:, None] & ~mass.negative, np.sqrt(least), np.inf)
    return Outcome(residuals, np.interp(place, np.arange(delays), instants.delays), mass.values)


def _explained(whole: Array, forces: Array, matrices: Array) -> Array:
    """How much of the forces, changed by each matrix, lies along the basis, shape (H, D, u, J).

    Args:
        whole: basis of each trial, weighted, shape (H, n, 6, u).
        forces: shape (H or 1, D, n, 6).
        matrices: shape (J, 6, 6).
    """
    count, n, _, unknowns = whole.shape
    delays = forces.shape[1]
    if len(matrices) < FEW:
        flat = whole.reshape(count, n * 6, unknowns).transpose(0, 2, 1)
        changed = (forces @ matrix.T for matrix in matrices)
        sides = [flat @ each.reshape(len(each), delays, n * 6).transpose(0, 2, 1) for each in changed]
        return np.stack(sides, axis=-1).transpose(0, 2, 1, 3)
    # what a unit of channel a in the place of channel i shows of each direction of the basis
    right = forces.transpose(0, 2, 1, 3).reshape(len(forces), n, delays * 6)
    shown = whole.transpose(0, 2, 3, 1).reshape(count, 6 * unknowns, n) @ right
    shown = shown.reshape(count, 6, unknowns, delays, 6).transpose(0, 3, 2, 1, 4).reshape(-1, 36)
    return np.asarray((shown @ matrices.reshape(-1, 36).T).reshape(count, delays, unknowns, len(matrices)))


def _parabola(values: Array) -> tuple[Array, Array]:
    """Least of values over the second axis, between its places, and where: shapes (H, J)."""
    count = values.shape[1]
    best = np.argmin(values, axis=1)
    if count < 3:
        return np.take_along_axis(values, best[:, None], 1)[:, 0], best.astype(float)
    middle = np.clip(best, 1, count - 2)
    low, mid, high = (np.take_along_axis(values, (middle + k)[:, None], 1)[:, 0] for k in (-1, 0, 1))
    bend, slope = low - 2.0 * mid + high, (high - low) / 2.0
    with np.errstate(divide="ignore", invalid="ignore"):
        step = np.where(bend > 0.0, np.clip(-slope / bend, -1.0, 1.0), 0.0)
    least = mid + slope * step + 0.5 * bend * step**2
    lowest = np.minimum(np.take_along_axis(values, best[:, None], 1)[:, 0], np.maximum(least, 0.0))
    return lowest, middle + step


class _Mass(NamedTuple):
    values: Array  # [kg], shape (H, J)
    negative: Flags  # for certain


class About(NamedTuple):
    """The point that moments must be about for a trial to leave least."""

    point: Array  # from the sensor's origin in its axes, shape (3,) [m]
    residuals: float  # weighted sum of squares; infinite where the machine cannot have such drives


def moments_about(instants: Instants, trial: Trial) -> About:
    """The point that moments must be about for a trial to leave least: the forces depend on it linearly.

    It is in the axes in which moments were taken, before a turn of the sensor takes effect on them.
    """
    regressors, motion = regressors_of(instants, [trial])
    if not motion.closed[0]:
        return About(np.zeros(3), np.inf)
    own = channels_of(trial)
    root = (instants.weights[:, None] / np.sqrt(own**2 @ instants.noise**2))[:, :, None]
    rows = (regressors[0] * root).reshape(-1, regressors.shape[3])
    basis = np.linalg.qr(rows * column_scale(rows))[0]
    later = channels_of(trial, FAMILIES[FAMILIES.index(Family.POINT) + 1 :])
    earlier = np.linalg.inv(later)
    best: Array = np.zeros(3)
    least = np.inf
    for forces in _forces(instants, [trial], own[None], motion.rotations)[0]:
        columns: Array = np.zeros(
            (len(forces), 6, 4)
        )  # the forces, and what a metre along each axis does to the moments
        columns[:, :, 0] = forces
        columns[:, 3:, 1:] = np.cross(np.eye(3), (forces @ earlier.T)[:, None, :3]).transpose(0, 2, 1)
        columns[:, :, 1:] = later @ columns[:, :, 1:]
        whole: Array = (columns * root).reshape(-1, 4)
        weighted = whole - basis @ (basis.T @ whole)
        point = np.asarray(np.linalg.lstsq(weighted[:, 1:], -weighted[:, 0], rcond=SINGULAR)[0], dtype=float)
        left = float(np.sum((weighted[:, 0] + weighted[:, 1:] @ point) ** 2))
        if left < least:
            best, least = point, left
    return About(best, least)


def _mass(instants: Instants, triangle: Array, scale: Array, explained: Array, place: Array, least: Array) -> _Mass:
    """Fitted mass of each trial."""
    names = instants.model.names
    if "m" not in names:
        return _Mass(np.full(place.shape, np.nan), np.zeros(place.shape, dtype=bool))
    row = names.index("m")
    inverse = np.linalg.pinv(triangle, rcond=SINGULAR)[:, row, :] * scale[:, row, None]  # shape (H, c)
    nearest = np.rint(place).astype(int)
    at = np.take_along_axis(explained, nearest[:, None, None, :], 1)[:, 0]  # shape (H, c, J)
    values = np.einsum("hc,hcj->hj", inverse, at)
    deviation = np.linalg.norm(inverse, axis=1)[:, None] * np.sqrt(least)
    return _Mass(values, values < -CERTAIN * deviation)


def regressors_of(instants: Instants, changes: Sequence[Trial]) -> tuple[Array, _Motion]:
    """A of each of some changes, shape (H, n, 6, u), with columns of nuisances, and the motion behind it."""
    cases = [case_of(trial, instants.case, ("case",)) for trial in changes]
    motion = _motion(instants, changes, cases)
    count, n = motion.positions.shape[:2]
    flat = [values.reshape(count * n, *values.shape[2:]) for values in motion[:4]]
    matrices = instants.model.matrices(*flat).reshape(count, n, 6, -1)
    matrices = _of_other_frames(instants, cases, motion, matrices)
    if instants.turning is not None and instants.turning.specific is not None:
        matrices = np.concatenate([matrices, _turns_of_accelerometer(instants, motion)], axis=3)
    return matrices, motion


def _motion(instants: Instants, changes: Sequence[Trial], cases: Sequence[Case]) -> _Motion:
    count, n = len(changes), len(instants.rows)
    gravity = np.array([instants.case.gravity - case.gravity for case in cases])
    if instants.turning is not None:
        turning, still = instants.turning, np.zeros((count, n, 3))
        rotations = np.broadcast_to(turning.rotations, (count, n, 3, 3))
        omega, alpha = (np.broadcast_to(values, (count, n, 3)) for values in (turning.omega, turning.alpha))
        acceleration = still + gravity[:, None, :]
        if turning.specific is not None:
            acceleration = still + np.einsum("nij,nj->ni", turning.rotations, turning.specific) + instants.case.gravity
        rates = np.concatenate([acceleration, alpha], axis=2)
        twists = np.concatenate([still, omega], axis=2)
        return _Motion(still, rotations, twists, rates, np.ones(count, dtype=bool))
    paths, of_each = _paths(instants, changes, cases)
    rates = paths.rates[of_each]
    rates[:, :, :3] += gravity[:, None, :]
    return _Motion(
        paths.positions[of_each], paths.rotations[of_each], paths.twists[of_each], rates, paths.closed[of_each]
    )


def _paths(instants: Instants, changes: Sequence[Trial], cases: Sequence[Case]) -> tuple[_Motion, list[int]]:
    """Motions of the sensor by the recorded drives, each once, and which of them is that of each change."""
    assert instants.drives is not None
    affine = [drives_of(trial, instants.drives[0].shape[1]) for trial in changes]
    pace = [pace_of(trial) for trial in changes]
    numbers: dict[tuple[bytes, bytes, float, int | None], int] = {}
    keys = [
        (a.matrix.tobytes(), a.offset.tobytes(), s, None if c.machine is instants.case.machine else id(c.machine))
        for a, s, c in zip(affine, pace, cases, strict=True)
    ]
    of_each = [numbers.setdefault(key, len(numbers)) for key in keys]
    first = [keys.index(key) for key in numbers]
    count, n = len(first), len(instants.rows)
    turns = np.array([affine[k].matrix for k in first]).transpose(0, 2, 1)
    offsets = np.array([affine[k].offset for k in first])[:, None, :]
    times = np.array([pace[k] for k in first])[:, None, None]
    places = instants.drives[0] @ turns + offsets
    velocities, accelerations = instants.drives[1] @ turns / times, instants.drives[2] @ turns / times**2
    flat = [values.reshape(count * n, -1) for values in (places, velocities, accelerations)]
    closed = np.ones(count, dtype=bool)
    if isinstance(instants.machine, SerialChain):
        positions, columns, twists, rates = over_samples(instants.machine.motion, *flat)
        rotations = columns.reshape(-1, 3, 3).transpose(0, 2, 1)
    else:
        joints, home = _hexapods([cases[k] for k in first])
        flat_joints, flat_home = np.repeat(joints, n, axis=0), np.repeat(home, n, axis=0)
        kinematics, ok = kinematics_of_hexapods(flat_joints, flat_home, flat[0], flat[1], flat[2], STEPS)
        closed = np.asarray(ok.reshape(count, n).all(axis=1))
        positions, twists, rates = kinematics.pose[:, :3], kinematics.twist, kinematics.twist_rate
        rotations = _rotations(kinematics.pose[:, 3:])
    motion = _Motion(
        positions.reshape(count, n, 3), rotations.reshape(count, n, 3, 3), twists.reshape(count, n, 6),
        rates.reshape(count, n, 6), closed,
    )  # fmt: skip
    return motion, of_each


def _hexapods(cases: Sequence[Case]) -> tuple[Array, Array]:
    """Joints, shape (H, 36) [m], and home, shape (H, 6) [m, rad]."""
    machines = [case.hexapod for case in cases]
    joints = [np.r_[m.base.points.ravel(), m.platform.points.ravel()] for m in machines if m is not None]
    return np.array(joints), np.array([m.home.vector for m in machines if m is not None])


def _rotations(angles: Array) -> Array:
    """R = Rz(yaw) Ry(pitch) Rx(roll), shape (n, 3) -> (n, 3, 3)."""
    from scipy.spatial.transform import Rotation

    return np.asarray(Rotation.from_euler("xyz", angles).as_matrix())


def _of_other_frames(instants: Instants, cases: Sequence[Case], motion: _Motion, matrices: Array) -> Array:
    """A where a case has other bars, or other joints beside sensors in the struts."""
    own = instants.case
    if instants.model.struts is not None:
        for k, case in enumerate(cases):
            if case.machine is not own.machine:
                try:
                    model = identification_model(case, instants.model.number)
                    matrices[k] = model.matrices(*(values[k] for values in motion[:4]))
                except HexciteError:
                    motion.closed[k] = False
        return matrices
    if own.sensor_frame.bars is None:
        return matrices
    for k, case in enumerate(cases):
        if case.sensor_frame is not own.sensor_frame:
            structure = case.sensor_frame.structure
            if not np.linalg.cond(structure) < 1e6:
                motion.closed[k] = False
                continue
            matrices[k] = np.linalg.solve(structure, instants.model.structure) @ matrices[k]
    return matrices


def _turns_of_accelerometer(instants: Instants, motion: _Motion) -> Array:
    """Columns of small turns of the accelerometer, of mass and first moments each, shape (H, n, 6, 12)."""
    turning = instants.turning
    assert turning is not None
    assert turning.specific is not None
    varied = np.stack([np.cross(axis, turning.specific) for axis in np.eye(3)], axis=-1)  # shape (n, 3, 3)
    moments = np.stack([np.cross(axis, varied, axisb=1, axisc=1) for axis in np.eye(3)], axis=-1).reshape(
        len(varied), 3, 9
    )
    wrench = np.zeros((len(varied), 6, 12))
    wrench[:, :3, :3], wrench[:, 3:, 3:] = varied, moments
    columns = np.linalg.solve(instants.model.structure, wrench)
    return np.asarray(np.broadcast_to(columns, (len(motion.positions), *columns.shape)))


def _forces(instants: Instants, changes: Sequence[Trial], own: Array, rotations: Array) -> Array:
    """Forces of each change, shape (H, D, n, 6), or (1, D, n, 6) where none changes them."""
    in_base = [k for k, trial in enumerate(changes) if any(hypothesis.in_base for hypothesis in trial)]
    if not in_base and np.array_equal(own, np.broadcast_to(np.eye(6), own.shape)):
        return instants.forces[None]
    forces = np.einsum("hij,dnj->hdni", own, instants.forces, optimize=True)
    for k in in_base:
        vectors = (instants.forces @ channels_of(changes[k], RECORDED).T).reshape(len(instants.delays), -1, 2, 3)
        sensed = np.einsum("nji,dnbj->dnbi", rotations[k], vectors).reshape(forces[k].shape)
        forces[k] = sensed @ channels_of(changes[k], SENSED).T
    return np.asarray(forces)


class Left(NamedTuple):
    """What a trial leaves at the delay at which it leaves least."""

    newtons: float  # rms of the residuals of forces [N]
    noise: float  # what the noise makes of it [N]
    shaking: float  # what noise of the recorded drives makes of the forces, over their noise


def left_by(instants: Instants, trial: Trial, delay: float) -> Left:
    """Residuals of a trial in newtons, beside what noise makes."""
    regressors, motion = regressors_of(instants, [trial])
    own = channels_of(trial)
    noise = np.sqrt(own**2 @ instants.noise**2)
    newtons = slice(0, 3 if instants.case.sensor_frame.has_moments else 6)
    of_noise = float(np.sqrt(np.mean(noise[newtons] ** 2)))
    if not motion.closed[0]:
        return Left(np.inf, of_noise, 0.0)
    nearest = int(np.argmin(np.abs(instants.delays - delay)))
    forces = _forces(instants, [trial], own[None], motion.rotations)[0]
    at = forces[nearest]
    if len(instants.delays) > 2:  # along the straight line to the other neighbour
        other = int(np.clip(nearest + (1 if delay > instants.delays[nearest] else -1), 0, len(forces) - 1))
        share = (delay - instants.delays[nearest]) / (instants.delays[other] - instants.delays[nearest] or 1.0)
        at = at + share * (forces[other] - at)
    root = (instants.weights[:, None] / noise)[:, :, None]
    matrix = (regressors[0] * root).reshape(-1, regressors.shape[3])
    scale = column_scale(matrix)
    values = scale * np.linalg.lstsq(matrix * scale, (at * root[:, :, 0]).ravel(), rcond=SINGULAR)[0]
    residuals = at - regressors[0] @ values
    shaking = 0.0
    if instants.shaking is not None and instants.drives is not None:
        drives = [own_drive + noise_of for own_drive, noise_of in zip(instants.drives, instants.shaking, strict=True)]
        shaken = replace(instants, drives=(drives[0], drives[1], drives[2]))
        other_regressors, other_motion = regressors_of(shaken, [trial])
        if other_motion.closed[0]:
            change = (other_regressors[0] - regressors[0]) @ values
            shaking = float(np.sqrt(np.mean((change / noise) ** 2)))
    return Left(float(np.sqrt(np.mean(residuals[:, newtons] ** 2))), of_noise, shaking)
