"""The machine along a motion, or in one pose after the other, as lines in frames that move: a scene in 3-D.

A page turns the lines by its own script, a printed picture by `Part.placed`. Lengths are in mm, as on the axes.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from cases.base.units import MM
from cases.machine import KeepOut, Tool
from cases.schema import Case
from hexcite.reports.chart import COLOURS
from identification.limits.chain import chain_frames
from identification.motion.motion import Array, Motion, StandingPoses, Trajectory, rotation_motion, sample

BESIDE = 0.25  # share of the machine's size: boxes are shown up to this distance
_BOTTOM = ((0, 0), (1, 0), (1, 1), (0, 1), (0, 0))
FRAMES_A_SECOND = 50.0
MOST_FRAMES = 3000  # times the frames that move: what a page holds
SECONDS_A_POSE = 0.5  # time of each pose when a pose set is played
BASE = 0  # number of the frame that stands still


@dataclass(frozen=True, slots=True)
class Part:
    """Lines of one name; each point keeps its place in a frame of its own, so that struts join two."""

    name: str
    lines: tuple[tuple[Array, tuple[int, ...]], ...]  # points, shape (k, 3) [mm], and the number of each one's frame
    width: float
    colour: str
    in_legend: bool = True

    def placed(self, scene: "Scene", k: int) -> list[Array]:
        """The lines in {B} at the k-th instant, shapes (points, 3) [mm]."""
        return [
            np.array(
                [scene.frames[k, f, :, :3] @ point + scene.frames[k, f, :, 3] for point, f in zip(*line, strict=True)]
            )
            for line in self.lines
        ]

    def to_json(self) -> dict[str, Any]:
        """What the page's script draws it from."""
        lines = [{"points": np.round(points, 3).tolist(), "frames": list(frames)} for points, frames in self.lines]
        return {
            "name": self.name, "lines": lines, "width": self.width, "colour": self.colour, "legend": self.in_legend,
        }  # fmt: skip


@dataclass(frozen=True, slots=True)
class Scene:
    """A machine at some instants."""

    steps: bool  # whether these are poses that are taken one after the other
    t: Array  # shape (n,) [s]
    frames: Array  # rows of (R p) of each frame in {B}, the first of the base, shape (n, f, 3, 4) [1, mm]
    parts: tuple[Part, ...]
    ends: Array  # lower and upper end of each axis, shape (3, 2) [mm]

    @property
    def path(self) -> Array:
        """Where the last frame's origin is, shape (n, 3) [mm]."""
        return np.asarray(self.frames[:, -1, :, 3])

    def to_json(self) -> dict[str, Any]:
        """What the page's script draws it from."""
        return {
            "steps": self.steps,
            "t": self.t.astype(np.float32),
            "frames": self.frames[:, 1:].astype(np.float32).ravel(),  # that of the base stands still
            "moving": self.frames.shape[1] - 1,
            "parts": [part.to_json() for part in self.parts],
            "ends": self.ends.round(1).tolist(),
        }


def moving_machine(case: Case, trajectory: Trajectory) -> Scene:
    """The machine of a case along a trajectory."""
    most = MOST_FRAMES / (1 if case.chain is None else len(case.chain.joints))
    return _scene(case, sample(trajectory, min(FRAMES_A_SECOND, most / max(trajectory.duration, 1e-9))), steps=False)


def posing_machine(case: Case, poses: Array) -> Scene:
    """The machine of a case in one pose after the other, shape (n, k) [m or rad]."""
    at = StandingPoses(poses).at(np.arange(float(len(poses))))
    return _scene(case, replace(at, t=SECONDS_A_POSE * at.t), steps=True)


def _scene(case: Case, motion: Motion, steps: bool) -> Scene:
    frames, parts = _hexapod(case, motion) if case.chain is None else _chain(case, motion)
    moving = Scene(steps, motion.t, frames, parts, np.zeros((3, 2)))
    shown = np.unique(np.linspace(0, len(motion.t) - 1, min(len(motion.t), 60)).astype(int))
    points = np.vstack([moving.path, *(line for k in shown for part in parts for line in part.placed(moving, k))])
    triads = _triads(moving, TRIAD * float(np.ptp(points, axis=0).max())) if steps else ()
    points = np.vstack([points, *(line for part in triads for line in part.placed(moving, 0))])
    keep_out = case.chain.keep_out if case.chain is not None else case.need_machine("the picture")[1].keep_out
    low, high = room(points.min(axis=0), points.max(axis=0), keep_out)
    boxes = box_outlines(keep_out, low, high)
    walls = (Part("kept out", tuple(_still(boxes)), 3.0, "#888888"),) if boxes else ()
    return Scene(steps, motion.t, frames, (*parts, *triads, *walls), np.column_stack([low, high]))


TRIAD = 0.07  # length of an axis at a pose, as a share of the width of the picture
AXES = "xyz"


def _triads(scene: Scene, size: float) -> tuple[Part, ...]:
    """The axes of the last frame at every pose, as in Figure 4: where the platform is, and how it is turned."""
    turns, origins = scene.frames[:, -1, :, :3], scene.path
    return tuple(
        Part(
            f"{axis} of {{P}} at the poses",
            tuple(_still(np.stack([origins, origins + size * turns[:, :, k]], axis=1))),
            3.0,
            COLOURS[k],
        )
        for k, axis in enumerate(AXES)
    )


def _still(lines: Iterable[Array], frame: int = BASE) -> Iterable[tuple[Array, tuple[int, ...]]]:
    return ((line, (frame,) * len(line)) for line in lines)


