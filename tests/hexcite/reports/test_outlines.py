"""Outlines of boxes and tools: they show what is limited, and nothing beside the picture."""

import numpy as np
import pytest

from cases.machine import KeepOut, Tool
from hexcite.reports.drawing.plots import case_figure
from hexcite.reports.drawing.scene import box_outlines, room, tool_outlines
from identification.limits.hexapod import distance_of_points
from planner.box.reach import standing_ratios
from tests.helpers import HOME
from tests.postprocessors.changed_case import changed

BOX = KeepOut(name="vice", x_mm=(-100.0, 100.0), y_mm=(0.0, 50.0), z_mm=(10.0, 20.0))
FAR = np.full(3, 1e4)


def length(lines: list[np.ndarray]) -> float:
    return float(sum(np.linalg.norm(np.diff(line, axis=0), axis=1).sum() for line in lines))


def test_a_box_has_twelve_edges_on_its_surface():
    lines = box_outlines([BOX], -FAR, FAR)
    assert length(lines) == pytest.approx(4 * (200.0 + 50.0 + 10.0))
    assert np.abs(distance_of_points(np.vstack(lines) * 1e-3, BOX.corners)).max() < 1e-12


def test_a_picture_of_a_machine_beside_a_hall_shows_the_machine():
    hall = KeepOut(name="hall", x_mm=(50.0, 1e6), y_mm=(-1e6, 1e6), z_mm=(-1e6, 1e6))
    low, high = room(np.zeros(3), np.full(3, 100.0), [hall])
    assert low == pytest.approx([0.0, -25.0, -25.0])
    assert high == pytest.approx([125.0, 125.0, 125.0])
    drawn = np.vstack(box_outlines([hall], low, high))
    assert drawn.min(axis=0) == pytest.approx([50.0, -25.0, -25.0])
    assert box_outlines([hall], -FAR, np.zeros(3)) == []


def test_a_tool_is_drawn_as_its_axis():
    (line,) = tool_outlines([Tool(name="probe", from_mm=(0.0, 0.0, 5.0), to_mm=(0.0, 0.0, 9.0))])
    assert line.tolist() == [[0.0, 0.0, 5.0], [0.0, 0.0, 9.0]]


def test_the_picture_of_a_case_shows_both_and_where_the_reach_ends_at_a_box(hexapod_case):
    box = {"name": "vice", "x_mm": [100.0, 300.0], "y_mm": [-50.0, 50.0], "z_mm": [850.0, 950.0]}
    case = changed(hexapod_case, workspace__keep_out=[box], workspace__tool=[{"name": "probe", "to_mm": [0, 0, 99.0]}])
    labels = case_figure(case).axes[0].get_legend_handles_labels()[1]
    assert {"tools", "kept out"} <= set(labels)
    inside = HOME + np.r_[0.15, 0.0, 0.0, 0.0, 0.0, 0.0]
    before, within = standing_ratios(case, np.stack([HOME, inside])).max(axis=1)
    assert before < 1.0 < within
    assert standing_ratios(hexapod_case, inside[None]).max() < 1.0
