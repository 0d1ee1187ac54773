"""What a session left behind: the driver's report and the log of every cycle."""

import json
import re
from pathlib import Path
from typing import Any, NoReturn

import numpy as np

from cases.errors import ExecutionError
from cases.units import MM
from postprocessors.execute.linuxcnc.configuration import CHANNELS, SERVO_PERIOD, UNITS
from postprocessors.execute.linuxcnc.isolation import OUTPUT_FILE
from postprocessors.execute.log import ControllerLog


class LostCycles(ExecutionError):
    """Cycles are missing in a log: the computer was too busy to fetch them."""


REPORT_FILE = "status.json"
SAMPLES_FILE = "samples.f64"


def read_report(program: Path, folder: Path) -> dict[str, Any]:
    """The report of a program that ran to its end.

    Args:
        program: the program, for messages.
        folder: the session's.

    Returns:
        `version` of LinuxCNC; `started` and `ended`: rows between which the program ran; `samples` and `lost`: counts.

    Raises:
        ExecutionError: LinuxCNC did not start, or stopped the program; the message says why.
    """
    try:
        report: dict[str, Any] = json.loads((folder / REPORT_FILE).read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        output = (folder / OUTPUT_FILE).read_text(encoding="utf-8", errors="replace").strip().splitlines()
        said = " ".join(output[-1].split()) if output else "nothing"
        raise ExecutionError(
            f"{program}: LinuxCNC did not start, or broke down; it said last: {said}; check the installation by "
            "running one of its sample configurations"
        ) from error
    if report["outcome"] != "done":
        _explain(program, report)
    return report


def _explain(program: Path, report: dict[str, Any]) -> NoReturn:
    said = " ".join((report["errors"] or ["it gave no reason"])[0].split()).rstrip(".")
    if match := re.search(r"\bline (\d+)", said):
        place = f"{program}, line {match[1]}"
    else:  # what the driver saw last is exact to its polling
        place = f"{program}, near line {report['line']}" if report["line"] else f"{program}"
    if report["outcome"] == "time limit":
        raise ExecutionError(f"{place}: LinuxCNC was not through in time; check the feeds, or allow more time")
    if report["outcome"] == "paused":
        raise ExecutionError(f"{place}: LinuxCNC waits for its operator; remove the pause from the program")
    if "limit" in said:
        remedy = "keep the program inside the limits of the case (hexcite check names what is outside)"
    else:
        remedy = "correct the program, or write it again with hexcite post --dialect linuxcnc"
    raise ExecutionError(f"{place}: LinuxCNC stopped: {said}; {remedy}")


def read_log(program: Path, folder: Path, report: dict[str, Any], speedup: float) -> ControllerLog:
    """The log of a session, in SI units.

    Args:
        program: the program, for messages.
        folder: the session's.
        report: the driver's.
        speedup: controller time per wall-clock time, for messages.

    Raises:
        LostCycles: cycles are missing.
    """
    lost, count = report["lost"], report["samples"]
    if lost or not count:
        raise LostCycles(
            f"{program}: {lost} of {count + lost} cycles were not logged; the computer is too busy, run again with a "
            f"speed-up below {speedup:g}"
        )
    samples = np.fromfile(folder / SAMPLES_FILE).reshape(count, 1 + len(CHANNELS))
    lines, trigger, values = samples[:, 1], samples[:, 2], samples[:, 3:]
    return ControllerLog(
        controller=f"LinuxCNC {report['version'].split('+')[0]}",
        period=SERVO_PERIOD,
        strut_lengths=values[:, :6] * MM,
        poses=values[:, 6:] * UNITS,
        trigger=trigger != 0.0,
        lines=lines.astype(np.int64),
    )
