"""The command `validate`: simulated machines, recordings of a real one, and what it refuses."""

from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import Browser

from cases.recording_format import STRUTS
from cases.schema import Case
from identification.hexapod import Hexapod
from identification.simulate import Circumstances
from planner.comparison.methods import METHODS
from tests.helpers import few, tells
from tests.planner.browser import opened
from tests.planner.command_line import call, refused
from tests.planner.comparison.excitations import CASE, poses
from tests.simulated_machine import simulate_standstills

Q5N = (1.81, 1.93, 2.07, 2.33, 2.74, 3.14)  # Table 7


@pytest.mark.parametrize("weights", few("0", "0,5"))
def test_the_command_prints_table_7_and_says_what_machine_it_was(weights: str, tmp_path: Path, browser: Browser):
    answer = call(
        "validate", "hexapod", "--methods", "Q5N", "--weights", weights, "-o", tmp_path / "v", "--json"
    ).json()
    assert answer["simulated"] is True
    assert "structural mode" in answer["machine"]
    assert answer["not_run"] == {}
    alone, truth = answer["recommendation"]["sentences"]
    assert "nothing to choose from" in alone
    errors = [abs(error) for row in answer["rows"] for error in row["error_in_std"].values()]
    assert tells(truth, f"{sum(error <= 3.0 for error in errors)} of {4 * len(answer['rows'])}", "of the truth")
    assert [row["weights"] for row in answer["rows"]] == [int(k) for k in weights.split(",")]
    for row in answer["rows"]:
        printed = Q5N[row["weights"]]
        assert printed / 1.5 < row["s0_N"] < printed * 1.5
        assert row["duration_s"] == pytest.approx(70.0, abs=2.0)
        assert abs(row["relative_deviation"]["m"]) < 0.02
    held = {p.name for p in (tmp_path / "v").iterdir()}
    assert held == {"report.html", "validation.json", "plans", "programs"}
    assert (tmp_path / "v" / "programs" / "Q5N.mpf").is_file()
    with opened(browser, Path(answer["report"]), 400) as tab:
        assert (tab.errors, tab.requests) == ([], [])
        assert f"{20 * int(weights[-1])} kg" in tab.page.locator("table").nth(2).inner_text()


def test_the_help_names_every_method():
    shown = " ".join(call("validate", "--help").out.replace("│", " ").split())
    assert f"by default all: {', '.join(METHODS)}." in shown


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
    runs = ("validate", "hexapod", "--recordings", tmp_path / "runs", "-o", tmp_path / "w")
    assert tells(refused(*runs, "--methods", "ptp"), "no folder", "static")
    for option in (("--weights", "0"), ("--on", "linuxcnc")):
        assert tells(refused(*runs, *option), f"{option[0]}: ", "--recordings")
    (tmp_path / "runs" / "static" / "1.csv").unlink()
    assert tells(refused(*runs, "--methods", "static"), "up to 2", "not 1")
    assert not (tmp_path / "w").exists()


def test_what_cannot_be_validated_is_refused(tmp_path: Path):
    assert "method 'Q6' is unknown" in refused("validate", "hexapod", "--methods", "Q6", "-o", tmp_path / "v")
    assert "name each once" in refused("validate", "hexapod", "--methods", "ptp,ptp", "-o", tmp_path / "v")
    assert "how many are mounted" in refused("validate", "hexapod", "--weights", "1", "-o", tmp_path / "v")
    assert "--starts 1 to 1000" in refused("validate", "hexapod", "--starts", "0", "-o", tmp_path / "v")
    assert "payloads: is missing" in refused("validate", "ft_wrist", "-o", tmp_path / "v")
    (tmp_path / "runs" / "one").mkdir(parents=True)
    write_standstills(CASE, tmp_path / "runs" / "one" / "0.csv", 0)
    said = refused("validate", "hexapod", "--recordings", tmp_path / "runs", "-o", tmp_path / "v")
    assert "at least 0 and 1" in said
    assert not (tmp_path / "v").exists()
