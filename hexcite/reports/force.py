"""The page of external forces: what a run pulled and pressed with, over time."""

import numpy as np

from hexcite.reports.chart import Axis, Chart, lines
from hexcite.reports.page import Head, page, section, table, tiles
from identification.results.force import ExternalForce, on_clock
from identification.texts import value_text

_GROUPS = (
    ("force", "External force on the load, frame: {}.", slice(0, 3), "N"),
    ("moment", "External moment about the origin of the frame: {}.", slice(3, 6), "N m"),
)


def force_charts(force: ExternalForce) -> list[Chart]:
    """Force and moment over time, or over the numbers of standstills."""
    still = force.origin is None
    x = Axis("standstill" if still else "time [s]")
    return [
        Chart(
            name,
            words.format(force.frame),
            lines(force.t, force.wrench[:, own], "xyz", dots=still),
            x,
            Axis(f"{name} [{unit}]"),
        )
        for name, words, own, unit in _GROUPS
    ]


def force_page(force: ExternalForce) -> str:
    """The page of external force and moment over a recording."""
    rows, largest = [], []
    for name, _, own, unit in _GROUPS:
        rms, peak = force.rms[own], force.peak[own]
        rows += [
            (f"{name} {axis}", value_text(float(r), float(r) / 10.0), value_text(float(p), float(r) / 10.0), unit)
            for axis, r, p in zip("xyz", rms, peak, strict=True)
        ]
        largest.append((f"{peak.max():.3g} {unit}", f"largest {name} along an axis"))
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
        section("How large", tiles(*largest), table(("component", "rms", "peak", "unit"), rows)),
        section("Over time", *force_charts(force)),
    )
