"""Programs for controllers, written, read back and proven, executed; and the calibrated model for the controller."""

from typing import TYPE_CHECKING

from cases.base.doors import door

if TYPE_CHECKING:
    from postprocessors.program import Program as Program
    from postprocessors.program import read_program as read_program

PUBLIC = {
    "Program": "postprocessors.program",
    "read_program": "postprocessors.program",
}
"""Public names, and the modules that they are imported from when they are first used."""
__getattr__, __dir__ = door(__name__, PUBLIC)
