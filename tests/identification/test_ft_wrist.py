"""A real force/torque sensor on a real robot: 24 poses recorded at NTNU and what others found in them."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import hexcite as hx
from cases.base.errors import IdentificationError
from cases.schema import Case, load_case
from hexcite._identifiability import identifiability_of_models
from hexcite.reports.identify import identify_page
from identification.identify import estimate_parameters
from identification.model.model import identification_model
from identification.recording.recording import Recording, read
from identification.samples.wrist import wrist_run
from tests.helpers import few, one_line, tells

FILE = Path(__file__).parents[3] / "shared/data/ft_wrist_ntnu/0-calibration_fts-accel.csv"
OFFSETS = [9.0765, -1.0181, 9.9848, 0.4325, -0.6916, -0.1570]
CASE = load_case("ft_wrist")

pytestmark = pytest.mark.skipif(not FILE.is_file(), reason=f"the recording is not there: {FILE}")


@pytest.fixture(scope="module")
def recording() -> Recording:
    return read(FILE, CASE)


def with_sense(sense: str) -> Case:
    frame = CASE.sensor_frame
    transducer = frame.transducer.model_copy(update={"sense": sense})
    return CASE.model_copy(update={"sensor_frame": frame.model_copy(update={"transducer": transducer})})


def moving(case: Case) -> Recording:
    return read([FILE.with_name(f"1-baseline_{name}.csv") for name in ("accel", "wrench", "orientations")], case)


def rows(recording: Recording, which: slice) -> Recording:
    arrays = {n: getattr(recording, n)[which] for n in ("forces", "rotations", "specific_forces")}
    return replace(recording, **arrays)


def weight_regressor(recording: Recording, which: slice) -> np.ndarray:
    """The regressor of a load at rest, from F = m g and T = c x F: the pull of the load on the sensor."""
    gravity = recording.rotations[which].transpose(0, 2, 1) @ CASE.gravity
    matrices = np.zeros((len(gravity), 6, 10))
    matrices[:, :3, 0] = gravity
    matrices[:, 3:, 1:4] = -np.cross(gravity[:, None, :], np.eye(3)[None]).transpose(0, 2, 1)
    matrices[:, :, 4:] = np.eye(6)
    return matrices


def test_mass_and_centre_of_gravity_are_the_published_ones(recording: Recording) -> None:
    found = estimate_parameters(recording, CASE).physical
    assert found["m"].value == pytest.approx(0.932, abs=0.004)
    assert found["zC"].value == pytest.approx(0.0439, abs=0.0005)
    assert found["xC"].value == pytest.approx(0.0003, abs=0.0005)
    assert found["yC"].value == pytest.approx(0.0001, abs=0.0005)


@pytest.mark.parametrize("channel", range(6))
def test_published_offsets_lie_in_their_95_percent_intervals(recording: Recording, channel: int) -> None:
    estimate = estimate_parameters(recording, CASE)
    low, high = estimate.physical[f"f_q0_{channel + 1}"].interval(estimate.fit.freedom)
    assert low <= OFFSETS[channel] <= high


def test_offsets_carry_the_unit_of_their_channel(recording: Recording) -> None:
    found = estimate_parameters(recording, CASE).physical
    assert [found[f"f_q0_{k}"].unit for k in range(1, 7)] == ["N"] * 3 + ["N m"] * 3


def test_the_wrong_sense_is_told_by_a_negative_mass(recording: Recording) -> None:
    with pytest.raises(IdentificationError, match=r"force channels 1, 2, 3, 4, 5, 6 .*sense") as caught:
        estimate_parameters(recording, with_sense("sensor_on_load"))
    one_line(caught.value)


def test_the_first_twelve_poses_predict_the_other_twelve(recording: Recording) -> None:
    """Least squares by another hand left an rms of 0.143 N and 0.0047 N m."""
    first, rest = slice(0, 12), slice(12, 24)
    estimate = estimate_parameters(rows(recording, first), CASE)
    error = recording.forces[rest] - weight_regressor(recording, rest) @ estimate.fit.values
    assert np.sqrt(np.mean(error[:, :3] ** 2, axis=0)).max() <= 0.1435
    assert np.sqrt(np.mean(error[:, 3:] ** 2, axis=0)).max() <= 0.00475


def test_newtons_and_newton_metres_are_weighted_by_their_own_noise(recording: Recording) -> None:
    estimate = estimate_parameters(recording, CASE)
    assert estimate.fit.white_noise == pytest.approx(1.0, abs=1e-3)  # dimensionless
    np.testing.assert_allclose(estimate.residual_rms[:3], [0.131, 0.047, 0.057], atol=0.002)
    np.testing.assert_allclose(estimate.residual_rms[3:], [2.4e-3, 4.4e-3, 1.4e-3], atol=1e-4)


@pytest.mark.first(1)
@pytest.mark.parametrize("cutoff", few(5.0, 40.0, 7.0, 10.0, kept=2))
def test_delay_and_mass_of_the_moving_run_hold_for_every_filter(cutoff: float) -> None:
    """At 5 Hz a delay passes for a turn of the accelerometer, unless it has a band of its own."""
    form = CASE.recording.model_copy(update={"filter_cutoff_Hz": cutoff})
    case = CASE.model_copy(update={"recording": form})
    estimate = estimate_parameters(moving(case), case)
    assert estimate.delay is not None
    assert -6.5e-3 < estimate.delay.value < -5.2e-3
    mass = estimate.physical["m"]
    assert abs(mass.value - 0.932) < 1.96 * mass.reported
    assert mass.reported < 0.015  # it is off by 4 to 10 g


def test_a_gap_of_half_a_step_between_evaluated_samples_leaves_no_place_twice() -> None:
    run = wrist_run(moving(CASE), CASE, identification_model(CASE, 6), cutoff=5.0)
    assert run.filter.stride % 2 == 0
    pause = run.filter.step * (run.filter.stride // 2)
    later = replace(run, t=np.where(np.arange(len(run.t)) < 40, run.t, run.t + pause))
    assert np.all(np.diff(later.places) >= 1)
    assert later.places[-1] - run.places[-1] in (0, 1)


@pytest.mark.repeats
def test_gaps_of_single_streams_leave_the_mass_where_it_is() -> None:
    """A fifth of a second of the accelerometer and a tenth of the forces are lost: sections stand each by itself."""
    whole = moving(CASE)
    assert whole.t is not None
    keep = (whole.t < whole.t[0] + 3.5) | (whole.t > whole.t[0] + 3.6)
    (felt,) = [s for s in whole.others if s.specific_forces is not None]
    assert felt.t is not None
    there = (felt.t < whole.t[0] + 2.0) | (felt.t > whole.t[0] + 2.2)
    assert felt.specific_forces is not None
    less = replace(felt, t=felt.t[there], specific_forces=felt.specific_forces[there])
    others = tuple(less if s is felt else s for s in whole.others)
    run = replace(whole, t=whole.t[keep], forces=whole.forces[keep], others=others)
    sound, estimate = estimate_parameters(whole, CASE), estimate_parameters(run, CASE)
    assert sound.samples.recorded_count - estimate.samples.recorded_count > 0.3 * 690
    assert sum(tells(w, "samples are missing", "no filter") for w in estimate.warnings) == 2
    mass, before = estimate.physical["m"], sound.physical["m"]
    assert abs(mass.value - before.value) < 2.0 * before.reported
    assert abs(mass.value - 0.932) < 1.96 * mass.reported
    assert estimate.delay is not None
    assert sound.delay is not None
    assert abs(estimate.delay.value - sound.delay.value) < 1e-3


@pytest.mark.first(1)
@pytest.mark.parametrize("push", [0.0, 5.0])
def test_a_push_against_the_tool_is_found_within_50_ms_and_left_out(push: float) -> None:
    run = moving(CASE)
    assert run.t is not None
    pushed = (run.t > run.t[0] + 3.0) & (run.t < run.t[0] + 3.2)
    forces = run.forces + push * pushed[:, None] * np.array([0.0, 1.0, 0.0, 0.05, 0.0, 0.0])
    estimate = estimate_parameters(replace(run, forces=forces), CASE)
    found = [w for w in estimate.warnings if "contact" in w]
    if not push:
        assert found == []
        return
    told = re.fullmatch(r".*: external contact from (.*) to (.*) s, up to (.*) N; left out", found[0])
    assert told is not None
    begin, end, peak = (float(v) for v in told.groups())
    assert abs(begin - run.t[0] - 3.0) < 0.05
    assert abs(end - run.t[0] - 3.2) < 0.05
    assert peak == pytest.approx(push, rel=0.2)
    free = estimate_parameters(run, CASE)
    assert abs(estimate.physical["m"].value - free.physical["m"].value) < 0.3 * free.physical["m"].reported
    assert abs(estimate.delay.value - free.delay.value) < free.delay.std


@pytest.mark.repeats
def test_of_a_motion_that_no_drive_says_the_own_model_is_looked_at() -> None:
    """Positions, and so other models, are not known; the page of a result is made all the same."""
    result = hx.identify(moving(CASE), CASE)
    (own,) = identifiability_of_models(result)
    assert (own.model, own.determined) == (result.record.model, True)
    assert hx.identifiability(moving(CASE), case=CASE).names == own.names
    assert "Which parameters can be told apart" in identify_page(result)


def test_all_models_of_a_wrist_are_those_that_its_orientations_carry() -> None:
    choice = hx.identify_models(moving(CASE), CASE)
    assert {row.model for row in choice.rows} == {0, 6}
