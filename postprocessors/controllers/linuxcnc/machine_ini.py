"""The INI file of a LinuxCNC machine, compared with what a case says of it."""

import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np

from cases.base.errors import Code, FileProblem, choice
from cases.base.file_reading import read_whole
from cases.base.phrases import phrase
from cases.schema import Case
from postprocessors.controllers.linuxcnc.configuration import PURPOSE, AxisLayout
from postprocessors.dialects.linuxcnc.promises import acceleration_headroom, path_jerk

MOST_BYTES = 1_000_000
SAME = 1e-4  # share by which a number of an INI file may differ from the case's: its rounding
DEFAULT_PATH_JERK = 1e9  # MAX_LINEAR_JERK where none is stated, in LinuxCNC 2.10
TRAPEZOIDAL, S_CURVE = 0, 1
LENGTHS = {"mm": 1.0, "metric": 1.0, "in": 25.4, "inch": 25.4, "imperial": 25.4}
"""LinuxCNC's names of machine units of length, in mm."""
_RAD = 180.0 / np.pi
ANGLES = {"deg": 1.0, "degree": 1.0, "rad": _RAD, "radian": _RAD, "grad": 0.9, "gon": 0.9}
"""The same of angles, in degrees."""

Entries = Mapping[tuple[str, str], tuple[str, str]]
"""Value and place of each key of each section; of a key that stands twice the first counts, as for LinuxCNC."""


class Planner(NamedTuple):
    """The planner that an INI file makes LinuxCNC run."""

    place: str  # file and line, or the file where no line says it
    jerk: float | None  # MAX_LINEAR_JERK in machine units; None: trapezoids


_SECTION = re.compile(r"\[(?P<name>[^\]]+)\]")
_ENTRY = re.compile(r"(?P<key>[A-Za-z0-9_]+)\s*=(?P<value>.*)")
_INCLUDE = re.compile(r"#INCLUDE\s(?P<file>.+)")


def _lines(file: Path, nested: bool = True) -> Iterator[tuple[str, str]]:
    """Lines of an INI file without comments, with their places; of files that it includes too, one level deep."""
    whole, start = "", 1
    for number, line in enumerate(read_whole(file, MOST_BYTES).decode("utf-8", errors="replace").splitlines(), 1):
        start = start if whole else number
        if line.endswith("\\"):
            whole += line[:-1]
            continue
        text, whole = (whole + line).strip(), ""
        if (match := _INCLUDE.fullmatch(text)) and nested:
            yield from _lines(file.parent / Path(match["file"].strip()).expanduser(), nested=False)
        elif text and text[0] not in "#;":
            yield text, f"{file}, line {start}"


def read_ini(file: Path) -> Entries:
    """Entries of an INI file of LinuxCNC; raises FileProblem where it, or one that it includes, cannot be read."""
    entries: dict[tuple[str, str], tuple[str, str]] = {}
    section = ""
    for text, place in _lines(file):
        if match := _SECTION.fullmatch(text):
            section = match["name"].strip()
        elif match := _ENTRY.fullmatch(text):
            entries.setdefault((section, match["key"]), (match["value"].strip(), place))
    return entries


def _number(entries: Entries, section: str, key: str) -> tuple[float, str] | None:
    """The number of an entry and its place; None where it is not stated."""
    if (section, key) not in entries:
        return None
    text, place = entries[section, key]
    try:
        return float(text), place
    except ValueError:
        raise FileProblem(
            place=place,
            problem=phrase(
                "ini_no_number", "[{section}]{key} = {text} is not a number", section=section, key=key, text=f"{text!r}"
            ),
            remedy=phrase("ini_comment", "correct it; a comment needs a line of its own there"),
            code=Code.SYNTAX,
        ) from None


def _unit(entries: Entries, key: str, default: str, units: Mapping[str, float], file: Path) -> float:
    """What a unit of the machine is in ours; raises FileProblem for one that LinuxCNC does not know."""
    name, place = entries.get(("TRAJ", key), (default, str(file)))
    if name not in units:
        raise FileProblem(
            place=place, problem=f"[TRAJ]{key} = {name!r} is unknown", remedy=choice(name, units), code=Code.UNIT
        )
    return units[name]


