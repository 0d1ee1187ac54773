"""Why a file is taken for what it is: codes with values, from which sentences are made in any language."""

from collections.abc import Mapping
from enum import Enum
from typing import Any


class Why(Enum):
    """A reason, as an English sentence with places for values."""

    OUR_NAME = "it has hexcite's name for it"
    NAME = "by its name"
    CASE_NAMES = "the case names it"
    CASE_STATES = "the case states it"
    FORMAT = "the format of the file says so"
    TWO_COLUMNS = "by its name; whole seconds that {column} adds nanoseconds to"
    RUNS_ON = "by its name, and its numbers run on with the rows"
    TICKS = "its numbers are ticks of 100 ns that run on with the rows"
    ALONE_CHANGES = "of those that may be it by their names it alone changes"
    ARE_LENGTHS = "its values are lengths that the struts can have"
    WRENCH = "the sensor of the case has forces and moments"
    DATES = "dates or times of day"
    LABEL = "its label or the row of units says it"
    OUR_UNIT = "none is stated, so that of hexcite's name for it is taken"
    OUR_UNIT_FITS = "none is stated; the values fit this one"
    RATE = "its steps are then {rate} rows a second, which recorders have"
    LENGTHS = "its values are then lengths that the struts can have"
    ENDS = "its values are then within the joints' ends"
    NEAR_HOME = "the platform is then near its home"
    SMALL = "its values are small"
    NO_UNIT = "no unit of this quantity; a scale has to say what a 1 is"
    HEADER = "the header says it"
    FIRST_LINES = "the first lines of the file say it"
    NUMBERS = "with it most columns are numbers in most rows"
    FIRST_ROW = "line {line} is the first row of numbers"
    KNOWN_NAMES = "of the lines above the numbers the one whose names are known best"
    LAST_ROW = "lines below the last row of numbers"
    NO_NAMES = "no line of the file names the columns"
    NOT_UTF8 = "the text is not UTF-8"
    SEVERAL_CLOCKS = "rows of several clocks stand among each other"
    WHERE_CHANGED = "values stand only where they change"
    OTHER_NAMES = "names that differ from ours"
    OTHER_UNITS = "units that differ from those of our names"
    BIT = "bit {bit} alone changes"
    ORIENTATION = "{conventions} by the names; by the values this may be"
    FILTER = "usual, and a fifth of the rows a second at most"
    JOINTS_OF = "positions of joints of {topic} by their names"
    WRENCH_OF = "forces and moments of {topic} by their names"
    MESSAGES = "that of messages of this type"
    CLOCK = "by the clock of the file"


class Reason(str):
    """A sentence, with the codes and values that it was made of; empty of no reason."""

    parts: tuple[tuple[Why, Mapping[str, str]], ...]

    def __new__(cls, *parts: tuple[Why, Mapping[str, str]]) -> "Reason":
        """One sentence of several parts."""
        reason = str.__new__(cls, ", and ".join(why.value.format(**values) for why, values in parts))
        reason.parts = parts
        return reason

    def also(self, why: Why) -> "Reason":
        """This reason, and another one."""
        return Reason(*self.parts, (why, {}))

    @property
    def codes(self) -> list[dict[str, Any]]:
        """Entries of an answer."""
        return [{"code": why.name.lower(), **values} for why, values in self.parts]


def because(why: Why, **values: object) -> Reason:
    """A reason with values in its places."""
    return Reason((why, {name: str(value) for name, value in values.items()}))


NO_REASON = Reason()
