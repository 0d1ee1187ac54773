"""Starts in parallel processes: how they are getting on, stopped on Ctrl-C without losing them, until they are enough.

A search ends with the first start after which the last ones, as many as the family waits for (`idle`), did not raise
the best by `WORTHWHILE`, the first `FAILURES` all failed, or there were `MOST`. `--starts N` asks for N of them
instead, `--seconds S` for as many as there is time for. Starts have an order, and results that come before their turn
wait for it: but for a search that lasts so many seconds, neither the number of processes nor what else the computer
does changes the result.
"""

import math
import os
import signal
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from multiprocessing import active_children, get_context, parent_process
from multiprocessing.process import BaseProcess
from threading import Event, Thread, current_thread, main_thread
from types import FrameType, ModuleType
from typing import Any

from threadpoolctl import threadpool_limits

from cases.base.errors import Interrupted
from identification.estimation.criteria import Criterion
from planner.request import Request
from planner.search.record import Failed
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


START, REFINEMENT = "start", "refinement"
POLL = 0.2  # [s] between two looks at the running starts


@dataclass(frozen=True, slots=True)
class Planned:
    """Starts that are about to run."""

    what: str  # what each is: `START` or `REFINEMENT`
    least: int  # their number at least
    exactly: bool  # whether there will not be more
    until: float  # when they are to end, by `time.monotonic` [s]; infinity without such a time


@dataclass(frozen=True, slots=True)
class UnderWay:
    """How far a running start is."""

    seed: int
    share: float  # of the iterations that it has at most


News = Request | Planned | UnderWay | Start | Failed | None
"""What a search tells: a request as it begins (one plan may take several), starts that are about to run, how far they
are, each result as it arrives, and None now and then while starts are running."""

Listener = Callable[[News], None]
"""Follows a search."""

Outcome = tuple[list[Start | Failed], bool]
"""Results of starts in their order, and whether Ctrl-C or their time ended them early."""


@dataclass(frozen=True, slots=True)
class Schedule:
    """Starts in their order, and when they are enough."""

    # number of a start, and results of the starts before it until now, in their order -> the start; None where there
    # are no more, or where it depends on results that are not there yet
    task: Callable[[int, Sequence[Start | Failed]], Task | None]
    # whether results, in the order of their starts, are enough
    enough: Callable[[Sequence[Start | Failed]], bool]
    until: float = math.inf  # when starts end with what they have reached, by `time.monotonic` [s]
    last: float = math.inf  # when they end even if none is done

    @classmethod
    def of(cls, tasks: Sequence[Task], until: float = math.inf) -> "Schedule":
        """All of some starts."""
        every = len(tasks)
        return cls(lambda k, _: tasks[k] if k < every else None, lambda results: len(results) >= every, until, until)

    def late(self, results: Iterable[Start | Failed]) -> bool:
        """Whether their time is over: what a start has reached before it is done is worth little, so one is awaited."""
        now = time.monotonic()
        return now >= self.last or (now >= self.until and any(isinstance(result, Start) for result in results))


class Results:
    """Results that arrive in any order, taken in that of their starts until they are enough."""

    def __init__(self, schedule: Schedule) -> None:
        self.schedule = schedule
        self.in_order: list[Start | Failed] = []
        self.early: dict[int, Start | Failed] = {}  # by the numbers of starts behind one that is still running
        self.enough = schedule.enough(())

    @property
    def late(self) -> bool:
        """Whether the time of the starts is over."""
        return self.schedule.late((*self.in_order, *self.early.values()))

    def add(self, number: int, result: Start | Failed) -> None:
        """Takes the result of a start."""
        self.early[number] = result
        while not self.enough and len(self.in_order) in self.early:
            self.in_order.append(self.early.pop(len(self.in_order)))
            self.enough = self.schedule.enough(self.in_order)


def silent(event: News) -> None:
    """The listener that shows nothing."""


_stop: Any = None
_shares: Any = None
TELLING = 1.0  # [s] between two times that a start tells how far it is


