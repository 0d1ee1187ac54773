"""What a run cannot tell is refused by name, with the file and a remedy, before it becomes a number."""

import re
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from cases.base.errors import CaseError, HexciteError, IdentificationError, RecordingError
from cases.schema import Case, load_case
from identification.identify import estimate_parameters
from identification.machines.hexapod import Hexapod
from identification.motion.motion import Standstill
from identification.recording.recording import Recording
from identification.simulate import simulate_recording
from tests.helpers import HOME, Harmonic, one_line, paper_poses
from tests.simulated_machine import PoseExecution

CASE = load_case("hexapod")
WRIST = load_case("ft_wrist")
RUN = simulate_recording(
    CASE, PoseExecution(Hexapod.of(CASE), Harmonic(duration=1.5)), np.array([[0.2, 1.3]]), 0, "run.csv"
)
TURNS = paper_poses()[1][:24]
ORDER = np.random.default_rng(0).permutation(len(RUN.forces))  # poses one by one, as nobody moves
STILL = replace(RUN, t=None, trigger=None, drives=RUN.drives[ORDER], forces=RUN.forces[ORDER])
ROTATIONS = Recording("run.csv", None, None, TURNS, np.random.default_rng(0).normal(size=(24, 6)), None)


def standing(trigger: bool) -> Recording:
    execution = PoseExecution(Hexapod.of(CASE), Standstill(HOME, 1.5))
    recording = simulate_recording(CASE, execution, np.array([[0.2, 1.3]]), 0, "run.csv")
    return recording if trigger else replace(recording, trigger=None)


def first(count: int) -> Recording:
    return replace(
        RUN, t=RUN.t[:count], drives=RUN.drives[:count], forces=RUN.forces[:count], trigger=RUN.trigger[:count]
    )


def triggered(count: int) -> Recording:
    on = np.zeros(len(RUN.t), dtype=bool)
    on[700 : 700 + count] = True
    return replace(RUN, trigger=on)


def with_struts(change: Callable[[np.ndarray], None], of: Recording) -> Recording:
    struts = of.drives.copy()
    change(struts)
    return replace(of, drives=struts)


def stuck(channel: int, of: Recording) -> Recording:
    forces = of.forces.copy()
    forces[:, channel] = 12.5
    return replace(of, forces=forces)


def jam(struts: np.ndarray) -> None:
    struts[1000:] = [0.3, 1.5, 0.3, 1.5, 0.3, 1.5]


def metres(struts: np.ndarray) -> None:
    struts /= 1000.0


def tremble(struts: np.ndarray) -> None:
    struts += 2e-5 * np.sin(np.arange(len(struts)))[:, None]


def same_pose(struts: np.ndarray) -> None:
    struts[:] = struts[0]


def without_filter() -> Case:
    return CASE.model_copy(update={"recording": CASE.recording.model_copy(update={"filter_cutoff_Hz": None})})


def filtered_at(cutoff: float) -> Case:
    return CASE.model_copy(update={"recording": CASE.recording.model_copy(update={"filter_cutoff_Hz": cutoff})})


UNFIT, UNREADABLE = IdentificationError, RecordingError

