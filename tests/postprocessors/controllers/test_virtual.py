"""The built-in virtual controller: exact on timed paths, within the limits where it times a move itself."""

import numpy as np
import pytest

from cases.base.errors import ProgramError
from cases.schema import Case
from identification.identify import estimate_parameters
from identification.limits.proof import prove
from identification.machines.executed import largest_distance, path_error
from identification.machines.hexapod import Hexapod
from identification.motion.motion import Trajectory, sample
from identification.simulate import simulate_recording
from identification.stretches import windows
from postprocessors.controllers.executed_run import ExecutedRun
from postprocessors.controllers.virtual import REST, commanded, run_virtual
from postprocessors.dialects.linuxcnc.promises import linuxcnc_guarantees
from postprocessors.reading import Timed
from tests.helpers import seeds
from tests.postprocessors.changed_case import changed
from tests.postprocessors.independent import strut_lengths
from tests.postprocessors.programs import parts, read_linuxcnc, small_excitation, there_and_back, timed, typed
from tests.simulated_machine import PoseExecution


def run(text: str, case: Case) -> ExecutedRun:
    reading = read_linuxcnc(text, "p.ngc")
    return run_virtual(reading, linuxcnc_guarantees(reading, case))


def motion_of(text: str, case: Case) -> Trajectory:
    reading = read_linuxcnc(text, "p.ngc")
    return commanded(reading, linuxcnc_guarantees(reading, case))[0]


def test_the_struts_that_it_moves_are_the_inverse_kinematics_of_the_planned_motion(hexapod_case: Case):
    """But for what a uniform cubic B-spline rounds: a sixth of the acceleration times the cycle's square."""
    text = small_excitation(hexapod_case)
    executed = run(text, hexapod_case)
    (planned,) = (s.points for s in parts(text, hexapod_case) if isinstance(s, Timed))
    ((start, end),) = executed.trigger
    t = np.linspace(0.0, planned.duration, 500)
    expected = strut_lengths(planned.at(t).coordinates, hexapod_case)
    cycle = hexapod_case.controller.cycle
    rounded_off = hexapod_case.limits.motion.strut_acceleration_m_s2 * cycle**2 / 6
    assert np.abs(executed.execution.drives(start + t) - expected).max() < rounded_off
    assert end - start == pytest.approx(planned.duration, abs=1e-12)


@pytest.mark.parametrize("cycle_ms", [1.0, 4.0])
def test_drives_move_smoothly_between_the_set_points_of_a_cycle(cycle_ms: float, hexapod_case: Case):
    """Without limit of jerk accelerations step, within a cycle; what moves takes a cycle and more for that."""
    case = changed(hexapod_case, controller__cycle_ms=cycle_ms)
    text = typed("G1 X20.3 F9000")
    executed, exact = run(text, case).execution, PoseExecution(Hexapod.of(case), motion_of(text, case))
    cycle = cycle_ms * 1e-3
    t = np.arange(0.0, exact.duration, cycle / 10)
    most, steps = np.abs(exact.drives(t, 2)).max(), np.abs(np.diff(exact.drives(t, 2), axis=0)).max()
    assert steps > most / 2
    assert np.abs(executed.drives(t, 2)).max() <= most * (1 + 1e-6)
    assert np.abs(np.diff(executed.drives(t, 2), axis=0)).max() < 0.3 * most
    assert np.abs(executed.drives(t) - exact.drives(t)).max() < most * cycle**2 / 6


@pytest.mark.repeats
def test_sensors_see_the_motion_that_encoders_see(hexapod_case: Case):
    """Whatever ends between two samples: nothing is left of a run but what the sensors' noise explains."""
    draw, here = np.random.default_rng(1), np.array([150.0, 150.0, 60.0, 12.0, 12.0, 12.0])
    stations = hexapod_case.machine.home.vector * 1e3 + np.vstack(
        [draw.uniform(-1.0, 1.0, (16, 6)) * here, np.zeros(6)]
    )
    moves = ("G1 " + " ".join(f"{letter}{v:.3f}" for letter, v in zip("XYZABC", at, strict=True)) for at in stations)
    text = typed("M64 P0\n" + " F36000\n".join(moves) + " F36000\nM65 P0")
    executed = run(text, hexapod_case)
    pointwise = PoseExecution(Hexapod.of(hexapod_case), motion_of(text, hexapod_case))
    s0, aliased = (
        estimate_parameters(
            simulate_recording(hexapod_case, execution, executed.trigger, 0), hexapod_case
        ).fit.white_noise
        for execution in (executed.execution, pointwise)
    )
    assert s0 == pytest.approx(hexapod_case.simulation.force_noise_N, rel=0.2)
    assert aliased > 2.0 * s0


