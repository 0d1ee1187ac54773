"""The distance of a tool from a table in a proof is that of the tool's own way, whatever is looked at closely."""

from typing import Any

import numpy as np
import pytest

from cases.schema import Case
from identification.limits.limit import LimitKind
from identification.limits.proof import of_mechanics, prove_at, shares_at
from identification.motion.motion import Joined, Standstill
from postprocessors.program import dialect
from postprocessors.writing import proven_program
from tests.postprocessors.joint_walks import ROBOT, walk

MM = 1e-3
TOP = 0.25  # [m] of the table
TOOL = [np.array([0.0, 0.0, 0.0]), np.array([0.0, 0.0, 0.2])], 0.05  # axis in the sensor's frame, and radius [m]


def beside_a_table() -> Case:
    """The built-in robot with a tool, above a table that it does not reach."""
    data = ROBOT.model_dump(mode="json", exclude_unset=True)
    chain = data["machine"]["chain"]
    for joint in chain["joints"]:
        joint.pop("bodies", None)
    chain.pop("base", None)
    ends, radius = TOOL
    chain["tool"] = [
        {"name": "gripper", "from_mm": [0, 0, 0], "to_mm": (ends[1] / MM).tolist(), "radius_mm": radius / MM}
    ]
    box = {"x_mm": [-2000.0, 2000.0], "y_mm": [-2000.0, 2000.0], "z_mm": [-500.0, 1e3 * TOP]}
    chain["keep_out"] = [{"name": "table", **box}]
    return Case.model_validate(data).found_at("ur10_wrist")


def placed(frame: dict) -> np.ndarray:
    """A constant transformation, from origin and angles as the case states them."""
    roll, pitch, yaw = np.radians(frame.get("rpy_deg") or [0.0, 0.0, 0.0])
    cr, sr, cp, sp, cy, sy = np.cos(roll), np.sin(roll), np.cos(pitch), np.sin(pitch), np.cos(yaw), np.sin(yaw)
    turn = np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]]) @ [[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]]
    matrix = np.eye(4)
    matrix[:3, :3] = turn @ [[1, 0, 0], [0, cr, -sr], [0, sr, cr]]
    matrix[:3, 3] = MM * np.array(frame.get("origin_mm") or [0.0, 0.0, 0.0])
    return matrix


def least_height(case: Case, joints: np.ndarray) -> float:
    """Least height of the tool above the table over positions of the joints, which turn about z, shape (n, 6) [m]."""
    chain = case.model_dump(mode="json", exclude_unset=True)["machine"]["chain"]
    lowest = np.inf
    for q in joints:
        frame = np.eye(4)
        for joint, angle in zip(chain["joints"], q, strict=True):
            assert joint["axis"] == [0.0, 0.0, 1.0]
            turn = np.eye(4)
            turn[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
            frame = frame @ placed(joint) @ turn
        frame = frame @ placed(chain["sensor"])
        lowest = min(lowest, *(float((frame @ [*end, 1.0])[2]) for end in TOOL[0]))
    return lowest - TOOL[1] - TOP


@pytest.mark.first(1)
@pytest.mark.parametrize("pause", [0.0, 4.0])
def test_a_program_keeps_the_distance_that_an_independent_kinematics_finds(pause: float) -> None:
    """A long standstill, and blocks far from every limit, lie between the places that are looked at closely."""
    case = beside_a_table()
    parts: Any = walk(ROBOT, 3, share=0.5).parts
    stand = (Standstill(parts[0].end, pause),) if pause else ()
    motion = Joined((parts[0], *stand, *parts[1:]))
    program = proven_program(motion, case, dialect("ros2"), "p.yaml", ("beside a table",))
    (check,) = (c for c in program.proof.limits.checks if c.kind is LimitKind.DISTANCE_FROM_BOX)
    moves = [s.points for s in program.reading.stretches if hasattr(s, "points")]
    ways = np.vstack([m.at(np.linspace(0.0, m.duration, 400)).coordinates for m in moves])
    least = least_height(case, ways)
    assert least > 0.02
    assert least / MM - 1.0 <= check.worst <= least / MM + 0.01  # the way until half way to the next instant counts


def test_what_is_between_instants_counts_with_both_of_them_and_no_further() -> None:
    """Instants that are far apart anywhere else do not make the distance at others smaller."""
    case = beside_a_table()
    motion = walk(ROBOT, 2, share=0.5)
    dense = np.linspace(0.0, 0.4, 401)
    alone = shares_at(motion, case, dense, False, of_mechanics)
    both = shares_at(motion, case, np.append(dense, [motion.duration]), False, of_mechanics)
    np.testing.assert_array_equal(both[:-2], alone[:-1])
    many = np.linspace(0.0, motion.duration, 5001)
    parts = [shares_at(motion, case, many[k : k + 1001], False, of_mechanics) for k in range(0, 4001, 1000)]
    whole = shares_at(motion, case, many, False, of_mechanics)
    assert len(whole) == len(many)
    np.testing.assert_allclose(whole[1:1000], parts[0][1:-1], rtol=1e-12)
    assert prove_at(motion, case, many, False, of_mechanics).checks


def test_an_arm_of_which_only_the_joints_are_limited_has_a_proven_program() -> None:
    """No bodies, no torques, no range of the sensor: its mechanics have no limit; the first state of a robot's case."""
    data = ROBOT.model_dump(mode="json", exclude_unset=True)
    chain = data["machine"]["chain"]
    for key in ("base", "tool", "keep_out"):
        del chain[key]
    for joint in chain["joints"]:
        for key in ("bodies", "torque_Nm", "link"):
            joint.pop(key, None)
    del data["sensors"]["range_N"], data["sensors"]["range_Nm"]
    case, motion = Case.model_validate(data).found_at("ur10_wrist"), walk(ROBOT, 1, share=0.5)
    assert shares_at(motion, case, np.linspace(0.0, 1.0, 11), False, of_mechanics).shape == (11, 0)
    program = proven_program(motion, case, dialect("ros2"), "p.yaml", ("an arm alone",))
    assert program.proof.limits.kept
    kinds = {check.kind for check in program.proof.limits.checks}
    assert {LimitKind.JOINT_ANGLE, LimitKind.ANGULAR_VELOCITY} <= kinds
    assert not kinds & {LimitKind.SENSOR_FORCE, LimitKind.DISTANCE_FROM_BOX, LimitKind.JOINT_TORQUE}
