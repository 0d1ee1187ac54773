"""What trials explain a run: those that leave what noise makes, and of those that are alike the simplest.

A trial explains a run where it leaves what noise makes and removes nearly all that is above it; what leaves as little
is named beside it, for it predicts the same forces.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from identification.findings.causes.hypothesis import FAMILIES, Family, Trial, mistakes
from identification.findings.causes.instants import Instants
from identification.findings.causes.trials import ResidualForces, residual_forces

NEAR = 3.0  # times what noise makes of the residuals, up to which they are explained
REMOVED = 0.02  # share of what is above the noise, squared, that an explanation leaves at most
ALIKE = 1.15  # ratio of residuals up to which trials predict the same forces
SAME = 1.03  # the same within a family, of which the simplest is named
WORSE = 1.5  # ratio of residuals by which two mistakes must explain a run better than one
CLEAN = 1.3  # times the noise, above which a second mistake is looked for beside one that explains a run
MODERATE = 8.0  # times the noise, up to which residuals are often noise with memory, or of the structure
LOWERED = 0.7  # share of such residuals that a hypothesis leaves which may be one of two mistakes
SIMPLER = 0.75  # mistakes fewer, by which one of those that are alike is named alone
ROUNDING = 1e-9  # of residuals that are the same
LEVEL = 0.3  # of the measured noise: differences between smaller residuals say nothing


@dataclass(frozen=True, slots=True)
class Tried:
    """A trial and what it leaves."""

    trial: Trial
    instants: Instants  # it was tried on
    residuals: float  # over the noise
    delay: float  # [s]

    @property
    def comparable(self) -> float:
        """Residuals over the noise without differences that say nothing, and as if two mistakes left more than one."""
        level = LEVEL * float(np.mean(self.instants.least / self.instants.noise))
        return float(np.hypot(self.residuals, level)) * WORSE ** (len(self.trial) - 1)

    def residual_forces(self) -> ResidualForces:
        """The same in newtons."""
        return residual_forces(self.instants, self.trial, self.delay)


def explanations(found: Sequence[Tried], recorded: Tried | None, flexible: float = 1.0) -> tuple[Tried, ...]:
    """Those of some trials that explain the run, alike, one of each family, the best first.

    Args:
        found: the trials.
        recorded: all as recorded.
        flexible: share of `NEAR` up to which two mistakes explain of which one has a size, found beside the other.
    """
    before = np.inf if recorded is None else recorded.residuals
    better = [entry for entry in found if entry.trial and entry.residuals < before / 2.0]
    if not better:
        return ()
    best = min(better, key=lambda entry: entry.residuals)
    noise = 1.0 if best.residuals <= most_left(before) and best.residuals <= NEAR else _noise_of(best)
    most = min(NEAR * noise, most_left(before, noise))
    less = min(flexible * NEAR * noise, most)
    explaining = [entry for entry in better if entry.residuals <= (less if _flexible(entry) else most)]
    if not explaining:
        return ()
    least = min(entry.comparable for entry in explaining)
    alike = [entry for entry in explaining if entry.comparable <= ALIKE * least]
    simplest: list[Tried] = []
    for families in dict.fromkeys(families_of(entry) for entry in alike):
        same_families = [entry for entry in alike if families_of(entry) == families]
        lowest = min(entry.comparable for entry in same_families)
        same = [entry for entry in same_families if entry.comparable <= SAME * lowest]
        one = min(same, key=lambda entry: (mistakes(entry.trial), entry.residuals))
        simplest += [entry for entry in same if entry is one or _equal(entry, one)]
    fewest = min(mistakes(entry.trial) for entry in simplest)
    plain = [entry for entry in simplest if mistakes(entry.trial) < fewest + SIMPLER]
    return tuple(sorted(plain, key=lambda entry: (mistakes(entry.trial), FAMILIES.index(entry.trial[0].family))))


def may_hide_another(explanation: Tried) -> bool:
    """Whether a single hypothesis leaves more than what noise makes, so that there may be a second mistake."""
    return bool(explanation.residuals > CLEAN * _noise_of(explanation))


def may_be_two(found: Sequence[Tried], recorded: Tried | None) -> bool:
    """Whether residuals are so large, or one hypothesis lowers them so much, that two mistakes may have made them."""
    if recorded is None or recorded.residuals > MODERATE:
        return True
    return min((entry.residuals for entry in found), default=np.inf) < LOWERED * recorded.residuals


def is_noise(entry: Tried) -> bool:
    """Whether residuals are what the noise of forces and of drives makes."""
    if entry.residuals <= NEAR:
        return True
    return bool(np.isfinite(entry.residuals) and entry.residuals <= NEAR * _noise_of(entry))


def _flexible(entry: Tried) -> bool:
    """Whether two mistakes at once, one of any size, follow much that neither of them made."""
    return len(entry.trial) > 1 and any(hypothesis.size is not None for hypothesis in entry.trial)


def most_left(before: float, noise: float = 1.0) -> float:
    """Residuals over the noise that an explanation leaves at most, of those that the run has as it was recorded.

    Args:
        before: those residuals.
        noise: what noise of forces and drives makes, over that of the forces.
    """
    return float(np.sqrt(noise**2 + REMOVED * max(before**2 - noise**2, 0.0)))


def _noise_of(entry: Tried) -> float:
    """What noise of the forces and of the recorded drives makes of a trial, over that of the forces."""
    return float(np.hypot(1.0, entry.residual_forces().shaking))


def _equal(one: Tried, other: Tried) -> bool:
    """Whether two trials are two words for one thing, as far as anybody can see."""
    equal = abs(one.residuals - other.residuals) <= ROUNDING * other.residuals
    return equal and mistakes(one.trial) == mistakes(other.trial)


def families_of(entry: Tried) -> tuple[Family, ...]:
    """The family of each hypothesis of a trial."""
    return tuple(hypothesis.family for hypothesis in entry.trial)
