"""A Dask cluster for a study: one of this computer's, or a running one, whose workers are asked for their versions.

Whoever can talk to a scheduler runs code as the user who started it. Clusters of this computer therefore take nobody
without the certificate that is made for each of them, which no file keeps; running ones are reached with TLS.
"""

import asyncio
import faulthandler
import logging
import os
import signal
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from importlib.metadata import PackageNotFoundError, version
from itertools import islice
from pathlib import Path
from threading import current_thread, main_thread
from typing import TYPE_CHECKING, Any

from cases.base.errors import Code, HexciteError, option
from planner.search.parallel import ctrl_c_waits

if TYPE_CHECKING:
    from distributed import Client, Future
    from distributed.security import Security

CONNECT = 5.0  # [s] to reach a scheduler
PATIENCE = "120s"  # with processes of this computer: they are not lost because it is busy
RESTARTING = "1h"  # time after which a worker that does not restart counts as lost; Dask's 15 s are too short

_ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), 1)


def require_dask() -> None:
    """Raises HexciteError, with the remedy, where Dask, or what makes certificates for it, is not installed."""
    for package, words in {"distributed": "Dask", "cryptography": "cryptography, for TLS,"}.items():
        try:
            version(package)
        except PackageNotFoundError:
            raise HexciteError(
                problem=f"studies need {words} which is not installed",
                remedy="pip install 'hexcite[study]'",
                code=Code.NOT_INSTALLED,
            ) from None


@contextmanager
def local_client(workers: int | None, memory_GB: float) -> Iterator["Client"]:
    """A cluster on this computer: single-threaded processes, one a core, which restart where they need more memory.

    Other users of the computer cannot talk to it: certificate and key are made for it. Dask keeps them in memory;
    while it loads them, they stand in a temporary folder that nobody else may open.
    """
    import dask
    from distributed import Client, LocalCluster
    from distributed.security import Security

    settings = {
        "distributed.scheduler.allowed-failures": 1,
        "distributed.scheduler.worker-saturation": 1.0,
        "distributed.nanny.pre-spawn-environ": _ONE_THREAD | {"MALLOC_TRIM_THRESHOLD_": 65536},
        "distributed.admin.log-length": 1000,
        "distributed.comm.timeouts.connect": PATIENCE,
        "distributed.comm.timeouts.tcp": PATIENCE,
        "distributed.deploy.lost-worker-timeout": RESTARTING,
        # The pages of both servers ask nobody for a certificate: tasks, call stacks and logs are not shown there.
        "distributed.scheduler.http.routes": [],
        "distributed.worker.http.routes": [],
    }
    with dask.config.set(settings):
        with ctrl_c_waits():
            cluster = LocalCluster(
                n_workers=workers or os.cpu_count() or 1,
                threads_per_worker=1,
                processes=True,
                host="127.0.0.1",
                dashboard_address="127.0.0.1:0",  # of the server that there is anyway: any free port
                scheduler_kwargs={"dashboard": False},
                security=Security.temporary(),
                memory_limit=int(memory_GB * 1e9),
                silence_logs=logging.CRITICAL,
            )
        with cluster, Client(cluster) as client:
            client.register_worker_callbacks(_without_interrupt)
            yield client


def _without_interrupt() -> None:
    """Ignores Ctrl-C, which a terminal sends to every process: the study handles it."""
    if current_thread() is main_thread():
        signal.signal(signal.SIGINT, signal.SIG_IGN)


@contextmanager
def remote_client(address: str, certificates: Path | None = None, insecure: bool = False) -> Iterator["Client"]:
    """A running cluster, after its workers have been found to have this version of hexcite.

    Args:
        address: tls://host:port.
        certificates: folder with ca.pem, cert.pem and key.pem, the same for scheduler, workers and clients; by default
            those of Dask's own configuration.
        insecure: whether tcp://host:port will do, where nobody else reaches the scheduler.

    Raises:
        HexciteError: the address is not one, or is not encrypted; nothing is reached there with these certificates; or
            a worker has no such hexcite.
    """
    from distributed import Client

    if "://" not in address:
        raise HexciteError(
            problem=f"scheduler {address!r} is not an address", remedy="write tls://host:port", code=Code.WRONG_KIND
        )
    if not address.startswith("tls://") and not insecure:
        raise HexciteError(
            problem=f"scheduler {address} is not encrypted: whoever reaches it runs code as its user",
            remedy="start it with "
            f"certificates and write tls://host:port, or go on with {option('insecure')} where "
            "nobody else reaches it",
            code=Code.CONTRADICTION,
        )
    security = None if not address.startswith("tls://") else _security(address, certificates)
    logging.getLogger("distributed").setLevel(logging.CRITICAL)
    try:
        try_to_reach(address, security)
        client = Client(address, timeout=CONNECT, set_as_default=False, security=security)
    except (OSError, TypeError, ValueError, TimeoutError, RuntimeError) as error:
        words = "" if security is None else ", and with these certificates"
        raise HexciteError(
            problem=f"scheduler {address} cannot be reached within {CONNECT:g} s",
            remedy=f"is `dask scheduler` running there{words}?",
            code=Code.RUN_FAILED,
        ) from error
    with client:
        require_version(client, address)
        yield client


