"""Results at the command line: exit codes and one line for what is wrong."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import hexcite as hx
from cases.tables import built_in_cases
from identification.results.estimate import entries_of_parameters, physical_values
from tests.damaged.runs import SOUND, STATED, Moves, machine, recorded
from tests.hexcite.command_line import call


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    where, of, case = tmp_path_factory.mktemp("results"), machine("hexapod"), hx.load_case("hexapod")
    for seed in (1, 2):
        hx.identify(recorded(of, Moves(of, seed, 4.0), seed, STATED, SOUND), case).save(where / f"run_{seed}")
    return where


def test_pool_writes_a_result_that_accept_judges(folder: Path) -> None:
    answer = call("pool", folder / "run_1", folder / "run_2", "-o", folder / "pooled", "--json").json()
    assert answer["pooled"]["degrees_of_freedom"] == len(answer["linear"]["values"])
    assert answer["expanded_k2"]["m"] == 2.0 * max(answer["parameters"]["m"][key] for key in ("std", "std_robust"))
    verdict = call("accept", folder / "pooled", "--json").json()
    assert verdict["passed"]
    assert "pooled" in call("pool", folder / "run_1", folder / "run_2", "-o", folder / "pooled").refusal()


def test_a_result_that_fails_has_exit_code_1_and_says_which_limit(folder: Path) -> None:
    strict = folder / "strict.toml"
    strict.write_text(built_in_cases()["hexapod"].read_text() + "\n[accept]\nnoise_times = 0.1\n")
    answer = call("accept", folder / "run_1", "--case", strict)
    assert (answer.code, answer.err) == (1, "")
    assert answer.out.startswith("FAIL: noise of channel")


def test_a_reference_of_a_payload_needs_an_uncertainty(folder: Path) -> None:
    result = hx.Result.load(folder / "run_2")
    body = {"m": 5.0, "mzC": 1.0, "I11": 0.5, "I22": 0.5}
    more = [value + body.get(name, 0.0) for name, value in zip(result.record.names, result.values, strict=True)]
    model, both = result.model, (result.covariance, result.covariance_robust)
    entries = entries_of_parameters(physical_values(model, np.array(more), *both), np.array(more), *both)
    replace(result, record=result.record.replaced(**entries)).save(folder / "loaded")
    runs = folder / "run_1", folder / "loaded"
    assert "m=2kg" in call("payload", *runs, "--reference", "m=2kg").refusal()
    agrees = call("payload", *runs, "--reference", "m=5+-0.02kg", "--json").json()
    assert agrees["reference"]["passed"]
    (text,) = call("payload", *runs, "--to", "urdf", "--preview", "--json").json()["texts"].values()
    call("payload", *runs, "--to", "urdf", "-o", folder / "tool.xml")
    assert text == (folder / "tool.xml").read_text()
    assert "--to" in call("payload", *runs, "--preview").refusal()
    tool = folder / "tool.json"
    differs = call("payload", *runs, "--reference", "m=5.5+-0.02kg", "--frame", "sensor", "-o", tool)
    page = tool.with_suffix(".html").read_text()
    assert "FAIL: E_n beside the reference" in page
    assert ">5.00" in page
    assert "frame: sensor" in page
    assert (differs.code, differs.err) == (1, "")
    assert "FAIL" in differs.out
