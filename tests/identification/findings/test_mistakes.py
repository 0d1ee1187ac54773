"""Mistakes that people make are named with a remedy that works; what is none of them, and sound runs, are not."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from cases.base.errors import IdentificationError
from cases.editing import write_keys
from cases.schema import Case, load_case
from identification.findings.causes.answer import causes_of, mended, words_of
from identification.findings.causes.channels import of_point, of_turn
from identification.findings.causes.drives import of_joints, of_offset
from identification.findings.causes.hypothesis import (
    AS_RECORDED,
    Family,
    Hypothesis,
    Trial,
    case_of,
    channels_of,
    drives_of,
    together,
)
from identification.findings.causes.instants import instants_of
from identification.findings.causes.remedies import remedy
from identification.findings.causes.search import Search, search
from identification.findings.causes.trials import tried
from identification.identify import default_model, estimate_parameters, fits
from identification.model.model import identification_model
from identification.recording.recording import Recording, read, write_recording
from identification.samples.samples import GAUSS_MARKOV
from tests.helpers import few, one_line
from tests.machines_in_numpy import Body
from tests.mistaken.machines import NAMES, WRIST, machine, run
from tests.mistaken.mistakes import Mistake, mistakes_of, others_of

MASSES = {"hexapod": 31.83, "foreign": 36.48, "ur10_wrist": 2.61, "panda": 1.7, "five_axis_table": 17.4, WRIST: 1.7}


def searched(recording: Recording, case: Case) -> Search:
    found = search(recording, case, identification_model(case, default_model(recording, case)))
    assert found is not None
    return found


def mistake(of: str, name: str) -> Mistake:
    return next(m for m in mistakes_of(of) if m.name == name)


def said(of: str, *names: str, seed: int = 0) -> str:
    """What is said of a run with some mistakes."""
    sound = run(of, seed)
    recording, case = sound.recording, sound.case
    for name in names:
        recording, case = mistake(of, name).make(sound, recording, case)
    with pytest.raises(IdentificationError) as caught:
        estimate_parameters(recording, case)
    return one_line(caught.value)


@pytest.mark.first(2)
@pytest.mark.parametrize(
    ("of", "name"),
    few(
        ("foreign", "machine platform: half-angle the other way"),
        ("foreign", "machine platform: other side"),
        ("foreign", "home upside down"),
        ("ur10_wrist", "axes of the base"),
        ("ur10_wrist", "joints in rad"),
        ("ur10_wrist", "slope of 25 deg"),
        ("ur10_wrist", "moments about the tool"),
        ("five_axis_table", "all joints that turn, the other way"),
        (WRIST, "orientation as rotation vector"),
        *((of, m.name) for of in NAMES for m in mistakes_of(of)),
        kept=5,
    ),
)
def test_a_mistake_is_named(of: str, name: str) -> None:
    sound = run(of, 0)
    found = searched(*mistake(of, name).make(sound, sound.recording, sound.case))
    if found.sound:  # too small to be seen
        assert found.recorded is not None
        assert found.recorded.residuals < 3.0
        return
    recording, case = mistake(of, name).make(sound, sound.recording, sound.case)
    model = identification_model(case, default_model(recording, case))
    words = [cause.words for cause in causes_of(found, recording, case, model, fits(model.number, GAUSS_MARKOV))]
    assert any(mistake(of, name).named_in(text) for text in words), words
    assert all(entry.residuals < 1.35 for entry in found.explanations)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("of", "names"),
    few(
        ("foreign", ("machine base: full angle", "channels 1-4 exchanged")),
        ("ur10_wrist", ("joint 4 turns the other way", "channels 2-3 exchanged")),
        ("five_axis_table", ("sensor turned 30 about z", "axes of the base")),
        ("five_axis_table", ("sign of channel 3", "time twice too slow")),
        ("five_axis_table", ("gravity +z in the case", "sensor turned 90 about z")),
        (WRIST, ("orientation as zyx intrinsic", "axes of the base")),
        ("ur10_wrist", ("sensor turned -72 about z", "moments about the tool")),
        ("ur10_wrist", ("40 % compensated", "moments about the tool")),
        ("panda", ("channels 1-2, 4-5 exchanged", "gravity +z in the case")),
        ("hexapod", ("channels 1-2, 4-5 exchanged", "upper ends 3-4 exchanged")),
        ("panda", ("joints 6-7 exchanged", "forces 150 ms late")),
        ("panda", ("sensor turned -90 about y", "forces 150 ms late")),
        ("hexapod", ("struts 1-4 exchanged", "forces 150 ms late")),
        ("hexapod", ("sign of channel 2", "channels 1-2, 4-5 exchanged")),  # the sign is that of the sensor's channel
        kept=1,
    ),
)
def test_two_mistakes_at_once_are_named_together(of: str, names: tuple[str, str]) -> None:
    text = said(of, *names)
    for name in names:
        assert mistake(of, name).named_in(text), text


@pytest.mark.slow
def test_gravity_along_an_axis_is_no_slope_beside_a_clock_whose_pace_is_found() -> None:
    """Both sizes are found beside each other; the case gets the axis, not 89.9 deg."""
    names = ("gravity -x in the case", "time twice too slow")
    text = said("hexapod", *names, seed=19)
    assert all(mistake("hexapod", name).named_in(text) for name in names), text


@pytest.mark.slow
def test_a_point_beside_a_turn_is_told_in_the_axes_of_the_sensor_as_it_is() -> None:
    """(-60, 0, 40) mm in the axes of the case are (40, 0, 60) mm in those of a sensor turned by -90 deg about y."""
    turn, off = (mistake("ur10_wrist", name) for name in ("sensor turned -90 about y", "sensor 70 mm off"))
    text = said("ur10_wrist", turn.name, off.name)
    assert turn.named_in(text), text
    assert replace(off, sizes=(40.0, 0.0, 60.0)).named_in(text), text


@pytest.mark.slow
@pytest.mark.parametrize(
    ("seed", "names"),
    [
        (1, ("channels 2-3 exchanged", "moments about the tool")),  # the controller adds moments of exchanged forces
        (2, ("sensor turned 180 about z", "40 % compensated")),  # the weight is taken off as if it were not turned
    ],
)
def test_two_mistakes_in_an_order_that_is_not_tried_have_no_cause(seed: int, names: tuple[str, str]) -> None:
    """Others with a size come near enough to look like one."""
    sound = run("panda", seed)
    recording, case = sound.recording, sound.case
    for name in names:
        recording, case = mistake("panda", name).make(sound, recording, case)
    assert searched(recording, case).explanations == ()


def test_the_pace_of_a_gentle_run_is_right_by_its_deviation() -> None:
    """Its residuals are three times the noise: a filter that passes less of that at another pace would count."""
    slow, sound = mistake("hexapod", "time twice too slow"), run("hexapod", 4)
    recording, case = slow.make(sound, sound.recording, sound.case)
    model = identification_model(case, default_model(recording, case))
    found = searched(recording, case)
    words = [cause.words for cause in causes_of(found, recording, case, model, fits(model.number, GAUSS_MARKOV))]
    assert len(words) == 1
    assert slow.named_in(words[0]), words


TURN = Rotation.from_euler("y", -90.0, degrees=True)


@pytest.mark.parametrize(
    "both",
    [
        lambda case: (of_point(case, np.array([0.03, -0.05, 0.09]), 1.0), of_turn(case, TURN)),
        lambda case: (other_way(case, 3), of_offset(case.chain, 3, 40.0)),
    ],
    ids=["sensor moved and turned", "joint that turns the other way from another zero"],
)
def test_keys_of_two_remedies_mend_what_both_did_to_the_readings(
    both: Callable[[Case], tuple[Hypothesis, Hypothesis]],
) -> None:
    sound = run("ur10_wrist", 0)
    trial, recorded = together(*both(sound.case)), sound.recording
    assert recorded.drives is not None
    drives = drives_of(trial, recorded.drives.shape[1])
    wrong = replace(
        recorded,
        forces=recorded.forces @ np.linalg.inv(channels_of(trial)).T,
        drives=(recorded.drives - drives.offset) @ np.linalg.inv(drives.matrix).T,
    )
    assert left(wrong, sound.case) > 10.0
    assert left(wrong, sound.case, trial) < 1.3
    assert left(wrong, case_of(trial, sound.case)) < 1.3


def left(recording: Recording, case: Case, trial: Trial = AS_RECORDED) -> float:
    """What is left of a run, over its noise."""
    instants = instants_of(recording, case, identification_model(case, default_model(recording, case)))
    assert instants is not None
    return float(tried(instants.part(40), [trial], [AS_RECORDED]).residuals[0, 0])


def other_way(case: Case, joint: int) -> Hypothesis:
    """A joint of a chain that turns the other way."""
    assert case.chain is not None
    return next(
        hypothesis
        for hypothesis in of_joints(case, case.chain)
        if hypothesis.family is Family.SIGNS
        and hypothesis.drives is not None
        and np.flatnonzero(np.diag(hypothesis.drives.matrix) < 0.0).tolist() == [joint]
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    ("of", "name"),
    few(
        ("hexapod", "vibration of 9 Hz"),
        ("foreign", "a joint 12 mm off"),
        ("ur10_wrist", "crosstalk"),
        *((of, m.name) for of in NAMES for m in others_of(of)),
        kept=1,
    ),
)
def test_what_is_no_known_mistake_has_no_cause(of: str, name: str) -> None:
    sound = run(of, 0)
    other = next(m for m in others_of(of) if m.name == name)
    found = searched(*other.make(sound, sound.recording, sound.case))
    assert [words_of(entry.trial) for entry in found.explanations] == []


@pytest.mark.repeats
def test_moments_about_another_point_are_mended_by_the_sensor_s_origin() -> None:
    """The remedy moves the sensor to where moments are about: centre of gravity and inertia are those from there."""
    sound = run("ur10_wrist", 0)
    recording, case = mistake("ur10_wrist", "moments about the tool").make(sound, sound.recording, sound.case)
    found = searched(recording, case)
    mended_run, mended_case = mended(found.explanations[0].trial, recording, case)
    assert mended_case.chain is not None
    assert mended_case.chain.sensor.origin_mm != case.chain.sensor.origin_mm
    of_tool = estimate_parameters(mended_run, mended_case).physical
    of_sensor = estimate_parameters(sound.recording, sound.case).physical
    moved = [1e3 * (of_sensor[name].value - of_tool[name].value) for name in ("xC", "yC", "zC")]
    np.testing.assert_allclose(moved, [20.0, -30.0, 140.0], atol=6.0)
    assert abs(of_tool["m"].value - of_sensor["m"].value) < 4.0 * of_tool["m"].reported


@pytest.mark.slow
def test_what_was_tried_is_said_with_what_it_left() -> None:
    sound = run("foreign", 0)
    other = next(m for m in others_of("foreign") if m.name == "vibration of 9 Hz")
    recording, case = other.make(sound, sound.recording, sound.case)
    (tried,) = [w for w in estimate_parameters(recording, case).warnings if w.startswith("none of these")]
    assert "where noise makes 0." in tried
    assert "rings" in tried
    assert "struts" in tried


@pytest.mark.parametrize("of", NAMES)
@pytest.mark.parametrize("seeds", few(range(1, 4), range(4, 60)))
def test_sound_runs_need_no_cause(of: str, seeds: range) -> None:
    for seed in seeds:
        sound = run(of, seed)
        assert searched(sound.recording, sound.case).sound


def written(folder: Path, recording: Recording, case: Case) -> tuple[Path, Case]:
    """A recording as a file, and its case as it was written and read again."""
    file = folder / "run.csv"
    write_recording(file, recording, case)
    return file, load_case(str(case.save(folder / "case.toml", overwrite=True)))


@pytest.mark.first(1)
@pytest.mark.parametrize(
    ("of", "name"),
    few(
        ("foreign", "sign of channel 2"),
        ("ur10_wrist", "joints 1-2 exchanged"),
        ("foreign", "upper ends 3-4 exchanged"),
        ("foreign", "struts shifted"),
        ("hexapod", "all signs"),
        ("ur10_wrist", "sign of channel 3"),
        ("ur10_wrist", "sensor turned 30 about z"),
        ("ur10_wrist", "joint 6 off by 180"),
        ("ur10_wrist", "time in ms"),
        ("ur10_wrist", "gravity -x in the case"),
        ("five_axis_table", "joints in rad"),
        ("five_axis_table", "time twice too slow"),
        kept=2,
    ),
)
def test_the_keys_of_a_remedy_mend_the_run_when_it_is_read_again(of: str, name: str, tmp_path: Path) -> None:
    sound = run(of, 1)
    recording, wrong = mistake(of, name).make(sound, sound.recording, sound.case)
    file, case = written(tmp_path, replace(recording, case=wrong), wrong)
    found = searched(read(file, case), case)
    for entry in found.explanations:
        if "compensated" in words_of(entry.trial):
            continue  # no key gives back what a controller has taken off: record the raw wrench
        (found_remedy,) = remedy("", case, case_of(entry.trial, case))
        _, case = written(tmp_path, recording, wrong)
        write_keys(tmp_path / "case.toml", found_remedy.keys)
        edited = load_case(str(tmp_path / "case.toml"))
        estimate = estimate_parameters(read(file, edited), edited)
        mass = estimate.physical["m"]
        assert abs(mass.value - MASSES[of]) < 5.0 * mass.reported + 1e-3 * MASSES[of]


def test_a_load_that_is_lost_is_named_with_its_place_and_size() -> None:
    sound, plant = run("ur10_wrist", 3), machine("ur10_wrist").plant
    assert sound.motion is not None
    lost = Body(0.25, np.array([0.02, 0.0, 0.12]), 1e-4 * np.eye(3))
    forces = sound.recording.forces.copy()
    forces[1700:] -= plant.channels(plant.wrench(sound.motion, lost))[1700:]
    text = said_of(replace(sound.recording, forces=forces), sound.case)
    assert "the load changes by -0.2" in text
    line = int(text.split("at about line ")[1].split()[0])
    assert abs(line - 1702) < 40
    assert "cut the run there" in text


def test_offsets_that_leap_are_named_with_channels_place_and_size() -> None:
    sound = run("five_axis_table", 3)
    forces = sound.recording.forces.copy()
    forces[900:, 2] += 12.0
    text = said_of(replace(sound.recording, forces=forces), sound.case)
    assert "fz_N by +1" in text
    assert abs(int(text.split("at about line ")[1].split()[0]) - 902) < 40


def said_of(recording: Recording, case: Case) -> str:
    with pytest.raises(IdentificationError) as caught:
        estimate_parameters(recording, case)
    return one_line(caught.value)


@pytest.mark.repeats
@pytest.mark.parametrize(("of", "foreign"), few(("ur10_wrist", "strut"), ("foreign", "joints that turn")))
def test_the_words_are_those_of_the_machine(of: str, foreign: str) -> None:
    """A robot has no struts, a hexapod no joints that turn."""
    sound = run(of, 0)
    size = np.repeat([30.0, 3.0 if sound.case.sensor_frame.has_moments else 30.0], 3)  # within the sensors' range
    noise = size * np.random.default_rng(0).normal(size=sound.recording.forces.shape)
    smooth = np.apply_along_axis(lambda f: np.convolve(f, np.ones(40) / 40, "same"), 0, noise)
    recording = replace(sound.recording, forces=sound.recording.forces + smooth)
    try:
        text = " ".join(estimate_parameters(recording, sound.case).warnings)
    except IdentificationError as error:
        text = str(error)
    assert "none of these" in text
    assert foreign not in text.split("none of these")[1]


def test_keys_of_an_estimated_size_come_with_its_deviation() -> None:
    error = refused("ur10_wrist", "sensor turned 30 about z")
    (key,) = error.remedies[0].keys
    assert key.place[-1] == "rpy_deg"
    assert abs(key.value[2] - 30.0) < 4.0 * key.deviation[2]
    assert 0.0 < key.deviation[2] < 0.2
    assert key.deviation[:2] == pytest.approx([0.0, 0.0], abs=1e-3)
    assert error.remedies[0].to_json()["deviations"] == [key.deviation]


def test_a_size_that_would_make_wrong_numbers_is_not_for_the_case() -> None:
    """The point is known from inertia alone: written into the case it would shift moments of inertia unnoticed."""
    error = refused("ur10_wrist", "sensor 70 mm off")
    assert error.remedies == ()
    assert "too loosely known" in str(error)
    assert "would be reported" in str(error)
    assert mistake("ur10_wrist", "sensor 70 mm off").named_in(str(error))


def refused(of: str, name: str) -> IdentificationError:
    sound = run(of, 0)
    recording, case = mistake(of, name).make(sound, sound.recording, sound.case)
    with pytest.raises(IdentificationError) as caught:
        estimate_parameters(recording, case)
    return caught.value
