"""Runs many independent tasks on a Dask cluster, which starts a task once more where it fails or its worker dies."""

import faulthandler
import os
import time
from collections.abc import Callable, Iterator
from itertools import islice
from typing import TYPE_CHECKING, Any, NamedTuple

from cases.errors import HexciteError

if TYPE_CHECKING:
    from distributed import Client, Future

DESERTED = 300.0  # [s] without any worker after which nobody is expected to come; on a busy computer one takes a minute
LOOK = 10.0  # [s] between two looks for workers while no task ends
AHEAD = 2  # tasks kept ready a thread, so that no worker waits for the next


class TaskEnd(NamedTuple):
    """What became of a task.

    Args:
        key: key of the task.
        value: what it returned; None where it failed.
        reason: why it failed twice, one line; None where it did not.
        seconds: seconds that it took on its worker; 0 where it failed.
    """

    key: str
    value: Any
    reason: str | None
    seconds: float


def run_tasks(
    client: "Client", function: Callable[[Any], Any], tasks: Iterator[tuple[str, Any]], time_limit: float
) -> Iterator[TaskEnd]:
    """Runs `function` on each payload; yields what became of it as it arrives, in any order.

    Only a few tasks a thread wait on the cluster at any time, so that a study of any size needs no more memory there.

    Args:
        client: client of a cluster whose workers have one thread each and can import `function`.
        function: what to do with a payload; an exception that it raises twice is a reason.
        tasks: keys, each once, and payloads.
        time_limit: time limit for one try [s]; a worker that passes it ends, and its nanny starts another.

    Raises:
        HexciteError: no worker is left.
    """
    from distributed import wait

    pending: dict[Future, str] = {}
    seen = time.monotonic()
    try:
        while True:
            threads = sum(client.nthreads().values())
            seen = time.monotonic() if threads else seen
            if time.monotonic() - seen > DESERTED:
                raise HexciteError(f"the cluster has had no workers for {DESERTED:g} s; what is done so far is kept")
            for key, payload in islice(tasks, max(0, AHEAD * max(1, threads) - len(pending))):
                pending[client.submit(_on_worker, function, payload, time_limit, pure=False, retries=1)] = key
            if not pending:
                return
            try:
                ended = wait(list(pending), timeout=LOOK, return_when="FIRST_COMPLETED").done
            except TimeoutError:
                continue
            yield from (_end(pending.pop(future), future, time_limit) for future in ended)
    finally:
        client.cancel(list(pending))


def _on_worker(function: Callable[[Any], Any], payload: Any, time_limit: float) -> tuple[Any, float]:
    """Value and seconds. The watchdog ends the process also where code holds the interpreter."""
    with open(os.devnull, "w") as nowhere:
        faulthandler.dump_traceback_later(time_limit, exit=True, file=nowhere)
        try:
            began = time.perf_counter()
            return function(payload), time.perf_counter() - began
        finally:
            faulthandler.cancel_dump_traceback_later()


def _end(key: str, future: "Future", time_limit: float) -> TaskEnd:
    error = future.exception()
    if error is None:
        value, seconds = future.result()
        return TaskEnd(key, value, None, seconds)
    if type(error).__name__ == "KilledWorker":
        reason = f"its worker died twice: too little memory, or past its limit of {time_limit:g} s"
    else:
        reason = " ".join(f"{type(error).__name__}: {error}".split())
    return TaskEnd(key, None, reason, 0.0)
