"""From a recording on one clock to what is evaluated of it: a window, a filter, and what damage leaves out."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from cases.base.errors import Code, IdentificationError, RecordingError
from cases.base.phrases import phrase
from cases.base.units import Array, Flags, Indices
from cases.schema import Case
from identification.finding import Finding, Kind, warning
from identification.machines.of_case import machine_of
from identification.model.model import Model
from identification.recording.formats.sampling import MOST_PUT_BACK
from identification.recording.recording import Recording
from identification.samples.moving import MovingRun, signals_at
from identification.samples.sample_checks import bridged
from identification.samples.samples import MOST_DELAY
from identification.signals import Filter, white_noise
from identification.stretches import off_between, stretches

LEAST_TRAVEL = 1e-4  # [m or rad] of struts or joints; below, the pose counts as constant
MOVING = 1e-3  # [m/s or rad/s] of struts or joints, from which the machine counts as moving, where there is no trigger
STANDING = 0.5e-3  # [m or rad] of struts or joints with the trigger on; below, a run was recorded at standstills
MOST_RATE = 2e3  # a fifth of the samples a second that a recorder of forces takes at most [1/s]
SURE = 6.0  # deviations of the encoders' noise, beyond which a change is motion
PULSE = 0.1  # [s] with the trigger on, at most, that is no standstill
OFF_TRAVEL = 0.5  # share of all travel, below which a switch that is on at both ends is off in motion
NOISY = 10.0  # deviations of noise between the largest and the smallest reading of a standstill
SLOWEST = 0.5  # [s] between samples, from which on no motion is seen in them
MOST_LEFT_OUT = 0.5  # share of the motion lost to damage and the filter's reach around it
# Bad samples in a row that a straight line replaces; behind the filter the difference is negligible.
MOST_BRIDGED = MOST_PUT_BACK


def moving_run(recording: Recording, case: Case, model: Model, whole: bool = False) -> MovingRun:
    """A moving run with its window; filtered samples that missing ones disturb are left out.

    Args:
        whole: evaluate all samples, not only the excitation.

    Raises:
        RecordingError: no struts, no filter in the case, a filter that does not fit the rate, a trigger that is never
        on.
        IdentificationError: the pose is constant.
    """
    require_position(recording, model)
    if recording.drives is None:
        raise RecordingError(
            place=recording.source,
            problem=phrase("clock_and_matrices", "has a clock and rotation matrices"),
            remedy=phrase(
                "moving_from_drives",
                "moving runs are evaluated from drives only, remove t_s if each row is an averaged standstill",
            ),
            code=Code.MISSING,
        )
    low_pass = checked_filter(recording, case)
    warnings: tuple[Finding, ...] = ()
    bad = recording.bad
    invalid = spoilt_by(bad, recording.lost, low_pass)
    struts = bridged(recording.drives, bad)
    recording = replace(recording, drives=struts, forces=bridged(recording.forces, bad))
    if whole:
        low_pass.require(struts, 0.0)
        window = np.arange(len(struts) - 2 * low_pass.margin)
    else:
        window, warnings = _window(recording, low_pass, *case.drive_words)
    together = np.flatnonzero(np.diff(window) == 1)
    missing = int(recording.lost[low_pass.margin + window[together]].sum())
    share = 1.0 - float(np.sum(~invalid[window])) / (len(window) + missing)
    warnings += about_left_out(recording.source, share, low_pass)
    window = window[~invalid[window]]
    rows = window[:: low_pass.stride]
    if len(rows) < 2:
        raise IdentificationError(
            place=recording.source,
            problem=phrase(
                "few_behind_filter",
                "{count} samples of motion are {independent} independent ones behind a {cutoff} Hz filter",
                count=len(window),
                independent=len(rows),
                cutoff=f"{low_pass.cutoff:g}",
            ),
            remedy=phrase("record_longer", "record longer"),
            code=Code.TOO_FEW,
        )
    t, recorded, forces = signals_at(recording, low_pass, rows)
    return MovingRun(
        model=model, t=t, recorded=recorded, forces=forces, recorded_count=len(window), window=warnings,
        filter=low_pass, recording=recording, machine=machine_of(case), rows=rows, spoilt=invalid,
    )  # fmt: skip


def stands_only(recording: Recording) -> bool:
    """Whether a run was recorded at standstills alone: its trigger comes on several times and nothing moves with it."""
    if recording.t is None or recording.drives is None or recording.trigger is None or not delimited(recording.trigger):
        return False
    on = stretches(recording.trigger)
    if len(on) == 2 and (_pulses(on, recording.step) or off_between(recording.trigger)):
        return False  # a motion from one to the other
    ranges = [np.ptp(recording.drives[w], axis=0).max() for w in on if w.stop > w.start + 1]
    return bool(ranges) and bool(max(ranges) < STANDING + NOISY * white_noise(recording.drives).max())


def _pulses(on: Sequence[slice], step: float) -> bool:
    """Whether a trigger comes on for moments only, too short for standstills; `step`: between samples [s]."""
    return all((part.stop - part.start) * step < PULSE for part in on)


def delimited(trigger: Flags | None) -> bool:
    """Whether a trigger, shape (n,), marks standstills: it comes on more than once."""
    return trigger is not None and len(stretches(trigger)) > 1


def checked_filter(recording: Recording, case: Case) -> Filter:
    """The low-pass of a case at the rate of a recording.

    Raises:
        RecordingError: the case has none, it does not fit the rate, or the clock is not uniform.
    """
    cutoff = case.recording.filter_cutoff_Hz
    if cutoff is None:
        raise RecordingError(
            place=recording.source,
            problem=phrase("filter_needed", "a moving run needs a filter"),
            remedy=phrase("state_cutoff", "set recording.filter_cutoff_Hz in the case"),
            code=Code.MISSING,
        )
    if len(recording.forces) < 2:
        raise RecordingError(
            place=recording.source,
            problem=phrase("not_a_run", "{count} sample is not a run", count=len(recording.forces)),
            remedy=phrase("record_longer", "record longer"),
            code=Code.TOO_FEW,
        )
    step = recording.step
    if step >= SLOWEST and (other := _other_clock(step, cutoff)):
        raise RecordingError(
            place=recording.source,
            problem=f"{1 / step:.4g} samples a second are too few for a motion",
            remedy=f"record faster{other}, and a cut-off of some ten Hz",
            code=Code.CLOCK,
        )
    if not cutoff <= 0.2 / step * (1.0 + 1e-3):  # what the message allows is taken, however stamps say the step
        raise RecordingError(
            place=recording.source,
            problem=phrase(
                "cutoff_too_high",
                "filter_cutoff_Hz = {cutoff} is too high for {rate} samples a second",
                cutoff=f"{cutoff:g}",
                rate=f"{1 / step:.4g}",
            ),
            remedy=phrase(
                "at_most", "at most {most}{other}", most=f"{0.2 / step:.4g}", other=_other_clock(step, cutoff)
            ),
            code=Code.CLOCK,
        ).in_doubt()
    return Filter(cutoff, step, MOST_DELAY)


def _other_clock(step: float, cutoff: float) -> str:
    """What to add where the time stamps make sense in a smaller unit."""
    for unit, factor in {"ms": 1e-3, "us": 1e-6}.items():
        if cutoff < 0.2 / (step * factor) < MOST_RATE:
            return f"; time stamps {step:.3g} s apart seem to be in {unit}: set recording.clock.unit = '{unit}'"
    return ""


def spoilt_by(bad: Flags, lost: Indices, low_pass: Filter) -> Flags:
    """Filtered samples that bad ones disturb, unless bridged, or that reach across a gap, shape (n - 2 margin,).

    Args:
        bad: samples that may not be used, shape (n,).
        lost: how many are missing between each and the next, shape (n - 1,).
        low_pass: the filter; each section between gaps is filtered by itself.
    """
    count, margin = len(bad), low_pass.margin
    change = np.zeros(count + 1, dtype=np.int64)
    cuts = 1 + np.flatnonzero(lost)
    np.add.at(change, np.maximum(cuts - margin, 0), 1)
    np.add.at(change, np.minimum(cuts + margin, count), -1)
    ends = {0, count, *cuts.tolist()}  # of sections, beyond which there is nothing to bridge to
    for part in stretches(bad):
        if part.stop - part.start > MOST_BRIDGED or part.start in ends or part.stop in ends:
            change[max(part.start - margin, 0)] += 1
            change[min(part.stop + margin, count)] -= 1
    invalid = np.cumsum(change)[:-1] > 0
    return np.asarray(invalid[margin : count - margin])


def about_left_out(source: str, share: float, low_pass: Filter) -> tuple[Finding, ...]:
    """What to say where damage, with the filter's reach around it, takes a share of the motion.

    Raises:
        RecordingError: it takes too much.
    """
    reach = low_pass.margin * low_pass.step
    if share > MOST_LEFT_OUT:
        raise RecordingError(
            place=source,
            problem=phrase(
                "too_much_damage",
                "damage, with the filter's reach of {reach} s on either side, takes {share} % of the motion, at "
                "most {most} % may be left out",
                reach=f"{reach:.3g}",
                share=f"{100 * share:.3g}",
                most=f"{100 * MOST_LEFT_OUT:g}",
            ),
            remedy=phrase("record_again", "record again"),
            code=Code.DAMAGED,
        )
    if share <= 0.0:
        return ()
    sentence = phrase(
        "left_out",
        "{share} % of the motion is left out: damage longer than {most} samples, gaps, and {reach} s on either side, "
        "as far as the filter reaches",
        share=f"{100 * share:.2g}",
        most=MOST_BRIDGED,
        reach=f"{reach:.3g}",
    )
    return (warning(Kind.DAMAGE, sentence),)


def require_position(recording: Recording, model: Model) -> None:
    """Raises IdentificationError where a model needs the position and the recording has none."""
    if model.needs_position and recording.drives is None:
        raise IdentificationError(
            place=recording.source,
            problem=phrase(
                "position_needed",
                "model {model} needs the platform's position, the recording has orientations only",
                model=model.number,
            ),
            remedy=phrase("other_model_or_drives", "choose model 0 or 6, or record the drives (struts, joints)"),
            code=Code.NOT_SUPPORTED,
        )


def _window(recording: Recording, low_pass: Filter, drives: str, unit: str) -> tuple[Indices, tuple[Finding, ...]]:
    """Samples with the trigger on; without a trigger from the first movement out of rest to rest again."""
    assert recording.drives is not None
    low_pass.require(recording.drives, 0.0)
    warnings: tuple[Finding, ...] = ()
    rows = None if recording.trigger is None else _triggered(recording, recording.trigger, low_pass.margin)
    if rows is None or _marks_no_motion(recording, low_pass.margin + rows):
        moving, count = _moving(recording.drives, low_pass)
        if rows is not None and len(moving):
            assert recording.trigger is not None
            sentence = phrase(
                "trigger_off_in_motion",
                "the trigger is on for {on} s without the motion, in pulses or as a switch that is off in motion: the "
                "motion is evaluated without it",
                on=f"{recording.trigger.sum() * recording.step:.2g}",
            )
            warnings = (warning(Kind.WINDOW, sentence),)
        if rows is None or len(moving):
            rows = np.arange(moving[0], moving[-1] + 1) if len(moving) else np.arange(count)
        if recording.trigger is None and not len(moving):
            sentence = phrase(
                "never_moves",
                "the {drives} are never faster than {least} {unit}/s, so that all of the recording is evaluated; "
                "record a trigger where only a part is meant",
                drives=phrase(drives, drives),
                least=f"{MOVING * 1e3:g}",
                unit=unit,
            )
            warnings = (warning(Kind.WINDOW, sentence),)
    _require_travel(recording, recording.drives, low_pass.margin + rows, drives, unit)
    return rows, warnings


def _triggered(recording: Recording, trigger: Flags, margin: int) -> Indices:
    """Filtered samples with the trigger on, none where that is at the ends; RecordingError where it is never on."""
    if trigger.any():
        return np.flatnonzero(trigger[margin:-margin])
    raise RecordingError(
        place=f"{recording.source}, trigger",
        problem=phrase("trigger_never", "is never 1"),
        remedy=phrase("trigger_or_none", "record with the trigger on during the motion, or leave it out"),
        code=Code.TRIGGER,
    )


def _marks_no_motion(recording: Recording, rows: Indices) -> bool:
    """Whether a trigger is on in pulses, while all stands, or at both ends of a motion; `rows`: where it counts."""
    drives, trigger = recording.drives, recording.trigger
    assert drives is not None
    assert trigger is not None
    on = stretches(trigger)
    travel = np.ptp(drives[rows], axis=0) if len(rows) else np.zeros(drives.shape[1])
    off_in_motion = off_between(trigger) and travel.max() < OFF_TRAVEL * np.ptp(drives, axis=0).max()
    return _pulses(on, recording.step) or off_in_motion or bool(travel.max() < _least_travel(drives))


def _least_travel(drives: Array) -> float:
    """Travel of a drive that counts as one, drives of shape (n, k) [m or rad]."""
    return LEAST_TRAVEL + NOISY * float(white_noise(drives).max())


def _moving(drives: Array, low_pass: Filter) -> tuple[Indices, int]:
    """Filtered samples at which a drive is faster than noise makes it, and how many there are of all."""
    speed = low_pass.apply(drives, 1)
    # of noise behind the filter
    least = SURE * white_noise(drives) * np.sqrt(np.sum(low_pass.kernel(1, 0.0) ** 2))
    return np.flatnonzero(np.any(np.abs(speed) > np.maximum(MOVING, least), axis=1)), len(speed)


def _require_travel(recording: Recording, values: Array, rows: Indices, drives: str, unit: str) -> None:
    """Raises IdentificationError where no drive travels farther than its noise, of drives of shape (n, k)."""
    travel = max(float(np.ptp(drive[rows])) for drive in values.T)
    least_travel = _least_travel(values)
    if travel < least_travel:
        raise IdentificationError(
            place=recording.source,
            problem=phrase(
                "pose_constant",
                "the pose is constant ({drives} move by {travel} {unit}, at least {least} {unit_2} are needed)",
                drives=drives,
                travel=f"{travel * 1000.0:.3g}",
                unit=unit,
                least=f"{least_travel * 1000.0:.3g}",
                unit_2=unit,
            ),
            remedy=phrase("record_excitation", "record the excitation, or remove t_s from averaged standstills"),
            code=Code.NO_EXCITATION,
        ).in_doubt()
