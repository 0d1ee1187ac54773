"""Starts in parallel processes: how they are getting on, stopped on Ctrl-C without losing them, until they are enough.

A search ends as soon as the last starts, as many as the family waits for (`idle`), did not raise the best by
`WORTHWHILE`, the first `FAILURES` all failed, or there were `MOST`. They are counted in an order that does not depend
on which of them was done first. `--starts N` asks for N of them instead.
"""

import math
import os
import signal
import sys
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing import get_context, parent_process
from threading import Event, Thread, current_thread, main_thread
from types import FrameType, ModuleType
from typing import Any

from threadpoolctl import threadpool_limits

from cases.errors import Interrupted
from identification.criteria import Criterion
from planner.request import Request
from planner.search import Failed
from planner.search.solving import Start, Task, run_safely

MOST = 40  # starts at most by default
FAILURES = 3  # in a row from the first on
WORTHWHILE = 0.005  # of an efficiency


def most_starts(request: Request) -> int:
    """Number of starts at most."""
    return request.starts or MOST


def enough(results: Sequence[Start | Failed], request: Request, parameters: int) -> bool:
    """Whether more starts are not worth their time.

    Args:
        results: results of all starts until now, in the order of their seeds.
        parameters: their number u.
    """
    every = len(results) >= most_starts(request)
    if every or request.starts is not None:
        return every
    failed = all(isinstance(result, Failed) for result in results)
    idle = FAILURES if failed else request.family.idle(request.criterion)
    return without_gain(results, request.criterion, parameters) >= idle


def without_gain(results: Sequence[Start | Failed], criterion: Criterion, parameters: int) -> int:
    """How many of the last starts did not raise the best by `WORTHWHILE`; small gains add up."""
    best, since = -math.inf, 0
    for result in results:
        since += 1
        if isinstance(result, Start) and gain(criterion, parameters, best, result.promise) >= WORTHWHILE:
            best, since = result.promise, 0
    return since


def gain(criterion: Criterion, parameters: int, old: float, new: float) -> float:
    """By which share a criterion is better, as an efficiency (D) or as the ratio of the variances it stands for."""
    if old == -math.inf or new == -math.inf:
        return math.inf if new > old else 0.0
    if criterion == Criterion.D:
        return math.expm1((new - old) / parameters)
    return abs(old / new) - 1.0 if new < 0.0 else new / old - 1.0


POLL = 0.2  # [s] between two looks at the running starts


Listener = Callable[[Request | Start | Failed | None], None]
"""Follows a search: called with a request as a search begins (one plan may take several), with each result as it
arrives, and with None between the results, while starts are running."""

Outcome = tuple[list[Start | Failed], bool]
"""Results of a round of starts, and whether Ctrl-C ended it early."""


def silent(event: Request | Start | Failed | None) -> None:
    """The listener that shows nothing."""


_stop: Any = None


def _begin(stop: Any) -> None:
    """Gives a worker process its end of the event."""
    global _stop
    _stop = stop
    threadpool_limits(limits=1, user_api="blas")  # there is a process for each core
    os.environ["OPENBLAS_NUM_THREADS"] = "1"  # for that of CasADi, which comes with IPOPT and which nobody else limits
    Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    """A killed parent cannot end its workers, which would wait for work for ever."""
    parent = parent_process()
    assert parent is not None
    parent.join()
    os._exit(1)


def _work(task: Task) -> Start | Failed:
    return run_safely(task, lambda objective: bool(_stop.is_set()))


Runner = Callable[[Sequence[Task], Listener], Outcome]
"""Runs a round of starts."""


def run_here(tasks: Sequence[Task], listener: Listener) -> Outcome:
    """Runs tasks one after the other in this process: for those who bring processes of their own."""
    results: list[Start | Failed] = []
    for task in tasks:
        result = run_safely(task, lambda objective: False)
        listener(result)
        results.append(result)
    return results, False


def cores() -> int:
    """Processors that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@contextmanager
def _without_script() -> Iterator[None]:
    """Processes that start inside do not run the script again, which has no guard in a notebook or in ten lines."""
    main = sys.modules["__main__"]
    sys.modules["__main__"] = ModuleType("__main__")  # without a file, which a new process would run
    try:
        yield
    finally:
        sys.modules["__main__"] = main


@contextmanager
def first_ctrl_c() -> Iterator[Event]:
    """An event that the first Ctrl-C inside sets; the second one raises `Interrupted`. In the main thread only."""
    pressed = Event()

    def press(number: int, frame: FrameType | None) -> None:
        if pressed.is_set():
            raise Interrupted
        pressed.set()

    if current_thread() is not main_thread():
        yield pressed
        return
    before = signal.signal(signal.SIGINT, press)
    try:
        yield pressed
    finally:
        signal.signal(signal.SIGINT, before)


@contextmanager
def ctrl_c_waits() -> Iterator[None]:
    """Inside, Ctrl-C is delayed where the system can; processes that are started inside do not receive it."""
    if not hasattr(signal, "pthread_sigmask"):  # of POSIX only
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def workers(pressed: Event, most: int | None = None) -> Iterator[Runner]:
    """Processes, one a core or at most `most`, that run rounds of starts until the context ends.

    Ctrl-C lets running starts end with what they have reached and drops those that wait.

    Args:
        pressed: event that Ctrl-C sets.
    """
    context = get_context("spawn")  # not forked: MUMPS and threads of a parent do not survive that
    stop = context.Event()
    pool = ProcessPoolExecutor(most or cores(), mp_context=context, initializer=_begin, initargs=(stop,))

    def run(tasks: Sequence[Task], listener: Listener) -> Outcome:
        if pressed.is_set():
            return [], True
        stop.clear()
        results: dict[int, Start | Failed] = {}
        with ctrl_c_waits(), _without_script():
            places = {pool.submit(_work, task): k for k, task in enumerate(tasks)}
        pending = set(places)
        while pending:
            finished, pending = wait(pending, POLL, FIRST_COMPLETED)
            listener(None)
            for future in finished:
                results[places[future]] = _result(future)
                listener(results[places[future]])
            if pressed.is_set():
                stop.set()
                pending = {f for f in pending if not f.cancel()}
        return [result for _, result in sorted(results.items())], pressed.is_set()

    try:
        yield run
    finally:
        stop.set()
        pool.shutdown(wait=False, cancel_futures=True)  # they end beside what follows


def _result(future: Future[Start | Failed]) -> Start | Failed:
    try:
        return future.result()
    except BrokenProcessPool:
        return Failed(0, "a worker process died, perhaps for want of memory; close other programs, or ask for less")
