"""Runs a program on LinuxCNC: configuration, headless session, log, proof of the log."""

import json
import logging
import re
import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from cases.base.errors import Code, HexciteError, option
from cases.base.phrases import phrase
from cases.schema import Case
from postprocessors.controllers.executed_run import ControllerLog
from postprocessors.controllers.linuxcnc import configuration, timing
from postprocessors.controllers.linuxcnc.configuration import AxisLayout
from postprocessors.controllers.linuxcnc.isolation import OUTPUT_FILE, SYSTEM_PATH, preload_works, run_session
from postprocessors.dialects.linuxcnc.promises import SERVO_PERIOD, acceleration_headroom, path_jerk
from postprocessors.reading import Still, Timed

if TYPE_CHECKING:
    from postprocessors.program import Program

HERE = Path(__file__).parent
PROGRAM_FILE = "program.ngc"
CLOCK_FILE = "warp.so"
REPORT_FILE = "status.json"
SAMPLES_FILE = "samples.f64"

LIMITS_JERK = 2, 10  # the first version with PLANNER_TYPE
START_LIMIT = 120.0  # wall-clock time for LinuxCNC to start, read a program and end [s]; on a very busy computer 20 s
LINE_LIMIT = 20.0  # mean time of a line in the default time limit [s of controller time]: longer than any move

_log = logging.getLogger(__name__)


@cache
def linuxcnc_missing() -> str | None:
    """Reason why LinuxCNC cannot be run on this computer, with the remedy; None if it can."""
    if not sys.platform.startswith("linux"):
        return f"LinuxCNC runs on Linux only, this is {sys.platform}; run with {option('on')} virtual"
    cnc, compiler = "linuxcnc-uspace", "gcc libc6-dev"
    for program, packages in {"linuxcnc": cnc, "halcmd": cnc, "python3": "python3", "gcc": compiler}.items():
        if shutil.which(program, path=SYSTEM_PATH) is None:
            return f"{program}, which LinuxCNC here needs, is missing; install the packages {packages}"
    imports = ["/usr/bin/python3", "-c", "import hal, linuxcnc"]
    result = subprocess.run(imports, env={"PATH": SYSTEM_PATH}, capture_output=True, text=True)
    if result.returncode != 0:
        reason = (result.stderr.strip().splitlines() or ["no reason given"])[-1]
        return f"/usr/bin/python3 cannot import LinuxCNC's modules ({reason}); reinstall the package {cnc}"
    return None


@cache
def linuxcnc_version() -> tuple[int, int]:
    """Version of the LinuxCNC that is installed here, its first two numbers."""
    question = ["/usr/bin/python3", "-c", "import linuxcnc; print(linuxcnc.version)"]
    answer = subprocess.run(question, env={"PATH": SYSTEM_PATH}, capture_output=True, text=True).stdout
    match = re.match(r"\s*(\d+)\.(\d+)", answer)
    return (0, 0) if match is None else (int(match[1]), int(match[2]))


def require_planner(case: Case, version: tuple[int, int]) -> None:
    """Raises HexciteError where a version of LinuxCNC has no such planner as the case states."""
    if path_jerk(case) is not None and version < LIMITS_JERK:
        raise HexciteError(
            place=f"case {case.name}, controller.linuxcnc.planner",
            problem=phrase(
                "linuxcnc_old",
                "LinuxCNC {version} here has no planner with limited jerk (s_curve, since {since})",
                version=".".join(map(str, version)),
                since=".".join(map(str, LIMITS_JERK)),
            ),
            remedy=phrase("on_virtual", "run with {on} virtual", on=option("on")),
            code=Code.NOT_INSTALLED,
        )


def run_linuxcnc(
    program: "Program",
    case: Case,
    *,
    speedup: float = 20.0,
    time_limit: float | None = None,
    override: float = 1.0,
) -> ControllerLog:
    """Runs a program on a LinuxCNC that is configured for the case, without hardware.

    Dwells are as long in the log as programmed. Commanded struts are the cubic B-spline (1, 4, 1)/6 of the inverse
    kinematics of the commanded pose, two cycles late: LinuxCNC interpolates them.

    Args:
        speedup: controller time per wall-clock time, at most; less for programs with short blocks. A run that loses
            cycles, waits for blocks or shortens dwells is repeated at half of it and at a quarter; then that is an
            error.
        override: feed override that the operator has turned.
        time_limit: limit of wall-clock time for the program [s]; by default by its dwells and lines.

    Raises:
        HexciteError: LinuxCNC is not installed, refuses the program, stops, loses cycles, waits for blocks or does
            not end in time.
    """
    path, reading = program.path, program.reading
    if (missing := linuxcnc_missing()) is not None:
        raise HexciteError(place=path, problem=f"cannot be run: {missing}", code=Code.NOT_INSTALLED)
    require_planner(case, linuxcnc_version())
    lines = timing.with_dwells(path, program.content.decode("ascii").split("\n"), reading)
    timed = any(isinstance(part, Timed) for part in reading.stretches)
    job = Job(path, tuple(lines), case, acceleration_headroom(case, timed), timed)
    standing = sum(part.duration for part in reading.stretches if isinstance(part, Still))
    speedup = min(speedup, timing.fastest(reading)) if preload_works() else 1.0
    for attempt in range(timing.ATTEMPTS):
        speed = speedup / 2**attempt
        usual = START_LIMIT / 2 + (LINE_LIMIT * len(lines) + standing) / speed
        limit = usual if time_limit is None else time_limit
        log, report = one_session(job, speed, limit, override)
        window = report["started"], report["ended"]
        if lost := lost_cycles(report, speed):
            problem = f"{path}: {lost}"
        elif reason := timing.supply_problem(log) or timing.dwell_problem(log, reading, window):
            problem = f"{path}, {reason}"
        else:
            return timing.without_surplus(log, reading, window)
        _log.info("%s", problem)
    raise HexciteError(problem=problem, code=Code.RUN_FAILED)


