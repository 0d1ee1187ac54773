"""Draws the README's picture from a demo's folder: machine and path, what the sensors saw, what was identified.

Usage: python tests/bench/picture.py hexcite-demo cases/hexapod/overview.png
"""

import json
import sys
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from cases.schema import load_case
from identification.motion.motion import sample
from identification.recording.recording import read
from identification.simulate import truth_rows
from planner.plans.plan import Plan

BLUE, RED, GREY = "#0072b2", "#d55e00", "#627d98"


def draw(demo: Path, picture: Path) -> None:
    """Three panels, left to right the chain: motion, forces, parameters."""
    from identification.identify import estimate_parameters

    case = load_case("hexapod")
    machine, _, _ = case.need_machine("the picture")
    motion = sample(Plan.load(demo / "plan").motion, 200.0)
    recording = read(demo / "recording", case)
    rows = truth_rows(case, estimate_parameters(recording, case, 9))
    mpl.rcParams.update({"font.size": 9, "svg.fonttype": "none", "axes.spines.top": False, "axes.spines.right": False})
    figure = Figure(figsize=(11, 3.6), layout="constrained")
    grid = figure.add_gridspec(1, 3, width_ratios=(1.0, 1.25, 1.25))

    ax = figure.add_subplot(grid[0], projection="3d")
    home = machine.home.vector[:3]
    base, platform = machine.base.points, machine.platform.points + home
    for b, p in zip(base, platform, strict=True):
        ax.plot(*np.array([b, p]).T, color=GREY, linewidth=1)
    for ring in (base, platform):
        ax.plot(*np.vstack([ring, ring[:1]]).T, color="#102a43", linewidth=1.2)
    ax.plot(*motion.coordinates[:, :3].T, color=BLUE, linewidth=0.9)
    ax.set_axis_off()
    ax.view_init(18, 35)
    ax.set_box_aspect((1, 1, 0.8), zoom=1.35)
    ax.set_title("1. the most informative motion\ninside every limit", fontsize=10)

    ax = figure.add_subplot(grid[1])
    assert recording.t is not None
    assert recording.trigger is not None
    on = np.flatnonzero(recording.trigger)[:3000]
    for k in range(6):
        ax.plot(recording.t[on] - recording.t[on[0]], recording.forces[on, k], linewidth=0.6, label=f"f{k + 1}")
    ax.set_xlabel("time [s]")
    ax.set_ylabel("sensor force [N]")
    about = json.loads((demo / "recording" / "recording.json").read_text())
    ax.set_title(f"2. its CNC program, executed\n({about['controller']})", fontsize=10)

    ax = figure.add_subplot(grid[2])
    errors = [r["error"] / r["std"] for r in rows]
    ax.axhspan(-1.96, 1.96, color="#d6e4f0", linewidth=0)
    ax.errorbar(range(len(rows)), errors, yerr=1.0, fmt="o", color=RED, markersize=3.5, linewidth=0.9)
    ax.axhline(0, color="#102a43", linewidth=0.8)
    ax.set_xticks(range(len(rows)), [r["name"] for r in rows], rotation=90, fontsize=7)
    ax.set_ylabel("(estimate - truth) / std")
    ax.set_ylim(-4, 4)
    ax.set_title("3. twenty parameters, with error bars\nthat hold the truth", fontsize=10)
    figure.savefig(picture, dpi=110)


if __name__ == "__main__":
    draw(Path(sys.argv[1]), Path(sys.argv[2]))
