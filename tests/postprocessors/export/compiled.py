"""The exported C, compiled and called from Python."""

import ctypes
import subprocess
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from identification.results.result import Result
from postprocessors.export.code import RING, c_sources

Array = NDArray[np.float64]
Six = ctypes.c_double * 6
STRICT = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", "-Wconversion", "-Wshadow"]
SYSTEM_PATH = "/usr/bin:/bin:/usr/sbin:/sbin"  # halcompile belongs to the system's Python, not to ours
OK, BAD_INPUT, NOT_CLOSED, FILLING = range(4)


def structures(width: int) -> tuple[type[ctypes.Structure], type[ctypes.Structure]]:
    """What the signal chain gives, and the chain itself, for so many positions a cycle."""
    positions = ctypes.c_double * width

    class Sample(ctypes.Structure):
        _fields_ = [*((name, positions) for name in ("position", "velocity", "acceleration")), ("force", Six)]

    class Signals(ctypes.Structure):
        _fields_ = [
            ("step", ctypes.c_double),
            ("half", ctypes.c_int),
            ("motion_late", ctypes.c_int),
            ("motion_part", ctypes.c_double),
            ("force_late", ctypes.c_int),
            ("force_part", ctypes.c_double),
            ("filled", ctypes.c_int),
            ("next", ctypes.c_int),
            ("position", positions * RING),
            ("force", Six * RING),
        ]

    return Sample, Signals


class Compiled:
    """A model in use."""

    def __init__(self, calibration: Result, folder: Path, name: str = "hexapod_force") -> None:
        header, source = c_sources(calibration, name)
        (folder / f"{name}.h").write_text(header, encoding="ascii")
        (folder / f"{name}.c").write_text(source, encoding="ascii")
        library = folder / f"{name}.so"
        command = ["gcc", *STRICT, "-O2", "-shared", "-fPIC", "-o", str(library), str(folder / f"{name}.c"), "-lm"]
        done = subprocess.run(command, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        count = len(calibration.model.names)

        class Model(ctypes.Structure):
            _fields_ = [
                ("parameters", ctypes.c_double * count),
                ("pose", Six),
                ("residuals", Six),
                ("steps", ctypes.c_int),
                ("tare_sum", Six),
                ("tare_count", ctypes.c_long),
            ]

        self.library = ctypes.CDLL(str(library))
        self.name = name
        self.model = Model()
        self.external = Six()
        self("init")

    def __call__(self, function: str, *arguments: object) -> int:
        """Calls a function of the model; arrays are copied in."""
        passed = [(ctypes.c_double * len(a))(*a) if isinstance(a, np.ndarray) else a for a in arguments]
        call = getattr(self.library, f"{self.name}_{function}")
        return int(call(ctypes.byref(self.model), *passed) or 0)

    def wrench(self, function: str, *arguments: Array) -> Array:
        """External force and moment."""
        assert self(function, *arguments, self.external) == OK
        return np.array(self.external)

    def struts_of_drives(self, drives: Array, order: int) -> Array:
        """Strut lengths or their derivatives."""
        struts = Six()
        getattr(self.library, f"{self.name}_struts_of_drives")(Six(*drives), ctypes.c_int(order), struts)
        return np.array(struts)

    @property
    def steps(self) -> int:
        """Of the forward kinematics in the latest call."""
        return int(self.model.steps)


class Chain:
    """The signal chain of a compiled model."""

    def __init__(self, compiled: Compiled, step: float, half_window: float, delay: float, width: int = 6) -> None:
        self.library, self.name = compiled.library, compiled.name
        sample, signals = structures(width)
        self.signals, self.sample = signals(), sample()
        start = getattr(self.library, f"{self.name}_signals_init")
        settings = (ctypes.c_double(v) for v in (step, half_window, delay))
        self.status = int(start(ctypes.byref(self.signals), *settings))

    def push(self, position: Array, force: Array) -> int:
        """One cycle; the result is in `sample`."""
        push = getattr(self.library, f"{self.name}_signals_push")
        return int(
            push(
                ctypes.byref(self.signals),
                (ctypes.c_double * len(position))(*position),
                Six(*force),
                ctypes.byref(self.sample),
            )
        )


def build_component(source: Path) -> Path:
    """Compiles a HAL component to a realtime module beside it."""
    command = ["halcompile", "--compile", source.name]
    subprocess.run(command, cwd=source.parent, env={"PATH": SYSTEM_PATH, "LC_ALL": "C"}, check=True, timeout=120.0)
    return source.with_suffix(".so")
