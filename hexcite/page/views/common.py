"""What several stages show: files, limits, parameters."""

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from cases.base.errors import Remedy, Write
from cases.base.places import placed
from cases.base.text_formats import toml_value
from hexcite.page.stages import RUN_FILE, Made
from hexcite.page.words import Words
from identification.texts import legible, std_text, value_text

BOUND = 0.99  # share from which a limit is used to its end
MOST_TEXT = 40_000  # characters of a program or export that are shown


Query = Mapping[str, str]


def chosen(made: Sequence[Any], name: str | None) -> Any:
    """The one that is asked for, else the newest that is fresh, else the newest; None where there is none."""
    named = next((each for each in made if each.name == name), None)
    fresh = next((each for each in made if not each.changed), None)
    return named or fresh or (made[0] if made else None)


def chosen_plan(plans: Sequence[Made], name: str | None) -> Made | None:
    """The plan that is asked for, else as `chosen`, one of a manual motion last, and of plans alike the best."""
    named = next((plan for plan in plans if plan.name == name), None)
    selection: Made | None = named or chosen([plan for plan in plans if not plan.by_hand] or plans, None)
    return selection if named is not None or selection is None else best_alike(plans, selection)


def best_alike(plans: Sequence[Made], plan: Made) -> Made:
    """Of the plans that are as fresh as this one and were asked for alike the one with most information."""
    alike = [each for each in plans if each.fresh == plan.fresh and _asked(each) == _asked(plan)]
    return max([plan, *alike], key=_information)


def _information(plan: Made) -> float:
    efficiency = plan.record.get("d_efficiency")
    return efficiency if isinstance(efficiency, float) else 0.0


def _asked(plan: Made) -> tuple[str, ...]:
    """What a search was asked for, but how long it may take and where it begins."""
    record, asked = plan.record, plan.record.get("asked") or {}
    settings = record.get("settings") or {}
    of_plan = (record.get(key) for key in ("criterion", "model", "payload", "known", "weights"))
    parts = (asked.get("duration_s"), asked.get("family"), asked.get("target"), plan.by_hand, *of_plan)
    return tuple(map(str, (*parts, settings.get("made_for"), settings.get("without"))))


def recording_in(record: Mapping[str, Any]) -> str:
    """Name of the recording that a result is of: of its file, or of the folder of a rehearsal."""
    recording = Path(str(record.get("recording", "")))
    return (recording.parent if recording.name == RUN_FILE else recording).name


def beginning(path: Path) -> tuple[str, bool]:
    """The beginning of a text file, and whether there is more."""
    try:
        with open(path, "rb") as stream:
            content = stream.read(MOST_TEXT + 1)
    except OSError:
        return "", False
    return content[:MOST_TEXT].decode("utf-8", "replace"), len(content) > MOST_TEXT


def limits(words: Words, limits: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Limits with the share that is used, the most used first."""
    rows = [
        {
            "name": words.limit_at(name, str(check.get("at", name))),
            "share": min(max(float(check["ratio"]), 0.0), 1.2),
            "text": f"{100 * float(check['ratio']):.1f} %",
            "status": words.status(str(check.get("status", ""))),
            "bound": float(check["ratio"]) >= BOUND,
        }
        for name, check in limits.items()
        if isinstance(check, Mapping) and isinstance(check.get("ratio"), int | float)
    ]
    return sorted(rows, key=lambda row: -float(str(row["share"])))


def remedies(offered: Sequence[Remedy]) -> list[dict[str, Any]]:
    """Remedies by keys: their words, and lines as a case file has them."""
    return [
        {
            "words": each.words,
            "phrase": each.phrase,
            "lines": [_line(write) for write in each.keys],
        }
        for each in offered
    ]


def parameter(words: Words, name: str, value: Mapping[str, Any]) -> tuple[str, str, str, str, str]:
    """A parameter in words, its value, its deviation, its expanded uncertainty (k = 2) and its unit."""
    scale, unit = unit_shown(str(value.get("unit", "")))
    std = max((float(value[key]) for key in ("std", "std_robust") if value.get(key) is not None), default=math.nan)
    if not math.isfinite(std) or std <= 0.0:
        return words.parameter(name), f"{float(value['value']) * scale:.6g}", "", "", unit
    digits = value_text(float(value["value"]) * scale, std * scale)
    from identification.estimation.fit import COVERAGE_FACTOR  # with scipy, which a first paint does not wait for

    expanded = std_text(COVERAGE_FACTOR * std * scale)
    return words.parameter(name), digits, std_text(std * scale), expanded, unit


def unit_shown(unit: str) -> tuple[float, str]:
    """Factor from a SI unit to the one that pages show, and its sign."""
    scale, sign = legible(unit)
    return scale, sign.replace("^2", "²")


def _line(write: Write) -> str:
    """A key with its value, and the standard deviation of an estimated one, as the page shows it."""
    plus_minus = f" ± {toml_value(_rounded(write.deviation))}" if write.deviation is not None else ""
    return f"{placed(write.place)} = {'–' if write.value is None else toml_value(write.value)}{plus_minus}"


def _rounded(deviation: Any) -> Any:
    """A standard deviation with two digits, or several in lists."""
    return [_rounded(each) for each in deviation] if isinstance(deviation, list) else float(f"{deviation:.2g}")