# what -> recording, case, model, error, what the message says beside the file
REFUSALS: dict[str, tuple[Recording, Case, int | None, type[HexciteError], str]] = {
    "inertia from standstills": (STILL, CASE, 9, UNFIT, "contains inertia.*choose a model from 0"),
    "position from rotations": (ROTATIONS, WRIST, 5, UNFIT, "needs the platform's position.*choose model 0"),
    "inertia from rotations at rest": (ROTATIONS, WRIST, 6, UNFIT, "standstills cannot excite"),
    "a motion of rotations only": (replace(ROTATIONS, t=np.arange(24.0)), WRIST, None, UNREADABLE, "and an acceler"),
    "a standstill with trigger": (standing(True), CASE, None, UNFIT, "the pose is constant"),
    "a standstill without trigger": (standing(False), CASE, None, UNFIT, "the pose is constant"),
    "a machine that trembles": (with_struts(tremble, standing(True)), CASE, None, UNFIT, "constant .*at least 0.1"),
    "a motion without clock": (replace(RUN, t=None), CASE, None, UNREADABLE, "no t_s column.*smooth like samples"),
    "one pose many times": (with_struts(same_pose, STILL), CASE, None, UNFIT, "rank 6 of 14: m, "),
    "one sample": (first(1), CASE, None, UNREADABLE, "."),
    "two samples": (first(2), CASE, None, UNREADABLE, "2 samples are too few for a 40 Hz filter"),
    "shorter than the filter": (first(150), CASE, None, UNREADABLE, "150 samples are too few.*record longer"),
    "one standstill": (replace(first(1), t=None), CASE, None, UNFIT, "1 samples? .*14 unknowns"),
    "trigger never on": (triggered(0), CASE, None, UNREADABLE, "trigger: is never 1"),
    "forces that are all zero": (replace(RUN, forces=0 * RUN.forces), CASE, None, UNFIT, "."),
    "a force channel that is stuck": (stuck(2, RUN), CASE, None, UNFIT, "channel 3 reads"),
    "the same at standstill": (stuck(4, STILL), CASE, None, UNFIT, "channel 5 reads"),
    "struts in metres": (with_struts(metres, RUN), CASE, None, UNFIT, 'struts are in m: .*units.struts = "m"'),
    "standstills in metres": (with_struts(metres, STILL), CASE, None, UNFIT, "no pose has the strut lengths.*unit"),
    "no filter": (RUN, without_filter(), None, UNREADABLE, "set recording.filter_cutoff_Hz"),
    "a filter too fast": (RUN, filtered_at(300.0), None, UNREADABLE, "too high for 1000 samples a second; at most 200"),
}  # fmt: skip


def at_length(what: str) -> object:
    """Of standstills that no pose explains all causes are looked for."""
    return pytest.param(what, marks=pytest.mark.repeats) if what == "standstills in metres" else what


@pytest.mark.parametrize("what", [at_length(what) for what in REFUSALS])
def test_it_is_refused_by_name(what: str) -> None:
    recording, case, number, kind, says = REFUSALS[what]
    with pytest.raises(kind, match=says) as caught:
        estimate_parameters(recording, case, number)
    assert "run.csv" in one_line(caught.value)


@pytest.mark.repeats
def test_the_highest_cutoff_that_is_named_is_taken() -> None:
    assert estimate_parameters(RUN, filtered_at(200.0)).fit.white_noise > 0.0


def test_another_model_is_answered_with_the_choices() -> None:
    with pytest.raises(IdentificationError, match=r"model 11\b.*choose 0, 1, 2"):
        estimate_parameters(RUN, CASE, 11)


def test_struts_of_a_case_without_machine_are_refused_by_the_case() -> None:
    with pytest.raises(CaseError, match="case ft_wrist: machine: is missing"):
        estimate_parameters(STILL, WRIST)


def place(error: BaseException) -> int:
    """Index of the row that a message names, as sample or as line of the file."""
    found = re.search(r"(sample|line) (\d+)", one_line(error))
    assert found is not None
    return int(found[2]) - {"sample": 1, "line": 2}[found[1]]


@pytest.mark.first(1)
@pytest.mark.parametrize(("recording", "reach"), [(RUN, 110), (STILL, 0)], ids=["moving", "standstills"])
@pytest.mark.usefixtures("causes_aside")
def test_struts_that_cannot_close_are_named_by_their_place_in_the_recording(recording: Recording, reach: int) -> None:
    """Rows from 1000 on are impossible; in a moving run the filter smears them by its own length."""
    with pytest.raises(IdentificationError, match=r"no pose.*strut lengths") as caught:
        estimate_parameters(with_struts(jam, recording), CASE)
    assert abs(place(caught.value) - 1000) <= reach


@pytest.mark.parametrize("count", [1, 4, pytest.param(20, marks=pytest.mark.repeats)])
def test_a_pulse_is_no_window_and_the_motion_is_evaluated(count: int) -> None:
    estimate = estimate_parameters(triggered(count), CASE)
    assert any(f.kind == "window" and f.severity == "warning" and "pulses" in f.sentence for f in estimate.findings)
    assert len(estimate.residuals) > 50  # behind the filter, of the whole motion
