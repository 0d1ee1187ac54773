"""Known weights that are mounted on a machine one after the other, to validate an identification."""

from typing import Annotated

from pydantic import Field

from cases.parts import Part
from cases.sensors import RigidBody


class Payloads(Part):
    """Known weights that are mounted one after the other to validate an identification."""

    source: str
    """Where the values come from."""
    weights: Annotated[tuple[RigidBody, ...], Field(min_length=1)]
    """In order of mounting; centres of gravity in {P}."""
