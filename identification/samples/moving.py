"""A moving run, evaluated at any delay between forces and motion, and by how much more its forces are smoothed.

Forces and struts of a moving run pass the same zero-phase low-pass, which also differentiates the struts: what a
controller's blocks and the encoders' steps add above the cut-off then disturbs neither side. The filtered signals are
evaluated at the rate that they still need.

But they were not sampled alike. Where accelerations leap within a sampling step T, as those of controllers without
limit of jerk do, forces sampled pointwise are those of a motion smoothed by -T^2/12 to T^2/24 more than the struts, by
where in a step they are sampled; averaging over the step, or a low-pass before the sampling, adds half its variance. To
first order f = A u + b d^2(A u)/dt^2: beside the delay, the first moment of the smoothing, b, half the second, is one
more unknown, estimated where the run determines it. Without it, the mass of a clean ten-second run is biased by two of
its standard deviations.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import ClassVar, Self

import numpy as np

from cases.base.phrases import phrase
from cases.base.units import Array, Flags, Indices
from identification.estimation.fit import Fit, Robust, joint_triangle
from identification.estimation.force_noise import turned
from identification.estimation.noise_mixtures import coloured_covariance, source_covariance
from identification.estimation.pose_noise import covariance_by_pose
from identification.finding import Finding, Kind, note
from identification.machines.hexapod import StrutsDoNotClose
from identification.machines.machine import Kinematics, Machine
from identification.model.model import expected_forces, regressors
from identification.recording.recording import Recording
from identification.samples.samples import MOST_DELAY, MotionOfSamples, MovingSamples
from identification.signals import MOST_SAMPLES, Filter, Residuals, decimated, fair_part, white_noise

SMOOTHING_STEP = 1e-3  # [s] for the second derivative: far below the periods that pass
PIECE = 6_000  # samples that go from struts to regressors together: what lies between stays in the cache
FORGOTTEN = 100  # samples after which noise counts as independent
SMOOTHED = ("smoothing", "delay")  # nuisances where it is estimated by how much more forces are smoothed than motion
DELAY_STEP = 1e-5  # [s] for the derivative with respect to the delay: far below what the filter lets pass


@dataclass(frozen=True, slots=True, kw_only=True)
class MovingRun(MovingSamples):
    """A moving run, ready to be evaluated at any delay between forces and motion."""

    recording: Recording
    machine: Machine
    rows: Indices  # samples that are evaluated, counted after the filter's margin, shape (n,)
    nuisances: tuple[str, ...] = ("delay",)  # or `SMOOTHED`
    # filtered samples that damage or a gap disturbs, shape (samples of the recording less two margins,)
    spoilt: Flags | None = None
    each: ClassVar[tuple[str, ...]] = (*MovingSamples.each, "rows")

    def at(self, rows: Indices) -> Self:
        """The run evaluated at other filtered samples, shape (n,)."""
        t, recorded, forces = signals_at(self.recording, self.filter, rows)
        return replace(self, rows=rows, t=t, recorded=recorded, forces=forces)

    def regressors(self, delay: float) -> Array:
        """A at the instants t_k - delay, shape (n, 6, u)."""
        return np.concatenate([regressors(self.model, motions[0]) for _, motions in self._motions(delay)])

    def kinematics(self, delay: float) -> Kinematics:
        """Motion of the platform at the instants t_k - delay, of n samples."""
        pieces = [motions[0] for _, motions in self._motions(delay)]
        return Kinematics(*(np.concatenate([getattr(p, f) for p in pieces]) for f in ("pose", "twist", "twist_rate")))

    def motion(self, delay: float) -> MotionOfSamples:
        """How the load moves at the samples, in a band in which next to nothing of it is noise of the drives.

        It is at most half of that of the fit, for residuals have that noise too. The motion is known where its longer
        filter reaches neither an end nor a gap of the recording.
        """
        struts = self.recording.drives
        assert struts is not None
        first, last = self.filter.margin + self.rows[[0, -1]]
        noise, low_pass, quiet = white_noise(struts[first : last + 1][:BLOCK]), self.filter, False
        for factor in BANDS:
            narrow = self.filter._replace(cutoff=self.filter.cutoff / factor)
            if len(struts) <= 2 * narrow.margin or np.mean(self._reached(narrow)[1]) < MOST_OF_IT:
                break
            low_pass, quiet = narrow, calm(narrow, struts[:BLOCK], noise, self.machine.turns)
            if quiet:
                break
        inside, known = self._reached(low_pass)
        at, inverse = np.unique(inside, return_inverse=True)
        drives = decimated(low_pass, struts, at, [(order, delay) for order in range(3)])
        place, speed, acceleration = (values[inverse] for values in drives)
        load = self.machine.kinematics(place, speed, acceleration)
        acceleration_noise = noise * float(np.linalg.norm(self.filter.kernel(2, 0.0)))
        return MotionOfSamples(
            known, load, (place, speed, acceleration), self.machine, noise, acceleration_noise, quiet
        )

    def _reached(self, other: Filter) -> tuple[Indices, Flags]:
        """Places of the samples behind another filter, and which no end and no gap reaches through it, shapes (n,)."""
        rows = self.rows - (other.margin - self.filter.margin)
        last, lost = len(self.recording.forces) - 2 * other.margin - 1, np.r_[0, np.cumsum(self.recording.lost > 0)]
        inside = np.clip(rows, 0, last)
        return inside, (rows == inside) & (lost[inside] == lost[inside + 2 * other.margin])

    def linearised(self, delay: float, values: Array) -> Array:
        """A and the columns of the nuisances at values u, shape (n, 6, u + nuisances).

        Derivatives are those of a shifted filter, not differences of neighbouring samples, between which the window may
        have a gap.
        """
        other_delay = delay + DELAY_STEP if delay < 0.0 else delay - DELAY_STEP  # on the side where the filter reaches
        room = MOST_DELAY - SMOOTHING_STEP  # where it still reaches to both sides
        middle, unknowns = float(np.clip(delay, -room, room)), len(values)
        around = (middle, middle - SMOOTHING_STEP, middle + SMOOTHING_STEP) if self.nuisances == SMOOTHED else ()
        columns = np.empty((len(self.rows), 6, unknowns + len(self.nuisances)))
        delays = tuple(dict.fromkeys((delay, other_delay, *around)))  # the middle is the delay itself as a rule
        for piece, motions in self._motions(*delays):
            at = dict(zip(delays, motions, strict=True))
            matrices, columns_of_piece = regressors(self.model, at[delay]), columns[piece]
            columns_of_piece[:, :, :unknowns] = matrices
            columns_of_piece[:, :, -1] = (expected_forces(self.model, at[other_delay], values) - matrices @ values) / (
                other_delay - delay
            )
            if around:
                now, before, after = (expected_forces(self.model, at[moment], values) for moment in around)
                columns_of_piece[:, :, unknowns] = (before + after - 2.0 * now) / SMOOTHING_STEP**2
        return columns

    def _motions(self, *delays: float) -> Iterator[tuple[slice, list[Kinematics]]]:
        """Motion at several delays, piece by piece; raises StrutsDoNotClose with the place in the file."""
        assert self.recording.drives is not None
        requests = [(order, delay) for delay in delays for order in range(3)]
        struts = decimated(self.filter, self.recording.drives, self.rows, requests)
        for begin in range(0, len(self.rows), PIECE):
            piece = slice(begin, begin + PIECE)
            parts = [s[piece] for s in struts]
            motions: list[Kinematics] = []
            try:
                for k in range(0, len(parts), 3):  # delays differ by so little that their poses are close
                    near = motions[0].pose if motions else None
                    motions.append(self.machine.kinematics(parts[k], parts[k + 1], parts[k + 2], near))
            except StrutsDoNotClose as error:  # say where in the file it is
                row = int(self.filter.margin + self.rows[begin + error.sample])
                raise StrutsDoNotClose(row, error.lengths, self.recording.lines.place(row)) from error
            yield piece, motions

    def robust_covariance(
        self, matrices: Array, residuals: Array, weights: Array, whitening: Array | None
    ) -> Robust | None:
        """Covariance of u for noise of any colour and errors of the pose, from A and residuals; None for short runs."""
        part, share = fair_part(len(residuals)), 1.0
        if len(part) < len(residuals):  # what a fit to the part would leave
            share, matrices, residuals = len(part) / len(residuals), matrices[part], residuals[part]
            top = joint_triangle(matrices, residuals, np.sqrt(weights))
            residuals = residuals - matrices @ np.linalg.lstsq(top[:, :-1], top[:, -1], rcond=None)[0]
        data = turned(matrices, residuals, weights, self._places_of(part))
        data = data._replace(share=share, sources=self.sources)
        assert self.recording.drives is not None
        if self.machine.of_pose:  # the field is one over the lengths of struts
            struts = self.recording.drives[self.filter.margin + self.rows[part]]
            pose_covariance = covariance_by_pose(data, struts, residuals if whitening is None else None)
            if pose_covariance is not None:
                return pose_covariance._replace(sources=source_covariance(data))
        return coloured_covariance(data)

    def _places_of(self, part: Indices) -> Indices:
        """Places of a part of the samples; its stretches follow each other, so far apart that noise is independent."""
        places = self.places[part]
        breaks = np.flatnonzero(np.diff(part) > 1)
        shift = np.zeros(len(part), dtype=np.int64)
        shift[breaks + 1] = np.maximum(np.diff(places)[breaks] - FORGOTTEN, 0)
        return np.asarray(places - np.cumsum(shift))

    def excerpt(self, times: int = 1) -> Self:
        """A part of the run that stands for it, `fair_part`; the run itself where that is all of it."""
        part = fair_part(len(self.rows), times)
        if len(part) == len(self.rows):
            return self
        left_out = np.ones(len(self.rows), dtype=bool)
        left_out[part] = False
        return self.without(left_out)

    def refined(self, fit: Fit, basis: Array, w: Array, delay: float) -> Self:
        """The run with its smoothing to be estimated, where that is worth it; as it is elsewhere."""
        return replace(self, nuisances=SMOOTHED) if _worth_smoothing(self, fit, basis, w, delay) else self

    def findings(self, fit: Fit) -> tuple[Finding, ...]:
        """The smoothing, where it was estimated; a sentence only where it is clear."""
        if self.nuisances != SMOOTHED:
            return ()
        place = len(self.model.parameters)
        std = max(float(fit.covariance[place, place]), float(fit.covariance_robust[place, place])) ** 0.5
        b = float(fit.values[place])
        sentence = phrase(
            "smoothed",
            "forces are {how} against the motion by {size} +- {std} ms^2, half a second moment (leaps between samples, "
            "averaging or a low-pass of the channels): estimated and compensated",
            how=phrase("how_smoothed", "smoothed") if b > 0.0 else phrase("how_sharpened", "sharpened"),
            size=f"{b * 1e6:+.3g}",
            std=f"{std * 1e6:.2g}",
        )
        clear = abs(b) >= CLEAR * std
        return (note(Kind.CLOCK, sentence if clear else "", smoothing_s2={"value": b, "std": std}),)

    def series(self, delay: float, values: Array) -> Residuals:
        """Recorded forces beside the model's at every sample of the window, decimated or not."""
        rows = np.arange(self.rows[0], self.rows[-1] + 1)
        every = self.at((rows if self.spoilt is None else rows[~self.spoilt[rows]])[:MOST_SAMPLES])
        predicted = expected_forces(every.model, every.kinematics(delay), values)
        return Residuals(every.t, every.recorded, predicted, self.filter.step, every.forces)


