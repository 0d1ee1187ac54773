"""The page of a comparison: parameters side by side (Table 6), planned and executed motions, and recommendation."""

from collections.abc import Sequence

import numpy as np

from cases.base.provenance import provenance
from hexcite.comparison.comparison import Comparison
from hexcite.comparison.entries import Entry
from hexcite.reports.drawing.accelerations import acceleration_charts, measured_accelerations, planned_accelerations
from hexcite.reports.drawing.chart import Axis, Chart, Points, colour
from hexcite.reports.drawing.densities import compared_densities
from hexcite.reports.page import Block, Head, note, page, section, table
from identification.texts import begun, legible, parameter_words, std_text, value_text
from planner.options import FAMILY_WORDS

FIGURES = {
    "planned_s": "duration as programmed [s]",
    "executed_s": "duration as executed [s]",
    "d_efficiency_planned": "D-efficiency as programmed",
    "d_efficiency": "D-efficiency as executed, behind the evaluation's filter",
    "path_error_mm": "off the path [mm]",
    "D": "log det F (D)",
    "A": "-trace F^-1 (A)",
    "K": "-mu_1/mu_u (K)",
    "N": "mu_u²/mu_1 (N)",
}
"""Figures of an execution and criteria of a plan, in words."""
SPREAD = 0.7  # share of the distance between two parameters that the markers of one occupy


def figure_rows(entries: Sequence[Entry]) -> list[list[str]]:
    """Rows of kind, cost and information of each entry; criteria of the mean information in the reference scaling."""
    rows = [
        ["is", *(e.level for e in entries)],
        ["motion or controller", *(FAMILY_WORDS.get(e.family, e.family) for e in entries)],
        ["model", *(str(e.model) for e in entries)],
        ["measuring time [s]", *("-" if e.duration is None else f"{e.duration:.2f}" for e in entries)],
        ["samples", *(str(e.samples) for e in entries)],
        ["s0 (27) [N, or 1 where weighted]", *("-" if e.s0 is None else f"{e.s0:.3g}" for e in entries)],
        ["white noise", *("-" if e.white_noise is None else f"{e.white_noise:.3g}" for e in entries)],
        ["force residual [N rms]", *("-" if e.residual is None else f"{e.residual:.3g}" for e in entries)],
    ]
    for key, label in FIGURES.items():
        values = [{**e.notes, **e.criteria}.get(key) for e in entries]
        if any(value is not None for value in values):
            rows.append([label, *("-" if value is None else f"{value:.4g}" for value in values)])
    return rows


def parameter_columns(entries: Sequence[Entry]) -> tuple[str, ...]:
    """Heads of `parameter_rows`."""
    labels = ((e.name, "std") if e.level == "identified" else (f"std {e.name}",) for e in entries)
    return ("parameter", *(label for each in labels for label in each))


def parameter_rows(entries: Sequence[Entry]) -> list[list[str]]:
    """Rows as in Table 6, one a parameter: of each entry the identified value and the standard deviation."""
    rows = []
    for name in dict.fromkeys(n for e in entries for n in e.parameters):
        values = [e.parameters.get(name) for e in entries]
        scale, unit = legible(next(t.unit for t in values if t is not None))
        row = [f"{parameter_words(name)} [{unit}]"]
        for entry, t in zip(entries, values, strict=True):
            if entry.level == "identified":
                row.append("-" if t is None else value_text(t.value * scale, t.reported * scale))
            row.append("-" if t is None else std_text(t.reported * scale))
        rows.append(row)
    return rows


CRITERIA_WORDS = (
    "Criteria of the information of a sample, parameters in units of the case (equations (30)-(33)): D, the log of its "
    "determinant; A, the sum of the variances, with a minus; K, its condition, with a minus; N, its smallest singular "
    "value squared over the largest. Larger is better."
)


