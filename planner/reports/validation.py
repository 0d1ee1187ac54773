"""The page of a validation: Table 7, cost and results of the methods, and why a value is off."""

import re
from collections.abc import Sequence

from markupsafe import Markup

from cases.files import provenance
from identification.precision import legible, parameter_words
from planner.comparison.claims import OFF_COLUMNS, off_rows
from planner.comparison.error_budget import SUSPICIOUS
from planner.comparison.methods import METHODS
from planner.comparison.trials import COMPARED, SHOWN, Trial
from planner.comparison.validation import Validation
from planner.reports.compare import ratio_chart
from planner.reports.page import COLOURS, Block, Chart, colour, note, page, section, table

TABLE_7 = ("load", "s0", *(label for n in SHOWN for label in ((n,) if n[0] == "k" else (n, "dev."))))
LEAST_DEVIATION = 1e-12  # the first trial is its own theory


def table_7(trials: Sequence[Trial]) -> list[list[str]]:
    """Rows as in Table 7, one a load: values with their relative deviation from theory."""
    rows = []
    for trial in trials:
        row = [f"{trial.load:.0f} kg", f"{trial.s0:.2f}"]
        for name in SHOWN:
            value = trial.estimate.physical.get(name)
            row.append("-" if value is None else f"{value.value * legible(value.unit)[0]:.2f}")
            if name[0] != "k":
                deviation = trial.deviation(name)
                blank = deviation is None or abs(deviation) < LEAST_DEVIATION
                row.append("" if blank or deviation is None else f"{100 * deviation:+.2f} %")
        rows.append(row)
    return rows


def _methods(trials: Sequence[Trial]) -> list[str]:
    return list(dict.fromkeys(trial.method for trial in trials))


def validation_page(validation: Validation) -> str:
    """The page of `hexcite validate`."""
    case, trials, payloads = validation.case, validation.trials, validation.case.payloads
    assert payloads is not None
    warnings = tuple(f"{method} was not run: {reason}" for method, reason in validation.failed.items())
    warnings += tuple(_warnings(trials))
    loads = ", ".join(dict.fromkeys(f"{s.load:.0f}" for s in trials))
    tables: list[Block] = []
    for method in _methods(trials):
        own = [s for s in trials if s.method == method]
        text = f" ({METHODS[method].label})" if method in METHODS else ""
        text += "" if own[0].duration is None else f", {own[0].duration:.1f} s"
        tables += [note(f"{method}{text}, model {own[0].estimate.model.number}"), table(TABLE_7, table_7(own))]
    sections = [
        section("What it comes to", *(note(claim.sentence()) for claim in validation.claims)),
        section("Which method gives the smallest standard deviations", *_std_charts(trials), _std_table(trials)),
        section("Values and deviations from theory (Table 7)", note(THEORY), *tables, *_error_blocks(trials)),
        section("Residuals grow with the load", _s0_chart(trials)),
    ]
    if off := off_rows(trials):
        words = (
            "Errors of more than 3 reported standard deviations, and what they consist of, in these: forces that each "
            "disturbance of the simulated machine added pass the evaluation of the run by themselves. The cause is the "
            "one without which the error would be smallest."
        )
        sections.insert(3, section("What is off, and why", note(words), table(OFF_COLUMNS, off, left=3)))
    return page(
        f"Validation with payloads: {case.title}",
        f"Known weights of {loads} kg mounted one after the other and identified by "
        f"{len(_methods(trials))} methods on {validation.machine}.",
        (
            ("case", f"{case.name} (hash {case.hash})"),
            ("machine", validation.machine),
            ("weights", payloads.source),
            *provenance([])["versions"].items(),
        ),
        warnings,
        *sections,
    )


def _warnings(trials: Sequence[Trial]) -> list[str]:
    """Each warning once, with the runs that it was given for: those that differ by numbers alone count as one."""
    groups: dict[str, list[tuple[str, str]]] = {}
    for trial in trials:
        for warning in trial.estimate.warnings:
            run = f"{trial.method} {trial.load:.0f} kg"
            groups.setdefault(re.sub(r"[0-9.]+", "#", warning), []).append((run, warning))
    sentences = []
    for runs in groups.values():
        first, warning = runs[0]
        others = ", ".join(run for run, _ in runs[1:])
        sentences.append(f"{first}: {warning}" + (f" (likewise: {others})" if others else ""))
    return sentences


