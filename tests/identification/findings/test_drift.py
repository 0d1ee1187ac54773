"""Offsets that drift are named with channel, change and remedy; still ones are not, with white noise or coloured."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.signal import lfilter

from cases.schema import Case, load_case
from identification.finding import Kind
from identification.findings.drift import drift_of
from identification.fitting import fitted_run
from identification.identify import estimate_parameters
from identification.model.model import identification_model
from identification.recording.recording import Recording
from identification.results.estimate import entries_of
from identification.results.force import force
from identification.results.result import Result
from identification.samples.samples import GAUSS_MARKOV
from tests.bench.table_3 import standing_run
from tests.chains import ROBOT, standing_forces, swing, swung_forces
from tests.helpers import few

T = np.arange(0.0, 8.0, 0.002)
NOISE = np.array([0.5] * 3 + [0.02] * 3)
FREE = swung_forces(T)
JOINTS = swing(T)[0]


def recorded(seed: int, drift: np.ndarray | float = 0.0, memory: float = 0.0, **more: Any) -> Recording:
    """A run of the robot; what drifts is added, shape (n, 6) [N, N m]; noise remembers so much of its last sample."""
    white = np.random.default_rng(seed).normal(size=(len(T), 6)) * NOISE * np.sqrt(1.0 - memory**2)
    noise = lfilter([1.0], [1.0, -memory], white, axis=0)
    return Recording("run.csv", T, JOINTS, None, FREE + noise + drift, None, case=ROBOT, **more)


def found(recording: Recording, case: Case = ROBOT) -> list[str]:
    return [f.sentence for f in estimate_parameters(recording, case).findings if f.kind is Kind.OFFSETS]


def of_channel(k: int, values: np.ndarray) -> np.ndarray:
    return values[:, None] * np.eye(6)[k]


@pytest.mark.first(1)
@pytest.mark.parametrize(("channel", "name", "a_minute", "unit"), [(2, "fz_N", 6.0, "N"), (4, "my_Nm", -0.3, "N m")])
def test_a_drift_is_named_with_channel_change_and_remedy(channel: int, name: str, a_minute: float, unit: str) -> None:
    (told,) = found(recorded(0, of_channel(channel, a_minute * T / 60.0)))
    assert f"offset of {name} drifts by {'+' if a_minute > 0.0 else '-'}0." in told
    assert f"{unit} over the 6.54 s of this run" in told
    assert "hexcite tare" in told
    entries = [
        f.quantity for f in estimate_parameters(recorded(0, of_channel(channel, a_minute * T / 60.0)), ROBOT).findings
    ]
    (drift,) = (entry["offset_drift"] for entry in entries if "offset_drift" in entry)
    assert drift["channel"] == name
    assert 60.0 * drift["change"] / drift["span"] == pytest.approx(a_minute, rel=0.1)


@pytest.mark.first(1)
@pytest.mark.parametrize("seeds", few(range(2), range(2, 8)))
@pytest.mark.parametrize("memory", [0.0, 0.9, 0.998])
def test_a_still_sensor_does_not_drift(memory: float, seeds: range) -> None:
    """The slowest noise remembers a second: it wanders, and deviations know it."""
    assert not [told for seed in seeds for told in found(recorded(seed, memory=memory))]


def standstills(seed: int, drift: float) -> Recording:
    """Forty averaged standstills of the robot, whose offset of fz drifts by so much from one to the next [N]."""
    rows = np.linspace(500, 3500, 40).astype(int)
    draw = np.random.default_rng(seed)
    q = JOINTS[rows] + draw.uniform(-0.5, 0.5, (40, 6))
    forces = standing_forces(q)
    forces += draw.normal(size=forces.shape) * NOISE / 20.0 + of_channel(2, drift * np.arange(40.0))
    return Recording("poses.csv", None, q, None, forces, None, case=ROBOT)


def test_standstills_drift_in_their_order() -> None:
    (told,) = found(standstills(0, 0.01))
    assert "fz_N drifts by +0." in told
    assert "over these 40 standstills" in told
    assert not [told for seed in range(6) for told in found(standstills(seed, 0.0))]


@pytest.fixture(scope="module")
def saved() -> Result:
    return Result(ROBOT, entries_of(estimate_parameters(recorded(7), ROBOT)))


def test_readings_that_are_off_all_along_are_named(saved: Result) -> None:
    (told,) = force(recorded(8, of_channel(1, np.full(len(T), -0.8))), saved).warnings
    assert "fy_N reads -0.7" in told
    assert "presses" in told
    for seed in (9, 10):
        assert not force(recorded(seed), saved).warnings


def test_a_push_is_not_a_drift(saved: Result) -> None:
    pushed = recorded(8, of_channel(1, np.where((T > 2.0) & (T < 5.0), -20.0, 0.0)))
    assert not force(pushed, saved).warnings


@pytest.mark.parametrize("drift", [0.0, -16.0])
@pytest.mark.parametrize("model", [0, 5])
def test_what_a_model_lacks_at_poses_in_the_order_of_a_grid_is_not_a_drift(model: int, drift: float) -> None:
    """The 480 poses of the paper: model 0 has no term of position, which looks like -16 N from first to last."""
    hexapod = load_case("hexapod")
    run = standing_run(hexapod, 1.0, 0)
    moved = replace(run, forces=run.forces + of_channel(0, drift * np.linspace(-0.5, 0.5, 480)))
    found = fitted_run(moved, hexapod, identification_model(hexapod, model), GAUSS_MARKOV).fitted
    of = drift_of(found)
    if drift == 0.0:
        assert of is None
    else:
        assert of is not None
        assert of.drifts.tolist() == [True, False, False, False, False, False]
        assert of.change[0] == pytest.approx(drift, rel=0.1)
