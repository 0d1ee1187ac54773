"""Frames of wrenches, as messages of ROS name them, beside the frame that the case names."""

from pathlib import Path

from cases.base.errors import Code, RecordingError
from cases.recording_format import FileFormat
from identification.recording.formats.table import shown

FRAME = "frame_id"  # how columns end that hold frames
STILL = ("base", "base_link", "base_footprint", "world", "map", "odom")


def stands(frame: str) -> bool:
    """Whether a frame has the name of one that no sensor moves with, such as `base_link` or `ur10_base`."""
    name = frame.rpartition("/")[2]
    return any(name == still or name.endswith(f"_{still}") for still in STILL)


def is_stated(frame: str, stated: str) -> bool:
    """Whether messages are in the frame that a case states; those that name none may be."""
    return not frame.strip("/") or frame.strip("/") == stated.strip("/")


def require_frame(place: Path | str, frame: str, form: FileFormat) -> None:
    """Raises RecordingError where a wrench is in another frame than `ros.frame` of a case, or in one that stands."""
    if problem := problem_of(frame, form.ros.get("frame")):
        words, remedy = problem
        raise RecordingError(place=place, problem=words, remedy=remedy, code=Code.CONTRADICTION)


def problem_of(frame: str, stated: str | None) -> tuple[str, str] | None:
    """What is wrong with the frame of a wrench, and the remedy; None where nothing is."""
    frame_name = shown(frame)
    if stated is not None:
        if is_stated(frame, stated):
            return None
        problem = (
            f"its wrench is in the frame {frame_name}; that of the sensor is {shown(stated)} (recording.ros.frame)"
        )
        return (
            problem,
            f"record the topic in {shown(stated)}; if {frame_name} has the axes of machine.chain.sensor, state it",
        )
    if not stands(frame):
        return None
    return (
        f"its wrench is in the frame {frame_name}, which does not move with the sensor",
        f'record the raw topic, in the axes of the sensor; if they are, state recording.ros.frame = "{frame_name}"',
    )
