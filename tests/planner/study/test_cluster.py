"""Other people's clusters: reached over their address, and asked for their versions before any work."""

import operator
from functools import partial
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import pytest
from distributed import LocalCluster

from cases.errors import HexciteError
from planner.study import cluster
from planner.study.cluster import remote_client, require_version, run_tasks
from tests.helpers import one_line


class Workers:
    """Stands in for a client: its workers answer what they are told to."""

    def __init__(self, **answers: object) -> None:
        self.answers = answers

    def run(self, function: object, *words: str, on_error: str) -> dict[str, Any]:
        assert (function, words, on_error) == (version, ("hexcite",), "return")
        return dict(self.answers)


def test_a_running_cluster_does_the_work(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(Path(__file__).parents[3]))
    with (
        LocalCluster(2, threads_per_worker=1, dashboard_address=None) as there,
        remote_client(there.scheduler_address) as client,
    ):
        found = list(run_tasks(client, ((str(k), partial(operator.neg, k)) for k in range(20)), 60.0))
    assert dict(found) == {str(k): -k for k in range(20)}


def test_a_study_ends_where_all_workers_are_lost(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cluster, "DESERTED", 1.0)
    monkeypatch.setattr(cluster, "LOOK", 0.2)
    with LocalCluster(1, threads_per_worker=1, processes=False, dashboard_address=None) as there:
        client = there.get_client()
        there.scale(0)
        with pytest.raises(HexciteError, match="no workers for 1 s"):
            list(run_tasks(client, ((str(k), partial(operator.neg, k)) for k in range(20)), 60.0))


@pytest.mark.parametrize(
    ("answers", "says"),
    [
        ({}, "has no workers; start `dask worker tcp://a:1`"),
        ({"w1": version("hexcite"), "w2": PackageNotFoundError("hexcite")}, "worker w2 has no hexcite, this is"),
        ({"w1": "0.0.9"}, "worker w1 has hexcite 0.0.9, this is"),
    ],
)
def test_a_worker_without_this_version_is_named(answers: dict[str, object], says: str) -> None:
    with pytest.raises(HexciteError) as caught:
        require_version(Workers(**answers), "tcp://a:1")
    assert says in one_line(caught.value)


def test_workers_of_the_require_version_will_do() -> None:
    require_version(Workers(w1=version("hexcite"), w2=version("hexcite")), "tcp://a:1")
