"""Figures of plans and results, drawn with matplotlib; functions take data and return a Figure.

Their margins are fixed: to find them takes matplotlib longer than to draw all lines.
"""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from cases.schema import Case
from cases.units import DEG, MM
from identification.identifiability import Identifiability
from identification.motion import Motion
from identification.result import Estimate

Array = NDArray[np.float64]

PNG_DPI = 160


def save_figure(figure: Figure, folder: Path, name: str) -> None:
    """Writes a figure for papers: `name.svg` and `name.png`."""
    folder.mkdir(parents=True, exist_ok=True)
    figure.savefig(folder / f"{name}.svg")
    # The usual level of 6 takes as long as all lines, for files a sixth smaller.
    figure.savefig(folder / f"{name}.png", dpi=PNG_DPI, pil_kwargs={"compress_level": 3})


def trajectory_figure(motion: Motion, case: Case) -> Figure:
    """Position, velocity, acceleration and jerk over time, translations left, rotations right, with their limits."""
    home, box = case.need_motion("the plot of a motion")
    figure = Figure(figsize=(11, 9))
    margins = {"left": 0.07, "right": 0.99, "bottom": 0.055, "top": 0.965, "wspace": 0.17, "hspace": 0.1}
    axes = figure.subplots(4, 2, sharex=True, gridspec_kw=margins)
    rows = (
        ("position from home", "mm", "deg", motion.pose - home, box.pose, (1 / MM, 1 / DEG)),
        ("velocity", "mm/s", "deg/s", motion.rates, np.array([-box.rate, box.rate]), (1 / MM, 1 / DEG)),
        ("acceleration", "m/s²", "rad/s²", motion.accelerations, _both(box.acceleration), (1.0, 1.0)),
        ("jerk", "m/s³", "rad/s³", motion.jerks, _both(box.jerk), (1.0, 1.0)),
    )
    for row, (name, length_unit, angle_unit, values, limit, scale) in zip(axes, rows, strict=True):
        for ax, part, unit, factor in zip(row, (~box.turns, box.turns), (length_unit, angle_unit), scale, strict=True):
            for k in np.flatnonzero(part):
                (line,) = ax.plot(motion.t, values[:, k] * factor, label=box.labels[k], linewidth=1.2)
                for bound in limit[:, k] * factor:
                    shared = bool(np.ptp(limit[:, part], axis=1).max() <= 1e-9 * np.abs(limit[:, part]).max())
                    colour = "0.3" if shared else line.get_color()
                    ax.axhline(float(bound), color=colour, dashes=(4, 3), linewidth=0.9)
            ax.set_ylabel(f"{name} [{unit}]")
            ax.grid(alpha=0.25)
    for ax, title in zip(
        axes[0], ("translations", "rotations; dashed: limits, of one axis in its colour"), strict=True
    ):
        ax.set_title(title, loc="left", fontsize="small")
        ax.legend(
            loc="lower right", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.1, ncols=3, handlelength=1.2,
            fontsize="small", frameon=False,
        )  # fmt: skip
    for ax in axes[-1]:
        ax.set_xlabel("time [s]")
    return figure


def _both(limit: Array) -> Array:
    return np.array([-limit, limit])


def identifiability_figure(found: Identifiability) -> Figure:
    """Figure 3 of the paper: correlation of the columns, and R of the scaled regressor, both as magnitudes."""
    figure = Figure(figsize=(11, 5))
    panels = (("|correlation|", np.abs(found.correlation)), ("|R| of the scaled regressor", np.abs(found.r)))
    margins = {"left": 0.06, "right": 1.0, "bottom": 0.13, "top": 0.93, "wspace": 0.14}
    for ax, (title, values) in zip(figure.subplots(1, 2, gridspec_kw=margins), panels, strict=True):
        image = ax.imshow(values, cmap="Blues", vmin=0.0, vmax=1.0)
        ax.set_title(title)
        ax.set_xticks(range(len(found.names)), found.names, rotation=90, fontsize=7)
        ax.set_yticks(range(len(found.names)), found.names, fontsize=7)
    figure.colorbar(image, ax=figure.axes, shrink=0.8, fraction=0.08, pad=0.03)
    return figure


def residual_figure(estimate: Estimate) -> Figure:
    """Residual of each channel over the samples and as a distribution, with the normal density of its rms."""
    figure = Figure(figsize=(10, 4))
    margins = {"left": 0.08, "right": 0.99, "bottom": 0.125, "top": 0.97, "wspace": 0.05}
    over, spread = figure.subplots(1, 2, width_ratios=(3, 1), gridspec_kw=margins)
    for k in range(6):
        over.plot(estimate.residuals[:, k], linewidth=0.6, label=f"channel {k + 1}")
    over.set_xlabel("sample")
    over.set_ylabel("residual f - A u [N or N m]")
    over.legend(ncols=6, fontsize="small")
    # Of these residuals, not of the recorded forces: behind a filter they are smaller.
    own = np.sqrt(np.mean(estimate.residuals**2, axis=0))
    scaled = (estimate.residuals / np.maximum(own, 1e-300)).ravel()
    spread.hist(scaled, bins=60, range=(-5, 5), density=True, color="0.7")
    x = np.linspace(-5, 5, 200)
    spread.plot(x, np.exp(-(x**2) / 2) / np.sqrt(2 * np.pi), color="C3")
    spread.set_xlabel("residual / rms of its channel")
    spread.set_yticks([])
    for ax in (over, spread):
        ax.grid(alpha=0.25)
    return figure
