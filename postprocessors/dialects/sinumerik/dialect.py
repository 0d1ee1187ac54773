"""SINUMERIK 840D sl and ONE: its functions as a value."""

from cases.controller import ControllerName
from postprocessors.dialects.dialect import Dialect
from postprocessors.dialects.sinumerik.promises import sinumerik_guarantees
from postprocessors.dialects.sinumerik.read import read_sinumerik
from postprocessors.dialects.sinumerik.write import prepare_sinumerik, write_sinumerik

SINUMERIK = Dialect(
    ControllerName.SINUMERIK,
    (".mpf",),
    write_sinumerik,
    read_sinumerik,
    sinumerik_guarantees,
    prepare=prepare_sinumerik,
)
