"""What speaks against a run is found and named with its rows: sensors, wiring, contact, motion without clock."""

import copy
import re
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.signal import lfilter

from cases.base.errors import IdentificationError, RecordingError
from cases.schema import Case, load_case
from identification.findings import contact
from identification.findings.contact import find_contacts
from identification.identify import estimate_parameters
from identification.machines.hexapod import Hexapod
from identification.model.parameters import linear_parameters
from identification.motion.motion import Joined
from identification.motion.moves import StraightMove
from identification.recording.recording import Recording
from identification.samples.sample_checks import scan
from identification.simulate import simulate_recording
from tests.helpers import HOME, Harmonic, few, one_line, seeds, simulated, tells
from tests.identification.leaping import moves_without_jerk_limit
from tests.identification.moving_run import MODEL
from tests.mistaken.machines import machine
from tests.mistaken.machines import run as of_machine
from tests.simulated_machine import PoseExecution

CASE = load_case("hexapod")
TRUTH = linear_parameters(MODEL, CASE.simulation.parameters)
MOTIONS = [PoseExecution(Hexapod.of(CASE), Harmonic(seed=s, duration=3.0)) for s in range(3)]
J = CASE.sensor_frame.structure


def run(seed: int = 0) -> Recording:
    return simulate_recording(CASE, MOTIONS[seed % 3], np.array([[0.2, 2.8]]), seed, "run.csv")


def errors(recording: Recording) -> tuple[float, tuple[str, ...]]:
    """Largest error of the parameters in their own standard deviations, and the warnings."""
    estimate = estimate_parameters(recording, CASE)
    std = np.sqrt(np.maximum(np.diag(estimate.fit.covariance), np.diag(estimate.fit.covariance_robust)))
    for warning in estimate.warnings:
        one_line(ValueError(warning))
    return float(np.abs((estimate.fit.values - TRUTH) / std).max()), estimate.warnings


def with_forces(change: Callable[[np.ndarray], None], of: Recording) -> Recording:
    forces = of.forces.copy()
    change(forces)
    return replace(of, forces=forces)


def pushed(of: Recording, start: float, newtons: np.ndarray, duration: float = 0.2) -> Recording:
    """The run with an external force on the platform, which (1) reads as f_Ext = -J^-T (f_q - f^)."""
    on = (of.t >= start) & (of.t < start + duration)
    extra = np.linalg.solve(J, np.r_[newtons, 0.0, 0.0, 0.0])
    return with_forces(lambda f: f.__setitem__(on, f[on] - extra), of)


@seeds(6)
def test_a_push_of_20_N_for_a_fifth_of_a_second_is_found_within_50_ms_and_left_out(seed: int) -> None:
    draw = np.random.default_rng(seed)
    direction = draw.normal(size=3)
    start = float(draw.uniform(0.4, 2.4))
    error, warnings = errors(pushed(run(seed), start, 20.0 * direction / np.linalg.norm(direction)))
    (warning,) = warnings
    found = re.search(r"lines (\d+) to (\d+): external contact from ([\d.]+) to ([\d.]+) s, up to ([\d.]+) N", warning)
    assert found is not None
    first, last, begin, end, peak = (float(v) for v in found.groups())
    assert abs(begin - start) < 0.05
    assert abs(end - start - 0.2) < 0.05
    assert abs((first - 2) * 1e-3 - begin) < 2e-3  # rows of a file with one line of names
    assert abs((last - 2) * 1e-3 - end) < 2e-3
    assert 17.0 < peak < 25.0
    assert error < 4.5


@pytest.mark.parametrize("seeds", few(range(2), range(2, 50)))
def test_a_run_that_nothing_touches_raises_no_alarm(seeds: range) -> None:
    for seed in seeds:
        assert errors(run(seed))[1] == ()


@pytest.mark.repeats
def test_a_run_in_contact_for_too_long_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(contact, "MOST_TOUCHED", 0.08)
    with pytest.raises(IdentificationError, match=r"leave the model.* (9|10) %") as caught:
        estimate_parameters(pushed(run(), 0.5, np.array([0.0, 0.0, 20.0])), CASE)
    one_line(caught.value)


