"""Conventions by which recordings write an orientation: the words, the columns, and the rotation matrix.

R turns vectors of the platform or sensor {P} into the base {B}. Angles of a recording are `a_deg`, `b_deg`, `c_deg`:
the first, the second and the third that the convention names, whatever the file calls them.

Users of conventions as the manuals of Basler's rc_cube and Mech-Mind's software list them (pose formats, Euler angles).
"""

import re
import warnings
from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import product
from typing import Literal

import numpy as np

from cases.base.units import Array

ANGLES = ("a_deg", "b_deg", "c_deg")
QUATERNION = ("qw", "qx", "qy", "qz")
ROTATION = tuple(f"r{i}{j}" for i in range(1, 4) for j in range(1, 4))
Form = Literal["angles", "rotation vector", "quaternion", "matrix"]


@dataclass(frozen=True, slots=True)
class Convention:
    """One way of writing an orientation."""

    name: str  # what `recording.orientation` calls it
    form: Form
    words: str  # what the numbers are, for people
    users: str  # who writes it; empty where we know of nobody
    axes: str = (
        ""  # of angles the axes that they turn about, in their order: capital letters where the axes turn with them
    )
    inverse: bool = False  # whether the numbers turn vectors of the base into the sensor's frame

    @property
    def columns(self) -> tuple[str, ...]:
        """Our names of the columns that it needs."""
        return {"quaternion": QUATERNION, "matrix": ROTATION}.get(self.form, ANGLES)

    def matrices(self, values: Array) -> Array:
        """R of each row, shape (n, 3, 3).

        Args:
            values: the columns, shape (n, 3, 4 or 9) [rad; quaternions and matrices have no unit]. Quaternions are
                divided by their norm, which is not 0; matrices are taken as they are.
        """
        from scipy.spatial.transform import Rotation

        if self.form == "matrix":
            turns = np.reshape(values, (-1, 3, 3))
        elif self.form == "quaternion":
            turns = Rotation.from_quat(np.roll(values, -1, axis=1)).as_matrix()
        elif self.form == "rotation vector":
            turns = Rotation.from_rotvec(values).as_matrix()
        else:
            turns = Rotation.from_euler(self.axes, values).as_matrix()
        return np.asarray(turns.transpose(0, 2, 1) if self.inverse else turns)

    def values(self, turns: Array) -> Array:
        """What it writes for rotation matrices, shape (n, 3, 3): its columns, shape (n, 3, 4 or 9), angles [rad]."""
        from scipy.spatial.transform import Rotation

        turns = turns.transpose(0, 2, 1) if self.inverse else turns
        if self.form == "matrix":
            return np.reshape(turns, (-1, 9))
        rotation = Rotation.from_matrix(turns)
        if self.form == "quaternion":
            return np.asarray(np.roll(rotation.as_quat(), 1, axis=1))
        if self.form == "rotation vector":
            return np.asarray(rotation.as_rotvec())
        with warnings.catch_warnings(action="ignore", category=UserWarning):  # where two axes coincide, one angle is 0
            return np.asarray(rotation.as_euler(self.axes))


_USERS = {
    "xyz extrinsic": "roll, pitch, yaw; FANUC W P R, Yaskawa Rx Ry Rz, Mitsubishi A B C, ROS",
    "xyz intrinsic": "U V W of positioning hexapods, Stäubli Rx Ry Rz",
    "zyx intrinsic": "KUKA A B C, ABB EulerZYX, Nachi",
    "zyz intrinsic": "Kawasaki O A T, Comau, Doosan",
}


def _of_angles(axes: str, moved: bool) -> Convention:
    """The convention of three angles about axes, which turn with them or stand."""
    name = f"{axes} {'intrinsic' if moved else 'extrinsic'}"
    turns = [f"R{axis}({angle[0]})" for axis, angle in zip(axes, ANGLES, strict=True)]
    kind = "the axes that turn along" if moved else "the fixed axes"
    order = f"a about {axes[0]}, then b about {axes[1]}, then c about {axes[2]}"
    words = f"angles about {kind}: {order}; R = {' '.join(turns if moved else turns[::-1])}"
    return Convention(name, "angles", words, _USERS.get(name, ""), axes.upper() if moved else axes)


def _from_base(of: Convention) -> Convention:
    """The convention whose numbers turn vectors of the base into the sensor's frame."""
    words = f"{of.words.replace('R = ', 'R^T = ')}, from base to sensor"
    return replace(of, name=f"{of.name} inverse", words=words, users="", inverse=True)


_ORDERS = tuple(f"{one}{two}{three}" for one, two, three in product("xyz", repeat=3) if one != two != three)
_ANGLES = tuple(_of_angles(axes, moved) for moved in (False, True) for axes in _ORDERS)
_VECTOR = "axis of the rotation times its angle, its three components a, b, c"
_QUATERNION = "unit quaternion, qw its scalar part"
_MATRIX = "rotation matrix, rij in row i and column j"
CONVENTIONS: Mapping[str, Convention] = {
    convention.name: convention
    for convention in (
        *_ANGLES,
        *(_from_base(of) for of in _ANGLES if of.users),
        Convention("rotation vector", "rotation vector", _VECTOR, "Universal Robots rx ry rz"),
        Convention("rotation vector inverse", "rotation vector", f"{_VECTOR}, from base to sensor", "", "", True),
        Convention("quaternion", "quaternion", _QUATERNION, "ABB q1 to q4 (q1 is qw), ROS x y z w"),
        Convention("quaternion inverse", "quaternion", f"{_QUATERNION}, from base to sensor", "", "", True),
        Convention("matrix", "matrix", f"{_MATRIX}, from sensor to base", "Franka O_T_EE (column by column)"),
        Convention("matrix inverse", "matrix", f"{_MATRIX}, from base to sensor", "", "", True),
    )
}  # fmt: skip
"""Every convention by its name: 12 orders of angles about fixed and 12 about moved axes, the inverse of the four that
makers use, and those without angles."""
ROLL_PITCH_YAW = CONVENTIONS["xyz extrinsic"]
"""What a recording has that states no other, and our own poses have: R = Rz(c) Ry(b) Rx(a)."""
OF_ANGLES = tuple(c for c in CONVENTIONS.values() if c.columns == ANGLES)
"""Conventions whose numbers are three angles or a rotation vector: the same columns may mean any of them."""


def ways_to_write(text: str) -> str:
    """What to write in place of a name that is none of the conventions', a maker's perhaps."""
    word = text.casefold().strip()
    users = ((c.name, user) for c in CONVENTIONS.values() for user in re.split("[,;] ", c.users))
    hints = [f"{user}: {name!r}" for name, user in users if len(word) > 2 and word in user.casefold()]
    names = "an order of three axes with how they turn, such as 'xyz intrinsic' (moved) or 'zyx extrinsic' (fixed)"
    others = ", ".join(f"'{c.name}'" for c in CONVENTIONS.values() if c.form != "angles")
    return "; ".join([*hints, f"give {names}, or {others}"])
