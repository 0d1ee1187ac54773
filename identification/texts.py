"""Texts for people: numbers to the second digit of their standard deviation, parameters in words, tables, limits."""

import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from math import floor, isfinite, log10
from typing import TYPE_CHECKING

from cases.base.phrases import Phrase, phrase, said

if TYPE_CHECKING:
    from identification.estimation.fit import Value
    from identification.limits.limit import LimitCheck

_BODY = {"m": "mass"} | {f"{axis}C": f"centre of gravity {axis}" for axis in "xyz"}
_BODY |= {f"IC{i}{j}": f"inertia {a}{b}" for i, a in enumerate("xyz", 1) for j, b in enumerate("xyz", 1)}
_WORDS = {
    "k0": "deformation: force by displacement",
    "k1": "deformation: moment by displacement",
    "k2": "deformation: force by tilt",
    "k3": "deformation: moment by tilt",
} | {f"f_q0_{k}": f"offset of channel {k}" for k in range(1, 7)}
_WORDS |= {f"K{n}_{k}{a}": f"deformation: channel {k} by {a}" for n in "134" for k in range(1, 7) for a in "xyz"}
_OF_STRUTS = {
    "mu": "mass of a rod",
    "h": "first moment of a rod",
    "k": "inertia of rod and tube",
    "d": "first moment of a tube",
    "cB": "viscous friction of a base joint",
    "cP": "viscous friction of a platform joint",
    "tB": "Coulomb friction of a base joint",
    "tP": "Coulomb friction of a platform joint",
}
_WORDS |= _OF_STRUTS
_WORDS |= {f"{name}_{k}": f"{words}, strut {k}" for name, words in _OF_STRUTS.items() for k in range(1, 7)}
MOST_TIMES = 10.0  # multiple of a limit up to which a share is shown
MOST_PLACES = 9  # decimals beyond which a fixed notation is not legible


def places(std: float) -> int | None:
    """Decimals that show `std` with two digits; None where it is not a scale (zero, not finite, tiny)."""
    if not isfinite(std) or std <= 0.0:
        return None
    digits = 1 - floor(log10(float(f"{std:.1e}")))  # rounded first: 0.0996 is shown as 0.10
    return None if digits > MOST_PLACES else max(digits, 0)


def value_text(value: float, std: float) -> str:
    """`value` with the digits that are significant for its standard deviation `std`, in the same unit."""
    decimals = places(std)
    return f"{value:.6g}" if decimals is None else f"{round(value, decimals) + 0.0:.{decimals}f}"


def std_text(std: float) -> str:
    """A standard deviation with two digits, without exponent where that is legible."""
    decimals = places(std)
    return f"{std:#.2g}" if decimals is None else f"{std:.{decimals}f}"


def two_digits(value: float) -> str:
    """A number with two digits, a large one whole and without an exponent.

    >>> two_digits(7.04), two_digits(512.3)
    ('7', '512')
    """
    return f"{value:.2g}" if abs(value) < 99.5 else f"{value:.0f}"


def with_deviation(value: float, std: float) -> str:
    """A value with its standard deviation, both rounded to two digits of the deviation."""
    return f"{value_text(value, std)} ± {std_text(std)}"


_NAME = re.compile(r"[\[\w-]+([._\]\d:]|\[)")
"""Beginning of a key of a case, or of the name of a file, a folder or a channel."""


def begun(text: str) -> str:
    """A text as a sentence begins: with a large letter, unless it begins with a name, which stays as it is written.

    >>> begun("half of all runs"), begun("case.toml: is empty")
    ('Half of all runs', 'case.toml: is empty')
    """
    return text if _NAME.match(text) else text[:1].upper() + text[1:]


SENTENCES = "sentences"
"""Code of texts that are sentences behind each other."""


def as_sentences(*parts: str) -> Phrase:
    """Texts as sentences behind each other, each with a large letter and a full stop.

    >>> as_sentences("half of all runs show it", "nothing else does")
    'Half of all runs show it. Nothing else does.'
    """
    result = Phrase(" ".join(f"{begun(part).removesuffix('.')}." for part in parts))
    result.code, result.values = SENTENCES, {"parts": [said(part) for part in parts]}
    return result


def number(value: float, std: float | None, digits: int) -> str:
    """A value with its standard deviation; where that is not known, with so many digits."""
    return f"{value:.{digits}g}" if std is None else with_deviation(value, std)


def legible(unit: str) -> tuple[float, str]:
    """Factor from an SI unit to the one for people, and that unit: mm for lengths, all else unchanged."""
    return (1e3, "mm") if unit == "m" else (1.0, unit)


def share_text(ratio: float, decimals: int = 2) -> str:
    """Share of a limit in %, with two decimals, as 99.99 is not 100; above ten times the limit in words."""
    return f"{100 * ratio:.{decimals}f} %" if ratio <= MOST_TIMES else "more than ten times"


