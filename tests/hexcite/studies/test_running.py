"""A study goes on where it was, and what it says of its cells is what the rows hold."""

import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import nullcontext
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import pytest

from cases.base.errors import Code, HexciteError
from cases.schema import Case
from hexcite.studies import cluster, conduct
from hexcite.studies.cell_rows import DONE, FAILED, PLANNED, file_of, read_rows, schema, work
from hexcite.studies.conduct import best_groups, groups
from hexcite.studies.spec import ExecutionSpec, Grid, Spec, cells_of, request_of
from planner.families.settings import Fourier
from planner.request import Request
from tests.helpers import tells
from tests.hexcite.command_line import PROGRAM, call, refused


def order_of(request: Request) -> int:
    assert isinstance(request.family, Fourier)
    return request.family.order


def study(seeds: int, orders: list[int], noise: int = 0) -> Spec:
    execute = ExecutionSpec(noise_seeds=noise) if noise else None
    return Spec(schema_version=1, name="x", grid=Grid(order=orders, seed=list(range(seeds))), execute=execute)


class Pretended:
    """Stands in for the cluster: notes what it was asked to do, answers at once, and stops when it is told to."""

    def __init__(self, stop_after: int = 10**9) -> None:
        self.jobs: list[Request] = []
        self.stop_after = stop_after

    def __call__(self, client: object, tasks: Iterator[tuple[str, partial]], limit: float) -> Iterator:
        for key, job in tasks:
            if len(self.jobs) == self.stop_after:
                raise KeyboardInterrupt
            _, request, execute = job.args
            self.jobs.append(request)
            plan = {"noise_seed": PLANNED, "status": DONE, "score": float(request.family.order), "converged": True}
            plan |= {"seconds": 2.0, "iterations": 10, "d_efficiency": 0.5}
            noise = [
                {"noise_seed": s, "status": DONE, "parameters": 20, "inside_95": 19, "seconds": 0.1}
                for s in range(execute.noise_seeds if execute else 0)
            ]
            yield (
                key,
                HexciteError(problem="no root", code=Code.WRONG_KIND) if request.family.order == 7 else [plan, *noise],
            )


def run(spec: Spec, case: Case, folder: Path, monkeypatch: pytest.MonkeyPatch, stop_after: int = 10**9) -> Pretended:
    cluster = Pretended(stop_after)
    monkeypatch.setattr(conduct, "run_tasks", cluster)
    monkeypatch.setattr(conduct, "local_client", lambda workers, memory: nullcontext(cluster))
    conduct.study(case, spec, folder)
    return cluster


def rows_of(folder: Path) -> pa.Table:
    return read_rows(sorted((folder / "rows").glob("*.parquet")))


def test_a_stopped_study_goes_on_where_it_was(
    tmp_path: Path, hexapod_case: Case, monkeypatch: pytest.MonkeyPatch
) -> None:
    spec = study(5, [2, 3])
    with pytest.raises(KeyboardInterrupt):
        run(spec, hexapod_case, tmp_path, monkeypatch, stop_after=4)
    rest = run(spec, hexapod_case, tmp_path, monkeypatch)
    assert len(rest.jobs) == 6
    assert run(spec, hexapod_case, tmp_path, monkeypatch).jobs == []
    assert len(rows_of(tmp_path)) == 10


def test_an_extended_study_computes_only_what_is_new(
    tmp_path: Path, hexapod_case: Case, monkeypatch: pytest.MonkeyPatch
) -> None:
    run(study(2, [2]), hexapod_case, tmp_path, monkeypatch)
    more = run(study(3, [2, 3]), hexapod_case, tmp_path, monkeypatch)
    assert sorted((order_of(request), request.seed) for request in more.jobs) == [(2, 2), (3, 0), (3, 1), (3, 2)]


def test_a_study_shows_its_own_cells_alone(tmp_path: Path, hexapod_case: Case, monkeypatch: pytest.MonkeyPatch) -> None:
    run(study(2, [2, 3]), hexapod_case, tmp_path, monkeypatch)
    fewer = conduct.study(hexapod_case, study(2, [3]), tmp_path)
    assert set(fewer.rows["order"].to_pylist()) == {3}
    assert (fewer.cells, fewer.computed, fewer.to_json()["done"]) == (2, 0, 2)


