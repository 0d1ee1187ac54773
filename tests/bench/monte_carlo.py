"""Predicted standard deviations against 500 simulated runs; bias and spread with noise in the accelerations."""

from threading import Event

import numpy as np

from cases.schema import Case, load_case
from identification.motion.motion import Trajectory
from planner.families.settings import Fourier
from planner.plans.making import search
from planner.request import Request
from planner.search.parallel import silent, workers
from tests.bench.tables import print_table
from tests.planner.monte_carlo import monte_carlo, vibrating, vibrating_runs

ACCELERATION_NOISE = 0.1  # [m/s^2, rad/s^2] of measured accelerations, in the regressor
VIBRATION = (1.0, 0.05, 1.0)  # [N, m/s^2, rad/s^2] of the machine, felt by the sensors


def monte_carlo_table() -> None:
    """Prints both for a planned Fourier motion of 3 s."""
    case = load_case("hexapod")
    request = Request(Fourier(), duration=3.0, starts=2)
    with workers(Event()) as run:
        motion = search(request, case, silent, run).motion
    white = monte_carlo(case, motion, 500, 1.0, 0.0)
    noisy = monte_carlo(case, motion, 50, 1.0, ACCELERATION_NOISE)
    rows = [
        [name, f"{p:.3g}", f"{f / p:.3f}", f"{b / p:+.2f}", f"{g / p:.2f}", f"{c / p:+.2f}"]
        for name, p, f, b, g, c in zip(
            white.names, white.predicted, white.found, white.bias, noisy.found, noisy.bias, strict=True
        )
    ]
    columns = (
        "parameter",
        "predicted std",
        "found / predicted",
        "bias / std",
        "noisy: spread / std",
        "noisy: bias / std",
    )
    worst = float(np.abs(white.found / white.predicted - 1).max())
    rows.append(["off by at most", "wanted: 10 %", f"{100 * worst:.1f} %", "", "", ""])
    print_table("500 runs with white force noise", columns, rows)
    _vibrating(case, motion)


def _vibrating(case: Case, motion: Trajectory) -> None:
    """500 runs of a machine that vibrates as its case states, by weights."""
    found = {w: vibrating_runs(vibrating(case, *VIBRATION, w), motion, 500) for w in ("equal", "stated")}
    equal, stated = found["equal"], found["stated"]
    rows = [
        [name, f"{e:.3g}", f"{f / e:.3f}", f"{p:.3g}", f"{s / p:.3f}", f"{b / p:+.2f}", f"{s / f:.2f}"]
        for name, e, f, p, s, b in zip(
            equal.names, equal.predicted, equal.found, stated.predicted, stated.found, stated.bias, strict=True
        )
    ]
    columns = (
        "parameter", "predicted, W = 1", "found / predicted", "predicted, W stated", "found / predicted", "bias / std",
        "found stated / equal",
    )  # fmt: skip
    force, linear, angular = VIBRATION
    noise = f"{force:g} N, {linear:g} m/s^2, {angular:g} rad/s^2"
    print_table(f"500 runs of a machine that vibrates ({noise}), by the weights of the identification", columns, rows)
