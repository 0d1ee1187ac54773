"""Hypotheses about how a recording was read, which no map of its drives makes: clocks, leaps of joints, poses."""

from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import replace

import numpy as np

from cases.base.errors import HexciteError
from cases.base.phrases import phrase
from cases.base.units import Array
from cases.machine import POSE
from cases.orientation import ANGLES, CONVENTIONS, OF_ANGLES, QUATERNION, ROLL_PITCH_YAW, Convention
from cases.recording_format import TICKS, Role
from cases.schema import Case
from identification.findings.causes.channels import in_unit, mapped, order_words, other_units, scaled
from identification.findings.causes.drives import with_joints
from identification.findings.causes.hypothesis import Edit, Family, Hypothesis
from identification.machines.hexapod import Hexapod
from identification.recording.formats.reading import written_columns
from identification.recording.recording import Recording

Changed = Callable[[Recording, Case], Recording | None]
Turns = Callable[[Array], Array]
"""Rotation matrices, shape (n, 3, 3), or what a file writes of them, from rotation matrices."""

SHORTEST, LONGEST = 1e-5, 0.2  # [s] between samples of a recorder
HALF_TURN = np.pi
USUAL_CUTOFF = 0.08  # of the samples a second, where a cut-off that fits another clock means nothing


def of_recording(recording: Recording, case: Case) -> Iterator[Hypothesis]:
    """Hypotheses about how a recording was read."""
    if recording.t is not None and len(recording.t) > 1:
        yield from _clocks(recording, case)
    if case.chain is not None and recording.drives is not None:
        yield from _leaps(recording, case)
    if recording.rotations is not None and case.setup != "1a":
        yield from _orientations(recording, case, _of_rotations)
    if recording.poses is not None and case.hexapod is not None:
        yield from _orientations(recording, case, _of_poses)
        yield from _positions(case)


def _clocks(recording: Recording, case: Case) -> Iterator[Hypothesis]:
    assert recording.t is not None
    step = float(np.median(np.diff(recording.t)))
    now = TICKS[case.recording.clock_unit]
    clocks = {now}
    for unit, tick in TICKS.items():
        ratio = tick / now
        if tick in clocks or not SHORTEST <= step * ratio <= LONGEST:
            continue
        clocks.add(tick)
        words = phrase("stamps_in", "time stamps are in {unit}", unit=unit)
        edit = _with_clock(unit, step * ratio, ratio)
        yield Hypothesis(family=Family.CLOCK, words=words, edit=edit, recorded=_at_pace(ratio))


def _at_pace(ratio: float) -> Callable[[Recording, Case], Recording | None]:
    def changed(recording: Recording, case: Case) -> Recording | None:
        del case
        if recording.t is None:
            return None
        others = tuple(s if s.t is None else replace(s, t=s.t * ratio) for s in recording.others)
        return replace(recording, t=recording.t * ratio, others=others)

    return changed


def _with_clock(unit: str, step: float, ratio: float) -> Edit:
    """Another unit of the stamps, and a cut-off that fits it where that of the case does not."""

    def edit(case: Case) -> Case:
        form = case.recording
        clock = form.clock.model_copy(update={"unit": unit})
        update: dict[str, object] = {"clock": clock}
        cutoff, highest = form.filter_cutoff_Hz, 0.2 / step
        if cutoff is not None and not 0.02 * highest <= cutoff <= highest:
            scaled = cutoff / ratio
            fitting = scaled if 0.1 * highest <= scaled <= highest else USUAL_CUTOFF / step
            update["filter_cutoff_Hz"] = float(f"{min(fitting, 40.0):.2g}")
        return case.model_copy(update={"recording": form.model_copy(update=update)})

    return edit


