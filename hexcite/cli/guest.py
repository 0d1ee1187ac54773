"""One command in a process that ends with the process that started it: `python -m .. PARENT COMMAND ..`."""

import ctypes
import os
import signal
import sys
from contextlib import suppress
from types import FrameType

_DEATH_SIGNAL = 1  # PR_SET_PDEATHSIG of Linux


def end_with(parent: int) -> None:
    """Lets the system interrupt this process, as one Ctrl-C does, when the one that started it ends in whatever way."""
    if sys.platform == "linux":
        signal.signal(signal.SIGUSR1, _interrupt_once)
        with suppress(OSError, AttributeError):
            ctypes.CDLL(None, use_errno=True).prctl(_DEATH_SIGNAL, signal.SIGUSR1)
        if os.getppid() != parent:  # it has ended meanwhile
            sys.exit(130)


def _interrupt_once(number: int, frame: FrameType | None) -> None:
    # The system tells of each thread of the parent that ends after having this process for its child, so perhaps
    # several times of one death; and a second Ctrl-C would throw away what the first one lets a search keep.
    if next(_first, False):
        signal.raise_signal(signal.SIGINT)


_first = iter((True,))  # taken in one step: a handler may be interrupted by itself

if __name__ == "__main__":
    end_with(int(sys.argv[1]))
    sys.argv[:] = ["hexcite", *sys.argv[2:]]
    from hexcite.cli import main

    main(own_risk=False)
