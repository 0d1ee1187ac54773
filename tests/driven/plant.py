"""An arm in MuJoCo that follows set points by its own drives: encoders and sensor see what it does."""

from collections.abc import Callable
from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from tests.driven.arms import Arm, Load

Array = NDArray[np.float64]
Setpoints = Callable[[float], tuple[Array, Array]]
"""Positions [rad] and speeds [rad/s] of the joints that the controller asks for at a time [s]."""

STEP = 5e-4  # of the simulation [s]
ROTORS = 0.3  # inertia of rotors and gears beside the smallest effort's joint [kg m^2 at 100 N m]


@dataclass(frozen=True)
class Drives:
    """How the drives of an arm follow, and what its joints resist: of all joints, or of each, shape (joints,)."""

    bandwidth: Array | float = 2 * np.pi * 12.0  # [rad/s]
    damping: Array | float = 0.9  # share of critical
    friction: Array | float = 0.015  # share of the joint's effort, at all speeds
    viscous: Array | float = 0.01  # share of the joint's effort at 1 rad/s

    @classmethod
    def drawn(cls, joints: int, seed: int) -> "Drives":
        """Those of another arm of the same make on another day: each joint by itself, up to twice and half."""
        middle, draw = cls(), np.random.default_rng([seed, 9])
        bandwidth, friction, viscous = 2.0 ** draw.uniform(-1.0, 1.0, (3, joints))
        return cls(
            middle.bandwidth * bandwidth**0.5,
            draw.uniform(0.7, 1.1, joints),
            middle.friction * friction,
            middle.viscous * viscous,
        )


@dataclass(frozen=True)
class Course:
    """What happened: times [s], positions of the joints (n, joints) [rad], readings of the sensor (n, 6) [N, N m]."""

    t: Array
    q: Array
    wrench: Array  # of the load on the sensor, without offsets and noise


def drive(arm: Arm, load: Load, setpoints: Setpoints, duration: float, drives: Drives | None = None) -> Course:
    """Drives an arm with a load, from where the set points begin, for some time [s].

    Each joint has a drive that follows position and speed by a law of its own, with the weight of links and load taken
    off, rotors, and friction: it lags behind the set points, differently in each joint.
    """
    text = arm.urdf(load.urdf).replace(
        "<link", '<mujoco><compiler fusestatic="false" balanceinertia="false"/></mujoco><link', 1
    )
    spec = mujoco.MjSpec.from_string(text)
    spec.body("load").add_site(name="ft")
    for kind in (mujoco.mjtSensor.mjSENS_FORCE, mujoco.mjtSensor.mjSENS_TORQUE):
        spec.add_sensor(type=kind, objtype=mujoco.mjtObj.mjOBJ_SITE, objname="ft")
    drives = drives or Drives()
    friction, viscous = (np.broadcast_to(v, len(arm.joints)) for v in (drives.friction, drives.viscous))
    for name, joint, sticks, resists in zip(arm.names, arm.joints, friction, viscous, strict=True):
        own = spec.joint(name)
        own.armature, own.frictionloss = ROTORS * joint.effort / 100.0, sticks * joint.effort
        own.damping[0] = resists * joint.effort
    spec.option.timestep, spec.option.integrator = STEP, mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    model = spec.compile()
    data = mujoco.MjData(model)
    data.qpos[:] = setpoints(0.0)[0]
    inertias = np.zeros((model.nv, model.nv))
    mujoco.mj_forward(model, data)
    mujoco.mj_fullM(model, data, inertias)
    stiffness = drives.bandwidth**2 * np.diag(inertias)
    rate = 2.0 * drives.damping * drives.bandwidth * np.diag(inertias)
    count = round(duration / STEP)
    positions, readings = np.empty((count, model.nv)), np.empty((count, 6))
    for k in range(count):
        at, speed = setpoints(k * STEP)
        data.qfrc_applied = data.qfrc_bias + stiffness * (at - data.qpos) + rate * (speed - data.qvel)
        positions[k] = data.qpos
        mujoco.mj_step(model, data)
        readings[k] = -data.sensordata
    return Course(np.arange(count) * STEP, positions, readings)
