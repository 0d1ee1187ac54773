"""What the columns of a file mean by their names: groups that belong together, and units."""

import re
from collections.abc import Mapping, Sequence

from cases.machine import POSE
from cases.orientation import ROTATION
from cases.recording_format import (
    ACCELEROMETER,
    BAR_FORCES,
    CLOCK,
    COLUMNS,
    DRIVES,
    OVERRIDE,
    STRUTS,
    TRIGGER,
    WRENCH,
)
from cases.unit_names import QUANTITIES

_BRACKETED = re.compile(r"[\[(<]\s*([^\])>]*?)\s*[\])>]")
_SUFFIX = re.compile(r"(?<=[A-Za-z0-9])[_ /]+([A-Za-zµμ%/]+)$")
_NOT_MEASURED = re.compile(r"soll|target|cmd|command|setp|desired|_ref|vel|speed|geschw|ld_?\d|qd_?\d")
_GROUPS = (STRUTS, DRIVES, POSE, ROTATION, ACCELEROMETER, BAR_FORCES, WRENCH, (CLOCK,), (TRIGGER,), (OVERRIDE,))
"""Columns that belong together: one of them is nothing without the others."""
# Names without separators -> a group, and the number in it of the first that the pattern can name.
_PATTERNS: tuple[tuple[str, tuple[str, ...], int], ...] = (
    (r"^(?:t|ts|time|zeit|timestamp|stamp|zeitstempel|elapsed.*)$", (CLOCK,), 1),
    (r"^(?:trig.*|ttl.*|gate|marker|.*digitalout.*|.*aout.*)$", (TRIGGER,), 1),
    (r"^(?:ovr|.*override.*)$", (OVERRIDE,), 1),
    (r"^(?:r|rot)([123])([123])$", ROTATION, 1),
    (r"^(?:a|roll|phi)$", POSE, 4),
    (r"^(?:b|pitch|theta)$", POSE, 5),
    (r"^(?:c|yaw|psi)$", POSE, 6),
    (r"(?:^|[^a-z])(?:r|rot)([xyz])$", POSE, 4),
    (r"^([xyz])(?:pos|act|ist)?$", POSE, 1),
    (r"(?:^f|force|kraft|ftf)([xyz])$", WRENCH, 1),
    (r"(?:^m|^t|moment|torque|drehmoment|ftt)([xyz])$", WRENCH, 4),
    (r"(?:^a|acc|accel)([xyz])$", ACCELEROMETER, 1),
    (r"wrench\D*(\d)$", WRENCH, 1),
    (r"(?:strut|leg|bein|strebe)\D*(\d)|^(?:l|len|length|laenge)(\d)", STRUTS, 1),
    (r"(?:force|kraft|loadcell|dms)\D*(\d)|^(?:f|fs|lc|sensor)(\d)", BAR_FORCES, 1),
    (r"(?:axis|achse|drive|antrieb|joint|motor|actpos|enc)\D*(\d)|(?:^|actual)(?:q|j)(\d)", DRIVES, 1),
)


def matched(
    names: Sequence[str], units: Sequence[str], joints: Mapping[str, str] | None = None
) -> tuple[dict[str, int], dict[str, str]]:
    """Our columns among a file's, and the units that names state.

    Args:
        units: units of the file's columns, or empty.
        joints: name of each joint of a chain, from the base -> our column; None: the machine is not a chain.

    Returns:
        Our name -> position in the file; our name -> unit. Groups that are not whole are left out.
    """
    groups: dict[tuple[str, ...], dict[int, int]] = {}
    stated: dict[int, str] = {}
    for k, name in enumerate(names):
        bare, unit = _without_unit(name, units[k] if units else "")
        if (meaning := _meaning(name, bare)) is not None:
            groups.setdefault(meaning[0], {}).setdefault(meaning[1], k)
        if unit is not None:
            stated[k] = unit
    if joints is not None:
        own = tuple(joints.values())
        groups[own] = _of_joints(names, groups.pop(DRIVES, {}), joints)
    places: dict[str, int] = {}
    for columns, numbered in groups.items():
        first = 0 if 0 in numbered else 1
        if all(number in numbered for number in range(first, first + len(columns))):
            places |= {ours: numbered[number] for number, ours in enumerate(columns, first)}
    return places, {ours: stated[k] for ours, k in places.items() if k in stated}


def unit_of(text: str) -> str | None:
    """A unit as hexcite writes it, in brackets or not; None where it is not one that a column of ours can have."""
    symbols = (units.symbol(text) for units in QUANTITIES)
    return next((symbol for symbol in symbols if symbol not in (None, "filetime", "1")), None)


def _without_unit(name: str, unit: str) -> tuple[str, str | None]:
    """A column's name in small letters without its unit, and the unit that it, or a line of units, states."""
    if any(name in group for group in _GROUPS):
        return name, None
    bracket = _BRACKETED.search(name)
    symbol = unit_of(unit) or (unit_of(bracket[1]) if bracket else None)
    bare = _BRACKETED.sub("", name).strip()
    suffix = _SUFFIX.search(bare)
    if symbol is None and suffix and (symbol := unit_of(suffix[1])):
        bare = bare[: suffix.start()]
    return bare.lower(), symbol


def _meaning(name: str, bare: str) -> tuple[tuple[str, ...], int] | None:
    """The group that a column is of, and its number there; numbers of some files count from 0."""
    for group in _GROUPS:
        if name in group:
            return group, group.index(name) + 1
    if name in COLUMNS or _NOT_MEASURED.search(bare):  # joints of a chain are found by `_of_joints`
        return None
    key = re.sub(r"[_ .\-#/]+", "", bare)
    for pattern, group, first in _PATTERNS:
        if match := re.search(pattern, key):
            found = [part for part in match.groups() if part is not None]
            if group is ROTATION:
                return group, 3 * int(found[0]) + int(found[1]) - 3
            if not found:
                return group, first
            return group, int(found[0]) if found[0].isdigit() else first + "xyz".index(found[0])
    return None


def _of_joints(names: Sequence[str], numbered: Mapping[int, int], joints: Mapping[str, str]) -> dict[int, int]:
    """Number of each joint of a chain -> its column: by our name or the joint's, else by the number in its name."""
    places: dict[int, int] = {}
    first = 0 if 0 in numbered else 1
    for number, (joint, ours) in enumerate(joints.items()):
        called = [k for k, name in enumerate(names) if name == ours] or [
            k
            for k, name in enumerate(names)
            if joint.lower() in name.lower() and not _NOT_MEASURED.search(name.lower())
        ]
        place = called[0] if len(called) == 1 else numbered.get(number + first)
        if place is not None:
            places[number + 1] = place
    return places
