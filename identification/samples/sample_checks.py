"""What is wrong with a recording although every number in it could have been measured: checked before any estimate.

Samples that no estimate may use are marked and named with their place; what makes a run useless is an error.
"""

from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from cases.base.errors import Code, RecordingError, Remedy, Write
from cases.base.phrases import NOTHING, Phrase, phrase
from cases.base.units import DEG, MM, Array, Flags, Indices
from cases.chain import Margin
from cases.machine import MotionLimits
from cases.recording_format import CLOCK, ROLE_UNITS, STRUTS, Role
from cases.schema import Case
from identification.finding import Finding, Kind, warning
from identification.recording.formats.clocks import lost_samples
from identification.recording.formats.names.misnamed import SMOOTH
from identification.recording.formats.quantities import CONTRADICTED
from identification.recording.formats.sampling import spread
from identification.recording.formats.table import Lines, Stream
from identification.recording.recording import Recording
from identification.stretches import off_between, stretches

Problem = tuple[int, str, Flags]  # number of a channel or drive, counted from 1, what is wrong with it, and where

FULL_RANGE = 0.999  # share of a sensor's range, from which on it is at its end
FLAT = 5  # samples in a row at the largest or smallest value of a channel, as where it is clipped
DIGITS = 5.0  # of a channel, by which others must change for it to be stuck: one that counts 10 N stands still for long
MOST_NAMED = 3  # places of one finding that a message lists
NEVER = 1e-9  # probability below which a silence of a channel is not chance
OUTLIER = 20.0  # robust standard deviations by which a single sample leaves its neighbours
SHAKEN = 4.0  # the same for accelerations of struts, from which on a force that leaves its neighbours is the motion's
BENT, BESIDE = 0.5, 3  # share of a jump, and samples beside it, by which slopes change where the motion makes it
TOGETHER = 10  # samples between a leap of the motion and that of the forces, delay included
LONELY = 5.0  # times what most samples around it do, for a glitch
LONELY_SHARE = 90.0  # [%] of these samples
LONELY_WIDTH = 101  # samples around
_THINGS = {
    "channel": phrase("a_channel", "channel"),
    "strut": phrase("a_strut", "strut"),
    "joint": phrase("a_joint", "joint"),
}
_AT_ONCE = 10_000  # windows in memory
_ENOUGH = 200_000  # samples that suffice for a median
SWIFT = 5.0  # times the limits of a drive: no motion of this machine, but a reading that jumps
TRAVELLING = 1e-4  # [m/s] of the struts from which a sensor that never changes is suspicious
MOST_BAD = 0.3  # of the samples; a run that is worse is to be recorded again
SMALL_STEP = 2.0 * MM  # of the struts between rows: standstills further apart are not samples of a motion
SMALL_TURN = 0.01  # [rad] the same for orientations
SMALL_SHARE = 0.02  # the same, of the range of the drive that moves most, where there are so many rows
MANY_ROWS = 1000  # that nobody took them one by one along a line
LEAST_ROWS = 50  # without a clock, from which on a smooth sequence is taken for a motion


def places(lines: Lines, rows: Flags) -> str:
    """Where rows stand in the file: `line 12`, `lines 12 to 40 and 77`, and how many more."""
    spans = [(span.start, span.stop - 1) for span in stretches(rows)]
    numbers = [[lines.number(k) for k in dict.fromkeys(span)] for span in spans[:MOST_NAMED]]
    ranges = [" to ".join(map(str, ends)) for ends in numbers]
    more = f" and {len(spans) - MOST_NAMED} more places" if len(spans) > MOST_NAMED else ""
    plural = "s" if int(rows.sum()) > 1 else ""
    return f"{lines.word}{plural} {', '.join(ranges)}{more}"


class CleanRun(NamedTuple):
    """A run on one clock that was looked through by `scan`."""

    recording: Recording  # all samples that no estimate may use are marked missing
    findings: tuple[Finding, ...]  # about the recording