def planner_of(entries: Entries, file: Path) -> Planner:
    """The planner that the entries of an INI file select; raises FileProblem for one that is not known here."""
    kind, place = _number(entries, "TRAJ", "PLANNER_TYPE") or (float(TRAPEZOIDAL), str(file))
    jerk, _ = _number(entries, "TRAJ", "MAX_LINEAR_JERK") or (DEFAULT_PATH_JERK, "")
    if kind not in (TRAPEZOIDAL, S_CURVE):
        raise FileProblem(
            place=place,
            problem=f"[TRAJ]PLANNER_TYPE = {kind:g} is a planner that is not known here",
            remedy=f"choose {TRAPEZOIDAL} (trapezoids) or {S_CURVE} (limited jerk)",
            code=Code.NOT_SUPPORTED,
        )
    return Planner(place, jerk if kind == S_CURVE and jerk >= 1.0 else None)


def require_same_machine(file: Path, case: Case, timed: bool) -> None:
    """Raises FileProblem where the INI file of a machine contradicts the case that a program is proven for.

    The planner and its limit of jerk must be those of `controller.linuxcnc`, and the axes' limits not above those of
    `[limits.motion]`: what the controller enforces would be less than the proof counts on.

    Args:
        timed: whether the program has paths in blocks of inverse time, for which acceleration limits are higher.
    """
    entries = read_ini(file)
    length, angle = (
        _unit(entries, key, default, units, file)
        for key, default, units in (("LINEAR_UNITS", "mm", LENGTHS), ("ANGULAR_UNITS", "degree", ANGLES))
    )
    jerk, planner = path_jerk(case), planner_of(entries, file)
    if planner.jerk is not None:
        planner = planner._replace(jerk=planner.jerk * length)
    if (jerk is None) != (planner.jerk is None) or not np.isclose(jerk or 1.0, planner.jerk or 1.0, rtol=SAME):
        kinds = [_words(jerk), _words(planner.jerk)]
        raise _contradiction(
            planner.place,
            f"LinuxCNC runs {kinds[1]}; case {case.name} says {kinds[0]}",
            "state what runs in controller.linuxcnc (planner, max_linear_jerk_mm_s3), plan again, or change the INI",
        )
    limits, layout = case.need_motion(PURPOSE)[1], AxisLayout.of(case)
    headroom = acceleration_headroom(case, timed)
    most = {"MAX_VELOCITY": limits.rate, "MAX_ACCELERATION": headroom * limits.acceleration}
    if jerk is not None:
        most["MAX_JERK"] = limits.jerk
    for key, values in most.items():
        expected = values / layout.units / np.where(layout.turns, angle, length)
        for axis, limit in zip(layout.axes, expected, strict=True):
            _require_below(entries, file, f"AXIS_{axis}", key, float(limit))
    if not case.need_controller(PURPOSE).overdriven:
        knob = _number(entries, "DISPLAY", "MAX_FEED_OVERRIDE")
        if knob is not None and knob[0] > 1.0 + SAME:
            raise _contradiction(
                knob[1],
                f"[DISPLAY]MAX_FEED_OVERRIDE = {knob[0]:g}; case {case.name} says that the knob ends at 100 %",
                "remove controller.most_override_percent, or set MAX_FEED_OVERRIDE = 1",
            )


def _words(jerk: float | None) -> str:
    if jerk is None:
        return "trapezoids (PLANNER_TYPE = 0)"
    return f"limited jerk (PLANNER_TYPE = 1, MAX_LINEAR_JERK = {jerk:g})"


def _require_below(entries: Entries, file: Path, section: str, key: str, limit: float) -> None:
    entry = _number(entries, section, key)
    if entry is None:
        problem, place = f"[{section}]{key} is missing, so that nothing keeps {limit:.6g}", str(file)
    elif entry[0] > limit * (1.0 + SAME):
        problem, place = f"[{section}]{key} = {entry[0]:g} is above limits.motion of the case ({limit:.6g})", entry[1]
    else:
        return
    raise _contradiction(place, problem, f"set it to {limit:.6g}, or state the machine's own limit in the case")


def _contradiction(place: str, problem: str, remedy: str) -> FileProblem:
    return FileProblem(place=place, problem=problem, remedy=remedy, code=Code.CONTRADICTION)
