"""What the case's controllers need to be told; anything uncertain is a required setting, never a guess."""

from cases.parts import Part, Positive
from cases.units import MINUTE, MM, MS


class LinuxCnc(Part):
    """Settings of the LinuxCNC configuration that is generated from the case."""

    acceleration_headroom: Positive
    """The controller's acceleration limits as a multiple of `[limits.motion]`. LinuxCNC has no look-ahead for paths
    that turn: at 1 it stretches dense paths; far above 1 it keeps the program's time, and the program's proof is
    what keeps the limits."""


class Controller(Part):
    """Settings of programs."""

    block_ms: Positive
    safe_feed_mm_min: Positive
    settle_s: Positive
    linuxcnc: LinuxCnc

    @property
    def block(self) -> float:
        """Duration of a block on a timed path [s]."""
        return self.block_ms * MS

    @property
    def safe_feed(self) -> float:
        """Feed of the first move to home [m/s]."""
        return self.safe_feed_mm_min * MM / MINUTE
