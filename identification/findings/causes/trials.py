"""Hypotheses tried on instants of a run: the model is fitted under each of them, at every delay, and leaves residuals.

What changes the motion or the case gives regressors A of its own. With the orthonormal basis Q of their columns a fit
leaves |f|^2 - |Q^T f|^2, for recorded forces f of any order, sign or axes: one projection serves all hypotheses about
channels. The delay is found on the parabola through three delays of a grid.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
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
    Affine,
    Family,
    Trial,
    case_of,
    channels_of,
    drives_of,
    pace_of,
)
from identification.findings.causes.instants import Instants, Memory
from identification.machines.casadi_batch import over_samples
from identification.machines.hexapod import kinematics_of_hexapods
from identification.machines.serial_chain import SerialChain
from identification.model.model import identification_model

AT_ONCE = 6_000  # samples whose regressors are in memory
STEPS = 9  # of Newton's method: under a right hypothesis home is near enough
LARGEST_CONDITION = 1e6  # of bars that measure all forces and moments
FEWEST = 5  # instants that show whether a machine can have some drives
FEW = 6  # changes of the forces, from which on they share one projection
SINGULAR = 1e-9  # of the largest singular value of scaled regressors
RIDGE = 1e-13  # of the information of scaled columns, which need not be independent
CERTAIN = 3.0  # standard deviations below zero, from which on a mass is negative


class Outcome(NamedTuple):
    """What trials leave: rows are those that change motion or case, columns those that change forces alone."""

    residuals: Array  # rms residuals over the noise, shape (H, J); infinite where nothing fits, or no mass is so
    delays: Array  # at which they are least, shape (H, J) [s]


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
    matrices, size = _of_sensors(instants, channels), max(1, AT_ONCE // len(instants.rows))
    residuals, delays = np.empty((2, len(changes), len(matrices)))
    of_channels = np.array([channels_of(trial) for trial in changes])
    as_recorded = [np.array_equal(matrix, np.eye(6)) for matrix in of_channels]
    turned = [any(hypothesis.in_base for hypothesis in trial) for trial in changes]
    plain = [k for k, recorded in enumerate(as_recorded) if recorded and not turned[k]]
    others = sorted({*range(len(changes))} - {*plain})
    for which in (plain, others):  # those that leave the forces as they were recorded share them
        for start in range(0, len(which), size):
            part = which[start : start + size]
            outcome = fits_of(instants, [changes[k] for k in part]).outcome_with(matrices)
            residuals[part], delays[part] = outcome
    return Outcome(residuals, delays)


def _of_sensors(instants: Instants, trials: Sequence[Trial]) -> Array:
    """What recorded forces are multiplied by where the case's own bars are taken for those of trials, shape (J, 6, 6).

    Bars are changed by few hypotheses, which many trials share.
    """
    matrices: Array = np.broadcast_to(np.eye(6), (len(trials), 6, 6))
    for k in range(max(len(trial) for trial in trials)):
        places = [j for j, trial in enumerate(trials) if len(trial) > k and trial[k].channels is not None]
        steps: Array = np.zeros((len(trials), 6, 6)) + np.eye(6)
        if places:
            steps[places] = [trials[j][k].channels for j in places]
        matrices = steps @ matrices
    frame_of_case, remembered = instants.case.sensor_frame, instants.memory.of_run
    for j, trial in enumerate(trials):
        if (frame := _case_of(instants, trial).sensor_frame) is not frame_of_case:
            key = "sensors", id(frame)
            if key not in remembered:  # with the frame, so that no other one gets its number
                remembered[key] = np.linalg.solve(instants.model.structure, frame.structure), frame
            matrices[j] = remembered[key][0] @ matrices[j]
    return matrices


def closing(instants: Instants, changes: Sequence[Trial]) -> list[Trial]:
    """Those of some changes under which the machine can have the recorded drives, at some instants."""
    few = instants.part(FEWEST)
    size = max(1, AT_ONCE // len(few.rows))
    parts = [changes[k : k + size] for k in range(0, len(changes), size)]
    closed = [_motion(few, part, [_case_of(few, trial) for trial in part]).closed for part in parts]
    return [trial for trial, ok in zip(changes, np.concatenate(closed), strict=True) if ok] if changes else []


@dataclass(frozen=True)
class Fits:
    """Fits of the model under H changes of motion, case or forces, ready for changed forces."""

    whole: Array  # rows over the noise: of the orthonormal basis, or where `whiten` leads to it, shape (H, u, 6, n)
    whiten: Array | None  # shape (H, u, u); None where rows are those of the basis
    of_mass: Array | None  # the mass by what lies along the basis, shape (H, u); None where the model has none
    noise: Array  # of the forces that the changes make, shape (H, 6)
    closed: Flags  # whether the machine can have such drives, shape (H,)
    forces: Array  # that the changes make, times the weights, shape (H, n, 6, D), or (1, n, 6, D) where they keep them
    delays: Array  # shape (D,) [s]

    @cached_property
    def products(self) -> Array:
        """Sums of products of forces, shape (H or 1, D, 6, 6)."""
        by_delay = self.forces.transpose(0, 3, 2, 1)
        return np.asarray(by_delay @ by_delay.transpose(0, 1, 3, 2))

    @cached_property
    def shares_by_channel(self) -> Array:
        """What channel a in the place of channel i shows of each direction of the basis, shape (H, u, 36, D)."""
        count, unknowns, _, n = self.whole.shape
        right = self.forces.reshape(len(self.forces), n, -1)
        projections = self.whole.reshape(count, unknowns * 6, n) @ right
        return self._whitened(projections.reshape(count, unknowns, -1)).reshape(count, unknowns, 36, -1)

    def _whitened(self, along: Array) -> Array:
        """What lies along the basis from what lies along the rows, shapes (H, u, k)."""
        return along if self.whiten is None else np.asarray(self.whiten @ along)

    def outcome_with(self, matrices: Array) -> Outcome:
        """What the changes leave where forces are multiplied by matrices, shape (J, 6, 6), behind what they make.

        Residuals are over the noise that the matrices make of that of the forces, on an average over the channels.
        """
        count, unknowns, _, n = self.whole.shape
        explained = self._explained(matrices)
        sizes = np.einsum("jia,hdab,jib->hjdi", matrices, self.products, matrices, optimize=True)
        total = np.einsum("hjdi,hi->hjd", np.broadcast_to(sizes, (count, *sizes.shape[1:])), 1.0 / self.noise**2)
        residuals = np.maximum(total - np.sum(explained**2, axis=1), 0.0)
        least, place = _parabola(residuals / max(6 * n - unknowns, 1))
        # of the noise that is recorded, as the changes make it of channels, the matrices make more or less
        shares = np.einsum("jia,ha,hi->hj", matrices**2, self.noise**2, 1.0 / self.noise**2, optimize=True)
        least = least / (shares / 6.0)
        fine = self.closed[:, None] & ~self._negative(explained, place, least)
        delays = np.interp(place, np.arange(len(self.delays)), self.delays)
        return Outcome(np.where(fine, np.sqrt(least), np.inf), delays)

    def _explained(self, matrices: Array) -> Array:
        """How much of the forces, changed by each matrix, lies along the basis, shape (H, u, J, D)."""
        if len(matrices) >= FEW or "shares_by_channel" in self.__dict__:
            return np.asarray(matrices.reshape(-1, 36) @ self.shares_by_channel)
        count, unknowns, _, n = self.whole.shape
        flat = self.whole.reshape(count, unknowns, 6 * n)
        forces = (self.forces if np.array_equal(m, np.eye(6)) else m @ self.forces for m in matrices)
        right = (each.transpose(0, 2, 1, 3).reshape(len(each), 6 * n, -1) for each in forces)
        return np.stack([self._whitened(flat @ each) for each in right], axis=2)

    def _negative(self, explained: Array, place: Array, least: Array) -> Flags:
        """Whether the fitted mass of each trial is negative for certain, shape (H, J)."""
        if self.of_mass is None:
            return np.zeros(place.shape, dtype=bool)
        nearest = np.rint(place).astype(int)
        at = np.take_along_axis(explained, nearest[:, None, :, None], 3)[..., 0]  # shape (H, u, J)
        values = np.einsum("hu,huj->hj", self.of_mass, at)
        deviation = np.linalg.norm(self.of_mass, axis=1)[:, None] * np.sqrt(least)
        return np.asarray(values < -CERTAIN * deviation)


def fits_of(instants: Instants, changes: Sequence[Trial]) -> Fits:
    """The model under some changes, which may change forces too.

    Instants that are to choose by go without an orthogonal triangular decomposition: the normal equations of scaled
    columns are near enough, and cost a quarter.
    """
    regressors, motion = regressors_of(instants, changes)
    of_channels = np.array([channels_of(trial) for trial in changes])
    noise = np.sqrt(np.einsum("hij,j->hi", of_channels**2, instants.noise**2))  # of the forces that the changes make
    count, n, _, unknowns = regressors.shape
    rows = np.empty((count, unknowns, 6, n))
    regressors[~motion.closed] = 0.0
    np.multiply(regressors.transpose(0, 3, 2, 1), instants.weights / noise[:, None, :, None], out=rows)
    flat = rows.reshape(count, unknowns, -1)
    norms = np.linalg.norm(flat, axis=2)
    scale = np.where(norms > 0.0, 1.0 / np.where(norms > 0.0, norms, 1.0), 1.0)
    flat = flat * scale[:, :, None]
    names = instants.model.names
    mass = names.index("m") if "m" in names else None
    whiten, inverse = _by_normal_equations(flat, mass) if instants.rough else (None, None)
    if whiten is None:
        flat, inverse = _by_triangles(flat, mass)
    whole = flat.reshape(rows.shape) / noise[:, None, :, None]
    of_mass = None if mass is None or inverse is None else inverse * scale[:, [mass]]
    forces = _forces(instants, changes, of_channels, motion.rotations) * instants.weights[:, None]
    right = np.ascontiguousarray(forces.transpose(0, 2, 3, 1))
    return Fits(whole, whiten, of_mass, noise, motion.closed, right, instants.delays)


def _by_normal_equations(flat: Array, mass: int | None) -> tuple[Array | None, Array | None]:
    """What leads from scaled columns to an orthonormal basis, and the row of the mass; None where they are singular.

    Args:
        flat: scaled columns, shape (H, u, k).
        mass: number of the mass; None where the model has none.
    """
    information = flat @ flat.transpose(0, 2, 1) + RIDGE * np.eye(flat.shape[1])
    try:
        whiten = np.linalg.inv(np.linalg.cholesky(information))
    except np.linalg.LinAlgError:
        return None, None
    return whiten, None if mass is None else whiten[:, :, mass]


def _by_triangles(flat: Array, mass: int | None) -> tuple[Array, Array | None]:
    """An orthonormal basis of scaled columns, shape (H, u, k), and the row of the mass, shape (H, u)."""
    basis, triangle = np.linalg.qr(flat.transpose(0, 2, 1))
    return np.ascontiguousarray(basis.transpose(0, 2, 1)), None if mass is None else _row_of_inverse(triangle, mass)


def _row_of_inverse(triangle: Array, row: int) -> Array:
    """A row of the inverse of each triangle, shape (H, u), of the pseudo-inverse where some are singular."""
    diagonal = np.abs(np.diagonal(triangle, axis1=1, axis2=2))
    if np.any(diagonal.min(axis=1) <= SINGULAR * diagonal.max(axis=1)):
        return np.asarray(np.linalg.pinv(triangle, rcond=SINGULAR)[:, row, :])
    unit = np.broadcast_to(np.eye(triangle.shape[1])[row], diagonal.shape)
    return np.asarray(np.linalg.solve(triangle.transpose(0, 2, 1), unit[:, :, None])[:, :, 0])


def _parabola(values: Array) -> tuple[Array, Array]:
    """Least of values over the last axis, between its places, and where: shapes (H, J)."""
    count = values.shape[2]
    best = np.argmin(values, axis=2)
    if count < 3:
        return np.take_along_axis(values, best[:, :, None], 2)[:, :, 0], best.astype(float)
    middle = np.clip(best, 1, count - 2)
    low, mid, high = (np.take_along_axis(values, (middle + k)[:, :, None], 2)[:, :, 0] for k in (-1, 0, 1))
    bend, slope = low - 2.0 * mid + high, (high - low) / 2.0
    with np.errstate(divide="ignore", invalid="ignore"):
        step = np.where(bend > 0.0, np.clip(-slope / bend, -1.0, 1.0), 0.0)
    least = mid + slope * step + 0.5 * bend * step**2
    lowest = np.minimum(np.take_along_axis(values, best[:, :, None], 2)[:, :, 0], np.maximum(least, 0.0))
    return lowest, middle + step


class About(NamedTuple):
    """The point that moments must be about for a trial to leave least."""

    point: Array  # from the sensor's origin in its axes, shape (3,) [m]
    residuals: float  # weighted sum of squares; infinite where the machine cannot have such drives


def moments_about(instants: Instants, trials: Sequence[Trial]) -> list[About]:
    """The point that moments must be about for each trial to leave least: the forces depend on it linearly.

    It is in the axes in which moments were taken, before a turn of the sensor takes effect on them.
    """
    size = max(1, AT_ONCE // len(instants.rows))
    parts = [trials[k : k + size] for k in range(0, len(trials), size)]
    return [about for part in parts for about in _about(fits_of(instants, part), part)]


def _about(fits: Fits, trials: Sequence[Trial]) -> Iterator[About]:
    after = FAMILIES[FAMILIES.index(Family.POINT) + 1 :]
    metres = np.zeros((3, 6, 6))  # what a metre along each axis does to the moments
    metres[:, 3:, :3] = np.cross(np.eye(3)[None], np.eye(3)[:, None])
    for k, trial in enumerate(trials):
        if not fits.closed[k]:
            yield About(np.zeros(3), np.inf)
            continue
        later = channels_of(trial, after)
        columns = np.concatenate([np.eye(6)[None], later @ metres @ np.linalg.inv(later)])
        along = np.einsum("jp,upd->dju", columns.reshape(4, 36), fits.shares_by_channel[k])
        over = columns / fits.noise[k][:, None]
        products = fits.products[k if len(fits.products) > 1 else 0]
        squares = np.einsum("jia,dab,lib->djl", over, products, over, optimize=True) - along @ along.transpose(0, 2, 1)
        points = -(np.linalg.pinv(squares[:, 1:, 1:], rcond=SINGULAR, hermitian=True) @ squares[:, 1:, :1])[:, :, 0]
        residuals = squares[:, 0, 0] + np.sum(squares[:, 0, 1:] * points, axis=1)
        best = int(np.argmin(residuals))
        yield About(points[best], max(float(residuals[best]), 0.0))


def _case_of(instants: Instants, trial: Trial) -> Case:
    """The case whose forces the model is to predict under a trial."""
    drawn = [h for h in trial if h.place == "case" and h.edit is not None]
    if not drawn:
        return instants.case
    remembered = instants.memory.of_run
    drawn.sort(key=lambda hypothesis: -FAMILIES.index(hypothesis.family))  # as `case_of` edits
    case = instants.case
    for k in range(len(drawn)):
        key = ("case", *map(id, drawn[: k + 1]))
        if key not in remembered:  # with the hypotheses, so that no others get their numbers
            remembered[key] = case_of((drawn[k],), case, ("case",)), drawn[: k + 1]
        case = remembered[key][0]
    return case


def regressors_of(instants: Instants, changes: Sequence[Trial]) -> tuple[Array, _Motion]:
    """A of each of some changes, shape (H, n, 6, u), with columns of nuisances, and the motion behind it."""
    cases = [_case_of(instants, trial) for trial in changes]
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
    paths = _paths(instants, changes, cases)
    pace = np.array([pace_of(trial) for trial in changes])[:, None, None]
    rates = paths.rates / pace**2
    rates[:, :, :3] += gravity[:, None, :]
    return _Motion(paths.positions, paths.rotations, paths.twists / pace, rates, paths.closed)


def _paths(instants: Instants, changes: Sequence[Trial], cases: Sequence[Case]) -> _Motion:
    """Motions of the sensor by the recorded drives, in seconds of the recording; each is computed once."""
    assert instants.drives is not None
    affine = [drives_of(trial, instants.drives[0].shape[1]) for trial in changes]
    keys = [
        (a.matrix.tobytes(), a.offset.tobytes(), None if c.machine is instants.case.machine else id(c.machine))
        for a, c in zip(affine, cases, strict=True)
    ]
    paths_by_case = instants.memory.of_instants
    new = list({key: k for k, key in enumerate(keys) if key not in paths_by_case}.values())
    if new:
        paths = _new_paths(instants, [affine[k] for k in new], [cases[k] for k in new])
        # with the machine, so that no other one gets its number
        paths_by_case |= {keys[k]: ([values[i] for values in paths], cases[k].machine) for i, k in enumerate(new)}
    return _Motion(*(np.stack(values) for values in zip(*(paths_by_case[key][0] for key in keys), strict=True)))


def _new_paths(instants: Instants, affine: Sequence[Affine], cases: Sequence[Case]) -> _Motion:
    assert instants.drives is not None
    count, n = len(affine), len(instants.rows)
    turns = np.array([a.matrix for a in affine]).transpose(0, 2, 1)
    offsets = np.array([a.offset for a in affine])[:, None, :]
    drives = (instants.drives[0] @ turns + offsets, instants.drives[1] @ turns, instants.drives[2] @ turns)
    flat = [values.reshape(count * n, -1) for values in drives]
    closed = np.ones(count, dtype=bool)
    if isinstance(instants.machine, SerialChain):
        positions, columns, twists, rates = over_samples(instants.machine.motion, *flat)
        rotations = columns.reshape(-1, 3, 3).transpose(0, 2, 1)
    else:
        joints, home = _hexapods(cases)
        flat_joints, flat_home = np.repeat(joints, n, axis=0), np.repeat(home, n, axis=0)
        kinematics, ok = kinematics_of_hexapods(flat_joints, flat_home, flat[0], flat[1], flat[2], STEPS)
        closed = np.asarray(ok.reshape(count, n).all(axis=1))
        positions, twists, rates = kinematics.pose[:, :3], kinematics.twist, kinematics.twist_rate
        rotations = _rotations(kinematics.pose[:, 3:])
    return _Motion(
        positions.reshape(count, n, 3), rotations.reshape(count, n, 3, 3), twists.reshape(count, n, 6),
        rates.reshape(count, n, 6), closed,
    )  # fmt: skip


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
    stated_case = instants.case
    if instants.model.struts is not None:
        for k, case in enumerate(cases):
            if case.machine is not stated_case.machine:
                try:
                    model = identification_model(case, instants.model.number)
                    matrices[k] = model.matrices(*(values[k] for values in motion[:4]))
                except HexciteError:
                    motion.closed[k] = False
        return matrices
    if stated_case.sensor_frame.bars is None:
        return matrices
    others = [k for k, case in enumerate(cases) if case.sensor_frame is not stated_case.sensor_frame]
    if others:
        structures = np.array([cases[k].sensor_frame.structure for k in others])
        regular = np.linalg.cond(structures) < LARGEST_CONDITION
        motion.closed[[k for k, ok in zip(others, regular, strict=True) if not ok]] = False
        some = [k for k, ok in zip(others, regular, strict=True) if ok]
        matrices[some] = (np.linalg.solve(structures[regular], instants.model.structure))[:, None] @ matrices[some]
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


def _forces(instants: Instants, changes: Sequence[Trial], of_channels: Array, rotations: Array) -> Array:
    """Forces of each change, shape (H, D, n, 6), or (1, D, n, 6) where none changes them."""
    in_base = [k for k, trial in enumerate(changes) if any(hypothesis.in_base for hypothesis in trial)]
    if not in_base and np.array_equal(of_channels, np.broadcast_to(np.eye(6), of_channels.shape)):
        return instants.forces[None]
    forces = np.einsum("hij,dnj->hdni", of_channels, instants.forces, optimize=True)
    for k in in_base:
        vectors = (instants.forces @ channels_of(changes[k], RECORDED).T).reshape(len(instants.delays), -1, 2, 3)
        sensed = np.einsum("nji,dnbj->dnbi", rotations[k], vectors).reshape(forces[k].shape)
        forces[k] = sensed @ channels_of(changes[k], SENSED).T
    return np.asarray(forces)


class ResidualForces(NamedTuple):
    """Forces that a trial leaves unexplained, at the delay at which it leaves least."""

    newtons: float  # rms of the residuals of forces [N]
    noise: float  # what noise of the forces and of the recorded drives makes of it [N]
    shaking: float  # what noise of the recorded drives makes of the forces, over their noise


def residual_forces(instants: Instants, trial: Trial, delay: float) -> ResidualForces:
    """Residuals of a trial in newtons, beside what noise makes."""
    regressors, motion = regressors_of(instants, [trial])
    channels = channels_of(trial)
    noise = np.sqrt(channels**2 @ instants.noise**2)
    newtons = slice(0, 3 if instants.case.sensor_frame.has_moments else 6)
    of_noise = float(np.sqrt(np.mean(noise[newtons] ** 2)))
    if not motion.closed[0]:
        return ResidualForces(np.inf, of_noise, 0.0)
    nearest = int(np.argmin(np.abs(instants.delays - delay)))
    forces = _forces(instants, [trial], channels[None], motion.rotations)[0]
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
        shaken = replace(instants, drives=(drives[0], drives[1], drives[2]), memory=Memory())
        other_regressors, other_motion = regressors_of(shaken, [trial])
        if other_motion.closed[0]:
            change = (other_regressors[0] - regressors[0]) @ values
            shaking = float(np.sqrt(np.mean((change / noise) ** 2)))
            of_noise = float(np.hypot(of_noise, np.sqrt(np.mean(change[:, newtons] ** 2))))
    return ResidualForces(float(np.sqrt(np.mean(residuals[:, newtons] ** 2))), of_noise, shaking)
