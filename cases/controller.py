"""What the case's controllers need to be told; anything uncertain is a required setting, never a guess."""

from typing import Annotated, Literal, TypeVar

from pydantic import Field

from cases.controller_setpoints import Setpoints
from cases.controller_sinumerik import Sinumerik
from cases.controller_twincat import TwinCat
from cases.errors import CaseError
from cases.parts import Part, Positive
from cases.units import MINUTE, MM, MS

Settings = TypeVar("Settings", "LinuxCnc", Sinumerik, TwinCat, Setpoints)


class LinuxCnc(Part):
    """Settings of the LinuxCNC configuration that is generated from the case."""

    acceleration_headroom: Positive
    """The controller's acceleration limits as a multiple of `[limits.motion]`. LinuxCNC has no look-ahead for paths
    that turn: at 1 it stretches dense paths; far above 1 it keeps the program's time, and the program's proof is
    what keeps the limits."""


class Controller(Part):
    """Settings of programs."""

    block_ms: Positive
    """Duration of the blocks that a dense path is written in."""
    safe_feed_mm_min: Positive | None = None
    """Feed of the first move of a hexapod, from wherever the machine stands to home."""
    safe_speed_percent: Annotated[Positive, Field(le=100.0)] = 10.0
    """Of the speeds and accelerations of `[limits.motion]`: the first move of a chain, from wherever it stands."""
    settle_s: Positive
    """Stood still before the trigger goes on and after it went off."""
    cycle_ms: Positive = 1.0
    """The controller's interpolation cycle. Phases of planned moves last three of them or more."""
    virtual_look_ahead: Literal["exact", "block_limited"] = "exact"
    """How the virtual controller follows timed paths: as written, or without look-ahead, so that it could come to rest
    at the end of each block, and with corners rounded as far as the program's controller may (LinuxCNC on paths that
    turn, under the limits of `[limits.motion]`)."""
    plan_for: Literal["linuxcnc", "virtual", "sinumerik", "twincat", "setpoints"] | None = None
    """The controller whose time law point-to-point plans are made for (`hexcite plan --for`). Without it all limits of
    `[limits.motion]` count, those of jerk too."""
    linuxcnc: LinuxCnc | None = None
    """Programs with timed blocks run under this multiple of the acceleration limits: 1 stretches dense paths, far above
    1 they keep their time, and nobody but the program keeps the limits."""
    sinumerik: Sinumerik | None = None
    twincat: TwinCat | None = None
    setpoints: Setpoints | None = None

    @property
    def cycle(self) -> float:
        """Interpolation cycle [s]."""
        return self.cycle_ms * MS

    @property
    def block(self) -> float:
        """Duration of a block on a timed path [s]."""
        return self.block_ms * MS

    @property
    def safe_feed(self) -> float:
        """Feed of the first move of a hexapod to home [m/s]; its case states one."""
        assert self.safe_feed_mm_min is not None
        return self.safe_feed_mm_min * MM / MINUTE

    @property
    def safe_share(self) -> float:
        """Share of the limits of motion that the first move of a chain may use."""
        return self.safe_speed_percent / 100.0

    def need_linuxcnc(self, case: str) -> LinuxCnc:
        """Settings of LinuxCNC's programs; raises CaseError where the case has none."""
        return _needed(self.linuxcnc, case, "linuxcnc")

    def need_sinumerik(self, case: str) -> Sinumerik:
        """Settings of SINUMERIK programs; raises CaseError where the case has none."""
        return _needed(self.sinumerik, case, "sinumerik")

    def need_twincat(self, case: str) -> TwinCat:
        """Settings of TwinCAT programs; raises CaseError where the case has none."""
        return _needed(self.twincat, case, "twincat")

    def need_setpoints(self, case: str) -> Setpoints:
        """Settings of setpoint tables; raises CaseError where the case has none."""
        return _needed(self.setpoints, case, "setpoints")


def _needed(settings: Settings | None, case: str, name: str) -> Settings:
    if settings is None:
        problem = (
            f"is missing; the dialect {name} needs it: add the table to the case file, see cases/hexapod/case.toml"
        )
        raise CaseError(f"case {case}", f"controller.{name}", problem)
    return settings
