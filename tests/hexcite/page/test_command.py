"""`hexcite page`: where it serves, what it refuses, and that Ctrl-C ends it."""

import os
import re
import signal
import socket
import subprocess
import sys
import urllib.error
import urllib.request
from pathlib import Path

import pytest

from tests.hexcite.command_line import refused


def test_it_serves_on_this_computer_alone_until_ctrl_c(root: Path):
    command = [sys.executable, "-P", "-m", "hexcite.cli.guest", str(os.getpid()), "page", str(root), "--no-browser"]
    with subprocess.Popen(command, cwd=root, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as server:
        assert server.stdout is not None
        assert server.stderr is not None
        found = re.search(r"http://127\.0\.0\.1:(\d+)/\?token=(\S{20,})", server.stdout.readline())
        assert found
        with pytest.raises(urllib.error.HTTPError) as error:
            urllib.request.urlopen(f"http://127.0.0.1:{found[1]}/", timeout=30)
        with error.value:
            assert error.value.code == 403
        with socket.socket() as other, pytest.raises(OSError, match="refused"):
            other.connect(("127.0.0.2", int(found[1])))
        server.send_signal(signal.SIGINT)
        assert server.wait(60) == 0
        assert server.stderr.read() == ""


def test_what_it_cannot_serve_is_said_in_a_line(root: Path):
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = str(taken.getsockname()[1])
        for arguments, words in (
            ([str(root / "nowhere")], "nowhere"),
            ([str(root), "--host", "0.0.0.0"], "0.0.0.0"),
            ([str(root), "--port", "70000"], "70000"),
            ([str(root), "--port", port], port),
        ):
            assert words in refused("page", *arguments, "--no-browser")


def test_what_stages_import_is_not_waited_for_before_the_first_page() -> None:
    code = "import sys, hexcite.page.server; print(*({'casadi', 'matplotlib', 'scipy'} & sys.modules.keys()))"
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert found.stdout.split() == []


COLD = """
import sys
from pathlib import Path
from hexcite.page import views
from hexcite.page.actions.common import Context
from hexcite.page.jobs import Jobs
from hexcite.page.stages import machine_of

root = Path(sys.argv[1])
for stage in ("machine", "plan", "program"):
    views.stage(Context(root, machine_of(root, "hexapod"), Jobs(root)), stage, {}, "en")
print(*({"casadi", "matplotlib", "scipy.linalg", "scipy.optimize"} & sys.modules.keys()))
"""


def test_first_stages_load_nothing_that_plans_or_fits(tmp_path: Path):
    """They are painted at once; what they take from such libraries would be a second of processor time."""
    run = subprocess.run([sys.executable, "-c", COLD, str(tmp_path)], capture_output=True, text=True, check=True)
    assert run.stdout.split() == []