def _leaps(recording: Recording, case: Case) -> Iterator[Hypothesis]:
    """Joints that turn, whose readings leap by a turn: as if they had no ends."""
    chain, positions = case.chain, recording.drives
    assert chain is not None
    assert positions is not None
    leaping = [
        k
        for k, joint in enumerate(chain.joints)
        if joint.turns and np.any(np.abs(np.diff(positions[:, k])) > HALF_TURN)
    ]
    if not leaping:
        return

    def changed(recording: Recording, case: Case) -> Recording | None:
        del case
        if recording.drives is None:
            return None
        struts: Array = recording.drives.copy()
        struts[:, leaping] = np.unwrap(struts[:, leaping], axis=0)
        return replace(recording, drives=struts)

    def edit(case: Case) -> Case:
        assert case.chain is not None
        joints = list(case.chain.joints)
        for k in leaping:
            joints[k] = joints[k].model_copy(update={"kind": "continuous", "position_deg": None})
        return with_joints(case, joints)

    names = ", ".join(f"{k + 1} ({chain.joints[k].name})" for k in leaping)
    if len(leaping) > 1:
        words = phrase("joints_leap", "readings of joints {names} leap by 360 deg", names=names)
    else:
        words = phrase("joint_leaps", "readings of joint {names} leap by 360 deg", names=names)
    yield Hypothesis(family=Family.CLOCK, words=words, edit=edit, recorded=changed)


OTHER_QUATERNIONS = ((1, 2, 3, 0), (3, 0, 1, 2), (3, 2, 1, 0))  # orders in which they are written: qw last, or first
SIGNED = 1.2  # mistakes that a convention which nobody is known to use, or a sign, counts for


def _orientations(recording: Recording, case: Case, of: Callable[[Turns], Changed]) -> Iterator[Hypothesis]:
    """Orientations that are written in another way than they are read, given what makes a recording of other turns."""
    now = _convention(recording, case)
    written = _written(recording, case, now)
    for other in OF_ANGLES if now.columns == ANGLES else CONVENTIONS.values():
        if other is not now and other.columns == now.columns:
            users = f" ({other.users})" if other.users else ""
            yield Hypothesis(
                family=Family.ORIENTATION,
                words=phrase("written_as", "orientations are written as '{name}'{users}", name=other.name, users=users),
                edit=_in_convention(other), recorded=of(_rewritten(written, other)),
                mistakes=1.0 if other.users or other.inverse else SIGNED,
            )  # fmt: skip
    if now.form == "quaternion":
        for order in OTHER_QUATERNIONS:
            words = order_words(order, phrase("quaternion", "the parts of the quaternion"), QUATERNION)
            change = _rewritten(written, now, np.eye(4)[list(order)])
            yield Hypothesis(
                family=Family.ORIENTATION, words=words, edit=mapped(QUATERNION, order), recorded=of(change)
            )
    if now.columns == ANGLES:
        yield from _angles(case, now, written, of)


def _convention(recording: Recording, case: Case) -> Convention:
    """That by which the orientations were read: the stated one, else that of the columns which the files have."""
    if case.recording.orientation is not None:
        return CONVENTIONS[case.recording.orientation]
    unstated = (ROLL_PITCH_YAW, CONVENTIONS["quaternion"], CONVENTIONS["matrix"])
    for convention in unstated:
        if {*case.recording.columns} & {*convention.columns}:
            return convention
    for convention in unstated:
        with suppress(HexciteError):
            if written_columns(recording.paths, case, convention.columns) is not None:
                return convention
    return CONVENTIONS["matrix"] if case.hexapod is None else ROLL_PITCH_YAW


def _angles(case: Case, now: Convention, written: Turns, of: Callable[[Turns], Changed]) -> Iterator[Hypothesis]:
    """Angles in another unit, or with another sign."""
    for unit, ratio in other_units(case, Role.ANGLES):
        yield Hypothesis(
            family=Family.UNITS, words=phrase("angles_in", "angles of the pose are in {unit}", unit=unit),
            edit=in_unit(Role.ANGLES, unit),
            recorded=of(_rewritten(written, now, ratio * np.eye(3))),
        )  # fmt: skip
    for signs in ((-1.0, 1.0, 1.0), (1.0, -1.0, 1.0), (1.0, 1.0, -1.0), (-1.0, -1.0, -1.0)):
        names = [name for name, sign in zip(ANGLES, signs, strict=True) if sign < 0.0]
        files = ", ".join(case.recording.file_name(name) for name in names)
        yield Hypothesis(
            family=Family.ORIENTATION, mistakes=SIGNED,
            words=phrase("sign_turned", "the sign of {name} is turned", name=files),
            edit=scaled(dict.fromkeys(names, -1.0)), recorded=of(_rewritten(written, now, np.diag(signs))),
        )  # fmt: skip


