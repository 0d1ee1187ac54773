"""What the rows of a study say: convergence, spread over seeds, coverage, and the settings that came out best."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from planner.study.rows import DONE, PLANNED, SETTINGS

if TYPE_CHECKING:
    import pyarrow as pa

GROUPED = tuple(name for name in SETTINGS if name != "seed")


@dataclass(frozen=True, slots=True)
class Group:
    """Cells that differ in their seed only.

    Args:
        settings: that they share.
        cells: how many.
        done: of these.
        converged: share of those done whose solver said so.
        scores: of the criterion, those done, shape (k,); the larger the better.
        seconds: mean of a cell.
        iterations: mean of a cell.
        intervals: 95 % intervals of identified parameters, over all seeds of the noise.
        inside: share of these that hold the truth; NaN without any.
    """

    settings: dict[str, Any]
    cells: int
    done: int
    converged: float
    scores: np.ndarray
    seconds: float
    iterations: float
    intervals: int
    inside: float

    @property
    def median(self) -> float:
        """Median score; NaN where no cell is done."""
        return float(np.median(self.scores)) if len(self.scores) else float("nan")

    @property
    def best(self) -> float:
        """Largest score; NaN where no cell is done."""
        return float(self.scores.max()) if len(self.scores) else float("nan")


def groups(table: "pa.Table") -> list[Group]:
    """Groups of cells that differ in their seed only, in the order in which they first appear.

    Args:
        table: rows of a study.
    """
    columns = {name: table[name].to_pylist() for name in table.schema.names}
    members: dict[tuple[Any, ...], list[int]] = {}
    for row, key in enumerate(zip(*(columns[name] for name in GROUPED), strict=True)):
        members.setdefault(key, []).append(row)
    return [_group(key, rows, columns) for key, rows in members.items()]


def _group(key: tuple[Any, ...], rows: list[int], columns: dict[str, list[Any]]) -> Group:
    plans = [r for r in rows if columns["noise_seed"][r] == PLANNED]
    done = [r for r in plans if columns["status"][r] == DONE]
    identified = [r for r in rows if columns["noise_seed"][r] != PLANNED and columns["status"][r] == DONE]
    intervals = sum(columns["parameters"][r] for r in identified)
    inside = sum(columns["inside_95"][r] for r in identified)
    return Group(
        settings={name: value for name, value in zip(GROUPED, key, strict=True) if value is not None},
        cells=len(plans),
        done=len(done),
        converged=_mean([columns["converged"][r] for r in done]),
        scores=np.array([columns["score"][r] for r in done], dtype=float),
        seconds=_mean([columns["seconds"][r] for r in done]),
        iterations=_mean([columns["iterations"][r] for r in done]),
        intervals=intervals,
        inside=inside / intervals if intervals else float("nan"),
    )


def _mean(values: list[Any]) -> float:
    return float(np.mean(values)) if values else float("nan")


def best_groups(found: list[Group]) -> dict[str, Group]:
    """For each criterion the settings whose best plan is the best; criteria without any plan are left out."""
    best: dict[str, Group] = {}
    for group in found:
        letter = group.settings["criterion"]
        if group.done and (letter not in best or group.best > best[letter].best):
            best[letter] = group
    return best