def scan(recording: Recording, case: Case) -> CleanRun:
    """The run of a recording on one clock, its standstills averaged where it has any, without unusable samples.

    Args:
        case: range of the sensors, workspace and limits of the machine.

    Raises:
        RecordingError: rows without a clock that are samples of a motion, or so much damage that the rest is not a run.
    """
    if recording.t is None:
        _require_standstills(recording, case)
    bad, damage = _damage(recording, case)
    findings = [*unmeasured(recording), *damage, *_outside(recording, case)]
    if bad.mean() > MOST_BAD:
        if (error := _in_kept_unit(recording, case, float(bad.mean()))) is not None:
            raise error
        raise RecordingError(
            place=recording.source,
            problem=phrase(
                "mostly_damaged",
                "{share} % of the samples are unusable, at most {most} % may be: {damage}",
                share=f"{100 * bad.mean():.0f}",
                most=f"{100 * MOST_BAD:.0f}",
                damage=next(f for f in findings if f.kind is Kind.DAMAGE),
            ),
            remedy=phrase(
                "mend_sensor", "mend the sensor and record again, or name the case of the machine that was recorded"
            ),
            code=Code.DAMAGED,
        ).in_doubt()
    return CleanRun(replace(recording, missing=bad), tuple(findings))


def _damage(recording: Recording, case: Case) -> tuple[Flags, list[Finding]]:
    """Samples that no estimate may use, shape (n,), and findings about those that were measured."""
    bad, findings = recording.bad.copy(), list[Finding]()
    channels = (_clipped(recording, case), _silent(recording), _jumping(recording, case))
    drive = "strut" if case.chain is None else "joint"
    for thing, problems in (*(("channel", [*alike]) for alike in channels), (drive, [*_leaping(recording, case)])):
        if problems:  # one finding for all that err alike, in full for the one with the most rows
            number, text, _ = max(problems, key=lambda problem: int(problem[2].sum()))
            others = ", ".join(str(k) for k, *_ in problems if k != number)
            names = {"thing": _THINGS[thing]}
            also = phrase("also_others", " (likewise {thing} {others})", others=others, **names) if others else NOTHING
            rows = np.any([rows for *_, rows in problems], axis=0)
            sentence = phrase(
                "damaged", "{thing} {number} {what}{also}; left out", number=number, what=text, also=also, **names
            )
            findings.append(warning(Kind.DAMAGE, sentence, places(recording.lines, rows)))
            bad |= rows
    return bad, findings


def _in_kept_unit(recording: Recording, case: Case, bad: float) -> RecordingError | None:
    """The error where the unit that the case keeps for forces makes a run useless, and another, tried, does not.

    Args:
        bad: share of the samples that are unusable.
    """
    form, most = case.recording, case.sensors.range_N
    kept = form.units.get(Role.FORCES)
    channels = case.sensor_frame.channels[: 3 if case.sensor_frame.has_moments else 6]
    if kept is None or most is None or form.files or form.scale.keys() & {*channels}:
        return None
    units = ROLE_UNITS[Role.FORCES]
    contradictions = (f.quantity.get(CONTRADICTED) for f in recording.findings)
    labels = [entries["says"] for entries in contradictions if entries and entries["key"] == "recording.units.forces"]
    unit = units.symbol(labels[0]) if labels else units.usual
    if unit is None or units[unit] == units[units.symbol(kept) or kept]:
        return None
    forces = recording.forces.copy()
    forces[:, : len(channels)] *= units[unit] / units[units.symbol(kept) or kept]
    if _damage(replace(recording, forces=forces), case)[0].mean() > MOST_BAD:
        return None
    fits = (
        phrase("unit_of_labels", "the unit is that of the labels")
        if labels
        else phrase("unit_in_range", "no label states a unit, and in {unit} forces are within the range", unit=unit)
    )
    error = RecordingError(
        place=recording.source,
        problem=phrase(
            "kept_unit",
            "recording.units.forces of the case says {kept}, in which {share} % of the samples are unusable: forces of "
            "up to {largest} N, the range is {most} N",
            kept=kept,
            share=f"{100 * bad:.0f}",
            largest=f"{np.nanmax(np.abs(recording.forces[:, : len(channels)])):.4g}",
            most=f"{most:g}",
        ),
        remedy=phrase("set_forces_unit", "set {key} = '{unit}' in the case", unit=unit, key="recording.units.forces"),
        code=Code.UNIT,
    )
    error.remedies = (Remedy(fits, (Write(("recording", "units", "forces"), unit),)),)
    return error


