"""Units of clock, struts, joints and angles that fit the values of a file, on the machine that they are from."""

import math
from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from cases.base.units import DEG, MM, Array
from cases.chain import Joint
from cases.machine import POSE
from cases.orientation import ANGLES
from cases.recording_format import (
    CLOCK,
    ROLE_OF,
    ROLE_UNITS,
    STRUTS,
    TICKS,
    Role,
)
from cases.schema import Case
from identification.recording.formats.assembly import can_turn, lengths_of_struts, unit_of_positions

USUAL_RATE = 1000.0  # what `recording.rate_Hz` has by default
RATES = (20.0, 50_000.0)  # rows per second that recorders have
MOST_RADIANS = 6.5  # of joints; in degrees one of them is beyond that in any motion
_MOST_METRES = 2.0  # of joints that slide; in millimetres one of them is beyond that in any motion
_NEARER = 3.0  # times nearer to home, from which on one unit fits and the other does not
_BEYOND = 1.0  # degrees or millimetres beyond the ends of a joint that a recording may have
FILETIMES = 1e17, 1e18  # stamps in ticks of 100 ns since the years 1 or 1601


def strut_unit(columns: Sequence[Array], case: Case | None) -> str | None:
    """The unit in which six columns are strut lengths that the machine has; None: there is none."""
    if case is None or case.hexapod is None:
        return None
    low, high = lengths_of_struts(case)
    if not all(np.isfinite(column).any() for column in columns):
        return None
    least, most = min(map(np.nanmin, columns)), max(map(np.nanmax, columns))
    inside = (u for u, factor in ROLE_UNITS[Role.STRUTS].items() if low <= least * factor and most * factor <= high)
    return next(inside, None)


def units_of_values(values: Mapping[str, Array], case: Case | None) -> Iterator[tuple[str, str]]:
    """Units of clock, struts, positions and turning joints that fit their values."""
    if CLOCK in values and len(clock := values[CLOCK]) > 1 and (step := float(np.median(np.diff(clock)))) > 0.0:
        names = ("filetime",) if FILETIMES[0] < clock[0] < FILETIMES[1] else ("s", "ms", "us", "ns")
        rates = {unit: 1.0 / (step * TICKS[unit]) for unit in names}
        possible = [unit for unit, rate in rates.items() if RATES[0] <= rate <= RATES[1]]
        if possible:
            yield CLOCK, min(possible, key=lambda unit: abs(np.log(rates[unit] / USUAL_RATE)))
    if STRUTS[0] in values and (length := strut_unit([values[strut] for strut in STRUTS if strut in values], case)):
        yield from ((strut, length) for strut in STRUTS)
    if case is not None and {*POSE[:3]} <= {*values} and all(np.isfinite(values[ours]).any() for ours in POSE[:3]):
        place = np.array([float(np.nanmedian(values[ours])) for ours in POSE[:3]])
        if unit := unit_of_positions(place, case):
            yield from ((ours, unit) for ours in POSE[:3])
    for unit, columns, _ in units_of_motion(values, case):
        yield from ((ours, unit) for ours in columns)


def unit_that_fits(values: Mapping[str, Array], kept: str, case: Case | None) -> str | None:
    """The unit in which values of one role fit the machine, or a recorder, where they do not in the kept one.

    None where they fit in the kept one, or in no other; readings of forces are `force_unit_in_range`'s.

    Args:
        values: our name -> readings as the file has them, shape (n,), of clock, struts, joints or drives.
        kept: the unit that the case keeps.
        case: the machine.
    """
    if not values or not all(np.isfinite(column).any() for column in values.values()):
        return None
    first = next(iter(values))
    usual = "s" if first == CLOCK else ROLE_UNITS[ROLE_OF[first]].usual
    other = dict(units_of_values(values, case)).get(first, usual)
    return other if _fits(values, other, case) is True and _fits(values, kept, case) is False else None


def _fits(values: Mapping[str, Array], unit: str, case: Case | None) -> bool | None:
    """Whether values of one role fit in a unit; None where nothing says it."""
    first = next(iter(values))
    if first == CLOCK:
        step = float(np.median(np.diff(values[CLOCK]))) if len(values[CLOCK]) > 1 else 0.0
        return RATES[0] <= 1.0 / (step * TICKS[unit]) <= RATES[1] if step > 0.0 and unit in TICKS else None
    role = ROLE_OF[first]
    factor = ROLE_UNITS[role][ROLE_UNITS[role].symbol(unit) or unit]
    if role is Role.STRUTS and case is not None and case.hexapod is not None:
        low, high = lengths_of_struts(case)
        return all(
            low <= np.nanmin(column) * factor and np.nanmax(column) * factor <= high for column in values.values()
        )
    if role in (Role.JOINTS, Role.DRIVES) and case is not None and case.chain is not None:
        joints = dict(zip(case.chain.columns, case.chain.joints, strict=True))
        if values.keys() <= joints.keys():
            return all(_within(joints[ours], column * factor) for ours, column in values.items())
    return None


def units_of_motion(values: Mapping[str, Array], case: Case | None) -> Iterator[tuple[str, tuple[str, ...], bool]]:
    """Units other than the usual ones that fit joints or angles, their columns, and whether the usual one does not."""
    chain = None if case is None else case.chain
    for role, usual, other, most in (
        (Role.JOINTS, DEG, ("rad", 1.0), MOST_RADIANS),
        (Role.DRIVES, MM, ("m", 1.0), _MOST_METRES),
        (Role.ANGLES, DEG, ("rad", 1.0), MOST_RADIANS),
    ):
        columns = tuple(ours for ours in values if ROLE_OF.get(ours) is role and np.isfinite(values[ours]).any())
        if not columns or (role is Role.DRIVES and chain is None):
            continue
        small = max(float(np.nanmax(np.abs(values[ours]))) for ours in columns) <= most
        joints = {} if chain is None else dict(zip(chain.columns, chain.joints, strict=True))
        of_chain = [(joints[ours], values[ours]) for ours in columns if ours in joints]
        fit = [all(_within(joint, v * factor) for joint, v in of_chain) for factor in (usual, other[1])]
        placed = [(joint.home, float(np.nanmedian(v))) for joint, v in of_chain if math.isfinite(joint.home)]
        far = [sum(abs(middle * factor - home) for home, middle in placed) for factor in (usual, other[1])]
        nearer = len(of_chain) == len(columns) and far[1] < far[0] / _NEARER
        sure = bool(of_chain) and fit[1] and (not fit[0] or nearer)
        if role is Role.ANGLES and case is not None and case.hexapod is not None and len(columns) == len(ANGLES):
            angles = np.column_stack([values[ours] for ours in columns])
            if not can_turn(case, angles * other[1]) and can_turn(case, angles * usual):
                continue  # small angles of a positioning stage
        farther = bool(of_chain) and (not fit[1] or far[0] < far[1] / _NEARER)
        if sure or (small and not farther):
            yield other[0], columns, sure


def _within(joint: Joint, positions: Array) -> bool:
    """Whether positions, shape (n,) [m or rad], are within the ends of a joint, a little more apart."""
    low, high = joint.position
    return bool(
        np.nanmin(positions) >= low - _BEYOND * joint.unit and np.nanmax(positions) <= high + _BEYOND * joint.unit
    )
