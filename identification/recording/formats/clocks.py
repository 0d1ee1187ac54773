"""Clocks: when the samples of a stream were taken, by the stamps that its recorder gave them.

A recorder of a control samples at equal steps; stamps of a host that receives these samples stray from them, are late,
are printed with few digits, or go backwards. Samples are therefore taken to be at equal steps on the straight line
through their stamps, which leaves room for those that were lost: stamps that are late come back to the line, behind
lost samples they never do.
"""

from dataclasses import dataclass
from math import ceil
from typing import NamedTuple

import numpy as np

from cases.base.units import Array, Flags, Indices

# Time stamps of equal steps are printed with rounding; beyond this share of a step they are said to stray.
UNIFORMITY = 0.05
GAP = 1.5  # steps between two samples, from which on others were lost between them
PAUSE = 5.0  # lost samples behind which a recorder may have begun anew: the line through the stamps does so too
_MOST_LOST = 0.06  # share of samples that are lost one by one; more at once are a pause
MOST_STRAY = 5.0  # steps by which stamps may be off the line for long
RATE = 0.05  # share by which a part of a run may be faster or slower than all of it, with what its stamps stray by
_FEW_STEPS = 5  # steps that distinguish a changed rate from a gap
_SEEN = 15  # stamps that distinguish a lost sample from a late one, at least
_MOST_SEEN = 401
_SHORT = 50  # stamps of which no scatter is taken
_FAINT = 0.12  # steps (rms) that stamps, or means of them, may stray by for their phases to agree
_AGREE = 0.5  # of phases, from which on samples are at equal steps
_FINEST = 0.05  # turns of a phase over the whole run to which the step is found
_FEW = 100  # phases whose agreement is not chance
_SAME = 1e-3  # share by which a step changes without being called another
_COARSEST = 8  # different stamps from which a step follows
_PARTS = 20  # of a run, whose rates are compared
_WRONG = 16.0  # deviations by which a stamp belongs to another line; those of late ones are no Gaussian
_ALIKE = 0.2  # share by which stamps may be off a stated period to say at all which samples were lost
_NEARLY = 0.2  # step that may be missing in the mean of stamps of few digits behind a lost sample
_ROUNDS = 5  # of fits, between which late stamps are left out
_FIRST = 512  # stamps by which a step is known well enough to count on
_MOST_RATES = 20_000  # rates on either side that are tried
_ENOUGH = 20_000  # stamps that show a step as well as more of them
_SLOWER = (1e-4, 0.05)  # share by which lost samples that cannot be seen singly make a stated period look longer
_BACKWARDS = "is not later than the time stamp above it, but time must increase"
_SORT = "sort the rows, remove the repeated part, or cut the file where one run ends and the next begins"


class Unsteady(NamedTuple):
    """Why stamps are not of samples at equal steps."""

    row: int  # the first that is concerned, counted from 0
    problem: str
    remedy: str
    backwards: bool = False  # whether time does not increase, so that nothing can be made of the stamps


@dataclass(frozen=True, slots=True)
class Even:
    """Samples at equal steps."""

    numbers: Indices  # number of each sample where lost ones count, ascending, shape (n,)
    t: Array  # instants, shape (n,) [s]
    step: float  # [s]
    deviation: float = 0.0  # standard deviation of the step as the stamps give it, as a share of it
    stray: float = 0.0  # of the stamps from these instants, rms [s]
    most: float = 0.0  # the same of the one that is furthest off [s]
    clear: bool = True  # whether a single sample that was lost would be seen
    written: float | None = None  # step that the stamps have where another was stated [s]

    @property
    def strays(self) -> bool:
        """Whether stamps are further off than rounding makes them."""
        return self.most > UNIFORMITY * self.step


def lost_samples(t: Array | None) -> Indices:
    """How many samples were lost between each one and the next, shape (n - 1,).

    By instants of equal steps, ascending, shape (n,) [s]; None: there is no clock, and no loss is known.
    """
    if t is None or len(t) < 3:
        return np.zeros(0 if t is None else max(len(t) - 1, 0), dtype=np.int64)
    return _lost(t, float(np.median(np.diff(t))))


def _lost(t: Array, step: float, least: float = GAP) -> Indices:
    steps = np.diff(t)
    if not steps.max() > least * step or step <= 0.0:
        return np.zeros(len(steps), dtype=np.int64)
    counts = np.maximum(np.rint(steps / step) - 1.0, 1.0)
    return np.asarray(np.where(steps > least * step, counts, 0.0).astype(np.int64))


