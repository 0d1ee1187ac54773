"""Struts or force channels in another order or with another sign than the case says, by the residuals of the model.

Every order that cables get into is tried on some instants of a run: exchanged pairs, one, two or three of them at once,
shifts, and changed signs. An order that explains the run far better than the recorded one names what is wrong.
"""

from collections.abc import Iterator, Sequence
from itertools import permutations, product

import numpy as np

from cases.errors import HexciteError
from cases.recording_format import STRUTS
from cases.schema import Case
from cases.units import Array
from identification.estimation.fit import column_scale, joint_triangle
from identification.hexapod import Hexapod
from identification.model import Model, machine_of, regressors
from identification.recording import Recording
from identification.runs.preparation import moving_run
from identification.runs.sample_checks import scan
from identification.runs.standstills import standstills
from identification.runs.wrist import wrist_run
from identification.signals import decimated

FACTOR = 2.0  # by which another order must lower the residuals: chance does not, with so many forces to judge by
SAME = 1.001  # ratio of residuals below which two orders count as equal
ALIKE = 1.2  # ratio of residuals below which struts and force channels cannot be distinguished
SMALL = 0.01  # share of what varies in forces and moments: a model that leaves less has its cables in order
LEAST = 60  # forces beyond the unknowns
INSTANTS = 90  # that are tried, with hundreds of orders
DULL = 1e-12  # of the larger of what forces and moments change by, squared: channels that read one value all the time

Order = tuple[tuple[int, int], ...]
"""For each of six columns the place in which it was recorded, counted from 0, and its sign there, 1 or -1."""

STRAIGHT: Order = tuple((k, 1) for k in range(6))
OPPOSITE: Order = tuple((k, -1) for k in range(6))
SIDES = {"force": "force channels", "strut": "struts"}


def orders_of(turned: bool) -> Iterator[Order]:
    """Exchanged pairs, up to three at once, shifts, and signs where they may be `turned`."""
    for places in permutations(range(6)):
        exchanged = all(places[place] == k for k, place in enumerate(places))
        shifted = len({(place - k) % 6 for k, place in enumerate(places)}) == 1
        if (exchanged or shifted) and places != (0, 1, 2, 3, 4, 5):
            yield tuple((place, 1) for place in places)
    if turned:
        yield from (tuple(enumerate(signs)) for signs in product((1, -1), repeat=6) if -1 in signs)


def words(order: Order, side: str) -> str:
    """What is wrong where an order of a side is the right one."""
    what, negative = SIDES[side], [str(k + 1) for k, (_, sign) in enumerate(order) if sign < 0]
    if negative:
        return f"the signs of {what} {', '.join(negative)} are turned"
    places = [place for place, _ in order]
    pairs = [f"{k + 1} and {place + 1}" for k, place in enumerate(places) if k < place and places[place] == k]
    if 2 * len(pairs) == sum(place != k for k, place in enumerate(places)):
        return f"{what} {', '.join(pairs)} are exchanged"
    return f"{what} are shifted by {places[0]}"


def _remedy(case: Case, side: str, order: Order) -> str:
    """What to write into the case where this order of a side is the right one."""
    if any(sign < 0 for _, sign in order):
        if side == "strut":
            return "turn these entries of recording.drives.sign in the case"
        return "turn the signs in the recorder, or the ends of bars or the sense of the sensor in [sensor_frame]"
    if side == "strut" and case.recording.drives is not None:
        return f"write recording.drives.order = {[case.recording.drives.order[place] for place, _ in order]}"
    names = STRUTS if side == "strut" else case.sensor_frame.channels
    entries = [
        f'{names[k]} = "{case.recording.file_name(names[place])}"' for k, (place, _) in enumerate(order) if place != k
    ]
    return f"write in [recording.columns]: {', '.join(entries)}"


