"""Runs that repeat themselves, on the simulated machine: rest at home, approach, periods, return."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from cases.schema import Case
from identification.hexapod import Hexapod
from identification.motion import Motion
from identification.recording import Recording
from identification.simulate import simulate_recording
from tests.helpers import Harmonic
from tests.simulated_machine import PoseExecution

LEAD = 0.4  # [s] before and after


@dataclass(frozen=True)
class Repeating:
    """A harmonic motion that goes on for some periods."""

    period: float = 2.0
    periods: float = 4.0
    seed: int = 0
    harmonic: Harmonic = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "harmonic", Harmonic(seed=self.seed, duration=self.period))

    @property
    def duration(self) -> float:
        return self.period * self.periods + 2 * LEAD

    def at(self, t: ArrayLike) -> Motion:
        return self.harmonic.at(t)


def recorded(case: Case, motion: Repeating, seed: int = 0) -> Recording:
    """With the trigger on for the whole periods."""
    window = np.array([[LEAD, LEAD + motion.period * motion.periods]])
    return simulate_recording(case, PoseExecution(Hexapod.of(case), motion), window, seed, "run.csv")
