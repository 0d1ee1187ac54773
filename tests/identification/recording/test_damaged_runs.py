"""A run with one bad value in a thousand rows still gives its result, and so does one of a sensor with few digits."""

import random
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from cases.base.errors import RecordingError
from cases.schema import load_case
from identification.identify import estimate_parameters
from identification.machines.hexapod import Hexapod
from identification.recording.recording import read, write_recording
from identification.simulate import simulate_recording
from tests.damaged.runs import truth_of
from tests.helpers import Harmonic, answer, few
from tests.mistaken.machines import machine, run
from tests.simulated_machine import PoseExecution

HEXAPOD = load_case("hexapod")


def mildly_damaged(text: str, seed: int) -> str:
    """One value in a thousand rows is another one: nothing, zero, a neighbour's, ten or a thousand times as large."""
    draw = random.Random(seed)
    rows = [line.split(",") for line in text.splitlines()]
    for first in range(1, len(rows), 1000):
        row = draw.randrange(first, min(first + 1000, len(rows)))
        column = draw.randrange(1, 13)
        value = float(rows[row][column])
        choices = ["", "0", rows[max(row - 1, 1)][column], f"{10 * value:.6f}", f"{1000 * value:.6f}", f"{-value:.6f}"]
        rows[row][column] = draw.choice(choices)
    return "\n".join(",".join(row) for row in rows)


def within_3_std(seeds: range, folder: Path) -> float:
    """Share of mildly damaged runs that give every parameter within 3 standard deviations of the undamaged ones."""
    file = folder / "recording.csv"
    execution = PoseExecution(Hexapod.of(HEXAPOD), Harmonic(seed=1, duration=2.0))
    write_recording(file, simulate_recording(HEXAPOD, execution, np.array([[0.2, 1.8]]), 1), HEXAPOD)
    text = file.read_text()
    clean = estimate_parameters(read(file, HEXAPOD), HEXAPOD)
    std = np.sqrt(np.diag(clean.fit.covariance))
    good = 0
    for seed in seeds:
        file.write_text(mildly_damaged(text, seed))
        estimate = answer(lambda: estimate_parameters(read(file, HEXAPOD), HEXAPOD), str(file))
        good += estimate is not None and bool((np.abs(estimate.fit.values - clean.fit.values) < 3.0 * std).all())
    return good / len(seeds)


@pytest.mark.slow
@pytest.mark.parametrize("seeds", few(range(4), range(4, 200)))
def test_mild_damage_leaves_most_runs_usable(seeds: range, tmp_path: Path) -> None:
    assert within_3_std(seeds, tmp_path) >= 0.9


@pytest.mark.parametrize("digit", [0.1, 0.25])  # [N m]; forces have twenty times as large ones
def test_a_moment_that_a_sensor_shows_in_few_digits_is_not_stuck(digit: float) -> None:
    """The moment about the sensor's axis stays within one digit for long while forces change by many."""
    sound = run("ur10_wrist", 42, 3.0)
    digits = np.repeat([20.0 * digit, digit], 3)
    recording = replace(sound.recording, forces=np.round(sound.recording.forces / digits) * digits)
    mass = estimate_parameters(recording, sound.case).physical["m"]
    assert abs(mass.value - truth_of(machine("ur10_wrist").plant)["m"]) < 4.0 * mass.reported


def test_a_moment_that_stops_changing_is_stuck() -> None:
    sound = run("ur10_wrist", 42, 3.0)
    forces = sound.recording.forces.copy()
    forces[400:, 4] = forces[400, 4]
    with pytest.raises(RecordingError, match="channel 5 is stuck"):
        estimate_parameters(replace(sound.recording, forces=forces), sound.case)
