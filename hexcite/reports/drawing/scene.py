"""The machine along a motion, or in one pose after the other, as lines in frames that move: a scene in 3-D.

A page turns the lines by its own script, a printed picture by `Part.placed`. Lengths are in mm, as on the axes.
"""

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from cases.base.convex import sharp_edges
from cases.base.units import MM
from cases.chain import Chain
from cases.machine import KeepOut, Tool
from cases.schema import Case
from hexcite.reports.drawing.chart import COLOURS
from identification.limits.chain import chain_frames
from identification.limits.limit import LimitKind
from identification.limits.proof import everything
from identification.motion.motion import Array, Motion, StandingPoses, Trajectory, rotation_motion, sample

BESIDE = 0.25  # share of the machine's size: boxes are shown up to this distance
_BOTTOM = ((0, 0), (1, 0), (1, 1), (0, 1), (0, 0))
FRAMES_A_SECOND = 50.0
MOST_FRAMES = 3000  # times the frames that move: what a page holds
SECONDS_A_POSE = 0.5  # time of each pose when a pose set is played
AXIS = 0.08  # length of an axis, as a share of the machine's size
AXLE = 0.6  # half of a joint's, of that
LEAST_SIDE = 0.5  # of the picture's longest side: what is flat would be seen from too near
_PICTURE = "the picture of the machine"
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


class Label(NamedTuple):
    """A name at a point, which keeps its place in a frame."""

    text: str
    point: Array  # shape (3,) [mm]
    frame: int


@dataclass(frozen=True, slots=True)
class Used:
    """How far limits are used at the instants of a scene."""

    names: tuple[str, ...]
    shares: Array  # largest since the instant before, shape (n, limits)

    def to_json(self) -> dict[str, Any]:
        """What the page's script lights limits from."""
        return {"names": list(self.names), "shares": self.shares.astype(np.float32).ravel()}


@dataclass(frozen=True, slots=True)
class Scene:
    """A machine at some instants."""

    steps: bool  # whether these are poses that are taken one after the other
    t: Array  # shape (n,) [s]
    frames: Array  # rows of (R p) of each frame in {B}, the first of the base, shape (n, f, 3, 4) [1, mm]
    parts: tuple[Part, ...]
    ends: Array  # lower and upper end of each axis, shape (3, 2) [mm]
    labels: tuple[Label, ...] = ()
    used: Used | None = None

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
            "labels": [[label.text, np.round(label.point, 3).tolist(), label.frame] for label in self.labels],
            "used": None if self.used is None else self.used.to_json(),
        }


def moving_machine(case: Case, trajectory: Trajectory) -> Scene:
    """The machine of a case along a trajectory."""
    most = MOST_FRAMES / (1 if case.chain is None else len(case.chain.joints))
    return _scene(case, sample(trajectory, min(FRAMES_A_SECOND, most / max(trajectory.duration, 1e-9))), steps=False)


def posing_machine(case: Case, poses: Array) -> Scene:
    """The machine of a case in one pose after the other, shape (n, k) [m or rad]."""
    at = StandingPoses(poses).at(np.arange(float(len(poses))))
    return _scene(case, replace(at, t=SECONDS_A_POSE * at.t), steps=True)


def standing_machine(case: Case) -> Scene:
    """The machine of a case at home, its joints named as in its drawing; raises CaseError where it has none."""
    if case.chain is not None:
        return standing_chain(case.chain)
    machine, workspace, _ = case.need_machine("the picture of the machine")
    frames, parts = _hexapod(case, StandingPoses(machine.home.vector[None]).at([0.0]))
    rings = ((BASE, machine.base), (1, machine.platform))
    labels = [Label(f"{k}", p / MM, frame) for frame, ring in rings for k, p in enumerate(ring.points, 1)]
    return _shown(Scene(False, np.zeros(1), frames, parts, np.zeros((3, 2)), tuple(labels)), workspace.keep_out)


