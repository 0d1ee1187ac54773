"""Pages that show what is described: a machine at home with its reach, and the channels of an unknown file."""

from collections.abc import Iterator, Sequence

import numpy as np

from cases.files import provenance
from cases.recording_format import CLOCK, TICKS
from cases.schema import Case
from cases.units import DEG, MM
from identification.formats.looked import Column, Look
from identification.formats.naming import GROUPS
from identification.limited_chain import chain_frames
from identification.motion import Array, StandingPoses
from planner.reach import Reach, StaticLimits
from planner.reports.case_figures import COLUMNS, coordinate_rows, share_sentences
from planner.reports.machine import box_outlines, posing_machine, room, tool_outlines
from planner.reports.page import COLOURS, GREY, Chart, note, page, section, table

GRID = 25  # poses along each side of a map
MOST_SHARE = 1.5  # share of a limit from which the colour stays the same
_TITLES = (
    "struts", "strut velocities", "drive positions", "drive velocities", "pose", "rotation", "accelerometer", "forces",
    "forces and moments",
)  # fmt: skip


def case_page(case: Case, reach: Reach) -> str:
    """The page of `hexcite case show`."""
    words = "Joints and sensors with their numbers. Drag to turn, wheel to zoom."
    home = case.need_motion("the picture of the machine")[0]
    picture = posing_machine(case, home[None], words) if case.chain is None else _chain(case)
    return page(
        f"Machine: {case.title}",
        "The machine at home, in {B}, to be compared with the drawing, and how far each coordinate reaches.",
        (("case", f"{case.name} (hash {case.hash})"), *provenance([])["versions"].items()),
        (),
        section("The machine at home", picture),
        section(
            "Reach of the motion box",
            note(share_sentences(reach)),
            table(COLUMNS, coordinate_rows(reach), left=len(COLUMNS)),
            note("The reach of a coordinate is that with the others at home."),
            *(_maps(case) if case.chain is None else ()),
        ),
    )


def _maps(case: Case) -> Iterator[Chart]:
    """Maps of the reach at home, over x and y and over roll and pitch, with the motion box."""
    machine, workspace, limits = case.need_machine("the picture of the machine")
    words = "Largest share of a limit; the red line is the end of reach, the white one the motion box."
    places, angles = np.array([workspace.x_mm, workspace.y_mm]) * MM, 2 * limits.pose[:, [3, 4]].T
    for name, at, titles, pair, unit, ends in (
        ("reach-level", "At the height of home, level.", ("x from home [mm]", "y from home [mm]"), [0, 1], MM, places),
        ("reach-tilted", "At home, tilted.", ("roll a [deg]", "pitch b [deg]"), [3, 4], DEG, angles),
    ):
        x, y = (np.linspace(low, high, GRID) for low, high in ends)
        poses = np.tile(machine.home.vector, (GRID**2, 1))
        poses[:, pair] += np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
        shares = StaticLimits(case).shares(poses).max(axis=1).reshape(GRID, GRID)
        field = {"x": x / unit, "y": y / unit, "z": np.minimum(shares, MOST_SHARE)}
        figure = Chart(name, f"{at} {words}", *titles, half=True, height=440, showlegend=False)
        levels = {"start": 0.0, "end": MOST_SHARE, "size": 0.1}
        figure.add("contour", **field, contours=levels, colorscale="Viridis", line={"width": 0})
        end = {"start": 1.0, "end": 1.0, "size": 1.0, "coloring": "none"}
        figure.add("contour", **field, contours=end, line={"color": "#ff0000", "width": 2})
        sides_x, sides_y = (limits.pose[:, pair] / unit).T
        box = {"x": sides_x[[0, 1, 1, 0, 0]], "y": sides_y[[0, 0, 1, 1, 0]]}
        figure.add("scatter", **box, mode="lines", line={"color": "#ffffff"}, name="motion box")
        figure.axes({"constrain": "domain"}, {"constrain": "domain", "scaleanchor": "x"})
        yield figure