def _closed(points: Array) -> Array:
    return np.vstack([points, points[:1]])


def _rows(places: Iterable[Array]) -> Array:
    """Rows of frames, shape (n, f, 3, 4) [1, mm], from homogeneous matrices [1, m], that of the base before them."""
    moving = np.stack([np.asarray(place)[:, :3] for place in places], axis=1)
    frames = np.concatenate([np.broadcast_to(np.eye(4)[:3], (len(moving), 1, 3, 4)), moving], axis=1)
    return np.asarray(frames / np.array([1.0, 1.0, 1.0, MM]))


def _hexapod(case: Case, motion: Motion) -> tuple[Array, tuple[Part, ...]]:
    machine, workspace, _ = case.need_machine("the picture of the machine")
    place = np.tile(np.eye(4), (len(motion.t), 1, 1))
    place[:, :3, :3], place[:, :3, 3] = rotation_motion(motion)[0], motion.pose[:, :3]
    base, platform = machine.base.points / MM, machine.platform.points / MM
    struts = [(np.stack(ends), (BASE, 1)) for ends in zip(base, platform, strict=True)]
    parts = [
        Part("base", tuple(_still([_closed(base)])), 6.0, COLOURS[3]),
        Part("struts", tuple(struts), 7.0, COLOURS[0]),
        Part("platform", tuple(_still([_closed(platform)], 1)), 8.0, COLOURS[1]),
    ]
    if (bars := case.sensor_frame.bars) is not None:
        lower, upper = bars.lower.points / MM, bars.upper.points / MM
        sensors = _still([*np.stack([lower, upper], axis=1), _closed(upper)], 1)
        parts.append(Part("sensors", tuple(sensors), 5.0, COLOURS[4]))
    if workspace.tool:
        parts.append(Part("tools", tuple(_still(tool_outlines(workspace.tool), 1)), 4.0, COLOURS[5]))
    parts.append(Part("origin of {P}", tuple(_still([np.zeros((1, 3))], 1)), 4.0, COLOURS[2], in_legend=False))
    return _rows([place]), tuple(parts)


def _chain(case: Case, motion: Motion) -> tuple[Array, tuple[Part, ...]]:
    chain, _ = case.need_chain("the picture of the machine")
    places = [place for place, _, _ in chain_frames(motion, chain)]
    last = len(places)  # number of the sensor's frame
    origins = np.zeros((last + 1, 3)), tuple(range(last + 1))
    parts = [Part("joints and sensor", (origins,), 6.0, COLOURS[0])]
    owners = [(BASE, chain.base), *((k, joint.bodies) for k, joint in enumerate(chain.joints, 1))]
    links = [line for frame, bodies in owners for line in _still(tool_outlines(bodies), frame)]
    if links:
        parts.append(Part("links", tuple(links), 9.0, COLOURS[1]))
    if chain.tool:
        parts.append(Part("tools", tuple(_still(tool_outlines(chain.tool), last)), 7.0, COLOURS[5]))
    size = 0.08 * float(np.ptp(np.concatenate([place[:, :3, 3] for place in places]), axis=0).max()) / MM
    for k, (name, place) in enumerate(frames_at_sensor(case)):
        origin, turn = place[:3, 3] / MM, place[:3, :3]
        axes = [(np.stack([origin, origin + size * axis]), (last, last)) for axis in turn.T]
        parts.append(Part(f"axes of the {name}", tuple(axes), 3.0, COLOURS[(4 + k) % len(COLOURS)]))
    parts.append(Part("origin of {P}", tuple(_still([np.zeros((1, 3))], last)), 4.0, COLOURS[2], in_legend=False))
    return _rows(places), tuple(parts)


def frames_at_sensor(case: Case) -> tuple[tuple[str, Array], ...]:
    """Frames behind the last joint of a chain by their names, in {P}: axes and origin, shapes (4, 4) [-, m]."""
    frames: list[tuple[str, Array]] = [("sensor", np.eye(4))]
    if case.in_flange is not None:
        flange: Array = np.asarray(np.linalg.inv(case.in_flange))
        frames.append(("flange", flange))
        if case.tcp is not None:
            frames.append(("tool (TCP)", flange @ case.tcp.place))
    return tuple(frames)


def room(low: Array, high: Array, boxes: Iterable[KeepOut]) -> tuple[Array, Array]:
    """Corners, shape (3,) [mm], of a picture that shows boxes too, as far as they stand beside a machine."""
    beside, corners = BESIDE * (high - low), [box.corners / MM for box in boxes]
    first = np.min([low, *(np.clip(least, low - beside, low) for least, _ in corners)], axis=0)
    last = np.max([high, *(np.clip(most, high, high + beside) for _, most in corners)], axis=0)
    return first, last


def box_outlines(boxes: Iterable[KeepOut], low: Array, high: Array) -> list[Array]:
    """Edges of boxes in {B}, as far as they lie between two corners: lines of shape (k, 3) [mm]."""
    lines = []
    for box in boxes:
        ends = np.clip(box.corners / MM, low, high)
        if np.any(ends[0] >= ends[1]):
            continue  # beside the picture
        floor, ceiling = (np.array([[ends[i, 0], ends[j, 1], ends[k, 2]] for i, j in _BOTTOM]) for k in (0, 1))
        lines += [floor, ceiling, *np.stack([floor[:4], ceiling[:4]], axis=1)]
    return lines


def tool_outlines(tools: Iterable[Tool]) -> list[Array]:
    """Axes of tools in {P}: lines of shape (2, 3) [mm]."""
    return [tool.axis / MM for tool in tools]
