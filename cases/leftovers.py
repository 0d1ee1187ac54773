"""What is valid in a case and yet hardly meant: values left over from another machine, and units mistaken."""

from collections.abc import Iterator

import numpy as np

from cases.basis import values
from cases.loading import built_in_cases, load_case
from cases.machine import Joints, Limits
from cases.schema import Case

_OTHER_BODY = 2.0  # ratio of simulated and nominal mass from which they are two bodies
_RADIANS = 1.6  # largest angle in degrees of a table that holds radians: a right angle
_SMALL_BOX = 0.9  # the same for the angles of a motion box
_METRES = 5.0  # largest length in millimetres of a table that holds metres
_TABLES = (
    "machine", "workspace", "limits", "poses", "sensor_frame", "nominal", "simulation", "payloads",
    "controller.sinumerik", "controller.twincat", "controller.setpoints",
)  # fmt: skip


def leftovers(case: Case) -> tuple[str, ...]:
    """Sentences about values that the user should look at, each with its key."""
    if case.name in built_in_cases() and case == load_case(case.name):
        return ()
    return (
        *_of_torques(case),
        *_of_other_machines(case),
        *_of_bodies(case),
        *_of_poses(case),
        *_of_gravity(case),
        *_of_units(case),
    )


def _of_torques(case: Case) -> Iterator[str]:
    """Torques that nothing is compared with."""
    joints = () if case.chain is None else case.chain.joints
    without = [joint.name for joint in joints if joint.link is None]
    if without and any(joint.torque_Nm or joint.force_N for joint in joints):
        yield (
            f"machine.chain.joints: torque_Nm and force_N limit nothing, for the link of {', '.join(without)} is not "
            "stated; add its mass, centre of gravity and inertia"
        )


def _of_other_machines(case: Case) -> Iterator[str]:
    """Tables that equal those of a built-in case, each named once, with the case that has most of them."""
    own = {name: table for name in _TABLES if len(table := values(case, [name])) > 1}  # one value may well be the same
    same = {
        other: [name for name, table in own.items() if table == values(load_case(other), [name])]
        for other in built_in_cases()
        if other != case.name
    }
    previous: set[str] = set()
    for name, tables in sorted(same.items(), key=lambda item: -len(item[1])):
        if names := [table for table in tables if table not in previous]:
            previous |= set(names)
            yield (
                f"{', '.join(names)}: still the values of the built-in case {name}; replace them by your machine's, or "
                "delete tables that it does not need"
            )


def _of_bodies(case: Case) -> Iterator[str]:
    if case.nominal is None or case.simulation is None:
        return
    simulated, nominal = case.simulation.parameters.body.mass_kg, case.nominal.mass_kg
    if not 1.0 / _OTHER_BODY <= simulated / nominal <= _OTHER_BODY:
        yield (
            f"simulation.parameters.body.mass_kg = {simulated:g} is {simulated / nominal:.3g} times nominal.mass_kg = "
            f"{nominal:g}; one of the two is of another machine"
        )


def _of_poses(case: Case) -> Iterator[str]:
    if case.poses is None or case.workspace is None:
        return
    for axis in ("x_mm", "y_mm"):
        first, last, _ = getattr(case.poses, axis)
        low, high = getattr(case.workspace, axis)
        if first < low or last > high:
            yield (
                f"poses.{axis} = {first:g} to {last:g} leaves workspace.{axis} = {low:g} to {high:g}; narrow it, poses "
                "outside are never chosen"
            )


def _of_gravity(case: Case) -> Iterator[str]:
    if case.gravity[2] > 0.0:
        yield (
            f"gravity_m_s2 = {list(case.gravity_m_s2)} points along +z of {{B}}; gravity points down: change its sign, "
            "unless the machine hangs"
        )


def _joints(case: Case) -> dict[str, Joints]:
    """The points of machine and sensor frame by their tables."""
    joints = {}
    if case.hexapod is not None:
        joints = {"machine.base": case.hexapod.base, "machine.platform": case.hexapod.platform}
    if case.sensor_frame.bars is not None:
        lower, upper = case.sensor_frame.bars.lower, case.sensor_frame.bars.upper
        joints |= {"sensor_frame.bars.lower": lower, "sensor_frame.bars.upper": upper}
    return joints


def _of_units(case: Case) -> Iterator[str]:
    """Angles that look like radians and lengths that look like metres."""
    angles: dict[str, tuple[float, float]] = {}
    lengths: dict[str, float] = {}
    if case.workspace is not None:
        for key in ("base_joint_angle_deg", "platform_joint_angle_deg"):
            angles[f"workspace.{key}"] = (getattr(case.workspace, key), _RADIANS)
        lengths["workspace.strut_length_mm"] = max(case.workspace.strut_length_mm)
    if isinstance(case.limits, Limits):
        motion = case.limits.motion
        largest = max(abs(v) for key in ("a_deg", "b_deg", "c_deg") for v in getattr(motion, key))
        angles["limits.motion.a_deg, b_deg and c_deg"] = (largest, _SMALL_BOX)
        angles["limits.motion.angular_velocity_deg_s"] = (max(motion.angular_velocity_deg_s), _RADIANS)
        lengths["limits.motion.strut_length_mm"] = max(motion.strut_length_mm)
    if case.hexapod is not None:
        lengths["machine.home.z_mm"] = abs(case.hexapod.home.z_mm) or np.inf
    for name, joints in _joints(case).items():
        field = "ring.radius_mm" if joints.ring is not None else "points_mm"
        lengths[f"{name}.{field}"] = float(np.abs(joints.points).max()) * 1e3
        if joints.ring is not None:
            angles[f"{name}.ring.half_angle_deg"] = (joints.ring.half_angle_deg, _RADIANS)
    for key, (value, most) in angles.items():
        if value <= most:
            yield f"{key}: {value:g} degrees at most; these look like radians, give degrees"
    for key, value in lengths.items():
        if value <= _METRES:
            yield f"{key}: {value:g} mm at most; this looks like metres, give millimetres"
