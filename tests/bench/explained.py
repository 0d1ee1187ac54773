"""Draws the figures of docs/explanation from what is planned, executed and identified for them; needs LinuxCNC.

Usage: python tests/bench/explained.py                        # some minutes
       python tests/bench/explained.py --validation FOLDER    # of hexcite validate, whose picture alone is drawn
"""

import argparse
import json
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

sys.path.insert(0, str(Path(__file__).parents[2]))  # started as a script: tests is not an installed package

import hexcite as hx
from cases.schema import Case
from hexcite._run import execute
from identification.limits.limit import KINETIC
from tests.bench.coverage import coloured_coverage, coverage, idealised
from tests.postprocessors.changed_case import changed

DOCS = Path(__file__).parents[2] / "docs" / "explanation"
FAMILIES: dict[str, Any] = {
    "by hand": hx.Manual(),
    "Fourier series": hx.Fourier(),
    "spline": hx.Spline(),
    "moves, limited jerk": hx.PointToPoint(controller="virtual"),
    "moves, for LinuxCNC": hx.PointToPoint(controller="linuxcnc", without="jerk"),
}
HARD = 0.7  # of a limit of acceleration
STEP = 1e-3  # [s]
SEEDS = 40
COLOURS = mpl.colormaps["viridis"](np.linspace(0.05, 0.95, 7))


def drawn(height: float) -> tuple[Figure, Axes]:
    """A figure as wide as a page, and its axes."""
    style()
    figure = Figure(figsize=(8.0, height), layout="constrained")
    return figure, figure.subplots()


def accelerations(plans: dict[str, hx.Plan]) -> Figure:
    """How many of the six coordinates accelerate hard at once, and for how much of the time, one bar a motion."""
    figure, axes = drawn(2.9)
    motions = [plan.motion.at(np.arange(0.0, plan.duration, STEP)).accelerations for plan in plans.values()]
    labels = [f"{name}: D-efficiency {plan.of_motion[1].d_efficiency:.2f}" for name, plan in plans.items()]
    left = np.zeros(len(plans))
    for count, share in enumerate(np.transpose([together(motion) for motion in motions])):
        axes.barh(labels, 100 * share, left=left, color=COLOURS[count], label=str(count))
        left += 100 * share
    axes.invert_yaxis()
    axes.set_xlabel("share of the time [%]")
    axes.set_xlim(0, 100)
    title = f"coordinates that accelerate with {100 * HARD:.0f} % of their limit or more at once"
    figure.legend(ncols=7, title=title, loc="outside upper center", frameon=False)
    return figure


def together(accelerations: NDArray[np.float64]) -> list[float]:
    """Shares of the time in which none, one, .. six coordinates accelerate hard."""
    limits = hx.load_case("hexapod").need_motion("the figure")[1].acceleration
    hard = (np.abs(accelerations) >= HARD * limits).sum(axis=1)
    return [float(np.mean(hard == count)) for count in range(7)]


def executed(plans: dict[str, hx.Plan]) -> Figure:
    """Information that was planned, and that LinuxCNC executes at the case's own limits of acceleration."""
    case = changed(hx.load_case("hexapod"), controller__linuxcnc__acceleration_headroom=1.0)
    names = [name for name in plans if name != "by hand"]
    runs = [on_linuxcnc(plans[name], case).executed for name in names]
    figure, axes = drawn(2.6)
    rows = np.arange(len(names))
    planned = [plans[name].of_motion[1].d_efficiency for name in names]
    reached = [run.d_efficiency or 0.0 for run in runs]
    axes.barh(rows - 0.2, planned, 0.38, color=COLOURS[5], label="as planned")
    axes.barh(rows + 0.2, reached, 0.38, color=COLOURS[1], label="as LinuxCNC executes it")
    for row, run, value in zip(rows, runs, reached, strict=True):
        axes.text(value + 0.01, row + 0.2, f"{run['executed_s']:.1f} s for {run['planned_s']:.1f} s", va="center")
    axes.set_yticks(rows, names)
    axes.invert_yaxis()
    axes.set_xlabel("D-efficiency")
    axes.set_xlim(0, 1)
    figure.legend(ncols=2, loc="outside upper center", frameon=False)
    return figure


def on_linuxcnc(plan: hx.Plan, case: Case) -> hx.Recording:
    """A run of a plan on the real controller, everything accepted that it does not enforce."""
    return execute(hx.write(replace(plan, case=case), "linuxcnc", accept=KINETIC), case, "linuxcnc", 0)[1]


