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

from cases.base.units import Array, Flags
from identification.estimation.fit import column_scale
from identification.findings.causes.hypothesis import (
    FAMILIES,
    RECORDED,
    SENSED,
    Family,
    Trial,
    channels_of,
)
from identification.findings.causes.instants import Instants, Memory
from identification.findings.causes.trial_motion import case_of_trial, motion_of_trials, regressors_of

AT_ONCE = 6_000  # samples whose regressors are in memory
FEWEST = 5  # instants that show whether a machine can have some drives
FEW = 6  # changes of the forces, from which on they share one projection
SINGULAR = 1e-9  # of the largest singular value of scaled regressors
RIDGE = 1e-13  # of the information of scaled columns, which need not be independent
CERTAIN = 3.0  # standard deviations below zero, from which on a mass is negative


class Outcome(NamedTuple):
    """What trials leave: rows are those that change motion or case, columns those that change forces alone."""

    residuals: Array  # rms residuals over the noise, shape (H, J); infinite where nothing fits, or no mass is so
    delays: Array  # at which they are least, shape (H, J) [s]


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
        if (frame := case_of_trial(instants, trial).sensor_frame) is not frame_of_case:
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
    closed = [motion_of_trials(few, part, [case_of_trial(few, trial) for trial in part]).closed for part in parts]
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
