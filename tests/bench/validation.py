"""Figures of `hexcite validate`: Table 7 of all six methods at three loads beside the paper's, and two on LinuxCNC."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from postprocessors.controllers.linuxcnc.session import linuxcnc_missing
from tests.bench.scatter import scatter_rows

WEIGHTS = (0, 3, 5)  # mounted: 0, 60 and 100 kg; the command itself takes every number
ON_LINUXCNC = (0, 5)
PRINTED_S0 = {  # Table 7, for 0, 60 and 100 kg
    "Q5M": (1.28, 1.65, 2.30),
    "Q5N": (1.81, 2.33, 3.14),
    "D9M": (5.11, 14.57, 29.75),
    "D9N": (8.59, 25.03, 46.62),
}

Command = Callable[..., tuple[float, str]]


def validation_rows(folder: Path, command: Command) -> list[list[str]]:
    """Runs the validation, prints what it prints, and gives its figures.

    Args:
        folder: that takes the results.
        command: runs hexcite with some words; gives seconds and what was printed.
    """
    seconds, answer = _validated(folder / "validation", command, WEIGHTS)
    rows = [["hexcite validate: 6 methods, 3 loads, virtual controller", f"{seconds:.0f} s", ""]]
    for method, wanted in PRINTED_S0.items():
        found = [row["s0_N"] for row in answer["rows"] if row["method"] == method]
        ratios = " ".join(f"{f / w:.2f}" for f, w in zip(found, wanted, strict=True))
        rows.append([f"  s0 of {method} over Table 7's, 0, 60, 100 kg", ratios, "0.67 to 1.5"])
    rows += _advice(answer)
    rows += scatter_rows(folder / "validation" / "programs")
    if (missing := linuxcnc_missing()) is not None:
        return [*rows, ["hexcite validate --on linuxcnc", missing, ""]]
    seconds, answer = _validated(folder / "linuxcnc", command, ON_LINUXCNC, "--on", "linuxcnc")
    rows.append(["hexcite validate --on linuxcnc: 2 loads", f"{seconds:.0f} s", ""])
    rows += [[f"  {method} not run", why, ""] for method, why in answer["not_run"].items()]
    return rows + _advice(answer)


def _validated(output: Path, command: Command, weights: tuple[int, ...], *more: str) -> tuple[float, dict[str, Any]]:
    words = ("hexapod", "--weights", ",".join(map(str, weights)), *more, "-o", str(output))
    seconds, printed = command("validate", *words)
    print(f"\nhexcite validate {' '.join(words[:3])}\n{printed}")
    answer: dict[str, Any] = json.loads((output / "validation.json").read_text(encoding="utf-8"))
    return seconds, answer


def _advice(answer: dict[str, Any]) -> list[list[str]]:
    return [[f"  {sentence}", "", ""] for sentence in answer["recommendation"]["sentences"]]
