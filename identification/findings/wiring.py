"""Struts or force channels in another order or with another sign than the case says, by the residuals of the model.

Every order that cables get into is tried on some instants of a run: exchanged pairs, one, two or three of them at once,
shifts, and changed signs. An order that explains the run far better than the recorded one names what is wrong.

Robots offer, beside the raw wrench of a wrist sensor, one without the tool's weight or in the axes of the base. Its
force at rest does not turn with the wrist, and the mass comes out as zero, too small or negative: the
residuals show this too.
"""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from cases.errors import HexciteError
from cases.schema import Case, load_case
from cases.tables import CASE_FILE, built_in_cases, find_case
from cases.units import Array
from identification.estimation.fit import column_scale, joint_triangle
from identification.findings.cable_orders import SIDES, STRAIGHT, Order, mistakes, orders_of, remedy, words
from identification.hexapod import Hexapod
from identification.model import Model, machine_of, regressors
from identification.parameters import nominal_parameters, offset_columns
from identification.recording import Recording
from identification.runs.preparation import moving_run
from identification.runs.sample_checks import scan
from identification.runs.standstills import standstills
from identification.runs.wrist import wrist_run
from identification.signals import decimated
from identification.symbolic import Kinematics

FACTOR = 2.0  # by which another order must lower the residuals: chance does not, with so many forces to judge by
SAME = 1.001  # ratio of residuals below which two orders count as equal
ALIKE = 1.2  # ratio of residuals below which struts and force channels cannot be distinguished
SMALL = 0.01  # share of what varies in forces and moments: a model that leaves less has its cables in order
LEAST = 60  # forces beyond the unknowns
INSTANTS = 90  # that are tried of a hexapod, with hundreds of orders
OF_CHAINS = 300  # that are tried of a chain
NOTHING = 0.1  # of what the nominal body makes the readings change by; a sensor that shows less is compensated
DULL = 1e-12  # of the larger of what forces and moments change by, squared: channels that read one value all the time
TURNS = 0.05  # of a unit vector: how much gravity must turn in the sensor's axes, rms
RECORD_RAW = "record the raw wrench in the sensor's axes (of Universal Robots ft_raw_wrench)"


def fitting_case(lengths: Array, case: Case) -> str | None:
    """A case whose machine has a pose with such strut lengths: built in, or in a folder beside this one's, or here.

    Args:
        lengths: lengths of a sample that no pose of the case has, shape (6,) [m].
    """
    own = None if not case.origin or case.origin in built_in_cases() else find_case(case.origin)
    places = [Path.cwd()] if own is None else [own.resolve().parent.parent, Path.cwd()]
    around = dict.fromkeys(file for place in places for file in sorted(place.glob(f"*/{CASE_FILE}")))
    for candidate in (*built_in_cases(), *map(str, around)):
        try:
            other = load_case(candidate)
            if other.machine == case.machine or other.machine is None or other.workspace is None:
                continue
            low, high = other.workspace.strut_length
            if np.all((lengths >= low) & (lengths <= high)):
                Hexapod.of(other).poses(lengths[None])
                return candidate
        except HexciteError:
            continue
    return None