def evened(t: Array, period: float | None = None) -> Even | Unsteady:
    """Instants of samples at equal steps behind their stamps, or why there are none.

    Args:
        t: stamps in the order of the samples, at least two, shape (n,) [s].
        period: time between two samples that is stated: it counts, and stamps that agree with it say what was lost [s].
    """
    coarse, anchors = _anchors(t)
    if len(t) < _SHORT and np.any(np.diff(t) <= 0.0):
        return Unsteady(1 + int(np.argmax(np.diff(t) <= 0.0)), _BACKWARDS, _SORT, backwards=True)
    if coarse and len(anchors) < _COARSEST:
        row = int(np.argmin(np.diff(t) != 0.0)) + 1
        few = (
            f"is not later than the one above it: the stamps have {len(anchors) + 1} different values in {len(t)} rows"
        )
        return Unsteady(row, few, "state recording.clock.period_ms, or remove the repeated part", backwards=True)
    marks = _Marks(anchors, t[anchors], coarse)
    numbering = _numbers(marks, period)
    if isinstance(numbering, Unsteady):
        return numbering
    numbers, section, clear = numbering
    rows = np.arange(len(t))
    every = rows + np.r_[numbers[0] - anchors[0], numbers - anchors][np.searchsorted(anchors, rows, side="right")]
    line = _line(marks, numbers, section, clear)
    problem = _unsteady(marks, numbers, line)
    if problem is not None:
        return problem
    steps = every - every[0]
    if period is not None:
        start = float(np.mean(marks.t - period * (numbers - every[0])))
        return Even(steps, start + period * steps, period, 0.0, line.stray, line.most, clear, line.step)
    sections = section[np.maximum(np.searchsorted(anchors, rows, side="right") - 1, 0)]
    instants = line.offsets[sections] + line.step * every
    off = t - instants
    off = off - off.mean() if coarse else off  # stamps of few digits are early by half a digit in the mean
    stray, most = float(np.sqrt(np.mean(off**2))), float(np.abs(off).max())
    return Even(steps, instants, line.step, line.deviation, stray, most, clear)


class _Marks(NamedTuple):
    """Stamps that count, with the rows at which they are."""

    rows: Indices
    t: Array
    coarse: bool  # whether their stamps have so few digits that they repeat

    @property
    def usual(self) -> float:
        """Usual time between two rows; late stamps and lost samples do not count [s]."""
        return self.over(1 if len(self.t) < _SHORT else _SEEN)

    def over(self, span: int) -> float:
        """Usual time between two rows by pairs of stamps so many apart [s]."""
        return float(np.median((self.t[span:] - self.t[:-span]) / (self.rows[span:] - self.rows[:-span])))

    def scatter(self, step: float) -> float:
        """Standard deviation of stamps about equal steps, by how far they are from their neighbours [steps]."""
        if len(self.t) < _SHORT:
            return 0.0
        delays = self.t / step - self.rows
        return float(1.4826 / np.sqrt(1.5) * np.median(np.abs(delays[1:-1] - 0.5 * (delays[:-2] + delays[2:]))))


def agrees(t: Array, period: float) -> bool:
    """Whether stamps, shape (n,), are about as far apart as a stated period [s], so that they say what was lost."""
    coarse, anchors = _anchors(t)
    return (
        len(anchors) > (_COARSEST if coarse else 1)
        and abs(_Marks(anchors, t[anchors], coarse).usual / period - 1.0) < _ALIKE
    )


def _anchors(t: Array) -> tuple[bool, Indices]:
    """Whether stamps repeat, or go back by one digit, and the rows that then say most about the instants.

    These are the first of each stamp; else all of them.
    """
    latest = np.maximum.accumulate(t)
    changes = np.flatnonzero(np.diff(latest) > 0.0) + 1
    digit = np.min(np.diff(latest)[changes - 1], initial=np.inf)
    coarse = bool(np.any(np.diff(t) == 0.0)) and np.min(np.diff(t)) > -1.5 * digit
    return coarse, changes if coarse else np.arange(len(t))


