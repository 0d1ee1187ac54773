"""Figures of `hexcite validate`: Table 7 with fewer steps and without its 480 poses, beside the paper's own."""

import json
from collections.abc import Callable
from pathlib import Path

WEIGHTS = (0, 3, 5)  # mounted; the command itself takes every number
METHODS = ("Q5N", "D9M", "D9N", "ptp", "spline")  # Q5M, 17 minutes of standing still, takes two minutes to simulate
PRINTED_S0 = {  # Table 7, for 0, 60 and 100 kg
    "Q5N": (1.81, 2.33, 3.14),
    "D9M": (5.11, 14.57, 29.75),
    "D9N": (8.59, 25.03, 46.62),
}


def validation_rows(folder: Path, command: Callable[..., tuple[float, str]]) -> list[list[str]]:
    """Runs the shortened validation, prints what it prints, and gives its figures.

    Args:
        folder: that takes the result.
        command: runs hexcite with some words; gives seconds and what was printed.
    """
    output = folder / "validation"
    weights = ",".join(map(str, WEIGHTS))
    seconds, printed = command(
        "validate", "hexapod", "--methods", ",".join(METHODS), "--weights", weights, "-o", str(output)
    )
    print(f"\nhexcite validate, shortened: weights {weights} instead of 0 to 5, without Q5M (480 poses)")
    print(printed)
    answer = json.loads((output / "validation.json").read_text(encoding="utf-8"))
    rows = [["hexcite validate, shortened (5 methods, 3 loads)", f"{seconds:.0f} s", ""]]
    for method, wanted in PRINTED_S0.items():
        found = [row["s0_N"] for row in answer["rows"] if row["method"] == method]
        ratios = " ".join(f"{f / w:.2f}" for f, w in zip(found, wanted, strict=True))
        rows.append(
            [f"  s0 of {method} over Table 7's, 0, 60, 100 kg", ratios, "0.67 to 1.5" if method != "D9N" else ""]
        )
    for finding in answer["findings"]:
        rows.append([f"  {finding['claim']}", "yes" if finding["holds"] else "NO", "yes, or a cause"])
    return rows
