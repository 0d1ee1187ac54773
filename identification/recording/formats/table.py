"""What readers share: columns with the place of each row in its file, and streams."""

import re
import stat
from bisect import bisect_right
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from os import PathLike
from pathlib import Path
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from cases.base.errors import Code, RecordingError, printable
from cases.base.phrases import phrase
from cases.base.renamed import renamed
from cases.base.units import Array, Flags
from cases.recording_format import FileFormat
from identification.finding import Finding
from identification.recording.formats.clocks import Unsteady, evened

Stamps = NDArray[np.float64] | NDArray[np.int64]
Channel = Literal["drives", "rotations", "forces", "trigger", "poses", "specific_forces", "override"]

_LAST_NUMBER = re.compile(r"[0-9]{1,9}(?=[^0-9]*$)")
_SHOWN_NAMES = 12  # or ranges of them
_COUNTED_ON = 3  # names that differ in a number which counts up are shown as a range from so many on
_SHOWN_CHARACTERS = 40


@dataclass(frozen=True, slots=True)
class Lines:
    """Where in its file each row stands."""

    first: int = 2  # number of the line of the first row, counted from 1
    skipped: tuple[int, ...] = ()  # numbers of lines behind it that hold no row, ascending
    word: str = "line"  # what the file's rows are called
    every: int = 1  # distance of the samples among the file's rows
    # rows that stand in no line, counted from 0 and ascending, before only every n-th is taken
    inserted: tuple[int, ...] = ()

    def later(self, row: int, every: int = 1) -> "Lines":
        """Places of the rows from `row` on, counted from 0, or of every n-th of them, n = `every`."""
        start = row * self.every
        count = bisect_right(self.inserted, start)
        inserted = tuple(k - start for k in self.inserted[count:])
        return replace(self, first=self.first + start - count, every=self.every * every, inserted=inserted)

    def without(self, rows: Sequence[int]) -> "Lines":
        """Places where some rows, counted from 0 and ascending, are left out."""
        return replace(self, skipped=tuple(sorted({*self.skipped, *map(self.number, rows)})))

    def number(self, row: int) -> int:
        """Number of the line of a row, counted from 0; of one that stands in no line that before it."""
        line = self.first + row * self.every - bisect_right(self.inserted, row * self.every)
        for skipped in self.skipped:
            if skipped > line:
                break
            line += 1
        return line

    def place(self, row: int) -> str:
        """Place of a row, counted from 0, as a message names it."""
        return f"{self.word} {self.number(row)}"


LARGEST = 1e20  # nothing that is measured is so large in any unit, not even ticks of 100 ns since 1601


@dataclass(frozen=True, slots=True)
class ColumnTable:
    """Columns of a file that share their rows, in the file's units."""

    source: str  # the file, for messages
    form: FileFormat  # how it is written
    names: tuple[str, ...]  # all columns that the file has, as it calls them
    # our column name -> numbers, shape (n,); missing ones are NaN. Only columns that we know
    values: Mapping[str, Array]
    # stamps of the clock, shape (n,), as the file counts; integers where it writes such. None: no clock
    stamps: Stamps | None
    tick: float  # duration of one unit of the stamps [s]
    lines: Lines  # where the rows stand
    stamped: bool = False  # whether the file has stamps; else its rows are counted
    unit_cells: Mapping[str, str] = field(default_factory=dict)  # our column name -> what a row of units has for it
    header: tuple[str, ...] = ()  # lines above the rows, which may say more about units
    factors: Mapping[str, float] = field(default_factory=dict)  # our column name -> SI value of the file's unit
    findings: tuple[Finding, ...] = ()  # what reading it made known

    @property
    def rows(self) -> int:
        """Number of rows."""
        columns = [*self.values.values(), *([] if self.stamps is None else [self.stamps])]
        return len(columns[0]) if columns else 0

    def place(self, row: int, ours: str) -> str:
        """File, line and column of a value, as a message names them."""
        return f"{self.source}, {self.lines.place(row)}, {shown(self.form.file_name(ours))}"

    def require(self, ours: str, good: Flags, problem: str, remedy: str) -> None:
        """Raises RecordingError at the first row of a column, shape (n,), whose value is not good."""
        if not good.all():
            row = int(np.argmin(good))
            value = self.values[ours][row] if ours in self.values else self.stamps[row]  # type: ignore[index]
            raise RecordingError(
                place=self.place(row, ours), problem=f"{value.item()} {problem}", remedy=remedy, code=Code.WRONG_KIND
            )


