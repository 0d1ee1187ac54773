"""The step between samples that the header of a file states, as a rate or an interval beside its unit."""

import re
from collections.abc import Sequence
from typing import NamedTuple

from identification.recording.formats.names.labels import LONGEST

_NUMBER = r"(?P<number>\d+(?:[.,]\d+)?(?:e[+-]?\d{1,2})?)"
_OF_SAMPLES = r"(?:sampl\w*|abtast\w*|scan\w*|mess|acquisition|aufzeichnungs?|record\w*|log\w*|daq)"
_RATE = r"(?:rate|freq\w*|takt)"
_STEP = r"(?:interval\w*|intervall\w*|zeit|time|period\w*|step|schritt|dt)"
_RATES = {"hz": 1.0, "khz": 1e3, "1/s": 1.0, "/s": 1.0, "s/s": 1.0, "sps": 1.0, "ksps": 1e3, "samples/s": 1.0}
_STEPS = {"s": 1.0, "sec": 1.0, "ms": 1e-3, "us": 1e-6, "µs": 1e-6, "μs": 1e-6, "ns": 1e-9}
_BETWEEN = r"[\s_\-:=;,\t\"'\[(]*"  # between a word, a unit and a number
_PATTERN = re.compile(
    rf"{_OF_SAMPLES}{_BETWEEN}(?:(?P<rate>{_RATE})|{_STEP})\b[\])]?{_BETWEEN}(?:(?P<before>1/s|[^\W\d_/]+(?:/s)?)[\])]?"
    rf"{_BETWEEN})?{_NUMBER}{_BETWEEN}(?P<behind>1?/s|[^\W\d_]+(?:/s)?|)",
    re.I,
)
_LONGEST, _SHORTEST = 10.0, 1e-6  # [s] between samples of a recording


class StatedStep(NamedTuple):
    """What a header says of the step between samples."""

    period: float  # [s]
    text: str  # the line that says it


def stated_step(header: Sequence[str]) -> StatedStep | None:
    """The step between samples by the lines of a header; None where none states it with its unit, or two differ."""
    steps = [step for line in header if (step := _of_line(line)) is not None]
    if not steps or any(abs(step.period / steps[0].period - 1.0) > 1e-6 for step in steps):
        return None
    return steps[0]


def _of_line(line: str) -> StatedStep | None:
    match = _PATTERN.search(line) if len(line) <= LONGEST else None
    if match is None:
        return None
    units = _STEPS if match["rate"] is None else _RATES
    unit = next((u.casefold() for u in (match["before"], match["behind"]) if u and u.casefold() in units), None)
    number = float(match["number"].replace(",", "."))
    if unit is None or number <= 0.0:
        return None
    period = number * units[unit] if match["rate"] is None else 1.0 / (number * units[unit])
    return StatedStep(period, line.strip()) if _SHORTEST <= period <= _LONGEST else None
