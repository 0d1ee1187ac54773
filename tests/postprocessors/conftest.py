"""What tests of programs share: LinuxCNC's own interpreter."""

import re
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

Canonical = list[tuple[str, list[float]]]
_CALL = re.compile(r"\d+ N\S+ (?P<name>[A-Z_0-9]+)\((?P<arguments>.*)\)$")
_NUMBER = re.compile(r"[+-]?\d+\.?\d*")


@pytest.fixture
def rs274(tmp_path: Path) -> Callable[[str], Canonical | str]:
    """Runs a text through `rs274 -g`: the machine commands that it makes of it, or what it says against it.

    For tests marked `linuxcnc`.
    """

    def interpret(text: str) -> Canonical | str:
        (tmp_path / "program.ngc").write_bytes(text.encode())
        run = subprocess.run(
            ["rs274", "-g", "program.ngc"],
            cwd=tmp_path,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            errors="replace",
            timeout=300,
        )
        if run.returncode != 0:
            return run.stderr.replace("executing\n", "").strip() or f"exit code {run.returncode}"
        calls = [match for line in run.stdout.splitlines() if (match := _CALL.search(line.strip()))]
        return [(m["name"], [float(n) for n in _NUMBER.findall(m["arguments"])]) for m in calls]

    return interpret