def test_the_trigger_window_is_as_long_as_the_excitation_and_leaves_out_the_dwells(hexapod_case: Case):
    body = f"G4 P0.5\nM64 P0\nG4 P0.25\n{timed(there_and_back())}\nG4 P0.25\nM65 P0\n{timed(there_and_back())}"
    executed = run(typed(body), hexapod_case)
    assert executed.excitation == pytest.approx(1.0)
    assert executed.trigger == pytest.approx(np.array([[REST + 0.75, REST + 1.75]]))
    assert executed.execution.duration == pytest.approx(2 * REST + 0.5 + 0.25 + 1.0 + 0.25 + 1.0)


def test_each_time_the_trigger_goes_on_is_a_window(hexapod_case: Case):
    path = timed(there_and_back())
    executed = run(typed(f"M64 P0\n{path}\nM65 P0\n{path}\nM62 P0\nG4 P1\nG1 X5 F3000"), hexapod_case)
    assert len(executed.trigger) == 2
    assert executed.trigger[1, 0] == pytest.approx(REST + 1 + 1 + 1)


@pytest.mark.parametrize("line", ["G0 X200 Y-100 A5 C-20", "G1 X200 A5 F3000", "G1 X200 C20 F36000", "G1 B15 F3600"])
def test_moves_that_it_times_itself_keep_every_limit_and_the_feed(line: str, hexapod_case: Case):
    """Of a LinuxCNC program every limit but those of jerk, which LinuxCNC does not have: accelerations step."""
    motion = motion_of(typed(line), hexapod_case)
    report = prove(motion, hexapod_case, 2000.0)
    box = ("position", "angle", "velocity", "angular velocity", "acceleration", "angular acceleration")
    assert max(report.to_json()[name]["ratio"] for name in ("jerk", "angular jerk")) > 10.0
    for name in box:
        assert report.to_json()[name]["ratio"] <= 1 + 1e-6, name
    if "F3000" in line:
        speed = np.linalg.norm(sample(motion, 2000.0).rates[:, :3], axis=1)
        assert speed.max() == pytest.approx(0.05, rel=1e-6)


def test_it_starts_and_ends_with_a_rest_that_filters_need(hexapod_case: Case):
    executed = run(typed(timed(there_and_back())), hexapod_case)
    struts = executed.execution.drives(np.array([0.0, REST / 2, REST]))
    assert np.ptp(struts, axis=0).max() < 1e-9  # a thousandth of an encoder's step
    assert REST * hexapod_case.recording.filter_cutoff_Hz >= 4.0  # half the filter's length


def test_motion_is_continuous_over_all_its_parts(hexapod_case: Case):
    body = f"G1 X2 A1 F3000\nG4 P0.1\nG0 X0 A0\n{timed(there_and_back())}"
    motion = sample(motion_of(typed(body), hexapod_case), 10_000.0)
    box = hexapod_case.limits.motion
    assert np.all(np.abs(np.diff(motion.coordinates, axis=0)) <= box.rate * 1e-4 * (1 + 1e-6))
    assert np.all(np.abs(np.diff(motion.rates, axis=0)) <= box.acceleration * 1e-4 * (1 + 1e-6))


def test_it_says_that_it_is_no_real_controller(hexapod_case: Case):
    executed = run(typed(""), hexapod_case)
    assert not executed.real
    assert "virtual" in executed.controller


def test_a_motion_that_is_not_defined_is_not_run(hexapod_case: Case):
    with pytest.raises(ProgramError, match=r"line 5: .*blended"):
        run(typed("G64\nG1 X5 F100"), hexapod_case)


