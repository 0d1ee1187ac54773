"""Messages of ROS 2 as `ros2 topic echo --csv` prints them: a row each, its fields in their order, without names.

`sensor_msgs/JointState` is seconds, nanoseconds, frame, then the names of all joints, their positions, velocities and
efforts, each of which may be left out; `geometry_msgs/WrenchStamped` is seconds, nanoseconds, frame, force, torque.
"""

from collections.abc import Sequence

from identification.recording.formats.words import is_number

SECONDS, NANOSECONDS, FRAME = "header.stamp.sec", "header.stamp.nanosec", "header.frame_id"
_HEADER = [SECONDS, NANOSECONDS, FRAME]
_WRENCH = [f"wrench.{kind}.{axis}" for kind in ("force", "torque") for axis in "xyz"]
_PARTS = ("position", "velocity", "effort")
_A_SECOND = 1_000_000_000  # [ns]


def echoed_names(rows: Sequence[Sequence[str]]) -> list[str] | None:
    """Names of the fields of rows that are such messages; None where they are not.

    Joints keep their order from row to row: of a driver that changes it a row says nothing of the next.
    """
    if not rows or len({len(row) for row in rows}) != 1 or not all(_is_stamp(row[:2]) for row in rows):
        return None
    frame, *rest = rows[0][2:]
    if is_number(frame) or any(row[2] != frame for row in rows):
        return None
    if len(rest) == len(_WRENCH) and all(is_number(field) for row in rows for field in row[3:]):
        return [*_HEADER, *_WRENCH]
    joints = [field for field in rest if not is_number(field)]
    values = len(rest) - len(joints)
    same = all(list(row[3 : 3 + len(joints)]) == joints for row in rows)
    if not joints or not same or values % len(joints) or not 1 <= values // len(joints) <= len(_PARTS):
        return None
    parts = _PARTS[: values // len(joints)]
    return [
        *_HEADER,
        *(f"name of {joint}" for joint in joints),
        *(f"{joint}/{part}" for part in parts for joint in joints),
    ]


def _is_stamp(fields: Sequence[str]) -> bool:
    """Whether two fields are seconds and nanoseconds of a stamp."""
    return all(field.strip().isdecimal() for field in fields) and int(fields[1]) < _A_SECOND
