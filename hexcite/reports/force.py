"""The page of external forces: what a run pulled and pressed with, over time."""

import numpy as np

from cases.base.phrases import Phrase, enumerated, phrase, said
from cases.recording_format import WRENCH
from hexcite.reports.drawing.chart import Axis, Chart, lines
from hexcite.reports.page import SOUND, Head, note, page, section, table, tiles
from identification.results.force import UNITS, ExternalForce, on_clock
from identification.texts import CAUSE, as_sentences, budget_cells, std_text, value_text


def _force_caption(frame: str) -> Phrase:
    words = "External force on the load, frame: {frame}. Dotted: U (k = 2) below and above."
    return phrase("force_over_time", words, frame=said(frame))


def _moment_caption(frame: str) -> Phrase:
    words = "External moment about the origin of the frame: {frame}. Dotted: U (k = 2) below and above."
    return phrase("moment_over_time", words, frame=said(frame))


_GROUPS = (
    ("force", _force_caption, slice(0, 3), "N"),
    ("moment", _moment_caption, slice(3, 6), "N m"),
)


def force_charts(force: ExternalForce) -> list[Chart]:
    """Force and moment over time, or over the numbers of standstills."""
    still = force.origin is None
    x = Axis("standstill" if still else "time [s]")
    charts = []
    for name, words, components, unit in _GROUPS:
        wrench, reach = force.wrench[:, components], force.expanded[:, components]
        ends = (lines(force.t, wrench + sign * reach, "xyz", 0.7, "dot") for sign in (-1.0, 1.0))
        series = (*lines(force.t, wrench, "xyz", dots=still), *(line for end in ends for line in end))
        caption = words(force.frame)
        charts.append(Chart(name, caption, series, x, Axis(f"{name} [{unit}]")))
    return charts


def unit_of_component(name: str) -> str:
    """Unit of a component of `WRENCH`."""
    return UNITS[WRENCH.index(name)]


def force_page(force: ExternalForce) -> str:
    """The page of external force and moment over a recording."""
    rows, largest = [], []
    for name, _, components, unit in _GROUPS:
        rms, peak, reach = force.rms[components], force.peak[components], force.typical_expanded[components]
        rows += [
            (
                f"{name} {axis}", value_text(float(r), float(r) / 10.0), value_text(float(p), float(r) / 10.0),
                std_text(float(u) / 2.0), std_text(float(u)), unit,
            )
            for axis, r, p, u in zip("xyz", rms, peak, reach, strict=True)
        ]  # fmt: skip
        largest.append((f"{peak.max():.3g} {unit}", f"largest {name} along an axis"))
    head, *parts = budget_cells({name: unit_of_component(name) for name in force.budget}, force.budget) or [()]
    budget = (table(head, [(row[0], *part[1:]) for row, part in zip(rows, parts, strict=True)]),) if parts else ()
    counts = [phrase("rms_of_deviations", "± and U (k = 2) are root mean squares over the recording")]
    if force.not_counted:
        kinds = enumerated("comma", [phrase(CAUSE, kind, name=kind) for kind in force.not_counted])
        counts.append(
            phrase("none_counted", "they count no tolerances of {kinds}: see [tolerances] of the case", kinds=kinds)
        )
    warnings, size = force.warnings, phrase("so_many_samples", "{count} samples", count=len(force.t))
    if force.origin is None:
        size = phrase("so_many_standstills", "{count} standstills", count=len(force.t))
    first = as_sentences(warnings[0] if warnings else SOUND)
    inputs = [("case", force.case), ("recording", force.recording), ("parameters", force.parameters)]
    if force.origin:
        inputs.append(("time 0", f"{on_clock(np.zeros(1), force.origin)[0]} s of the recorder's clock"))
    return page(
        "External force",
        Head(first, not warnings, force.case, (("recording", force.recording),)),
        phrase(
            "what_acted",
            "What acted on the load from outside over {recording}, {size}: measured forces less those that the "
            "parameters of {parameters} explain.",
            recording=force.recording,
            size=size,
            parameters=force.parameters,
        ),
        inputs,
        warnings[1:],
        section(
            "How large",
            tiles(*largest),
            table(("component", "rms", "peak", "±", "U (k = 2)", "unit"), rows),
            note(as_sentences(*counts)),
            *budget,
        ),
        section("Over time", *force_charts(force)),
    )
