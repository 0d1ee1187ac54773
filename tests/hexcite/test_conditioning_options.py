"""`hexcite identify` with what is done to a moving run beforehand."""

from pathlib import Path

import numpy as np
import pytest

from cases.recording_format import BAR_FORCES, STRUTS
from cases.schema import load_case
from identification.machines.hexapod import Hexapod
from tests.helpers import Harmonic, tells
from tests.hexcite.command_line import call
from tests.simulated_machine import PoseExecution, true_forces

CASE = load_case("hexapod")
TRUTH = {"m": 31.83, "zC": 0.10505, "IC33": 0.91, "k3": 28.27}


@pytest.mark.repeats
def test_forces_and_struts_of_different_rates_are_one_run_of_several_files(tmp_path: Path) -> None:
    """Struts every 2 ms, forces ten times as often: the noise of 3 N falls to 0.95 N, and people are told."""
    execution = PoseExecution(Hexapod.of(CASE), Harmonic(duration=2.5))
    t, fine = np.arange(0.0, 2.5, 2e-3), np.arange(0.0, 2.5, 2e-4)
    forces = true_forces(CASE, execution, fine) + 3.0 * np.random.default_rng(0).normal(size=(len(fine), 6))
    for name, columns, clock, values in (
        ("struts.csv", STRUTS, t, execution.drives(t) * 1e3),
        ("forces.csv", BAR_FORCES, fine, forces),
    ):
        rows = np.column_stack([clock, values])
        np.savetxt(tmp_path / name, rows, "%.9f", ",", header=",".join(["t_s", *columns]), comments="")
    words = ("identify", tmp_path / "forces.csv", tmp_path / "struts.csv", "--case", "hexapod", "-o", tmp_path / "r")
    answer = call(*words, "--json").json()
    assert answer["averaged"]["ratio"] == pytest.approx(10.0)
    assert answer["s0"] == pytest.approx(3.0 / np.sqrt(10.0), rel=0.15)
    for name, truth in TRUTH.items():
        p = answer["parameters"][name]
        assert abs(p["value"] - truth) < 4.5 * max(p["std"], p["std_robust"]), name
    assert tells(answer["notes"][0], "10 samples averaged", "no group delay")
