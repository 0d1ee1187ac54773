"""What is said of stated noise holds for a machine that shares nothing with the model: forces by Newton's law."""

import numpy as np
import pytest

from cases.schema import load_case
from identification.hexapod import Hexapod
from identification.identify import estimate_parameters
from identification.model import identification_model
from identification.parameters import physical_form
from identification.recording import Recording
from tests.helpers import Harmonic
from tests.identification.point_masses import PointMasses, wrench_of_bars

CASE = load_case("hexapod")
MODEL = identification_model(CASE, 9)
MASSES = PointMasses.drawn(5)
TRUTH = physical_form(MODEL).of([MASSES.parameters.get(n, 0.0) for n in MODEL.names], np.eye(20))[0]
MOTION = Harmonic(size=0.7, duration=2.0)
FORCE_NOISE, STRUT_NOISE_UM, SEEDS = 2.0, 4.0, 12
STATED = {"force_noise_N": FORCE_NOISE, "strut_noise_um": STRUT_NOISE_UM}
NOISY = CASE.model_copy(update={"sensors": CASE.sensors.model_copy(update=STATED)})


@pytest.fixture(scope="module")
def exact() -> Recording:
    """Forces of bars that carry point masses, and struts, without any noise."""
    t = np.arange(0.0, MOTION.duration, 1e-3)
    wrenches = np.array([MASSES.wrench(MOTION, at, CASE.gravity) for at in t])
    bars = np.array([wrench_of_bars(CASE.sensor_frame.bars, unit) for unit in np.eye(6)]).T
    forces = np.linalg.solve(bars, wrenches.T).T
    struts = Hexapod.of(CASE).strut_lengths(MOTION.at(t).pose)
    return Recording("newton.csv", t, struts, None, forces, np.ones(len(t), dtype=bool))


def noisy(exact: Recording, seed: int) -> Recording:
    draw = np.random.default_rng(seed)
    forces = exact.forces + draw.normal(0.0, FORCE_NOISE, exact.forces.shape)
    struts = exact.struts + draw.normal(0.0, STRUT_NOISE_UM * 1e-6, exact.struts.shape)
    return Recording("newton.csv", exact.t, struts, None, forces, exact.trigger)


@pytest.mark.slow
def test_shares_and_attenuation_are_those_of_the_noise_that_was_added(exact: Recording) -> None:
    found = [estimate_parameters(noisy(exact, seed), NOISY) for seed in range(SEEDS)]
    sources = [f.noise for f in found]
    # The share of the forces is known exactly, that of the accelerations is the rest of s0^2.
    s0_squared = np.mean([f.fit.s0**2 for f in found])
    assert np.mean([s.force_sensors for s in sources]) == pytest.approx(FORCE_NOISE**2 / s0_squared, rel=0.02)
    assert np.mean([s.accelerations for s in sources]) == pytest.approx(1 - FORCE_NOISE**2 / s0_squared, rel=0.06)
    assert np.mean([s.accelerations for s in sources]) > 0.3  # the test sees them
    values = np.array([[v.value for v in f.physical.values()] for f in found])
    told = np.mean([[a["bias"] for a in f.attenuation.values()] for f in found], axis=0)
    error = values.std(axis=0, ddof=1) / np.sqrt(SEEDS)
    off = values.mean(axis=0) - TRUTH
    clear = np.abs(told) > 8 * error
    assert "m" in {n for n, c in zip(found[0].physical, clear, strict=True) if c}
    assert np.all(np.abs(off - told) < 4.0 * error + 0.1 * np.abs(told))
