"""A machine's results over time: what noise makes is no change, and what changes is named with its size."""

from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import hexcite as hx
from cases.base.errors import FileProblem, HexciteError
from cases.schema import load_case
from identification.model.model import identification_model
from identification.results.estimate import physical_values
from tests.helpers import one_line
from tests.hexcite.command_line import call
from tests.postprocessors.export.calibrations import plausible, write_result

CASE = load_case("hexapod")
MODEL = identification_model(CASE, 6)
START = datetime(2026, 3, 1, 8, 0, tzinfo=UTC)
TRUTH = plausible(CASE, MODEL)
STD = 1e-3 * np.abs(TRUTH) + 1e-3
"""Deviations of (28) that `write_result` states; the robust ones are twice as large."""


def add(folder: Path, number: int, u: np.ndarray, **entries: Any) -> Path:
    """A result of another day."""
    recorded = {"recorded_at": (START + timedelta(days=number)).isoformat(), "recording": f"run_{number}.csv"}
    inputs = [{"file": f"run_{number}.csv", "sha256": f"{number:064x}"}]
    return write_result(folder / f"day_{number}", CASE, 6, u, **{**recorded, "inputs": inputs, **entries})


def noisy(seed: int, number: int) -> np.ndarray:
    draw = np.random.default_rng([seed, number])
    return TRUTH + 2.0 * STD * draw.normal(size=len(TRUTH))


def test_noise_alone_is_no_change(tmp_path: Path) -> None:
    """One of a hundred histories has a leap or a drift by noise: two of six are next to impossible."""
    changed = 0
    for seed in range(6):
        for number in range(5):
            add(tmp_path / str(seed), number, noisy(seed, number))
        changed += bool(hx.history(tmp_path / str(seed)).findings)
    assert changed <= 1


def test_a_leap_is_named_with_its_dates_and_size(tmp_path: Path) -> None:
    """A tool of half a kilogram more from the fourth day on."""
    for number in range(6):
        u = noisy(1, number)
        u[0] += 0.5 * (number >= 3)
        add(tmp_path, number, u)
    found = hx.history([tmp_path])
    leaps = {leap.parameter: leap for leap in found.leaps}
    assert "m" in leaps
    assert leaps["m"].change == pytest.approx(0.5, abs=5 * leaps["m"].std)
    assert [leaps["m"].before.when.day, leaps["m"].after.when.day] == [3, 4]
    assert not any(drift.parameter == "m" for drift in found.drifts)
    assert found.leaps[0].parameter in str(found)


def test_a_step_that_no_two_results_show_is_no_drift(tmp_path: Path) -> None:
    """Means before and after differ by more than two neighbours can tell."""
    at = MODEL.names.index("f_q0_2")
    for number in range(10):
        u = noisy(6, number)
        u[at] += 3.0 * 2.0 * STD[at] * (number >= 5)
        add(tmp_path, number, u)
    found = hx.history(tmp_path)
    assert not found.drifts
    (leap,) = found.leaps
    assert leap.parameter == "f_q0_2"
    assert [leap.before.when.day, leap.after.when.day] == [5, 6]
    assert leap.change == pytest.approx(6.0 * STD[at], abs=4 * leap.std)


def test_a_drift_is_told_by_the_day(tmp_path: Path) -> None:
    """An offset that grows by less from day to day than one deviation."""
    at, rate = MODEL.names.index("f_q0_2"), 0.8 * 2.0 * STD[MODEL.names.index("f_q0_2")]
    for number in range(12):
        u = noisy(2, number)
        u[at] += rate * number
        add(tmp_path, number, u)
    found = hx.history(tmp_path)
    assert [drift.parameter for drift in found.drifts] == ["f_q0_2"]
    drift = found.drifts[0]
    assert drift.rate * 86400.0 == pytest.approx(rate, abs=4 * drift.std * 86400.0)
    assert not found.leaps


