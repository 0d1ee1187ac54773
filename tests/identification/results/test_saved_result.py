"""A result that is saved and loaded is the same, and nobody can change it."""

import json
import pickle
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from cases.base.errors import FileProblem
from cases.schema import load_case
from identification.estimation.fit import Value
from identification.finding import SEVERITIES, Finding, Kind
from identification.machines.hexapod import Hexapod
from identification.model.model import identification_model
from identification.recording.record import RunRecord
from identification.recording.recording import Recording
from identification.results.estimate import ResultEntries, entries_of_parameters, physical_values
from identification.results.result import Result
from identification.simulate import simulate_recording
from tests.helpers import Harmonic, examples, refused_at
from tests.postprocessors.export.calibrations import calibration
from tests.simulated_machine import PoseExecution

CASE = load_case("hexapod")
TEXT = st.text(st.characters(exclude_categories=["Cs"]), max_size=20)
NUMBER = st.floats(-1e3, 1e3)
POSITIVE = st.floats(1e-6, 1e3)
JSON = st.recursive(st.none() | st.booleans() | NUMBER | TEXT, lambda inner: st.lists(inner, max_size=3), max_leaves=4)
KEYS = TEXT.map(lambda text: f"own_{text}")  # other than those of result.json
FINDINGS = st.builds(
    Finding,
    st.sampled_from(Kind),
    st.sampled_from(SEVERITIES),
    TEXT,
    TEXT,
    st.dictionaries(KEYS, JSON | st.dictionaries(TEXT, JSON, max_size=2), max_size=2),
)


@st.composite
def results(draw: st.DrawFn) -> Result:
    model = identification_model(CASE, draw(st.integers(0, 9)))
    count = len(model.names)
    u = np.array([draw(st.floats(1.0, 1e3)), *draw(st.lists(NUMBER, min_size=count - 1, max_size=count - 1))])
    white, robust = (np.diag(draw(st.lists(POSITIVE, min_size=count, max_size=count))) for _ in range(2))
    rms, freedom = draw(POSITIVE), draw(st.floats(3.0, 1e6))
    optional: dict[str, Any] = draw(
        st.fixed_dictionaries(
            {},
            optional={
                "stale": st.lists(TEXT, max_size=2).map(tuple),
                "run": st.dictionaries(TEXT, JSON, max_size=2),
                "measuring_s": POSITIVE,
                "tared_with": TEXT,
            },
        )
    )
    entries = ResultEntries(
        case=CASE.name,
        case_hash=CASE.hash,
        recording=draw(TEXT),
        inputs=({"file": draw(TEXT), "sha256": "5e6f"},),
        versions={"hexcite": draw(TEXT)},
        model=model.number,
        **entries_of_parameters(physical_values(model, u, white, robust), u, white, robust),
        names=tuple(model.names),
        delay_s=draw(st.none() | POSITIVE.map(lambda std: Value(2.5e-3, std, std, "s"))),
        weights="equal",
        s0=draw(POSITIVE),
        white_noise=draw(POSITIVE),
        s0_N=rms,
        residual_rms=(rms,) * 6,
        samples=draw(st.integers(1, 10**6)),
        degrees_of_freedom=freedom,
        rank=draw(st.integers(1, count)),
        condition=draw(POSITIVE),
        findings=tuple(draw(st.lists(FINDINGS, max_size=4, unique_by=lambda f: str(sorted(f.quantity))))),
        **optional,
    )
    return Result(CASE, entries)


@given(results())
def test_loading_undoes_saving(result: Result) -> None:
    with TemporaryDirectory() as name:
        result.save(Path(name) / "result")
        loaded = Result.load(Path(name) / "result", CASE)
    assert loaded == result
    assert len({loaded, result}) == 1
    assert loaded.findings == result.findings
    assert loaded != Result(CASE, result.record.replaced(samples=result.record.samples + 1))


@given(results())
@settings(deadline=None, max_examples=examples(5))
def test_nobody_can_change_a_result(result: Result) -> None:
    with pytest.raises(ValidationError, match="frozen"):
        result.record.samples = 1
    with pytest.raises(TypeError):
        result.record.covariance[0][0] = 1.0  # type: ignore[index]


def test_a_damaged_entry_of_the_recording_is_named() -> None:
    execution = PoseExecution(Hexapod.of(CASE), Harmonic(duration=2.0))
    run = simulate_recording(CASE, execution, np.array([[0.15, 1.85]]), 0, "run.csv")
    with pytest.raises(FileProblem, match="entry plan_hash is missing or damaged") as caught:
        replace(run, record={"case": CASE.name, "plan_hash": 5})
    assert caught.value.place == "Recording: record"


@pytest.mark.parametrize(
    ("key", "value", "words"),
    [
        ("executed_s", 2.5, "was changed by hand"),
        ("executed_s", None, "entry executed_s is missing or damaged"),
        ("exceeded", 3.0, "entry exceeded is missing or damaged"),
        ("peaks_of_limit", {"jerk": "much"}, "entry peaks_of_limit.jerk is missing or damaged"),
    ],
)
def test_a_record_of_a_run_that_was_changed_is_refused(key: str, value: object, words: str, tmp_path: Path) -> None:
    """Also where it has no fingerprint, as in files of 0.2, and the entry is not what it must be."""
    of_run = {"executed_s": 2.0, "planned_s": 2.0, "path_error_mm": 0.1, "d_efficiency": None, "controller": "virtual"}
    of_run |= {"remark": "", "peaks_of_limit": {"jerk": 0.5}, "exceeded": []}
    run = simulate_recording(CASE, PoseExecution(Hexapod.of(CASE), Harmonic(duration=0.5)), np.array([[0.1, 0.4]]), 0)
    replace(run, case=CASE, record=RunRecord.of_case(CASE).to_json() | of_run).save(tmp_path / "run")
    assert "executed on virtual" in repr(Recording.load(tmp_path / "run"))
    file = tmp_path / "run" / "recording.json"
    data = json.loads(file.read_text(encoding="utf-8")) | {key: value}
    if "by hand" not in words:
        del data["content"]
    file.write_text(json.dumps(data), encoding="utf-8")
    with refused_at(file, words, FileProblem):
        Recording.load(tmp_path / "run")


@pytest.mark.parametrize(("key", "value"), [("s0", 0.5), ("samples", 7), ("recording", "other.csv")])
def test_an_entry_that_was_changed_by_hand_is_refused(key: str, value: object, tmp_path: Path) -> None:
    """Also one that nothing else in the file contradicts; files of 0.2 have no fingerprint and are read."""
    made = calibration(tmp_path / "made", "hexapod", 9)
    made.save(tmp_path / "saved")
    file = tmp_path / "saved" / "result.json"
    data = json.loads(file.read_text(encoding="utf-8"))
    assert Result.load(tmp_path / "saved").record == made.record
    file.write_text(json.dumps(data | {key: value}), encoding="utf-8")
    with pytest.raises(FileProblem, match="was changed by hand"):
        Result.load(tmp_path / "saved")
    del data["content"]
    file.write_text(json.dumps(data), encoding="utf-8")
    assert Result.load(tmp_path / "saved").record == made.record


def test_a_result_goes_to_another_process(tmp_path: Path) -> None:
    made = calibration(tmp_path, "hexapod", 9)
    again = pickle.loads(pickle.dumps(made))
    assert again == made
    assert again["m"] == made["m"]
    assert again.case == made.case
