"""The load as inertia in URDF, MJCF and SDF, each an element to put into the link or body that carries it."""

import numpy as np

from identification.options import FrameName
from identification.results.frames import place_of
from postprocessors.export.calibration import comment_lines
from postprocessors.export.load import Carried, carried_words, deviations_words, load_in, require_inertia

ORDER = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")


def urdf(result: Carried, name: str, frame: FrameName) -> str:
    """`<inertial>` of a URDF link whose frame is that of the sensor, flange or tool [kg, m, kg m^2]."""
    load = load_in(result, frame)
    xx, yy, zz, xy, xz, yz = _elements(require_inertia(load, result, "a link"))
    return _document(
        result,
        frame,
        "<inertial>",
        f'  <origin xyz="{_spaced(load.centre)}" rpy="0 0 0"/>',
        f'  <mass value="{load.mass:.9g}"/>',
        f'  <inertia ixx="{xx}" ixy="{xy}" ixz="{xz}" iyy="{yy}" iyz="{yz}" izz="{zz}"/>',
        "</inertial>",
    )


def mjcf(result: Carried, name: str, frame: FrameName) -> str:
    """`<inertial>` of a body of MuJoCo whose frame is that of the sensor, flange or tool [kg, m, kg m^2]."""
    load = load_in(result, frame)
    full = " ".join(_elements(require_inertia(load, result, "a body")))
    return _document(
        result,
        frame,
        f'<inertial pos="{_spaced(load.centre)}" mass="{load.mass:.9g}" fullinertia="{full}"/>',
    )


def sdf(result: Carried, name: str, frame: FrameName) -> str:
    """`<inertial>` of a link of SDFormat whose frame is that of the sensor, flange or tool [kg, m, kg m^2]."""
    load = load_in(result, frame)
    elements = _elements(require_inertia(load, result, "a link"))
    return _document(
        result,
        frame,
        "<inertial>",
        f"  <pose>{_spaced(load.centre)} 0 0 0</pose>",
        f"  <mass>{load.mass:.9g}</mass>",
        "  <inertia>",
        *(f"    <{key}>{value}</{key}>" for key, value in zip(ORDER, elements, strict=True)),
        "  </inertia>",
        "</inertial>",
    )


def _elements(inertia: np.ndarray) -> list[str]:
    """Ixx, Iyy, Izz, Ixy, Ixz, Iyz."""
    return [f"{v:.9g}" for v in (*inertia.diagonal(), inertia[0, 1], inertia[0, 2], inertia[1, 2])]


def _spaced(values: np.ndarray) -> str:
    return " ".join(f"{v:.9g}" for v in values)


def _document(result: Carried, frame: FrameName, *lines: str) -> str:
    """An element behind a comment, which must not hold two hyphens in a row."""
    remarks = [
        *comment_lines(result),
        f"{carried_words(result)}; in the frame: {place_of(result.case_as_told, frame).words}",
        deviations_words(result, frame),
    ]
    comment = "\n".join(f"  {line}" for line in remarks)
    while "--" in comment:
        comment = comment.replace("--", "- -")
    return "\n".join([f"<!--\n{comment}\n-->", *lines, ""])
