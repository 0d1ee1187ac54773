"""Poses of a case: the table `[poses]` of quasi-static measurement, and moves and poses made by hand, from files.

The grid of candidate poses, what counts as a valid pose, and how long it is measured; a chain has no grid: its poses
are searched for in the box of `[limits.motion]`. A hand-made excitation is data too: straight moves, full
circles and pauses, one after the other.
"""

import math
from collections.abc import Sequence
from functools import cached_property
from pathlib import Path
from typing import Annotated, ClassVar, Literal

import numpy as np
from pydantic import Field, model_validator

from cases.errors import FileProblem
from cases.loading import read_tables
from cases.machine import POSE, Grid, Number, Part, Positive, Range, frozen, own_units, si
from cases.units import Array

GRID = ("x_mm", "y_mm", "z_mm", "tilt_deg", "azimuth_deg", "torsion_deg")


class Poses(Part):
    """How long poses are measured, and of a hexapod the grid of candidates; a chain's lie in `[limits.motion]`.

    Tilt-and-torsion angles, R = Rz(azimuth) Ry(tilt) Rz(torsion - azimuth); positions relative to home.
    """

    settle_s: Positive
    """Waited at each pose before averaging begins."""
    average_s: Positive
    """Averaged at each pose."""
    x_mm: Grid | None = None
    """Grid of positions relative to home: [first, last, step]; a hexapod needs it, and all below."""
    y_mm: Grid | None = None
    """As `x_mm`."""
    z_mm: Grid | None = None
    """As `x_mm`."""
    radius_mm: Range | None = None
    """Distance from home in the XY plane: grid points outside are left out."""
    tilt_deg: Grid | None = None
    """Grid of tilts: [first, last, step]."""
    azimuth_deg: Grid | None = None
    """Grid of the tilts' directions: [first, last, step]."""
    torsion_deg: Grid | None = None
    """Grid of turns about the tilted z axis: [first, last, step]."""
    singularity_distance: Annotated[float, Field(strict=True, gt=0, lt=1)] | None = None
    """Smallest determinant of the machine's inverse Jacobian, as a share of that at home."""

    radius: ClassVar = si("radius_mm")
    """Smallest and largest distance from home in the XY plane, shape (2,) [m]."""

    @cached_property
    def axes(self) -> tuple[Array, ...]:
        """Grid values of x, y and z relative to home [m], and of tilt, azimuth and torsion [rad]."""
        return tuple(
            frozen((getattr(self, key)[0] + getattr(self, key)[2] * np.arange(self._count(key))) * own_units([key]))
            for key in GRID
        )

    @property
    def grid_size(self) -> int:
        """Points of the grid before any is left out."""
        return math.prod(map(self._count, GRID))

    def _count(self, key: str) -> int:
        first, last, step = getattr(self, key)
        return int(np.floor((last - first) / step + 1e-9)) + 1


MOST_STEPS = 1000


class ManualStep(Part):
    """A straight move to a pose relative to home, a full circle, or a pause."""

    x_mm: Number = 0.0
    y_mm: Number = 0.0
    z_mm: Number = 0.0
    a_deg: Number = 0.0
    b_deg: Number = 0.0
    c_deg: Number = 0.0
    circle: Literal["XY", "ZX", "YZ"] | None = None
    """A full circle in this plane; its centre lies at `radius_mm` from its start, against the plane's first axis."""
    radius_mm: Positive | None = None
    pause_s: Positive | None = None
    speed: Annotated[float, Field(strict=True, gt=0.0, le=1.0)] = 1.0
    """Share of the limits of velocity; accelerations take its square, jerks its cube."""

    @model_validator(mode="after")
    def _one_kind(self) -> "ManualStep":
        fields = self.model_fields_set
        pose = fields & set(POSE)
        if (self.circle is None) != (self.radius_mm is None):
            raise ValueError("a circle needs circle and radius_mm, a move neither")
        if sum((bool(pose), self.circle is not None, self.pause_s is not None)) > 1:
            raise ValueError("a step is a move, a circle or a pause, not several; make separate steps")
        return self

    offset: ClassVar = si(*POSE)
    """Pose relative to home, shape (6,) [m, rad]."""


class Steps(Part):
    """A hand-made excitation: it begins and ends standing at home."""

    title: str
    steps: Annotated[tuple[ManualStep, ...], Field(min_length=1, max_length=MOST_STEPS)]


_WANTED = "name a TOML file of steps or a CSV of poses"


def load_sequence(file: Path, columns: Sequence[str] = POSE) -> Steps:
    """Reads a sequence from a TOML file, for a machine whose coordinates, `columns`, are the pose of a platform.

    Raises:
        FileProblem: it is not there, or the machine has other coordinates.
        CaseError: it describes no sequence; the message names the step.
    """
    if tuple(columns) != POSE:
        raise FileProblem(file, "holds steps of a platform", f"name a CSV of poses with {', '.join(columns)}")
    if not file.exists():
        raise FileProblem(file, "cannot be read (No such file or directory)", _WANTED)
    return read_tables(Steps, file)


def load_poses(file: Path, columns: Sequence[str] = POSE) -> Array:
    """Reads poses from a CSV file with a column for each coordinate: of a platform absolute in {B}, or of joints.

    Shape (n, columns) [m or rad]; names of columns end in mm or deg.

    Raises:
        FileProblem: it cannot be read, columns are missing, or a row holds no numbers.
    """
    try:
        lines = file.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise FileProblem(file, f"cannot be read ({error})", _WANTED) from error
    rows = [line.split(",") for line in lines if line.strip() and not line.startswith("#")]
    header = [cell.strip() for cell in rows[0]] if rows else []
    missing = [c for c in columns if c not in header]
    if missing:
        raise FileProblem(file, f"column {missing[0]} is missing", f"the first line must name {', '.join(columns)}")
    if not 1 <= len(rows) - 1 <= MOST_STEPS:
        raise FileProblem(file, f"holds {len(rows) - 1} poses", f"1 to {MOST_STEPS} make an excitation")
    poses = []
    for number, row in enumerate(rows[1:], start=1):
        try:
            values = [float(row[header.index(c)]) for c in columns]
        except (ValueError, IndexError):
            values = [float("nan")]
        if not np.isfinite(values).all():
            raise FileProblem(file, f"pose {number} holds no {len(columns)} numbers", "mend that line")
        poses.append(values)
    return np.asarray(np.array(poses) * own_units(columns))
