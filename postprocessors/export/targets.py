"""From a result to files: the targets, their names, and files that appear as a whole or not at all."""

from collections.abc import Callable, Iterable
from itertools import permutations, product
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from cases.errors import FileProblem, HexciteError, IdentificationError
from cases.files import atomic_folder, check_file, check_folder, output_place, write_text
from cases.units import DEG, MM
from identification.motion import Array
from identification.outcome import Result
from identification.parameters import INERTIA
from postprocessors.export.calibration import (
    checked_name,
    comment_lines,
    default_name,
    json_document,
    require_exportable,
)
from postprocessors.export.code import c_sources, linuxcnc_component, structured_text

# target that is one file -> its suffix, what it holds, and whether the file's name becomes the name of the model
SINGLE_FILES: dict[str, tuple[str, Callable[[Result, str], str], bool]] = {
    "linuxcnc": (".comp", linuxcnc_component, True),
    "st": (".st", structured_text, True),
    "json": (".json", lambda result, _: json_document(result), False),
    "urscript": (".script", lambda result, _: urscript_payload(result), False),
    "isg-load": (".nc", lambda result, _: isg_load(result), False),
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
        raise HexciteError(f"target {target!r} is unknown; choose {', '.join(TARGETS)}")
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
    kind = "a C model", frozenset((*names, f"{name}.o"))  # files of a compiler there may be replaced too
    check_folder(folder, kind, [Path(result.source)], overwrite)
    header, source = c_sources(result, name)
    with atomic_folder(folder, kind, overwrite) as part:
        (part / names[0]).write_text(source, encoding="ascii")
        (part / names[1]).write_text(header, encoding="ascii")
    return [folder / n for n in names]


LARGEST = 133.0  # [kg m^2] largest element of the inertia


def urscript_payload(result: Result) -> str:
    """A URScript program that sets the identified body as payload; errors as `identified_load`, or it is too large.

    Script manual: mass, centre of gravity from the tool flange in metres, inertia about the centre of gravity along the
    flange's axes, in the order Ixx, Iyy, Izz, Ixy, Ixz, Iyz. The command zeroes the robot's own force sensor.
    """
    mass, centre, inertia = identified_load(result, "set_target_payload")
    elements = [inertia[i, j] for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))]
    if max(map(abs, elements)) > LARGEST:
        problem = f"an inertia of {max(map(abs, elements)):.4g} kg m^2 is above what a robot takes ({LARGEST:g})"
        raise IdentificationError(result.source, f"{problem}; is this the load of a robot?")
    lines = [
        *(f"# {line}" for line in comment_lines(result)),
        "# payload: everything that the force sensor carries; add what is between flange and sensor, and the sensor",
        "# tool flange = sensor frame {P} of the case; m from it, kg m^2 about the centre of gravity",
        f"set_target_payload({mass:.4f}, {_list(centre, 5)}, {_list(elements, 6)})",
    ]
    return "def payload():\n" + "".join(f"  {line}\n" for line in lines) + "end\n"


def _list(values: Iterable[float], decimals: int) -> str:
    return f"[{', '.join(f'{float(v) + 0.0:.{decimals}f}' for v in values)}]"


ROUNDING = 1e-9  # share of the largest principal inertia: tolerance of the triangle inequality for rounding


def principal_axes(inertia: Array) -> tuple[Array, Array]:
    """Principal moments, shape (3,), of a tensor, shape (3, 3) [kg m^2], and the rotation from their axes to {P}.

    Order and sense of the axes are those that turn them least from {P}.
    """
    moments, axes = np.linalg.eigh(inertia)
    ways = product(permutations(range(3)), product((1.0, -1.0), repeat=3))
    turned = [(moments[list(order)], axes[:, order] * signs) for order, signs in ways]
    rotations = [(values, turn) for values, turn in turned if np.linalg.det(turn) > 0.0]
    return max(rotations, key=lambda found: float(np.trace(found[1])))  # trace = 1 + 2 cos(angle)


def identified_load(result: Result, command: str) -> tuple[float, Array, Array]:
    """The load of the force sensors as a rigid body in {P}, for a controller's command of some name.

    Returns mass [kg], centre of gravity, shape (3,) [m], and inertia about it, shape (3, 3) [kg m^2].

    Raises:
        IdentificationError: a static model, which has no inertia, an inertia that no body has, or sensors in struts at
            the drive, whose body is the platform with the rods.
    """
    source, number = result.source, result.model.number
    if INERTIA not in result.model.blocks:
        problem = f"model {number} has no inertia, which {command} needs; identify model 6, 7, 8 or 9"
        raise IdentificationError(source, problem)
    struts = result.model.struts
    if struts is not None and struts.sensors.at == "drive":
        problem = (
            f"{command} describes a load, and sensors at the drives' end of the struts cannot tell it from the rods"
        )
        raise IdentificationError(source, problem, "export --to c, linuxcnc or st")
    value = {name: v.value for name, v in result.parameters.items()}
    xx, xy, xz, yy, yz, zz = (value[f"IC{k}"] for k in ("11", "12", "13", "22", "23", "33"))
    inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    smallest, middle, largest = moments = np.linalg.eigvalsh(inertia)
    if smallest <= 0.0 or smallest + middle < largest * (1.0 - ROUNDING):
        problem = f"no body has the principal inertias {', '.join(f'{v:.4g}' for v in moments)} kg m^2"
        raise IdentificationError(source, f"{problem}; identify from a run that turns the machine more")
    return value["m"], np.array([value[f"{c}C"] for c in "xyz"]), inertia


def isg_load(result: Result) -> str:
    """NC code that defines the identified body as load 1 and selects it; errors as `identified_load`.

    Beckhoff infosys, TF5200: P-CHAN-00763 to 00772 (mass, centre of gravity, rotation, main moments of inertia) and
    00776 (ID), diagnosis 22209 (form of the command); ISG kernel documentation, "Load parameterisation" (frames,
    rotation, IDX).
    """
    mass, centre, inertia = identified_load(result, "#LIMIT LOAD")
    moments, turn = principal_axes(inertia)
    rx, ry, rz = Rotation.from_matrix(turn).as_euler("xyz") / DEG
    words = [f"{letter}={v:.4f}" for letter, v in zip("XYZ", centre / MM, strict=True)]
    words += [f"{letter}={v:.4f}" for letter, v in zip(("RX", "RY", "RZ"), (rx, ry, rz), strict=True)]
    words += [f"{letter}={v:.6f}" for letter, v in zip(("IX", "IY", "IZ"), moments, strict=True)]
    words.append(f"MASS={mass:.4f}")
    load = " ".join(words)
    comments = [
        *comment_lines(result),
        "load: everything that the force sensors carry, as a rigid body",
        "flange coordinate system = platform frame {P} of the case",
        "X Y Z: centre of gravity [mm]; RX RY RZ: principal axes, R = Rz Ry Rx [degrees]",
        "IX IY IZ: principal moments of inertia about the centre of gravity [kg m^2]; MASS [kg]",
        f"kernels that count loads from 0: #LIMIT LOAD [IDX=0 {load}]",
    ]
    code = ["G71", f"#LIMIT LOAD DEF [{load} ID=1]", "#LIMIT LOAD [ID=1]"]
    return "".join(f"; {line}\n" for line in comments) + "".join(f"{line}\n" for line in code)
