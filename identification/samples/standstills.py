"""Standstills in a recorded run: detected with or without a trigger, averaged, matched to poses, made samples."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from cases.base.errors import Code, RecordingError
from cases.base.phrases import phrase
from cases.base.units import DEG, MM, Array, Flags
from cases.schema import Case
from identification.finding import Kind, note
from identification.machines.hexapod import StrutsDoNotClose
from identification.machines.machine import Kinematics
from identification.machines.of_case import machine_of
from identification.model.model import Model, regressors
from identification.recording.formats.table import Lines
from identification.recording.recording import Recording
from identification.samples.moving_window import MOVING, SURE, delimited, require_position
from identification.samples.samples import MotionOfSamples, Standstills
from identification.signals import white_noise
from identification.stretches import stretches

SPEED_SPAN = 0.02  # [s] over which strut speeds are taken: encoder steps of 1 um then look like 0.05 mm/s
LEAVING = 0.04  # [s] of the beginning of a movement that is too slow to be seen
LONGEST_SPAN = 0.2  # [s] the same where encoders are noisy
SHORTEST = 0.1  # [s] of a standstill that is worth averaging
SAME_POSITION = 2.0 * MM  # between a standstill and its pose of the program
SAME_ANGLE = 0.5 * DEG
_COUNTED = Lines(first=1, word="standstill")
BATCHES = 10  # of a standstill: the scatter of their means is the uncertainty of its mean for noise of any colour


def find_standstills(recording: Recording, settle: float) -> list[slice]:
    """Rows of the standstills of a run.

    With a trigger that comes on several times: where it is on. Else, as in a joint trajectory, which switches none:
    where the struts stand, less the time to settle and the beginning of the next movement.

    Args:
        settle: time after a movement that is not averaged, where there is no trigger [s].

    Raises:
        RecordingError: no struts, no clock, nothing stands still, or the machine moves with the trigger on.
    """
    if recording.drives is None or recording.t is None:
        raise RecordingError(
            place=recording.source,
            problem="standstills are found from positions of drives with a clock",
            remedy="record both",
            code=Code.MISSING,
        )
    step = recording.step
    moving = _moving(recording.drives, step)
    trigger = recording.trigger
    if trigger is not None and delimited(trigger):
        windows = stretches(trigger)
        for k, w in enumerate(windows, 1):
            if moving[w].mean() > 0.5:
                raise RecordingError(
                    place=f"{recording.source}, {recording.lines.place(w.start)}",
                    problem=phrase(
                        "moves_in_standstill",
                        "the machine moves while the trigger is on (standstill {number})",
                        number=k,
                    ),
                    remedy=phrase("not_at_poses", "this is not a measurement at poses, identify it as a motion"),
                    code=Code.TRIGGER,
                )
    else:
        settling = round(settle / step)
        standing = ~moving if trigger is None or not trigger.any() else ~moving & trigger
        windows = [slice(w.start + settling, w.stop - round(LEAVING / step)) for w in stretches(standing)]
    windows = [w for w in windows if (w.stop - w.start) * step >= SHORTEST]
    if len(windows) < 2:
        raise RecordingError(
            place=recording.source,
            problem=phrase(
                "few_standstills",
                "{count} standstills of at least {least} s",
                count=len(windows),
                least=f"{SHORTEST:g}",
            ),
            remedy=phrase("record_poses", "record a program of hexcite poses, or identify the run as a motion"),
            code=Code.TOO_FEW,
        )
    return windows


def average(recording: Recording, windows: Sequence[slice]) -> Recording:
    """Means of forces and struts over each standstill, one row each, without a clock.

    Each is weighed by one over the standard deviation of its forces, pooled over the channels in units of each
    channel's own scatter: 1 is usual, less is restless.

    Args:
        windows: rows of each, at least ten.

    Raises:
        RecordingError: a standstill has too few samples with all values.
    """
    assert recording.drives is not None
    rows = [w.start + np.flatnonzero(~recording.bad[w]) for w in windows]
    for w, measured in zip(windows, rows, strict=True):
        if len(measured) < BATCHES:
            raise RecordingError(
                place=f"{recording.source}, {recording.lines.place(w.start)}",
                problem=phrase(
                    "short_standstill",
                    "the standstill that begins here has {count} samples with all values, {needed} are needed",
                    count=len(measured),
                    needed=BATCHES,
                ),
                remedy=phrase("record_again", "record again"),
                code=Code.TOO_FEW,
            )
    forces = np.array([recording.forces[r].mean(axis=0) for r in rows])
    struts = np.array([recording.drives[r].mean(axis=0) for r in rows])
    variance = np.array([variance_of_mean(recording.forces[r]) for r in rows])
    usual = np.maximum(np.median(variance, axis=0), np.finfo(float).tiny)
    scatter = np.sqrt(np.maximum(np.mean(variance / usual, axis=1), 1e-6))
    return replace(
        recording, t=None, drives=struts, forces=forces, trigger=None, poses=None,
        rotations=None, specific_forces=None, override=None, others=(), lines=_COUNTED,
        weights=1.0 / scatter, missing=None, missing_in=(),
    )  # fmt: skip


def _alike(case: Case) -> Callable[[Array, Array], bool]:
    """Whether two poses of a machine are one, as far as a control reaches them; full turns of an endless joint are."""
    limits, turn = case.need_motion("the match of poses")[1], 2.0 * np.pi
    tolerance = np.where(limits.turns, SAME_ANGLE, SAME_POSITION)
    joints = () if case.chain is None else case.chain.joints
    endless = np.array([joint.kind == "continuous" for joint in joints] or [False] * len(limits.turns))

    def same(pose: Array, other: Array) -> bool:
        apart = pose - other
        apart = np.where(endless, apart - turn * np.rint(apart / turn), apart)
        return bool(np.all(np.abs(apart) <= tolerance))

    return same


def among(averages: Recording, case: Case, expected: Array) -> Recording | None:
    """The standstills at some poses, in the order of these; None where one is missing, or there are no others.

    A set of poses can so be evaluated from a run of more of them, as of all candidates.

    Args:
        averages: averaged standstills.
        expected: poses, in the coordinates of the machine, shape (k, n) [m or rad].
    """
    assert averages.drives is not None
    poses, same = machine_of(case).coordinates(averages.drives), _alike(case)
    home, _ = case.need_motion("the match of poses")
    rows: list[int] = []
    for pose in expected:
        remaining = [k for k in range(len(poses)) if k not in rows and same(poses[k], pose)]
        if not remaining:
            return None
        rows.append(min(remaining, key=lambda k: float(np.abs(poses[k] - pose).max())))
    others = [k for k in range(len(poses)) if k not in rows and not same(poses[k], home)]
    if not others:
        return None
    weights = None if averages.weights is None else averages.weights[rows]
    missing = None if averages.missing is None else averages.missing[rows]
    finding = note(
        Kind.WINDOW,
        phrase(
            "standstills_of_plan",
            "{count} of {all} standstills are evaluated, those at the poses of the plan",
            count=len(rows),
            all=len(poses),
        ),
        evaluated_standstills={"evaluated": len(rows), "of": len(poses)},
    )
    return replace(
        averages, drives=averages.drives[rows], forces=averages.forces[rows], weights=weights, missing=missing,
        findings=(*averages.findings, finding),
    )  # fmt: skip


def match(averages: Recording, case: Case, expected: Array, names: str) -> tuple[Recording, slice]:
    """The standstills that belong to the poses of a program, in its order, and which of all they are.

    Those at home around them are left out.

    Args:
        averages: standstills of `average`.
        expected: poses of the program, in the coordinates of the machine, shape (k, n) [m or rad].
        names: the recording, for messages.

    Raises:
        RecordingError: a pose of the program was not measured, or a standstill is not one of its poses.
    """
    assert averages.drives is not None
    assert averages.weights is not None
    home, _ = case.need_motion("the match of poses")
    poses, same = machine_of(case).coordinates(averages.drives), _alike(case)
    first, end = 0, len(poses)
    while end - first > len(expected) and same(poses[first], home) and not same(expected[0], home):
        first += 1
    while end - first > len(expected) and same(poses[end - 1], home) and not same(expected[-1], home):
        end -= 1
    measured = poses[first:end]
    for k in range(max(len(expected), len(measured))):
        if k >= min(len(expected), len(measured)) or not same(measured[k], expected[k]):
            measured_words, expected_words = (
                case.words(rows[k]) if k < len(rows) else "missing" for rows in (measured, expected)
            )
            raise RecordingError(
                place=names,
                problem=f"standstill {k + 1}: {measured_words}; "
                f"pose {k + 1} of the program's {len(expected)}: {expected_words}",
                remedy="record the whole program and nothing else, or name the right plan",
                code=Code.OTHER_SOURCE,
            ).in_doubt()
    part = slice(first, end)
    struts, forces, weights = averages.drives[part], averages.forces[part], averages.weights[part]
    return replace(averages, drives=struts, forces=forces, weights=weights), part


def standstills(recording: Recording, case: Case, model: Model) -> Standstills:
    """Averaged standstills, ready to be evaluated, without the missing ones.

    Raises:
        IdentificationError: the model needs what the recording does not have, or the struts cannot close.
        RecordingError: nothing in it says how the sensors stand.
    """
    require_position(recording, model)
    valid = ~recording.bad
    still = np.zeros((int(valid.sum()), 6))
    known, standing = np.ones(len(still), dtype=bool), None
    if recording.drives is not None:
        none = np.zeros_like(recording.drives[valid])
        try:
            machine = machine_of(case)
            poses = machine.kinematics(recording.drives[valid], none, none)
        except StrutsDoNotClose as error:
            row = int(np.flatnonzero(valid)[error.sample])
            raise StrutsDoNotClose(row, error.lengths, recording.lines.place(row)) from error
        matrices = regressors(model, poses)
        if case.setup != "1a":
            standing = MotionOfSamples(known, poses, (recording.drives[valid], none, none), machine)
    else:
        rotations = _rotations(recording, case)[valid]
        matrices = model.matrices(np.zeros((len(still), 3)), rotations, still, still)
        angles = Rotation.from_matrix(rotations).as_euler("xyz")
        standing = MotionOfSamples(known, Kinematics(np.hstack([0.0 * angles, angles]), still, still))
    t = np.arange(1.0, len(valid) + 1.0) if recording.t is None else recording.t
    scale = np.ones(len(valid)) if recording.weights is None else recording.weights
    forces, scale = recording.forces[valid], scale[valid]
    return Standstills(
        model=model, t=t[valid], recorded=forces, forces=forces * scale[:, None], recorded_count=len(forces),
        matrices=matrices, scale=scale, clocked=recording.t is not None, standing=standing,
    )  # fmt: skip


def _rotations(recording: Recording, case: Case) -> Array:
    """R of each standstill, shape (n, 3, 3); of a frame that does not move any will do where none was recorded."""
    if recording.rotations is not None:
        return recording.rotations
    if case.setup == "1a":
        return np.tile(np.eye(3), (recording.rows, 1, 1))
    raise RecordingError(
        place=recording.source,
        problem="has neither drives nor rotations: nothing says how the sensors stand",
        remedy="give drives (struts or joints), or rotations, one row a standstill",
        code=Code.MISSING,
    )


def _moving(struts: Array, step: float) -> Flags:
    """Whether a strut is faster than what counts as moving, taken over some milliseconds around each row."""
    noise = white_noise(struts)
    half = max(1, round(SPEED_SPAN / step / 2))
    while 2.0 * SURE * noise.max() > MOVING * (2 * half * step) * np.sqrt(half) and half * step < LONGEST_SPAN / 2:
        half += 1  # of the means on either side, the further apart, the less is noise
    most = np.maximum(MOVING, SURE * noise * np.sqrt(2.0 / half) / (half * step))
    if not np.any(SURE * noise * np.sqrt(2.0) > MOVING * SPEED_SPAN):
        rows = np.arange(len(struts))
        before, after = np.maximum(rows - half, 0), np.minimum(rows + half, len(struts) - 1)
        span = np.maximum(after - before, 1)[:, None] * step
        return np.asarray(np.any(np.abs((struts[after] - struts[before]) / span) > most, axis=1))
    from scipy.ndimage import uniform_filter1d

    means = uniform_filter1d(struts, half, axis=0, mode="nearest", origin=0)
    rows = np.arange(len(struts))
    before, after = np.maximum(rows - (half + 1) // 2, 0), np.minimum(rows + half // 2, len(struts) - 1)
    span = np.maximum(after - before, 1)[:, None] * step
    return np.asarray(np.any(np.abs((means[after] - means[before]) / span) > most, axis=1))


def variance_of_mean(forces: Array) -> Array:
    """Variance of the mean of each channel, from the scatter of batch means, slow noise included, shape (6,)."""
    batches = min(BATCHES, len(forces))
    length = len(forces) // batches
    means = forces[: batches * length].reshape(batches, length, -1).mean(axis=1)
    return np.asarray(means.var(axis=0, ddof=1) / batches)
