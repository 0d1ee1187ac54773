"""The payload experiment: an ideal machine meets theory exactly, a disturbed one errs as far as it is told why."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import Browser

from cases.disturbances import Disturbances
from cases.loading import load_case
from cases.schema import Case
from identification.executed import PoseExecution
from identification.hexapod import Hexapod
from identification.identify import identify
from identification.loaded import Circumstances
from identification.recording import STRUTS, Recording
from identification.simulate import simulate_standstills
from planner.validation import RIGID, SHOWN, Cause, Excitation, _theory, causes, dynamic, static, steps, without_each
from tests.helpers import Harmonic, ideal, paper_poses
from tests.planner.browser import opened
from tests.planner.command_line import call, hexcite, refused

CASE = load_case("hexapod")
Q5N = (1.81, 1.93, 2.07, 2.33, 2.74, 3.14)  # Table 7


def poses() -> np.ndarray:
    from scipy.spatial.transform import Rotation

    places, turns = paper_poses()
    return np.column_stack([places, Rotation.from_matrix(turns).as_euler("xyz")])[::8]


def test_an_ideal_machine_meets_theory_exactly():
    found = list(steps(CASE, static(ideal(CASE), "ideal", "", 1.0, poses(), 0), None))
    assert [s.load for s in found] == pytest.approx([19.93 * k for k in range(6)])
    for step in found:
        for name in SHOWN:
            if name in step.theory:
                assert step.deviation(name) == pytest.approx(0.0, abs=1e-9), name
        assert step.estimate.physical["m"].value == pytest.approx(31.83 + step.load)


def test_theory_follows_what_was_identified_without_payload_and_truth_does_not():
    first, second, *_ = steps(CASE, static(CASE, "Q", "", 1.0, poses(), 0), CASE.simulation.disturbances)
    bare = first.estimate.physical["m"].value
    assert second.theory["m"] == pytest.approx(bare + 19.93, rel=1e-12)
    assert second.truth["m"] == pytest.approx(31.83 + 19.93, rel=1e-12)
    assert second.theory["f_q0_3"] == first.estimate.physical["f_q0_3"].value


def test_the_cause_is_the_disturbance_without_which_the_error_vanishes():
    cause = Cause("D", 5, "m", 0.03, {"the ripple": 0.029, "the mode": -0.001, "the errors of the pose": 0.031})
    assert cause.name == "the mode"
    assert "+3.00 %" in cause.sentence()
    assert "without the mode it would be off by -0.10 %" in cause.sentence()


def test_each_disturbance_is_taken_away_alone():
    whole = CASE.simulation.disturbances.model_dump()
    changed = [
        {k for k, v in d.model_dump().items() if v != whole[k]}
        for d in without_each(CASE.simulation.disturbances).values()
    ]
    assert changed == [{"mode_Hz"}, {"strut_velocity_noise_mm_s"}, {"pose_error_N", "pose_error_of_load"}]


def test_what_is_not_off_needs_no_cause():
    excitation = static(CASE, "ideal", "", 1.0, poses(), 0)
    found = list(steps(CASE, excitation, None))
    assert all(abs(s.error(name)) < 3.0 for s in found for name in ("m", "zC"))
    assert causes(CASE, excitation, found, CASE.simulation.disturbances) == []


def test_a_machine_that_errs_by_its_mode_is_told_to_err_by_its_mode():
    """Forces are five per cent too large wherever the mode is there, and right without it."""
    exact = static(CASE, "Q", "", 1.0, poses(), 0)

    def recorded(weights: int, disturbances: Disturbances | None) -> Recording:
        right = exact.recorded(weights, None)
        return right if disturbances.mode_Hz == RIGID else replace(right, forces=1.05 * right.forces)

    found = CASE.simulation.disturbances
    excitation = Excitation("Q", "", 1.0, recorded)
    (cause,) = [c for c in causes(CASE, excitation, list(steps(CASE, excitation, found)), found) if c.parameter == "m"]
    assert cause.name == "the structural mode"
    assert cause.error == pytest.approx(0.05, abs=0.005)
    assert cause.without["the ripple of the struts"] == pytest.approx(cause.error)


def test_theory_of_a_motion_contains_the_inertia_of_the_weights():
    """An ideal moving run: what theory says of a loaded platform is what the machine truly has."""
    motion = Harmonic(seed=1, duration=4.0)
    run = (PoseExecution(Hexapod.of(CASE), motion), np.array([[0.5, 3.5]]))
    found = dynamic(ideal(CASE), "D", "", 3.0, run, 0)
    for k, recording in enumerate((found.recorded(0, None), found.recorded(2, None))):
        estimate = identify(recording, CASE)
        if k == 0:
            theory = _theory(estimate, CASE.payloads.weights[:2])
        else:
            assert estimate.physical["IC33"].value == pytest.approx(theory["IC33"], rel=1e-3)
            assert estimate.physical["m"].value == pytest.approx(theory["m"], rel=1e-4)


def test_the_command_prints_table_7_and_says_what_machine_it_was(tmp_path: Path, browser: Browser):
    answer = hexcite("validate", "hexapod", "--methods", "Q5N", "-o", tmp_path / "v", "--json").json()
    assert answer["simulated"] is True
    assert "structural mode" in answer["machine"]
    assert len(answer["rows"]) == 6
    for row, printed in zip(answer["rows"], Q5N, strict=True):
        assert printed / 1.6 < row["s0_N"] < printed * 1.5
        assert abs(row["relative_deviation"]["m"]) < 0.02
    held = {p.name for p in (tmp_path / "v").iterdir()}
    assert held == {"report.html", "validation.json", "plots", "plans"}
    with opened(browser, Path(answer["report"]), 400) as tab:
        assert (tab.errors, tab.requests) == ([], [])
        assert "100 kg" in tab.page.locator("table").nth(1).inner_text()


def write_standstills(case: Case, file: Path, weights: int) -> None:
    """As a real machine would record it: struts and forces, a row a pose."""
    around = Circumstances(case.payloads.weights[:weights])
    recording = simulate_standstills(case, poses(), 1000, weights, around)
    struts = Hexapod.of(case).strut_lengths(poses()) * 1e3
    header = ",".join((*STRUTS, *(f"f{k}_N" for k in range(1, 7))))
    np.savetxt(file, np.hstack([struts, recording.forces]), delimiter=",", header=header, comments="", fmt="%.8f")


def test_recordings_of_a_machine_are_validated_without_knowing_its_truth(tmp_path: Path):
    (tmp_path / "runs" / "static").mkdir(parents=True)
    for k in range(3):
        write_standstills(CASE, tmp_path / "runs" / "static" / f"{k}.csv", k)
    answer = call("validate", "hexapod", "--recordings", tmp_path / "runs", "-o", tmp_path / "v", "--json").json()
    assert answer["simulated"] is False
    assert [row["method"] for row in answer["rows"]] == ["static"] * 3
    for row in answer["rows"]:
        assert row["error_in_std"] == {}
        assert abs(row["relative_deviation"]["m"]) < 5e-3
        assert abs(row["relative_deviation"]["f_q0_3"]) < 1e-3


def test_what_cannot_be_validated_is_refused(tmp_path: Path):
    assert "method 'Q6' is unknown" in refused("validate", "hexapod", "--methods", "Q6", "-o", tmp_path / "v")
    assert "name each once" in refused("validate", "hexapod", "--methods", "ptp,ptp", "-o", tmp_path / "v")
    assert "payloads: is missing" in refused("validate", "ft_wrist", "-o", tmp_path / "v")
    (tmp_path / "runs" / "one").mkdir(parents=True)
    write_standstills(CASE, tmp_path / "runs" / "one" / "0.csv", 0)
    said = refused("validate", "hexapod", "--recordings", tmp_path / "runs", "-o", tmp_path / "v")
    assert "a validation needs at least 0 and 1" in said
    assert not (tmp_path / "v").exists()