def _written(recording: Recording, case: Case, now: Convention) -> Turns:
    """What the file holds, from the turns that were read by a convention: where it can be, from the file itself.

    Angles of a rotation are not unique, and rotation vectors of more than half a turn are others then.
    """
    values: Array | None = None
    with suppress(HexciteError):
        values = written_columns(recording.paths, case, now.columns)

    def written(turns: Array) -> Array:
        return values if values is not None and len(values) == len(turns) else now.values(turns)

    return written


def _rewritten(written: Turns, other: Convention, matrix: Array | None = None) -> Turns:
    """The turns by another convention, or of changed values."""
    return lambda turns: other.matrices(written(turns) if matrix is None else written(turns) @ matrix.T)


def _in_convention(other: Convention) -> Edit:
    def edit(case: Case) -> Case:
        form = case.recording.model_copy(update={"orientation": other.name})
        return case.model_copy(update={"recording": form})

    return edit


def _of_rotations(change: Turns) -> Changed:
    def changed(recording: Recording, case: Case) -> Recording | None:
        del case
        if recording.rotations is None:
            return None
        return replace(recording, rotations=change(recording.rotations))

    return changed


def _of_poses(change: Turns) -> Changed:
    """The recording with other orientations of its poses."""
    from scipy.spatial.transform import Rotation

    def changed(recording: Recording, case: Case) -> Recording | None:
        if recording.poses is None:
            return None
        turns = change(Rotation.from_euler("xyz", recording.poses[:, 3:]).as_matrix())
        angles = Rotation.from_matrix(turns).as_euler("xyz")
        return _with_poses(recording, case, np.hstack([recording.poses[:, :3], angles]))

    return changed


def _with_poses(recording: Recording, case: Case, poses: Array) -> Recording:
    return replace(recording, poses=poses, drives=Hexapod.of(case).strut_lengths(poses))


def _positions(case: Case) -> Iterator[Hypothesis]:
    """Positions of a hexapod's platform in another unit, order, or with another sign."""
    names = POSE[:3]

    def of_matrix(matrix: Array) -> Changed:
        def changed(recording: Recording, case: Case) -> Recording | None:
            if recording.poses is None:
                return None
            return _with_poses(recording, case, np.hstack([recording.poses[:, :3] @ matrix.T, recording.poses[:, 3:]]))

        return changed

    for unit, ratio in other_units(case, Role.POSITIONS):
        yield Hypothesis(
            family=Family.UNITS, words=phrase("positions_in", "positions are in {unit}", unit=unit),
            edit=in_unit(Role.POSITIONS, unit),
            recorded=of_matrix(ratio * np.eye(3)),
        )  # fmt: skip
    for order in ((1, 0, 2), (2, 1, 0), (0, 2, 1), (1, 2, 0), (2, 0, 1)):
        yield Hypothesis(
            family=Family.DRIVES, words=order_words(order, phrase("positions", "positions"), names),
            edit=mapped(names, order),
            recorded=of_matrix(np.eye(3)[list(order)]),
        )  # fmt: skip
    for k, name in enumerate(names):
        signs = np.where(np.arange(3) == k, -1.0, 1.0)
        yield Hypothesis(
            family=Family.SIGNS, mistakes=SIGNED,
            words=phrase("sign_turned", "the sign of {name} is turned", name=case.recording.file_name(name)),
            edit=scaled({name: -1.0}), recorded=of_matrix(np.diag(signs)),
        )  # fmt: skip
