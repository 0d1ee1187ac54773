"""Core commands use nothing that only POSIX has, but for LinuxCNC and studies."""

import subprocess
import sys
from pathlib import Path

import pytest

from tests.hexcite.command_line import ACCEPT

COMMANDS = (
    ("plan", "hexapod", "--family", "manual", "-o", "plan"),
    ("plan", "hexapod", "--family", "fourier", "--order", "2", "--model", "0", "--starts", "1", "-o", "searched"),
    ("post", "plan", *ACCEPT, "-o", "p.ngc"),
    ("check", "p.ngc", "--case", "hexapod"),
    ("run", "p.ngc", "--case", "hexapod", "-o", "run"),
    ("identify", "run", "-o", "result"),
    ("compare", "plan", "result", "-o", "cmp"),
    ("export", "result", "--to", "json", "--force"),
    ("retime", "plan"),
    ("poses", "hexapod", "--count", "6", "--method", "backward", "--candidates", "60", "-o", "poses"),
    ("case", "check", "hexapod"),
)
WITHOUT = """
import os, signal, sys

if __name__ == "__main__":
    sys.modules["fcntl"] = sys.modules["resource"] = None
    del signal.pthread_sigmask, os.fork
    from hexcite.cli import main

    for words in COMMANDS:
        sys.argv = ["hexcite", *words]
        try:
            main()
        except SystemExit as stop:
            if stop.code:
                sys.exit(f"{' '.join(words)}: exit code {stop.code}")
"""


@pytest.mark.slow
@pytest.mark.usefixtures("cache")
def test_core_commands_run_without_what_only_posix_has(tmp_path: Path) -> None:
    script = tmp_path / "without.py"
    script.write_text(WITHOUT.replace("COMMANDS", repr(COMMANDS)), encoding="utf-8")
    run = subprocess.run([sys.executable, script], cwd=tmp_path, capture_output=True, text=True, timeout=600)
    said = [line for line in run.stderr.splitlines() if not line.startswith("searching: ")]  # of a slow computer
    assert (run.returncode, said) == (0, [])
    assert {p.name for p in tmp_path.iterdir()} >= {"plan", "searched", "p.ngc", "run", "result", "cmp", "poses"}
