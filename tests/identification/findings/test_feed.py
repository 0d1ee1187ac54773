"""Feed override: found by comparison with the plan and in the control's own column, and what it does not touch."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from numpy.typing import ArrayLike

from cases.errors import RecordingError
from cases.loading import load_case
from identification.findings.feed import about_feed, against_plan, recorded_overrides
from identification.hexapod import Hexapod
from identification.identify import identify
from identification.motion import Joined, Motion, Standstill, TimedPoints, Trajectory
from identification.recording import Recording
from identification.simulate import simulate_recording
from tests.helpers import HOME, Harmonic, one_line
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
        return Motion(time, there.pose, there.rates * f, accelerations, there.jerks * f**3)


def through(seed: int, count: int = 7, pause: float = 0.0) -> Trajectory:
    """Timed points from rest to rest, with a pause in the middle."""
    draw = np.random.default_rng(seed)
    poses = HOME + draw.uniform(-1, 1, (count, 6)) * ([0.12] * 3 + [0.15] * 3)
    parts = [TimedPoints.through(np.arange(count) * 0.45, poses)]
    if pause:
        back = TimedPoints.through(np.arange(count) * 0.45, poses[::-1])
        parts += [Standstill(poses[-1], pause), back]
    return Joined(tuple(parts)) if pause else parts[0]


PLAN = through(0)


def recorded(motion: Trajectory, seed: int = 0) -> Recording:
    """With rest before and after, the trigger on in between."""
    rest = 0.4
    whole = Joined(
        (Standstill(motion.at([0.0]).pose[0], rest), motion, Standstill(motion.at([motion.duration]).pose[0], rest))
    )
    window = np.array([[rest, rest + motion.duration]])
    return simulate_recording(CASE, PoseExecution(Hexapod.of(CASE), whole), window, seed, "run.csv")


@pytest.mark.parametrize("pause", [0.0, 0.7])
@pytest.mark.parametrize("seed", range(3))
def test_a_run_as_planned_has_nothing_to_tell(seed: int, pause: float) -> None:
    plan = through(seed, pause=pause)
    run = recorded(plan, seed)
    found = against_plan(run, CASE, plan, "plan")
    assert found == ()
    assert about_feed(run, found, "plan") == ([], {})


@pytest.mark.parametrize("feed", [0.1, 0.5, 0.9, 1.2])
def test_an_override_over_the_whole_run_is_found_with_its_value(feed: float) -> None:
    run = recorded(AtFeed(PLAN, (), (feed,)))
    found = against_plan(run, CASE, PLAN, "plan")
    share = sum(s.rows.sum() for s in found) / run.trigger.sum()
    assert share > 0.75  # beginning and end are too slow to tell
    for stretch in found:
        assert stretch.scale == pytest.approx(feed, rel=0.03)


def test_a_feed_that_changes_is_told_piece_by_piece() -> None:
    run = recorded(AtFeed(PLAN, (1.0, 2.5), (1.0, 0.5, 0.8)))
    first, second = against_plan(run, CASE, PLAN, "plan")
    assert (first.scale, second.scale) == (pytest.approx(0.5, abs=0.04), pytest.approx(0.8, abs=0.04))
    t = run.t
    assert t[first.rows][[0, -1]] == pytest.approx([1.4, 2.9], abs=0.15)
    assert t[second.rows][0] == pytest.approx(2.9, abs=0.15)
    (sentence,), entries = about_feed(run, (first, second), "comparison with plan")
    assert "the parameters are valid" in sentence
    assert "are not of this run" in sentence
    assert [e["feed"] for e in entries["feed"]["stretches"]] == [first.scale, second.scale]


def test_a_feed_hold_is_an_override_of_zero() -> None:
    run = recorded(AtFeed(PLAN, (1.2, 2.4), (1.0, 0.0, 1.0)))
    scales = [s.scale for s in against_plan(run, CASE, PLAN, "plan")]
    assert min(scales) < 0.1


def test_parameters_do_not_care_about_the_feed() -> None:
    run = recorded(AtFeed(PLAN, (1.0,), (1.0, 0.6)))
    estimate = identify(run, CASE)
    assert abs(estimate.physical["m"].value - 31.83) < 4.5 * estimate.physical["m"].reported


def test_noise_and_a_glitch_of_a_strut_are_no_override() -> None:
    run = recorded(PLAN)
    struts = run.struts + 2e-6 * np.random.default_rng(0).normal(size=run.struts.shape)
    struts[1500, 2] += 0.02
    assert against_plan(replace(run, struts=struts), CASE, PLAN, "plan") == ()


@pytest.mark.parametrize("other", [through(5), Harmonic(duration=3.0), through(0, count=4)])
def test_a_run_of_another_plan_is_refused(other: Trajectory) -> None:
    with pytest.raises(RecordingError, match="it is no run of that plan") as caught:
        against_plan(recorded(PLAN), CASE, other, "the plan")
    assert "run.csv" in one_line(caught.value)
    assert "the plan" in one_line(caught.value)


def test_standstills_have_no_feed() -> None:
    still = replace(recorded(PLAN), t=None)
    with pytest.raises(RecordingError, match="is no moving run with struts") as caught:
        against_plan(still, CASE, PLAN, "plan")
    one_line(caught.value)


def test_a_recorded_override_is_told_where_it_counts() -> None:
    run = recorded(PLAN)
    override = np.ones(len(run.t))
    override[:300] = 0.0  # before the trigger
    override[1000:1500], override[1500:1600] = 0.5, 0.75
    run = replace(run, override=override)
    first, second = recorded_overrides(run)
    assert (first.scale, first.rows.sum()) == (0.5, 500)
    assert (second.scale, second.rows.sum()) == (0.75, 100)
    estimate = identify(run, CASE)
    (warning,) = [w for w in estimate.warnings if "feed other than 100 %" in w]
    assert "by the recorded override: lines 1002 to 1501 (1.000 to 1.499 s) at 50 %, lines 1502 to 1601" in warning
    assert [e["feed"] for e in estimate.told["feed"]["stretches"]] == [0.5, 0.75]
    plain = identify(replace(run, override=None), CASE)
    np.testing.assert_array_equal(estimate.values, plain.values)
    assert identify(replace(run, override=np.ones(len(run.t))), CASE).warnings == ()
