"""What a search has found after how much time: D-efficiency over seconds, one curve a family."""

import json
from collections.abc import Callable
from pathlib import Path

from planner.cli.console import print_table

Command = Callable[..., tuple[float, str]]

SECONDS = (3.0, 6.0, 12.0, 25.0, 45.0)
WANTED = {"fourier": "0.36 in 6 s", "ptp": "0.575 in 12 s, 0.583 in 25 s", "spline": "0.63 in 25 s, 0.645 in 45 s"}


def anytime(folder: Path, command: Command, case: str = "hexapod", picture: Path | None = None) -> None:
    """Prints a table, and draws it.

    Args:
        folder: for the plans.
        command: runs hexcite; gives wall time and output.
        case: machine.
        picture: PNG to write.
    """
    curves: dict[str, list[tuple[float, float]]] = {}
    for family in WANTED:
        curves[family] = []
        for seconds in (*SECONDS, None):
            words = () if seconds is None else ("--seconds", f"{seconds:g}")
            output = folder / f"{family}-{'rule' if seconds is None else f'{seconds:g}'}"
            wall, printed = command("plan", case, "--family", family, *words, "--json", "-o", str(output))
            curves[family].append((wall, json.loads(printed)["d_efficiency"]))
    rows = [
        [family, *(f"{efficiency:.3f} ({wall:.0f} s)" for wall, efficiency in points), WANTED[family]]
        for family, points in curves.items()
    ]
    columns = ("family", *(f"--seconds {s:g}" for s in SECONDS), "default", "wanted, whole command, two idle cores")
    print_table(f"D-efficiency over time of search, {case} (whole command)", columns, rows)
    if picture is not None:
        _draw(curves, picture)


def _draw(curves: dict[str, list[tuple[float, float]]], picture: Path) -> None:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7.0, 4.0), layout="constrained")
    axes = figure.subplots()
    for family, points in curves.items():
        axes.plot(*zip(*sorted(points), strict=True), marker="o", label=family)
    axes.set_xlabel("whole command [s]")
    axes.set_ylabel("D-efficiency")
    axes.set_ylim(bottom=0.0)
    axes.legend()
    figure.savefig(picture)
    print(f"picture written: {picture}")
