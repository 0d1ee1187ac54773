"""A ROS 2 bag at first sight: its topics, their joints, how their clocks run, and what `[recording]` needs."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from cases.recording_format import CLOCK, WRENCH
from cases.schema import Case
from identification.formats.looked import Column
from identification.formats.naming import matched
from identification.formats.ros import (
    AXES,
    KINDS,
    STAMP,
    joint_names,
    joint_rows,
    opened,
    topic_of,
    topics_of,
    wrench_rows,
)
from identification.formats.table import Array, Stamps, listed, shown

_NS = 1e-9
_SPAN = 15  # messages over which a step is measured
_MOST_JITTER = 0.2  # of a step, from which on stamps are worth a word


def look_at_bag(bag: Path, case: Case | None) -> tuple[tuple[Column, ...], dict[str, Any], list[str]]:
    """Columns, settings for `[recording]`, and what is odd; the sensor's readings are those at the joints' stamps.

    Args:
        case: the machine that it was recorded on; without one nobody knows the order of the joints.

    Raises:
        RecordingError: it is damaged, or lacks joints or a sensor.
    """
    chain = None if case is None else case.chain
    columns_of = {} if chain is None else dict(zip(chain.names, chain.columns, strict=True))
    with opened(bag) as reader:
        stated = {what: None if case is None else getattr(case.recording.ros, what) for what in KINDS}
        possible = {what: topics_of(reader, what) for what in KINDS}
        chosen = {what: topic_of(bag, reader, what, stated[what] or next(iter(possible[what]), None)) for what in KINDS}
        names = joint_names(reader, chosen["joints"])
        places = matched(names, (), columns_of)[0] if columns_of else {}
        ours = {names[k]: column for column, k in places.items() if column in columns_of.values()}
        stamps, positions = joint_rows(bag, reader, chosen["joints"], tuple(ours) or names)
        read, readings, frame = wrench_rows(bag, reader, chosen["wrench"])
    several = {what: topic for what, topic in chosen.items() if len(possible[what]) > 1}
    renamed = {ours[name]: name for name in ours if columns_of.get(name) != ours[name]}
    settings: dict[str, Any] = {"ros": several} if several else {}
    settings |= {"columns": renamed} if renamed else {}
    odd = [f"{KINDS[what]}: of {listed(possible[what])} this is {shown(several[what])}" for what in several]
    odd += [f"{shown(chosen['wrench'])}: in the frame {shown(frame)}, which must be that of machine.chain.sensor"]
    odd += [*_clock(chosen["joints"], stamps), *_clock(chosen["wrench"], read)]
    t = (stamps - stamps[0]) * _NS
    columns = [Column(STAMP, CLOCK, "s", False, t)]
    for k, name in enumerate(tuple(ours) or names):
        unit = "m" if ours.get(name, "").endswith("_mm") else "rad"
        columns.append(Column(name, ours.get(name), unit, False, positions[:, k]))
    for k, (axis, column) in enumerate(zip(AXES, WRENCH, strict=True)):
        values = np.interp(t, (read - stamps[0]) * _NS, readings[:, k])
        columns.append(Column(axis, column, "N" if k < 3 else "Nm", False, values))
    settings["rate_Hz"] = float(f"{min(1.0 / _step(stamps), 1.0 / _step(read)):.4g}")
    return tuple(columns), settings, odd


def _step(stamps: Stamps) -> float:
    """Usual time between messages [s]; late stamps and lost messages do not count."""
    span = max(min(_SPAN, len(stamps) - 1), 1)
    return max(float(np.median(stamps[span:] - stamps[:-span])) / span, 1.0) * _NS if len(stamps) > 1 else 1.0


def _clock(topic: str, stamps: Stamps) -> Iterator[str]:
    """How often messages come, and how evenly by their own stamps."""
    step = _step(stamps)
    yield f"{shown(topic)}: {len(stamps)} messages, {1.0 / step:.4g} a second"
    away: Array = np.abs(np.diff(stamps) * _NS - step)
    usual = 1e3 * float(np.quantile(away, 0.95)) if len(away) else 0.0
    if usual > _MOST_JITTER * 1e3 * step:
        yield f"{shown(topic)}: stamps vary by {usual:.2g} ms; they are read as equal steps of {1e3 * step:.3g} ms"
