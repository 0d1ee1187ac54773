"""Standstills in a run: found with and without a trigger, averaged with their scatter, matched pose by pose."""

from dataclasses import replace

import numpy as np
import pytest

from cases.base.errors import Code, IdentificationError, RecordingError
from cases.schema import load_case
from identification.estimation.estimators import Method
from identification.estimation.priors import Prior
from identification.identify import estimate_parameters, identify
from identification.machines.hexapod import Hexapod
from identification.model.blocks import INERTIA
from identification.model_choice import identify_models
from identification.motion.motion import Joined, Standstill, Trajectory
from identification.motion.moves import StraightMove
from identification.recording.record import RunRecord
from identification.recording.recording import Recording
from identification.samples.moving_window import stands_only
from identification.samples.standstills import among, average, find_standstills, match
from identification.simulate import simulate_recording
from tests.helpers import one_line
from tests.mistaken import machines as mistaken
from tests.simulated_machine import PoseExecution, simulate_standstills

CASE = load_case("hexapod")
HOME = np.array([0.0, 0.0, 0.9, 0.0, 0.0, 0.0])
SETTLE, AVERAGE = 0.1, 0.3


def poses(count: int = 6) -> np.ndarray:
    draw = np.random.default_rng(8)
    return HOME + draw.uniform(-1.0, 1.0, (count, 6)) * np.r_[0.2, 0.2, 0.0, 0.3, 0.3, 0.2]


def measured(stations: np.ndarray, rest: float = 0.3) -> Recording:
    """A run from home through poses and back, with the trigger on in the last 0.3 s at each."""
    box = CASE.limits.motion if CASE.limits is not None else None
    assert box is not None
    parts: list[Trajectory] = [Standstill(HOME, rest)]
    trigger, clock, here = [], rest, HOME
    for pose in stations:
        move = StraightMove.fastest(here, pose, box.rate, box.acceleration, box.jerk)
        parts += [move, Standstill(pose, SETTLE + AVERAGE)]
        clock += move.duration + SETTLE + AVERAGE
        trigger.append((clock - AVERAGE, clock))
        here = pose
    parts += [StraightMove.fastest(here, HOME, box.rate, box.acceleration, box.jerk), Standstill(HOME, rest)]
    execution = PoseExecution(Hexapod.of(CASE), Joined(tuple(parts)))
    return simulate_recording(CASE, execution, np.array(trigger), 1)


RUN = measured(poses())
PLAIN = replace(RUN, trigger=None)


def test_the_trigger_marks_the_standstills() -> None:
    windows = find_standstills(RUN, SETTLE)
    assert len(windows) == 6
    assert all(abs(w.stop - w.start - 300) <= 1 for w in windows)
    assert stands_only(RUN)


def test_without_a_trigger_the_same_standstills_are_found_after_settling_and_those_at_home_too() -> None:
    assert not stands_only(PLAIN)
    with_trigger, without = find_standstills(RUN, SETTLE), find_standstills(PLAIN, SETTLE)
    assert len(without) == 8
    for theirs, ours in zip(with_trigger, without[1:-1], strict=True):
        assert abs(theirs.start - ours.start) < 40
        assert theirs.start - 20 <= ours.start
        assert -25 < theirs.stop - ours.stop < 65


def test_without_a_trigger_no_slow_beginning_of_a_movement_is_averaged() -> None:
    """A quintic from rest: forces change some 10 ms before a strut is as fast as a moving one."""
    t = np.arange(4000) * 1e-3
    u = np.clip((t % 2.0 - 1.0) / 0.8, 0.0, 1.0)
    way = np.floor(t / 2.0) + u**3 * (10.0 - 15.0 * u + 6.0 * u**2)
    poses = HOME + 0.1 * np.outer(way, np.eye(6)[0])
    record = Recording("run", t, Hexapod.of(CASE).strut_lengths(poses), None, np.zeros((4000, 6)), None)
    first, second = find_standstills(record, SETTLE)
    assert np.ptp(way[first]) == np.ptp(way[second]) == 0.0


def test_averages_are_the_struts_of_the_poses_and_as_precise_as_the_number_of_samples_makes_them() -> None:
    averages = average(RUN, find_standstills(RUN, SETTLE))
    struts = averages.drives
    assert struts is not None
    assert averages.t is None
    np.testing.assert_allclose(struts, Hexapod.of(CASE).strut_lengths(poses()), atol=1e-7)
    np.testing.assert_allclose(np.median(1.0 / averages.weights), 1.0, atol=0.2)


def test_the_run_is_matched_to_its_program_with_and_without_the_trigger() -> None:
    for recording in (RUN, PLAIN):
        found, part = match(average(recording, find_standstills(recording, SETTLE)), CASE, poses(), "run")
        assert part.stop - part.start == len(found.forces) == 6


