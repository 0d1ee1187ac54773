"""The identified body as a load of ISG kernels (Beckhoff TwinCAT CNC, TF5200): `#LIMIT LOAD`.

Beckhoff infosys, TF5200: P-CHAN-00763 to 00772 (mass, centre of gravity, rotation, main moments of inertia) and 00776
(ID), diagnosis 22209 (form of the command); ISG kernel documentation, "Load parameterisation" (frames, rotation, IDX).
"""

from itertools import permutations, product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from cases.errors import IdentificationError
from cases.units import DEG, MM
from identification.regressor_blocks import INERTIA
from postprocessors.export.calibration import Calibration, comment_lines

Array = NDArray[np.float64]

ROUNDING = 1e-9  # of the largest principal inertia: what the triangle inequality may miss by rounding


class PrincipalAxes(NamedTuple):
    """Principal moments of inertia, shape (3,) [kg m^2], and the rotation from their axes to {P}, shape (3, 3)."""

    moments: Array
    turn: Array


def principal_axes(inertia: Array) -> PrincipalAxes:
    """Principal axes of a tensor, shape (3, 3) [kg m^2], in the order and sense that turn them least from {P}'s."""
    moments, axes = np.linalg.eigh(inertia)
    best = PrincipalAxes(moments, axes)
    largest = -np.inf
    for order in permutations(range(3)):
        for signs in product((1.0, -1.0), repeat=3):
            turn = axes[:, order] * signs
            if np.linalg.det(turn) > 0.0 and np.trace(turn) > largest:  # trace = 1 + 2 cos(angle)
                largest, best = float(np.trace(turn)), PrincipalAxes(moments[list(order)], turn)
    return best


class IdentifiedLoad(NamedTuple):
    """What the force sensors carry, as a rigid body in {P}."""

    mass: float  # [kg]
    centre: Array  # of gravity, shape (3,) [m]
    inertia: Array  # about the centre of gravity, shape (3, 3) [kg m^2]
    principal: PrincipalAxes


def identified_load(calibration: Calibration, command: str) -> IdentifiedLoad:
    """The identified body, for a controller's command of some name.

    Raises:
        IdentificationError: a static model, which has no inertia, an inertia that no body has, or sensors in struts at
            the drive, whose body is the platform with the rods.
    """
    source, number = calibration.result.source, calibration.model.number
    if INERTIA not in calibration.model.blocks:
        raise IdentificationError(
            f"{source}: model {number} has no inertia, which {command} needs; identify model 6, 7, 8 or 9"
        )
    struts = calibration.model.struts
    if struts is not None and struts.sensors.at == "drive":
        raise IdentificationError(
            source,
            f"{command} describes a load, and sensors at the drives' end of the struts cannot tell it from the rods",
            "export --to c, linuxcnc or st",
        )
    value = {name: v.value for name, v in calibration.physical.items()}
    xx, xy, xz, yy, yz, zz = (value[f"IC{k}"] for k in ("11", "12", "13", "22", "23", "33"))
    inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    principal = principal_axes(inertia)
    smallest, middle, largest = np.sort(principal.moments)
    if smallest <= 0.0 or smallest + middle < largest * (1.0 - ROUNDING):
        raise IdentificationError(
            f"{source}: no body has the principal inertias {', '.join(f'{v:.4g}' for v in principal.moments)} kg m^2; "
            "identify from a run that turns the machine more"
        )
    return IdentifiedLoad(value["m"], np.array([value[f"{c}C"] for c in "xyz"]), inertia, principal)


def isg_load(calibration: Calibration) -> str:
    """NC code that defines the identified body as load 1 and selects it.

    Raises:
        IdentificationError: a static model, which has no inertia, or an inertia that no body has.
    """
    body = identified_load(calibration, "#LIMIT LOAD")
    rx, ry, rz = Rotation.from_matrix(body.principal.turn).as_euler("xyz") / DEG
    words = [f"{letter}={v:.4f}" for letter, v in zip("XYZ", body.centre / MM, strict=True)]
    words += [f"{letter}={v:.4f}" for letter, v in zip(("RX", "RY", "RZ"), (rx, ry, rz), strict=True)]
    words += [f"{letter}={v:.6f}" for letter, v in zip(("IX", "IY", "IZ"), body.principal.moments, strict=True)]
    words.append(f"MASS={body.mass:.4f}")
    load = " ".join(words)
    comments = [
        *comment_lines(calibration),
        "load: everything that the force sensors carry, as a rigid body",
        "flange coordinate system = platform frame {P} of the case",
        "X Y Z: centre of gravity [mm]; RX RY RZ: principal axes, R = Rz Ry Rx [degrees]",
        "IX IY IZ: principal moments of inertia about the centre of gravity [kg m^2]; MASS [kg]",
        f"kernels that count loads from 0: #LIMIT LOAD [IDX=0 {load}]",
    ]
    code = ["G71", f"#LIMIT LOAD DEF [{load} ID=1]", "#LIMIT LOAD [ID=1]"]
    return "".join(f"; {line}\n" for line in comments) + "".join(f"{line}\n" for line in code)
