"""What the columns of an unknown file are likely to mean by their names."""

import re
from collections.abc import Iterator, Mapping, Sequence

from cases.machine import POSE
from cases.recording_format import (
    ACCELEROMETER,
    BAR_FORCES,
    CLOCK,
    COLUMNS,
    DRIVE_VELOCITIES,
    DRIVES,
    OVERRIDE,
    ROLE_UNITS,
    ROTATION,
    STRUT_VELOCITIES,
    STRUTS,
    TEMPERATURE,
    TICKS,
    TRIGGER,
    WRENCH,
)

_UNITS = {
    "µm": "um", "µs": "us", "μm": "um", "μs": "us", "sec": "s", "msec": "ms", "°": "deg", "grad": "deg", "N*m": "Nm",
    "N m": "Nm", "N·m": "Nm", "N*mm": "Nmm",
}  # fmt: skip
_KNOWN = {*TICKS, *(unit for units in ROLE_UNITS.values() for unit in units)} - {"filetime", "1"}
_BRACKETED = re.compile(r"[\[(<]\s*([^\])>]*?)\s*[\])>]")
_SUFFIX = re.compile(r"(?<=[A-Za-z0-9])[_ /]+([A-Za-zµμ%/]+)$")
_WRENCH = re.compile(r"wrench|force|kraft|(?:^|_)fts?(?:_|$)")
_COMMANDED = re.compile(r"soll|target|cmd|command|setp|desired|_ref")
_RATE = re.compile(r"vel|speed|geschw|ld_?\d|qd_?\d")
_NUMBERED: tuple[tuple[str, Sequence[str], Sequence[str]], ...] = (
    (r"(?:strut|leg|bein|strebe)\D*(\d)|^(?:l|ld|len|length|laenge)(\d)", STRUTS, STRUT_VELOCITIES),
    (r"(?:force|kraft|loadcell|dms)\D*(\d)|^(?:f|fs|lc|sensor)(\d)", BAR_FORCES, ()),
    (
        r"(?:axis|achse|drive|antrieb|joint|motor|actpos|enc)\D*(\d)|(?:^|actual|target)(?:q|qd|j)(\d)",
        DRIVES,
        DRIVE_VELOCITIES,
    ),
)
_LETTERED: tuple[tuple[str, Sequence[str]], ...] = (
    (r"(?:^|\W|_)(?:f|force|kraft)[_ ./]?([xyz])$", WRENCH[:3]),
    (r"(?:^|\W|_)(?:m|t|moment|torque|drehmoment)[_ ./]?([xyz])$", WRENCH[3:]),
    (r"(?:^|\W|_)(?:a|acc|accel)[_ ./]?([xyz])$", ACCELEROMETER),
    (r"(?:^|\W|_)(?:r|rot)[_ ]?([xyz])$", POSE[3:]),
    (r"^([xyz])(?:_?(?:pos|act|ist))?$", POSE[:3]),
)
_LETTERED_WORDS = re.compile(r"strut|leg|bein|strebe|force|kraft|sensor|loadcell|axis|achse|drive|antrieb|joint")
_SINGLE = (
    (r"^(?:t|ts|time|zeit|timestamp|stamp|zeitstempel|elapsed.*)$", CLOCK),
    (r"^(?:trig.*|ttl.*|gate|marker|.*digital-?out.*|.*a_out.*)$", TRIGGER),
    (r"^(?:ovr|.*override.*)$", OVERRIDE),
    (r"^(?:.*temp(?:erature|eratur)?)$", TEMPERATURE),
    (r"^(?:a|roll|phi)$", POSE[3]),
    (r"^(?:b|pitch|theta)$", POSE[4]),
    (r"^(?:c|yaw|psi)$", POSE[5]),
)
GROUPS = (STRUTS, STRUT_VELOCITIES, DRIVES, DRIVE_VELOCITIES, POSE, ROTATION, ACCELEROMETER, BAR_FORCES, WRENCH)
"""Columns that belong together: one of them is nothing without the others."""
_OF_DRIVES = (DRIVES, DRIVE_VELOCITIES)


def named(theirs: str, unit: str = "") -> tuple[str | None, str | None]:
    """Our name of a column and the unit that its own name, or a line of units, states; None where it says nothing."""
    if theirs in COLUMNS:
        return theirs, None
    match = _BRACKETED.search(theirs)
    symbol = unit_of(unit) or (unit_of(match[1]) if match else None)
    bare = _BRACKETED.sub("", theirs).strip()
    suffix = _SUFFIX.search(bare)
    if symbol is None and suffix and unit_of(suffix[1]):
        symbol, bare = unit_of(suffix[1]), bare[: suffix.start()]
    return _ours(bare.lower()), symbol


def _is_command(theirs: str) -> bool:
    """Whether a name says that its column was commanded, not measured."""
    return theirs not in COLUMNS and _COMMANDED.search(_BRACKETED.sub("", theirs).lower()) is not None


