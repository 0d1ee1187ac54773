"""Tasks on a real Dask cluster: nothing is lost when workers die, fail or hang, and each failure is charged once."""

import os
import signal
import time
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from distributed import Client

from cases.base.errors import HexciteError
from hexcite.studies.cluster import local_client, run_tasks

pytestmark = pytest.mark.filterwarnings("ignore::DeprecationWarning")


@pytest.fixture(scope="module")
def client() -> Iterator[Client]:
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(Path(__file__).parents[3]))  # so that workers find these functions
        with local_client(2, 1.0) as client:
            yield client


def outcomes(client: Client, function: Any, payloads: dict[str, Any], time_limit: float = 300.0) -> dict[str, Any]:
    tasks = ((key, partial(function, payload)) for key, payload in payloads.items())
    found = list(run_tasks(client, tasks, time_limit))
    assert len(dict(found)) == len(found)  # each once
    return dict(found)


def square(x: float) -> float:
    return x * x


def tallied(payload: tuple[str, str]) -> int:
    """Notes in a file that it was started; then does what it is told to."""
    file, what = Path(payload[0]), payload[1]
    with file.open("a") as tally:
        tally.write("x")
    tries = len(file.read_text())
    if what == "dies" or (what == "dies once" and tries == 1):
        os.kill(os.getpid(), signal.SIGKILL)
    if what == "fails" or (what == "fails once" and tries == 1):
        raise ArithmeticError("no\nroot")
    if what == "hangs" or (what == "hangs once" and tries == 1):
        time.sleep(1000.0)
    return tries


def test_every_task_comes_back_once(client: Client) -> None:
    found = outcomes(client, square, {str(k): float(k) for k in range(50)})
    assert found == {str(k): float(k * k) for k in range(50)}


def test_no_tasks_are_no_work(client: Client) -> None:
    assert outcomes(client, square, {}) == {}


@pytest.mark.parametrize(
    ("what", "reason"),
    [
        ("dies once", None),
        ("fails once", None),
        pytest.param("hangs once", None, marks=pytest.mark.slow),
        pytest.param(
            "dies", "its worker died twice: too little memory, or past its limit of 300 s", marks=pytest.mark.repeats
        ),
        ("fails", "ArithmeticError: no root"),
        pytest.param(
            "hangs", "its worker died twice: too little memory, or past its limit of 8 s", marks=pytest.mark.slow
        ),
    ],
)
def test_a_bad_task_costs_one_retry_and_disturbs_no_other(
    what: str, reason: str | None, client: Client, tmp_path: Path
) -> None:
    payloads: dict[str, Any] = {f"good {k}": (str(tmp_path / f"good {k}"), "works") for k in range(6)}
    payloads["bad"] = (str(tmp_path / "bad"), what)
    # On a busy computer it takes seconds until it is known that a task is done.
    found = outcomes(client, tallied, payloads, time_limit=8.0 if "hangs" in what else 300.0)
    bad = found.pop("bad")
    assert (tmp_path / "bad").read_text() == "xx"
    assert (bad.typed if isinstance(bad, HexciteError) else bad) == (2 if reason is None else reason)
    assert len(found) == 6
    assert all(isinstance(tries, int) for tries in found.values())  # one that shared the worker may run again


def sleeper(seconds: float) -> int:
    time.sleep(seconds)
    return os.getpid()


@pytest.mark.slow
def test_workers_that_are_killed_from_outside_lose_nothing(client: Client) -> None:
    tasks = iter([(str(k), partial(sleeper, 0.05)) for k in range(40)])
    found = []
    for key, process in run_tasks(client, tasks, 300.0):
        assert isinstance(process, int)
        found.append(int(key))
        if len(found) == 5:
            os.kill(process, signal.SIGKILL)
    assert sorted(found) == list(range(40))