def _begin(stop: Any, shares: Any) -> None:
    """Gives a worker process its ends of the event and of the queue by which starts tell how far they are."""
    global _stop, _shares
    _stop, _shares = stop, shares
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
    calls, last = 0, time.monotonic()

    def watch(objective: float) -> bool:
        nonlocal calls, last
        calls += 1
        if time.monotonic() - last >= TELLING:
            last = time.monotonic()
            _shares.put(UnderWay(task.seed, min(calls / task.most_calls, 1.0)))
        return bool(_stop.is_set())

    return run_safely(task, watch)


_kept: list[tuple[list[BaseProcess], tuple[Any, ...]]] = []


def _keep_until_ended(*ends: Any) -> None:
    """Keeps ends of events and queues for processes that are still beginning, which would not find them otherwise.

    A process that is started late in a search, on a busy computer, may begin when the search is over.
    """
    _kept[:] = [(processes, held) for processes, held in _kept if any(process.is_alive() for process in processes)]
    _kept.append((active_children(), ends))


Runner = Callable[[Schedule, Listener], Outcome]
"""Runs starts until they are enough."""


def run_here(schedule: Schedule, listener: Listener) -> Outcome:
    """Runs starts one after the other in this process: for those who bring processes of their own."""
    results = Results(schedule)
    while not results.enough and (task := schedule.task(len(results.in_order), results.in_order)) is not None:
        if results.in_order and results.late:
            break
        result = run_safely(task, lambda objective: results.late)
        listener(result)
        results.add(len(results.in_order), result)
    return results.in_order, results.late and not results.enough


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
    """Processes, one a core or at most `most`, that run starts until the context ends.

    Ctrl-C, and the end of their time, let running starts end with what they have reached and drop those that wait. At
    least one start runs however short the time is.

    Args:
        pressed: event that Ctrl-C sets.
    """
    context = get_context("spawn")  # not forked: MUMPS and threads of a parent do not survive that
    stop, shares = context.Event(), context.SimpleQueue()
    width = most or cores()
    pool = ProcessPoolExecutor(width, mp_context=context, initializer=_begin, initargs=(stop, shares))

    def run(schedule: Schedule, listener: Listener) -> Outcome:
        stop.clear()
        results, upcoming = Results(schedule), 0
        running: dict[Future[Start | Failed], int] = {}
        with suppress(BrokenProcessPool):  # of which the results of the starts that were running tell
            while not (pressed.is_set() or results.enough or (upcoming > 0 and results.late)):
                while len(running) < width and (task := schedule.task(upcoming, results.in_order)) is not None:
                    with ctrl_c_waits(), _without_script():
                        running[pool.submit(_work, task)] = upcoming
                    upcoming += 1
                if not running:
                    break
                _take(running, results, listener, shares)
        early = not results.enough and (pressed.is_set() or results.late)
        stop.set()  # for starts that are not waited for, and for those that leave what they have reached
        while running:
            _take(running, results, listener, shares)
        behind = sorted(results.early.items()) if early or pressed.is_set() else []
        return [*results.in_order, *(result for _, result in behind)], early or pressed.is_set()

    try:
        yield run
    finally:
        stop.set()
        pool.shutdown(wait=False, cancel_futures=True)  # they end beside what follows
        _keep_until_ended(stop, shares)


def _take(running: dict[Future[Start | Failed], int], results: Results, listener: Listener, shares: Any) -> None:
    """Waits a moment for starts, takes how far they are, and those that are done."""
    finished, _ = wait(running, POLL, FIRST_COMPLETED)
    while not shares.empty():
        listener(shares.get())
    listener(None)
    for future in finished:
        result = _result(future)
        listener(result)
        results.add(running.pop(future), result)


def _result(future: Future[Start | Failed]) -> Start | Failed:
    try:
        return future.result()
    except BrokenProcessPool:
        return Failed(0, "a worker process died, perhaps for want of memory; close other programs, or ask for less")
