"""Runs a LinuxCNC session in isolation and ends all of its processes.

LinuxCNC expects to be alone on a computer: a lock file in /tmp, fixed shared memory keys, TCP port 5005, and a start-up
that kills every process called milltask. Where the kernel allows it, each session therefore gets private process, IPC,
network and mount namespaces, in which its folder is /tmp; the kernel ends all of its processes with the first one, also
when hexcite itself is killed. Elsewhere (most containers) sessions wait for each other, and none starts beside
another LinuxCNC.
"""

import logging
import os
import signal
import subprocess
import tempfile
import time
import uuid
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path

from cases.base.errors import Code, HexciteError

SYSTEM_PATH = "/usr/bin:/bin:/usr/sbin:/sbin"  # of LinuxCNC and its Python, which get nothing of the user's environment
NOBODY = 65534  # user of LinuxCNC's realtime process where hexcite runs as root: that process refuses to run as root
OUTPUT_FILE = "linuxcnc.out"  # file with the output of LinuxCNC
GRACE = 20.0  # time for LinuxCNC to end in an orderly manner [s]; it takes about one
POLL = 0.005  # time between two checks of the processes that are being killed [s]
MARK = "HEXCITE_SESSION"  # environment variable that all processes of a session carry
PROCESSES = {"milltask", "rtapi_app", "linuxcncsvr"}  # processes of which one means that a LinuxCNC is running

_log = logging.getLogger(__name__)
_ENTER = 'mount --bind "$0" /tmp && cd /tmp && exec "$@"'


def _private() -> list[str]:
    """The command line that starts another one, given its folder and arguments, in namespaces of its own."""
    user = [f"--map-user={NOBODY}", f"--map-group={NOBODY}"] if os.getuid() == 0 else ["--map-current-user"]
    spaces = ["--user", *user, "--keep-caps", "--ipc", "--net", "--mount", "--mount-proc", "--pid"]
    return ["setpriv", "--pdeathsig", "KILL", "unshare", *spaces, "--fork", "--kill-child", "sh", "-c", _ENTER]


@cache
def namespaces_allowed() -> bool:
    """Whether the kernel lets this process make the namespaces of a session."""
    with tempfile.TemporaryDirectory(prefix="hexcite-") as folder:
        try:
            trial = subprocess.run([*_private(), folder, "true"], env={"PATH": SYSTEM_PATH}, capture_output=True)
        except OSError:
            return False
        return trial.returncode == 0


def preload_works() -> bool:
    """Whether LinuxCNC's realtime process loads the faster clock: set-uid programs ignore LD_PRELOAD for users."""
    return namespaces_allowed() or os.getuid() == 0


def run_session(folder: Path, arguments: list[str], environment: dict[str, str], time_limit: float) -> int | None:
    """Runs `linuxcnc` in `folder` and ends all of its processes, whatever happens.

    Args:
        folder: holds everything that the session reads and writes; its output goes to `OUTPUT_FILE`.
        environment: added to the session's environment; `{folder}` stands for its folder as seen from inside.
        time_limit: limit of wall-clock time [s].

    Returns:
        The exit code; None where the time limit was reached.

    Raises:
        HexciteError: without namespaces, another LinuxCNC is running.
    """
    if namespaces_allowed():
        return _run(folder, Path("/tmp"), [*_private(), str(folder)], arguments, environment, time_limit)
    with _alone():
        if os.getuid() == 0:
            environment = {**environment, "RTAPI_UID": str(NOBODY)}
            folder.chmod(0o711)
        return _run(folder, folder, [], arguments, environment, time_limit)


def _run(
    folder: Path, inside: Path, start: list[str], arguments: list[str], environment: dict[str, str], time_limit: float
) -> int | None:
    home = folder / "home"
    home.mkdir()
    home.chmod(0o777)  # the realtime process may be another user
    mark = f"{MARK}={uuid.uuid4().hex}"
    settings = {"HOME": "{folder}/home", "RTAPI_FIFO_PATH": "{folder}/home/fifo", **environment}
    assignments = [f"{key}={value.replace('{folder}', str(inside))}" for key, value in settings.items()]
    with (folder / OUTPUT_FILE).open("wb") as output:
        process = subprocess.Popen(
            [*start, "env", mark, *assignments, "linuxcnc", *arguments],
            cwd=folder,
            env={"PATH": SYSTEM_PATH},
            stdin=subprocess.DEVNULL,
            stdout=output,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
        try:
            return process.wait(time_limit)
        except subprocess.TimeoutExpired:
            return None
        finally:
            if process.poll() is None and not start:
                # LinuxCNC unloads its realtime part, which is not in the process group and may belong to root
                _signal_group(process, signal.SIGTERM)
                with suppress(subprocess.TimeoutExpired):
                    process.wait(GRACE)
            _signal_group(process, signal.SIGKILL)
            process.wait()
            end_marked(mark)


def _signal_group(process: subprocess.Popen[bytes], number: signal.Signals) -> None:
    with suppress(ProcessLookupError):
        os.killpg(process.pid, number)


def end_marked(mark: str) -> None:
    """Kills the remaining processes of a session, and those that they still start, until all have ended."""
    deadline = time.monotonic() + GRACE
    while processes := running(mark):
        if time.monotonic() > deadline:
            names = ", ".join(f"{name} ({number})" for number, name in processes.items())
            _log.warning("processes of LinuxCNC did not end within %g s of being killed: %s", GRACE, names)
            return
        for number in processes:
            with suppress(OSError):  # gone by now, or another user's
                os.kill(number, signal.SIGKILL)
        time.sleep(POLL)


def running(mark: str = "") -> dict[int, str]:
    """Numbers and names of all processes but zombies, or of those that carry the mark of a session."""
    processes = {}
    for entry in Path("/proc").glob("[0-9]*"):
        with suppress(OSError):  # gone, or another user's
            zombie = (entry / "stat").read_text().rpartition(") ")[2].startswith("Z")
            if not zombie and (not mark or mark.encode() in (entry / "environ").read_bytes().split(b"\0")):
                processes[int(entry.name)] = (entry / "comm").read_text().strip()
    return processes


@contextmanager
def _alone() -> Iterator[None]:
    """Waits for other sessions of hexcite; refuses to start beside another LinuxCNC."""
    import fcntl  # exists on POSIX only, as LinuxCNC does

    lock = os.open(Path(tempfile.gettempdir()) / f"hexcite-linuxcnc-{os.getuid()}.lock", os.O_RDWR | os.O_CREAT, 0o600)
    try:
        fcntl.flock(lock, fcntl.LOCK_EX)
        for number, name in running().items():
            if name in PROCESSES:
                raise HexciteError(
                    problem=f"another LinuxCNC is running on this computer ({name}, process {number})",
                    remedy="end it first, or allow hexcite to make namespaces (unshare --user)",
                    code=Code.RUN_FAILED,
                )
        yield
    finally:
        os.close(lock)