def unit_of(text: str) -> str | None:
    """A unit as hexcite writes it, in brackets or not; None where it is not known."""
    unit = _UNITS.get(text := text.strip("[]() "), text)
    return unit if unit in _KNOWN else None


def _ours(key: str) -> str | None:
    rotation = re.fullmatch(r"(?:r|rot)_?([123])_?([123])", key)
    if rotation:
        return f"r{rotation[1]}{rotation[2]}"
    for pattern, ours in _SINGLE:
        if re.search(pattern, key):
            return ours
    for pattern, columns in _LETTERED:
        if match := re.search(pattern, key):
            return columns["xyz".index(match[1])]
    if _LETTERED_WORDS.search(key):  # legs A to F
        key = re.sub(r"(?<![a-z])[a-f](?![a-z])", lambda letter: str("abcdef".index(letter[0]) + 1), key)
    for pattern, columns, rates in _NUMBERED:
        match = re.search(pattern, re.sub(r"[_ .\-#]+", "", key))
        if match:
            number = int(next(group for group in match.groups() if group is not None))
            names = rates if rates and _RATE.search(key) else columns
            return f"{names[0][: names[0].index('1')]}{number}{names[0][names[0].index('1') + 1 :]}"
    return None


def matched(
    names: Sequence[str], units: Sequence[str], joints: Mapping[str, str] | None = None
) -> tuple[dict[str, int], dict[str, str]]:
    """Our columns among a file's, and the units that names state.

    Args:
        units: units of the file's columns, or empty.
        joints: name of each joint of a chain, from the base -> our column; None: the machine is not a chain.

    Returns:
        Our name -> position in the file; our name -> unit. Numbers that count from 0 are shifted; of two columns for
        one of ours the first that is not a command counts; groups that are not whole are left out.
    """
    meanings = [named(name, units[k] if units else "") for k, name in enumerate(names)]
    places: dict[str, int] = {}
    for k in sorted(range(len(names)), key=lambda k: _is_command(names[k])):  # stable: measured ones first
        if (ours := meanings[k][0]) is not None:
            places.setdefault(ours, k)
    shifted = dict(_from_one(places))
    if joints is not None:
        shifted = _of_joints(names, shifted, joints)
    groups = GROUPS if joints is None else (tuple(joints.values()), *(g for g in GROUPS if g not in _OF_DRIVES))
    incomplete = {ours for group in groups if not shifted.keys() >= {*group} for ours in group}
    whole = {ours: k for ours, k in shifted.items() if ours not in incomplete}
    column_units = {ours: unit for ours, k in whole.items() if (unit := meanings[k][1]) is not None}
    return whole, column_units


def _from_one(places: Mapping[str, int]) -> Iterator[tuple[str, int]]:
    """The same with groups that count from 0 counted from 1."""
    numbered = (STRUTS, STRUT_VELOCITIES, DRIVES, DRIVE_VELOCITIES, BAR_FORCES)
    for group in numbered:
        zeroth = group[0].replace("1", "0")
        theirs = (zeroth, *group[:-1]) if zeroth in places else group
        yield from ((ours, places[old]) for ours, old in zip(group, theirs, strict=True) if old in places)
    yield from ((ours, k) for ours, k in places.items() if ours in COLUMNS and not any(ours in g for g in numbered))


def _of_joints(names: Sequence[str], places: Mapping[str, int], joints: Mapping[str, str]) -> dict[str, int]:
    """Drives that are the joints of a chain: by the joints' own names in those of the columns, else by numbers."""
    columns = {ours: k for ours, k in places.items() if not any(ours in group for group in _OF_DRIVES)}
    for number, (joint, ours) in enumerate(joints.items()):
        called = [k for k, name in enumerate(names) if joint.lower() in name.lower() and not _is_command(name)]
        numbered = places.get(f"q{number + 1}_mm", places.get(ours))
        place = called[0] if len(called) == 1 else numbered
        if place is not None:
            columns[ours] = place
    return columns


def sixes(names: Sequence[str], free: Sequence[int]) -> Iterator[tuple[int, ...]]:
    """Six of the `free` columns next to each other whose names differ in a number only: they may be six channels."""
    for start in range(len(free) - 5):
        six = tuple(free[start : start + 6])
        if six[-1] - six[0] == 5 and len({re.sub(r"\d+", "#", names[k]) for k in six}) == 1:
            yield six


def wrenches(names: Sequence[str], free: Sequence[int]) -> list[tuple[int, ...]]:
    """Six of the `free` columns whose names call them a wrench; raw ones first, for robots offer others too."""
    wrench = [six for six in sixes(names, free) if _WRENCH.search(names[six[0]].lower())]
    measured = [six for six in wrench if not _is_command(names[six[0]])]
    return sorted(measured, key=lambda six: ("raw" not in names[six[0]].lower(), "wrench" not in names[six[0]].lower()))


def may_be_force(name: str) -> bool:
    """Whether a name says nothing, or that it is a force."""
    return not _is_command(name) and named(name)[0] in (None, *BAR_FORCES, *WRENCH)
