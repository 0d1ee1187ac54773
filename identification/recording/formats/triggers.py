"""Triggers: a switch in a column of numbers, a voltage, or a bit among others."""

import numpy as np

from cases.base.errors import Code, RecordingError
from cases.base.phrases import phrase
from cases.base.units import Array, Flags
from cases.recording_format import TRIGGER
from identification.finding import Finding, Kind, note
from identification.recording.formats.table import ColumnTable

LEVELS = 0.2  # of the way between two levels that a switch may be off either: noise of a voltage
OFF = 0.3  # share of the level on, up to which the level off of a voltage may be
_BETWEEN = 0.2  # share of values far from both ends of their range, from which on they are noise about one level
_RIPPLE = 0.1  # share of a voltage's level that it may change by without being switched
_NOISY = 20  # different values from which on they may be noise
_WHOLE = 2.0**53  # largest whole number whose bits a double holds


def trigger_of(table: ColumnTable) -> tuple[Flags | None, list[Finding]]:
    """Whether the trigger is on, shape (n,), and what to say of it; None: there is none, or it never switches.

    Raises RecordingError where a column that should be a trigger is not a switch.
    """
    if (values := table.values.get(TRIGGER)) is None:
        return None, []
    bit = None if table.form.trigger is None else table.form.trigger.bit
    findings: list[Finding] = []
    if bit is not None:
        _require_bits(table, values)
        values = (values.astype(np.int64) >> bit & 1).astype(float)
    elif (changing := _changing_bit(values)) is not None:
        findings = [
            note(
                Kind.WINDOW,
                phrase(
                    "trigger_bit",
                    "the trigger is bit {bit} of {column}, which alone changes",
                    bit=changing,
                    column=table.form.file_name(TRIGGER),
                ),
            )
        ]
        values = (values.astype(np.int64) >> changing & 1).astype(float)
    if _never_switches(values):
        level = float(np.median(values))
        sentence = phrase(
            "trigger_constant",
            "the trigger never switches, it is {level} all along: it marks nothing",
            level=f"{level:.6g}",
        )
        return None, [note(Kind.WINDOW, sentence)]
    flags = switched(values)
    if flags is None:
        off = np.minimum(np.abs(values), np.abs(values - values.max()))  # 0 and the largest are the levels of a switch
        row = int(np.argmax(off))
        remedy = f"export the trigger as a switch between 0 and {values.max():g}, or leave it out"
        if _is_whole(values):
            bits = changing_bits(values)
            names = ", ".join(map(str, bits))
            remedy = (
                f"if it is a bit field (bits {names} change), state which: recording.trigger = {{ bit = {bits[0]} }}"
            )
        raise RecordingError(
            place=table.place(row, TRIGGER),
            problem=phrase("not_a_switch", "{value} is not a level of a switch", value=values[row].item()),
            remedy=remedy,
            code=Code.TRIGGER,
        )
    return flags, findings


def switched(values: Array) -> Flags | None:
    """Whether a switch is on: 0 and 1, or a voltage near one of two levels, shape (n,); None if it is not a switch.

    It is off at the level near 0, and on at the other, which may be -1: some languages write TRUE so.
    """
    low, high = float(np.min(values)), float(np.max(values))
    if low == high:
        return values > 0.0
    near = np.minimum(values - low, high - values) <= LEVELS * (high - low)
    if near.all() and abs(low) <= OFF * high:
        return values > (low + high) / 2
    return values < (low + high) / 2 if near.all() and abs(high) <= OFF * -low else None


def _never_switches(values: Array) -> bool:
    """Whether values are about one level: the same, or those of a voltage with its noise, whose range has a middle."""
    low, high = float(np.min(values)), float(np.max(values))
    if low == high or (low > 0.0 and high - low <= _RIPPLE * high and not _is_whole(values)):
        return True
    between = np.minimum(values - low, high - values) > LEVELS * (high - low)
    return bool(between.mean() > _BETWEEN) and len(np.unique(values)) > _NOISY


def _is_whole(values: Array) -> bool:
    """Whether all values are whole numbers without a sign, as bit fields are."""
    return bool(np.all((values >= 0.0) & (values < _WHOLE) & (values == np.rint(values)))) and values.max() > 1.0


def changing_bits(values: Array) -> list[int]:
    """The bits of whole numbers, shape (n,), that change, counted from 0; none where they are not such numbers."""
    if not _is_whole(values):
        return []
    whole = values.astype(np.int64)
    changing = int(np.bitwise_or.reduce(whole ^ whole[0]))
    return [k for k in range(changing.bit_length()) if changing >> k & 1]


def _changing_bit(values: Array) -> int | None:
    """The only bit that changes where another one is on all along; None where there is no such."""
    if not _is_whole(values):
        return None
    bits = changing_bits(values)
    return bits[0] if len(bits) == 1 and values.min() > 0.0 else None


def _require_bits(table: ColumnTable, values: Array) -> None:
    """Raises RecordingError at the first value that is not a whole number."""
    good = (values >= 0.0) & (values < _WHOLE) & (values == np.rint(values))
    if not good.all():
        row = int(np.argmin(good))
        remedy = "leave recording.trigger.bit out if the column is a switch"
        raise RecordingError(
            place=table.place(row, TRIGGER),
            problem=f"{values[row].item()} has no bits",
            remedy=remedy,
            code=Code.TRIGGER,
        )
