"""`hexcite identify` with what is done to a moving run beforehand."""

import json
from pathlib import Path

import numpy as np
import pytest

from cases.recording_format import BAR_FORCES, STRUTS
from cases.schema import load_case
from identification.hexapod import Hexapod
from identification.recording import write_recording
from tests.helpers import Harmonic, tells
from tests.identification.repeating import Repeating, recorded
from tests.planner.command_line import call, refused
from tests.simulated_machine import PoseExecution, true_forces

CASE = load_case("hexapod")
TRUTH = {"m": 31.83, "zC": 0.10505, "IC33": 0.91, "k3": 28.27}


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A recording of three periods of 1.5 s."""
    file = tmp_path_factory.mktemp("run") / "run.csv"
    write_recording(file, recorded(CASE, Repeating(1.5, 3)), CASE)
    return file


def identify(run: Path, tmp_path: Path, *words: object) -> list[object]:
    return ["identify", run, "--case", "hexapod", "-o", tmp_path / "result", *words]


@pytest.mark.parametrize("words", [("--period", "auto"), ("--period", "1.5s", "--harmonics", 12)])
def test_a_periodic_run_is_averaged(words: tuple, run: Path, tmp_path: Path) -> None:
    answer = call(*identify(run, tmp_path, "--json", *words)).json()
    found = answer["periodic"]
    assert found["period_s"] == pytest.approx(1.5, abs=1e-6)
    assert (found["periods"], found["harmonics_chosen"]) == (3, "auto" in words)
    assert (found["from_s"], found["to_s"]) == (pytest.approx(0.4, abs=2e-3), pytest.approx(4.9, abs=2e-3))
    assert json.loads((tmp_path / "result" / "result.json").read_text())["periodic"] == found
    for name, truth in TRUTH.items():
        p = answer["parameters"][name]
        assert abs(p["value"] - truth) < 4.5 * max(p["std"], p["std_robust"]), name


def test_people_are_told_which_part_was_used(run: Path, tmp_path: Path) -> None:
    text = " ".join(call(*identify(run, tmp_path, "--period", "auto")).out.split())
    assert tells(text, "3 periods of 1.5 s", "0.400 to 4.899 s", "struts repeat within")
    assert "harmonics, up to" in text
    assert "3 periods of 1.5 s" in (tmp_path / "result" / "report.html").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--period", "soon"), "--period soon: is not a period; give auto or seconds"),
        (("--period", "-1"), "--period -1: is not a period"),
        (("--period", "nan"), "--period nan: is not a period"),
        (("--period", "1.1"), "--period 1.1: a period later the struts are"),
        (("--period", "90"), "fits into it"),
        (("--harmonics", "5"), "add --period auto"),
        (("--flexible", "--period", "auto"), "--flexible: lowers the low-pass, which --period does without"),
        (("--flexible", "--prior", "m=33+-0.5kg"), "--flexible sees a mode in struts behind the low-pass"),
        (("--period", "auto", "--harmonics", "0"), "--harmonics 0: is not a number of harmonics"),
        (("--period", "auto", "--harmonics", "999"), "give 1 to 60"),
    ],
)
def test_what_cannot_be_is_refused(words: tuple, message: str, run: Path, tmp_path: Path) -> None:
    assert message in refused(*identify(run, tmp_path, *words))
    assert not (tmp_path / "result").exists()


def test_a_run_that_does_not_repeat_is_refused_with_what_was_measured(tmp_path: Path) -> None:
    file = tmp_path / "once.csv"
    write_recording(file, recorded(CASE, Repeating(3.0, 1)), CASE)
    assert tells(refused(*identify(file, tmp_path, "--period", "auto")), "not periodic", "best period")


def test_forces_and_struts_of_different_rates_are_one_run_of_several_files(tmp_path: Path) -> None:
    """Struts every 2 ms, forces ten times as often: the noise of 3 N falls to 0.95 N, and people are told."""
    execution = PoseExecution(Hexapod.of(CASE), Harmonic(duration=2.5))
    t, fine = np.arange(0.0, 2.5, 2e-3), np.arange(0.0, 2.5, 2e-4)
    forces = true_forces(CASE, execution, fine) + 3.0 * np.random.default_rng(0).normal(size=(len(fine), 6))
    for name, columns, clock, values in (
        ("struts.csv", STRUTS, t, execution.struts(t) * 1e3),
        ("forces.csv", BAR_FORCES, fine, forces),
    ):
        rows = np.column_stack([clock, values])
        np.savetxt(tmp_path / name, rows, "%.9f", ",", header=",".join(["t_s", *columns]), comments="")
    words = ("identify", tmp_path / "forces.csv", tmp_path / "struts.csv", "--case", "hexapod", "-o", tmp_path / "r")
    answer = call(*words, "--json").json()
    assert answer["averaged"]["ratio"] == pytest.approx(10.0)
    assert answer["s0"] == pytest.approx(3.0 / np.sqrt(10.0), rel=0.15)
    for name, truth in TRUTH.items():
        p = answer["parameters"][name]
        assert abs(p["value"] - truth) < 4.5 * max(p["std"], p["std_robust"]), name
    assert tells(answer["notes"][0], "10 samples averaged", "2 ms", "no group delay")