def other_wiring(recording: Recording, case: Case, model: Model, negative: bool = False) -> str | None:
    """How struts or force channels seem to be exchanged or turned, with the remedy; None without such signs.

    Args:
        recording: a run that something speaks against.
        model: model that its forces are compared with.
        negative: whether the mass came out negative for certain.
    """
    try:
        signals, drives, matrices = _instants(recording, case, model)
    except HexciteError:
        return None
    if signals[0].size - len(model.names) < LEAST:
        return None
    mass = model.names.index("m") if "m" in model.names else None
    root = _root_weights(signals[0], case)
    recorded = _rms(signals, root, matrices)
    if not negative and recorded <= SMALL * float(np.sqrt(np.mean(root**2 * signals[0].var(axis=0)))):
        return None
    candidates = [(_rms(signals, root, matrices, order, mass), "force", order) for order in orders_of(turned=True)]
    if drives is not None:
        orders = list(orders_of(turned=case.recording.drives is not None))
        tried = zip(_regressors_of(drives, case, model, orders), orders, strict=True)
        candidates += [(_rms(signals, root, other, mass=mass), "strut", order) for other, order in tried]
    least = min(residuals for residuals, *_ in candidates)
    if not np.isfinite(least) or least * FACTOR > recorded:
        if not negative:
            return None
        remedy = _remedy(case, "force", OPPOSITE)
        return (
            f"{words(OPPOSITE, 'force')}: the mass comes out negative; {remedy}, or correct gravity_m_s2; "
            "a wrench must be raw and in the axes of the sensor"
        )
    rivals = []
    for side in SIDES:  # of orders that leave the same, the one with the fewest mistakes
        own = [candidate for candidate in candidates if candidate[1] == side and candidate[0] <= ALIKE * least]
        same = [candidate for candidate in own if candidate[0] <= SAME * min(own)[0]]
        rivals += sorted(same, key=lambda candidate: _mistakes(candidate[2]))[:1]
    rivals.sort()
    names = " or ".join(words(order, side) for _, side, order in rivals)
    smaller = f"{recorded / least:.3g} times smaller" if np.isfinite(recorded) else "small; no pose fits as recorded"
    remedies = " or ".join(_remedy(case, side, order) for _, side, order in rivals)
    return f"{names}: then residuals are {smaller}; {remedies}"


def _mistakes(order: Order) -> int:
    """Number of columns that are exchanged or have the other sign."""
    return sum(entry != straight for entry, straight in zip(order, STRAIGHT, strict=True))


def _instants(recording: Recording, case: Case, model: Model) -> tuple[list[Array], list[Array] | None, Array | None]:
    """Some instants of a run: forces, moving with their derivative, which a delay adds; a hexapod's struts; and A."""
    _, recording = scan(recording, case)
    if recording.struts is None:
        if recording.t is None or case.setup == "1a":
            still = standstills(recording, case, model)
            return [still.recorded], None, still.matrices
        wrist = wrist_run(recording, case, model)
        return [wrist.forces], None, wrist.regressors(0.0)
    if recording.t is None or case.setup == "1a":
        valid = np.flatnonzero(~recording.bad)
        valid = valid[:: -(-len(valid) // INSTANTS)]
        places = recording.struts[valid]
        drives, signals = [places, np.zeros_like(places), np.zeros_like(places)], [recording.forces[valid]]
    else:
        moving = moving_run(recording, case, model)
        assert moving.recording.struts is not None
        rows = moving.rows[:: -(-len(moving.rows) // INSTANTS)]
        drives = decimated(moving.filter, moving.recording.struts, rows, [(0, 0.0), (1, 0.0), (2, 0.0)])
        signals = decimated(moving.filter, moving.recording.forces, rows, [(0, 0.0), (1, 0.0)])
    if case.chain is not None:  # the order of its joints is not looked at
        return signals, None, regressors(model, machine_of(case).kinematics(*drives))
    return signals, drives, _regressors_of(drives, case, model, [STRAIGHT])[0]


def _root_weights(forces: Array, case: Case) -> Array:
    """Root of W for newtons beside newton metres: one over what forces and moments change by, shape (6,)."""
    if not case.sensor_frame.has_moments:
        return np.ones(6)
    spread = np.repeat(forces.var(axis=0).reshape(2, 3).mean(axis=1), 3)
    return np.asarray(1.0 / np.sqrt(np.maximum(spread, max(DULL * float(spread.max()), np.finfo(float).tiny))))


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
    signals: Sequence[Array], root: Array, matrices: Array | None, order: Order = STRAIGHT, mass: int | None = None
) -> float:
    """Weighted rms residuals in an order; infinite where struts do not close or a mass is negative."""
    if matrices is None:
        return float("inf")
    places, signs = np.array(order).T
    forces, *slopes = (signal[:, places] * signs for signal in signals)
    top = joint_triangle(np.dstack([matrices, *slopes]), forces, root)
    scale = column_scale(top[:, :-1])
    values = scale * np.linalg.lstsq(top[:, :-1] * scale, top[:, -1], rcond=1e-9)[0]
    if mass is not None and values[mass] < 0.0:
        return float("inf")
    return float(np.linalg.norm(top[:, -1] - top[:, :-1] @ values)) / float(np.sqrt(forces.size))
