"""From a result to files: the targets, their names, and files that appear as a whole or not at all."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import NamedTuple

from cases.base.atomic import atomic_folder, write_text
from cases.base.errors import WITH_OUTPUT, Code, FileProblem, HexciteError, choice, option
from cases.base.folder_kinds import FolderKind
from cases.base.options import default_of, documented
from cases.base.output_places import check_file, check_folder, output_place
from identification.options import FrameName
from identification.results.frames import frame_named
from identification.results.payload import Payload
from identification.results.result import Result
from postprocessors.export import robots, ros2, simulators
from postprocessors.export.calibration import (
    checked_name,
    default_name,
    json_document,
    require_added,
    require_exportable,
)
from postprocessors.export.code import c_sources, linuxcnc_component, python_module, structured_text
from postprocessors.export.load import Carried
from postprocessors.options import DespiteWarnings, ExportFrame, ExportTarget


class Target(NamedTuple):
    """What can be written as one file.

    Args:
        suffix: of the file.
        text: its text, of the result and the name of model or module.
        named: whether the file's name becomes that name.
        what: a few words for people.
    """

    suffix: str
    text: Callable[[Result, str], str]
    named: bool
    what: str


class ChainTarget(NamedTuple):
    """A signal chain in a language, whose wrench is about and along the frame that is chosen."""

    suffix: str
    text: Callable[[Result, str, FrameName], str]
    named: bool
    what: str


class RobotTarget(NamedTuple):
    """A target that states the load, of a result or a payload, from the robot's flange."""

    suffix: str
    text: Callable[[Carried, str], str]
    named: bool
    what: str


class LinkTarget(NamedTuple):
    """A target whose text is counted from the frame that is chosen; `usual` where none is."""

    suffix: str
    text: Callable[[Carried, str, FrameName], str]
    named: bool
    what: str
    usual: FrameName = "sensor"


AnyTarget = Target | ChainTarget | RobotTarget | LinkTarget

SINGLE_FILES: dict[str, AnyTarget] = {
    "linuxcnc": ChainTarget(".comp", linuxcnc_component, True, "HAL component"),
    "st": ChainTarget(".st", structured_text, True, "IEC 61131-3"),
    "python": ChainTarget(".py", python_module, True, "a module that needs NumPy"),
    "json": Target(".json", lambda result, _: json_document(result), False, "the whole model"),
    "urscript": RobotTarget(".script", robots.urscript, False, "Universal Robots"),
    "kuka": RobotTarget(".dat", robots.kuka, False, "LOAD_DATA"),
    "rapid": RobotTarget(".mod", robots.rapid, True, "ABB loaddata"),
    "franka": RobotTarget(".yaml", robots.franka, False, "setLoad"),
    "xarm": RobotTarget(".py", robots.xarm, False, "UFACTORY"),
    "kinova": RobotTarget(".py", robots.kinova, False, "Kortex API"),
    "fanuc": RobotTarget(".txt", robots.fanuc, False, "PAYLOAD SET, to type in"),
    "table": LinkTarget(".txt", robots.table, False, "to type in: other robots", "flange"),
    "ros2": Target(".yaml", ros2.broadcaster, False, "force_torque_sensor_broadcaster"),
    "ft-tools": Target(".yaml", ros2.ft_tools, False, "calibration of ft_tools"),
    "urdf": LinkTarget(".xml", simulators.urdf, False, "<inertial>"),
    "mjcf": LinkTarget(".xml", simulators.mjcf, False, "<inertial>"),
    "sdf": LinkTarget(".xml", simulators.sdf, False, "<inertial>"),
}

LOADS = tuple(n for n, target in SINGLE_FILES.items() if not isinstance(target, Target | ChainTarget))
FRAMED = ("c", *(n for n, target in SINGLE_FILES.items() if isinstance(target, ChainTarget | LinkTarget)))
"""Targets that have a choice of frames."""
TARGETS = ("c", *SINGLE_FILES)