def _numbers(marks: _Marks, period: float | None) -> tuple[Indices, Indices, bool] | Unsteady:
    """Number of each marked sample where lost ones count, and the section between two pauses in which it is.

    And whether a single sample that was lost would be seen.
    """
    rows, t, coarse = marks
    steps = np.diff(t)
    usual = marks.usual
    scatter = marks.scatter(usual) if usual > 0.0 else 0.0
    if usual <= 0.0 or steps.min() <= min(0.0, -_WRONG * scatter * usual):
        return Unsteady(int(rows[1 + np.argmin(steps)]), _BACKWARDS, _SORT, backwards=True)
    ratios = steps / usual
    counts = np.maximum(np.rint(ratios), np.diff(rows))
    if np.all(np.abs(ratios - counts) <= UNIFORMITY):  # as a control writes them, apart from losses
        numbers = rows[0] + np.r_[0, np.cumsum(counts)].astype(np.int64)
        return numbers, np.r_[0, np.cumsum(np.diff(numbers) - np.diff(rows) >= PAUSE)], True
    if len(t) < _SHORT and np.all(np.diff(rows) == 1):
        row = int(np.argmax(np.abs(ratios - counts) > UNIFORMITY))
        problem = f"step of {steps[row] * 1e3:.4g} ms that is not a gap, where the run has {usual * 1e3:.4g} ms"
        return Unsteady(row + 1, problem, "export the run at one rate")
    if len(t) < _SHORT:  # where stamps repeat, few of them do not say which samples were lost
        return rows, np.zeros(len(t), dtype=np.int64), False
    width = min(_MOST_SEEN, max(_SEEN, ceil(400.0 * scatter**2)), len(t) // 4) | 1
    pauses = _pauses(t / usual - rows, width)
    section = np.searchsorted(np.array(pauses, dtype=np.int64), np.arange(len(t)), side="right")
    step = _lattice(marks, section, usual, scatter)
    clear = step is not None
    step = step or marks.over(max(_SEEN, len(t) // 10))
    if not clear and period is not None and _SLOWER[0] < step / period - 1.0 < _SLOWER[1]:
        step, clear = period, True
    delays = t / step - rows
    shift = np.zeros(len(t), dtype=np.int64)
    for first, end in zip([0, *pauses], [*pauses, len(t)], strict=True):
        inside = _losses(delays[first:end], width, coarse) if clear else 0
        before = np.median(delays[max(first - width, 0) : max(first, 1)])
        paused = max(int(np.rint(np.median(delays[first:end][:width]) - before)), 1) if first else 0
        shift[first:end] = (shift[first - 1] if first else 0) + paused + inside
    return rows + shift, section, clear


def _lattice(marks: _Marks, section: Indices, usual: float, scatter: float) -> float | None:
    """Step of equal steps of which some are missing: the one with which the phases of all stamps agree best [s].

    None: they agree with none. Means of neighbours stand for stamps that stray by much [steps].
    """
    size = ceil((scatter / _FAINT) ** 2) | 1
    if len(marks.t) < _FEW * size:
        return None
    count = len(marks.t) // size
    places = [part[: count * size].reshape(count, size) for part in (marks.t - marks.t[0], marks.rows, section)]
    # rows between the middle of neighbours and their mean are known
    t = (places[0] - usual * (places[1] - places[1][:, size // 2 : size // 2 + 1])).mean(axis=1)
    place = places[2][:, size // 2]
    rate, reach = 1.0 / usual, min(0.02, 0.4 / size) / usual
    samples, share = min(count, _FIRST), 0.25
    while True:
        chosen = np.unique(np.linspace(0, samples - 1, min(samples, _ENOUGH)).astype(np.int64))
        fine = share / (t[chosen[-1]] - t[0])
        if reach / fine > _MOST_RATES:  # stamps that are years apart, or a pause of many times what was recorded
            return None
        rates = rate + fine * np.arange(-ceil(reach / fine), ceil(reach / fine) + 1)
        starts = np.flatnonzero(np.diff(place[chosen], prepend=-1))
        turns = (np.add.reduceat(np.exp(2j * np.pi * (candidates * t[chosen] % 1.0)), starts) for candidates in rates)
        agreement = np.array([np.abs(turn).sum() for turn in turns]) / len(chosen)
        rate = float(rates[np.argmax(agreement)])
        if samples == count and fine < _FINEST / (t[-1] - t[0]):
            return 1.0 / rate if agreement.max() > _AGREE else None
        samples, reach, share = min(2 * samples, count), 4.0 * fine, share if samples < count else _FINEST / 2.0


def _least_behind(late: Array) -> Array:
    """The least of each value and all behind it, shape (n,)."""
    return np.asarray(np.minimum.accumulate(late[::-1])[::-1])


def _smooth(values: Array, width: int, mean: bool = False) -> Array:
    """Running median or mean, shape (n,)."""
    from scipy.ndimage import median_filter, uniform_filter1d

    return np.asarray((uniform_filter1d if mean else median_filter)(values, width, mode="nearest"))


def _pauses(late: Array, width: int) -> list[int]:
    """The first stamps behind pauses."""
    least = _least_behind(_smooth(late, width))
    rises = np.zeros(len(late), dtype=bool)
    rises[width:] = least[width:] - least[:-width] >= max(PAUSE, _MOST_LOST * width)
    groups = np.split(np.flatnonzero(rises), 1 + np.flatnonzero(np.diff(np.flatnonzero(rises)) > 1))
    spans = ((max(g[0] - width, 0), g[-1]) for g in groups if len(g))
    return sorted({first + 1 + int(np.argmax(np.diff(late[first : last + 1]))) for first, last in spans})


def _phase(late: Array) -> float:
    """By which part of a step stamps are late in the mean, whole steps apart."""
    return float(np.angle(np.exp(2j * np.pi * late).sum())) / (2.0 * np.pi)


def _off(late: Array) -> Array:
    """How far each is from that, and whole steps, shape (n,)."""
    distance = late - _phase(late)
    return np.abs(distance - np.rint(distance))


def _losses(late: Array, width: int, coarse: bool) -> Indices:
    """How many samples were lost before each one of a section, shape (n,), by how late it is [steps].

    Stamps of few digits are off by whole steps either way, more often at one end of a run than at the other: their
    means count, of which only nearly a whole step is a sample.
    """
    smooth = late if _off(late).max() < 0.25 and not coarse else _smooth(late, width, coarse)
    phase = _phase(smooth)
    distance = late - phase
    least = _least_behind(smooth - phase)
    losses = np.floor(least - least[0] + _NEARLY) if coarse else np.rint(least)
    if smooth is late:
        return np.asarray(losses - losses[0], dtype=np.int64)
    bounds = [0, *(np.flatnonzero(np.diff(losses)) + 1).tolist(), len(distance)]
    for before, k, behind in zip(bounds, bounds[1:-1], bounds[2:], strict=False):
        first, end = max(before, k - width), min(behind, k + width)
        fewer, more = np.abs(distance[first:end] - losses[k - 1]), np.abs(distance[first:end] - losses[k])
        best = first + int(np.argmin(np.r_[0.0, np.cumsum(fewer - more)]))
        if best > 0:
            low, high = losses[k - 1], losses[k]
            losses[first:best], losses[best:end] = low, high
    return np.asarray(losses - losses[0], dtype=np.int64)


class _Line(NamedTuple):
    """Straight lines through stamps over the numbers of their samples, of one step."""

    step: float  # [s]
    deviation: float  # standard deviation of the step, as a share of it
    offsets: Array  # instant of number 0 by the line of each section, shape (k,) [s]
    strays: Array  # of the stamps from it, shape (n,) [s]

    @property
    def stray(self) -> float:
        """Rms [s]."""
        return float(np.sqrt(np.mean(self.strays**2)))

    @property
    def most(self) -> float:
        """Of the stamp that is furthest off [s]."""
        return float(np.abs(self.strays).max())


def _line(marks: _Marks, numbers: Indices, section: Indices, clear: bool) -> _Line:
    """The lines; stamps that are late by far no longer count once the others have shown where the lines are.

    Where single lost samples are not seen, a share p of n that are lost at random makes stamps wander by w = sqrt(p n /
    15) steps (rms) about the line, and the step too long by p. Stamps of few digits may all be rounded up at one end of
    a run and down at the other.
    """
    t = marks.t
    counted = np.ones(len(t), dtype=bool)
    for _ in range(_ROUNDS):
        count = np.maximum(np.bincount(section, weights=counted), 1.0)
        middle = np.bincount(section, weights=numbers * counted) / count
        mean = np.bincount(section, weights=t * counted) / count
        away, delays = (numbers - middle[section]) * counted, (t - mean[section]) * counted
        spread = max(float(away @ away), np.finfo(float).tiny)
        step = float(away @ delays) / spread
        offsets = mean - step * middle
        strays = t - offsets[section] - step * numbers
        scatter = 1.4826 * float(np.median(np.abs(strays - np.median(strays))))
        counted = np.abs(strays) <= max(_WRONG * scatter, abs(step))
        if counted.all():
            break
    # errors of stamps follow each other while a host is busy: sums over parts of the run say how much they weigh
    parts = np.array_split(away * strays * counted, min(_PARTS, len(t)))
    deviation = float(np.sqrt(np.sum([part.sum() ** 2 for part in parts]))) / spread / step
    if marks.coarse and np.abs(strays).max() > UNIFORMITY * step:
        deviation = float(np.hypot(deviation, _NEARLY / (numbers[-1] - numbers[0])))
    if not clear:
        wander = [float(part.mean()) / step for part in np.array_split(strays, min(_PARTS, len(t)))]
        deviation = float(np.hypot(deviation, 15.0 * np.mean(np.square(wander)) / (numbers[-1] - numbers[0])))
    return _Line(step, deviation, offsets, strays)


def _unsteady(marks: _Marks, numbers: Indices, line: _Line) -> Unsteady | None:
    """Why samples are not at equal steps although they were numbered; None: they are."""
    usual, cut = marks.usual, "export the run at one rate, or cut it there"
    row = _slowed(np.diff(numbers) - np.diff(marks.rows), line)
    if row is not None:
        step = (marks.t[row + 1] - marks.t[row]) / (marks.rows[row + 1] - marks.rows[row])
        problem = f"step of {step * 1e3:.4g} ms that is not a gap, where the run has {usual * 1e3:.4g} ms"
        return Unsteady(int(marks.rows[row + 1]), problem, cut)
    if line.most <= UNIFORMITY * line.step:
        return None
    lasting = line.strays if line.most <= MOST_STRAY * line.step else _smooth(line.strays, len(numbers) // _PARTS | 1)
    if np.abs(lasting).max() <= MOST_STRAY * line.step and not _rate_changes(numbers, line):
        return None
    # where two rates meet, stamps are furthest from the line between first and last
    bend = int(np.argmax(np.abs(lasting - np.interp(numbers, numbers[[0, -1]], lasting[[0, -1]]))))
    bend = min(max(bend, 2), len(numbers) - 3)
    before, behind = (float(np.median(np.diff(marks.t[part]) / np.diff(numbers[part]))) * 1e3
                      for part in (slice(0, bend + 1), slice(bend, None)))  # fmt: skip
    problem = f"steps of {behind:.4g} ms from here on, of {before:.4g} ms before"
    if abs(behind / before - 1.0) < _SAME:
        problem = (
            f"the time stamps are {np.abs(lasting).max() * 1e3:.3g} ms from equal steps of {line.step * 1e3:.4g} ms"
        )
        cut = f"{cut}, or state recording.clock.period_ms"
    return Unsteady(int(marks.rows[bend]), problem, cut)


def _rate_changes(numbers: Indices, line: _Line) -> bool:
    """Whether a part of a run is faster or slower than all of it, beyond what its stamps stray by."""
    for part in np.array_split(np.arange(len(numbers)), _PARTS):
        half = len(part) // 2
        if half < 2:
            continue
        early, behind = part[:half], part[-half:]
        apart = float(np.median(numbers[behind]) - np.median(numbers[early])) * line.step
        rate = float(np.median(line.strays[behind]) - np.median(line.strays[early])) / apart
        if abs(rate) > RATE + _WRONG * 1.25 * np.sqrt(2.0 / half) * line.stray / apart:
            return True
    return False


def _slowed(lost: Indices, line: _Line) -> int | None:
    """The first of steps from which on the rate has changed, by the samples that each lost, shape (n - 1,); None: none.

    A recorder that is busy loses a third of its samples for a while, now one and now two. One at another rate loses as
    many in each step, or some in all of many steps, or its samples lie between those of the first rate.
    """
    off = np.abs(line.strays) > max(UNIFORMITY * line.step, 4.0 * 1.4826 * float(np.median(np.abs(line.strays))))
    alike = np.r_[np.diff(lost) == 0, False] & (lost > 0)  # as the next one
    between = (lost > 0) & (off[1:] | off[:-1])
    width = 2 * _FEW_STEPS
    rates = (
        _crowded(alike, width - 1, width - 1),
        _crowded(lost > 0, 2 * width, 2 * width),
        _crowded(between, width, _FEW_STEPS),
    )
    return min((first for first in rates if first is not None), default=None)


def _crowded(there: Flags, width: int, least: int) -> int | None:
    """The first of flags, shape (n,), of which at least so many are set among `width` in a row; None: nowhere."""
    total = np.r_[0, np.cumsum(there)]
    width = min(width, len(there))
    many = total[width:] - total[:-width] >= least
    if not many.any():
        return None
    return int(np.argmax(many) + np.argmax(there[np.argmax(many) :]))
