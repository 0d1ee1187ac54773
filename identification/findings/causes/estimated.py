"""Hypotheses with a size: an angle, a direction, a gain, found where they leave least."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.spatial.transform import Rotation

from cases.base.units import DEG, Array
from cases.schema import Case
from identification.findings.causes.channels import angle_and_axis, excess_of, of_gain, of_point, of_turn
from identification.findings.causes.drives import of_offset
from identification.findings.causes.geometry import of_turned_bars
from identification.findings.causes.hypothesis import (
    AS_RECORDED,
    Family,
    Hypothesis,
    Size,
    Trial,
    channels_of,
    together,
)
from identification.findings.causes.instants import Instants
from identification.findings.causes.surroundings import leaning_of, of_gravity, of_pace, of_share
from identification.findings.causes.trials import Fits, fits_of, moments_about, tried

SIZED = 1.3  # mistakes that a hypothesis with a size counts for: round values are preferred to it
FREE = 1.6  # the same of a turn about any axis
BEST = 2  # starts of each that are refined
ROUNDS = 9
COARSELY = 4  # rounds on the coarse instants
PROMISING = 3.0  # times the least residuals on the coarse instants, up to which sizes are found on all
SHRINKING = 0.55  # of the steps from round to round
PACE = 5.5  # factor by which seconds of a recording may be longer or shorter, unless their unit is another
LEAST_ANGLE = 0.3  # [deg] below which an angle is not a mistake that people make
LEAST_OFFSET = 2e-3  # [m], the same of an offset
FARTHEST = 5.0  # [m] from the sensor that anybody has moments about
LEAST_SHARE = 0.02  # of a weight, the same


@dataclass(frozen=True, slots=True)
class Sized:
    """A family of hypotheses over sizes, shape (k,) each."""

    family: Family
    # None for a size that is not a mistake; with standard deviations of what words state of it, where they are known
    of_size: Callable[[Array, Sequence[float] | None], Hypothesis | None]
    starts: tuple[tuple[float, ...], ...]
    steps: tuple[float, ...]  # by which sizes are changed at first
    of_channels: bool  # whether it changes forces alone
    stated: Callable[[Array], Array]  # the numbers that words state of a size
    nudge: float = 0.1  # share of a step by which residuals change in proportion

    def make(self, size: Array) -> Hypothesis | None:
        """The hypothesis of a size; None where that is not a mistake."""
        return self.of_size(size, None)

    def found(self, size: Array) -> Size:
        """A size that was found."""
        return Size(size, self.nudge * np.array(self.steps), self.of_size, self.stated)

    def hypotheses(self, sizes: Sequence[Array]) -> list[tuple[Array, Hypothesis]]:
        """Those of some sizes that are mistakes."""
        hypotheses_of_sizes = [(size, self.make(size)) for size in sizes]
        return [(size, hypothesis) for size, hypothesis in hypotheses_of_sizes if hypothesis is not None]


def sized_of(instants: Instants, prefix: Trial) -> Iterator[Sized]:
    """The hypotheses with a size of a run, beside others that are taken for granted."""
    case = instants.case
    if case.sensor_frame.has_moments:
        yield from _turns(case)
        if instants.step is not None and instants.turning is None:
            yield _share(case)
            yield from _point(instants, prefix)
        if instants.turning is None or instants.turning.specific is None:
            yield _slopes(case)
    elif case.sensor_frame.bars is not None:
        yield _turned_bars()
        yield _slopes(case)
    else:
        yield _slopes(case)
    for channel in range(6):
        yield _gain(case, channel)
    if case.chain is not None:
        for k, joint in enumerate(case.chain.joints):
            if joint.turns:
                yield _offset(case, k)
    if instants.drives is not None and instants.step is not None:
        yield _pace(instants.step)


def _turns(case: Case) -> Iterator[Sized]:
    """The sensor is turned by any angle about one of its axes, or about any."""

    def of_turn_by(turn: Rotation, weight: float, stds: Sequence[float] | None) -> Hypothesis | None:
        return of_turn(case, turn, weight, stds=stds) if np.degrees(turn.magnitude()) > LEAST_ANGLE else None

    def about(axis: Array) -> Callable[[Array, Sequence[float] | None], Hypothesis | None]:
        return lambda size, stds: of_turn_by(Rotation.from_rotvec(axis * size[0]), SIZED, stds)

    def turned(axis: Array) -> Callable[[Array], Array]:
        return lambda size: angle_and_axis(Rotation.from_rotvec(axis * size[0]))

    angles = tuple((float(angle),) for angle in np.arange(-165.0, 180.1, 15.0) * DEG)
    for axis in np.eye(3):
        yield Sized(Family.SENSOR, about(axis), angles, (7.0 * DEG,), True, turned(axis))
    starts = tuple(tuple(turn.as_rotvec()) for turn in Rotation.create_group("O"))
    yield Sized(
        Family.SENSOR,
        lambda size, stds: of_turn_by(Rotation.from_rotvec(size), FREE, stds),
        starts,
        (12.0 * DEG,) * 3,
        True,
        lambda size: angle_and_axis(Rotation.from_rotvec(size)),
    )


def _within_a_turn(size: Array) -> Array:
    """An angle between -180 and 180 deg, shape (1,)."""
    return np.asarray((size + 180.0) % 360.0 - 180.0)


def _turned_bars() -> Sized:
    def make(size: Array, stds: Sequence[float] | None) -> Hypothesis | None:
        angle = float(_within_a_turn(size)[0])
        return of_turned_bars(angle, SIZED, _only(stds)) if abs(angle) > LEAST_ANGLE else None

    starts = tuple((float(a),) for a in np.arange(-165.0, 180.1, 15.0))
    return Sized(Family.BARS, make, starts, (7.0,), False, _within_a_turn)


def _only(stds: Sequence[float] | None) -> float | None:
    """The standard deviation of the one number that words state."""
    return None if stds is None else float(stds[0])


def _slopes(case: Case) -> Sized:
    """Gravity along any direction: two angles from one of the axes, of which the first size is the number."""
    frames = [Rotation.align_vectors([axis], [[0.0, 0.0, 1.0]])[0] for axis in np.vstack([np.eye(3), -np.eye(3)])]
    lean = np.tan(35.0 * DEG)
    starts = [(float(k), x, y) for k in range(6) for x in (-lean, 0.0, lean) for y in (-lean, 0.0, lean)]

    def along(size: Array) -> Array:
        return np.asarray(frames[round(float(size[0]))].apply([size[1], size[2], 1.0]))

    def leaning(size: Array) -> Array:
        return np.array([leaning_of(case, along(size))])

    def make(size: Array, stds: Sequence[float] | None) -> Hypothesis | None:
        return of_gravity(case, along(size), SIZED, std=_only(stds)) if leaning(size)[0] > LEAST_ANGLE else None

    return Sized(Family.GRAVITY, make, tuple(starts), (0.0, 0.2, 0.2), False, leaning)


def _share(case: Case) -> Sized:
    def make(size: Array, stds: Sequence[float] | None) -> Hypothesis | None:
        share = float(size[0])
        known = min(abs(share), abs(share - 1.0)) < LEAST_SHARE  # raw, or without all of the weight
        return None if known else of_share(case, share, SIZED, _only(stds))

    starts = tuple((float(s),) for s in np.arange(-0.5, 2.0, 0.25))
    return Sized(Family.COMPENSATED, make, starts, (0.1,), False, lambda size: 100.0 * size)


def _point(instants: Instants, prefix: Trial) -> Iterator[Sized]:
    (about,) = moments_about(instants, [prefix])
    if not about.residuals < np.inf or np.linalg.norm(about.point) > FARTHEST:
        return

    def make(size: Array, stds: Sequence[float] | None) -> Hypothesis | None:
        return of_point(instants.case, size, SIZED, stds) if np.linalg.norm(size) > LEAST_OFFSET else None

    yield Sized(Family.POINT, make, (tuple(about.point),), (2e-3,) * 3, True, lambda size: 1e3 * size)


def _gain(case: Case, channel: int) -> Sized:
    def make(size: Array, stds: Sequence[float] | None) -> Hypothesis | None:
        gain = float(np.exp(size[0]))
        return of_gain(case, channel, gain, _only(stds)) if abs(gain - 1.0) > 0.01 else None

    starts = tuple((float(np.log(gain)),) for gain in (0.25, 0.5, 0.8, 0.95, 1.05, 1.25, 2.0, 4.0))
    return Sized(Family.GAINS, make, starts, (0.1,), True, lambda size: np.array([excess_of(float(np.exp(size[0])))]))


def _offset(case: Case, k: int) -> Sized:
    chain = case.chain
    assert chain is not None

    def make(size: Array, stds: Sequence[float] | None) -> Hypothesis | None:
        angle = float(_within_a_turn(size)[0])
        return of_offset(chain, k, angle, SIZED, _only(stds)) if abs(angle) > LEAST_ANGLE else None

    starts = tuple((float(a),) for a in np.arange(-150.0, 181.0, 30.0))
    return Sized(Family.OFFSETS, make, starts, (12.0,), False, _within_a_turn)


def _pace(step: float) -> Sized:
    def make(size: Array, stds: Sequence[float] | None) -> Hypothesis | None:
        pace = float(np.exp(size[0]))
        return of_pace(step, pace, _only(stds)) if abs(pace - 1.0) > 0.01 and 1.0 / PACE < pace < PACE else None

    starts = tuple((float(value),) for value in np.linspace(-np.log(0.9 * PACE), np.log(0.9 * PACE), 19))
    # small enough for as many samples to be evaluated
    return Sized(Family.CLOCK, make, starts, (0.08,), False, lambda size: 1e3 * step * np.exp(size), nudge=2e-4)


@dataclass(frozen=True, slots=True)
class _Point:
    """A size of a family on the way to where it leaves least."""

    sized: Sized
    size: Array
    residuals: float
    proposed: Array  # size to go on from


def refined(
    instants: Instants, coarse: Instants, families: Sequence[Sized], prefix: Trial, worth: float = np.inf
) -> list[Trial]:
    """The best of each family, sizes found on the coarse instants and then on all, beside other hypotheses.

    Args:
        instants: all of them.
        coarse: some of them.
        families: hypotheses with a size.
        prefix: the hypotheses that are taken for granted.
        worth: residuals on the coarse instants up to which it is worth while to find a size on all.
    """
    starts = [(sized, np.array(start)) for sized in families for start in sized.starts]
    on, on_all = _Prefixed(coarse, prefix), _Prefixed(instants, prefix)
    residuals = on.residuals_of(starts)
    points: list[_Point] = []
    for sized in families:
        positions = [k for k, (other, _) in enumerate(starts) if other is sized and np.isfinite(residuals[k])]
        best = sorted(positions, key=lambda k: residuals[k])[:BEST]
        points += [_Point(sized, starts[k][1], np.inf, starts[k][1]) for k in best]
    for k in range(COARSELY):
        points = _stepped(on, points, SHRINKING**k)
    most = min([worth, *(PROMISING * point.residuals for point in points)])
    promising = [point for point in points if point.residuals <= most]
    others = [point for point in points if not point.residuals <= most]
    for k in range(COARSELY, ROUNDS):
        promising = _stepped(on_all, promising, SHRINKING**k)
    hypotheses = [(point, point.sized.make(point.size)) for point in (*promising, *others)]
    return [
        together(*prefix, replace(hypothesis, size=point.sized.found(point.size)))
        for point, hypothesis in hypotheses
        if hypothesis is not None
    ]


def settled(instants: Instants, coarse: Instants, trial: Trial) -> Trial:
    """A trial whose sizes are found once more, each beside the others: one was found before the other was known."""
    now = trial
    for family in [hypothesis.family for hypothesis in trial if hypothesis.size is not None]:
        others = tuple(hypothesis for hypothesis in now if hypothesis.family is not family)
        sized_of_family = [sized for sized in sized_of(coarse, others) if sized.family is family]
        possible = [now, *refined(instants, coarse, sized_of_family, others)]
        now = possible[int(np.argmin(tried(instants, possible, [AS_RECORDED]).residuals[:, 0]))]
    return now


def _stepped(on: "_Prefixed", points: Sequence[_Point], shrunk: float) -> list[_Point]:
    """Points after a step of each: to the minimum of the parabola through three sizes of each kind."""
    trial_sizes: list[tuple[Sized, Array]] = []
    for point in points:
        steps = np.diag(point.sized.steps)[np.flatnonzero(point.sized.steps)] * shrunk
        trial_sizes += [(point.sized, point.proposed + step) for step in (0.0 * steps[0], *steps, *-steps)]
        trial_sizes.append((point.sized, point.size))
    residuals, results = list(on.residuals_of(trial_sizes)), []
    for point in points:
        moved = np.flatnonzero(point.sized.steps)
        values, before = np.array([residuals.pop(0) for _ in range(1 + 2 * len(moved))]), residuals.pop(0)
        sizes = [trial_sizes.pop(0)[1] for _ in range(2 + 2 * len(moved))]
        best = int(np.argmin(values))
        if not values[best] < before:
            results.append(replace(point, residuals=before, proposed=point.size))
            continue
        size, proposed = sizes[best], sizes[best].copy()
        if best == 0:
            squares = values**2
            for place, k in enumerate(moved):
                high, low = squares[1 + place], squares[1 + len(moved) + place]
                bend, slope = low - 2.0 * squares[0] + high, (high - low) / 2.0
                if np.isfinite([low, high]).all() and bend > 0.0:
                    proposed[k] -= np.clip(slope / bend, -1.0, 1.0) * point.sized.steps[k] * shrunk
        results.append(_Point(point.sized, size, float(values[best]), proposed))
    return results


@dataclass(frozen=True)
class _Prefixed:
    """Instants, and hypotheses that are taken for granted, beside which sizes of others are tried."""

    instants: Instants
    prefix: Trial

    @cached_property
    def fits(self) -> Fits:
        """The model under what is taken for granted."""
        return fits_of(self.instants, [self.prefix])

    def residuals_of(self, wanted: Sequence[tuple[Sized, Array]]) -> Array:
        """Residuals under some sizes of families, over the noise; infinity where they are not mistakes."""
        hypotheses = [sized.make(size) for sized, size in wanted]
        residuals = np.full(len(hypotheses), np.inf)
        in_sensor = not any(hypothesis.in_base for hypothesis in self.prefix)
        columns = [
            k for k, (sized, _) in enumerate(wanted) if hypotheses[k] is not None and sized.of_channels and in_sensor
        ]
        rows = [k for k, hypothesis in enumerate(hypotheses) if hypothesis is not None and k not in {*columns}]
        if columns:
            before = np.linalg.inv(channels_of(self.prefix))  # the fits have it already
            channels = [channels_of(together(*self.prefix, *_alone(hypotheses[k]))) @ before for k in columns]
            residuals[columns] = self.fits.outcome_with(np.array(channels)).residuals[0]
        if rows:
            changes = [together(*self.prefix, *_alone(hypotheses[k])) for k in rows]
            residuals[rows] = tried(self.instants, changes, [AS_RECORDED]).residuals[:, 0]
        return residuals


def _alone(hypothesis: Hypothesis | None) -> Trial:
    return () if hypothesis is None else (hypothesis,)
