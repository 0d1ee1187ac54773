"""One command in a process that ends with the process that started it: `python -m .. PARENT COMMAND ..`."""

import ctypes
import os
import signal
import sys
from contextlib import suppress

_DEATH_SIGNAL = 1  # PR_SET_PDEATHSIG of Linux


def end_with(parent: int) -> None:
    """Lets the system interrupt this process, as Ctrl-C does, when the one that started it ends in whatever way."""
    if sys.platform == "linux":
        with suppress(OSError, AttributeError):
            ctypes.CDLL(None, use_errno=True).prctl(_DEATH_SIGNAL, signal.SIGINT)
        if os.getppid() != parent:  # it has ended meanwhile
            sys.exit(130)


if __name__ == "__main__":
    end_with(int(sys.argv[1]))
    sys.argv[:] = ["hexcite", *sys.argv[2:]]
    from hexcite.cli import main

    main()
