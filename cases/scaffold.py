"""The beginning of a case file for one's own machine: a built-in one with advice above each table."""

import ast
import inspect
import json
import re
import textwrap
from collections.abc import Callable, Mapping
from itertools import pairwise
from pathlib import Path

from cases.controller import Controller, Setpoints, Sinumerik, TwinCat
from cases.errors import CaseError, FileProblem
from cases.files import toml_value, write_text
from cases.poses import Poses
from cases.schema import Case, load_case
from cases.tables import CASE_FILE, Part, built_in_cases, find_case
from cases.urdf import read_urdf

_NAME = re.compile(r"[a-z][a-z0-9_]*")

_ADVICE = {
    "machine": "From the drawing: centres of the joints, base joints in {B}, platform joints in {P}, in strut order.\n"
    "# A ring lists them pair by pair: first centre less half_angle, first centre plus half_angle, second centre\n"
    "# less half_angle, and so on.\n"
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
    "# and of vibration acceleration_noise_m_s2 and\n"
    "# angular_acceleration_noise_rad_s2. hexcite identify says what errors look like that depend on the pose:\n"
    "# pose_error_N and pose_error_length_mm, which plans then count on.",
    "recording": "How recordings are written: `hexcite look RECORDING --case CASE` proposes this table. By example:\n"
    "# delimiter = ';', decimal = ',', header_rows = 2, names_row = 1      # text that is not plain CSV\n"
    '# clock = { unit = "ms" }            # of the stamps; { period_ms = 1.0 } where a file has none\n'
    '# units = { struts = "m", forces = "kN" }\n'
    "# and below all keys of this table, our name of a column = the file's:\n"
    "# [recording.columns]\n"
    '# t_s = "time"\n'
    '# l1_mm = "Strut1.ActPos"\n'
    '# f1_N = "Force1"\n'
    '# trigger = "Trigger"',
    "controller": "How the controller is set up. Nothing here is guessed: check each with its machine's parameters.",
    "controller.sinumerik": "SINUMERIK programs; without one delete this table, and the next ones likewise. The\n"
    "# transformation of a hexapod is the machine builder's: ask for these words.",
    "controller.twincat": "TwinCAT CNC (TF5200) and ISG programs.",
    "controller.setpoints": "Setpoints for a controller that takes positions cycle by cycle.",
    "nominal": "A-priori values of the moving body from CAD: mass, centre of gravity in {P}, inertia about it.",
    "simulation": "A simulated machine for rehearsals (hexcite run, demo): parameters of a first result will\n"
    "# do. Plans and programs do without it.",
}