def signals_at(recording: Recording, low_pass: Filter, rows: Indices) -> tuple[Array, Array, Array]:
    """Times, and forces as recorded and behind the filter, at filtered samples, shape (n,)."""
    assert recording.t is not None
    at = low_pass.margin + rows
    filtered = decimated(low_pass, recording.forces, rows, [(0, 0.0)])[0]
    return recording.t[at], recording.forces[at], filtered


SAMPLED = 1.0 / 12.0  # of T^2: the largest b that sampling alone makes
CLEAR = 3.0  # standard deviations of b from which it is reported
BLOCK = 100_000  # rows that are looked at for that noise, and to which it is added at a time: limits the memory
BANDS = (2.0, 4.0, 8.0)  # by which the band of `MovingRun.motion` is narrower than that of the fit
CALM = 0.05  # of the second derivatives of accelerations, that may be noise of the drives
MOST_OF_IT = 0.6  # of a run, that a longer filter has to leave


def calm(low_pass: Filter, drives: Array, noise: Array, turns: Flags, order: int = 2) -> bool:
    """Whether noise of drives, shape (k,), is small behind a filter, in accelerations bent as often as is looked at.

    Args:
        low_pass: the filter.
        drives: what was recorded, shape (n, k).
        noise: its white noise, shape (k,).
        turns: of which kind each is, shape (k,); those of a kind are judged together.
        order: derivative of it that the forces follow.
    """
    count, step = len(drives) - 2 * low_pass.margin, low_pass.stride
    bends = decimated(low_pass, drives, np.arange(0, count, step), [(order, 0.0)])[0]
    snaps = np.sqrt(np.mean(np.diff(bends, 2, axis=0) ** 2, axis=0))
    kernel = np.pad(low_pass.kernel(order, 0.0), step)
    acceleration_noise = noise * np.linalg.norm(np.roll(kernel, step) + np.roll(kernel, -step) - 2.0 * kernel)
    kinds = [turns == kind for kind in (True, False) if np.any(turns == kind)]
    return all(acceleration_noise[kind].max() <= CALM * snaps[kind].max() for kind in kinds)


