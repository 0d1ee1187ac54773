"""A motion as a table of poses over time, as `motion.csv` has them."""

import csv
from pathlib import Path

import numpy as np

from cases.errors import FileProblem
from cases.recording import POSE
from cases.units import DEG, MM
from identification.motion import TimedPoints

MOST_POINTS = 1_000_000


def read_motion(file: Path) -> TimedPoints:
    """A motion from a table with `t_s` and the six pose columns, as `motion.csv` has them; other columns do not count.

    Raises:
        FileProblem: unreadable, a column is missing, a value is no number, or times do not increase.
    """
    try:
        with file.open(newline="", encoding="utf-8") as stream:
            rows = csv.reader(stream)
            header = [name.strip() for name in next(rows, [])]
            missing = [name for name in ("t_s", *POSE) if name not in header]
            if missing:
                raise FileProblem(
                    f"{file}, line 1: column {missing[0]} is missing; head the columns as motion.csv does"
                )
            places = [header.index(name) for name in ("t_s", *POSE)]
            values = [_numbers(file, line, row, places, header) for line, row in enumerate(rows, start=2) if row]
    except FileProblem:
        raise
    except OSError as error:
        raise FileProblem(f"{file}: cannot be read ({error.strerror or error}); give a plan folder or a CSV") from error
    except (UnicodeDecodeError, csv.Error) as error:
        raise FileProblem(f"{file}: is no table in UTF-8 ({error}); give a plan folder or a CSV") from error
    if not 4 <= len(values) <= MOST_POINTS:
        raise FileProblem(f"{file}: holds {len(values)} poses; a motion has 4 to {MOST_POINTS}")
    table = np.array(values)
    steps = np.diff(table[:, 0])
    if not np.all(steps > 0.0):
        line = int(np.argmax(steps <= 0.0)) + 3
        raise FileProblem(f"{file}, pose of line {line}: t_s does not increase; sort the rows and drop repeated times")
    return TimedPoints.through(table[:, 0] - table[0, 0], table[:, 1:] * np.repeat([MM, DEG], 3))


def _numbers(file: Path, line: int, row: list[str], places: list[int], header: list[str]) -> list[float]:
    values = []
    for place in places:
        text = row[place] if place < len(row) else ""
        try:
            value = float(text)
        except ValueError:
            value = float("nan")
        if not np.isfinite(value):
            raise FileProblem(f"{file}, line {line}: {header[place]} is {text!r}, not a number; correct it")
        values.append(value)
    return values
