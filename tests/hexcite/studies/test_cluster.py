"""Other people's clusters: reached over their address, and asked for their versions before any work."""

import operator
import re
from functools import partial
from http.client import HTTPConnection
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import pytest
from distributed import LocalCluster
from distributed.security import Security

from cases.base.errors import HexciteError
from hexcite.studies import cluster
from hexcite.studies.cluster import OF_TLS, local_client, remote_client, require_version, run_tasks, try_to_reach
from tests.helpers import one_line


class Workers:
    """Stands in for a client: its workers answer what they are told to."""

    def __init__(self, **answers: object) -> None:
        self.answers = answers

    def run(self, function: object, *words: str, on_error: str) -> dict[str, Any]:
        assert (function, words, on_error) == (version, ("hexcite",), "return")
        return dict(self.answers)


@pytest.mark.repeats
def test_a_running_cluster_does_the_work(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(Path(__file__).parents[3]))
    with (
        LocalCluster(2, threads_per_worker=1, dashboard_address="127.0.0.1:0") as there,
        remote_client(there.scheduler_address, insecure=True) as client,
    ):
        found = list(run_tasks(client, ((str(k), partial(operator.neg, k)) for k in range(20)), 60.0))
    assert dict(found) == {str(k): -k for k in range(20)}


def test_a_study_ends_where_all_workers_are_lost(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cluster, "DESERTED", 1.0)
    monkeypatch.setattr(cluster, "LOOK", 0.2)
    with LocalCluster(1, threads_per_worker=1, processes=False, dashboard_address="127.0.0.1:0") as there:
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


@pytest.mark.slow
def test_nobody_without_the_certificate_is_let_into_a_cluster_of_ones_own() -> None:
    """Neither over a bare connection, nor without a certificate, nor with one of another cluster."""
    with local_client(1, 1.0) as client:
        address = client.scheduler.address
        assert address.startswith("tls://127.0.0.1:")
        addresses = [address, *client.scheduler_info()["workers"]]
        for place in addresses:
            assert place.startswith("tls://")
        assert dict(run_tasks(client, iter([("a", partial(operator.neg, 1))]), 60.0)) == {"a": -1}
        try_to_reach(address, client.security, 3.0)
        stranger = Security.temporary()
        for there, security in ((address.replace("tls", "tcp"), None), (address, None), (address, stranger)):
            with pytest.raises((OSError, TypeError, ValueError)):
                try_to_reach(there, security, 3.0)
        info = client.scheduler_info()
        ports = [*info["services"].values(), *(p for w in info["workers"].values() for p in w["services"].values())]
        paths = ("info/main/workers.html", "info/logs.html", "json/counts.json", "metrics", "health")
        answers = [answer_of(port, path) for port in ports if isinstance(port, int) for path in paths]
        assert answers
        assert set(answers) == {404}  # nor is anything shown to those who ask by a browser


def answer_of(port: int, path: str) -> int:
    """The status with which a server of this computer answers."""
    connection = HTTPConnection("127.0.0.1", port, timeout=5.0)
    try:
        connection.request("GET", f"/{path}")
        return connection.getresponse().status
    finally:
        connection.close()


def test_a_running_cluster_is_reached_with_its_certificates(tmp_path: Path) -> None:
    there = Security.temporary()
    for name, text in zip(
        OF_TLS.values(), (there.tls_ca_file, there.tls_client_cert, there.tls_client_key), strict=True
    ):
        (tmp_path / name).write_text(text)
    with LocalCluster(
        1, threads_per_worker=1, processes=False, dashboard_address="127.0.0.1:0", security=there, protocol="tls"
    ) as own:
        with remote_client(own.scheduler_address, tmp_path) as client:
            assert dict(run_tasks(client, iter([("a", partial(operator.neg, 1))]), 60.0)) == {"a": -1}
        other = Security.temporary()
        (tmp_path / "cert.pem").write_text(other.tls_client_cert)
        (tmp_path / "key.pem").write_text(other.tls_client_key)
        with pytest.raises(HexciteError, match="cannot be reached"), remote_client(own.scheduler_address, tmp_path):
            pass


@pytest.mark.parametrize(
    ("address", "certificates", "says"),
    [
        ("a:1", None, "write tls://host:port"),
        ("tcp://a:1", None, "is not encrypted.*--insecure"),
        ("tls://a:1", None, "wants certificates.*ca.pem, cert.pem, key.pem"),
        ("tls://a:1", Path("nowhere"), "nowhere/ca.pem: is missing"),
    ],
)
def test_what_a_connection_needs_is_said(address: str, certificates: Path | None, says: str) -> None:
    with pytest.raises(HexciteError) as caught, remote_client(address, certificates):
        pass
    assert re.search(says, caught.value.typed)
