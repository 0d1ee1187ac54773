"""The page of a case: the machine at home, and how much of its motion box it reaches."""

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from cases.files import provenance
from cases.machine import HexapodMachine
from cases.schema import Case
from cases.units import DEG, MM
from identification.limited_chain import frames_at
from planner.reach import Reach, StaticLimits
from planner.reports.case_figures import COLUMNS, coordinate_rows, share_sentences
from planner.reports.charts import Chart, plain
from planner.reports.figures import COLOURS, GREY
from planner.reports.machine import box_outlines, room, tool_outlines
from planner.reports.page import Item, Note, Page, Plot, Section, Table

Array = NDArray[np.float64]

GRID = 25  # poses along each side of a map
BESIDE = 0.12  # numbers stand that share of the ring's radius outside of it
MOST = 1.5  # share of a limit from which the colour stays the same
CAMERA = {"eye": {"x": 1.5, "y": 1.5, "z": 0.9}, "center": {"x": 0.0, "y": 0.0, "z": -0.15}}
END = "#d62728"  # of the line where the reach ends


def case_page(case: Case, reach: Reach) -> Page:
    """The page of `hexcite case show`: the machine in 3-D, maps of a hexapod's reach, a table of each coordinate's.

    Args:
        case: case with machine and limits.
        reach: its reachable part of the motion box.

    Raises:
        CaseError: the case has no machine or no limits.
    """
    picture = hexapod_picture(case) if case.chain is None else chain_picture(case)
    maps = _maps(case) if case.chain is None else ()
    table = Table(COLUMNS, coordinate_rows(reach), left=len(COLUMNS))
    return Page(
        title=f"Machine: {case.title}",
        lead="What the case file describes, to be compared with the drawing, and what the machine reaches of its "
        "motion box.",
        inputs=(("case", f"{case.name} (hash {case.hash})"), *provenance([])["versions"].items()),
        warnings=(),
        sections=(
            Section("The machine at home", (picture,)),
            Section("What it reaches", (Note(share_sentences(reach)), *maps, table)),
        ),
    )


def hexapod_picture(case: Case) -> Plot:
    """Base, platform, struts, bars of the sensors, tools and boxes at home, in mm; joints and sensors are numbered."""
    machine, workspace, _ = case.need_machine("the picture of the machine")
    home, figure = machine.home.vector, Chart()
    turn = Rotation.from_euler("xyz", home[3:]).as_matrix()
    base = machine.base.points / MM
    platform = (home[:3] + machine.platform.points @ turn.T) / MM
    for ring, name, colour in ((base, "base", GREY), (platform, "platform", COLOURS[0])):
        _draw(figure, [np.vstack([ring, ring[:1]])], name, colour, 6)
        _number(figure, ring + BESIDE * (ring - ring.mean(axis=0)), colour)
    _draw(figure, np.stack([base, platform], axis=1), "struts 1 to 6", GREY, 3)
    if (bars := case.sensor_frame.bars) is not None:
        low, high = ((home[:3] + ring.points @ turn.T) / MM for ring in (bars.lower, bars.upper))
        _draw(figure, np.stack([low, high], axis=1), "sensors 1 to 6", COLOURS[1], 5)
        _number(figure, high, COLOURS[1])
    tools = [home[:3] / MM + line @ turn.T for line in tool_outlines(workspace.tool)]
    _draw(figure, tools, "tools", COLOURS[3], 4)
    extent = np.vstack([base, platform, *tools])
    boxes = box_outlines(workspace.keep_out, *room(extent.min(axis=0), extent.max(axis=0), workspace.keep_out))
    _draw(figure, boxes, "kept out", COLOURS[4], 3)
    return _picture(figure)


def chain_picture(case: Case) -> Plot:
    """A chain at home with its named joints, bodies and tool, and the boxes that they stay out of, in mm."""
    chain, _ = case.need_chain("the picture of the machine")
    figure = Chart()
    frames = [np.eye(4), *(frame[0] for frame in frames_at(chain, chain.home[None]))]
    origins = np.array([frame[:3, 3] for frame in frames]) / MM
    _draw(figure, [origins], "joints", GREY, 5)
    _number(figure, origins[1 : len(chain.joints) + 1], GREY, [joint.name for joint in chain.joints])
    _number(figure, origins[-1:], COLOURS[1], ["sensor"])
    links = [(f, j.bodies) for f, j in zip(frames[1:], chain.joints, strict=False)]
    outlines = [origins]
    for owners, name, colour in (
        ([(frames[0], chain.base)], "base", COLOURS[5]),
        (links, "links", COLOURS[0]),
        ([(frames[-1], chain.tool)], "tool", COLOURS[3]),
    ):
        lines = [line @ frame[:3, :3].T + frame[:3, 3] / MM for frame, own in owners for line in tool_outlines(own)]
        _draw(figure, lines, name, colour, 2)
        outlines += lines
    every = np.vstack(outlines)
    boxes = box_outlines(chain.keep_out, *room(every.min(axis=0), every.max(axis=0), chain.keep_out))
    _draw(figure, boxes, "kept out", COLOURS[4], 3)
    return _picture(figure)