def unmeasured(recording: Recording) -> tuple[Finding, ...]:
    """Findings about how a run was read and what was not measured: units and clocks, values that are missing, gaps."""
    elsewhere = [replace(f, sentence=f"{s.source}, {f}") for s in recording.others for f in missing_values(s)]
    return *recording.findings, *missing_values(recording), *elsewhere


def bridged(values: Array, bad: Flags) -> Array:
    """Values with bad samples bridged between good neighbours (`spread`), shape (n, k)."""
    return spread(values[~bad], np.flatnonzero(~bad), np.arange(len(bad)), False) if bad.any() else values


def missing_values(stream: Stream) -> list[Finding]:
    """Values that were not measured, and samples that were lost."""
    findings, every = [], stream.lines.every
    rows = [k // every for k in stream.lines.inserted if k % every == 0]
    inserted = _at(np.array([row for row in rows if row < stream.rows], dtype=int), stream.rows)  # of a part of a run
    if np.any(stream.bad & ~inserted):
        names = ", ".join(dict.fromkeys(stream.missing_in))
        findings.append(
            warning(
                Kind.DAMAGE,
                phrase("no_value", "no measured value in {names}; left out", names=names),
                places(stream.lines, stream.bad & ~inserted),
            )
        )
    if inserted.any():
        before = np.r_[inserted[1:] & ~inserted[:-1], False]
        sentence = phrase(
            "lost_bridged",
            "{behind}; bridged from their neighbours",
            behind=_behind(stream.lines, before, int(inserted.sum())),
        )
        findings.append(warning(Kind.DAMAGE, sentence))
    gaps = lost_samples(stream.t)
    if gaps.any():
        sentence = phrase(
            "lost_gap", "{behind}; no filter reaches across", behind=_behind(stream.lines, gaps > 0, int(gaps.sum()))
        )
        findings.append(warning(Kind.DAMAGE, sentence))
    return findings


def _behind(lines: Lines, rows: Flags, count: int) -> Phrase:
    """What to say of rows behind which samples are missing, and of how many are in all."""
    if count == 1:
        return phrase("one_lost_behind", "behind {places}: 1 sample is missing", places=places(lines, rows))
    return phrase(
        "lost_behind", "behind {places}: {count} samples are missing", places=places(lines, rows), count=count
    )


def _clipped(recording: Recording, case: Case) -> Iterator[Problem]:
    """Forces and moments at the end of the sensors' range."""
    for k, most in enumerate(() if case.sensors.range is None else case.sensors.range):
        if (rows := at_full_range(recording.forces[:, k], most)).any():
            text = phrase(
                "at_full_range",
                "is at the end of its range of {most} {unit}",
                most=f"{most:g}",
                unit=case.sensor_frame.units[k],
            )
            yield k + 1, text, rows


def at_full_range(force: Array, most: float) -> Flags:
    """Samples of a channel, shape (n,), at the end of its range [N or N m].

    Of one that reads a constant far beyond its range, as raw values of converters do, the constant does not count: it
    is at an end where it stays at its largest or smallest value.
    """
    beyond = np.abs(force) >= FULL_RANGE * most
    if not beyond.all() or not 0.0 < np.ptp(force) <= 2.0 * most:
        return np.asarray(beyond)
    flat = np.zeros(len(force), dtype=bool)
    for end in (force.min(), force.max()):
        for part in stretches(force == end):
            flat[part] = part.stop - part.start >= FLAT
    return flat


def _silent(recording: Recording) -> Iterator[Problem]:
    """Force channels that stop changing although the machine moves: a saturated amplifier, a bus that repeats."""
    if recording.t is None or recording.drives is None or len(recording.t) < LEAST_ROWS:
        return
    travel = TRAVELLING * float(np.median(np.diff(recording.t)))
    for k in range(6):
        still = np.diff(recording.forces[:, k]) == 0.0
        steps_of = np.abs(np.diff(recording.forces[:, k]))
        digit = float(np.min(steps_of[steps_of > 0.0], initial=np.inf))  # what the channel changes by at least
        if np.isfinite(digit) and np.ptp(recording.forces[:, k]) <= DIGITS * digit:
            continue  # a moment about the axis of a load, say, of which the sensor shows a few digits
        usual = float(np.clip(np.mean(still), 0.01, 0.999))
        least = int(np.ceil(np.log(NEVER / len(still)) / np.log(usual)))
        rows = np.zeros(len(recording.forces), dtype=bool)
        for steps in stretches(still):
            if steps.stop - steps.start < least:
                continue
            # The other channels distinguish a stuck sensor from constant forces.
            span = slice(steps.start, steps.stop + 1)
            others = np.ptp(np.delete(recording.forces[span], k, axis=1), axis=0).max()
            moves = np.abs(np.diff(recording.drives[span], axis=0)).max(axis=1) > travel
            if others > (DIGITS * digit if np.isfinite(digit) else 0.0) and moves.mean() > 0.5:
                rows[span] = True
        if rows.any():
            value = f"{recording.forces[np.argmax(rows), k]:g}"
            yield k + 1, phrase("stuck_in_motion", "is stuck at {value} while the machine moves", value=value), rows


def _jumping(recording: Recording, case: Case) -> Iterator[Problem]:
    """Single samples too far from their neighbours: no noise moves forces so far."""
    if recording.t is None or len(recording.t) < LEAST_ROWS:
        return
    for k in range(6):
        force = recording.forces[:, k]
        jumps = np.abs(_from_neighbours(force))
        usual = 1.4826 * _median(jumps)
        # An acceleration that steps moves the force lastingly: the samples on both sides do not agree then.
        leaps = _peaks(jumps, max(OUTLIER * usual, 1e-9 * max(float(force.max()), -float(force.min()))))
        leaps = leaps[np.abs(force[leaps + 2] - force[leaps]) < jumps[leaps]]
        # A jerk that changes its sign bends the force lastingly: slopes before and after do not agree then.
        leaps = leaps[_bend(force, leaps + 1) < BENT * jumps[leaps]]
        leaps = leaps[~_shaken(recording, leaps + 1)]
        # A drive that ripples makes forces that leap again and again; a glitch stands alone.
        leaps = leaps[jumps[leaps] > LONELY * _around(jumps, leaps)]
        if usual > 0.0 and len(leaps):
            text = phrase(
                "jumps",
                "jumps by up to {most} {unit} for single samples",
                most=f"{jumps[leaps].max():.4g}",
                unit=case.sensor_frame.units[k],
            )
            yield k + 1, text, _at(leaps + 1, len(force))


def _leaping(recording: Recording, case: Case) -> Iterator[Problem]:
    """Single samples of struts or joints too far from their neighbours for any drive."""
    if recording.t is None or recording.drives is None or len(recording.t) < LEAST_ROWS:
        return
    step = float(np.median(np.diff(recording.t)))
    gaps = np.flatnonzero(recording.lost)
    for k, (velocity, acceleration) in enumerate(_fastest(case)):
        jumps = np.abs(_from_neighbours(recording.drives[:, k]))
        for row in (gaps - 1, gaps):  # neighbours that are not neighbours in time
            jumps[row[(row >= 0) & (row < len(jumps))]] = 0.0
        leaps = _peaks(jumps, SWIFT * max(acceleration * step**2, 0.1 * velocity * step))
        # Values that are held for some samples step again and again; a glitch stands alone.
        leaps = leaps[jumps[leaps] > LONELY * _around(jumps, leaps)]
        if len(leaps):
            turns = case.chain is not None and case.chain.joints[k].turns
            text = phrase(
                "drive_jumps",
                "jumps by up to {most} {unit} between samples {step} ms apart, which its limit of {limit} forbids",
                most=f"{jumps[leaps].max() / (DEG if turns else MM):.4g}",
                unit="deg" if turns else "mm",
                step=f"{step * 1e3:.3g}",
                limit=f"{velocity / DEG:.4g} deg/s" if turns else f"{velocity:g} m/s",
            )
            yield k + 1, text, _at(leaps + 1, len(recording.forces))


def _fastest(case: Case) -> list[tuple[float, float]]:
    """Largest velocity and acceleration of each strut or joint [m/s or rad/s, m/s^2 or rad/s^2]; none if unknown."""
    motion = None if case.limits is None else case.limits.motion
    if isinstance(motion, MotionLimits):
        return [(motion.strut_velocity_m_s, motion.strut_acceleration_m_s2)] * len(STRUTS)
    return [] if motion is None else list(zip(motion.rate.tolist(), motion.acceleration.tolist(), strict=True))


def _from_neighbours(values: Array) -> Array:
    """How far samples are from the middle of their neighbours, shape (n - 2,)."""
    deviations = values[:-2] + values[2:]
    deviations *= -0.5
    deviations += values[1:-1]
    return np.asarray(deviations)


def _bend(values: Array, rows: Indices) -> Array:
    """Half of what the slope changes by across some samples, in units of the values, shape of `rows`."""
    slopes = np.diff(values)
    before, after = (np.clip(rows + k, 0, len(slopes) - 1) for k in (-BESIDE - 1, BESIDE))
    return np.asarray(np.abs(slopes[after] - slopes[before]) / 2.0)


def _median(values: Array) -> float:
    """The median, of a long series by many of its values."""
    return float(np.median(values[:: max(1, len(values) // _ENOUGH)]))


def _at(rows: Indices, count: int) -> Flags:
    marked = np.zeros(count, dtype=bool)
    marked[rows] = True
    return marked


def _around(size: Array, index: Indices) -> Array:
    """What most samples around some of them stay below, shape of `index`."""
    half = LONELY_WIDTH // 2
    rank = int(LONELY_WIDTH * LONELY_SHARE / 100.0)
    levels = np.empty(len(index))
    for start in range(0, len(index), _AT_ONCE):
        part = index[start : start + _AT_ONCE]
        windows = size[np.clip(part[:, None] + np.arange(-half, half + 1), 0, len(size) - 1)]
        levels[start : start + _AT_ONCE] = np.partition(windows, rank, axis=1)[:, rank]
    return levels


def _shaken(recording: Recording, rows: Indices) -> Flags:
    """Whether at or shortly before some samples the acceleration of a strut leaves its neighbours, shape of `rows`."""
    # Encoders see an acceleration through two differences of their steps, far less clearly than force sensors. The
    # limit is low: noise of Gaussian struts hides one glitch in a hundred, but no motion is cut.
    if recording.drives is None or not len(rows):
        return np.zeros(len(rows), dtype=bool)
    near = np.clip(rows[:, None] + np.arange(-TOGETHER, TOGETHER + 1), 2, len(recording.drives) - 3)
    mask = np.zeros(near.shape, dtype=bool)
    for k in range(recording.drives.shape[1]):
        deviations = np.abs(_from_neighbours(np.diff(recording.drives[:, k], 2)))
        usual = 1.4826 * _median(deviations)
        if usual > 0.0:
            mask |= deviations[near - 2] > SHAKEN * usual
    return np.asarray(mask.any(axis=1))


def _peaks(size: Array, most: float) -> Indices:
    """Places that are larger than `most` and not smaller than their neighbours, which see half of it."""
    large = np.flatnonzero(size > most)
    before, after = (size[np.clip(large + k, 0, len(size) - 1)] for k in (-1, 1))
    return np.asarray(large[(size[large] >= before) & (size[large] >= after)])


def _outside(recording: Recording, case: Case) -> list[Finding]:
    """Struts or joints beyond their ends by more than the margin: a run of another machine, or a wrong offset."""
    if recording.drives is None or (ends := _ends(case)) is None:
        return []
    low, high, near = ends
    beyond: Array = np.maximum(low - recording.drives, recording.drives - high)
    if not (beyond > near).any():
        return []
    row, worst = np.unravel_index(int(beyond.argmax()), beyond.shape)
    others = int((beyond > 0.0).any(axis=0).sum()) - 1
    joint = None if case.chain is None else case.chain.joints[worst]
    unit = MM if joint is None else joint.unit
    values = {
        "also": phrase("and_others", " (and {count} others)", count=others) if others else NOTHING,
        "low": f"{low[worst] / unit:g}",
        "high": f"{high[worst] / unit:g}",
    }
    value = f"{recording.drives[row, worst] / unit:.6g}"
    if joint is None:
        text = phrase(
            "strut_outside",
            "strut {number} of {length} mm{also} is outside the workspace of {low} to {high} mm; check offset and "
            "order of the struts, or workspace.strut_length_mm",
            number=worst + 1,
            length=value,
            **values,
        )
    else:
        text = phrase(
            "joint_outside",
            "joint {name} at {position} {unit}{also} is beyond its ends of {low} to {high} {unit}; check zeros, signs "
            "and order of the joints, or {key}",
            name=joint.name,
            position=value,
            unit="deg" if joint.turns else "mm",
            key=f"machine.chain.joints[{worst + 1}].position_{'deg' if joint.turns else 'mm'}",
            **values,
        )
    return [warning(Kind.CASE, text, places(recording.lines, np.any(beyond > 0.0, axis=1)))]


def _ends(case: Case) -> tuple[Array, Array, Array] | None:
    """Lower and upper end of each strut or joint and what encoders may be beyond them, shape (k,) [m or rad]."""
    if case.chain is not None:
        (low, high), turns = case.chain.position, [joint.turns for joint in case.chain.joints]
    elif case.workspace is not None:
        low, high = (np.full(len(STRUTS), end) for end in case.workspace.strut_length)
        turns = [False] * len(STRUTS)
    else:
        return None
    margin = Margin() if case.limits is None else case.limits.margin
    near = [margin.of_way(*way) for way in zip(low.tolist(), high.tolist(), turns, strict=True)]
    return low, high, np.array(near)


def cut_off(recording: Recording) -> list[Finding]:
    """Where the recorder stopped before the run did: its trigger, which changes, is on in the last row."""
    trigger = recording.trigger
    if recording.t is None or trigger is None or not trigger[-1] or trigger.all() or off_between(trigger):
        return []
    sentence = phrase(
        "cut_off", "the recording ends while the trigger is on; its end is missing, record until the machine rests"
    )
    return [warning(Kind.WINDOW, sentence, recording.lines.place(len(trigger) - 1))]


def _distance(step: float, drive: int, of_drives: bool, case: Case) -> str:
    """How far apart rows are, in words, by the drive that moves most."""
    turns = not of_drives or (case.chain is not None and case.chain.joints[drive].turns)
    return f"{step:.2g} rad" if turns else f"{step / MM:.3g} mm"


def _require_standstills(recording: Recording, case: Case) -> None:
    """Raises RecordingError where rows without a clock follow each other as samples of a motion do."""
    for values, small in ((recording.drives, SMALL_STEP), (recording.rotations, SMALL_TURN)):
        if values is None or len(values) < LEAST_ROWS:
            continue
        flat = values.reshape(len(values), -1)
        first, second = np.diff(flat, axis=0), np.diff(flat, n=2, axis=0)
        steps = np.abs(first).max(axis=1)
        step = float(np.median(steps[steps > 0.0])) if steps.any() else 0.0  # a motion may stand now and then
        most = int(np.argmax(np.sum(first**2, axis=0)))
        share = SMALL_SHARE if len(values) >= MANY_ROWS else 0.0
        if 0.0 < step < max(small, share * float(np.ptp(flat[:, most]))) and np.mean(second**2) < SMOOTH**2 * np.mean(
            first**2
        ):
            distance = _distance(step, most, values is recording.drives, case)
            clock = case.recording.columns.get(CLOCK)
            no_clock = "has no t_s column" if clock is None else f"has no column {clock!r} for t_s, as the case says"
            raise RecordingError(
                place=recording.source,
                problem=f"{no_clock}, yet its {len(values)} rows are {distance} apart and smooth like samples of a "
                "motion, not averaged standstills",
                remedy="add the time, map its name in [recording.columns] or give recording.clock.period_ms",
                code=Code.CLOCK,
            )