@pytest.mark.repeats
@pytest.mark.parametrize(("seed", "start", "duration"), few((0, 0.5, 1.2), (1, 0.3, 0.9), (2, 1.6, 1.2)))
def test_a_contact_of_up_to_half_the_run_is_warned_of_and_makes_deviations_large(
    seed: int, start: float, duration: float
) -> None:
    found = estimate_parameters(pushed(run(seed), start, np.array([12.0, 0.0, 16.0]), duration), CASE)
    assert tells(found.warnings[0], "f", "times the white noise that the case states", "1 N", "Do not use the result")
    assert "a long contact" in found.warnings[0]
    mass = found.physical["m"]
    assert abs(mass.value - 31.83) < 4.5 * mass.reported


@pytest.mark.parametrize(("nominal", "doubted"), [(1.2, False), (6.0, True)])
def test_a_load_that_was_mounted_does_not_doubt_the_values_and_a_light_one_does(nominal: float, doubted: bool) -> None:
    """A payload makes the body heavier than the case's; a compensated wrench makes it lighter."""
    sound, tables = of_machine("ur10_wrist", 0), copy.deepcopy(dict(machine("ur10_wrist").tables))
    tables["nominal"]["mass_kg"] = nominal
    case = Case.model_validate(tables)
    (finding,) = [f for f in estimate_parameters(sound.recording, case).findings if "nominal.mass_kg" in f.sentence]
    assert finding.severity == "warning"
    assert finding.doubts_values == doubted


@pytest.mark.repeats
def test_noise_with_memory_is_no_contact() -> None:
    """It is told for what it is."""
    noise = lfilter([0.3], [1.0, -0.98], np.random.default_rng(0).normal(size=(len(run().t) + 500, 6)), axis=0)[500:]
    found = estimate_parameters(replace(run(), forces=run().forces + noise), CASE)
    assert any(tells(w, "times the white noise", "simulation.force_noise_N makes 1 N") for w in found.warnings)
    assert any(tells(n, "noise is not white", "+- counts it") for n in found.notes)
    assert not any("contact from" in w or " follow " in w for w in found.warnings)


@pytest.mark.repeats
@pytest.mark.parametrize(("a", "b"), few((0, 1), (0, 3), (1, 4), (2, 5)))
def test_exchanged_channels_are_named(a: int, b: int) -> None:
    swapped = with_forces(lambda f: f.__setitem__((slice(None), [a, b]), f[:, [b, a]]), run(3))
    with pytest.raises(IdentificationError, match=rf"force channels {a + 1} and {b + 1}\b.*exchanged") as caught:
        estimate_parameters(swapped, CASE)
    assert "run.csv" in one_line(caught.value)


@pytest.mark.repeats
@pytest.mark.parametrize("channel", few(5, 0))
def test_a_turned_sign_is_named(channel: int) -> None:
    turned = with_forces(lambda f: f.__setitem__((slice(None), channel), -f[:, channel]), run(3))
    with pytest.raises(IdentificationError, match=rf"force channels {channel + 1} are turned"):
        estimate_parameters(turned, CASE)


def test_clipped_forces_are_left_out_with_their_rows() -> None:
    """Channel 2 swings to 180 N; at 150 N it is cut off, which biases the rest unless these samples are left out."""
    whole = run()
    case = CASE.model_copy(update={"sensors": CASE.sensors.model_copy(update={"range_N": 150.0})})
    cut = with_forces(lambda f: f.__setitem__((slice(None), 2), f[:, 2] - 330.0), whole)  # a tare brings it into range
    cut = replace(cut, forces=np.clip(cut.forces, -150.0, 150.0))
    assert np.mean(np.abs(cut.forces) >= 150.0) > 0.001
    found, ignored = estimate_parameters(cut, case), estimate_parameters(cut, CASE)
    assert any(tells(w, "channel 2", "150 N", "left out") for w in found.warnings)
    assert any(re.match(r"lines? \d+", w) for w in found.warnings)
    rows = [k for k, name in enumerate(found.model.names) if not name.startswith("f_q0")]
    assert np.abs((found.fit.values - TRUTH) / np.sqrt(np.diag(found.fit.covariance)))[rows].max() < 4.5
    assert ignored.samples.recorded_count > found.samples.recorded_count