@pytest.mark.parametrize(
    ("on", "expected"),
    [
        ([0, 0, 0], []),
        ([1, 1, 1], [[0, 3]]),
        ([0, 1, 0], [[1, 2]]),
        ([1, 0, 1, 1], [[0, 1], [2, 4]]),
        ([0, 1, 1, 0, 0, 1], [[1, 3], [5, 6]]),
    ],
)
def test_windows_are_the_runs_of_ones(on: list[int], expected: list[list[int]]):
    found = windows(np.array(on, dtype=bool), 0.5)
    assert found.tolist() == (0.5 * np.array(expected).reshape(-1, 2)).tolist()


PACED = ("velocity", "angular velocity", "acceleration", "angular acceleration", "strut velocity", "strut acceleration")


def shares(motion: Trajectory, case: Case) -> dict[str, float]:
    """What a motion uses of the limits that a pace decides on."""
    report = prove(motion, case, 4000.0).to_json()
    return {name: report[name]["ratio"] for name in PACED}


def test_a_path_that_asks_too_much_is_followed_later_inside_the_limits(hexapod_case: Case):
    """Exactly in its place; what is proven never comes here."""
    body = timed(there_and_back(count=40, size=200.0, seconds=0.02))
    (path,) = (s.points for s in parts(typed(body), hexapod_case) if isinstance(s, Timed))
    assert max(shares(path, hexapod_case).values()) > 1.3
    text = typed(f"M64 P0\n{body}\nM65 P0")
    executed = run(text, hexapod_case)
    assert executed.excitation > 1.05 * path.duration
    assert max(shares(motion_of(text, hexapod_case), hexapod_case).values()) <= 1.0 + 1e-6
    # what drives round off between set points of 1 ms: a / 6 of 1 ms squared, of 6 m/s^2 along each axis
    assert path_error(path, executed.execution, executed.trigger) < 2e-6


@seeds(5)
def test_a_distance_from_a_path_does_not_depend_on_where_its_points_lie(seed: int):
    """A path that turns back onto itself again and again, as moves between few places do, seen anywhere on it."""
    draw = np.random.default_rng(seed)
    corners = draw.normal(size=(3, 3))[draw.integers(3, size=40)] + 1e-5 * draw.normal(size=(40, 3))
    ways = np.diff(corners, axis=0)
    steps = np.maximum(2, (np.linalg.norm(ways, axis=1) / draw.uniform(1e-3, 5e-2, len(ways))).astype(int))
    path = np.vstack([corners[k] + np.linspace(0, 1, steps[k])[:, None] * ways[k] for k in range(len(ways))])
    k = draw.integers(len(ways), size=500)
    on_it = corners[k] + draw.random((500, 1)) * ways[k]
    assert largest_distance(on_it, path) < 1e-12
    aside = on_it + 0.01 * np.vstack([np.cross(ways[n], [1.0, 2.0, 3.0]) for n in k])
    exact = 0.0
    for point in aside:
        shares = np.clip(
            np.sum((point - corners[:-1]) * ways, axis=1) / np.maximum(np.sum(ways**2, axis=1), 1e-300), 0, 1
        )
        exact = max(exact, np.linalg.norm(point - corners[:-1] - shares[:, None] * ways, axis=1).min())
    assert largest_distance(aside, path) == pytest.approx(exact, rel=1e-9)
    assert largest_distance(aside[:1], path[:1].repeat(3, axis=0)) == pytest.approx(np.linalg.norm(aside[0] - path[0]))


def test_ways_whose_squares_are_zero_do_not_hide_how_far_a_run_is_from_its_path() -> None:
    """Splines through points that stand leave ways of 1e-170 m there."""
    path = np.zeros((600, 3))
    path[:300, 0] = np.sin(np.linspace(0.0, np.pi, 300))
    path[300:, 0], path[300:, 1] = path[299, 0], 1e-170 * np.arange(300)
    assert largest_distance(path + np.array([0.0, 0.0, 1e-3]), path) == pytest.approx(1e-3)
