"""What a SINUMERIK 840D sl / ONE with a hexapod transformation needs to be told; nothing of it can be guessed."""

from typing import Annotated, Literal

from pydantic import AfterValidator, Field, model_validator

from cases.controller_promises import Promises
from cases.controller_struts import PointToPointDrives
from cases.parts import Part, Positive
from cases.units import DEG, MM, MS

PROGRAM_NAME = r"^(?:[A-Z]{2}|_[A-Z])[A-Z0-9_]{0,22}$"
TRANSFORMATION = r"^[A-Z][A-Z0-9_]*(?:\([0-9](?:,[0-9])*\))?$"
_NOT_WORDS = set("FGHLMNPRSTXYZ")


def _angle_words(words: tuple[str, str, str]) -> tuple[str, str, str]:
    if len(set(words)) < 3 or _NOT_WORDS & set(words):
        raise ValueError(f"{', '.join(words)} do not name three angles; write the words for roll, pitch and yaw")
    return words


Word = Annotated[str, Field(pattern=r"^[A-Z][A-Z]*[0-9]?$", max_length=8)]
AngleWords = Annotated[tuple[Word, Word, Word], AfterValidator(_angle_words)]


class Sinumerik(Part):
    """Settings of SINUMERIK programs. The transformation of a hexapod is the machine builder's: ask for these words."""

    program_name: Annotated[str, Field(pattern=PROGRAM_NAME)]
    """Internal name: 2 to 24 capitals, digits and underscores that begin with two letters or `_` and a letter."""
    transformation: Annotated[str, Field(pattern=TRANSFORMATION)]
    """What switches the transformation on: `TRAORI`, `TRAORI(2)` or the builder's own name."""
    transformation_off: Annotated[str, Field(pattern=TRANSFORMATION)]
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
    poly_axes: Annotated[int, Field(strict=True, ge=1, le=9)]
    """How many axes one POLY block may hold; fewer than six cannot carry a hexapod's motion."""
    poly_block_ms: Positive
    """Longest POLY block. Shorter blocks leave the controller less to decide, and cost it more of them a second."""
    poly_tolerance_mm: Positive
    poly_tolerance_deg: Positive
    """How far POLY blocks may be from a motion that is no polynomial of their degree."""
    contour_tolerance_mm: Positive
    orientation_tolerance_deg: Positive
    """CTOL and OTOL of the compressor."""
    trigger_output: Annotated[int, Field(strict=True, ge=1, le=1024)]
    """Number of the digital output $A_OUT that a synchronised action switches."""
    shortest_block_ms: Positive
    """The controller's block cycle time: shorter blocks starve it."""
    most_blocks: Annotated[int, Field(strict=True, ge=10)]
    """What its program memory holds."""
    controller_keeps: Promises
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