def other_wiring(recording: Recording, case: Case, model: Model, negative: bool = False) -> str | None:
    """How struts or force channels seem to be exchanged or compensated, with the remedy; None without such signs.

    Args:
        recording: a run that something speaks against.
        model: model that its forces are compared with.
        negative: whether the mass came out negative for certain.
    """
    try:
        signals, drives, matrices = _instants(recording, case, model)
        if drives is not None and case.chain is not None:
            motion = machine_of(case).kinematics(*drives)
            if (explanation := _compensated(signals, motion, case, model)) is not None:
                return explanation
            matrices = regressors(model, motion)
        elif drives is not None:
            (matrices,) = _regressors_of(drives, case, model, [STRAIGHT])
    except HexciteError:
        return None
    if signals[0].size - len(model.names) < LEAST:
        return None
    mass = model.names.index("m") if "m" in model.names else None
    weights = _weights(signals[0], case)
    weighted, newtons = _rms(signals, weights, matrices)
    if not negative and weighted <= SMALL * float(np.sqrt(np.mean(weights * signals[0].var(axis=0)))):
        return None
    candidates = [(_rms(signals, weights, matrices, order, mass), "force", order) for order in orders_of(turned=True)]
    if drives is not None and case.chain is None:  # the order of a chain's joints is not looked at
        orders = list(orders_of(turned=case.recording.drives is not None))
        tried = zip(_regressors_of(drives, case, model, orders), orders, strict=True)
        candidates += [(_rms(signals, weights, other, mass=mass), "strut", order) for other, order in tried]
    least, *_ = min(candidates, key=lambda f: f[0])[0]
    if not np.isfinite(least) or least * FACTOR > weighted:
        if not negative:
            return None
        opposite = tuple((k, -1) for k in range(6))
        return (
            f"{words(opposite, SIDES['force'])}: the mass comes out negative, with residuals of {newtons:.2g} N; "
            f"{remedy(case, 'force', opposite)}, or correct gravity_m_s2"
        )
    rivals = [_likeliest([f for f in candidates if f[1] == side]) for side in {f[1] for f in candidates}]
    alike = sorted((r for r in rivals if r[0][0] <= ALIKE * least), key=lambda r: r[0])
    names = " or ".join(words(order, SIDES[side]) for _, side, order in alike)
    recorded = _in_words(weights, weighted, newtons)
    instead = f" instead of {recorded}" if np.isfinite(newtons) else ", while no pose fits them as recorded"
    remedies = " or ".join(remedy(case, side, order) for _, side, order in alike)
    return f"{names}: residuals {_in_words(weights, *alike[0][0])}{instead}; {remedies}"


_Candidate = tuple[tuple[float, float], str, Order]  # residuals as `_rms` has them, side, order that leaves them


def _likeliest(candidates: Sequence[_Candidate]) -> _Candidate:
    """The order that leaves least, and of those that leave the same, the one with the fewest mistakes."""
    least = min(residuals for residuals, _, _ in candidates)[0]
    same = [c for c in candidates if c[0][0] <= SAME * least]
    return min(same or candidates, key=lambda c: mistakes(c[2]))


def _in_words(weights: Array, weighted: float, newtons: float) -> str:
    """Rms residuals of forces, and of the moments among the channels."""
    if np.ptp(weights) == 0.0:
        return f"{newtons:.2g} N"
    of_forces, of_moments = weights[[0, 3]]
    moments = np.sqrt(max(2.0 * weighted**2 - of_forces * newtons**2, 0.0) / of_moments)
    return f"{newtons:.2g} N and {moments:.2g} N m"


