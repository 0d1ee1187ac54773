"""Families of motions side by side: how near each comes to both information limits, with the manual motion as 1."""

import json
from collections.abc import Callable
from pathlib import Path
from time import perf_counter

import numpy as np

from cases.schema import load_case
from identification.model.model import identification_model
from planner.bounds.bound import compute_bound
from tests.bench.tables import print_table

Command = Callable[..., tuple[float, str]]

COMMON = ("--criterion", "D", "--model", "9", "--json")
SEARCHED = ("--starts", "2", "--seed", "0")
FAMILIES: dict[str, tuple[tuple[str, ...], str, str]] = {  # arguments, wanted d_efficiency (floor / goal), wanted time
    "manual": (("--family", "manual"), "about 0.10", "-"),
    "fourier, order 5, period 2 s": (("--family", "fourier"), "0.20 / 0.23", "5 s"),
    "fourier, order 7, period 3 s": (("--family", "fourier", "--order", "7", "--period", "3"), "0.20 / 0.23", "5 s"),
    "fourier, best order and period": (
        ("--family", "fourier", "--free-order", "--free-period"),
        "0.20 / 0.23",
        "5 s",
    ),
    "ptp, 32 moves": (("--family", "ptp", "--moves", "32"), "0.52 / 0.58", "60 s"),
    "ptp, 40 moves": (("--family", "ptp", "--moves", "40"), "0.52 / 0.58", "60 s"),
    "spline, 90 knots": (("--family", "spline", "--knots", "90"), "0.56 / 0.62", "60 s"),
    "spline, 120 knots": (("--family", "spline", "--knots", "120"), "0.56 / 0.62", "60 s"),
}


def limits_of_information() -> list[list[str]]:
    """The bound of the hexapod, model 9, computed anew: value, gap to the best design found, time."""
    case = load_case("hexapod")
    model = identification_model(case, 9)
    began = perf_counter()
    found = compute_bound(case, model)
    seconds = perf_counter() - began
    share = 100.0 * (1.0 - np.exp((found.design_logdet - found.logdet) / found.parameters))
    return [
        ["information limit, motion box", f"{found.logdet:.3f} ({found.label})", ""],
        ["  the best design found lies below, in efficiency", f"{share:.2f} %", ""],
        ["  time", f"{seconds:.1f} s", ""],
    ]


def families(folder: Path, command: Command) -> None:
    """Prints a table of the families, 12 s, every limit active, at rest at both ends."""
    rows = []
    manual: dict[str, float] | None = None
    for k, (name, (words, wanted, time)) in enumerate(FAMILIES.items()):
        _, printed = command(
            "plan",
            "hexapod",
            *words,
            *COMMON,
            *(() if "manual" in words else SEARCHED),
            "-o",
            str(folder / f"family-{k}"),
        )
        plan = json.loads(printed)
        # standard deviations of one second of each motion: equal time and noise
        std = {name: value * np.sqrt(plan["duration_s"]) for name, value in plan["predicted_std"].items()}
        manual = {"efficiency": plan["d_efficiency"]} | std if manual is None else manual
        worst = max(std, key=lambda name: std[name] / manual[name])
        explored = [s["seconds"] for s in plan["starts"]] or [0.0]
        rows.append(
            [
                name,
                f"{plan['duration_s']:.2f} s",
                f"{plan['d_efficiency']:.3f}",
                f"{plan['d_efficiency'] / manual['efficiency']:.2f}",
                f"{std[worst] / manual[worst]:.2f} ({worst})",
                f"{max(explored):.1f} s",
                wanted,
                time,
            ]
        )
    columns = (
        "family", "duration", "d_efficiency", "manual = 1", "worst std, manual = 1; ptp wanted 0.5",
        "longest start", "wanted", "wanted time",
    )  # fmt: skip
    print_table("Families on the hexapod, model 9, criterion D, two starts each", columns, rows)
