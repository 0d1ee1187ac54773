"""`plot`: the matplotlib figure of a value, with what its page shows of it."""

from typing import TYPE_CHECKING, Any

import numpy as np

from cases.base.units import DEG, MM
from hexcite.reports.drawing.chart import Axis, Chart, Line, Points, colour, lines
from hexcite.reports.drawing.figures import unit_of
from hexcite.reports.drawing.still import drawn, machine_figure
from identification.motion.motion import sample

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from cases.schema import Case
    from hexcite.comparison.comparison import Comparison
    from hexcite.comparison.validation import Validation
    from identification.model_choice import ModelChoice
    from identification.recording.recording import Recording
    from identification.results.force import ExternalForce
    from identification.results.history import History
    from identification.results.identifiability import Identifiability
    from identification.results.result import Result
    from planner.bounds.bound import Bound
    from planner.plans.plan import Plan

DRAWN_RATE = 500.0  # [1/s]
SPAN = 3.0  # of log det for each parameter that is drawn of a bound


def plot(
    value: "Case | Plan | Recording | Result | Comparison | Validation | ModelChoice | Identifiability | Bound "
    "| ExternalForce | History",
) -> "Figure":
    """A matplotlib figure of a value: its `savefig` writes it, a notebook shows it.

    A case is drawn at home, a plan as motion with its limits (poses as machine in some of them), a recording as what
    moved and what was measured, a result as forces, residuals and accelerations (as correlations where it was loaded),
    a comparison as standard deviations side by side and accelerations of its runs, a validation with its residuals over
    the load, models of a run by what they predict, identifiability as correlations and R (Figure 3), a bound as
    D-efficiency up to it, an external force over time, a history as parameters over time.

    >>> hx.plot(hx.Result.load("empty-result")).savefig("correlations.svg")
    """
    match type(value).__name__:  # to import the types of all takes a second
        case "Case":
            from hexcite.reports.drawing.plots import case_figure

            return case_figure(value)  # type: ignore[arg-type]
        case "Plan":
            return _plan(value)
        case "Recording":
            return drawn(_recording(value))
        case "Result":
            return drawn(_result(value))
        case "Bound":
            return drawn([_bound(value)])
        case "ModelChoice":
            return drawn([_models(value)])
        case "Validation":
            from hexcite.reports.compare import std_chart
            from hexcite.reports.validation import growth_chart

            return drawn([std_chart(value.comparison.groups), growth_chart(value)])  # type: ignore[union-attr, arg-type]
        case "Identifiability":
            from hexcite.reports.identifiability import identifiability_charts

            return drawn(identifiability_charts(value))  # type: ignore[arg-type]
        case "Comparison":
            from hexcite.reports.compare import acceleration_blocks, std_chart

            groups = value.groups  # type: ignore[union-attr]
            return drawn([std_chart(groups), *(b for b in acceleration_blocks(groups) if isinstance(b, Chart))])
        case "History":
            from hexcite.reports.history import history_charts

            return drawn(history_charts(value))  # type: ignore[arg-type]
        case _:
            from hexcite.reports.force import force_charts

            return drawn(force_charts(value))  # type: ignore[arg-type]


def _plan(plan: Any) -> "Figure":
    from hexcite.reports.drawing.figures import motion_blocks
    from hexcite.reports.drawing.scene import posing_machine

    if len(plan.poses):
        return machine_figure(posing_machine(plan.case, plan.poses))
    return drawn(motion_blocks(plan.case, sample(plan.motion, DRAWN_RATE)))


def _recording(recording: Any) -> list[Chart]:
    """What moved, by its own clock, and what was measured; of standstills over their number."""
    case: Case | None = recording.case
    moving = recording.t is not None
    t = recording.t if moving else np.arange(1.0, len(recording.forces) + 1.0)
    x, charts = Axis("time [s]" if moving else "standstill"), []
    motion = recording.motion
    if motion is not None and motion.drives is not None:
        drives, at = motion.drives[~motion.bad], (motion.t if moving else t)[~motion.bad]
        columns = case.drive_columns if case is not None else tuple(f"drive {k + 1}" for k in range(drives.shape[1]))
        units = np.array([DEG if column.endswith("_deg") else MM for column in columns])
        titles = dict.fromkeys("[deg]" if unit == DEG else "[mm]" for unit in units)
        series = lines(at, drives / units, columns, dots=not moving)
        charts.append(Chart("drives", "What moved the sensors.", series, x, Axis(f"position {', '.join(titles)}")))
    channels = case.sensor_frame.channels if case is not None else tuple(f"channel {k}" for k in range(1, 7))
    title = f"force [{unit_of(channels)}]" if case is not None else "force [N, or N and N m]"
    series = lines(t, recording.forces, channels, 1.0, dots=not moving)
    return [*charts, Chart("forces", "What the sensors measured.", series, x, Axis(title))]


def _result(result: Any) -> list[Chart]:
    from hexcite.reports.identify import acceleration_blocks, correlation_chart, residual_charts

    residuals = result.residuals
    if residuals is None:
        return [correlation_chart(result)]
    accelerations = [block for block in acceleration_blocks(result) if isinstance(block, Chart)]
    return [*residual_charts(result.case, residuals), *accelerations]


def _bound(bound: Any) -> Chart:
    """D-efficiency over log det, up to the bound, with the best design that was found."""
    best = bound.efficiency(bound.design_logdet)
    ends = bound.logdet - SPAN * bound.parameters, bound.logdet
    x = np.linspace(*ends, 200)
    y = np.exp((x - bound.logdet) / bound.parameters)
    return Chart(
        "bound",
        f"D-efficiency of a motion over the log det of its mean information, {bound.parameters} parameters. No motion "
        f"inside the box exceeds the end of the line ({bound.label}).",
        (
            Line(x, y, "D-efficiency", colour(0)),
            Points(np.array([bound.design_logdet]), np.array([best]), "best design found, no motion", colour(1)),
            Points(np.array([bound.logdet]), np.ones(1), f"bound ({bound.label})", colour(2), hollow=True),
        ),
        Axis("log det F, reference scaling"),
        Axis("D-efficiency", ends=(0.0, 1.05)),
    )


def _models(choice: Any) -> Chart:
    """What each model leaves of the forces that it was fitted to, and of those that were left out."""
    rows = [row for row in choice.rows if row.reason is None]
    at = np.arange(len(rows), dtype=float)
    names = tuple(f"model {row.model}{' (preferred)' if row.model == choice.best else ''}" for row in rows)
    return Chart(
        "models",
        f"Each model of a run: s0 (27), and the rms of its errors on {choice.blocks} blocks of {choice.of} that were "
        "left out, behind the evaluation's filter.",
        (
            Points(at, np.array([row.predicted for row in rows]), "predicted, left out", colour(0)),
            Points(at, np.array([row.s0 for row in rows]), "s0 (27)", colour(1), hollow=True),
        ),
        Axis(ends=(-0.6, len(rows) - 0.4), names=names, tilt=60.0),
        Axis("force [N, or 1 where weighted]", logarithmic=True),
    )