@dataclass(frozen=True, slots=True)
class Job:
    """A program as LinuxCNC is given it, and the machine that it is configured for."""

    program: Path
    lines: tuple[str, ...]  # of the program, with dwells for what is to be seen while it stands
    case: Case
    headroom: float  # its limits of acceleration over those of the case
    timed: bool  # whether the program states durations


def one_session(
    job: Job, speedup: float, time_limit: float, override: float = 1.0
) -> tuple[ControllerLog, dict[str, Any]]:
    """Runs a program once; returns the log and the report of `read_report`."""
    program, case = job.program, job.case
    with tempfile.TemporaryDirectory(prefix="hexcite-linuxcnc-") as name:
        folder = Path(name)
        configuration.write_configuration(folder, case, job.headroom, job.timed)
        (folder / PROGRAM_FILE).write_bytes("\n".join(job.lines).encode("ascii"))
        (folder / configuration.DISPLAY_FILE).write_bytes((HERE / "driver.py").read_bytes())
        (folder / configuration.DISPLAY_FILE).chmod(0o755)
        _compile_clock(folder)
        arguments = ["-r", configuration.INI_FILE, PROGRAM_FILE, repr(time_limit), repr(override)]
        clock = {"HEXCITE_SPEEDUP": repr(speedup), "LD_PRELOAD": f"{{folder}}/{CLOCK_FILE}"}
        if run_session(folder, arguments, clock, time_limit + START_LIMIT) is None:
            problem = f"LinuxCNC did not end within {time_limit + START_LIMIT:g} s and was killed"
            raise HexciteError(
                place=program,
                problem=problem,
                remedy="run again, and check its installation if that does not help",
                code=Code.RUN_FAILED,
            )
        report = read_report(program, folder)
        layout = AxisLayout.of(case)
        samples = np.fromfile(folder / SAMPLES_FILE).reshape(-1, 1 + len(layout.channels))
    values = samples[:, 3:]
    log = ControllerLog(
        controller=f"LinuxCNC {report['version'].split('+')[0]}",
        period=SERVO_PERIOD,
        drives=values[:, : len(layout.axes)] * layout.joint_units,
        poses=values[:, len(layout.axes) :] * layout.units,
        trigger=samples[:, 2] != 0.0,
        lines=samples[:, 1].astype(np.int64),
    )
    return log, report


def _compile_clock(folder: Path) -> None:
    flags = ["-O2", "-shared", "-fPIC", "-pthread"]
    command = ["gcc", *flags, "-o", CLOCK_FILE, str(HERE / "warp.c"), "-ldl"]
    result = subprocess.run(command, env={"PATH": SYSTEM_PATH}, cwd=folder, capture_output=True, text=True)
    if result.returncode != 0:
        reason = next(
            (line for line in result.stderr.splitlines() if "error" in line), f"exit code {result.returncode}"
        )
        raise HexciteError(
            problem=f"gcc cannot compile LinuxCNC's clock ({reason})",
            remedy="install the packages gcc and libc6-dev",
            code=Code.NOT_INSTALLED,
        )


def read_report(program: Path, folder: Path) -> dict[str, Any]:
    """The report of a program that ran to its end.

    Returns:
        `version` of LinuxCNC; `started` and `ended`: rows between which the program ran; `samples` and `lost`: counts.

    Raises:
        HexciteError: LinuxCNC did not start, or stopped the program; the message says why.
    """
    try:
        report: dict[str, Any] = json.loads((folder / REPORT_FILE).read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        output = (folder / OUTPUT_FILE).read_text(encoding="utf-8", errors="replace").strip().splitlines()
        last_line = " ".join(output[-1].split()) if output else "nothing"
        problem = f"LinuxCNC did not start, or broke down; it said last: {last_line}"
        remedy = "check the installation by running one of its sample configurations"
        raise HexciteError(place=program, problem=problem, remedy=remedy, code=Code.RUN_FAILED) from error
    if report["outcome"] == "done":
        return report
    message = " ".join((report["errors"] or ["it gave no reason"])[0].split()).rstrip(".")
    match = re.search(r"\bline (\d+)", message)
    near = f", near line {report['line']}" if report["line"] else ""  # the last line in motion
    place = f"{program}, line {match[1]}" if match else f"{program}{near}"
    remedy = "correct the program (hexcite check names what is outside a limit), or write it again with hexcite post"
    problem, remedy = {
        "time limit": ("LinuxCNC was not through in time", "check the feeds, or allow more time"),
        "paused": ("LinuxCNC waits for its operator", "remove the pause from the program"),
    }.get(report["outcome"], (f"LinuxCNC stopped: {message}", remedy))
    raise HexciteError(place=place, problem=problem, remedy=remedy, code=Code.RUN_FAILED)


def lost_cycles(report: dict[str, Any], speedup: float) -> str | None:
    """The problem where cycles are missing in a log: the computer was too busy to fetch them."""
    gaps, count = report["lost"], report["samples"]
    if not gaps and count:
        return None
    return (
        f"{gaps} of {count + gaps} cycles were not logged; the computer is too busy, run again with a speed-up below "
        f"{speedup:g}"
    )