def test_a_failed_cell_is_a_row_with_its_reason_and_is_not_tried_again(
    tmp_path: Path, hexapod_case: Case, monkeypatch: pytest.MonkeyPatch
) -> None:
    run(study(1, [2, 7], noise=3), hexapod_case, tmp_path, monkeypatch)
    assert run(study(1, [2, 7], noise=3), hexapod_case, tmp_path, monkeypatch).jobs == []
    good, bad = (rows_of(tmp_path).filter(pc.field("order") == order).to_pylist() for order in (2, 7))
    assert [(row["noise_seed"], row["status"]) for row in good] == [(k, DONE) for k in (PLANNED, 0, 1, 2)]
    assert [(row["status"], row["reason"]) for row in bad] == [(FAILED, "no root")]
    assert good[0]["case_hash"] == hexapod_case.hash
    found = conduct.study(hexapod_case, study(1, [2, 7], noise=3), tmp_path).to_json()
    assert (found["done"], found["failed"]) == (1, 1)


def test_a_lost_cell_is_computed_again(tmp_path: Path, hexapod_case: Case, monkeypatch: pytest.MonkeyPatch) -> None:
    run(study(3, [2]), hexapod_case, tmp_path, monkeypatch)
    first, *_ = cells_of(study(3, [2]), hexapod_case)
    file_of(tmp_path, first).unlink()
    assert len(run(study(3, [2]), hexapod_case, tmp_path, monkeypatch).jobs) == 1


def table(rows: list[dict[str, Any]]) -> pa.Table:
    return pa.Table.from_pylist([{"family": "fourier", "criterion": "D", "cell": "x"} | r for r in rows], schema())


def test_the_summary_counts_what_the_rows_hold() -> None:
    plans = [
        {"order": 2, "seed": s, "noise_seed": PLANNED, "status": DONE, "score": -s, "converged": s > 0, "seconds": 1.0,
         "iterations": 5, "d_efficiency": 0.5, "cell": str(s)}
        for s in range(4)
    ]  # fmt: skip
    noise = [
        {"order": 2, "seed": 0, "noise_seed": n, "status": DONE, "parameters": 20, "inside_95": 20 - n, "cell": "0"}
        for n in range(3)
    ]  # fmt: skip
    broken = [{"order": 3, "seed": 0, "noise_seed": PLANNED, "status": FAILED, "reason": "none"}]
    good, bad = groups(table(plans + noise + broken))
    assert good.settings == {"family": "fourier", "criterion": "D", "order": 2}
    assert (good.cells, good.done, good.converged, good.best, good.median) == (4, 4, 0.75, 0.0, -1.5)
    assert (good.inside, good.seconds) == (57 / 60, 1.0)
    assert (bad.cells, bad.done) == (1, 0)
    assert np.isnan(bad.best)
    assert best_groups([good, bad]) == {"D": good}


SMALL = """
schema_version = 1
name = "small"
[grid]
order = 2
duration_s = 3.0
seed = [0, 1]
"""


@pytest.mark.slow
def test_a_study_from_the_command_line(tmp_path: Path) -> None:
    """On a real cluster of this computer, stopped and extended."""
    spec, folder = tmp_path / "small.toml", tmp_path / "study"
    spec.write_text(SMALL)
    first = call("study", "hexapod", "--spec", spec, "--workers", 1, "-o", folder, "--json").json()
    assert (first["cells"], first["done"], first["computed"], first["failed"]) == (2, 2, 2, 0)
    again = call("study", "hexapod", "--spec", spec, "--workers", 1, "-o", folder, "--json").json()
    assert (again["done"], again["computed"]) == (2, 0)
    assert again["best"] == first["best"]
    page = (folder / "report.html").read_text()
    assert "hexcite plan hexapod --family fourier --criterion D" in page
    rows = rows_of(folder).to_pylist()
    assert {r["seed"] for r in rows} == {0, 1}
    assert all(r["score"] > -60.0 and r["seconds"] > 0.0 for r in rows)


