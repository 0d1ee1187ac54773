"""Readings of a wrist sensor that a controller has compensated, or turned into base axes: told by what a model leaves.

Robots offer, beside the raw wrench, one without the tool's weight or in the axes of the base. Its force at rest does
not turn with the wrist, and the mass comes out as nothing, as too little, or negative.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from cases.errors import HexciteError
from cases.schema import Case
from identification.findings.sample_checks import scan
from identification.hexapod import Kinematics
from identification.machines import machine_of
from identification.model import Model, regressors
from identification.parameters import OFFSETS, nominal_parameters
from identification.recording import Recording
from identification.runs.preparation import moving_run
from identification.signals import decimated

Array = NDArray[np.float64]

FACTOR = 2.0  # by which another reading must lower the residuals
NOTHING = 0.1  # of what the nominal body makes the readings change by; a sensor that shows less is compensated
TURNS = 0.05  # of a unit vector: how much gravity must turn in the sensor's axes, rms
INSTANTS = 300  # that are tried
REMEDY = "record the raw wrench in the sensor's axes (of Universal Robots ft_raw_wrench)"


def compensated(recording: Recording, case: Case, model: Model) -> str | None:
    """What has been done to the readings of a chain's sensor, with the remedy; None where nothing speaks for it.

    Args:
        model: model that they are compared with.
    """
    if case.chain is None or case.nominal is None or "m" not in model.names or recording.struts is None:
        return None
    try:
        run = _instants(recording, case, model)
    except HexciteError:
        return None
    offsets = [model.names.index(p.name) for p in OFFSETS.parameters]
    still = np.zeros_like(run.moving.twist)
    whole = regressors(model, run.moving)
    weight = regressors(model, Kinematics(run.moving.pose, still, still))
    weight[:, :, offsets] = 0.0
    turn = Rotation.from_euler("xyz", run.moving.pose[:, 3:]).as_matrix()
    if np.sqrt(turn[:, 2].var(axis=0).sum()) < TURNS:
        return None
    expected = whole @ nominal_parameters(model, case.nominal)
    changes = [np.sqrt(v.var(axis=0).reshape(2, 3).sum(axis=1)) for v in (run.forces, expected)]
    if np.all(changes[0] < NOTHING * changes[1]):
        return f"the force hardly changes, where that of the nominal load does: it is compensated, or none; {REMEDY}"
    recorded, _ = run.left(whole, np.eye(3)[None], model)
    tried = [(*run.left(matrices, axes, model), words) for words, matrices, axes in _readings(whole, weight, turn)]
    left, _, words = min((t for t in tried if t[1] > 0.0), default=(np.inf, 0.0, ""))
    if not left * FACTOR < recorded:
        return None
    return f"{words}: as such they leave residuals {recorded / left:.1f} times smaller; {REMEDY}"


def _readings(whole: Array, weight: Array, turn: Array) -> Iterator[tuple[str, Array, Array]]:
    """What readings may be beside raw ones: in words, their A, shape (n, 6, u), and what turns them back, (n, 3, 3)."""
    back, none = turn.transpose(0, 2, 1), np.eye(3)[None]
    yield "the weight has been taken out of the readings", whole - weight, none
    yield "the readings are in the axes of the base, not in those of the sensor", whole, back
    yield "the weight has been taken out of the readings, which are in the axes of the base", whole - weight, back


class _Instants(NamedTuple):
    """Some instants of a run."""

    forces: Array  # shape (n, 6) [N, N m]
    slopes: Array | None  # their derivative, which a delay adds, shape (n, 6); None of standstills
    moving: Kinematics  # motion of the sensor frame at n instants

    def left(self, matrices: Array, back: Array, model: Model) -> tuple[float, float]:
        """Rms residuals, forces and moments in units of what they change by, and the mass in some unit.

        Args:
            matrices: A, shape (n, 6, u).
            back: what turns the readings into the axes of the sensor, shape (n, 3, 3) or (1, 3, 3).
        """
        columns = [matrices, *([] if self.slopes is None else [_turned(back, self.slopes)[:, :, None]])]
        forces = _turned(back, self.forces)
        spread = np.repeat([forces[:, k : k + 3].var(axis=0).mean() for k in (0, 3)], 3)
        root = 1.0 / np.sqrt(np.maximum(spread, np.finfo(float).tiny))
        flat = (np.dstack(columns) * root[:, None]).reshape(-1, matrices.shape[2] + len(columns) - 1)
        size = np.linalg.norm(flat, axis=0)
        scaled = flat / np.where(size > 0.0, size, 1.0)
        values = np.linalg.lstsq(scaled, (forces * root).ravel(), rcond=1e-9)[0]
        residuals = (forces * root).ravel() - scaled @ values
        return float(np.sqrt(np.mean(residuals**2))), float(values[model.names.index("m")])


def _turned(back: Array, readings: Array) -> Array:
    return np.hstack([(back @ readings[:, k : k + 3, None])[:, :, 0] for k in (0, 3)])


def _instants(recording: Recording, case: Case, model: Model) -> _Instants:
    found, machine = scan(recording, case), machine_of(case)
    assert recording.struts is not None
    if recording.t is None:
        q = recording.struts[~found.bad]
        return _Instants(recording.forces[~found.bad], None, machine.kinematics(q, np.zeros_like(q), np.zeros_like(q)))
    run = moving_run(recording, case, model, found=found)
    assert run.recording.struts is not None
    rows = run.rows[:: max(1, len(run.rows) // INSTANTS)]
    motion = decimated(run.filter, run.recording.struts, rows, [(order, 0.0) for order in range(3)])
    forces, slopes = decimated(run.filter, run.recording.forces, rows, [(0, 0.0), (1, 0.0)])
    return _Instants(forces, slopes, machine.kinematics(*motion))
