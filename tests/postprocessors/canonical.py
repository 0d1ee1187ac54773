"""LinuxCNC's own interpreter: the machine commands that `rs274` makes of a program, and what they use of the limits."""

import os
import re
import shutil
import subprocess
import tempfile
from pathlib import Path

import numpy as np

from cases.schema import Case
from tests.postprocessors.naive import share_of_moves

Canonical = list[tuple[str, list[float]]]
_CALL = re.compile(r"\d+ N\S+ +(?P<name>[A-Z_0-9]+)\((?P<arguments>.*)\)$")
_CHECKED = re.compile(r"\[abs\[#<_([a-cx-z])>([+-]\d+(?:\.\d+)?)\] gt")
_NUMBER = re.compile(r"[+-]?\d+\.?\d*")
_AXES = {"SELECT_PLANE_XY": [0, 1, 2], "SELECT_PLANE_XZ": [2, 0, 1], "SELECT_PLANE_YZ": [1, 2, 0]}
LENGTH = 5e-5  # [mm, deg] to which moves are printed


def missing_interpreter() -> str | None:
    """Why nothing can be interpreted here; None where it can."""
    return None if shutil.which("rs274") else "rs274 of LinuxCNC is missing"


def canonical(content: bytes, folder: Path) -> Canonical | str:
    """The machine commands of a program, or what the interpreter says against it."""
    # places that the program checks: the interpreter alone stands at zero
    asks = {axis: -float(place) for axis, place in _CHECKED.findall(content.decode("latin-1"))}
    start = "G0 " + " ".join(f"{axis}{place:.6f}" for axis, place in asks.items()) + "\nG80\n" if asks else ""
    (folder / "program.ngc").write_bytes(start.encode() + content)
    run = subprocess.run(
        ["rs274", "-g", "program.ngc"], cwd=folder, stdin=subprocess.DEVNULL, capture_output=True, text=True,
        errors="replace", timeout=300, env=os.environ | {"HOME": str(folder)},  # its table of tools is a file there
    )  # fmt: skip
    if run.returncode != 0:
        return run.stderr.replace("executing\n", "").strip() or f"exit code {run.returncode}"
    calls = [match for line in run.stdout.splitlines() if (match := _CALL.search(line.strip()))]
    if asks:
        calls = calls[[m["name"] for m in calls].index("STRAIGHT_TRAVERSE") + 1 :]
    return [(m["name"] + _plane(m["arguments"]), [float(n) for n in _NUMBER.findall(m["arguments"])]) for m in calls]


def _plane(arguments: str) -> str:
    """The plane that is selected, as a part of the command's name."""
    return arguments.removeprefix("CANON_PLANE") if arguments.startswith("CANON_PLANE") else ""


def interpreted_share(content: bytes, case: Case) -> float | str:
    """The largest share of a limit that poses and feeds of a program use as LinuxCNC understands it.

    What it says against the program where it refuses that, for what it refuses must not be called proven.
    """
    with tempfile.TemporaryDirectory() as name:
        commands = canonical(content, Path(name))
    if isinstance(commands, str):
        return 0.0 if commands.startswith(("Not at home", "The coordinate system G54")) else commands  # nothing moves
    pose, feed, on, found, axes = np.full(6, np.nan), 0.0, False, [], _AXES["SELECT_PLANE_XY"]
    for command, numbers in commands:
        if command == "SET_FEED_RATE":
            feed = numbers[0]
        elif command in _AXES:
            axes = _AXES[command]
        elif command.endswith("_OUTPUT_BIT"):
            on = command.startswith("SET_")
        elif command in ("STRAIGHT_FEED", "STRAIGHT_TRAVERSE", "ARC_FEED"):
            end = np.array(numbers)
            if command == "ARC_FEED":  # ends in the plane and across it, with centre and turns between them
                end = np.r_[np.zeros(3), numbers[6:9]]
                end[axes] = *numbers[:2], numbers[5]
            if np.isnan(pose).any() and not end.any():  # G0 without axes: to where it stands, 0 to the interpreter
                continue
            if not np.isnan(pose).any():
                # Of a rapid the controller's own limits keep the speed; of short moves four decimals tell too little.
                way = np.linalg.norm((end - pose)[:3]) or np.linalg.norm((end - pose)[3:])
                speed = feed if command == "STRAIGHT_FEED" and way > 1000 * LENGTH else 0.0
                found.append((pose, end, speed, on))
            pose = end
    return share_of_moves(found, case)
