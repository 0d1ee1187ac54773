"""What a TwinCAT 3 CNC (TF5200) or another ISG kernel needs to be told; nothing of it can be guessed."""

import re
from typing import Annotated, Literal

from pydantic import AfterValidator, Field, model_validator

from cases.controller_promises import Promises
from cases.controller_struts import PointToPointDrives
from cases.parts import Part, Positive
from cases.units import MS

PROGRAM_NAME = r"^[A-Za-z0-9_][A-Za-z0-9_.-]{0,62}$"
_TAKEN = {0, 1, 2, 3, 4, 5, 6, 17, 19, 29, 30}


def _program_name(name: str) -> str:
    if re.fullmatch(PROGRAM_NAME, name) is None:
        raise ValueError(
            f"{name!r} is no program name; write up to 63 letters, digits, _, . and -, not . or - at the beginning"
        )
    return name


def _free(number: int) -> int:
    if number in _TAKEN:
        raise ValueError(f"M{number} means something else to the controller; choose a user M function")
    return number


MFunction = Annotated[int, Field(strict=True, ge=7, le=999), AfterValidator(_free)]


class TwinCat(Part):
    """Settings of TF5200 / ISG programs. Channel parameters are named as in Beckhoff's manuals."""

    program_name: Annotated[str, AfterValidator(_program_name)]
    """Name in the `%` line."""
    kinematic_id: Annotated[int, Field(strict=True, ge=1, le=999)]
    """Of the hexapod's transformation: no manual names one, it is what `trafo[i].id` says."""
    angle_sign_b: Literal[-1, 1]
    """-1: B turns negatively, R = Rz(C) Ry(-B) Rx(A) (P-CHAN-00112 = 0, the default). +1: the kinematics takes the
    angles as R = Rz(C) Ry(B) Rx(A). Try it with a single small B before anything else."""
    path: Literal["akima", "hsc", "contour"]
    """Dense paths: `#SPLINE TYPE AKIMA` through the points, `#HSC ON [BSPLINE ..]` or `#CONTOUR MODE [DEV ..]` near
    them."""
    path_deviation_mm: Positive
    """PATH_DEV of `#HSC` and `#CONTOUR MODE`."""
    track_deviation_deg: Positive
    """TRACK_DEV of `#HSC` and `#CONTOUR MODE`."""
    slope: Literal["STEP", "TRAPEZ"]
    """`#SLOPE TYPE`: TRAPEZ limits the jerk, STEP does not."""
    trigger_on_m: MFunction
    """M function that the PLC makes the trigger's beginning of; it needs a synchronisation type (P-CHAN-00041)."""
    trigger_off_m: MFunction
    """The same for the trigger's end."""
    shortest_block_ms: Positive
    """The controller's cycle: shorter blocks starve it."""
    most_blocks: Annotated[int, Field(strict=True, ge=10)]
    """What its program memory holds."""
    controller_keeps: Promises
    """Limits that the controller keeps by itself in what it times; what is not named here is `NOT enforced`."""
    ptp: PointToPointDrives | None = None
    """Drives in moves under `#PTP ON`, which only `hexcite post --ptp-struts` writes; without it they are refused."""

    @model_validator(mode="after")
    def _two_functions(self) -> "TwinCat":
        if self.trigger_on_m == self.trigger_off_m:
            raise ValueError(f"trigger_on_m and trigger_off_m are both {self.trigger_on_m}; give two M functions")
        return self

    @property
    def shortest_block(self) -> float:
        """Shortest block [s]."""
        return self.shortest_block_ms * MS
