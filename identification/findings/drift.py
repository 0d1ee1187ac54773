"""Offsets that drift within a run: a straight line in time, or one that settles as a sensor does that warms up.

Of each channel the size of such a change is estimated beside the parameters, and judged by noise as it is beside all of
them, which wanders too where it remembers, and by how surely that noise is known. It is not removed. Poses in an order,
as those of a grid, make what a model lacks look like a drift: terms of position and orientation are estimated beside.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy.special import ndtri

from cases.base.phrases import NOTHING, phrase
from cases.base.units import Array, Flags
from cases.schema import Case
from identification.estimation.alternatives import Sizes, sizes_of
from identification.estimation.score_test import chance_of
from identification.finding import Finding, Kind, warning
from identification.findings.noise_level import channel_words
from identification.findings.remains import excerpt_of, remainder_of
from identification.model.blocks import K1, K2, K3, K4, K5, MASS
from identification.model.model import regressors
from identification.recording.recording import Recording
from identification.samples.samples import Fitted

WARM_UP = "let the sensor warm up, and run hexcite tare shortly before its readings count"
CHANCE = 1e-6  # probability of a false drift, in each channel
LEAST_FREEDOM = 4.0  # degrees of freedom of a channel, from which on a drift can be judged
SETTLING = (1.0 / 3.0, 0.1)  # time constants of sensors that warm up, in lengths of the run


class Drift(NamedTuple):
    """How offsets change within a run."""

    shape: Array  # of the change over time, by 1 over the run and of mean 0, shape (n,)
    settles: bool  # whether it is that of a sensor that warms up, else a straight line
    change: Array  # of each channel over the run, shape (6,) [N, or N and N m]
    sure: Array  # normal standard deviations of such a chance, shape (6,)
    drifts: Flags  # channels that drift for certain, shape (6,)
    bias: Array  # by how much the values of the fit are off for it, shape (v,)


def drift_of(fitted: Fitted) -> Drift | None:
    """How offsets change within the run of a fit; None where they do not, or where that cannot be judged."""
    samples = fitted.samples
    freedom = len(fitted.fit.residuals) - len(fitted.regression.names) / 6 - 1
    span = float(np.ptp(samples.t))
    if fitted.method.priors or freedom < LEAST_FREEDOM or span == 0.0:
        return None
    excerpt, part = excerpt_of(fitted)
    rest, scale = remainder_of(excerpt), np.broadcast_to(excerpt.samples.scale, len(part))
    if (pose_errors := _lacking(excerpt)) is not None:
        rest = rest.beside(pose_errors)
    shapes = [_shape((samples.t - samples.t.min()) / span, memory) for memory in (None, *SETTLING)]
    columns = [(shape[part] * scale)[:, None, None] * np.eye(6) for shape in shapes]
    rough = [(k, sizes_of(each, rest, roughly=True)) for k, each in enumerate(columns)]
    likely = [(-drifts.explained, k) for k, drifts in rough if drifts is not None and _chances(drifts).min() < CHANCE]
    for _, k in sorted(likely):
        drifts = sizes_of(columns[k], rest)
        if drifts is None or (chances := _chances(drifts)).min() >= CHANCE:
            continue
        sure = -ndtri(np.maximum(chances, np.finfo(float).tiny) / 2.0)
        return Drift(shapes[k], k > 0, drifts.values, sure, chances < CHANCE, drifts.answer @ drifts.values)
    return None


def _chances(found: Sizes) -> Array:
    """Probability of the size in each channel by noise, shape (6,)."""
    alone = [found.noise.along(axis) for axis in np.eye(6)]
    return np.array([chance_of(found.values[k : k + 1], noise)[1] for k, noise in enumerate(alone)])


def _lacking(fitted: Fitted) -> Array | None:
    """Columns of errors by position and orientation that a model does not have, weighted, shape (n, 6, k)."""
    samples, model = fitted.samples, fitted.samples.model
    blocks = model.blocks
    terms = (K2,) * (K1 not in blocks and K2 not in blocks)
    terms += (K5,) * (K3 not in blocks and K4 not in blocks and K5 not in blocks)
    if (
        not terms
        or MASS not in blocks
        or model.struts is not None
        or model.machine is None
        or not model.machine.elastic
    ):
        return None
    motion = samples.motion(fitted.at)
    if motion is None or motion.drives is None:
        return None
    scale = np.broadcast_to(samples.scale, len(motion.known)) * motion.known
    return np.asarray(regressors(replace(model, blocks=terms), motion.load) * scale[:, None, None])


def _shape(share: Array, memory: float | None) -> Array:
    """A change by 1 from a share of the run 0 to 1, of mean 0, shape (n,): straight, or settling with a memory."""
    shape = share if memory is None else -np.expm1(-share / memory) / -np.expm1(-1.0 / memory)
    return np.asarray(shape - shape.mean())


def drift_findings(recording: Recording, case: Case, fitted: Fitted, drift: Drift | None) -> list[Finding]:
    """The channel whose offset changes most surely within a run, with the change over the run."""
    if drift is None:
        return []
    span, by_channel = float(np.ptp(fitted.samples.t)), np.where(drift.drifts, drift.sure, 0.0)
    worst = int(np.argmax(by_channel))
    channel, unit = channel_words(case, worst)
    by = float(drift.change[worst])
    if recording.t is None:
        over = phrase("over_standstills", "these {count} standstills", count=round(span) + 1)
    else:
        over = phrase("over_seconds", "the {seconds} s of this run", seconds=f"{span:.3g}")
    others = [channel_words(case, k)[0] for k in np.flatnonzero(drift.drifts).tolist() if k != worst]
    too = phrase("too", "; {others} too", others=", ".join(others)) if others else NOTHING
    warms = phrase("warms_up", ", most at its beginning, as of a sensor that warms up") if drift.settles else NOTHING
    sentence = phrase(
        "offset_drifts",
        "the offset of {channel} drifts by {by} {unit} over {over}{how} ({sure} standard deviations){more}: the result "
        "has the mean; {remedy}",
        channel=channel,
        by=f"{by:+.2g}",
        unit=unit,
        over=over,
        how=warms,
        sure=f"{drift.sure[worst]:.0f}",
        more=too,
        remedy=phrase("warm_up", WARM_UP),
    )
    entry = {"channel": channel, "change": by, "standard_deviations": float(drift.sure[worst]), "span": span}
    return [warning(Kind.OFFSETS, sentence, offset_drift=entry | {"unit": unit})]
