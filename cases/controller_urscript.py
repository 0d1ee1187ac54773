"""What a URScript program needs to be told."""

from typing import Annotated

from pydantic import Field

from cases.parts import Part


class UrScript(Part):
    """Settings of programs for robots of Universal Robots."""

    program_name: Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_]{0,30}$")]
    """Of the function that the program is: letters, digits and underscores."""
    trigger_output: Annotated[int, Field(strict=True, ge=0, le=7)]
    """Standard digital output that is on while the excitation runs; RTDE records it with the robot's clock."""