def efficiency_text(value: float, decimals: int = 3) -> str:
    """A D-efficiency; one above 1 is that of a motion that exceeded the limits, or of a bound that is an estimate."""
    if value <= 1.0:
        return f"{value:.{decimals}f}"
    return f"above 1 ({value:.{decimals}f}: more than inside the limits, by a bound that may be an estimate)"


def bounds_text(check: "LimitCheck") -> str:
    """The limit, or both where there are two."""
    if check.bounds is None:
        return f"at least {check.limit:.4g}" if check.kind.least else f"{check.limit:.4g}"
    low, high = check.bounds
    return f"±{high:.4g}" if low == -high else f"{low:.4g} to {high:.4g}"


def use_text(check: "LimitCheck", decimals: int = 2, unit: str = "") -> str:
    """What is used of a limit; where a share cannot be compared with it, what is left to it, in `unit`."""
    room = check.room
    if room is None or not isfinite(room):
        return share_text(check.ratio, decimals)
    size = f"{abs(room):.3g}{f' {unit}' if unit else ''}"
    if check.kept or room >= 0.0:
        return phrase("room_left", "{size} left", size=size)
    return phrase("room_beyond", "{size} beyond", size=size)


def carries_rods(names: Collection[str]) -> bool:
    """Whether these are parameters of sensors in struts that carry whole rods: the body is the platform with rods."""
    kinds = {name.partition("_")[0] for name in names}
    return "d" in kinds and "mu" not in kinds


def parameter_words(name: str, rods: bool = False) -> str:
    """A parameter in words with its letter in brackets, such as `mass (m)`; letters that have no words stay alone.

    Args:
        rods: whether parameters of the body are those of the platform with rods, see `carries_rods`.
    """
    words = _BODY.get(name, _WORDS.get(name))
    if words is None:
        return name
    return f"{words}, platform with rods ({name})" if rods and name in _BODY else f"{words} ({name})"


PARAMETER = "parameter"
"""Code of a parameter in words."""
CAUSE = "cause_of_deviations"
"""Code of a kind of cause, which is its value."""
CHECK = "check"
"""Code of what is judged, whose values are its own code and its channel or parameter."""


def parameter_phrase(name: str) -> Phrase:
    """The same as a phrase, whose value is the name."""
    return phrase(PARAMETER, parameter_words(name), name=name)


def value_cells(name: str, value: "Value", rods: bool = False) -> tuple[str, ...]:
    """A parameter for people: words, value, the larger standard deviation, U (k = 2), both deviations, unit."""
    scale, unit = legible(value.unit)
    if value.reported <= 1e-9 * abs(value.value):  # a given value deviates by rounding only
        return parameter_words(name, rods), f"{value.value * scale:.6g}", "given", "-", "-", "-", unit
    deviations = (std_text(std * scale) for std in (value.reported, value.expanded, value.std, value.std_robust))
    return parameter_words(name, rods), value_text(value.value * scale, value.reported * scale), *deviations, unit


PARAMETER_COLUMNS = ("parameter", "value", "+-", "U (k=2)", "std (28)", "std robust", "unit")  # of `value_cells`


def aligned(*rows: Sequence[str]) -> list[str]:
    """Lines of a table, its head first: numbers stand at the right of their columns, words at the left."""
    lines = [""] * len(rows)
    for k, column in enumerate(zip(*rows, strict=True)):
        width = max(map(len, column))
        numbers = k > 0 and any(cell.lstrip("~±+-")[:1].isdigit() for cell in column[1:])
        cells = (cell.rjust(width) if numbers else cell.ljust(width) for cell in column)
        lines = [f"{line}  {cell}" for line, cell in zip(lines, cells, strict=True)]
    return [line.rstrip() for line in lines]


def parameter_lines(parameters: "Mapping[str, Value]") -> list[str]:
    """The table of identified parameters."""
    rods = carries_rods(parameters)
    return aligned(PARAMETER_COLUMNS, *(value_cells(name, value, rods) for name, value in parameters.items()))


def budget_cells(units: Mapping[str, str], budget: Mapping[str, Mapping[str, float]]) -> list[tuple[str, ...]]:
    """Rows of a budget, its head first: of each parameter the parts of its deviation by their causes; none of none.

    `units` are SI units of the parameters.
    """
    if not budget:
        return []
    kinds = list(next(iter(budget.values())))
    rows: list[tuple[str, ...]] = [("parts of ±", *kinds, "unit")]
    for name, parts in budget.items():
        scale, unit = legible(units[name])
        rows.append((name, *(std_text(parts[kind] * scale) if parts[kind] else "-" for kind in kinds), unit))
    return rows


def limit_lines(checks: "Iterable[LimitCheck]") -> list[str]:
    """The table of limits; values that follow from a controller's own time law are predictions, marked with ~."""
    rows = [("limit", "worst", "allowed", "unit", "used", "status")]
    for check in checks:
        proven = check.status == "proven"
        about, words = "" if proven else "~", "EXCEEDED" if proven and not check.kept else str(check.status)
        share = f"{about}{use_text(check)}"
        rows.append((check.name, f"{about}{check.worst:.4g}", bounds_text(check), check.unit, share, words))
    return aligned(*rows)
