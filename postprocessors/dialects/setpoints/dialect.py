"""Tables of setpoints, one row a control cycle: its functions as a value."""

from cases.controller import ControllerName
from postprocessors.dialects.dialect import Dialect
from postprocessors.dialects.setpoints.promises import setpoint_guarantees
from postprocessors.dialects.setpoints.read import read_setpoints
from postprocessors.dialects.setpoints.write import require_same_table, write_setpoints

SETPOINTS = Dialect(
    ControllerName.SETPOINTS,
    (".csv",),
    write_setpoints,
    read_setpoints,
    setpoint_guarantees,
    same=require_same_table,
    start="the machine must stand at home when the table starts",
)
