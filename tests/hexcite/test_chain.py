"""The chain, each command in a process of its own: what one writes the next one reads."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cases.schema import Case
from identification.model.model import identification_model
from identification.model.parameters import linear_parameters, physical_form
from tests.hexcite.command_line import call

Chain = dict[str, dict[str, Any]]


def test_every_estimate_lies_within_four_standard_deviations_of_the_truth(chain: Chain, hexapod_case: Case):
    model = identification_model(hexapod_case, 9)
    u = linear_parameters(model, hexapod_case.simulation.parameters)
    truth, _ = physical_form(model).of(u, np.zeros((len(u), len(u))))
    found = chain["identify"]["parameters"]
    assert len(found) == len(truth) == 20
    for (name, p), true in zip(found.items(), truth, strict=True):
        assert abs(p["value"] - true) < 4 * max(p["std"], p["std_robust"]), name


def test_the_estimates_are_as_good_as_the_plan_promised(chain: Chain):
    """One run's standard deviations are what the design predicts, apart from noise in them and the delay's share."""
    for name, std in chain["plan"]["predicted_std"].items():
        assert chain["identify"]["parameters"][name]["std"] == pytest.approx(std, rel=0.25), name


def test_the_virtual_controller_keeps_time_path_and_information(chain: Chain):
    run, plan = chain["run"], chain["plan"]
    assert run["duration_s"] == pytest.approx(plan["duration_s"], abs=1e-6)
    assert run["planned_s"] == pytest.approx(plan["duration_s"], abs=1e-6)
    assert run["path_error_mm"] < 3e-3  # what drives round off between set points of 1 ms: a / 6 of 1 ms squared
    assert run["d_efficiency"] == pytest.approx(plan["d_efficiency"], rel=0.01)
    assert chain["identify"]["samples"] == pytest.approx(1000 * plan["duration_s"], abs=1)


def test_what_post_proved_check_finds_again_in_the_file(chain: Chain):
    assert chain["check"]["ok"]
    assert chain["check"]["violations"] == []
    assert chain["check"]["limits"] == chain["post"]["limits"]
    assert chain["check"]["duration_s"] == chain["post"]["duration_s"]


def test_the_recording_knows_its_case_program_and_seed(chain: Chain, shared: Path):
    about = json.loads((shared / "recording" / "recording.json").read_text())
    assert (about["case"], about["seed"], about["simulated"]) == ("hexapod", 0, True)
    assert about["case_hash"] == chain["plan"]["case_hash"]
    assert Path(about["program"]) == shared / "excitation.ngc"


@pytest.mark.repeats
def test_another_seed_is_other_noise_and_the_same_seed_the_same(chain: Chain, shared: Path, tmp_path: Path):
    first = (shared / "recording" / "recording.csv").read_bytes()
    for seed, same in ((0, True), (1, False)):
        folder = tmp_path / f"seed-{seed}"
        call("run", shared / "excitation.ngc", "--case", "hexapod", "--seed", seed, "-o", folder, "--json").json()
        assert ((folder / "recording.csv").read_bytes() == first) is same


@pytest.mark.slow
def test_a_model_with_fewer_parameters_can_be_asked_for(chain: Chain, shared: Path, tmp_path: Path):
    answer = call("identify", shared / "recording", "--model", 6, "-o", tmp_path / "six", "--json").json()
    assert (answer["model"], answer["rank"]) == (6, 16)
    assert answer["s0_N"] > chain["identify"]["s0_N"]  # the error terms that it leaves out are in the forces
