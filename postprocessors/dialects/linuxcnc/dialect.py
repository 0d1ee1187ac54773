"""LinuxCNC: axes in mm and degrees, the pose of a platform or the joints of a chain: its functions as a value."""

from cases.controller import ControllerName
from postprocessors.dialects.dialect import Dialect
from postprocessors.dialects.linuxcnc.promises import linuxcnc_guarantees
from postprocessors.dialects.linuxcnc.read import read_linuxcnc
from postprocessors.dialects.linuxcnc.write import prepare_linuxcnc, write_linuxcnc

LINUXCNC = Dialect(
    ControllerName.LINUXCNC,
    (".ngc",),
    write_linuxcnc,
    read_linuxcnc,
    linuxcnc_guarantees,
    prepare=prepare_linuxcnc,
)