@pytest.mark.slow
def test_a_study_that_is_killed_loses_no_cell_and_leaves_no_workers(tmp_path: Path) -> None:
    """Kill -9 in the middle, then the same command again."""
    spec, folder = tmp_path / "small.toml", tmp_path / "study"
    spec.write_text(SMALL.replace("[0, 1]", str(list(range(12)))))
    command = [PROGRAM, "study", "hexapod", "--spec", spec, "--workers", "2", "-o", folder]
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, env=os.environ | {"MARK": str(tmp_path)}) as process:
        while len(list(folder.glob("rows/*.parquet"))) < 3:
            assert process.poll() is None
            time.sleep(0.05)
        process.kill()
    kept = len(rows_of(folder))
    assert 3 <= kept < 12
    again = call("study", "hexapod", "--spec", spec, "--workers", 1, "-o", folder, "--json").json()
    assert (again["computed"], again["done"]) == (12 - kept, 12)
    for _ in range(300):
        left = [p for p in Path("/proc").glob("[0-9]*/environ") if _holds(p, f"MARK={tmp_path}")]
        if not left:
            return
        time.sleep(0.1)
    pytest.fail(f"{len(left)} processes are still running")


def _holds(environment: Path, entry: str) -> bool:
    try:
        return entry.encode() in environment.read_bytes()
    except OSError:
        return False


@pytest.mark.slow
def test_a_cell_gives_the_same_plan_on_any_worker(tmp_path: Path, hexapod_case: Case) -> None:
    request = request_of({"family": "fourier", "order": 2, "duration_s": 3.0, "seed": 1})
    (one,), (other,) = work(hexapod_case, request), work(hexapod_case, request)
    assert one["status"] == DONE
    assert one["score"] == other["score"]


@pytest.mark.repeats
def test_bad_input_is_refused_in_one_line(tmp_path: Path, hexapod_case: Case, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cluster, "CONNECT", 0.2)
    spec, folder = tmp_path / "small.toml", tmp_path / "study"
    spec.write_text(SMALL)
    assert "within 0.2 s" in refused(
        "study", "hexapod", "--spec", spec, "--scheduler", "tcp://127.0.0.1:1", "--insecure", "-o", folder
    )
    assert "is not an address" in refused("study", "hexapod", "--spec", spec, "--scheduler", "localhost", "-o", folder)
    assert "machine: is missing" in refused("study", "ft_wrist", "--spec", spec, "-o", folder)
    assert "cannot be read" in refused("study", "hexapod", "--spec", tmp_path / "none.toml", "-o", folder)
    assert not folder.exists()
    folder.mkdir()
    (folder / "study.json").write_text('{"name": "small", "case": "mill"}')
    assert "study small of case mill" in refused("study", "hexapod", "--spec", spec, "--workers", 1, "-o", folder)


@pytest.mark.slow
def test_a_cell_with_payload_is_executed_and_identified_against_its_own_truth(hexapod_case: Case) -> None:
    """The estimate holds the mass of machine and weights: an error against the bare machine's would be 20 kg."""
    request = request_of({"family": "fourier", "order": 3, "duration_s": 3.0, "seed": 0, "payload": 1})
    plan, run = work(hexapod_case, request, ExecutionSpec())
    assert (plan["status"], run["status"], run["noise_seed"]) == (DONE, DONE, 0)
    assert abs(run["mass_error_kg"]) < 4.0 * run["mass_std_kg"] < 0.5
    assert run["inside_95"] <= run["parameters"] == 20


@pytest.mark.slow
def test_ctrl_c_keeps_what_is_done_and_leaves_no_workers(tmp_path: Path) -> None:
    spec, folder = tmp_path / "small.toml", tmp_path / "study"
    spec.write_text(SMALL.replace("[0, 1]", str(list(range(1000)))))
    command = [PROGRAM, "study", "hexapod", "--spec", spec, "--workers", "1", "-o", folder]
    environment = os.environ | {"MARK": str(tmp_path)}
    with subprocess.Popen(
        command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, env=environment, start_new_session=True
    ) as process:
        while not list(folder.glob("rows/*.parquet")):
            assert process.poll() is None
            time.sleep(0.05)
        os.killpg(process.pid, signal.SIGINT)
        _, said = process.communicate(timeout=300)
    assert process.returncode == 130
    assert tells(said, "hexcite: interrupted", f"{folder}, ", "same command")
    assert len([line for line in said.splitlines() if not line.startswith("study small of hexapod: ")]) == 1  # progress
    assert len(rows_of(folder)) >= 1
    assert not [p for p in Path("/proc").glob("[0-9]*/environ") if _holds(p, f"MARK={tmp_path}")]