def deviations(plan: hx.Plan) -> Figure:
    """How many 95 % intervals hold the truth, by (28) and by the larger deviation."""
    case = hx.load_case("hexapod")
    executed, _ = execute(hx.write(plan, "linuxcnc", accept=KINETIC), case, "virtual", 0)
    run = executed.execution, executed.trigger
    white, filtered = coverage(idealised(case), *run, SEEDS), coloured_coverage(idealised(case), *run, SEEDS)
    figure, axes = drawn(2.2)
    rows = np.arange(2)
    axes.barh(rows - 0.2, [white.white, filtered.white], 0.38, color=COLOURS[5], label="std (28)")
    axes.barh(rows + 0.2, [white.reported, filtered.robust], 0.38, color=COLOURS[1], label="+-, the larger of both")
    axes.axvline(95.0, color="0.3", linewidth=0.8)
    axes.set_xlim(70, 100)
    axes.set_yticks(rows, ["white noise", "noise behind a 20 Hz filter"])
    axes.invert_yaxis()
    axes.set_xlabel("95 % intervals that hold the truth [%]")
    figure.legend(ncols=2, loc="outside upper center", frameon=False)
    return figure


WAYS = {
    "Q5M": "480\nposes", "Q5N": "30\nposes", "D9M": "by hand", "D9N": "Fourier", "ptp": "moves",
    "ptp-steps": "moves,\nLinuxCNC", "spline": "spline",
}  # fmt: skip
SHOWN = {
    "m": ("mass", "kg", 1.0), "xC": ("centre of gravity, x", "mm", 1e3), "zC": ("centre of gravity, z", "mm", 1e3),
    "IC33": ("inertia about z", "kg m\u00b2", 1.0), "k0": ("deformation k0", "N/m", 1.0),
    "k1": ("deformation k1", "N", 1.0),
}  # fmt: skip


def validated(results: Path) -> Figure:
    """Reported deviations of each way to calibrate a simulated machine, and the true ones as lines."""
    rows = [r for r in json.loads(results.read_text(encoding="utf-8"))["rows"] if r["weights"] == 0]
    style()
    figure = Figure(figsize=(11.0, 5.0), layout="constrained")
    for axes, (name, (words, unit, scale)) in zip(figure.subplots(2, 3).ravel(), SHOWN.items(), strict=True):
        largest = 0.0
        for k, row in enumerate(rows):
            if name not in row["parameters"]:
                axes.text(k, 0.0, "none", ha="center", va="bottom", fontsize=8)
                continue
            entry = row["parameters"][name]
            reported, true = scale * max(entry["std"], entry["std_robust"]), scale * row["std_over_machines"][name]
            axes.bar(k, reported, 0.7, color=COLOURS[min(k, 5)])
            axes.plot([k - 0.45, k + 0.45], [true, true], color="black", linewidth=1.5)
            axes.text(k, max(reported, true), f"{reported:.2g}", ha="center", va="bottom", fontsize=8)
            largest = max(largest, reported, true)
        axes.set_title(f"{words} [{unit}]", loc="left", fontsize=9)
        axes.set_ylim(0.0, 1.15 * largest)
        axes.set_yticks([])
        axes.spines["left"].set_visible(False)
        labels = [f"{WAYS[row['method']]}\n{row['duration_s']:.0f} s" for row in rows]
        axes.set_xticks(range(len(rows)), labels, fontsize=7)
    return figure


def style() -> None:
    """Small letters, no frame, the same file from the same figures."""
    plain = {"axes.spines.top": False, "axes.spines.right": False}
    mpl.rcParams.update({"font.size": 9, "svg.hashsalt": "hexcite", **plain})  # type: ignore[dict-item]


def main() -> None:
    """Plans each motion once, and draws."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--validation", type=Path)
    chosen = parser.parse_args()
    if chosen.validation is not None:
        save("validation", validated(chosen.validation / "validation.json"))
        return
    case = hx.load_case("hexapod")
    plans = {
        name: hx.plan(case, family, **({} if name == "by hand" else {"starts": 1})) for name, family in FAMILIES.items()
    }
    save("accelerations", accelerations(plans))
    save("executed", executed(plans))
    save("deviations", deviations(plans["Fourier series"]))


def save(name: str, figure: Figure) -> None:
    """Writes a picture of the documents."""
    figure.savefig(DOCS / f"{name}.svg", metadata={"Date": None})
    print(f"picture written: {DOCS / f'{name}.svg'}", flush=True)


if __name__ == "__main__":
    main()
