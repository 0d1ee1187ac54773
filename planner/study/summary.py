"""Summary of a study: convergence, spread over seeds, coverage, and the best settings."""

from collections import Counter
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from markupsafe import Markup

from planner.reports.page import Chart, note, page, section, table, tiles
from planner.study import DONE, FAILED, OPTIONS, PLANNED, SETTINGS, CellSettings

if TYPE_CHECKING:
    import pyarrow as pa


GROUPED = tuple(name for name in SETTINGS if name != "seed")


@dataclass(frozen=True, slots=True)
class SettingsGroup:
    """Cells that differ in their seed only."""

    settings: CellSettings  # settings that they share
    cells: int  # number of cells
    done: int  # number of these that are done
    converged: float  # share of those done whose solver said so
    scores: np.ndarray  # scores of the criterion, those done, shape (k,); the larger the better
    best: float  # largest score; NaN where no cell is done
    median: float  # median score; NaN where no cell is done
    seconds: float  # mean time of a cell [s]
    iterations: float  # mean number of iterations of a cell
    intervals: int  # 95 % intervals of identified parameters, over all seeds of the noise
    inside: float  # share of these that contain the truth; NaN without any


def groups(table: "pa.Table") -> list[SettingsGroup]:
    """Groups of cells that differ in their seed only, in the order of their settings."""
    columns = {name: table[name].to_pylist() for name in table.schema.names}
    members: dict[tuple[Any, ...], list[int]] = {}
    for row, key in enumerate(zip(*(columns[name] for name in GROUPED), strict=True)):
        members.setdefault(key, []).append(row)
    ordered = sorted(members, key=lambda key: [(value is not None, value) for value in key])
    return [
        _group({n: v for n, v in zip(GROUPED, key, strict=True) if v is not None}, members[key], columns)
        for key in ordered
    ]


def _group(settings: CellSettings, rows: list[int], columns: dict[str, list[Any]]) -> SettingsGroup:
    plans = [r for r in rows if columns["noise_seed"][r] == PLANNED]
    planned = [r for r in plans if columns["status"][r] == DONE]
    identified = [r for r in rows if columns["noise_seed"][r] != PLANNED and columns["status"][r] == DONE]
    intervals = sum(columns["parameters"][r] for r in identified)
    inside = sum(columns["inside_95"][r] for r in identified)
    scores = np.array([columns["score"][r] for r in planned], dtype=float)

    def mean(column: str) -> float:
        return float(np.mean([columns[column][r] for r in planned])) if planned else float("nan")

    return SettingsGroup(
        settings=settings,
        cells=len(plans),
        done=len(planned),
        converged=mean("converged"),
        scores=scores,
        best=float(scores.max()) if planned else float("nan"),
        median=float(np.median(scores)) if planned else float("nan"),
        seconds=mean("seconds"),
        iterations=mean("iterations"),
        intervals=intervals,
        inside=inside / intervals if intervals else float("nan"),
    )


def command_of(settings: CellSettings, case: str) -> str:
    """The command line that plans a cell anew, from eight starts."""
    words = [f"--{OPTIONS.get(k, k)} {v}" for k, v in settings.items() if k != "seed"]
    return " ".join(["hexcite plan", case, *words])


def best_groups(settings_groups: list[SettingsGroup]) -> dict[str, SettingsGroup]:
    """Settings with the best plan for each criterion; criteria without any plan are omitted."""
    best: dict[str, SettingsGroup] = {}
    for group in settings_groups:
        letter = group.settings["criterion"]
        if group.done and (letter not in best or group.best > best[letter].best):
            best[letter] = group
    return best


MOST_BOXES = 60
MOST_REASONS = 20


def study_page(about: dict[str, Any], cells: "pa.Table") -> str:
    """The page of a study folder."""
    settings_groups = groups(cells)
    outcomes = zip(cells["status"].to_pylist(), cells["reason"].to_pylist(), strict=True)
    failures = Counter(str(reason) for status, reason in outcomes if status == FAILED)
    failure_count = failures.total()
    warnings = (f"{failure_count} rows failed; their reasons stand below",) if failure_count else ()
    cell_count = sum(g.done for g in settings_groups)
    figures = [(f"{cell_count} of {about['cells']}", "cells planned"), (str(failure_count), "rows failed")]
    intervals = sum(g.intervals for g in settings_groups)
    if intervals:
        inside = sum(g.inside * g.intervals for g in settings_groups if g.intervals) / intervals
        figures.append((f"{100 * inside:.1f} %", f"of {intervals} 95 % intervals hold the truth"))
    sections = [
        section("In short", tiles(*figures), *_best(settings_groups, about["case_file"])),
        section("Settings", _table(settings_groups)),
        section("Spread over seeds", *_boxes(settings_groups)),
    ]
    if failures:
        rows = ((reason, str(count)) for reason, count in failures.most_common(MOST_REASONS))
        sections.append(section("What failed", table(("reason", "rows"), rows)))
    return page(
        f"Study {about['name']}: {about['case']}",
        f"{len(cells)} rows of {about['cells']} cells; a cell is one start of an optimisation, and what it gave.",
        (("case", f"{about['case']} (hash {about['case_hash']})"), ("hexcite", about["version"])),
        warnings,
        *sections,
    )


def _best(settings_groups: list[SettingsGroup], case_file: str) -> tuple[Markup, ...]:
    rows = [
        (letter, command_of(group.settings, case_file), f"{group.best:.4g}", f"{group.median:.4g}")
        for letter, group in sorted(best_groups(settings_groups).items())
    ]
    if not rows:
        return (note("No cell is done yet."),)
    return (
        table(("criterion", "command that plans it", "best", "median"), rows, left=2),
        note("The larger the better: A is minus the trace, K minus the condition, in the reference scaling."),
    )


def _table(settings_groups: list[SettingsGroup]) -> Markup:
    varied = [name for name in GROUPED if len({g.settings.get(name) for g in settings_groups}) > 1]
    columns = (*varied, "cells", "done", "converged", "best", "median", "iterations", "s a cell", "coverage")
    rows = (
        (
            *(str(g.settings.get(name, "-")) for name in varied),
            str(g.cells),
            str(g.done),
            _share(g.converged),
            _number(g.best),
            _number(g.median),
            _number(g.iterations),
            _number(g.seconds),
            _share(g.inside),
        )
        for g in settings_groups
    )
    return table(columns, rows, left=len(varied))


def _number(value: float) -> str:
    return f"{value:.4g}" if np.isfinite(value) else "-"


def _share(value: float) -> str:
    return f"{100 * value:.1f} %" if np.isfinite(value) else "-"


def _boxes(settings_groups: list[SettingsGroup]) -> list[Chart]:
    charts: list[Chart] = []
    for letter in sorted({g.settings["criterion"] for g in settings_groups}):
        members = [g for g in settings_groups if g.settings["criterion"] == letter and g.done]
        members = sorted(members, key=lambda g: -g.best)[:MOST_BOXES]
        if not members:
            continue
        varied = [n for n in GROUPED if n != "criterion" and len({g.settings.get(n) for g in members}) > 1]
        caption = f"{len(members)} best settings for {letter}, a box each."
        figure = Chart(f"spread-{letter}", caption, y=f"criterion {letter}", showlegend=False)
        for g in members:
            name = ", ".join(f"{n} {g.settings.get(n)}" for n in varied if n in g.settings) or "all"
            figure.add("box", y=g.scores, name=name, boxpoints="all" if len(g.scores) <= 50 else "outliers")
        charts.append(figure)
    return charts
