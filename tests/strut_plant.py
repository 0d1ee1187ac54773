"""A hexapod with sensors in its struts as a closed loop in MuJoCo: an independent plant for the forces in the struts.

A free platform; for each strut two hinges at the base (universal joint), a slide that drives, one that is the sensor
and does not move, and the end of the strut connected to the platform. Of a motion the generalised forces are those of
the open tree, M a + c; what drives, sensors and connections do of them follows from one linear system.
"""

from typing import Any, NamedTuple

import casadi as ca
import mujoco
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from cases.sensors import RigidBody
from identification.machines.rotations import rotation, twist, twist_rate

Array = NDArray[np.float64]
NOTHING = 1e-9  # [kg, kg m^2] what MuJoCo wants of a body that has no mass


class Struts(NamedTuple):
    """Rod and tube of each strut, slender."""

    rod_mass: float  # [kg]
    rod_first_moment: float  # from the platform joint towards the base joint [kg m]
    rod_inertia: float  # about the platform joint [kg m^2]
    tube_mass: float  # [kg]
    tube_first_moment: float  # from the base joint towards the platform joint [kg m]
    tube_inertia: float  # about the base joint [kg m^2]


class StrutPlant:
    """The hexapod in MuJoCo.

    Args:
        base: joints of the base in {B}, shape (6, 3) [m].
        platform: joints of the platform in {P}, shape (6, 3) [m].
        body: the platform, in {P}.
        at_drive: whether sensors sit between drive and rod; else between rod and platform.
        gravity: in {B}, shape (3,) [m/s^2].
    """

    def __init__(
        self, base: Array, platform: Array, body: RigidBody, struts: Struts, at_drive: bool, gravity: Array
    ) -> None:
        self.base, self.platform = base, platform
        self.frames = [
            Rotation.align_vectors([p - b], [[0.0, 0.0, 1.0]])[0] for b, p in zip(base, platform, strict=True)
        ]
        i = np.array(body.inertia)
        full = _list([i[0, 0], i[1, 1], i[2, 2], i[0, 1], i[0, 2], i[1, 2]])
        text = (
            f'<body name="platform"><freejoint/><inertial pos="{_list(body.centre_of_gravity)}" mass="{body.mass_kg}" '
        )
        text += f'fullinertia="{full}"/></body>'
        for k, (foot, turn) in enumerate(zip(base, self.frames, strict=True)):
            tube = _slender(struts.tube_mass, struts.tube_first_moment, struts.tube_inertia, 1.0)
            rod = _slender(struts.rod_mass, struts.rod_first_moment, struts.rod_inertia, -1.0)
            none = f'<inertial pos="0 0 0" mass="{NOTHING}" diaginertia="{NOTHING} {NOTHING} {NOTHING}"/>'
            lower, upper = (none, rod) if at_drive else (rod, none)
            slide = '<joint type="slide" axis="0 0 1"/>'
            text += f'<body pos="{_list(foot)}" quat="{_list(turn.as_quat(scalar_first=True))}">'
            text += f'<joint axis="1 0 0"/><joint axis="0 1 0"/>{tube}<body>{slide}{lower}'
            text += f'<body name="end {k}">{slide}{upper}</body></body></body>'
        ends = "".join(
            f'<connect body1="platform" body2="end {k}" anchor="{_list(p)}"/>' for k, p in enumerate(platform)
        )
        self.model = mujoco.MjModel.from_xml_string(
            f'<mujoco><compiler angle="radian"/><option gravity="{_list(gravity)}" jacobian="dense"/>'
            f"<worldbody>{text}</worldbody><equality>{ends}</equality></mujoco>"
        )
        self.model.eq_data[:, 3:6] = 0.0  # the anchor on the strut is its end, in whatever pose the model was made
        self.data = mujoco.MjData(self.model)
        self.coordinates = self._coordinates()

    def _coordinates(self) -> ca.Function:
        """(pose, rates, accelerations) -> two angles and the length of each strut with their derivatives, (18, 3)."""
        pose, rates, accelerations = (ca.SX.sym(n, 6) for n in ("q", "v", "a"))
        turn, angles = rotation(pose[3:]), []
        for foot, joint, frame in zip(self.base, self.platform, self.frames, strict=True):
            strut = ca.DM(frame.as_matrix().T) @ (pose[:3] + turn @ ca.DM(joint) - ca.DM(foot))
            length = ca.norm_2(strut)
            angles += [ca.atan2(-strut[1], strut[2]), ca.asin(strut[0] / length), length]
        now = ca.vertcat(*angles)
        first = ca.jtimes(now, pose, rates)
        second = ca.jtimes(first, pose, rates) + ca.jtimes(now, pose, accelerations)
        moved, rate = twist(pose, rates), twist_rate(pose, rates, accelerations)
        free = ca.horzcat(ca.vertcat(moved[:3], turn.T @ moved[3:]), ca.vertcat(rate[:3], turn.T @ rate[3:]))
        return ca.Function("coordinates", [pose, rates, accelerations], [ca.horzcat(now, first, second), free])

    def forces(self, pose: Array, rates: Array, accelerations: Array) -> tuple[Array, float]:
        """What the sensors read, shape (6,) [N], and by how much the loop is open [m].

        Args:
            pose: of {P} in {B}, with its derivatives in time, shape (6,) [m, rad].
        """
        struts, free = (v.full() for v in self.coordinates(pose, rates, accelerations))
        each = np.zeros((6, 4, 3))
        each[:, :3] = struts.reshape(6, 3, 3)
        q, v, a = each.reshape(24, 3).T
        turn = Rotation.from_euler("xyz", pose[3:]).as_quat(scalar_first=True)
        data, model = self.data, self.model
        data.qpos = np.r_[pose[:3], turn, q]
        data.qvel, data.qacc = np.r_[free[:, 0], v], np.r_[free[:, 1], a]
        mujoco.mj_inverse(model, data)
        jacobian = np.array(data.efc_J).reshape(data.nefc, model.nv)
        drives, sensors = np.zeros((2, model.nv, 6))
        drives[6 + 4 * np.arange(6) + 2, np.arange(6)] = sensors[6 + 4 * np.arange(6) + 3, np.arange(6)] = 1.0
        found = np.linalg.solve(np.hstack([drives, sensors, jacobian.T]), data.qfrc_inverse + data.qfrc_constraint)
        return found[6:12], float(np.abs(data.efc_pos).max())


def _slender(mass: float, first_moment: float, inertia: float, way: float) -> str:
    """A body along z from the origin of its frame; moments of inertia about its axis do not count."""
    centre = first_moment / mass
    across = inertia - mass * centre**2
    return f'<inertial pos="0 0 {way * centre!r}" mass="{mass}" diaginertia="{across!r} {across!r} {NOTHING}"/>'


def _list(values: Any) -> str:
    return " ".join(repr(float(v)) for v in np.ravel(values))
