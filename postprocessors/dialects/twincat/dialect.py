"""TwinCAT CNC (TF5200) and other ISG kernels: its functions as a value."""

from cases.controller import ControllerName
from postprocessors.dialects.dialect import Dialect
from postprocessors.dialects.twincat.promises import twincat_guarantees
from postprocessors.dialects.twincat.read import read_twincat
from postprocessors.dialects.twincat.write import write_twincat

TWINCAT = Dialect(
    ControllerName.TWINCAT,
    (".nc", ".cnc"),
    write_twincat,
    read_twincat,
    twincat_guarantees,
)
