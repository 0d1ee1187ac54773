"""Ctrl-C: an exception that no library takes for its own, and an event for the first one."""

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from threading import Event, current_thread, main_thread
from types import FrameType


class Interrupted(BaseException):
    """Ctrl-C. Not a KeyboardInterrupt: the command-line library turns those into a word of its own.

    An argument is what the user is told instead of "nothing was written".
    """


def _raise(number: int, frame: FrameType | None) -> None:
    raise Interrupted


@contextmanager
def ctrl_c_raises() -> Iterator[None]:
    """Inside, Ctrl-C raises `Interrupted`; outside the main thread nothing changes."""
    with _handling(_raise):
        yield


@contextmanager
def first_ctrl_c() -> Iterator[Event]:
    """An event that the first Ctrl-C inside sets; the second one raises `Interrupted`."""
    pressed = Event()

    def handle(number: int, frame: FrameType | None) -> None:
        if pressed.is_set():
            raise Interrupted
        pressed.set()

    with _handling(handle):
        yield pressed


@contextmanager
def _handling(handler: Callable[[int, FrameType | None], None]) -> Iterator[None]:
    if current_thread() is not main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, handler)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


@contextmanager
def ctrl_c_waits() -> Iterator[None]:
    """Inside, Ctrl-C is held back where the system can; processes that are started inside never hear of it."""
    if not hasattr(signal, "pthread_sigmask"):  # of POSIX only
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
