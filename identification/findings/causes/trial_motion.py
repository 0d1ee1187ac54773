"""Motion of the sensor and regressors of the model, as trials describe machine, drives and clock.

A motion that several trials have is computed once; what a case has otherwise, its bars or joints, changes A behind it.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from cases.base.errors import HexciteError
from cases.base.units import Array, Flags
from cases.schema import Case
from identification.findings.causes.hypothesis import FAMILIES, Affine, Trial, case_of, drives_of, pace_of
from identification.findings.causes.instants import Instants
from identification.machines.casadi_batch import over_samples
from identification.machines.hexapod import kinematics_of_hexapods
from identification.machines.serial_chain import SerialChain
from identification.model.model import identification_model

STEPS = 9  # of Newton's method: under a right hypothesis home is near enough
LARGEST_CONDITION = 1e6  # of bars that measure all forces and moments


class TrialMotion(NamedTuple):
    """Motion of the sensor of H trials at n instants."""

    positions: Array  # shape (H, n, 3) [m]
    rotations: Array  # R, shape (H, n, 3, 3)
    twists: Array  # shape (H, n, 6)
    rates: Array  # shape (H, n, 6), less what gravity is off by
    closed: Flags  # whether the machine can have such drives, shape (H,)


def case_of_trial(instants: Instants, trial: Trial) -> Case:
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


def regressors_of(instants: Instants, changes: Sequence[Trial]) -> tuple[Array, TrialMotion]:
    """A of each of some changes, shape (H, n, 6, u), with columns of nuisances, and the motion behind it."""
    cases = [case_of_trial(instants, trial) for trial in changes]
    motion = motion_of_trials(instants, changes, cases)
    count, n = motion.positions.shape[:2]
    flat = [values.reshape(count * n, *values.shape[2:]) for values in motion[:4]]
    matrices = instants.model.matrices(*flat).reshape(count, n, 6, -1)
    matrices = _of_other_frames(instants, cases, motion, matrices)
    if instants.turning is not None and instants.turning.specific is not None:
        matrices = np.concatenate([matrices, _turns_of_accelerometer(instants, motion)], axis=3)
    return matrices, motion


def motion_of_trials(instants: Instants, changes: Sequence[Trial], cases: Sequence[Case]) -> TrialMotion:
    """Motion of the sensor under each of some changes, with the cases that they make, in the recording's own time."""
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
        return TrialMotion(still, rotations, twists, rates, np.ones(count, dtype=bool))
    paths = _paths(instants, changes, cases)
    pace = np.array([pace_of(trial) for trial in changes])[:, None, None]
    rates = paths.rates / pace**2
    rates[:, :, :3] += gravity[:, None, :]
    return TrialMotion(paths.positions, paths.rotations, paths.twists / pace, rates, paths.closed)


def _paths(instants: Instants, changes: Sequence[Trial], cases: Sequence[Case]) -> TrialMotion:
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
    return TrialMotion(*(np.stack(values) for values in zip(*(paths_by_case[key][0] for key in keys), strict=True)))


def _new_paths(instants: Instants, affine: Sequence[Affine], cases: Sequence[Case]) -> TrialMotion:
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
    return TrialMotion(
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


def _of_other_frames(instants: Instants, cases: Sequence[Case], motion: TrialMotion, matrices: Array) -> Array:
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


def _turns_of_accelerometer(instants: Instants, motion: TrialMotion) -> Array:
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
