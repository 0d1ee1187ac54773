"""The page of an identification: parameters with error bars, what determines them, and what the model leaves."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from cases.schema import Case
from identification.identifiability import Identifiability
from identification.recording import force_columns
from identification.result import Estimate
from identification.runs.residuals import Residuals
from planner.precision import std_text, value_text, with_deviation
from planner.reports.figures import (
    distribution_plot,
    forces_plot,
    identifiability_plots,
    parameters_plot,
    residuals_plot,
    spectrum_plot,
)
from planner.reports.page import Item, Note, Page, Plot, Section, Table, Tile, Tiles
from planner.runs.about import about_recording

PARAMETER_COLUMNS = ("parameter", "value", "std (28)", "std robust", "95 % from", "to", "unit")


def identify_page(
    case: Case, estimate: Estimate, found: Identifiability, residuals: Residuals, inputs: Sequence[tuple[str, str]]
) -> Page:
    """The page of `hexcite identify`.

    Args:
        case: of the recording.
        estimate: the result.
        found: what the run determines.
        residuals: of the recorded forces.
        inputs: where the recording came from, names and values.
    """
    what = "averaged standstills" if residuals.step is None else "samples"
    return Page(
        title=f"Identification: {case.title}",
        lead=f"Model {estimate.model} identified from {estimate.samples} {what} of {estimate.source}.",
        inputs=(("case", f"{case.name} (hash {case.hash})"), ("recording", estimate.source), *inputs),
        warnings=estimate.warnings,
        sections=(
            Section("Parameters with error bars", (_headline(estimate), *parameter_items(estimate))),
            Section("What the run determines", identifiability_items(found)),
            Section("Forces and residuals", residual_items(case, residuals)),
        ),
    )


def _headline(estimate: Estimate) -> Tiles:
    body = (("m", 1.0, "kg", "mass, with its standard deviation"), ("zC", 1e3, "mm", "centre of gravity, z"))
    tiles = [
        Tile(_with_error(estimate, name, scale, unit), text)
        for name, scale, unit, text in body
        if name in estimate.physical  # a frame that does not move tells offsets alone
    ]
    tiles += [
        noise_tile(estimate),
        Tile(f"{estimate.condition:.3g}", f"condition of the scaled regressor, rank {estimate.rank}"),
    ]
    return Tiles(tuple(tiles))


def noise_tile(estimate: Estimate) -> Tile:
    """s0, and what it is; a filter keeps from it what the recorded forces have above the pass band."""
    recorded = f"recorded forces less the model: {estimate.s0_N:.3g} N rms"
    if estimate.weights != "equal":
        return Tile(f"{estimate.s0:.3g}", f"s0, 1 where the weights are right ({recorded})")
    filtered = "" if estimate.delay is None else ", the filter's stop band included"
    return Tile(f"{estimate.s0:.3g} N", f"s0, noise of one force by the residuals ({recorded}{filtered})")


def _with_error(estimate: Estimate, name: str, scale: float, unit: str) -> str:
    value = estimate.physical[name]
    return f"{with_deviation(value.value * scale, value.reported * scale)} {unit}"


def parameter_items(estimate: Estimate) -> tuple[Item, ...]:
    """Figure and table of the parameters."""
    rows = []
    for name, p in estimate.physical.items():
        scale, unit = (1e3, "mm") if p.unit == "m" else (1.0, p.unit)
        low, high = p.interval(estimate.freedom)
        widest = p.reported * scale
        value, *ends = (value_text(v * scale, widest) for v in (p.value, low, high))
        rows.append((name, value, std_text(p.std * scale), std_text(p.std_robust * scale), *ends, unit))
    items: list[Item] = [
        parameters_plot({name: value._asdict() for name, value in estimate.physical.items()}),
        Table(PARAMETER_COLUMNS, tuple(rows)),
        Note("std (28) takes the noise as white; std robust allows for residuals that are correlated in time."),
    ]
    if estimate.delay is not None:
        lag, std = estimate.delay.value * 1e3, estimate.delay.std * 1e3
        items.append(Note(f"Forces lag the motion by {lag:.3f} ± {std:.3f} ms: estimated with the parameters."))
    items += [Note(note) for note in estimate.notes]
    return tuple(items)


def identifiability_items(found: Identifiability) -> tuple[Item, ...]:
    """Correlation, QR and the strongest pairs."""
    rows = tuple((f"{a} ~ {b}", f"{value:+.3f}") for a, b, value in found.strongest())
    return (*identifiability_plots(found), Table(("strongest correlations", "value"), rows))


def residual_items(case: Case, residuals: Residuals) -> tuple[Item, ...]:
    """Forces, residuals over time, their distribution and spectrum."""
    channels = force_columns(case)
    plots: list[Plot] = [forces_plot(residuals, channels), residuals_plot(residuals, channels)]
    plots.append(distribution_plot(residuals))
    if residuals.step is not None:
        plots.append(spectrum_plot(residuals, channels, case.recording.filter_cutoff_Hz))
    columns = [("residual, rms", residuals.left)]
    if residuals.filtered is not None:
        columns = [("residual behind the filter, rms", residuals.left), ("of the forces as recorded", residuals.values)]
    rms = [(values**2).mean(axis=0) ** 0.5 for _, values in columns]
    rows = tuple(
        (*name.rsplit("_", 1)[:1], *(f"{r[k]:.3g}" for r in rms), name.rsplit("_", 1)[1].replace("Nm", "N m"))
        for k, name in enumerate(channels)
    )
    return (*plots, Table(("channel", *(words for words, _ in columns), "unit"), rows))


def about_inputs(recording: Path, provenance: dict[str, Any]) -> tuple[tuple[str, str], ...]:
    """Where a run came from, for the page's inputs.

    Args:
        recording: file, or folder of `hexcite run`.
        provenance: `inputs` and `versions` of a result.
    """
    words = [(i["file"], f"SHA-256 {i['sha256']}") for i in provenance["inputs"]]
    words += provenance["versions"].items()
    about = about_recording(recording)
    if not about:
        return (("origin", "recorded on a machine: nothing says that it was simulated"), *words)
    return (*run_inputs(about), *words)


def run_inputs(about: dict[str, Any]) -> tuple[tuple[str, str], ...]:
    """What `recording.json`, or the answer of a run, says about it."""
    keys = ("controller", "program", "program_hash", "plan_hash", "seed", "payload", "simulation_source")
    simulated = "sensors and encoders are simulated" if about.get("simulated") else "recorded on a machine"
    return (("origin", simulated), *((key, _in_words(about[key])) for key in keys if about.get(key) is not None))


def _in_words(value: Any) -> str:
    if isinstance(value, dict):
        return ", ".join(f"{key} {inner}" for key, inner in value.items())
    return str(value)