@documented()
def export(
    result: Carried,
    target: ExportTarget,
    output: Path | str | None = None,
    *,
    frame: ExportFrame = default_of(ExportFrame),
    force: DespiteWarnings = default_of(DespiteWarnings),
    overwrite: bool = False,
) -> list[Path]:
    """Writes the calibrated model, or the load that it found, for a controller or a simulator.

    >>> hx.export(hx.Result.load("empty-result"), "json", "calibration.json")[0].name
    'calibration.json'

    Args:
        result: identified parameters, or the payload between two results for a target of `LOADS`.
        output: file, or folder for `c`; by default named after the case, in the current folder.
        OPTIONS
        overwrite: whether to replace the files of an earlier export.

    Returns:
        The files, the one that matters first.

    Raises:
        HexciteError: the target is unknown, cannot carry the model or cannot be written.
        FileProblem: the result carries warnings and `force` is not set.

    Example:
        `hx.export(result, "kuka", "load.dat")` writes LOAD_DATA with the load counted from the flange.
    """
    exporter = _target(target)
    place = None if output is None else Path(output)
    require_exportable(result, force)
    if exporter is None:
        result = _whole(result, target)
        return _c_folder(result, place, overwrite, frame_named(frame or "sensor"))
    usual = Path(f"{_usual_name(result)}{exporter.suffix}")
    file = output_place(place, usual, overwrite, "_" if exporter.named else "-")  # no name of a model holds "-"
    read = [result] if isinstance(result, Result) else [result.empty, result.loaded]
    check_file(file, [exporter.suffix], [Path(of.source) for of in read], overwrite)
    write_text(
        file, _text(result, target, exporter, checked_name(file.stem, file) if exporter.named else file.stem, frame)
    )
    return [file]


@documented()
def preview(
    result: Carried, target: ExportTarget, *, frame: ExportFrame = default_of(ExportFrame)
) -> Mapping[str, str]:
    """What `export` would write, warnings or not: the text of each file by its usual name.

    >>> list(hx.preview(hx.Result.load("empty-result"), "c"))
    ['hexapod_force.h', 'hexapod_force.c']

    Args:
        result: as of `export`.
        OPTIONS

    Raises:
        HexciteError: the target is unknown, or cannot carry the model.
    """
    exporter, name = _target(target), _usual_name(result)
    if exporter is None:
        header, source = c_sources(_whole(result, target), name, frame_named(frame or "sensor"))
        return {f"{name}.h": header, f"{name}.c": source}
    return {f"{name}{exporter.suffix}": _text(result, target, exporter, name, frame)}


def _target(target: str) -> AnyTarget | None:
    """The target of that name; None for `c`."""
    if target not in TARGETS:
        raise HexciteError(problem=f"target {target!r} is unknown", remedy=choice(target, TARGETS), code=Code.UNKNOWN)
    return SINGLE_FILES.get(target)


def _text(result: Carried, target: str, kind: AnyTarget, name: str, frame: str | None) -> str:
    if isinstance(kind, Target):
        _require_no_frame(target, frame)
        return kind.text(_whole(result, target), name)
    if isinstance(kind, ChainTarget):
        return kind.text(_whole(result, target), name, frame_named(frame or "sensor"))
    if isinstance(result, Payload):
        require_added(result)
    if isinstance(kind, RobotTarget):
        _require_no_frame(target, frame)
        return kind.text(result, name)
    return kind.text(result, name, kind.usual if frame is None else frame_named(frame))


def _usual_name(result: Carried) -> str:
    """Name of a file: that of the case; a payload says that it is one."""
    return default_name(result.case) if isinstance(result, Result) else f"{default_name(result.loaded.case)}_payload"


def _whole(result: Carried, target: str) -> Result:
    """The result itself; raises HexciteError for a payload, which has neither offsets nor a model of forces."""
    if isinstance(result, Result):
        return result
    problem = f"target {target} states what a sensor reads, which no payload alone does"
    raise HexciteError(
        problem=problem, remedy=f"export the result with it, or choose {', '.join(LOADS)}", code=Code.NOT_SUPPORTED
    )


def _require_no_frame(target: str, frame: str | None) -> None:
    if frame is not None:
        raise HexciteError(
            problem=f"target {target} has a frame of its own",
            remedy=f"leave {option('frame')} out, or choose {', '.join(FRAMED)}",
            code=Code.CONTRADICTION,
        )


def _c_folder(result: Result, output: Path | None, overwrite: bool, frame: FrameName) -> list[Path]:
    name = default_name(result.case)
    folder = output_place(output, Path(f"{name}-c"), overwrite)
    if folder.suffix in (".c", ".h"):
        raise FileProblem(
            place=folder,
            problem=f"{option('target', 'to')} c writes a folder with {name}.h and {name}.c",
            remedy=f"name a folder{WITH_OUTPUT}",
            code=Code.WRONG_KIND,
        )
    names = [f"{name}.c", f"{name}.h"]
    compiled = frozenset({f"{name}.o"})  # files of a compiler there may be replaced too
    kind = FolderKind("a C model", frozenset(names) | compiled, f"{name}.h", compiled)
    check_folder(folder, kind, [Path(result.source)], overwrite)
    header, source = c_sources(result, name, frame)
    with atomic_folder(folder, kind, overwrite) as part:
        (part / names[0]).write_text(source, encoding="ascii")
        (part / names[1]).write_text(header, encoding="ascii")
    return [folder / n for n in names]