def _draw(figure: Chart, lines: Iterable[Array], name: str, colour: str, width: int) -> None:
    """Lines of shape (k, 3) as one trace; none where there are none."""
    gap = np.full((1, 3), np.nan)
    points = np.vstack([gap, *(part for line in lines for part in (line, gap))])
    if len(points) > 1:
        x, y, z = points.T
        line = {"color": colour, "width": width}
        figure.add("scatter3d", x=x, y=y, z=z, mode="lines", name=name, line=line, hoverinfo="name")


def _number(figure: Chart, points: Array, colour: str, names: Iterable[str] = "123456") -> None:
    """Names at points, shape (k, 3)."""
    x, y, z = points.T
    text = [plain(name) for name in names]
    figure.add(
        "scatter3d", x=x, y=y, z=z, mode="text", text=text, textfont={"color": colour}, showlegend=False,
        hoverinfo="skip",
    )  # fmt: skip


def _picture(figure: Chart) -> Plot:
    axes = {f"{axis}axis": {"title": {"text": f"{axis} [mm]"}} for axis in "xyz"}
    figure.update_layout(scene={"aspectmode": "data", "camera": CAMERA, **axes}, height=620, showlegend=True)
    return Plot("machine-at-home", figure, "The machine at home, in {B}. Drag to turn, wheel to zoom.")


def _maps(case: Case) -> tuple[Item, ...]:
    """Largest share of a limit over x and y, and over roll and pitch, the other coordinates at home."""
    machine, workspace, limits = case.need_machine("the picture of the machine")
    box = limits.motion.pose
    over = [np.linspace(low * MM, high * MM, GRID) for low, high in (workspace.x_mm, workspace.y_mm)]
    tilted = [np.linspace(2 * box[0, k], 2 * box[1, k], GRID) for k in (3, 4)]
    return (
        _map(case, machine, (0, 1), over, ("x", "y")),
        _map(case, machine, (3, 4), tilted, ("roll a", "pitch b")),
    )


def _map(
    case: Case, machine: HexapodMachine, pair: tuple[int, int], sides: list[Array], titles: tuple[str, str]
) -> Plot:
    unit, word = (MM, "mm") if pair == (0, 1) else (DEG, "deg")
    first, second = np.meshgrid(*sides)
    poses = np.tile(machine.home.vector, (first.size, 1))
    poses[:, pair[0]] += first.ravel()
    poses[:, pair[1]] += second.ravel()
    values = np.clip(StaticLimits(case).shares(poses).max(axis=1).reshape(first.shape), 0.0, MOST)
    x, y = (side / unit for side in sides)
    figure = Chart()
    levels = {"start": 0.0, "end": MOST, "size": 0.1}
    figure.add("contour", x=x, y=y, z=values, contours=levels, colorscale="Viridis", line={"width": 0}, name="share")
    ends = {"start": 1.0, "end": 1.0, "size": 1.0, "coloring": "none"}
    figure.add(
        "contour", x=x, y=y, z=values, contours=ends, line={"color": END, "width": 3}, showscale=False,
        name="end of reach", showlegend=True, hoverinfo="skip",
    )  # fmt: skip
    corners = case.need_machine("the picture of the machine")[2].motion.pose[:, list(pair)] / unit
    around = corners[[0, 1, 1, 0, 0], 0], corners[[0, 0, 1, 1, 0], 1]
    line = {"color": "#ffffff", "width": 2}
    figure.add_scatter(x=around[0], y=around[1], mode="lines", line=line, name="motion box", hoverinfo="skip")
    figure.update_xaxes(title=f"{titles[0]} from home [{word}]", constrain="domain")
    figure.update_yaxes(title=f"{titles[1]} from home [{word}]", scaleanchor="x", constrain="domain")
    note = "Largest share of a limit, the other coordinates at home; white: the motion box, red: where the reach ends."
    return Plot(f"reach-{titles[0].split()[0]}", figure.update_layout(height=440, showlegend=False), note, half=True)