def test_sizes_that_all_runs_have_in_common_make_no_change_smaller(tmp_path: Path) -> None:
    """A gain within its tolerance is the same today and tomorrow: it hides no leap."""
    bias = np.zeros((len(TRUTH), 1))
    bias[0] = 1.0  # a kilogram
    for number in range(4):
        u = noisy(3, number)
        u[0] += 0.5 * (number == 3)
        robust = 4.0 * np.diag(STD**2) + bias @ bias.T
        physical = {n: v._asdict() for n, v in physical_values(MODEL, u, np.diag(STD**2), robust).items()}
        own: dict[str, Any] = {"covariance": np.diag(STD**2).tolist(), "covariance_robust": robust.tolist()}
        own |= {"tolerance_biases": {"gain_percent": bias.tolist()}}
        add(tmp_path, number, u, parameters=physical, **own)
    assert [leap.parameter for leap in hx.history(tmp_path).leaps] == ["m"]


def test_a_payload_is_no_leap(tmp_path: Path) -> None:
    for number in range(4):
        u = noisy(4, number)
        u[0] += 20.0 * (number % 2)
        run = {"payload": {"mass_kg": 20.0 * (number % 2)}}
        add(tmp_path, number, u, run=run)
    assert not hx.history(tmp_path).leaps


def test_a_run_that_was_identified_twice_counts_once(tmp_path: Path) -> None:
    add(tmp_path, 0, TRUTH)
    add(tmp_path / "again", 0, TRUTH + 10.0 * STD)
    add(tmp_path, 1, TRUTH)
    found = hx.history(tmp_path)
    assert len(found.entries) == 2
    assert "same recording" in found.left_out[0]


def test_runs_count_and_not_what_was_pooled_of_them_where_all_are_there(tmp_path: Path) -> None:
    both = [{"file": f"run_{k}.csv", "sha256": f"{k:064x}"} for k in (0, 1)]
    pooled = {"runs": ["day_0", "day_1"], "chi2": 1.0, "freedom": 1, "p": 0.5, "without": None}
    add(tmp_path, 0, TRUTH)
    add(tmp_path / "pools", 0, TRUTH, inputs=both, pooled=pooled)
    assert [len(entry.result.recordings) for entry in hx.history(tmp_path).entries] == [2]  # one of its runs is gone
    add(tmp_path, 1, TRUTH)
    found = hx.history(tmp_path)
    assert [len(entry.result.recordings) for entry in found.entries] == [1, 1]
    assert "pools" in found.left_out[0]


def test_results_of_several_machines_need_a_name(tmp_path: Path) -> None:
    add(tmp_path, 0, TRUTH)
    write_result(tmp_path / "robot", load_case("ur10_wrist"), 6)
    with pytest.raises(HexciteError) as caught:
        hx.history(tmp_path)
    line = one_line(caught.value)
    assert "hexapod" in line
    assert "ur10_wrist" in line
    assert len(hx.history(tmp_path, "hexapod").entries) == 1
    with pytest.raises(HexciteError, match="'mill'"):
        hx.history(tmp_path, "mill")


def test_what_cannot_be_read_is_left_out_and_said(tmp_path: Path) -> None:
    add(tmp_path, 0, TRUTH)
    (tmp_path / "broken").mkdir()
    (tmp_path / "broken" / "result.json").write_text("{}", encoding="utf-8")
    found = hx.history(tmp_path)
    assert len(found.entries) == 1
    assert "broken" in found.left_out[0]
    for place in (tmp_path / "nowhere", tmp_path / "broken"):
        with pytest.raises(FileProblem) as caught:
            hx.history(place)
        assert place.name in one_line(caught.value)


def test_the_command_prints_the_table_and_writes_the_page(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for number in range(3):
        add(tmp_path / "results", number, noisy(5, number))
    answer = call("history", tmp_path / "results")
    assert answer.out.count("run_") == 3
    assert "hexapod-history.html" in answer.out
    page = (tmp_path / "hexapod-history.html").read_text(encoding="utf-8")
    assert "run_2.csv" in page
    data = call("history", tmp_path / "results", "--json").json()
    assert [entry["recording"] for entry in data["results"]] == ["run_0.csv", "run_1.csv", "run_2.csv"]
    hx.plot(hx.history(tmp_path / "results")).savefig(tmp_path / "history.pdf")
