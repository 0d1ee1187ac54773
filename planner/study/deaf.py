"""Workers that leave Ctrl-C to the study: a terminal sends it to every process."""

import signal
from threading import current_thread, main_thread
from typing import Any

from distributed import WorkerPlugin


class Deaf(WorkerPlugin):  # type: ignore[misc]  # distributed has no types
    """Makes a worker ignore SIGINT."""

    name = "hexcite-deaf"

    def setup(self, worker: Any) -> None:
        """Called in each worker as it starts."""
        if current_thread() is main_thread():
            signal.signal(signal.SIGINT, signal.SIG_IGN)
