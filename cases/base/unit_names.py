"""Units that recordings may have, by quantity: symbols, other spellings of them, SI values."""

import re
from collections.abc import Iterator, Mapping
from functools import cached_property

from cases.base.units import DEG, MINUTE, MM

STANDARD_GRAVITY = 9.80665  # [m/s^2], by which kilogram-force and pound-force are defined
_POUND = 0.45359237 * STANDARD_GRAVITY  # [N]
_INCH = 25.4 * MM


class Units(Mapping[str, float]):
    """Units of one quantity: symbol -> SI value; the first is the one that our column names have."""

    def __init__(self, quantity: str, values: Mapping[str, float], spellings: Mapping[str, str]) -> None:
        """A table of units.

        Args:
            quantity: what they measure, in a word for messages.
            values: symbol -> SI value.
            spellings: other spelling -> symbol.
        """
        self.quantity = quantity
        self._values = dict(values)
        self._spellings = {**{symbol: symbol for symbol in values}, **spellings}

    def __getitem__(self, symbol: str) -> float:
        return self._values[symbol]

    def __iter__(self) -> Iterator[str]:
        return iter(self._values)

    def __len__(self) -> int:
        return len(self._values)

    @property
    def usual(self) -> str:
        """Symbol of the unit that our column names have."""
        return next(iter(self._values))

    @cached_property
    def _folded(self) -> dict[str, set[str]]:
        """Spelling in small letters -> symbols."""
        folded: dict[str, set[str]] = {}
        for spelling, symbol in self._spellings.items():
            folded.setdefault(spelling.casefold(), set()).add(symbol)
        return folded

    def spellings(self, symbol: str) -> tuple[str, ...]:
        """Other spellings of a unit."""
        return tuple(spelling for spelling, same_unit in self._spellings.items() if same_unit == symbol != spelling)

    def symbol(self, text: str) -> str | None:
        """Symbol of a unit as a file or a person spells it; None where it is not of this quantity, or ambiguous.

        Small and capital letters count where they decide, as between mN and MN.
        """
        plain = plain_unit(text)
        for spelling in (plain, _SEPARATOR.sub("", plain)):
            if spelling in self._spellings:
                return self._spellings[spelling]
            symbols = self._folded.get(spelling.casefold(), set())
            if len(symbols) == 1:
                return next(iter(symbols))
        return None


_SEPARATOR = re.compile(r"[\s*·⋅∙×.\-_]+")  # between the factors of a product


def plain_unit(text: str) -> str:
    """A unit without the brackets and blanks around it, its micro sign as `u`."""
    return text.strip(" \t[](){}<>").replace("\N{MICRO SIGN}", "u").replace("\N{GREEK SMALL LETTER MU}", "u")


def _each(symbol: str, spellings: str) -> dict[str, str]:
    return dict.fromkeys(spellings.split(), symbol)


