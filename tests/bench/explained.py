"""Draws the figures of docs/explanation from plans that are made for them.

Usage: python tests/bench/explained.py [docs/explanation]
"""

import subprocess
import sys
import tempfile
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

sys.path.insert(0, str(Path(__file__).parents[2]))  # started as a script: tests is not an installed package

from cases.loading import load_case
from planner.plan_folder import load_plan

DOCS = Path(__file__).parents[2] / "docs" / "explanation"
HEXCITE = Path(sys.executable).parent / "hexcite"
PLANS = {
    "by hand": ("--family", "manual"),
    "Fourier series": ("--family", "fourier", "--starts", "1"),
    "spline": ("--family", "spline", "--starts", "1"),
    "moves, limited jerk": ("--family", "ptp", "--starts", "1"),
    "moves, for LinuxCNC": ("--family", "ptp", "--starts", "1", "--for", "linuxcnc"),
}
HARD = 0.7  # of a limit of acceleration
STEP = 1e-3  # [s]


def accelerations(picture: Path) -> None:
    """How many of the six coordinates accelerate hard at once, and for how much of the time, one bar a motion."""
    shares, labels = [], []
    with tempfile.TemporaryDirectory() as folder:
        for k, (label, words) in enumerate(PLANS.items()):
            place = Path(folder) / str(k)
            subprocess.run([str(HEXCITE), "plan", "hexapod", *words, "-o", str(place)], check=True, capture_output=True)
            plan = load_plan(place)
            shares.append(_together(plan.motion.at(np.arange(0.0, plan.duration, STEP)).accelerations))
            labels.append(f"{label}: D-efficiency {plan.of_motion[1].d_efficiency:.2f}")
    mpl.rcParams.update(
        {"font.size": 9, "svg.hashsalt": "hexcite", "axes.spines.top": False, "axes.spines.right": False}
    )
    figure = Figure(figsize=(8.0, 2.9), layout="constrained")
    axes = figure.subplots()
    colours = mpl.colormaps["viridis"](np.linspace(0.05, 0.95, 7))
    left = np.zeros(len(PLANS))
    for count, share in enumerate(np.transpose(shares)):
        axes.barh(labels, 100 * share, left=left, color=colours[count], label=str(count))
        left += 100 * share
    axes.invert_yaxis()
    axes.set_xlabel("share of the time [%]")
    axes.set_xlim(0, 100)
    title = f"coordinates that accelerate with {100 * HARD:.0f} % of their limit or more at once"
    figure.legend(ncols=7, title=title, loc="outside upper center", frameon=False)
    figure.savefig(picture, metadata={"Date": None})
    print(f"picture written: {picture}")


def _together(accelerations: NDArray[np.float64]) -> list[float]:
    """Shares of the time in which none, one, .. six coordinates accelerate hard."""
    limits = load_case("hexapod").need_motion("the figure")[1].acceleration
    hard = (np.abs(accelerations) >= HARD * limits).sum(axis=1)
    return [float(np.mean(hard == count)) for count in range(7)]


if __name__ == "__main__":
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else DOCS
    accelerations(folder / "accelerations.svg")
