"""A hypothesis of what is wrong with a run or its case: what it changes, in words, and what to write where it is right.

Every hypothesis changes the forces as recorded, the drives as recorded, or the case, or two of them; so can be tried
what several of them do together.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Literal, NamedTuple

import numpy as np

from cases.base.phrases import NOTHING, Phrase
from cases.base.units import Array
from cases.schema import Case
from identification.recording.recording import Recording


class Family(StrEnum):
    """What hypotheses are about, in words for the list of those that were tried; first what concerns the recording."""

    CLOCK = "clocks"
    ORIENTATION = "conventions of the orientation"
    UNITS = "units"
    CHANNELS = "exchanged, shifted and turned force channels"
    GAINS = "scales of single channels"
    DRIVES = "exchanged and shifted {drives}"
    AXES = "a wrench in the axes of the base"
    POINT = "moments about another point"
    COMPENSATED = "a compensated wrench"
    SENSOR = "a sensor that is turned"
    SIGNS = "signs of {drives}"
    OFFSETS = "offsets of {drives}"
    GRAVITY = "gravity"
    MACHINE = "rings, joints and home of the hexapod"
    BARS = "rings and ends of bars"
    LEAPS = "an offset that leaps"


FAMILIES = tuple(Family)
# a recorder changes channels after a controller turned the wrench into the axes of the base, a sensor before
RECORDED, SENSED = FAMILIES[: FAMILIES.index(Family.AXES)], FAMILIES[FAMILIES.index(Family.AXES) :]


class Affine(NamedTuple):
    """Drives from recorded drives: matrix times them, and an offset."""

    matrix: Array  # shape (d, d)
    offset: Array  # shape (d,) [m or rad]

    def after(self, first: "Affine") -> "Affine":
        """This one of what another one gives."""
        return Affine(self.matrix @ first.matrix, self.matrix @ first.offset + self.offset)

    def of(self, drives: Array) -> Array:
        """Drives, shape (n, d)."""
        return np.asarray(drives @ self.matrix.T + self.offset)


Edit = Callable[[Case], Case]


class Size(NamedTuple):
    """The size of a hypothesis, as it was found."""

    values: Array  # shape (k,)
    nudges: Array  # changes that residuals show well and follow in proportion, shape (k,); 0 of what stays
    # the hypothesis of another size; with standard deviations of the numbers that its words state, where they are known
    make: "Callable[[Array, Sequence[float] | None], Hypothesis | None]"
    stated: Callable[[Array], Array]  # the numbers that words state of a size, in the units that these have, shape (j,)

    @property
    def free(self) -> list[int]:
        """Which of the values were found."""
        return [int(k) for k in np.flatnonzero(self.nudges)]


@dataclass(frozen=True, slots=True, kw_only=True)
class Hypothesis:
    """One thing that may be wrong."""

    family: Family
    words: Phrase  # what is wrong, a clause
    # how many things are wrong then: of equal hypotheses of a family the one with the fewest is named
    mistakes: float = 1.0
    size: Size | None = None  # that was found where it leaves least
    single: bool = False  # whether it is tried alone only, as one of many that several mistakes at once would make
    # the keys that mend it, as another case; None where no key does
    edit: Edit | None = None
    # where the mistake is: `recording`, so that the edit has its effect when files are read; `case`, so that forces are
    # to be computed from the edited case; `either`, so that the edited case does what channels and drives below do
    place: Literal["recording", "case", "either"] = "recording"
    remedy: Phrase = NOTHING  # what to do where no key mends it, or beside it
    channels: Array | None = None  # recorded forces are multiplied by it, shape (6, 6)
    drives: Affine | None = None
    pace: float = 1.0  # true seconds in a second of the recording
    in_base: bool = False  # whether recorded forces are in the axes of {B}
    # recordings that no affine map of the drives makes; None where the change does not apply to a recording
    recorded: Callable[[Recording, Case], Recording | None] | None = None


Trial = tuple[Hypothesis, ...]
"""Hypotheses that are tried together, in the order of their families; none of them: all is as recorded."""
AS_RECORDED: Trial = ()


def together(*hypotheses: Hypothesis) -> Trial:
    """Hypotheses in the order in which they take effect: what concerns the recording first.

    Within a family too: a sign that the case may turn is that of the channel behind an exchange of columns.
    """
    return tuple(sorted(hypotheses, key=lambda each: (FAMILIES.index(each.family), each.place != "recording")))


def mistakes(trial: Trial) -> float:
    """How many things are wrong where all of a trial is right."""
    return sum(hypothesis.mistakes for hypothesis in trial)


def channels_of(trial: Trial, families: Sequence[Family] = FAMILIES) -> Array:
    """What hypotheses of some families multiply recorded forces by, shape (6, 6)."""
    matrix = np.eye(6)
    for hypothesis in trial:
        if hypothesis.channels is not None and hypothesis.family in families:
            matrix = hypothesis.channels @ matrix
    return matrix


def drives_of(trial: Trial, count: int) -> Affine:
    """Drives of a machine with so many of them from the recorded ones."""
    affine = Affine(np.eye(count), np.zeros(count))
    for hypothesis in trial:
        if hypothesis.drives is not None:
            affine = hypothesis.drives.after(affine)
    return affine


def pace_of(trial: Trial) -> float:
    """True seconds in a second of the recording."""
    return float(np.prod([hypothesis.pace for hypothesis in trial]))


def case_of(trial: Trial, case: Case, places: Sequence[str] = ("recording", "case", "either")) -> Case:
    """The case with the edits of hypotheses whose mistakes are in some places.

    What was read is mended in the order in which it takes effect. Frames and axes are nested the other way: what takes
    effect last on a reading, as a turn of the sensor, is nearest to the machine that the case describes.
    """
    read = [hypothesis for hypothesis in trial if hypothesis.place == "recording"]
    drawn = [hypothesis for hypothesis in trial if hypothesis.place != "recording"]
    drawn.sort(key=lambda hypothesis: -FAMILIES.index(hypothesis.family))
    for hypothesis in (*read, *drawn):
        if hypothesis.edit is not None and hypothesis.place in places:
            case = hypothesis.edit(case)
    return case