def standing_chain(chain: Chain) -> Scene:
    """A chain at home, each joint with its name and its axis; joints without a home where they are drawn.

    The case around it may lack all else.
    """
    frames, parts = _chain(chain, StandingPoses(drawn_pose(chain)[None]).at([0.0]))
    last = len(chain.joints)
    size = _size(frames)
    names = [Label(joint.name, np.zeros(3), k) for k, joint in enumerate(chain.joints, 1)]
    axes = [Label(f"{axis} sensor", size * np.eye(3)[k], last + 1) for k, axis in enumerate(AXES)]
    lines = tuple(
        (np.outer([-1.0, 1.0], AXLE * size * np.array(joint.axis) / np.linalg.norm(joint.axis)), (k, k))
        for k, joint in enumerate(chain.joints, 1)
    )
    axles = Part("axes of the joints", lines, 3.0, "#888888")
    scene = Scene(False, np.zeros(1), frames, (*parts, axles), np.zeros((3, 2)), (*names, *axes))
    return _shown(scene, chain.keep_out)


def drawn_pose(chain: Chain) -> Array:
    """Coordinates at home, shape (n,) [rad or m]; of joints without a home where pictures have them."""
    return np.array([joint.drawn_at for joint in chain.joints])


def _scene(case: Case, motion: Motion, steps: bool) -> Scene:
    frames, parts = _hexapod(case, motion) if case.chain is None else _chain(case.need_chain(_PICTURE)[0], motion)
    keep_out = case.chain.keep_out if case.chain is not None else case.need_machine(_PICTURE)[1].keep_out
    return _shown(Scene(steps, motion.t, frames, parts, np.zeros((3, 2))), keep_out)


def shown_alone(scene: Scene) -> Scene:
    """A scene without boxes, with the ends of its axes."""
    return _shown(scene, ())


def _shown(moving: Scene, keep_out: Sequence[KeepOut]) -> Scene:
    """The scene with the ends of its axes, its boxes, and the axes of poses."""
    motion, parts, steps = moving, moving.parts, moving.steps
    frames = np.unique(np.linspace(0, len(motion.t) - 1, min(len(motion.t), 60)).astype(int))
    points = np.vstack([moving.path, *(line for k in frames for part in parts for line in part.placed(moving, k))])
    triads = _triads(moving, TRIAD * float(np.ptp(points, axis=0).max())) if steps else ()
    points = np.vstack([points, *(line for part in triads for line in part.placed(moving, 0))])
    low, high = room(points.min(axis=0), points.max(axis=0), keep_out)
    boxes = box_outlines(keep_out, low, high)
    walls = (Part("kept out", tuple(_still(boxes)), 3.0, "#888888"),) if boxes else ()
    short = np.maximum(0.0, LEAST_SIDE * float((high - low).max()) - (high - low)) / 2.0
    ends = np.column_stack([low - short, high + short])
    return replace(moving, parts=(*parts, *triads, *walls), ends=ends)


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
    place[:, :3, :3], place[:, :3, 3] = rotation_motion(motion)[0], motion.coordinates[:, :3]
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
        outlines = [*tool_outlines(workspace.tool), *hull_outlines(workspace.tool)]
        parts.append(Part("tools", tuple(_still(outlines, 1)), 4.0, COLOURS[5]))
    parts.append(Part("origin of {P}", tuple(_still([np.zeros((1, 3))], 1)), 4.0, COLOURS[2], in_legend=False))
    return _rows([place]), tuple(parts)


def _size(frames: Array) -> float:
    """Length of a drawn axis [mm]."""
    return AXIS * float(np.ptp(frames[..., 3].reshape(-1, 3), axis=0).max())


