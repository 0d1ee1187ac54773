"""The page of a machine's history: its results over time, and what leapt or drifted."""

import numpy as np

from cases.base.phrases import phrase
from hexcite.reports.drawing.chart import Axis, Chart, Line, Points, colour
from hexcite.reports.page import Head, page, section, table
from identification.results.history import DAY, History
from identification.texts import as_sentences, legible, parameter_phrase, with_deviation


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
        texts = tuple(
            f"{entry.when:%Y-%m-%d %H:%M} {entry.result.record.recording}: {with_deviation(float(v), float(b))} {unit}"
            for entry, v, b in zip(of.entries, at, bars, strict=True)
        )
        series = (
            Line(days, at, "", colour(k), 0.8, "dot", in_legend=False),
            Points(days, at, name, colour(k), texts, bar=bars, in_legend=False),
        )
        words = "{parameter} over time, with its deviation"
        caption = as_sentences(phrase("over_time", words, parameter=parameter_phrase(name)))
        charts.append(Chart(f"history_{name}", caption, series, axis, Axis(f"{name} [{unit}]"), half=True))
    return charts


def history_page(of: History) -> str:
    """The page of a history."""
    head, *rows = of.rows()
    first, last = of.entries[0].when, of.entries[-1].when
    sound = phrase("nothing_leaps", "Nothing leaps or drifts beyond its deviation")
    first_sentence, *others = of.findings or (sound,)
    return page(
        "History",
        Head(as_sentences(first_sentence), not of.findings, of.case, ()),
        phrase(
            "history_of",
            "{results} of {machine} from {first} to {last}. A leap is a change between two results that follow each "
            "other, with the same payload, beyond what their own noise and the tolerances allow.",
            results=of.words,
            machine=of.case,
            first=f"{first:%Y-%m-%d %H:%M}",
            last=f"{last:%Y-%m-%d %H:%M}",
        ),
        [("case", of.case), *(("left out", reason) for reason in of.left_out)],
        others,
        section("Results", table(head, rows, 2)),
        section("Over time", *history_charts(of)),
    )
