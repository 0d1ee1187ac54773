"""A computer that stops LinuxCNC's servo thread again and again, as a busy one does: worse, and on purpose."""

import os
import random
import signal
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

SERVO = "rtapi"  # how the processes that run servo threads are called


def _parents() -> dict[int, tuple[str, int]]:
    """Name and parent of each living process."""
    found = {}
    for entry in Path("/proc").glob("[0-9]*"):
        with suppress(OSError):  # gone by now
            name, _, rest = (entry / "stat").read_text().partition(" (")[2].rpartition(") ")
            state, parent, *_ = rest.split()
            if state != "Z":
                found[int(entry.name)] = name, int(parent)
    return found


def _servo_processes() -> list[int]:
    """Those that this process has started, itself or through others."""
    parents, found = _parents(), []
    for process, (name, _) in parents.items():
        ancestor = process
        while ancestor in parents and ancestor != os.getpid():
            ancestor = parents[ancestor][1]
        if name.startswith(SERVO) and ancestor == os.getpid():
            found.append(process)
    return found


@contextmanager
def stuttering(stopped: float, running: float, seed: int) -> Iterator[list[float]]:
    """Stops servo threads of LinuxCNC sessions that are started in the block; yields the stops made so far [s].

    Args:
        stopped: the longest stop [s].
        running: the longest time between two stops [s].
        seed: of both.
    """
    draw, ended, stops = random.Random(seed), threading.Event(), list[float]()

    def tell(processes: list[int], what: signal.Signals) -> None:
        for process in processes:
            with suppress(ProcessLookupError):
                os.kill(process, what)

    def stutter() -> None:
        while not ended.is_set():
            if not (processes := _servo_processes()):
                time.sleep(0.02)
                continue
            for _ in range(20):  # before looking again, which takes a while
                stops.append(draw.uniform(0.0, stopped))
                tell(processes, signal.SIGSTOP)
                time.sleep(stops[-1])
                tell(processes, signal.SIGCONT)
                time.sleep(draw.uniform(0.0, running))

    thread = threading.Thread(target=stutter)
    thread.start()
    try:
        yield stops
    finally:
        ended.set()
        thread.join()
