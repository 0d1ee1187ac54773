"""A recorded run in SI units: streams of channels that share a clock, and the run that they make up."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal, NamedTuple, get_args

import numpy as np
from numpy.typing import NDArray

from cases.schema import Case
from cases.units import as_html
from identification.findings import Finding, Kind, note
from identification.formats.table import Array, Lines, lost_samples, uniform_step

Channel = Literal[
    "struts",
    "rotations",
    "forces",
    "trigger",
    "poses",
    "specific_forces",
    "override",
    "temperature",
]
CHANNELS: tuple[Channel, ...] = get_args(Channel)
_BELOW_A_HEADER = Lines()
Rows = NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class Stream:
    """Samples of one clock, one row a sample; arrays are None where there are no such channels."""

    source: str  # the file, for messages
    t: Array | None  # time since the first sample of the run, shape (n,) [s]; None: every row is an averaged standstill
    # what moves the sensors: strut lengths, shape (n, 6) [m]; of a chain its joints, shape (n, k) [m or rad]
    struts: Array | None
    rotations: Array | None  # R, shape (n, 3, 3)
    forces: Array | None  # forces of the sensors, shape (n, 6) [N, or N and N m]
    trigger: NDArray[np.bool_] | None  # shape (n,)
    poses: Array | None = None  # poses of {P} in {B}, shape (n, 6) [m, rad]
    specific_forces: Array | None = None  # acceleration less gravity, in the axes of {P}, shape (n, 3) [m/s^2]
    override: Array | None = None  # override of the feed, shape (n,); 1 is none
    temperature: Array | None = None  # of the sensor, shape (n,) [degC]
    lines: Lines = _BELOW_A_HEADER  # where the rows stand in the file
    # rows in which a value was not measured and stands for nothing, shape (n,); None: there are none
    missing: Rows | None = None
    missing_in: tuple[str, ...] = ()  # the columns in which they are, as the file calls them

    @property
    def channels(self) -> dict[Channel, Any]:
        """The arrays that are there, by name."""
        arrays = {name: getattr(self, name) for name in CHANNELS}
        return {name: array for name, array in arrays.items() if array is not None}

    @property
    def rows(self) -> int:
        """Number of samples."""
        return len(next(iter(self.channels.values()), ()))

    @property
    def step(self) -> float:
        """Time between samples [s]; raises RecordingError where there is no clock or it is not uniform."""
        return uniform_step(self.source, self.t, self.lines)


class Averaged(NamedTuple):
    """Forces that were averaged over the motion's sampling interval."""

    ratio: float  # samples of the forces in an interval
    interval: float  # interval of the motion [s]
    noise: Array  # noise of a sample, from the differences of neighbours, shape (6,) [N, or N and N m]

    @property
    def expected(self) -> Array:
        """Noise of an average below the motion's Nyquist frequency if that of the samples is white, shape (6,)."""
        return np.asarray(self.noise / np.sqrt(self.ratio))

    def finding(self, w: Array, s0: float) -> Finding:
        """The noise that is left beside that which white samples would leave.

        Args:
            w: W of (24) for one sample, shape (6, 6).
            s0: s0 of the fit.
        """
        expected = float(np.sqrt(np.trace(w @ np.diag(self.expected**2)) / 6.0))
        entries = {
            "ratio": self.ratio,
            "interval_s": self.interval,
            "sample_noise": self.noise.tolist(),
            "expected_noise": self.expected.tolist(),
        }
        return note(
            Kind.CLOCK,
            f"forces: {self.ratio:.4g} samples averaged for each of the motion ({self.interval * 1e3:.4g} ms, "
            f"centred: no group delay); noise of a sample {float(np.median(self.noise)):.3g} N; were it white, s0 "
            f"would be {expected:.3g}, it is {s0:.3g}",
            averaged=entries,
        )


@dataclass(frozen=True, slots=True, repr=False)
class Recording(Stream):
    """A run: the samples of the forces, with all channels of their clock, and streams of other clocks."""

    forces: Array  # forces of the sensors, shape (n, 6) [N, or N and N m]
    others: tuple[Stream, ...] = ()  # what was sampled by other clocks, on the same time axis
    # weights of averaged standstills: what forces and model of each are multiplied by in a fit, shape (n,)
    weights: Array | None = None
    averaged: Averaged | None = None  # how forces were averaged that were sampled faster than the motion
    case: Case | None = None  # case that it is of; None where that is not known
    paths: tuple[Path, ...] = ()  # paths of the files that it was read from
    record: Mapping[str, Any] = field(default_factory=dict)  # what `recording.json` says; empty where there is none

    def save(self, folder: Path | str, overwrite: bool = False) -> None:
        """Makes a folder with recording.csv and recording.json; numbers as in `identification.recording`."""
        from identification.recording import save_recording

        save_recording(self, Path(folder), overwrite)

    @classmethod
    def load(cls, folder: Path | str) -> "Recording":
        """The recording of a folder; see `identification.recording.load_recording`."""
        from identification.recording import load_recording

        return load_recording(Path(folder))

    def __repr__(self) -> str:
        """A few lines: where it is from, how long, which channels."""
        size = f"{len(self.forces)} samples"
        if self.t is not None and len(self.t) > 1:
            size += f" in {float(self.t[-1] - self.t[0]):.2f} s"
        lines = [f"Recording {self.source}: {size}", f"channels: {', '.join(self.channels)}"]
        lines += [f"with another clock: {', '.join(s.channels)} ({s.source})" for s in self.others]
        if "controller" in self.record:
            lines.append(f"executed on {self.record['controller']}; sensors and encoders are simulated")
        return "\n".join(lines)

    def _repr_html_(self) -> str:
        return as_html(repr(self))

    @property
    def lost(self) -> NDArray[np.int64]:
        """How many samples were lost between each row and the next, shape (n - 1,)."""
        return lost_samples(self.t)

    @property
    def streams(self) -> tuple[Stream, ...]:
        """All streams of the run, that of the forces first."""
        return self, *self.others

    def stream_with(self, channel: Channel) -> Stream | None:
        """The stream that has a channel; None where the run has no such channel."""
        return next((s for s in self.streams if channel in s.channels), None)


def either(one: Rows | None, other: Rows | None) -> Rows | None:
    """Rows that are marked in one of two, None standing for no rows at all."""
    if one is None or other is None:
        return other if one is None else one
    return one | other
