"""Runs many independent tasks on a Dask cluster; a task that dies, fails or takes too long costs one retry, no more.

Dask brings tasks to workers and back and replaces workers that die. What is added here is what it leaves open: how
often a task may be tried, how long it may take, and that its failure is an answer like any other.
"""

import contextlib
import os
import queue
import signal
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from cases.errors import HexciteError

if TYPE_CHECKING:
    from distributed import Client, Future

TOPIC = "hexcite-study"
TRIES = 2
DESERTED = 300.0  # [s] without any worker after which nobody is expected to come; on a busy computer one takes a minute
LOOK = 0.2  # [s] between two looks for tasks past their time
AHEAD = 2  # tasks kept ready a thread, so that no worker waits for the next


@dataclass(frozen=True, slots=True)
class Outcome:
    """What became of a task.

    Args:
        key: of the task.
        value: what it returned; None where it failed.
        reason: why it failed, one line; None where it did not.
        tries: how often it was started, as far as workers lived long enough to say so.
        seconds: that its last try took on its worker.
        worker: address of the last worker.
    """

    key: str
    value: Any
    reason: str | None
    tries: int
    seconds: float
    worker: str


@dataclass(slots=True)
class _Running:
    """A task that has been submitted and has not come back."""

    payload: Any
    future: "Future"
    submitted: int = 1
    tries: int = 0
    worker: str = ""
    started: float | None = None


@dataclass(slots=True)
class _State:
    running: dict[str, _Running] = field(default_factory=dict)
    mailbox: "queue.SimpleQueue[tuple[str, str, Any]]" = field(default_factory=queue.SimpleQueue)


def _on_worker(function: Callable[[Any], Any], key: str, payload: Any) -> tuple[Any, float]:
    """Says that the task has begun, and does it."""
    from distributed import get_worker

    get_worker().log_event(TOPIC, {"key": key, "worker": get_worker().address})
    began = time.perf_counter()
    value = function(payload)
    return value, time.perf_counter() - began


def run_tasks(
    client: "Client", function: Callable[[Any], Any], tasks: Iterator[tuple[str, Any]], time_limit: float
) -> Iterator[Outcome]:
    """Runs `function` on each payload; yields outcomes as they arrive, in any order.

    Only a few tasks a thread wait on the cluster at any time, so that a study of any size needs no more memory there.

    Args:
        client: of a cluster whose workers can import `function`.
        function: what to do with a payload; whatever it raises is an outcome.
        tasks: keys, each once, and payloads.
        time_limit: for one try [s]; a worker that is past it is killed, and its nanny starts another.

    Raises:
        HexciteError: no worker is left.
    """
    state = _State()
    client.subscribe_topic(TOPIC, lambda event: state.mailbox.put(("began", event[1]["key"], event[1]["worker"])))
    try:
        seen = time.monotonic()
        while True:
            threads = sum(client.nthreads().values())
            seen = time.monotonic() if threads else seen
            if time.monotonic() - seen > DESERTED:
                raise HexciteError(f"the cluster has had no workers for {DESERTED:g} s; what is done so far is kept")
            _fill(client, function, tasks, state, AHEAD * max(1, threads))
            if not state.running:
                return
            yield from _answers(client, function, state)
            yield from _overdue(client, function, state, time_limit)
    finally:
        client.unsubscribe_topic(TOPIC)
        for task in state.running.values():
            task.future.cancel()


def _fill(
    client: "Client", function: Callable[[Any], Any], tasks: Iterator[tuple[str, Any]], state: _State, room: int
) -> None:
    while len(state.running) < room:
        try:
            key, payload = next(tasks)
        except StopIteration:
            return
        state.running[key] = _Running(payload, _submit(client, function, key, payload, state))


def _submit(client: "Client", function: Callable[[Any], Any], key: str, payload: Any, state: _State) -> "Future":
    future = client.submit(_on_worker, function, key, payload, pure=False, retries=0)
    future.add_done_callback(lambda done: state.mailbox.put(("done", key, done)))
    return future


def _answers(client: "Client", function: Callable[[Any], Any], state: _State) -> Iterator[Outcome]:
    """Everything that has arrived; waits a little where nothing has."""
    wait = LOOK
    while True:
        try:
            kind, key, content = state.mailbox.get(timeout=wait) if wait else state.mailbox.get_nowait()
        except queue.Empty:
            return
        wait = 0.0
        task = state.running.get(key)
        if task is None:
            continue  # of a try that was given up
        if kind == "began":
            task.tries, task.worker, task.started = task.tries + 1, content, time.monotonic()
            if task.tries > TRIES:  # Dask starts a task anew when its worker dies
                yield _given_up(key, task, "its worker died twice", state)
        elif content is task.future and content.status != "cancelled":
            yield from _ended(client, function, key, task, state)


def _ended(
    client: "Client", function: Callable[[Any], Any], key: str, task: _Running, state: _State
) -> Iterator[Outcome]:
    error = task.future.exception()
    if error is None:
        value, seconds = task.future.result()
        del state.running[key]
        yield Outcome(key, value, None, max(1, task.tries), seconds, task.worker)
        return
    task.tries = max(task.tries, task.submitted)  # what cannot even be unpacked never says that it has begun
    if type(error).__name__ == "KilledWorker":
        yield _given_up(key, task, "its worker died twice", state)
    elif task.tries < TRIES:
        _again(client, function, key, task, state)
    else:
        yield _given_up(key, task, " ".join(f"{type(error).__name__}: {error}".split()), state)


def _overdue(client: "Client", function: Callable[[Any], Any], state: _State, time_limit: float) -> Iterator[Outcome]:
    """Restarts workers whose task is past its time; other tasks that this interrupts are not charged for it."""
    now = time.monotonic()
    late = [k for k, t in state.running.items() if t.started is not None and now - t.started > time_limit]
    for key in late:
        task = state.running[key]
        task.future.cancel(force=True)
        for other in state.running.values():
            if other is not task and other.worker == task.worker and other.started is not None:
                other.tries, other.started = other.tries - 1, None
        # No nanny: the task keeps its thread. Unknown to the scheduler (LookupError): died by itself meanwhile.
        with contextlib.suppress(ValueError, OSError, TimeoutError, LookupError):
            client.run(_kill, workers=[task.worker], nanny=True, on_error="ignore")
        if task.tries < TRIES:
            _again(client, function, key, task, state)
        else:
            yield _given_up(key, task, f"past its time limit of {time_limit:g} s", state)


def _kill(dask_worker: Any) -> None:
    """Run by a worker's nanny, which then starts another: code that holds the interpreter listens to nobody else."""
    os.kill(dask_worker.pid, signal.SIGKILL)


def _again(client: "Client", function: Callable[[Any], Any], key: str, task: _Running, state: _State) -> None:
    task.started, task.submitted = None, task.submitted + 1
    task.future = _submit(client, function, key, task.payload, state)


def _given_up(key: str, task: _Running, reason: str, state: _State) -> Outcome:
    del state.running[key]
    task.future.cancel()
    seconds = time.monotonic() - task.started if task.started is not None else 0.0
    return Outcome(key, None, reason, min(task.tries, TRIES), seconds, task.worker)
