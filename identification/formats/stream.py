"""What files of a run become: streams in SI units, each of channels that share a clock."""

from dataclasses import dataclass, field
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from cases.units import Array
from identification.formats.table import Lines, uniform_step

Channel = Literal["struts", "rotations", "forces", "trigger", "poses", "specific_forces", "override", "temperature"]
CHANNELS: tuple[Channel, ...] = get_args(Channel)
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
    override: Array | None = None  # override of the feed, shape (n,); 1 for 100 %
    temperature: Array | None = None  # of the sensor, shape (n,) [degC]
    lines: Lines = field(default_factory=Lines)  # where the rows stand in the file
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
