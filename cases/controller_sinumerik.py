"""What a SINUMERIK 840D sl / ONE with a hexapod transformation needs to be told; nothing of it can be guessed."""

import re
from typing import Annotated, Literal

from pydantic import AfterValidator, Field, model_validator

from cases.controller_promises import Promises
from cases.controller_struts import PointToPointDrives
from cases.parts import Part, Positive
from cases.units import DEG, MM, MS

PROGRAM_NAME = r"^(?:[A-Z]{2}|_[A-Z])[A-Z0-9_]{0,22}$"
TRANSFORMATION = r"^[A-Z][A-Z0-9_]*(?:\([0-9](?:,[0-9])*\))?$"
_NOT_WORDS = {
    *"DFGHIJKLMNPRSTXYZ",
    "LEAD",
    "TILT",
    "THETA",
    "PHI",
    "PSI",
    "AR",
    "CR",
    "PL",
    "PO",
    "PW",
    "SD",
    "ACC",
    "OVR",
}
_VECTORS = re.compile(r"[ABC][3-7]")


def _program_name(name: str) -> str:
    if re.fullmatch(PROGRAM_NAME, name) is None:
        raise ValueError(
            f"{name!r} is no program name; write 2 to 24 of A-Z, 0-9 and _, beginning with two letters or _ and a "
            "letter"
        )
    return name


def _transformation(call: str) -> str:
    if re.fullmatch(TRANSFORMATION, call) is None:
        raise ValueError(f"{call!r} switches no transformation; write a name as TRAORI or a call as TRAORI(2)")
    return call


def _angle_words(words: tuple[str, str, str]) -> tuple[str, str, str]:
    vector = next((word for word in words if _VECTORS.fullmatch(word)), None)
    if vector is not None:
        raise ValueError(
            f"{vector} takes a component of a vector, not an angle; write the words for roll, pitch and yaw, such as "
            "A2, B2, C2"
        )
    if len(set(words)) < 3 or _NOT_WORDS & set(words):
        raise ValueError(f"{', '.join(words)} do not name three angles; write the words for roll, pitch and yaw")
    return words


def _word(word: str) -> str:
    if re.fullmatch(r"[A-Z]{1,7}[0-9]?", word) is None:
        raise ValueError(f"{word!r} is no address; write capitals and at most one digit, such as A or A2")
    return word


Word = Annotated[str, AfterValidator(_word)]
Call = Annotated[str, AfterValidator(_transformation)]
AngleWords = Annotated[tuple[Word, Word, Word], AfterValidator(_angle_words)]


class Sinumerik(Part):
    """Settings of SINUMERIK programs. The transformation of a hexapod is the machine builder's: ask for these words."""

    program_name: Annotated[str, AfterValidator(_program_name)]
    """Internal name: 2 to 24 capitals, digits and underscores that begin with two letters or `_` and a letter."""
    transformation: Call
    """What switches the transformation on: `TRAORI`, `TRAORI(2)` or the builder's own name."""
    transformation_off: Call
    """What switches it off."""
    orientation_words: AngleWords
    """Roll, pitch, yaw in blocks: `A2 B2 C2` (written `A2=`, read under ORIRPY), or `A B C` if the transformation
    takes the angles as axes."""
    orientation_axes: AngleWords
    """Names of the axes behind them, for FGROUP( ) and PO[ ]."""
    path: Literal["poly", "lines"]
    """Motions that are no straight moves: polynomial blocks (POLY), or dense G1 with the compressor COMPCAD."""
    moves: Literal["feed", "poly"] = "feed"
    """Point-to-point moves: G1 at a feed under the controller's own time law, or POLY blocks that hold the plan's."""
    poly_degree: Literal[3, 5]
    """Of the polynomials that the controller takes."""
    poly_axes: Annotated[int, Field(strict=True, ge=1, le=9)]
    """How many axes one POLY block may hold; fewer than six cannot carry a hexapod's motion."""
    poly_block_ms: Positive
    """Longest POLY block. Shorter blocks leave the controller less to decide, and cost it more of them a second."""
    poly_tolerance_mm: Positive
    """How far POLY blocks may be from a motion that no polynomial of their degree describes: positions."""
    poly_tolerance_deg: Positive
    """The same for angles."""
    contour_tolerance_mm: Positive
    """CTOL of the compressor."""
    orientation_tolerance_deg: Positive
    """OTOL of the compressor."""
    trigger_output: Annotated[int, Field(strict=True, ge=1, le=1024)]
    """Number of the digital output $A_OUT that a synchronised action switches."""
    shortest_block_ms: Positive
    """The controller's block cycle time: shorter blocks starve it."""
    most_blocks: Annotated[int, Field(strict=True, ge=10)]
    """What its program memory holds."""
    controller_keeps: Promises
    """Limits that the controller keeps by itself in what it times; what is not named here is `NOT enforced`."""
    ptp: PointToPointDrives | None = None
    """Drives in moves under `PTP`, which only `hexcite post --ptp-struts` writes; without it they are refused."""

    @model_validator(mode="after")
    def _polynomials_at_all(self) -> "Sinumerik":
        if self.moves == "poly" and self.path != "poly":
            raise ValueError("moves = 'poly' needs path = 'poly'; set both, or moves = 'feed'")
        return self

    @property
    def poly_block(self) -> float:
        """Longest POLY block [s]."""
        return self.poly_block_ms * MS

    @property
    def poly_tolerance(self) -> tuple[float, float]:
        """Of positions [m] and angles [rad]."""
        return self.poly_tolerance_mm * MM, self.poly_tolerance_deg * DEG

    @property
    def shortest_block(self) -> float:
        """Shortest block [s]."""
        return self.shortest_block_ms * MS
