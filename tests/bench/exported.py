"""How long one call of the exported C takes: forward kinematics, model and external force of a moving machine."""

import json
import subprocess
import tempfile
from pathlib import Path

import numpy as np

from identification.machines.hexapod import Hexapod
from postprocessors.export.code import c_sources
from tests.helpers import Harmonic
from tests.postprocessors.export.calibrations import calibration
from tests.postprocessors.export.compiled import STRICT
from tests.simulated_machine import kinematics_of_coordinates

ROUNDS = 200
TIMER = r"""
#define _POSIX_C_SOURCE 200809L
#include <stdio.h>
#include <time.h>
#include "hexapod_force.h"
#include "motion.h"

int main(void)
{
    static hexapod_force_model model;
    struct timespec begin, end;
    double external[6], sum = 0.0, best = 1e9, worst = 0.0, one;
    long steps = 0, most = 0;
    int round, n;

    hexapod_force_init(&model);
    for (round = 0; round < ROUNDS; round++) {
        clock_gettime(CLOCK_MONOTONIC, &begin);
        for (n = 0; n < COUNT; n++) {
            if (hexapod_force_from_struts(&model, motion[n], motion[n] + 6, motion[n] + 12, motion[n] + 18, external))
                return 1;
            sum += external[2];
            steps += model.steps;
            if (model.steps > most && (round || n))
                most = model.steps;
        }
        clock_gettime(CLOCK_MONOTONIC, &end);
        one = ((double)(end.tv_sec - begin.tv_sec) * 1e6 + (double)(end.tv_nsec - begin.tv_nsec) * 1e-3) / COUNT;
        if (one < best)
            best = one;
        if (one > worst)
            worst = one;
    }
    printf("{\"best\": %.3f, \"worst\": %.3f, \"steps\": %.2f, \"most\": %ld, \"sum\": %g}\n", best, worst,
        (double)steps / ((double)ROUNDS * COUNT), most, sum);
    return 0;
}
"""


def exported() -> list[list[str]]:
    """Rows of figures: microseconds a call at 1 kHz, and steps of the forward kinematics."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        made = calibration(folder, "hexapod", 9)
        header, source = c_sources(made, "hexapod_force")
        (folder / "hexapod_force.h").write_text(header)
        (folder / "hexapod_force.c").write_text(source)
        # Ends where it began: the next round goes on from there. Forces do not matter for the time.
        motion = Harmonic(seed=1, duration=2.0, size=0.6).at(np.arange(0.0, 2.0, 1e-3))
        hexapod = Hexapod.of(made.case)
        k = kinematics_of_coordinates(motion.coordinates, motion.rates, motion.accelerations)
        lengths = hexapod.strut_lengths(k.pose)
        velocities = np.gradient(lengths, 1e-3, axis=0)
        rows = np.column_stack(
            [lengths, velocities, np.gradient(velocities, 1e-3, axis=0), np.full((len(lengths), 6), 9.0)]
        )
        body = ",\n".join("{" + ", ".join(repr(float(v)) for v in row) + "}" for row in rows)
        (folder / "motion.h").write_text(
            f"#define ROUNDS {ROUNDS}\n#define COUNT {len(rows)}\n"
            f"static const double motion[COUNT][24] = {{\n{body}\n}};\n"
        )
        (folder / "timer.c").write_text(TIMER)
        build = ["gcc", *STRICT, "-o", "timer", "timer.c", "hexapod_force.c", "-lm"]
        subprocess.run(build, cwd=folder, check=True)
        figures = json.loads(subprocess.run([folder / "timer"], capture_output=True, text=True, check=True).stdout)
    return [
        ["exported C, strut motion to external force", f"{figures['best']:.2f} us a call", "20 us"],
        ["  the same, slowest of 200 rounds of 2 s at 1 kHz", f"{figures['worst']:.2f} us a call", "20 us"],
        ["  steps of the forward kinematics, mean / most", f"{figures['steps']:.2f} / {figures['most']}", "12"],
    ]


if __name__ == "__main__":
    for row in exported():
        print(*row, sep=" | ")
