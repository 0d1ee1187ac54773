"""A few samples that a recorder lost: their rows are put back, marked as missing, so that a filter can pass them.

Longer gaps stay gaps. Stamps that a host gives jitter; of these nothing can be said about single samples.
"""

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from identification.formats.clock import UNIFORMITY, crowded, lost_samples
from identification.formats.stream import Channel, Stream
from identification.formats.table import Array

MOST_PUT_BACK = 3  # samples in a row
_SWITCHING: tuple[Channel, ...] = ("trigger", "override", "rotations")  # keep their last value


def with_lost_rows(stream: Stream, last: float | None = None, step: float | None = None) -> Stream:
    """The stream with rows for samples that were lost, a few at a time.

    Args:
        stream: with a clock, or as it is.
        last: time of the row before its first [s]; None: there is none.
        step: usual time between samples [s]; by default that of the stream.
    """
    if stream.t is None or len(stream.t) < MOST_PUT_BACK:
        return stream
    before = np.r_[stream.t[0] if last is None else last, stream.t]
    steps = np.diff(before)[last is None :]
    usual = float(np.median(steps)) if step is None else step
    lost = lost_samples(before[last is None :], step=usual)
    if np.any((np.abs(steps - usual) > UNIFORMITY * usual) & (lost == 0)) or crowded(lost > 0) is not None:
        return stream  # not at one rate: the reason is told where a rate is needed
    lost = np.r_[0, lost] if last is None else lost
    count = np.where(lost <= MOST_PUT_BACK, lost, 0)
    if not count.any():
        return stream
    own = np.arange(len(stream.t)) + np.cumsum(count)  # where the rows that are there stand in the result
    rows = np.arange(own[-1] + 1)
    there = np.zeros(len(rows), dtype=bool)
    there[own] = True
    at = (before[1:], own) if last is None else (before, np.r_[-1, own])
    more: dict[Any, Any] = {n: _spread(v, own, rows, n in _SWITCHING) for n, v in stream.channels.items()}
    missing = ~there
    if stream.missing is not None:
        missing[own] = stream.missing
    lines = replace(stream.lines, inserted=tuple(np.flatnonzero(~there).tolist()))
    t = np.interp(rows, at[1], at[0])
    return replace(stream, t=t, lines=lines, missing=missing, **more)


def _spread(values: Array, own: NDArray[np.int64], rows: NDArray[np.int64], kept: bool) -> Array:
    """Values at all rows: straight lines between those that are there, or the last of them."""
    last = np.clip(np.searchsorted(own, rows, side="right") - 1, 0, len(own) - 1)
    if kept:
        return np.asarray(values[last])
    following = np.minimum(last + 1, len(own) - 1)
    share = np.clip((rows - own[last]) / np.maximum(own[following] - own[last], 1), 0.0, 1.0)
    share = share.reshape(-1, *(1,) * (values.ndim - 1))
    result = values[last] + share * (values[following] - values[last])
    result[own] = values
    return np.asarray(result)
