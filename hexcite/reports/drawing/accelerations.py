"""Accelerations of the load's frame, planned and measured (Figure 5)."""

import casadi as ca
import numpy as np

from cases.base.phrases import Phrase, phrase
from cases.base.units import Array
from cases.schema import Case
from hexcite.reports.drawing.chart import Axis, Chart, Dash, lines
from identification.machines.casadi_batch import over_samples
from identification.machines.of_case import machine_of
from identification.motion.motion import Trajectory, sample
from identification.results.estimate import Estimate
from identification.samples.moving import MovingRun

RATE = 200.0  # [1/s] at which a plan is drawn
POINTS = 700  # of a line: there are twelve on a page
AXES = (("translation", slice(0, 3), ("x", "y", "z"), "m/s²"), ("rotation", slice(3, 6), ("a", "b", "c"), "rad/s²"))
Accelerations = tuple[Array, Array]
"""Times, shape (n,) [s], and twist rates in {B}, shape (n, 6) [m/s^2, rad/s^2]."""


def planned_accelerations(case: Case, motion: Trajectory, begins: float = 0.0) -> Accelerations:
    """Those of a plan, which begins at a time of the run [s]."""
    machine = machine_of(case)
    state = [ca.SX.sym(name, machine.count) for name in ("coordinates", "rates", "accelerations")]
    function = ca.Function("twist_rate", state, [ca.densify(machine.frame(*state)[3])])
    path = sample(motion, RATE)
    return path.t + begins, over_samples(function, path.coordinates, path.rates, path.accelerations)[0]


def measured_accelerations(estimate: Estimate) -> Accelerations | None:
    """Those of a run by its drives, behind the evaluation's filter; None where nothing moves, or it is not known."""
    samples, at = estimate.samples, estimate.at
    if isinstance(samples, MovingRun):
        return samples.t, samples.kinematics(at).twist_rate
    motion = samples.motion(at)
    if motion is None or motion.by_accelerometer or not samples.nuisances:
        return None
    return samples.t[motion.known], motion.load.twist_rate[motion.known]


def acceleration_charts(
    measured: Accelerations | None, planned: Accelerations | None, name: str = "", of: str = ""
) -> tuple[Chart, ...]:
    """Figure 5: measured and planned accelerations over time.

    Args:
        name: what the names of the figures end in, where there are several on a page.
        of: whose they are, for the caption.
    """
    charts = []
    for kind, axes, labels, unit in AXES:
        series = () if measured is None else lines(measured[0], measured[1][:, axes], labels, 1.2, most=POINTS)
        if planned is not None:
            dash: Dash = "dash" if measured is not None else "solid"
            series += lines(planned[0], planned[1][:, axes], labels, 1.2, dash, most=POINTS)
        shown = phrase("lines_and_dashed", "lines: by the drives, behind the evaluation's filter; dashed: planned")
        if planned is None:
            shown = phrase("drives_alone_shown", "by the drives, behind the evaluation's filter")
        elif measured is None:
            shown = phrase("of_plan_alone", "planned")
        charts.append(
            Chart(
                f"figure5-{kind}{name}",
                _caption(kind, of, shown),
                series,
                Axis("time [s]"),
                Axis(f"acceleration [{unit}]"),
                height=260,
                half=True,
            )
        )
    return tuple(charts)


def _caption(kind: str, of: str, shown: Phrase) -> Phrase:
    words = phrase("of_translation", "Accelerations of the translation of the load's frame")
    if kind == "rotation":
        words = phrase("of_rotation", "Accelerations of the rotation of the load's frame")
    base = "{B}"
    if of:
        whole = "{words} in {base} of {name}: {shown}."
        return phrase("accelerations_of", whole, words=words, base=base, name=of, shown=shown)
    return phrase("accelerations", "{words} in {base}: {shown}.", words=words, base=base, shown=shown)


def summary(measured: Accelerations, planned: Accelerations) -> Phrase:
    """How far measured accelerations are from those planned, rms over what both hold, in words."""
    inside = (measured[0] >= planned[0][0]) & (measured[0] <= planned[0][-1])
    if not np.any(inside):
        return phrase("no_time_shared", "plan and run share no time")
    expected = np.array([np.interp(measured[0][inside], planned[0], column) for column in planned[1].T]).T
    away = measured[1][inside] - expected
    sizes = {}
    for kind, axes, _, unit in AXES:
        size, whole = np.sqrt(np.mean(away[:, axes] ** 2)), np.sqrt(np.mean(expected[:, axes] ** 2))
        sizes[kind] = phrase(
            "rms_of", "{size} of {whole} {unit} rms", size=f"{size:.2g}", whole=f"{whole:.2g}", unit=unit
        )
    return phrase(
        "measured_less_planned",
        "measured less planned accelerations: translation {translation}, rotation {rotation}",
        **sizes,
    )
