"""Reads tables of setpoints: rows that follow from each other, with struts that belong to their poses.

Rates, accelerations and struts are not believed: each row must lead to the next within the jerk limits, and the struts
of a hexapod are computed again from pose, rates and accelerations.
"""

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from cases.controller_setpoints import Setpoints
from cases.errors import ProgramError
from cases.machine import Machine
from cases.schema import Case
from cases.units import MM
from identification.limited import strut_motion
from identification.motion import Array, Motion
from postprocessors.reading.setpoint_table import Table, columns_of, read_table, units_of
from postprocessors.reading.words import Event, Pause, Reading, Rows, Stand, Switch

ROUNDING = np.array([1e-9, 1e-6]) * MM  # of poses and rates: a thousand times the last decimal of a table
STRUT_ROUNDING = np.array([1e-6, 1e-4, 1e-2]) * MM
SAME_TIME = 1e-9  # [s]
AT_HOME = 1e-9  # [m, rad]
_PARTS = ("pose", "rates", "accelerations")


class _Rows:
    """The table in SI with the places of its cells."""

    def __init__(self, file: str, table: Table, settings: Setpoints, columns: tuple[str, ...], count: int) -> None:
        self.file, self.columns, self.units = file, columns, units_of(columns)
        self.parts = {name: slice(1 + k * count, 1 + (k + 1) * count) for k, name in enumerate(_PARTS)}
        self.struts = slice(1 + 3 * count, len(columns) - 1)
        self.first = table.first
        self.cycle = settings.cycle
        self.values = table.values * self.units
        self.time = self.values[:, 0]
        self.pose, self.rates, self.accelerations = (self.values[:, part] for part in self.parts.values())
        self.trigger = table.values[:, -1]
        self.rest: NDArray[np.bool_] = np.asarray(~(self.rates.any(axis=1) | self.accelerations.any(axis=1)))

    def error(self, row: int, column: int | None, problem: str) -> ProgramError:
        where = "" if column is None else f"{self.columns[column]}: "
        return ProgramError(self.file, self.first + row, 0, f"{where}{problem}")

    def require(self, case: Case) -> None:
        home, limits = case.need_motion("the check of a table")
        steps = np.diff(self.time)
        late = np.abs(self.time - np.arange(len(self.time)) * self.cycle) > SAME_TIME
        if late.any():
            row = int(np.argmax(late))
            gap = f"{1e3 * steps[row - 1]:.6g} ms after the row before" if row else f"{self.time[0]:g} s"
            raise self.error(
                row, 0, f"{gap}; rows begin at 0 and follow each {1e3 * self.cycle:g} ms, the case's cycle"
            )
        wrong = ~np.isin(self.trigger, (0.0, 1.0))
        if wrong.any():
            row = int(np.argmax(wrong))
            raise self.error(row, len(self.columns) - 1, f"{self.trigger[row]:g} is neither 0 nor 1; correct it")
        for row, what in ((0, "begins"), (-1, "ends")):
            if not self.rest[row]:
                raise self.error(row % len(self.time), None, f"the table {what} in motion; it must be at rest there")
        off = np.abs(self.pose[0] - home) > AT_HOME
        if off.any():
            raise self.error(
                0, 1 + int(np.argmax(off)), "the table does not begin at home, where the machine must stand"
            )
        self._require_sequence(limits.jerk)
        if case.hexapod is not None:
            self._require_struts(case.hexapod)

    def _require_sequence(self, jerk: Array) -> None:
        """Taylor's remainder: what a jerk within its limit can make of a row by the next one."""
        h = self.cycle
        p, v, a = self.pose, self.rates, self.accelerations
        left = {
            "rates": (v[1:] - v[:-1] - h * (a[1:] + a[:-1]) / 2, jerk * h**2 / 2, ROUNDING[1]),
            "pose": (p[1:] - p[:-1] - h * v[:-1] - h**2 * (2 * a[:-1] + a[1:]) / 6, jerk * h**3 / 3, ROUNDING[0]),
        }  # differences of accelerations are the jerk, which the proof judges
        for name, (error, bound, rounding) in left.items():
            bad = ~(np.abs(error) <= bound + rounding)
            if bad.any():
                row, k = (int(n) for n in np.argwhere(bad)[0])
                column = self.parts[name].start + k
                raise self.error(
                    row + 1, column, "does not follow from the row before with its rate and acceleration; correct it"
                )

    def _require_struts(self, machine: Machine) -> None:
        none = np.zeros_like(self.pose)
        motion = Motion(self.time.copy(), self.pose.copy(), self.rates.copy(), self.accelerations.copy(), none)
        exact = np.hstack(strut_motion(motion, machine))
        bad = ~(np.abs(exact - self.values[:, self.struts]) <= np.repeat(STRUT_ROUNDING, 6))
        if bad.any():
            row, k = (int(n) for n in np.argwhere(bad)[0])
            column = self.struts.start + k
            found, wanted = self.values[row, column] / self.units[column], exact[row, k] / self.units[column]
            raise self.error(row, column, f"{found:.9g}, but the pose and its derivatives give {wanted:.9g}")

    def events(self) -> list[Event]:
        """Standstills, paths between them, and the trigger where it switches at rest."""
        still = self.rest[1:] & self.rest[:-1] & ~(np.diff(self.pose, axis=0).any(axis=1))
        change = np.flatnonzero((np.diff(still.astype(int)) != 0) | (np.diff(self.trigger[:-1]) != 0.0)) + 1
        edges = [0, *(int(c) for c in change), len(still)]
        events: list[Event] = [Stand(self.first, self.pose[0])]
        on = False
        for start, end in pairwise(edges):
            if bool(self.trigger[start]) != on:
                if not self.rest[start]:
                    raise self.error(start, len(self.columns) - 1, "the trigger switches in motion; switch at rest")
                on = not on
                events.append(Switch(self.first + start, on, at_once=True))
            if still[start]:
                events.append(Pause(self.first + start, (end - start) * self.cycle))
                continue
            if not self.rest[end]:
                raise self.error(end, len(self.columns) - 1, "the trigger switches in motion; switch at rest")
            rows = slice(start, end + 1)
            events.append(
                Rows(self.first + start, self.cycle, self.pose[rows], self.rates[rows], self.accelerations[rows])
            )
        if bool(self.trigger[-1]) != on:
            events.append(Switch(self.first + len(still), not on, at_once=True))
        return events


def read_setpoints(content: bytes, file: str, case: Case) -> Reading:
    """Reads a table.

    Args:
        content: of the file, CSV or Parquet.
        file: its name, for messages.
        case: gives home, kinematics, cycle and the size of the controller's memory.

    Raises:
        ProgramError: anything that is not such a table, or rows that do not belong together, with their line.
        CaseError: the case has no machine or no settings of this dialect.
    """
    settings = case.need_controller("a setpoint table").need_setpoints(case.name)
    home, limits = case.need_motion("the check of a table")
    columns = columns_of(limits.columns, case.hexapod is not None)
    table = read_table(content, file, settings.most_rows, columns)
    rows = _Rows(file, table, settings, columns, len(home))
    rows.require(case)
    return Reading(file, tuple(rows.events()), len(table.values))