THEORY = (
    "Theory: what the method itself identified without payload, plus the known weights; offsets must stay. s0 is (27), "
    "of the recorded forces [N]. m in kg, zC in mm, IC33 in kg m², f_q0_3 in N, k0 in N/m, k1 in N m/m."
)


def _std_charts(trials: Sequence[Trial]) -> list[Chart]:
    """Reported standard deviations without payload, at each method's own s0, and for one second of measuring."""
    bare = [s for s in trials if s.weights == 0]
    timed = [(s, s.duration**0.5) for s in bare if s.duration is not None]
    words = "Reported standard deviations without payload, at each method's own residuals"
    kinds = [("std", words, [(s, {n: v.reported for n, v in s.estimate.physical.items()}) for s in bare])]
    if bare and all(s.scatter for s in bare):
        words = (
            "What these deviations are in truth: over simulated machines whose errors of the pose differ, and which "
            "therefore repeat wherever a motion comes back to a pose"
        )
        kinds.append(("std-true", words, [(s, dict(s.scatter)) for s in bare]))
    if timed:
        words = "The same for one second of measuring: times the square root of the measuring time"
        each = [(s, {n: v.reported * root for n, v in s.estimate.physical.items()}) for s, root in timed]
        kinds.append(("std-per-second", words, each))
    charts = []
    for name, words, shown in kinds:
        series = [(s.method, d, {"color": colour(k), "symbol": "circle"}) for k, (s, d) in enumerate(shown)]
        caption = f"{words}, over the smallest of each parameter."
        charts.append(ratio_chart(name, caption, series, height=400, showlegend=True))
    return charts


def _std_table(trials: Sequence[Trial]) -> Markup:
    bare = [s for s in trials if s.weights == 0]
    names = list(dict.fromkeys(n for s in bare for n in s.estimate.physical))
    rows = [("measuring time", *("-" if s.duration is None else f"{s.duration:.1f} s" for s in bare))]
    rows.append(("s0", *(f"{s.s0:#.3g} N" for s in bare)))
    for name in names:
        estimates = [s.estimate.physical.get(name) for s in bare]
        scale, unit = legible(next(v.unit for v in estimates if v is not None))
        rows.append((f"std {name} [{unit}]", *("-" if v is None else f"{v.reported * scale:#.3g}" for v in estimates)))
    return table(("without payload", *(s.method for s in bare)), rows)


def _error_blocks(trials: Sequence[Trial]) -> list[Block]:
    """Errors of a simulated machine in reported standard deviations, with the band of random errors."""
    charts: list[Chart] = []
    for name in COMPARED:
        caption = f"{parameter_words(name).capitalize()}: points inside the band may be chance."
        figure = Chart(
            f"error-{name}", caption, "load [kg]", f"error of {name} / std", half=True, height=320, showlegend=True
        )
        _add_over_load(figure, trials, [trial.error(name) for trial in trials])
        figure.add_band(SUSPICIOUS, COLOURS[0], 0.12)
        if figure.data:
            charts.append(figure)
    words = "Estimate less truth of the simulated machine, in reported standard deviations; band: 3 of them."
    return [note(words), *charts] if charts else []


def _s0_chart(trials: Sequence[Trial]) -> Chart:
    caption = "s0 over the load: vibration and errors of the pose make it grow with the mass that is moved."
    figure = Chart("s0", caption, "load [kg]", "s0 [N]", height=340, showlegend=True)
    _add_over_load(figure, trials, [trial.s0 for trial in trials])
    figure.axes(y={"type": "log", "tickvals": [v * 10.0**k for k in range(-3, 5) for v in (1, 2, 5)]})
    return figure


def _add_over_load(figure: Chart, trials: Sequence[Trial], values: Sequence[float | None]) -> None:
    """Adds a line for each method that has values: these over the load."""
    for k, method in enumerate(_methods(trials)):
        own = [(s.load, v) for s, v in zip(trials, values, strict=True) if s.method == method and v is not None]
        if own:
            x, y = zip(*own, strict=True)
            figure.add("scatter", x=x, y=y, name=method, mode="lines+markers", line={"color": colour(k)})