def compare_page(comparison: Comparison) -> str:
    """The page of `hexcite compare`."""
    groups, entries = comparison.groups, comparison.entries
    figures = acceleration_blocks(groups)
    hashes = dict.fromkeys((f"case {e.conditions.case.name}", e.conditions.case.hash) for e in entries)
    return page(
        "Comparison of excitations",
        comparison_head(comparison),
        f"{len(entries)} plans, runs and results of {len(groups)} excitations.",
        (*hashes, *((e.name, e.level) for e in entries), *provenance([])["versions"].items()),
        comparison.warnings,
        section("Recommendation", *map(note, comparison.sentences)),
        section(
            "Parameters side by side",
            std_chart(groups),
            table(parameter_columns(entries), parameter_rows(entries)),
            note("std of plans: predicted from the information alone, with white noise as the case states."),
            *compared_densities(entries),
        ),
        *((section("Accelerations, planned and measured", *figures),) if figures else ()),
        section("Figures", table(("", *(e.name for e in entries)), figure_rows(entries)), note(CRITERIA_WORDS)),
    )


def acceleration_blocks(groups: Sequence[Sequence[Entry]]) -> tuple[Block, ...]:
    """Accelerations of each run, and those of the plan of its group (Figure 5)."""
    blocks: list[Block] = []
    for number, group in enumerate(groups):
        motion = next((e.motion for e in group if e.motion is not None), None)
        runs = [e for e in group if e.measured is not None and e.measured.estimate is not None]
        for k, entry in enumerate(runs):
            estimate = None if entry.measured is None else entry.measured.estimate
            measured = None if estimate is None else measured_accelerations(estimate)
            if estimate is None or measured is None:
                continue
            planned = (
                None if estimate.planned is None else planned_accelerations(entry.conditions.case, *estimate.planned)
            )
            blocks += acceleration_charts(measured, planned, f"-{number}-{k}", entry.name)
        if not runs and motion is not None:
            planned = planned_accelerations(group[0].conditions.case, motion)
            blocks += acceleration_charts(None, planned, f"-{number}", group[0].name)
    return tuple(blocks)


def comparison_head(comparison: Comparison) -> Head:
    """What the page of a comparison begins with: the recommendation."""
    cases = ", ".join(dict.fromkeys(e.conditions.case.name for e in comparison.entries))
    first = comparison.sentences[0] if comparison.sentences else "Nothing can be recommended"
    return Head(f"{begun(first)}.", not comparison.warnings, cases)


def std_chart(groups: Sequence[Sequence[Entry]]) -> Chart:
    """Standard deviations over the smallest of each parameter; what belongs together has one colour."""
    entries = [(colour(k), entry) for k, group in enumerate(groups) for entry in group]
    names = list(dict.fromkeys(n for _, entry in entries for n in entry.parameters))
    above_zero = {n: [e.parameters[n].reported for _, e in entries if n in e.parameters] for n in names}
    best = {n: min(filter(None, values), default=0.0) for n, values in above_zero.items()}  # a given value has none
    caption = (
        "Standard deviations over the smallest of each parameter: open circles predicted by a plan, dots "
        "identified; a plan, its runs and their results have one colour."
    )
    series = []
    for k, (colour_of_entry, entry) in enumerate(entries):
        std = {n: value.reported for n, value in entry.parameters.items() if value.reported > 0.0}
        aside = SPREAD * ((k + 0.5) / len(entries) - 0.5)
        at, height = np.array([names.index(n) + aside for n in std]), np.array([std[n] / best[n] for n in std])
        words = tuple(f"{n}: {std[n]:.3g} (SI), {std[n] / best[n]:.3g} times the smallest" for n in std)
        series.append(Points(at, height, entry.name, colour_of_entry, words, hollow=entry.level == "planned"))
    return Chart(
        "std",
        caption,
        tuple(series),
        Axis(ends=(-0.6, len(names) - 0.4), names=tuple(names), tilt=90.0),
        Axis("times the smallest", logarithmic=True),
        height=420,
    )