def _worth_smoothing(run: MovingRun, fit: Fit, basis: Array, w: Array, delay: float) -> bool:
    """Whether b is worth an estimate: where it is known more closely than sampling can make it, or clear.

    Elsewhere neglecting b biases parameters by less than estimating it would widen them. Noise of the struts looks like
    smoothing, for it disturbs A u and, the other way, its second derivative: where it biases b by more than a standard
    deviation and makes up a third of b, b is left out.
    """
    part, (size, free) = run.excerpt(), basis.shape
    matrices, share = part.regressors(delay), len(part.rows) / len(run.rows)
    expected = matrices @ fit.values[:size]
    # Differences of evaluated samples are near enough to choose by: at the cut-off they see seven tenths of the bend.
    even = np.diff(part.rows) == run.filter.stride
    inner = 1 + np.flatnonzero(even[1:] & even[:-1])
    if len(inner) <= free:
        return False
    slope = (expected[inner + 1] - expected[inner - 1]) / (2.0 * run.step)
    bend = (expected[inner + 1] - 2.0 * expected[inner] + expected[inner - 1]) / run.step**2
    root, residuals = np.linalg.cholesky(w).T, (part.forces - expected)[inner]
    rows = root @ np.dstack([matrices[inner] @ basis, slope, bend, residuals])
    triangle = np.asarray(np.linalg.qr(rows.reshape(-1, free + 3), mode="r"))[:-1]
    information = float(triangle[-1, -2]) ** 2  # on b
    if np.abs(np.diag(triangle)).min() == 0.0:  # nothing bends, as in a standstill
        return False
    std = fit.white_noise * np.sqrt(share / (run.filter.stride * information))
    smoothing = abs(float(triangle[-1, -1] / triangle[-1, -2]))  # forces may be sharpened, as by a structural mode
    if std > SAMPLED * run.filter.step**2 and smoothing < CLEAR * std:
        return False
    assert part.recording.drives is not None
    draw, struts = np.random.default_rng(0), part.recording.drives.copy()
    moving = struts[part.filter.margin + part.rows[0] : part.filter.margin + part.rows[-1]][:BLOCK]
    noise = white_noise(moving)  # of each strut [m]
    for first in range(0, len(struts), BLOCK):
        block = struts[first : first + BLOCK]
        block += noise * draw.standard_normal(block.shape)
    noisy = replace(part, recording=replace(part.recording, drives=struts))
    error = (noisy.regressors(delay) @ fit.values[:size] - expected) @ root.T
    bias = float(np.sum(error[inner] * (2.0 * error[inner] - error[inner + 1] - error[inner - 1]))) / run.step**2
    return bool(bias < max(std, smoothing / CLEAR) * information)
