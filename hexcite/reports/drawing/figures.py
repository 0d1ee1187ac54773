"""Figures and tables that several pages show: a motion with its limits, and how close it comes to each."""

from collections.abc import Sequence

import numpy as np
from markupsafe import Markup

from cases.base.phrases import Phrase, phrase, said
from cases.base.units import DEG, MM
from cases.schema import Case
from hexcite.reports.drawing.chart import Axis, Chart, Rule, colour, lines
from hexcite.reports.drawing.marks import mark
from identification.limits.limit import TOLERANCE, LimitCheck, LimitReport, Status
from identification.motion.motion import Motion
from identification.texts import bounds_text, use_text

MOST_SHARE = 1.2  # largest share of a limit for which a bar has room


def motion_blocks(case: Case, motion: Motion) -> tuple[Chart, ...]:
    """Position, velocity and acceleration over time, each axis with its own limits."""
    home, box = case.need_motion("the report")
    rows = (
        ("position from home", "mm", "deg", motion.coordinates - home, box.coordinates, 1 / MM, 1 / DEG),
        ("velocity", "mm/s", "deg/s", motion.rates, np.outer((-1, 1), box.rate), 1 / MM, 1 / DEG),
        ("acceleration", "m/s²", "rad/s²", motion.accelerations, np.outer((-1, 1), box.acceleration), 1.0, 1.0),
    )
    charts = []
    for name, length_unit, angle_unit, values, limit, to_length, to_angle in rows:
        for kind, axes, unit, factor in (
            ("translation", ~box.turns, length_unit, to_length),
            ("rotation", box.turns, angle_unit, to_angle),
        ):
            if not axes.any():
                continue
            labels = [label for label, its in zip(box.labels, axes, strict=True) if its]
            chart = Chart(
                f"{name.split()[0]}-{kind}",
                f"{name[0].upper()}{name[1:]} of each {kind} over time; dashed: the limits of the axis in its colour.",
                lines(motion.t, values[:, axes] * factor, labels, 1.6),
                Axis("time [s]"),
                Axis(f"{name} [{unit}]"),
                tuple(
                    Rule("y", float(value), colour(k)) for row in limit[:, axes] * factor for k, value in enumerate(row)
                ),
                height=280,
                half=not axes.all(),
            )
            charts.append(chart)
    return tuple(charts)


# What a reader asks first: is a limit exceeded, which does nobody enforce, and then those that are ensured.
_LEFT_OUT = Status.STEPS, Status.LEFT_OUT
_ORDER = (Status.NOT_ENFORCED, *_LEFT_OUT, Status.PROVEN, Status.FOLLOWS, Status.ENFORCED)
_WORDS = {
    Status.PROVEN: "proven", Status.ENFORCED: "enforced by the controller", Status.NOT_ENFORCED: "nobody enforces it",
    Status.STEPS: "the controller steps, and does not limit it", Status.LEFT_OUT: "left out, as planned",
    Status.FOLLOWS: "follows from what the controller enforces",
}  # fmt: skip


def limits_table(report: LimitReport) -> Markup:
    """Use of each limit as a bar, what is exceeded first, then what nobody enforces, then what is ensured."""
    ordered = sorted(report.checks, key=lambda c: (not _exceeded(c), _ORDER.index(c.status), -c.ratio))
    rows = Markup("\n").join(map(_bar, ordered))
    return Markup('<div class="bars" role="list" aria-label="use of each limit">\n{}\n</div>').format(rows)


def _allowed(check: LimitCheck) -> Phrase:
    """The limit in words."""
    if check.kind.least:
        return phrase("allowed_least", "at least {limit}", limit=f"{check.limit:.4g}")
    if check.two_sided and check.bounds is not None and check.bounds[0] != -check.bounds[1]:
        low, high = (f"{end:.4g}" for end in check.bounds)
        return phrase("allowed_between", "from {low} to {high}", low=low, high=high)
    return phrase("allowed_limit", "limit {limit}", limit=bounds_text(check))


def _exceeded(check: LimitCheck) -> bool:
    """Whether a limit that counts is exceeded, or predicted to be."""
    return check.ratio > 1.0 + TOLERANCE and check.status is not Status.LEFT_OUT


def _bar(check: LimitCheck) -> Markup:
    exceeded = _exceeded(check)
    state = "over" if exceeded else "open" if check.status in (Status.NOT_ENFORCED, *_LEFT_OUT) else "sure"
    text = (
        '<div role="listitem" class="{}"><span class="what"{}>{}</span>{}<span class="share"{}>{}</span>'
        '<span class="value">{} <span{}>{}</span>, <span{}>{}</span>; <span{}>{}</span></span></div>'
    )
    words: str = _WORDS[check.status]
    if exceeded:
        words = phrase("exceeded_and", "EXCEEDED, {words}", words=said(words))
    width = 100.0 * min(check.ratio, MOST_SHARE) / MOST_SHARE
    # A least value has no share, and so no bar: it stands beside what it must not fall below.
    bar = Markup('<span class="track{}"><i style="width: {:.2f}%"></i></span>')
    track = bar.format(" none", 0.0) if check.kind.least else bar.format("", width)
    texts = (check.name, use_text(check, 1, check.unit.split()[0]), powers(check.unit), _allowed(check), words)
    name, share, unit, allowed, ensured = ((mark(each), each) for each in texts)
    return Markup(text).format(state, *name, track, *share, value_of(check), *unit, *allowed, *ensured)


def value_of(check: LimitCheck) -> str:
    """The worst value with four digits, without powers of ten."""
    return f"{check.worst:.4g}" if abs(check.worst) < 1e4 else f"{float(f'{check.worst:.3g}'):,.0f}".replace(",", " ")


def powers(unit: str) -> str:
    """A unit with its powers raised."""
    return unit.replace("^2", "²").replace("^3", "³")


def unit_of(channels: Sequence[str]) -> str:
    """The units in which the names of the channels end, such as `fx_N`, `mz_Nm`."""
    return ", ".join(dict.fromkeys(name.rsplit("_", 1)[-1].replace("Nm", "N m") for name in channels))