def test_a_part_of_the_poses_of_a_run_can_be_evaluated_in_any_order() -> None:
    """As the 30 that are chosen among 480, from the run of all of them."""
    many = measured(poses(20))
    averages = average(many, find_standstills(many, SETTLE))
    rows = [14, 3, 8, 19, 0, 11, 5]
    part = among(averages, CASE, poses(20)[rows])
    assert part is not None
    np.testing.assert_array_equal(part.forces, averages.forces[rows])
    np.testing.assert_array_equal(part.weights, averages.weights[rows])
    result = identify(many, CASE, 5, poses=poses(20)[rows])
    assert result.record.samples == 7
    assert result.record.standstills["count"] == 7
    assert any("7 of 20" in sentence for sentence in result.notes)
    again = identify(part, CASE, 5)
    np.testing.assert_allclose(result.values, again.values, rtol=1e-12)
    rowwise = identify(averages, CASE, 5, poses=poses(20)[rows])  # averaged rows too
    np.testing.assert_allclose(result.values, rowwise.values, rtol=1e-12)


def test_a_pose_that_the_run_does_not_hold_is_no_part_of_it() -> None:
    averages = average(RUN, find_standstills(RUN, SETTLE))
    elsewhere = np.vstack([poses()[:2], HOME + np.r_[0.15, 0.0, 0.0, 0.1, 0.0, 0.0]])
    assert among(averages, CASE, elsewhere) is None
    assert among(averages, CASE, poses()) is None  # these are all: their order is that of the program
    with pytest.raises(RecordingError, match=r"standstill 3\b") as caught:
        identify(RUN, CASE, 5, poses=elsewhere)
    one_line(caught.value)


def test_identification_of_averages_is_within_its_error_bars_and_says_how_noisy_an_average_is() -> None:
    many = measured(poses(20))
    estimate = estimate_parameters(average(many, find_standstills(many, SETTLE)), CASE, 5)
    for name, truth in {"m": 31.83, "zC": 0.10505, "k0": 24.05, "k2": 37.38, "k3": 28.27}.items():
        value = estimate.physical[name]
        assert abs(value.value - truth) < 4.5 * value.std
    assert estimate.fit.white_noise == pytest.approx(1.0 / np.sqrt(300), rel=0.3)


def test_inertia_that_is_known_or_left_out_is_not_asked_of_standstills() -> None:
    """At rest its columns are zero: with model 9 the rest comes out as with model 5."""
    many, inertia = measured(poses(20)), [p.name for p in INERTIA.parameters]
    averages = average(many, find_standstills(many, SETTLE))
    plain = estimate_parameters(averages, CASE, 5, Method(dropped=("k2",)))
    for how in (Method(dropped=(*inertia, "k2")), Method(dict.fromkeys(inertia, 1.0), ("k2",))):
        found = estimate_parameters(averages, CASE, 9, how)
        for name in ("m", "zC", "k0", "k3"):
            assert found.physical[name].value == pytest.approx(plain.physical[name].value)
    with pytest.raises(IdentificationError, match="contains inertia, which standstills cannot excite"):
        estimate_parameters(averages, CASE, 9, Method(dropped=tuple(inertia[1:])))


@pytest.mark.usefixtures("causes_aside")
def test_a_restless_standstill_counts_less() -> None:
    many = measured(poses(20))
    windows = find_standstills(many, SETTLE)
    shaken = many.forces.copy()
    restless = windows[7]
    t = np.arange(restless.stop - restless.start) * 1e-3
    shaken[restless] += 40.0 * np.sin(2 * np.pi * 2.3 * t)[:, None]
    standing = average(replace(many, forces=shaken), windows)
    assert int(np.argmin(standing.weights)) == 7
    assert standing.weights[7] < 1.0 / 20.0
    weighted = estimate_parameters(standing, CASE, 5)
    plain = estimate_parameters(replace(standing, weights=None), CASE, 5)
    truth = 31.83
    assert abs(weighted.physical["m"].value - truth) < 0.3 * abs(plain.physical["m"].value - truth)
    assert weighted.physical["m"].std < 0.2 * plain.physical["m"].std


def test_a_pose_that_was_not_measured_is_named() -> None:
    missing = measured(np.delete(poses(), 2, axis=0))
    standing = average(missing, find_standstills(missing, SETTLE))
    with pytest.raises(RecordingError, match=r"standstill 3: x .* deg; pose 3 of the program's 6: x "):
        match(standing, CASE, poses(), "run.csv")


def test_a_run_that_ends_early_names_the_first_pose_that_is_missing() -> None:
    standing = average(RUN, find_standstills(RUN, SETTLE)[:4])
    with pytest.raises(RecordingError, match=r"standstill 5: missing; pose 5 .* x .*; record"):
        match(standing, CASE, poses(), "run.csv")


def test_a_standstill_elsewhere_is_named_with_both_places() -> None:
    moved = poses()
    moved[3, 0] += 0.01
    with pytest.raises(RecordingError, match=r"standstill 4: x .*; pose 4 .*: x ") as error:
        match(average(RUN, find_standstills(RUN, SETTLE)), CASE, moved, "run.csv")
    one_line(error.value)


