"""Tests that run LinuxCNC, again and again beside busy processes: none may ever fail."""

import os
import re
import subprocess
import sys
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager

ROUNDS, BUSY = 20, 4
WIDE = "500"  # columns, in which pytest says why a test fails


@contextmanager
def busy(count: int) -> Iterator[None]:
    """Processes that do nothing but keep the computer busy."""
    spinning = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(count)]
    try:
        yield
    finally:
        for process in spinning:
            process.kill()
            process.wait()


def under_load(rounds: int = ROUNDS, processes: int = BUSY) -> tuple[int, Counter[str]]:
    """Tests that passed, and how often each failed and why, over `rounds` of all tests marked `linuxcnc`."""
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:xdist", "-m", "linuxcnc and not slow", "tests"]
    passed, failed = 0, Counter[str]()
    with busy(processes):
        for number in range(1, rounds + 1):
            said = subprocess.run(command, capture_output=True, text=True, env={**os.environ, "COLUMNS": WIDE}).stdout
            if (count := re.search(r"(\d+) passed", said)) is None:
                raise RuntimeError(f"pytest says:\n{said}")
            passed += int(count[1])
            failed.update(re.findall(r"^(?:FAILED|ERROR) (.+)", said, re.M))
            print(f"round {number}: {count[0]}, failed so far: {dict(failed)}", file=sys.stderr, flush=True)
    return passed, failed


def under_load_rows() -> list[list[str]]:
    """Failures among all runs of tests that run LinuxCNC."""
    passed, failed = under_load()
    title = f"tests that run LinuxCNC, {ROUNDS} times beside {BUSY} busy processes: failed of {passed + failed.total()}"
    return [[title, f"{failed.total()}", "0"], *([f"  {name}", str(count), "0"] for name, count in failed.items())]


if __name__ == "__main__":
    print(*under_load(*map(int, sys.argv[1:])))