def _chain(case: Case) -> Chart:
    """A chain at home, with its bodies, its tool and the keep-out boxes beside it."""
    chain, _ = case.need_chain("the picture of the machine")
    at_home = StandingPoses(chain.home[None]).at([0.0])
    frames = [np.eye(4), *(place[0] for place, _, _ in chain_frames(at_home, chain))]
    origins = np.array([frame[:3, 3] for frame in frames]) / MM
    owners = {
        "base": [(frames[0], chain.base)],
        "links": list(zip(frames[1:], (joint.bodies for joint in chain.joints), strict=False)),
        "tool": [(frames[-1], chain.tool)],
    }
    shapes = {
        name: [line @ frame[:3, :3].T + frame[:3, 3] / MM for frame, bodies in pairs for line in tool_outlines(bodies)]
        for name, pairs in owners.items()
    }
    drawn = np.vstack([origins, *(line for lines in shapes.values() for line in lines)])
    shapes["kept out"] = box_outlines(chain.keep_out, *room(drawn.min(axis=0), drawn.max(axis=0), chain.keep_out))
    titles = {f"{axis}axis": {"title": {"text": f"{axis} [mm]"}} for axis in "xyz"}
    caption = "Joints with their names, bodies, and boxes that are kept out of. Drag to turn, wheel to zoom."
    figure = Chart("chain", caption, height=560, showlegend=True, scene={"aspectmode": "data", **titles})
    names = ["", *(joint.name for joint in chain.joints), "sensor"][: len(origins)]
    x, y, z = origins.T
    thick = {"color": GREY, "width": 6}
    figure.add(
        "scatter3d", x=x, y=y, z=z, name="joints", mode="lines+markers+text", text=names, line=thick, marker={"size": 4}
    )
    for (name, lines), colour in zip(shapes.items(), (GREY, *COLOURS[:3]), strict=True):
        if lines:
            x, y, z = np.vstack([part for line in lines for part in (line, np.full((1, 3), np.nan))]).T
            figure.add("scatter3d", x=x, y=y, z=z, name=name, mode="lines", line={"color": colour, "width": 3})
    return figure


def look_page(report: Look) -> str:
    """The page of `hexcite look`: every column of numbers over time, or over the rows without a clock."""
    t, label = _time(report)
    charts = []
    for k, (title, columns) in enumerate(_panels(report.columns)):
        units = {column.unit for column in columns if column.unit}
        unit = f"[{units.pop()}]" if len(units) == 1 else ""
        chart = Chart(f"panel-{k}", f"{title[0].upper()}{title[1:]}.", label, unit, height=280, showlegend=True)
        chart.add_lines(t, np.column_stack([column.values for column in columns]), list(map(_legend, columns)), 1)
        charts.append(chart)
    return page(
        f"Look: {report.file.name}",
        f"{report.rows} rows. Each column with the meaning that it is taken to have; ? where its values alone say so.",
        (("recording", str(report.file)), *provenance([])["versions"].items()),
        report.odd,
        section("Channels", *charts),
    )


def _legend(column: Column) -> str:
    name = column.name if column.ours in (None, column.name) else f"{column.name} = {column.ours}"
    return name + (" ?" if column.guessed else "")


def _time(report: Look) -> tuple[Array, str]:
    clock = next((c for c in report.columns if c.ours == CLOCK), None)
    if clock is not None:
        return (clock.values - clock.values[0]) * TICKS[clock.unit], "time from the first row [s]"
    period = report.settings.get("clock", {}).get("period_ms")
    if period is not None:
        return np.arange(report.rows) * period / 1e3, "time from the first row [s]"
    return np.arange(1.0, report.rows + 1.0), "row"


def _panels(columns: Sequence[Column]) -> Iterator[tuple[str, list[Column]]]:
    """Titles and columns of the panels: known groups, then single columns, then columns without a known meaning."""
    numbers = [column for column in columns if len(column.values) and column.ours != CLOCK]
    grouped = {ours for group in GROUPS for ours in group}
    for title, group in zip(_TITLES, GROUPS, strict=True):
        members = [column for column in numbers if column.ours in group]
        if members:
            yield title, members
    for column in numbers:
        if column.ours is not None and column.ours not in grouped:
            yield column.ours.replace("_", " "), [column]
    unknown = [column for column in numbers if column.ours is None]
    if unknown:
        yield "without a meaning for hexcite", unknown
