"""The page of an identification: parameters with standard deviations, residuals, correlations of the estimates."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from markupsafe import Markup

from cases.base.phrases import Phrase, enumerated, phrase, said
from cases.base.units import Array
from cases.schema import Case
from hexcite._identifiability import identifiability_of_models
from hexcite.reports.drawing.accelerations import (
    acceleration_charts,
    measured_accelerations,
    planned_accelerations,
    summary,
)
from hexcite.reports.drawing.chart import Axis, Chart, Heat, Rule, lines
from hexcite.reports.drawing.densities import density_charts, normal_chart
from hexcite.reports.drawing.figures import unit_of
from hexcite.reports.identifiability import identifiability_blocks
from hexcite.reports.page import SOUND, Block, Head, note, page, section, table, tiles
from identification.findings.noise_level import noise_of_channels, stated_noise
from identification.model_choice import figures_of, table_3
from identification.options import FrameName
from identification.recording.record import RunOrigin
from identification.results.result import Result
from identification.results.result_rows import physical_rows, pooled_rows, scatter_rows, treatment_rows
from identification.results.verdicts import accept
from identification.signals import Residuals
from identification.texts import (
    CAUSE,
    as_sentences,
    budget_cells,
    carries_rods,
    legible,
    value_cells,
    value_text,
    with_deviation,
)

PARAMETER_COLUMNS = ("parameter", "value", "±", "U (k = 2)", "unit", "95 % from", "to", "std (28)", "std robust")


def identify_page(result: Result) -> str:
    """The page of a result; residuals are shown where it was not loaded from a folder."""
    case, record, residuals = result.case, result.record, result.residuals
    samples = phrase("so_many_samples", "{count} samples", count=record.samples)
    if record.delay_s is None:
        samples = phrase("so_many_averaged", "{count} averaged standstills", count=record.samples)
    source = record.recording
    run = record.run
    origin = run_inputs(run) if run else (("origin", "recorded on a machine: nothing says that it was simulated"),)
    origin += tuple((i["file"], f"SHA-256 {i['sha256']}") for i in record.inputs)
    origin += tuple(record.versions.items())
    sections = []
    if case.accept is not None:
        verdict = accept(result)
        columns, *rows = verdict.rows()
        unjudged: tuple[Markup, ...] = ()
        if verdict.unjudged:
            reasons = phrase(
                "not_judged_are", "not judged: {reasons}", reasons=enumerated("semicolon", verdict.unjudged)
            )
            unjudged = (note(as_sentences(reasons)),)
        title = phrase("verdict_is", "Verdict: {verdict}", verdict=said(verdict.word))
        sections.append(section(title, table(columns, rows, left=2), *unjudged))
    sections.append(section("Parameters with standard deviations", _headline(result), *parameter_blocks(result)))
    if in_frames := frame_blocks(result):
        sections.append(section("The load at the robot's flange", *in_frames))
    if record.treatment is not None:
        (columns, *rows), words = treatment_rows(record.treatment), record.treatment["words"]
        text = "Evaluated: {words}. Differences are shares of the default's deviations."
        text = phrase("evaluated_as", text, words=said(words))
        sections.append(section("Treatment of the data beside the default", note(text), table(columns, rows)))
    if columns_and_rows := physical_rows(result.parameters, record.physical):
        columns, *rows = columns_and_rows
        words = "Estimates are made without asking whether a body can have them; this one can, and keeps [bounds]."
        sections.append(section("Nearest body that can exist", note(words), table(columns, rows)))
    if record.pooled is not None:
        words = "Runs are compared by their own noise; tolerances of the case, which they have in common, count once."
        both = (table(columns, rows) for columns, *rows in (pooled_rows(record.pooled), scatter_rows(record.pooled)))
        sections.append(section("The runs, and how far they scatter", note(words), *both))
    if record.models is not None:
        sections.append(section("All models of the run (Table 3)", *model_blocks(record.models)))
    if residuals is not None:
        sections.append(section("Forces and residuals", *misfit_blocks(result), *residual_blocks(case, residuals)))
        if accelerations := acceleration_blocks(result):
            sections.append(section("Accelerations, planned and measured", *accelerations))
    sections.append(section("Parameters that take each other's part", *correlation_blocks(result)))
    if densities := density_charts(result.parameters):
        sections.append(section("Normal densities of the parameters (Table 5)", *densities))
    if residuals is not None:
        blocks_of_models = identifiability_blocks(identifiability_of_models(result), record.model)
        sections.append(section("Which parameters can be told apart", *blocks_of_models))
    return page(
        phrase("page_of_result", "Identification: {machine}", machine=case.heading_phrase),
        identified_head(result),
        phrase(
            "identified_from",
            "Model {model} identified from {samples} of {source}.",
            model=record.model,
            samples=samples,
            source=source,
        ),
        (("case", f"{case.name} (hash {case.hash})"), ("recording", source), *origin),
        result.warnings[1:],
        *sections,
    )


def model_blocks(choice: Mapping[str, Any]) -> tuple[Block, ...]:
    """Table 3 of a run, what each model predicts of what is left out, and which is preferred."""
    (columns, *rows), (names, *values) = figures_of(choice), table_3(choice)
    words = (f"{sentence[0].upper()}{sentence[1:]}." for sentence in choice["sentences"])
    return table(columns, rows), *map(note, words), table(names, values)


def identified_head(result: Result) -> Head:
    """What the page of a result begins with."""
    parameters, warnings = result.parameters, result.warnings
    mass = parameters.get("m")
    parts: list[str] = []
    if mass is not None:
        parts.append(phrase("mass_is", "mass {value} kg", value=with_deviation(mass.value, mass.reported)))
    parts.append(warnings[0] if warnings else SOUND)
    if len(warnings) > 1:
        parts.append(phrase("more_below", "{count} more below", count=len(warnings) - 1))
    facts = [("recording", str(result.record.recording))]
    if result.record.run is not None and (program := result.record.run.program) is not None:
        facts.append(("program", str(program)))
    return Head(as_sentences(*parts), not warnings, result.case.name, tuple(facts))


def _headline(result: Result) -> Markup:
    body = (("m", 1.0, "kg", "mass, with its standard deviation"), ("zC", 1e3, "mm", "centre of gravity, z"))
    parameters = result.parameters
    figures = [
        (f"{with_deviation(parameters[name].value * scale, parameters[name].reported * scale)} {unit}", text)
        for name, scale, unit, text in body
        if name in parameters  # a frame that does not move determines offsets alone
    ]
    condition, rank = result.record.condition, result.record.rank
    figures += [
        noise_tile(result),
        (f"{condition:.3g}", phrase("condition_and_rank", "condition of the scaled regressor, rank {rank}", rank=rank)),
    ]
    return tiles(*figures)


def correlations(result: Result) -> tuple[list[str], Array]:
    """Names of the estimated parameters, and their correlations by (28), shape (u, u)."""
    std = np.sqrt(np.diag(result.covariance))
    free = np.flatnonzero(std > 0.0)  # what was given correlates with nothing
    correlation = result.covariance[np.ix_(free, free)] / np.outer(std[free], std[free])
    return [result.model.names[k] for k in free], correlation


def correlation_chart(result: Result) -> Chart:
    """Magnitudes of the correlations of the estimated parameters."""
    names, correlation = correlations(result)
    return Chart(
        "correlation",
        "Magnitude of the correlation of two estimates; near 1 only their sum or difference is known well.",
        (Heat(np.abs(correlation)),),
        Axis(names=tuple(names), tilt=90.0),
        Axis(names=tuple(names), downwards=True),
        height=560,
    )


def correlation_blocks(result: Result) -> tuple[Block, ...]:
    """Correlations of the estimated parameters, and the strongest pairs."""
    names, correlation = correlations(result)
    first, second = np.triu_indices(len(names), 1)
    strongest = np.argsort(-np.abs(correlation[first, second]))[:5]
    rows = [
        (f"{names[i]} ~ {names[j]}", f"{correlation[i, j]:+.3f}")
        for i, j in zip(first[strongest], second[strongest], strict=True)
    ]
    return (correlation_chart(result), table(("strongest correlations", "value"), rows))


def noise_tile(result: Result) -> tuple[str, str]:
    """Value of s0 and its meaning; white noise does not contain what a filter removes from the recorded forces."""
    record = result.record
    if record.weights != "equal":
        words = phrase(
            "s0_weighted",
            "s0 (27), 1 where the weights are right (white noise {noise}, recorded forces less the model {rest} N rms)",
            noise=f"{record.white_noise:.3g}",
            rest=f"{record.s0_N:.3g}",
        )
        return f"{record.s0:.3g}", words
    noise = phrase("noise_standing", "white noise {noise} N", noise=f"{record.white_noise:.3g}")
    if record.delay_s is not None:
        by_band = "white noise by the filter's pass band {noise} N"
        noise = phrase("noise_moving", by_band, noise=f"{record.white_noise:.3g}")
    return f"{record.s0:.3g} N", phrase("s0_newtons", "s0 (27), recorded forces less the model ({noise})", noise=noise)


def parameter_blocks(result: Result) -> tuple[Block, ...]:
    """Table of the parameters."""
    rows, freedom, rods = [], float(result.record.degrees_of_freedom), carries_rods(result.parameters)
    for name, p in result.parameters.items():
        scale, unit = legible(p.unit)
        low, high = p.interval(freedom)
        ends = (value_text(v * scale, p.reported * scale) for v in (low, high))
        words, value, widest, expanded, *stds, _ = value_cells(name, p, rods)
        rows.append((words, value, widest, expanded, unit, *ends, *stds))
    delay = delay_words(result)
    larger = "± is the larger of std (28), which takes the noise as white, and std robust, which does not"
    counted = [phrase("larger_of_both", larger)]
    if result.not_counted:
        kinds = enumerated("comma", [phrase(CAUSE, kind, name=kind) for kind in result.not_counted])
        counted.append(
            phrase("none_counted", "they count no tolerances of {kinds}: see [tolerances] of the case", kinds=kinds)
        )
    return (
        table(PARAMETER_COLUMNS, rows),
        note(as_sentences(*counted)),
        *_budget(result),
        *map(note, [*([] if delay is None else [delay]), *map(as_sentences, result.notes)]),
    )


def frame_blocks(result: Result) -> tuple[Block, ...]:
    """Tables of the load in the frames of the robot that the case states; none where it states none."""
    case = result.case
    if case.flange_from_sensor is None or "m" not in result.parameters:
        return ()
    blocks: list[Block] = []
    frames: tuple[FrameName, ...] = ("flange",) if case.tcp is None else ("flange", "tool")
    for frame in frames:
        body = result.in_frame(frame)
        rows = [(*value_cells(name, value)[:4], legible(value.unit)[1]) for name, value in body.parameters.items()]
        about = "About and along the axes of {frame}:"
        blocks.append(note(phrase("about_axes_of", about, frame=said(body.place.words))))
        blocks.append(table(("parameter", "value", "±", "U (k = 2)", "unit"), rows))
    return tuple(blocks)


def _budget(result: Result) -> tuple[Block, ...]:
    """The parts of each deviation by their causes; nothing where the case states no tolerances."""
    head, *rows = budget_cells({n: p.unit for n, p in result.parameters.items()}, result.budget) or [()]
    about = "Squares of the parts add up to that of ±; tolerances are carried through to first order."
    return (table(head, rows), note(about)) if rows else ()


def delay_words(result: Result) -> Phrase | None:
    """Delay of the forces behind the motion, in words; None where it was not estimated."""
    delay = result.record.delay_s
    if delay is None:
        return None
    lag, std = delay.value * 1e3, delay.std * 1e3
    later = "Forces lag the motion by {lag} ± {std} ms: estimated with the parameters."
    return phrase("forces_lag", later, lag=f"{lag:.3f}", std=f"{std:.3f}")


def residual_charts(case: Case, residuals: Residuals) -> list[Chart]:
    """Forces, residuals over time and their spectrum."""
    channels = case.sensor_frame.channels
    at, unit = "time [s]" if residuals.step is not None else "standstill", unit_of(channels)
    source = "Lines: recorded, behind the evaluation's low-pass. Dotted: the identified model."
    if residuals.filtered is None:
        source = "Lines: recorded. Dotted: the identified model."
    standing = residuals.step is None  # a few points, not a line
    forces = Chart(
        "forces",
        source,
        lines(residuals.t, residuals.explained, channels, 1.0, dots=standing)
        + lines(residuals.t, residuals.predicted, channels, 2.0, "dot", dots=standing),
        Axis(at),
        Axis(f"force [{unit}]"),
        height=340,
    )
    rest = Chart(
        "residuals",
        "What the model leaves of each channel. Noise without a pattern is good; waves and steps have a cause.",
        lines(residuals.t, residuals.evaluated, channels, 0.8, dots=standing),
        Axis(at),
        Axis(f"recorded - model [{unit}]"),
        height=320,
    )
    charts = [forces, rest]
    if not standing:
        charts.append(spectrum_chart(residuals, channels, case.recording.filter_cutoff_Hz))
    charts.append(normal_chart(residuals, channels))
    return charts


def acceleration_blocks(result: Result) -> tuple[Block, ...]:
    """Accelerations of the run beside those of its plan (Figure 5); none where nothing moves."""
    estimate = result.estimate
    measured = None if estimate is None else measured_accelerations(estimate)
    if estimate is None or measured is None:
        return ()
    planned = None if estimate.planned is None else planned_accelerations(result.case, *estimate.planned)
    words = () if planned is None else (note(as_sentences(summary(measured, planned))),)
    return (*acceleration_charts(measured, planned), *words)


def misfit_blocks(result: Result) -> tuple[Block, ...]:
    """What the residuals follow, and the noise of each channel beside what the case states."""
    blocks: list[Block] = []
    channels = result.case.sensor_frame.channels
    for finding in result.findings:
        if effects := finding.quantity.get("systematic"):
            rows = [(e["follows"], e["as_with"], f"{100 * e['share']:.2g} %", f"{e['chance']:.0e}") for e in effects]
            blocks.append(table(("residuals follow", "as with", "share of their power", "chance of it by noise"), rows))
    estimate = result.estimate
    noise_of_case = None if estimate is None else stated_noise(estimate.samples, estimate.fit, result.case)
    if estimate is not None and noise_of_case is not None:
        noise = noise_of_channels(estimate.samples, estimate.fit)
        rows = [
            (name, f"{n:.3g}", f"{s:.3g}", f"{n / s:.2g}")
            for name, n, s in zip(channels, noise, noise_of_case, strict=True)
        ]
        columns = ("channel", f"white noise by its residuals [{unit_of(channels)}]", "stated by the case", "ratio")
        blocks.append(table(columns, rows))
    return tuple(blocks)


def residual_blocks(case: Case, residuals: Residuals) -> tuple[Block, ...]:
    """Forces, residuals over time and their spectrum, and the size of the residuals."""
    channels = case.sensor_frame.channels
    rms = [(values**2).mean(axis=0) ** 0.5 for values in (residuals.evaluated, residuals.values)]
    rows = ((name, *(f"{r[k]:.3g}" for r in rms)) for k, name in enumerate(channels))
    return (
        *residual_charts(case, residuals),
        table(("channel", "residual as evaluated, rms", "of the forces as recorded"), rows),
    )


SHOWN_OF_RUN = ("controller", "program", "program_hash", "plan_hash", "seed", "payload", "simulation_source")


def run_inputs(about: RunOrigin) -> tuple[tuple[str, str], ...]:
    """Facts about a run: names and values."""
    simulated = "sensors and encoders are simulated" if about.simulated else "recorded on a machine"
    entries = about.to_json()
    facts = {key: entries[key] for key in SHOWN_OF_RUN if entries.get(key) is not None}
    words = {
        k: ", ".join(f"{n} {v}" for n, v in value.items()) for k, value in facts.items() if isinstance(value, Mapping)
    }
    return (("origin", simulated), *((key, words.get(key, str(value))) for key, value in facts.items()))


def spectrum_chart(residuals: Residuals, channels: Sequence[str], cutoff: float | None) -> Chart:
    """Amplitude spectral density of the residuals; the evaluation does not use frequencies above the cut-off."""
    frequency, density = residuals.spectrum()
    caption = "Of the forces as recorded."
    if cutoff is not None:
        caption = phrase(
            "spectrum_filtered",
            "Of the forces as recorded. Dashed: the evaluation's low-pass at {cutoff} Hz; what lies above it, as "
            "ripple of "
            "a controller, the estimate does not see.",
            cutoff=f"{cutoff:g}",
        )
    return Chart(
        "spectrum",
        caption,
        lines(frequency[1:], density[1:], channels, 1.2),
        Axis("frequency [Hz]", logarithmic=True),
        Axis(f"residual [{unit_of(channels)}/√Hz]", logarithmic=True),
        () if cutoff is None else (Rule("x", cutoff),),
        height=320,
    )
