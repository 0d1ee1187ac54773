"""What leaps within a run: the offsets of sensors that slip or are zeroed, the load where something falls off.

For every place the model is fitted with further columns behind it. Sums over the instants behind a place serve all
places, so that they cost no more than one.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from cases.base.phrases import Phrase, enumerated, phrase
from cases.base.units import Array
from cases.schema import Case
from identification.estimation.fit import column_scale
from identification.findings.causes.hypothesis import AS_RECORDED, Family, Hypothesis
from identification.findings.causes.instants import Instants
from identification.findings.causes.trial_motion import regressors_of
from identification.model.blocks import FIRST_MOMENT, INERTIA, MASS
from identification.recording.recording import Recording
from identification.texts import with_deviation

FEWEST = 20  # instants on either side of a leap
CLEAR = 5.0  # deviations by which an offset must leap to be named
ARRAYS = (
    "t", "drives", "rotations", "forces", "trigger", "poses", "specific_forces", "override", "missing", "weights",
)  # fmt: skip
RIDGE = 1e-9  # of the information about further columns, which need not be independent of the others


@dataclass(frozen=True, slots=True)
class Leap:
    """Something that leaps, in the words and at the place where it leaves least."""

    residuals: float  # over the noise
    at: int  # number of the first instant behind it
    words: str


def leaps_of(instants: Instants, delay: float, recording: Recording, case: Case) -> Iterator[tuple[Leap, Hypothesis]]:
    """What may leap in a run, as a hypothesis each: that a part of the run is another run.

    Args:
        instants: all as recorded.
        delay: of the forces [s].
        recording: it leaps in.
        case: names its channels.
    """
    count = len(instants.rows)
    if count < 2 * FEWEST:
        return
    regressors, _ = regressors_of(instants, [AS_RECORDED])
    root = (instants.weights[:, None] / instants.noise)[:, :, None]
    forces = instants.forces[int(np.argmin(np.abs(instants.delays - delay)))]
    rows, right = regressors[0] * root, forces[:, :, None] * root
    flat = rows.reshape(-1, rows.shape[2])
    basis = np.linalg.qr(flat * column_scale(flat))[0].reshape(rows.shape)
    remainder = right[:, :, 0] - basis @ np.einsum("nic,ni->c", basis, right[:, :, 0])
    total = float(np.sum(remainder**2))
    freedom = remainder.size - rows.shape[2]
    names = instants.model.names
    body = [names.index(p.name) for block in (MASS, FIRST_MOMENT, INERTIA) for p in block.parameters if p.name in names]
    kinds = (("offsets", np.broadcast_to(np.eye(6), (count, 6, 6)) * root), ("load", rows[:, :, body]))
    for kind, columns in kinds:
        gains, sizes, deviations = _gains(basis, remainder, columns)
        inner = np.where((np.arange(count) >= FEWEST) & (np.arange(count) <= count - FEWEST), gains, -np.inf)
        at = int(np.argmax(inner))
        residuals = float(np.sqrt(max(total - gains[at], 0.0) / max(freedom - columns.shape[2] - 1, 1)))
        line = recording.lines.place(int(instants.rows[at]))
        what = (
            _of_offsets(case, sizes[at], deviations[at] * max(residuals, 1.0))
            if kind == "offsets"
            else phrase(
                "load_changes",
                "the load changes by {size} kg",
                size=_signed(sizes[at][0], deviations[at][0] * max(residuals, 1.0)),
            )
        )
        if not what:
            continue
        time = "" if recording.t is None else f" ({recording.t[instants.rows[at]]:.3g} s)"
        words = phrase("at_about", "{what} at about {line}{time}", what=what, line=line, time=time)
        yield Leap(residuals, at, words), _as_two_runs(words, line, _longer(recording, int(instants.rows[at])))


def _gains(basis: Array, left: Array, columns: Array) -> tuple[Array, Array, Array]:
    """What further columns behind each instant explain of the residuals, their values and deviations.

    Args:
        basis: of the model, shape (n, 6, u).
        left: residuals, shape (n, 6).
        columns: shape (n, 6, k).
    """

    def behind(values: Array) -> Array:
        return np.asarray(np.cumsum(values[::-1], axis=0)[::-1])

    norms = behind(np.einsum("nia,nib->nab", columns, columns))
    shared = behind(np.einsum("nic,nia->nca", basis, columns))
    right = behind(np.einsum("nia,ni->na", columns, left))
    information = norms - np.einsum("nca,ncb->nab", shared, shared)
    size = np.sqrt(np.maximum(np.einsum("naa->na", norms), 0.0))
    diagonal = np.where(size > 0.0, size, 1.0)
    scaled = information / (diagonal[:, :, None] * diagonal[:, None, :]) + RIDGE * np.eye(columns.shape[2])
    inverse = np.linalg.inv(scaled) / (diagonal[:, :, None] * diagonal[:, None, :])
    values = np.einsum("nab,nb->na", inverse, right)
    deviations = np.sqrt(np.maximum(np.einsum("naa->na", inverse), 0.0))
    return np.einsum("na,na->n", right, values), values, deviations


def _of_offsets(case: Case, sizes: Array, deviations: Array) -> str:
    """The channels whose offsets leap, the largest leaps first; empty where none does clearly."""
    clear = np.abs(sizes) / np.maximum(deviations, np.finfo(float).tiny)
    channels = [k for k in np.argsort(-clear) if clear[k] > CLEAR][:3]
    if not channels:
        return ""
    parts = []
    for k in channels:
        name, _, unit = case.sensor_frame.channels[k].rpartition("_")
        of, size = case.recording.file_name(f"{name}_{unit}"), _signed(sizes[k], deviations[k])
        parts.append(phrase("by", "{of} by {size} {unit}", of=of, size=size, unit="N m" if unit == "Nm" else unit))
    return phrase("offsets_leap", "offsets leap, of {parts},", parts=enumerated("comma", parts))


def _signed(value: float, std: float) -> str:
    return f"{'' if value < 0.0 else '+'}{with_deviation(value, std)}"


def _longer(recording: Recording, row: int) -> slice:
    """The longer part of a recording that is cut at a row."""
    count = len(recording.forces)
    return slice(0, row) if row >= count - row else slice(row, count)


def _as_two_runs(words: Phrase, line: str, part: slice) -> Hypothesis:
    def changed(recording: Recording, case: Case) -> Recording | None:
        del case
        return cut(recording, part)

    if part.start == 0:
        longer = phrase("before_line", "before {line}", line=line)
    else:
        longer = phrase("from_line", "from {line}", line=line)
    what = "cut the run there and evaluate the parts alone, the longer one is {longer}"
    return Hypothesis(
        family=Family.LEAPS, words=words, recorded=changed, mistakes=1.4,
        remedy=phrase("cut_there", what, longer=longer),
    )  # fmt: skip


def cut(recording: Recording, part: slice) -> Recording:
    """The rows of a recording in a part of it."""
    whole = {name: getattr(recording, name) for name in ARRAYS}
    parts: dict[str, Any] = {name: None if value is None else value[part] for name, value in whole.items()}
    return replace(recording, lines=recording.lines.later(part.start or 0), **parts)