LENGTHS = Units(
    "length",
    {
        "mm": MM, "m": 1.0, "um": 1e-6, "nm": 1e-9, "cm": 1e-2, "dm": 0.1, "in": _INCH, "mil": 1e-3 * _INCH,
        "ft": 12.0 * _INCH,
    },
    {
        **_each("mm", "millimeter millimeters millimetre millimetres мм"),
        **_each("m", "meter meters metre metres м"),
        **_each("cm", "см"),
        **_each("um", "micron microns mikron micrometer micrometers micrometre micrometres mikrometer мкм"),
        **_each("in", "inch inches zoll ″ ''"),
        **_each("mil", "mils thou"),
        **_each("ft", "foot feet"),
    },
)  # fmt: skip
_TURN = 360.0 * DEG
ANGLES = Units(
    "angle",
    {
        "deg": DEG, "rad": 1.0, "mrad": 1e-3, "urad": 1e-6, "mdeg": 1e-3 * DEG, "arcmin": DEG / 60.0,
        "arcsec": DEG / 3600.0, "rev": _TURN, "gon": _TURN / 400.0,
    },
    {
        **_each("deg", "° º degree degrees degs grad град"),  # Grad is German for degree
        **_each("rad", "rads radian radians рад"),
        **_each("mdeg", "m°"),
        **_each("arcmin", "′ arcmins winkelminute winkelminuten bogenminute bogenminuten"),
        **_each("arcsec", "″ arcsecs asec winkelsekunde winkelsekunden bogensekunde bogensekunden"),
        **_each("rev", "revs turn turns revolution revolutions"),
        **_each("gon", "gons gradian gradians"),
    },
)  # fmt: skip
FORCES = Units(
    "force",
    {
        "N": 1.0, "kN": 1e3, "mN": 1e-3, "MN": 1e6, "uN": 1e-6, "cN": 1e-2, "daN": 10.0, "kgf": STANDARD_GRAVITY,
        "kp": STANDARD_GRAVITY, "gf": 1e-3 * STANDARD_GRAVITY, "tf": 1e3 * STANDARD_GRAVITY, "lbf": _POUND,
        "klbf": 1e3 * _POUND, "ozf": _POUND / 16.0, "dyn": 1e-5,
    },
    {
        **_each("N", "newton newtons Н"),
        **_each("kN", "kilonewton kilonewtons кН"),
        **_each("mN", "millinewton millinewtons мН"),
        **_each("MN", "meganewton meganewtons МН"),
        **_each("kgf", "kg kilopond kilogramforce кгс"),  # a force that is given in kg is a weight
        **_each("gf", "g"),
        **_each("tf", "t"),
        **_each("lbf", "lb lbs lbsf pound pounds poundforce"),
        **_each("klbf", "klb klbs kip kips"),
        **_each("ozf", "oz"),
    },
)  # fmt: skip
_ARMS = {"m": 1.0, "cm": 1e-2, "mm": MM, "in": _INCH, "ft": 12.0 * _INCH}
_PRODUCTS = (
    ("kgf", "m"), ("kgf", "cm"), ("kgf", "mm"), ("gf", "cm"), ("lbf", "in"), ("lbf", "ft"), ("ozf", "in"), ("ozf", "ft")
)  # fmt: skip
"""Forces and arms of moments that have no symbol of their own."""
_SPELLED = {
    "kgf": "kgf kg kp", "gf": "gf g", "lbf": "lbf lb lbs pound pounds", "ozf": "ozf oz", "in": "in inch inches",
    "ft": "ft foot feet",
}  # fmt: skip
MOMENTS = Units(
    "moment",
    {
        "Nm": 1.0, "Nmm": MM, "Ncm": 1e-2, "kNm": 1e3, "kNmm": 1.0, "mNm": 1e-3, "uNm": 1e-6, "MNm": 1e6, "cNm": 1e-2,
        "dNm": 0.1, "daNm": 10.0,
        **{f"{force}-{arm}": FORCES[force] * _ARMS[arm] for force, arm in _PRODUCTS},
    },
    {
        **_each("Nm", "newtonmeter newtonmeters newtonmetre newtonmetres Нм"),
        **_each("Nmm", "Нмм"),
        **_each("kNm", "кНм"),
        **{
            spelling: f"{force}-{arm}"
            for force, arm in _PRODUCTS
            for name in _SPELLED[force].split()
            for length in _SPELLED.get(arm, arm).split()
            for spelling in (f"{name}{length}", f"{length}{name}")
        },
    },
)  # fmt: skip
TIMES = Units(
    "time",
    {
        "s": 1.0,
        "ms": 1e-3,
        "us": 1e-6,
        "ns": 1e-9,
        "filetime": 1e-7,
        "min": MINUTE,
        "h": 60.0 * MINUTE,
        "d": 1440.0 * MINUTE,
    },
    {
        **_each("s", "sec secs second seconds sek sekunde sekunden с сек"),
        **_each("ms", "msec msecs millisecond milliseconds millisekunden мс"),
        **_each("us", "usec usecs microsecond microseconds мкс"),
        **_each("ns", "nsec nsecs nanosecond nanoseconds"),
        **_each("filetime", "100ns"),
        **_each("min", "minute minutes minuten мин"),
        **_each("h", "hr hrs hour hours stunde stunden"),
        **_each("d", "day days tag tage"),
    },
)
SHARES = Units("share", {"%": 0.01, "1": 1.0}, _each("%", "percent prozent pct"))
QUANTITIES = (LENGTHS, ANGLES, FORCES, MOMENTS, TIMES, SHARES)

COUNTS = frozenset(
    {
        "cnt", "cnts", "count", "counts", "cts", "lsb", "adc", "adu", "inc", "incs", "increment", "increments", "tick",
        "ticks", "digit", "digits", "pulses", "inkr", "inkremente",
    }
)  # fmt: skip
"""What converters and encoders count, in small letters: numbers that have a unit only by a factor."""
_OTHERS = frozenset(
    {
        "V", "mV", "uV", "kV", "mV/V", "uV/V", "V/V", "A", "mA", "uA", "Ohm", "Ω", "bar", "mbar", "psi", "ksi", "Pa",
        "hPa", "kPa", "MPa", "°C", "degC", "°F", "K", "Hz", "kHz", "MHz", "W", "kW", "J", "a.u.", "a.u", "arb.u.",
        "p.u.", "Volt", "Volts", "C", "nC", "pC", "%FS", "FS", "‰", "bit", "bits", "dN", "hN", "m/s", "mm/s",
        "mm/min", "m/min", "in/s", "in/min", "m/s^2", "m/s2", "m/s²", "mm/s^2", "mm/s2", "mm/s²", "m/s3", "deg/s",
        "°/s", "rad/s", "rpm", "1/min", "U/min", "1/s", "deg/s^2", "deg/s2", "°/s²", "rad/s^2", "rad/s2", "rad/s²",
        "um/m", "ustrain", "ue", "uε", "ε", "N/mm", "N/s", "bool", "-", "none",
    }
)  # fmt: skip
"""Other units that recorders write: no column of ours has such a quantity."""
_FOLDED_OTHERS = frozenset(map(str.casefold, _OTHERS))


_OF_A_RANGE = re.compile(r"(?:%|(?:percent|per cent|prozent|pct)\b).*|f\.?s\.?o?\.?|full[ -]?scale(?: output)?", re.I)


def is_share(text: str) -> bool:
    """Whether a text says that numbers are shares of a range, as %FS: they have a unit by that range only."""
    return _OF_A_RANGE.fullmatch(plain_unit(text)) is not None


def is_unit(text: str) -> bool:
    """Whether a text is a unit that recorders write, whether or not a column of ours can have it."""
    plain = plain_unit(text)
    known = plain in _OTHERS or (len(plain) > 1 and plain.casefold() in _FOLDED_OTHERS)
    known = known or plain.casefold() in COUNTS or is_share(plain)
    return known or any(units.symbol(plain) not in (None, "1") for units in QUANTITIES)


def is_other_unit(text: str, units: Units) -> bool:
    """Whether a text is the symbol of a unit, letter by letter, that is not one of this quantity."""
    every = _OTHERS.union(*(table for table in QUANTITIES if table is not units))
    return plain_unit(text) in every and units.symbol(text) is None
