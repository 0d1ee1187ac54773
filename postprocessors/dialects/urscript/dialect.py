"""URScript of Universal Robots: its functions as a value."""

from cases.controller import ControllerName
from postprocessors.dialects.dialect import Dialect
from postprocessors.dialects.urscript.promises import urscript_guarantees
from postprocessors.dialects.urscript.read import read_urscript
from postprocessors.dialects.urscript.write import write_urscript

URSCRIPT = Dialect(
    ControllerName.URSCRIPT,
    (".script",),
    write_urscript,
    read_urscript,
    urscript_guarantees,
)