@renamed(struts="drives")
@dataclass(frozen=True, slots=True)
class Stream:
    """Samples of one clock in SI units, one row a sample; arrays are None where there are no such channels."""

    source: str  # the file, for messages
    t: Array | None  # time since the first sample of the run, shape (n,) [s]; None: every row is an averaged standstill
    # what moves the sensors: lengths of a hexapod's struts, or joints of a chain, shape (n, k) [m or rad]
    drives: Array | None
    rotations: Array | None  # R, shape (n, 3, 3)
    forces: Array | None  # forces of the sensors, shape (n, 6) [N, or N and N m]
    trigger: Flags | None  # shape (n,)
    poses: Array | None = None  # poses of {P} in {B}, shape (n, 6) [m, rad]
    specific_forces: Array | None = None  # acceleration less gravity, in the axes of {P}, shape (n, 3) [m/s^2]
    override: Array | None = None  # override of the feed, shape (n,); 1 for 100 %
    lines: Lines = field(default_factory=Lines)  # where the rows stand in the file
    # rows in which a value was not measured and stands for nothing, shape (n,); None: there are none
    missing: Flags | None = None
    missing_in: tuple[str, ...] = ()  # the columns in which they are, as the file calls them
    findings: tuple[Finding, ...] = ()  # what reading made known: how it was read, and doubts about that
    # what the recorder's own clock said at t = 0 [s], exact: a double has too few digits for epochs in ns
    origin: Fraction = Fraction(0)

    def __post_init__(self) -> None:
        """Makes arrays of what is given as such, of floats or flags; RecordingError names what cannot be."""
        kind = type(self).__name__
        if not isinstance(self.source, str | PathLike):
            raise RecordingError(
                place=f"{kind}: source",
                problem=f"is {told(self.source)}",
                remedy="name the file or place it is from",
                code=Code.WRONG_KIND,
            )
        object.__setattr__(self, "source", printable(str(self.source)))
        for name, shape in SHAPES.items():
            if (value := getattr(self, name, None)) is not None:
                object.__setattr__(self, name, _array(value, shape, name in FLAGS, f"{kind}: {name}"))
        self._require_alike(kind)

    def _require_alike(self, kind: str) -> None:
        """Raises RecordingError where arrays differ in length, or have no value in a row that is not missing."""
        arrays = {name: array for name in SHAPES if (array := getattr(self, name, None)) is not None}
        first = next((name for name in ("forces", "t", *arrays) if name in arrays), None)
        for name, array in arrays.items():
            if first is not None and len(array) != (rows := len(arrays[first])):
                problem = f"has {len(array)} rows where {first} has {rows}"
                raise RecordingError(
                    place=f"{kind}: {name}",
                    problem=problem,
                    remedy="give one row a sample of one clock",
                    code=Code.CLOCK,
                )
            if name in FLAGS or np.isfinite(array).all():
                continue
            odd = ~np.isfinite(array.reshape(len(array), -1)).all(axis=1)
            odd = odd if name == "t" or self.missing is None else odd & ~self.missing
            if odd.any():
                remedy = "leave the row out" if name == "t" else "mark such rows in missing, or leave them out"
                problem = f"row {int(np.argmax(odd))} of {len(array)}, counted from 0, is not finite"
                raise RecordingError(place=f"{kind}: {name}", problem=problem, remedy=remedy, code=Code.WRONG_KIND)

    @property
    def channels(self) -> dict[Channel, Any]:
        """The arrays that are there, by name."""
        arrays = {name: getattr(self, name) for name in get_args(Channel)}
        return {name: array for name, array in arrays.items() if array is not None}

    @property
    def rows(self) -> int:
        """Number of samples."""
        return len(next(iter(self.channels.values()), ()))

    @property
    def bad(self) -> Flags:
        """Rows that no estimate may use, shape (n,)."""
        return np.zeros(self.rows, dtype=bool) if self.missing is None else self.missing

    @property
    def step(self) -> float:
        """Time between samples, gaps apart [s].

        Raises RecordingError where there is no clock, or where samples are not at equal steps: with the first that is
        not.
        """
        if self.t is None:
            raise RecordingError(
                place=self.source, problem="has no t_s column", remedy="its rows are standstills", code=Code.MISSING
            )
        if len(self.t) < 2:
            raise RecordingError(
                place=self.source,
                problem=phrase("one_row", "has one row, which is not a motion"),
                remedy=phrase("record_again", "record again"),
                code=Code.TOO_FEW,
            )
        even = evened(self.t)
        if isinstance(even, Unsteady):
            raise RecordingError(
                place=f"{self.source}, {self.lines.place(even.row)}, t_s",
                problem=even.problem,
                remedy=even.remedy,
                code=Code.CLOCK,
            )
        return even.step


