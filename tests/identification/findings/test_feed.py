"""Feed override in the control's own column, and what it does not touch."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from numpy.typing import ArrayLike

from cases.schema import load_case
from identification.identify import estimate_parameters
from identification.machines.hexapod import Hexapod
from identification.motion.motion import Joined, Motion, Standstill, TimedPoints, Trajectory
from identification.recording.recording import Recording
from identification.simulate import simulate_recording
from tests.helpers import HOME, tells
from tests.simulated_machine import PoseExecution

CASE = load_case("hexapod")
RAMP = 0.05  # [s] in which a feed changes


@dataclass(frozen=True)
class AtFeed:
    """A motion at feeds that change at given times of the run, by straight ramps."""

    planned: Trajectory
    times: tuple[float, ...]
    feeds: tuple[float, ...]

    @property
    def _table(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        t = np.arange(0.0, 12 * self.planned.duration, 1e-4)
        knots = np.r_[0.0, np.ravel([[k - RAMP / 2, k + RAMP / 2] for k in self.times])]
        feed = np.interp(t, knots, np.repeat(self.feeds, 2)[: len(knots)])
        return t, feed, np.r_[0.0, np.cumsum((feed[1:] + feed[:-1]) / 2 * 1e-4)]

    @property
    def duration(self) -> float:
        t, _, tau = self._table
        return float(np.interp(self.planned.duration, tau, t))

    def at(self, t: ArrayLike) -> Motion:
        grid, feed, tau = self._table
        time = np.asarray(t, dtype=float)
        f, slope = np.interp(time, grid, feed)[:, None], np.interp(time, grid, np.gradient(feed, grid))[:, None]
        there = self.planned.at(np.clip(np.interp(time, grid, tau), 0.0, self.planned.duration))
        accelerations = there.accelerations * f**2 + there.rates * slope
        return Motion(time, there.coordinates, there.rates * f, accelerations, there.jerks * f**3)


def through(seed: int, count: int = 7, pause: float = 0.0) -> Trajectory:
    """Timed points from rest to rest, with a pause in the middle."""
    draw = np.random.default_rng(seed)
    poses = HOME + draw.uniform(-1, 1, (count, 6)) * ([0.12] * 3 + [0.15] * 3)
    parts: list[Trajectory] = [TimedPoints.through(np.arange(count) * 0.45, poses)]
    if pause:
        back = TimedPoints.through(np.arange(count) * 0.45, poses[::-1])
        parts += [Standstill(poses[-1], pause), back]
    return Joined(tuple(parts)) if pause else parts[0]


PLAN = through(0)


def recorded(motion: Trajectory, seed: int = 0) -> Recording:
    """With rest before and after, the trigger on in between."""
    rest = 0.4
    whole = Joined(
        (
            Standstill(motion.at([0.0]).coordinates[0], rest),
            motion,
            Standstill(motion.at([motion.duration]).coordinates[0], rest),
        )
    )
    window = np.array([[rest, rest + motion.duration]])
    return simulate_recording(CASE, PoseExecution(Hexapod.of(CASE), whole), window, seed, "run.csv")


@pytest.mark.repeats
def test_parameters_do_not_care_about_the_feed() -> None:
    run = recorded(AtFeed(PLAN, (1.0,), (1.0, 0.6)))
    estimate = estimate_parameters(run, CASE)
    assert abs(estimate.physical["m"].value - 31.83) < 4.5 * estimate.physical["m"].reported


def test_a_recorded_override_is_told_where_it_counts() -> None:
    run = recorded(PLAN)
    override = np.ones(len(run.t))
    override[:300] = 0.0  # before the trigger
    override[1000:1500], override[1500:1600] = 0.5, 0.75
    run = replace(run, override=override)
    estimate = estimate_parameters(run, CASE)
    (warning,) = [w for w in estimate.warnings if "override" in w]
    assert tells(warning, "lines 1002 to 1601", "50 to 75 %")
    assert estimate.quantities["feed"] == {"lowest": 0.5, "highest": 0.75}
    plain = estimate_parameters(replace(run, override=None), CASE)
    np.testing.assert_array_equal(estimate.fit.values, plain.fit.values)
    assert estimate_parameters(replace(run, override=np.ones(len(run.t))), CASE).warnings == ()
