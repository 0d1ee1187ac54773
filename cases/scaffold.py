"""The beginning of a case file for one's own machine: a built-in one with advice above each table."""

import ast
import inspect
import re
import textwrap
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import NamedTuple

from cases.controller import Controller, Setpoints, Sinumerik, TwinCat
from cases.errors import CaseError, FileProblem
from cases.files import write_text
from cases.loading import CASE_FILE, built_in_cases, find_case, load_case
from cases.parts import Part
from cases.poses import Poses
from cases.schema import Case

_NAME = re.compile(r"[a-z][a-z0-9_]*")

_ADVICE = {
    "machine": "From the drawing: centres of the joints, base joints in {B}, platform joints in {P}, in strut order.\n"
    "# points_mm = [[x, y, z], ...] lists them one by one. home is where programs begin and end.",
    "workspace": "What the machine can reach at all: its manual. Joint angles count from the joints' normals.\n"
    '# keep_out = [{ name = "table", x_mm = [a, b], y_mm = [a, b], z_mm = [a, b] }] are boxes in {B} that nothing may\n'
    '# enter; tool = [{ name = "spindle", to_mm = [0.0, 0.0, 250.0], radius_mm = 40.0 }] is what the platform\n'
    "# carries, from its origin or from_mm to there.",
    "limits.motion": "What an excitation may use, each coordinate relative to home: the manual's values or less.",
    "poses": "For measuring at standstills (hexcite poses): candidate poses in tilt-and-torsion angles.",
    "sensor_frame.bars": "From the drawing of the frame: both ends of each bar in {P}, in the order of the channels.",
    "sensor_frame": 'How the sensor reads: sense = "load_on_sensor" or "sensor_on_load".',
    "sensors": "From the sensors' data sheet. Noise may be stated: force_noise_N,\n"
    "# encoder_resolution_um, strut_noise_um, and of vibration acceleration_noise_m_s2 and\n"
    "# angular_acceleration_noise_rad_s2: hexcite identify tells what the residuals look like. So it does of errors\n"
    "# that depend on the pose: pose_error_N and pose_error_length_mm, which plans then count on.",
    "recording": "Names, units and clock of the recorded columns, where they differ from hexcite's (CONVENTIONS.md).",
    "controller": "How the controller is set up. Nothing here is guessed: check each with its machine's parameters.",
    "controller.sinumerik": "SINUMERIK programs; without one delete this table, and the next ones likewise. The\n"
    "# transformation of a hexapod is the machine builder's: ask for these words.",
    "controller.twincat": "TwinCAT CNC (TF5200) and ISG programs.",
    "controller.setpoints": "Setpoints for a controller that takes positions cycle by cycle.",
    "nominal": "A-priori values of the moving body from CAD: mass, centre of gravity in {P}, inertia about it.",
    "simulation": "A simulated machine for rehearsals; delete it and its sub-tables where none is wanted.",
}

_EXPLAINED: Mapping[str, type[Part]] = {
    "poses": Poses,
    "controller": Controller,
    "controller.sinumerik": Sinumerik,
    "controller.twincat": TwinCat,
    "controller.setpoints": Setpoints,
}
"""Tables whose keys are explained one by one, in the words of their classes."""

_WIDTH = 110  # characters of a comment