SHAPES: dict[str, tuple[int | None, ...]] = {
    "t": (None,), "drives": (None, None), "rotations": (None, 3, 3), "forces": (None, 6), "trigger": (None,),
    "poses": (None, None), "specific_forces": (None, 3), "override": (None,), "missing": (None,), "weights": (None,),
}  # fmt: skip
"""Shapes of the arrays of a stream; None: any number."""
FLAGS = ("trigger", "missing")


def told(value: object) -> str:
    """A value as a message can show it."""
    text = repr(value)
    return shown(text) if len(text) <= _SHOWN_CHARACTERS else f"a {type(value).__name__}"


def _array(value: Any, shape: tuple[int | None, ...], flags: bool, place: str) -> Any:
    """A value as an array of floats or flags; raises RecordingError where it is none, or of another shape."""
    expected_kind = "flags" if flags else "numbers"
    if isinstance(value, np.ma.MaskedArray):
        if np.any(np.ma.getmaskarray(value)):
            count = int(np.count_nonzero(np.ma.getmaskarray(value)))
            problem = f"is a masked array that hides {count} of its {value.size} values"
            raise RecordingError(
                place=place,
                problem=problem,
                remedy="give a plain array, and mark such rows in missing",
                code=Code.MISSING,
            )
        value = value.data
    try:
        array = np.asarray(value)
    except ValueError:  # rows of unequal length
        raise RecordingError(
            place=place,
            problem="is not an array of equal rows",
            remedy=f"give {expected_kind} of shape {_shape(shape)}",
            code=Code.WRONG_KIND,
        ) from None
    if array.dtype.kind not in "bifu":
        kind = told(value) if array.ndim == 0 else f"an array of {array.dtype}"
        raise RecordingError(
            place=place,
            problem=f"is {kind}",
            remedy=f"give {expected_kind} of shape {_shape(shape)}",
            code=Code.WRONG_KIND,
        )
    if array.ndim != len(shape) or any(want not in (None, have) for want, have in zip(shape, array.shape, strict=True)):
        problem = f"has the shape {_shape(array.shape)}"
        raise RecordingError(
            place=place,
            problem=problem,
            remedy=f"give {expected_kind} of shape {_shape(shape)}, one row a sample",
            code=Code.WRONG_KIND,
        )
    if not flags:
        return np.asarray(array, dtype=float)
    if array.dtype.kind != "b" and not np.isin(array, (0, 1)).all():
        raise RecordingError(
            place=place,
            problem="holds more than 0 and 1",
            remedy="give flags, such as trigger > 0.5",
            code=Code.TRIGGER,
        )
    return np.asarray(array, dtype=bool)


def _shape(shape: Sequence[int | None]) -> str:
    """A shape in words: (n, 6)."""
    letters = iter("nk")
    words = [str(next(letters, "m") if size is None else size) for size in shape]
    return f"({', '.join(words)}{',' * (len(words) == 1)})"


