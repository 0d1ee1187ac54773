"""The page of external forces: what a run pulled and pressed with, over time."""

import numpy as np

from cases.recording_format import WRENCH
from hexcite.reports.drawing.chart import Axis, Chart, lines
from hexcite.reports.page import Head, note, page, section, table, tiles
from identification.results.force import UNITS, ExternalForce, on_clock
from identification.texts import budget_cells, std_text, value_text

_GROUPS = (
    ("force", "External force on the load, frame: {}.", slice(0, 3), "N"),
    ("moment", "External moment about the origin of the frame: {}.", slice(3, 6), "N m"),
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
        caption = f"{words.format(force.frame)} Dotted: U (k = 2) below and above."
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
    counts = "± and U (k = 2) are root mean squares over the recording."
    if force.not_counted:
        counts += f" They count no tolerances of {', '.join(force.not_counted)}: see [tolerances] of the case."
    warnings, size = force.warnings, f"{len(force.t)} {'standstills' if force.origin is None else 'samples'}"
    first = f"{warnings[0][0].upper()}{warnings[0][1:]}." if warnings else "Nothing speaks against this run."
    inputs = [("case", force.case), ("recording", force.recording), ("parameters", force.parameters)]
    if force.origin:
        inputs.append(("time 0", f"{on_clock(np.zeros(1), force.origin)[0]} s of the recorder's clock"))
    return page(
        "External force",
        Head(first, not warnings, force.case, (("recording", force.recording),)),
        f"What acted on the load from outside over {force.recording}, {size}: measured forces less those that the "
        f"parameters of {force.parameters} explain.",
        inputs,
        warnings,
        section(
            "How large",
            tiles(*largest),
            table(("component", "rms", "peak", "±", "U (k = 2)", "unit"), rows),
            note(counts),
            *budget,
        ),
        section("Over time", *force_charts(force)),
    )