def test_a_channel_that_sticks_for_a_while_is_left_out_with_its_rows() -> None:
    error, warnings = errors(with_forces(lambda f: f.__setitem__((slice(800, 1000), 4), f[800, 4]), run(1)))
    assert tells(warnings[0], "lines 802 to 1001: channel 5", "stuck at")
    assert error < 4.5


def test_what_befalls_several_channels_alike_is_one_finding() -> None:
    stuck = with_forces(lambda f: f.__setitem__((slice(800, 1000), [1, 4]), f[800, [1, 4]]), run(1))
    (warning,) = [w for w in map(str, scan(stuck, CASE).findings) if "stuck" in w]
    assert re.search(r"channel \d .*stuck.*likewise channel \d.*left out", warning)


@pytest.mark.first(1)
@pytest.mark.parametrize("size", [50.0, 4e3])
def test_single_force_samples_that_jump_are_left_out_with_their_rows(size: float) -> None:
    error, warnings = errors(with_forces(lambda f: f.__setitem__(([500, 1500], 2), size), run(2)))
    assert tells(warnings[0], "lines 502, 1502: channel 3", "jumps")
    assert error < 4.5


def test_a_drive_that_ripples_is_no_glitch() -> None:
    """Forces leap between blocks of a program all the time, with any size: that is the machine, above the filter."""

    def ripple(forces: np.ndarray) -> None:
        draw = np.random.default_rng(0)
        forces[5::10] += draw.uniform(-400.0, 400.0, (len(forces[5::10]), 6)) * draw.uniform(size=6)

    _, warnings = errors(with_forces(ripple, run(0)))
    assert not any("jumps" in warning for warning in warnings)


def test_an_acceleration_that_steps_is_no_glitch() -> None:
    """Controllers without jerk limit switch forces between two samples."""

    def steps(forces: np.ndarray) -> None:
        for row in (600, 900, 1500, 2100):
            forces[row:] += np.array([200.0, -150.0, 100.0, 80.0, -60.0, 120.0]) * (1 if row < 1000 else -1)

    assert scan(with_forces(steps, run(0)), CASE).findings == ()


def test_a_jerk_that_changes_its_sign_is_no_glitch() -> None:
    """Short moves reach no constant acceleration: a quiet sensor sees a peak that lasts for one sample."""
    quiet = simulated(CASE, force_noise_N=0.02)
    box = CASE.limits.motion
    places = HOME + np.array([[0.0] * 6, [0.02, -0.01, 0.015, 0.0, 0.0, 0.0], [0.0, 0.01, -0.01, 0.0, 0.0, 0.0]])
    ways = pairwise(places[[0, 1, 2] * 6])
    moves = Joined(tuple(StraightMove.fastest(a, b, box.rate, box.acceleration, box.jerk) for a, b in ways))
    execution = PoseExecution(Hexapod.of(CASE), moves)
    recording = simulate_recording(quiet, execution, np.array([[0.0, moves.duration]]), 0, "run.csv")
    away = recording.forces[1:-1] - (recording.forces[:-2] + recording.forces[2:]) / 2
    assert np.abs(away).max() > 40.0 * np.median(np.abs(away))
    assert scan(recording, quiet).findings == ()
    (told,) = map(str, scan(with_forces(lambda f: f.__setitem__((500, 2), f[500, 2] + 5.0), recording), quiet).findings)
    size = re.search(r"line 502: channel 3 jumps by up to ([\d.]+) N", told)
    assert size is not None
    assert float(size[1]) == pytest.approx(5.0, abs=0.5)


