"""Forces and motion by clocks that are further apart than any filter delays: two computers, or a slow line."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from cases.base.phrases import phrase
from cases.base.units import MS, Array
from cases.schema import Case
from identification.estimation.fit import column_scale
from identification.findings.causes.hypothesis import AS_RECORDED, Family, Hypothesis, Trial
from identification.findings.causes.instants import Instants
from identification.findings.causes.leaps import cut
from identification.findings.causes.trial_motion import regressors_of
from identification.recording.recording import Recording
from identification.samples.sample_checks import bridged
from identification.samples.samples import MOST_DELAY

LATEST = 2.0  # [s] that forces are looked for before and after the motion
COARSE, FINE = 0.02, 1e-3  # [s] between places at which they are looked for
CLEARER = 0.25  # of what the motion as recorded leaves of the forces' squares, below which another one counts
SIMILAR = 1.1  # ratio of what two places leave, of which the one with the least shift counts: motions may repeat
SAME_COLUMN = 1e-5  # of the strongest direction of what a motion makes, below which columns are sums of others
RISING = 0.025  # [s] over which forces are averaged: as usual filters do, and for the noise


def late_forces(
    instants: Instants, recording: Recording, case: Case, others: Sequence[Hypothesis] = ()
) -> Hypothesis | None:
    """Forces recorded later, or earlier, than the motion by more than any delay; None where no such time fits better.

    The time is found to about a millisecond; what is left of it is a delay as any other.

    Args:
        others: what may be wrong with the motion as well, one at a time.
    """
    if recording.t is None or instants.t is None or instants.step is None:
        return None
    if recording.others and (recording.drives is not None or recording.rotations is not None):
        return None  # which of the streams is late is not to be told from forces alone
    wide = np.arange(-LATEST, LATEST + COARSE / 2, COARSE)
    alone = _nearest(instants, recording, wide, [AS_RECORDED])
    beside = _nearest(instants, recording, wide, [(other,) for other in others])
    clearer = beside is not None and (alone is None or beside.residual < CLEARER * alone.residual)
    found = beside if clearer else alone
    if found is None or abs(found.place) < MOST_DELAY - COARSE:
        return None
    near = _nearest(instants, recording, found.place + np.arange(-COARSE, COARSE + FINE / 2, FINE), [found.trial])
    late = round((found if near is None else near).place / MS) * MS
    rows = round(late / instants.step)
    if not recording.others and not 0 < abs(rows) < len(recording.forces) // 2:
        return None

    def recorded(recording: Recording, case: Case) -> Recording | None:
        del case
        if recording.t is None:
            return None
        if recording.others:
            others = tuple(s if s.t is None else replace(s, t=s.t + late) for s in recording.others)
            return replace(recording, others=others)
        motion = cut(recording, slice(0, -rows) if rows > 0 else slice(-rows, None))
        forces = cut(recording, slice(rows, None) if rows > 0 else slice(0, rows))
        missing = None if recording.missing is None else motion.bad | forces.bad
        return replace(motion, forces=forces.forces, missing=missing)

    def edit(case: Case) -> Case:
        clock = case.recording.clock
        offsets = {**clock.offset_s, "forces": round(clock.offset_s.get("forces", 0.0) - late, 6)}
        form = case.recording.model_copy(update={"clock": clock.model_copy(update={"offset_s": offsets})})
        return case.model_copy(update={"recording": form})

    size = f"{abs(late) / MS:.0f}"
    if late > 0.0:
        words = phrase("forces_late", "forces are stamped {size} ms late beside the motion", size=size)
    else:
        words = phrase("forces_early", "forces are stamped {size} ms early beside the motion", size=size)
    return Hypothesis(family=Family.CLOCK, words=words, edit=edit, recorded=recorded)


class _Nearest(NamedTuple):
    """Where forces are as a motion makes them."""

    place: float  # [s] after the motion
    trial: Trial  # of the motion
    residual: float  # weighted squares of the forces that it leaves


def _nearest(instants: Instants, recording: Recording, places: Array, trials: Sequence[Trial]) -> _Nearest | None:
    """The time, of some, at which forces are as one of some motions makes them; None where none can be computed.

    Each channel may be any sum of what the motion makes of all of them, so that channels that are exchanged, turned or
    scaled as well do not hide the time; not in the axes of the base. Before the first sample and after the last the
    machine is taken to stand.
    """
    assert recording.t is not None
    assert instants.t is not None
    smooth = _smooth(recording, float(instants.step or 0.0))
    at = instants.t + places[:, None]  # shape (p, n)
    forces = np.stack([np.interp(at, recording.t, channel) for channel in smooth.T], axis=-1)
    weighted = (forces * (instants.weights[:, None] / instants.noise)).transpose(1, 2, 0)  # shape (n, 6, p)
    best: _Nearest | None = None
    for made, trial in zip(_made(instants, trials), trials, strict=True):
        if made is None:
            continue
        directions, strengths, _ = np.linalg.svd(made * column_scale(made), full_matrices=False)
        basis, flat = directions[:, strengths > SAME_COLUMN * strengths[0]], weighted.reshape(len(made), -1)
        residuals = np.sum((flat - basis @ (basis.T @ flat)).reshape(weighted.shape) ** 2, axis=(0, 1))
        if best is None or residuals.min() < best.residual:
            similar = places[residuals <= SIMILAR**2 * residuals.min()]
            best = _Nearest(float(min(similar, key=abs)), trial, float(residuals.min()))
    return best


def _made(instants: Instants, trials: Sequence[Trial]) -> Iterator[Array | None]:
    """What each of some motions makes, weighted: columns of all channels, shape (n, 6 u), for each channel to be a sum
    of; in the axes of the base, where such sums would follow any forces, of the channels as they are, shape (6 n, u).
    None where it cannot be computed.
    """
    if not trials:
        return
    regressors, motion = regressors_of(instants, trials)
    for trial, matrices, turns, closed in zip(trials, regressors, motion.rotations, motion.closed, strict=True):
        made = matrices * instants.weights[:, None, None]
        if not closed:
            yield None
        elif any(hypothesis.in_base for hypothesis in trial):
            in_base = np.einsum("nij,nbju->nbiu", turns, made.reshape(len(made), 2, 3, -1)).reshape(made.shape)
            yield (in_base / instants.noise[:, None]).reshape(-1, made.shape[2])
        else:
            yield made.reshape(len(made), -1)


def _smooth(recording: Recording, step: float) -> Array:
    """Forces averaged around each sample, shape (n, 6)."""
    from scipy.ndimage import uniform_filter1d

    return np.asarray(uniform_filter1d(bridged(recording.forces, recording.bad), max(1, round(RISING / step)), axis=0))
