"""From a result to files: the targets, their names, and files that appear as a whole or not at all."""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from cases.errors import FileProblem, HexciteError, IdentificationError, choice
from cases.files import FolderKind, atomic_folder, check_file, check_folder, output_place, write_text
from cases.units import DEG, MM, Array
from identification.outcome import Result
from postprocessors.export.calibration import (
    checked_name,
    comment_lines,
    default_name,
    json_document,
    load_at_flange,
    require_exportable,
)
from postprocessors.export.code import c_sources, linuxcnc_component, structured_text

# target that is one file -> its suffix, what it holds, and whether the file's name becomes the name of the model
SINGLE_FILES: dict[str, tuple[str, Callable[[Result, str], str], bool]] = {
    "linuxcnc": (".comp", linuxcnc_component, True),
    "st": (".st", structured_text, True),
    "json": (".json", lambda result, _: json_document(result), False),
    "urscript": (".script", lambda result, _: urscript_payload(result), False),
}

TARGETS = ("c", *SINGLE_FILES)


def export(
    result: Result,
    target: str,
    output: Path | str | None = None,
    *,
    force: bool = False,
    overwrite: bool = False,
) -> list[Path]:
    """Writes the calibrated model for a controller.

    Args:
        result: identified parameters.
        target: one of `TARGETS`.
        output: file, or folder for `c`; by default named after the case, in the current folder.
        force: whether to export in spite of warnings, which are written into the file.
        overwrite: whether to replace the files of an earlier export.

    Returns:
        The files, the one that matters first.

    Raises:
        HexciteError: the target is unknown, cannot carry the model or cannot be written.
        FileProblem: the result carries warnings and `force` is not set.
    """
    require_exportable(result, force)
    place = None if output is None else Path(output)
    if target == "c":
        return _c_folder(result, place, overwrite)
    if target not in SINGLE_FILES:
        raise HexciteError(f"target {target!r} is unknown; {choice(target, TARGETS)}")
    suffix, text, named = SINGLE_FILES[target]
    usual = Path(f"{default_name(result.case)}{suffix}")
    file = output_place(place, usual, overwrite, "_" if named else "-")  # no name of a model holds "-"
    check_file(file, [suffix], [Path(result.source)], overwrite)
    write_text(file, text(result, checked_name(file.stem, file) if named else file.stem))
    return [file]


def _c_folder(result: Result, output: Path | None, overwrite: bool) -> list[Path]:
    name = default_name(result.case)
    folder = output_place(output, Path(f"{name}-c"), overwrite)
    if folder.suffix in (".c", ".h"):
        raise FileProblem(folder, f"--to c writes a folder with {name}.h and {name}.c", "name a folder with -o")
    names = [f"{name}.c", f"{name}.h"]
    compiled = frozenset({f"{name}.o"})  # files of a compiler there may be replaced too
    kind = FolderKind("a C model", frozenset(names) | compiled, f"{name}.h", compiled)
    check_folder(folder, kind, [Path(result.source)], overwrite)
    header, source = c_sources(result, name)
    with atomic_folder(folder, kind, overwrite) as part:
        (part / names[0]).write_text(source, encoding="ascii")
        (part / names[1]).write_text(header, encoding="ascii")
    return [folder / n for n in names]


LARGEST = 133.0  # [kg m^2] largest element of the inertia
ROUNDING = 1e-9  # share of the largest principal inertia: tolerance of the triangle inequality for rounding


def urscript_payload(result: Result) -> str:
    """A URScript program that sets the load of the force sensor, a rigid body, as payload of the robot.

    Script manual: mass, centre of gravity from the tool flange in metres, inertia about the centre of gravity along the
    flange's axes, in the order Ixx, Iyy, Izz, Ixy, Ixz, Iyz. The command zeroes the robot's own force sensor.

    Raises:
        CaseError: the case does not say where the flange is.
        IdentificationError: a static model, which has no inertia, an inertia that no body has or no robot takes, or
            sensors in struts at the drive, whose body is the platform with the rods.
    """
    load = load_at_flange(result)
    i = load.inertia
    moments = smallest, middle, largest = np.linalg.eigvalsh(i)
    if smallest <= 0.0 or smallest + middle < largest * (1.0 - ROUNDING) or i.diagonal().max() > LARGEST:
        problem = f"no load of a robot has the principal inertias {', '.join(f'{v:.4g}' for v in moments)} kg m^2"
        raise IdentificationError(result.source, f"{problem}; identify from a run that turns the machine more")
    centre = ", ".join(f"{v + 0.0:.5f}" for v in load.centre)
    elements = ", ".join(f"{v + 0.0:.6f}" for v in (*i.diagonal(), i[0, 1], i[0, 2], i[1, 2]))
    lines = [
        *(f"# {line}" for line in comment_lines(result)),
        "# payload: everything that the force sensor carries; add what is between flange and sensor, and the sensor",
        f"# from the tool flange, in its axes: the case's sensor frame lies in it at {_words(load.sensor)}",
        "# m from the flange, kg m^2 about the centre of gravity",
        f"set_target_payload({load.mass:.4f}, [{centre}], [{elements}])",
    ]
    return "def payload():\n" + "".join(f"  {line}\n" for line in lines) + "end\n"


def _words(place: Array) -> str:
    """Origin and angles of a frame, shape (4, 4)."""
    r = place[:3, :3]
    roll, yaw = np.arctan2(r[2, 1], r[2, 2]), np.arctan2(r[1, 0], r[0, 0])
    pitch = np.arctan2(-r[2, 0], np.hypot(r[0, 0], r[1, 0]))
    origin, angles = (
        ", ".join(f"{round(float(v), 2) + 0.0:.2f}" for v in values)
        for values in (place[:3, 3] / MM, np.array([roll, pitch, yaw]) / DEG)
    )
    return f"{origin} mm, turned by {angles} deg (roll, pitch, yaw)"
