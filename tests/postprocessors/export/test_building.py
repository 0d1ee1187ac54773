"""Sanitizers find nothing in the exported C."""

import subprocess
from pathlib import Path

import pytest

from postprocessors.export.code import c_sources
from tests.postprocessors.export.calibrations import calibration

DRIVER = r"""
#include <math.h>
#include <stdio.h>
#include "hexapod_force.h"

int main(void)
{
    static hexapod_force_model model;
    static hexapod_force_signals signals;
    hexapod_force_sample sample;
    const double odd[] = { 1.3, -4.0, 0.0, 1e300, -1e300, 0.9, NAN };
    double position[6], force[6], external[6];
    int half, n, k, good = 0;

    hexapod_force_init(&model);
    for (half = 1; half <= 127; half += 21) {
        hexapod_force_signals_init(&signals, 1e-3, half * 1e-3, (half - 60) * 0.3e-3);
        for (n = 0; n < 700; n++) {
            for (k = 0; k < 6; k++) {
                position[k] = n % 311 == 310 ? odd[(n + k) % 7] : 1.02 + 1e-5 * ((n * (k + 3)) % 97);
                force[k] = n;
            }
            if (hexapod_force_signals_push(&signals, position, force, &sample) == HEXAPOD_FORCE_OK)
                good += hexapod_force_from_struts(&model, sample.position, sample.velocity, sample.acceleration,
                    sample.force, external) == HEXAPOD_FORCE_OK;
            hexapod_force_from_struts(&model, odd, position, position, force, external);
            hexapod_force_from_pose(&model, position, odd, position, force, external);
            hexapod_force_tare_add(&model);
        }
        hexapod_force_tare_end(&model);
    }
    printf("%d\n", good);
    return 0;
}
"""


@pytest.mark.slow
@pytest.mark.usefixtures("gcc")
def test_sanitizers_find_nothing(tmp_path: Path) -> None:
    """Windows and delays of all lengths, jumps, values that are not numbers: no bounds are left, nothing overflows."""
    header, source = c_sources(calibration(tmp_path, "hexapod", 9), "hexapod_force")
    (tmp_path / "hexapod_force.h").write_text(header, encoding="ascii")
    (tmp_path / "hexapod_force.c").write_text(source, encoding="ascii")
    (tmp_path / "driver.c").write_text(DRIVER, encoding="ascii")
    flags = ["-std=c99", "-O1", "-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=all"]
    build = subprocess.run(
        ["gcc", *flags, "-o", "driver", "driver.c", "hexapod_force.c", "-lm"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
    )
    if build.returncode != 0 and "cannot find" in build.stderr:
        pytest.skip("gcc has no sanitizers here; install libasan and libubsan")
    assert build.returncode == 0, build.stderr
    run = subprocess.run([tmp_path / "driver"], capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    assert int(run.stdout) > 500
