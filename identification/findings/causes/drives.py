"""Hypotheses about recorded drives, struts of a hexapod or joints of a chain: order, sign, offset, unit."""

from collections.abc import Iterator, Sequence
from itertools import combinations, product

import numpy as np
from scipy.spatial.transform import Rotation

from cases.base.phrases import phrase
from cases.base.units import DEG, Array
from cases.chain import Chain, Joint
from cases.machine import turned
from cases.recording_format import STRUTS, Role
from cases.schema import Case
from identification.findings.causes.channels import in_unit, mapped, matrix_of, order_words, orders, other_units, rpy_of
from identification.findings.causes.hypothesis import Affine, Edit, Family, Hypothesis
from identification.texts import number

RIGHT_ANGLES = (90.0, -90.0, 180.0)  # [deg] that zeros of joints are off by where conventions differ


def of_struts(case: Case) -> Iterator[Hypothesis]:
    """Hypotheses about recorded struts of a hexapod, or its drives."""
    numbers = [str(k + 1) for k in range(6)]
    drives = case.recording.drives
    for order in orders(6):
        pairs = sum(place != k for k, place in enumerate(order)) // 2
        swapped = all(order[place] == k for k, place in enumerate(order))
        yield Hypothesis(
            family=Family.DRIVES, words=order_words(order, phrase("struts", "struts"), numbers),
            mistakes=pairs if swapped else 1.5,
            drives=Affine(matrix_of(order), np.zeros(6)), single=pairs > 1 and swapped,
            edit=mapped(STRUTS, order) if drives is None else _drives_in(order),
        )  # fmt: skip
    role = Role.STRUTS if drives is None else Role.DRIVES
    for unit, ratio in other_units(case, role):
        offset = np.zeros(6) if drives is None else (1.0 - ratio) * drives.offset
        yield Hypothesis(
            family=Family.UNITS, words=phrase("struts_in", "{role} are in {unit}", role=role, unit=unit),
            edit=in_unit(role, unit),
            drives=Affine(ratio * np.eye(6), offset),
        )  # fmt: skip
    if drives is None:
        return
    for signs in product((1.0, -1.0), repeat=6):
        flipped = [k for k in range(6) if signs[k] < 0.0]
        if flipped:
            offset = np.where(np.array(signs) < 0.0, 2.0 * drives.offset, 0.0)  # mirrored where the drive stands at 0
            which = ", ".join(numbers[k] for k in flipped)
            yield Hypothesis(
                family=Family.SIGNS,
                words=phrase("strut_signs", "the signs of struts {which} are turned", which=which),
                drives=Affine(np.diag(signs), offset), edit=_with_signs(signs),
                mistakes=1.5 if len(flipped) == 6 else len(flipped), single=1 < len(flipped) < 6,
            )  # fmt: skip


def _drives_in(order: Sequence[int]) -> Edit:
    def edit(case: Case) -> Case:
        form = case.recording
        assert form.drives is not None
        numbers = [form.drives.order[place] for place in order]
        drives = form.drives.model_copy(update={"order": tuple(numbers)})
        return case.model_copy(update={"recording": form.model_copy(update={"drives": drives})})

    return edit


def _with_signs(signs: Sequence[float]) -> Edit:
    def edit(case: Case) -> Case:
        form = case.recording
        assert form.drives is not None
        turned_signs = tuple(present * sign for present, sign in zip(form.drives.sign, signs, strict=True))
        drives = form.drives.model_copy(update={"sign": turned_signs})
        return case.model_copy(update={"recording": form.model_copy(update={"drives": drives})})

    return edit


def of_joints(case: Case, chain: Chain) -> Iterator[Hypothesis]:
    """Hypotheses about recorded joints of a chain."""
    yield from _joint_orders(chain)
    yield from _joint_units(case, chain)
    yield from _joint_signs(chain)
    for k, joint in enumerate(chain.joints):
        if joint.turns:
            yield from (of_offset(chain, k, angle) for angle in RIGHT_ANGLES)


def _names(chain: Chain, places: Sequence[int]) -> str:
    """Numbers of joints, with the names that say more."""
    return ", ".join(_label(chain, k) for k in places)


def _label(chain: Chain, k: int) -> str:
    return f"{k + 1} ({chain.joints[k].name})"


