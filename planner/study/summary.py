"""Summary of a study: the settings with their scores over the seeds, coverage, and the best of each criterion."""

from collections import Counter
from dataclasses import dataclass
from importlib.metadata import version
from typing import TYPE_CHECKING

import numpy as np

from cases.schema import Case
from planner.reports.page import Chart, note, page, section, table
from planner.study import SETTINGS, CellSettings, Spec, command_of
from planner.study.rows import FAILED

if TYPE_CHECKING:
    import pyarrow as pa


GROUPED = [name for name in SETTINGS if name != "seed"]
MOST_REASONS = 20


@dataclass(frozen=True, slots=True)
class SettingsGroup:
    """Cells that differ in their seed only; figures are those of cells that are done, NaN where there are none."""

    settings: CellSettings  # settings that they share
    cells: int  # number of cells
    done: int  # number of plans
    converged: float  # share of these whose solver said so
    best: float  # largest score of the criterion; the larger the better
    median: float  # median score
    efficiencies: tuple[float, ...]  # D-efficiencies of the plans
    seconds: float  # mean time of a cell [s]
    iterations: float  # mean number of iterations of a cell
    inside: float  # share of the 95 % intervals of identified parameters that contain the truth


def groups(rows: "pa.Table") -> list[SettingsGroup]:
    """Groups of cells that differ in their seed only, in the order of their settings."""
    figures = {
        "cell": "count_distinct", "converged": "mean", "iterations": "mean", "seconds": "sum", "parameters": "sum",
        "inside_95": "sum", "score": "list", "d_efficiency": "list",
    }  # fmt: skip
    found = rows.group_by(GROUPED).aggregate(list(figures.items())).sort_by([(name, "ascending") for name in GROUPED])
    result = []
    for row in found.to_pylist():
        scores = [score for score in row["score_list"] if score is not None]
        efficiencies = tuple(value for value in row["d_efficiency_list"] if value is not None)
        cells, intervals = row["cell_count_distinct"], row["parameters_sum"]
        result.append(
            SettingsGroup(
                settings={name: row[name] for name in GROUPED if row[name] is not None},
                cells=cells,
                done=len(efficiencies),
                converged=_number(row["converged_mean"]),
                best=max(scores, default=np.nan),
                median=float(np.median(scores)) if scores else np.nan,
                efficiencies=efficiencies,
                seconds=_number(row["seconds_sum"]) / cells,
                iterations=_number(row["iterations_mean"]),
                inside=row["inside_95_sum"] / intervals if intervals else np.nan,
            )
        )
    return result


def _number(value: float | None) -> float:
    return np.nan if value is None else value


def best_groups(settings_groups: list[SettingsGroup]) -> dict[str, SettingsGroup]:
    """Settings with the best plan for each criterion that has one, in the order of their letters."""
    best: dict[str, SettingsGroup] = {}
    for group in settings_groups:
        letter = group.settings["criterion"]
        if group.done and (letter not in best or group.best > best[letter].best):
            best[letter] = group
    return dict(sorted(best.items()))


def study_page(spec: Spec, case: Case, cells: int, rows: "pa.Table") -> str:
    """The page of a study: the best settings, a table of all, and the D-efficiency of their plans."""
    found = groups(rows)
    outcomes = zip(rows["status"].to_pylist(), rows["reason"].to_pylist(), strict=True)
    failures = Counter(str(reason) for status, reason in outcomes if status == FAILED)
    best = [
        note(f"Criterion {letter}, best {group.best:.4g}: {command_of(group.settings, case.origin)}")
        for letter, group in best_groups(found).items()
    ]
    varied = [name for name in GROUPED if len({group.settings.get(name) for group in found}) > 1]
    spread = Chart("spread", "D-efficiency of the plans of each setting, over their seeds.", y="D-efficiency")
    cells_of_table = []
    for group in found:
        texts = [str(group.settings.get(name, "-")) for name in varied]
        spread.add("box", y=group.efficiencies, name=", ".join(texts), boxpoints="all", showlegend=False)
        shares = [f"{100 * share:.1f} %" if np.isfinite(share) else "-" for share in (group.converged, group.inside)]
        numbers = group.best, group.median, group.iterations, group.seconds
        figures = [f"{number:.4g}" if np.isfinite(number) else "-" for number in numbers]
        cells_of_table.append((*texts, str(group.cells), str(group.done), *figures, *shares))
    columns = (*varied, "cells", "done", "best", "median", "iterations", "s a cell", "converged", "coverage")
    words = "Larger is better: A is minus the trace, K minus the condition, in the reference scaling."
    return page(
        f"Study {spec.name}: {case.name}",
        f"{len(rows)} rows of {cells} cells; a cell is one start of an optimisation, and what it gave.",
        (("case", f"{case.name} (hash {case.hash})"), ("hexcite", version("hexcite"))),
        [f"{count} rows failed: {reason}" for reason, count in failures.most_common(MOST_REASONS)],
        section("Best settings", *(best or [note("No cell is done yet.")]), note(words)),
        section("Settings", table(columns, cells_of_table, left=len(varied)), spread),
    )
