"""Columns that hold what only a column of another name can: a list of names that is in another order than the file.

Names come from the case where a file has none, and two columns of such a list are soon exchanged. Their values tell:
struts have lengths that the machine allows, a clock rises by equal steps.
"""

import numpy as np

from cases.base.errors import Code, RecordingError
from cases.base.units import MM, Array
from cases.recording_format import CLOCK, OVERRIDE, STRUTS, TRIGGER
from cases.schema import Case
from identification.recording.formats.table import ColumnTable, Stamps, listed

ALIKE = 0.05  # share by which steps of a clock may differ
SMOOTH = 0.5  # second over first differences, rms: samples of a motion have less, noise has 1.7
_LEAST = 20  # rows that show it
_MOST = 10_000  # rows that show it as well as all of them


def require_own_values(table: ColumnTable, case: Case, lengths: tuple[float, float] | None) -> None:
    """Raises RecordingError where a column cannot be what it is called and another one can.

    Args:
        lengths: of the shortest and the longest strut [m]; None: the machine has no struts.
    """
    if table.rows < _LEAST:
        return
    names = "recording.column_names" if table.form.column_names else "[recording.columns]"
    remedy = f"compare the order of {names} with the columns, which hexcite look draws"
    clocks = [ours for ours, values in table.values.items() if ours != CLOCK and _is_clock(values)]
    if table.stamps is not None and (clocks or table.form.column_names) and not _rises(table.stamps):
        problem = f"does not rise as a clock does{f', but {listed(clocks)} does' if clocks else ''}"
        raise RecordingError(place=table.place(0, CLOCK), problem=problem, remedy=remedy, code=Code.CLOCK)
    struts = [ours for ours in STRUTS if ours in table.values]
    if lengths is None or not struts or {*struts} & {*table.form.scale, *table.form.offset}:
        return
    low, high = lengths
    factor = table.factors[struts[0]]
    middles = {ours: float(np.median(np.abs(table.values[ours][:_MOST]))) * factor for ours in struts}
    wrong = [ours for ours, middle in middles.items() if not low <= middle <= high]
    others = [ours for ours in table.values if ours not in (*struts, CLOCK, TRIGGER, OVERRIDE)]
    strangers = [ours for ours in others if _is_length(table.values[ours][:_MOST] * factor, low, high)]
    if wrong and len(strangers) >= len(wrong):
        problem = (
            f"{middles[wrong[0]] / MM:.4g} mm is not a length of a strut, {low / MM:.4g} to {high / MM:.4g} mm, "
            f"but columns that move smoothly within them are called {listed(strangers)}"
        )
        raise RecordingError(place=table.place(0, wrong[0]), problem=problem, remedy=remedy, code=Code.UNIT)


def _rises(values: Stamps) -> bool:
    """Whether numbers, shape (n,), go on from row to row, however unevenly."""
    steps = np.diff(values[:_MOST])
    return bool(np.mean(steps >= 0.0) > 1.0 - ALIKE and steps.sum() > 0.0 and np.mean(steps > 0.0) > ALIKE)


def _is_clock(values: Stamps) -> bool:
    """Whether numbers, shape (n,), rise by equal steps."""
    steps = np.diff(values[:_MOST])
    return bool(steps.min() > 0.0 and np.ptp(steps) <= ALIKE * float(np.median(steps)))


def _is_length(values: Array, low: float, high: float) -> bool:
    """Whether lengths, shape (n,) [m], stay between two others and change as those of a motion do."""
    first, second = np.diff(values), np.diff(values, n=2)
    moves = float(np.mean(first**2))
    within = bool(low <= values.min() and values.max() <= high)
    return within and moves > 0.0 and float(np.mean(second**2)) < SMOOTH**2 * moves