_OF_KEYS = {
    "setup": "Where the sensors are: 1a in a frame at rest (clamping table), 1b in the moving end-effector, 2x in\n"
    "# the struts, R between a robot's flange, or a machine tool's table, and its load (six-axis force/torque sensor).",
    "gravity_m_s2": "In {B}, of your place: 9.78 at the equator to 9.83 at the poles. Masses go with its inverse.",
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


def new_case(name: str, like: str = "hexapod", folder: Path | str | None = None) -> Path:
    """Writes `folder/case.toml`, the built-in case `like` under another name, to be filled in; returns its path.

        hx.check_case(hx.new_case("mill"))

    Args:
        name: small letters, digits and underscores.
        folder: folder to make; named after the case unless given.

    Raises:
        CaseError: a name that a case cannot have, or no such built-in case.
        FileProblem: the folder holds a case, or cannot be written.
    """
    file = _place(name, folder)
    load_case(like)
    lines: list[str] = [
        f"# {name}: begun from the case {like}; every number is that case's until you replace it. Keys carry units.",
        "# {B} is the frame of the base, {P} that of the platform. `hexcite case check` says what cannot be.",
        "",
    ]
    comments: Mapping[str, str] = {}
    for line in find_case(like).read_text(encoding="utf-8").splitlines():
        if line.startswith("#"):
            continue  # the built-in case's own words on its sources
        table = re.match(r"\[([a-z_.]+)\]", line)
        if table:
            if table[1] in _ADVICE:
                lines.append(f"# {_ADVICE[table[1]]}")
            line = table[0]  # what follows it is about the built-in case's source
            comments = explanations(_EXPLAINED[table[1]]) if table[1] in _EXPLAINED else {}
        elif key := re.match(r"(\w+) = ", line):
            lines += textwrap.wrap(comments.get(key[1], ""), _WIDTH, initial_indent="# ", subsequent_indent="# ")
            line = re.sub(r"\] # .*", "]", line)
        line = re.sub(r'^name = ".*"', f'name = "{name}"', line)
        line = re.sub(r'^title = ".*"', 'title = "what it is, in a line"', line)
        if comment := next((words for key, words in _OF_KEYS.items() if line.startswith(f"{key} = ")), None):
            lines.append(f"# {comment}")
        line = re.sub(r'^source = ".*"', 'source = "where these values come from"', line)
        lines.append(line)
        if line == "[controller]":
            lines += textwrap.wrap(comments["plan_for"], _WIDTH, initial_indent="# ", subsequent_indent="# ")
            lines.append('# plan_for = "linuxcnc"')
    write_text(file, "\n".join(lines).replace("\n\n\n", "\n\n") + "\n")
    return file


def new_arm(name: str, urdf: Path | str, flange: str | None = None, folder: Path | str | None = None) -> Path:
    """Writes `folder/case.toml` with the chain of a URDF file; keys that no URDF has are there as comments.

        hx.new_arm("arm", "robot.urdf", "tool0")

    Args:
        flange: link that carries the sensor.
        folder: folder to make; named after the case unless given.

    Raises:
        CaseError: a name that a case cannot have; the URDF file is not sound or has no such link.
        FileProblem: the folder holds a case, or cannot be written.
    """
    file = _place(name, folder)
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    templates = Environment(
        loader=FileSystemLoader(Path(__file__).parent),
        undefined=StrictUndefined,
        trim_blocks=True,
        keep_trailing_newline=True,
    )
    templates.filters["keys"] = _keys
    base, joints, sensor = read_urdf(Path(urdf), flange)
    robot = {"urdf": Path(urdf).name, "base": base, "flange": flange, "joints": joints, "sensor": sensor}
    write_text(file, templates.get_template("arm.toml.jinja").render(robot, name=name, advice=_ADVICE))
    return file


def _keys(table: Part) -> str:
    """TOML of what a table states, its name first; 12 decimals, so that right angles and millimetres read as such."""
    text = table.model_dump_json(exclude_unset=True, exclude_none=True)
    stated = json.loads(text, parse_float=lambda number: round(float(number), 12) + 0.0)
    return "\n".join(f"{key} = {toml_value(stated[key])}" for key in sorted(stated, key=lambda key: key != "name"))


def _place(name: str, folder: Path | str | None) -> Path:
    """The case file to write; raises CaseError for a name that no case can have, FileProblem where it exists."""
    if not _NAME.fullmatch(name):
        raise CaseError(
            name or "''", "", "is not a name of a case; use small letters, digits and underscores, a letter first"
        )
    if name in built_in_cases():
        raise CaseError(name, "", "is the name of a built-in case; choose another one")
    file = Path(name if folder is None else folder) / CASE_FILE
    if file.exists():
        raise FileProblem(file, "exists", "choose another folder with -o, or edit that file")
    return file


def explanations(part: type[Part]) -> Mapping[str, str]:
    """What each key of a table means: the string that stands below its field in the class."""
    bodies = (ast.parse(inspect.getsource(base)).body[0] for base in reversed(part.__mro__) if issubclass(base, Part))
    return {
        field.target.id: " ".join(str(text.value.value).split())
        for body in bodies
        for field, text in pairwise(ast.iter_child_nodes(body))
        if isinstance(field, ast.AnnAssign) and isinstance(field.target, ast.Name)
        if isinstance(text, ast.Expr) and isinstance(text.value, ast.Constant)
    }


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
    "post --dialect urscript": (*_PROGRAM, "controller.urscript"),
    "post --dialect ros2": _PROGRAM,
    "run": _RUN,
    "identify a motion": ("recording.filter_cutoff_Hz",),
    "identify standstills, force, tare": (),
    "validate": (*_RUN, "controller.sinumerik", "nominal", "poses", "payloads"),  # on the virtual controller
    "demo": (*_RUN, "nominal"),
}
"""Command -> the tables and keys of a case that it needs; a table that is named needs those around it too."""
_NOT_OF_A_CHAIN = frozenset({"workspace", "controller.linuxcnc"})  # what chains do not need
_OF_A_MOVING_FRAME = frozenset(NEEDS) - {"identify standstills, force, tare"}


def readiness(case: Case) -> dict[str, tuple[str, ...]]:
    """Tables and keys that a case lacks for each command, or why the command is not for it; empty where it is ready."""
    if case.setup == "1a":  # Figure 1: the sensor frame stands
        still = ("a sensor frame that moves (setup is 1a)",)
        return {command: still if command in _OF_A_MOVING_FRAME else () for command in NEEDS}
    return {name: _lacks(case, name, keys) for name, keys in NEEDS.items()}


_OTHER_MACHINES: tuple[tuple[tuple[str, ...], Callable[[Case], bool], str], ...] = (
    (("validate",), lambda case: case.chain is not None, "a hexapod (the machine is a chain)"),
    (
        ("validate",),
        lambda case: case.sensor_frame.struts is not None,
        "sensors in the platform (they sit in the struts)",
    ),
    (
        ("post --dialect urscript", "post --dialect ros2"),
        lambda case: case.hexapod is not None,
        "a chain of joints (the machine is a hexapod)",
    ),
    (
        ("post --dialect linuxcnc", "post --dialect sinumerik", "post --dialect twincat"),
        lambda case: case.chain is not None and not set(case.chain.names) <= set("XYZABC"),
        "joints that are named as axes, X, Y, Z, A, B, C",
    ),
    (
        ("post --dialect urscript",),
        lambda case: case.chain is not None and [j.kind for j in case.chain.joints] != ["revolute"] * 6,
        "six joints that turn between ends",
    ),
)
"""Commands, the machines that they are not for, and what they are for."""


def _lacks(case: Case, command: str, keys: tuple[str, ...]) -> tuple[str, ...]:
    """Keys that a command misses, of a table that is missing its own name only, or the machine that it is for."""
    if wanted := [words for commands, refuses, words in _OTHER_MACHINES if command in commands and refuses(case)]:
        return (wanted[0],)
    missing = [key for key in keys if not _has(case, key) and (case.chain is None or key not in _NOT_OF_A_CHAIN)]
    return tuple(key for key in missing if key.rpartition(".")[0] not in missing)


def _has(case: Case, key: str) -> bool:
    value: object = case
    for part in key.split("."):
        value = getattr(value, part, None)
    return value is not None