def _instants(recording: Recording, case: Case, model: Model) -> tuple[list[Array], list[Array] | None, Array | None]:
    """Some instants of a run: forces, moving with their derivative, which a delay adds; drives with theirs, or A."""
    _, recording = scan(recording, case)
    most = INSTANTS if case.chain is None else OF_CHAINS
    if recording.t is None or case.setup == "1a":
        valid = np.flatnonzero(~recording.bad)
        if recording.struts is None:
            return [recording.forces[valid]], None, standstills(recording, case, model).matrices
        valid = valid[:: max(1, -(-len(valid) // most))]
        places = recording.struts[valid]
        return [recording.forces[valid]], [places, np.zeros_like(places), np.zeros_like(places)], None
    if recording.struts is None:
        wrist = wrist_run(recording, case, model)
        return [wrist.forces], None, wrist.regressors(0.0)
    run = moving_run(recording, case, model)
    assert run.recording.struts is not None
    rows = run.rows[:: max(1, -(-len(run.rows) // most))]
    drives = decimated(run.filter, run.recording.struts, rows, [(0, 0.0), (1, 0.0), (2, 0.0)])
    return decimated(run.filter, run.recording.forces, rows, [(0, 0.0), (1, 0.0)]), drives, None


def _weights(forces: Array, case: Case) -> Array:
    """Weights of newtons beside newton metres: one over the squared change of forces and of moments, shape (6,)."""
    if not case.sensor_frame.has_moments:
        return np.ones(6)
    spread = np.repeat(forces.var(axis=0).reshape(2, 3).mean(axis=1), 3)
    return np.asarray(1.0 / np.maximum(spread, max(DULL * float(spread.max()), np.finfo(float).tiny)))


def _compensated(signals: Sequence[Array], motion: Kinematics, case: Case, model: Model) -> str | None:
    """What has been done to the readings of a chain's sensor, with the remedy; None where nothing speaks for it."""
    turn = Rotation.from_euler("xyz", motion.pose[:, 3:]).as_matrix()
    if case.nominal is None or "m" not in model.names or np.sqrt(turn[:, 2].var(axis=0).sum()) < TURNS:
        return None
    whole, still = regressors(model, motion), np.zeros_like(motion.twist)
    weightless = whole - regressors(model, Kinematics(motion.pose, still, still))
    offsets = offset_columns(model)
    weightless[:, :, offsets] = whole[:, :, offsets]
    expected = whole @ nominal_parameters(model, case.nominal)
    changes = [np.sqrt(v.var(axis=0).reshape(2, 3).sum(axis=1)) for v in (signals[0], expected)]
    if np.all(changes[0] < NOTHING * changes[1]):
        return (
            f"the force hardly changes, where that of the nominal load does: it is compensated, or none; {RECORD_RAW}"
        )
    in_base = [np.einsum("nji,nkj->nki", turn, s.reshape(-1, 2, 3)).reshape(-1, 6) for s in signals]
    weights, weights_of_base = _weights(signals[0], case), _weights(in_base[0], case)
    mass = model.names.index("m")
    tried = (
        (_rms(signals, weights, weightless, mass=mass), "the weight has been taken out of the readings"),
        (
            _rms(in_base, weights_of_base, whole, mass=mass),
            "the readings are in the axes of the base, not in those of the sensor",
        ),
        (
            _rms(in_base, weights_of_base, weightless, mass=mass),
            "the weight has been taken out of the readings, which are in the axes of the base",
        ),
    )
    recorded, ((least, _), reading) = _rms(signals, weights, whole)[0], min(tried)
    if not least * FACTOR < recorded:
        return None
    return f"{reading}: as such they leave residuals {recorded / least:.1f} times smaller; {RECORD_RAW}"


def _regressors_of(drives: Sequence[Array], case: Case, model: Model, orders: Sequence[Order]) -> list[Array | None]:
    """A where the struts were recorded in other orders, shape (n, 6, u) each; None where no pose has such struts."""
    places, signs = np.moveaxis(np.array(orders), 2, 0)
    signs = np.repeat(signs, len(drives[0]), axis=0)
    lengths, velocities, accelerations = (
        np.swapaxes(motion[:, places], 0, 1).reshape(-1, 6) for motion in drives
    )  # those of each order in turn
    if case.recording.drives is not None:  # a drive with the other sign mirrors its strut at the offset
        lengths = np.where(signs > 0, lengths, 2.0 * case.recording.drives.offset - lengths)
    motion, closed = Hexapod.of(case).kinematics_where_closed(lengths, velocities * signs, accelerations * signs)
    matrices = np.split(regressors(model, motion), len(orders))
    return [a if c.all() else None for a, c in zip(matrices, np.split(closed, len(orders)), strict=True)]


def _rms(
    signals: Sequence[Array], weights: Array, matrices: Array | None, order: Order = STRAIGHT, mass: int | None = None
) -> tuple[float, float]:
    """Rms residuals in an order, weighted and in newtons; infinite where struts do not close or a mass is negative."""
    nothing = float("inf"), float("inf")
    if matrices is None:
        return nothing
    places, signs = np.array(order).T
    forces, *slopes = (signal[:, places] * signs for signal in signals)
    root = np.sqrt(weights)
    columns = np.dstack([matrices, *slopes])
    top = joint_triangle(columns, forces, root)
    scale = column_scale(top[:, :-1])
    values = scale * np.linalg.lstsq(top[:, :-1] * scale, top[:, -1], rcond=1e-9)[0]
    if mass is not None and values[mass] < 0.0:
        return nothing
    residuals = forces - columns @ values
    channels = slice(0, 6) if np.ptp(weights) == 0.0 else slice(0, 3)
    weighted, newtons = np.mean((residuals * root) ** 2), np.mean(residuals[:, channels] ** 2)
    return float(np.sqrt(weighted)), float(np.sqrt(newtons))