def _chain(chain: Chain, motion: Motion) -> tuple[Array, tuple[Part, ...]]:
    places = [place for place, _, _ in chain_frames(motion, chain)]
    last = len(places)  # number of the sensor's frame
    origins = np.zeros((last + 1, 3)), tuple(range(last + 1))
    parts = [Part("joints and sensor", (origins,), 6.0, COLOURS[0])]
    owners = [(BASE, chain.base), *((k, joint.bodies) for k, joint in enumerate(chain.joints, 1))]
    links = [line for frame, bodies in owners for line in _still(tool_outlines(bodies), frame)]
    if links:
        parts.append(Part("links", tuple(links), 9.0, COLOURS[1]))
    if tools := _still(tool_outlines(chain.tool), last):
        parts.append(Part("tools", tuple(tools), 7.0, COLOURS[5]))
    hulls = [line for frame, bodies in (*owners, (last, chain.tool)) for line in _still(hull_outlines(bodies), frame)]
    if hulls:
        parts.append(Part("convex bodies", tuple(hulls), 2.0, COLOURS[1]))
    size = _size(_rows(places)[:, 1:])
    for k, (name, place) in enumerate(frames_at_sensor(chain)):
        origin, turn = place[:3, 3] / MM, place[:3, :3]
        axes = [(np.stack([origin, origin + size * axis]), (last, last)) for axis in turn.T]
        parts.append(Part(f"axes of the {name}", tuple(axes), 3.0, COLOURS[(4 + k) % len(COLOURS)]))
    parts.append(Part("origin of {P}", tuple(_still([np.zeros((1, 3))], last)), 4.0, COLOURS[2], in_legend=False))
    return _rows(places), tuple(parts)


def frames_at_sensor(chain: Chain) -> tuple[tuple[str, Array], ...]:
    """Frames behind the last joint of a chain by their names, in {P}: axes and origin, shapes (4, 4) [-, m]."""
    frames: list[tuple[str, Array]] = [("sensor", np.eye(4))]
    if chain.flange is not None:
        link_from_sensor, link_from_flange = chain.sensor.parent_from_frame, chain.flange.parent_from_frame
        sensor_from_flange: Array = np.asarray(np.linalg.solve(link_from_sensor, link_from_flange))
        frames.append(("flange", sensor_from_flange))
        if chain.tcp is not None:
            frames.append(("tool (TCP)", sensor_from_flange @ chain.tcp.parent_from_frame))
    return tuple(frames)


def room(low: Array, high: Array, boxes: Iterable[KeepOut]) -> tuple[Array, Array]:
    """Corners, shape (3,) [mm], of a picture that shows boxes too, as far as they stand beside a machine."""
    margin, corners = BESIDE * (high - low), [box.corners / MM for box in boxes]
    first = np.min([low, *(np.clip(least, low - margin, low) for least, _ in corners)], axis=0)
    last = np.max([high, *(np.clip(most, high, high + margin) for _, most in corners)], axis=0)
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
    """Axes of round tools in {P}: lines of shape (2, 3) [mm]."""
    return [tool.axis / MM for tool in tools if tool.corners_mm is None]


def hull_outlines(tools: Iterable[Tool]) -> list[Array]:
    """Edges of convex tools in {P}, without what rounds them: lines of shape (2, 3) [mm]."""
    return [edge / MM for tool in tools if tool.corners_mm is not None for edge in sharp_edges(tool.points)]


USED_RATE = 1000.0  # [1/s] at which limits are looked at between the instants of a scene


def with_limits(scene: Scene, case: Case, trajectory: Trajectory, without: Collection[LimitKind] = ()) -> Scene:
    """The scene with how far each limit is used: at its instants, and at USED_RATE between them.

    Args:
        without: families of limits that the motion leaves out, as was asked for.
    """
    fine = np.unique(np.append(scene.t, np.arange(scene.t[0], scene.t[-1], 1.0 / USED_RATE)))
    first = np.searchsorted(fine, scene.t[:-1], side="right")  # of each stretch that ends at an instant
    limits: dict[str, Array] = {}
    for quantity in everything(trajectory.at(fine), case, True):
        if quantity.of.kind.family not in without:
            share = np.minimum(quantity.ratio.max(axis=1), MOST_SHARE)
            stretches = np.maximum.reduceat(share, np.append(0, first))
            name = str(quantity.of)
            limits[name] = np.maximum(limits[name], stretches) if name in limits else stretches
    return replace(scene, used=Used(tuple(limits), np.column_stack([*limits.values()])))


MOST_SHARE = 9.0  # that is shown
