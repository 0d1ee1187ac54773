"""Figures of programs: time of post and check, LinuxCNC against plan and virtual controller, long ones."""

import json
from collections.abc import Callable
from pathlib import Path

from cases.schema import load_case
from postprocessors.controllers.linuxcnc.session import linuxcnc_missing, run_linuxcnc
from postprocessors.program import read_program
from tests.bench.long_programs import long_programs
from tests.postprocessors.changed_case import changed

Command = Callable[..., tuple[float, str]]  # words of a command -> seconds, what it printed
ACCEPT = ("--accept", "acceleration,jerk,strut-acceleration,strut-velocity,sensor-force")


def point_to_point(folder: Path, command: Command) -> list[list[str]]:
    """The best point-to-point plan, on both controllers."""
    _, printed = command("plan", "hexapod", "--family", "ptp", "-o", str(folder / "ptp"), "--json")
    plan = json.loads(printed)
    program = str(folder / "ptp.ngc")
    command("post", str(folder / "ptp"), *ACCEPT, "-o", program, "--json")
    took, rows = {}, []
    for controller in ["virtual"] + ([] if linuxcnc_missing() else ["linuxcnc"]):
        _, printed = command(
            "run", program, "--case", "hexapod", "--on", controller, "-o", str(folder / controller), "--json"
        )
        run = json.loads(printed)
        took[controller] = run["duration_s"]
        rows += [
            [
                f"point-to-point on {controller}: duration / plan",
                f"{run['duration_s'] / plan['duration_s']:.4f}",
                "1.04",
            ],
            ["  D-efficiency of plan's", f"{100 * run['d_efficiency'] / plan['d_efficiency']:.1f} %", "85 %"],
            [
                "  peak acceleration of limit",
                f"{max(v for k, v in run['peaks_of_limit'].items() if 'acceleration' in k):.2f}",
                "",
            ],
        ]
    if "linuxcnc" in took:
        rows.append(["  LinuxCNC / virtual duration", f"{took['linuxcnc'] / took['virtual']:.4f}", "0.95 to 1.05"])
    return rows


def wide_open(name: str, program: Path, command: Command) -> list[list[str]]:
    """A smooth plan on LinuxCNC under `acceleration_headroom` times the case's acceleration limits."""
    case = load_case("hexapod")
    headroom = case.need_controller("a run").linuxcnc.acceleration_headroom
    folder = str(program.with_suffix(""))
    _, printed = command("run", str(program), "--case", "hexapod", "--on", "linuxcnc", "-o", f"{folder}-run", "--json")
    run = json.loads(printed)
    lasted, efficiency = run["duration_s"] / run["planned_s"], run["d_efficiency"] / run["d_efficiency_planned"]
    return [
        [f"{name} plan on LinuxCNC, acceleration {headroom:g} times the limits: time / plan", f"{lasted:.4f}", "1.01"],
        ["  distance from the planned path", f"{run['path_error_mm']:.3f} mm", "0.15 mm"],
        ["  D-efficiency of plan's, behind the evaluation's filter", f"{100 * efficiency:.1f} %", ""],
        [
            "  peak acceleration of the case's limit",
            f"{max(v for k, v in run['peaks_of_limit'].items() if 'acceleration' in k):.2f}",
            "",
        ],
    ]


def spline(folder: Path, command: Command) -> list[list[str]]:
    """A spline plan of 6 s with 10 ms blocks, jerks at their limit."""
    if linuxcnc_missing() is not None:
        return []
    program = folder / "spline.ngc"
    plan = ["plan", "hexapod", "--family", "spline", "--duration", "6", "--starts", "1", "-o", str(folder / "spline")]
    command(*plan, "--json")
    command("post", str(folder / "spline"), *ACCEPT, "-o", str(program), "--json")
    return wide_open("spline", program, command)


def dense(folder: Path, command: Command) -> list[list[str]]:
    """Post and check of a smooth plan of 12 s; LinuxCNC wide open, and its stretch under the case's own limits."""
    program = folder / "fourier.ngc"
    command("plan", "hexapod", "--family", "fourier", "-o", str(folder / "fourier"), "--json")
    post = ("post", str(folder / "fourier"), *ACCEPT, "-o", str(program), "--overwrite", "--json")
    posted = min(command(*post)[0] for _ in range(3))
    checked = min(command("check", str(program), "--case", "hexapod", "--json")[0] for _ in range(3))
    rows = [
        ["post of a 12 s plan, whole command", f"{posted:.1f} s", "2 s"],
        ["check of it, whole command", f"{checked:.1f} s", "2 s"],
    ]
    if linuxcnc_missing() is None:
        rows += wide_open("fourier", program, command)
        case = load_case("hexapod")
        read = read_program(program, case)
        log = run_linuxcnc(read, changed(case, controller__linuxcnc__acceleration_headroom=1.0))
        measured = float(log.trigger.sum()) * log.period / 12.0
        rows.append(["LinuxCNC's stretch under the case's limits", f"{measured:.2f} times", ""])
    return rows


def programs(folder: Path, command: Command) -> list[list[str]]:
    """All of them."""
    return [
        *long_programs(folder),
        *dense(folder, command),
        *spline(folder, command),
        *point_to_point(folder, command),
    ]