def _joint_orders(chain: Chain) -> Iterator[Hypothesis]:
    labels = [_label(chain, k) for k in range(len(chain.joints))]
    turns = [joint.turns for joint in chain.joints]
    alphabetic = tuple(
        int(np.argsort(np.argsort(chain.names, kind="stable"), kind="stable")[k]) for k in range(len(turns))
    )
    backwards = tuple(range(len(turns)))[::-1]
    orders_tried = {tuple(range(len(turns)))}
    for order in (*orders(len(turns)), alphabetic, backwards):
        if order in orders_tried or any(turns[k] != turns[place] for k, place in enumerate(order)):
            continue
        orders_tried.add(order)
        swapped = all(order[place] == k for k, place in enumerate(order))
        pairs = sum(place != k for k, place in enumerate(order)) // 2
        usual = not swapped or pairs == 1
        words = order_words(order, phrase("joints", "joints"), labels)
        if order == alphabetic:
            words = phrase("alphabetic", "{words} (they were recorded in the order of the alphabet)", words=words)
        yield Hypothesis(
            family=Family.DRIVES, words=words, mistakes=pairs if swapped else 1.5, single=not usual,
            drives=Affine(matrix_of(order), np.zeros(len(order))), edit=mapped(chain.columns, order),
        )  # fmt: skip


def _joint_units(case: Case, chain: Chain) -> Iterator[Hypothesis]:
    turning_ones, sliding_ones = (
        phrase("joints_turning", "joints that turn"),
        phrase("joints_sliding", "joints that slide"),
    )
    for role, turning, what in ((Role.JOINTS, True, turning_ones), (Role.DRIVES, False, sliding_ones)):
        those = np.array([joint.turns == turning for joint in chain.joints])
        if those.any():
            every = phrase("joints", "joints") if those.all() else what
            for unit, ratio in other_units(case, role):
                matrix = np.diag(np.where(those, ratio, 1.0))
                yield Hypothesis(
                    family=Family.UNITS, words=phrase("joints_in", "{every} are in {unit}", every=every, unit=unit),
                    edit=in_unit(role, unit), drives=Affine(matrix, np.zeros(len(those))),
                )  # fmt: skip


def _joint_signs(chain: Chain) -> Iterator[Hypothesis]:
    count = len(chain.joints)
    turning = [k for k in range(count) if chain.joints[k].turns]
    for size in range(1, count + 1):
        for flipped in combinations(range(count), size):
            signs = np.where(np.isin(np.arange(count), flipped), -1.0, 1.0)
            every = list(flipped) in (turning, list(range(count)))
            names, turns = _names(chain, flipped), set(flipped) <= {*turning}
            if size > 1:
                words = (
                    phrase("joints_turn_back", "joints {names} turn the other way", names=names)
                    if turns
                    else phrase("joints_move_back", "joints {names} move the other way", names=names)
                )
            elif turns:
                words = phrase("joint_turns_back", "joint {names} turns the other way", names=names)
            else:
                words = phrase("joint_moves_back", "joint {names} moves the other way", names=names)
            yield Hypothesis(
                family=Family.SIGNS, words=words,
                drives=Affine(np.diag(signs), np.zeros(count)), edit=_other_axes(flipped), place="either",
                mistakes=min(size, 1.5) if every else size, single=size > 1 and not every,
            )  # fmt: skip


def with_joints(case: Case, joints: Sequence[Joint]) -> Case:
    """The case with other joints of its chain."""
    assert case.chain is not None
    assert case.machine is not None
    chain = case.chain.model_copy(update={"joints": tuple(joints)})
    return case.model_copy(update={"machine": case.machine.model_copy(update={"chain": chain})})


def _other_axes(flipped: Sequence[int]) -> Edit:
    def edit(case: Case) -> Case:
        assert case.chain is not None
        joints = list(case.chain.joints)
        for k in flipped:
            x, y, z = joints[k].axis
            joints[k] = joints[k].model_copy(update={"axis": (0.0 - x, 0.0 - y, 0.0 - z)})
        return with_joints(case, joints)

    return edit


def of_offset(chain: Chain, k: int, angle: float, mistakes: float = 1.0, std: float | None = None) -> Hypothesis:
    """A joint stands at an angle where its reading is 0; std: standard deviation of the angle [deg]."""
    offset = np.zeros(len(chain.joints))
    offset[k] = angle * DEG
    return Hypothesis(
        family=Family.OFFSETS,
        words=phrase(
            "joint_zero", "joint {joint} stands at {angle} deg where it reads 0", joint=_label(chain, k),
            angle=number(angle, std, 4),
        ),
        drives=Affine(np.eye(len(offset)), offset), edit=_turned_joint(k, angle), place="either", mistakes=mistakes,
    )  # fmt: skip


def _turned_joint(k: int, angle: float) -> Edit:
    def edit(case: Case) -> Case:
        assert case.chain is not None
        joints = list(case.chain.joints)
        axis = np.array(joints[k].axis) / np.linalg.norm(joints[k].axis)
        matrix: Array = turned(joints[k].rpy) @ Rotation.from_rotvec(axis * angle * DEG).as_matrix()
        rpy = tuple(float(round(v, 3)) + 0.0 for v in np.degrees(rpy_of(matrix)))
        joints[k] = joints[k].model_copy(update={"rpy_deg": rpy})
        return with_joints(case, joints)

    return edit
