"""A serial chain with its load as a MuJoCo model: an independent plant to compare kinematics and sensor forces with."""

from collections.abc import Sequence

import mujoco
import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from cases.chain import Chain
from cases.machine import Frame
from cases.sensors import RigidBody

Array = NDArray[np.float64]
LIGHT = '<inertial pos="0 0 0" mass="0.01" diaginertia="1e-5 1e-5 1e-5"/>'
FRAME_SENSORS = ("pos", "quat", "linvel", "angvel", "linacc", "angacc")


class Plant:
    """A chain in MuJoCo, with a load behind its sensor.

    Args:
        chain: geometry; links without inertia weigh next to nothing.
        load: body behind the sensor, in {P}; None for a light one.
        gravity: gravitational acceleration in {B}, shape (3,) [m/s^2].
    """

    def __init__(self, chain: Chain, load: RigidBody | None = None, gravity: Sequence[float] = (0, 0, -9.81)) -> None:
        text = f'<body name="load" {_frame(chain.sensor)}><site name="P"/>{_inertial(load)}</body>'
        for joint in reversed(chain.joints):
            kind = "hinge" if joint.turns else "slide"
            own = f'<joint name="{joint.name}" type="{kind}" axis="{_list(joint.axis)}"/>'
            text = f"<body {_frame(joint)}>{own}{_inertial(joint.link)}{text}</body>"
        frames = "".join(f'<frame{name} objtype="site" objname="P"/>' for name in FRAME_SENSORS)
        self.gravity = np.array(gravity, dtype=float)
        self.model = mujoco.MjModel.from_xml_string(
            f'<mujoco><compiler angle="radian"/><option gravity="{_list(gravity)}"/><worldbody>{text}</worldbody>'
            f'<sensor>{frames}<force site="P"/><torque site="P"/></sensor></mujoco>'
        )
        self.data = mujoco.MjData(self.model)

    def read(self, q: ArrayLike, rates: ArrayLike, accelerations: ArrayLike) -> dict[str, Array]:
        """What stands for each sample: position, rotation, twist, twist rate of {P}, wrench on the load, torques.

        Args:
            q: positions of the joints, shape (n, joints) [rad or m].
            rates: their first derivatives in time.
            accelerations: their second derivatives.
        """
        rows = [
            self._row(*row) for row in zip(np.asarray(q), np.asarray(rates), np.asarray(accelerations), strict=True)
        ]
        return {name: np.array([row[name] for row in rows]) for name in rows[0]}

    def _row(self, q: Array, rates: Array, accelerations: Array) -> dict[str, Array]:
        data = self.data
        data.qpos, data.qvel, data.qacc = q, rates, accelerations
        mujoco.mj_inverse(self.model, data)
        sensed = data.sensordata.copy()
        position, quaternion = sensed[:3], sensed[3:7]
        velocity, spin, acceleration, spin_rate, force, torque = sensed[7:].reshape(6, 3)
        return {
            "position": position,
            "rotation": Rotation.from_quat(quaternion, scalar_first=True).as_matrix(),
            "twist": np.r_[velocity, spin],
            # MuJoCo counts gravity as an upward acceleration of everything
            "twist_rate": np.r_[acceleration + self.gravity, spin_rate],
            "wrench": np.r_[force, torque],
            "torques": data.qfrc_inverse.copy(),
        }


def _frame(frame: Frame) -> str:
    quaternion = Rotation.from_euler("xyz", frame.rpy).as_quat(scalar_first=True)
    return f'pos="{_list(frame.origin)}" quat="{_list(quaternion)}"'


def _inertial(body: RigidBody | None) -> str:
    if body is None:
        return LIGHT
    i11, i12, i13, i22, i23, i33 = body.inertia_kg_m2
    full = _list((i11, i22, i33, i12, i13, i23))
    return f'<inertial pos="{_list(body.centre_of_gravity)}" mass="{body.mass_kg!r}" fullinertia="{full}"/>'


def _list(values: Sequence[float] | Array) -> str:
    return " ".join(repr(float(v)) for v in values)
