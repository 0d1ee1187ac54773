"""Where limits let nothing move: which, and what to change, by the keys of the case."""

from cases.errors import InfeasiblePlan
from cases.schema import Case
from identification.limits import LimitCheck, prove
from identification.machine import machine_of
from identification.motion import Standstill
from planner.families.family import box_middle

_BOX, _WORKSPACE = "limits.motion", "workspace"
_KEYS = {
    "position": f"{_BOX}.x_mm, y_mm, z_mm",
    "angle": f"{_BOX}.a_deg, b_deg, c_deg",
    "workspace position": f"{_WORKSPACE}.x_mm, y_mm",
    "velocity": f"{_BOX}.velocity_mm_s",
    "angular velocity": f"{_BOX}.angular_velocity_deg_s",
    "acceleration": f"{_BOX}.acceleration_m_s2",
    "angular acceleration": f"{_BOX}.angular_acceleration_rad_s2",
    "jerk": f"{_BOX}.jerk_m_s3",
    "angular jerk": f"{_BOX}.angular_jerk_rad_s3",
    "strut length": f"{_BOX}.strut_length_mm and {_WORKSPACE}.strut_length_mm",
    "strut velocity": f"{_BOX}.strut_velocity_m_s",
    "strut acceleration": f"{_BOX}.strut_acceleration_m_s2",
    "base joint angle": f"{_WORKSPACE}.base_joint_angle_deg",
    "platform joint angle": f"{_WORKSPACE}.platform_joint_angle_deg",
}


_JOINTS = f"{_BOX}.joints"
_OF_JOINTS = {
    "position": f"position_mm of {_JOINTS}",
    "angle": f"position_deg of {_JOINTS}",
    "joint position": "position_mm of machine.chain.joints",
    "joint angle": "position_deg of machine.chain.joints",
    "velocity": f"velocity_mm_s of {_JOINTS}",
    "angular velocity": f"velocity_deg_s of {_JOINTS}",
    "acceleration": f"acceleration_m_s2 of {_JOINTS}",
    "angular acceleration": f"acceleration_rad_s2 of {_JOINTS}",
    "jerk": f"jerk_m_s3 of {_JOINTS}",
    "angular jerk": f"jerk_rad_s3 of {_JOINTS}",
}


def remedy(check: LimitCheck, case: Case) -> str:
    """What to change where a limit of a case lets nothing move."""
    kind = check.name.split(" (")[0]
    if kind.startswith("distance from"):
        return f"make that box of {'workspace' if case.chain is None else 'machine.chain'}.keep_out smaller"
    if kind == "distance between links":
        return f"narrow position_deg of {_JOINTS}, correct the bodies in machine.chain"
    if kind in ("joint torque", "joint force"):
        return f"lower the accelerations of {_JOINTS}, correct {kind[6:]}_N{'m' * (kind == 'joint torque')} or nominal"
    if kind in ("sensor force", "sensor moment"):
        return "take weights out of [payloads], correct sensors.range_N or range_Nm"
    if kind == "singularity":
        return f"narrow the poses of {_BOX}"
    return f"widen {(_KEYS if machine_of(case).of_pose else _OF_JOINTS)[kind]}"


def require_rest(case: Case) -> None:
    """Standing still in the middle of the box must be possible: every family can shrink to that.

    Raises:
        InfeasiblePlan: it is not; the message names the limit.
    """
    report = prove(Standstill(box_middle(case)[0], 0.01), case, 100.0)
    if not report.kept:
        worst = report.violations[0]
        raise InfeasiblePlan(f"no feasible motion: {worst.sentence(timed=False)}; {remedy(worst, case)} or move home")
