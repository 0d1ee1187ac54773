"""The page of a machine's history: its results over time, and what leapt or drifted."""

import numpy as np

from hexcite.reports.drawing.chart import Axis, Chart, Line, Points, colour
from hexcite.reports.page import Head, page, section, table
from identification.results.history import DAY, History
from identification.texts import legible, parameter_words, with_deviation


def history_charts(of: History) -> list[Chart]:
    """Each of the prominent parameters over time, with its deviation."""
    days = np.array([(entry.when - of.entries[0].when).total_seconds() / DAY for entry in of.entries])
    axis = Axis(f"days since {of.entries[0].when:%Y-%m-%d %H:%M}")
    charts = []
    for k, name in enumerate(of.prominent):
        values = [entry.result[name] for entry in of.entries]
        scale, unit = legible(values[0].unit)
        at = np.array([value.value * scale for value in values])
        bars = np.array([value.reported * scale for value in values])
        words = tuple(
            f"{entry.when:%Y-%m-%d %H:%M} {entry.result.record.recording}: {with_deviation(float(v), float(b))} {unit}"
            for entry, v, b in zip(of.entries, at, bars, strict=True)
        )
        series = (
            Line(days, at, "", colour(k), 0.8, "dot", in_legend=False),
            Points(days, at, name, colour(k), words, bar=bars, in_legend=False),
        )
        caption = f"{parameter_words(name)[:1].upper()}{parameter_words(name)[1:]} over time, with its deviation."
        charts.append(Chart(f"history_{name}", caption, series, axis, Axis(f"{name} [{unit}]"), half=True))
    return charts


def history_page(of: History) -> str:
    """The page of a history."""
    head, *rows = of.rows()
    first, last = of.entries[0].when, of.entries[-1].when
    sentences = of.findings or ("Nothing leaps or drifts beyond its deviation.",)
    return page(
        "History",
        Head(f"{sentences[0][0].upper()}{sentences[0][1:]}", not of.findings, of.case, ()),
        f"{of.words.capitalize()} of {of.case} from {first:%Y-%m-%d %H:%M} to {last:%Y-%m-%d %H:%M}. A leap is a "
        "change between two results that follow each other, with the same payload, beyond what their own noise and "
        "the tolerances allow.",
        [("case", of.case), *(("left out", reason) for reason in of.left_out)],
        of.findings,
        section("Results", table(head, rows, 2)),
        section("Over time", *history_charts(of)),
    )