def test_solvers_are_compared_by_the_best_that_any_of_them_found_with_the_same_settings(
    hexapod_case: Case, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    efficiencies = {"ipopt": (0.4, 0.3), "sqp": (0.2, 0.1), "active-set": (0.5, 0.5)}

    def answers(client: object, tasks: Iterator[tuple[str, partial]], limit: float) -> Iterator:
        for key, job in tasks:
            request = job.args[1]
            plan = {"noise_seed": PLANNED, "status": DONE, "score": 1.0, "converged": request.solver != "ipopt"}
            efficiency = efficiencies[request.solver][request.seed]
            yield key, [plan | {"seconds": 2.0, "iterations": 10, "d_efficiency": efficiency}]

    monkeypatch.setattr(conduct, "run_tasks", answers)
    monkeypatch.setattr(conduct, "local_client", lambda workers, memory: nullcontext("a client"))
    spec = Spec(schema_version=1, name="x", grid=Grid(order=[3, 5], solver=list(efficiencies), seed=[0, 1]))
    result = conduct.study(hexapod_case, spec, tmp_path / "study")
    found = {summary.solver: summary for summary in conduct.solver_summaries(groups(result.rows))}
    assert [found[name].reached for name in efficiencies] == pytest.approx([0.7, 0.3, 1.0])
    assert [found[name].converged for name in efficiencies] == [0.0, 1.0, 1.0]
    assert all((s.plans, s.failed, s.start) == (4, 0, "random") for s in found.values())
    assert {round(g.spread, 3) for g in groups(result.rows)} == {0.25, 0.5, 0.0}
    text = result.write_page().read_text()
    assert "Solvers and start values" in text
    assert "70.0 %" in text
    assert tells(repr(result), "ipopt", "70.0 %")


def test_the_page_counts_cells_and_not_their_runs(
    hexapod_case: Case, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One cell is planned and run three times, the other one is refused."""

    def answers(client: object, tasks: Iterator[tuple[str, partial]], limit: float) -> Iterator:
        for key, job in tasks:
            if job.args[1].seed:
                yield key, HexciteError(problem="no motion", code=Code.INFEASIBLE)
                continue
            plan = {"noise_seed": PLANNED, "status": DONE, "score": 1.0, "d_efficiency": 0.3, "seconds": 1.0}
            yield key, [plan, *({"noise_seed": k, "status": DONE, "seconds": 1.0} for k in range(3))]

    monkeypatch.setattr(conduct, "run_tasks", answers)
    monkeypatch.setattr(conduct, "local_client", lambda workers, memory: nullcontext("a client"))
    spec = Spec(schema_version=1, name="x", grid=Grid(seed=[0, 1]), execute=ExecutionSpec(noise_seeds=3))
    result = conduct.study(hexapod_case, spec, tmp_path / "study")
    assert (result.done, result.failed) == (1, 1)
    assert "1 of 2 cells are done, 1 failed" in result.write_page().read_text()


@pytest.mark.repeats
def test_in_one_process_cells_are_computed_without_dask_and_without_a_port(
    hexapod_case: Case, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A cell that breaks twice is a row with its reason; one that breaks once is computed."""
    for module in ("dask", "distributed", "cryptography"):
        monkeypatch.setitem(sys.modules, module, None)
    monkeypatch.setattr(socket.socket, "listen", lambda *_: pytest.fail("something listens"))
    tried: list[int] = []

    def breaks(case: Case, request: Request, execute: ExecutionSpec | None) -> list[dict[str, Any]]:
        order = order_of(request)
        tried.append(order)
        if order == 4 or (order == 3 and tried.count(3) == 1):
            raise ZeroDivisionError("nothing\nleft")
        return work(case, request, execute) if order == 2 else [{"noise_seed": PLANNED, "status": DONE}]

    monkeypatch.setattr(conduct, "work", breaks)
    found = conduct.study(hexapod_case, study(1, [2, 3, 4]), tmp_path / "s", one_process=True)
    assert (found.computed, found.done, found.failed) == (3, 2, 1)
    assert sorted(tried) == [2, 3, 3, 4, 4]
    assert found.rows.filter(pc.field("status") == FAILED)["reason"].to_pylist() == ["ZeroDivisionError: nothing left"]
    assert 0.0 < found.best["D"].efficiencies[0] < 1.0
    with pytest.raises(HexciteError, match=r"one.process starts no other"):
        conduct.study(hexapod_case, study(1, [2]), tmp_path / "s", one_process=True, workers=2)