def test_one_standstill_too_many_is_named() -> None:
    standing = average(RUN, find_standstills(RUN, SETTLE))
    with pytest.raises(RecordingError, match=r"standstill 6: x .*pose 6 of the program's 5: missing"):
        match(standing, CASE, poses()[:5], "run.csv")


def test_a_trigger_that_is_on_while_the_machine_moves_is_no_measurement_at_poses() -> None:
    assert RUN.trigger is not None
    moving = replace(RUN, trigger=~RUN.trigger)
    with pytest.raises(RecordingError, match="moves while the trigger"):
        find_standstills(moving, SETTLE)


def test_a_run_that_never_stands_still_is_refused() -> None:
    with pytest.raises(RecordingError, match="standstills of at least"):
        find_standstills(PLAIN, 100.0)


def test_averages_without_a_clock_have_no_standstills_to_find() -> None:
    standing = average(RUN, find_standstills(RUN, SETTLE))
    with pytest.raises(RecordingError, match="with a clock"):
        find_standstills(standing, SETTLE)


def test_thousands_of_standstills_are_identified() -> None:
    result = identify(simulate_standstills(CASE, poses(2300), 100, 2), CASE)
    mass = result.parameters["m"]
    assert CASE.simulation is not None
    assert abs(mass.value - CASE.simulation.parameters.body.mass_kg) < 4.0 * mass.reported


@pytest.mark.parametrize("name", ["hexapod", "ur10_wrist"])
def test_a_motion_without_a_clock_is_told_from_standstills(name: str) -> None:
    """Though it stands more than half of the time, and encoders count steps."""
    whole = RUN if name == "hexapod" else mistaken.run(name, 0).recording
    rest = np.r_[np.arange(len(whole.forces)), np.full(2 * len(whole.forces), len(whole.forces) - 1)]
    struts = np.round(whole.drives[rest] / 1e-6) * 1e-6  # type: ignore[index]
    run = replace(whole, t=None, trigger=None, drives=struts, forces=whole.forces[rest])
    with pytest.raises(RecordingError) as caught:
        identify(run, load_case(name))
    said = one_line(caught.value)
    assert "clock.period_ms" in said
    assert f"{len(rest)} rows" in said
    assert (" rad apart" if name == "ur10_wrist" else " mm apart") in said


def test_poses_in_order_along_a_line_are_standstills() -> None:
    """Sixty of them, further apart than rows of a motion, though they follow each other as smoothly."""
    line = HOME + np.linspace(-1.0, 1.0, 60)[:, None] * np.r_[0.2, 0.15, 0.0, 0.25, -0.2, 0.2]
    assert CASE.simulation is not None
    mass = identify(simulate_standstills(CASE, line, 100, 3), CASE, 0).parameters["m"]
    assert abs(mass.value - CASE.simulation.parameters.body.mass_kg) < 3.0 * mass.reported


BARS = load_case("clamping_table")  # a sensor frame that does not move


def forces_alone(rows: int) -> Recording:
    forces = 100.0 + np.random.default_rng(3).normal(size=(rows, 6))
    return Recording("run", None, None, None, forces, None)


def test_a_frame_that_stands_needs_no_pose_and_others_are_asked_for_one() -> None:
    run = forces_alone(20)
    offsets = estimate_parameters(run, BARS).fit.values
    np.testing.assert_allclose(offsets, run.forces.mean(axis=0), rtol=1e-9)
    with pytest.raises(RecordingError) as caught:
        estimate_parameters(run, CASE)
    assert caught.value.code is Code.MISSING
    assert all(word in one_line(caught.value) for word in ("run", "drives", "rotations"))


def test_offsets_have_priors_too() -> None:
    """Of a frame that stands, of which no mass is identified."""
    run = forces_alone(20)
    usual = estimate_parameters(run, BARS)
    known = run.forces.mean(axis=0)[0] + 1.0
    sure = estimate_parameters(run, BARS, how=Method(priors=(Prior("f_q0_1", known, 1e-6),)))
    assert sure.fit.values[0] == pytest.approx(known, abs=1e-5)
    np.testing.assert_allclose(sure.fit.values[1:], usual.fit.values[1:], rtol=1e-6)


def test_models_are_not_compared_by_one_sample() -> None:
    """Whose other samples would predict it."""
    known = {f"f_q0_{k}": 100.0 for k in range(1, 6)}
    with pytest.raises(IdentificationError) as caught:
        identify_models(forces_alone(1), BARS, how=Method(known=known))
    assert caught.value.code is Code.TOO_FEW


def test_a_run_of_another_machine_keeps_its_error_and_says_whose_it_is() -> None:
    run = replace(forces_alone(3), record=RunRecord.of_case(BARS), drives=np.ones((3, 6)))
    with pytest.raises(IdentificationError) as caught:
        identify(run, CASE)
    assert caught.value.code is Code.NO_EXCITATION
    assert all(name in caught.value.remedy for name in (BARS.name, CASE.name))
