"""The page of a validation: what each method costs and gives without payload, Table 7, and residuals over the load."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from cases.base.provenance import provenance
from hexcite.comparison.trials import METHODS, SHOWN, Trial
from hexcite.comparison.validation import OFF, Validation, entry_of_trial
from hexcite.reports.compare import comparison_head, figure_rows, parameter_columns, parameter_rows, std_chart
from hexcite.reports.drawing.chart import Axis, Chart, Line, colour
from hexcite.reports.page import Block, Head, note, page, section, table
from identification.texts import legible

TABLE_7 = ("load", "s0", *(label for n in SHOWN for label in ((n,) if n[0] == "k" else (n, "dev."))))
LEAST_DEVIATION = 1e-12  # the first trial is its own theory
THEORY = (
    "Theory: what the method itself identified without payload, plus the known weights; offsets must stay. s0 is (27), "
    "of the recorded forces [N]. m in kg, zC in mm, IC33 in kg m², f_q0_3 in N, k0 in N/m, k1 in N m/m."
)


UNDISTURBED = (
    "The order of the methods is that of this machine with its vibration, ripple and errors of the pose. Without them "
    "it may be another, as for a manual motion (D9M) and a Fourier series (D9N), Table 6: compare results of runs on "
    "the virtual controller, which are undisturbed."
)


def table_7(trials: Sequence[Trial]) -> list[list[str]]:
    """Rows as in Table 7, one a load: values with their relative deviation from theory."""
    rows = []
    for trial in trials:
        row = [trial.load_words, f"{trial.s0:.2f}"]
        for name in SHOWN:
            value = trial.result.parameters.get(name)
            row.append("-" if value is None else f"{value.value * legible(value.unit)[0]:.2f}")
            if name[0] != "k":
                deviation = trial.deviation(name) or 0.0
                row.append("" if abs(deviation) < LEAST_DEVIATION else f"{100 * deviation:+.2f} %")
        rows.append(row)
    return rows


OFF_BY = "Off by, in reported standard deviations: what was added, from what is known of the weights."


def errors_of(trials: Sequence[Trial]) -> tuple[list[str], list[list[str]]]:
    """Head and rows, one a load: errors in reported standard deviations."""
    names = list(dict.fromkeys(name for trial in trials for name in trial.errors))
    rows = [
        [trial.load_words, *(f"{trial.errors[n]:+.1f}" if n in trial.errors else "-" for n in names)]
        for trial in trials
        if trial.errors
    ]
    return ["load", *names], rows


def validation_page(validation: Validation) -> str:
    """The page of `hexcite validate`."""
    return _measured_page(validation) if validation.measured else _methods_page(validation)


def _measured_page(validation: Validation) -> str:
    """Results of runs with known weights: what was added, Table 7 of this machine, and all parameters."""
    case, trials = validation.case, validation.trials
    (sentence,) = validation.sentences
    near = all(abs(error) <= OFF for trial in trials for error in trial.errors.values())
    entries = [replace(entry_of_trial(case, trial), name=trial.load_words) for trial in trials]
    head = Head(f"{sentence[0].upper()}{sentence[1:]}.", near and not validation.warnings, validation.machine)
    return page(
        f"Known weights: {case.heading}",
        head,
        f"Weights of {', '.join(entry.name for entry in entries)}, each run identified, and set beside what is known "
        "of the weights.",
        (
            *((entry.name, trial.result.source) for entry, trial in zip(entries, trials, strict=True)),
            *_inputs(validation),
        ),
        validation.warnings,
        section("What was added", note(OFF_BY), table(*errors_of(trials))),
        section("Values and deviations from theory (Table 7)", note(THEORY), table(TABLE_7, table_7(trials))),
        section(
            "All parameters",
            table(parameter_columns(entries), parameter_rows(entries)),
            table(("", *(entry.name for entry in entries)), figure_rows(entries)),
        ),
        section("Residuals over the load", growth_chart(validation)),
    )


def _inputs(validation: Validation) -> tuple[tuple[str, str], ...]:
    """What it was made of: names and values."""
    case, payloads = validation.case, validation.case.payloads
    assert payloads is not None
    return (
        ("case", f"{case.name} (hash {case.hash})"),
        ("machine", validation.machine),
        ("weights", payloads.source),
        *provenance([])["versions"].items(),
    )


def _methods_page(validation: Validation) -> str:
    """Methods on a simulated machine, side by side."""
    case, comparison = validation.case, validation.comparison
    by_method: dict[str, list[Trial]] = {}
    for trial in validation.trials:
        by_method.setdefault(trial.method, []).append(trial)
    tables: list[Block] = []
    for method, trials in by_method.items():
        lasting, model = trials[0].duration or 0.0, trials[0].result.record.model
        words = f"{method} ({METHODS[method].label}), {lasting:.1f} s, model {model}"
        tables += [note(words), table(TABLE_7, table_7(trials))]
    entries = comparison.entries
    mounted = ", ".join(dict.fromkeys(trial.load_words for trial in validation.trials))
    return page(
        f"Validation with payloads: {case.heading}",
        comparison_head(comparison)._replace(machine=validation.machine),
        f"Known weights of {mounted} mounted one after the other and identified by {len(by_method)} methods on "
        f"{validation.machine}.",
        _inputs(validation),
        (*(f"{method} was not run: {why}" for method, why in validation.failed.items()), *comparison.warnings),
        section("Recommendation", *map(note, validation.sentences)),
        section(
            "Without payload, side by side",
            std_chart(comparison.groups),
            table(parameter_columns(entries), parameter_rows(entries)),
            table(("", *(entry.name for entry in entries)), figure_rows(entries)),
        ),
        section("Values and deviations from theory (Table 7)", note(THEORY), note(UNDISTURBED), *tables),
        section("Residuals grow with the load", growth_chart(validation)),
    )


def growth_chart(validation: Validation) -> Chart:
    """Values of s0 by each method over the load."""
    caption = "s0 over the load: vibration and errors of the pose make it grow with the mass that is moved."
    series = []
    for k, method in enumerate(dict.fromkeys(trial.method for trial in validation.trials)):
        trials = [trial for trial in validation.trials if trial.method == method]
        loads, s0 = np.array([t.load for t in trials]), np.array([t.s0 for t in trials])
        series.append(Line(loads, s0, method, colour(k), dots=True))
    return Chart("s0", caption, tuple(series), Axis("load [kg]"), Axis("s0 [N]", logarithmic=True), height=340)