@seeds(4)
def test_a_channel_that_hardly_changes_while_others_leap_has_its_noise_and_no_contact(seed: int) -> None:
    """Where five channels leap by a hundred newtons some of that is left, and in the sixth its noise alone."""
    draw = np.random.default_rng(seed)
    t = np.arange(0.0, 8.0, 8e-3)
    expected = np.cumsum(np.where(draw.uniform(size=len(t)) < 0.02, draw.normal(0.0, 100.0, len(t)), 0.0))[:, None]
    expected = expected * np.array([1.0, -0.8, 1.2, 0.9, -1.1, 0.0])
    leaps = np.diff(expected, axis=0, prepend=0.0)
    left = 0.07 * (leaps + np.roll(leaps, 1, axis=0)) + draw.normal(0.0, 1.0, expected.shape)
    assert find_contacts(t, left, J, expected) == ()
    pushed_at = (t > 3.0) & (t < 3.2)
    (contact,) = find_contacts(t, left + 12.0 * pushed_at[:, None], J, expected)
    assert contact.start == pytest.approx(3.0, abs=0.05)


@seeds(4)
def test_what_accelerations_leap_by_between_moves_is_the_motion_s(seed: int) -> None:
    """Forces leap by some fifty newtons for a sample or two; the encoders' steps nearly hide what they leap with."""
    execution = moves_without_jerk_limit(seed)
    recording = simulate_recording(CASE, execution, np.array([[0.25, execution.duration - 0.25]]), seed, "run.csv")
    away = recording.forces[1:-1] - (recording.forces[:-2] + recording.forces[2:]) / 2
    assert np.abs(away).max() > 20.0
    assert scan(recording, CASE).findings == ()
    assert not [w for w in estimate_parameters(recording, CASE).warnings if "contact" in w or "jumps" in w]


@pytest.mark.first(1)
@pytest.mark.parametrize("size", [1e-3, 0.1])
def test_struts_that_jump_faster_than_drives_are_left_out_with_their_rows(size: float) -> None:
    whole = run(1)
    struts = whole.drives.copy()
    struts[[700, 1900], 3] += size
    error, warnings = errors(replace(whole, drives=struts))
    assert tells(warnings[0], "lines 702, 1902: strut 4", "jumps")
    assert "1 m/s" in warnings[0]
    assert error < 4.5


@pytest.mark.slow
def test_a_run_with_most_samples_damaged_is_refused() -> None:
    with pytest.raises(RecordingError, match=r"\d %.*unusable.*record again"):
        estimate_parameters(with_forces(lambda f: f.__setitem__((slice(100, 1800), 0), 5000.0), run()), CASE)


def test_a_run_outside_the_workspace_is_told_with_its_rows() -> None:
    longest = float(run().drives.max()) * 1e3 - 5.0
    workspace = type(CASE.workspace).model_validate(CASE.workspace.model_dump() | {"strut_length_mm": (650.0, longest)})
    (warning,) = estimate_parameters(run(), CASE.model_copy(update={"workspace": workspace})).warnings
    assert re.match(rf"lines \d+ to \d+.*strut \d .*workspace.*650 to {longest:g} mm", warning)


@pytest.mark.repeats
def test_a_run_that_touches_the_end_of_a_strut_as_far_as_encoders_err_is_not() -> None:
    longest = float(run().drives.max()) * 1e3 - 0.05
    workspace = type(CASE.workspace).model_validate(CASE.workspace.model_dump() | {"strut_length_mm": (650.0, longest)})
    assert estimate_parameters(run(), CASE.model_copy(update={"workspace": workspace})).warnings == ()


def test_a_motion_without_clock_is_no_list_of_standstills() -> None:
    with pytest.raises(RecordingError, match=r"no t_s .* \d+ rows .*recording\.clock\.period_ms"):
        estimate_parameters(replace(run(), t=None, trigger=None), CASE)


@pytest.mark.slow
def test_a_motion_slower_than_anything_that_counts_as_moving_is_still_evaluated() -> None:
    """A standstill by speed, but not by pose: without a trigger all of it counts, and the warning says so."""
    case = CASE.model_copy(update={"recording": CASE.recording.model_copy(update={"filter_cutoff_Hz": 2.0})})
    case = simulated(case, encoder_rate_Hz=20.0)
    slow = PoseExecution(Hexapod.of(CASE), Harmonic(duration=2000.0))
    recording = replace(simulate_recording(case, slow, np.array([[0.0, 1.0]]), 0, "run.csv"), trigger=None)
    estimate = estimate_parameters(recording, case, 5)
    assert any("1 mm/s" in w for w in estimate.warnings)
    assert estimate.samples.recorded_count > 0.99 * 2000 * 20 - 200
    assert estimate.physical["m"].value == pytest.approx(31.83, abs=0.2)


