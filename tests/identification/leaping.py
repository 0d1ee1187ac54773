"""A run of a controller without limit of jerk: what it does to forces between two samples no encoder shows clearly."""

import numpy as np

from cases.schema import load_case
from identification.machines.executed import Execution
from identification.machines.hexapod import Hexapod

CASE = load_case("hexapod")


def moves_without_jerk_limit(seed: int) -> Execution:
    """Point-to-point moves as LinuxCNC times them: accelerations step, and where moves meet leap for a single cycle."""
    draw, step = np.random.default_rng(seed), 1e-3
    accelerations = [np.zeros((300, 6))]
    for _ in range(8):
        half = np.tile(draw.uniform(-1.0, 1.0, 6) * [4.0, 4.0, 2.0, 6.0, 6.0, 6.0], (60, 1))
        leap = draw.choice([-1.0, 1.0], 6) * [0.7, 0.7, 0.4, 1.0, 1.0, 1.0]
        accelerations += [half, half[:1] + leap, half, -half, -half[:1] - leap, -half]
        accelerations += [-half, -half[:1] - leap, -half, half, half[:1] + leap, half]
    accelerations.append(np.zeros((300, 6)))
    way = np.cumsum(np.cumsum(np.vstack(accelerations), axis=0), axis=0) * step**2
    hexapod = Hexapod.of(CASE)
    return Execution.of_log(hexapod, step, hexapod.strut_lengths(CASE.machine.home.vector + way))
