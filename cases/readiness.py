"""What a case lacks for each command: tables and keys, or another machine."""

from collections.abc import Mapping
from typing import get_args

from cases.base.errors import CaseError, Code
from cases.controller import Controller, ControllerName
from cases.schema import Case
from cases.tables import Part


class AnyOf(tuple[str, ...]):
    """Tables of a case of which a command needs one."""

    def __new__(cls, *keys: str) -> "AnyOf":
        """Of their keys."""
        return super().__new__(cls, keys)

    def __str__(self) -> str:
        return " or ".join(self)


def _settings(controller: str) -> tuple[str, ...]:
    """The table of a controller's settings, where it has keys that must be stated."""
    field = Controller.model_fields.get(controller)
    tables = [] if field is None else _tables(field.annotation)
    required = any(key.is_required() for table in tables for key in table.model_fields.values())
    return (f"controller.{controller}",) if required else ()


def _tables(annotation: object) -> list[type[Part]]:
    """The tables of a case that a field may be."""
    if isinstance(annotation, type):
        return [annotation] if issubclass(annotation, Part) else []
    return [table for kind in get_args(annotation) for table in _tables(kind)]


_MACHINE = ("machine", "workspace", "limits.motion")
_PLAN = (*_MACHINE, "nominal")
_PROGRAM = (*_MACHINE, "controller")
_RUN = (*_PROGRAM, "simulation", "recording.filter_cutoff_Hz")
NEEDS: Mapping[str, tuple[str | AnyOf, ...]] = {
    "plan": (*_PLAN, "controller"),
    "plan --family fourier": _PLAN,
    "poses": (*_PLAN, "poses"),
    "bound": _MACHINE,
    "retime": _PROGRAM,
    **{f"post --dialect {name}": (*_PROGRAM, *_settings(name)) for name in ControllerName if name != "virtual"},
    "run": _RUN,
    "identify a motion": ("recording.filter_cutoff_Hz",),
    "identify standstills, force, tare": (),
    "validate": (*_RUN, AnyOf("controller.sinumerik", "controller.twincat"), "nominal", "poses", "payloads"),
    "demo": (*_RUN, "nominal"),
}
"""Command -> tables and keys of a case that it needs, or one of several; what is named needs the tables around it."""
_NOT_OF_A_CHAIN = frozenset({"workspace", "controller.linuxcnc"})  # what chains do not need
_OF_A_MOVING_FRAME = frozenset(NEEDS) - {"identify standstills, force, tare"}


def readiness(case: Case) -> dict[str, tuple[str, ...]]:
    """Tables and keys that a case lacks for each command, or why the command is not for it; empty where it is ready."""
    if case.setup == "1a":  # Figure 1: the sensor frame stands
        still = ("a sensor frame that moves (setup is 1a)",)
        return {command: still if command in _OF_A_MOVING_FRAME else () for command in NEEDS}
    return {name: _lacks(case, name, keys) for name, keys in NEEDS.items()}


def _lacks(case: Case, command: str, keys: tuple[str | AnyOf, ...]) -> tuple[str, ...]:
    """Keys that a command misses, of a table that is missing its own name only, or the machine that it is for."""
    if machine := other_machine(case, command.removeprefix("post --dialect ")):
        return (machine,)
    moving = () if case.chain is None or "limits.motion" not in keys else case.chain.joints
    missing: list[str | AnyOf] = [
        f"machine.chain.joints.{key}" for key in sorted({key for joint in moving for key in joint.lacks})
    ]
    transducer = case.sensor_frame.transducer
    if transducer is not None and transducer.sense is None:
        missing.append("sensor_frame.transducer.sense")
    for key in keys:
        ways = key if isinstance(key, AnyOf) else (key,)
        needed = case.chain is None or not _NOT_OF_A_CHAIN.issuperset(ways)
        if needed and not any(_has(case, way) for way in ways):
            missing.append(key)
    whole = [str(key) for key in missing]
    tables = ({way.rpartition(".")[0] for way in (key if isinstance(key, AnyOf) else (key,))} for key in missing)
    return tuple(key for key, around in zip(whole, tables, strict=True) if not around & {*whole})


def other_machine(case: Case, name: str) -> str | None:
    """The machine that a command, or a dialect, is for; None where it is for that of the case."""
    if case.chain is None:
        if name in ("urscript", "ros2") and case.hexapod is not None:
            return "a chain of joints (the machine is a hexapod)"
        struts = name == "validate" and case.sensor_frame.struts is not None
        return "sensors in the platform (they sit in the struts)" if struts else None
    if name == "validate":
        return "a hexapod (the machine is a chain)"
    if name in ("linuxcnc", "sinumerik", "twincat") and not set(case.chain.names) <= set("XYZABC"):
        return "joints that are named as axes, X, Y, Z, A, B, C"
    if name == "urscript" and [joint.kind for joint in case.chain.joints] != ["revolute"] * 6:
        return "six joints that turn between ends"
    return None


def languages_of(case: Case) -> tuple[ControllerName, ...]:
    """Controllers that the machine of a case can have, whatever settings it states."""
    return tuple(name for name in ControllerName if other_machine(case, name) is None)


def require_machine(case: Case, controller: str, remedy: str) -> None:
    """Raises CaseError with a remedy where a controller runs programs of other machines than that of the case."""
    if machine := other_machine(case, controller):
        raise CaseError(
            file=f"case {case.name}",
            key="machine",
            problem=f"{controller} runs programs of {machine}",
            remedy=remedy,
            code=Code.NOT_SUPPORTED,
        )


def _has(case: Case, key: str) -> bool:
    value: object = case
    for part in key.split("."):
        value = getattr(value, part, None)
    return value is not None
