"""Forces and motion by clocks that are further apart than any filter delays: two computers, or a slow line."""

from dataclasses import replace

import numpy as np

from cases.base.phrases import phrase
from cases.base.units import MS, Array
from cases.schema import Case
from identification.estimation.fit import column_scale
from identification.findings.causes.hypothesis import AS_RECORDED, Family, Hypothesis
from identification.findings.causes.instants import Instants
from identification.findings.causes.leaps import cut
from identification.findings.causes.trials import regressors_of
from identification.recording.recording import Recording
from identification.samples.sample_checks import bridged
from identification.samples.samples import MOST_DELAY

LATEST = 2.0  # [s] that forces are looked for before and after the motion
COARSE, FINE = 0.02, 1e-3  # [s] between places at which they are looked for
SIMILAR = 1.1  # ratio of what two places leave, of which the one with the least shift counts: motions may repeat
RISING = 0.025  # [s] over which forces are averaged: as usual filters do, and for the noise


def late_forces(instants: Instants, recording: Recording, case: Case) -> Hypothesis | None:
    """Forces recorded later, or earlier, than the motion by more than any delay; None where no such time fits better.

    The time is found to about a millisecond; what is left of it is a delay as any other.
    """
    if recording.t is None or instants.t is None or instants.step is None:
        return None
    if recording.others and (recording.drives is not None or recording.rotations is not None):
        return None  # which of the streams is late is not to be told from forces alone
    wide = np.arange(-LATEST, LATEST + COARSE / 2, COARSE)
    late = _nearest(instants, recording, wide)
    if late is None or abs(late) < MOST_DELAY - COARSE:
        return None
    near = _nearest(instants, recording, late + np.arange(-COARSE, COARSE + FINE / 2, FINE))
    late = round((late if near is None else near) / MS) * MS
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


def _nearest(instants: Instants, recording: Recording, places: Array) -> float | None:
    """The time [s] after the motion, of some, at which forces are as it makes them; None where it cannot be computed.

    Before the first sample and after the last the machine is taken to stand.
    """
    assert recording.t is not None
    assert instants.t is not None
    regressors, motion = regressors_of(instants, [AS_RECORDED])
    if not motion.closed[0]:
        return None
    smooth = _smooth(recording, float(instants.step or 0.0))
    at = instants.t + places[:, None]  # shape (p, n)
    forces = np.stack([np.interp(at, recording.t, channel) for channel in smooth.T], axis=-1)
    root = instants.weights[:, None] / instants.noise
    rows = (regressors[0] * root[:, :, None]).reshape(-1, regressors.shape[3])
    basis = np.linalg.qr(rows * column_scale(rows))[0]
    weighted = (forces * root).reshape(len(places), -1)
    residuals = np.sum((weighted - weighted @ basis @ basis.T) ** 2, axis=1)
    similar = places[residuals <= SIMILAR**2 * residuals.min()]
    return float(min(similar, key=abs))


def _smooth(recording: Recording, step: float) -> Array:
    """Forces averaged around each sample, shape (n, 6)."""
    from scipy.ndimage import uniform_filter1d

    return np.asarray(uniform_filter1d(bridged(recording.forces, recording.bad), max(1, round(RISING / step)), axis=0))
