"""What each command needs of a case, and what of it is missing."""

from collections.abc import Iterator, Mapping
from typing import NamedTuple

from cases.schema import Case

_MACHINE = ("machine", "workspace", "limits.motion")
_PLAN = (*_MACHINE, "nominal")
_PROGRAM = (*_MACHINE, "controller")
_RUN = (*_PROGRAM, "simulation", "recording.filter_cutoff_Hz")
NEEDS: Mapping[str, tuple[str, ...]] = {
    "plan": (*_PLAN, "controller"),
    "plan --family fourier": _PLAN,
    "poses": (*_PLAN, "poses"),
    "bound": _MACHINE,
    "retime": _PROGRAM,
    "post --dialect linuxcnc": (*_PROGRAM, "controller.linuxcnc"),
    "post --dialect sinumerik": (*_PROGRAM, "controller.sinumerik"),
    "post --dialect twincat": (*_PROGRAM, "controller.twincat"),
    "post --dialect setpoints": (*_PROGRAM, "controller.setpoints"),
    "run": _RUN,
    "identify a motion": ("recording.filter_cutoff_Hz",),
    "identify standstills, force, tare": (),
    "validate": (*_RUN, "nominal", "poses", "payloads"),
    "demo": (*_RUN, "nominal"),
}
"""Command -> the tables and keys of a case that it needs; a table that is named needs those around it too."""
_OF_A_MOVING_FRAME = frozenset(NEEDS) - {"identify standstills, force, tare"}


class Readiness(NamedTuple):
    """Whether a case has what a command needs.

    Args:
        command: as it is typed.
        missing: tables and keys that the case lacks, or why the command is not for it.
    """

    command: str
    missing: tuple[str, ...]


def readiness(case: Case) -> tuple[Readiness, ...]:
    """What each command misses in a case."""
    if case.setup == "1a":  # Figure 1: the sensor frame stands
        return tuple(
            Readiness(command, ("a sensor frame that moves (setup is 1a)",) if command in _OF_A_MOVING_FRAME else ())
            for command in NEEDS
        )
    return tuple(Readiness(name, tuple(_missing(case, keys))) for name, keys in NEEDS.items())


def _missing(case: Case, keys: tuple[str, ...]) -> Iterator[str]:
    """Keys that the case lacks; of a table that is missing as a whole its own name only."""
    for key in keys:
        above = key.rpartition(".")[0]
        if not _has(case, key) and not (above in keys and not _has(case, above)):
            yield key


def _has(case: Case, key: str) -> bool:
    value: object = case
    for part in key.split("."):
        value = getattr(value, part, None)
    return value is not None