def new_case(name: str, like: str, folder: Path) -> Path:
    """Writes `folder/case.toml`, the built-in case `like` under another name, to be filled in.

    Args:
        name: of the new case.
        like: name of a built-in case.
        folder: to make; it must not hold a case yet.

    Returns:
        The case file.

    Raises:
        CaseError: a name that a case cannot have, or no such built-in case.
        FileProblem: the folder holds a case, or cannot be written.
    """
    if not _NAME.fullmatch(name):
        raise CaseError(
            name or "''", "", "is no name of a case; use small letters, digits and underscores, a letter first"
        )
    if name in built_in_cases():
        raise CaseError(name, "", "is the name of a built-in case; choose another one")
    file = folder / CASE_FILE
    if file.exists():
        raise FileProblem(file, "exists", "choose another folder with -o, or edit that file")
    load_case(like)
    lines: list[str] = [
        f"# {name}: begun from the case {like}; every number is that case's until you replace it. Keys carry units.",
        "# {B} is the frame of the base, {P} that of the platform. `hexcite case check` tells what cannot be.",
        "",
    ]
    told: Mapping[str, str] = {}
    for line in find_case(like).read_text(encoding="utf-8").splitlines():
        if line.startswith("#"):
            continue  # the built-in case's own words on its sources
        table = re.match(r"\[([a-z_.]+)\]", line)
        if table:
            if table[1] in _ADVICE:
                lines.append(f"# {_ADVICE[table[1]]}")
            line = table[0]  # what follows it is about the built-in case's source
            told = _explanations(_EXPLAINED[table[1]]) if table[1] in _EXPLAINED else {}
        elif key := re.match(r"(\w+) = ", line):
            lines += textwrap.wrap(told.get(key[1], ""), _WIDTH, initial_indent="# ", subsequent_indent="# ")
            line = re.sub(r"\] # .*", "]", line)
        line = re.sub(r'^name = ".*"', f'name = "{name}"', line)
        line = re.sub(r'^title = ".*"', 'title = "what it is, in a line"', line)
        line = re.sub(r'^source = ".*"', 'source = "where these values come from"', line)
        lines.append(line)
    write_text(file, "\n".join(lines).replace("\n\n\n", "\n\n") + "\n")
    return file


def _explanations(part: type[Part]) -> Mapping[str, str]:
    """Field -> the string that stands below it; of several fields with one string it is above the first."""
    (body,) = (node.body for node in ast.parse(inspect.getsource(part)).body if isinstance(node, ast.ClassDef))
    told: dict[str, str] = {}
    waiting: str | None = None
    for node in body:
        if isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name):
            waiting = waiting or node.target.id
        elif isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and waiting is not None:
            told[waiting] = " ".join(str(node.value.value).split())
            waiting = None
    return told


_MACHINE = ("machine", "workspace", "limits.motion")
_PLAN = (*_MACHINE, "nominal")
_PROGRAM = (*_MACHINE, "controller")
_RUN = (*_PROGRAM, "simulation", "recording.filter_cutoff_Hz")
NEEDS: Mapping[str, tuple[str, ...]] = {
    "plan": (*_PLAN, "controller"),
    "plan --family fourier": _PLAN,
    "poses": (*_PLAN, "poses"),
    "bound": _MACHINE,
    "retime": _PROGRAM,
    "post --dialect linuxcnc": (*_PROGRAM, "controller.linuxcnc"),
    "post --dialect sinumerik": (*_PROGRAM, "controller.sinumerik"),
    "post --dialect twincat": (*_PROGRAM, "controller.twincat"),
    "post --dialect setpoints": (*_PROGRAM, "controller.setpoints"),
    "run": _RUN,
    "identify a motion": ("recording.filter_cutoff_Hz",),
    "identify standstills, force, tare": (),
    "validate": (*_RUN, "nominal", "poses", "payloads"),
    "demo": (*_RUN, "nominal"),
}
"""Command -> the tables and keys of a case that it needs; a table that is named needs those around it too."""
_OF_A_MOVING_FRAME = frozenset(NEEDS) - {"identify standstills, force, tare"}


class Readiness(NamedTuple):
    """Whether a case has what a command needs.

    Args:
        command: as it is typed.
        missing: tables and keys that the case lacks, or why the command is not for it.
    """

    command: str
    missing: tuple[str, ...]


def readiness(case: Case) -> tuple[Readiness, ...]:
    """What each command misses in a case."""
    if case.setup == "1a":  # Figure 1: the sensor frame stands
        return tuple(
            Readiness(command, ("a sensor frame that moves (setup is 1a)",) if command in _OF_A_MOVING_FRAME else ())
            for command in NEEDS
        )
    return tuple(Readiness(name, tuple(_missing(case, keys))) for name, keys in NEEDS.items())


def _missing(case: Case, keys: tuple[str, ...]) -> Iterator[str]:
    """Keys that the case lacks; of a table that is missing as a whole its own name only."""
    for key in keys:
        above = key.rpartition(".")[0]
        if not _has(case, key) and not (above in keys and not _has(case, above)):
            yield key


def _has(case: Case, key: str) -> bool:
    value: object = case
    for part in key.split("."):
        value = getattr(value, part, None)
    return value is not None
