"""The lines of a machine at home, with the names of its joints: what a drawing of it consists of.

Joints whose home is not stated stand at 0, where they can.
"""

from collections.abc import Iterable

import numpy as np

from cases.base.units import MM
from cases.chain import Chain
from cases.machine import KeepOut, turned
from cases.schema import Case
from hexcite.reports.drawing.scene import AXIS, drawn_pose, frames_at_sensor, hull_outlines, tool_outlines
from identification.limits.chain import chain_frames
from identification.motion.motion import Array, StandingPoses

Lines = dict[str, tuple[str, Iterable[Array]]]
"""Entry of the legend -> colour, and lines of points, shapes (n, 3) [mm]."""
Labels = list[tuple[Array, str]]
"""Places, shape (3,) or (2,) [mm], and what is written there."""
AXIS_COLOURS = ("tab:red", "tab:green", "tab:blue")
SAME_PLACE = 0.01  # of the machine's size, within which labels are written as one


def outline(case: Case) -> tuple[Lines, Labels, tuple[KeepOut, ...]]:
    """Lines and labels of the machine at home in {B}, and the boxes that it keeps out of; raises CaseError."""
    return _hexapod(case) if case.chain is None else _chain(case)


def where(case: Case) -> str:
    """Where the machine of the picture stands, for its title."""
    odd = [] if case.chain is None else [joint for joint in case.chain.joints if np.isnan(joint.home)]
    if not odd:
        return "at home"
    apart = [f"{joint.name} at {joint.drawn_at / joint.unit:.3g}" for joint in odd if joint.drawn_at]
    return f"joints without a home at 0{''.join(f', {words}' for words in apart)}"


def together(labels: Labels, near: float) -> Labels:
    """The labels, those of one place as one."""
    merged: Labels = []
    for place, text in labels:
        same = next((k for k, (other, _) in enumerate(merged) if np.linalg.norm(other - place) <= near), None)
        if same is None:
            merged.append((place, text))
        else:
            merged[same] = merged[same][0], f"{merged[same][1]}, {text}"
    return merged


def _hexapod(case: Case) -> tuple[Lines, Labels, tuple[KeepOut, ...]]:
    machine, workspace, _ = case.need_machine("the picture of the machine")
    origin, turn = machine.home.vector[:3] / MM, turned(machine.home.vector[3:])

    def placed(points: Array) -> Array:
        return np.asarray(origin + points @ turn.T)

    base, platform = machine.base.points / MM, placed(machine.platform.points / MM)
    lines: Lines = {
        "base": ("0.3", [np.vstack([base, base[:1]])]),
        "platform": ("tab:blue", [np.vstack([platform, platform[:1]])]),
        "struts 1 to 6": ("tab:gray", np.stack([base, platform], axis=1)),
        "tools": (
            "tab:purple",
            [placed(line) for line in (*tool_outlines(workspace.tool), *hull_outlines(workspace.tool))],
        ),
    }
    ends = [base, platform]
    if (bars := case.sensor_frame.bars) is not None:
        sensors = [placed(ring.points / MM) for ring in (bars.lower, bars.upper)]
        lines["sensors 1 to 6"] = "tab:red", np.stack(sensors, axis=1)
        ends.append(sensors[1])
    labels = [(place, f"{k}") for joints in ends for k, place in enumerate(joints, start=1)]
    return lines, labels, workspace.keep_out


def _chain(case: Case) -> tuple[Lines, Labels, tuple[KeepOut, ...]]:
    return chain_outline(case.need_joints("the picture of the machine"))


def chain_outline(chain: Chain) -> tuple[Lines, Labels, tuple[KeepOut, ...]]:
    """Lines and labels of a chain at home in {B}, and the boxes that it keeps out of; a case may lack all else."""
    at_home = StandingPoses(drawn_pose(chain)[None]).at([0.0])
    frames = [np.eye(4), *(place[0] for place, _, _ in chain_frames(at_home, chain))]
    origins = np.array([frame[:3, 3] for frame in frames]) / MM
    lines: Lines = {"joints and sensor": ("tab:gray", [origins])}
    for name, colour, owners in (
        ("base", "0.3", [(frames[0], chain.base)]),
        ("tool", "tab:purple", [(frames[-1], chain.tool)]),
        ("links", "tab:cyan", zip(frames[1:], (joint.bodies for joint in chain.joints), strict=False)),
    ):
        outlines = [
            (frame, line) for frame, bodies in owners for line in (*tool_outlines(bodies), *hull_outlines(bodies))
        ]
        lines[name] = colour, [line @ frame[:3, :3].T + frame[:3, 3] / MM for frame, line in outlines]
    labels = list(zip(origins[1:], chain.names, strict=False))
    size = AXIS * float(np.ptp(origins, axis=0).max())
    for name, place in frames_at_sensor(chain):
        frame = frames[-1] @ place
        origin, ends = frame[:3, 3] / MM, frame[:3, 3] / MM + size * frame[:3, :3].T
        labels.append((origin, name))
        for k, (axis, colour) in enumerate(zip("xyz", AXIS_COLOURS, strict=True)):
            entry = f"{axis} of sensor, flange, tool"
            lines[entry] = colour, [*lines.get(entry, ("", ()))[1], np.stack([origin, ends[k]])]
    return lines, labels, chain.keep_out