def require_file(file: Path) -> None:
    """Raises RecordingError unless there is a file that holds something."""
    try:
        about = file.stat()
    except (OSError, ValueError) as error:
        raise unreadable(file, error) from error
    if not stat.S_ISREG(about.st_mode):
        raise RecordingError(
            place=file,
            problem=f"cannot be read (it is {'a folder' if stat.S_ISDIR(about.st_mode) else 'not a regular file'})",
            remedy="give a recording's CSV or folder",
            code=Code.UNREADABLE,
        )
    if about.st_size == 0:
        raise RecordingError(
            place=file,
            problem=phrase("empty_file", "is empty"),
            remedy=phrase("record_again", "record again"),
            code=Code.TOO_FEW,
        )


MOST_MISSING = 0.3  # of a column's rows; one with more is sampled at another rate, or is broken
BYTES = 40  # of memory that reading and evaluating a run take at most for each number in it


def require_room(file: Path, rows: int, columns: int, others: int = 0) -> None:
    """Raises RecordingError where a run takes more than half of the free memory; `others` are its other numbers."""
    most = free_memory() // (2 * BYTES)
    if others + rows * columns > most:
        raise RecordingError(
            place=file,
            problem=phrase(
                "too_large_run",
                "{count} numbers in this run take more than half of the free memory to be evaluated ({size} GB)",
                count=f"{others + rows * columns:,}",
                size=f"{2e-09 * BYTES * most:.3g}",
            ),
            remedy=phrase(
                "cut_run",
                "cut the run, at most {rows} rows of {columns} columns fit, or free memory",
                rows=f"{most // columns:,}",
                columns=columns,
            ),
            code=Code.OUT_OF_RANGE,
        )


def free_memory() -> int:
    """Memory that can be used without swapping [bytes]; 2^60 where the system does not report it."""
    try:
        lines = Path("/proc/meminfo").read_text(encoding="ascii").splitlines()
        return next(int(line.split()[1]) * 1024 for line in lines if line.startswith("MemAvailable:"))
    except (OSError, StopIteration):
        return 1 << 60


def unreadable(file: Path, error: Exception) -> RecordingError:
    """The error for a file that the system cannot read."""
    reason = (error.strerror if isinstance(error, OSError) else None) or type(error).__name__
    return RecordingError(
        place=file,
        problem=f"cannot be read ({reason})",
        remedy="give a recording's CSV or folder",
        code=Code.UNREADABLE,
    )


def shown(text: str, limit: int = _SHOWN_CHARACTERS) -> str:
    """Text from a file as a message can show it: printable and short."""
    clean = "".join(c if c.isprintable() else "\N{REPLACEMENT CHARACTER}" for c in text)
    return clean if len(clean) <= limit else clean[: limit - 2] + ".."


def listed(names: Iterable[str]) -> str:
    """Names from a file as a message can list them: of more than a dozen the first, those that count up as a range.

    >>> listed(["t", "q_0", "q_1", "q_2", "fx", *"abcdefghijkl"])
    't, q_0 .. q_2, fx, a, b, c, d, e, f, g, h, i and 3 more'
    """
    ranges: list[list[str]] = []
    every = [name for name in names if name.strip()]
    for name in every:
        if ranges and _counts_on(ranges[-1][-1], name):
            ranges[-1].append(name)
        else:
            ranges.append([name])
    parts: list[list[str]] = []  # each is shown as one
    for each in ranges:
        parts += [each] if len(each) >= _COUNTED_ON and len(every) > _SHOWN_NAMES else [[name] for name in each]
    first, rest = parts[:_SHOWN_NAMES], sum(map(len, parts[_SHOWN_NAMES:]))
    labels = [shown(of[0]) if len(of) == 1 else f"{shown(of[0])} .. {shown(of[-1])}" for of in first]
    return (", ".join(labels) or "no names") + (f" and {rest} more" if rest else "")


def _counts_on(name: str, following: str) -> bool:
    """Whether a name is another one with its last number one higher."""
    found = _LAST_NUMBER.search(name)
    return found is not None and following == f"{name[: found.start()]}{int(found[0]) + 1}{name[found.end() :]}"
