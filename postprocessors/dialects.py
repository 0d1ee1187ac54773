"""The languages of controllers: who writes and reads them, and what their controllers answer for. Loaded when used."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from cases.errors import HexciteError, ProgramError
from cases.schema import Case
from identification.motion import Array
from postprocessors.guarantees import Guarantees
from postprocessors.program import Program
from postprocessors.reading.words import Reading


@dataclass(frozen=True, slots=True)
class Language:
    """What a dialect can do.

    Args:
        write: program and case -> content of the file.
        read: content, name for messages, case -> what it says; shares nothing with `write`; raises ProgramError with
            line and column at anything that it does not understand.
        guarantees: what the controller answers for when it runs a program that was read.
        tolerance: how far its paths may be off the plan beside rounding, shape (6,) [m, rad].
    """

    write: Callable[[Program, Case], bytes]
    read: Callable[[bytes, str, Case], Reading]
    guarantees: Callable[[Reading, Case], Guarantees]
    tolerance: Callable[[Case], Array] = lambda case: np.zeros(6)


@dataclass(frozen=True, slots=True)
class Dialect:
    """A controller's language.

    Args:
        name: on the command line.
        description: one line for people.
        suffixes: of its files, in lower case, the usual one first.
        load: imports and returns what it can do.
    """

    name: str
    description: str
    suffixes: tuple[str, ...]
    load: Callable[[], Language]

    @property
    def suffix(self) -> str:
        """The usual suffix."""
        return self.suffixes[0]


def _linuxcnc() -> Language:
    from postprocessors.execute.linuxcnc.guarantees import linuxcnc_guarantees
    from postprocessors.linuxcnc import write_linuxcnc
    from postprocessors.reading.linuxcnc import read_linuxcnc_bytes

    return Language(
        lambda program, case: write_linuxcnc(program, case).encode("ascii"), read_linuxcnc_bytes, linuxcnc_guarantees
    )


def _sinumerik() -> Language:
    from postprocessors.promises import sinumerik_guarantees, sinumerik_tolerance
    from postprocessors.reading.sinumerik import read_sinumerik
    from postprocessors.sinumerik import write_sinumerik

    return Language(write_sinumerik, read_sinumerik, sinumerik_guarantees, sinumerik_tolerance)


def _twincat() -> Language:
    from postprocessors.promises import twincat_guarantees
    from postprocessors.reading.twincat import read_twincat
    from postprocessors.twincat import write_twincat

    return Language(write_twincat, read_twincat, twincat_guarantees)


DIALECTS = {
    d.name: d
    for d in (
        Dialect(
            "linuxcnc",
            "LinuxCNC 2.9: G1 with exact stop, dense G93 paths, arcs; runs here with `hexcite run --on linuxcnc`",
            (".ngc",),
            _linuxcnc,
        ),
        Dialect(
            "sinumerik",
            "SINUMERIK 840D sl / ONE: G1 with exact stop, POLY blocks or the compressor, arcs",
            (".mpf",),
            _sinumerik,
        ),
        Dialect(
            "twincat",
            "TwinCAT CNC (TF5200) and ISG: G01 with exact stop, #SPLINE, #HSC or #CONTOUR MODE, arcs",
            (".nc", ".cnc"),
            _twincat,
        ),
    )
}


def dialect(name: str) -> Dialect:
    """The dialect of a name.

    Raises:
        HexciteError: unknown; the message lists the known ones.
    """
    if name not in DIALECTS:
        raise HexciteError(f"dialect {name!r} is unknown; choose {', '.join(DIALECTS)}")
    return DIALECTS[name]


def dialect_of_file(file: str) -> Dialect:
    """The dialect that a program's file name says.

    Raises:
        ProgramError: no dialect has this suffix.
    """
    for known in DIALECTS.values():
        if file.lower().endswith(known.suffixes):
            return known
    suffixes = ", ".join(s for d in DIALECTS.values() for s in d.suffixes)
    raise ProgramError(file, 0, 0, f"the suffix names no controller; programs end in {suffixes}")
