"""Readings that are not what the sensor measured: offsets that drift, and wrenches that a controller has compensated.

Within a run a straight line in time, or in the temperature that was recorded, is added to each channel and judged by
the deviations that noise with memory leaves it. Afterwards a channel that reads too much all along has drifted, or
something presses on it all along.

Robots offer, beside the raw wrench of a wrist sensor, one without the tool's weight or in the axes of the base. Its
force at rest does not turn with the wrist, and the mass comes out as nothing, as too little, or negative: told by what
a model leaves.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag
from scipy.spatial.transform import Rotation
from scipy.special import stdtrit

from cases.errors import HexciteError
from cases.schema import Case
from identification.estimation.biases import DRIFTED
from identification.estimation.compressed import inverse_root, joint_triangle
from identification.estimation.estimators import Method
from identification.estimation.fit import whitened
from identification.findings import Finding, Kind, warning
from identification.findings.sample_checks import scan
from identification.fitting import SANDWICHED, Fitted
from identification.hexapod import Kinematics
from identification.machines import machine_of
from identification.model import Model, regressors
from identification.parameters import OFFSETS, nominal_parameters
from identification.recording import Recording
from identification.runs.averaging import PeriodicRun
from identification.runs.preparation import moving_run
from identification.samples import Standstills
from identification.signals import decimated, fair_part

Array = NDArray[np.float64]

CHANCE = 1e-6  # probability of a drift that is none, in each channel
LEAST_WARMING = 0.2  # [K] within a run, from which on its temperature says more than its time
LEAST_FREEDOM = 4.0  # of a channel, that tell a deviation
STRETCHES = 10  # of a recording, in each of which a channel reads too much
WARM_UP = "let the sensor warm up, and run hexcite tare shortly before its readings count"


def drifting(recording: Recording, case: Case, how: Method, fitted: Fitted) -> list[Finding]:
    """Channels whose offset changes within a run, with the rate and the change over the run."""
    samples = fitted.samples
    freedom = len(fitted.fit.residuals) - fitted.columns.shape[2] / 6 - 1
    if isinstance(samples, PeriodicRun) or how.name not in SANDWICHED or how.priors or freedom < LEAST_FREEDOM:
        return []
    axis, warming = _axis(recording, samples.t)
    if np.ptp(axis) == 0.0:
        return []
    line = (axis - axis.mean()) / np.ptp(axis)
    if isinstance(samples, Standstills):
        line = line * samples.scale
    part = fair_part(len(line))
    if not _likely(*_with_lines(fitted, how, line, part), freedom * len(part) / len(line)):
        return []  # noise with memory makes deviations larger, and takes time
    columns, left, weights = _with_lines(fitted, how, line, np.arange(len(line)))
    change, white = _solved(columns, left, weights, freedom)
    robust = samples.robust_covariance(columns, left - columns @ change, weights, fitted.whitening)
    spread = white if robust is None else np.maximum(white, np.diag(robust.covariance)[-6:])
    # noise that remembers long has so few independent samples that a straight line is no surprise
    most = -stdtrit(np.maximum(freedom * white / spread, 1.0), CHANCE / 2.0)
    sure = np.abs(change[-6:]) / np.sqrt(spread)
    if not np.any(sure > most):
        return []
    return [_told(case, np.asarray(change[-6:]), sure, most, float(np.ptp(axis)), warming, recording.t is not None)]


def _with_lines(fitted: Fitted, how: Method, line: Array, rows: NDArray[np.int64]) -> tuple[Array, Array, Array]:
    """A with a line in each channel, residuals and weights of some samples, as an estimator takes them."""
    basis = how.selection(fitted.samples.model).basis
    free = fitted.columns[rows] @ block_diag(basis, np.eye(fitted.columns.shape[2] - len(basis)))
    lines = line[rows, None, None] * np.eye(6)
    columns, left = whitened(fitted.whitening, np.dstack([free, lines]), fitted.fit.residuals[rows])
    return columns, left, fitted.fit.weights if fitted.whitening is None else np.ones(6)


def _solved(columns: Array, left: Array, weights: Array, freedom: float) -> tuple[Array, Array]:
    """How far the values of a fit move with the lines, and the variance of these six by white noise."""
    top = joint_triangle(columns, left, np.sqrt(weights))
    half, change = inverse_root(top[:-1, :-1]), np.linalg.lstsq(top[:-1, :-1], top[:-1, -1], rcond=None)[0]
    covariance = half @ half.T * top[-1, -1] ** 2 / (6.0 * freedom)
    return np.asarray(change), np.diag(covariance)[-6:]


def _likely(columns: Array, left: Array, weights: Array, freedom: float) -> bool:
    """Whether a line is more than white noise makes."""
    change, white = _solved(columns, left, weights, freedom)
    return bool(np.any(np.abs(change[-6:]) > -stdtrit(freedom, CHANCE / 2.0) * np.sqrt(white)))


def _axis(recording: Recording, t: Array) -> tuple[Array, bool]:
    """What offsets may go with, at the evaluated samples, and whether that is the temperature."""
    if recording.temperature is None:
        return t, False
    own = np.arange(1.0, len(recording.temperature) + 1.0) if recording.t is None else recording.t
    temperature = np.interp(t, own, recording.temperature)
    return (temperature, True) if np.ptp(temperature) >= LEAST_WARMING else (t, False)


def _told(
    case: Case, change: Array, sure: Array, most: Array, span: float, warming: bool, clocked: bool
) -> Finding:  # fmt: skip
    worst = int(np.argmax(sure / most))
    channel, unit = _channel(case, worst)
    by = float(change[worst])
    if warming:
        rate, over = f"{by / span:+.2g} {unit}/K", f"the {span:.2g} K of this run"
    elif clocked:
        rate, over = f"{60.0 * by / span:+.2g} {unit} a minute", f"the {span:.3g} s of this run"
    else:
        rate, over = f"{by / span:+.2g} {unit} from standstill to standstill", f"these {round(span) + 1}"
    others = [_channel(case, k)[0] for k in np.flatnonzero(sure > most).tolist() if k != worst]
    more = f"; {', '.join(others)} too" if others else ""
    told = (
        f"the offset of {channel} drifts by {rate}, {by:+.2g} {unit} over {over} ({sure[worst]:.0f} standard "
        f"deviations){more}: the result has the mean; {WARM_UP}"
    )
    drift = {"channel": channel, "change": by, "standard_deviations": float(sure[worst]), "span": span, "unit": unit,
             "with": "temperature" if warming else "time"}  # fmt: skip
    return warning(Kind.OFFSETS, told, offset_drift=drift)


def shifted_all_along(residuals: Array, variance: Array, case: Case) -> list[str]:
    """What to say where a channel reads more, or less, than a result expects in every part of a recording.

    Args:
        residuals: measured less expected, in the order of time, shape (n, 6) [N, or N and N m].
        variance: variance of the result's offsets, shape (6,).
    """
    if len(residuals) < STRETCHES:
        return []
    means = np.array([part.mean(axis=0) for part in np.array_split(residuals, STRETCHES)])
    std = np.sqrt(variance + means.var(axis=0, ddof=1))
    one_way = np.abs(np.sign(means).sum(axis=0)) == STRETCHES
    least = np.where(one_way, np.abs(means).min(axis=0), 0.0) / np.maximum(std, np.finfo(float).tiny)
    worst = int(np.argmax(least))
    if not least[worst] > DRIFTED:
        return []
    channel, unit = _channel(case, worst)
    told = f"{channel} reads {means[:, worst].mean():+.2g} {unit} more than the result expects all along: its offset "
    return [f"{told}has drifted, or something presses all along; {WARM_UP}"]


def drifted_since(change: Array, std: Array, case: Case, source: str) -> list[str]:
    """What to say where a tare finds other offsets than a result.

    Args:
        change: new offsets less old ones, shape (6,) [N, or N and N m].
        std: standard deviation of that, shape (6,).
        source: the result.
    """
    sure = np.abs(change) / np.maximum(std, np.finfo(float).tiny)
    worst = int(np.argmax(sure))
    if not sure[worst] > DRIFTED:
        return []
    channel, unit = _channel(case, worst)
    told = (
        f"the offset of {channel} has drifted by {change[worst]:+.2g} {unit} ({sure[worst]:.0f} standard deviations) "
    )
    return [f"{told}since {source}: what was computed with that meanwhile is off by it"]


def _channel(case: Case, k: int) -> tuple[str, str]:
    name, _, unit = case.sensor_frame.channels[k].rpartition("_")
    return case.recording.file_name(f"{name}_{unit}"), {"Nm": "N m"}.get(unit, unit)


FACTOR = 2.0  # by which another reading must lower the residuals
NOTHING = 0.1  # of what the nominal body makes the readings change by; a sensor that shows less is compensated
TURNS = 0.05  # of a unit vector: how much gravity must turn in the sensor's axes, rms
INSTANTS = 300  # that are tried
RECORD_RAW = "record the raw wrench in the sensor's axes (of Universal Robots ft_raw_wrench)"


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
        return (
            f"the force hardly changes, where that of the nominal load does: it is compensated, or none; {RECORD_RAW}"
        )
    recorded, _ = run.left(whole, np.eye(3)[None], model)
    tried = [(*run.left(matrices, axes, model), words) for words, matrices, axes in _readings(whole, weight, turn)]
    left, _, words = min((t for t in tried if t[1] > 0.0), default=(np.inf, 0.0, ""))
    if not left * FACTOR < recorded:
        return None
    return f"{words}: as such they leave residuals {recorded / left:.1f} times smaller; {RECORD_RAW}"


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