def try_to_reach(address: str, security: "Security | None", seconds: float = CONNECT) -> None:
    """Connects to a scheduler once, and hangs up; raises OSError, TypeError or ValueError where it does not answer.

    A client that does not reach its scheduler waits for ever for its thread when it is collected while another starts.
    """
    from distributed.comm import connect

    async def reached() -> None:
        arguments = {} if security is None else security.get_connection_args("client")
        (await connect(address, timeout=seconds, **arguments)).abort()

    with ThreadPoolExecutor(1) as pool:  # in a notebook a loop runs already in this thread
        pool.submit(asyncio.run, reached()).result()


OF_TLS = {"tls_ca_file": "ca.pem", "tls_client_cert": "cert.pem", "tls_client_key": "key.pem"}


def _security(address: str, certificates: Path | None) -> "Security":
    """What a client shows a scheduler, and by what it knows it; raises HexciteError where a file is missing."""
    from distributed.security import Security

    if certificates is None:
        security = Security(require_encryption=True)  # of Dask's own configuration
        if not all(getattr(security, name) for name in OF_TLS):
            raise HexciteError(
                problem=f"scheduler {address} wants certificates",
                remedy=f"name their folder, with {', '.join(OF_TLS.values())}, with {option('certificates')}",
                code=Code.MISSING,
            )
        return security
    files = {name: certificates / file for name, file in OF_TLS.items()}
    for file in files.values():
        if not file.is_file():
            raise HexciteError(
                place=file,
                problem="is missing",
                remedy=f"{option('certificates')} is a folder with {', '.join(OF_TLS.values())}",
                code=Code.MISSING,
            )
    return Security(require_encryption=True, **{name: str(file) for name, file in files.items()})


def require_version(client: "Client", address: str) -> None:
    """Raises HexciteError unless there are workers, and every one has this version of hexcite."""
    ours = version("hexcite")
    theirs = client.run(version, "hexcite", on_error="return")
    if not theirs:
        raise HexciteError(
            problem=f"scheduler {address} has no workers", remedy=f"start `dask worker {address}`", code=Code.RUN_FAILED
        )
    for worker, release in theirs.items():
        if release != ours:
            has = "no hexcite" if isinstance(release, PackageNotFoundError) else f"hexcite {release}"
            raise HexciteError(
                problem=f"worker {worker} has {has}, this is {ours}",
                remedy="install the same wheel on both",
                code=Code.VERSION,
            )


DESERTED = 300.0  # [s] without any worker after which none is expected; on a busy computer one takes a minute
LOOK = 10.0  # [s] between two checks for workers while no task ends
AHEAD = 2  # tasks in the queue for each thread, so that workers do not wait


def run_tasks(
    client: "Client", tasks: Iterator[tuple[str, Callable[[], Any]]], time_limit: float
) -> Iterator[tuple[str, Any]]:
    """Runs tasks; yields key and answer of each as they arrive, in any order.

    The answer of a task that failed twice is a HexciteError that says why, in one line. Only a few tasks a thread wait
    on the cluster at any time, so that a study of any size needs no more memory there.

    Args:
        client: client of a cluster whose workers have one thread each and can import what the tasks call.
        tasks: keys, each once, and functions.
        time_limit: time limit for one try [s]; a worker that passes it ends, and its nanny starts another.

    Raises:
        HexciteError: all workers are lost.
    """
    from distributed import wait

    pending: dict[Future, str] = {}
    last_contact = time.monotonic()
    try:
        while True:
            threads = sum(client.nthreads().values())
            last_contact = time.monotonic() if threads else last_contact
            if time.monotonic() - last_contact > DESERTED:
                raise HexciteError(
                    problem=f"the cluster has had no workers for {DESERTED:g} s",
                    remedy="what is done so far is kept",
                    code=Code.RUN_FAILED,
                )
            for key, task in islice(tasks, max(0, AHEAD * max(1, threads) - len(pending))):
                pending[client.submit(_on_worker, task, time_limit, pure=False, retries=1)] = key
            if not pending:
                return
            try:
                with client.as_current():
                    ended = wait(list(pending), timeout=LOOK, return_when="FIRST_COMPLETED").done
            except TimeoutError:
                continue
            yield from ((pending.pop(future), _answer(future, time_limit)) for future in ended)
    finally:
        client.cancel(list(pending))


def run_one_by_one(tasks: Iterator[tuple[str, Callable[[], Any]]]) -> Iterator[tuple[str, Any]]:
    """Runs tasks in this process, one after the other; yields key and answer of each, see `run_tasks`.

    Nothing listens on a port, and nothing bounds a task's time and memory. One that fails is tried once more.
    """
    for key, task in tasks:
        for attempt in range(2):
            try:
                answer = task()
            except Exception as error:
                answer = HexciteError(problem=_reason(error), code=Code.RUN_FAILED)
                if attempt == 0:
                    continue
            yield key, answer
            break


def _on_worker(task: Callable[[], Any], time_limit: float) -> Any:
    """The answer of a task; a watchdog ends the process also where code blocks the interpreter."""
    with open(os.devnull, "w") as nowhere:
        faulthandler.dump_traceback_later(time_limit, exit=True, file=nowhere)
        try:
            return task()
        finally:
            faulthandler.cancel_dump_traceback_later()


def _answer(future: "Future", time_limit: float) -> Any:
    error = future.exception()
    if error is None:
        return future.result()
    reason = _reason(error)
    if type(error).__name__ == "KilledWorker":
        reason = f"its worker died twice: too little memory, or past its limit of {time_limit:g} s"
    return HexciteError(problem=reason, code=Code.RUN_FAILED)


def _reason(error: BaseException) -> str:
    return " ".join(f"{type(error).__name__}: {error}".split())