@pytest.mark.repeats
def test_residuals_that_are_not_white_are_told() -> None:
    """A model without the elastic terms leaves what follows the pose: what is missing is named."""
    warnings = estimate_parameters(run(), CASE, 6).warnings
    assert tells(warnings[0], "times the white noise", "simulation.force_noise_N makes 1 N")
    assert any(tells(w, "follow what model 9 has beside model 6", "k0, k1, k2, k3", "choose model 9") for w in warnings)


@pytest.mark.repeats
def test_struts_in_the_wrong_order_are_told() -> None:
    whole = run(1)
    with pytest.raises(IdentificationError, match=r"struts 1 and 2, 3 and 4, 5 and 6\b.*exchanged"):
        estimate_parameters(replace(whole, drives=whole.drives[:, [1, 0, 3, 2, 5, 4]]), CASE)


@pytest.mark.repeats
def test_a_mass_that_is_not_nominal_is_told() -> None:
    """Neither with payloads nor without."""
    told = CASE.model_dump(exclude_defaults=True)
    other = type(CASE).model_validate(told | {"nominal": told["nominal"] | {"mass_kg": 60.0}})
    warnings = estimate_parameters(run(), other).warnings
    assert any(tells(w, "31.8 kg", "nominal.mass_kg", "60 kg") for w in warnings)
    assert not any("mass comes out" in w for w in estimate_parameters(run(), CASE).warnings)


@pytest.mark.repeats
def test_many_contacts_are_one_finding_with_a_count() -> None:
    touched = run()
    for start in (0.4, 1.4, 2.4):
        touched = pushed(touched, start, np.array([0.0, 0.0, 20.0]), 0.08)
    (warning,) = [w for w in estimate_parameters(touched, CASE).warnings if "contact" in w]
    told = r"3 external contacts, 0\.\d+ s in all, up to [\d.]+ N; the longest: lines "
    assert re.match(told, one_line(ValueError(warning)))


def test_a_contact_lasts_at_least_20_ms() -> None:
    t, expected = np.arange(0.0, 2.0, 5e-3), np.zeros((400, 6))
    left = np.random.default_rng(0).normal(0.0, 1.0, expected.shape)
    left[100:102] += 40.0
    assert find_contacts(t, left, J, expected) == ()
    left[100:106] += 40.0
    assert len(find_contacts(t, left, J, expected)) == 1


@pytest.mark.first(1)
@pytest.mark.parametrize(("unit", "factor"), [("kN", 1e-3), ("mN", 1e3)])
def test_forces_in_another_unit_are_told_by_the_mass(unit: str, factor: float) -> None:
    unlimited = CASE.model_copy(update={"sensors": CASE.sensors.model_copy(update={"range_N": None})})
    recorded = run()
    with pytest.raises(IdentificationError, match=rf"forces .* in {unit}; set recording\.units\.forces") as caught:
        estimate_parameters(replace(recorded, forces=factor * recorded.forces), unlimited)
    one_line(caught.value)


@pytest.mark.usefixtures("causes_aside")
def test_a_model_without_inertia_is_warned_of_in_a_motion() -> None:
    motion = PoseExecution(Hexapod.of(CASE), Harmonic(seed=1, duration=4.0))
    found = estimate_parameters(simulate_recording(CASE, motion, np.array([[0.2, 3.8]]), 1), CASE, 3)
    assert any(tells(w, "model 9 has beside model 3", "I11", "choose model 9") for w in found.warnings)


def test_a_clock_in_another_unit_is_named() -> None:
    recorded = run()
    assert recorded.t is not None
    with pytest.raises(RecordingError, match=r"time stamps .* in ms: .*recording\.clock\.unit = 'ms'"):
        estimate_parameters(replace(recorded, t=1e3 * recorded.t), CASE)
